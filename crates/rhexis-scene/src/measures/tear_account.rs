//! The energy account of a body's tears: the fracture work by the toughness, and where the energy that they release goes.
//!
//! An advance by a whole triangle is made at fixed positions and takes nothing out of the body. Energy set free becomes motion in later steps, which
//! damping and the scheme use up. So the toughness's claim, G_c·h·da, is no further term of the balance: it is the part of those that the
//! tissue would have taken. Where tips glide, the elastic energy that their moves and the field's relaxation take is a term of the
//! balance, [`EnergyBalance::released`]. How far the two are apart shows over the span from one step with advances to the next:
//!
//! | figure | definition |
//! |---|---|
//! | surface energy | Σ G_c·h·da of the advances and starts at the beginning of the span |
//! | work | of holds, jaws and loads within it |
//! | released | work and edits less the growth of the elastic energy |
//! | torn | energy taken by tips that glide and by tears in static solves |
//! | damping, drag, numerical, other | dissipation of the rest; the remainder is motion, `kinetic_change` |
//!
//! Over the whole time between the first and the last advance, work per torn area is the cost to the hand. Where the tear is steady, it
//! is to be compared with the toughness. Elsewhere it is the released energy per torn area, less the energy that the load goes on storing.

use super::hand_force::{HandForce, HandForceFigures};
use hecs::World;
use rhexis::components::{EnergyBalance, Grips, Holds, Reactions, TearLog};
use rhexis::event::{Event, EventKind};
use rhexis::storage::BodyId;

/// How much later than they were due tips have advanced: G/G_c − 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overshoot {
    /// Median over the advances.
    pub median: f64,
    /// The largest.
    pub max: f64,
}

/// Energy supplied and dissipated from one step with advances to a later one, all in mJ.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct TearSpan {
    /// From the end of one step with advances to that of another \[ms\].
    pub time: [f64; 2],
    /// Area torn from its beginning on, its last step's left out \[mm²\].
    pub area: f64,
    /// Surface energy that the toughness claims for that area; `None` for a body without one.
    pub surface_energy: Option<f64>,
    /// The body's balance of energy over the span.
    pub balance: EnergyBalance,
}

impl TearSpan {
    /// Energy released from the elastic energy \[mJ\]: work and the energy of edits, less the growth of the elastic energy.
    pub fn released(&self) -> f64 {
        let balance = &self.balance;
        balance.work() + balance.edits.elastic + balance.edits.kinetic - balance.stored.elastic
    }

    /// Elastic energy taken by tips that glide and by tears in static solves \[mJ\]; zero for dynamic tears by whole triangles.
    pub fn torn(&self) -> f64 {
        self.balance.released
    }

    /// Small terms \[mJ\]: the residual's work, unbalanced energy, and the imbalance.
    pub fn other(&self) -> f64 {
        self.balance.residual + self.balance.unbalanced + self.balance.imbalance()
    }

    /// Work per torn area \[N/mm\]: the cost to the hand.
    pub fn work_per_area(&self) -> f64 {
        self.balance.work() / self.area
    }

    /// Released elastic energy per torn area \[N/mm\]: the work per area where loading and stored energy repeat from advance to advance.
    pub fn released_per_area(&self) -> f64 {
        self.released() / self.area
    }

    /// Mean toughness of the torn area \[N/mm\]; `None` for a body without one.
    pub fn toughness(&self) -> Option<f64> {
        Some(self.surface_energy? / self.area)
    }
}

/// The figures of the account.
#[derive(Clone, Debug, PartialEq)]
pub struct AccountFigures {
    /// Area torn by the criterion \[mm²\].
    pub area: f64,
    /// Surface energy that the toughness claims for it \[mJ\]; `None` where none of it was torn under a toughness.
    pub surface_energy: Option<f64>,
    /// `None` where no advance has been decided against a toughness.
    pub overshoot: Option<Overshoot>,
    /// From the first to the last advance; `None` before there are two steps with advances, and without a balance of energy.
    pub span: Option<TearSpan>,
}

/// Torn at the end of a step.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
struct Torn {
    time: f64,
    area: f64,
    surface_energy: Option<f64>,
    balance: EnergyBalance,
}

/// Follows the tears of one body from its present state on. It must see every step.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct TearAccount {
    body: BodyId,
    area: f64,
    surface_energy: Option<f64>,
    first: Option<Torn>,
    last: Option<Torn>,
    overshoots: Vec<f64>,
    /// Forces of holds and of jaws, by name.
    holds: Vec<(String, HandForce)>,
    jaws: Vec<(String, HandForce)>,
}

