//! Obstacles: put into the world, moved, and asked for their forces.

use super::{Simulation, SimulationError};
use crate::components::check::{Check, Host};
use crate::components::{
    Body, BodyError, Contact, ContactForces, Obstacle, ObstacleMotion, ObstaclePath, Path, Rigid, Shape, SolverScratch,
    Turning,
};
use crate::registry::Rejected;
use crate::replay::Input;
use crate::storage::{BodyId, ObstacleId};
use glam::DVec3;
use hecs::Entity;
use smallvec::SmallVec;

/// An obstacle before it is spawned: a shape, and the motion that it follows.
#[derive(Clone, Debug, PartialEq)]
pub struct Solid {
    shape: Shape,
    path: Option<Path>,
    turning: Option<Turning>,
    rigid: Option<Rigid>,
}

impl Solid {
    /// An obstacle at rest.
    pub fn new(shape: Shape) -> Self {
        Self { shape, path: None, turning: None, rigid: None }
    }

    /// The obstacle as a rigid body that tissue pushes.
    #[must_use]
    pub fn rigid(self, rigid: Rigid) -> Self {
        Self { rigid: Some(rigid), ..self }
    }

    /// The obstacle displaced along a path over time.
    #[must_use]
    pub fn path(self, path: Path) -> Self {
        Self { path: Some(path), ..self }
    }

    /// The obstacle turned over time, before it is displaced.
    #[must_use]
    pub fn turning(self, turning: Turning) -> Self {
        Self { turning: Some(turning), ..self }
    }
}

impl From<Shape> for Solid {
    fn from(shape: Shape) -> Self {
        Self::new(shape)
    }
}

impl From<Obstacle> for Solid {
    fn from(obstacle: Obstacle) -> Self {
        Self::new(obstacle.shape)
    }
}

/// Whether an obstacle can be pushed.
fn may_be_rigid(shape: &Shape, follows_path: bool) -> Result<(), BodyError> {
    let what = match shape {
        Shape::Plane { .. } => "a half space has no mass: give a box",
        _ if follows_path => "an obstacle that follows a path or turns by a curve yields to nothing: give one of both",
        _ => return Ok(()),
    };
    Err(BodyError::Contradiction { component: "Rigid", what })
}

impl Simulation {
    /// Puts an obstacle into the world; bodies that carry [`Contact`] feel it. Tissue that it meets on its way is taken along.
    ///
    /// # Errors
    /// For a shape with a number that is not finite, a radius or half axis that is not positive, or a normal that is no unit vector, for
    /// a path or a turn whose numbers are not finite or whose times do not ascend, and for a rigid body as [`set_rigid`](Self::set_rigid).
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// use rhexis::components::Path;
    ///
    /// let shape = Shape::Sphere { centre: DVec3::new(5.0, 5.0, -3.0), radius: 2.0 };
    /// let up = Path { points: vec![(0.0, DVec3::ZERO), (1000.0, DVec3::Z)] };
    /// let ball = simulation.spawn_obstacle(Solid::new(shape).path(up))?;
    /// assert_eq!(simulation.obstacles(), [ball]);
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn spawn_obstacle(&mut self, solid: impl Into<Solid>) -> Result<ObstacleId, BodyError> {
        let Solid { shape, path, turning, rigid } = solid.into();
        let obstacle = Obstacle { shape };
        if let Some(rigid) = rigid {
            obstacle.check(&Host::default())?;
            may_be_rigid(&obstacle.shape, path.is_some() || turning.is_some())?;
            rigid.check("Rigid")?;
        }
        if path.is_none() && turning.is_none() {
            self.note(|| Input::SpawnObstacle(obstacle.clone()));
            obstacle.check(&Host::default())?;
            let spawned = self.world.spawn((obstacle,)).into();
            if let Some(rigid) = rigid {
                // It was checked.
                let _ = self.set_rigid(spawned, rigid);
            }
            return Ok(spawned);
        }
        let path = path.unwrap_or_default();
        self.note(|| Input::SpawnMovingObstacle(obstacle.clone(), path.clone(), turning.clone()));
        let origin = obstacle.shape.clone();
        let path = ObstaclePath { origin: origin.clone(), path, turning };
        obstacle.check(&Host::default())?;
        path.check(&Host::default())?;
        Ok(self.world.spawn((obstacle, path, ObstacleMotion::at(origin))).into())
    }

