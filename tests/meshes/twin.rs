//! The naive twin of a mesh: corners, positions, keys and members by row, and every question is answered by looking at all
//! triangles. What it holds is compared with the tables, their topology and their masses, bit for bit.

use super::Body;
use glam::DVec3;
use rhexis::math::RestTriangle;
use rhexis::storage::{Edit, NONE, TriangleKey, VertexKey};
use std::collections::{HashMap, HashSet};

#[derive(Clone)]
pub struct Twin {
    pub corners: Vec<[u32; 3]>,
    pub rest: Vec<DVec3>,
    pub now: Vec<DVec3>,
    pub vertex_keys: Vec<VertexKey>,
    pub triangle_keys: Vec<TriangleKey>,
    /// Values attached to vertices.
    pub members: Vec<Option<DVec3>>,
    /// Keys of vertices that something refers to.
    pub marked: Vec<VertexKey>,
}

/// All keys that were ever given out: none may come back for another part.
#[derive(Default)]
pub struct Seen {
    vertices: HashSet<VertexKey>,
    triangles: HashSet<TriangleKey>,
}

impl Twin {
    pub fn new(body: &Body, members: Vec<Option<DVec3>>, marked: Vec<VertexKey>, seen: &mut Seen) -> Self {
        let mut twin = Self {
            corners: body.triangles.corners.clone(),
            rest: body.vertices.rest_position.clone(),
            now: body.vertices.position.clone(),
            vertex_keys: Vec::new(),
            triangle_keys: Vec::new(),
            members,
            marked,
        };
        twin.name_new(body, seen);
        twin
    }

    pub fn find(&self, from: u32, to: u32) -> Option<(usize, usize)> {
        let edge = |c: &[u32; 3]| (0..3).find(|&e| c[e] == from && c[(e + 1) % 3] == to);
        self.corners.iter().enumerate().find_map(|(t, c)| Some((t, edge(c)?)))
    }

    /// The rows of all vertices joined to one.
    pub fn ring(&self, vertex: u32) -> HashSet<u32> {
        self.corners.iter().filter(|c| c.contains(&vertex)).flatten().copied().collect()
    }

    fn push_between(&mut self, weights: &[(u32, f64)], member: Option<DVec3>) -> u32 {
        for list in [&mut self.rest, &mut self.now] {
            let mut point = list[weights[0].0 as usize] * weights[0].1;
            for &(row, weight) in &weights[1..] {
                point += list[row as usize] * weight;
            }
            list.push(point);
        }
        self.members.push(member);
        self.rest.len() as u32 - 1
    }

    fn replaced(c: [u32; 3], old: u32, new: u32) -> [u32; 3] {
        c.map(|v| if v == old { new } else { v })
    }

    /// Does an edit that the mesh has accepted.
    pub fn apply(&mut self, edit: &Edit, body: &Body, seen: &mut Seen) {
        match *edit {
            Edit::SplitEdge { triangle, edge, weight } => {
                let c = self.corners[triangle as usize];
                let (u, v) = (c[edge], c[(edge + 1) % 3]);
                let other = self.find(v, u);
                let values = self.members[u as usize].zip(self.members[v as usize]).filter(|_| other.is_none());
                let value = values.map(|(a, b)| a * (1.0 - weight) + b * weight);
                let m = self.push_between(&[(u, 1.0 - weight), (v, weight)], value);
                self.corners.push(Self::replaced(c, u, m));
                self.corners[triangle as usize] = Self::replaced(c, v, m);
                if let Some((s, _)) = other {
                    let c = self.corners[s];
                    self.corners.push(Self::replaced(c, v, m));
                    self.corners[s] = Self::replaced(c, u, m);
                }
            }
            Edit::SplitTriangle { triangle, weights: w } => {
                let c = self.corners[triangle as usize];
                let m = self.push_between(&[(c[0], w[0]), (c[1], w[1]), (c[2], w[2])], None);
                self.corners[triangle as usize] = [c[0], c[1], m];
                self.corners.extend([[m, c[1], c[2]], [c[0], m, c[2]]]);
            }
            Edit::Flip { triangle, edge } => {
                let c = self.corners[triangle as usize];
                let (u, v, o) = (c[edge], c[(edge + 1) % 3], c[(edge + 2) % 3]);
                let (s, f) = self.find(v, u).unwrap();
                let p = self.corners[s][(f + 2) % 3];
                self.corners[triangle as usize] = Self::replaced(c, v, p);
                self.corners[s] = Self::replaced(self.corners[s], u, o);
            }
            Edit::Slide { vertex, towards, weight } => {
                for list in [&mut self.rest, &mut self.now] {
                    let (a, b) = (list[vertex as usize], list[towards as usize]);
                    list[vertex as usize] = a * (1.0 - weight) + b * weight;
                }
            }
            Edit::Glide { vertex, triangle, weights } => {
                let parents = self.corners[triangle as usize].map(|row| row as usize);
                for list in [&mut self.rest, &mut self.now] {
                    let [a, b, c] = parents.map(|row| list[row]);
                    list[vertex as usize] = a * weights[0] + b * weights[1] + c * weights[2];
                }
            }
            Edit::Collapse { vertex, into } => self.collapse(vertex, into),
            Edit::Open { ref path } => self.open(path),
        }
        self.name_new(body, seen);
    }

