//! What the crates of this workspace share with the engine. It is no part of the public interface and may change in any version.

pub use crate::generate::{Random, bounded, length};
pub use crate::snapshot::hash::sum as fingerprint;
pub use crate::storage::mesh::{THINNEST, by_corners, slenderness};

/// Reading files that a user names.
pub mod source {
    pub use crate::source::read;
}

/// The state of a run as bytes and as a file.
#[cfg(feature = "snapshot")]
pub mod bytes {
    pub use crate::snapshot::bytes::{Kind, pack, read, replace, unpack};
}
