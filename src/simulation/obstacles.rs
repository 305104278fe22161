//! Obstacles: put into the world, moved, and asked for their forces.

use super::{Simulation, SimulationError};
use crate::components::check::{Check, Host};
use crate::components::{
    Body, BodyError, Contact, ContactForces, Obstacle, ObstacleMotion, ObstaclePath, Path, Shape, SolverScratch,
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
}

impl Solid {
    /// An obstacle at rest.
    pub fn new(shape: Shape) -> Self {
        Self { shape, path: None, turning: None }
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

impl Simulation {
    /// Puts an obstacle into the world; bodies that carry [`Contact`] feel it. Tissue that it meets on its way is taken along.
    ///
    /// # Errors
    /// For a shape with a number that is not finite, a radius or half axis that is not positive, or a normal that is no unit vector, and for
    /// a path or a turn whose numbers are not finite or whose times do not ascend.
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
        let Solid { shape, path, turning } = solid.into();
        let obstacle = Obstacle { shape };
        if path.is_none() && turning.is_none() {
            self.note(|| Input::SpawnObstacle(obstacle.clone()));
            obstacle.check(&Host::default())?;
            return Ok(self.world.spawn((obstacle,)).into());
        }
        let path = path.unwrap_or_default();
        self.note(|| Input::SpawnMovingObstacle(obstacle.clone(), path.clone(), turning.clone()));
        let origin = obstacle.shape.clone();
        let path = ObstaclePath { origin: origin.clone(), path, turning };
        obstacle.check(&Host::default())?;
        path.check(&Host::default())?;
        Ok(self.world.spawn((obstacle, path, ObstacleMotion { from: origin, turn: None })).into())
    }

    /// Moves an obstacle during the next step: it begins where it is and ends as `shape`. Tissue met on a straight way is taken
    /// along; a turn, or another shape, is only looked at in its end. A path that it followed is forgotten.
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
        self.world
            .insert_one(obstacle.entity(), ObstacleMotion { from, turn: None })
            .map_err(|_| SimulationError::NoSuchBody)
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
            *obstacle_motion = ObstacleMotion { from: obstacle.shape.clone(), turn: None };
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
