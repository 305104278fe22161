//! The energy audit: every term of [`EnergyBalance`] over a step, each from its own formula.
//!
//! Six short systems. `begin` lets the last step stand; `refined` measures what changes the mesh before the step;
//! `membrane` and `loads` keep the forces of the last evaluation apart; `account` sums the terms when the iterations
//! have ended; `edits` measures what tears have changed at fixed positions. Reactions, residual and nodal forces are
//! those of the step itself; what the scheme did with the membrane is computed anew, triangle by triangle, so that an
//! error in either leaves an imbalance.
//!
//! A dynamic step by backward Euler, the only formula that these terms are of, ends with M·(v₁ − v₀)/dt = f(x_k) −
//! K·δ + loads + reactions − residual, linearised at its last evaluation x_k = x₁ − δ. It is multiplied by u = x₁ − x₀:
//! what M gives is Δkinetic and ½·(v₁ − v₀)·M·(v₁ − v₀). A static solve only knows its two ends; its works are those of
//! the mean of the forces there.

use super::kernels::membrane::{ElementTangent, shear_majorant, stretch_rate};
use super::kernels::path_work::Element;
use super::linear::Folds;
use super::{StepContext, parallel};
use crate::components::{
    Bending, Damping, Drag, Energies, EnergyAudit, EnergyBalance, Equilibrium, ExternalStiffness, FibreLaws, Forces,
    Frames, Holds, Increment, Planar, PreStretch, Reactions, Refined, Shares, SolverScratch, TearDecisions, TearLog,
    fibre_law,
};
use crate::event::EventKind;
use crate::math::{FibreLaw, GeometricStiffness};
use crate::settings::Tangent;
use crate::storage::room::copy;
use crate::storage::{Topology, Triangles, Vertices};
use glam::DVec3;

/// What the elastic energy depends on beside positions.
#[derive(Clone, Copy)]
pub struct Sheet<'a> {
    triangles: &'a Triangles,
    bending: Option<(&'a Bending, &'a Vertices, &'a Topology)>,
    is_planar: bool,
    pre_stretch: Option<&'a PreStretch>,
    fibres: Option<FibreLaw>,
}

/// The components, beside bending, that the energy of the triangles depends on.
type Strained<'a> = (Option<&'a Planar>, Option<&'a PreStretch>, FibreLaws<'a>);

impl<'a> Sheet<'a> {
    /// The triangles of a body with the components that their energy depends on.
    pub fn new(triangles: &'a Triangles, (planar, pre_stretch, fibres): Strained<'a>) -> Self {
        let fibres = fibre_law(fibres, pre_stretch);
        Self { triangles, bending: None, is_planar: planar.is_some(), pre_stretch, fibres }
    }

    /// With the energy of bending, where there is any.
    pub fn bent(self, bending: Option<&'a Bending>, vertices: &'a Vertices, topology: &'a Topology) -> Self {
        Self { bending: bending.map(|bending| (bending, vertices, topology)), ..self }
    }

    fn element(&self, t: usize) -> Element<'_> {
        let rest = &self.triangles.rest[t];
        Element {
            rest,
            stiffness: &self.triangles.stiffness[t],
            volume: rest.area * self.triangles.thickness[t],
            is_planar: self.is_planar,
            unstretched: PreStretch::unstretched(self.pre_stretch),
            fibres: self.fibres.as_ref(),
        }
    }

    /// Energies with the vertices at these positions and velocities. `partials` is scratch.
    pub fn energies(&self, x: &[DVec3], v: &[DVec3], mass: &[f64], partials: &mut Vec<f64>) -> Energies {
        let energy = |t: usize| self.element(t).energy(self.triangles.corners[t].map(|c| x[c as usize]));
        let stretched = parallel::sum(self.triangles.len(), partials, energy);
        let bent = self.bending.map_or(0.0, |(bending, vertices, topology)| {
            Folds::energy_at((vertices, self.triangles, topology), bending, None, x)
        });
        Energies { elastic: stretched + bent, kinetic: kinetic(v, mass) }
    }
}

fn kinetic(velocity: &[DVec3], mass: &[f64]) -> f64 {
    velocity.iter().zip(mass).map(|(v, m)| 0.5 * m * v.length_squared()).sum()
}

fn dot(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum()
}

