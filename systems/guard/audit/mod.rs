//! The energy audit: every term of [`EnergyBalance`](crate::components::EnergyBalance) over a step, each from its own formula.
//!
//! Six short systems. `begin` lets the last step stand; `refined` measures the mesh changes before the step; `membrane` and
//! `loads` keep the forces of the last evaluation apart; `account` sums the terms when the iterations have ended; `edits`
//! measures the changes by tears at fixed positions. Reactions, residual and nodal forces are those of the step itself; the
//! scheme's works on the membrane are recomputed triangle by triangle, so that an error in either leaves an imbalance.
//!
//! A dynamic step by backward Euler, the only formula that these terms are of, ends with
//! M·(v₁ − v₀)/dt = f(x_k) − K·δ + loads + reactions − residual, linearised at its last evaluation x_k = x₁ − δ.
//! It is multiplied by u = x₁ − x₀: the term of M gives Δkinetic and ½·(v₁ − v₀)·M·(v₁ − v₀). A static solve only knows its two
//! ends; its works are those of the mean of the forces there.

mod carried;

use crate::components::{
    Bending, CompartmentState, Damping, Drag, Energies, EnergyAudit, EnergyBalance, Equilibrium, ExternalStiffness,
    FibreLaws, Forces, Frames, Grips, Holds, Increment, Planar, PreStretch, Reactions, Refined, SolveResult,
    SolverScratch, TearDecisions, TearLog, Tearing, fibre_law,
};
use crate::event::EventKind;
use crate::math::FibreLaw;
use crate::storage::room::copy;
use crate::storage::{Topology, Triangles, Vertices};
use crate::systems::bending::DihedralAngles;
use crate::systems::forces::compartment::ContentTerms;
use crate::systems::forces::element::BodyLaw;
use crate::systems::forces::relaxation;
use crate::systems::kernels::path_work::Element;
use crate::systems::{StepContext, parallel};
use carried::Carried;
use glam::DVec3;

