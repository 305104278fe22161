//! The C interface of the membrane-tearing engine `rhexis`; `include/rhexis.h` is generated from this crate.
//!
//! Objects are named by handles of 64 bits; every call answers a [`RhexisStatus`](status::RhexisStatus) and keeps a message on failure. No
//! panic crosses the boundary, and a world that two threads use at once answers one of them that it is busy. `README.md` beside the
//! sources has the rules for threads and the life of what is lent.

#![allow(
    unsafe_code,
    reason = "a C interface exports symbols and looks behind pointers: only `pointer.rs` does the latter"
)]
#![deny(clippy::undocumented_unsafe_blocks, unsafe_op_in_unsafe_fn)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods, unreachable_pub))]
#![cfg_attr(not(test), warn(clippy::expect_used, clippy::panic, clippy::unreachable, clippy::unwrap_used))]

pub mod abi;
pub mod body;
pub mod component;
pub mod events;
mod handle;
pub mod haptics;
pub mod pins;
pub mod pointer;
pub mod saved;
pub mod shown;
pub mod status;
mod toml_form;
pub mod tools;
pub mod types;
pub mod world;