impl TearAccount {
    /// Begins with the body as it is.
    pub fn new(world: &World, body: BodyId) -> Self {
        let (area, surface_energy) = torn(world, body);
        Self {
            body,
            area,
            surface_energy,
            first: None,
            last: None,
            overshoots: Vec::new(),
            holds: Vec::new(),
            jaws: Vec::new(),
        }
    }

    /// The body.
    pub fn body(&self) -> BodyId {
        self.body
    }

    /// Takes a step in: its end \[ms\], the events that it has left, the world after it and the body's balance of energy, if it is kept.
    /// Where tips have advanced or begun in it, gives the span since the step before in which they did.
    pub fn note(
        &mut self,
        world: &World,
        time: f64,
        events: &[Event],
        balance: Option<EnergyBalance>,
    ) -> Option<TearSpan> {
        let cost = |event: &Event| match event.kind {
            EventKind::Advanced { cost, .. } if event.body == self.body => cost,
            _ => None,
        };
        self.overshoots.extend(events.iter().filter_map(cost).map(|cost| cost.overshoot));
        let (area, surface_energy) = torn(world, self.body);
        let is_torn = area > self.area;
        self.note_forces(world, is_torn);
        let before =
            (std::mem::replace(&mut self.area, area), std::mem::replace(&mut self.surface_energy, surface_energy));
        let balance = balance.filter(|_| is_torn)?;
        let now = Torn { time, area: before.0, surface_energy: before.1, balance };
        self.first.get_or_insert(now);
        self.last.replace(now).map(|last| span(&last, &now))
    }

    /// Force of the hold with this name while tips advance; `None` before there are two steps with advances.
    pub fn hold_force(&self, name: &str) -> Option<HandForceFigures> {
        figures(&self.holds, name)
    }

    /// Force of the jaws with this name while tips advance; `None` where they were not closed from one step with an advance to another.
    pub fn jaws_force(&self, name: &str) -> Option<HandForceFigures> {
        figures(&self.jaws, name)
    }

    /// The figures up to now.
    pub fn figures(&self) -> AccountFigures {
        let mut sorted = self.overshoots.clone();
        sorted.sort_by(f64::total_cmp);
        let overshoot = sorted.last().map(|&max| Overshoot { median: sorted[sorted.len() / 2], max });
        let ends = self.first.as_ref().zip(self.last.as_ref()).filter(|(first, last)| first.time < last.time);
        let span = ends.map(|(first, last)| span(first, last));
        AccountFigures { area: self.area, surface_energy: self.surface_energy, overshoot, span }
    }

    fn note_forces(&mut self, world: &World, has_advanced: bool) {
        let entity = self.body.entity();
        if let (Ok(holds), Ok(reactions)) = (world.get::<&Holds>(entity), world.get::<&Reactions>(entity)) {
            for (hold, forces) in holds.groups.iter().zip(&reactions.groups) {
                hand(&mut self.holds, &hold.name).note(Some(forces.iter().sum()), has_advanced);
            }
        }
        let Ok(grips) = world.get::<&Grips>(entity) else { return };
        let is_gone = |name: &String| grips.pinches.iter().all(|pinch| pinch.name != *name);
        self.jaws.iter_mut().filter(|(name, _)| is_gone(name)).for_each(|(_, hand)| hand.note(None, has_advanced));
        for pinch in &grips.pinches {
            hand(&mut self.jaws, &pinch.name).note(pinch.is_closed().then_some(pinch.force), has_advanced);
        }
    }
}

fn figures(hands: &[(String, HandForce)], name: &str) -> Option<HandForceFigures> {
    hands.iter().find(|(known, _)| known == name)?.1.figures()
}

/// Hand of this name, added if it is new.
fn hand<'a>(hands: &'a mut Vec<(String, HandForce)>, name: &str) -> &'a mut HandForce {
    let place = hands.iter().position(|(known, _)| known == name).unwrap_or_else(|| {
        hands.push((name.to_owned(), HandForce::default()));
        hands.len() - 1
    });
    &mut hands[place].1
}

/// Area torn by the criterion, and the surface energy claimed for it.
fn torn(world: &World, body: BodyId) -> (f64, Option<f64>) {
    world.get::<&TearLog>(body.entity()).map_or((0.0, None), |log| (log.area, log.surface_energy))
}

fn span(from: &Torn, to: &Torn) -> TearSpan {
    let claimed = to.surface_energy.map(|energy| energy - from.surface_energy.unwrap_or(0.0));
    TearSpan {
        time: [from.time, to.time],
        area: to.area - from.area,
        surface_energy: claimed,
        balance: to.balance.since(&from.balance),
    }
}
