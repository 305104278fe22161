//! Coupled stress-energy nucleation criterion, where both a strength and a toughness are in force (Leguillon 2002). The stress
//! reaches the strength along a whole length, and opening that length releases the toughness on average.
//!
//! The release is that of a crack on whose lips the tractions are taken away which the tissue carried there (Bueckner 1958). From
//! inside it is that in a wide plate, from the boundary that at a straight rim.

use crate::components::{TearDecision, TearSite};
use crate::math::{CrackTip, elementary};
use crate::storage::NONE;
use crate::systems::fracture::criterion::tip_disc::Disc;
use crate::systems::fracture::{EnergyTerms, Surface, Walk, disc_average, strength};
use crate::systems::kernels::failure::direction_value;
use glam::{DVec2, DVec3};
use smallvec::{SmallVec, smallvec};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Weight of a straight rim (Bueckner 1970): √(2/π(a−x))·(1 + m₁·s² + m₂·s⁴), s² = 1 − x/a. Here m₂ gives K = 1.1215·σ·√(πa) under even
/// tension, and 0.685·σ·√(πa) (0.683) where tension grows from nothing at the rim.
const RIM: [f64; 2] = [0.6147, 0.2040];
/// Points of the midpoint rule over an opening. It meets even and linear tractions to 0.1 %.
const POINTS: u32 = 24;
/// Square of the largest principal stress around a tip over K/√(2πr), at 60° from its direction.
const LARGEST_SQ: f64 = 1.69;
/// Distance ahead at which a way is probed for the triangle it enters, in lengths of a step or a zone.
const PROBED_AHEAD: f64 = 0.01;
/// Triangles that one step of the walk may cross.
const MOST_CROSSED_BY_STEP: usize = 64;

/// Result of the coupled stress-energy nucleation criterion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoupledCriterion {
    /// Length to open \[mm\], to either side of a start from inside.
    pub length: f64,
    /// Energy released by opening it, per area \[N/mm\].
    pub release: f64,
    /// Mean toughness along it \[N/mm\].
    pub toughness: f64,
    /// Whether both conditions hold.
    pub opens: bool,
}

/// Buffers of the coupled criterion.
pub type CoupledBuffers<'a> = (&'a mut Disc, &'a mut Walk);

/// Stresses at a point of the way: tractions across and along it \[MPa\] and the toughness \[N/mm\].
#[derive(Clone, Copy)]
struct Sample {
    opening: f64,
    sliding: f64,
    toughness: f64,
}

/// A way from the start through the rest surface.
struct Ray {
    at: DVec3,
    ahead: DVec3,
    triangle: u32,
}

