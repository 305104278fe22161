//! Noise that is the same in every run.

use glam::DVec3;

/// Uniform in −1 … 1 (splitmix64 of a counter).
pub fn noise(i: usize) -> f64 {
    let mut z = (i as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// Three of them for a vertex.
pub fn noises(v: usize, seed: usize) -> DVec3 {
    let first = 1_000_003 * seed + 3 * v;
    DVec3::new(noise(first), noise(first + 1), noise(first + 2))
}
