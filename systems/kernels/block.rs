//! 3×3 blocks in single precision, as three columns of four numbers of which the last is zero: what every processor can load at
//! once.

use glam::{DMat3, DVec3, Mat4, Vec4, Vec4Swizzles};

/// Columns.
pub type Block = [Vec4; 3];

/// The zero block.
pub const ZERO: Block = [Vec4::ZERO; 3];

/// A pivot below this fraction of the block's own diagonal is taken for none: single precision leaves no digit of it.
const LEAST_PIVOT: f64 = 1e-6;

/// The product with a vector.
#[inline(always)]
pub fn apply(a: &Block, v: Vec4) -> Vec4 {
    a[0] * v.xxxx() + a[1] * v.yyyy() + a[2] * v.zzzz()
}

/// a += b.
#[inline(always)]
pub fn add(a: &mut Block, b: &Block) {
    for (a, b) in a.iter_mut().zip(b) {
        *a += *b;
    }
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
/// positive, measured by the diagonal of `own`.
#[inline(always)]
pub fn invert(a: &Block, own: &Block, free: Vec4) -> Option<Block> {
    // In double precision: the determinant is a cube, and would leave the range of single precision.
    let free = free.truncate().as_dvec3();
    let least = DVec3::new(own[0].x.into(), own[1].y.into(), own[2].z.into()) * LEAST_PIVOT;
    let [x, y, z] = a.map(|column| column.truncate().as_dvec3());
    let fixed = DVec3::ONE - free;
    let d1 = x.x + fixed.x;
    let (l2, l3) = (x.y / d1, x.z / d1);
    let d2 = y.y + fixed.y - l2 * x.y;
    let m = y.z - l2 * x.z;
    let n3 = m / d2;
    let d3 = z.z + fixed.z - l3 * x.z - n3 * m;
    if !(d1 > least.x && d2 > least.y && d3 > least.z) {
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

/// What stands for the inverse of a symmetric block that has none: that of its mean stiffness; zero for an empty block.
#[inline(always)]
pub fn invert_alone(own: &Block, free: Vec4) -> Block {
    let free = free * Vec4::new(1.0, 1.0, 1.0, 0.0);
    let trace = (Vec4::new(own[0].x, own[1].y, own[2].z, 0.0).abs() * free).element_sum();
    let mean = if trace > 0.0 && trace.is_finite() { free * (free.element_sum() / trace) } else { Vec4::ZERO };
    [Vec4::X * mean, Vec4::Y * mean, Vec4::Z * mean]
}