impl EnergyTerms<'_> {
    /// Coupled criterion of a nucleation at `site`, its length grown by one edge at a time. The first length that meets both conditions wins, or
    /// the last at the strength. A line from the rim that is at its strength up to another boundary opens. `None` without such a site.
    pub fn coupled_criterion(
        &self,
        surface: &Surface,
        site: TearSite,
        decision: &TearDecision,
        buffers: CoupledBuffers<'_>,
    ) -> Option<CoupledCriterion> {
        let step = self.tearing.radius / decision.edges_per_radius;
        let mut rays = self.rays(surface, site, decision.direction, step)?;
        let triangle = rays.first()?.triangle as usize;
        let (disc, walk) = buffers;
        let first = self.sample(surface, rays.first()?, (&mut *disc, &mut *walk))?.1;
        let law = surface.triangles.stiffness.get(triangle)?;
        let crack = CrackTip::new(law, angle_of_fibre(surface, triangle, decision.direction));
        let mut ways: SmallVec<[Vec<Sample>; 2]> = rays.iter().map(|_| vec![first]).collect();
        let (mut released, mut rate) = (0.0, 0.0);
        let mut coupled = CoupledCriterion { length: 0.0, release: 0.0, toughness: first.toughness, opens: false };
        loop {
            let length = coupled.length + step;
            for (ray, way) in rays.iter_mut().zip(&mut ways) {
                if !ray.go_on(surface, step) {
                    let is_through = way.len() > 1 && matches!(site, TearSite::Vertex(_));
                    return Some(CoupledCriterion { opens: is_through, ..coupled });
                }
                let (criterion, sample) = self.sample(surface, ray, (&mut *disc, &mut *walk))?;
                if !(criterion >= 1.0) {
                    return Some(coupled);
                }
                way.push(sample);
            }
            let now = release(&crack, &ways, length, step);
            released += 0.5 * (rate + now) * step;
            rate = now;
            let count = ways.len() as f64;
            let toughness = ways.iter().map(|way| mean(way, |sample| sample.toughness)).sum::<f64>() / count;
            coupled = CoupledCriterion { length, release: released / (count * length), toughness, opens: false };
            if coupled.release >= toughness {
                return Some(CoupledCriterion { opens: true, ..coupled });
            }
        }
    }

    /// Distance \[mm\] within which the field of a tip, at most 1.3·K/√(2πr) in mode I, reaches the strength; zero without an energy decision.
    pub fn overstressed(&self, surface: &Surface, decision: &TearDecision) -> f64 {
        let Some(release) = decision.release else { return 0.0 };
        let way = decision.direction * (PROBED_AHEAD * self.tearing.radius);
        let Some(triangle) = triangle_ahead(surface, decision.row, way) else { return 0.0 };
        let triangle = triangle as usize;
        let law = &surface.triangles.stiffness[triangle];
        let across = decision.axes[0].cross(decision.axes[1]).cross(decision.direction);
        let angle = elementary::atan2(decision.fibre.dot(across), decision.fibre.dot(decision.direction));
        let intensity_sq = release / CrackTip::new(law, angle).energy_release(1.0, 0.0);
        let delta = elementary::atan2(elementary::sin_cos(angle).0.abs(), elementary::sin_cos(angle).1.abs());
        let strength = strength(self.tearing).times(surface.triangles.strength[triangle]);
        LARGEST_SQ * intensity_sq / (TAU * elementary::powi(strength.threshold(delta), 2))
    }

    /// The ways of a start: inward from a vertex of the rim, both ways from inside.
    fn rays(&self, surface: &Surface, site: TearSite, d: DVec3, step: f64) -> Option<SmallVec<[Ray; 2]>> {
        match site {
            TearSite::Vertex(vertex) => {
                let at = surface.vertices.rest_position[vertex as usize];
                let triangle = triangle_ahead(surface, vertex, d * (PROBED_AHEAD * step))?;
                Some(smallvec![Ray { at, ahead: d, triangle }])
            }
            TearSite::Triangle(triangle) => {
                let [a, b, c] = corners(surface, triangle);
                let at = (a + b + c) / 3.0;
                Some([d, -d].into_iter().map(|ahead| Ray { at, ahead, triangle }).collect())
            }
        }
    }

    /// The criterion of strength at the position of a ray, and the tractions released there.
    fn sample(&self, surface: &Surface, ray: &Ray, (disc, walk): CoupledBuffers<'_>) -> Option<(f64, Sample)> {
        let axes = [ray.ahead, ray.normal(surface).cross(ray.ahead)];
        let average = disc_average(surface, ray.at, axes, self.tearing.radius, [ray.triangle], (disc, walk))?;
        let triangle = ray.triangle as usize;
        let strength = strength(self.tearing).times(surface.triangles.strength[triangle]);
        let criterion = direction_value(average.stress, average.fibre, &strength, DVec2::X);
        let delta = elementary::atan2(average.fibre.y.abs(), average.fibre.x.abs());
        let toughness = self.toughness().threshold(delta) * surface.triangles.toughness[triangle];
        Some((criterion, Sample { opening: average.stress.yy, sliding: average.stress.xy, toughness }))
    }
}

impl Ray {
    fn normal(&self, surface: &Surface) -> DVec3 {
        let [a, b, c] = corners(surface, self.triangle);
        (b - a).cross(c - a).normalize_or(DVec3::Z)
    }

    /// Goes on by a length \[mm\]; `false` where a boundary is nearer.
    fn go_on(&mut self, surface: &Surface, length: f64) -> bool {
        let to = self.at + self.ahead * length;
        for _ in 0..MOST_CROSSED_BY_STEP {
            let x = corners(surface, self.triangle);
            let weights = barycentric(x, to);
            let mut outside: SmallVec<[usize; 3]> = (0..3).filter(|&i| weights[i] < -1e-9).collect();
            if outside.is_empty() {
                let normal = self.normal(surface);
                self.at = to - normal * (to - x[0]).dot(normal);
                self.ahead = (self.ahead - normal * normal.dot(self.ahead)).normalize_or(self.ahead);
                return true;
            }
            outside.sort_by(|&a, &b| weights[a].total_cmp(&weights[b]));
            let neighbours = surface.topology.neighbours[self.triangle as usize];
            let Some(next) = outside.into_iter().map(|i| neighbours[(i + 1) % 3]).find(|&n| n != NONE) else {
                return false;
            };
            self.triangle = next;
        }
        false
    }
}

