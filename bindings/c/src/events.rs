//! What has happened, one event after the other.

use crate::pointer::Out;
use crate::status::{Answer, RhexisStatus, c_text, call};
use crate::types::*;
use crate::world::{World, with};
use glam::DVec3;
use rhexis::event::{Event, EventKind};
use rhexis::storage::TipKey;
use slotmap::Key;

/// There are no more events.
pub const RHEXIS_EVENT_NONE: u32 = 0;
/// A tear began, by a cut or by the criterion: `tip`, `at`; `value` is the criterion, 0 for a cut.
pub const RHEXIS_EVENT_STARTED: u32 = 1;
/// A tip moved on: `tip`, `at`, `to`, `direction`; `value` is the criterion; `text` says by which course.
pub const RHEXIS_EVENT_ADVANCED: u32 = 2;
/// Energy released between two equilibria: `value` \[mJ\], `length` torn.
pub const RHEXIS_EVENT_RELEASED: u32 = 3;
/// A tip reached a boundary and is gone: `tip`, `at`.
pub const RHEXIS_EVENT_ENDED: u32 = 4;
/// A live tip was left at a notch or a branch: `tip`, `at`; `text` says which.
pub const RHEXIS_EVENT_RENEWED: u32 = 5;
/// Tissue parted where no tip led: `at`; `value` is by how much it was too weak; `text` says why.
pub const RHEXIS_EVENT_PARTED: u32 = 6;
/// A fragment came free: `count` triangles.
pub const RHEXIS_EVENT_FRAGMENT_FREED: u32 = 7;
/// A tear stays shut where a hold keeps both lips: `at`.
pub const RHEXIS_EVENT_HELD_SHUT: u32 = 8;
/// The mesh is too coarse at a tip: `tip`, `at`; `value` is edges per averaging radius, to be 3 or more.
pub const RHEXIS_EVENT_UNDER_RESOLVED: u32 = 9;
/// A tip waits, no faster than Rayleigh waves: `tip`, `at`; `value` is the criterion.
pub const RHEXIS_EVENT_HELD_BACK: u32 = 10;
/// A nucleation was blocked by energy: `at`; `value` is the criterion; `length`.
pub const RHEXIS_EVENT_NUCLEATION_BLOCKED: u32 = 11;
/// An advance that the mesh could not make: `tip`, `at`; `text` says why.
pub const RHEXIS_EVENT_REFUSED: u32 = 12;
/// Jaws were pulled beyond their limit: `value` \[N\]; `count` is 1 where they have let go; `text` is their name.
pub const RHEXIS_EVENT_SLIPPED: u32 = 13;
/// A body fell asleep.
pub const RHEXIS_EVENT_FELL_ASLEEP: u32 = 14;
/// A body woke: `text` says by what.
pub const RHEXIS_EVENT_WOKE: u32 = 15;
/// The guard against created energy began to act: `count` attempts were undone.
pub const RHEXIS_EVENT_STEP_GUARDED: u32 = 16;
/// A step was given up, the last good state stands: `text` says why.
pub const RHEXIS_EVENT_STEP_FAILED: u32 = 17;
/// A tool has cut: `length` \[mm, rest shape\], `value` the length asked for, `count` strokes.
pub const RHEXIS_EVENT_CUT: u32 = 18;
/// Something that has no number here yet: `text` says what.
pub const RHEXIS_EVENT_OTHER: u32 = 19;

fn key(tip: TipKey) -> u64 {
    tip.data().as_ffi()
}

