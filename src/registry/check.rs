//! Validation of entities: every component by its own check, then the rules between components.

use super::components;
use crate::components::check::{Check, Host};
use crate::components::*;
use crate::math::Sym2;
use crate::storage::{Tips, Topology, Triangles, Vertices};
use hecs::{Component, Entity, EntityBuilder, EntityRef, World};
use std::any::{Any, TypeId};

/// Why something that was written into the world, or is to be, is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{owner}: {source}")]
pub struct Rejected {
    /// The body, obstacle or tool.
    pub entity: Entity,
    /// Kind of the entity, and its name where it has one.
    pub(crate) owner: String,
    /// Component, its rejected value and the requirement.
    pub source: BodyError,
}

/// Something whose components can be looked at.
pub(crate) trait Look {
    /// Looks at a component, if it is there.
    fn look<C: Component, T>(&self, look: impl FnOnce(&C) -> T) -> Option<T>;

    /// Whether it is.
    fn has<C: Component>(&self) -> bool {
        self.look::<C, _>(|_| ()).is_some()
    }
}

impl Look for EntityBuilder {
    fn look<C: Component, T>(&self, look: impl FnOnce(&C) -> T) -> Option<T> {
        self.get::<&C>().map(look)
    }
}

impl Look for EntityRef<'_> {
    fn look<C: Component, T>(&self, look: impl FnOnce(&C) -> T) -> Option<T> {
        self.get::<&C>().map(|component| look(&component))
    }
}

/// An entity as it would be with another value of one component, or without it.
pub(crate) struct Changed<'a, P> {
    pub entity: EntityRef<'a>,
    pub to: Option<&'a P>,
}

impl<P: Component> Look for Changed<'_, P> {
    fn look<C: Component, T>(&self, look: impl FnOnce(&C) -> T) -> Option<T> {
        if TypeId::of::<C>() != TypeId::of::<P>() {
            return self.entity.look(look);
        }
        self.to.and_then(|to| (to as &dyn Any).downcast_ref::<C>()).map(look)
    }
}

/// Declares the walk over components that hosts may change.
macro_rules! walk {
    (
        parameter, saved, recorded { $($p:ident: $parameter:ty,)* }
        state, saved, recorded { $($t:ident: $tool:ty,)* }
        parameter, saved last, recorded { $($l:ident: $last:ty,)* }
        $($rest:tt)*
    ) => {
        /// Validates components that hosts may change, and the rules between components.
        pub(crate) fn check_changed(entity: &impl Look, host: &Host<'_>) -> Result<(), BodyError> {
            $( entity.look(|component: &$parameter| Check::check(component, host)).transpose()?; )*
            $( entity.look(|component: &$tool| Check::check(component, host)).transpose()?; )*
            $( entity.look(|component: &$last| Check::check(component, host)).transpose()?; )*
            check_rules(entity)
        }
    };
}
components!(walk);

/// Rules between the components of a body.
pub(crate) fn check_rules(body: &impl Look) -> Result<(), BodyError> {
    let refused = |what| BodyError::Contradiction { component: "Compartment", what };
    let rules = [
        (body.has::<Refinement>() && !body.has::<Tearing>(), BodyError::RefinementWithoutTearing),
        (body.has::<EnergyCriterion>() && !body.has::<Tearing>(), BodyError::EnergyCriterionWithoutTearing),
        (body.has::<HolzapfelGasserOgden>() && body.has::<StiffeningFibres>(), BodyError::TwoFibreLaws),
        (
            body.has::<Relaxation>() && (body.has::<HolzapfelGasserOgden>() || body.has::<StiffeningFibres>()),
            BodyError::RelaxationOfFibreLaw,
        ),
        (body.has::<Bending>() && body.has::<Planar>(), BodyError::BendingInPlane),
        (
            body.has::<Compartment>() && body.has::<Planar>(),
            refused("a planar body bounds no volume: let it leave its plane, or leave the compartment out"),
        ),
        (
            body.has::<Compartment>() && body.has::<Pressure>(),
            refused("`Pressure` is on the body too: leave that out, or give it as the pressure `outside`"),
        ),
        (
            body.has::<HolzapfelGasserOgden>() && body.look(Triangles::are_pre_stretched).unwrap_or(false),
            BodyError::PublishedLawPreStretched,
        ),
    ];
    rules.into_iter().find(|(is_broken, _)| *is_broken).map_or(Ok(()), |(_, error)| Err(error))?;
    check_holds(body)?;
    check_compartment(body)?;
    let held = body.look(|held: &PreStretch| held.strain).unwrap_or(Sym2::ZERO);
    body.look(|law: &HolzapfelGasserOgden| law.check_under(held)).unwrap_or(Ok(()))
}

