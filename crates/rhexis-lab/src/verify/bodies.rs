//! What the cases share: settings, holds, looks into the world.

use super::VerifyError;
use glam::DVec3;
use rhexis::components::{Curve, Forces, Frames, Hold, Increment, Material, SolverScratch};
use rhexis::math::GeometricStiffness;
use rhexis::membrane::Membrane;
use rhexis::settings::{Advanced, LinearParams, Settings, Tangent};
use rhexis::simulation::{Simulation, SimulationError};
use rhexis::storage::{Attached, BodyId, Topology, Triangles, Vertices};
use rhexis::systems::bending::BendingPasses;
use rhexis::systems::forces::assembly;
use rhexis::systems::kernels::membrane::second_piola;
use rhexis::systems::solver::{Operator, ProductMemory};

/// Settings that solve every step nearly to rounding, on one thread: cases run side by side. Rounding of forces is 1e-14 N,
/// about 2e-12 of the largest corner force where a ramp begins.
pub(super) fn exacting() -> Settings {
    Settings {
        threads: 1,
        advanced: Advanced {
            linear: LinearParams::by_residual(1e-12, 20_000),
            newton_iterations: 30,
            newton_tolerance: 1e-11,
            ..Advanced::default()
        },
        ..Settings::default()
    }
}

/// A simulation of one body.
pub(super) fn simulate(settings: Settings, membrane: Membrane) -> Result<(Simulation, BodyId), VerifyError> {
    let mut simulation = Simulation::new(settings)?;
    let body = simulation.spawn(membrane)?;
    Ok((simulation, body))
}

/// The material of a reference file.
pub(super) fn material(constants: [f64; 4], thickness: f64, density: f64) -> Material {
    let [young_fibre, young_transverse, poisson_major, shear] = constants;
    Material { young_fibre, young_transverse, poisson_major, shear_modulus: Some(shear), thickness, density }
}

/// A hold of all vertices of a membrane for which `offset` gives a displacement \[mm\], along all axes, at once.
pub(super) fn hold(membrane: &Membrane, name: &str, offset: impl Fn(DVec3) -> Option<DVec3>) -> Hold {
    hold_along(membrane, name, [true; 3], Curve::constant(1.0), offset)
}

/// A hold along some axes, over time.
pub(super) fn hold_along(
    membrane: &Membrane,
    name: &str,
    axes: [bool; 3],
    curve: Curve,
    offset: impl Fn(DVec3) -> Option<DVec3>,
) -> Hold {
    let positions = membrane.mesh().positions.iter().enumerate();
    let members = positions.filter_map(|(i, &p)| offset(p).map(|u| (i as u32, u)));
    Hold { name: name.into(), members: Attached::new(members), axes, curve }
}

/// The edge of the rectangle \[0, a\] × \[0, b\], held where it is.
pub(super) fn hold_rim(membrane: Membrane, a: f64, b: f64) -> Membrane {
    let rim = hold(&membrane, "rim", |p| (p.x == 0.0 || p.x == a || p.y == 0.0 || p.y == b).then_some(DVec3::ZERO));
    membrane.hold(rim)
}

/// The positions \[mm\].
pub(super) fn positions(simulation: &Simulation, body: BodyId) -> Result<Vec<DVec3>, VerifyError> {
    let vertices = simulation.world().get::<&Vertices>(body.entity()).map_err(|_| SimulationError::NoSuchBody)?;
    Ok(vertices.position.clone())
}

/// Sets positions \[mm\] and velocities \[mm/ms\] from the rest positions.
pub(super) fn set_motion(
    simulation: &mut Simulation,
    body: BodyId,
    motion: impl Fn(usize, DVec3) -> (DVec3, DVec3),
) -> Result<(), VerifyError> {
    let vertices = simulation.world_mut().query_one_mut::<&mut Vertices>(body.entity());
    let vertices = vertices.map_err(|_| SimulationError::NoSuchBody)?;
    for v in 0..vertices.len() {
        (vertices.position[v], vertices.velocity[v]) = motion(v, vertices.rest_position[v]);
    }
    Ok(())
}

/// The answer of a linear response.
pub(super) struct Linear {
    /// Displacement per vertex \[mm\].
    pub displacement: Vec<DVec3>,
    /// Force of the holds per vertex \[N\].
    pub reaction: Vec<DVec3>,
    /// ½ · (loads and reactions) · displacement \[mJ\].
    pub energy: f64,
    /// The residual that the displacements leave when it is formed anew, over the largest force: rounding can keep it from
    /// following the one that the solver carries along.
    pub residual: f64,
}

