//! Cuts by a tool, quasi-static tearing, and the collection of events.

use super::{Energies, Simulation, SimulationError, order};
use crate::components::{Body, DecidedBy, EnergyAudit, Refined, TearDecisions, TearLog};
use crate::event::{Course, Event, EventKind, WokenBy};
use crate::math::is_place;
use crate::registry::{Rejected, owner_of};
use crate::replay::Input;
use crate::report::Report;
use crate::storage::{BodyId, EditRecord, Mesh, TipKey, TipRow, Tips, Topology, Triangles, Vertices};
use crate::systems::StepContext;
use crate::systems::forces;
use crate::systems::fracture::split::{add_tip, note_parted};
use crate::systems::fracture::{
    CutOutcome, Cutter, Followers, FollowersQuery, NewTip, Quality, TearRefusal, TearScratch,
};
use crate::systems::step::run::Running;
use crate::systems::step::schedule::Stage;
use glam::DVec3;
use hecs::Entity;

/// Result of a cut.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cut {
    /// Points along the cut \[mm, rest shape\], one stroke after the other.
    pub path: Vec<DVec3>,
    /// Number of points of each stroke; a boundary, or tissue that is cut already, lies between two.
    pub strokes: Vec<usize>,
    /// Length \[mm\] of the polyline that was asked for.
    pub asked: f64,
    /// Length \[mm, rest shape\] that was cut.
    pub made: f64,
    /// Tips at its ends inside the tissue, for a body that can tear.
    pub tips: Vec<TipKey>,
    /// Largest distance \[mm\] of a point of the cut from the polyline, or of an end of the cut from that of the polyline inside the body.
    pub off_line: f64,
    /// Smallest rest angle \[rad\] of the triangles that the cut has touched.
    pub smallest_angle: f64,
    /// Number of fragments that came free.
    pub fragment_count: usize,
}

