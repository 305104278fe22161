//! Parameters set on entities of the world and removed from them: the one validated way.

use super::Simulation;
use crate::components::check::Owner;
use crate::components::{Blade, Body, Forceps, Obstacle};
use crate::event::WokenBy;
use crate::registry::{
    Changed, Parameter, ParameterVisitor, Parameters, Rejected, check_rules, complete_in, owner_of, with_host,
};
use crate::replay::Input;
use hecs::{Entity, EntityRef};

/// Why a component was not set or taken off; nothing has changed then.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SetError {
    /// The entity is gone.
    #[error("there is no such body, obstacle or tool")]
    NoSuchEntity,
    /// The component belongs to another kind of entity.
    #[error("{owner}: {component} belongs to {needs}")]
    AnotherOwner {
        /// Kind of the entity.
        owner: String,
        /// The component.
        component: &'static str,
        /// Kind of entity that the component belongs to.
        needs: &'static str,
    },
    /// Without it the entity would be nothing.
    #[error("{owner}: {component} stays as long as the entity does: despawn it instead")]
    Irremovable {
        /// Kind of the entity.
        owner: String,
        /// The component.
        component: &'static str,
    },
    /// Rejected component: its numbers or rows, or a contradiction with another.
    #[error(transparent)]
    Rejected(#[from] Rejected),
}

impl Simulation {
    /// Gives a body, an obstacle or a tool a component, in place of the one that it has: loads, springs, material laws beside the
    /// tissue's own, a criterion, a shape. Required components come with it, and a body that sleeps is woken.
    ///
    /// ```
    /// use rhexis::components::{Gravity, Material, PointLoad, PointLoads, Curve};
    /// use rhexis::{membrane::Membrane, settings::Settings, simulation::Simulation, storage::TriangleMesh};
    /// use glam::DVec3;
    /// let positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
    /// let mesh = TriangleMesh { positions, triangles: vec![[0, 1, 2]], ..TriangleMesh::default() };
    /// let mut simulation = Simulation::new(Settings::default())?;
    /// let body = simulation.spawn(Membrane::new("sheet", mesh, Material::allard_2009()))?;
    /// simulation.set(body, Gravity { acceleration: DVec3::NEG_Z * 9.81e-3 })?;
    /// let load = PointLoad { rows: vec![7], force: DVec3::Z, curve: Curve::constant(1.0) };
    /// let error = simulation.set(body, PointLoads { groups: vec![load] }).unwrap_err();
    /// assert_eq!(error.to_string(), "body `sheet`: PointLoads: load 0 names vertex 7, but the mesh has 3 vertices");
    /// simulation.unset::<Gravity>(body)?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// For an entity that is gone or of another kind, a number out of range, a row or edge that is not there, and a value that contradicts
    /// another component; nothing has changed then.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// simulation.set(body, Gravity { acceleration: DVec3::new(0.0, -9.81e-3, 0.0) })?;
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn set<C: Parameter>(&mut self, entity: impl Into<Entity>, component: C) -> Result<(), SetError> {
        let entity = entity.into();
        self.note(|| Input::Set { entity, to: C::change(Some(component.clone())).into() });
        let found = self.owner::<C>(entity)?;
        let judged = with_host(found, |host| {
            component.check(host).and_then(|()| check_rules(&Changed { entity: found, to: Some(&component) }))
        });
        judged.map_err(|source| Rejected { entity, owner: owner_of(found), source })?;
        let before = self.audited_energies(entity.into());
        // It is there.
        let _ = self.world.insert_one(entity, component);
        complete_in(&mut self.world, entity);
        self.note_edited_energies(entity.into(), before);
        self.wake_by(entity, WokenBy::Caller);
        Ok(())
    }

    /// Takes a component off a body or an obstacle; whether it was there. A body that sleeps is woken.
    ///
    /// # Errors
    /// For an entity that is gone or of another kind, for the defining component of an obstacle or a tool, and for one that another
    /// component needs; nothing has changed then.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// simulation.set(body, Damping { time: 1.0 })?;
    /// assert!(simulation.unset::<Damping>(body)?);
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn unset<C: Parameter>(&mut self, entity: impl Into<Entity>) -> Result<bool, SetError> {
        let entity = entity.into();
        self.note(|| Input::Set { entity, to: C::change(None).into() });
        let found = self.owner::<C>(entity)?;
        let without = Changed::<C> { entity: found, to: None };
        check_rules(&without).map_err(|source| Rejected { entity, owner: owner_of(found), source })?;
        let is_itself = C::OWNER != Owner::Body && C::NAME != "ObstaclePath";
        if is_itself {
            return Err(SetError::Irremovable { owner: owner_of(found), component: C::NAME });
        }
        let before = self.audited_energies(entity.into());
        let was_there = self.world.remove_one::<C>(entity).is_ok();
        complete_in(&mut self.world, entity);
        self.note_edited_energies(entity.into(), before);
        self.wake_by(entity, WokenBy::Caller);
        Ok(was_there)
    }

    /// The entity, if it is one that carries such components.
    fn owner<C: Parameter>(&self, entity: Entity) -> Result<EntityRef<'_>, SetError> {
        let found = self.world.entity(entity).map_err(|_| SetError::NoSuchEntity)?;
        let (is_right, needs) = match C::OWNER {
            Owner::Body => (found.has::<Body>(), "a body"),
            Owner::Obstacle => (found.has::<Obstacle>(), "an obstacle"),
            Owner::Forceps => (found.has::<Forceps>(), "forceps"),
            Owner::Blade => (found.has::<Blade>(), "a blade"),
        };
        let other = || SetError::AnotherOwner { owner: owner_of(found), component: C::NAME, needs };
        is_right.then_some(found).ok_or_else(other)
    }

    /// Sets recorded parameters again.
    pub(super) fn set_again(&mut self, entity: Entity, to: &Parameters) {
        to.visit(&mut Again { simulation: self, entity });
    }
}

/// An entity whose changes are repeated.
struct Again<'a> {
    simulation: &'a mut Simulation,
    entity: Entity,
}

impl ParameterVisitor for Again<'_> {
    fn set<C: Parameter>(&mut self, to: &C) {
        // A set refused in the recording is refused again.
        let _ = self.simulation.set(self.entity, to.clone());
    }

    fn unset<C: Parameter>(&mut self) {
        let _ = self.simulation.unset::<C>(self.entity);
    }
}
