//! The split: tips advance where the criterion exceeds 1, tears start where there is no tip, and everything that refers to
//! the mesh follows.

use super::StepContext;
use super::tearing::{Advance, Cutter, End, Followers, Quality, Start, TearRefusal, TearScratch, TipChart};
use crate::components::{
    EdgeLoads, Grips, Holds, Increment, PointLoads, Refined, Springs, TearDecision, TearDecisions, TearLog, TearMode,
    Tearing,
};
use crate::event::EventKind;
use crate::storage::{Mesh, TipKey, TipRow, Tips, Topology, Triangles, Vertices};
use glam::DVec3;
use smallvec::SmallVec;

/// Carries out what the criterion has decided: one advance per tip, in the order of the tips' rows, then one start.
pub fn split(world: &mut hecs::World, step: &StepContext) -> usize {
    let mut count = 0;
    type Query<'a> = (
        (&'a mut Vertices, &'a mut Triangles, &'a mut Topology, &'a mut Increment),
        (&'a Tearing, &'a mut Tips, &'a mut TearDecisions, &'a mut TearLog, &'a mut TearScratch),
        (Option<&'a mut Holds>, Option<&'a mut Springs>, Option<&'a mut Grips>),
        (Option<&'a mut PointLoads>, Option<&'a mut EdgeLoads>, Option<&'a mut Refined>),
    );
    for (
        (vertices, triangles, topology, increment),
        (tearing, tips, decisions, log, scratch),
        (holds, springs, grips),
        (point_loads, edge_loads, refined),
    ) in world.query_mut::<Query>()
    {
        if step.is_resumed && !decisions.may_advance_further {
            continue;
        }
        let asks = |d: &&TearDecision| d.value > 1.0;
        if decisions.start.is_none() && !decisions.tips.iter().flatten().any(|d| asks(&d)) {
            tips.allowance.fill(0.0);
            tips.is_refused.fill(false);
            decisions.may_advance_further = false;
            continue;
        }
        count += 1;
        let reach = if step.is_static {
            f64::INFINITY
        } else if step.is_resumed {
            0.0
        } else {
            tearing.max_tear_speed * step.dt
        };
        let advances_before = log.advance_count;
        let mut tearer = Tearer {
            mesh: Mesh { vertices, triangles, topology },
            followers: Followers { increment, holds, springs, grips, point_loads, edge_loads, refined },
            tearing,
            tips,
            log,
            scratch,
        };
        let keys: SmallVec<[TipKey; 8]> = tearer.tips.keys().into();
        for (key, decision) in keys.into_iter().zip(&decisions.tips) {
            if let Some(decision) = decision {
                tearer.advance(key, decision, reach);
            }
        }
        if let Some(start) = &decisions.start {
            tearer.start(start);
        }
        let has_advanced = tearer.log.advance_count > advances_before;
        decisions.may_advance_further = has_advanced && tearer.tips.allowance.iter().any(|&left| left > 0.0);
    }
    count
}

/// One body while it tears.
struct Tearer<'a> {
    mesh: Mesh<'a>,
    followers: Followers<'a>,
    tearing: &'a Tearing,
    tips: &'a mut Tips,
    log: &'a mut TearLog,
    scratch: &'a mut TearScratch,
}

impl Tearer<'_> {
    /// Advances a tip by at most what it has saved up and `reach` \[mm\] more.
    fn advance(&mut self, key: TipKey, decision: &TearDecision, reach: f64) {
        // A tip that another one has met in this step is gone.
        let Some(tip) = self.tips.row(key).map(|row| row as usize) else { return };
        self.log.edges_per_radius =
            Some(self.log.edges_per_radius.map_or(decision.edges_per_radius, |e| e.min(decision.edges_per_radius)));
        if !(decision.value > 1.0) {
            self.tips.allowance[tip] = 0.0;
            self.tips.is_refused[tip] = false;
            return;
        }
        self.tips.allowance[tip] += reach;
        let (vertex, ideal) = (self.tips.vertex[tip], self.tips.ideal[tip]);
        // Whole triangles only: a tear that stopped inside one would leave more and worse ones. What is too short is saved up;
        // a sum of equal parts may miss the way by roundings.
        let way = self.way_ahead(vertex, decision.direction);
        if way.is_some_and(|way| self.tips.allowance[tip] < way * (1.0 - 1e-9)) {
            return;
        }
        let mode = self.tearing.mode;
        let result = self.cut(|cutter| match mode {
            TearMode::Free => {
                cutter.advance(vertex, decision.direction, f64::INFINITY).map(|advance| (advance, advance.to))
            }
            TearMode::Edge => {
                let advance = cutter.advance_along_edge(vertex, ideal, decision.direction)?;
                Ok((advance.advance, advance.ideal))
            }
        });
        match result {
            Ok((advance, ideal)) => self.record_advance(key, decision, &advance, ideal),
            Err(refusal) => {
                self.tips.allowance[tip] = 0.0;
                if !std::mem::replace(&mut self.tips.is_refused[tip], true) {
                    self.refuse(Some(key), self.mesh.vertices.rest_position[vertex as usize], &refusal);
                }
            }
        }
    }

    /// How far the ray from a vertex goes before it leaves the triangles there \[mm\].
    fn way_ahead(&self, vertex: u32, direction: DVec3) -> Option<f64> {
        let tip = TipChart::new(&self.mesh, vertex).ok()?;
        tip.chart.exit(tip.chart.to_chart(direction)).map(|exit| exit.distance)
    }

    fn record_advance(&mut self, key: TipKey, decision: &TearDecision, advance: &Advance, ideal: DVec3) {
        let Some(tip) = self.tips.row(key) else { return };
        let length = advance.length();
        let before = self.tips.at(tip);
        self.tips.set(
            tip,
            TipRow {
                vertex: advance.vertex,
                previous: decision.direction,
                ideal,
                criterion: decision.value,
                allowance: (before.allowance - length).max(0.0),
                is_refused: false,
            },
        );
        self.log.length += length;
        self.log.advance_count += 1;
        self.log.ambiguous_count += u32::from(decision.is_ambiguous);
        self.log.note_angle(advance.smallest_angle);
        self.log.pending.push(EventKind::Advanced {
            tip: key,
            from: advance.from,
            to: advance.to,
            direction: decision.direction,
            criterion: decision.value,
            margin: decision.margin,
            is_ambiguous: decision.is_ambiguous,
        });
        if let Some(End { freed }) = advance.end {
            self.end_tips_at(advance.vertex, advance.to);
            self.record_freed(freed);
        }
    }

    /// Every tip at the vertex is gone.
    fn end_tips_at(&mut self, vertex: u32, at: DVec3) {
        while let Some(row) = self.tips.vertex.iter().position(|&v| v == vertex) {
            let row = row as u32;
            let Some(tip) = self.tips.key(row) else { return };
            self.tips.swap_remove(row);
            self.log.end_count += 1;
            let vertex = self.mesh.vertices.key(vertex);
            self.log.pending.push(EventKind::Ended { tip, at, vertex });
        }
    }

    fn record_freed(&mut self, freed: Option<usize>) {
        if let Some(triangle_count) = freed {
            self.log.piece_count += 1;
            self.log.pending.push(EventKind::PieceFreed { triangle_count });
        }
    }

    /// Starts a tear inside a triangle.
    fn start(&mut self, decision: &TearDecision) {
        match self.cut(|cutter| cutter.start_inside(Start::Triangle(decision.row), decision.direction)) {
            Ok(slit) => {
                self.log.note_angle(slit.smallest_angle);
                let rest = &self.mesh.vertices.rest_position;
                let lengths = slit.path.windows(2).map(|w| rest[w[0] as usize].distance(rest[w[1] as usize]));
                self.log.length += lengths.sum::<f64>();
                for &(vertex, direction) in &slit.tips {
                    add_tip(self.tips, self.log, self.mesh.vertices, vertex, direction);
                }
                self.record_freed(slit.freed);
            }
            Err(refusal) => {
                let corners = self.mesh.triangles.corners[decision.row as usize];
                self.refuse(None, self.mesh.vertices.rest_position[corners[0] as usize], &refusal);
            }
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
            quality: Quality::default(),
            scratch: self.scratch,
        };
        let result = work(&mut cutter);
        self.followers.follow(&mut self.scratch.records, &mut self.mesh, Some(self.tips));
        result
    }
}

/// Puts a tip at a vertex and logs the start of its tear.
pub fn add_tip(tips: &mut Tips, log: &mut TearLog, vertices: &Vertices, vertex: u32, direction: DVec3) -> TipKey {
    let at = vertices.rest_position[vertex as usize];
    let row = TipRow { vertex, previous: direction, ideal: at, criterion: 0.0, allowance: 0.0, is_refused: false };
    let tip = tips.push(row);
    log.pending.push(EventKind::Started { tip, at });
    tip
}
