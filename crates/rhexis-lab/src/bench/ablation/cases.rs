//! The scenes of the ablation.

use rhexis::settings::{Accuracy, Settings};

/// Source of a case's simulation.
pub(super) enum Source {
    /// A scene of the catalog, with changes as of `rhexis run --set`.
    Catalog(&'static str, &'static [&'static str]),
    /// The game, with a preset.
    Game(fn() -> Settings),
}

/// A scene and the window of time in which it is measured.
pub(super) struct Case {
    /// Name on the command line.
    pub name: &'static str,
    /// Description in the remarks.
    pub about: &'static str,
    pub source: Source,
    /// State in which all rows begin: reached with everything on \[ms\].
    pub from: f64,
    /// End of the window \[ms\], and that of the quick run; a scene may end before.
    pub until: [f64; 2],
    /// Time between compared states \[ms\].
    pub every: f64,
    /// Whether runs part whatever their tolerance, so that errors are those of single steps.
    pub is_chaotic: bool,
}

/// All cases.
pub(super) const CASES: &[Case] = &[
    Case {
        name: "capsulorhexis",
        about: "the lens capsule with 5,000 triangles before refinement, from the fourth grasp to the closing of the tear",
        source: Source::Catalog("capsulorhexis", &[]),
        from: 14_000.0,
        until: [20_000.0, 14_100.0],
        every: 100.0,
        is_chaotic: true,
    },
    Case {
        name: "fig2-tear",
        about: "the notched square with 15,010 triangles until it is torn through",
        source: Source::Catalog("fig2-tear", &["bodies.0.mesh.grid.nx=95", "bodies.0.mesh.grid.ny=79"]),
        from: 0.0,
        until: [2_000.0, 100.0],
        every: 50.0,
        is_chaotic: false,
    },
    Case {
        name: "play",
        about: "the game of `examples/play` without its saves, loads and second sheet, seed 1, default settings",
        source: Source::Game(Settings::default),
        from: 0.0,
        until: [4_000.0, 500.0],
        every: 250.0,
        is_chaotic: true,
    },
    Case {
        name: "play-game",
        about: "the same game with the preset `game`",
        source: Source::Game(|| Settings::new(Accuracy::Game)),
        from: 0.0,
        until: [4_000.0, 500.0],
        every: 250.0,
        is_chaotic: true,
    },
    Case {
        name: "fig2-haptic",
        about: "the square of 1,500 triangles in a trembling hand",
        source: Source::Catalog("fig2-haptic", &[]),
        from: 40.0,
        until: [1_000.0, 80.0],
        every: 20.0,
        is_chaotic: false,
    },
];
