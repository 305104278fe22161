//! The sheet of a trouser test: its mesh, its hands, and what it shows while it tears.

use crate::verify::{VerifyError, bodies, largest};
use glam::{DVec2, DVec3};
use rhexis::components::{
    Bending, Curve, Damping, Drag, EnergyCriterion, Fibres, Material, Refinement, TearMode, Tearing, Toughness,
};
use rhexis::event::EventKind;
use rhexis::membrane::Membrane;
use rhexis::settings::{Advanced, Preconditioner, Settings};
use rhexis::simulation::{Simulation, SimulationError};
use rhexis::storage::{BodyId, Tips, TriangleMesh, Vertices};
use rhexis_scene::generate::{self, GenerateError};

/// Width and length of the sheet, and length of its legs \[mm\].
pub(super) const WIDTH: f64 = 12.0;
pub(super) const LENGTH: f64 = 30.0;
pub(super) const LEGS: f64 = 12.0;
/// Held at the inner corners of the legs, so that they pull along the line of the tear \[mm\].
pub(super) const HELD: f64 = 1.5;
/// Size of triangles far from the tip \[mm\].
const COARSE: f64 = 1.0;
/// Speed of either hand across the sheet \[mm/ms\]: the tear goes as fast.
const SPEED: f64 = 0.01;
/// How long the hands go on, at their full speed \[ms\].
const MOST: f64 = 4000.0;
/// Of strain rates \[MPa·ms\] and of what is around \[N·ms/mm³\]: hands that feel ten times as much of either pull 5 % more.
const VISCOSITY: f64 = 0.5;
const DRAG: f64 = 4e-7;
/// Steps are long where the criterion, √(G/G_c), is below this: long ones raise it by less than what is left.
const TAUT: f64 = 0.85;
const SLACK_STEP: f64 = 5.0;
pub(super) const THICKNESS: f64 = 0.1;
/// Toughness \[N/mm\].
pub(super) const TOUGHNESS: f64 = 0.05;

/// How the triangles lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::verify::tear) enum Triangles {
    /// Cells with alternating diagonals.
    Alternating,
    /// Cells with all diagonals one way: no mirror image of themselves about the tear.
    OneWay,
    /// No order, from a seed.
    Unstructured(u64),
}

impl Triangles {
    /// The sheet `[-width / 2, width / 2] × [0, length]` \[mm\] with edges of about `edge` \[mm\].
    pub(in crate::verify::tear) fn mesh(
        self,
        width: f64,
        length: f64,
        edge: f64,
    ) -> Result<TriangleMesh, GenerateError> {
        let half = 0.5 * width;
        let [nx, ny] = [width, length].map(|side| (side / edge) as usize);
        let mut mesh = match self {
            Self::Alternating => generate::grid(width, length, nx, ny)?,
            Self::OneWay => {
                let mut mesh = generate::grid(width, length, nx, ny)?;
                let cells = (0..ny).flat_map(|j| (0..nx).map(move |i| (j * (nx + 1) + i) as u32));
                let row = nx as u32 + 1;
                mesh.triangles = cells.flat_map(|a| [[a, a + 1, a + 1 + row], [a, a + 1 + row, a + row]]).collect();
                mesh
            }
            Self::Unstructured(seed) => {
                let corners = [[0.0, 0.0], [width, 0.0], [width, length], [0.0, length]].map(DVec2::from);
                generate::unstructured(&corners, edge, seed)?
            }
        };
        mesh.positions.iter_mut().for_each(|p| p.x -= half);
        Ok(mesh)
    }
}

/// A sheet that is torn.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trouser {
    pub name: &'static str,
    pub triangles: Triangles,
    /// Size of the triangles around the tip \[mm\].
    pub edge: f64,
    /// Young's modulus \[MPa\].
    pub young: f64,
    /// Toughness \[N/mm\].
    pub toughness: f64,
    /// R \[mm\].
    pub radius: f64,
    /// Angle of the fibres from the line of the tear \[°\], toughness across them over that along, and exponent α, if they count.
    pub fibres: Option<[f64; 3]>,
    /// Time step while the legs are taut \[ms\].
    pub dt: f64,
}

/// The state before a step in which the tear advanced.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pull {
    /// Mean pull of a leg \[N\].
    pub force: f64,
    /// What it rose by in the step before \[N\].
    pub rise: f64,
    /// Mean of the legs' stretches between grip and tip.
    pub stretch: f64,
    /// Energy that the advance was to release per area, by the material force when it was decided \[N/mm\].
    pub release: f64,
    /// Work of the hands until then \[mJ\].
    pub work: f64,
    /// Length torn until then \[mm\].
    pub torn: f64,
}

/// What a tear has shown.
#[derive(Clone, Debug, Default)]
pub(super) struct Torn {
    pub pulls: Vec<Pull>,
    /// From the end of the cut on \[mm\].
    pub path: Vec<DVec2>,
    /// Whether it has run to the end of the sheet.
    pub is_through: bool,
    /// Whether the first advance was a tie with another direction.
    pub is_tie: bool,
}

