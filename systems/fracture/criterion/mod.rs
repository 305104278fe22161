//! The tear criterion at every tip and, where a body may tear by itself, at its triangles and along its boundary.
//!
//! Tissue tears in the direction d of the largest c(d) = σ_u/σ̄(δ), where that exceeds 1. `kernels::failure` has the formula, its maximum
//! and the criterion √(G/G_c) on energy.

pub(super) mod by_triangle;
pub(super) mod coupled_criterion;
pub(super) mod crack_field;
pub(super) mod energy_decision;
pub(super) mod held_shut;
pub(super) mod shifted_disc;
pub(super) mod shifted_folds;
pub(super) mod tip_decision;
pub(super) mod tip_disc;
pub(super) mod tip_memory;
pub(super) mod tip_stress;
pub(super) mod ultimate_stretch;

use crate::components::{
    BlockedNucleation, DecidedBy, EnergyCriterion, Grips, Holds, LigamentFailure, SolveResult, TearDecision,
    TearDecisions, TearLog, TearSite, Tearing,
};
use crate::math::elementary;
use crate::storage::Tips;
use crate::systems::fracture::{
    EnergyTerms, Surface, SurfaceQuery, TipMemory, beyond_stretch, decision, disc_average, energy_decision, strength,
    tip_decision, vertex_decision,
};
use crate::systems::kernels::failure;
use crate::systems::{StepContext, parallel};
use glam::DVec3;

/// A tear starts at least so many averaging radii from every tip, and from every vertex that a hold or a closed grip has hold
/// of. Nearer, a disc ahead of the tip shares its stress concentration, and can even exceed the tip's own average by a
/// fifth (K field: 1.2 against 1.02 K/√(2πR) at a distance R, 0.75 at 2R): there the tip decides, or each tear would raise a
/// swarm of others. A clamp concentrates stress in the same way at its corners, and the tissue in its jaws is not modelled.
const APART: f64 = 2.0;

/// Cost of a tip at rest, in evaluations of a triangle's stress: some 0.6 µs.
const TIP: usize = 100;

