//! 3×3 blocks in single precision, as three columns of four numbers of which the last is zero: a layout that every processor can load
//! at once.

use glam::{DMat3, DVec3, Mat4, Vec4, Vec4Swizzles};

/// Columns.
pub type Block = [Vec4; 3];

/// The zero block.
pub const ZERO: Block = [Vec4::ZERO; 3];

/// A pivot of an elimination below this fraction of its diagonal entry is taken for none: single precision has left no digit
/// of it.
pub(super) const LEAST_PIVOT: f64 = 1e-7;

/// The product with a vector.
#[inline(always)]
pub fn apply(a: &Block, v: Vec4) -> Vec4 {
    a[0] * v.xxxx() + a[1] * v.yyyy() + a[2] * v.zzzz()
}

/// The product of the transpose with a vector.
#[inline(always)]
pub fn apply_transposed(a: &Block, v: Vec4) -> Vec4 {
    let [x, y, z] = transpose(&[a[0] * v, a[1] * v, a[2] * v]);
    x + y + z
}

/// a += b.
#[inline(always)]
pub fn add(a: &mut Block, b: &Block) {
    for (a, b) in a.iter_mut().zip(b) {
        *a += *b;
    }
}

/// a + b·factor.
#[inline(always)]
pub fn sum(a: &Block, b: &Block, factor: f32) -> Block {
    [a[0] + b[0] * factor, a[1] + b[1] * factor, a[2] + b[2] * factor]
}

/// The product a·b.
#[inline(always)]
pub fn product(a: &Block, b: &Block) -> Block {
    b.map(|column| apply(a, column))
}

/// c −= a·bᵀ.
#[inline(always)]
pub fn subtract_product_transposed(c: &mut Block, a: &Block, b: &Block) {
    c[0] -= a[0] * b[0].xxxx() + a[1] * b[1].xxxx() + a[2] * b[2].xxxx();
    c[1] -= a[0] * b[0].yyyy() + a[1] * b[1].yyyy() + a[2] * b[2].yyyy();
    c[2] -= a[0] * b[0].zzzz() + a[1] * b[1].zzzz() + a[2] * b[2].zzzz();
}

/// The transpose.
#[inline(always)]
pub fn transpose(a: &Block) -> Block {
    let t = Mat4::from_cols(a[0], a[1], a[2], Vec4::ZERO).transpose();
    [t.x_axis, t.y_axis, t.z_axis]
}

/// The rows and columns that are free (1), zeros elsewhere.
#[inline(always)]
pub fn mask(a: &Block, rows: Vec4, columns: Vec4) -> Block {
    [a[0] * (rows * columns.xxxx()), a[1] * (rows * columns.yyyy()), a[2] * (rows * columns.zzzz())]
}

/// The inverse of a symmetric block on its free axes (1 free, 0 prescribed), zero along the others. `None` where it is not
/// positive.
#[inline(always)]
pub fn invert(a: &Block, free: Vec4) -> Option<Block> {
    // In double precision: the determinant is a cube, and would leave the range of single precision.
    let free = free.truncate().as_dvec3();
    let fixed = DVec3::ONE - free;
    let [x, y, z] = a.map(|column| column.truncate().as_dvec3());
    let d1 = x.x + fixed.x;
    let (l2, l3) = (x.y / d1, x.z / d1);
    let d2 = y.y + fixed.y - l2 * x.y;
    let m = y.z - l2 * x.z;
    let n3 = m / d2;
    let d3 = z.z + fixed.z - l3 * x.z - n3 * m;
    let is_positive = d1 > 0.0 && d2 > y.y * LEAST_PIVOT && d3 > z.z * LEAST_PIVOT;
    if !(is_positive && (d1 + d2 + d3).is_finite()) {
        return None;
    }
    // L⁻ᵀ·D⁻¹·L⁻¹ with L⁻¹ = [1; −l2, 1; l2·n3 − l3, −n3, 1].
    let p = l2 * n3 - l3;
    let (e1, e2, e3) = (1.0 / d1, 1.0 / d2, 1.0 / d3);
    let inverse = DMat3::from_cols(
        DVec3::new(e1 + l2 * l2 * e2 + p * p * e3, -l2 * e2 - p * n3 * e3, p * e3),
        DVec3::new(-l2 * e2 - p * n3 * e3, e2 + n3 * n3 * e3, -n3 * e3),
        DVec3::new(p * e3, -n3 * e3, e3),
    );
    let column = |c: DVec3, f: f64| (c * free * f).as_vec3().extend(0.0);
    Some([column(inverse.x_axis, free.x), column(inverse.y_axis, free.y), column(inverse.z_axis, free.z)])
}

