//! `report.json`: the figures of a run. Every number has its unit in its name.

use super::account::AccountReport;
use super::caveats::caveats;
use super::guard::GuardTally;
use super::progress::real_time_factor;
use super::series::Observation;
use super::tally::{AmbiguousDecision, Count, EventCounts, Tally};
use super::timings::{SystemTime, Timings};
use rhexis::components::{Body, EnergyCriterion, Refined, Refinement, RingFault, TearLog, Tearing};
use rhexis::storage::{BodyId, Tips, Triangles, Vertices};
use rhexis_scene::course::CourseReport;
use rhexis_scene::measures::{HandForceFigures, TearAccount, TearCourse};
use rhexis_scene::schema::Mode;
use rhexis_scene::{CutTold, Instance, MeshSummary, Scene, thresholds};
use serde::Serialize;
use std::collections::BTreeMap;
use std::time::Duration;

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case", tag = "state", content = "reason")]
pub(super) enum End {
    /// It is still going; the report is a snapshot.
    Running,
    /// A tear has ended and the scene asked to end there.
    TearEnded,
    /// All steps are done.
    Done,
    /// No tip is left and the scene asked to end there.
    TornThrough,
    /// Somebody has ended it early; the state is kept, to go on from with `--resume`.
    Interrupted,
    /// It could not go on; the last good state stands.
    Failed(String),
}

/// The whole report.
#[derive(Serialize)]
pub(super) struct RunReport {
    /// Version of this layout.
    pub layout: u32,
    /// Program and version.
    pub program: String,
    pub scene: String,
    pub about: String,
    /// Changes made with `--set`.
    pub overrides: Vec<String>,
    pub mode: &'static str,
    pub dt_ms: f64,
    pub threads: usize,
    pub end: End,
    pub steps: u64,
    pub steps_planned: u64,
    pub simulated_ms: f64,
    /// Time from the first step to now, with the writing of files.
    pub elapsed_s: f64,
    /// The part of it spent in steps.
    pub stepping_s: f64,
    /// Simulated time over `stepping_s`.
    pub real_time_factor: f64,
    pub bodies: Vec<BodyFigures>,
    /// Cuts that the scene asked for; absent where there are none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub cuts: Vec<CutTold>,
    /// Forces of the obstacles on the bodies; absent where no body feels them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub obstacles: Vec<ForceFigures>,
    pub solver: SolverFigures,
    pub events: EventCounts,
    /// Decisions that another run could have taken the other way.
    pub ambiguous: Vec<AmbiguousDecision>,
    /// Of the state at the end: equal where every bit of it is.
    pub hash: String,
    /// The systems of the step in their order.
    pub systems: Vec<SystemTime>,
    /// Everything that limits what the figures are worth; empty for a clean run.
    pub caveats: Vec<String>,
}

/// One body at the end.
#[derive(Serialize)]
pub(super) struct BodyFigures {
    pub name: String,
    pub vertices: usize,
    pub triangles: usize,
    /// The mesh before any cut.
    pub mesh: MeshSummary,
    pub mass_g: f64,
    pub elastic_mj: f64,
    pub kinetic_mj: f64,
    /// Terms of the energy balance; absent where it is not kept.
    pub balance_mj: Option<BTreeMap<&'static str, f64>>,
    /// Imbalance of the energy balance over its largest other term; absent where it is not kept.
    pub relative_imbalance: Option<f64>,
    /// Its unbalanced term over the largest one.
    pub relative_unbalanced: Option<f64>,
    pub reactions: Vec<ForceFigures>,
    pub grips: Vec<GripFigures>,
    /// What the energy guard did.
    pub guard: GuardTally,
    /// Absent for a body that cannot tear or is not gripped.
    pub course: Option<CourseReport>,
    /// Absent for a body that cannot tear and was not cut.
    pub tear: Option<TearFigures>,
    /// Absent for a body without a bed.
    pub bed: Option<BedFigures>,
    /// Absent for a body without a compartment.
    pub compartment: Option<CompartmentFigures>,
}

