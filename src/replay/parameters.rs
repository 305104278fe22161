//! What a host may change of a body or an obstacle between two calls: its parameters, and where its vertices are.

use crate::components::*;
use crate::storage::Vertices;
use glam::DVec3;
use hecs::{Entity, World};

/// Declares [`Parameters`].
macro_rules! parameters {
    ($($name:ident: $component:ty,)*) => {
        /// The parameters of an entity, or those of them that have changed: outer `None` where one has not, inner where it is gone.
        #[derive(Clone, Default)]
        #[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
        pub(crate) struct Parameters {
            $( $name: Option<Option<$component>>, )*
            /// Positions and velocities.
            motion: Option<(Vec<DVec3>, Vec<DVec3>)>,
        }

        impl Parameters {
            /// Those of an entity as it is.
            pub fn of(world: &World, entity: Entity) -> Self {
                let motion = world.get::<&Vertices>(entity).ok();
                Self {
                    $( $name: Some(world.get::<&$component>(entity).ok().map(|component| (*component).clone())), )*
                    motion: motion.map(|vertices| (vertices.position.clone(), vertices.velocity.clone())),
                }
            }

            /// Those that differ from what they were; `None` where none does.
            pub fn since(mut self, before: &Self) -> Option<Self> {
                let mut is_any = false;
                $( if self.$name == before.$name { self.$name = None } else { is_any = true } )*
                if self.motion == before.motion { self.motion = None } else { is_any = true }
                is_any.then_some(self)
            }

            /// Gives them to an entity. An entity that is gone has none.
            pub fn give(&self, world: &mut World, entity: Entity) {
                $( match &self.$name {
                    Some(Some(component)) => _ = world.insert_one(entity, component.clone()),
                    Some(None) => _ = world.remove_one::<$component>(entity),
                    None => {}
                } )*
                if let (Some((position, velocity)), Ok(vertices)) = (&self.motion, world.query_one_mut::<&mut Vertices>(entity))
                    && position.len() == vertices.len() && velocity.len() == vertices.len()
                {
                    vertices.position.copy_from_slice(position);
                    vertices.velocity.copy_from_slice(velocity);
                }
            }
        }
    };
}

parameters! {
    holds: Holds,
    springs: Springs,
    grips: Grips,
    point_loads: PointLoads,
    edge_loads: EdgeLoads,
    damping: Damping,
    gravity: Gravity,
    pressure: Pressure,
    drag: Drag,
    pre_stretch: PreStretch,
    stiffening_fibres: StiffeningFibres,
    contact: Contact,
    bending: Bending,
    obstacle: Obstacle,
    obstacle_path: ObstaclePath,
    forceps: Forceps,
    blade: Blade,
    tearing: Tearing,
    energy_criterion: EnergyCriterion,
    refinement: Refinement,
    sleeping: Sleeping,
    holzapfel_gasser_ogden: HolzapfelGasserOgden,
}
