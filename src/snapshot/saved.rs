//! One entity as a snapshot keeps it: the components that the registry lists as saved, and the solvers' memory.

use super::tail::Tail;
#[cfg(feature = "snapshot")]
use crate::components::check::{Check, Host};
use crate::components::*;
use crate::membrane::make_room;
#[cfg(feature = "snapshot")]
use crate::registry::check_rules;
use crate::registry::{Look, components};
use crate::storage::{Mesh, Tips, Topology, Triangles, Vertices};
use crate::systems::bending::{BendingPasses, DihedralAngles};
use crate::systems::forces::relaxation::rest;
use crate::systems::fracture::{TearScratch, TipMemory};
use crate::systems::solver::{Factor, FactorState, MixedSolver};
use hecs::{Component, Entity, EntityBuilder, EntityRef, World};
use std::any::{Any, TypeId};

/// Declares [`Saved`]. `kept` components are cloned; of `derived` ones it is kept whether they are there, and an empty one takes
/// their place: a step fills them.
macro_rules! saved {
    (
        parameter, saved, recorded { $($a:ident: $p:ty,)* }
        state, saved, recorded { $($b:ident: $q:ty,)* }
        parameter, saved last, recorded { $($last:ident: $late:ty,)* }
        state, saved last { $($later:ident: $latest:ty,)* }
        parameter, saved { $($c:ident: $r:ty,)* }
        state, saved { $($d:ident: $s:ty,)* }
        state, saved, of the last step { $($e:ident: $t:ty,)* }
        derived { $($derived:tt)* }
        state, remade { $($f:ident: $solver:ty,)* }
        derived, remade { $($g:ident: $other:ty,)* }
    ) => {
        saved! {
            kept { $($a: $p,)* $($b: $q,)* $($c: $r,)* $($d: $s,)* $($e: $t,)* }
            derived { $($derived)* }
            in part { $($solver,)* $($other,)* }
            last { $($last: $late,)* $($later: $latest,)* }
        }
    };
    (
        kept { $($name:ident: $kept:ty,)* }
        derived { $($flag:ident: $derived:ty,)* }
        in part { $($part:ty,)* }
        last { $($last:ident: $late:ty,)* }
    ) => {
        /// A body, an obstacle or a tool with all its components.
        #[derive(Clone)]
        #[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
        pub(crate) struct Saved {
            #[cfg_attr(feature = "snapshot", serde(with = "crate::storage::handle::bits"))]
            pub entity: Entity,
            $( pub $name: Option<$kept>, )*
            $( pub $flag: bool, )*
            /// Of a body: follows from its triangles.
            #[cfg_attr(feature = "snapshot", serde(skip))]
            pub topology: Option<Topology>,
            /// Result of a body's last solve, and the account of its guard.
            #[cfg_attr(feature = "snapshot", serde(with = "super::solve"))]
            pub solve: Option<(SolveResult, GuardLedger)>,
            #[cfg_attr(feature = "snapshot", serde(with = "super::factor"))]
            pub factor: Option<FactorState>,
            /// Memory of the solvers in mixed precision, and components that stand last.
            pub tail: Tail,
        }

        impl Saved {
            /// Saved state of an entity; `None` for one that is neither a body nor an obstacle nor a tool.
            pub(crate) fn of(entity: EntityRef<'_>) -> Option<Self> {
                if !is_ours(entity) {
                    return None;
                }
                let triangles = entity.get::<&Triangles>();
                Some(Self {
                    entity: entity.entity(),
                    $( $name: entity.get::<&$kept>().map(|component| (*component).clone()), )*
                    $( $flag: entity.has::<$derived>(), )*
                    topology: entity.get::<&Topology>().map(|topology| (*topology).clone()),
                    solve: entity
                        .get::<&SolveResult>()
                        .zip(entity.get::<&GuardLedger>())
                        .map(|(result, ledger)| ((*result).clone(), (*ledger).clone())),
                    factor: entity.get::<&Factor>().map(|factor| factor.state()),
                    tail: Tail {
                        creep: triangles
                            .as_ref()
                            .and_then(|triangles| triangles.relaxing.as_ref())
                            .map_or(Vec::new(), |relaxing| relaxing.creep.clone()),
                        $( $last: entity.get::<&$late>().map(|component| (*component).clone()), )*
                        mixed: entity
                            .get::<&MixedSolver>()
                            .zip(triangles)
                            .map(|(mixed, triangles)| mixed.state(&triangles)),
                    },
                })
            }

            /// Validates every component, and the conditions between them.
            #[cfg(feature = "snapshot")]
            pub(crate) fn check(&self, host: &Host<'_>) -> Result<(), BodyError> {
                $( if let Some(component) = &self.$name {
                    Check::check(component, host)?;
                } )*
                $( if let Some(component) = &self.tail.$last {
                    Check::check(component, host)?;
                } )*
                check_rules(self)
            }

            /// Components of the entity, except the solvers.
            pub(crate) fn into_components(mut self) -> EntityBuilder {
                if let Self {
                    tearing: Some(_), vertices: Some(vertices), triangles: Some(triangles), topology: Some(topology), ..
                } = &mut self
                {
                    make_room(Mesh { vertices, triangles, topology });
                }
                self.relax();
                let mut builder = EntityBuilder::new();
                $( if let Some(component) = self.tail.$last { builder.add(component); } )*
                $( if let Some(component) = self.$name { builder.add(component); } )*
                $( if self.$flag { builder.add(<$derived>::default()); } )*
                if self.has_folds {
                    builder.add(BendingPasses::default());
                }
                if let Some(topology) = self.topology {
                    builder.add(topology);
                }
                if let Some((result, ledger)) = self.solve {
                    builder.add(result).add(ledger).add(SolverScratch::default());
                }
                builder
            }
        }

        impl Look for Saved {
            fn look<C: Component, T>(&self, look: impl FnOnce(&C) -> T) -> Option<T> {
                $( if let Some(component) = &self.$name
                    && let Some(component) = (component as &dyn Any).downcast_ref::<C>()
                {
                    return Some(look(component));
                } )*
                $( if let Some(component) = &self.tail.$last
                    && let Some(component) = (component as &dyn Any).downcast_ref::<C>()
                {
                    return Some(look(component));
                } )*
                None
            }
        }

        /// Whether components of this type belong to the engine.
        fn is_known(id: TypeId) -> bool {
            let known = [
                $( TypeId::of::<$kept>(), )*
                $( TypeId::of::<$derived>(), )*
                $( TypeId::of::<$part>(), )*
                $( TypeId::of::<$late>(), )*
            ];
            known.contains(&id)
        }

        /// Leaves an entity with those components that are not the engine's; whether there are any.
        pub(crate) fn strip(world: &mut World, entity: Entity) -> bool {
            let has_others = |entity: EntityRef<'_>| entity.component_types().any(|id| !is_known(id));
            if !world.entity(entity).is_ok_and(has_others) {
                return false;
            }
            $( let _ = world.remove_one::<$kept>(entity); )*
            $( let _ = world.remove_one::<$derived>(entity); )*
            $( let _ = world.remove_one::<$part>(entity); )*
            $( let _ = world.remove_one::<$late>(entity); )*
            true
        }
    };
}

impl Saved {
    /// Gives the triangles of a body that relaxes their history.
    fn relax(&mut self) {
        let unstretched = PreStretch::unstretched(self.pre_stretch.as_ref());
        let (Some(triangles), Some(relaxation)) = (&mut self.triangles, &self.tail.relaxation) else { return };
        let mut relaxing = triangles.relaxing.take().unwrap_or_default();
        relaxing.creep.clone_from(&self.tail.creep);
        rest(&mut relaxing, triangles, relaxation, unstretched);
        triangles.relaxing = Some(relaxing);
    }
}

/// Whether an entity is a body, an obstacle or a tool.
pub(crate) fn is_ours(entity: EntityRef<'_>) -> bool {
    entity.has::<Body>() || entity.has::<Obstacle>() || entity.has::<Forceps>() || entity.has::<Blade>()
}

// The order of the registry is that of the bytes.
components!(saved);