/// Content of a body's compartment.
#[derive(Serialize)]
pub(super) struct CompartmentFigures {
    pub volume_mm3: f64,
    /// Volume of the content at ambient pressure.
    pub content_mm3: f64,
    pub pressure_mpa: f64,
    pub leaked_mm3: f64,
    /// Area of the openings.
    pub opening_mm2: f64,
}

/// The bonds of a body to its bed.
#[derive(Serialize)]
pub(super) struct BedFigures {
    pub area_mm2: f64,
    /// Part of the area whose bonds are off.
    pub off_mm2: f64,
    /// Energy that the bonds have taken.
    pub energy_mj: f64,
    /// Least strength that the mesh allows over the one that is given.
    pub resolved: f64,
}

/// The force of a hold or an obstacle on a body.
#[derive(Serialize)]
pub(super) struct ForceFigures {
    pub name: String,
    pub force_n: [f64; 3],
    /// Torque about the pivot of a turned hold; absent for others.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torque_nmm: Option<[f64; 3]>,
    /// Absent for an obstacle, and where no tip advanced in two steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub while_tearing: Option<WhileTearing>,
}

/// The force of a hold or a grip on the tissue over the steps after the first advance up to the last; of a grip within each grasp.
#[derive(Serialize)]
pub(super) struct WhileTearing {
    pub steps: usize,
    pub mean_n: f64,
    /// A tenth of the steps have less, and a tenth more.
    pub p10_n: f64,
    pub p90_n: f64,
    /// Largest change of the force, as a vector, from one step to the next.
    pub largest_jump_n: f64,
    /// Mean at the end of the steps before those with an advance.
    pub before_advances_n: f64,
}

impl WhileTearing {
    fn of(figures: &HandForceFigures) -> Self {
        let &HandForceFigures { steps, mean, range: [low, high], largest_jump, before_advances } = figures;
        Self {
            steps,
            mean_n: mean,
            p10_n: low,
            p90_n: high,
            largest_jump_n: largest_jump,
            before_advances_n: before_advances,
        }
    }
}

/// The force of a grip on the tissue.
#[derive(Serialize)]
pub(super) struct GripFigures {
    pub name: String,
    /// At the last step.
    pub force_n: [f64; 3],
    /// Root mean square while it was closed.
    pub rms_n: f64,
    pub peak_n: f64,
    /// Absent where no tip advanced in two steps of a grasp.
    pub while_tearing: Option<WhileTearing>,
}

/// What was torn.
#[derive(Serialize)]
pub(super) struct TearFigures {
    /// Torn and cut, in the rest shape.
    pub length_mm: f64,
    pub starts: u32,
    /// Steps in which a start had the stress and not the energy; absent for a body without an energy criterion.
    pub nucleations_blocked: Option<u32>,
    pub advances: u32,
    /// What the toughness claims, and where the energy went; absent for a body that cannot tear.
    pub account: Option<AccountReport>,
    /// Advances by another way than the one wanted.
    pub detours: u32,
    /// Starts and advances.
    pub ambiguous: u32,
    /// Advances by the material force, off the plane crack's field; absent for a body without energy criterion.
    pub by_material_force: Option<u32>,
    /// What decided at tips, one decision per tip and step; absent for a body without an energy criterion.
    pub decisions: Option<DecisionFigures>,
    /// Steps in which a tear that was to advance waited, no faster than Rayleigh waves, and the largest criterion meanwhile.
    pub held_back_steps: u32,
    pub held_back_criterion: f64,
    pub ended: u32,
    pub fragments_freed: u32,
    /// Live tips left at notches, second tips of branches, and places where tissue parted without a tip.
    pub renewed: u32,
    pub branches: u32,
    pub parted: u32,
    /// Parted vertices that a hold or grip keeps shut.
    pub held_shut: u32,
    pub refusals: u32,
    pub tips: Vec<TipFigures>,
    /// Smallest rest angle of the triangles that tears have touched.
    pub smallest_angle_deg: Option<f64>,
    /// Smallest averaging radius over edge length at a tip; figures want 3.
    pub edges_per_radius: Option<f64>,
    /// Absent for a body whose mesh is not refined around tips.
    pub refinement: Option<RefinementFigures>,
    /// Absent for a body that cannot tear.
    pub thresholds: Option<ThresholdFigures>,
}

