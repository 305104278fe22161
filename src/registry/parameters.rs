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

/// Positions and velocities of a body.
type Motion = (Vec<DVec3>, Vec<DVec3>);

/// End of the bytes. The first two forms are those of an option, as bytes were before a component stood last; the third and the fourth those
/// before a second one did.
#[cfg(feature = "snapshot")]
#[derive(serde::Serialize, serde::Deserialize)]
enum Tail<M, L, K> {
    None,
    Motion(M),
    Last(L),
    Both(M, L),
    All(Option<M>, Option<L>, K),
}

/// Declares [`Parameters`].
macro_rules! parameters {
    (
        parameter, saved, recorded { $($p:ident: $parameter:ty,)* }
        state, saved, recorded { $($t:ident: $tool:ty,)* }
        parameter, saved last, recorded { $last:ident: $late:ty, $later:ident: $latest:ty, }
        $($rest:tt)*
    ) => {
        parameters! { last $last: $late, $later: $latest, $($p: $parameter,)* $($t: $tool,)* }
    };
    (last $last:ident: $late:ty, $later:ident: $latest:ty, $($name:ident: $component:ty,)*) => {
        /// The parameters of an entity, or those of them that have changed: outer `None` where one has not, inner where it is gone.
        #[derive(Clone, Default)]
        pub struct Parameters {
            $( $name: Option<Option<$component>>, )*
            $last: Option<Option<$late>>,
            $later: Option<Option<$latest>>,
            /// Positions and velocities.
            motion: Option<Motion>,
        }

        /// Form of bytes: `motion` and the components that stand last are the tail.
        #[cfg(feature = "snapshot")]
        mod form {
            use super::*;
            use serde::{Deserialize, Deserializer, Serialize, Serializer};

            #[derive(Serialize)]
            struct Written<'a> {
                $( $name: &'a Option<Option<$component>>, )*
                tail: Tail<&'a Motion, &'a Option<$late>, &'a Option<$latest>>,
            }

            #[derive(Deserialize)]
            struct Read {
                $( $name: Option<Option<$component>>, )*
                tail: Tail<Motion, Option<$late>, Option<$latest>>,
            }

            impl Serialize for Parameters {
                fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
                    let tail = match (self.motion.as_ref(), self.$last.as_ref(), self.$later.as_ref()) {
                        (None, None, None) => Tail::None,
                        (Some(motion), None, None) => Tail::Motion(motion),
                        (None, Some(last), None) => Tail::Last(last),
                        (Some(motion), Some(last), None) => Tail::Both(motion, last),
                        (motion, last, Some(later)) => Tail::All(motion, last, later),
                    };
                    Written { $( $name: &self.$name, )* tail }.serialize(to)
                }
            }

            impl<'de> Deserialize<'de> for Parameters {
                fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
                    let Read { $( $name, )* tail } = Read::deserialize(from)?;
                    let (motion, $last, $later) = match tail {
                        Tail::None => (None, None, None),
                        Tail::Motion(motion) => (Some(motion), None, None),
                        Tail::Last(last) => (None, Some(last), None),
                        Tail::Both(motion, last) => (Some(motion), Some(last), None),
                        Tail::All(motion, last, later) => (motion, last, Some(later)),
                    };
                    Ok(Self { $( $name, )* $last, $later, motion })
                }
            }
        }

        parameters! { all $( $name: $component, )* $last: $late, $later: $latest, }
    };
    (all $($name:ident: $component:ty,)*) => {

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
