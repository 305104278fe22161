//! Taking a snapshot, and going back to one.

use super::Simulation;
use crate::components::Body;
use crate::replay::Input;
use crate::report::Report;
use crate::settings::Settings;
use crate::snapshot::{Contents, Handles, Saved, Snapshot, SnapshotError, StateHash, hash_of, is_ours, strip};
use crate::storage::{Topology, Triangles, Vertices};
use crate::systems::parallel::Pool;
use crate::systems::solver::{Factor, MixedSolver};
use hecs::{Entity, World};
use std::sync::Arc;

impl Simulation {
    /// The whole state as it is now. The run goes on as without it.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// let before = simulation.snapshot();
    /// simulation.step(5.0)?;
    /// simulation.restore(&before)?;
    /// assert_eq!(simulation.time(), before.time());
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn snapshot(&self) -> Snapshot {
        let (mut entities, mut others) = (Vec::new(), Vec::new());
        for entity in self.world.iter() {
            match Saved::of(entity) {
                Some(saved) => entities.push(saved),
                None => others.push(entity.entity().to_bits().get()),
            }
        }
        let free = self.world.freelist().map(|entity| entity.to_bits().get()).collect();
        let Report { step, time, ref bodies, rolled_back, has_failed, .. } = self.report;
        let report = Report { step, time, systems: Vec::new(), bodies: bodies.clone(), rolled_back, has_failed };
        Snapshot(Arc::new(Contents {
            settings: self.settings,
            report,
            events: self.events.clone(),
            next_order: self.next_order,
            entities,
            handles: Handles { others, free },
            writer: env!("CARGO_PKG_VERSION").to_owned(),
        }))
    }

    /// Goes back to a snapshot, of this simulation or of another one: from there on it takes the same steps to the same
    /// bits. Bodies and obstacles are those of the snapshot, under their handles; others are gone. Components of your
    /// own stay on entities that live on, and entities of your own stay where no handle of the snapshot needs their place;
    /// those that are gone since are there again, empty. Settings are the snapshot's, but for the threads and their
    /// instructions.
    ///
    /// # Errors
    /// Where the parts of a solver do not fit together; nothing has changed then. That of a snapshot that was taken in
    /// this process does.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<(), SnapshotError> {
        let contents = &*snapshot.0;
        let solvers = contents.entities.iter().map(solvers).collect::<Result<Vec<_>, _>>()?;
        self.note(|| Input::Restore(snapshot.clone()));
        let mut old = std::mem::take(&mut self.world);
        let world = &mut self.world;
        let strangers = old.iter().filter(|entity| !is_ours(*entity)).map(|entity| entity.entity());
        let strangers: Vec<Entity> = strangers.collect();
        for entity in strangers {
            if let Ok(taken) = old.take(entity) {
                world.spawn_at(entity, taken);
            }
        }
        for (saved, solvers) in contents.entities.iter().zip(solvers) {
            if strip(&mut old, saved.entity)
                && let Ok(taken) = old.take(saved.entity)
            {
                world.spawn_at(saved.entity, taken);
            }
            put(world, saved, solvers);
        }
        set_free_handles(world, contents);
        let Settings { threads, portable_instructions, .. } = self.settings;
        self.settings = Settings { threads, portable_instructions, ..contents.settings };
        self.report = contents.report.clone();
        self.schedule.reset_reports(&mut self.report.systems);
        self.events.clone_from(&contents.events);
        self.next_order = contents.next_order;
        // A snapshot taken before validation is not validated.
        self.dirty.note(None);
        for body in snapshot.bodies() {
            // A body of the snapshot is there, with tables or not.
            let _ = self.refresh(body);
        }
        Ok(())
    }

    /// A simulation that goes on from a snapshot, with as many threads as its settings ask for.
    ///
    /// # Errors
    /// As [`new`](Self::new) and [`restore`](Self::restore).
    pub fn from_snapshot(snapshot: &Snapshot) -> Result<Self, SnapshotError> {
        let settings = *snapshot.settings();
        settings.validate()?;
        let pool = Pool::new(settings.threads, settings.portable_instructions).map_err(SnapshotError::Threads)?;
        let mut simulation = Self::with_pool(settings, pool);
        simulation.restore(snapshot)?;
        Ok(simulation)
    }

    /// Puts a body back under its handle that was spawned when a recording was made.
    pub(super) fn put_back(&mut self, saved: &Saved) {
        // A body that has just been spawned has no solver yet that could not be made.
        // Where something stands in its place it would be two things in one.
        if let (Ok(solvers), Some(Body { order, .. }), false) =
            (solvers(saved), &saved.body, self.world.contains(saved.entity))
        {
            put(&mut self.world, saved, solvers);
            self.next_order = self.next_order.max(order + 1);
        }
        self.note_spawned(saved.entity.into());
    }

    /// A number that tells the state and its topology from others: the same on every platform of equal arithmetic. The data it
    /// runs over are listed at [`StateHash`].
    pub fn hash(&self) -> StateHash {
        hash_of(&self.world, self.report.step, self.report.time)
    }
}

/// Gives an entity its components.
fn put(world: &mut World, saved: &Saved, solvers: Solvers) {
    let mut components = saved.clone().into_components();
    if let Some((factor, mixed)) = solvers {
        components.add_bundle((factor, mixed));
    }
    match world.contains(saved.entity) {
        true => _ = world.insert(saved.entity, components.build()),
        false => world.spawn_at(saved.entity, components.build()),
    }
}

type Solvers = Option<(Factor, MixedSolver)>;

/// The solvers of a body.
fn solvers(saved: &Saved) -> Result<Solvers, SnapshotError> {
    let Saved { body: Some(Body { name, .. }), factor: Some(factor), tail, .. } = saved else { return Ok(None) };
    let Some(mixed) = &tail.mixed else { return Ok(None) };
    let (Some(vertices), Some(triangles), Some(topology)) = (&saved.vertices, &saved.triangles, &saved.topology) else {
        return Ok(None);
    };
    let wrong = |what| SnapshotError::contradiction(format!("body `{name}`"), what);
    let factor = Factor::of_state(factor).map_err(|_| wrong("its matrix has no Cholesky factor"))?;
    let mesh: (&Vertices, &Triangles, &Topology) = (vertices, triangles, topology);
    let mixed = MixedSolver::of_state(mixed, mesh).ok_or_else(|| wrong("multigrid's numbers are of another mesh"))?;
    Ok(Some((factor, mixed)))
}

/// New handles are those that the simulation of the snapshot would give, unless things of the host's own are in the way. Entities that the
/// host had then and has no more are there again, empty.
fn set_free_handles(world: &mut World, contents: &Contents) {
    let Contents { entities, handles: Handles { others, free }, .. } = contents;
    let mut is_taken = vec![false; entities.len() + others.len() + free.len()];
    let mut take = |entity: Entity| {
        let place = is_taken.get_mut(entity.id() as usize);
        place.is_some_and(|taken| !std::mem::replace(taken, true))
    };
    let mut is_apart = world.iter().map(|entity| entity.entity()).all(&mut take);
    let entity = |&bits: &u64| Entity::from_bits(bits);
    let gone: Vec<Entity> = others.iter().filter_map(entity).filter(|&other| !world.contains(other)).collect();
    for other in gone {
        if take(other) {
            world.spawn_at(other, ());
        }
    }
    let free: Vec<Entity> = free.iter().filter_map(entity).collect();
    is_apart &= free.iter().copied().all(take);
    if is_apart && is_taken.iter().all(|&taken| taken) {
        world.set_freelist(&free);
    }
}