/// Decisions at tips of a body with an energy criterion.
#[derive(Serialize)]
pub(super) struct DecisionFigures {
    pub by_ring: u64,
    /// By the material force, with the reason why the ring had no field of a plane crack.
    pub by_material_force: BTreeMap<String, u64>,
}

/// What refinement and coarsening did to the mesh.
#[derive(Serialize)]
pub(super) struct RefinementFigures {
    pub splits: u32,
    pub vertices_removed: u32,
    /// Triangles added, less those removed.
    pub triangles_added: i64,
    /// The budget: most triangles that may be added.
    pub most_triangles_added: i64,
    /// How often the budget has ended a refinement.
    pub budget_hits: u32,
    /// Sum of the changes of elastic energy by coarsening.
    pub coarsening_energy_mj: f64,
}

/// Strengths, and the toughness that they imply over the averaging radius.
#[derive(Serialize)]
pub(super) struct ThresholdFigures {
    pub strength_along_fibres_mpa: f64,
    pub strength_across_fibres_mpa: f64,
    pub radius_mm: f64,
    pub toughness_along_fibres_n_per_mm: f64,
    pub toughness_across_fibres_n_per_mm: f64,
}

/// A tip that is alive.
#[derive(Serialize)]
pub(super) struct TipFigures {
    /// In the rest shape.
    pub at_mm: [f64; 3],
    pub criterion: f64,
    /// Energy released per area of tear in the last direction, by the material force.
    pub release_n_per_mm: f64,
    /// Angle from the last direction to the material force, counter-clockwise.
    pub force_turn_deg: f64,
}

/// What the solver did over the run.
#[derive(Serialize)]
pub(super) struct SolverFigures {
    pub iterations: u64,
    pub mean_iterations_per_step: f64,
    pub most_iterations_of_a_step: u32,
    pub last_residual: f64,
    pub largest_residual: f64,
    /// Steps whose linear solve stopped above the tolerance.
    pub unsolved: Count,
    /// Steps whose Newton iteration stopped short of its tolerance.
    pub unconverged: Count,
    /// Steps in which the rotated tangent had to take the exact one's place.
    pub fell_back: Count,
    /// Steps in which a Cholesky factor was made on the spot after a linear solve failed without one.
    pub fallback_factors: Count,
    /// Steps in which a linear solve stopped because its time was up.
    pub late: Count,
    /// Steps in which a body took only a fraction of its increment, lest it create energy.
    pub step_limited: Count,
    /// Vertices were relaxed locally: the linear solution would have gained energy, and the most at once.
    pub relaxed: Count,
    pub most_relaxed_vertices: usize,
    /// Steps at whose end vertices were put back outside an obstacle.
    pub vertices_projected: Count,
    /// Steps at whose end vertices were held back, lest layers of a body pass through each other; the most at once.
    pub layers_held_back: Count,
    pub most_held_back_vertices: u32,
    /// Steps in which a body moved as one, since keeping its layers apart had reached its limit.
    pub layers_moved_as_one: Count,
    /// Steps at whose start layers of a body overlapped; the most pairs of triangles at once.
    pub layers_overlapping: Count,
    pub most_overlapping_triangles: u32,
    /// Steps in which a tear could have gone on when the resumes, the budget or the rounds were used up.
    pub cut_short: Count,
    /// Steps in which the budget had no room for the second solve of a tear that was due.
    pub tear_undecided: Count,
    /// Steps at whose end holds or jaws were behind their hands.
    pub hands_ahead: Count,
    /// Largest distance between them \[mm\].
    pub most_hand_ahead_mm: f64,
    /// Steps in which corrector solves ran out before the energy release at a tip came to rest.
    pub release_unsettled: Count,
    /// Steps in which friction, rigid obstacles or bonds did not meet their laws.
    pub traction_unsettled: Count,
    /// Steps that left refinement to the next one, the budget being used up.
    pub refinement_put_off: Count,
    /// Steps that were given up.
    pub failed: Count,
    /// Sub-steps undone and retried in halves.
    pub rolled_back: u64,
}