    fn collapse(&mut self, vertex: u32, into: u32) {
        let (gone, heir) = (self.vertex_keys[vertex as usize], self.vertex_keys[into as usize]);
        self.marked.iter_mut().filter(|key| **key == gone).for_each(|key| *key = heir);
        for t in (0..self.corners.len()).rev() {
            if self.corners[t].contains(&vertex) && self.corners[t].contains(&into) {
                self.corners.swap_remove(t);
                self.triangle_keys.swap_remove(t);
            }
        }
        let last = self.rest.len() as u32 - 1;
        for c in &mut self.corners {
            *c = Self::replaced(Self::replaced(*c, vertex, into), last, vertex);
        }
        self.rest.swap_remove(vertex as usize);
        self.now.swap_remove(vertex as usize);
        self.vertex_keys.swap_remove(vertex as usize);
        self.members.swap_remove(vertex as usize);
    }

    fn open(&mut self, path: &[u32]) {
        let cut = |a, b| path.windows(2).any(|p| p == [a, b] || p == [b, a]);
        let before = self.corners.clone();
        let loops = path.first() == path.last();
        for &v in &path[usize::from(loops)..] {
            // Grow groups of triangles that share an uncut edge at v, by repeated merging.
            let mut groups: Vec<Vec<usize>> =
                (0..before.len()).filter(|&t| before[t].contains(&v)).map(|t| vec![t]).collect();
            let joined = |a: &[usize], b: &[usize]| {
                a.iter().any(|&t| {
                    before[t].iter().any(|&w| w != v && !cut(v, w) && b.iter().any(|&s| before[s].contains(&w)))
                })
            };
            while let Some((i, j)) = (0..groups.len())
                .flat_map(|i| (0..i).map(move |j| (i, j)))
                .find(|&(i, j)| joined(&groups[i], &groups[j]))
            {
                let merged = groups.swap_remove(i);
                groups[j].extend(merged);
            }
            groups.sort_by_key(|g| g.iter().min().copied());
            for group in &groups[1..] {
                let copy = self.push_between(&[(v, 1.0)], self.members[v as usize]);
                for &t in group {
                    let corner = before[t].iter().position(|&w| w == v).unwrap();
                    self.corners[t][corner] = copy;
                }
            }
        }
    }

    /// Takes note of the keys of new rows, which must be new.
    fn name_new(&mut self, body: &Body, seen: &mut Seen) {
        for row in self.vertex_keys.len()..self.rest.len() {
            let key = body.vertices.key(row as u32).unwrap();
            assert!(seen.vertices.insert(key), "a vertex has the key of an older one");
            self.vertex_keys.push(key);
        }
        for row in self.triangle_keys.len()..self.corners.len() {
            let key = body.triangles.key(row as u32).unwrap();
            assert!(seen.triangles.insert(key), "a triangle has the key of an older one");
            self.triangle_keys.push(key);
        }
    }

    pub fn compare(&self, body: &Body, context: &str) {
        assert_eq!(self.corners, body.triangles.corners, "{context}");
        assert_eq!(self.rest, body.vertices.rest_position, "{context}");
        assert_eq!(self.now, body.vertices.position, "{context}");
        assert_eq!(self.vertex_keys, body.vertices.keys(), "{context}");
        assert_eq!(self.triangle_keys, body.triangles.keys(), "{context}");
        let mut incident = vec![Vec::new(); self.rest.len()];
        let mut mass = vec![0.0; self.rest.len()];
        let mut edges = HashMap::new();
        for (t, c) in self.corners.iter().enumerate() {
            let x = c.map(|v| self.rest[v as usize]);
            let rest = RestTriangle::new(x, body.triangles.fibre[t]).unwrap();
            assert_eq!(rest, body.triangles.rest[t], "{context}");
            for corner in 0..3 {
                incident[c[corner] as usize].push(3 * t as u32 + corner as u32);
                mass[c[corner] as usize] += rest.area * body.triangles.thickness[t] * body.triangles.density[t] / 3.0;
                edges.insert((c[corner], c[(corner + 1) % 3]), t as u32);
            }
        }
        assert_eq!(mass, body.vertices.mass, "{context}");
        assert!(incident.iter().eq(body.topology.incident.iter().map(|list| list.as_slice())), "{context}");
        for (t, c) in self.corners.iter().enumerate() {
            let expected = [0, 1, 2].map(|e| edges.get(&(c[(e + 1) % 3], c[e])).copied().unwrap_or(NONE));
            assert_eq!(expected, body.topology.neighbours[t], "{context}");
        }
    }
}
