//! Writing files, whole or not at all, and why one could not be written.

mod error;
pub mod file;

pub use error::OutputError;
