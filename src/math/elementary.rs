//! Elementary functions with the same bits on every platform: those of the crate `libm`, in place of the system's.
//!
//! Sine, exponential and the like are not exactly rounded anywhere, and each system's library errs in its own last digits; a tear
//! that they turn goes on elsewhere. Square roots, absolute values, floors and fused multiply-adds are exactly rounded by IEEE 754, and stay those of
//! the machine. Everything that a step or a scene's geometry computes comes from here; `clippy.toml` refuses the others.

use glam::{DQuat, DVec2, DVec3};
use num_complex::Complex64;

/// The sine of an angle \[rad\].
#[inline]
pub fn sin(x: f64) -> f64 {
    libm::sin(x)
}

/// The cosine of an angle \[rad\].
#[inline]
pub fn cos(x: f64) -> f64 {
    libm::cos(x)
}

/// The sine and the cosine of an angle \[rad\].
#[inline]
pub fn sin_cos(x: f64) -> (f64, f64) {
    libm::sincos(x)
}

/// The tangent of an angle \[rad\].
#[inline]
pub fn tan(x: f64) -> f64 {
    libm::tan(x)
}

/// The angle \[rad\] in \[−π/2, π/2\] of a sine.
#[inline]
pub(crate) fn asin(x: f64) -> f64 {
    libm::asin(x)
}

/// The angle \[rad\] in \[0, π\] of a cosine.
#[inline]
pub fn acos(x: f64) -> f64 {
    libm::acos(x)
}

/// The angle \[rad\] in \[−π/2, π/2\] of a tangent.
#[inline]
pub(crate) fn atan(x: f64) -> f64 {
    libm::atan(x)
}

/// The angle \[rad\] in \[−π, π\] of the point (x, y) from the x axis.
#[inline]
pub fn atan2(y: f64, x: f64) -> f64 {
    libm::atan2(y, x)
}

/// eˣ.
#[inline]
pub fn exp(x: f64) -> f64 {
    libm::exp(x)
}

/// eˣ − 1, exact to rounding near zero.
#[inline]
pub(crate) fn exp_m1(x: f64) -> f64 {
    libm::expm1(x)
}

/// The natural logarithm.
#[inline]
pub fn ln(x: f64) -> f64 {
    libm::log(x)
}

/// The logarithm to base ten.
#[inline]
pub fn log10(x: f64) -> f64 {
    libm::log10(x)
}

/// xᵉ; x itself for e = 1.
#[inline]
pub fn pow(x: f64, e: f64) -> f64 {
    libm::pow(x, e)
}

/// xⁿ by repeated squaring, whose order of products is fixed here: that of `powi` is left to the compiler.
#[inline]
pub fn powi(mut x: f64, mut n: u32) -> f64 {
    let mut power = 1.0;
    while n > 0 {
        if n & 1 == 1 {
            power *= x;
        }
        x *= x;
        n >>= 1;
    }
    power
}

/// √(x² + y²) without overflow on the way.
#[inline]
pub fn hypot(x: f64, y: f64) -> f64 {
    libm::hypot(x, y)
}

/// 2ⁿ, exactly; n is taken into \[−1022, 1023\].
#[inline]
pub(crate) fn power_of_two(n: i32) -> f64 {
    f64::from_bits(((n.clamp(-1022, 1023) + 1023) as u64) << 52)
}

/// The whole n with 2ⁿ ≤ |x| < 2ⁿ⁺¹ of a normal number.
#[inline]
pub fn exponent(x: f64) -> i32 {
    (x.to_bits() >> 52 & 0x7ff) as i32 - 1023
}

/// The unit vector at an angle \[rad\] counter-clockwise from x.
#[inline]
pub fn unit_at(angle: f64) -> DVec2 {
    let (s, c) = sin_cos(angle);
    DVec2::new(c, s)
}

/// The angle \[rad\] in \[−π, π\] of a vector from x.
#[inline]
pub(crate) fn angle_of(v: DVec2) -> f64 {
    atan2(v.y, v.x)
}

/// The angle \[rad\] in \[−π, π\] counter-clockwise from one vector to another.
#[inline]
pub fn turn(from: DVec2, to: DVec2) -> f64 {
    atan2(from.perp_dot(to), from.dot(to))
}

/// The rotation about a unit axis by an angle \[rad\].
pub fn rotation(axis: DVec3, angle: f64) -> DQuat {
    let (s, c) = sin_cos(0.5 * angle);
    let v = axis * s;
    DQuat::from_xyzw(v.x, v.y, v.z, c)
}

