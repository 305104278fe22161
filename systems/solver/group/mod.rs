//! One solve for bodies that touch each other, before each is solved by itself.
//!
//! Springs between bodies couple their systems: A·δ + Σ k·(n·w)·(n·w)ᵀ·δ = b over all vertices of a group. Conjugate gradients in double precision
//! solve that with an incomplete factor of the whole. The forces of the springs in the answer, equal and opposite, are then loads of the bodies, which
//! take δ as it is: reactions, the energy guard and the balance of momentum see loads. Solved in turns, a light body on stiff springs would be
//! thrown off.

mod dense;
mod factor;

use super::initial_guess::residual_without;
use super::patch::Patch;
use super::{Operator, ProductMemory};
use crate::components::{
    BodyGroup, CompartmentState, Damping, ExternalStiffness, Forces, Frames, FreeAxes, Increment, PairSpring,
    SolveResult, SolverScratch,
};
use crate::settings::Tangent;
use crate::settings::ablation::Part as Ablated;
use crate::storage::{Topology, Triangles, Vertices};
use crate::systems::bending::{BendingPasses, DihedralAngles};
use crate::systems::contact::layers::{give_back, take_groups};
use crate::systems::{Formula, StepContext, work};
use dense::solve_dense;
use factor::{Blocks, Factor};
use glam::DVec3;
use hecs::{Entity, World};

/// Maximum iterations.
const MOST_ITERATIONS: u32 = 400;

type Query<'a> = (
    (&'a Vertices, &'a Triangles, &'a Topology, &'a Frames),
    (&'a mut Forces, &'a mut Increment, &'a mut SolveResult, &'a mut SolverScratch),
    (&'a mut ExternalStiffness, Option<&'a DihedralAngles>, Option<&'a mut BendingPasses>),
    (Option<&'a Damping>, Option<&'a CompartmentState>),
);

/// Solves the groups of bodies between which there are springs, and loads the bodies with their forces. Returns the number of bodies.
pub fn solve(world: &mut World, step: &StepContext) -> usize {
    let mut count = 0;
    for (first, mut group) in take_groups(world) {
        if !group.springs.is_empty() {
            let bodies = world.query_mut::<(Entity, Query)>().into_iter();
            let mut bodies: Vec<(usize, Query)> = bodies
                .filter_map(|(entity, body)| Some((group.bodies.iter().position(|other| *other == entity)?, body)))
                .filter(|(_, (_, (_, _, result, _), ..))| result.is_active())
                .collect();
            bodies.sort_by_key(|(place, _)| *place);
            count += bodies.len();
            load(&mut group, &mut bodies, step);
        }
        give_back(world, first, group);
    }
    count
}

/// End of a spring: the part and its row; none where the body stands.
type End = Option<(usize, usize)>;

/// A spring between bodies in the solve.
struct Link {
    spring: PairSpring,
    ends: [End; 4],
    /// Force at the evaluation, and in the answer \[N\].
    start: f64,
    force: f64,
}

impl Link {
    /// Ends with their weights.
    fn ends(&self) -> impl Iterator<Item = (usize, usize, f64)> {
        let ends = self.ends.iter().zip(self.spring.weights);
        ends.filter_map(|(end, weight)| end.map(|(part, row)| (part, row, weight)))
    }

    /// Growth of its length \[mm\] by displacements of the parts.
    fn growth(&self, of: impl Fn(usize, usize) -> DVec3) -> f64 {
        self.spring.normal.dot(self.ends().map(|(part, row, weight)| of(part, row) * weight).sum())
    }
}

