//! The program around the engine: command line, scenes, mesh files, pictures, verification, faults;
//! and what the README says of it.

mod bench;
mod bodies;
mod cli;
mod decorated;
mod dump;
mod faults;
mod files_from_anywhere;
mod guards;
mod mesh_files;
mod output;
mod overrides;
mod plots;
mod readme;
mod renders;
mod scene_keys;
mod scenes;
mod slips;
mod stability;
mod stress;
mod sweeps;
mod told;
mod turns;
mod verify;
mod view;
mod vtu;
