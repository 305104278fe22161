//! What a run writes for the eye: pictures and ParaView files.
//!
//! Every file is first written beside its place and then renamed, so a reader (or an interrupted run) never meets half a
//! file.

mod corners;
pub mod gltf;
pub mod picture;
pub mod pvd;
mod shape;
pub mod surface;
pub mod vtu;
pub mod vtu_read;

pub use gltf::write_gltf;
pub use picture::{PictureSettings, View, render};
pub use pvd::PvdWriter;
pub use rhexis_scene::output::OutputError;
pub(crate) use rhexis_scene::output::file;
pub use surface::{write_obj, write_ply};
pub use vtu::{write_solids, write_vtu};
pub use vtu_read::{VtuError, read_solids, read_vtu};
