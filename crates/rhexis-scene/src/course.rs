//! The course of a tear drawn by forceps, with the keys that it has in `report.json`, on the page and in Python.

use crate::measures::{GraspFigures, Outcome, TearCourse};
use crate::score::{Score, Scoring};
use serde::Serialize;

/// The course of a tear about an axis; figures as [`CourseFigures`](crate::measures::CourseFigures) defines them.
#[derive(Clone, Debug, Serialize)]
pub struct CourseReport {
    /// `"closed"`, `"ran_out"`, `"torn_off"` or `"unfinished"`.
    pub outcome: &'static str,
    /// Angle about the axis that cuts and tips have passed \[°\].
    pub completion_deg: f64,
    /// Mean diameter of the opening at rest \[mm\]; absent unless the tear has closed, as the next four.
    pub diameter_mm: Option<f64>,
    /// Mean diameter of its outline in space as it closed \[mm\].
    pub diameter_as_it_lies_mm: Option<f64>,
    /// Circularity of that outline.
    pub circularity_as_it_lies: Option<f64>,
    /// Circularity at rest.
    pub circularity: Option<f64>,
    /// Way from the axis to the opening's middle \[mm\].
    pub decentration_mm: Option<f64>,
    /// From the axis to the farthest point \[mm\].
    pub largest_radius_mm: f64,
    /// Jaws closed.
    pub grasps: u32,
    /// Time from the beginning to the tear's end \[ms\].
    pub time_ms: f64,
    /// Root mean square of the force at closed jaws \[N\].
    pub force_rms_n: f64,
    /// Its peak \[N\].
    pub force_peak_n: f64,
    /// Mean of the force at closed jaws \[N\].
    pub force_mean_n: f64,
    /// Force × time above the limit, 9 mN unless a scoring says otherwise \[mN·s\].
    pub force_time_above_mn_s: f64,
    /// Way of closed jaws \[mm\].
    pub tool_path_mm: f64,
    /// Tremor of closed jaws, RMS above 2 Hz \[mm\]; absent where no grasp has lasted for a second.
    pub tremor_mm: Option<f64>,
    /// Largest sideways sum of the forces of the springs to ground \[N\]; absent without such springs.
    pub zonule_load_n: Option<f64>,
    /// Spikes of the opening at rest; absent unless the tear has closed, as the next two.
    pub spikes: Option<u32>,
    /// Part of an optic's edge that the capsule covers; the optic has 6 mm unless a scoring says otherwise.
    pub optic_covered: Option<f64>,
    /// Smallest overlap of the capsule with that optic \[mm\], negative where its edge is bare.
    pub optic_overlap_mm: Option<f64>,
    /// One row per grasp.
    pub force_by_grasp: Vec<GraspReport>,
    /// Score; absent without a scoring.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub score: Option<Score>,
}

/// The force of one grasp; figures as [`GraspFigures`] defines them.
#[derive(Clone, Debug, Serialize)]
pub struct GraspReport {
    /// End of its first step \[ms\].
    pub from_ms: f64,
    /// End of its last step \[ms\].
    pub until_ms: f64,
    /// Mean \[N\].
    pub force_mean_n: f64,
    /// Root mean square \[N\].
    pub force_rms_n: f64,
    /// Peak \[N\].
    pub force_peak_n: f64,
}

impl GraspReport {
    fn of(grasp: &GraspFigures) -> Self {
        Self {
            from_ms: grasp.from,
            until_ms: grasp.until,
            force_mean_n: grasp.force_mean,
            force_rms_n: grasp.force_rms,
            force_peak_n: grasp.force_peak,
        }
    }
}

impl CourseReport {
    /// The figures of a course as they stand.
    pub fn of(course: &TearCourse) -> Self {
        let figures = course.figures();
        let (opening, lies) = (figures.opening.as_ref(), figures.opening_as_it_lies.as_ref());
        Self {
            outcome: match figures.outcome {
                Outcome::Closed => "closed",
                Outcome::RanOut => "ran_out",
                Outcome::TornOff => "torn_off",
                Outcome::Unfinished => "unfinished",
            },
            completion_deg: figures.completion.to_degrees(),
            diameter_mm: opening.map(|o| o.diameter),
            diameter_as_it_lies_mm: lies.map(|o| o.diameter),
            circularity_as_it_lies: lies.map(|o| o.circularity),
            circularity: opening.map(|o| o.circularity),
            decentration_mm: opening.map(|o| o.decentration),
            largest_radius_mm: opening.map_or(figures.largest_radius, |o| o.largest_radius),
            grasps: figures.grasps,
            time_ms: figures.time,
            force_rms_n: figures.force_rms,
            force_peak_n: figures.force_peak,
            force_mean_n: figures.force_mean,
            force_time_above_mn_s: figures.force_time_above,
            tool_path_mm: figures.tool_path,
            tremor_mm: figures.tremor,
            zonule_load_n: figures.zonule_load,
            spikes: figures.spikes,
            optic_covered: figures.optic.map(|optic| optic.covered),
            optic_overlap_mm: figures.optic.map(|optic| optic.smallest),
            force_by_grasp: course.grasps().iter().map(GraspReport::of).collect(),
            score: None,
        }
    }

    /// The figures of a course as they stand, with their score.
    pub fn scored(course: &TearCourse, scoring: &Scoring) -> Self {
        let report = Self::of(course);
        Self { score: Some(scoring.score(&report)), ..report }
    }
}
