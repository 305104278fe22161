//! Random numbers, mostly such as make sense.

use rhexis_c::types::*;

/// Xorshift64* (Vigna 2016): the same calls on every machine.
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    pub fn below(&mut self, count: usize) -> usize {
        (self.next() >> 33) as usize % count
    }

    pub fn chance(&mut self, one_in: usize) -> bool {
        self.below(one_in) == 0
    }

    pub fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.below(from.len())]
    }

    /// Mostly a length or a time that makes sense.
    pub fn number(&mut self) -> f64 {
        const HOSTILE: [f64; 10] =
            [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -0.0, -1.0, 1e-300, 1e300, f64::MAX, f64::MIN_POSITIVE];
        if self.chance(12) { self.pick(&HOSTILE) } else { (self.next() >> 11) as f64 / (1u64 << 53) as f64 * 4.0 }
    }

    pub fn vector(&mut self) -> RhexisVec3 {
        RhexisVec3 { x: self.number(), y: self.number(), z: self.number() - 2.0 }
    }

    pub fn pose(&mut self) -> RhexisPose {
        let mut pose =
            RhexisPose { position: self.vector(), orientation: RhexisQuat { x: 0.0, y: 0.0, z: 0.0, w: 1.0 } };
        if self.chance(8) {
            pose.orientation.x = self.number();
        }
        pose
    }
}
