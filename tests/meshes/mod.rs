//! Meshes and bodies for the tests of edits and tears, and a random source with fixed seeds.
#![allow(dead_code, reason = "shared: each that takes it in uses a part")]

pub mod tears;
pub mod twin;

use glam::{DMat3, DVec3};
use proptest::prelude::Rng;
use proptest::test_runner::{RngAlgorithm, TestRng};
use rhexis::generate;
use rhexis::math::{Orthotropic, RestTriangle, Sym2};
use rhexis::storage::{
    Mesh, NONE, Topology, TriangleMesh, TriangleRow, Triangles, VertexRow, Vertices,
    measure::{rest_corners, rest_data},
};

pub struct Random(TestRng);

impl Random {
    pub fn new(seed: u8) -> Self {
        Self(TestRng::from_seed(RngAlgorithm::ChaCha, &[seed; 32]))
    }

    /// In [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    pub fn below(&mut self, count: usize) -> usize {
        (self.0.next_u64() % count as u64) as usize
    }

    pub fn vector(&mut self, size: f64) -> DVec3 {
        DVec3::new(self.between(-size, size), self.between(-size, size), self.between(-size, size))
    }
}

#[derive(Clone)]
pub struct Sheet {
    pub positions: Vec<DVec3>,
    pub corners: Vec<[u32; 3]>,
}

impl From<TriangleMesh> for Sheet {
    fn from(mesh: TriangleMesh) -> Self {
        Self { positions: mesh.positions, corners: mesh.triangles }
    }
}

/// Structured grid over [0, width] × [0, height] with alternating diagonals.
pub fn grid(nx: usize, ny: usize, width: f64, height: f64) -> Sheet {
    generate::grid(width, height, nx, ny).unwrap().into()
}

/// The grid with inner vertices moved at random.
pub fn jittered(nx: usize, ny: usize, width: f64, height: f64, seed: u64) -> Sheet {
    generate::jittered(width, height, nx, ny, seed).unwrap().into()
}

/// A cap of about `rings` rings: radius of curvature 10, 9.8 across, the sphere's centre at the origin.
pub fn cap(rings: usize) -> Sheet {
    let mut cap = Sheet::from(generate::cap(10.0, 9.8, 6 * rings * rings).unwrap());
    cap.positions.iter_mut().for_each(|p| p.z += 10.0);
    cap
}

/// A closed sphere: an octahedron, each triangle split into four, `levels` times.
pub fn sphere(levels: usize) -> Sheet {
    let mut positions = vec![DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
    let mut corners: Vec<[u32; 3]> =
        vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    for _ in 0..levels {
        let mut middle = std::collections::HashMap::new();
        let mut next = Vec::new();
        for c in &corners {
            let m = [0, 1, 2].map(|i| {
                let (a, b) = (c[i], c[(i + 1) % 3]);
                *middle.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    positions.push((positions[a as usize] + positions[b as usize]).normalize());
                    positions.len() as u32 - 1
                })
            });
            next.extend([[c[0], m[0], m[2]], [m[0], c[1], m[1]], [m[2], m[1], c[2]], m]);
        }
        corners = next;
    }
    Sheet { positions, corners }
}

/// A closed torus of `n` × `m` cells, radii 3 and 1.
pub fn torus(n: usize, m: usize) -> Sheet {
    let at = |i: usize, j: usize| (i % n * m + j % m) as u32;
    let turn = |k: usize, of: usize| std::f64::consts::TAU * k as f64 / of as f64;
    let point = |i, j| {
        let (out, (up, across)) = (DMat3::from_rotation_z(turn(i, n)).x_axis, turn(j, m).sin_cos());
        out * (3.0 + across) + DVec3::Z * up
    };
    let cells = || (0..n).flat_map(|i| (0..m).map(move |j| (i, j)));
    let halves = |(i, j)| {
        let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
        [[a, b, c], [a, c, d]]
    };
    Sheet { positions: cells().map(|(i, j)| point(i, j)).collect(), corners: cells().flat_map(halves).collect() }
}

#[derive(Clone)]
pub struct Body {
    pub vertices: Vertices,
    pub triangles: Triangles,
    pub topology: Topology,
}

