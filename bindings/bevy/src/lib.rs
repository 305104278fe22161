//! Tissues that tear in Bevy: the plugin of the engine [`rhexis`].
//!
//! ```
//! use bevy::prelude::{App, Commands, Startup, TaskPoolPlugin, TransformPlugin, Transform};
//! use bevy::time::TimePlugin;
//! use bevy_rhexis::rhexis::prelude::*;
//! use bevy_rhexis::{Forceps, RhexisPlugin, Tissue};
//!
//! let mut app = App::new();
//! app.add_plugins((TaskPoolPlugin::default(), TimePlugin, TransformPlugin, RhexisPlugin::default()));
//! app.add_systems(Startup, |mut commands: Commands| {
//!     let Ok(mesh) = generate::disc(5.0, 200) else { return };
//!     commands.spawn(Tissue::new(Membrane::new("capsule", mesh, Material::allard_2009()).with(Tearing::default())));
//!     let jaws = Jaws { radius: 0.5, ..Jaws::default() };
//!     commands.spawn((Forceps { is_closed: true, ..Forceps::new(jaws, 1.0) }, Transform::from_xyz(1.0, 0.0, 0.2)));
//! });
//! app.update();
//! ```
//!
//! A [`Tissue`] is a membrane of the engine shown by a mesh; [`Forceps`] and [`Pins`] follow the transforms of their entities. What
//! happens comes as messages: [`TissueEvent`], [`TissueGone`], [`RhexisError`]. All else are calls of the engine, through
//! [`RhexisWorld`]; [`ShownObstacles`] shows the engine's obstacles. Units are the engine's: mm, g, ms, hence N and MPa.

mod forceps;
#[cfg(feature = "gizmos")]
mod gizmos;
mod mesh;
mod message;
mod obstacles;
mod pins;
mod plugin;
mod space;
mod step;
mod tissue;
mod world;

pub use forceps::{Forceps, ForcepsState};
#[cfg(feature = "gizmos")]
pub use gizmos::{RhexisGizmoGroup, RhexisGizmos, material_forces};
pub use mesh::MeshUpdates;
pub use message::{Cause, RhexisError, TissueEvent, TissueGone};
pub use obstacles::{ShownObstacle, ShownObstacles};
pub use pins::{Pins, PinsState};
pub use plugin::{RhexisPlugin, RhexisSystems};
pub use rhexis;
pub use space::Space;
pub use tissue::{Tissue, TissueBody};
pub use world::RhexisWorld;
