//! The plugin in apps without window and graphics.

mod bits;
mod common;
#[cfg(feature = "gizmos")]
mod gizmos;
mod life;
mod mesh;
mod obstacles;
mod readme;
mod time;
mod tools;
mod trainer;
