//! Proof that the parts of a pair have not met: a direction that tells them apart at the start and at the end. Parts whose ways are straight have a plane
//! between them all the way then, which moves with them. Layers that move together are free by it.

use crate::components::{Pair, PairStart};
use glam::DVec3;

/// Gap to be left between the parts of a pair, over that at the start, or over the radius if that is less.
const LEFT: f64 = 0.2;

/// Gap at the start along a direction of a proof, over the distance.
const TOLD_APART: f64 = 0.3;

/// Verdict on a pair's ways.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Proof {
    /// They have not met.
    Apart,
    /// They met at the start: they are left alone.
    Touching,
    /// No direction tells them apart; `missing` is how much of the gap is missing \[mm\] along the nearest one.
    Through { normal: DVec3, target: f64, missing: f64 },
}

impl Proof {
    /// Looks for a direction that tells a pair apart at both ends.
    pub(super) fn new(
        (pair, &PairStart { normal, distance }): (&Pair, &PairStart),
        start: &[DVec3],
        end: &[DVec3],
        radius: f64,
    ) -> Self {
        if !(distance > 1e-9 * radius) {
            return Self::Touching;
        }
        let target = LEFT * distance.min(radius);
        let missing = target - pair.heights(normal, end).gap();
        if missing <= target * 1e-9 {
            return Self::Apart;
        }
        let mut best = (normal, missing);
        for direction in [pair.across(start), pair.across(end), pair.nearest(end).way] {
            let Some(direction) = direction.try_normalize() else { continue };
            for normal in [direction, -direction] {
                if pair.heights(normal, start).gap() < (TOLD_APART * distance).max(target).min(radius) {
                    continue;
                }
                let missing = target - pair.heights(normal, end).gap();
                if missing < best.1 {
                    best = (normal, missing);
                }
            }
        }
        let (normal, missing) = best;
        if missing <= target * 1e-9 { Self::Apart } else { Self::Through { normal, target, missing } }
    }
}