/// A body's name.
pub(super) fn body_name(instance: &Instance, body: BodyId) -> String {
    instance.simulation.world().get::<&Body>(body.entity()).map_or(String::new(), |b| b.name.clone())
}

/// What the report needs beside the simulation.
pub(super) struct Sources<'a> {
    pub scene: &'a Scene,
    pub overrides: &'a [String],
    pub tally: &'a Tally,
    pub timings: &'a Timings,
    pub last: &'a Observation,
    pub courses: &'a [TearCourse],
    pub accounts: &'a [TearAccount],
    pub elapsed: Duration,
    pub stepping: Duration,
    pub end: End,
}

/// The report as things stand.
pub(super) fn report(instance: &mut Instance, s: Sources<'_>) -> RunReport {
    let bodies = instance.bodies.clone().into_iter().enumerate();
    let bodies: Vec<BodyFigures> = bodies.map(|(index, body)| body_figures(instance, index, body, &s)).collect();
    let t = s.tally;
    RunReport {
        layout: 1,
        program: concat!("rhexis ", env!("CARGO_PKG_VERSION")).to_owned(),
        scene: s.scene.name().to_owned(),
        about: s.scene.about().to_owned(),
        overrides: s.overrides.to_vec(),
        mode: if instance.run.mode == Mode::Static { "static" } else { "dynamic" },
        dt_ms: instance.run.dt,
        threads: instance.simulation.thread_count(),
        caveats: caveats(&s, &bodies)
            .into_iter()
            .chain(instance.doubts.iter().map(|doubt| doubt.text.clone()))
            .chain(instance.obstacle_notes.iter().cloned())
            .chain(instance.opened_under_pressure())
            .chain(instance.fragments_under_pressure())
            .chain(not_made(&instance.cuts))
            .collect(),
        end: s.end,
        steps: s.last.step,
        steps_planned: instance.run.steps,
        simulated_ms: s.last.time,
        elapsed_s: s.elapsed.as_secs_f64(),
        stepping_s: s.stepping.as_secs_f64(),
        real_time_factor: real_time_factor(s.last.time, s.stepping),
        bodies,
        cuts: instance.cuts.clone(),
        obstacles: s.last.obstacles.iter().map(force_figures).collect(),
        solver: SolverFigures {
            iterations: t.iterations,
            mean_iterations_per_step: t.iterations as f64 / t.steps.max(1) as f64,
            most_iterations_of_a_step: t.most_iterations,
            last_residual: s.last.residual,
            largest_residual: t.largest_residual,
            unsolved: t.unsolved,
            unconverged: t.unconverged,
            fell_back: t.fell_back,
            fallback_factors: t.fallback_factors,
            late: t.late,
            step_limited: t.step_limited,
            relaxed: t.relaxed,
            most_relaxed_vertices: t.most_relaxed,
            vertices_projected: t.vertices_projected,
            layers_held_back: t.layers_held_back,
            most_held_back_vertices: t.most_held_back,
            layers_moved_as_one: t.layers_moved_as_one,
            layers_overlapping: t.layers_overlapping,
            most_overlapping_triangles: t.most_overlapping,
            cut_short: t.cut_short,
            tear_undecided: t.tear_undecided,
            hands_ahead: t.hands_ahead,
            most_hand_ahead_mm: t.most_hand_ahead,
            release_unsettled: t.release_unsettled,
            traction_unsettled: t.traction_unsettled,
            refinement_put_off: t.refinement_put_off,
            failed: t.failed,
            rolled_back: t.rolled_back,
        },
        events: t.events,
        ambiguous: t.ambiguous.clone(),
        hash: instance.simulation.hash().to_string(),
        systems: s.timings.systems(),
    }
}

