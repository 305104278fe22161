//! Whether lists of corners are the same, told without a copy of the one before.

use xxhash_rust::xxh3::Xxh3;

/// Triangles that are handed to the hash at once.
const AT_ONCE: usize = 64;

/// The number of some triangles and 64 bits of their corners, by XXH3: others have the same bits with a probability of 2⁻⁶⁴, less than that
/// of a fault of the memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Fingerprint {
    count: usize,
    bits: u64,
}

impl Fingerprint {
    /// That of some corners.
    pub(super) fn of(corners: &[[u32; 3]]) -> Self {
        let mut hash = Xxh3::new();
        let mut bytes = [[0; 4]; 3 * AT_ONCE];
        for corners in corners.chunks(AT_ONCE) {
            let corners = corners.as_flattened();
            bytes.iter_mut().zip(corners).for_each(|(bytes, corner)| *bytes = corner.to_le_bytes());
            hash.update(bytes[..corners.len()].as_flattened());
        }
        Self { count: corners.len(), bits: hash.digest() }
    }
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