impl Trouser {
    fn sheet(&self, most: f64) -> Result<Membrane, VerifyError> {
        let [degrees, ratio, exponent] = self.fibres.unwrap_or([0.0, 1.0, 1.0]);
        let toughness = Toughness { along: self.toughness, across: ratio * self.toughness };
        // By whole triangles: the pull is that before an advance.
        let mode = TearMode::Free;
        let tearing = Tearing { radius: self.radius, exponent, mode, ..Tearing::default() };
        let refinement = Refinement { edges_per_radius: self.radius / self.edge, budget: 6.0, ..Refinement::default() };
        let mut sheet = Membrane::new(
            "sheet",
            self.triangles.mesh(WIDTH, LENGTH, COARSE)?,
            Material::isotropic(self.young, 0.3, THICKNESS),
        )
        // The tear goes against y.
        .fibres(Fibres::at_degrees(degrees - 90.0))
        // The viscosity does not depend on the stiffness.
        .with(Damping { time: VISCOSITY / self.young })
        .with(Drag { coefficient: DRAG })
        .with(Bending::default())
        .with(tearing)
        .with(EnergyCriterion::new(toughness))
        .with(refinement);
        for (name, side) in [("left", -1.0), ("right", 1.0)] {
            let curve = Curve::ramp(most, 1.0).unwrap_or_else(|_| Curve::constant(1.0));
            let hold = bodies::hold_along(&sheet, name, [true; 3], curve, |p| is_held(p, side).then_some(way(side)));
            sheet = sheet.hold(hold);
        }
        Ok(sheet)
    }

    /// Tears it to its end.
    ///
    /// # Errors
    /// If the scene is refused or a step fails.
    pub(super) fn tear(&self) -> Result<Torn, VerifyError> {
        let pace = self.pace();
        let most = MOST / pace;
        let settings = Settings {
            threads: 1,
            advanced: Advanced { preconditioner: Preconditioner::Cholesky, ..Advanced::default() },
            ..Settings::default()
        };
        let (mut simulation, body) = bodies::simulate(settings, self.sheet(most)?)?;
        let tip = DVec2::new(0.0, LENGTH - LEGS);
        simulation.cut(body, &[DVec3::new(0.0, LENGTH, 0.0), tip.extend(0.0)])?;
        let mut torn = Torn { path: vec![tip], ..Torn::default() };
        let (mut before, mut last) = ([DVec3::ZERO; 2], 0.0);
        let (mut work, mut length, mut stretch) = (0.0, 0.0, 1.0);
        while simulation.time() < most && !torn.is_through {
            // Long steps while the legs are slack.
            let criterion = simulation
                .world()
                .get::<&Tips>(body.entity())
                .map_or(0.0, |tips| largest(tips.criterion.iter().copied()));
            let dt = if criterion < TAUT { self.dt.max(SLACK_STEP) } else { self.dt };
            simulation.step(dt)?;
            let force = 0.5 * (before[0].length() + before[1].length());
            let mut pull = Pull { force, rise: force - last, stretch, release: f64::NAN, work, torn: length };
            let mut has_advanced = false;
            for event in simulation.drain_events() {
                match event.kind {
                    EventKind::Advanced { from, to, release, is_ambiguous, .. } => {
                        if !has_advanced {
                            pull.release = release.unwrap_or(f64::NAN);
                            torn.is_tie |= torn.path.len() == 1 && is_ambiguous;
                        }
                        has_advanced = true;
                        torn.path.push(to.truncate());
                        length += from.distance(to);
                    }
                    EventKind::Ended { .. } => torn.is_through = true,
                    _ => {}
                }
            }
            if has_advanced {
                torn.pulls.push(pull);
            }
            let now = simulation.reactions(body)?;
            let now = [0, 1].map(|i| now.get(i).map_or(DVec3::NAN, |(_, force)| *force));
            for (side, (before, now)) in [-1.0, 1.0].into_iter().zip(before.into_iter().zip(now)) {
                work += 0.5 * (before + now).dot(way(side)) * (dt / most);
            }
            (last, before) = (force, now);
            stretch = stretched(&simulation, body)?;
        }
        Ok(torn)
    }

    /// Part of the hands' usual speed: stiffer and tougher legs come taut in less time of their way.
    pub(super) fn pace(&self) -> f64 {
        (self.toughness / TOUGHNESS / self.young).clamp(0.3, 1.0)
    }
}

fn is_held(p: DVec3, side: f64) -> bool {
    p.y == LENGTH && p.x * side > 0.0 && p.x * side <= HELD
}

/// Whole way of a hand; the legs' ends come nearer to the tip as they rise.
fn way(side: f64) -> DVec3 {
    DVec3::new(0.0, -0.5, -side) * (SPEED * MOST)
}

/// Mean of both legs' distance between the middle of the grip and the tip over that at rest.
fn stretched(simulation: &Simulation, body: BodyId) -> Result<f64, VerifyError> {
    let mut query = simulation.world().query_one::<(&Vertices, &Tips)>(body.entity());
    let (vertices, tips) = query.get().map_err(|_| SimulationError::NoSuchBody)?;
    let Some(&tip) = tips.vertex.first() else { return Ok(f64::NAN) };
    let stretch = |side: f64| {
        let held = (0..vertices.len()).filter(|&v| is_held(vertices.rest_position[v], side));
        let (mut rest, mut now, mut count) = (DVec3::ZERO, DVec3::ZERO, 0.0);
        for v in held {
            rest += vertices.rest_position[v];
            now += vertices.position[v];
            count += 1.0;
        }
        let at = tip as usize;
        (now / count).distance(vertices.position[at]) / (rest / count).distance(vertices.rest_position[at])
    };
    Ok(0.5 * (stretch(-1.0) + stretch(1.0)))
}