/// Data on which the elastic energy depends beside positions.
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

    /// Adds the energy of bending, where there is any.
    pub fn bent(self, bending: Option<&'a Bending>, vertices: &'a Vertices, topology: &'a Topology) -> Self {
        Self { bending: bending.map(|bending| (bending, vertices, topology)), ..self }
    }

    fn element(&self, t: usize) -> Element<'_> {
        let (is_planar, unstretched) = (self.is_planar, PreStretch::unstretched(self.pre_stretch));
        BodyLaw { is_planar, unstretched, fibres: self.fibres.as_ref() }.element(self.triangles, t)
    }

    /// Energies with the vertices at these positions and velocities. `partials` is scratch.
    pub fn energies(&self, x: &[DVec3], v: &[DVec3], mass: &[f64], partials: &mut Vec<f64>) -> Energies {
        let energy = |t: usize| self.element(t).energy(self.triangles.corners[t].map(|c| x[c as usize]));
        let stretched = parallel::sum(self.triangles.len(), partials, energy);
        let bent = self.bending.map_or(0.0, |(bending, vertices, topology)| {
            DihedralAngles::energy_at((vertices, self.triangles, topology), bending, None, x)
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
pub fn begin(world: &mut hecs::World, step: &StepContext) -> usize {
    let mut count = 0;
    type Query<'a> = (
        (&'a mut EnergyAudit, Option<&'a Refined>, &'a Vertices, &'a Triangles, &'a Topology),
        (Strained<'a>, Option<&'a Bending>, &'a mut SolverScratch, &'a SolveResult, Option<&'a Tearing>),
    );
    for ((audit, refined, vertices, triangles, topology), (strained, bending, scratch, _, tearing)) in
        world.query_mut::<Query>()
    {
        count += 1;
        audit.settle(tearing.is_some_and(|tearing| tearing.glides(step.is_static)));
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

/// Measures the energy changes by refinement and coarsening between two steps.
pub fn refined(world: &mut hecs::World, _: &StepContext) -> usize {
    let mut count = 0;
    type Query<'a> = (
        (&'a mut EnergyAudit, &'a Refined, &'a Vertices, &'a Triangles, &'a Topology),
        (Strained<'a>, Option<&'a Bending>, &'a mut SolverScratch, &'a SolveResult),
    );
    for ((audit, _, vertices, triangles, topology), (strained, bending, scratch, _)) in world.query_mut::<Query>() {
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
    type Query<'a> = (&'a mut EnergyAudit, &'a Vertices, &'a Forces, &'a Increment, &'a SolveResult);
    for (audit, vertices, forces, increment, result) in world.query_mut::<Query>() {
        if !result.is_active() {
            continue;
        }
        count += 1;
        let room = vertices.position.capacity();
        let EnergyAudit { loads, start: [start_membrane, start_loads], displacement, equilibrium, .. } = audit;
        if step.is_static && result.newton_iterations == 0 {
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
    for (audit, forces, result) in world.query_mut::<(&mut EnergyAudit, &Forces, &SolveResult)>() {
        if !result.is_active() {
            continue;
        }
        count += 1;
        let EnergyAudit { loads, start: [_, start_loads], .. } = audit;
        parallel::for_rows(loads, |v, load| *load = forces.nodal[v] - *load);
        if step.is_static && result.newton_iterations == 0 && start_loads.is_empty() {
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
        (&'a Forces, &'a Increment, &'a SolverScratch, &'a SolveResult),
        (Option<&'a ExternalStiffness>, Option<&'a Damping>, Option<&'a Drag>, Option<&'a CompartmentState>),
        (Option<(&'a Holds, &'a Reactions)>, Option<&'a Grips>),
        (Strained<'a>, Option<&'a Bending>, Option<&'a DihedralAngles>),
    );
    for (
        (audit, log, decisions),
        (vertices, triangles, topology, frames),
        (forces, increment, scratch, result),
        (external, damping, drag, compartment),
        (held, grips),
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
        let is_planar = strained.0.is_some();
        let relaxation = relaxation::dissipated(&vertices.position, triangles, is_planar, &mut Vec::new());
        let sheet = Sheet::new(triangles, strained).bent(bending, vertices, topology);
        let viscosity = damping.map_or(0.0, |d| d.time) * step.inv_effective_dt();
        let body = Carried {
            vertices,
            sheet,
            topology,
            frames,
            forces,
            increment,
            scratch,
            result,
            external,
            viscosity,
            drag,
            held,
            grips,
            folds,
            compartment,
        };
        let of_content = ContentTerms::of(compartment, &increment.displacement, step);
        if step.is_static && step.newton_iterations > 1 {
            let sums = body.sums(audit, true, |t, x, u, _| body.between_ends(t, x, u));
            let is_relaxation = audit.equilibrium.is_some_and(|last| last.time == step.time);
            let terms = body.static_terms(audit, &sums, is_relaxation);
            *audit.step = of_content.told(EnergyBalance { relaxation, ..terms });
            note_equilibrium(audit, log, step, result.has_converged);
        } else {
            let sums = body.sums(audit, false, |t, _, u, change| body.linearised(t, u, change));
            let terms = body.dynamic_terms(audit, &sums, step);
            audit.note_step(of_content.told(EnergyBalance { relaxation, ..terms }));
            audit.equilibrium = None;
        }
    }
    count
}

/// Measures the energy changes by tears at the end of the step and, should it be redone, at its start.
pub fn edits(world: &mut hecs::World, _: &StepContext) -> usize {
    let mut count = 0;
    type Query<'a> = (
        (&'a mut EnergyAudit, &'a TearDecisions, &'a Vertices, &'a Triangles, &'a Topology, &'a Increment),
        (Strained<'a>, Option<&'a Bending>, &'a mut SolverScratch, &'a SolveResult),
    );
    for ((audit, _, vertices, triangles, topology, increment), (strained, bending, scratch, _)) in
        world.query_mut::<Query>()
    {
        count += 1;
        let sheet = Sheet::new(triangles, strained).bent(bending, vertices, topology);
        let Vertices { position, velocity, mass, .. } = vertices;
        let Increment { start, start_velocity, .. } = increment;
        let ends = [(start, start_velocity), (position, velocity)];
        let ends = ends.map(|(x, v)| sheet.energies(x, v, mass, &mut scratch.partials));
        audit.note_tear([ends[0] - audit.ends[0], ends[1] - audit.ends[1]]);
    }
    count
}

/// Records an equilibrium. Where tears have advanced since the last one and nothing else has moved on, it reports the energy
/// they have released: the fall of the elastic energy and the work of the loads.
fn note_equilibrium(audit: &mut EnergyAudit, log: &mut TearLog, step: &StepContext, has_converged: bool) {
    let now = Equilibrium { time: step.time, elastic: audit.ends[1].elastic, torn: log.length };
    if let Some(last) = audit.equilibrium.filter(|last| has_converged && last.time == now.time && last.torn < now.torn)
    {
        let energy = last.elastic - now.elastic + audit.step.work_of_loads;
        log.pending.push(EventKind::Released { energy, length: now.torn - last.torn });
    }
    audit.equilibrium = has_converged.then_some(now);
}
