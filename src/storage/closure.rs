//! The closed side of a surface: the volume under its largest piece and flat lids over the loops of its boundary.

use super::{Attached, NONE, Topology, Triangles};
use glam::DVec3;

/// Boundary of the largest piece of a surface. *Derived* from the topology.
#[derive(Clone, Debug, Default)]
pub struct Closure {
    /// Whether a triangle belongs to another piece; empty where there is no other.
    is_beside: Vec<bool>,
    /// Vertices along the boundary with the surface to the left, loop after loop.
    vertices: Vec<u32>,
    /// End of every loop among them.
    ends: Vec<usize>,
}

impl Closure {
    /// Finds the boundary of the surface as it is.
    pub fn find(&mut self, triangles: &Triangles, topology: &Topology) {
        let Self { is_beside, vertices, ends } = self;
        is_beside.clear();
        vertices.clear();
        ends.clear();
        let boundary = |t: usize| topology.neighbours[t].contains(&NONE);
        if !(0..triangles.len()).any(boundary) {
            return;
        }
        let (count, piece) = topology.components();
        if count > 1 {
            let largest = largest(triangles, &piece, count);
            is_beside.extend(piece.iter().map(|piece| *piece as usize != largest));
        }
        let mut is_seen = vec![false; topology.incident.len()];
        for t in (0..triangles.len()).filter(|t| boundary(*t) && !is_beside.get(*t).is_some_and(|beside| *beside)) {
            for (e, _) in topology.neighbours[t].iter().enumerate().filter(|(_, next)| **next == NONE) {
                let mut vertex = triangles.corners[t][e];
                if is_seen[vertex as usize] {
                    continue;
                }
                while !std::mem::replace(&mut is_seen[vertex as usize], true) {
                    vertices.push(vertex);
                    let Some(next) = topology.next_boundary_vertex(&triangles.corners, vertex) else { break };
                    vertex = next;
                }
                ends.push(vertices.len());
            }
        }
    }

    /// Whether a triangle bounds the volume.
    #[inline]
    pub fn has(&self, triangle: usize) -> bool {
        !self.is_beside.get(triangle).is_some_and(|beside| *beside)
    }

    /// Number of triangles of other pieces.
    pub fn count_beside(&self) -> usize {
        self.is_beside.iter().filter(|beside| **beside).count()
    }

    /// Vertices of the loops.
    pub fn loops(&self) -> impl Iterator<Item = &[u32]> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, end)| &self.vertices[start..*end])
    }

    /// Volume \[mm³\] between a triangle and the origin.
    #[inline]
    pub fn under(&self, triangle: usize, corners: &[[u32; 3]], position: &[DVec3], origin: DVec3) -> f64 {
        if !self.has(triangle) {
            return 0.0;
        }
        let [a, b, c] = corners[triangle].map(|v| position[v as usize] - origin);
        a.dot(b.cross(c)) / 6.0
    }

    /// Volume \[mm³\] between the lids and the origin.
    pub fn under_lids(&self, position: &[DVec3], origin: DVec3) -> f64 {
        let lid = |list: &[u32]| -> f64 {
            let centre = mean(list, position) - origin;
            sides(list).map(|[a, b]| centre.dot((position[b] - origin).cross(position[a] - origin)) / 6.0).sum()
        };
        self.loops().map(lid).sum()
    }

    /// Adds the derivative of the lids' part of the volume by every vertex \[mm²\].
    pub fn add_lids(&self, position: &[DVec3], gradient: &mut [DVec3]) {
        for list in self.loops() {
            let centre = mean(list, position);
            let mut apex = DVec3::ZERO;
            for [a, b] in sides(list) {
                let sixth = (position[b] - centre).cross(position[a] - centre) / 6.0;
                gradient[a] += sixth;
                gradient[b] += sixth;
                apex += sixth;
            }
            list.iter().for_each(|v| gradient[*v as usize] += apex / list.len() as f64);
        }
    }

    /// Volume \[mm³\] of the closed side, one triangle after the other.
    pub fn volume(&self, corners: &[[u32; 3]], position: &[DVec3]) -> f64 {
        let origin = position.first().copied().unwrap_or_default();
        let sum: f64 = (0..corners.len()).map(|t| self.under(t, corners, position, origin)).sum();
        sum + self.under_lids(position, origin)
    }

    /// Area \[mm²\] of the openings: of every run of boundary edges outside the rim, closed by its chord, the area of its projection along its mean
    /// normal.
    pub fn opening(&self, rim: &Attached<()>, position: &[DVec3]) -> f64 {
        self.loops().map(|list| opening_of(list, rim, position)).sum()
    }
}

/// The piece with the largest rest area, the first of several.
fn largest(triangles: &Triangles, piece: &[u32], count: usize) -> usize {
    let mut areas = vec![0.0; count];
    piece.iter().zip(&triangles.rest).for_each(|(piece, rest)| areas[*piece as usize] += rest.area);
    (1..count).fold(0, |most, piece| if areas[piece] > areas[most] { piece } else { most })
}

fn mean(list: &[u32], position: &[DVec3]) -> DVec3 {
    list.iter().map(|v| position[*v as usize]).sum::<DVec3>() / list.len() as f64
}

/// Edges of a loop.
fn sides(list: &[u32]) -> impl Iterator<Item = [usize; 2]> {
    (0..list.len()).map(|i| [list[i] as usize, list[(i + 1) % list.len()] as usize])
}

fn opening_of(list: &[u32], rim: &Attached<()>, position: &[DVec3]) -> f64 {
    let is_rim = |[a, b]: [usize; 2]| rim.value(a as u32).is_some() && rim.value(b as u32).is_some();
    let edges: Vec<[usize; 2]> = sides(list).collect();
    // From the end of a run of rim edges on, so that no run of others is cut in two.
    let first = (0..edges.len()).find(|i| is_rim(edges[*i]) && !is_rim(edges[(i + 1) % edges.len()]));
    let first = match first {
        Some(first) => first + 1,
        None if edges.first().is_some_and(|edge| is_rim(*edge)) => return 0.0,
        None => 0,
    };
    let (mut sum, mut run, mut start) = (0.0, DVec3::ZERO, None);
    for place in 0..=edges.len() {
        let edge = edges[(first + place) % edges.len()];
        if place == edges.len() || is_rim(edge) {
            sum += 0.5 * run.length();
            (run, start) = (DVec3::ZERO, None);
            continue;
        }
        let [a, b] = edge.map(|v| position[v]);
        let start = *start.get_or_insert(a);
        run += (a - start).cross(b - start);
    }
    sum
}
