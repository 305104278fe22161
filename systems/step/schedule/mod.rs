//! The systems of the step as one list on one screen; their loops are those of [`phases`](super::phases).

mod own;

pub use crate::systems::context::{Formula, StepContext};
pub use own::{BadPlace, Place, Schedule};

use crate::systems;
use hecs::World;

/// When a system runs within a step; [`PHASES`](super::phases::PHASES) has the order of the stages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Stage {
    /// Once, before anything moves.
    Begin,
    /// Each time the step is resumed after tears have advanced.
    Resume,
    /// Forces and tangent: before every solve, and once at the start of a step of two stages.
    Evaluate,
    /// Once, on the forces at the start of a step of two stages.
    Start,
    /// Once, between the two stages of a step.
    SecondStage,
    /// The linear solve on the evaluated forces and tangent, its energy guard and time integration.
    Solve,
    /// Convergence count of Newton's method: the bodies that need another iteration.
    Unconverged,
    /// Bodies that the energy guard sends to a Newton correction: marked and counted; all others are done.
    Uncorrected,
    /// Ends the iterations of a linearly implicit solve.
    Solved,
    /// Energy check of Newton's and of two-stage steps, once per pass; linearly implicit solves are checked in [`Solve`](Self::Solve).
    Judge,
    /// Selects and counts the bodies of which a solve has carried a vertex deep into an obstacle, or through it.
    Penetrating,
    /// Selects and counts the bodies whose friction is far from its law in the answer.
    Slipping,
    /// Notes and counts the bodies whose friction or bonds are still far from their laws after the rounds of friction.
    Unsettled,
    /// Depenetration where the rounds of contact are used up and a vertex is still deep in an obstacle.
    Depenetrate,
    /// Clamp against tunnelling: after contact in each pass, and after the corrector solve.
    PreventTunnelling,
    /// The criterion on the state that the iterations have reached; once more after a corrector solve.
    Decide,
    /// Selects and counts the bodies whose tips will advance in this step.
    Advancing,
    /// Each time the iterations have ended for good.
    Account,
    /// Tears by the decisions of the criterion.
    Tear,
    /// Counts the bodies whose tips may advance further in the step.
    Unfinished,
}

/// A system and its place.
#[derive(Clone, Copy, Debug)]
pub struct System {
    /// Name in reports.
    pub name: &'static str,
    /// When it runs.
    pub stage: Stage,
    /// The function; returns the number of bodies it ran on.
    pub run: fn(&mut World, &StepContext) -> usize,
}

const fn system(name: &'static str, stage: Stage, run: fn(&mut World, &StepContext) -> usize) -> System {
    System { name, stage, run }
}

