//! The validator: names the first broken invariant of a body's tables.

use super::{Topology, Triangles, Vertices, measure};
use crate::math::RestTriangle;

/// A broken invariant.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Broken {
    /// A column's length differs from the number of keys.
    #[error("column {column} of table {table} is out of step with its keys")]
    Misaligned {
        /// The table.
        table: &'static str,
        /// The column.
        column: &'static str,
    },
    /// A triangle refers to a vertex that is not there.
    #[error("triangle {triangle} refers to vertex {vertex}, which does not exist")]
    CornerRange {
        /// Row of the triangle.
        triangle: u32,
        /// The vertex it names.
        vertex: u32,
    },
    /// Two corners of a triangle are the same vertex.
    #[error("triangle {triangle} has a vertex twice")]
    RepeatedCorner {
        /// Row of the triangle.
        triangle: u32,
    },
    /// More than one triangle has this directed edge: not a manifold, or not oriented the same way.
    #[error("more than one triangle runs from vertex {from} to vertex {to}")]
    EdgeUsedTwice {
        /// Row of the first vertex.
        from: u32,
        /// Row of the second vertex.
        to: u32,
    },
    /// A vertex belongs to no triangle.
    #[error("vertex {vertex} belongs to no triangle")]
    LooseVertex {
        /// Row of the vertex.
        vertex: u32,
    },
    /// Triangles around a vertex are joined in that vertex only.
    #[error("the triangles around vertex {vertex} form more than one fan")]
    Bowtie {
        /// Row of the vertex.
        vertex: u32,
    },
    /// A neighbour list disagrees with the corners.
    #[error("the neighbours of triangle {triangle} differ from a rebuild")]
    Neighbours {
        /// Row of the triangle.
        triangle: u32,
    },
    /// An incidence list disagrees with the corners, or is not sorted.
    #[error("the triangles around vertex {vertex} differ from a rebuild")]
    Incidence {
        /// Row of the vertex.
        vertex: u32,
    },
    /// A position or velocity is not a finite number.
    #[error("{column} of vertex {vertex} is not finite")]
    NotFinite {
        /// The column.
        column: &'static str,
        /// Row of the vertex.
        vertex: u32,
    },
    /// A triangle has no area in the rest shape.
    #[error("triangle {triangle} has no area in the rest shape")]
    RestArea {
        /// Row of the triangle.
        triangle: u32,
    },
    /// Rest data disagree with corners, rest positions and fibre.
    #[error("the rest data of triangle {triangle} differ from a rebuild")]
    RestData {
        /// Row of the triangle.
        triangle: u32,
    },
    /// A mass differs from the sum over the triangles around the vertex, or is not positive.
    #[error("the mass of vertex {vertex} is not the sum over its triangles")]
    Mass {
        /// Row of the vertex.
        vertex: u32,
    },
}

/// Checks every invariant of the tables and the topology.
///
/// # Errors
/// The first broken invariant, in the order: columns, corners, edges, fans, topology against a rebuild, finite state, rest
/// data, masses.
pub fn validate(vertices: &Vertices, triangles: &Triangles, topology: &Topology) -> Result<(), Broken> {
    if let Some(column) = vertices.first_misaligned_column() {
        return Err(Broken::Misaligned { table: "vertices", column });
    }
    if let Some(column) = triangles.first_misaligned_column() {
        return Err(Broken::Misaligned { table: "triangles", column });
    }
    let rebuilt = Topology::new(vertices.len(), &triangles.corners)?;
    same_topology(topology, &rebuilt)?;
    for row in 0..vertices.len() {
        let columns = [
            ("position", vertices.position[row]),
            ("velocity", vertices.velocity[row]),
            ("rest_position", vertices.rest_position[row]),
        ];
        if let Some((column, _)) = columns.into_iter().find(|(_, value)| !value.is_finite()) {
            return Err(Broken::NotFinite { column, vertex: row as u32 });
        }
    }
    for row in 0..triangles.len() {
        let triangle = row as u32;
        let corners = measure::rest_corners(vertices, triangles.corners[row]);
        let rest = RestTriangle::new(corners, triangles.fibre[row]).ok_or(Broken::RestArea { triangle })?;
        if rest != triangles.rest[row] {
            return Err(Broken::RestData { triangle });
        }
    }
    for row in 0..vertices.len() {
        let mass = vertices.mass[row];
        let is_sum = mass == measure::lumped_mass(triangles, topology, row as u32);
        if !is_sum || mass <= 0.0 {
            return Err(Broken::Mass { vertex: row as u32 });
        }
    }
    Ok(())
}

fn same_topology(topology: &Topology, rebuilt: &Topology) -> Result<(), Broken> {
    if topology.neighbours.len() != rebuilt.neighbours.len() {
        return Err(Broken::Misaligned { table: "topology", column: "neighbours" });
    }
    if topology.incident.len() != rebuilt.incident.len() {
        return Err(Broken::Misaligned { table: "topology", column: "incident" });
    }
    let differs = topology.neighbours.iter().zip(&rebuilt.neighbours).position(|(a, b)| a != b);
    if let Some(triangle) = differs {
        return Err(Broken::Neighbours { triangle: triangle as u32 });
    }
    let differs = topology.incident.iter().zip(&rebuilt.incident).position(|(a, b)| a != b);
    match differs {
        Some(vertex) => Err(Broken::Incidence { vertex: vertex as u32 }),
        None => Ok(()),
    }
}
