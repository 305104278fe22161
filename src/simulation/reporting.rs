//! The report of a step or a static solve, and the part kept of one that is undone.

use super::Simulation;
use crate::components::{
    Body, Contact, Grips, GuardLedger, Increment, Refined, Sleeping, SolveResult, SolverScratch, TearLog,
};
use crate::event::{Event, EventKind};
use crate::report::{BodyReport, GuardFigures};
use crate::storage::{BodyId, Tips, Triangles, Vertices};
use crate::systems::StepContext;
use crate::systems::forces;
use crate::systems::forces::hold::{Held, behind};
use crate::systems::step::faults::{fault_in, restore};
use hecs::{Entity, World};
use smallvec::SmallVec;

impl Simulation {
    /// Undoes a static solve. The report keeps the figures that the attempt has reached where they are finite.
    pub(super) fn undo(&mut self, step: &StepContext) {
        for body in &mut self.report.bodies {
            body.fault = fault_in(&self.world, body.body.entity());
            let figures = [&mut body.residual, &mut body.stress_error, &mut body.imbalance];
            figures.into_iter().filter(|figure| !figure.is_finite()).for_each(|figure| *figure = 0.0);
        }
        restore(&mut self.world, step, self.report.time);
        forces::end(&mut self.world, false);
        for body in self.bodies() {
            // A body from the list exists.
            let _ = self.refresh(body);
        }
        self.report.has_failed = true;
    }

    pub(super) fn begin_report(&mut self) {
        self.schedule.reset_reports(&mut self.report.systems);
        self.report.rolled_back = 0;
        for increment in self.world.query_mut::<&mut Increment>() {
            (increment.any_substep_limited, increment.any_vertex_projected) = (false, false);
            (*increment.guard, increment.relaxed) = (GuardFigures::default(), 0);
        }
        for result in self.world.query_mut::<&mut SolveResult>() {
            (result.work, result.fallback_factors) = (0, 0);
            (result.is_tear_undecided, result.is_release_unsettled) = (false, false);
            result.is_traction_unsettled = false;
        }
        self.report.has_failed = false;
    }

    pub(super) fn finish_report(&mut self) {
        self.report.step += 1;
        let Self { world, report, .. } = self;
        let before: SmallVec<[BodyId; 4]> = acted(&report.bodies).map(|body| body.body).collect();
        report.bodies.clear();
        type Query<'a> = (
            (Entity, &'a Vertices, &'a Triangles, Option<&'a Tips>, &'a TearLog),
            (&'a Increment, &'a SolveResult, &'a GuardLedger, &'a SolverScratch),
            (Option<&'a Sleeping>, Option<&'a Refined>, Option<&'a Grips>, Option<&'a Contact>),
            Held<'a>,
        );
        let mut bodies = world.query::<Query>().with::<&Body>();
        for (
            (body, vertices, triangles, tips, log),
            (increment, result, ledger, scratch),
            (sleeping, refined, grips, contact),
            held,
        ) in &mut bodies
        {
            let closed = grips.iter().flat_map(|grips| &grips.pinches).filter(|pinch| pinch.is_closed());
            let ahead = closed.map(|pinch| pinch.hand_ahead(report.time)).fold(0.0, f64::max);
            let is_behind = increment.any_substep_limited || ledger.hold_pace > 0.0;
            let behind = if is_behind { behind(vertices, (held, grips), report.time) } else { 0.0 };
            let touches_itself = contact.is_some_and(|contact| contact.self_contact.is_some());
            let layers = scratch.contact.layers.as_deref().filter(|_| touches_itself);
            report.bodies.push(BodyReport {
                body: body.into(),
                vertex_count: vertices.len(),
                triangle_count: triangles.len(),
                tip_count: tips.map_or(0, Tips::len),
                iterations: result.iterations,
                work: result.work,
                position_error: result.position_error,
                newton_iterations: result.newton_iterations,
                residual: result.linear_residual,
                stress_error: result.stress_error,
                is_late: result.is_late,
                imbalance: result.imbalance,
                is_converged: result.has_converged,
                fell_back: result.fell_back,
                fallback_factors: result.fallback_factors,
                is_tear_cut_short: false,
                is_tear_undecided: result.is_tear_undecided,
                is_release_unsettled: result.is_release_unsettled,
                is_traction_unsettled: result.is_traction_unsettled,
                is_refinement_put_off: refined.is_some_and(|refined| refined.is_put_off),
                is_step_limited: ledger.is_step_limited,
                any_substep_limited: increment.any_substep_limited,
                any_vertex_projected: increment.any_vertex_projected,
                relaxed_vertices: increment.relaxed as usize,
                hand_ahead: ahead.max(behind),
                self_contacts: layers.map_or(0, |layers| layers.touching + layers.touching_others),
                layers_held_back: layers.map_or(0, |layers| layers.held_back),
                layers_moved_as_one: layers.is_some_and(|layers| layers.moved_as_one),
                layers_overlapping: layers.map_or(0, |layers| layers.crossed.len() as u32 + layers.overlapping_others),
                tear_held_back: log.held_back_count,
                held_back_criterion: log.held_back_criterion,
                guard: *increment.guard,
                fault: result.fault,
                is_asleep: sleeping.is_some_and(Sleeping::is_asleep),
            });
        }
        report.bodies.sort_unstable_by_key(|report| order(world, report.body));
        for body in acted(&report.bodies).filter(|body| !before.contains(&body.body)) {
            let GuardFigures { limited_vertices, first, .. } = body.guard;
            let [refused, limited] = [body.guard.refusals(), body.guard.limitations()];
            let kind = EventKind::StepGuarded { refused, limited, limited_vertices, first };
            self.events.push(Event { step: report.step, time: report.time, body: body.body, kind });
        }
    }
}

/// The bodies to which the guard did anything.
fn acted(bodies: &[BodyReport]) -> impl Iterator<Item = &BodyReport> {
    bodies.iter().filter(|body| body.guard.has_acted())
}

/// A body's place in the order of spawning.
pub(super) fn order(world: &World, body: BodyId) -> u32 {
    world.get::<&Body>(body.entity()).map_or(u32::MAX, |about| about.order)
}
