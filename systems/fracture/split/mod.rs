//! The split: tips advance where the criterion exceeds 1, tears start where there is no tip, and everything that refers to
//! the mesh follows.

mod account;
mod ends;
mod glide;
mod nucleation;

pub use glide::{NEARLY, begin_glides};

use crate::components::{
    EnergyCriterion, PartedBy, Refined, SolveResult, TearDecision, TearDecisions, TearLog, TearMode, Tearing, TipGlide,
};
use crate::event::EventKind;
use crate::storage::{EditRecord, Mesh, TipKey, TipRow, Tips, Topology, Triangles, Vertices};
use crate::systems::fracture::{
    Advance, Cutter, Followers, FollowersQuery, NewTip, Quality, TearRefusal, TearScratch, TipChart, corrector,
};
use crate::systems::{StepContext, work};
use glam::DVec3;
use smallvec::SmallVec;

/// Edges per averaging radius below which the tear load depends on the mesh.
const RESOLVED: f64 = 3.0;

/// Carries out the decisions of the criterion: one advance per tip in turn, one nucleation and, where neither tore, one ligament failure.
pub fn split(world: &mut hecs::World, step: &StepContext) -> usize {
    let mut count = 0;
    type Query<'a> = (
        (&'a mut Vertices, &'a mut Triangles, &'a mut Topology),
        (&'a Tearing, Option<&'a EnergyCriterion>, &'a mut Tips, &'a mut TearDecisions, &'a mut TearLog),
        (&'a mut TearScratch, &'a mut SolveResult, Option<&'a mut Refined>),
        FollowersQuery<'a>,
    );
    for (
        (vertices, triangles, topology),
        (tearing, energy, tips, decisions, log),
        (scratch, result, refined),
        followers,
    ) in world.query_mut::<Query>()
    {
        if !result.is_in_step {
            continue;
        }
        if !step.is_resumed {
            log.note_decisions(&decisions.tips);
            note_blocked_nucleation(decisions, log);
        }
        let is_gliding = tearing.glides(step.is_static);
        if is_gliding {
            glide::learn(vertices, (tips, decisions), tearing, step.is_resumed);
        }
        if !(decisions.ask() || is_gliding && glide::is_near(decisions)) {
            tips.is_refused.fill(false);
            decisions.may_advance_further = false;
            continue;
        }
        count += 1;
        result.is_release_unsettled |= corrector::leaves_unsettled(tearing, tips, decisions, followers.0.applied);
        let (advances_before, starts_before) = (log.advance_count, log.nucleation_count);
        let mut tearer = Tearer {
            mesh: Mesh { vertices, triangles, topology },
            followers: Followers::of(followers, refined),
            tearing,
            energy,
            tips,
            log,
            scratch,
            parted: SmallVec::new(),
            touched: SmallVec::new(),
            waits_for_speed: false,
            waits_for_budget: false,
            gliding_dt: is_gliding.then_some(step.dt),
            glides: std::mem::take(&mut decisions.glides),
            may_glide_on: false,
            has_glided: false,
            lengthened: 0,
        };
        let most = work::of_advances(tearer.tips.len(), tearer.mesh.triangles.len());
        let takes_turns = step.left(result).is_some_and(|left| left < most);
        for (key, decision) in in_turn((tearer.tips, tearer.log), &decisions.tips, takes_turns) {
            let advances = (tearer.log.advance_count - advances_before) as usize + tearer.lengthened;
            let and_this = work::of_advances(advances + 1, tearer.mesh.triangles.len());
            if advances > 0 && step.left(result).is_some_and(|left| left < and_this) {
                tearer.wait(key, decision);
            } else {
                tearer.advance(key, decision);
            }
        }
        // A glide may have given rows to others: sites found before it are void.
        let has_glided = tearer.has_glided;
        if let Some((site, decision)) = decisions.nucleation.filter(|_| !has_glided) {
            let refused = tearer.nucleate(site, &decision, decisions.nucleation_length);
            tearer.tell_refused(refused, &mut decisions.refused_nucleation);
        }
        let has_torn =
            has_glided || tearer.log.advance_count > advances_before || tearer.log.nucleation_count > starts_before;
        // A ligament parts only by a criterion evaluated on the present mesh.
        let has_parted = match &decisions.ligament_failure {
            Some(failure) if !has_torn => tearer.part(failure, &mut decisions.refused_ligament_failure),
            _ => false,
        };
        let is_ligament = decisions.ligament_failure.as_ref().is_some_and(|failure| failure.by == PartedBy::Ligament);
        if is_ligament && !has_torn && !has_parted {
            decisions.ligament_refused_at = tearer.log.length;
        }
        let (waits_for_speed, waits_for_budget) = (tearer.waits_for_speed, tearer.waits_for_budget);
        let may_glide_on = tearer.may_glide_on;
        decisions.glides = std::mem::take(&mut tearer.glides);
        result.follows_glide = has_glided;
        let lengthened = tearer.lengthened;
        let triangles = tearer.mesh.triangles.len();
        let (has_advanced, has_started) = (log.advance_count > advances_before, log.nucleation_count > starts_before);
        decisions.may_advance_further = if step.is_static {
            has_advanced || has_started || has_parted
        } else if is_gliding {
            may_glide_on || waits_for_budget
        } else {
            has_advanced
        };
        let advances = (log.advance_count - advances_before) as usize + lengthened;
        result.work = result.work.saturating_add(work::of_advances(advances, triangles));
        // The last pass of a step: those before are redone.
        let is_counted = waits_for_speed && !decisions.may_advance_further;
        log.held_back_count = log.held_back_count.saturating_add(u32::from(is_counted));
    }
    count
}

/// Counts a step in which a nucleation is blocked by energy: the stress suffices, the energy does not. It is reported once.
fn note_blocked_nucleation(decisions: &mut TearDecisions, log: &mut TearLog) {
    let was_reported = std::mem::replace(&mut decisions.is_blocked_reported, decisions.blocked_by_energy.is_some());
    if let Some(blocked) = decisions.blocked_by_energy {
        log.blocked_nucleation_count = log.blocked_nucleation_count.saturating_add(1);
        if !was_reported {
            log.pending.push(EventKind::NucleationBlocked(blocked));
        }
    }
}

/// Judged tips in the order of their rows. Where they take turns it begins one further on after every advance.
fn in_turn<'a>(
    (tips, log): (&Tips, &TearLog),
    decisions: &'a [Option<TearDecision>],
    takes_turns: bool,
) -> SmallVec<[(TipKey, &'a TearDecision); 8]> {
    let judged = tips.keys().iter().zip(decisions).filter_map(|(key, decision)| Some((*key, decision.as_ref()?)));
    let mut judged: SmallVec<[(TipKey, &TearDecision); 8]> = judged.collect();
    if takes_turns && !judged.is_empty() {
        let first = log.advance_count as usize % judged.len();
        judged.rotate_left(first);
    }
    judged
}

/// One body while it tears.
struct Tearer<'a> {
    mesh: Mesh<'a>,
    followers: Followers<'a>,
    tearing: &'a Tearing,
    energy: Option<&'a EnergyCriterion>,
    tips: &'a mut Tips,
    log: &'a mut TearLog,
    scratch: &'a mut TearScratch,
    /// The vertices that the last cut has parted.
    parted: SmallVec<[u32; 4]>,
    /// The vertices that the last cut has parted, with their copies.
    touched: SmallVec<[u32; 8]>,
    /// Whether a tip waits because Rayleigh waves would go no further in this step.
    waits_for_speed: bool,
    /// Whether a tip waits because the work budget is used up.
    waits_for_budget: bool,
    /// The time step \[ms\] where tips glide.
    gliding_dt: Option<f64>,
    /// Tips that have glided in this step.
    glides: Vec<TipGlide>,
    /// Whether a tip is to glide on after another solve.
    may_glide_on: bool,
    /// Whether a tip has glided in this pass.
    has_glided: bool,
    /// Number of glides that have lengthened an earlier advance of this step.
    lengthened: usize,
}

impl Tearer<'_> {
    /// Lets a tip wait that would advance, for the work budget of a later step.
    fn wait(&mut self, key: TipKey, decision: &TearDecision) {
        let Some(tip) = self.tips.row(key) else { return };
        if decision.value > 1.0 {
            self.waits_for_budget = true;
        } else {
            self.tips.is_refused[tip as usize] = false;
        }
    }

    /// Advances a tip: by a glide where it can, else by one triangle or edge.
    fn advance(&mut self, key: TipKey, decision: &TearDecision) {
        // A tip that another one has met in this step is gone.
        let Some(tip) = self.tips.row(key).map(|row| row as usize) else { return };
        self.log.edges_per_radius =
            Some(self.log.edges_per_radius.map_or(decision.edges_per_radius, |e| e.min(decision.edges_per_radius)));
        let least = if self.gliding_dt.is_some() { glide::NEARLY } else { 1.0 };
        if !(decision.value > least) {
            self.tips.is_refused[tip] = false;
            return;
        }
        let (vertex, ideal) = (self.tips.vertex[tip], self.tips.ideal[tip]);
        let at = self.mesh.vertices.rest_position[vertex as usize];
        let edges_per_radius = decision.edges_per_radius;
        if edges_per_radius < RESOLVED && !std::mem::replace(&mut self.tips.is_coarse[tip], true) {
            self.log.pending.push(EventKind::UnderResolved { tip: key, at, edges_per_radius });
        }
        if let Some(dt) = self.gliding_dt
            && self.glide(key, tip, decision, dt)
        {
            return;
        }
        // Whole triangles only: a tear that stopped inside one would leave more and worse ones.
        let chart = TipChart::new(&self.mesh, vertex);
        let factor = chart.as_ref().map_or(1.0, |tip| self.factor_ahead(tip, decision.direction));
        let thickness = self.thickness_at(vertex);
        let result = chart.and_then(|tip| self.cut_from(&tip, ideal, decision.direction));
        match result {
            Ok((advance, ideal)) => {
                self.record_advance(key, decision, (&advance, thickness, factor), ideal);
                self.count_way(key, advance.length());
                self.leave_notch(&advance);
                self.branch(decision);
            }
            Err(refusal) => {
                if !std::mem::replace(&mut self.tips.is_refused[tip], true) {
                    self.refuse(Some(key), at, &refusal);
                }
            }
        }
    }

    /// Notes that a tip waits for the speed of waves.
    fn note_held_back(&mut self, tip: TipKey, at: DVec3, criterion: f64) {
        if self.log.held_back_criterion == 0.0 {
            self.log.pending.push(EventKind::HeldBack { tip, at, criterion });
        }
        self.waits_for_speed = true;
        self.log.held_back_criterion = self.log.held_back_criterion.max(criterion);
    }

    /// Finishes a cut, once the tip that made it has moved on.
    fn finish_cut(&mut self, freed: Option<usize>) {
        note_parted(&self.parted, Some(self.tips), self.log, &self.followers, self.mesh.vertices);
        if let Some(triangle_count) = freed {
            self.log.fragment_count += 1;
            self.log.pending.push(EventKind::FragmentFreed { triangle_count });
        }
    }

    /// Cuts one triangle or edge further from a tip; the second value is where the tip would be if it could leave the edges.
    fn cut_from(&mut self, tip: &TipChart, ideal: DVec3, direction: DVec3) -> Result<(Advance, DVec3), TearRefusal> {
        let mode = self.tearing.mode;
        self.cut(|cutter| match mode {
            TearMode::Free | TearMode::Glide => {
                cutter.advance_from(tip, direction).map(|advance| (advance, advance.to))
            }
            TearMode::Edge => {
                let step = cutter.advance_along_edge_from(tip, ideal, direction)?;
                Ok((step.advance, step.ideal))
            }
        })
    }

    fn refuse(&mut self, tip: Option<TipKey>, at: DVec3, refusal: &TearRefusal) {
        self.log.refusal_count += 1;
        self.log.pending.push(EventKind::Refused { tip, at, reason: refusal.to_string() });
    }

    /// Cuts, and lets everything follow. Vertices that belong to the tissue alone may be moved.
    fn cut<T>(&mut self, work: impl FnOnce(&mut Cutter<'_, '_>) -> Result<T, TearRefusal>) -> Result<T, TearRefusal> {
        self.cut_moving(|followers, v| followers.leave_free(v), work)
    }

    /// Cuts, and lets everything follow; `may_move` tells which vertices but tips may be moved.
    fn cut_moving<T>(
        &mut self,
        may_move: impl Fn(&Followers<'_>, u32) -> bool,
        work: impl FnOnce(&mut Cutter<'_, '_>) -> Result<T, TearRefusal>,
    ) -> Result<T, TearRefusal> {
        let (followers, tips) = (&self.followers, &self.tips);
        let is_movable = |v: u32| may_move(followers, v) && !tips.vertex.contains(&v);
        let mut cutter = Cutter {
            mesh: &mut self.mesh,
            is_movable: &is_movable,
            quality: Quality::of_radius(self.tearing.radius),
            scratch: self.scratch,
        };
        let result = work(&mut cutter);
        self.parted.clear();
        self.parted.extend(self.scratch.records.iter().flat_map(EditRecord::parted));
        self.touched.clear();
        let copies = self.scratch.records.iter().flat_map(EditRecord::created);
        let copies = copies.filter(|(_, parents)| parents.is_duplicate()).map(|(copy, _)| copy);
        self.touched.extend(self.parted.iter().copied().chain(copies));
        self.followers.follow(&mut self.scratch.records, &mut self.mesh, Some(self.tips));
        result
    }
}

/// Puts a tip at a vertex.
pub fn add_tip(tips: &mut Tips, tip: NewTip) -> TipKey {
    let NewTip { vertex, direction, ideal } = tip;
    let fresh =
        TipRow { vertex, previous: direction, ideal, criterion: 0.0, fall: 0.0, is_refused: false, is_coarse: false };
    tips.push(fresh)
}

/// Updates tips and events for parted vertices: a tip there is gone, and a held vertex is reported as held shut.
pub fn note_parted(
    parted: &[u32],
    tips: Option<&mut Tips>,
    log: &mut TearLog,
    followers: &Followers<'_>,
    vertices: &Vertices,
) {
    let mut tips = tips;
    for &parted in parted {
        let at = vertices.rest_position[parted as usize];
        while let Some(tips) = tips.as_deref_mut()
            && let Some(row) = tips.vertex.iter().position(|&vertex| vertex == parted)
            && let Some(tip) = tips.key(row as u32)
        {
            tips.swap_remove(row as u32);
            log.end_count += 1;
            log.pending.push(EventKind::Ended { tip, at, vertex: vertices.key(parted) });
        }
        if followers.hold(parted) {
            log.held_shut_count += 1;
            log.pending.push(EventKind::HeldShut { at });
        }
    }
}
