//! Required components, added at spawn, by `set` and after direct edits of the world.

use super::Look;
use super::check::filled;
use crate::components::*;
use crate::storage::{Tips, Triangles};
use crate::systems::bending::{BendingPasses, DihedralAngles};
use crate::systems::forces::relaxation::rest;
use crate::systems::fracture::{TearScratch, TipMemory};
use crate::systems::solver::{Factor, MixedSolver};
use hecs::{Component, Entity, EntityBuilder, World};

/// Something that can be given components.
pub(crate) trait Give: Look {
    /// Gives one, in place of any of its type.
    fn give<C: Component>(&mut self, component: C);

    /// Changes a component, if it is there.
    fn change<C: Component>(&mut self, change: impl FnOnce(&mut C));

    /// Gives an empty one, unless there is one.
    fn ensure<C: Component + Default>(&mut self) {
        if !self.has::<C>() {
            self.give(C::default());
        }
    }
}

impl Give for EntityBuilder {
    fn give<C: Component>(&mut self, component: C) {
        self.add(component);
    }

    fn change<C: Component>(&mut self, change: impl FnOnce(&mut C)) {
        if let Some(component) = self.get_mut::<&mut C>() {
            change(component);
        }
    }
}

/// An entity of a world.
struct Inside<'a> {
    world: &'a mut World,
    entity: Entity,
}

impl Look for Inside<'_> {
    fn look<C: Component, T>(&self, look: impl FnOnce(&C) -> T) -> Option<T> {
        self.world.get::<&C>(self.entity).ok().map(|component| look(&component))
    }
}

impl Give for Inside<'_> {
    fn give<C: Component>(&mut self, component: C) {
        // One that is gone needs nothing.
        let _ = self.world.insert_one(self.entity, component);
    }

    fn change<C: Component>(&mut self, change: impl FnOnce(&mut C)) {
        if let Ok(component) = self.world.query_one_mut::<&mut C>(self.entity) {
            change(component);
        }
    }
}

/// Completes an entity of a world, and takes off it the angles of a bending and the content of a compartment that it no longer has: solves would go on by
/// them.
pub(crate) fn complete_in(world: &mut World, entity: Entity) {
    if world.satisfies::<hecs::Without<&CompartmentState, &Compartment>>(entity) {
        let _ = world.remove_one::<CompartmentState>(entity);
    }
    complete(&mut Inside { world, entity });
    if world.satisfies::<hecs::Without<&DihedralAngles, &Bending>>(entity) {
        let _ = world.remove_one::<DihedralAngles>(entity);
        let _ = world.remove_one::<BendingPasses>(entity);
    }
}

/// Adds the required components of a body or an obstacle.
pub(crate) fn complete(entity: &mut impl Give) {
    if entity.has::<ObstaclePath>()
        && !entity.has::<ObstacleMotion>()
        && let Some(from) = entity.look(|obstacle: &Obstacle| obstacle.shape.clone())
    {
        entity.give(ObstacleMotion::at(from));
    }
    if !entity.has::<Body>() {
        return;
    }
    entity.ensure::<Frames>();
    entity.ensure::<Forces>();
    entity.ensure::<Increment>();
    entity.ensure::<SolveResult>();
    entity.ensure::<GuardLedger>();
    entity.ensure::<SolverScratch>();
    entity.ensure::<Factor>();
    entity.ensure::<MixedSolver>();
    entity.ensure::<TearLog>();
    entity.ensure::<TearScratch>();
    if entity.has::<Holds>() {
        entity.ensure::<Reactions>();
    }
    if entity.has::<Tearing>() {
        entity.ensure::<Tips>();
        entity.ensure::<TearDecisions>();
        entity.ensure::<TipMemory>();
    }
    if entity.has::<Refinement>() && !entity.has::<Refined>() {
        let start_count = entity.look(Triangles::len).unwrap_or(0);
        entity.give(Refined { start_count, ..Refined::default() });
    }
    if entity.has::<Bending>() {
        entity.ensure::<DihedralAngles>();
        entity.ensure::<BendingPasses>();
    }
    if let Some(contact) = entity.look(Contact::with_band).flatten() {
        entity.give(contact);
    }
    relax(entity);
    fill(entity);
    if entity.has::<Springs>() || entity.has::<Grips>() || entity.has::<Drag>() || entity.has::<Contact>() {
        entity.ensure::<ExternalStiffness>();
    }
}

/// Begins the content of a compartment, unless it has begun.
fn fill(entity: &mut impl Give) {
    if entity.has::<CompartmentState>() {
        return;
    }
    if let Some(state) = filled(entity) {
        entity.give(state);
    }
}

/// Gives a body that relaxes its history, and takes it off one that does not any more.
fn relax(entity: &mut impl Give) {
    let relaxation = entity.look(Relaxation::clone);
    if relaxation.is_none() && !entity.look(|triangles: &Triangles| triangles.relaxing.is_some()).unwrap_or(false) {
        return;
    }
    let unstretched = PreStretch::unstretched(entity.look(|held: &PreStretch| *held).as_ref());
    entity.change(|triangles: &mut Triangles| {
        let mut relaxing = triangles.relaxing.take().unwrap_or_default();
        if let Some(relaxation) = &relaxation {
            rest(&mut relaxing, triangles, relaxation, unstretched);
            triangles.relaxing = Some(relaxing);
        }
    });
}
