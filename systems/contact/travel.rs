//! Obstacles at the end of the step, and their ways to there.

use crate::components::{Obstacle, ObstacleMotion};
use glam::{DMat3, DVec3};
use hecs::{Entity, World};
use smallvec::SmallVec;

/// An obstacle at the end of the step, and how it has come there.
pub(super) type Moved = (Obstacle, Travel);

/// The rigid motion of an obstacle in a step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Travel {
    /// Displacement of its anchor \[mm\].
    pub(super) offset: DVec3,
    /// Rotation of the obstacle, and the start position of its anchor \[mm\].
    pub(super) turn: Option<(DMat3, DVec3)>,
    /// Whether tissue moves the obstacle, and whether several bodies have in this step.
    pub(super) is_rigid: bool,
    pub(super) is_shared: bool,
}

impl Travel {
    /// Motion of an obstacle since the start of the step.
    fn of(obstacle: &Obstacle, obstacle_motion: Option<&ObstacleMotion>) -> Self {
        obstacle_motion.map_or(Self::default(), |obstacle_motion| {
            let anchor = obstacle_motion.from.anchor();
            Self {
                offset: obstacle.shape.anchor() - anchor,
                turn: obstacle_motion.turn.map(|turn| (turn, anchor)),
                is_rigid: obstacle_motion.rigid.is_some(),
                is_shared: obstacle_motion.under_way.as_ref().is_some_and(|under_way| under_way.deviations.len() > 1),
            }
        })
    }

    /// The way of a point against the obstacle that was at `start` and is at `x`.
    pub(super) fn slip(&self, start: DVec3, x: DVec3) -> DVec3 {
        match self.turn {
            None => x - start - self.offset,
            Some(_) => x - self.carry(start),
        }
    }

    /// Position at the end of the step of a point that goes with the obstacle.
    pub(super) fn carry(&self, start: DVec3) -> DVec3 {
        match self.turn {
            None => start + self.offset,
            Some((turn, anchor)) => turn * (start - anchor) + anchor + self.offset,
        }
    }

    /// A direction that goes with the obstacle.
    pub(super) fn turned(&self, u: DVec3) -> DVec3 {
        self.turn.map_or(u, |(turn, _)| turn * u)
    }

    pub(super) fn is_none(&self) -> bool {
        self.offset == DVec3::ZERO && self.turn.is_none()
    }
}

/// Obstacles in the order of their handles, whatever components they have beside.
pub(super) type Obstacles = SmallVec<[(Entity, Moved); 8]>;

/// The obstacles of a world.
pub(super) fn obstacles(world: &mut World) -> Obstacles {
    let travel = |(entity, obstacle, obstacle_motion): (Entity, &Obstacle, Option<&ObstacleMotion>)| {
        (entity, (obstacle.clone(), Travel::of(obstacle, obstacle_motion)))
    };
    let found = world.query_mut::<(Entity, &Obstacle, Option<&ObstacleMotion>)>();
    let mut obstacles: Obstacles = found.into_iter().map(travel).collect();
    obstacles.sort_unstable_by_key(|(entity, _)| *entity);
    obstacles
}