fn force_figures((name, force): &(String, glam::DVec3)) -> ForceFigures {
    ForceFigures { name: name.clone(), force_n: force.to_array(), torque_nmm: None, while_tearing: None }
}

/// Cuts that were refused.
fn not_made(cuts: &[CutTold]) -> impl Iterator<Item = String> {
    cuts.iter().filter(|cut| cut.refused.is_some()).map(ToString::to_string)
}

/// The body that is the scene's `index`-th.
fn body_figures(instance: &mut Instance, index: usize, body: BodyId, s: &Sources<'_>) -> BodyFigures {
    let name = body_name(instance, body);
    let energies = instance.simulation.energies(body).unwrap_or_default();
    // A name alone does not tell: those of bodies and holds may have slashes of their own.
    let [reactions, grips] = s.last.own.get(index).cloned().unwrap_or_default();
    let prefix = format!("{name}/");
    let plain = |full: &str| full.strip_prefix(&prefix).unwrap_or(full).to_owned();
    let account = s.accounts.iter().find(|account| account.body() == body);
    let reactions = s.last.reactions.get(reactions).unwrap_or_default().iter();
    let reactions = reactions.map(|(full, force)| {
        let torque = s.last.torques.iter().find(|(name, _)| name == full);
        let torque_nmm = torque.map(|(_, torque)| torque.to_array());
        let name = plain(full);
        let while_tearing = account.and_then(|account| account.hold_force(&name)).as_ref().map(WhileTearing::of);
        ForceFigures { name, force_n: force.to_array(), torque_nmm, while_tearing }
    });
    let grips = s.last.grips.get(grips).unwrap_or_default().iter().map(|(full, force)| {
        let (rms_n, peak_n) = s.tally.grip(full);
        let name = plain(full);
        let while_tearing = account.and_then(|account| account.jaws_force(&name)).as_ref().map(WhileTearing::of);
        GripFigures { name, force_n: force.to_array(), rms_n, peak_n, while_tearing }
    });
    let (reactions, grips) = (reactions.collect(), grips.collect());
    let balance = instance.simulation.energy_balance(body).ok().flatten();
    let world = instance.simulation.world();
    let vertices = world.get::<&Vertices>(body.entity());
    BodyFigures {
        name,
        vertices: vertices.as_ref().map_or(0, |v| v.len()),
        triangles: world.get::<&Triangles>(body.entity()).map_or(0, |t| t.len()),
        mesh: instance.meshes.get(index).cloned().unwrap_or_default(),
        mass_g: vertices.map_or(0.0, |v| v.mass.iter().sum()),
        elastic_mj: energies.elastic,
        kinetic_mj: energies.kinetic,
        relative_imbalance: balance.map(|balance| balance.relative_imbalance()),
        relative_unbalanced: balance.map(|balance| balance.relative_unbalanced()),
        balance_mj: balance
            .map(|balance| balance.terms().into_iter().chain([("dissipated", balance.dissipated())]).collect()),
        reactions,
        grips,
        guard: s.tally.guard(index),
        course: s.courses.iter().find(|course| course.body() == body).map(|course| match &instance.scoring {
            Some(scoring) => CourseReport::scored(course, scoring),
            None => CourseReport::of(course),
        }),
        tear: tear_figures(instance, body, account),
        bed: instance.simulation.bed(body).map(|bed| BedFigures {
            area_mm2: bed.area,
            off_mm2: bed.off,
            energy_mj: bed.energy,
            resolved: bed.resolved,
        }),
        compartment: instance.simulation.compartment(body).map(|state| CompartmentFigures {
            volume_mm3: state.volume,
            content_mm3: state.content,
            pressure_mpa: state.pressure,
            leaked_mm3: state.leaked,
            opening_mm2: state.opening,
        }),
    }
}

