//! Vertices at one place become one.

use std::collections::HashMap;

use glam::DVec3;

/// Cells are no smaller than this part of the largest coordinate, so that their numbers stay exact.
const LEAST_CELL: f64 = 4e-16;

/// For each position the first one that lies within `tolerance` \[mm\] of it and is not itself joined to another. Linear in their
/// number: those that stand for themselves keep apart, so that a cell holds few of them.
pub(super) fn representatives(positions: &[DVec3], tolerance: f64) -> Vec<u32> {
    let largest = positions.iter().map(|p| p.abs().max_element()).filter(|x| x.is_finite()).fold(0.0, f64::max);
    let side = tolerance.max(LEAST_CELL * largest).max(f64::MIN_POSITIVE);
    let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    let mut out = Vec::with_capacity(positions.len());
    for (row, p) in positions.iter().enumerate() {
        let row = row as u32;
        if !p.is_finite() {
            out.push(row);
            continue;
        }
        let cell = (*p / side).floor().to_array().map(|x| x as i64);
        let mut found: Option<u32> = None;
        for i in 0..27 {
            let step = [i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1];
            let near = [0, 1, 2].map(|axis| cell[axis].saturating_add(step[axis]));
            for &other in cells.get(&near).into_iter().flatten() {
                if positions[other as usize].distance(*p) <= tolerance && found.is_none_or(|first| other < first) {
                    found = Some(other);
                }
            }
        }
        if found.is_none() {
            cells.entry(cell).or_default().push(row);
        }
        out.push(found.unwrap_or(row));
    }
    out
}

/// How many vertices lie where another one does: within 1e-9 of the extent.
pub(crate) fn coincident(positions: &[DVec3]) -> usize {
    let (low, high) =
        positions.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
    let joined = representatives(positions, 1e-9 * (high - low).max_element().max(0.0));
    joined.iter().enumerate().filter(|(row, first)| *row != **first as usize).count()
}