/// G \[N/mm\], summed over the tips, of a crack of this length on the ways, of which a point is known at each multiple of `step`.
fn release(crack: &CrackTip, ways: &[Vec<Sample>], length: f64, step: f64) -> f64 {
    let of = |way: &[Sample], x: f64| {
        let place = (x / step).clamp(0.0, way.len() as f64 - 1.0);
        let (row, part) = (place as usize, place.fract());
        let [a, b] = [row, row + 1].map(|row| way[row.min(way.len() - 1)]);
        DVec2::new(a.opening, a.sliding) * (1.0 - part) + DVec2::new(b.opening, b.sliding) * part
    };
    let nodes = || (0..POINTS).map(|i| (f64::from(i) + 0.5) / f64::from(POINTS));
    let intensities: SmallVec<[DVec2; 2]> = match ways {
        [rim] => {
            // With x = a·(1 − s²).
            let weight = |s: f64| 2.0 * (1.0 + RIM[0] * s * s + RIM[1] * elementary::powi(s, 4));
            let sum: DVec2 = nodes().map(|s| of(rim, length * (1.0 - s * s)) * weight(s)).sum();
            smallvec![sum * ((2.0 * length / PI).sqrt() / f64::from(POINTS))]
        }
        _ => {
            // With x = a·sin t, from the middle; the weight of either tip is (1 ± sin t)·√(a/π).
            let scale = (length / PI).sqrt() * FRAC_PI_2 / f64::from(POINTS);
            let mut sums: SmallVec<[DVec2; 2]> = smallvec![DVec2::ZERO; ways.len()];
            for sin in nodes().map(|s| elementary::sin_cos(FRAC_PI_2 * s).0) {
                for (near, way) in ways.iter().enumerate() {
                    let traction = of(way, length * sin) * scale;
                    for (tip, sum) in sums.iter_mut().enumerate() {
                        *sum += traction * if tip == near { 1.0 + sin } else { 1.0 - sin };
                    }
                }
            }
            sums
        }
    };
    // Pressed lips release by sliding alone.
    intensities.iter().map(|k| crack.energy_release(k.x.max(0.0), k.y)).sum()
}

/// Mean of values at equal distances, by the trapezoidal rule.
fn mean(way: &[Sample], of: impl Fn(&Sample) -> f64) -> f64 {
    let sum: f64 = way.windows(2).map(|pair| 0.5 * (of(&pair[0]) + of(&pair[1]))).sum();
    sum / (way.len() - 1).max(1) as f64
}

/// The triangle at a vertex that a way \[mm\] from it enters, or comes nearest to.
fn triangle_ahead(surface: &Surface, vertex: u32, way: DVec3) -> Option<u32> {
    let to = surface.vertices.rest_position.get(vertex as usize)? + way;
    let least = |[a, b, c]: [f64; 3]| a.min(b).min(c);
    let within = |t: u32| least(barycentric(corners(surface, t), to));
    let around = surface.topology.incident.get(vertex as usize)?.iter().map(|entry| entry / 3);
    around.max_by(|&a, &b| within(a).total_cmp(&within(b)))
}

/// Angle \[rad\] of a triangle's fibre from a direction, counter-clockwise about its normal.
fn angle_of_fibre(surface: &Surface, triangle: usize, d: DVec3) -> f64 {
    let [a, b, c] = corners(surface, triangle as u32);
    let (fibre, across) = (surface.triangles.fibre[triangle], (b - a).cross(c - a).normalize_or(DVec3::Z).cross(d));
    elementary::atan2(fibre.dot(across), fibre.dot(d))
}

/// Rest positions \[mm\] of a triangle's corners.
fn corners(surface: &Surface, triangle: u32) -> [DVec3; 3] {
    surface.triangles.corners[triangle as usize].map(|v| surface.vertices.rest_position[v as usize])
}

/// Barycentric weights of a point's foot in the plane of a triangle.
fn barycentric([a, b, c]: [DVec3; 3], p: DVec3) -> [f64; 3] {
    let normal = (b - a).cross(c - a);
    let part = |u: DVec3, v: DVec3| (u - p).cross(v - p).dot(normal) / normal.length_squared();
    [part(b, c), part(c, a), part(a, b)]
}
