//! From `[[probes]]` to points and sections of bodies.

use super::build::{direction, own_names};
use super::error::{Fault, positive};
use super::schema::{ProbeSpec, SectionSpec};
use glam::DVec3;
use rhexis::simulation::Section;
use rhexis::storage::BodyId;

/// Part of the tissue that is read after every step.
#[derive(Clone, Debug)]
pub struct Probe {
    /// Name of its columns.
    pub name: String,
    /// Body of the probe.
    pub body: BodyId,
    /// Quantity that is read.
    pub kind: ProbeKind,
}

/// Quantity that a probe reads.
#[derive(Clone, Copy, Debug)]
pub enum ProbeKind {
    /// Place and stress at a point of the rest shape \[mm\].
    Point(DVec3),
    /// Force across a plane.
    Section(Section),
}

/// The probes of a scene on bodies of these names.
pub(super) fn of(specs: &[ProbeSpec], bodies: &[BodyId], names: &[String]) -> Result<Vec<Probe>, Fault> {
    let keys = (0..specs.len()).map(|i| format!("probes.{i}"));
    own_names(keys.clone().zip(specs.iter().map(|spec| spec.name.clone())))?;
    let probe = |(key, spec): (String, &ProbeSpec)| {
        let place = match &spec.body {
            Some(name) => names.iter().position(|own| own == name),
            None => (bodies.len() == 1).then_some(0),
        };
        let place = place.ok_or_else(|| {
            let what = match &spec.body {
                Some(name) => format!("there is no body `{name}`"),
                None => format!("there are {} bodies, and the probe names none", bodies.len()),
            };
            Fault::new(format!("{key}.body"), what, format!("give one of {}", names.join(", ")))
        })?;
        let kind = match spec.section {
            None => ProbeKind::Point(spec.point.0),
            Some(SectionSpec { normal, radius }) => ProbeKind::Section(Section {
                point: spec.point.0,
                normal: direction(normal.0, &format!("{key}.section.normal"))?,
                radius: radius.map_or(Ok(f64::INFINITY), |r| positive(format!("{key}.section.radius"), r, "mm"))?,
            }),
        };
        Ok(Probe { name: spec.name.clone(), body: bodies[place], kind })
    };
    keys.zip(specs).map(probe).collect()
}
