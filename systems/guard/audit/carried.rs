//! State of a step when its iterations have ended, and the terms of the balance that follow from it.

use super::{Sheet, dot, kinetic};
use crate::components::{
    CompartmentState, Drag, Energies, EnergyAudit, EnergyBalance, ExternalStiffness, Forces, Frames, Grips, Hold,
    Holds, Increment, Pinch, Reactions, Shares, SolveResult, SolverScratch,
};
use crate::settings::Tangent;
use crate::storage::{Topology, Vertices};
use crate::systems::bending::DihedralAngles;
use crate::systems::kernels::membrane::{ElementTangent, stretch_rate};
use crate::systems::solver::Operator;
use crate::systems::{StepContext, parallel};
use glam::DVec3;

/// A body when its iterations have ended.
pub(super) struct Carried<'a> {
    pub vertices: &'a Vertices,
    pub sheet: Sheet<'a>,
    pub topology: &'a Topology,
    pub frames: &'a Frames,
    pub forces: &'a Forces,
    pub increment: &'a Increment,
    pub scratch: &'a SolverScratch,
    pub result: &'a SolveResult,
    pub external: Option<&'a ExternalStiffness>,
    /// β/s of strain-rate damping.
    pub viscosity: f64,
    pub drag: Option<&'a Drag>,
    pub held: Option<(&'a Holds, &'a Reactions)>,
    pub grips: Option<&'a Grips>,
    pub folds: Option<&'a DihedralAngles>,
    pub compartment: Option<&'a CompartmentState>,
}

