//! The rule of tips that glide: each goes on as far as brings its energy release back to the toughness.
//!
//! With g = G/G_c, its fall κ per length and its rise λ by the load of the last step, expected again, the move is (g + λ − 1)/κ: in the next step
//! g is 1 without a second solve. Where g − 1 is more than a tolerance, moves and solves alternate; each teaches the fall.

use super::Tearer;
use crate::components::{TearDecision, TearDecisions, TearMode, Tearing, TipGlide};
use crate::math::elementary;
use crate::storage::{TipKey, Tips, Vertices};

/// g − 1 up to which a step is not resumed.
const AT_TOUGHNESS: f64 = 0.04;
/// Criterion from which on a tip is judged: by the load to come it may have to move before g is 1. With 0.98 tips at steps of 5 ms moved in every
/// second step, at four fifths of the force.
pub const NEARLY: f64 = 0.95;
/// Largest rise of g in a step that is expected in the next step as well. Beyond it a step is long beside the edges, and is resumed instead.
const FORESEEN: f64 = 0.5;
/// Maximum moves of a tip in a step.
const MOVES: u32 = 3;
/// Longest move, in edges.
const LONGEST: f64 = 0.5;
/// First guess of the fall of g, per edge. One too large makes moves too short, one too small lets the load expected oscillate.
const FIRST_FALL: f64 = 3.0;
/// Exponent with which a fall that was seen counts.
const LEARNING: f64 = 0.3;
/// Bounds of the fall per edge, and of one that was seen over the one known.
const FALLS: [f64; 2] = [0.05, 1e3];
const SEEN: f64 = 10.0;
/// Shortest move, in edges.
const SHORTEST: f64 = 1e-4;

/// Whether tips of a body glide in this step.
pub fn is_gliding(tearing: &Tearing, is_static: bool) -> bool {
    tearing.mode == TearMode::Glide && !is_static
}

/// Lists the tips of a body that glides, each with the g that its last moves were to lead to. Whether one has moved since the last solve.
pub fn begin_glides(vertices: &Vertices, tips: &Tips, decisions: &mut TearDecisions) -> bool {
    decisions.glides.clear();
    let mut has_moved = false;
    for (row, &tip) in tips.keys().iter().enumerate() {
        let way = vertices.rest_position[tips.vertex[row] as usize].distance(tips.ideal[row]);
        has_moved |= way > 0.0;
        let expected = tips.criterion[row] * tips.criterion[row] - tips.advance_budget[row] * way;
        decisions.glides.push(TipGlide { tip, way: 0.0, moves: 0, last: None, expected });
    }
    has_moved
}

/// Whether a tip may have to move.
pub(super) fn is_near(decisions: &TearDecisions) -> bool {
    decisions.tips.iter().flatten().any(|decision| decision.value > NEARLY)
}

/// Learns the fall of G/G_c at every tip from the last solve, and notes where the tips are.
pub(super) fn learn(vertices: &Vertices, tips: &mut Tips, decisions: &mut TearDecisions, tearing: &Tearing) {
    for row in 0..tips.len() {
        tips.ideal[row] = vertices.rest_position[tips.vertex[row] as usize];
        let (Some(Some(decision)), Some(key)) = (decisions.tips.get(row), tips.key(row as u32)) else { continue };
        let (g, edge) = (decision.value * decision.value, tearing.radius / decision.edges_per_radius);
        // In this mode the column has the fall.
        let fall = &mut tips.advance_budget[row];
        if *fall <= 0.0 {
            *fall = FIRST_FALL / edge;
        }
        let last = decisions.glides.iter_mut().find(|glide| glide.tip == key).and_then(|glide| glide.last.take());
        if let Some((moved, before)) = last {
            let seen = ((before - g) / moved).clamp(*fall / SEEN, *fall * SEEN);
            *fall *= elementary::pow(seen / *fall, LEARNING);
        }
        *fall = fall.clamp(FALLS[0] / edge, FALLS[1] / edge);
    }
}

impl Tearer<'_> {
    /// Lets a tip glide as far as its energy release asks for. False where it is to advance by a whole triangle instead.
    pub(super) fn glide(&mut self, key: TipKey, tip: usize, decision: &TearDecision, dt: f64) -> bool {
        let vertex = self.tips.vertex[tip];
        let edge = self.tearing.radius / decision.edges_per_radius;
        let g = decision.value * decision.value;
        let place = self.glides.iter().position(|glide| glide.tip == key).unwrap_or_else(|| {
            self.glides.push(TipGlide { tip: key, way: 0.0, moves: 0, last: None, expected: g });
            self.glides.len() - 1
        });
        let TipGlide { way, moves, expected, .. } = self.glides[place];
        // The load of a step that is expected again.
        let load = if moves == 0 && g - expected < FORESEEN { (g - expected).max(0.0) } else { 0.0 };
        let asked = ((g + load - 1.0) / self.tips.advance_budget[tip]).min(LONGEST * edge);
        if !(asked > SHORTEST * edge) {
            self.tips.is_refused[tip] = false;
            return true;
        }
        let length = asked.min(self.tearing.max_tear_speed * dt - way);
        if !(length > 0.0) {
            self.note_held_back(key, self.mesh.vertices.rest_position[vertex as usize], decision.value);
            return true;
        }
        self.glides[place].moves += 1;
        self.may_glide_on |= g - 1.0 > AT_TOUGHNESS && moves + 1 < MOVES;
        if !self.followers.leave_free(vertex) {
            return decision.value <= 1.0;
        }
        let (thickness, direction) = (self.thickness_at(vertex), decision.direction);
        let glide = self
            .cut_moving(|followers, v| followers.can_spare(v), |cutter| cutter.glide(vertex, direction, length, edge));
        let Ok(advance) = glide else { return decision.value <= 1.0 };
        self.has_glided = true;
        let length = advance.length();
        let glide = &mut self.glides[place];
        (glide.last, glide.way) = (Some((length, g)), way + length);
        let factor = self.factor_at(advance.vertex);
        if way == 0.0 {
            self.record_advance(key, decision, (&advance, thickness, factor), self.tips.ideal[tip]);
        } else {
            self.lengthen_advance(key, decision, (&advance, thickness, factor));
            self.lengthened += 1;
        }
        true
    }
}
