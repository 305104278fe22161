//! The rule of tips that glide: a tip moves by the length that brings its energy release back to the toughness.
//!
//! With g = G/G_c, its fall κ per length and its rise λ by the load of the last step, expected again, a tip that runs moves by (g + λ − 1)/κ: in
//! the next step g is 1 without a second solve. A resting tip moves where g > 1, by (g − 1)/κ. Where g − 1 is more than a tolerance, moves
//! and solves alternate, and κ is learnt from every move. With a toughness that grows with speed, g − κ·a = 1 + ((w + a)/(v₀·Δt))ⁿ gives the move
//! a after the way w of the step before it.

use super::Tearer;
use crate::components::{TearDecision, TearDecisions, TearRate, Tearing, TipGlide};
use crate::math::elementary;
use crate::storage::{TipKey, Tips, Triangles, Vertices};

/// g − 1 up to which a step is not resumed.
const AT_TOUGHNESS: f64 = 0.04;
/// Criterion above which a running tip is judged: the load to come may move it before g is 1. With 0.98 tips moved in every second of steps of
/// 5 ms, at four fifths of the force (`rhexis verify tear-hand-force`).
pub const NEARLY: f64 = 0.95;
/// Largest rise of g in a step that is expected in the next step as well. A larger one means a step that is long beside the edges: it is resumed.
const FORESEEN: f64 = 0.5;
/// Longest move, in edges.
const LONGEST: f64 = 0.5;
/// First guess of the fall of g, per edge. A large guess shortens moves; a small one lets the expected load oscillate.
const FIRST_FALL: f64 = 3.0;
/// Exponent with which a fall that was seen counts.
const LEARNING: f64 = 0.3;
/// Bounds of the fall per edge, and of one that was seen over the one known.
const FALLS: [f64; 2] = [0.05, 1e3];
const SEEN: f64 = 10.0;
/// Shortest move, in edges.
const SHORTEST: f64 = 1e-4;
/// Halvings of the interval in which the move at a rate lies.
const HALVINGS: usize = 40;
/// Speed of Rayleigh waves over that of shear waves, at least: that of a Poisson's ratio of zero (Rayleigh 1885).
const RAYLEIGH: f64 = 0.874;

/// Speed \[mm/ms\] that no gliding tip exceeds: that of Rayleigh waves where they are slowest (Freund 1990, section 4.2).
fn fastest(triangles: &Triangles) -> f64 {
    let Triangles { stiffness, density, .. } = triangles;
    let speed_sq = |row: usize| stiffness[row].q66 / density[row];
    let different = if stiffness.is_uniform() && density.is_uniform() { 1 } else { triangles.len() };
    RAYLEIGH * (0..triangles.len().min(different)).map(speed_sq).fold(f64::INFINITY, f64::min).sqrt()
}

/// Move \[mm\] that brings g = G/G_c to the toughness, with its fall per length \[1/mm\]: to 1 or, with a rate, to that at the speed of the whole way of
/// the step, of which a part \[mm\] is done in the time \[ms\].
fn way_to_toughness(g: f64, fall: f64, rate: Option<(TearRate, f64, f64)>) -> f64 {
    let Some((rate, done, time)) = rate else { return (g - 1.0) / fall };
    let excess = |way: f64| g - fall * way - 1.0 - rate.added(done + way, time);
    let (mut short, mut long) = (0.0, (g - 1.0) / fall);
    if !(excess(short) > 0.0) {
        return 0.0;
    }
    // The excess falls with the way: halving finds its root to the last bits of the longest way.
    for _ in 0..HALVINGS {
        let middle = 0.5 * (short + long);
        *(if excess(middle) > 0.0 { &mut short } else { &mut long }) = middle;
    }
    short
}

/// Lists the gliding tips of a body, each with the g expected of its last moves. Returns whether a tip has moved since the last solve.
pub fn begin_glides(vertices: &Vertices, tips: &Tips, decisions: &mut TearDecisions) -> bool {
    let mut has_moved = false;
    for (row, &tip) in tips.keys().iter().enumerate() {
        let way = vertices.rest_position[tips.vertex[row] as usize].distance(tips.ideal[row]);
        has_moved |= way > 0.0;
        let (criterion, fall) = (tips.criterion[row], tips.fall[row]);
        let expected = criterion * criterion - fall.abs() * way;
        decisions.glides.push(TipGlide { tip, way: 0.0, last: None, is_running: fall > 0.0, expected, load: 0.0 });
    }
    has_moved
}

