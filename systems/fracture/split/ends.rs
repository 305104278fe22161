//! Continuation of tears at a boundary: live tips at notches, branches where two directions tie, and failure without a tip.

use super::{Tearer, add_tip};
use crate::components::{LigamentFailure, PartedBy, RefusedSite, TearDecision, TearSite};
use crate::event::{EventKind, Renewal};
use crate::storage::{NONE, TipKey, TipRow};
use crate::systems::fracture::{Advance, NewTip, TearRefusal, TipChart};
use glam::DVec3;
use smallvec::SmallVec;
use std::f64::consts::PI;

/// Tissue around a vertex \[rad\] from which it is a notch; 200°. Corners of lips have less, polygonal rims about 184°.
const NOTCH: f64 = 200.0 / 180.0 * PI;
/// Triangles of a disc, or vertices of rims about it, that are listed without an allocation.
const PART: usize = 256;

impl Tearer<'_> {
    /// Leaves a live tip where a tear has met a boundary and freed no piece, or only a chip smaller than the averaging disc. It
    /// lies at the sharpest notch of the rim within 2R, the reach around which starts are left to tips.
    pub(super) fn leave_notch(&mut self, advance: &Advance) {
        let Some(end) = advance.end else { return };
        let radius = self.tearing.radius;
        let rim: SmallVec<[u32; 8]> = self.touched.clone();
        let chip =
            end.freed.map(|most| rim.iter().find_map(|&vertex| self.part_of(vertex, most, PI * radius * radius)));
        let Some(chip) = chip.unwrap_or_else(|| Some(SmallVec::new())) else { return };
        let rest = |row: u32| self.mesh.vertices.rest_position[row as usize];
        let is_within = |row: u32, most: f64| rest(row).distance(advance.to) <= most;
        if self.tips.vertex.iter().any(|&tip| is_within(tip, radius)) {
            return;
        }
        let mut walk: SmallVec<[u32; PART]> = rim.iter().copied().collect();
        let mut best: Option<(f64, f64, u32)> = None;
        let mut at = 0;
        while let Some(&vertex) = walk.get(at) {
            at += 1;
            let Ok(tip) = TipChart::new(&self.mesh, vertex) else { continue };
            if tip.fan.is_closed || tip.fan.sectors.iter().any(|&(triangle, _)| chip.contains(&triangle)) {
                continue;
            }
            let (from, to) = tip.chart.range();
            let (angle, distance) = (to - from, rest(vertex).distance(advance.to));
            // The sharper one; of equal ones the nearer.
            let is_better = |(a, d, _): (f64, f64, u32)| angle > a + 1e-9 || (angle > a - 1e-9 && distance < d);
            if angle >= NOTCH && best.is_none_or(is_better) {
                best = Some((angle, distance, vertex));
            }
            for next in [0, tip.spoke_count() - 1].into_iter().filter_map(|spoke| tip.end(&self.mesh, spoke)) {
                if is_within(next, 2.0 * radius) && !walk.contains(&next) {
                    walk.push(next);
                }
            }
        }
        if let Some((.., vertex)) = best {
            self.renew(NewTip { vertex, direction: DVec3::ZERO, ideal: rest(vertex) }, Renewal::Notch);
        }
    }

    /// The triangles that hang together with those at a vertex, where there are at most `most` of less than this area \[mm²\].
    fn part_of(&self, vertex: u32, most: usize, area: f64) -> Option<SmallVec<[u32; PART]>> {
        let mut part: SmallVec<[u32; PART]> =
            self.mesh.topology.fan(vertex).sectors.iter().map(|sector| sector.0).collect();
        let (mut next, mut found) = (0, 0.0);
        while let Some(&triangle) = part.get(next) {
            next += 1;
            found += self.mesh.triangles.rest[triangle as usize].area;
            if part.len() > most || found >= area {
                return None;
            }
            for neighbour in self.mesh.topology.neighbours[triangle as usize] {
                if neighbour != NONE && !part.contains(&neighbour) {
                    part.push(neighbour);
                }
            }
        }
        (!part.is_empty()).then_some(part)
    }

    /// Whether two directions of a tip tie, both above its toughness.
    pub(super) fn is_tie(&self, decision: &TearDecision) -> bool {
        let is_tie = self.tearing.branch_margin.is_some_and(|most| decision.margin <= most);
        is_tie && decision.other.is_some() && decision.value * (1.0 - decision.margin) > 1.0
    }

    /// Sends a second tip the other way from a notch where two directions tie ([`branch_margin`]).
    ///
    /// [`branch_margin`]: crate::components::Tearing::branch_margin
    pub(super) fn branch(&mut self, decision: &TearDecision) {
        let Some(other) = decision.other.filter(|_| self.is_tie(decision)) else { return };
        // The first tear has parted the notch: the other way leads from that of the two corners which has tissue there.
        let leads = |vertex: &u32| {
            let tip = TipChart::new(&self.mesh, *vertex).ok().filter(|tip| !tip.fan.is_closed)?;
            tip.chart.exit(tip.chart.to_chart(other)).map(|_| tip)
        };
        let copies: SmallVec<[u32; 8]> = self.touched.clone();
        let Some(tip) = copies.iter().find_map(leads) else { return };
        let at = self.mesh.vertices.rest_position[tip.vertex as usize];
        let key = self.renew(NewTip { vertex: tip.vertex, direction: other, ideal: at }, Renewal::Branch);
        let (thickness, factor) = (self.thickness_at(tip.vertex), self.factor_ahead(&tip, other));
        match self.cut_from(&tip, at, other) {
            Ok((advance, ideal)) => {
                let decision = TearDecision { direction: other, ..*decision };
                self.record_advance(key, &decision, (&advance, thickness, factor), ideal);
            }
            Err(refusal) => self.refuse(Some(key), at, &refusal),
        }
    }

    fn renew(&mut self, tip: NewTip, by: Renewal) -> TipKey {
        let at = self.mesh.vertices.rest_position[tip.vertex as usize];
        let tip = add_tip(self.tips, tip);
        match by {
            Renewal::Notch => self.log.renewed_count += 1,
            Renewal::Branch => self.log.branch_count += 1,
        }
        self.log.pending.push(EventKind::Renewed { tip, at, by });
        tip
    }

    /// Parts tissue that fails without a tip. Whether it did; a refusal is reported once for a site.
    pub(super) fn part(&mut self, failure: &LigamentFailure, last: &mut Option<RefusedSite>) -> bool {
        let parted = match (failure.by, failure.site) {
            (PartedBy::Ligament, _) => self.part_ligament(failure),
            (PartedBy::Stretch, TearSite::Vertex(tip)) => self.lead_on(tip, failure),
            (PartedBy::Stretch, TearSite::Triangle(_)) => self.part_stretched(failure),
        };
        let has_parted = parted.is_ok();
        self.tell_refused(parted.map_err(|refusal| (failure.site, refusal)), last);
        has_parted
    }

    /// Opens a ligament from the vertex of the rim at which it was found straight on, to the rim across or as far as the mesh
    /// lets it.
    fn part_ligament(&mut self, failure: &LigamentFailure) -> Result<(), TearRefusal> {
        let slit = self.open_at(failure.site, failure.fibre, failure.direction)?;
        self.note_ligament_failure(failure);
        self.finish_cut(slit.freed);
        for mut tip in slit.tips {
            let mut has_met = false;
            while !has_met && let Ok(chart) = TipChart::new(&self.mesh, tip.vertex) {
                let thickness = self.thickness_at(tip.vertex);
                let Ok((advance, ideal)) = self.cut_from(&chart, tip.ideal, failure.direction) else { break };
                self.note_way(&advance, thickness, failure);
                (tip.vertex, tip.ideal, has_met) = (advance.vertex, ideal, advance.end.is_some());
                self.finish_cut(advance.end.and_then(|end| end.freed));
            }
            if !has_met {
                self.renew(tip, Renewal::Notch);
            }
        }
        Ok(())
    }

    /// Leads the tip at a vertex on into tissue that is stretched too far.
    fn lead_on(&mut self, vertex: u32, failure: &LigamentFailure) -> Result<(), TearRefusal> {
        let Some(row) = self.tips.vertex.iter().position(|&v| v == vertex).map(|row| row as u32) else { return Ok(()) };
        let (key, before, thickness) = (self.tips.key(row), self.tips.at(row), self.thickness_at(vertex));
        let chart = TipChart::new(&self.mesh, vertex)?;
        let (advance, ideal) = self.cut_from(&chart, before.ideal, failure.direction)?;
        self.note_ligament_failure(failure);
        self.note_way(&advance, thickness, failure);
        if let Some(row) = key.and_then(|key| self.tips.row(key)) {
            let led =
                TipRow { vertex: advance.vertex, previous: failure.direction, ideal, is_refused: false, ..before };
            self.tips.set(row, led);
        }
        self.finish_cut(advance.end.and_then(|end| end.freed));
        Ok(())
    }

    /// Opens tissue across its greatest stretch, as a start does.
    fn part_stretched(&mut self, failure: &LigamentFailure) -> Result<(), TearRefusal> {
        let slit = self.open_at(failure.site, failure.fibre, failure.direction)?;
        self.note_ligament_failure(failure);
        self.finish_cut(slit.freed);
        for tip in slit.tips {
            self.renew(tip, Renewal::Notch);
        }
        Ok(())
    }

    fn note_ligament_failure(&mut self, failure: &LigamentFailure) {
        let at = (failure.ends[0] + failure.ends[1]) * 0.5;
        self.log.parted_count += 1;
        self.log.pending.push(EventKind::Parted { at, value: failure.value, by: failure.by });
    }

    /// Records one way of a ligament failure, with the thickness \[mm\] of the sheet at its start.
    fn note_way(&mut self, advance: &Advance, thickness: f64, failure: &LigamentFailure) {
        let way = (advance.to - advance.from).normalize_or(failure.direction);
        self.log.length += advance.length();
        let factor = self.factor_at(advance.vertex);
        self.log.note_area(advance.length() * thickness, self.toughness(failure.fibre, way, factor));
        self.log.note_angle(advance.smallest_angle);
    }
}
