//! The square of Figure 2 as the benchmarks load it.
#![allow(dead_code)]

use glam::DVec3;
use rhexis::components::{Curve, Damping, Fibres, Hold, Material};
use rhexis::membrane::Membrane;
use rhexis::scene::generate;
use rhexis::scene::schema::HandSpec;
use rhexis::storage::Attached;

/// Cells of the meshes: 1,500 and 15,010 triangles.
pub const SMALL: [usize; 2] = [30, 25];
pub const LARGE: [usize; 2] = [95, 79];

/// The square, its left edge held and its right edge led along x \[mm\].
pub fn square([nx, ny]: [usize; 2], right: Curve) -> Membrane {
    let mesh = generate::grid(30.0, 30.0, nx, ny).expect("a grid");
    let mut body = Membrane::new("square", mesh, Material::figure_2())
        .fibres(Fibres::at_degrees(45.0))
        .planar()
        .with(Damping { time: 0.1 });
    for (name, x, curve) in [("left", 0.0, Curve::constant(0.0)), ("right", 30.0, right)] {
        let rows = body.select(|p| p.x == x).into_iter();
        let members = Attached::new(rows.map(|row| (row, DVec3::X)));
        body = body.hold(Hold { name: name.into(), members, axes: [true; 3], curve });
    }
    body
}

/// The hand of the catalog's scene `fig2-haptic`.
pub fn hand() -> Curve {
    let (to, within, tremor, period, noise) = (1.5, 100.0, 0.3, 100.0, 0.01);
    let hand = HandSpec { to, within, tremor, period, noise, seed: 7, every: 1.0, duration: 4000.0 };
    hand.curve().expect("a hand")
}
