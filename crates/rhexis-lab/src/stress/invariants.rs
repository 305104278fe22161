//! What must hold after every step.

use super::FailureKind;
use glam::DVec3;
use rhexis::simulation::Simulation;
use rhexis::storage::{BodyId, Broken, Topology, Triangles, Vertices, measure, validate};

/// A part of the area and of the mass that rounding may take in a case: some hundred edits, each of some digits.
const ROUNDING: f64 = 1e-9;

/// What is in a body that nothing feeds may grow by so much. The engine lets a tenth of what is there be spurious, of which a tenth
/// is there again.
const GROWTH: f64 = 1.112;

/// The strain whose energy counts as being in a body, as in `systems/guard/mod.rs`.
const SLACK: f64 = 0.01;

/// On a curved surface the flat triangles that edits make are chords: on the coarsest closed ones they take or give so much of the area.
const CHORDS: f64 = 0.25;

/// A body as it was.
pub(super) struct Ledger {
    is_flat: bool,
    area: f64,
    mass: f64,
    angle: f64,
    energy: Option<Start>,
}

/// From when on no energy may come in.
struct Start {
    energy: f64,
    rest_positions: Vec<DVec3>,
    corners: Vec<[u32; 3]>,
}

impl Ledger {
    /// Of a body as it is.
    pub(super) fn new(simulation: &Simulation, body: BodyId) -> Self {
        let mut query = simulation.world().query_one::<(&Vertices, &Triangles)>(body.entity());
        let Ok((vertices, triangles)) = query.get() else {
            return Self { is_flat: true, area: 0.0, mass: 0.0, angle: 0.0, energy: None };
        };
        let angle = measure::rest_angles(vertices, triangles).fold(f64::MAX, f64::min);
        let normals = || {
            let corners = triangles.corners.iter().map(|&corners| measure::rest_corners(vertices, corners));
            corners.map(|[a, b, c]| (b - a).cross(c - a).normalize_or_zero())
        };
        let first = normals().next().unwrap_or_default();
        let is_flat = normals().all(|normal| normal.dot(first) > 1.0 - ROUNDING);
        let (area, mass) = (measure::total_area(triangles), measure::total_mass(vertices));
        Self { is_flat, area, mass, angle, energy: None }
    }

    /// Somebody has acted: energy counts from now on.
    pub(super) fn forget_energy(&mut self) {
        self.energy = None;
    }
}

/// The first invariant that a body breaks; in a scene that is free, nothing but the hand feeds it.
pub(super) fn broken(
    simulation: &mut Simulation,
    is_free: bool,
    body: BodyId,
    ledger: &mut Ledger,
) -> Option<(FailureKind, String)> {
    if let Some(found) = broken_tables(simulation, body, ledger) {
        return Some(found);
    }
    let energies = match simulation.energies(body) {
        Ok(energies) => energies,
        Err(error) => return Some((FailureKind::Refused, error.to_string())),
    };
    let energy = energies.elastic + energies.kinetic;
    if !energy.is_finite() {
        return Some((FailureKind::NotFinite, format!("energies of {energies:?}")));
    }
    if is_free { gained(simulation, body, ledger, energy) } else { None }
}

fn broken_tables(simulation: &Simulation, body: BodyId, ledger: &Ledger) -> Option<(FailureKind, String)> {
    let mut query = simulation.world().query_one::<(&Vertices, &Triangles, &Topology)>(body.entity());
    let Ok((vertices, triangles, topology)) = query.get() else {
        return Some((FailureKind::Mesh, "the body has lost its tables".to_owned()));
    };
    if let Err(broken) = validate(vertices, triangles, topology) {
        let is_number = matches!(broken, Broken::NotFinite { .. });
        return Some((if is_number { FailureKind::NotFinite } else { FailureKind::Mesh }, broken.to_string()));
    }
    let (area, mass) = (measure::total_area(triangles), measure::total_mass(vertices));
    let share = if ledger.is_flat { ROUNDING } else { CHORDS };
    let sums = [(FailureKind::Area, area, ledger.area, share), (FailureKind::Mass, mass, ledger.mass, ROUNDING)];
    for (kind, now, before, share) in sums {
        if !((now - before).abs() <= share * before) {
            return Some((kind, format!("{now:e}, at first {before:e}")));
        }
    }
    let (angle, least) = (measure::rest_angles(vertices, triangles).fold(f64::MAX, f64::min), ledger.angle);
    let least = least.min(10_f64.to_radians()) * (1.0 - ROUNDING);
    (!(angle >= least))
        .then(|| (FailureKind::Angle, format!("{}°, at first {}°", angle.to_degrees(), ledger.angle.to_degrees())))
}

/// Whether a body that nothing acts on has more than it had.
fn gained(simulation: &Simulation, body: BodyId, ledger: &mut Ledger, energy: f64) -> Option<(FailureKind, String)> {
    let mut query = simulation.world().query_one::<(&Vertices, &Triangles)>(body.entity());
    let Ok((vertices, triangles)) = query.get() else { return None };
    let is_same = |start: &&Start| start.corners == triangles.corners && start.rest_positions == vertices.rest_position;
    // An edit of the mesh may take the state over with another energy.
    let Some(start) = ledger.energy.as_ref().filter(is_same) else {
        let (rest_positions, corners) = (vertices.rest_position.clone(), triangles.corners.clone());
        ledger.energy = Some(Start { energy, rest_positions, corners });
        return None;
    };
    // Of a body thrown far away positions are rounded, and strains with them.
    let rounded = f64::EPSILON * vertices.position.iter().map(|x| x.abs().max_element()).fold(0.0, f64::max);
    let slack = |t: usize| {
        let (law, [g1, g2]) = (&triangles.stiffness[t], triangles.rest[t].gradients);
        let strain_sq = SLACK * SLACK + (rounded * rounded) * (g1.length_squared() + g2.length_squared());
        0.5 * triangles.rest[t].area * triangles.thickness[t] * (law.q11 + law.q22) * strain_sq
    };
    let slack: f64 = (0..triangles.len()).map(slack).sum();
    let most = GROWTH * (start.energy + slack);
    (!(energy <= most)).then(|| {
        (
            FailureKind::Energy,
            format!("{energy:e} mJ, {:e} at first, a strain of 1 % would store {slack:e}", start.energy),
        )
    })
}
