//! What a run prints at its end.

use super::account::AccountReport;
use super::course;
use super::report::{End, RunReport, WhileTearing};

/// The few lines at the end.
pub(super) fn summary(report: &RunReport) -> String {
    let end = match &report.end {
        End::Running => "running",
        End::Interrupted => "interrupted (--resume goes on)",
        End::Done => "done",
        End::TornThrough => "torn through",
        End::TearEnded => "the tear has ended",
        End::Failed(_) => "FAILED",
    };
    let mut lines = vec![format!(
        "{}: {end} after {} of {} steps, {:.6} ms simulated in {:.2} s ({:.3} × real time)",
        report.scene,
        report.steps,
        report.steps_planned,
        report.simulated_ms,
        report.stepping_s,
        report.real_time_factor
    )];
    for body in &report.bodies {
        lines.push(format!(
            "  {}: {} triangles, elastic {:.6} mJ, kinetic {:.3e} mJ",
            body.name, body.triangles, body.elastic_mj, body.kinetic_mj
        ));
        for r in &body.reactions {
            // Adding zero turns a rounded −0 into 0.
            let [x, y, z] = r.force_n.map(|f| (f * 1e6).round() * 1e-6 + 0.0);
            let torque = r.torque_nmm.map_or(String::new(), |[x, y, z]| format!("; {x:.6}, {y:.6}, {z:.6} N·mm"));
            lines.push(format!("    {}: {x:.6}, {y:.6}, {z:.6} N{torque}", r.name));
            lines.extend(r.while_tearing.as_ref().map(while_tearing));
        }
        for grip in body.grips.iter().filter(|grip| grip.peak_n > 0.0) {
            let (rms, peak) = (1e3 * grip.rms_n, 1e3 * grip.peak_n);
            lines.push(format!("    {}: {rms:.2} mN rms, {peak:.2} mN peak", grip.name));
            lines.extend(grip.while_tearing.as_ref().map(while_tearing));
        }
        lines.extend(body.course.as_ref().map(course::lines));
        if let Some(bed) = &body.bed {
            let coarse = match bed.resolved {
                resolved if resolved < 0.999 => {
                    format!("; strength down to {:.0} % of the one given, which the mesh resolves", 100.0 * resolved)
                }
                _ => String::new(),
            };
            let (off, area, energy) = (bed.off_mm2, bed.area_mm2, bed.energy_mj);
            lines.push(format!("    bed: {off:.3} of {area:.3} mm² off, {energy:.6} mJ taken{coarse}"));
        }
        if let Some(own) = &body.compartment {
            let (volume, pressure, leaked, opening) =
                (own.volume_mm3, own.pressure_mpa, own.leaked_mm3, own.opening_mm2);
            lines.push(format!(
                "    compartment: {volume:.3} mm³ at {pressure:.6} MPa, {leaked:.3} mm³ leaked, openings of {opening:.4} mm²"
            ));
        }
        if let Some(tear) = &body.tear {
            lines.push(format!(
                "    torn {:.3} mm in {} advances, {} tip(s) left, {} ended, {} fragment(s) free",
                tear.length_mm,
                tear.advances,
                tear.tips.len(),
                tear.ended,
                tear.fragments_freed
            ));
            lines.extend(tear.account.iter().flat_map(AccountReport::summary));
            if let Some(refinement) = &tear.refinement {
                lines.push(format!(
                    "    refined by {} splits, coarsened by {} vertices; {} triangles more than at the start and torn, {} allowed",
                    refinement.splits,
                    refinement.vertices_removed,
                    refinement.triangles_added,
                    refinement.most_triangles_added
                ));
            }
        }
    }
    for obstacle in &report.obstacles {
        let [x, y, z] = obstacle.force_n.map(|f| (f * 1e6).round() * 1e-6 + 0.0);
        lines.push(format!("  {}: {x:.6}, {y:.6}, {z:.6} N", obstacle.name));
    }
    lines.extend(report.cuts.iter().filter(|cut| cut.refused.is_none()).map(|cut| format!("  {cut}")));
    lines.extend(report.caveats.iter().map(|caveat| format!("  note: {caveat}")));
    lines.join("\n")
}

/// The line of a hand's force while it tears.
fn while_tearing(force: &WhileTearing) -> String {
    let [mean, low, high, jump, before] =
        [force.mean_n, force.p10_n, force.p90_n, force.largest_jump_n, force.before_advances_n]
            .map(|force| 1e3 * force);
    format!(
        "      while it tears: mean {mean:.3} mN (10 to 90 % of {} steps: {low:.3} to {high:.3}), {before:.3} before advances, \
         largest jump {jump:.3}",
        force.steps
    )
}
