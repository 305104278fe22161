//! A new order of a mesh's rows: along a space-filling curve through the rest shape. Neighbours in the tissue are then near in
//! memory, whatever edits have put at the end of the tables.
//!
//! Keys stay with the parts they name. Whoever keeps rows maps them by the [`Order`].

use super::{Mesh, NONE, Vertices, measure};
use glam::DVec3;

/// Bits per axis of a place on the curve: three axes fit into 64.
const BITS: u32 = 21;

/// An order of vertices and triangles, to be brought into a mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Order {
    /// Per new row of a vertex its old one.
    pub vertices: Vec<u32>,
    /// Per new row of a triangle its old one.
    pub triangles: Vec<u32>,
    /// Per old row of a vertex its new one.
    vertex_rows: Vec<u32>,
    /// Per old row of a triangle its new one.
    triangle_rows: Vec<u32>,
}

impl Order {
    /// Vertices by their places, and triangles by their centroids, along Hilbert's curve (1891). Of those at one place, as on
    /// the two lips of a tear, the first stays the first.
    pub fn along_curve(mesh: &Mesh<'_>) -> Self {
        let curve = Curve::through(mesh.vertices);
        let centroid = |corners: &[u32; 3]| measure::rest_corners(mesh.vertices, *corners).iter().sum::<DVec3>() / 3.0;
        let vertices = sorted(mesh.vertices.rest_position.iter().map(|&x| curve.place(x)));
        let triangles = sorted(mesh.triangles.corners.iter().map(|corners| curve.place(centroid(corners))));
        let (vertex_rows, triangle_rows) = (inverse(&vertices), inverse(&triangles));
        Self { vertices, triangles, vertex_rows, triangle_rows }
    }

    /// The new row of the vertex in an old one.
    pub fn vertex(&self, old: u32) -> u32 {
        self.vertex_rows[old as usize]
    }

    /// The new row of the triangle in an old one.
    pub fn triangle(&self, old: u32) -> u32 {
        self.triangle_rows[old as usize]
    }

    /// Sorts a list of vertices' values; one of another length belongs to another mesh and is emptied.
    pub fn sort_vertices<T: Copy>(&self, values: &mut Vec<T>) {
        sort(&self.vertices, values);
    }

    /// Sorts a list of triangles' values; one of another length belongs to another mesh and is emptied.
    pub fn sort_triangles<T: Copy>(&self, values: &mut Vec<T>) {
        sort(&self.triangles, values);
    }
}

/// Brings a mesh into an order. Every column keeps its bits but the masses, whose sums run over the triangles in their new order.
pub fn reorder(mesh: &mut Mesh<'_>, order: &Order) {
    mesh.vertices.permute(&order.vertices);
    mesh.triangles.permute(&order.triangles);
    if let Some(relaxing) = &mut mesh.triangles.relaxing {
        relaxing.sort(&order.triangles);
    }
    for corner in mesh.triangles.corners.as_flattened_mut() {
        *corner = order.vertex(*corner);
    }
    let topology = &mut *mesh.topology;
    order.sort_triangles(&mut topology.neighbours);
    for neighbour in topology.neighbours.as_flattened_mut().iter_mut().filter(|row| **row != NONE) {
        *neighbour = order.triangle(*neighbour);
    }
    let mut incident = Vec::with_capacity(topology.incident.capacity());
    incident.extend(order.vertices.iter().map(|&old| std::mem::take(&mut topology.incident[old as usize])));
    for around in &mut incident {
        around.iter_mut().for_each(|entry| *entry = 3 * order.triangle(*entry / 3) + *entry % 3);
        around.sort_unstable();
    }
    topology.incident = incident;
    topology.log.renew();
    for vertex in 0..mesh.vertices.len() {
        mesh.vertices.mass[vertex] = measure::lumped_mass(mesh.triangles, mesh.topology, vertex as u32);
    }
    debug_assert_eq!(mesh.validate(), Ok(()), "after a new order");
}

fn sorted(places: impl Iterator<Item = u64>) -> Vec<u32> {
    let mut rows: Vec<(u64, u32)> = places.zip(0..).collect();
    rows.sort_unstable();
    rows.into_iter().map(|(_, row)| row).collect()
}

fn inverse(order: &[u32]) -> Vec<u32> {
    let mut rows = vec![0; order.len()];
    (0..).zip(order).for_each(|(new, &old)| rows[old as usize] = new);
    rows
}

/// Brings values into an order, which has the old place of every new one; reserved room stays. Values of another length belong
/// to another mesh and are emptied.
pub fn sort<T: Copy>(order: &[u32], values: &mut Vec<T>) {
    if values.len() != order.len() {
        return values.clear();
    }
    let mut sorted = Vec::with_capacity(values.capacity());
    sorted.extend(order.iter().map(|&old| values[old as usize]));
    *values = sorted;
}

/// Hilbert's curve through the box around a shape.
struct Curve {
    low: DVec3,
    scale: f64,
}

impl Curve {
    fn through(vertices: &Vertices) -> Self {
        let corner =
            |pick: fn(DVec3, DVec3) -> DVec3| vertices.rest_position.iter().copied().reduce(pick).unwrap_or_default();
        let (low, high) = (corner(DVec3::min), corner(DVec3::max));
        Self { low, scale: f64::from((1 << BITS) - 1) / (high - low).max_element().max(f64::MIN_POSITIVE) }
    }

    /// How far along the curve a point comes (Skilling 2004, "Programming the Hilbert curve").
    fn place(&self, at: DVec3) -> u64 {
        let mut x = ((at - self.low) * self.scale).to_array().map(|c| c as u32);
        for bit in (1..BITS).rev().map(|b| 1_u32 << b) {
            for axis in 0..3 {
                let swapped = if x[axis] & bit == 0 { (x[0] ^ x[axis]) & (bit - 1) } else { 0 };
                x[0] ^= if x[axis] & bit == 0 { swapped } else { bit - 1 };
                x[axis] ^= swapped;
            }
        }
        x[1] ^= x[0];
        x[2] ^= x[1];
        let turned = (1..BITS).map(|b| 1_u32 << b).filter(|bit| x[2] & bit != 0).fold(0, |t, bit| t ^ (bit - 1));
        (0..BITS)
            .rev()
            .fold(0, |place, b| x.iter().fold(place, |place, c| place << 1 | u64::from((c ^ turned) >> b & 1)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All places of a cube of eight to a side, on the curve's grid.
    #[test]
    fn the_curve_goes_from_neighbour_to_neighbour() {
        let curve = Curve { low: DVec3::ZERO, scale: 1.0 };
        let side = 0..8;
        let points = side.clone().flat_map(|x| side.clone().flat_map(move |y| (0..8).map(move |z| [x, y, z])));
        let mut places: Vec<(u64, DVec3)> =
            points.map(|p| p.map(f64::from)).map(|p| (curve.place(DVec3::from(p)), DVec3::from(p))).collect();
        places.sort_by_key(|&(place, _)| place);
        assert!(places.iter().zip(0..).all(|(&(place, _), i)| place == i), "every place once");
        assert!(places.windows(2).all(|w| w[0].1.distance(w[1].1) == 1.0));
    }
}
