//! Obstacles: put into the world, moved, and asked for their forces.

use super::{Simulation, SimulationError};
use crate::components::check::{Check, Host};
use crate::components::{
    Body, BodyError, Contact, FrictionState, Increment, Obstacle, ObstacleMotion, ObstaclePath, Path, Shape, Turning,
};
use crate::registry::Rejected;
use crate::replay::Input;
use crate::storage::{BodyId, ObstacleId, Topology, Triangles, Vertices};
use crate::systems::contact;
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

    /// The forces \[N\] of the obstacles on a body, each with its obstacle: along their normals as it is, and the friction of the last step.
    /// Those that do not touch it are left out.
    ///
    /// # Errors
    /// If there is no such body.
    pub fn contact_forces(&self, body: BodyId) -> Result<Vec<(ObstacleId, DVec3)>, SimulationError> {
        type Query<'a> = (&'a Body, &'a Vertices, &'a Triangles, &'a Topology, Option<&'a Contact>);
        let mut query = self.world.query_one::<Query>(body.entity());
        let (about, vertices, triangles, topology, contact) = query.get().map_err(|_| SimulationError::NoSuchBody)?;
        let Some(contact) = contact else { return Ok(Vec::new()) };
        let mut obstacles = self.world.query::<(Entity, &Obstacle, Option<&FrictionState>)>();
        let force = |(entity, obstacle, friction): (Entity, &Obstacle, Option<&FrictionState>)| {
            let friction =
                friction.and_then(|friction| friction.forces.iter().find(|(order, _)| *order == about.order));
            let push = contact::force_of(obstacle, contact, (vertices, triangles, topology));
            (ObstacleId::from(entity), push + friction.map_or(DVec3::ZERO, |(_, force)| *force))
        };
        let mut forces: Vec<_> = obstacles.iter().map(force).filter(|(_, force)| *force != DVec3::ZERO).collect();
        forces.sort_unstable_by_key(|(obstacle, _)| *obstacle);
        Ok(forces)
    }

    /// After a step: takes down the friction of the obstacles, and those that were moved stay.
    pub(super) fn rest_obstacles(&mut self) {
        self.note_friction();
        for (obstacle, obstacle_motion) in self.world.query_mut::<(&Obstacle, &mut ObstacleMotion)>() {
            *obstacle_motion = ObstacleMotion { from: obstacle.shape.clone(), turn: None };
        }
    }

    /// Takes down the friction of the last step on every body that feels some.
    fn note_friction(&mut self) {
        let has_friction = |contact: &Contact| contact.friction > 0.0;
        if !self.world.query_mut::<&Contact>().into_iter().any(has_friction) {
            return;
        }
        type Rubbed<'a> = (&'a Body, &'a Vertices, &'a Triangles, &'a Topology, &'a Increment, &'a Contact);
        let obstacles = self.world.query_mut::<(Entity, &Obstacle)>();
        let obstacles: SmallVec<[Entity; 8]> = obstacles.into_iter().map(|(entity, _)| entity).collect();
        for entity in obstacles {
            let known =
                self.world.get::<&mut FrictionState>(entity).ok().map(|mut friction| std::mem::take(&mut *friction));
            let is_known = known.is_some();
            let mut friction = known.unwrap_or_default();
            friction.forces.clear();
            if let Ok(obstacle) = self.world.get::<&Obstacle>(entity) {
                let obstacle_motion = self.world.get::<&ObstacleMotion>(entity).ok();
                let mut bodies = self.world.query::<Rubbed>();
                for (about, vertices, triangles, topology, increment, contact) in bodies.iter() {
                    let (moved, body) = ((&*obstacle, obstacle_motion.as_deref()), (vertices, triangles, topology));
                    let force = contact::friction_of(moved, contact, body, &increment.start);
                    if force != DVec3::ZERO {
                        friction.forces.push((about.order, force));
                    }
                }
            }
            if is_known || !friction.forces.is_empty() {
                // An obstacle that was just there.
                let _ = self.world.insert_one(entity, friction);
            }
        }
    }
}
