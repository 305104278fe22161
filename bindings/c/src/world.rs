//! Worlds: made, stepped, destroyed.

use crate::handle::{Kind, Table, pack, tag, unpack};
use crate::pointer::{Buffer, In, Out, Text};
use crate::shown::Shown;
use crate::status::{Answer, Failure, RhexisStatus, call, refused, unreadable};
use crate::toml_form;
use crate::types::*;
use hecs::Entity;
use rhexis::components::{Body, Obstacle};
use rhexis::event::Event;
use rhexis::report::Report;
use rhexis::settings::{Accuracy, Settings};
use rhexis::simulation::Simulation;
use rhexis::storage::{BodyId, ObstacleId};
use rhexis_scene::{Instance, Scene};
use std::collections::{BTreeMap, VecDeque};
use std::ffi::CString;
use std::time::Duration;

/// Preset: the engine's defaults.
pub const RHEXIS_ACCURACY_FAST: u32 = 0;
/// Preset: steps for a hand that feels them.
pub const RHEXIS_ACCURACY_HAPTIC: u32 = 1;
/// Preset: steps that are looked at, with a budget of 80 iterations' work.
pub const RHEXIS_ACCURACY_GAME: u32 = 2;
/// Preset: steps that are right rather than fast.
pub const RHEXIS_ACCURACY_ACCURATE: u32 = 3;
/// Preset: equilibria by `rhexis_settle`.
pub const RHEXIS_ACCURACY_STATIC: u32 = 4;

/// All worlds of the process.
pub(crate) static WORLDS: Table<World> = Table::new(Kind::World);

/// A simulation alone, or one that a scene drives.
pub(crate) enum Run {
    Bare(Box<Simulation>),
    Scene(Box<Instance>),
}

/// A world and what it has lent to C.
pub(crate) struct World {
    tag: u64,
    pub(crate) run: Run,
    pub(crate) shown: BTreeMap<BodyId, Shown>,
    pub(crate) events: VecDeque<Event>,
    pub(crate) event_text: CString,
}

impl World {
    fn new(handle: u64, run: Run) -> Self {
        let (shown, events, event_text) = (BTreeMap::new(), VecDeque::new(), CString::default());
        Self { tag: tag(handle), run, shown, events, event_text }
    }

    pub(crate) fn simulation(&mut self) -> &mut Simulation {
        match &mut self.run {
            Run::Bare(simulation) => simulation,
            Run::Scene(instance) => &mut instance.simulation,
        }
    }

    /// The entity of a handle, alive.
    pub(crate) fn entity(&mut self, handle: RhexisEntity) -> Answer<Entity> {
        let entity = unpack(self.tag, handle.bits)?;
        if self.simulation().world().contains(entity) {
            return Ok(entity);
        }
        let message = format!("the entity {:#x} is destroyed, or was never made", handle.bits);
        Err(Failure::new(RhexisStatus::InvalidHandle, message))
    }

    /// The body of a handle, alive.
    pub(crate) fn body(&mut self, handle: RhexisEntity) -> Answer<BodyId> {
        let entity = self.entity(handle)?;
        if self.simulation().world().satisfies::<&Body>(entity) {
            return Ok(entity.into());
        }
        let message = format!("the entity {:#x} is no body", handle.bits);
        Err(Failure::new(RhexisStatus::InvalidHandle, message))
    }

    /// The obstacle of a handle, alive.
    pub(crate) fn obstacle(&mut self, handle: RhexisEntity) -> Answer<ObstacleId> {
        let entity = self.entity(handle)?;
        if self.simulation().world().satisfies::<&Obstacle>(entity) {
            return Ok(entity.into());
        }
        let message = format!("the entity {:#x} is no obstacle", handle.bits);
        Err(Failure::new(RhexisStatus::InvalidHandle, message))
    }

    /// The handle of an entity.
    pub(crate) fn handle(&self, entity: impl Into<Entity>) -> Answer<RhexisEntity> {
        pack(self.tag, entity.into()).map(|bits| RhexisEntity { bits })
    }

    /// The handle of what has just been put into the world; where there is none left it is taken out again.
    pub(crate) fn handle_of_new(&mut self, entity: impl Into<Entity>) -> Answer<RhexisEntity> {
        let entity = entity.into();
        self.handle(entity).inspect_err(|_| {
            // It has just been spawned.
            let _ = self.simulation().despawn(entity);
        })
    }
}

/// Works on a world that no other thread works on.
pub(crate) fn with<R>(world: RhexisWorld, work: impl FnOnce(&mut World) -> Answer<R>) -> Answer<R> {
    WORLDS.with(world.bits, work)
}