/// Whether a tip may have to move.
pub(super) fn is_near(decisions: &TearDecisions) -> bool {
    decisions.tips.iter().flatten().any(|decision| decision.value > NEARLY)
}

/// Learns the fall of G/G_c at every tip from the last solve, and the load of a step from its first; notes where the tips are.
pub(super) fn learn(
    vertices: &Vertices,
    (tips, decisions): (&mut Tips, &mut TearDecisions),
    tearing: &Tearing,
    is_resumed: bool,
) {
    for row in 0..tips.len() {
        tips.ideal[row] = vertices.rest_position[tips.vertex[row] as usize];
        let (Some(Some(decision)), Some(key)) = (decisions.tips.get(row), tips.key(row as u32)) else { continue };
        let (g, edge) = (decision.value * decision.value, tearing.radius / decision.edges_per_radius);
        let is_sound = g.is_finite() && edge > 0.0 && edge.is_finite();
        let known = tips.fall[row];
        let mut fall = if known == 0.0 { FIRST_FALL / edge } else { known.abs() };
        if !(is_sound && fall.is_finite()) {
            continue;
        }
        if let Some(glide) = decisions.glides.iter_mut().find(|glide| glide.tip == key) {
            if let Some((moved, before)) = glide.last.take() {
                let seen = ((before - g) / moved).clamp(fall / SEEN, fall * SEEN);
                fall *= elementary::pow(seen / fall, LEARNING);
            }
            let rise = g - glide.expected;
            if !is_resumed && (0.0..FORESEEN).contains(&rise) {
                glide.load = rise;
            }
        }
        let is_moving = is_resumed && known > 0.0;
        fall = fall.clamp(FALLS[0] / edge, FALLS[1] / edge);
        tips.fall[row] = if is_moving { fall } else { -fall };
    }
}

impl Tearer<'_> {
    /// Adds an advance by a whole triangle to the way of a tip that glides.
    pub(super) fn count_way(&mut self, key: TipKey, length: f64) {
        if let Some(glide) = self.glides.iter_mut().find(|glide| glide.tip == key) {
            glide.way += length;
        }
    }

    /// Lets a tip glide by the length for its energy release. Returns false where the tip is to advance by a whole triangle instead.
    pub(super) fn glide(&mut self, key: TipKey, tip: usize, decision: &TearDecision, dt: f64) -> bool {
        let vertex = self.tips.vertex[tip];
        let edge = self.tearing.radius / decision.edges_per_radius;
        let g = decision.value * decision.value;
        let place = self.glides.iter().position(|glide| glide.tip == key).unwrap_or_else(|| {
            let (is_running, expected, load) = (false, g, 0.0);
            self.glides.push(TipGlide { tip: key, way: 0.0, last: None, is_running, expected, load });
            self.glides.len() - 1
        });
        let TipGlide { way, is_running, load, .. } = self.glides[place];
        let fall = self.tips.fall[tip].abs();
        let move_at = |g: f64| way_to_toughness(g, fall, self.tearing.rate.map(|rate| (rate, way, dt)));
        let wanted = move_at(g);
        // A move that is cut to the longest is as far from the toughness as one of a large fall.
        let will_resume = fall * wanted > AT_TOUGHNESS || wanted > LONGEST * edge;
        // The step ends with the solve that finds the tip at its toughness; the move after it foresees the load.
        let load = if is_running && !will_resume { load } else { 0.0 };
        let asked = move_at(g + load).min(LONGEST * edge);
        // A resting tip moves at its toughness, whatever the load to come.
        if !(asked > SHORTEST * edge) || !is_running && !(g > 1.0) {
            self.tips.is_refused[tip] = false;
            return true;
        }
        // A tip whose ways tie may branch.
        if self.is_tie(decision) {
            return !(g > 1.0);
        }
        let allowed = fastest(self.mesh.triangles) * dt - way;
        if asked > allowed {
            self.note_held_back(key, self.mesh.vertices.rest_position[vertex as usize], decision.value);
        }
        let length = asked.min(allowed);
        if !(length > 0.0) {
            return true;
        }
        self.glides[place].is_running = true;
        self.may_glide_on |= will_resume && asked <= allowed;
        if !self.followers.leave_free(vertex) {
            return decision.value <= 1.0;
        }
        let (thickness, direction) = (self.thickness_at(vertex), decision.direction);
        let glide = self
            .cut_moving(|followers, v| followers.can_spare(v), |cutter| cutter.glide(vertex, direction, length, edge));
        let Ok(advance) = glide else { return decision.value <= 1.0 };
        self.has_glided = true;
        self.tips.fall[tip] = fall;
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
