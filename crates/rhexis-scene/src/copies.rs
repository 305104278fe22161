//! The bodies of a scene, every copy by itself.

use super::build::own_names;
use super::error::Fault;
use super::schema::BodySpec;

/// The names of a body's copies.
pub(super) fn names(spec: &BodySpec) -> impl Iterator<Item = String> {
    (1..=spec.copies).map(|copy| if spec.copies == 1 { spec.name.clone() } else { format!("{}-{copy}", spec.name) })
}

/// Whether every copy of every body has a name of its own.
pub(super) fn check_names(specs: &[BodySpec]) -> Result<(), Fault> {
    let all = specs.iter().enumerate();
    own_names(all.flat_map(|(i, spec)| names(spec).map(move |name| (format!("bodies.{i}"), name))))
}