/// Tells of an event: its numbers, and its text.
fn told(event: &Event, blank: RhexisEvent) -> (RhexisEvent, String) {
    let of = |kind: u32| RhexisEvent { kind, ..blank };
    let at_tip = |kind: u32, tip: TipKey, at: DVec3| RhexisEvent { kind, tip: key(tip), at: at.into(), ..blank };
    let at = |kind: u32, at: DVec3| RhexisEvent { kind, at: at.into(), ..blank };
    let none = String::new;
    match &event.kind {
        EventKind::Started { tip, at, verdict } => {
            let is_ambiguous = u8::from(verdict.is_some_and(|verdict| verdict.is_ambiguous));
            let value = verdict.map_or(0.0, |verdict| verdict.criterion);
            (RhexisEvent { value, is_ambiguous, ..at_tip(RHEXIS_EVENT_STARTED, *tip, *at) }, none())
        }
        EventKind::Advanced { tip, from, to, direction, criterion, is_ambiguous, course, .. } => {
            let (to, direction, value) = (RhexisVec3::from(*to), RhexisVec3::from(*direction), *criterion);
            let is_ambiguous = u8::from(*is_ambiguous);
            let from = at_tip(RHEXIS_EVENT_ADVANCED, *tip, *from);
            (RhexisEvent { to, direction, value, is_ambiguous, ..from }, course.to_string())
        }
        EventKind::Released { energy, length } => {
            (RhexisEvent { value: *energy, length: *length, ..of(RHEXIS_EVENT_RELEASED) }, none())
        }
        EventKind::Ended { tip, at, .. } => (at_tip(RHEXIS_EVENT_ENDED, *tip, *at), none()),
        EventKind::Renewed { tip, at, by } => (at_tip(RHEXIS_EVENT_RENEWED, *tip, *at), by.to_string()),
        EventKind::Parted { at: place, value, by } => {
            (RhexisEvent { value: *value, ..at(RHEXIS_EVENT_PARTED, *place) }, by.to_string())
        }
        EventKind::FragmentFreed { triangle_count } => {
            (RhexisEvent { count: *triangle_count as u64, ..of(RHEXIS_EVENT_FRAGMENT_FREED) }, none())
        }
        EventKind::HeldShut { at: place } => (at(RHEXIS_EVENT_HELD_SHUT, *place), none()),
        EventKind::UnderResolved { tip, at, edges_per_radius } => {
            (RhexisEvent { value: *edges_per_radius, ..at_tip(RHEXIS_EVENT_UNDER_RESOLVED, *tip, *at) }, none())
        }
        EventKind::HeldBack { tip, at, criterion } => {
            (RhexisEvent { value: *criterion, ..at_tip(RHEXIS_EVENT_HELD_BACK, *tip, *at) }, none())
        }
        EventKind::NucleationBlocked(start) => {
            let (value, length) = (start.criterion, start.length);
            (RhexisEvent { value, length, ..at(RHEXIS_EVENT_NUCLEATION_BLOCKED, start.at) }, none())
        }
        EventKind::Refused { tip, at: place, reason } => {
            let tip = tip.map_or(0, key);
            (RhexisEvent { tip, ..at(RHEXIS_EVENT_REFUSED, *place) }, reason.clone())
        }
        EventKind::Slipped { jaws, force, is_open } => {
            let count = u64::from(*is_open);
            (RhexisEvent { value: *force, count, ..of(RHEXIS_EVENT_SLIPPED) }, jaws.clone())
        }
        EventKind::FellAsleep => (of(RHEXIS_EVENT_FELL_ASLEEP), none()),
        EventKind::Woke { by } => (of(RHEXIS_EVENT_WOKE), by.to_string()),
        EventKind::StepGuarded { refused, .. } => {
            (RhexisEvent { count: u64::from(*refused), ..of(RHEXIS_EVENT_STEP_GUARDED) }, none())
        }
        EventKind::StepFailed { reason } => (of(RHEXIS_EVENT_STEP_FAILED), reason.clone()),
        EventKind::Cut { asked, made, strokes } => {
            (RhexisEvent { value: *asked, length: *made, count: *strokes as u64, ..of(RHEXIS_EVENT_CUT) }, none())
        }
        other => (of(RHEXIS_EVENT_OTHER), format!("{other:?}")),
    }
}

/// The next event; one of kind NONE where there is none.
fn next(world: &mut World) -> Answer<RhexisEvent> {
    if world.events.is_empty() {
        let fresh: Vec<Event> = world.simulation().drain_events().collect();
        world.events.extend(fresh);
    }
    let zero = RhexisVec3::default();
    let mut blank = RhexisEvent {
        kind: RHEXIS_EVENT_NONE,
        is_ambiguous: 0,
        step: 0,
        time: 0.0,
        body: RhexisEntity::default(),
        tip: 0,
        at: zero,
        to: zero,
        direction: zero,
        value: 0.0,
        length: 0.0,
        count: 0,
        text: c"".as_ptr(),
    };
    let Some(event) = world.events.pop_front() else { return Ok(blank) };
    (blank.step, blank.time, blank.body) = (event.step, event.time, world.handle(event.body)?);
    let (event, text) = told(&event, blank);
    world.event_text = c_text(&text);
    Ok(RhexisEvent { text: world.event_text.as_ptr(), ..event })
}

/// Takes the next event since the last step, in order; one of kind `RHEXIS_EVENT_NONE` where there are no more.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_next_event(world: RhexisWorld, event: Out<RhexisEvent>) -> RhexisStatus {
    call(|| {
        event.check("event")?;
        event.write(with(world, next)?);
        Ok(())
    })
}
