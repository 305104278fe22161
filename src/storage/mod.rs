//! The mesh as tables of columns: keys at the border, rows inside.
//!
//! Three kinds of address: *which thing* is a `hecs::Entity` (a body, a tool, an obstacle), *which part of it* is a slotmap
//! key (stable for as long as the part lives), *where it is now* is a `u32` row. Public calls take keys, kernels rows.
//!
//! The mesh changes by edits only: an `Edit` is a value; `apply` refuses it or does it whole and gives the
//! `EditRecord` by which derived data `Follow` and `undo` goes back; the topology's `EditLog` tells which triangles
//! have changed since a moment; `validate` names the first broken invariant.
//!
//! Rows stay dense: where an edit removes one, the last row of the table moves into its place, and the record holds the removed
//! and the moved rows. Whoever keeps rows has to follow; a key names the same part before and after. The keys of removed
//! parts are kept free for [`undo`] until [`Mesh::release`].

mod apply;
mod attached;
mod closure;
mod draft;
mod edit;
mod edit_log;
mod follow_topology;
pub(crate) mod handle;
#[doc(hidden)]
pub mod measure;
pub(crate) mod mesh;
mod mesh_error;
mod order;
mod outlook;
mod record;
mod relaxing;
pub(crate) mod room;
mod rows;
mod table;
mod tables;
mod topology;
mod uniform;
mod validate;

#[doc(hidden)]
pub use apply::{Mesh, apply, undo};
pub use attached::{Attached, Attachment};
#[doc(hidden)]
pub use closure::Closure;
#[doc(hidden)]
pub use edit::{Edit, Refusal};
pub(crate) use edit_log::{EditLog, Revision};
pub use handle::{BladeId, BodyId, ForcepsId, ObstacleId};
pub use mesh::TriangleMesh;
pub use mesh_error::MeshError;
#[doc(hidden)]
pub use order::{Order, reorder, sort};
#[doc(hidden)]
pub use outlook::{Outlook, outlook};
pub use record::Parents;
#[doc(hidden)]
pub use record::{ChangedTriangle, EditRecord, Follow, NewTriangle, Removed, RemovedTriangle, Tables};
pub(crate) use relaxing::MOST_BRANCHES;
#[doc(hidden)]
pub use relaxing::Relaxing;
#[doc(hidden)]
pub use rows::Rows;
pub use tables::{TipKey, Tips, TriangleKey, Triangles, VertexKey, Vertices};
#[doc(hidden)]
pub use tables::{TipRow, TriangleRow, VertexRow};
pub use topology::Topology;
#[doc(hidden)]
pub use topology::{Fan, Incidence};
#[doc(hidden)]
pub use uniform::Uniform;
#[doc(hidden)]
pub use validate::{Broken, validate};

/// The row that stands for "none": no neighbour across an edge, no vertex.
pub const NONE: u32 = u32::MAX;