impl Carried<'_> {
    /// Sums over the triangles, from x₀, u and u − u_k: their true work along the step, the scheme's work and the damping by
    /// `terms`, and their energies at both ends. Bending is included; its work may be that between the ends.
    pub(super) fn sums(
        &self,
        EnergyAudit { displacement: evaluated, partials, .. }: &mut EnergyAudit,
        is_between_ends: bool,
        terms: impl Fn(usize, [DVec3; 3], [DVec3; 3], [DVec3; 3]) -> [f64; 2] + Sync,
    ) -> Shares {
        let Increment { start, displacement, .. } = self.increment;
        let Sheet { triangles, .. } = self.sheet;
        let mut sums = parallel::sum_rows(&mut vec![(); triangles.len()], partials, |t, ()| {
            let corners = triangles.corners[t].map(|v| v as usize);
            let (x, u) = (corners.map(|v| start[v]), corners.map(|v| displacement[v]));
            let element = self.sheet.element(t);
            let [scheme, damping] = terms(t, x, u, corners.map(|v| displacement[v] - evaluated[v]));
            let end = element.energy(corners.map(|v| self.vertices.position[v]));
            Shares { work: element.work(x, u), scheme, damping, start: element.energy(x), end }
        });
        if let (Some((bending, vertices, topology)), Some(folds)) = (self.sheet.bending, self.folds) {
            let body = (vertices, triangles, topology);
            let [work, scheme, damping, start, end] = if is_between_ends {
                DihedralAngles::works_between_ends(body, bending, start, displacement)
            } else {
                let is_exact = self.result.tangent == Tangent::Exact;
                folds.works_of_step(body, bending, start, (evaluated, displacement), is_exact)
            };
            sums += Shares { work, scheme, damping, start, end };
        }
        sums
    }

    /// −(mean of the forces at both ends) · u.
    pub(super) fn between_ends(&self, t: usize, x: [DVec3; 3], u: [DVec3; 3]) -> [f64; 2] {
        let element = self.sheet.element(t);
        let end = std::array::from_fn(|i| x[i] + u[i]);
        [0.5 * (element.slope(x, u) + element.slope(end, u)), 0.0]
    }

    /// The membrane's part of the step's operator.
    fn membrane(&self) -> Operator<'_> {
        Operator::membrane((self.vertices, self.sheet.triangles, self.topology, self.frames), self.result.tangent)
    }

    /// −(f(x_k) − K·δ) · u with the tangent that was used, and dt·v·C·v.
    pub(super) fn linearised(&self, t: usize, u: [DVec3; 3], change: [DVec3; 3]) -> [f64; 2] {
        let operator = self.membrane();
        // The frames may hold terms of another tangent, which was indefinite.
        let is_rotated = operator.tangent == Tangent::Rotated;
        let tangent = if is_rotated { operator.rotated_element(t) } else { operator.element(t) };
        let ElementTangent { state, rest, stiffness, coupling, geometric: volume, .. } = tangent;
        let rate = stretch_rate(&state.polar, rest, u);
        let scheme = volume * state.stress.contract(rate) + dot(&tangent.apply(change), &u);
        [scheme, volume * self.viscosity * stiffness.coupled_stress(coupling, rate).contract(rate)]
    }

    /// Work along the step of the holds, by their force on each vertex: the reactions, or others.
    fn work_of_holds(&self, force: Option<&[DVec3]>) -> f64 {
        let Some((holds, reactions)) = self.held else { return 0.0 };
        let u = &self.increment.displacement;
        let of_group = |(hold, forces): (&Hold, &Vec<DVec3>)| {
            let held = DVec3::from_array(hold.axes.map(|a| f64::from(u8::from(a))));
            let pairs = hold.members.rows().iter().map(|&row| row as usize).zip(forces);
            pairs.map(|(v, reaction)| force.map_or(*reaction, |force| force[v] * held).dot(u[v])).sum::<f64>()
        };
        holds.groups.iter().zip(&reactions.groups).map(of_group).sum()
    }

    /// Work along the step of the jaws that prescribe, by their force on each vertex: the reactions, or others.
    fn work_of_jaws(&self, force: Option<&[DVec3]>) -> f64 {
        let u = &self.increment.displacement;
        let of_pinch = |pinch: &Pinch| {
            let rows = pinch.held.rows().iter().map(|&row| row as usize);
            let pairs = rows.zip(pinch.prescribed.iter().zip(&pinch.forces));
            pairs.map(|(v, (axes, own))| force.map_or(*own, |force| force[v] * *axes).dot(u[v])).sum::<f64>()
        };
        let pinches = self.grips.into_iter().flat_map(|grips| &grips.pinches);
        pinches.filter(|pinch| pinch.is_constraint()).map(of_pinch).sum()
    }

    /// Forces that keep every vertex on its way beside the forces of the step \[N\]: where the solve's answer was not followed
    /// in full, A·δ − b for the displacement since the last evaluation. On prescribed axes those are the reactions, on free
    /// ones nothing exerts them.
    fn missing_forces(&self, audit: &EnergyAudit, step: &StepContext) -> Vec<DVec3> {
        let Increment { displacement, .. } = self.increment;
        let gone: Vec<DVec3> = displacement.iter().zip(&audit.displacement).map(|(u, at)| *u - *at).collect();
        let operator =
            Operator { external: self.external, folds: self.folds, viscosity: self.viscosity, ..self.membrane() };
        let operator = Operator { volume: self.compartment.map(CompartmentState::stiffness), ..operator };
        let pressure = operator.volume_pressure(&gone);
        let force = |v: usize| {
            let momentum = step.momentum(self.increment, v) * self.vertices.mass[v];
            operator.apply_at(v, &gone) + operator.volume_force(v, pressure) - self.forces.nodal[v] - momentum
        };
        (0..displacement.len()).map(force).collect()
    }

    pub(super) fn dynamic_terms(&self, audit: &mut EnergyAudit, sums: &Shares, step: &StepContext) -> EnergyBalance {
        let Vertices { velocity, mass, .. } = self.vertices;
        let Increment { start_velocity, displacement: u, .. } = self.increment;
        let mut work_of_loads = dot(&audit.loads, u);
        if let Some(external) = self.external {
            let blocks = external.block.iter().zip(u).zip(&audit.displacement);
            work_of_loads -= blocks.map(|((k, u), at)| (*k * (*u - *at)).dot(*u)).sum::<f64>();
            work_of_loads += external.coupled.work_of_rigid(|v| u[v] - audit.displacement[v], u);
        }
        if let Some(volume) = self.compartment.map(CompartmentState::stiffness) {
            let swept = volume.swept(u);
            work_of_loads -= volume.stiffness * (swept - volume.swept(&audit.displacement)) * swept;
        }
        let coefficient = self.drag.map_or(0.0, |d| d.coefficient) * step.inv_effective_dt();
        let area = |v: usize| self.topology.vertex_area(self.sheet.triangles, v as u32);
        let braked = |(v, u): (usize, &DVec3)| coefficient * area(v) * u.length_squared();
        let drag = if coefficient > 0.0 { u.iter().enumerate().map(braked).sum() } else { 0.0 };
        let is_shifted = self.increment.is_fraction || self.increment.has_projected_vertices;
        let missing = is_shifted.then(|| self.missing_forces(audit, step));
        let missing = missing.as_deref();
        let jumps = velocity.iter().zip(start_velocity).zip(mass);
        let residual = self.scratch.residual.iter().zip(&self.scratch.free).zip(u);
        audit.ends = [
            Energies { elastic: sums.start, kinetic: kinetic(start_velocity, mass) },
            Energies { elastic: sums.end, kinetic: kinetic(velocity, mass) },
        ];
        EnergyBalance {
            work_of_holds: self.work_of_holds(missing),
            work_of_jaws: self.work_of_jaws(missing),
            // Among the loads drag is a force as any other.
            work_of_loads: work_of_loads + drag,
            damping: sums.damping,
            drag,
            numerical_elastic: sums.scheme - sums.work,
            numerical_kinetic: if step.is_static {
                audit.ends[0].kinetic
            } else {
                jumps.map(|((v1, v0), m)| 0.5 * m * (*v1 - *v0).length_squared()).sum()
            },
            residual: if missing.is_none() { residual.map(|((r, f), u)| (*r * *f).dot(*u)).sum() } else { 0.0 },
            unbalanced: missing.map_or(0.0, |missing| {
                let free = missing.iter().zip(&self.scratch.free).zip(u);
                -free.map(|((force, f), u)| (*force * *f).dot(*u)).sum::<f64>()
            }),
            ..EnergyBalance::default()
        }
    }

    /// In a relaxation, which follows an equilibrium at the same time, the error of the trapezoidal rule belongs to the
    /// released energy; else the scheme's works are off by it.
    pub(super) fn static_terms(&self, audit: &mut EnergyAudit, sums: &Shares, is_relaxation: bool) -> EnergyBalance {
        let Increment { start_velocity, displacement: u, .. } = self.increment;
        let [start_membrane, start_loads] = &audit.start;
        let start: Vec<DVec3> = start_membrane.iter().zip(start_loads).map(|(own, load)| -(*own + *load)).collect();
        let mut released = 0.0;
        for (v, free) in self.scratch.free.iter().enumerate() {
            released += 0.5 * ((self.forces.nodal[v] - start[v]) * *free).dot(u[v]);
        }
        let off = sums.scheme - sums.work;
        let work_of_loads = 0.5 * (dot(start_loads, u) + dot(&audit.loads, u));
        let kinetic = kinetic(start_velocity, &self.vertices.mass);
        audit.ends = [Energies { elastic: sums.start, kinetic }, Energies { elastic: sums.end, kinetic: 0.0 }];
        EnergyBalance {
            work_of_holds: 0.5 * (self.work_of_holds(Some(&start)) + self.work_of_holds(None)),
            work_of_jaws: 0.5 * (self.work_of_jaws(Some(&start)) + self.work_of_jaws(None)),
            work_of_loads,
            released: released + if is_relaxation { off } else { 0.0 },
            numerical_elastic: if is_relaxation { 0.0 } else { off },
            numerical_kinetic: kinetic,
            ..EnergyBalance::default()
        }
    }
}
