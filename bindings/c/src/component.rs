//! Components of bodies, obstacles and tools, by their names.

use crate::pointer::{Buffer, Out, Text};
use crate::status::{Answer, Failure, RhexisStatus, c_text, call, refused};
use crate::toml_form::{patched, text};
use crate::types::*;
use crate::world::with;
use hecs::Entity;
use rhexis::components::*;
use rhexis::simulation::{Parameter, Simulation};
use serde::{Serialize, de::DeserializeOwned};
use std::ffi::c_char;

/// What can be done with a component by its name.
struct Entry {
    /// With a zero at its end.
    name: &'static str,
    set: fn(&mut Simulation, Entity, &str) -> Answer<()>,
    unset: fn(&mut Simulation, Entity) -> Answer<bool>,
    get: fn(&Simulation, Entity) -> Answer<Option<String>>,
}

macro_rules! entries {
    ($($component:ident $(or $default:expr)?;)*) => {
        const ENTRIES: &[Entry] = &[$(Entry {
            name: concat!(stringify!($component), "\0"),
            set: |simulation, entity, toml| {
                let default: Option<$component> = None$(.or(Some($default)))?;
                set::<$component>(simulation, entity, default, toml)
            },
            unset: |simulation, entity| simulation.unset::<$component>(entity).map_err(refused),
            get: |simulation, entity| {
                let found = simulation.world().get::<&$component>(entity);
                found.ok().map(|found| text(<$component as Parameter>::NAME, &*found)).transpose()
            },
        },)*];
    };
}

rhexis::recorded_components!(entries);

fn set<C: Parameter + Serialize + DeserializeOwned>(
    simulation: &mut Simulation,
    entity: Entity,
    default: Option<C>,
    toml: &str,
) -> Answer<()> {
    let present = simulation.world().get::<&C>(entity).ok().map(|present| (*present).clone());
    let component = patched(C::NAME, present.or(default).as_ref(), toml)?;
    simulation.set(entity, component).map_err(refused)
}

fn names() -> impl Iterator<Item = &'static str> {
    ENTRIES.iter().map(|entry| entry.name.trim_end_matches('\0'))
}

fn entry(name: &str) -> Answer<&'static Entry> {
    ENTRIES.iter().find(|entry| entry.name.trim_end_matches('\0') == name).ok_or_else(|| {
        let known = names().collect::<Vec<_>>().join(", ");
        let near =
            rhexis_scene::nearest(name, names()).map_or(String::new(), |near| format!("did you mean `{near}`? "));
        let message = format!("there is no component `{name}`; {near}there are {known}");
        Failure::new(RhexisStatus::NotFound, message)
    })
}

/// The name of a component by number, from 0 on; NULL past the last. Valid for ever.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_component_name(index: usize) -> *const c_char {
    ENTRIES.get(index).map_or(std::ptr::null(), |entry| entry.name.as_ptr().cast())
}

/// Gives a body, an obstacle or a tool a component, or changes the one that it has: "Tearing" with "strength_across_fibres = 0.8", say. Keys that the
/// text does not name keep their values, or those of the default where the component is new and has one. The component is judged as a whole;
/// nothing has changed where it is refused.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_set(world: RhexisWorld, entity: RhexisEntity, component: Text, toml: Text) -> RhexisStatus {
    call(|| {
        let entry = entry(component.read("the component's name")?)?;
        let toml = toml.read("the component")?;
        with(world, |world| {
            let entity = world.entity(entity)?;
            (entry.set)(world.simulation(), entity, toml)
        })
    })
}

/// Takes a component off a body or an obstacle. `was_there` gets 1 or 0, and may be NULL.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_unset(
    world: RhexisWorld,
    entity: RhexisEntity,
    component: Text,
    was_there: Out<u8>,
) -> RhexisStatus {
    call(|| {
        was_there.check_if_any("was_there")?;
        let entry = entry(component.read("the component's name")?)?;
        let was = with(world, |world| {
            let entity = world.entity(entity)?;
            (entry.unset)(world.simulation(), entity)
        })?;
        was_there.write(u8::from(was));
        Ok(())
    })
}

/// Writes a component as TOML into a buffer, with a zero at the end that `count` counts too: all its keys, as `rhexis_set` reads them.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_get(
    world: RhexisWorld,
    entity: RhexisEntity,
    component: Text,
    buffer: Buffer<u8>,
    capacity: usize,
    count: Out<usize>,
) -> RhexisStatus {
    call(|| {
        count.check("the count")?;
        let name = component.read("the component's name")?;
        let entry = entry(name)?;
        let found = with(world, |world| {
            let entity = world.entity(entity)?;
            (entry.get)(world.simulation(), entity)
        })?;
        let none = || Failure::new(RhexisStatus::NotFound, format!("the entity has no component {name}"));
        buffer.fill(capacity, c_text(&found.ok_or_else(none)?).as_bytes_with_nul(), count)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The engine's list of its public items names all components that hosts may change.
    #[test]
    fn every_component_has_its_name() {
        let list = include_str!("../../../tests/public_api.txt");
        let of_list = list.lines().filter_map(|line| {
            let (item, traits) = line.strip_prefix("rhexis::components::")?.rsplit_once('[')?;
            let is_parameter = traits.trim_end_matches(']').split(", ").any(|name| name == "Parameter");
            is_parameter.then(|| item.split(':').next().unwrap_or_default())
        });
        assert_eq!(names().collect::<Vec<_>>(), of_list.collect::<Vec<_>>());
    }
}
