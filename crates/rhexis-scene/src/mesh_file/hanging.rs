//! Vertices on the edge of a triangle that does not have them: the surface is slit there until they are split in.

use super::draft::Draft;
use glam::DVec3;

/// Distance from an edge, as a part of its length, within which a vertex lies on it.
const ON_EDGE: f64 = 1e-6;

/// The most that rounding of coordinates may add to it.
const MOST_ROUNDING: f64 = 1e-3;

/// Maximum number of places per vertex of the rim; those beyond are found once these are split.
const MOST_EDGES: usize = 16;

/// Points in a leaf of the search tree.
const LEAF: usize = 8;

/// A vertex on an edge of a triangle that does not have it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Hanging {
    /// The vertex.
    pub vertex: u32,
    /// The triangle.
    pub triangle: usize,
    /// The edge from this corner of the triangle to the next.
    pub side: usize,
    /// Place on the edge, from 0 to 1.
    along: f64,
}

/// All vertices of the rim on edges of the rim, by triangle, side and place. Vertices within `weld` of an edge lie on it.
pub(crate) fn hanging(positions: &[DVec3], triangles: &[[u32; 3]], weld: f64) -> Vec<Hanging> {
    let sides = rim(triangles);
    let mut vertices: Vec<u32> = sides.iter().flat_map(|&(triangle, side)| ends(triangles[triangle], side)).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let largest = positions.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
    let tree = Tree::new(positions, vertices);
    let most = MOST_EDGES * tree.vertices.len();
    let mut found = Vec::new();
    for (triangle, side) in sides {
        let corners = triangles[triangle];
        let [a, b] = ends(corners, side).map(|corner| positions[corner as usize]);
        let length = a.distance(b);
        let rounding = (super::finish::ROUNDING * largest).min(MOST_ROUNDING * length);
        let reach = rounding.max(ON_EDGE * length).max(weld);
        tree.near([a, b], reach, &mut |vertex| {
            let p = positions[vertex as usize];
            let along = (p - a).dot(b - a) / (length * length);
            let is_between = a.distance(p) > reach && b.distance(p) > reach && (0.0..1.0).contains(&along);
            if !corners.contains(&vertex) && is_between && p.distance(a.lerp(b, along)) <= reach {
                found.push(Hanging { vertex, triangle, side, along });
            }
            found.len() < most
        });
    }
    found.sort_by(|a, b| (a.triangle, a.side).cmp(&(b.triangle, b.side)).then(a.along.total_cmp(&b.along)));
    found
}

/// The ends of a side.
pub(crate) fn ends(corners: [u32; 3], side: usize) -> [u32; 2] {
    [corners[side], corners[(side + 1) % 3]]
}

/// Sides of triangles that no other triangle has.
fn rim(triangles: &[[u32; 3]]) -> Vec<(usize, usize)> {
    let mut sides: Vec<([u32; 2], usize, usize)> = Vec::with_capacity(3 * triangles.len());
    for (triangle, &corners) in triangles.iter().enumerate() {
        sides.extend((0..3).map(|side| {
            let [a, b] = ends(corners, side);
            ([a.min(b), a.max(b)], triangle, side)
        }));
    }
    sides.sort_unstable();
    let alone = sides.chunk_by(|a, b| a.0 == b.0).filter(|group| group.len() == 1).flatten();
    alone.map(|&(_, triangle, side)| (triangle, side)).collect()
}

/// Splits the triangles at the vertices that hang on their edges. Where they were.
pub(super) fn split(draft: &mut Draft, sources: &[u32], weld: f64) -> Vec<Hanging> {
    let found = hanging(&draft.positions, &draft.triangles, weld);
    for group in found.chunk_by(|a, b| a.triangle == b.triangle) {
        let first = group[0].triangle;
        let (corners, textured) = (draft.triangles[first], draft.textured[first]);
        let mut pieces = vec![Piece { corners, textured }];
        for side in group.chunk_by(|a, b| a.side == b.side) {
            let [mut from, to] = ends(corners, side[0].side);
            for &Hanging { vertex, along, .. } in side {
                let row = draft.decoration.between(ends(textured, side[0].side), along, sources[vertex as usize]);
                split_piece(&mut pieces, [from, to], (vertex, row));
                from = vertex;
            }
        }
        (draft.triangles[first], draft.textured[first]) = (pieces[0].corners, pieces[0].textured);
        for piece in &pieces[1..] {
            draft.triangles.push(piece.corners);
            draft.textured.push(piece.textured);
            draft.cells.push(draft.cells[first]);
            draft.places.push(draft.places[first]);
            draft.rows.push(draft.rows[first]);
        }
    }
    found
}