/// Solves the linear problem at time 1 from the rest state.
pub(super) fn linear(simulation: &mut Simulation, body: BodyId) -> Result<Linear, VerifyError> {
    simulation.linear_response(1.0)?;
    type Query<'a> =
        ((&'a Vertices, &'a Triangles, &'a Topology, &'a Frames), (&'a Forces, &'a Increment, &'a SolverScratch));
    let world = simulation.world();
    let mut query = world.query_one::<Query>(body.entity());
    let ((vertices, triangles, topology, frames), (forces, increment, scratch)) =
        query.get().map_err(|_| SimulationError::NoSuchBody)?;
    let displacement = increment.displacement.clone();
    let operator = operator(vertices, triangles, topology, frames);
    let mut product = vec![DVec3::ZERO; displacement.len()];
    let memory = &mut ProductMemory { corner: &mut Vec::new(), passes: &mut BendingPasses::default() };
    operator.apply(&displacement, &scratch.free, memory, &mut product, &mut Vec::new());
    // On held axes this is the reaction, on free ones what the solve has left.
    let left: Vec<DVec3> = product.iter().zip(&forces.nodal).map(|(k, f)| *k - *f).collect();
    let scale = product.iter().map(|f| f.length()).fold(0.0, f64::max);
    let free = left.iter().zip(&scratch.free).map(|(r, f)| (*r * *f).length());
    let residual = super::largest(free) / scale;
    let reaction: Vec<DVec3> = left.iter().zip(&scratch.free).map(|(r, f)| *r * (DVec3::ONE - *f)).collect();
    let work = displacement.iter().zip(reaction.iter().zip(&forces.nodal)).map(|(u, (r, f))| u.dot(*r + *f));
    let energy = 0.5 * work.sum::<f64>();
    Ok(Linear { displacement, reaction, energy, residual })
}

/// The static stiffness with the exact tangent at the state of `frames`.
pub(super) fn operator<'a>(
    vertices: &'a Vertices,
    triangles: &'a Triangles,
    topology: &'a Topology,
    frames: &'a Frames,
) -> Operator<'a> {
    Operator::membrane((vertices, triangles, topology, frames), Tangent::Exact)
}

/// Copies of a body's tables with its frames brought up to the positions, ready for an [`operator`].
pub(super) struct Snapshot {
    /// Vertices.
    pub vertices: Vertices,
    /// Triangles.
    pub triangles: Triangles,
    /// Topology.
    pub topology: Topology,
    /// State of the triangles, with the geometric stiffness of the exact tangent.
    pub frames: Frames,
}

impl Snapshot {
    /// The body now.
    pub(super) fn new(simulation: &mut Simulation, body: BodyId) -> Result<Self, VerifyError> {
        simulation.refresh(body)?;
        let mut query = simulation.world().query_one::<(&Vertices, &Triangles, &Topology, &Frames)>(body.entity());
        let (vertices, triangles, topology, frames) = query.get().map_err(|_| SimulationError::NoSuchBody)?;
        let mut frames = frames.clone();
        let normal = |s: rhexis::math::ElementState| second_piola(s.stress, s.polar.stretch);
        let geometric = |s| GeometricStiffness { normal: normal(s), in_plane: 0.0 };
        frames.geometric = frames.states().map(geometric).collect();
        Ok(Self { vertices: vertices.clone(), triangles: triangles.clone(), topology: topology.clone(), frames })
    }

    /// Elastic forces on the vertices \[N\].
    pub(super) fn elastic_forces(&self) -> Vec<DVec3> {
        let mut forces = Forces::default();
        let mesh = (&self.triangles, &self.topology);
        assembly::membrane_forces(mesh, &self.frames, |_| DVec3::ZERO, 0.0, &mut forces);
        forces.nodal
    }
}

/// Sum of the forces \[N\] of the hold with a name, from the last step.
pub(super) fn reaction(simulation: &Simulation, body: BodyId, name: &str) -> Result<DVec3, VerifyError> {
    let reactions = simulation.reactions(body)?;
    Ok(reactions.iter().filter(|(hold, _)| hold == name).map(|(_, force)| *force).sum())
}
