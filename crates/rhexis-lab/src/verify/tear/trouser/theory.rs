//! Where a trouser tear goes and what it takes.

use super::sheet::{HELD, LEGS, LENGTH, THICKNESS, Trouser};
use glam::DVec2;
use std::f64::consts::FRAC_PI_2;

/// Length of a step along the path \[mm\].
const STEP: f64 = 0.05;
/// Directions that are tried \[°\].
const FINE: f64 = 0.02;

/// The path that theory gives to a tear.
pub(super) struct Path {
    /// From the end of the cut on \[mm\], to the right.
    points: Vec<DVec2>,
    /// Pull of a leg at each of them, of legs that do not stretch \[N\].
    pulls: Vec<f64>,
}

impl Trouser {
    /// Toughness against a tear at so large an angle from the line of the cut \[N/mm\].
    fn toughness_at(&self, psi: f64) -> f64 {
        let [degrees, ratio, exponent] = self.fibres.unwrap_or([0.0, 1.0, 1.0]);
        let delta = (psi - degrees.to_radians()).abs() / FRAC_PI_2;
        self.toughness * (1.0 + (ratio - 1.0) * delta.powf(exponent))
    }

    /// The direction of the largest Σ cos(ψ − ψᵢ)/G_c(ψ − θ).
    fn best(&self, ways: [f64; 2]) -> f64 {
        let gain = |psi: f64| ways.iter().map(|way| (psi - way).cos()).sum::<f64>() / self.toughness_at(psi);
        let angles = (0..=(90.0 / FINE) as u32).map(|i| (f64::from(i) * FINE).to_radians());
        angles.max_by(|a, b| gain(*a).total_cmp(&gain(*b))).unwrap_or_default()
    }

    /// Where it turns at first: both legs pull along the cut.
    pub(super) fn first_direction(&self) -> f64 {
        self.best([0.0; 2])
    }

    /// Whether theory has the tear turn on after its first advance, by more than a degree.
    pub(super) fn turns(&self) -> bool {
        let first = self.first_direction();
        let ahead = DVec2::new(first.sin(), first.cos()) * LEGS;
        (self.direction(ahead, first) - first).abs() > 1_f64.to_radians()
    }

    /// The direction from a place aside of and ahead of the end of the cut, for a tear that has come in the direction `psi`.
    /// The last directions ψᵢ are those of the shortest ways within the legs from grip to tip. On the side from which the
    /// tear turns away that leads round the end of the cut and along its lip, on the other it is straight.
    pub(super) fn direction(&self, at: DVec2, psi: f64) -> f64 {
        self.best([psi, straight(at)])
    }
}

/// Direction of the straight way to a tip from the grip on its side.
fn straight(tip: DVec2) -> f64 {
    (tip.x - 0.5 * HELD).atan2(LEGS + tip.y)
}

impl Path {
    /// So many mm of it at the most.
    pub(super) fn new(trouser: &Trouser, length: f64) -> Self {
        let start = DVec2::new(0.0, LENGTH - LEGS);
        let (mut tip, mut psi) = (DVec2::ZERO, 0.0);
        let (mut points, mut pulls) = (vec![start], Vec::new());
        while points.len() as f64 * STEP < length && tip.y < start.y {
            let ways = [psi, straight(tip)];
            psi = trouser.direction(tip, psi);
            let release: f64 = ways.iter().map(|way| (psi - way).cos()).sum();
            pulls.push(THICKNESS * trouser.toughness_at(psi) / release);
            tip += DVec2::new(psi.sin(), psi.cos()) * STEP;
            points.push(start + DVec2::new(tip.x, -tip.y));
        }
        Self { points, pulls }
    }

    /// The pull of a leg after so many mm of tear \[N\]; not a number beyond its end.
    pub(super) fn pull(&self, torn: f64) -> f64 {
        self.pulls.get((torn / STEP) as usize).copied().unwrap_or(f64::NAN)
    }

    /// The largest distance of points from it \[mm\], on either side.
    pub(super) fn off(&self, path: &[DVec2]) -> f64 {
        let side = path.last().map_or(1.0, |p| 1.0_f64.copysign(p.x));
        let distance = |p: &DVec2| {
            let p = DVec2::new(p.x * side, p.y);
            self.points.iter().map(|q| q.distance(p)).fold(f64::INFINITY, f64::min)
        };
        path.iter().map(distance).fold(0.0, f64::max)
    }
}
