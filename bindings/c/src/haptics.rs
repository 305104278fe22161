//! Haptic models, and their feed to a thread that does not wait.

use crate::handle::{Kind, Table};
use crate::pointer::{In, Out, Text};
use crate::status::{Answer, Failure, RhexisStatus, call, refused};
use crate::types::*;
use crate::world::{World, with};
use rhexis::simulation::{Coupling, HapticBlend, HapticModel, HapticReceiver, HapticSender, Haptics, haptic_feed};
use rhexis::storage::{BodyId, ForcepsId};

static MAKERS: Table<Maker> = Table::new(Kind::Haptics);
static RECEIVERS: Table<Receiver> = Table::new(Kind::Receiver);

/// Makes models of one tool and sends them.
struct Maker {
    haptics: Haptics,
    sender: HapticSender,
    receiver: HapticReceiver,
}

/// The haptic thread's end.
struct Receiver {
    feed: HapticReceiver,
    blend: HapticBlend,
}

fn none_yet() -> Failure {
    Failure::new(RhexisStatus::NotFound, "no model has been sent yet")
}

/// Makes a maker of haptic models for one tool, and its feed. `horizon` \[ms\]: models hold for motions slower than that; with the length of a
/// step it is the answer that the step will give, with 1000 that in equilibrium.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_haptics_create(horizon: f64, haptics: Out<RhexisHaptics>) -> RhexisStatus {
    call(|| {
        haptics.check("haptics")?;
        let (sender, receiver) = haptic_feed();
        let bits = MAKERS.add(|_| Maker { haptics: Haptics::new(horizon), sender, receiver })?;
        haptics.write(RhexisHaptics { bits });
        Ok(())
    })
}

/// Destroys a maker. Its receivers keep the last model.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_haptics_destroy(haptics: RhexisHaptics) -> RhexisStatus {
    call(|| MAKERS.remove(haptics.bits))
}

fn coupling(world: &mut World, forceps: ForcepsId) -> Answer<(BodyId, Coupling)> {
    let simulation = world.simulation();
    let body = simulation.forceps(forceps).map_err(refused)?.body;
    let body = body.ok_or_else(|| refused("the forceps hold nothing: close them first"))?;
    Ok((body, simulation.coupling_of_forceps(forceps).map_err(refused)?))
}

fn make(
    handles: (RhexisHaptics, RhexisWorld),
    model: Out<RhexisHapticModel>,
    work: impl FnOnce(&mut World, &mut Haptics) -> Answer<HapticModel>,
) -> RhexisStatus {
    call(|| {
        model.check_if_any("model")?;
        let made = MAKERS.with(handles.0.bits, |maker| {
            let made = with(handles.1, |world| work(world, &mut maker.haptics))?;
            maker.sender.send(&made);
            Ok(made)
        })?;
        model.write(made.into());
        Ok(())
    })
}

/// Makes the model of the tissue at closed forceps, and sends it to the receivers. `model` may be NULL.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_haptics_model(
    haptics: RhexisHaptics,
    world: RhexisWorld,
    forceps: RhexisEntity,
    model: Out<RhexisHapticModel>,
) -> RhexisStatus {
    make((haptics, world), model, |world, haptics| {
        let forceps = ForcepsId::from(world.entity(forceps)?);
        let (body, coupling) = coupling(world, forceps)?;
        haptics.model(world.simulation(), body, &coupling).map_err(refused)
    })
}

/// Makes the model that follows the last one of the same forceps at a part of its cost, and sends it. `model` may be NULL.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_haptics_refresh(
    haptics: RhexisHaptics,
    world: RhexisWorld,
    forceps: RhexisEntity,
    model: Out<RhexisHapticModel>,
) -> RhexisStatus {
    make((haptics, world), model, |world, haptics| {
        let forceps = ForcepsId::from(world.entity(forceps)?);
        let (body, coupling) = coupling(world, forceps)?;
        haptics.refresh(world.simulation(), body, &coupling).map_err(refused)
    })
}

/// Makes the model of the tissue at the pins of a name, and sends it. `model` may be NULL.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_haptics_model_of_pins(
    haptics: RhexisHaptics,
    world: RhexisWorld,
    body: RhexisEntity,
    name: Text,
    model: Out<RhexisHapticModel>,
) -> RhexisStatus {
    make((haptics, world), model, |world, haptics| {
        let (name, body) = (name.read("the name")?, world.body(body)?);
        let coupling = world.simulation().coupling_of_pins(body, name).map_err(refused)?;
        haptics.model(world.simulation(), body, &coupling).map_err(refused)
    })
}

/// Makes an end of a maker's feed for one haptic thread. `interval` \[ms\]: within that each model takes the place of the last, best the time
/// between two models; 0 lets forces jump.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_receiver_create(
    haptics: RhexisHaptics,
    interval: f64,
    receiver: Out<RhexisReceiver>,
) -> RhexisStatus {
    call(|| {
        receiver.check("receiver")?;
        let feed = MAKERS.with(haptics.bits, |maker| Ok(maker.receiver.clone()))?;
        let bits = RECEIVERS.add(|_| Receiver { feed, blend: HapticBlend::new(interval) })?;
        receiver.write(RhexisReceiver { bits });
        Ok(())
    })
}

/// Destroys an end of a feed.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_receiver_destroy(receiver: RhexisReceiver) -> RhexisStatus {
    call(|| RECEIVERS.remove(receiver.bits))
}

/// The last model sent; NOT_FOUND before the first. Does not wait for a step.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_receiver_latest(receiver: RhexisReceiver, model: Out<RhexisHapticModel>) -> RhexisStatus {
    call(|| {
        model.check("model")?;
        let latest = RECEIVERS.with(receiver.bits, |receiver| receiver.feed.latest().ok_or_else(none_yet))?;
        model.write(latest.into());
        Ok(())
    })
}

/// Force of the tool on the tissue \[N\] with the tool at a position \[mm\], `elapsed` \[ms\] after the last call: without jumps from model to
/// model, and without energy that the hand has not put in. The hand feels the opposite. NOT_FOUND before the first model. Does not wait for a
/// step.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_receiver_force(
    receiver: RhexisReceiver,
    elapsed: f64,
    position: RhexisVec3,
    force: Out<RhexisVec3>,
) -> RhexisStatus {
    call(|| {
        force.check("force")?;
        let place = position.vector();
        if !(elapsed >= 0.0 && elapsed.is_finite() && place.is_finite()) {
            return Err(Failure::argument(format!("a position of {place} mm after {elapsed} ms: both must be finite")));
        }
        let felt = RECEIVERS.with(receiver.bits, |Receiver { feed, blend }| {
            blend.hand_over(&feed.latest().ok_or_else(none_yet)?);
            blend.force_at(elapsed, place).ok_or_else(none_yet)
        })?;
        force.write(felt.into());
        Ok(())
    })
}

/// Force of the tool on the tissue \[N\] by one model, with the tool at a position \[mm\].
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_haptic_force_at(
    model: In<RhexisHapticModel>,
    position: RhexisVec3,
    force: Out<RhexisVec3>,
) -> RhexisStatus {
    call(|| {
        force.check("force")?;
        force.write(model.read("model")?.model().force_at(position.vector()).into());
        Ok(())
    })
}