/// Solves a group, and loads its bodies with the forces between them.
fn load(group: &mut BodyGroup, bodies: &mut [(usize, Query<'_>)], step: &StepContext) {
    let BodyGroup { springs, first, .. } = group;
    let end = |row: u32| {
        let place = first.partition_point(|first| *first <= row) - 1;
        let part = bodies.iter().position(|(of, _)| *of == place)?;
        Some((part, (row - first[place]) as usize))
    };
    let link = |&(spring, force): &(PairSpring, f64)| Link { ends: spring.rows.map(end), spring, start: force, force };
    let mut links: Vec<Link> = springs.iter().map(link).collect();
    let is_exact = |(_, (_, (_, _, result, _), ..)): &(usize, Query)| step.tangent_of(result) == Tangent::Exact;
    if step.is_static || bodies.iter().any(is_exact) {
        // An exact tangent may be indefinite: each body has the springs as if the others stood.
        for link in &links {
            for (place, end) in link.ends.iter().enumerate() {
                let Some((part, row)) = *end else { continue };
                let (_, (_, _, (external, ..), _)) = &mut bodies[part];
                external.block[row] += link.spring.block(place);
            }
        }
    } else if step.formula != Formula::Start {
        let mut spare: Vec<BendingPasses> = bodies.iter().map(|_| BendingPasses::default()).collect();
        let parts = bodies.iter_mut().zip(&mut spare);
        let parts: Vec<Part> = parts.map(|((_, body), spare)| Part::new(body, spare, step)).collect();
        let mut solve = Group::new(parts, links);
        solve.solve(step);
        links = solve.links;
    }
    for link in &links {
        for (part, row, weight) in link.ends() {
            let (_, (_, (forces, _, _, scratch), ..)) = &mut bodies[part];
            let force = link.spring.normal * (link.force * weight);
            forces.nodal[row] += force;
            scratch.momentum.balance.iter_mut().for_each(|balance| balance.loads += force);
        }
    }
}

/// A body in the solve of its group.
struct Part<'a> {
    operator: Operator<'a>,
    memory: ProductMemory<'a>,
    x: &'a mut [DVec3],
    scratch: &'a mut SolverScratch,
    result: &'a mut SolveResult,
    patches: Vec<Patch>,
    /// Right-hand side without springs \[N\].
    rhs: Vec<DVec3>,
    /// Squared norm of the momenta at the start of the step over its length \[N²\].
    momentum_sq: f64,
    residual: Vec<DVec3>,
    direction: Vec<DVec3>,
    /// Product with the direction, and in turn the preconditioned residual.
    product: Vec<DVec3>,
}

impl<'a> Part<'a> {
    fn new(
        (
            (vertices, triangles, topology, frames),
            (forces, increment, result, scratch),
            implicit,
            (damping, compartment),
        ): &'a mut Query<'_>,
        spare: &'a mut BendingPasses,
        step: &StepContext,
    ) -> Self {
        let (external, folds, passes) = implicit;
        let operator = Operator {
            external: Some(external),
            volume: compartment.map(CompartmentState::stiffness),
            folds: *folds,
            inertia: step.inertia(),
            viscosity: damping.map_or(0.0, |damping| damping.time) * step.inv_effective_dt(),
            ..Operator::membrane((vertices, triangles, topology, frames), step.tangent_of(result))
        };
        let known = |v: usize| forces.nodal[v] + step.momentum(increment, v) * vertices.mass[v];
        let rhs: Vec<DVec3> = (0..vertices.len()).map(known).collect();
        let momentum =
            |(velocity, mass): (&DVec3, &f64)| (*velocity * (*mass * step.inv_effective_dt())).length_squared();
        let momentum_sq = increment.start_velocity.iter().zip(&vertices.mass).map(momentum).sum();
        let zero = vec![DVec3::ZERO; vertices.len()];
        Self {
            patches: Patch::all(&operator, &scratch.free),
            operator,
            memory: ProductMemory { corner: &mut forces.corner, passes: passes.as_deref_mut().unwrap_or(spare) },
            x: &mut increment.delta,
            scratch,
            result,
            rhs,
            momentum_sq,
            residual: zero.clone(),
            direction: zero.clone(),
            product: zero,
        }
    }

    /// `product` = A·`direction`; returns the scalar product of both.
    fn multiply(&mut self) -> f64 {
        let Self { operator, memory, scratch, direction, product, .. } = self;
        let SolverScratch { free, partials, .. } = &mut **scratch;
        operator.apply(direction, free, memory, product, partials)
    }
}

/// Factors the operators with the springs.
fn factor(parts: &[Part<'_>], links: &[Link], first: &[u32]) -> Factor {
    let mut blocks = Blocks::default();
    parts.iter().zip(first).for_each(|(part, first)| blocks.add_body(&part.operator, *first));
    for link in links {
        blocks.add_spring(&link.spring, link.ends.map(|end| end.map(|(part, row)| first[part] + row as u32)));
    }
    let free: Vec<&FreeAxes> = parts.iter().map(|part| &part.scratch.free).collect();
    blocks.finish(&free, first);
    blocks.factor()
}

/// The bodies of a group that are solved, and the springs between them.
struct Group<'a> {
    parts: Vec<Part<'a>>,
    links: Vec<Link>,
    /// First row of every part in the factor.
    first: Vec<u32>,
    factor: Factor,
    /// Rows of all parts.
    rows: Vec<DVec3>,
}

impl<'a> Group<'a> {
    fn new(parts: Vec<Part<'a>>, links: Vec<Link>) -> Self {
        let mut count = 0;
        let mut first = Vec::new();
        for part in &parts {
            first.push(count);
            count += part.x.len() as u32;
        }
        let factor = factor(&parts, &links, &first);
        Self { parts, links, first, factor, rows: vec![DVec3::ZERO; count as usize] }
    }

    /// Solves for the displacements of all bodies, and the forces of the springs.
    fn solve(&mut self, step: &StepContext) {
        let most = self.parts.iter().filter_map(|part| step.left(part.result)).min();
        let most = most.map_or(MOST_ITERATIONS, |left| (left / 2).clamp(work::LEAST_ITERATIONS, MOST_ITERATIONS));
        let reference_sq = self.begin(step);
        let guess: Vec<Vec<DVec3>> = self.parts.iter().map(|part| part.x.to_vec()).collect();
        let tolerance = step.linear.tolerance;
        let iterations = self.iterate(tolerance * tolerance * reference_sq, most);
        let relative = if reference_sq > 0.0 { (self.residual_sq() / reference_sq).sqrt() } else { 0.0 };
        self.balance();
        let Self { parts, links, .. } = self;
        for link in links.iter_mut() {
            link.force = link.start - link.spring.stiffness * link.growth(|part, row| parts[part].x[row]);
        }
        if !links.iter().all(|link| link.force.is_finite()) {
            links.iter_mut().for_each(|link| link.force = link.start);
            parts.iter_mut().zip(&guess).for_each(|(part, guess)| part.x.copy_from_slice(guess));
        }
        for part in &mut self.parts {
            part.scratch.contact.solved_together = Some(relative);
            part.result.iterations += iterations;
            part.result.work = part.result.work.saturating_add(work::SET_UP).saturating_add(iterations);
        }
    }

    /// Returns the squared norm that residuals are measured by: that of the momentum at the start, of a zero guess or of the step. Springs are left out of
    /// it: beside those that push bodies out of each other all else would be nothing.
    fn begin(&mut self, step: &StepContext) -> f64 {
        let mut sum = 0.0;
        for part in &mut self.parts {
            let Part { operator, memory, x, scratch, rhs, direction, product, .. } = part;
            let SolverScratch { free, partials, reference_sq: of_step, .. } = &mut **scratch;
            if step.is_fallback || !step.has(Ablated::InitialGuess) {
                x.iter_mut().zip(&*free).for_each(|(x, free)| *x *= DVec3::ONE - *free);
            }
            let own = residual_without(operator, (x, free, rhs), direction, product, (partials, memory.passes));
            *of_step = own.unwrap_or(0.0).max(*of_step).max(part.momentum_sq);
            sum += *of_step;
        }
        sum
    }

    /// Conjugate gradients from the displacements at hand, until the squared norm of the residual is at most `least_sq`. Returns the iterations.
    fn iterate(&mut self, least_sq: f64, most: u32) -> u32 {
        for part in &mut self.parts {
            part.direction.copy_from_slice(part.x);
            part.multiply();
            let Part { scratch, rhs, residual, product, .. } = part;
            for (v, r) in residual.iter_mut().enumerate() {
                *r = (rhs[v] - product[v]) * scratch.free[v];
            }
        }
        let Self { parts, links, .. } = &mut *self;
        for link in links {
            let force = link.start - link.spring.stiffness * link.growth(|part, row| parts[part].x[row]);
            for (part, row, weight) in link.ends() {
                let Part { scratch, residual, .. } = &mut parts[part];
                residual[row] += link.spring.normal * (force * weight) * scratch.free[row];
            }
        }
        let (mut iterations, mut rz, mut beta) = (0, self.precondition(), 0.0);
        while self.residual_sq() > least_sq && iterations < most {
            for Part { direction, product, .. } in &mut self.parts {
                direction.iter_mut().zip(&*product).for_each(|(p, z)| *p = *z + *p * beta);
            }
            let curvature = self.multiply();
            if !(curvature > 0.0 && curvature.is_finite() && rz.is_finite()) {
                break;
            }
            let alpha = rz / curvature;
            for Part { scratch, x, residual, direction, product, .. } in &mut self.parts {
                for v in 0..x.len() {
                    x[v] += direction[v] * alpha;
                    residual[v] -= product[v] * scratch.free[v] * alpha;
                }
            }
            let before = std::mem::replace(&mut rz, self.precondition());
            beta = rz / before;
            iterations += 1;
        }
        iterations
    }

    /// Moves every body so that the sum of its residual is zero (Galerkin's condition for its three translations): stiff forces within a body, which the
    /// residual is small beside, would leave an error of its momentum otherwise.
    fn balance(&mut self) {
        let size = 3 * self.parts.len();
        let (mut matrix, mut load) = (vec![vec![0.0; size]; size], vec![0.0; size]);
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        for (p, part) in self.parts.iter_mut().enumerate() {
            for (a, axis) in axes.into_iter().enumerate() {
                let Part { scratch, direction, residual, .. } = &mut *part;
                direction.iter_mut().zip(&scratch.free).for_each(|(motion, free)| *motion = axis * *free);
                load[3 * p + a] = residual.iter().map(|r| r.dot(axis)).sum();
                part.multiply();
                let Part { scratch, product, .. } = &*part;
                let sum: DVec3 = product.iter().zip(&scratch.free).map(|(force, free)| *force * *free).sum();
                (0..3).for_each(|b| matrix[3 * p + b][3 * p + a] += sum[b]);
            }
        }
        for link in &self.links {
            let mut growth: Vec<(usize, f64)> = Vec::with_capacity(12);
            for (part, row, weight) in link.ends() {
                let motion = link.spring.normal * self.parts[part].scratch.free[row] * weight;
                growth.extend((0..3).map(|a| (3 * part + a, motion[a])));
            }
            for (i, by) in &growth {
                growth.iter().for_each(|(j, along)| matrix[*i][*j] += link.spring.stiffness * by * along);
            }
        }
        let Some(motion) = solve_dense(matrix, load) else { return };
        for (part, motion) in self.parts.iter_mut().zip(motion.chunks_exact(3)) {
            let motion = DVec3::from_slice(motion);
            part.x.iter_mut().zip(&part.scratch.free).for_each(|(x, free)| *x += motion * *free);
        }
    }

    /// `product` = M⁻¹·`residual`; returns the scalar product of both.
    fn precondition(&mut self) -> f64 {
        let Self { parts, first, factor, rows, .. } = self;
        for (part, &first) in parts.iter().zip(&*first) {
            rows[first as usize..][..part.residual.len()].copy_from_slice(&part.residual);
        }
        factor.apply(rows);
        let mut sum = 0.0;
        for (Part { residual, product, patches, .. }, &first) in parts.iter_mut().zip(&*first) {
            product.copy_from_slice(&rows[first as usize..][..residual.len()]);
            sum += residual.iter().zip(&*product).map(|(r, z)| r.dot(*z)).sum::<f64>();
            for patch in &*patches {
                let (answer, part) = patch.answer(|v| residual[v]);
                patch.spread(&answer, |v, motion| product[v] += motion);
                sum += part;
            }
        }
        sum
    }

    fn residual_sq(&self) -> f64 {
        self.parts.iter().flat_map(|part| &part.residual).map(|r| r.length_squared()).sum()
    }

    /// Product of the operators and springs with the directions; returns the curvature.
    fn multiply(&mut self) -> f64 {
        let Self { parts, links, .. } = self;
        let mut curvature: f64 = parts.iter_mut().map(Part::multiply).sum();
        for link in links {
            let growth = link.growth(|part, row| parts[part].direction[row]);
            let force = link.spring.stiffness * growth;
            curvature += force * growth;
            for (part, row, weight) in link.ends() {
                parts[part].product[row] += link.spring.normal * (force * weight);
            }
        }
        curvature
    }
}
