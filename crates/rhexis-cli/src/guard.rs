//! What the energy guard did over a run.

use super::tally::Count;
use rhexis::report::{BodyReport, GuardCause, GuardPlace};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Share of the steps, limited, above which forces and tears of a run are not to be trusted.
const MOST_LIMITED: f64 = 0.02;

/// What the guard did to one body.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub(super) struct GuardTally {
    /// Steps with an attempt that was undone.
    pub refused: Count,
    /// Steps with an answer that was limited.
    pub limited: Count,
    /// Attempts that were solved further from where they led, by cause.
    #[serde(default)]
    pub corrected_by_cause: BTreeMap<String, u64>,
    /// Attempts that were undone, by cause.
    pub refused_by_cause: BTreeMap<String, u64>,
    /// Parts of steps whose answer was limited, by cause.
    pub limited_by_cause: BTreeMap<String, u64>,
    /// Parts of steps in which a few vertices were relaxed locally, by cause.
    #[serde(default)]
    pub relaxed_by_cause: BTreeMap<String, u64>,
    /// Most vertices limited in one part of a step.
    pub largest_limited_vertices: u32,
    /// Vertices of the body in that step.
    pub vertices_then: usize,
    /// The place of the first action of the guard.
    pub first: Option<Place>,
    /// The place where the largest amount of energy would have been created.
    pub largest: Option<Place>,
}

/// A place where the guard acted.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(super) struct Place {
    pub step: u64,
    pub cause: String,
    pub triangle: Option<u32>,
    pub vertex: Option<u32>,
    /// In the rest shape.
    pub at_mm: [f64; 3],
    /// What the attempt would have created.
    pub energy_mj: f64,
}

impl Place {
    fn of(step: u64, place: &GuardPlace) -> Self {
        let GuardPlace { cause, triangle, vertex, at, energy } = *place;
        Self { step, cause: cause.to_string(), triangle, vertex, at_mm: at.to_array(), energy_mj: energy }
    }
}

impl GuardTally {
    /// Adds what the guard did in a step of the run.
    pub(crate) fn add(&mut self, step: u64, body: &BodyReport) {
        let guard = &body.guard;
        self.refused.note(guard.refusals() > 0, step);
        self.limited.note(guard.limitations() > 0, step);
        let counts = [
            (&mut self.corrected_by_cause, &guard.corrected),
            (&mut self.refused_by_cause, &guard.refused),
            (&mut self.limited_by_cause, &guard.limited),
            (&mut self.relaxed_by_cause, &guard.relaxed),
        ];
        for (counts, by_cause) in counts {
            for (cause, count) in GuardCause::ALL.iter().zip(by_cause).filter(|(_, count)| **count > 0) {
                *counts.entry(cause.to_string()).or_default() += u64::from(*count);
            }
        }
        if guard.limited_vertices > self.largest_limited_vertices {
            (self.largest_limited_vertices, self.vertices_then) = (guard.limited_vertices, body.vertex_count);
        }
        let Some(first) = &guard.first else { return };
        self.first.get_or_insert_with(|| Place::of(step, first));
        if self.largest.as_ref().is_none_or(|largest| first.energy > largest.energy_mj) {
            self.largest = Some(Place::of(step, first));
        }
    }

    /// What a reader must know of a body of this name, in a run of so many steps.
    pub(crate) fn caveat(&self, name: &str, steps: u64) -> Option<String> {
        let listed = |counts: &BTreeMap<String, u64>| {
            let counts: Vec<String> = counts.iter().map(|(cause, count)| format!("{cause} {count}")).collect();
            counts.join(", ")
        };
        let share = |count: Count| count.steps as f64 / steps.max(1) as f64;
        let first = self.first.as_ref().map_or(String::new(), |place| {
            let [x, y, z] = place.at_mm;
            format!("first in step {} at ({x:.3}, {y:.3}, {z:.3}) mm, {:.2e} mJ", place.step, place.energy_mj)
        });
        if self.limited.first.is_none() {
            if self.refused.first.is_none() {
                let causes = listed(&self.relaxed_by_cause);
                return (!causes.is_empty()).then(|| format!("{name}: few vertices relaxed ({causes}); {first}"));
            }
            let (part, causes) = (100.0 * share(self.refused), listed(&self.refused_by_cause));
            let steps_refused = self.refused.steps;
            return Some(format!("{name}: {steps_refused} step(s), {part:.1} %, retried in parts ({causes}); {first}"));
        }
        let part = share(self.limited);
        let trust = if part > MOST_LIMITED {
            format!(
                "; above {:.0} % forces and tears of this run are not to be trusted: take a smaller run.dt, or bending",
                100.0 * MOST_LIMITED
            )
        } else {
            String::new()
        };
        Some(format!(
            "{name}: the motion was limited in {} of {steps} step(s), {:.1} %, up to {} of {} vertices ({}); {first}{trust}",
            self.limited.steps,
            100.0 * part,
            self.largest_limited_vertices,
            self.vertices_then,
            listed(&self.limited_by_cause)
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    fn tally(limited: u64) -> GuardTally {
        let place = Place {
            step: 7,
            cause: "membrane".into(),
            triangle: Some(3),
            vertex: None,
            at_mm: [1.0; 3],
            energy_mj: 2e-3,
        };
        GuardTally {
            refused: Count { steps: limited + 1, first: Some(7) },
            limited: Count { steps: limited, first: (limited > 0).then_some(8) },
            corrected_by_cause: BTreeMap::new(),
            refused_by_cause: BTreeMap::from([("membrane".into(), limited + 1)]),
            limited_by_cause: BTreeMap::from([("membrane".into(), limited)]),
            relaxed_by_cause: BTreeMap::new(),
            largest_limited_vertices: 12,
            vertices_then: 100,
            first: Some(place),
            largest: None,
        }
    }

    #[test]
    fn a_caveat_says_when_forces_are_not_to_be_trusted() {
        assert_eq!(GuardTally::default().caveat("sheet", 100), None);
        let [retried, few, many] = [0, 2, 3].map(|limited| tally(limited).caveat("sheet", 100).unwrap());
        assert!(retried.contains("1 step(s), 1.0 %") && !retried.contains("trusted"), "{retried}");
        assert!(few.contains("in 2 of 100 step(s)") && few.contains("12 of 100 vertices"), "{few}");
        assert!(!few.contains("trusted") && many.contains("not to be trusted"), "{few}\n{many}");
    }
}