/// Keeps a simulation as a world.
pub(crate) fn keep(run: Run) -> Answer<RhexisWorld> {
    WORLDS.add(|handle| World::new(handle, run)).map(|bits| RhexisWorld { bits })
}

pub(crate) fn summary(report: &Report) -> RhexisReport {
    let bodies = &report.bodies;
    let any = |is: fn(&rhexis::report::BodyReport) -> bool| u8::from(bodies.iter().any(is));
    RhexisReport {
        step: report.step,
        time: report.time,
        iterations: bodies.iter().map(|body| u64::from(body.iterations)).sum(),
        tip_count: bodies.iter().map(|body| body.tip_count as u64).sum(),
        rolled_back: report.rolled_back,
        has_failed: u8::from(report.has_failed),
        is_late: any(|body| body.is_late),
        is_cut_short: any(|body| body.is_tear_cut_short),
    }
}

fn settings_of(given: RhexisSettings) -> Answer<Settings> {
    let mut settings = Settings::new(match given.accuracy {
        RHEXIS_ACCURACY_FAST => Accuracy::Fast,
        RHEXIS_ACCURACY_HAPTIC => Accuracy::Haptic,
        RHEXIS_ACCURACY_GAME => Accuracy::Game,
        RHEXIS_ACCURACY_ACCURATE => Accuracy::Accurate,
        RHEXIS_ACCURACY_STATIC => Accuracy::Static,
        other => return Err(Failure::argument(format!("there is no accuracy {other}: give 0 to 4"))),
    });
    settings.threads = given.threads as usize;
    settings.portable_instructions = given.portable_instructions != 0;
    if given.budget != 0 {
        settings.budget = Some(given.budget);
    }
    Ok(settings)
}

/// Fills settings with the defaults.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_settings_init(settings: Out<RhexisSettings>) -> RhexisStatus {
    call(|| {
        settings.check("settings")?;
        settings.write(RhexisSettings {
            accuracy: RHEXIS_ACCURACY_FAST,
            threads: 0,
            budget: 0,
            portable_instructions: 0,
        });
        Ok(())
    })
}

/// Makes an empty world at time zero. `settings` may be NULL for the defaults.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_world_create(settings: In<RhexisSettings>, world: Out<RhexisWorld>) -> RhexisStatus {
    call(|| {
        world.check("world")?;
        let settings = settings.read_if_any("settings")?.map_or(Ok(Settings::default()), settings_of)?;
        let simulation = Simulation::new(settings).map_err(refused)?;
        world.write(keep(Run::Bare(Box::new(simulation)))?);
        Ok(())
    })
}

/// Makes a world from a scene's text, TOML as `rhexis scenes --show NAME` prints it. `origin` names the text in errors and may be NULL.
/// Mesh files that the text names are looked for in the working directory. `rhexis_advance` does the scene's steps.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_world_from_scene(text: Text, origin: Text, world: Out<RhexisWorld>) -> RhexisStatus {
    call(|| {
        world.check("world")?;
        let origin = if origin.is_null() { "scene" } else { origin.read("origin")? };
        let scene = Scene::parse(text.read("the scene's text")?, origin).map_err(unreadable)?;
        let instance = scene.instantiate().map_err(unreadable)?;
        world.write(keep(Run::Scene(Box::new(instance)))?);
        Ok(())
    })
}

/// Makes a world from a scene of the catalog, such as "fig2-tear".
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_world_from_catalog(name: Text, world: Out<RhexisWorld>) -> RhexisStatus {
    call(|| {
        world.check("world")?;
        let scene = Scene::named(name.read("the scene's name")?).map_err(unreadable)?;
        let instance = scene.instantiate().map_err(unreadable)?;
        world.write(keep(Run::Scene(Box::new(instance)))?);
        Ok(())
    })
}

/// Destroys a world and all that it has lent. A world that has failed too.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_world_destroy(world: RhexisWorld) -> RhexisStatus {
    call(|| WORLDS.remove(world.bits))
}

/// Moves the world on by `dt` \[ms\]. `report` may be NULL.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_step(world: RhexisWorld, dt: f64, report: Out<RhexisReport>) -> RhexisStatus {
    call(|| {
        report.check_if_any("report")?;
        let done = with(world, |world| world.simulation().step(dt).map(summary).map_err(refused))?;
        report.write(done);
        Ok(())
    })
}

/// Does the next step of a scene: its time step, its timed cuts and tools, its mode. `report` may be NULL. Refused for a world that is not
/// from a scene.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_advance(world: RhexisWorld, report: Out<RhexisReport>) -> RhexisStatus {
    call(|| {
        report.check_if_any("report")?;
        let done = with(world, |world| scene(world)?.advance().map(summary).map_err(refused))?;
        report.write(done);
        Ok(())
    })
}