fn tear_figures(instance: &Instance, body: BodyId, account: Option<&TearAccount>) -> Option<TearFigures> {
    let world = instance.simulation.world();
    let log = world.get::<&TearLog>(body.entity()).ok()?;
    let can_tear = world.get::<&Tearing>(body.entity()).is_ok();
    if !can_tear && log.length == 0.0 {
        return None;
    }
    let vertices = world.get::<&Vertices>(body.entity()).ok()?;
    let at = |row: u32| vertices.rest_position.get(row as usize).map_or([f64::NAN; 3], |p| p.to_array());
    let tips = world.get::<&Tips>(body.entity()).map_or(Vec::new(), |tips| {
        let alive = tips.vertex.iter().zip(&tips.criterion);
        let forces = instance.simulation.material_forces(body).unwrap_or_default();
        let figures = alive.zip(forces).map(|((&row, &criterion), force)| TipFigures {
            at_mm: at(row),
            criterion,
            release_n_per_mm: force.along,
            force_turn_deg: force.turn.to_degrees(),
        });
        figures.collect()
    });
    Some(TearFigures {
        length_mm: log.length,
        starts: log.nucleation_count,
        nucleations_blocked: world
            .get::<&EnergyCriterion>(body.entity())
            .is_ok()
            .then_some(log.blocked_nucleation_count),
        advances: log.advance_count,
        account: account.map(|account| AccountReport::of(&account.figures())),
        detours: log.detour_count,
        ambiguous: log.ambiguous_count,
        by_material_force: world.get::<&EnergyCriterion>(body.entity()).is_ok().then_some(log.material_force_count),
        decisions: world.get::<&EnergyCriterion>(body.entity()).is_ok().then(|| decision_figures(&log)),
        held_back_steps: log.held_back_count,
        held_back_criterion: log.held_back_criterion,
        ended: log.end_count,
        fragments_freed: log.fragment_count,
        renewed: log.renewed_count,
        branches: log.branch_count,
        parted: log.parted_count,
        held_shut: log.held_shut_count,
        refusals: log.refusal_count,
        tips,
        smallest_angle_deg: log.smallest_angle.map(f64::to_degrees),
        edges_per_radius: log.edges_per_radius,
        refinement: refinement_figures(instance, body),
        thresholds: thresholds(&instance.simulation, body).map(|(tearing, toughness)| ThresholdFigures {
            strength_along_fibres_mpa: tearing.strength_along_fibres,
            strength_across_fibres_mpa: tearing.strength_across_fibres,
            radius_mm: tearing.radius,
            toughness_along_fibres_n_per_mm: toughness.along,
            toughness_across_fibres_n_per_mm: toughness.across,
        }),
    })
}

fn decision_figures(log: &TearLog) -> DecisionFigures {
    let reasons = RingFault::ALL.iter().zip(log.force_decision_counts).filter(|(_, count)| *count > 0);
    let by_material_force = reasons.map(|(fault, count)| (fault.to_string(), count)).collect();
    DecisionFigures { by_ring: log.energy_decision_count, by_material_force }
}

fn refinement_figures(instance: &Instance, body: BodyId) -> Option<RefinementFigures> {
    let world = instance.simulation.world();
    let (refinement, refined) =
        (world.get::<&Refinement>(body.entity()).ok()?, world.get::<&Refined>(body.entity()).ok()?);
    Some(RefinementFigures {
        splits: refined.split_count,
        vertices_removed: refined.removed_count,
        triangles_added: refined.added,
        most_triangles_added: refinement.most_added(refined.start_count),
        budget_hits: refined.budget_hit_count,
        coarsening_energy_mj: refined.energy_change,
    })
}
