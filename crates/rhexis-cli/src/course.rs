//! The course of a tear drawn by forceps, in the report and the summary.

use rhexis::report::{GraspFigures, Outcome, TearCourse};
use serde::Serialize;

/// Figures as [`CourseFigures`](rhexis::report::CourseFigures) defines them.
#[derive(Serialize)]
pub(super) struct CourseReport {
    /// `"closed"`, `"ran_out"`, `"torn_off"` or `"unfinished"`.
    pub outcome: &'static str,
    pub completion_deg: f64,
    /// Absent unless the tear has closed, as the next four.
    pub diameter_mm: Option<f64>,
    /// Of the outline in space as it closed.
    pub diameter_as_it_lies_mm: Option<f64>,
    pub circularity_as_it_lies: Option<f64>,
    pub circularity: Option<f64>,
    pub decentration_mm: Option<f64>,
    /// Of the outline where the tear has closed, else of the way of the tips.
    pub largest_radius_mm: f64,
    pub grasps: u32,
    pub time_ms: f64,
    pub force_rms_n: f64,
    pub force_peak_n: f64,
    /// One row per grasp.
    pub force_by_grasp: Vec<GraspReport>,
}

/// Figures as [`GraspFigures`] defines them.
#[derive(Serialize)]
pub(super) struct GraspReport {
    pub from_ms: f64,
    pub until_ms: f64,
    pub force_mean_n: f64,
    pub force_rms_n: f64,
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
    pub(crate) fn of(course: &TearCourse) -> Self {
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
            force_by_grasp: course.grasps().iter().map(GraspReport::of).collect(),
        }
    }

    /// Its lines in the summary.
    pub(crate) fn summary(&self) -> String {
        let outcome = match (self.diameter_mm, self.circularity, self.decentration_mm) {
            (Some(diameter), Some(circularity), Some(decentration)) => format!(
                "opening: diameter {diameter:.3} mm{}, circularity {circularity:.3}, {decentration:.3} mm off centre, largest radius {:.3} mm",
                self.diameter_as_it_lies_mm.map_or(String::new(), |lies| format!(" ({lies:.3} mm as it lies)")),
                self.largest_radius_mm
            ),
            _ if self.outcome == "ran_out" => {
                format!(
                    "run out to the rim at {:.0}°, {:.3} mm from the axis",
                    self.completion_deg, self.largest_radius_mm
                )
            }
            _ if self.outcome == "torn_off" => {
                format!("the flap has torn off from its inner end to the rim; {:.0}° passed", self.completion_deg)
            }
            _ => format!(
                "open: {:.0}° done, at most {:.3} mm from the axis",
                self.completion_deg, self.largest_radius_mm
            ),
        };
        let by_grasp: Vec<String> =
            self.force_by_grasp.iter().map(|grasp| format!("{:.1}", 1e3 * grasp.force_rms_n)).collect();
        let by_grasp =
            if by_grasp.len() > 1 { format!("; rms by grasp {}", by_grasp.join(", ")) } else { String::new() };
        format!(
            "    {outcome}\n    {} grasp(s) in {:.2} s, {:.2} mN rms, {:.2} mN peak{by_grasp}",
            self.grasps,
            1e-3 * self.time_ms,
            1e3 * self.force_rms_n,
            1e3 * self.force_peak_n
        )
    }
}