/// Whether a symmetric block is positive on its free axes (1 free, 0 prescribed): by elimination without a
/// division, in double precision, because a soft direction leaves few digits of a stiff one.
#[inline(always)]
pub fn is_positive(a: &Block, free: Vec4) -> bool {
    let fixed = DVec3::ONE - free.truncate().as_dvec3();
    let [x, y, z] = a.map(|column| column.truncate().as_dvec3());
    let (xx, yy, zz) = (x.x + fixed.x, y.y + fixed.y, z.z + fixed.z);
    let (yy, yz, zz) = (xx * yy - x.y * x.y, xx * y.z - x.y * x.z, xx * zz - x.z * x.z);
    xx > 0.0 && yy > 0.0 && yy * zz - yz * yz > 0.0
}

/// Substitute for the inverse of a symmetric block that has none: that of its mean stiffness; zero for an empty block.
#[inline(always)]
pub fn invert_alone(own: &Block, free: Vec4) -> Block {
    let free = free * Vec4::new(1.0, 1.0, 1.0, 0.0);
    let trace = (Vec4::new(own[0].x, own[1].y, own[2].z, 0.0).abs() * free).element_sum();
    let mean = if trace > 0.0 && trace.is_finite() { free * (free.element_sum() / trace) } else { Vec4::ZERO };
    [Vec4::X * mean, Vec4::Y * mean, Vec4::Z * mean]
}

#[cfg(test)]
mod tests {
    use super::*;

    const FREE: Vec4 = Vec4::new(1.0, 1.0, 1.0, 0.0);

    /// Stiff along one direction, soft across it by `ratio`, as a slack triangle is along its normal.
    fn soft(ratio: f32) -> Block {
        let n = Vec4::new(0.6, 0.48, 0.64, 0.0);
        [Vec4::X, Vec4::Y, Vec4::Z].map(|axis| axis - n * (n.dot(axis) * (1.0 - ratio)))
    }

    #[test]
    fn an_inverse_undoes_its_block() {
        let v = Vec4::new(0.3, -0.7, 0.5, 0.0);
        let inverse = invert(&soft(1e-3), FREE).unwrap();
        // The inverse has entries up to 1e3, each with half of 1.2e-7 of them lost.
        assert!((apply(&inverse, apply(&soft(1e-3), v)) - v).length() < 1e3 * 4.0 * f32::EPSILON);
    }

    #[test]
    fn prescribed_axes_stay_zero() {
        for free in [Vec4::new(1.0, 0.0, 1.0, 0.0), Vec4::new(0.0, 0.0, 1.0, 0.0), Vec4::ZERO] {
            let a = mask(&soft(0.5), free, free);
            assert!(is_positive(&a, free));
            for inverse in [invert(&a, free).unwrap(), invert_alone(&a, free)] {
                let image = apply(&inverse, Vec4::ONE);
                assert_eq!(image * (Vec4::ONE - free), Vec4::ZERO);
            }
        }
    }

    #[test]
    fn what_is_not_positive_has_no_inverse() {
        assert!(is_positive(&soft(1e-4), FREE) && !is_positive(&soft(-1e-4), FREE));
        assert!(invert(&soft(-0.1), FREE).is_none() && invert(&ZERO, FREE).is_none());
        let nan = [Vec4::NAN; 3];
        assert!(invert(&nan, FREE).is_none() && invert_alone(&nan, FREE) == ZERO);
        assert_eq!(invert_alone(&ZERO, FREE), ZERO);
    }
}
