//! Whether lists of corners are the same, told without a copy of the one before.

/// Numbers that are hashed side by side: a multiplication waits for the one before it.
const SIDE_BY_SIDE: usize = 8;

/// An odd number without a pattern in its bits, by which every step multiplies: 2⁶⁴ over the golden ratio.
const FACTOR: u64 = 0x9e37_79b9_7f4a_7c15;

/// The number of some triangles and 64 bits of their corners: others have the same bits with a probability of 2⁻⁶⁴, less than that of a
/// fault of the memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fingerprint {
    count: usize,
    bits: u64,
}

impl Fingerprint {
    /// That of some corners.
    pub fn of(corners: &[[u32; 3]]) -> Self {
        let mut lanes: [u64; SIDE_BY_SIDE] = std::array::from_fn(|lane| FACTOR.wrapping_mul(lane as u64 + 1));
        let (pairs, rest) = corners.as_flattened().as_chunks::<2>();
        for pairs in pairs.chunks(SIDE_BY_SIDE) {
            for (lane, [a, b]) in lanes.iter_mut().zip(pairs) {
                *lane = mixed(*lane, u64::from(*a) | u64::from(*b) << 32);
            }
        }
        let lanes = lanes.into_iter().chain(rest.iter().map(|&corner| corner.into()));
        Self { count: corners.len(), bits: lanes.fold(FACTOR, mixed) }
    }
}

#[inline(always)]
fn mixed(bits: u64, value: u64) -> u64 {
    let product = (bits ^ value).wrapping_mul(FACTOR);
    product ^ (product >> 32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whatever_is_changed_shows() {
        for count in [0, 1, 2, 3, 8, 100] {
            let corners: Vec<[u32; 3]> = (0..count).map(|t| [t, t + 1, t + 2]).collect();
            let fingerprint = Fingerprint::of(&corners);
            assert_eq!(fingerprint, Fingerprint::of(&corners.clone()));
            for t in 0..corners.len() {
                for bit in 0..32 {
                    let mut other = corners.clone();
                    other[t][bit % 3] ^= 1 << bit;
                    assert_ne!(fingerprint, Fingerprint::of(&other), "bit {bit} of triangle {t} of {count}");
                }
                for u in 0..t {
                    let mut other = corners.clone();
                    other.swap(t, u);
                    assert_ne!(fingerprint, Fingerprint::of(&other), "triangles {t} and {u} of {count} swapped");
                }
            }
            assert_ne!(fingerprint, Fingerprint::of(&[&corners[..], &[[0; 3]]].concat()));
        }
    }
}
