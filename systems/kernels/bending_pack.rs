//! Bending of eight triangles side by side in single precision, in three passes with other triangles between them. They find tilts
//! of a displacement, moments of the tilts of both sides, and forces of the moments of both sides.
//!
//! Layout: eight numbers per entry, a lane per triangle. Tilts and moments of a pack are 24 numbers, edge by edge, and those of
//! all packs one list: an edge is found from across by its place in that.
//!
//! Tilts are times the length of their edge here, laws over both. The edges e₀, e₁, e₂ follow one after the other, and
//! cₑ = eₑ·eₑ₊₁/(2·area). Heights a and b of corners 1 and 2 over corner 0 tilt by c₂·(a − b) − c₀·b, c₁·a + c₀·b and
//! −c₁·a − c₂·(a − b). So three numbers do, the cₑ, which are minus the cotangents of the angles; and the tilts sum to zero.

use super::bending::{forces_along, symmetric_product, tilts};
use super::formulas::{dot, less, scaled};
use super::lanes::{Lanes, SINGLES, Singles};
use super::pack::LANES;
use glam::Vec4;

/// Numbers of a pack in the lists of tilts and moments.
pub const NUMBERS: usize = 3 * LANES;

/// One number of each of eight triangles.
type Entry = [f32; SINGLES];

/// Bending data of eight triangles; a lane without one has zeros.
#[derive(Clone, Copy, Debug, Default)]
pub struct BendingPack {
    /// Components of the normal.
    pub normal: [Entry; 3],
    /// cₑ.
    pub minus_cotangent: [Entry; 3],
    /// A quarter of the law between edges that have a triangle across, over the lengths of both: 00, 11, 22, 01, 12, 20 \[N/mm\].
    pub law: [Entry; 6],
    /// Place of every edge as the triangle across has it; its own at the boundary.
    pub across: [[u32; LANES]; 3],
    /// Rows of the corners.
    pub row: [[u32; LANES]; 3],
}

impl BendingPack {
    /// The tilts by a displacement `u` of all rows.
    #[inline(always)]
    pub fn tilt<L: Lanes>(&self, lanes: L, u: &[Vec4], tilts_of_pack: &mut [f32; NUMBERS]) {
        let u0 = gather(lanes, &self.row[0], u);
        let (u1, u2) = (gather(lanes, &self.row[1], u), gather(lanes, &self.row[2], u));
        let n = [entry(lanes, &self.normal[0]), entry(lanes, &self.normal[1]), entry(lanes, &self.normal[2])];
        put(tilts(self.minus_cotangents(lanes), dot(n, less(u1, u0)), dot(n, less(u2, u0))), tilts_of_pack);
    }

    /// Half the moments of its triangles by the tilts of all.
    #[inline(always)]
    pub fn moment<L: Lanes>(&self, lanes: L, pack: usize, tilts: &[f32], moments: &mut [f32; NUMBERS]) {
        let both = self.with_others(lanes, pack, tilts);
        let mut q = [both[0]; 6];
        for i in 0..6 {
            q[i] = entry(lanes, &self.law[i]);
        }
        put(symmetric_product(&q, both), moments);
    }

    /// The forces on corners 1 and 2 by the moments of all.
    #[inline(always)]
    pub fn forces<L: Lanes>(&self, lanes: L, pack: usize, moments: &[f32]) -> [[Singles<L>; 3]; 2] {
        let m = self.with_others(lanes, pack, moments);
        let n = [entry(lanes, &self.normal[0]), entry(lanes, &self.normal[1]), entry(lanes, &self.normal[2])];
        let [_, along, across] = forces_along(self.minus_cotangents(lanes), m);
        [scaled(n, along), scaled(n, across)]
    }

    #[inline(always)]
    fn minus_cotangents<L: Lanes>(&self, lanes: L) -> [Singles<L>; 3] {
        let [a, b, c] = &self.minus_cotangent;
        [entry(lanes, a), entry(lanes, b), entry(lanes, c)]
    }

    /// The sums of its triangles' values and those across at their edges; anything at the boundary.
    #[inline(always)]
    fn with_others<L: Lanes>(&self, lanes: L, pack: usize, all: &[f32]) -> [Singles<L>; 3] {
        let mut sums = [Singles::splat(lanes, 0.0); 3];
        for e in 0..3 {
            let own = &all[pack * NUMBERS + e * LANES..][..LANES];
            let a = &self.across[e];
            let low = Vec4::new(all[a[0] as usize], all[a[1] as usize], all[a[2] as usize], all[a[3] as usize]);
            let high = Vec4::new(all[a[4] as usize], all[a[5] as usize], all[a[6] as usize], all[a[7] as usize]);
            let own = Singles::new(lanes, [Vec4::from_slice(&own[..4]), Vec4::from_slice(&own[4..])]);
            sums[e] = own + Singles::new(lanes, [low, high]);
        }
        sums
    }
}

/// Eight rows' vectors by components.
#[inline(always)]
fn gather<L: Lanes>(lanes: L, row: &[u32; LANES], u: &[Vec4]) -> [Singles<L>; 3] {
    let mut rows = [Vec4::ZERO; LANES];
    for lane in 0..LANES {
        rows[lane] = u[row[lane] as usize];
    }
    Singles::components(lanes, rows)
}

#[inline(always)]
fn entry<L: Lanes>(lanes: L, x: &Entry) -> Singles<L> {
    Singles::new(lanes, [Vec4::from_slice(&x[..4]), Vec4::from_slice(&x[4..])])
}

#[inline(always)]
fn put<L: Lanes>(values: [Singles<L>; 3], out: &mut [f32; NUMBERS]) {
    for e in 0..3 {
        let [low, high] = values[e].to_array();
        low.write_to_slice(&mut out[e * LANES..e * LANES + 4]);
        high.write_to_slice(&mut out[e * LANES + 4..(e + 1) * LANES]);
    }
}
