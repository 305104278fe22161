//! The bodies of a scene, every copy by itself.

use super::build::own_name;
use super::error::Fault;
use super::schema::BodySpec;

/// The most copies of a body.
const MOST_COPIES: u32 = 10_000;

/// The bodies, every copy by itself under a name of its own, each with its path in the file.
pub(super) fn bodies(specs: &[BodySpec]) -> Result<Vec<(String, BodySpec)>, Fault> {
    let mut bodies: Vec<(String, BodySpec)> = Vec::new();
    for (i, spec) in specs.iter().enumerate() {
        let key = format!("bodies.{i}");
        if !(1..=MOST_COPIES).contains(&spec.copies) {
            let what = format!("{} is no number of copies", spec.copies);
            return Err(Fault::new(format!("{key}.copies"), what, format!("give 1 to {MOST_COPIES}")));
        }
        for copy in 1..=spec.copies {
            let name = if spec.copies == 1 { spec.name.clone() } else { format!("{}-{copy}", spec.name) };
            own_name(&name, bodies.iter().map(|(_, other)| other.name.as_str()), &key)?;
            bodies.push((key.clone(), BodySpec { name, ..spec.clone() }));
        }
    }
    Ok(bodies)
}
