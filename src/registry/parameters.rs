//! Changes that a host may make to a body or an obstacle between two calls: its parameters, and its vertex positions.

use super::{Parameter, components, sealed};
use crate::components::*;
use crate::storage::Vertices;
use glam::DVec3;
use hecs::{Entity, World};

/// A receiver of changes, one by one.
pub trait ParameterVisitor {
    /// A component has another value.
    fn set<C: Parameter>(&mut self, to: &C);

    /// A component is gone.
    fn unset<C: Parameter>(&mut self);
}

/// Declares [`Parameters`].
macro_rules! parameters {
    (
        parameter, saved, recorded { $($p:ident: $parameter:ty,)* }
        state, saved, recorded { $($t:ident: $tool:ty,)* }
        $($rest:tt)*
    ) => {
        parameters! { $($p: $parameter,)* $($t: $tool,)* }
    };
    ($($name:ident: $component:ty,)*) => {
        /// The parameters of an entity, or those of them that have changed: outer `None` where one has not, inner where it is gone.
        #[derive(Clone, Default)]
        #[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
        pub struct Parameters {
            $( $name: Option<Option<$component>>, )*
            /// Positions and velocities.
            motion: Option<(Vec<DVec3>, Vec<DVec3>)>,
        }

        impl Parameters {
            /// Parameters of an entity as it is.
            pub fn of(world: &World, entity: Entity) -> Self {
                let motion = world.get::<&Vertices>(entity).ok();
                Self {
                    $( $name: Some(world.get::<&$component>(entity).ok().map(|component| (*component).clone())), )*
                    motion: motion.map(|vertices| (vertices.position.clone(), vertices.velocity.clone())),
                }
            }

            /// Parameters that differ from those before; `None` where none does.
            pub fn since(mut self, before: &Self) -> Option<Self> {
                let mut is_any = false;
                $( if self.$name == before.$name { self.$name = None } else { is_any = true } )*
                if self.motion == before.motion { self.motion = None } else { is_any = true }
                is_any.then_some(self)
            }

            /// Tells of each.
            pub fn visit(&self, visitor: &mut impl ParameterVisitor) {
                $( match &self.$name {
                    Some(Some(component)) => visitor.set(component),
                    Some(None) => visitor.unset::<$component>(),
                    None => {}
                } )*
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

        $(
            impl sealed::Listed for $component {
                fn change(to: Option<Self>) -> Parameters {
                    Parameters { $name: Some(to), ..Parameters::default() }
                }
            }

            impl Parameter for $component {
                const NAME: &'static str = stringify!($component);
            }
        )*
    };
}
components!(parameters);