/// All systems by stage: the order holds within a stage, [`PHASES`](super::phases::PHASES) orders the stages.
pub const STEP: &[System] = &[
    system("obstacles", Stage::Begin, systems::contact::move_obstacles),
    system("sleep: wake", Stage::Begin, systems::step::sleep::wake),
    system("bodies: groups", Stage::Begin, systems::contact::layers::find_groups),
    system("participants", Stage::Begin, systems::step::integrate::begin),
    system("energy audit: begin", Stage::Begin, systems::guard::audit::begin),
    system("refine", Stage::Begin, systems::fracture::topology::refine::refine),
    system("energy audit: refined", Stage::Begin, systems::guard::audit::refined),
    system("grip: take", Stage::Begin, systems::tools::grip::take),
    system("hold", Stage::Begin, systems::step::integrate::hold),
    system("refine further", Stage::Resume, systems::fracture::topology::refine::refine),
    system("energy audit: refined further", Stage::Resume, systems::guard::audit::edits),
    system("resume", Stage::Resume, systems::step::integrate::resume),
    system("relaxation", Stage::Evaluate, systems::forces::relaxation::relaxation),
    system("corotation", Stage::Evaluate, systems::forces::corotation::corotation),
    system("assembly", Stage::Evaluate, systems::forces::assembly::assembly),
    system("bending", Stage::Evaluate, systems::bending::bending),
    system("energy guard: begin", Stage::Evaluate, systems::guard::nonlinear::begin),
    system("energy audit: membrane", Stage::Evaluate, systems::guard::audit::membrane),
    system("gravity", Stage::Evaluate, systems::forces::gravity::gravity),
    system("pressure", Stage::Evaluate, systems::forces::pressure::pressure),
    system("compartment", Stage::Evaluate, systems::forces::compartment::compartment),
    system("point loads", Stage::Evaluate, systems::forces::loads::point_loads),
    system("edge loads", Stage::Evaluate, systems::forces::loads::edge_loads),
    system("forces of the step", Stage::Evaluate, systems::forces::loads::step_forces),
    system("springs", Stage::Evaluate, systems::forces::springs::springs),
    system("momentum: loads", Stage::Evaluate, systems::guard::momentum::loads),
    system("grip", Stage::Evaluate, systems::tools::grip::grip),
    system("contact", Stage::Evaluate, systems::contact::contact),
    system("layers: push apart", Stage::Evaluate, systems::contact::layers::push_apart),
    system("bodies: push apart", Stage::Evaluate, systems::contact::layers::push_bodies_apart),
    system("sleep", Stage::Evaluate, systems::step::sleep::fall_asleep),
    system("drag", Stage::Evaluate, systems::forces::drag::drag),
    system("bodies: solve together", Stage::Evaluate, systems::solver::group::solve),
    system("energy audit: loads", Stage::Evaluate, systems::guard::audit::loads),
    system("start", Stage::Start, systems::step::integrate::start),
    system("obstacles further", Stage::SecondStage, systems::contact::move_obstacles),
    system("energy guard: second stage", Stage::SecondStage, systems::guard::nonlinear::second_stage),
    system("second stage", Stage::SecondStage, systems::step::integrate::second_stage),
    system("solve", Stage::Solve, systems::solver::solve::solve),
    system("energy guard", Stage::Solve, systems::guard::enforce),
    system("energy guard: stage", Stage::Solve, systems::guard::nonlinear::linearise),
    system("contact: forces", Stage::Solve, systems::solver::reactions::of_contacts),
    system("rigid: follow", Stage::Solve, systems::contact::rigid::follow),
    system("momentum: answer", Stage::Solve, systems::guard::momentum::answer),
    system("integrate", Stage::Solve, systems::step::integrate::integrate),
    system("solve: unconverged", Stage::Unconverged, systems::solver::solve::unconverged),
    system("energy guard: uncorrected", Stage::Uncorrected, systems::guard::uncorrected),
    system("bodies: uncorrected", Stage::Uncorrected, systems::contact::layers::select_together),
    system("solve: end", Stage::Solved, systems::solver::solve::end),
    system("energy guard: end", Stage::Judge, systems::guard::nonlinear::enforce),
    system("contact: penetrating", Stage::Penetrating, systems::contact::penetrating),
    system("bodies: penetrating", Stage::Penetrating, systems::contact::layers::penetrating),
    system("bodies: penetrating together", Stage::Penetrating, systems::contact::layers::select_together),
    system("contact: slipping", Stage::Slipping, systems::contact::friction::far_from_law),
    system("springs: far from law", Stage::Slipping, systems::forces::springs::far_from_law),
    system("bodies: slipping", Stage::Slipping, systems::contact::layers::select_together),
    system("contact: unsettled", Stage::Unsettled, systems::contact::friction::unsettled),
    system("springs: unsettled", Stage::Unsettled, systems::forces::springs::unsettled),
    system("contact: depenetrate", Stage::Depenetrate, systems::contact::depenetrate),
    system("contact: prevent tunnelling", Stage::PreventTunnelling, systems::contact::prevent_tunnelling),
    system("layers: keep apart", Stage::PreventTunnelling, systems::contact::layers::keep_apart),
    system("bodies: hold apart", Stage::PreventTunnelling, systems::contact::layers::hold_bodies_apart),
    system("criterion", Stage::Decide, systems::fracture::criterion::criterion),
    system("split: advancing", Stage::Advancing, systems::fracture::advancing),
    system("bodies: advancing", Stage::Advancing, systems::contact::layers::select_together),
    system("compartment: settle", Stage::Account, systems::forces::compartment::settle),
    system("energy audit: account", Stage::Account, systems::guard::audit::account),
    system("momentum: account", Stage::Account, systems::guard::momentum::account),
    system("grip: feel", Stage::Account, systems::tools::grip::feel),
    system("contact: settle friction", Stage::Account, systems::contact::settle),
    system("springs: come off", Stage::Account, systems::forces::springs::come_off),
    system("split", Stage::Tear, systems::fracture::split::split),
    system("energy audit: edits", Stage::Tear, systems::guard::audit::edits),
    system("split: unfinished", Stage::Unfinished, systems::fracture::unfinished),
];
