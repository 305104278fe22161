//! What a reader must know before trusting the figures of a run.

use super::report::{BodyFigures, End, RefinementFigures, Sources};
use super::tally::Count;

/// The part of its largest term by which an energy balance may be off unreported: rounding and quadrature leave a thousandth at
/// most.
const MOST_IMBALANCE: f64 = 0.01;

/// The part of its largest term that forces may do as work that nothing exerts.
const MOST_UNBALANCED: f64 = 0.05;

/// A tear that waits at a criterion up to this has waited for less than the length of a triangle's edge or for a correction of the step.
const CLEAR: f64 = 1.05;

/// What a reader must know before trusting the figures.
pub(super) fn caveats(s: &Sources<'_>, bodies: &[BodyFigures]) -> Vec<String> {
    let t = s.tally;
    let mut list = Vec::new();
    let mut counted = |count: Count, what: &str| {
        if let Some(first) = count.first {
            list.push(format!("{} step(s), the first being step {first}: {what}", count.steps));
        }
    };
    counted(t.failed, "given up; the last good state stood");
    counted(t.unsolved, "the linear solve stopped above its tolerance (run.advanced.linear_iterations, run.budget)");
    counted(t.unconverged, "Newton's iteration stopped short of its tolerance");
    counted(t.fell_back, "the exact tangent was indefinite and the rotated one took its place");
    counted(t.late, "a linear solve stopped because its time was up: another run may give other figures");
    let most = t.most_relaxed;
    counted(
        t.relaxed,
        &format!("up to {most} vertices were relaxed locally: the linear solution would have gained energy"),
    );
    counted(t.vertices_projected, "vertices were put back outside an obstacle, where no solve had left them");
    counted(
        t.layers_held_back,
        &format!("up to {} vertices were held back, lest layers of a body pass through each other", t.most_held_back),
    );
    counted(
        t.layers_moved_as_one,
        "a body moved as one: keeping its layers apart had taken all that run.budget left, or too many of them were near",
    );
    counted(
        t.layers_overlapping,
        &format!(
            "layers of a body overlapped in up to {} pairs of triangles, which are left alone",
            t.most_overlapping
        ),
    );
    counted(
        t.cut_short,
        "a tear could have gone on when the step had used up run.max_tear_passes, run.budget or run.advanced.static_advances",
    );
    counted(t.tear_undecided, "a tear was decided on without a second solve (run.budget)");
    counted(
        t.hands_ahead,
        &format!("holds or jaws were up to {:.3} mm behind their hands: the step was limited", t.most_hand_ahead),
    );
    counted(
        t.release_unsettled,
        "corrector solves (five, or fewer by run.budget, the last perhaps shortened) did not bring the energy release at a tip to rest",
    );
    counted(
        t.traction_unsettled,
        "friction, rigid obstacles or bonds were off their laws after four rounds, or fewer by run.budget",
    );
    counted(t.refinement_put_off, "refinement was left to the next step (run.budget)");
    if t.rolled_back > 0 {
        list.push(format!("{} sub-step(s) were undone and retried in halves", t.rolled_back));
    }
    for body in bodies {
        list.extend(body.guard.caveat(&body.name, t.steps));
        list.extend(body.mesh.doubts().into_iter().map(|doubt| format!("{}: {doubt}", body.name)));
        if let Some(part) = body.relative_imbalance.filter(|&part| part > MOST_IMBALANCE) {
            let what = "of its largest term: some force or edit of this run is not accounted for (balance_mj)";
            list.push(format!("{}: the energy balance is off by {:.2} % {what}", body.name, 100.0 * part));
        }
        if let Some(part) = body.relative_unbalanced.filter(|&part| part > MOST_UNBALANCED) {
            let what = "of the energy balance's largest term is work of forces that no tissue exerts: bodies went only a part of their way, \
                        or vertices were put back outside an obstacle; take a smaller run.dt";
            list.push(format!("{}: {:.1} % {what}", body.name, 100.0 * part));
        }
        let Some(tear) = &body.tear else { continue };
        if tear.held_back_criterion > CLEAR {
            list.push(format!(
                "{}: tears were held back to the speed of Rayleigh waves in {} step(s), largest criterion {:.3}: a load that is faster than the material's waves",
                body.name, tear.held_back_steps, tear.held_back_criterion
            ));
        }
        if let Some(steps) = tear.nucleations_blocked.filter(|&steps| steps > 0) {
            list.push(format!(
                "{}: in {steps} step(s) the stress reached the strength where no tear started: opening it would have released less than the \
                 toughness (events.jsonl says where)",
                body.name
            ));
        }
        if tear.refusals > 0 {
            list.push(format!(
                "{}: {} advance(s) were refused by the mesh (events.jsonl says why)",
                body.name, tear.refusals
            ));
        }
        if tear.ambiguous > 0 {
            let what = "had a runner-up within 5 %: another run could have gone the other way (`ambiguous` lists them)";
            list.push(format!("{}: {} start(s) or advance(s) {what}", body.name, tear.ambiguous));
        }
        if tear.held_shut > 0 {
            let what = "torn vertices are kept shut by a hold or grip that has hold of both lips";
            list.push(format!("{}: {} {what}", body.name, tear.held_shut));
        }
        if let Some(refinement) = tear.refinement.as_ref().filter(|refinement| refinement.budget_hits > 0) {
            let RefinementFigures { budget_hits, most_triangles_added: most, .. } = refinement;
            let left = tear.edges_per_radius.map_or(String::new(), |edges| format!(": R has only {edges:.2} edges"));
            list.push(format!(
                "{}: the budget of {most} more triangles ended {budget_hits} refinement(s){left}",
                body.name
            ));
        }
        if let Some(edges) = tear.edges_per_radius.filter(|&edges| edges < 3.0) {
            let what = "edges per averaging radius at a tip: under 3 the tear load depends on the mesh";
            list.push(format!("{}: only {edges:.2} {what}", body.name));
        }
    }
    if let End::Failed(reason) = &s.end {
        list.push(format!("the run ended early: {reason}"));
    }
    list
}
