//! The polar decomposition F = R·U of a membrane's 3×2 deformation gradient, in closed form and without dividing by det U.
//!
//! With n the unit normal and t = tr U = √(|f₁|² + |f₂|² + 2|f₁×f₂|): R = (F + [f₂×n, n×f₁])/t and U = Rᵀ·F. At an area ratio
//! of 1e-8 this R is orthonormal to rounding, where √det(FᵀF) has lost every digit.

use super::formulas::{Rotated, least_area, lengths_sq, rotated_about, rotated_in_plane};
use super::simd::LANES;
use crate::math::{Polar, Sym2};
use glam::DVec3;

/// Polar decomposition of a membrane in space: the columns `f1`, `f2` of F are images of the rest axes.
///
/// Where the triangle has collapsed to a segment the normal is a fixed perpendicular of it, where it has collapsed to a
/// point the rotation is the identity; U is right in both cases, so the force that opens the triangle again is too.
#[inline]
pub fn membrane(f1: DVec3, f2: DVec3) -> Polar {
    let f = [f1.to_array(), f2.to_array()];
    let cross = f1.cross(f2);
    let twice_area = cross.length();
    let trace = (lengths_sq(f) + 2.0 * twice_area).sqrt();
    let normal = if twice_area > least_area(f) {
        // Not by one over the area, as lanes have it: that of a triangle by itself may be next to nothing.
        cross / twice_area
    } else if trace > 0.0 {
        let longer = if f1.length_squared() >= f2.length_squared() { f1 } else { f2 };
        longer.normalize_or(DVec3::X).any_orthonormal_vector()
    } else {
        return Polar { fibre_axis: DVec3::X, transverse_axis: DVec3::Y, stretch: Sym2::ZERO };
    };
    polar(rotated_about(f, normal.to_array(), trace))
}

/// Polar decomposition of a body that stays in the plane z = const. The normal is fixed to +z and the area is signed. So a mirrored
/// triangle has a stretch that is far from the identity and a force that turns it back.
#[inline]
pub fn planar(f1: DVec3, f2: DVec3) -> Polar {
    let f = [f1.with_z(0.0).to_array(), f2.with_z(0.0).to_array()];
    let (rotated, trace_sq) = rotated_in_plane(f);
    // A pure mirror image has no nearest rotation (any R gives a symmetric RᵀF): the identity is as good as all others.
    if trace_sq.sqrt() <= 1e-14 * lengths_sq(f).sqrt() || trace_sq == 0.0 {
        let xy = 0.5 * (f2.x + f1.y);
        return Polar { fibre_axis: DVec3::X, transverse_axis: DVec3::Y, stretch: Sym2::new(f1.x, f2.y, xy) };
    }
    polar(rotated)
}

fn polar(Rotated { axes: [r1, r2], stretch }: Rotated<f64>) -> Polar {
    Polar {
        fibre_axis: DVec3::from_array(r1),
        transverse_axis: DVec3::from_array(r2),
        stretch: Sym2::from_array(stretch),
    }
}

