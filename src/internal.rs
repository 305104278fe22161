//! Items that the crates of this workspace share with the engine. It is no part of the public interface and may change in any version.

pub use crate::generate::{Random, bounded, length};
pub use crate::snapshot::hash::sum as fingerprint;
pub use crate::storage::mesh::{THINNEST, by_corners, slenderness};

/// Whether this build has sparse Cholesky factors. A crate's own feature `direct` does not tell: another crate of the same build may
/// have asked for them.
pub const HAS_FACTORS: bool = cfg!(feature = "direct");

/// A simulation with one sheet of 10 mm, held at its left rim, which tears and notes its changes: the start of examples in the docs.
///
/// # Errors
/// None: the sheet is sound.
pub fn example() -> crate::Result<(crate::simulation::Simulation, crate::storage::BodyId)> {
    use crate::prelude::{Changes, Hold, Material, Membrane, Settings, Simulation, Tearing};
    let sheet = Membrane::new("sheet", crate::generate::grid(10.0, 10.0, 8, 8)?, Material::allard_2009());
    let hold = Hold::new("left", sheet.select(|p| p.x == 0.0));
    let mut simulation = Simulation::new(Settings { threads: 1, ..Settings::default() })?;
    let body = simulation.spawn(sheet.hold(hold).with(Tearing::default()).with(Changes::default()))?;
    Ok((simulation, body))
}

/// Reading files that a user names.
pub mod source {
    pub use crate::source::{Sources, open, read};
}

/// The state of a run as bytes and as a file.
#[cfg(feature = "snapshot")]
pub mod bytes {
    pub use crate::snapshot::bytes::{Kind, pack, read, replace, unpack};
}
