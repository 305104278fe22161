//! What the library is: version, features, build.

use crate::pointer::Out;
use crate::status::{Failure, RhexisStatus, call};
use std::ffi::c_char;

/// Version of this interface: a library of another one is refused by `rhexis_check_abi`.
pub const RHEXIS_ABI_VERSION: u32 = 1;

/// Feature bit: snapshots and recordings have a form as bytes.
pub const RHEXIS_FEATURE_BYTES: u64 = 1;
/// Feature bit: panics are caught at the boundary. Not of a library built with `panic = "abort"`.
pub const RHEXIS_FEATURE_UNWIND: u64 = 2;
/// Feature bit: the engine has sparse Cholesky factors (`--features direct`). Recordings of builds without the bit are refused.
pub const RHEXIS_FEATURE_DIRECT: u64 = 4;

/// How the library was built.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct RhexisBuildInfo {
    /// `RHEXIS_ABI_VERSION` of the library.
    pub abi_version: u32,
    /// Bits of a pointer.
    pub pointer_bits: u32,
    /// Feature bits.
    pub features: u64,
    /// Version of the engine, such as "0.1.0". Valid for ever.
    pub version: *const c_char,
    /// Not 0: assertions of a debug build are on.
    pub is_debug: u8,
}

/// The version of the package as text for C.
const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), "\0");

fn features() -> u64 {
    let unwind = if cfg!(panic = "unwind") { RHEXIS_FEATURE_UNWIND } else { 0 };
    let direct = if rhexis::internal::HAS_FACTORS { RHEXIS_FEATURE_DIRECT } else { 0 };
    RHEXIS_FEATURE_BYTES | unwind | direct
}

/// Tells whether header and library fit: call it first, as `rhexis_check_abi(RHEXIS_ABI_VERSION, 0)`, or with the feature bits that the
/// host relies on.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_check_abi(abi_version: u32, features_needed: u64) -> RhexisStatus {
    call(|| {
        let missing = features_needed & !features();
        let message = match (abi_version == RHEXIS_ABI_VERSION, missing) {
            (true, 0) => return Ok(()),
            (true, _) => {
                let remedy = match missing {
                    RHEXIS_FEATURE_DIRECT => "build it with `--features direct`",
                    RHEXIS_FEATURE_UNWIND => "build it without `panic = \"abort\"`",
                    _ => "take a library that has them",
                };
                format!("the library lacks the features {missing:#x} of {features_needed:#x}: {remedy}")
            }
            (false, _) => format!(
                "the header has version {abi_version} of the interface, the library {RHEXIS_ABI_VERSION}: build the host with the \
                 library's header"
            ),
        };
        Err(Failure::new(RhexisStatus::AbiMismatch, message))
    })
}

/// Tells how the library was built.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_build_info(info: Out<RhexisBuildInfo>) -> RhexisStatus {
    call(|| {
        info.check("info")?;
        info.write(RhexisBuildInfo {
            abi_version: RHEXIS_ABI_VERSION,
            pointer_bits: usize::BITS,
            features: features(),
            version: VERSION.as_ptr().cast(),
            is_debug: u8::from(cfg!(debug_assertions)),
        });
        Ok(())
    })
}
