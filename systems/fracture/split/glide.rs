//! The rule of tips that glide: each goes on as far as brings its energy release back to the toughness.
//!
//! With g = G/G_c and its fall κ per length the move is (g − 1)/κ. The fall is learnt from the change by each move. Moves and
//! solves alternate while g − 1 is more than a tolerance.

use super::Tearer;
use crate::components::{TearDecision, TearDecisions, TearMode, Tearing, TipGlide};
use crate::math::elementary;
use crate::storage::{TipKey, Tips};

/// g − 1 up to which a step is not resumed.
const AT_TOUGHNESS: f64 = 0.04;
/// Maximum moves of a tip in a step.
const MOVES: u32 = 3;
/// Longest move, in edges.
const LONGEST: f64 = 0.5;
/// First guess of the fall of g, per edge.
const FIRST_FALL: f64 = 1.5;
/// Exponent with which a fall that was seen counts.
const LEARNING: f64 = 0.3;
/// Bounds of the fall per edge, and of one that was seen over the one known.
const FALLS: [f64; 2] = [0.05, 1e3];
const SEEN: f64 = 10.0;
/// Shortest move that teaches the fall, in edges.
const TEACHES: f64 = 1e-4;

/// Whether tips of a body glide in this step.
pub(super) fn is_gliding(tearing: &Tearing, is_static: bool) -> bool {
    tearing.mode == TearMode::Glide && !is_static
}

/// Learns the fall of G/G_c at every tip from the last solve.
pub(super) fn learn(tips: &mut Tips, decisions: &mut TearDecisions, tearing: &Tearing) {
    for (row, decision) in decisions.tips.iter().enumerate() {
        let (Some(decision), Some(key)) = (decision, tips.key(row as u32)) else { continue };
        let (g, edge) = (decision.value * decision.value, tearing.radius / decision.edges_per_radius);
        // In this mode the column has the fall.
        let fall = &mut tips.advance_budget[row];
        if *fall <= 0.0 {
            *fall = FIRST_FALL / edge;
        }
        let last = decisions.glides.iter_mut().find(|glide| glide.tip == key).and_then(|glide| glide.last.take());
        if let Some((moved, before)) = last.filter(|(moved, _)| *moved > TEACHES * edge) {
            let seen = ((before - g) / moved).clamp(*fall / SEEN, *fall * SEEN);
            *fall *= elementary::pow(seen / *fall, LEARNING);
        }
        *fall = fall.clamp(FALLS[0] / edge, FALLS[1] / edge);
    }
}

impl Tearer<'_> {
    /// Lets a tip glide as far as its energy release asks for. Whether it has done so or waits for its speed; else it is to advance by a whole
    /// triangle.
    pub(super) fn glide(&mut self, key: TipKey, tip: usize, decision: &TearDecision, dt: f64) -> bool {
        let vertex = self.tips.vertex[tip];
        let edge = self.tearing.radius / decision.edges_per_radius;
        let g = decision.value * decision.value;
        let place = self.glides.iter().position(|glide| glide.tip == key).unwrap_or_else(|| {
            self.glides.push(TipGlide { tip: key, way: 0.0, moves: 0, last: None });
            self.glides.len() - 1
        });
        let TipGlide { way, moves, .. } = self.glides[place];
        let by_speed = self.tearing.max_tear_speed * dt - way;
        let length = ((g - 1.0) / self.tips.advance_budget[tip]).min(LONGEST * edge).min(by_speed);
        if !(length > 0.0) {
            self.note_held_back(key, self.mesh.vertices.rest_position[vertex as usize], decision.value);
            return true;
        }
        self.glides[place].moves += 1;
        self.may_glide_on |= g - 1.0 > AT_TOUGHNESS && moves + 1 < MOVES;
        if !self.followers.leave_free(vertex) {
            return false;
        }
        let (thickness, direction) = (self.thickness_at(vertex), decision.direction);
        let glide = self
            .cut_moving(|followers, v| followers.can_spare(v), |cutter| cutter.glide(vertex, direction, length, edge));
        let Ok(advance) = glide else { return false };
        self.has_glided = true;
        let length = advance.length();
        let glide = &mut self.glides[place];
        (glide.last, glide.way) = (Some((length, g)), way + length);
        let factor = self.factor_at(advance.vertex);
        if way == 0.0 {
            self.record_advance(key, decision, (&advance, thickness, factor), advance.to);
        } else {
            self.lengthen_advance(key, decision, (&advance, thickness, factor));
            self.lengthened += 1;
        }
        true
    }
}