    /// Moves an obstacle during the next step: it begins where it is and ends as `shape`. Tissue met on a straight way is taken
    /// along; a turn, or another shape, is only looked at in its end. A path that it followed is forgotten, and so is the mass of a rigid body.
    ///
    /// # Errors
    /// If there is no such obstacle, and for a shape as [`spawn_obstacle`](Self::spawn_obstacle).
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// # let shape = Shape::Sphere { centre: DVec3::new(5.0, 5.0, -3.0), radius: 2.0 };
    /// let ball = simulation.spawn_obstacle(Obstacle { shape })?;
    /// simulation.move_obstacle(ball, Shape::Sphere { centre: DVec3::new(5.0, 5.0, -2.9), radius: 2.0 })?;
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn move_obstacle(&mut self, obstacle: ObstacleId, shape: Shape) -> Result<(), SimulationError> {
        self.note(|| Input::MoveObstacle { obstacle, shape: shape.clone() });
        if !self.world.satisfies::<&Obstacle>(obstacle.entity()) {
            return Err(SimulationError::NoSuchBody);
        }
        let rejected = |source| Rejected {
            entity: obstacle.entity(),
            owner: format!("obstacle {}", obstacle.entity().id()),
            source,
        };
        shape.check("Obstacle").map_err(rejected)?;
        let found =
            self.world.query_one_mut::<&mut Obstacle>(obstacle.entity()).map_err(|_| SimulationError::NoSuchBody)?;
        let from = std::mem::replace(&mut found.shape, shape);
        // Moved twice before a step: from where it was at its start.
        let from = self
            .world
            .get::<&ObstacleMotion>(obstacle.entity())
            .map_or(from, |obstacle_motion| obstacle_motion.from.clone());
        let _ = self.world.remove_one::<ObstaclePath>(obstacle.entity());
        self.world.insert_one(obstacle.entity(), ObstacleMotion::at(from)).map_err(|_| SimulationError::NoSuchBody)
    }

