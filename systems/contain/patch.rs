//! Limits the displacement around the triangles that create energy, where the whole answer would create too much of it.
//!
//! Of a patch with weights w, 1 at the corners of those triangles and falling to 0 over some rings of edges, the vertices go u' = u − w·s·(u −
//! ū), with their mean ū by m·w: so momentum is that of the whole answer. The forces b − A·u' on free axes are those of nothing;
//! what they do along u' is no work of holds and loads, and is taken off what the step has created as it is where the body goes a part of
//! its way. So a patch is taken by the same bound as a whole body. Angular momentum is not kept.

use super::{Bounds, Solved};
use crate::components::ExternalStiffness;
use crate::systems::linear::Operator;
use crate::systems::parallel;
use glam::DVec3;

/// Rings of edges over which the weights fall, in the order in which they are tried; triangles are found anew for each.
const RINGS: [u32; 7] = [1, 2, 3, 4, 6, 8, 12];

/// Parts of the motion about the mean that are taken away.
const STRENGTHS: [f64; 2] = [0.5, 1.0];

/// The part of a body's triangles above which it is limited as a whole.
const MOST_SEEDS: f64 = 0.25;

/// The part of the limit that is aimed at.
const AIM: f64 = 0.5;

/// The part of all energy created that is looked for at most: what is spread thin over many triangles is no patch.
const SEARCHED: f64 = 0.9;

/// How far vertices go of a solve's answer.
#[derive(Clone, Copy)]
pub(super) enum Way<'a> {
    /// The same part along free axes.
    Part(f64),
    /// Displacements of their own \[mm\].
    Each(&'a [DVec3]),
}

/// An answer limited in patches.
pub(super) struct Limited {
    /// Displacements \[mm\].
    pub way: Vec<DVec3>,
    /// Vertices that do not go all of their way.
    pub vertices: usize,
    /// What is left over \[mJ\].
    pub sum: f64,
}

impl Solved<'_> {
    /// The answer limited in patches such that no more is left over than is bearable; none where that takes a large part of the body.
    pub(super) fn limit_patches(
        &self,
        bounds: &Bounds,
        external: Option<&ExternalStiffness>,
        partials: &mut Vec<f64>,
    ) -> Option<Limited> {
        let delta = &self.increment.delta;
        let triangles = self.operator.triangles;
        let mut limited = Limited { way: delta.clone(), vertices: 0, sum: bounds.before + bounds.more + bounds.work };
        let (mut seeds, mut count) = (vec![false; triangles.len()], 0);
        let (mut corner, mut product) = (Vec::new(), vec![DVec3::ZERO; delta.len()]);
        for rings in RINGS {
            count += self.add_seeds(&mut seeds, &limited, bounds.most);
            if count as f64 > MOST_SEEDS * triangles.len() as f64 {
                return None;
            }
            let weights = self.weights(&seeds, rings);
            let means = self.means(&weights);
            limited.vertices = weights.iter().filter(|w| **w > 0.0).count();
            for strength in STRENGTHS {
                let way = |v: usize| delta[v] - self.free[v] * (delta[v] - means[v]) * (strength * weights[v]);
                limited.way.iter_mut().enumerate().for_each(|(v, u)| *u = way(v));
                // A·(u − u'), then its work along u'.
                let left: Vec<DVec3> = delta.iter().zip(&limited.way).map(|(u, way)| *u - *way).collect();
                let operator = Operator { external, ..self.operator };
                operator.apply(&left, self.free, &mut corner, &mut product, partials);
                let undone = |v: usize| product[v].dot(limited.way[v] * self.free[v]);
                let undone = parallel::sum(delta.len(), partials, undone);
                let created = self.left_over(Way::Each(&limited.way), partials);
                limited.sum = bounds.before + created + bounds.work - undone;
                if limited.sum <= bounds.most {
                    return Some(limited);
                }
            }
        }
        None
    }

    /// Adds the triangles that create most, until without them little enough is left. Returns how many are new.
    fn add_seeds(&self, seeds: &mut [bool], limited: &Limited, most: f64) -> usize {
        let created = |t: usize| {
            let created = self.of_triangle(t, Way::Each(&limited.way));
            if created.is_nan() { f64::INFINITY } else { created }
        };
        let mut creating: Vec<(f64, usize)> =
            (0..seeds.len()).map(|t| (created(t), t)).filter(|(e, _)| *e > 0.0).collect();
        // Ties in the order of the triangles.
        creating.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let all: f64 = creating.iter().map(|(e, _)| e).filter(|e| e.is_finite()).sum();
        let (wanted, mut found, mut new) = ((limited.sum - AIM * most).min(SEARCHED * all), 0.0, 0);
        for (energy, t) in creating {
            if energy.is_finite() && found >= wanted {
                break;
            }
            found += if energy.is_finite() { energy } else { 0.0 };
            new += usize::from(!std::mem::replace(&mut seeds[t], true));
        }
        new
    }

    /// 1 at the corners of the seeds, falling to 0 over so many rings.
    fn weights(&self, seeds: &[bool], rings: u32) -> Vec<f64> {
        let corners = &self.operator.triangles.corners;
        let mut weights = vec![0.0; self.increment.delta.len()];
        for (corners, _) in corners.iter().zip(seeds).filter(|(_, seed)| **seed) {
            corners.iter().for_each(|v| weights[*v as usize] = 1.0);
        }
        let fall = 1.0 / f64::from(rings + 1);
        for ring in 1..=rings {
            let weight = 1.0 - fall * f64::from(ring);
            let inner = weight + 0.5 * fall;
            let before = weights.clone();
            for corners in corners.iter().filter(|corners| corners.iter().any(|v| before[*v as usize] > inner)) {
                corners.iter().for_each(|v| weights[*v as usize] = weights[*v as usize].max(weight));
            }
        }
        weights
    }

    /// The mean displacement along free axes of each vertex's patch, by mass and weight.
    fn means(&self, weights: &[f64]) -> Vec<DVec3> {
        let Operator { vertices, triangles, .. } = self.operator;
        let mut parents: Vec<u32> = (0..).take(weights.len()).collect();
        let root = |parents: &[u32], mut v: u32| {
            while parents[v as usize] != v {
                v = parents[v as usize];
            }
            v
        };
        for corners in triangles.corners.iter() {
            if corners.iter().all(|v| weights[*v as usize] > 0.0) {
                let least = corners.iter().map(|v| root(&parents, *v)).fold(u32::MAX, u32::min);
                for v in corners {
                    let own = root(&parents, *v);
                    (parents[own as usize], parents[*v as usize]) = (least, least);
                }
            }
        }
        let mut sums = vec![[DVec3::ZERO; 2]; weights.len()];
        for (v, weight) in weights.iter().enumerate().filter(|(_, weight)| **weight > 0.0) {
            let [moment, mass] = &mut sums[root(&parents, v as u32) as usize];
            let share = self.free[v] * (vertices.mass[v] * weight);
            *moment += share * self.increment.delta[v];
            *mass += share;
        }
        let mean = |v: u32| {
            let [moment, mass] = sums[root(&parents, v) as usize];
            let along = |moment: f64, mass: f64| if mass > 0.0 { moment / mass } else { 0.0 };
            DVec3::new(along(moment.x, mass.x), along(moment.y, mass.y), along(moment.z, mass.z))
        };
        (0..).take(weights.len()).map(mean).collect()
    }
}
