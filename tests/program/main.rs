//! The program around the engine: command line, scenes, mesh files, pictures, verification, faults;
//! and what the README says of it.

mod bench;
mod bodies;
mod cli;
mod dump;
mod faults;
mod guards;
mod mesh_files;
mod output;
mod readme;
mod scenes;
mod stability;
mod stress;
mod verify;
