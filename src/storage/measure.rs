//! Quantities that follow from the tables: rest triangles, lumped masses, totals.
//!
//! Rest data and masses are pure functions of corners, rest positions, fibres, thickness and density. Edits recompute them
//! for the rows they touch, so that patched and rebuilt values have the same bits.

use super::{Broken, Mesh, Topology, TriangleRow, Triangles, Vertices};
use crate::math::{RestTriangle, smallest_angle};
use glam::DVec3;

/// Mass \[g\] of a triangle.
pub fn triangle_mass(triangle: &TriangleRow) -> f64 {
    triangle.rest.area * triangle.thickness * triangle.density
}

/// Lumped mass \[g\] of a vertex: a third of every triangle around it, in ascending order of rows.
pub fn lumped_mass(triangles: &Triangles, topology: &Topology, vertex: u32) -> f64 {
    // As `triangle_mass`, of three columns only: an edit sums the masses of all vertices around it.
    let mass = |t: usize| triangles.rest[t].area * triangles.thickness[t] * triangles.density[t];
    topology.incident[vertex as usize].iter().map(|&entry| mass((entry / 3) as usize) / 3.0).sum()
}

/// Computes the rest data of all triangles and the masses of all vertices: for the start, and as the oracle of edits.
///
/// # Errors
/// [`Broken::RestArea`] for a triangle without area; the tables may be partly rewritten then.
pub fn rest_data(mesh: &mut Mesh<'_>) -> Result<(), Broken> {
    for row in 0..mesh.triangles.len() {
        let corners = rest_corners(mesh.vertices, mesh.triangles.corners[row]);
        let rest = RestTriangle::new(corners, mesh.triangles.fibre[row]);
        mesh.triangles.rest[row] = rest.ok_or(Broken::RestArea { triangle: row as u32 })?;
    }
    for row in 0..mesh.vertices.len() {
        mesh.vertices.mass[row] = lumped_mass(mesh.triangles, mesh.topology, row as u32);
    }
    Ok(())
}

/// Rest positions \[mm\] of three vertices.
pub fn rest_corners(vertices: &Vertices, corners: [u32; 3]) -> [DVec3; 3] {
    corners.map(|c| vertices.rest_position[c as usize])
}

/// Total rest area \[mm²\].
pub fn total_area(triangles: &Triangles) -> f64 {
    triangles.rest.iter().map(|rest| rest.area).sum()
}

/// Total mass \[g\].
pub fn total_mass(vertices: &Vertices) -> f64 {
    vertices.mass.iter().sum()
}

/// Linear momentum \[g·mm/ms\].
pub fn linear_momentum(vertices: &Vertices) -> DVec3 {
    vertices.velocity.iter().zip(&vertices.mass).map(|(&v, &m)| v * m).sum()
}

/// The smallest angle \[rad\] of every triangle in the rest shape.
pub fn rest_angles<'a>(vertices: &'a Vertices, triangles: &'a Triangles) -> impl Iterator<Item = f64> + 'a {
    triangles.corners.iter().map(|&corners| smallest_angle(rest_corners(vertices, corners)))
}
