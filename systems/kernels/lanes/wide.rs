//! The registers of 256 bits of a wide processor (AVX2).

use super::Lanes;
use glam::Vec4;
use pulp::x86::V3;
use std::arch::x86_64::{__m128, __m256, __m256d, _CMP_GT_OQ};

/// Transposes the 4×4 matrix in either half.
#[inline(always)]
fn transpose(v3: V3, [a, b, c, d]: [__m256; 4]) -> [__m256; 4] {
    let avx = v3.avx;
    let (ab, cd) = (avx._mm256_unpacklo_ps(a, b), avx._mm256_unpacklo_ps(c, d));
    let (ab_high, cd_high) = (avx._mm256_unpackhi_ps(a, b), avx._mm256_unpackhi_ps(c, d));
    [
        avx._mm256_shuffle_ps::<0b01_00_01_00>(ab, cd),
        avx._mm256_shuffle_ps::<0b11_10_11_10>(ab, cd),
        avx._mm256_shuffle_ps::<0b01_00_01_00>(ab_high, cd_high),
        avx._mm256_shuffle_ps::<0b11_10_11_10>(ab_high, cd_high),
    ]
}

impl Lanes for V3 {
    type Singles = __m256;
    type Doubles = __m256d;

    const HAS_DOUBLES: bool = true;

    #[inline(always)]
    fn singles(self, [low, high]: [Vec4; 2]) -> __m256 {
        self.avx._mm256_set_m128(high.into(), low.into())
    }
    #[inline(always)]
    fn single_array(self, x: __m256) -> [Vec4; 2] {
        let high: __m128 = self.avx._mm256_extractf128_ps::<1>(x);
        [self.avx._mm256_castps256_ps128(x).into(), high.into()]
    }
    #[inline(always)]
    fn add_singles(self, a: __m256, b: __m256) -> __m256 {
        self.avx._mm256_add_ps(a, b)
    }
    #[inline(always)]
    fn sub_singles(self, a: __m256, b: __m256) -> __m256 {
        self.avx._mm256_sub_ps(a, b)
    }
    #[inline(always)]
    fn mul_singles(self, a: __m256, b: __m256) -> __m256 {
        self.avx._mm256_mul_ps(a, b)
    }
    #[inline(always)]
    fn components(self, rows: [Vec4; 8]) -> [__m256; 3] {
        let (a, b) = (self.singles([rows[0], rows[4]]), self.singles([rows[1], rows[5]]));
        let (c, d) = (self.singles([rows[2], rows[6]]), self.singles([rows[3], rows[7]]));
        let [x, y, z, _] = transpose(self, [a, b, c, d]);
        [x, y, z]
    }
    #[inline(always)]
    fn rows(self, [x, y, z]: [__m256; 3]) -> [Vec4; 8] {
        let [a, b, c, d] = transpose(self, [x, y, z, self.avx._mm256_setzero_ps()]);
        let [a, e] = self.single_array(a);
        let [b, f] = self.single_array(b);
        let [c, g] = self.single_array(c);
        let [d, h] = self.single_array(d);
        [a, b, c, d, e, f, g, h]
    }

    #[inline(always)]
    fn spread(self, x: __m256) -> [__m256; 3] {
        let avx = self.avx;
        [
            avx._mm256_permute_ps::<0b00_00_00_00>(x),
            avx._mm256_permute_ps::<0b01_01_01_01>(x),
            avx._mm256_permute_ps::<0b10_10_10_10>(x),
        ]
    }
    #[inline(always)]
    fn sums(self, [a, b, c]: [__m256; 3]) -> __m256 {
        let (avx, zero) = (self.avx, self.avx._mm256_setzero_ps());
        let ab = avx._mm256_add_ps(avx._mm256_unpacklo_ps(a, b), avx._mm256_unpackhi_ps(a, b));
        let c = avx._mm256_add_ps(avx._mm256_unpacklo_ps(c, zero), avx._mm256_unpackhi_ps(c, zero));
        let even = avx._mm256_shuffle_ps::<0b01_00_01_00>(ab, c);
        avx._mm256_add_ps(even, avx._mm256_shuffle_ps::<0b11_10_11_10>(ab, c))
    }

    #[inline(always)]
    fn doubles(self, x: [f64; 4]) -> __m256d {
        self.avx._mm256_setr_pd(x[0], x[1], x[2], x[3])
    }
    #[inline(always)]
    fn widened(self, x: Vec4) -> __m256d {
        self.avx._mm256_cvtps_pd(x.into())
    }
    #[inline(always)]
    fn double_array(self, x: __m256d) -> [f64; 4] {
        let [low, high] = [self.avx._mm256_castpd256_pd128(x), self.avx._mm256_extractf128_pd::<1>(x)];
        let sse2 = self.sse2;
        let (b, d) = (sse2._mm_unpackhi_pd(low, low), sse2._mm_unpackhi_pd(high, high));
        [sse2._mm_cvtsd_f64(low), sse2._mm_cvtsd_f64(b), sse2._mm_cvtsd_f64(high), sse2._mm_cvtsd_f64(d)]
    }
    #[inline(always)]
    fn add_doubles(self, a: __m256d, b: __m256d) -> __m256d {
        self.avx._mm256_add_pd(a, b)
    }
    #[inline(always)]
    fn sub_doubles(self, a: __m256d, b: __m256d) -> __m256d {
        self.avx._mm256_sub_pd(a, b)
    }
    #[inline(always)]
    fn mul_doubles(self, a: __m256d, b: __m256d) -> __m256d {
        self.avx._mm256_mul_pd(a, b)
    }
    #[inline(always)]
    fn div_doubles(self, a: __m256d, b: __m256d) -> __m256d {
        self.avx._mm256_div_pd(a, b)
    }
    #[inline(always)]
    fn sqrt_doubles(self, a: __m256d) -> __m256d {
        self.avx._mm256_sqrt_pd(a)
    }
    #[inline(always)]
    fn max_doubles(self, a: __m256d, b: __m256d) -> __m256d {
        self.avx._mm256_max_pd(a, b)
    }
    #[inline(always)]
    fn are_larger(self, a: __m256d, b: __m256d) -> bool {
        let avx = self.avx;
        avx._mm256_movemask_pd(avx._mm256_cmp_pd::<_CMP_GT_OQ>(a, b)) == 0b1111
    }
    #[inline(always)]
    fn transpose_doubles(self, [a, b, c, d]: [__m256d; 4]) -> [__m256d; 4] {
        let avx = self.avx;
        let (ab, cd) = (avx._mm256_unpacklo_pd(a, b), avx._mm256_unpacklo_pd(c, d));
        let (ab_odd, cd_odd) = (avx._mm256_unpackhi_pd(a, b), avx._mm256_unpackhi_pd(c, d));
        [
            avx._mm256_permute2f128_pd::<0x20>(ab, cd),
            avx._mm256_permute2f128_pd::<0x20>(ab_odd, cd_odd),
            avx._mm256_permute2f128_pd::<0x31>(ab, cd),
            avx._mm256_permute2f128_pd::<0x31>(ab_odd, cd_odd),
        ]
    }
}