/// Lets the last step stand, and measures the energies with which the first one begins, and every one of a mesh that may be
/// refined before it.
pub fn begin(world: &mut hecs::World, _: &StepContext) -> usize {
    let mut count = 0;
    type Query<'a> = (
        (&'a mut EnergyAudit, Option<&'a Refined>, &'a Vertices, &'a Triangles, &'a Topology),
        (Strained<'a>, Option<&'a Bending>, &'a mut SolverScratch),
    );
    for ((audit, refined, vertices, triangles, topology), (strained, bending, scratch)) in world.query_mut::<Query>() {
        count += 1;
        audit.settle();
        if audit.initial.is_none() || refined.is_some() {
            let sheet = Sheet::new(triangles, strained).bent(bending, vertices, topology);
            let Vertices { position, velocity, mass, .. } = vertices;
            let now = sheet.energies(position, velocity, mass, &mut scratch.partials);
            audit.initial.get_or_insert(now);
            audit.ends = [now; 2];
        }
    }
    count
}

/// Measures what refinement and coarsening have changed between two steps.
pub fn refined(world: &mut hecs::World, _: &StepContext) -> usize {
    let mut count = 0;
    type Query<'a> = (
        (&'a mut EnergyAudit, &'a Refined, &'a Vertices, &'a Triangles, &'a Topology),
        (Strained<'a>, Option<&'a Bending>, &'a mut SolverScratch),
    );
    for ((audit, _, vertices, triangles, topology), (strained, bending, scratch)) in world.query_mut::<Query>() {
        count += 1;
        let sheet = Sheet::new(triangles, strained).bent(bending, vertices, topology);
        let Vertices { position, velocity, mass, .. } = vertices;
        let now = sheet.energies(position, velocity, mass, &mut scratch.partials);
        audit.note_edits(now - audit.ends[1]);
    }
    count
}

/// Keeps the forces of the membrane, before loads are added to them.
pub fn membrane(world: &mut hecs::World, step: &StepContext) -> usize {
    let mut count = 0;
    type Query<'a> = (&'a mut EnergyAudit, &'a Vertices, &'a Forces, &'a Increment, &'a SolverScratch);
    for (audit, vertices, forces, increment, scratch) in world.query_mut::<Query>() {
        if scratch.is_converged {
            continue;
        }
        count += 1;
        let room = vertices.position.capacity();
        let EnergyAudit { loads, start: [start_membrane, start_loads], displacement, equilibrium, .. } = audit;
        if step.is_static && scratch.newton_iterations == 0 {
            copy(start_membrane, &forces.nodal, room);
            start_loads.clear();
            if equilibrium.is_some_and(|e| e.time != step.time) && loads.len() == forces.nodal.len() {
                std::mem::swap(loads, start_loads);
            }
        }
        copy(loads, &forces.nodal, room);
        copy(displacement, &increment.displacement, room);
    }
    count
}

/// Keeps the forces of the loads and, in a static solve that puts them on at once, those at its start.
pub fn loads(world: &mut hecs::World, step: &StepContext) -> usize {
    let mut count = 0;
    for (audit, forces, scratch) in world.query_mut::<(&mut EnergyAudit, &Forces, &SolverScratch)>() {
        if scratch.is_converged {
            continue;
        }
        count += 1;
        let EnergyAudit { loads, start: [_, start_loads], .. } = audit;
        parallel::for_rows(loads, |v, load| *load = forces.nodal[v] - *load);
        if step.is_static && scratch.newton_iterations == 0 && start_loads.is_empty() {
            start_loads.clone_from(loads);
        }
    }
    count
}

/// Sums the terms of the step that has just been carried out.
pub fn account(world: &mut hecs::World, step: &StepContext) -> usize {
    let mut count = 0;
    type Query<'a> = (
        (&'a mut EnergyAudit, &'a mut TearLog, Option<&'a TearDecisions>),
        (&'a Vertices, &'a Triangles, &'a Topology, &'a Frames),
        (&'a Forces, &'a Increment, &'a SolverScratch),
        (Option<&'a ExternalStiffness>, Option<&'a Damping>, Option<&'a Drag>, Option<(&'a Holds, &'a Reactions)>),
        (Strained<'a>, Option<&'a Bending>, Option<&'a Folds>),
    );
    for (
        (audit, log, decisions),
        (vertices, triangles, topology, frames),
        (forces, increment, scratch),
        (external, damping, drag, held),
        (strained, bending, folds),
    ) in world.query_mut::<Query>()
    {
        if step.is_resumed {
            if !decisions.is_some_and(|d| d.may_advance_further) {
                continue;
            }
            audit.void_step();
        }
        count += 1;
        let sheet = Sheet::new(triangles, strained).bent(bending, vertices, topology);
        let body =
            Carried { vertices, sheet, topology, frames, forces, increment, scratch, external, drag, held, folds };
        let viscosity = damping.map_or(0.0, |d| d.time) * step.rate();
        if step.is_static && step.newton_iterations > 1 {
            let sums = body.sums(audit, true, |t, x, u, _| body.between_ends(t, x, u));
            let is_relaxation = audit.equilibrium.is_some_and(|last| last.time == step.time);
            audit.step = body.static_terms(audit, &sums, is_relaxation);
            note_equilibrium(audit, log, step, scratch.is_converged);
        } else {
            let sums = body.sums(audit, false, |t, _, u, change| body.linearised(t, u, change, viscosity));
            audit.step = body.dynamic_terms(audit, &sums, step);
            audit.equilibrium = None;
        }
    }
    count
}

/// Measures what tears have changed in the end of the step and, should it be taken up again, in its start.
pub fn edits(world: &mut hecs::World, _: &StepContext) -> usize {
    let mut count = 0;
    type Query<'a> = (
        (&'a mut EnergyAudit, &'a TearDecisions, &'a Vertices, &'a Triangles, &'a Topology, &'a Increment),
        (Strained<'a>, Option<&'a Bending>, &'a mut SolverScratch),
    );
    for ((audit, _, vertices, triangles, topology, increment), (strained, bending, scratch)) in
        world.query_mut::<Query>()
    {
        count += 1;
        let sheet = Sheet::new(triangles, strained).bent(bending, vertices, topology);
        let Vertices { position, velocity, mass, .. } = vertices;
        let Increment { start, start_velocity, .. } = increment;
        audit.edits_of_start = sheet.energies(start, start_velocity, mass, &mut scratch.partials) - audit.ends[0];
        audit.step.edits = sheet.energies(position, velocity, mass, &mut scratch.partials) - audit.ends[1];
    }
    count
}

/// A body when its iterations have ended.
struct Carried<'a> {
    vertices: &'a Vertices,
    sheet: Sheet<'a>,
    topology: &'a Topology,
    frames: &'a Frames,
    forces: &'a Forces,
    increment: &'a Increment,
    scratch: &'a SolverScratch,
    external: Option<&'a ExternalStiffness>,
    drag: Option<&'a Drag>,
    held: Option<(&'a Holds, &'a Reactions)>,
    folds: Option<&'a Folds>,
}

impl Carried<'_> {
    /// Sums over the triangles their true work along the step, what `terms` gives for it (the scheme's work and the
    /// damping), and their energies at both ends, from x₀, u and u − u_k; with those of bending, whose work may be that between the ends.
    fn sums(
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
                Folds::works_between_ends(body, bending, start, displacement)
            } else {
                let is_exact = self.scratch.tangent == Tangent::Exact;
                folds.works_of_step(body, bending, start, (evaluated, displacement), is_exact)
            };
            sums += Shares { work, scheme, damping, start, end };
        }
        sums
    }

    /// −(mean of the forces at both ends) · u.
    fn between_ends(&self, t: usize, x: [DVec3; 3], u: [DVec3; 3]) -> [f64; 2] {
        let element = self.sheet.element(t);
        let end = std::array::from_fn(|i| x[i] + u[i]);
        [0.5 * (element.slope(x, u) + element.slope(end, u)), 0.0]
    }

    /// −(f(x_k) − K·δ) · u with the tangent that was used, and dt·v·C·v.
    fn linearised(&self, t: usize, u: [DVec3; 3], change: [DVec3; 3], viscosity: f64) -> [f64; 2] {
        let Sheet { triangles, .. } = self.sheet;
        let (state, rest) = (self.frames.state(t), &triangles.rest[t]);
        let (stiffness, coupling) = (self.frames.stiffness(triangles, t), self.frames.coupling(t));
        let volume = rest.area * triangles.thickness[t];
        let GeometricStiffness { mut normal, mut in_plane } = self.frames.geometric_stiffness(t);
        let is_exact = self.scratch.tangent != Tangent::Rotated;
        if !is_exact {
            // The frames may hold what goes with another tangent, which was indefinite; what goes with this one stays.
            normal = normal.positive_part();
            let law = &triangles.stiffness[t];
            in_plane = shear_majorant(state.stress, state.polar.stretch, law, StepContext::RESERVE_OF_EULER);
        }
        let (elastic, geometric) = (volume, volume);
        let tangent =
            ElementTangent { state, rest, stiffness, coupling, normal, in_plane, elastic, geometric, is_exact };
        let rate = stretch_rate(&state.polar, rest, u);
        let scheme = volume * state.stress.contract(rate) + dot(&tangent.apply(change), &u);
        [scheme, volume * viscosity * stiffness.coupled_stress(coupling, rate).contract(rate)]
    }

    /// Work of the holds' reactions along the step.
    fn work_of_reactions(&self) -> f64 {
        let Some((holds, reactions)) = self.held else { return 0.0 };
        let groups = holds.groups.iter().zip(&reactions.groups);
        let pairs = groups.flat_map(|(hold, forces)| hold.members.rows().iter().zip(forces));
        pairs.map(|(&row, force)| force.dot(self.increment.displacement[row as usize])).sum()
    }

    fn dynamic_terms(&self, audit: &mut EnergyAudit, sums: &Shares, step: &StepContext) -> EnergyBalance {
        let Vertices { velocity, mass, .. } = self.vertices;
        let Increment { start_velocity, displacement: u, .. } = self.increment;
        let mut work_of_loads = dot(&audit.loads, u);
        if let Some(external) = self.external {
            let blocks = external.block.iter().zip(u).zip(&audit.displacement);
            work_of_loads -= blocks.map(|((k, u), at)| (*k * (*u - *at)).dot(*u)).sum::<f64>();
        }
        let coefficient = self.drag.map_or(0.0, |d| d.coefficient) * step.rate();
        let area = |v: usize| self.topology.vertex_area(self.sheet.triangles, v as u32);
        let braked = |(v, u): (usize, &DVec3)| coefficient * area(v) * u.length_squared();
        let drag = if coefficient > 0.0 { u.iter().enumerate().map(braked).sum() } else { 0.0 };
        let jumps = velocity.iter().zip(start_velocity).zip(mass);
        let residual = self.scratch.residual.iter().zip(&self.scratch.free).zip(u);
        audit.ends = [
            Energies { elastic: sums.start, kinetic: kinetic(start_velocity, mass) },
            Energies { elastic: sums.end, kinetic: kinetic(velocity, mass) },
        ];
        EnergyBalance {
            work_of_holds: self.work_of_reactions(),
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
            residual: residual.map(|((r, f), u)| (*r * *f).dot(*u)).sum(),
            ..EnergyBalance::default()
        }
    }

    /// In a relaxation, which follows an equilibrium at the same time, what the trapezoidal rule is off belongs to what is
    /// released; else the scheme's works are off by it.
    fn static_terms(&self, audit: &mut EnergyAudit, sums: &Shares, is_relaxation: bool) -> EnergyBalance {
        let Increment { start_velocity, displacement: u, .. } = self.increment;
        let [start_membrane, start_loads] = &audit.start;
        let (mut start_reactions, mut released) = (0.0, 0.0);
        for (v, free) in self.scratch.free.iter().enumerate() {
            let start = start_membrane[v] + start_loads[v];
            let end = self.forces.nodal[v];
            start_reactions -= (start * (DVec3::ONE - *free)).dot(u[v]);
            released += 0.5 * ((start + end) * *free).dot(u[v]);
        }
        let off = sums.scheme - sums.work;
        let work_of_loads = 0.5 * (dot(start_loads, u) + dot(&audit.loads, u));
        let kinetic = kinetic(start_velocity, &self.vertices.mass);
        audit.ends = [Energies { elastic: sums.start, kinetic }, Energies { elastic: sums.end, kinetic: 0.0 }];
        EnergyBalance {
            work_of_holds: 0.5 * (start_reactions + self.work_of_reactions()),
            work_of_loads,
            released: released + if is_relaxation { off } else { 0.0 },
            numerical_elastic: if is_relaxation { 0.0 } else { off },
            numerical_kinetic: kinetic,
            ..EnergyBalance::default()
        }
    }
}

/// Remembers an equilibrium. Where tears have advanced since the last one and nothing else has moved on, tells what they have
/// released: the fall of the elastic energy and the work of the loads.
fn note_equilibrium(audit: &mut EnergyAudit, log: &mut TearLog, step: &StepContext, is_converged: bool) {
    let now = Equilibrium { time: step.time, elastic: audit.ends[1].elastic, torn: log.length };
    if let Some(last) = audit.equilibrium.filter(|last| is_converged && last.time == now.time && last.torn < now.torn) {
        let energy = last.elastic - now.elastic + audit.step.work_of_loads;
        log.pending.push(EventKind::Released { energy, length: now.torn - last.torn });
    }
    audit.equilibrium = is_converged.then_some(now);
}
