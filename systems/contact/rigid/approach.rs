//! The way of a rigid obstacle to its first touch with tissue.

use super::couple::rigid_ones;
use super::{rotation, settle_place};
use crate::components::{Contact, Obstacle, ObstacleMotion, RigidStep, Shape, SolveResult};
use crate::storage::{Triangles, Vertices};
use crate::systems::StepContext;
use crate::systems::contact::deepest::{at, deepest};
use crate::systems::contact::travel::Travel;
use crate::systems::contact::{faces, held};
use crate::systems::context::Formula;
use glam::{DMat3, DVec3};
use hecs::World;

/// Part of its way by which an obstacle may begin beyond the first touch.
const TOUCH: f64 = 1e-3;

/// Moves rigid obstacles that touch nothing on their way without tissue, up to where they first touch it: beyond they would meet vertices
/// that they will not touch, and draw them along.
pub(in crate::systems::contact) fn approach(world: &mut World, step: &StepContext) {
    if step.is_static || step.formula == Formula::Start {
        return;
    }
    for (_, entity, ..) in rigid_ones(world) {
        let Ok((obstacle, motion)) = world.query_one_mut::<(&mut Obstacle, &mut ObstacleMotion)>(entity) else {
            continue;
        };
        let Some(mut under_way) = motion.under_way.take_if(|under_way| under_way.waits()) else { continue };
        let obstacle = obstacle.clone();
        let time = step.stage_dt();
        let place_at = |part: f64| {
            let expected = under_way.expected.map(|way| way * (1.0 - part));
            let rest = RigidStep { expected, ..(*under_way).clone() };
            let (mut obstacle, mut motion) = (obstacle.clone(), ObstacleMotion::at(obstacle.shape.clone()));
            settle_place(&mut obstacle, &mut motion, &rest, time, |_| true);
            obstacle.shape
        };
        let way = Way { from: obstacle.shape.clone(), to: place_at(1.0), turn: rotation(-under_way.expected[1]) };
        let mut part = 1.0;
        type Query<'a> = (&'a Vertices, &'a Triangles, &'a Contact, &'a SolveResult);
        let mut query = world.query::<Query>();
        for (vertices, triangles, _, _) in query.iter() {
            part = way.first_touch(&place_at, (vertices, triangles), part);
        }
        drop(query);
        under_way.expected = under_way.expected.map(|way| way * (1.0 - part));
        let Ok((obstacle, motion)) = world.query_one_mut::<(&mut Obstacle, &mut ObstacleMotion)>(entity) else {
            continue;
        };
        settle_place(obstacle, motion, &under_way, time, |_| true);
        motion.under_way = Some(under_way);
    }
}

/// Whether an obstacle waits for tissue that it has left in the last solve.
pub(in crate::systems::contact) fn any_waits(world: &mut World) -> bool {
    let mut motions = world.query_mut::<&ObstacleMotion>().into_iter().filter_map(|motion| motion.under_way.as_ref());
    motions.any(|under_way| under_way.waits())
}

impl RigidStep {
    /// Whether it touches nothing and has not gone all its way.
    fn waits(&self) -> bool {
        self.deviations.is_empty() && self.expected != [DVec3::ZERO; 2]
    }
}

/// The way of an obstacle that has still to be gone.
struct Way {
    from: Shape,
    to: Shape,
    turn: DMat3,
}

impl Way {
    /// The part of the way at which the obstacle has just touched a body, if that is less than `part`.
    fn first_touch(
        &self,
        place_at: &impl Fn(f64) -> Shape,
        (vertices, triangles): (&Vertices, &Triangles),
        mut part: f64,
    ) -> f64 {
        let Self { from, to, turn } = self;
        let x = &vertices.position;
        let travel =
            Travel { offset: to.anchor() - from.anchor(), turn: Some((*turn, from.anchor())), ..Travel::default() };
        let moved = (Obstacle { shape: to.clone() }, travel);
        let mut look = |is_inside: &dyn Fn(&Shape) -> bool| {
            if !is_inside(&place_at(part)) {
                return;
            }
            let mut low = 0.0;
            if is_inside(from) {
                part = 0.0;
            }
            while part - low > TOUCH {
                let middle = 0.5 * (low + part);
                if is_inside(&place_at(middle)) { part = middle } else { low = middle }
            }
        };
        for &x in x {
            if held(&moved, x, x).is_some() {
                look(&|shape| shape.distance(x).is_some_and(|(distance, _)| distance < 0.0));
            }
        }
        faces::for_held(&moved, x, (&x[..], triangles), |t, _| {
            let corners = triangles.corners[t].map(|v| x[v as usize]);
            look(&|shape| {
                let place = deepest(shape, corners).map(|weights| at(corners, weights));
                place.and_then(|x| shape.distance(x)).is_some_and(|(distance, _)| distance < 0.0)
            });
        });
        part
    }
}