/// Why a cut was not made; the body is as it was.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CutError {
    /// There is no such body.
    #[error("there is no such body")]
    NoSuchBody,
    /// There is no such blade.
    #[error("there is no such blade")]
    NoSuchBlade,
    /// A blade whose numbers are out of range.
    #[error(
        "a blade with a reach of {reach:?} mm and a shortest cut of {least:?} mm: both must be positive and finite"
    )]
    BadBlade {
        /// \[mm\].
        reach: f64,
        /// \[mm\].
        least: f64,
    },
    /// A point, direction or length of a cut that is no number.
    #[error("{owner}: {what} is {value}: it must be finite, up to 1e75")]
    NotFinite {
        /// Kind and name of the body.
        owner: String,
        /// Point or direction.
        what: &'static str,
        /// Rejected value.
        value: DVec3,
    },
    /// The tool does not meet the surface.
    #[error("there is no surface within reach, or the direction is normal to it")]
    NothingThere,
    /// The mesh refused it.
    #[error(
        "the cut was refused: {0}; begin it outside the body, of which it cuts what lies inside, or farther from the boundary"
    )]
    Refused(#[from] TearRefusal),
    /// Something that was written past the calls is refused.
    #[error(transparent)]
    Written(#[from] Rejected),
}

impl Cut {
    fn add(&mut self, outcome: CutOutcome) {
        self.made += length(&outcome.path);
        self.strokes.push(outcome.path.len());
        let is_first = self.strokes.len() == 1;
        self.smallest_angle =
            if is_first { outcome.smallest_angle } else { self.smallest_angle.min(outcome.smallest_angle) };
        self.off_line = self.off_line.max(outcome.off_line);
        self.fragment_count += outcome.freed.len();
        self.path.extend(outcome.path);
    }
}

fn length(path: &[DVec3]) -> f64 {
    path.windows(2).map(|way| way[0].distance(way[1])).sum()
}

impl Simulation {
    /// Cuts a body along a polyline \[mm, rest shape\], taken at the nearest points of the surface. A polyline that starts on
    /// the boundary makes a notch, one that starts inside a slit with two ends. Where the body can tear, the cut's ends
    /// inside the tissue become tips; a cut that starts at a tip leads that tip on. The part outside the body is left out, and
    /// behind a hole, a slit or its own line the cut goes on. Points that are too near to each other for the mesh are thinned out.
    /// An end that finds no room goes on along its line by up to half an edge, to the boundary if that is there, or back by as much, or
    /// else to a vertex within an edge: [`Cut::off_line`] says how far. Between lips without room for a stroke up to half of the length is left out:
    /// [`Cut::made`] says how much is there.
    ///
    /// # Errors
    /// Why the cut was not made; the body is as it was.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// let cut = simulation.cut(body, &[DVec3::new(0.0, 5.0, 0.0), DVec3::new(4.0, 5.0, 0.0)])?;
    /// assert!((cut.made - 4.0).abs() < 1e-9);
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn cut(&mut self, body: BodyId, polyline: &[DVec3]) -> Result<Cut, CutError> {
        self.note(|| Input::Cut { body, polyline: polyline.to_vec() });
        self.make_cut(body, polyline)
    }

    /// Refuses a point or direction that is no number.
    pub(super) fn check_finite(&self, body: BodyId, what: &'static str, value: DVec3) -> Result<(), CutError> {
        if is_place(value) {
            return Ok(());
        }
        let owner = self.world.entity(body.entity()).map_err(|_| CutError::NoSuchBody).map(owner_of)?;
        Err(CutError::NotFinite { owner, what, value })
    }

    /// Cuts without writing it down.
    pub(super) fn make_cut(&mut self, body: BodyId, polyline: &[DVec3]) -> Result<Cut, CutError> {
        type Query<'a> = (
            (&'a mut Vertices, &'a mut Triangles, &'a mut Topology),
            (Option<&'a mut Tips>, &'a mut TearLog, &'a mut TearScratch, Option<&'a mut Refined>),
            FollowersQuery<'a>,
        );
        self.validate_dirty()?;
        polyline.iter().try_for_each(|&point| self.check_finite(body, "a point of the cut", point))?;
        self.wake_by(body, WokenBy::Cut);
        let before = self.audited_energies(body);
        let found = self.world.query_one_mut::<Query>(body.entity()).map_err(|_| CutError::NoSuchBody)?;
        let ((vertices, triangles, topology), (mut tips, log, scratch, refined), followers) = found;
        let mut mesh = Mesh { vertices, triangles, topology };
        let mut followers = Followers::of(followers, refined);
        let outcome = {
            let tip_rows = tips.as_ref().map_or(&[][..], |tips| &tips.vertex);
            let is_movable = |v: u32| followers.leave_free(v) && !tip_rows.contains(&v);
            let quality = Quality::default();
            Cutter { mesh: &mut mesh, is_movable: &is_movable, quality, scratch }.cut(polyline)
        };
        let parted: Vec<u32> = scratch.records.iter().flat_map(EditRecord::parted).collect();
        followers.follow(&mut scratch.records, &mut mesh, tips.as_deref_mut());
        let outcomes = outcome?;
        let mut cut = Cut { asked: length(polyline), ..Cut::default() };
        for (i, outcome) in outcomes.into_iter().enumerate() {
            let led = tips.as_deref_mut().and_then(|tips| lead_tip(tips, &outcome, log));
            if i == 0 {
                note_parted(&parted, tips.as_deref_mut(), log, &followers, mesh.vertices);
            }
            log.length += length(&outcome.path);
            log.note_angle(outcome.smallest_angle);
            log.fragment_count += outcome.freed.len() as u32;
            if let Some(tips) = tips.as_deref_mut() {
                let led_to = led.and_then(|tip| tips.row(tip)).map(|row| tips.vertex[row as usize]);
                cut.tips.extend(led.filter(|_| led_to.is_some()));
                for &(vertex, direction) in outcome.tips.iter().filter(|(vertex, _)| Some(*vertex) != led_to) {
                    let at = mesh.vertices.rest_position[vertex as usize];
                    let tip = add_tip(tips, NewTip { vertex, direction, ideal: at });
                    log.pending.push(EventKind::Started { tip, at, verdict: None });
                    cut.tips.push(tip);
                }
            }
            log.pending.extend(outcome.freed.iter().map(|&triangle_count| EventKind::FragmentFreed { triangle_count }));
            cut.add(outcome);
        }
        log.pending.push(EventKind::Cut { asked: cut.asked, made: cut.made, strokes: cut.strokes.len() });
        self.note_edited_energies(body, before);
        self.collect_events();
        Ok(cut)
    }

    /// Energies of a body whose audit has begun.
    pub(super) fn audited_energies(&mut self, body: BodyId) -> Option<Energies> {
        let has_begun = self.world.get::<&EnergyAudit>(body.entity()).is_ok_and(|audit| audit.initial.is_some());
        if has_begun { self.energies(body).ok() } else { None }
    }

    /// Tells the audit of a body, where it has begun, the change of its energies since `before`.
    pub(super) fn note_edited_energies(&mut self, body: BodyId, before: Option<Energies>) {
        if let (Some(before), Some(after)) = (before, self.audited_energies(body))
            && let Ok(audit) = self.world.query_one_mut::<&mut EnergyAudit>(body.entity())
        {
            audit.note_edits(after - before);
        }
    }

    /// Moves time on by `dt` \[ms\], finds the equilibrium there and tears quasi-statically. Advances of all tips by one triangle
    /// or edge, and equilibrium, alternate until no tip exceeds the criterion or at most `rounds` times. Where the rounds have
    /// ended it, the report says so.
    ///
    /// # Errors
    /// As [`settle`](Self::settle); tears made before the failure stay.
    pub fn settle_and_tear(&mut self, dt: f64, tolerance: f64, rounds: u32) -> Result<&Report, SimulationError> {
        self.note(|| Input::SettleAndTear { dt, tolerance, rounds });
        self.find_equilibrium(dt, tolerance)?;
        for _ in 0..rounds {
            let step = StepContext::of_static_solve(
                1.0,
                self.report.time,
                tolerance,
                2,
                self.settings.advanced.preconditioner,
            );
            let Self { world, pool, schedule, report, spare, .. } = self;
            let mut running = Running { schedule, report, spare };
            pool.run(|| {
                running.stage(world, &step, Stage::Decide);
                running.stage(world, &step, Stage::Tear);
                forces::end(world, true);
            });
            self.check_callers(&step)?;
            self.collect_events();
            if !self.may_tear_further() {
                self.use_forces_up();
                return Ok(&self.report);
            }
            self.find_equilibrium(0.0, tolerance)?;
        }
        forces::end(&mut self.world, true);
        self.use_forces_up();
        self.note_unfinished_tears();
        Ok(&self.report)
    }

    fn may_tear_further(&mut self) -> bool {
        self.world.query_mut::<&TearDecisions>().into_iter().any(|decisions| decisions.may_advance_further)
    }

    /// Says in the report which tears were ended by the budget of the step.
    pub(super) fn note_unfinished_tears(&mut self) {
        for body in &mut self.report.bodies {
            let decisions = self.world.query_one_mut::<&TearDecisions>(body.body.entity());
            body.is_tear_cut_short = decisions.is_ok_and(|decisions| decisions.may_advance_further);
        }
    }

    /// Moves the bodies' pending events into the queue, in the order of spawning.
    pub(super) fn collect_events(&mut self) {
        let (step, time) = (self.report.step, self.report.time);
        let Self { world, events, .. } = self;
        let first = events.len();
        for (body, log) in world.query_mut::<(Entity, &mut TearLog)>().with::<&Body>() {
            events.extend(log.pending.drain(..).map(|kind| Event { step, time, body: body.into(), kind }));
        }
        // Stable: the order within a body stays.
        if !events[first..].is_sorted_by_key(|event| order(world, event.body)) {
            events[first..].sort_by_key(|event| order(world, event.body));
        }
    }
}

/// Leads the tip at which a cut begins to where it ends, as one tear; its key, where there is one.
fn lead_tip(tips: &mut Tips, outcome: &CutOutcome, log: &mut TearLog) -> Option<TipKey> {
    let [first, end] = outcome.ends;
    let row = tips.vertex.iter().position(|&vertex| vertex == first)? as u32;
    let key = tips.key(row)?;
    let ways = || outcome.path.windows(2).map(|way| (way[0], way[1], (way[1] - way[0]).normalize_or_zero()));
    let (_, ideal, previous) = ways().next_back()?;
    tips.set(row, TipRow { vertex: end, previous, ideal, is_refused: false, ..tips.at(row) });
    log.advance_count += outcome.path.len() as u32 - 1;
    log.pending.extend(ways().map(|(from, to, direction)| EventKind::Advanced {
        tip: key,
        from,
        to,
        direction,
        criterion: 0.0,
        margin: f64::INFINITY,
        is_ambiguous: false,
        by: DecidedBy::Blade,
        release: None,
        cost: None,
        course: Course::Exact,
    }));
    Some(key)
}