/// Volume at which a compartment begins; one that is filled already has begun.
fn check_compartment(body: &impl Look) -> Result<(), BodyError> {
    if body.has::<CompartmentState>() {
        return Ok(());
    }
    filled(body).map_or(Ok(()), |state| check_volume(state.volume))
}

/// Content with which the compartment of a body begins; `None` without one.
pub(super) fn filled(body: &impl Look) -> Option<CompartmentState> {
    let state = body.look(|compartment: &Compartment| {
        body.look(|vertices: &Vertices| {
            body.look(|triangles: &Triangles| {
                body.look(|topology: &Topology| CompartmentState::new(compartment, (vertices, triangles, topology)))
            })
        })
    });
    state.flatten().flatten().flatten()
}

/// Rules between holds, their rotations and the axes they leave free.
fn check_holds(body: &impl Look) -> Result<(), BodyError> {
    let is_planar = body.has::<Planar>();
    let beside =
        |check: &dyn Fn(&Holds) -> Result<(), BodyError>| body.look(check).unwrap_or_else(|| check(&Holds::default()));
    body.look(|turns: &HoldTurns| beside(&|holds| turns.check_beside(holds, is_planar))).transpose()?;
    let guided = |guides: &HoldGuides| {
        let validate = |turns: Option<&HoldTurns>| beside(&|holds| guides.check_beside(holds, turns, is_planar));
        body.look(|turns: &HoldTurns| validate(Some(turns))).unwrap_or_else(|| validate(None))
    };
    body.look(guided).transpose().map(|_| ())
}

/// Validates an entity that may have been edited directly. One that is gone, or none of the engine's, passes.
pub(crate) fn validate(world: &World, entity: Entity) -> Result<(), Rejected> {
    let Ok(found) = world.entity(entity) else { return Ok(()) };
    with_host(found, |host| {
        check_tables(&found, host)?;
        found.look(|tips: &Tips| tips.check(host)).transpose()?;
        found.look(|forces: &StepForces| forces.check(host)).transpose()?;
        found.look(|obstacle_motion: &ObstacleMotion| obstacle_motion.check(host)).transpose()?;
        check_changed(&found, host)
    })
    .map_err(|source| Rejected { entity, owner: owner_of(found), source })
}

/// Judges all that hosts may change of every entity, and the rows that it names.
pub(crate) fn validate_all(world: &World) -> Result<(), Rejected> {
    world.iter().try_for_each(|found| {
        with_host(found, |host| check_changed(&found, host)).map_err(|source| {
            let entity = found.entity();
            Rejected { entity, owner: owner_of(found), source }
        })
    })
}

/// Judges the tables of a body alone: whether its triangles and their surroundings name rows that are there.
pub(crate) fn validate_tables(world: &World, entity: Entity) -> Result<(), Rejected> {
    let Ok(found) = world.entity(entity) else { return Ok(()) };
    with_host(found, |host| check_tables(&found, host)).map_err(|source| Rejected {
        entity,
        owner: owner_of(found),
        source,
    })
}

/// Tells of the mesh that an entity has.
pub(crate) fn with_host<T>(entity: EntityRef<'_>, validate: impl FnOnce(&Host<'_>) -> T) -> T {
    let (vertices, triangles) = (entity.get::<&Vertices>(), entity.get::<&Triangles>());
    let topology = entity.get::<&Topology>();
    validate(&Host::new(vertices.as_deref(), triangles.as_deref().zip(topology.as_deref())))
}

fn check_tables(entity: &impl Look, host: &Host<'_>) -> Result<(), BodyError> {
    entity.look(|vertices: &Vertices| vertices.check(host)).transpose()?;
    entity.look(|triangles: &Triangles| triangles.check(host)).transpose()?;
    entity.look(|topology: &Topology| topology.check(host)).transpose().map(|_| ())
}

/// Kind and name of an entity, for errors.
pub(crate) fn owner_of(entity: EntityRef<'_>) -> String {
    let body = || entity.look(|body: &Body| format!("body `{}`", body.name));
    let forceps = || entity.look(|forceps: &Forceps| format!("forceps `{}`", forceps.name));
    let blade = || entity.has::<Blade>().then(|| format!("blade {}", entity.entity().id()));
    let other = || format!("obstacle {}", entity.entity().id());
    body().or_else(forceps).or_else(blade).unwrap_or_else(other)
}
