//! Block Jacobi: the inverse of each vertex' 3×3 diagonal block.

use super::Operator;
use crate::components::FreeAxes;
use crate::math::Sym3;
use crate::systems::parallel;
use glam::{DMat3, DVec3};

/// A block's weakest direction is raised to this fraction of its strongest, so that a direction without any stiffness (a
/// slack vertex in a static solve) has an inverse.
const LEAST_RATIO: f64 = 1e-12;

/// Fills the lists with the inverse blocks \[mm/N\], restricted to the free axes: xx, yy, zz and yz, zx, xy; where nothing is free along z
/// xx, yy, xy, and nothing in the second.
pub(super) fn invert_blocks(operator: &Operator, free: &FreeAxes, [first, second]: &mut [Vec<DVec3>; 2]) {
    let is_flat = free.are_flat();
    first.resize(free.len(), DVec3::ZERO);
    second.resize(if is_flat { 0 } else { free.len() }, DVec3::ZERO);
    let of_vertex = |v: usize| invert(operator.diagonal_block(v), free[v]);
    if is_flat {
        return parallel::for_rows(first, |v, inverse| {
            let DMat3 { x_axis: x, y_axis: y, .. } = of_vertex(v);
            *inverse = DVec3::new(x.x, y.y, x.y);
        });
    }
    parallel::for_pairs(first, second, |start, first, second| {
        for (v, (first, second)) in (start..).zip(first.iter_mut().zip(second)) {
            let DMat3 { x_axis: x, y_axis: y, z_axis: z } = of_vertex(v);
            (*first, *second) = (DVec3::new(x.x, y.y, z.z), DVec3::new(y.z, z.x, x.y));
        }
    });
}

/// The inverse of a block \[mm/N\], restricted to the free axes.
pub(super) fn invert(block: DMat3, free: DVec3) -> DMat3 {
    // Prescribed rows and columns become those of the identity, and leave again after inversion.
    let mask = DMat3::from_diagonal(free);
    let trace = block.x_axis.x.abs() * free.x + block.y_axis.y.abs() * free.y + block.z_axis.z.abs() * free.z;
    if !(trace > 0.0 && trace.is_finite()) {
        return DMat3::ZERO;
    }
    let shift = DMat3::from_diagonal(free * (trace * LEAST_RATIO) + (DVec3::ONE - free) * trace);
    let inverse = (mask * block * mask + shift).inverse();
    let symmetric = (inverse + inverse.transpose()) * 0.5;
    // An indefinite block (exact tangent under compression) is replaced by its mean stiffness.
    let is_positive = [symmetric.x_axis.x, symmetric.y_axis.y, symmetric.z_axis.z].iter().all(|&d| d > 0.0)
        && symmetric.determinant() > 0.0;
    let inverse = if is_positive && symmetric.is_finite() {
        symmetric
    } else {
        DMat3::from_diagonal(DVec3::splat((free.x + free.y + free.z) / trace))
    };
    mask * inverse * mask
}

/// z = M⁻¹·r; returns r·z.
pub(super) fn apply([first, second]: &[Vec<DVec3>; 2], r: &[DVec3], z: &mut [DVec3], partials: &mut Vec<f64>) -> f64 {
    if second.is_empty() {
        return parallel::sum_rows(z, partials, |v, z| {
            let (b, r) = (first[v], r[v]);
            *z = DVec3::new(b.x * r.x + b.z * r.y, b.z * r.x + b.y * r.y, 0.0);
            r.dot(*z)
        });
    }
    parallel::sum_rows(z, partials, |v, z| {
        *z = Sym3 { diagonal: first[v], beside: second[v] } * r[v];
        r[v].dot(*z)
    })
}