/// The rotation that is `part` of the shorter way from `a` to `b`, at an even speed (Shoemake 1985).
pub(crate) fn slerp(a: DQuat, b: DQuat, part: f64) -> DQuat {
    let dot = a.dot(b);
    let (b, dot) = if dot < 0.0 { (-b, -dot) } else { (b, dot) };
    if dot > 1.0 - f64::EPSILON {
        return a.lerp(b, part);
    }
    let angle = acos(dot.clamp(-1.0, 1.0));
    let [from, to] = [angle * (1.0 - part), angle * part].map(sin);
    (a * from + b * to) * (1.0 / sin(angle))
}

/// The square root with a positive real part, or on the imaginary axis.
pub(crate) fn complex_sqrt(z: Complex64) -> Complex64 {
    let norm = hypot(z.re, z.im);
    // Of the two parts the one that does not cancel first.
    let larger = (0.5 * (norm + z.re.abs())).sqrt();
    if larger == 0.0 {
        return Complex64::ZERO;
    }
    let other = 0.5 * z.im.abs() / larger;
    if z.re >= 0.0 {
        Complex64::new(larger, other.copysign(z.im))
    } else {
        Complex64::new(other, larger.copysign(z.im))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Errors of two good libraries in units of the last place, each below one for these functions.
    fn agree(ours: f64, other: f64) -> bool {
        ours == other || (ours - other).abs() <= 2.0 * f64::EPSILON * other.abs().max(f64::MIN_POSITIVE)
    }

    proptest! {
        #[test]
        fn agrees_with_the_systems_to_the_last_digits(x in -30.0..30.0_f64, y in 0.0..30.0_f64, e in -3.0..3.0_f64) {
            let pairs = [
                (sin(x), x.sin()), (cos(x), x.cos()), (tan(x), x.tan()), (sin_cos(x).0, x.sin()), (sin_cos(x).1, x.cos()),
                (asin(x / 30.0), (x / 30.0).asin()), (acos(x / 30.0), (x / 30.0).acos()), (atan(x), x.atan()),
                (atan2(x, e), x.atan2(e)), (exp(x), x.exp()), (exp_m1(x), x.exp_m1()), (ln(y), y.ln()), (log10(y), y.log10()),
                (pow(y, e), y.powf(e)), (hypot(x, y), x.hypot(y)), (powi(x, 3), x * x * x), (pow(y, 1.0), y),
                (angle_of(DVec2::new(x, y)), y.atan2(x)), (unit_at(x).x, x.cos()), (unit_at(x).y, x.sin()),
            ];
            for (i, (ours, other)) in pairs.into_iter().enumerate() {
                prop_assert!(agree(ours, other), "{i}: {ours:e}, {other:e}");
            }
        }

        #[test]
        fn rotations_are_those_of_glam(x in -1.0..1.0_f64, angle in -3.0..3.0_f64, other in -3.0..3.0_f64, part in 0.0..1.0_f64) {
            let axis = DVec3::new(x, 0.3, 0.7).normalize();
            let (a, b) = (rotation(axis, angle), rotation(DVec3::Y, other));
            prop_assert!(a.abs_diff_eq(DQuat::from_axis_angle(axis, angle), 1e-15));
            prop_assert!(slerp(a, b, part).abs_diff_eq(a.slerp(b, part), 1e-12));
        }

        #[test]
        fn complex_roots_squared_are_the_number(re in -1e3..1e3_f64, im in -1e3..1e3_f64) {
            for z in [Complex64::new(re, im), Complex64::new(re, 0.0), Complex64::new(0.0, im)] {
                let root = complex_sqrt(z);
                prop_assert!(root.re >= 0.0 && (root * root - z).norm() <= 4.0 * f64::EPSILON * z.norm(), "{z}: {root}");
            }
        }
    }

    #[test]
    fn powers_of_two_and_their_exponents_are_exact() {
        for n in -1022..=1023 {
            assert_eq!(power_of_two(n), 2.0_f64.powi(n));
            assert_eq!(exponent(power_of_two(n) * 1.999), n);
        }
        assert_eq!(exponent(1.0_f64.next_down()), -1);
        assert_eq!(complex_sqrt(Complex64::ZERO), Complex64::ZERO);
        assert_eq!(complex_sqrt(Complex64::new(-4.0, 0.0)), Complex64::new(0.0, 2.0));
    }
}
