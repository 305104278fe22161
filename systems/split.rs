//! The split: tips advance where the criterion exceeds 1, tears start where there is no tip, and everything that refers to
//! the mesh follows.

use super::StepContext;
use super::linear::Factor;
use super::tearing::{
    Advance, Cutter, End, EnergyTerms, Followers, NewTip, Quality, Reach, TearRefusal, TearScratch, TipChart,
    TipMemory, may_go_on,
};
use crate::components::{
    Changes, DecidedBy, EdgeLoads, EnergyCriterion, Grips, Holds, Increment, PointLoads, Refined, RefusedSite,
    SolverScratch, Springs, StepForces, TearDecision, TearDecisions, TearLog, TearMode, TearSite, Tearing,
};
use crate::event::{Course, EventKind, TearCost, Verdict};
use crate::math::elementary;
use crate::storage::{EditRecord, Mesh, TipKey, TipRow, Tips, Topology, Triangles, Vertices};
use glam::DVec3;
use smallvec::SmallVec;

/// With fewer edges per averaging radius the tear load depends on the mesh.
const RESOLVED: f64 = 3.0;

/// Carries out what the criterion has decided: one advance per tip, in the order of the tips' rows, then one start.
pub fn split(world: &mut hecs::World, step: &StepContext) -> usize {
    let mut count = 0;
    type Query<'a> = (
        (&'a mut Vertices, &'a mut Triangles, &'a mut Topology, &'a mut Increment),
        (&'a Tearing, Option<&'a EnergyCriterion>, &'a mut Tips, &'a mut TearDecisions, &'a mut TearLog),
        (&'a mut TearScratch, Option<&'a mut TipMemory>, &'a mut Factor),
        (Option<&'a mut Holds>, Option<&'a mut Springs>, Option<&'a mut Grips>),
        (Option<&'a mut PointLoads>, Option<&'a mut EdgeLoads>, Option<&'a mut StepForces>),
        (Option<&'a mut Refined>, Option<&'a mut Changes>),
    );
    for (
        (vertices, triangles, topology, increment),
        (tearing, energy, tips, decisions, log),
        (scratch, memory, factor),
        (holds, springs, grips),
        (point_loads, edge_loads, step_forces),
        (refined, changes),
    ) in world.query_mut::<Query>().with::<&SolverScratch>()
    {
        if step.is_done(Some(decisions)) {
            continue;
        }
        let reach = Reach::new(step, tearing);
        if !step.is_resumed {
            log.note_decisions(&decisions.tips);
            note_withheld(decisions, log);
        }
        if !decisions.ask() {
            (0..tips.len()).for_each(|tip| rest(tips, tip, reach));
            decisions.may_advance_further = false;
            continue;
        }
        count += 1;
        let (advances_before, starts_before) = (log.advance_count, log.start_count);
        let mut tearer = Tearer {
            mesh: Mesh { vertices, triangles, topology },
            followers: Followers {
                increment,
                factor,
                memory,
                holds,
                springs,
                grips,
                point_loads,
                edge_loads,
                step_forces,
                refined,
                changes,
            },
            tearing,
            energy,
            tips,
            log,
            scratch,
            parted: SmallVec::new(),
            is_held_back: false,
        };
        let keys: SmallVec<[TipKey; 8]> = tearer.tips.keys().into();
        for (key, decision) in keys.into_iter().zip(&decisions.tips) {
            if let Some(decision) = decision {
                tearer.advance(key, decision, reach);
            }
        }
        if let Some((site, decision)) = decisions.start {
            let refused = tearer.start(site, &decision, decisions.start_length);
            tearer.tell_refused_start(refused, &mut decisions.refused_start);
        }
        let tables = (&*tearer.mesh.vertices, &*tearer.mesh.triangles, &*tearer.mesh.topology);
        let has_more = (0..tearer.tips.len()).any(|tip| may_go_on(tables, tearing, tearer.tips, tip));
        let is_held_back = tearer.is_held_back;
        let (has_advanced, has_started) = (log.advance_count > advances_before, log.start_count > starts_before);
        decisions.may_advance_further =
            if step.is_static { has_advanced || has_started } else { has_advanced && has_more };
        // The last pass of a step: those before are taken up again.
        let is_counted = is_held_back && !decisions.may_advance_further;
        log.held_back_count = log.held_back_count.saturating_add(u32::from(is_counted));
    }
    count
}

/// Counts a step in which a start has the stress and not the energy, and tells of it once.
fn note_withheld(decisions: &mut TearDecisions, log: &mut TearLog) {
    let was_told = std::mem::replace(&mut decisions.is_withheld_told, decisions.withheld.is_some());
    if let Some(withheld) = decisions.withheld {
        log.withheld_start_count = log.withheld_start_count.saturating_add(1);
        if !was_told {
            log.pending.push(EventKind::StartWithheld(withheld));
        }
    }
}

/// A tip that does not want to advance saves nothing up; only what it went too far is paid off in time.
fn rest(tips: &mut Tips, tip: usize, reach: Reach) {
    let more = if let Reach::New(more) = reach { more } else { 0.0 };
    tips.allowance[tip] = (tips.allowance[tip] + more).min(0.0);
    tips.is_refused[tip] = false;
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
    /// Whether a tip has to wait because it may go no further in this step.
    is_held_back: bool,
}

impl Tearer<'_> {
    /// Advances a tip by one triangle or edge, if its allowance is enough for it.
    fn advance(&mut self, key: TipKey, decision: &TearDecision, reach: Reach) {
        // A tip that another one has met in this step is gone.
        let Some(tip) = self.tips.row(key).map(|row| row as usize) else { return };
        self.log.edges_per_radius =
            Some(self.log.edges_per_radius.map_or(decision.edges_per_radius, |e| e.min(decision.edges_per_radius)));
        if !(decision.value > 1.0) {
            return rest(self.tips, tip, reach);
        }
        let (vertex, ideal) = (self.tips.vertex[tip], self.tips.ideal[tip]);
        let at = self.mesh.vertices.rest_position[vertex as usize];
        let edges_per_radius = decision.edges_per_radius;
        if edges_per_radius < RESOLVED && !std::mem::replace(&mut self.tips.is_coarse[tip], true) {
            self.log.pending.push(EventKind::UnderResolved { tip: key, at, edges_per_radius });
        }
        // Whole triangles only: a tear that stopped inside one would leave more and worse ones.
        let chart = TipChart::new(&self.mesh, vertex);
        let exit = chart.as_ref().ok().and_then(|tip| tip.chart.exit(tip.chart.to_chart(decision.direction)));
        let way = exit.map_or(0.0, |exit| exit.distance);
        self.tips.allowance[tip] = reach.allowance(self.tips.allowance[tip], way);
        if !reach.allows(self.tips.allowance[tip], way) {
            return self.note_held_back(key, at, decision.value);
        }
        let thickness = self.thickness_at(vertex);
        let result = chart.and_then(|tip| self.cut_from(&tip, ideal, decision.direction));
        match result {
            Ok((advance, ideal)) => self.record_advance(key, decision, (&advance, thickness), ideal),
            Err(refusal) => {
                self.tips.allowance[tip] = self.tips.allowance[tip].min(0.0);
                if !std::mem::replace(&mut self.tips.is_refused[tip], true) {
                    self.refuse(Some(key), at, &refusal);
                }
            }
        }
    }

    /// A tip that has to wait for its allowance.
    fn note_held_back(&mut self, tip: TipKey, at: DVec3, criterion: f64) {
        if self.log.held_back_criterion == 0.0 {
            self.log.pending.push(EventKind::HeldBack { tip, at, criterion });
        }
        self.is_held_back = true;
        self.log.held_back_criterion = self.log.held_back_criterion.max(criterion);
    }

    /// Takes down an advance from where the sheet was so thick \[mm\].
    fn record_advance(
        &mut self,
        key: TipKey,
        decision: &TearDecision,
        (advance, thickness): (&Advance, f64),
        ideal: DVec3,
    ) {
        let Some(tip) = self.tips.row(key) else { return };
        let length = advance.length();
        let area = length * 0.5 * (thickness + self.thickness_at(advance.vertex));
        let toughness = self.toughness(decision, advance.to - advance.from);
        self.log.note_area(area, toughness);
        let overshoot = decision.value * decision.value - 1.0;
        let before = self.tips.at(tip);
        self.tips.set(
            tip,
            TipRow {
                vertex: advance.vertex,
                previous: decision.direction,
                ideal,
                criterion: decision.value,
                allowance: before.allowance - length,
                is_refused: false,
                ..before
            },
        );
        self.log.length += length;
        self.log.advance_count += 1;
        let wanted = if self.tearing.mode == TearMode::Edge { Course::Edge } else { Course::Exact };
        self.log.detour_count += u32::from(advance.course != wanted);
        self.log.ambiguous_count += u32::from(decision.is_ambiguous);
        self.log.material_force_count += u32::from(matches!(decision.by, DecidedBy::MaterialForce(_)));
        self.log.note_angle(advance.smallest_angle);
        self.log.pending.push(EventKind::Advanced {
            tip: key,
            from: advance.from,
            to: advance.to,
            direction: decision.direction,
            criterion: decision.value,
            margin: decision.margin,
            is_ambiguous: decision.is_ambiguous,
            by: decision.by,
            release: decision.release,
            cost: toughness.map(|toughness| TearCost { area, toughness, overshoot }),
            course: advance.course,
        });
        self.finish_cut(advance.end.and_then(|End { freed }| freed));
    }

    /// Mean thickness of the triangles around a vertex \[mm\].
    fn thickness_at(&self, vertex: u32) -> f64 {
        let around = &self.mesh.topology.incident[vertex as usize];
        let thickness = around.iter().map(|entry| self.mesh.triangles.thickness[(entry / 3) as usize]);
        thickness.sum::<f64>() / around.len().max(1) as f64
    }

    /// Toughness against a tear along a way near a decision \[N/mm\], of a body that has one.
    fn toughness(&self, decision: &TearDecision, way: DVec3) -> Option<f64> {
        let terms = EnergyTerms { tearing: self.tearing, energy: self.energy? };
        let (fibre, way) = (decision.fibre, way.normalize_or(decision.direction));
        let delta = elementary::atan2(fibre.cross(way).length(), fibre.dot(way).abs());
        Some(terms.toughness().threshold(delta))
    }

    /// What follows from a cut, once the tip that made it has moved on.
    fn finish_cut(&mut self, freed: Option<usize>) {
        note_parted(&self.parted, Some(self.tips), self.log, &self.followers, self.mesh.vertices);
        if let Some(triangle_count) = freed {
            self.log.piece_count += 1;
            self.log.pending.push(EventKind::PieceFreed { triangle_count });
        }
    }

    /// Starts a tear at the site or, where the mesh refuses that, at a corner of the triangle.
    /// It opens so much of its `length` \[mm\] at once as the mesh lets it.
    fn start(&mut self, site: TearSite, decision: &TearDecision, length: f64) -> Result<(), (TearSite, TearRefusal)> {
        let from = self.site_at(site);
        let mode = self.tearing.mode;
        let corners = match site {
            TearSite::Vertex(_) => None,
            TearSite::Triangle(triangle) => Some(self.mesh.triangles.corners[triangle as usize].map(TearSite::Vertex)),
        };
        let mut started = self.cut(|cutter| cutter.start(site, decision.direction, mode));
        for other in corners.into_iter().flatten() {
            if started.is_ok() {
                break;
            }
            started = self.cut(|cutter| cutter.start(other, decision.direction, mode)).or(started);
        }
        let slit = started.map_err(|refusal| (site, refusal))?;
        let rest = &self.mesh.vertices.rest_position;
        let lengths = slit.path.windows(2).map(|w| rest[w[0] as usize].distance(rest[w[1] as usize]));
        self.log.length += lengths.sum::<f64>();
        for ends in slit.path.windows(2) {
            let way =
                self.mesh.vertices.rest_position[ends[1] as usize] - self.mesh.vertices.rest_position[ends[0] as usize];
            let thickness = 0.5 * (self.thickness_at(ends[0]) + self.thickness_at(ends[1]));
            self.log.note_area(way.length() * thickness, self.toughness(decision, way));
        }
        self.log.start_count += 1;
        self.log.ambiguous_count += u32::from(decision.is_ambiguous);
        self.log.note_angle(slit.smallest_angle);
        let TearDecision { value: criterion, margin, is_ambiguous, .. } = *decision;
        let verdict = Some(Verdict { criterion, margin, is_ambiguous });
        self.finish_cut(slit.freed);
        let mut opening: SmallVec<[(TipKey, DVec3); 2]> = SmallVec::new();
        for tip in slit.tips {
            let at = self.mesh.vertices.rest_position[tip.vertex as usize];
            let direction = tip.direction;
            let tip = add_tip(self.tips, tip);
            self.log.pending.push(EventKind::Started { tip, at, verdict });
            opening.push((tip, direction));
        }
        for (tip, direction) in opening {
            self.open_further(tip, TearDecision { direction, ..*decision }, (from, length));
        }
        Ok(())
    }

    /// Leads the tip of a start on until the tear is so long \[mm\], to half of a triangle.
    fn open_further(&mut self, key: TipKey, decision: TearDecision, (from, length): (DVec3, f64)) {
        let edge = self.tearing.radius / decision.edges_per_radius;
        while let Some(tip) = self.tips.row(key).map(|row| row as usize)
            && let (vertex, ideal) = (self.tips.vertex[tip], self.tips.ideal[tip])
            && let at = self.mesh.vertices.rest_position[vertex as usize]
            && at.distance(from) + 0.5 * edge < length
            && let thickness = self.thickness_at(vertex)
            && let Ok(chart) = TipChart::new(&self.mesh, vertex)
            && let Ok((advance, ideal)) = self.cut_from(&chart, ideal, decision.direction)
        {
            self.record_advance(key, &decision, (&advance, thickness), ideal);
        }
    }

    /// Where a start lies \[mm, rest shape\].
    fn site_at(&self, site: TearSite) -> DVec3 {
        let at = |v: u32| self.mesh.vertices.rest_position[v as usize];
        match site {
            TearSite::Vertex(vertex) => at(vertex),
            TearSite::Triangle(t) => self.mesh.triangles.corners[t as usize].into_iter().map(at).sum::<DVec3>() / 3.0,
        }
    }

    /// One triangle or edge further from a tip, with where it would be if it could leave the edges.
    fn cut_from(&mut self, tip: &TipChart, ideal: DVec3, direction: DVec3) -> Result<(Advance, DVec3), TearRefusal> {
        let mode = self.tearing.mode;
        self.cut(|cutter| match mode {
            TearMode::Free => cutter.advance_from(tip, direction).map(|advance| (advance, advance.to)),
            TearMode::Edge => {
                let step = cutter.advance_along_edge_from(tip, ideal, direction)?;
                Ok((step.advance, step.ideal))
            }
        })
    }

    /// Tells of a start that was refused, unless the last one was refused at the same site.
    fn tell_refused_start(&mut self, started: Result<(), (TearSite, TearRefusal)>, last: &mut Option<RefusedSite>) {
        let Err((site, refusal)) = started else { return *last = None };
        let (row, site) = match site {
            TearSite::Vertex(vertex) => (vertex, self.mesh.vertices.key(vertex).map(RefusedSite::Vertex)),
            TearSite::Triangle(triangle) => (
                self.mesh.triangles.corners[triangle as usize][0],
                self.mesh.triangles.key(triangle).map(RefusedSite::Triangle),
            ),
        };
        if std::mem::replace(last, site) != site {
            self.refuse(None, self.mesh.vertices.rest_position[row as usize], &refusal);
        }
    }

    fn refuse(&mut self, tip: Option<TipKey>, at: DVec3, refusal: &TearRefusal) {
        self.log.refusal_count += 1;
        self.log.pending.push(EventKind::Refused { tip, at, reason: refusal.to_string() });
    }

    /// Cuts, and lets everything follow.
    fn cut<T>(&mut self, work: impl FnOnce(&mut Cutter<'_, '_>) -> Result<T, TearRefusal>) -> Result<T, TearRefusal> {
        let (followers, tips) = (&self.followers, &self.tips);
        let is_movable = |v: u32| followers.leave_free(v) && !tips.vertex.contains(&v);
        let mut cutter = Cutter {
            mesh: &mut self.mesh,
            is_movable: &is_movable,
            quality: Quality::of_radius(self.tearing.radius),
            scratch: self.scratch,
        };
        let result = work(&mut cutter);
        self.parted.clear();
        self.parted.extend(self.scratch.records.iter().flat_map(EditRecord::parted));
        self.followers.follow(&mut self.scratch.records, &mut self.mesh, Some(self.tips));
        result
    }
}

/// Puts a tip at a vertex.
pub fn add_tip(tips: &mut Tips, tip: NewTip) -> TipKey {
    let NewTip { vertex, direction, ideal } = tip;
    let fresh = TipRow {
        vertex,
        previous: direction,
        ideal,
        criterion: 0.0,
        allowance: 0.0,
        is_refused: false,
        is_coarse: false,
    };
    tips.push(fresh)
}

/// What it means for vertices that they were parted: a tip there is gone, and what has hold of one keeps it shut.
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
