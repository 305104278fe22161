//! Recording and replay of the calls to a simulation.

use super::{Simulation, Solid, order};
use crate::components::{Body, SolverScratch};
use crate::registry::Parameters;
use crate::replay::{Input, Recorder, Recording, ReplayError, Spawned};
use crate::snapshot::Saved;
use crate::storage::BodyId;
use hecs::Entity;

impl Simulation {
    /// Records all inputs from now on; an earlier recording is dropped. Memory grows by some bytes per call.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// simulation.record();
    /// simulation.step(5.0)?;
    /// let recording = simulation.end_recording().expect("a recording");
    /// assert_eq!(recording.replay()?.hash(), simulation.hash());
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn record(&mut self) {
        self.recorder = Some(Recorder::new(self.snapshot()));
    }

    /// Ends the recording; `None` where there was none.
    pub fn end_recording(&mut self) -> Option<Recording> {
        self.note_changes();
        let end = self.hash();
        self.recorder.take().map(|recorder| recorder.finish(end))
    }

    /// Writes a call down, after the changes made before it.
    pub(super) fn note(&mut self, input: impl FnOnce() -> Input) {
        self.note_changes();
        if let Some(recorder) = &mut self.recorder {
            recorder.note(input());
        }
    }

    /// Before an entity, or all of them, is handed out to be changed.
    pub(super) fn lend(&mut self, entity: Option<Entity>) {
        self.dirty.note(entity);
        self.keep_lent(entity);
    }

    /// Keeps the parameters of an entity, or of all, before they are changed.
    pub(super) fn keep_lent(&mut self, entity: Option<Entity>) {
        let Self { world, recorder: Some(recorder), .. } = self else { return };
        match entity {
            Some(entity) => recorder.lend(entity, Parameters::of(world, entity)),
            None => {
                let all = world.iter().map(|entity| entity.entity());
                all.for_each(|entity| recorder.lend(entity, Parameters::of(world, entity)));
            }
        }
    }

    /// Records changes to the parameters that were handed out.
    fn note_changes(&mut self) {
        let Self { world, recorder: Some(recorder), .. } = self else { return };
        for (entity, before) in recorder.take_lent() {
            if let Some(changed) = Parameters::of(world, entity).since(&before) {
                recorder.note(Input::Change { entity, to: changed.into() });
            }
        }
    }

    /// Writes down the body that was put into the world.
    pub(super) fn note_spawned(&mut self, body: BodyId) {
        if self.recorder.is_some()
            && let Some(saved) = self.world.entity(body.entity()).ok().and_then(Saved::of)
        {
            self.note(|| Input::Spawn(Spawned(Box::new(saved))));
        }
    }

    /// Before a step: its solves stop where `scripts` say, in the order of spawning; without any where time is up.
    pub(super) fn begin_stops(&mut self, scripts: &[Vec<u32>]) {
        if self.settings.advanced.linear.time.is_none() {
            return;
        }
        for (place, body) in self.bodies().into_iter().enumerate() {
            if let Ok(scratch) = self.world.query_one_mut::<&mut SolverScratch>(body.entity()) {
                scratch.stops.begin(scripts.get(place).map_or(&[], Vec::as_slice));
            }
        }
    }

    /// After a step: where its solves have stopped.
    pub(super) fn note_stops(&mut self) {
        let Self { world, recorder: Some(recorder), settings, .. } = self else { return };
        if settings.advanced.linear.time.is_none() {
            return;
        }
        let mut query = world.query::<(Entity, &SolverScratch)>().with::<&Body>();
        let mut stops: Vec<_> =
            query.iter().map(|(body, s)| (order(world, body.into()), s.stops.taken().to_vec())).collect();
        stops.sort_unstable_by_key(|&(order, _)| order);
        recorder.note_stops(stops.into_iter().map(|(_, taken)| taken).collect());
    }

    /// Repeats a recorded input. An input refused then is refused now.
    pub fn repeat(&mut self, input: &Input) {
        match input {
            Input::Step { dt, stops } => _ = self.step_with(*dt, stops),
            Input::Settle { dt, tolerance } => _ = self.settle(*dt, *tolerance),
            Input::SettleAndTear { dt, tolerance, rounds } => _ = self.settle_and_tear(*dt, *tolerance, *rounds),
            Input::LinearResponse { dt } => _ = self.linear_response(*dt),
            Input::Cut { body, polyline } => _ = self.cut(*body, polyline),
            Input::Spawn(Spawned(saved)) => self.put_back(saved),
            Input::SpawnObstacle(obstacle) => _ = self.spawn_obstacle(obstacle.clone()),
            Input::SpawnMovingObstacle(obstacle, path, turning) => {
                let solid = Solid::new(obstacle.shape.clone()).path(path.clone());
                _ = self.spawn_obstacle(match turning {
                    Some(turning) => solid.turning(turning.clone()),
                    None => solid,
                });
            }
            Input::MoveObstacle { obstacle, shape } => _ = self.move_obstacle(*obstacle, shape.clone()),
            Input::SetMaterial { body, to } => _ = self.put_materials(*body, to.as_ref().clone()),
            Input::SetRigid { obstacle, rigid } => _ = self.set_rigid(*obstacle, *rigid),
            Input::SpawnForceps { name, jaws, pose } => _ = self.spawn_forceps(name, *jaws, *pose),
            Input::MoveForceps { forceps, pose, within } => _ = self.move_forceps(*forceps, *pose, *within),
            Input::CloseForceps { forceps, body, grasp } => _ = self.close_forceps(*forceps, *body, grasp),
            Input::OpenForceps(forceps) => _ = self.open_forceps(*forceps),
            Input::SpawnBlade { reach, least } => _ = self.spawn_blade(*reach, *least),
            Input::DrawBlade { blade, body, edge } => _ = self.draw_blade(*blade, *body, *edge),
            Input::Pin { body, name, vertices } => _ = self.pin(*body, name, vertices),
            Input::Unpin { body, vertices } => _ = self.unpin(*body, vertices),
            Input::UnpinAll { body, name } => _ = self.unpin_all(*body, name),
            Input::Teleport { body, rotation, shift } => _ = self.teleport(*body, *rotation, *shift),
            Input::Despawn(entity) => _ = self.despawn(*entity),
            Input::Wake(body) => _ = self.wake((*body).into()),
            Input::WakeAll => _ = self.world_mut(),
            Input::Reorder(body) => _ = self.reorder(*body),
            Input::SetSettings(settings) => _ = self.set_settings(*settings),
            Input::Change { entity, to } => {
                self.dirty.note(Some(*entity));
                to.0.give(&mut self.world, *entity);
            }
            Input::Restore(snapshot) => _ = self.restore(snapshot),
            Input::Set { entity, to } => self.set_again(*entity, &to.0),
            Input::ApplyForce { body, vertex, force } => _ = self.apply_force(*body, *vertex, *force),
        }
    }
}

impl Recording {
    /// Repeats all of it.
    ///
    /// # Errors
    /// Where it does not begin, or does not end as the recording did.
    pub fn replay(&self) -> Result<Simulation, ReplayError> {
        let mut simulation = Simulation::from_snapshot(self.start())?;
        self.inputs().iter().for_each(|input| simulation.repeat(input));
        let (expected, found) = (self.end(), simulation.hash());
        if found == expected { Ok(simulation) } else { Err(ReplayError::Diverged { expected, found }) }
    }
}
