//! Effect of an edit on the shapes of triangles, for whoever has to choose among edits.

use super::draft::draft;
use super::measure::rest_corners;
use super::{Edit, Mesh, Refusal};
use crate::math::smallest_angle;
use std::f64::consts::PI;

/// The triangles that an edit touches, in the rest shape. The elastic energy is left to callers who know the stress.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outlook {
    /// Smallest angle \[rad\] of the triangles that the edit would change or remove, as they are.
    pub smallest_angle_before: f64,
    /// Smallest angle \[rad\] of the triangles that it would leave in their place.
    pub smallest_angle: f64,
    /// Longest edge of those \[mm\].
    pub longest_edge: f64,
}

/// Outlook of an edit; nothing changes.
///
/// # Errors
/// Why the edit would be refused.
pub fn outlook(mesh: &Mesh<'_>, edit: &Edit) -> Result<Outlook, Refusal> {
    let draft = draft(mesh, edit)?;
    let mut outlook = Outlook { smallest_angle_before: PI, smallest_angle: PI, longest_edge: 0.0 };
    for &row in draft.changed.iter().map(|(row, _)| row).chain(&draft.removed_triangles) {
        let rest = rest_corners(mesh.vertices, mesh.triangles.corners[row as usize]);
        outlook.smallest_angle_before = outlook.smallest_angle_before.min(smallest_angle(rest));
    }
    let new = |row: u32| draft.new_vertices.get((row as usize).checked_sub(mesh.vertices.len())?).map(|(_, v)| *v);
    let moved = |row: u32| draft.moved.filter(|&(moved, _)| moved == row).map(|(_, v)| v);
    for (_, triangle) in draft.changed.iter().chain(&draft.added) {
        let rest = triangle.corners.map(|row| new(row).or_else(|| moved(row)).unwrap_or_else(|| mesh.vertices.at(row)));
        let rest = rest.map(|vertex| vertex.rest_position);
        outlook.smallest_angle = outlook.smallest_angle.min(smallest_angle(rest));
        let edges = [0, 1, 2].map(|i| rest[i].distance(rest[(i + 1) % 3]));
        outlook.longest_edge = edges.into_iter().fold(outlook.longest_edge, f64::max);
    }
    Ok(outlook)
}