/// A part of a triangle: corners, and rows of the decoration with their texture coordinates.
struct Piece {
    corners: [u32; 3],
    textured: [u32; 3],
}

/// Splits the piece that has the edge at a vertex, whose texture coordinate stands in a row of the decoration.
fn split_piece(pieces: &mut Vec<Piece>, edge: [u32; 2], (vertex, row): (u32, u32)) {
    let has_edge = |piece: &Piece| (0..3).find(|&side| ends(piece.corners, side) == edge);
    let Some((place, side)) = (0..pieces.len()).find_map(|place| Some((place, has_edge(&pieces[place])?))) else {
        return;
    };
    let &Piece { corners, textured } = &pieces[place];
    let (next, third) = ((side + 1) % 3, (side + 2) % 3);
    let of = |corners, textured| Piece { corners, textured };
    pieces[place] = of([corners[side], vertex, corners[third]], [textured[side], row, textured[third]]);
    pieces.push(of([vertex, corners[next], corners[third]], [row, textured[next], textured[third]]));
}

/// A search tree over vertices: each part is split at its median across its longest side.
struct Tree<'a> {
    positions: &'a [DVec3],
    vertices: Vec<u32>,
    /// The axis of the split at each place that is a median.
    axes: Vec<u8>,
}

impl<'a> Tree<'a> {
    fn new(positions: &'a [DVec3], vertices: Vec<u32>) -> Self {
        let mut tree = Self { positions, axes: vec![0; vertices.len()], vertices };
        let mut parts = vec![(0, tree.vertices.len())];
        while let Some((start, end)) = parts.pop() {
            let part = start..end;
            if part.len() <= LEAF {
                continue;
            }
            let points = tree.vertices[part.clone()].iter().map(|&vertex| positions[vertex as usize]);
            let (low, high) =
                points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
            let axis = (high - low).max_position();
            let middle = part.len() / 2;
            let at = |vertex: &u32| positions[*vertex as usize][axis];
            tree.vertices[part.clone()].select_nth_unstable_by(middle, |a, b| at(a).total_cmp(&at(b)));
            tree.axes[start + middle] = axis as u8;
            parts.extend([(start, start + middle), (start + middle + 1, end)]);
        }
        tree
    }

    /// Visits all vertices within `reach` of a line between two points, and some beside them, until `visit` is false.
    fn near(&self, [a, b]: [DVec3; 2], reach: f64, visit: &mut impl FnMut(u32) -> bool) {
        // A part, and the stretch of the line that comes near it.
        let mut parts = vec![(0..self.vertices.len(), [0.0_f64, 1.0])];
        while let Some((part, [begin, end])) = parts.pop() {
            if part.len() <= LEAF {
                if !self.vertices[part].iter().all(|vertex| visit(*vertex)) {
                    return;
                }
                continue;
            }
            let median = part.start + part.len() / 2;
            let axis = self.axes[median] as usize;
            if !visit(self.vertices[median]) {
                return;
            }
            let split = self.positions[self.vertices[median] as usize][axis];
            let (start, slope) = (a[axis], b[axis] - a[axis]);
            for (part, sign) in [(part.start..median, 1.0), (median + 1..part.end, -1.0)] {
                // Where sign · (start + t · slope − split) ≤ reach.
                let (slope, room) = (sign * slope, reach - sign * (start - split));
                let stretch = match slope {
                    0.0 if room < 0.0 => continue,
                    0.0 => [begin, end],
                    _ if slope > 0.0 => [begin, end.min(room / slope)],
                    _ => [begin.max(room / slope), end],
                };
                if stretch[0] <= stretch[1] {
                    parts.push((part, stretch));
                }
            }
        }
    }
}