    /// Makes an obstacle a rigid body that tissue pushes, with this motion, or one that yields to nothing. A step moves it, by backward
    /// Euler, as unknowns of the solve: a light body is as stable as a heavy one. Obstacles do not feel each other. A host that
    /// integrates it further calls this before every step, and puts it into its place by
    /// `set(obstacle, Obstacle { shape })`.
    ///
    /// # Errors
    /// If there is no such obstacle; for a mass that is not positive, an inertia that is not positive definite, a number that is not finite, and
    /// for a plane or an obstacle that follows a path.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// use rhexis::components::Rigid;
    /// let shape = Shape::Sphere { centre: DVec3::new(5.0, 5.0, 3.0), radius: 2.0 };
    /// let ball = Rigid::of(&shape, 0.5).ok_or("a plane")?;
    /// let falling = Rigid { velocity: DVec3::NEG_Z * 0.1, acceleration: DVec3::NEG_Z * 9.81e-3, ..ball };
    /// let ball = simulation.spawn_obstacle(Solid::new(shape).rigid(falling))?;
    /// simulation.step(1.0)?;
    /// let now = simulation.rigid(ball)?.ok_or("not rigid")?;
    /// assert!((now.velocity.z + 0.10981).abs() < 1e-15);
    /// simulation.set_rigid(ball, None)?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn set_rigid(&mut self, obstacle: ObstacleId, rigid: impl Into<Option<Rigid>>) -> Result<(), SimulationError> {
        let rigid = rigid.into();
        self.note(|| Input::SetRigid { obstacle, rigid });
        let entity = obstacle.entity();
        let rejected = |source| Rejected { entity, owner: format!("obstacle {}", entity.id()), source };
        let follows_path = self.world.satisfies::<&ObstaclePath>(entity);
        let shape = self.world.get::<&Obstacle>(entity).map_err(|_| SimulationError::NoSuchBody)?.shape.clone();
        if let Some(rigid) = rigid {
            may_be_rigid(&shape, follows_path).and_then(|()| rigid.check("Rigid")).map_err(rejected)?;
        }
        let found = self.world.get::<&ObstacleMotion>(entity).ok().map(|motion| (*motion).clone());
        let motion = ObstacleMotion { rigid, ..found.unwrap_or_else(|| ObstacleMotion::at(shape)) };
        self.world.insert_one(entity, motion).map_err(|_| SimulationError::NoSuchBody)
    }

    /// Mass and motion of a rigid obstacle, and the impulse of the last step; `None` for an obstacle that yields to nothing.
    ///
    /// # Errors
    /// If there is no such obstacle.
    ///
    /// # Examples
    /// See [`set_rigid`](Self::set_rigid).
    pub fn rigid(&self, obstacle: ObstacleId) -> Result<Option<Rigid>, SimulationError> {
        if !self.world.satisfies::<&Obstacle>(obstacle.entity()) {
            return Err(SimulationError::NoSuchBody);
        }
        Ok(self.world.get::<&ObstacleMotion>(obstacle.entity()).ok().and_then(|motion| motion.rigid))
    }

    /// Forces \[N\] of the obstacles on a body in the last step or static solve, each with its obstacle: those of the last linear solve, friction
    /// included, and the impulses of later corrections over the length of the step. Of a step taken in parts they are those of the last
    /// part. Obstacles that did not touch the body are left out.
    ///
    /// # Errors
    /// If there is no such body.
    pub fn contact_forces(&self, body: BodyId) -> Result<Vec<(ObstacleId, DVec3)>, SimulationError> {
        let mut query = self.world.query_one::<hecs::Satisfies<&Contact>>(body.entity());
        let has_contact = query.get().map_err(|_| SimulationError::NoSuchBody)?;
        let about = self.world.get::<&Body>(body.entity()).map_err(|_| SimulationError::NoSuchBody)?;
        if !has_contact {
            return Ok(Vec::new());
        }
        let mut obstacles = self.world.query::<(Entity, &ContactForces)>();
        let force = |(entity, known): (Entity, &ContactForces)| {
            let (_, force) = known.forces.iter().find(|(order, _)| *order == about.order)?;
            Some((ObstacleId::from(entity), *force))
        };
        let mut forces: Vec<_> = obstacles.iter().filter_map(force).collect();
        forces.sort_unstable_by_key(|(obstacle, _)| *obstacle);
        Ok(forces)
    }

    /// After a step: records the forces of the obstacles, and those that were moved stay.
    pub(super) fn rest_obstacles(&mut self) {
        self.note_contact_forces();
        for (obstacle, obstacle_motion) in self.world.query_mut::<(&Obstacle, &mut ObstacleMotion)>() {
            obstacle_motion.from = obstacle.shape.clone();
            obstacle_motion.turn = None;
        }
    }

    /// Records the forces of the last solve on every body. Bodies that have not been solved since they were restored keep theirs.
    pub(super) fn note_contact_forces(&mut self) {
        type Felt<'a> = (&'a Body, &'a SolverScratch, &'a Contact);
        let obstacles = self.world.query_mut::<(Entity, &Obstacle)>();
        let obstacles: SmallVec<[Entity; 8]> = obstacles.into_iter().map(|(entity, _)| entity).collect();
        for obstacle in obstacles {
            let known =
                self.world.get::<&mut ContactForces>(obstacle).ok().map(|mut known| std::mem::take(&mut *known));
            let is_known = known.is_some();
            let mut known = known.unwrap_or_default();
            for (Body { order, .. }, scratch, _) in self.world.query::<Felt>().iter() {
                let contact = &scratch.contact;
                if !contact.is_known {
                    continue;
                }
                known.forces.retain(|(other, _)| other != order);
                let felt = contact.forces.iter().find(|(other, force)| *other == obstacle && *force != DVec3::ZERO);
                known.forces.extend(felt.map(|(_, force)| (*order, *force)));
            }
            if is_known || !known.forces.is_empty() {
                // An obstacle that was just there.
                let _ = self.world.insert_one(obstacle, known);
            }
        }
    }
}
