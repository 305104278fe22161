//! Vertices held and let go, and what holds bear.

use crate::pointer::{Array, Buffer, Out, Text};
use crate::status::{Answer, Failure, RhexisStatus, call, refused};
use crate::tools::keys;
use crate::types::*;
use crate::world::with;
use glam::DVec3;
use rhexis::simulation::Pin;
use slotmap::Key;
use std::collections::HashMap;

impl From<Pin> for RhexisPin {
    fn from(pin: Pin) -> Self {
        let Pin { vertex, rest_position, place } = pin;
        Self { vertex: vertex.data().as_ffi(), rest_position: rest_position.into(), place: place.into() }
    }
}

/// Holds vertices where they are now, under a name; those already held under it stay held.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_pin(
    world: RhexisWorld,
    body: RhexisEntity,
    name: Text,
    vertices: Array<u64>,
    vertex_count: usize,
) -> RhexisStatus {
    call(|| {
        let name = name.read("the name")?;
        let vertices = keys(vertices.read(vertex_count, "the vertices")?)?;
        with(world, |world| {
            let body = world.body(body)?;
            world.simulation().pin(body, name, &vertices).map_err(refused)
        })
    })
}

/// Lets vertices go, whoever holds them.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_unpin(
    world: RhexisWorld,
    body: RhexisEntity,
    vertices: Array<u64>,
    vertex_count: usize,
) -> RhexisStatus {
    call(|| {
        let vertices = keys(vertices.read(vertex_count, "the vertices")?)?;
        with(world, |world| {
            let body = world.body(body)?;
            world.simulation().unpin(body, &vertices).map_err(refused)
        })
    })
}

/// Lets go what is pinned under a name, copies that tears have made included.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_unpin_all(world: RhexisWorld, body: RhexisEntity, name: Text) -> RhexisStatus {
    call(|| {
        let name = name.read("the name")?;
        with(world, |world| {
            let body = world.body(body)?;
            world.simulation().unpin_all(body, name).map_err(refused)
        })
    })
}

/// Writes what is pinned under a name into a buffer, in the order of rows, and its number. Tears add copies.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_pins(
    world: RhexisWorld,
    body: RhexisEntity,
    name: Text,
    buffer: Buffer<RhexisPin>,
    capacity: usize,
    count: Out<usize>,
) -> RhexisStatus {
    call(|| {
        count.check("the count")?;
        let name = name.read("the name")?;
        let pins = with(world, |world| {
            let body = world.body(body)?;
            world.simulation().pins(body, name).map_err(refused)
        })?;
        buffer.fill(capacity, &pins.into_iter().map(RhexisPin::from).collect::<Vec<_>>(), count)
    })
}

/// Moves what is pinned under a name by a way \[mm\] from where it is held, reached at the end of the next step.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_pins_shift(
    world: RhexisWorld,
    body: RhexisEntity,
    name: Text,
    way: RhexisVec3,
) -> RhexisStatus {
    call(|| {
        let name = name.read("the name")?;
        with(world, |world| {
            let body = world.body(body)?;
            world.simulation().move_pins(body, name, |pin| pin.place + way.vector()).map_err(refused)
        })
    })
}

/// Moves what is pinned under a name to places \[mm\], three numbers each, in the order and number of `rhexis_pins`; reached at the end of the
/// next step.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_pins_move(
    world: RhexisWorld,
    body: RhexisEntity,
    name: Text,
    places: Array<f64>,
    place_count: usize,
) -> RhexisStatus {
    call(|| {
        let name = name.read("the name")?;
        let numbers = place_count.checked_mul(3).ok_or_else(|| Failure::argument("there are too many places"))?;
        let places = places.read(numbers, "the places")?.as_chunks::<3>().0;
        with(world, |world| {
            let body = world.body(body)?;
            let pins = world.simulation().pins(body, name).map_err(refused)?;
            if pins.len() != places.len() {
                let message = format!("{} vertices are pinned, {} places are given", pins.len(), places.len());
                return Err(Failure::argument(message));
            }
            let places: HashMap<_, _> = pins.iter().map(|pin| pin.vertex).zip(places).collect();
            let place = |pin: Pin| places.get(&pin.vertex).map_or(pin.place, |place| DVec3::from_array(**place));
            world.simulation().move_pins(body, name, place).map_err(refused)
        })
    })
}

fn of_name(list: Vec<(String, DVec3)>, name: &str) -> Answer<DVec3> {
    let found = list.into_iter().find(|(known, _)| known == name).map(|(_, value)| value);
    found.ok_or_else(|| Failure::new(RhexisStatus::NotFound, format!("the body has no hold `{name}`")))
}

/// The force \[N\] of a hold or of pins on a body at the last step. Does not change the world.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_reaction(
    world: RhexisWorld,
    body: RhexisEntity,
    name: Text,
    force: Out<RhexisVec3>,
) -> RhexisStatus {
    call(|| {
        force.check("force")?;
        let name = name.read("the name")?;
        let found = with(world, |world| {
            let body = world.body(body)?;
            of_name(world.simulation().reactions(body).map_err(refused)?, name)
        })?;
        force.write(found.into());
        Ok(())
    })
}