/// Evaluates the criterion at the current positions and leaves the decisions in [`TearDecisions`]. Does not run on a body that
/// has no tip, may not start a tear and has nothing that could part without one.
pub fn criterion(world: &mut hecs::World, _: &StepContext) -> usize {
    for (decisions, result) in world.query_mut::<(&mut TearDecisions, &SolveResult)>() {
        if result.is_in_step {
            decisions.forget();
        }
    }
    type Query<'a> = (
        (SurfaceQuery<'a>, &'a Tearing),
        (&'a mut Tips, &'a mut TearDecisions, &'a mut TipMemory, &'a SolveResult, &'a TearLog),
        (Option<&'a Holds>, Option<&'a Grips>, Option<&'a EnergyCriterion>),
    );
    parallel::for_bodies::<Query>(
        world,
        |((((_, triangles, _), _), tearing), (tips, _, _, result, log), _)| {
            let is_searched = tearing.may_initiate || tearing.ultimate_stretch.is_some() || log.length > 0.0;
            match (result.is_in_step, is_searched) {
                (false, _) => 0,
                (true, true) => triangles.len(),
                (true, false) => tips.len() * TIP,
            }
        },
        |((surface, tearing), (tips, decisions, memory, _, log), (holds, grips, energy))| {
            let surface = Surface::of(surface);
            decisions.make_room(tips.len());
            for tip in 0..tips.len() {
                let place = (tips.vertex[tip], tips.previous[tip]);
                let decision = match energy {
                    Some(energy) => energy_decision(&surface, EnergyTerms { tearing, energy }, tip, place, memory)
                        .map(|found| found.0),
                    None => tip_decision(&surface, tearing, tip, place, memory),
                };
                tips.criterion[tip] = decision.map_or(0.0, |d| d.value);
                decisions.tips.push(decision);
            }
            let held = || holds.iter().flat_map(|h| &h.groups).flat_map(|group| group.members.rows());
            let gripped = || grips.iter().flat_map(|g| &g.pinches).flat_map(|pinch| pinch.held.rows());
            if log.length > decisions.ligament_refused_at {
                let at = |row: u32| surface.vertices.rest_position[row as usize];
                let least_sq = elementary::powi(tearing.radius, 2);
                let may_part = |p: DVec3| {
                    let mut others = tips.vertex.iter().chain(held()).chain(gripped());
                    others.all(|&row| at(row).distance_squared(p) >= least_sq)
                };
                let ligaments = memory.ligaments(&surface, tearing.radius);
                decisions.ligament_failure = ligaments.weakest(&surface, &strength(tearing), &may_part).map(Box::new);
            }
            if let Some(ultimate) = tearing.ultimate_stretch {
                let is_held = |row: u32| held().chain(gripped()).any(|&other| other == row);
                let stretched = beyond_stretch(&surface, ultimate, &tips.vertex, &is_held);
                let ligament = decisions.ligament_failure.as_deref();
                // Overstretched tissue at a tip goes first; else, of a ligament and a stretched triangle, the one farther beyond its
                // limit.
                let leads = |found: &LigamentFailure| match found.site {
                    TearSite::Vertex(_) => true,
                    TearSite::Triangle(_) => ligament.is_none_or(|ligament| found.value > ligament.value),
                };
                if let Some(found) = stretched.filter(leads) {
                    decisions.ligament_failure = Some(Box::new(found));
                }
            }
            if tearing.may_initiate {
                let at = |&row: &u32| surface.vertices.rest_position[row as usize];
                let least_sq = elementary::powi(APART * tearing.radius, 2);
                let may_nucleate = |p: DVec3| {
                    let mut others = tips.vertex.iter().chain(held()).chain(gripped()).map(at);
                    others.all(|q| q.distance_squared(p) >= least_sq)
                };
                let scratch = (&mut decisions.rim, &mut *memory);
                match energy {
                    None => decisions.nucleation = strongest_nucleation(&surface, tearing, &may_nucleate, scratch),
                    Some(energy) => {
                        coupled_nucleation(&surface, EnergyTerms { tearing, energy }, &may_nucleate, decisions, memory)
                    }
                }
            }
        },
    )
}

/// The place whose disc average exceeds the criterion most; of equal ones triangles before vertices, and the lowest row.
fn strongest_nucleation(
    surface: &Surface,
    tearing: &Tearing,
    may_nucleate: &dyn Fn(DVec3) -> bool,
    scratch: (&mut Vec<u32>, &mut TipMemory),
) -> Option<(TearSite, TearDecision)> {
    let mut best: Option<(TearSite, TearDecision)> = None;
    for_each_nucleation_site(surface, tearing, may_nucleate, scratch, |site, found| {
        if found.value > best.map_or(1.0, |(_, best)| best.value) {
            best = Some((site, found));
        }
    });
    best
}

/// First site, in the order of the strength criterion, whose coupled criterion opens. One site nucleates per pass, as a tear unloads its
/// surroundings.
fn coupled_nucleation(
    surface: &Surface,
    terms: EnergyTerms<'_>,
    may_nucleate: &dyn Fn(DVec3) -> bool,
    decisions: &mut TearDecisions,
    memory: &mut TipMemory,
) {
    let mut reached: Vec<(TearSite, TearDecision)> = Vec::new();
    for_each_nucleation_site(
        surface,
        terms.tearing,
        may_nucleate,
        (&mut decisions.rim, &mut *memory),
        |site, found| {
            if found.value > 1.0 {
                reached.push((site, found));
            }
        },
    );
    // Where a tip's own field reaches the strength, the tip decides: one that runs through equilibria far above its toughness would raise a
    // swarm ahead of it.
    let rest = &surface.vertices.rest_position;
    for tip in decisions.tips.iter().flatten() {
        let (at, reach) = (rest[tip.row as usize], terms.overstressed(surface, tip));
        reached.retain(|&(site, _)| site_at(surface, site).distance(at) >= reach);
    }
    // Stable: of equal ones the first offered stays first.
    reached.sort_by(|a, b| b.1.value.total_cmp(&a.1.value));
    for (site, found) in reached {
        let Some(coupled) = terms.coupled_criterion(surface, site, &found, (&mut memory.passing, &mut memory.walk))
        else {
            continue;
        };
        if coupled.opens {
            let found = TearDecision { by: DecidedBy::Nucleation, release: Some(coupled.release), ..found };
            (decisions.nucleation, decisions.nucleation_length) = (Some((site, found)), coupled.length);
            decisions.blocked_by_energy = None;
            return;
        }
        decisions.blocked_by_energy.get_or_insert_with(|| BlockedNucleation {
            at: site_at(surface, site),
            criterion: found.value,
            length: coupled.length,
            release: coupled.release,
            toughness: coupled.toughness,
        });
    }
}

/// Position of a site \[mm, rest shape\].
fn site_at(surface: &Surface, site: TearSite) -> DVec3 {
    let at = |v: u32| surface.vertices.rest_position[v as usize];
    match site {
        TearSite::Vertex(vertex) => at(vertex),
        TearSite::Triangle(t) => surface.triangles.corners[t as usize].into_iter().map(at).sum::<DVec3>() / 3.0,
    }
}

/// Offers the criterion at every place that may start a tear, triangles before vertices of the boundary, by rows. The cheap
/// bound comes first. A triangle whose own largest principal stress is under every threshold cannot be the centre of a start.
/// Nor can a vertex of the boundary whose triangles are all under the thresholds of the weakest triangle.
fn for_each_nucleation_site(
    surface: &Surface,
    tearing: &Tearing,
    may_nucleate: &dyn Fn(DVec3) -> bool,
    (rim, memory): (&mut Vec<u32>, &mut TipMemory),
    mut offer: impl FnMut(TearSite, TearDecision),
) {
    let strength = strength(tearing);
    let weakest = strength.times(surface.triangles.least_strength());
    let rest = &surface.vertices.rest_position;
    rim.clear();
    for t in 0..surface.triangles.len() {
        let stress = surface.stress(t);
        if failure::cannot_tear(stress, &weakest) {
            continue;
        }
        let corners = surface.triangles.corners[t];
        rim.extend(corners.into_iter().filter(|&v| surface.topology.is_boundary_vertex(v)));
        if failure::cannot_tear(stress, &strength.times(surface.triangles.strength[t])) {
            continue;
        }
        let x = corners.map(|v| rest[v as usize]);
        if !may_nucleate((x[0] + x[1] + x[2]) / 3.0) {
            continue;
        }
        if let Some(found) = in_triangle(surface, tearing, t, x, memory) {
            offer(TearSite::Triangle(t as u32), found);
        }
    }
    rim.sort_unstable();
    rim.dedup();
    for &vertex in rim.iter().filter(|&&vertex| may_nucleate(rest[vertex as usize])) {
        if let Some(found) = vertex_decision(surface, tearing, vertex, memory) {
            offer(TearSite::Vertex(vertex), found);
        }
    }
}

/// The criterion at the centroid of a triangle, from the average over the disc about it.
fn in_triangle(
    surface: &Surface,
    tearing: &Tearing,
    t: usize,
    x: [DVec3; 3],
    memory: &mut TipMemory,
) -> Option<TearDecision> {
    let fibre = surface.triangles.fibre[t];
    let axes = [fibre, (x[1] - x[0]).cross(x[2] - x[0]).normalize().cross(fibre)];
    let centre = (x[0] + x[1] + x[2]) / 3.0;
    let buffers = (&mut memory.passing, &mut memory.walk);
    let average = disc_average(surface, centre, axes, tearing.radius, [t as u32], buffers)?;
    let answer = memory.search(strength(tearing)).evaluate(average.stress, average.fibre, None, None)?;
    let answer = answer.over(surface.triangles.strength[t]);
    let d = answer.best.direction;
    Some(decision(t as u32, &answer, &average, axes, axes[0] * d.x + axes[1] * d.y))
}