/// Tells whether a scene is at its end: 1, or 0. A scene that is may be advanced further.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_is_finished(world: RhexisWorld, is_finished: Out<u8>) -> RhexisStatus {
    call(|| {
        is_finished.check("is_finished")?;
        is_finished.write(u8::from(with(world, |world| Ok(scene(world)?.is_finished()))?));
        Ok(())
    })
}

fn scene(world: &mut World) -> Answer<&mut Instance> {
    match &mut world.run {
        Run::Scene(instance) => Ok(instance),
        Run::Bare(_) => Err(refused("the world is not from a scene: call rhexis_step with a time step")),
    }
}

/// Moves time on by `dt` \[ms\] and finds the equilibrium there, to `tolerance`, a fraction of the largest corner force. `report` may be NULL.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_settle(
    world: RhexisWorld,
    dt: f64,
    tolerance: f64,
    report: Out<RhexisReport>,
) -> RhexisStatus {
    call(|| {
        report.check_if_any("report")?;
        let done = with(world, |world| world.simulation().settle(dt, tolerance).map(summary).map_err(refused))?;
        report.write(done);
        Ok(())
    })
}

/// Limits the next steps: iterations that a body may take in one step, and time of a solve \[ms\], after which the step is not the same on
/// every run; 0 for no limit.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_set_budget(world: RhexisWorld, iterations: u32, milliseconds: f64) -> RhexisStatus {
    call(|| {
        let time = Duration::try_from_secs_f64(milliseconds * 1e-3);
        let time = time.map_err(|error| Failure::argument(format!("a time of {milliseconds} ms: {error}")))?;
        with(world, |world| {
            let mut settings = *world.simulation().settings();
            settings.budget = (iterations > 0).then_some(iterations);
            settings.advanced.linear.time = (!time.is_zero()).then_some(time);
            world.simulation().set_settings(settings).map_err(refused)
        })
    })
}

/// Changes settings of the next steps by TOML, such as "max_tear_passes = 2"; what it does not name stays. `rhexis_settings_get` shows all.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_settings_set(world: RhexisWorld, toml: Text) -> RhexisStatus {
    call(|| {
        let toml = toml.read("the settings")?;
        with(world, |world| {
            let changed = toml_form::patched("settings", Some(world.simulation().settings()), toml)?;
            world.simulation().set_settings(changed).map_err(refused)
        })
    })
}

/// Writes the settings as TOML into a buffer, with a zero at the end that `count` counts too.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_settings_get(
    world: RhexisWorld,
    buffer: Buffer<u8>,
    capacity: usize,
    count: Out<usize>,
) -> RhexisStatus {
    call(|| {
        count.check("the count")?;
        let text = with(world, |world| toml_form::text("settings", world.simulation().settings()))?;
        buffer.fill(capacity, crate::status::c_text(&text).as_bytes_with_nul(), count)
    })
}

/// Writes the likely slips in all that a world holds into a buffer, one per line, with a zero at the end that `count` counts too: wrong units, missing
/// holds. `dt` is the time step \[ms\] that is meant, `duration` that of the run \[ms\], 0 where it is not known. A world from a scene has those of its scene,
/// whatever these are.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_doubts(
    world: RhexisWorld,
    dt: f64,
    duration: f64,
    buffer: Buffer<u8>,
    capacity: usize,
    count: Out<usize>,
) -> RhexisStatus {
    call(|| {
        count.check("the count")?;
        let list = with(world, |world| {
            Ok(match &world.run {
                Run::Scene(instance) => instance.doubts.clone(),
                Run::Bare(simulation) => simulation.doubts(dt, (duration > 0.0).then_some(duration)),
            })
        })?;
        let lines: Vec<String> = list.into_iter().map(|doubt| doubt.text).collect();
        buffer.fill(capacity, crate::status::c_text(&lines.join("\n")).as_bytes_with_nul(), count)
    })
}

/// Time reached \[ms\].
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_time(world: RhexisWorld, time: Out<f64>) -> RhexisStatus {
    call(|| {
        time.check("time")?;
        time.write(with(world, |world| Ok(world.simulation().time()))?);
        Ok(())
    })
}