/// The stretches U alone of several triangles, half as dear as [`planar`] or [`membrane`]: with C = FᵀF and the area ratio J,
/// U = (C + J·I)/tr U. Side by side, so that the compiler finds the lanes of its vectors.
#[inline]
pub fn stretches(f: &[(DVec3, DVec3); LANES], is_planar: bool) -> [Sym2; LANES] {
    let component = |pick: fn(&(DVec3, DVec3)) -> f64| f.each_ref().map(pick);
    let [ax, ay, mut az] = [component(|f| f.0.x), component(|f| f.0.y), component(|f| f.0.z)];
    let [bx, by, mut bz] = [component(|f| f.1.x), component(|f| f.1.y), component(|f| f.1.z)];
    if is_planar {
        (az, bz) = ([0.0; LANES], [0.0; LANES]);
    }
    let (mut u, mut is_sound) = ([[0.0; LANES]; 3], [true; LANES]);
    for i in 0..LANES {
        let c11 = ax[i] * ax[i] + ay[i] * ay[i] + az[i] * az[i];
        let c22 = bx[i] * bx[i] + by[i] * by[i] + bz[i] * bz[i];
        let c12 = ax[i] * bx[i] + ay[i] * by[i] + az[i] * bz[i];
        let nz = ax[i] * by[i] - ay[i] * bx[i];
        let (area, trace_sq) = if is_planar {
            // Not C11 + C22 + 2J: near a mirror image that cancels.
            let (even, odd) = (ax[i] + by[i], ay[i] - bx[i]);
            (nz, even * even + odd * odd)
        } else {
            let (nx, ny) = (ay[i] * bz[i] - az[i] * by[i], az[i] * bx[i] - ax[i] * bz[i]);
            let area = (nx * nx + ny * ny + nz * nz).sqrt();
            (area, c11 + c22 + 2.0 * area)
        };
        let inverse = 1.0 / trace_sq.sqrt();
        for (u, value) in u.iter_mut().zip([c11 + area, c22 + area, c12]) {
            u[i] = value * inverse;
        }
        // Nearer to a mirror image C + J·I loses digits as well.
        is_sound[i] = trace_sq > 1e-4 * (c11 + c22);
    }
    std::array::from_fn(|i| {
        let full = if is_planar { planar } else { membrane };
        if is_sound[i] { Sym2::new(u[0][i], u[1][i], u[2][i]) } else { full(f[i].0, f[i].1).stretch }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DMat3, DQuat};

    fn parts(rotation: DMat3, u: Sym2) -> (DVec3, DVec3) {
        (rotation * DVec3::new(u.xx, u.xy, 0.0), rotation * DVec3::new(u.xy, u.yy, 0.0))
    }

    #[test]
    fn finds_rotation_and_stretch_down_to_an_area_ratio_of_1e_8() {
        let rotation = DMat3::from_quat(DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 2.0) / 3.0, 2.39));
        for squeeze in [1.0, 0.3, 1e-4, 1e-8] {
            let u = Sym2::new(1.2, squeeze, 0.0).in_axes_turned_by(0.3);
            let (f1, f2) = parts(rotation, u);
            let p = membrane(f1, f2);
            // Orthonormal to rounding; the direction of the thin axis is known to rounding over the squeeze, U is not hurt by that.
            assert!(
                (p.fibre_axis.length() - 1.0).abs() < 1e-15 * 4.0 && p.fibre_axis.dot(p.transverse_axis).abs() < 1e-15
            );
            let d = p.stretch - u;
            assert!(d.xx.abs().max(d.yy.abs()).max(d.xy.abs()) < 1e-14, "{squeeze}: {d:?}");
        }
    }

    #[test]
    fn the_stretch_alone_is_the_same() {
        let columns = [DVec3::ZERO, DVec3::X, DVec3::new(0.3, -1.1, 0.2), DVec3::new(-0.9, 1e-9, 0.0), DVec3::Y * 1e-8];
        for (f1, f2) in columns.into_iter().flat_map(|f1| columns.map(|f2| (f1, f2))) {
            let flat = |f: DVec3| DVec3::new(f.x, f.y, 0.0);
            let around = [(DVec3::X, DVec3::Y); LANES];
            let alone = |f1, f2, is_planar| {
                let mut batch = around;
                batch[1] = (f1, f2);
                stretches(&batch, is_planar)[1]
            };
            for (alone, full) in [
                (alone(f1, f2, false), membrane(f1, f2).stretch),
                (alone(flat(f1), flat(f2), true), planar(flat(f1), flat(f2)).stretch),
            ] {
                let d = alone - full;
                // Some roundings of numbers of size one.
                assert!(d.xx.abs().max(d.yy.abs()).max(d.xy.abs()) < 1e-14, "{f1} {f2}: {alone:?} {full:?}");
            }
        }
    }

    #[test]
    fn collapsed_triangles_have_a_frame() {
        for (f1, f2) in [(DVec3::ZERO, DVec3::ZERO), (DVec3::X, DVec3::X * 2.0), (DVec3::ZERO, DVec3::Z)] {
            let p = membrane(f1, f2);
            assert!((p.fibre_axis.length() - 1.0).abs() < 1e-14 && p.fibre_axis.dot(p.transverse_axis).abs() < 1e-14);
            assert!(p.stretch.is_finite());
        }
    }

    #[test]
    fn a_mirrored_planar_triangle_is_far_from_rest() {
        let p = planar(DVec3::X, -DVec3::Y);
        assert_eq!(p.stretch, Sym2::new(1.0, -1.0, 0.0));
        let slightly = planar(DVec3::X, DVec3::new(0.1, -0.9, 0.0));
        assert!((slightly.fibre_axis.length() - 1.0).abs() < 1e-14 && slightly.stretch.determinant() < 0.0);
    }
}
