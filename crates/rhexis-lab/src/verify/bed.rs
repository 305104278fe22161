//! Tissue that is stuck to a bed: the force of peeling against Kendall's formula.

use super::bodies;
use super::{Artifacts, Depth, Row, Rows, VerifyError};
use glam::DVec3;
use rhexis::components::{Anchor, Bond, Curve, Damping, Fibres, Hold, Material, Springs};
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::settings::Settings;
use rhexis::storage::Attached;

/// Width, length and free arm of the strip \[mm\], its modulus \[MPa\] and thickness \[mm\]: those of a lens capsule, which fibres make stiff.
const WIDTH: f64 = 0.5;
const LENGTH: f64 = 5.0;
const ARM: f64 = 1.0;
const YOUNG: f64 = 30.0;
const THICKNESS: f64 = 0.015;

/// Strength of its bonds \[MPa\].
const STRENGTH: f64 = 0.05;

/// Speed of the front \[mm/ms\].
const SPEED: f64 = 0.0004;

/// Time steps \[ms\] in which the front goes on by a fiftieth and by a tenth of an edge of 0.1 mm.
const SHORT: f64 = 5.0;
const LONG: f64 = 25.0;

/// A strip on its bed, and how it is drawn off.
#[derive(Clone, Copy)]
struct Strip {
    /// Angle \[°\] between the free arm and the part that is stuck.
    degrees: f64,
    /// Edges per mm.
    per_mm: usize,
    /// Energy of the bonds per area \[N/mm\].
    energy: f64,
}

impl Strip {
    /// The strip, whose arm is drawn so that it keeps its angle.
    fn membrane(self) -> Result<Membrane, VerifyError> {
        let Self { degrees, per_mm, energy } = self;
        let angle = degrees.to_radians();
        let (nx, ny) = (5 * per_mm, (per_mm / 2).max(2));
        let along = DVec3::new(-angle.cos(), 0.0, angle.sin());
        let place = |s: f64, y: f64| DVec3::new(s.max(ARM), y, 0.0) + along * (ARM - s).max(0.0);
        let mesh = generate::mapped_grid(nx, ny, |u, v| place(u * LENGTH, v * WIDTH))?;
        let strip = Membrane::new("strip", mesh, Material::isotropic(YOUNG, 0.0, THICKNESS));
        let column = |row: u32| row as usize % (nx + 1);
        let rows = 0..strip.mesh().positions.len() as u32;
        let bond = Bond::new(STRENGTH, energy);
        let anchor = |row: u32| {
            let point = strip.mesh().positions[row as usize];
            (row, Anchor { point, stiffness: bond.usual_stiffness(), bond: Some(bond) })
        };
        let anchors = Attached::new(rows.clone().filter(|row| column(*row) >= per_mm).map(anchor));
        let members = Attached::new(rows.filter(|row| column(*row) == 0).map(|row| (row, DVec3::X + along)));
        let curve = Curve::ramp(1e4, 1e4 * SPEED)?;
        let hand = Hold { name: "hand".into(), members, axes: [true; 3], curve };
        Ok(strip.fibres(Fibres::at_degrees(0.0)).with(Springs { anchors }).with(Damping { time: 0.1 }).hold(hand))
    }

    /// Mean force of the hand over the formula's at the angle of the pull, while the front goes on by 2 mm, and its deviation from the mean over that.
    fn peel(self, dt: f64) -> Result<[f64; 2], VerifyError> {
        let (mut simulation, body) =
            bodies::simulate(Settings { threads: 1, ..Settings::default() }, self.membrane()?)?;
        let mut forces = Vec::new();
        while simulation.time() < 3.0 / SPEED {
            simulation.step(dt)?;
            if simulation.time() > 1.0 / SPEED {
                forces.extend(simulation.reactions(body)?.first().map(|(_, force)| *force));
            }
        }
        let count = forces.len() as f64;
        let mean = forces.iter().sum::<DVec3>() / count;
        let deviation = forces.iter().map(|force| force.distance_squared(mean)).sum::<f64>() / count;
        let wanted = WIDTH * kendall(mean.z.atan2(-mean.x), self.energy);
        Ok([mean.length() / wanted, deviation.sqrt() / mean.length()])
    }
}

/// Force of peeling per width \[N/mm\]: P²/(2·E·h) + P·(1 − cos θ) = G (Kendall 1975).
fn kendall(angle: f64, energy: f64) -> f64 {
    let (stiffness, turn) = (YOUNG * THICKNESS, 1.0 - angle.cos());
    stiffness * ((turn * turn + 2.0 * energy / stiffness).sqrt() - turn)
}

pub(super) fn peel(artifacts: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("bed-peel");
    let of = |degrees, per_mm, energy| Strip { degrees, per_mm, energy };
    let mut cases = vec![
        of(45.0, 10, 0.003),
        of(90.0, 5, 0.003),
        of(90.0, 10, 0.003),
        of(90.0, 20, 0.003),
        of(90.0, 10, 0.03),
        of(135.0, 10, 0.003),
        of(135.0, 10, 0.03),
    ];
    if artifacts.depth == Depth::Full {
        cases.extend([of(45.0, 20, 0.003), of(135.0, 20, 0.003), of(170.0, 10, 0.003), of(170.0, 20, 0.03)]);
    }
    for case in cases {
        let Strip { degrees, per_mm, energy } = case;
        // A fiftieth of an edge of 0.1 mm in a step, on finer meshes as well.
        let [mean, deviation] = case.peel(SHORT * 10.0 / per_mm.max(10) as f64)?;
        let name = format!("{degrees}°, {per_mm} edges per mm, {energy} N/mm");
        // At steep angles the front of weak bonds jumps from vertex to vertex: 1.6 % at 135°, 13 % at 170°, 0.4 % else.
        let most = if degrees > 150.0 && energy < 0.01 { f64::INFINITY } else { 0.03 };
        rows.relative(format!("{name}: mean force against Kendall's"), mean, 1.0, most);
        rows.note(format!("{name}: deviation of the force"), deviation, "1");
    }
    // Tissue that turns over between two states of one linear solve is stretched on its way.
    for (degrees, most) in [(45.0, 0.03), (90.0, 0.07), (135.0, f64::INFINITY), (170.0, f64::INFINITY)] {
        let [mean, _] = of(degrees, 10, 0.003).peel(LONG)?;
        rows.relative(format!("{degrees}°, in steps of a tenth of an edge: mean force"), mean, 1.0, most);
    }
    rows.finish()
}