/// Writes the bodies in order of spawning into a buffer, and their number.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_bodies(
    world: RhexisWorld,
    buffer: Buffer<RhexisEntity>,
    capacity: usize,
    count: Out<usize>,
) -> RhexisStatus {
    call(|| {
        count.check("the count")?;
        let bodies = with(world, |world| {
            let bodies = world.simulation().bodies();
            bodies.into_iter().map(|body| world.handle(body)).collect::<Answer<Vec<_>>>()
        })?;
        buffer.fill(capacity, &bodies, count)
    })
}

/// Finds the body of a name.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_find_body(world: RhexisWorld, name: Text, body: Out<RhexisEntity>) -> RhexisStatus {
    call(|| {
        body.check("body")?;
        let name = name.read("the name")?;
        let found = with(world, |world| {
            let simulation = world.simulation();
            let is_it =
                |body: &BodyId| simulation.world().get::<&Body>(body.entity()).is_ok_and(|body| body.name == name);
            let found = simulation.bodies().into_iter().find(is_it);
            let none = || Failure::new(RhexisStatus::NotFound, format!("there is no body `{name}`"));
            world.handle(found.ok_or_else(none)?)
        })?;
        body.write(found);
        Ok(())
    })
}

/// Takes a body, an obstacle or a tool out of the world.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_entity_destroy(world: RhexisWorld, entity: RhexisEntity) -> RhexisStatus {
    call(|| {
        with(world, |world| {
            let entity = world.entity(entity)?;
            world.shown.remove(&entity.into());
            world.simulation().despawn(entity).map_err(refused)
        })
    })
}

/// The hash of state and topology: equal for equal runs on every platform of equal arithmetic, from C, Rust or any other language.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_hash(world: RhexisWorld, hash: Out<u64>) -> RhexisStatus {
    call(|| {
        hash.check("hash")?;
        hash.write(with(world, |world| Ok(world.simulation().hash().0))?);
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::saved::{rhexis_snapshot_destroy, rhexis_snapshot_take, rhexis_world_from_snapshot};

    fn out<T>(value: &mut T) -> Out<T> {
        // SAFETY: a reference may be written to, and calls do not keep what they are given.
        unsafe { Out::new(value) }
    }

    fn empty() -> RhexisWorld {
        let mut world = RhexisWorld::default();
        assert_eq!(rhexis_world_create(In::NULL, out(&mut world)), RhexisStatus::Ok);
        world
    }

    #[test]
    fn a_call_within_a_call_is_told_that_the_world_is_busy() {
        let world = empty();
        let inside = call(|| {
            with(world, |_| {
                assert_eq!(rhexis_step(world, 1.0, Out::NULL), RhexisStatus::Busy);
                assert_eq!(rhexis_world_destroy(world), RhexisStatus::Busy);
                Ok(())
            })
        });
        assert_eq!(inside, RhexisStatus::Ok);
        assert_eq!(rhexis_step(world, 1.0, Out::NULL), RhexisStatus::Ok);
        assert_eq!(rhexis_world_destroy(world), RhexisStatus::Ok);
    }

    #[test]
    fn a_panic_stays_inside_and_marks_the_world() {
        let (world, other, mut snapshot) = (empty(), empty(), RhexisSnapshot::default());
        assert_eq!(rhexis_step(world, 1.0, Out::NULL), RhexisStatus::Ok);
        assert_eq!(rhexis_snapshot_take(world, out(&mut snapshot)), RhexisStatus::Ok);
        assert_eq!(call(|| with(world, |_| -> Answer<()> { panic!("on purpose") })), RhexisStatus::Panic);
        // SAFETY: the library's own text.
        let message = unsafe { std::ffi::CStr::from_ptr(crate::status::rhexis_last_error_message()) };
        assert_eq!(message, c"the library has failed inside: on purpose");
        assert_eq!(rhexis_step(world, 1.0, Out::NULL), RhexisStatus::Poisoned);
        assert_eq!(rhexis_snapshot_take(world, out(&mut { snapshot })), RhexisStatus::Poisoned);
        assert_eq!(rhexis_step(other, 1.0, Out::NULL), RhexisStatus::Ok);
        assert_eq!(rhexis_world_destroy(world), RhexisStatus::Ok);
        assert_eq!(rhexis_step(world, 1.0, Out::NULL), RhexisStatus::InvalidHandle);
        let mut again = RhexisWorld::default();
        assert_eq!(rhexis_world_from_snapshot(snapshot, out(&mut again)), RhexisStatus::Ok);
        assert_eq!(rhexis_step(again, 1.0, Out::NULL), RhexisStatus::Ok);
        assert_eq!(rhexis_snapshot_destroy(snapshot), RhexisStatus::Ok);
        [other, again].into_iter().for_each(|world| assert_eq!(rhexis_world_destroy(world), RhexisStatus::Ok));
    }
}
