//! The course of a tear drawn by forceps, in the summary.

use rhexis_scene::course::CourseReport;
use rhexis_scene::score::Score;

/// Lines of the summary about a course.
pub(super) fn lines(course: &CourseReport) -> String {
    let outcome = match (course.diameter_mm, course.circularity, course.decentration_mm) {
        (Some(diameter), Some(circularity), Some(decentration)) => format!(
            "opening: diameter {diameter:.3} mm{}, circularity {circularity:.3}, {decentration:.3} mm off centre, largest radius {:.3} mm",
            course.diameter_as_it_lies_mm.map_or(String::new(), |lies| format!(" ({lies:.3} mm as it lies)")),
            course.largest_radius_mm
        ),
        _ if course.outcome == "ran_out" => {
            format!(
                "run out to the rim at {:.0}°, {:.3} mm from the axis",
                course.completion_deg, course.largest_radius_mm
            )
        }
        _ if course.outcome == "torn_off" => {
            format!("the flap has torn off from its inner end to the rim; {:.0}° passed", course.completion_deg)
        }
        _ => format!(
            "open: {:.0}° done, at most {:.3} mm from the axis",
            course.completion_deg, course.largest_radius_mm
        ),
    };
    let by_grasp: Vec<String> =
        course.force_by_grasp.iter().map(|grasp| format!("{:.1}", 1e3 * grasp.force_rms_n)).collect();
    let by_grasp = if by_grasp.len() > 1 { format!("; rms by grasp {}", by_grasp.join(", ")) } else { String::new() };
    let rim = match (course.spikes, course.optic_covered, course.optic_overlap_mm) {
        (Some(spikes), Some(covered), Some(overlap)) => format!(
            "\n    {spikes} spike(s), {:.0} % of the optic's edge covered, overlap at least {overlap:.3} mm",
            100.0 * covered
        ),
        _ => String::new(),
    };
    let score = course.score.as_ref().map_or(String::new(), |score| format!("\n    {}", score_line(score)));
    let tremor = course.tremor_mm.map_or(String::new(), |tremor| format!(", tremor {:.1} µm rms", 1e3 * tremor));
    let zonules = course.zonule_load_n.map_or(String::new(), |load| format!(", zonules up to {:.2} mN", 1e3 * load));
    format!(
        "    {outcome}{rim}\n    {} grasp(s) in {:.2} s, {:.2} mN rms, {:.2} mN peak{by_grasp}\n    {:.2} mN mean, {:.2} mN·s above the \
         limit, {:.2} mm of way{tremor}{zonules}{score}",
        course.grasps,
        1e-3 * course.time_ms,
        1e3 * course.force_rms_n,
        1e3 * course.force_peak_n,
        1e3 * course.force_mean_n,
        course.force_time_above_mn_s,
        course.tool_path_mm
    )
}

/// The line of a course's score.
fn score_line(score: &Score) -> String {
    let total = format!("score {:.0} of 100 (pass at {:.0})", score.total, score.pass);
    if let Some(failure) = score.failure {
        return format!("{total}: {failure}");
    }
    let points: Vec<String> =
        score.measures.iter().map(|row| format!("{} {:.0}", row.key.name(), row.points)).collect();
    format!("{total}: {}", points.join(", "))
}