impl Body {
    /// A body at rest in its rest shape, with fibres along `fibre` projected into each triangle.
    pub fn new(sheet: &Sheet, fibre: DVec3) -> Self {
        let (mut vertices, mut triangles) = (Vertices::default(), Triangles::default());
        for &position in &sheet.positions {
            vertices.push(VertexRow { position, velocity: DVec3::ZERO, rest_position: position, mass: 0.0 });
        }
        let stiffness = Orthotropic::new(10.0, 1.0, 0.3, 0.5).unwrap();
        for &corners in &sheet.corners {
            let [a, b, c] = rest_corners(&vertices, corners);
            let rest = RestTriangle::new([a, b, c], fibre).unwrap();
            let fibre = RestTriangle::axis((b - a).cross(c - a).normalize(), fibre, b - a);
            triangles.push(TriangleRow {
                corners,
                rest,
                fibre,
                stiffness,
                thickness: 0.1,
                density: 1e-3,
                pre_stretch: Sym2::ZERO,
                strength: 1.0,
                toughness: 1.0,
            });
        }
        let topology = Topology::new(vertices.len(), &triangles.corners).unwrap();
        let mut body = Self { vertices, triangles, topology };
        rest_data(&mut body.mesh()).unwrap();
        body
    }

    /// Deforms the body smoothly (strains of some 10 %, rotations of 0.5 rad) and gives it velocities.
    pub fn deform(&mut self, random: &mut Random) {
        let stretch = DMat3::from_cols(
            DVec3::X + random.vector(0.1),
            DVec3::Y + random.vector(0.1),
            DVec3::Z + random.vector(0.1),
        ) * DMat3::from_axis_angle(random.vector(1.0).normalize(), 0.5);
        let wave = random.vector(0.3);
        for row in 0..self.vertices.len() {
            let x = self.vertices.rest_position[row];
            self.vertices.position[row] = stretch * x + DVec3::new(0.0, 0.05, 0.1) * wave.dot(x).sin();
            self.vertices.velocity[row] = random.vector(1.0);
        }
    }

    /// Vertices where two lips of equal length meet, each with the vertices before and after it along the boundary: found by looking
    /// at all edges.
    pub fn tips(&self) -> Vec<(u32, [u32; 2])> {
        let edges = || self.triangles.corners.iter().flat_map(|c| [0, 1, 2].map(|e| (c[e], c[(e + 1) % 3])));
        let all: std::collections::HashSet<(u32, u32)> = edges().collect();
        let mut beside = vec![[NONE; 2]; self.vertices.len()];
        for (from, to) in edges().filter(|&(from, to)| !all.contains(&(to, from))) {
            beside[from as usize][1] = to;
            beside[to as usize][0] = from;
        }
        let rest = |row: u32| self.vertices.rest_position[row as usize];
        let is_tip = |&(_, [a, b]): &(u32, [u32; 2])| a != NONE && rest(a).distance(rest(b)) < 1e-12;
        (0..).zip(beside).filter(is_tip).collect()
    }

    /// Area of a flat body within its outline, by the edges of the boundary alone.
    pub fn outlined_area(&self) -> f64 {
        let next = |v: u32| Some((v, self.topology.next_boundary_vertex(&self.triangles.corners, v)?));
        let rest = |row: u32| self.vertices.rest_position[row as usize];
        let edges = (0..self.vertices.len() as u32).filter_map(next);
        edges.map(|(a, b)| 0.5 * rest(a).cross(rest(b)).z).sum()
    }

    pub fn mesh(&mut self) -> Mesh<'_> {
        Mesh { vertices: &mut self.vertices, triangles: &mut self.triangles, topology: &mut self.topology }
    }

    /// Co-rotational energy \[mJ\] ½·A·h·(U−I):C:(U−I) with U = √(FᵀF) by the closed form for 2×2 roots.
    pub fn elastic_energy(&self) -> f64 {
        let mut energy = 0.0;
        for row in 0..self.triangles.len() {
            let t = self.triangles.at(row as u32);
            let [x0, x1, x2] = t.corners.map(|c| self.vertices.position[c as usize]);
            let [g1, g2] = t.rest.gradients;
            let f1 = (x1 - x0) * g1.x + (x2 - x0) * g2.x;
            let f2 = (x1 - x0) * g1.y + (x2 - x0) * g2.y;
            let (xx, yy, xy) = (f1.dot(f1), f2.dot(f2), f1.dot(f2));
            let root = (xx * yy - xy * xy).max(0.0).sqrt();
            let trace = (xx + yy + 2.0 * root).sqrt();
            let (exx, eyy, exy) = ((xx + root) / trace - 1.0, (yy + root) / trace - 1.0, xy / trace);
            let q = t.stiffness;
            let density = q.q11 * exx * exx + 2.0 * q.q12 * exx * eyy + q.q22 * eyy * eyy + 4.0 * q.q66 * exy * exy;
            energy += 0.5 * t.rest.area * t.thickness * density;
        }
        energy
    }
}
