//! What a run writes: pictures and ParaView files.

pub mod picture;
pub mod vtu;
