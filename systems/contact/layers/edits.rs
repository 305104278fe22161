//! Edits of a mesh between whose layers nothing may pass.

use super::Mesh;
use super::closest::cross;
use super::proof::Proof;
use crate::components::{Bounds, Pair, PairStart, SelfContact};
use glam::DVec3;

/// Least distance of a pair after an edit, over that before or over the radius if that is less. At a fifth, which suffices in a step, a pair has 33 times
/// the force that it has here.
const KEPT: f64 = 0.7;

/// Whether a vertex may be taken out by moving it along an edge to the vertex `into`: no pair that is guarded afterwards meets on the way. `longest` is a
/// bound on the length of edges \[mm\]; box tests are counted in `tests`.
pub(in crate::systems) fn may_collapse(
    (vertices, triangles, topology): Mesh<'_>,
    own: &SelfContact,
    (row, into): (u32, u32),
    (longest, tests): (f64, &mut usize),
) -> bool {
    let (x, rest) = (&vertices.position, &vertices.rest_position);
    let end = |v: u32| x[if v == row { into } else { v } as usize];
    let band = own.band.unwrap_or(0.0);
    let is_near = |v: u32, w: u32| {
        let of = |v: u32| rest[if v == row { into } else { v } as usize];
        of(v).distance_squared(of(w)) < band * band
    };
    let inflated = DVec3::splat(own.radius);
    let bounds_of = |corners: [u32; 3]| {
        let both = corners.map(|v| Bounds { low: x[v as usize].min(end(v)), high: x[v as usize].max(end(v)) });
        both[0].join(both[1]).join(both[2])
    };
    let around = &topology.incident[row as usize];
    let ways: Vec<([u32; 3], Bounds)> = around
        .iter()
        .map(|entry| triangles.corners[*entry as usize / 3])
        .filter(|corners| !corners.contains(&into))
        .map(|corners| {
            let Bounds { low, high } = bounds_of(corners);
            (corners, Bounds { low: low - inflated, high: high + inflated })
        })
        .collect();
    let Some(all) = ways.iter().map(|(_, bounds)| *bounds).reduce(Bounds::join) else { return true };
    let reach = Bounds { low: all.low - longest, high: all.high + longest };
    *tests += x.len() / 3;
    for (v, place) in (0..).zip(x) {
        if !reach.has(*place) {
            continue;
        }
        // A triangle comes up with the first of its corners that is within reach.
        for entry in &topology.incident[v as usize] {
            let t = entry / 3;
            let other = triangles.corners[t as usize];
            let is_first = other.iter().filter(|w| reach.has(x[**w as usize])).min() == Some(&v);
            let of_other = bounds_of(other);
            if !is_first || other.contains(&row) || !all.meets(&of_other) {
                continue;
            }
            for (corners, bounds) in &ways {
                *tests += 1;
                if bounds.meets(&of_other)
                    && !stay_apart(&[*corners, other], (row, t), (&end, &is_near), (x, own.radius))
                {
                    return false;
                }
            }
        }
    }
    true
}

/// Whether the guarded pairs of two triangles, of which the first has the vertex `row` that moves and the second is `t`, do not meet.
fn stay_apart(
    [c, d]: &[[u32; 3]; 2],
    (row, t): (u32, u32),
    (end, is_near): (&impl Fn(u32) -> DVec3, &impl Fn(u32, u32) -> bool),
    (x, radius): (&[DVec3], f64),
) -> bool {
    let near = c.map(|v| d.map(|w| is_near(v, w)));
    if near == [[false; 3]; 3] && cross([*c, *d].map(|corners| corners.map(|v| x[v as usize]))) {
        return false;
    }
    let is_apart = |are_edges: bool, rows: [u32; 4]| {
        let [start, end] = [rows.map(|v| x[v as usize]), rows.map(end)];
        let pair = Pair { are_edges, rows: [0, 1, 2, 3], triangle: t };
        let way = pair.nearest(&start).way;
        let distance = way.length();
        let begin = PairStart { normal: way / distance, distance };
        Proof::new((&pair, &begin), &start, &end, radius) == Proof::Apart
            && pair.nearest(&end).way.length() >= KEPT * distance.min(radius)
    };
    let vertices = (0..3).all(|k| {
        (c[k] != row || near[k] != [false; 3] || is_apart(false, [c[k], d[0], d[1], d[2]]))
            && (near.iter().any(|row| row[k]) || is_apart(false, [d[k], c[0], c[1], c[2]]))
    });
    vertices
        && (0..3).all(|i| {
            let i_next = (i + 1) % 3;
            let moves = c[i] == row || c[i_next] == row;
            !moves
                || (0..3).all(|j| {
                    let j_next = (j + 1) % 3;
                    let is_guarded = ![i, i_next].iter().any(|i| near[*i][j] || near[*i][j_next]);
                    !is_guarded || is_apart(true, [c[i], c[i_next], d[j], d[j_next]])
                })
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::storage::{Topology, Triangles, Vertices};

    /// A square whose middle lies lower, and a triangle beside it, at these heights.
    fn may_flatten(middle: f64, other: f64) -> bool {
        let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
        let square = [at(0.0, 0.0, 0.0), at(1.0, 0.0, 0.0), at(1.0, 1.0, 0.0), at(0.0, 1.0, 0.0), at(0.5, 0.5, 0.0)];
        let beside = [at(9.4, 0.4, 0.0), at(9.6, 0.4, 0.0), at(9.5, 0.6, 0.0)];
        let rest_position: Vec<DVec3> = square.into_iter().chain(beside).collect();
        let mut position = rest_position.clone();
        position[4].z = middle;
        position[5..].iter_mut().for_each(|x| *x += at(-9.0, 0.0, other));
        let corners = vec![[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4], [5, 6, 7]];
        let topology = Topology::new(8, &corners).unwrap();
        let (mut vertices, mut triangles) = (Vertices::default(), Triangles::default());
        (vertices.position, vertices.rest_position, triangles.corners) = (position, rest_position, corners);
        let own = SelfContact { radius: 0.05, band: Some(0.5) };
        may_collapse((&vertices, &triangles, &topology), &own, (4, 0), (2.0, &mut 0))
    }

    #[test]
    fn a_vertex_is_not_taken_out_where_its_triangles_would_pass_through_a_layer_or_come_near_it() {
        assert!(may_flatten(-0.1, 9.0) && may_flatten(-0.1, 0.2) && may_flatten(-0.1, -0.3));
        // On the way, at its end, within seven tenths of the radius of it, and crossing from the start.
        assert!(
            !may_flatten(-0.3, -0.1) && !may_flatten(-0.3, 0.0) && !may_flatten(-0.3, 0.03) && !may_flatten(0.0, 0.0)
        );
        assert!(may_flatten(0.0, 0.06));
    }
}
