//! Scenes: mesh generators, mesh files, scene files and the catalog.

pub mod generate;
pub mod mesh_file;
