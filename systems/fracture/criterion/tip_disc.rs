//! The disc around a tip in the rest shape: its triangles, their weights, and the directions of their axes in those of the
//! disc.
//!
//! All of it follows from the rest shape and the topology. So a disc stays as it is until an edit touches one of its triangles,
//! those just beyond its rim included. Only the stress in it changes from step to step. Triangles are found by walking from
//! neighbour to neighbour, so a disc never reaches across a crack.

use crate::math::{FibreLaw, Sym2, edge_of_equilateral, elementary};
use crate::storage::NONE;
use crate::systems::fracture::Surface;
use crate::systems::kernels::disc::disc_triangle_overlap;
use crate::systems::kernels::membrane;
use crate::systems::kernels::polar::stretches;
use crate::systems::kernels::simd::LANES;
use glam::{DVec2, DVec3};

/// Overlaps up to this part of R² are roundings of a triangle that touches the rim: counted as members, such triangles and
/// their neighbours would tell mirror images apart.
const LEAST_OVERLAP: f64 = 1e-13;

/// Triangles for which a disc, and its rim, have room from the start: with three edges to the radius there are some 65 in it.
const USUAL_DISC: usize = 128;

/// A disc laid out on the surface.
#[derive(Clone, Debug, Default)]
pub struct Disc {
    members: Vec<Member>,
    /// Triangles that border on it and have no part in it.
    rim: Vec<u32>,
    /// Area of the disc that is tissue \[mm²\].
    pub area: f64,
    /// Unit mean fibre in the disc's axes: the principal axis of the mean of f ⊗ f.
    pub fibre: DVec2,
    /// Gradient of the fibre's angle over the disc \[rad/mm\], by a linear fit.
    pub fibre_turn: DVec2,
    /// R over the mean edge length in the disc; under 3 the average is under-resolved.
    pub edges_per_radius: f64,
}

/// A triangle's part in the average: its overlap times the squares c², s² and the product c·s of its fibre (c, s).
#[derive(Clone, Copy, Debug)]
struct Member {
    triangle: u32,
    along: f64,
    across: f64,
    mixed: f64,
}

/// Buffers of the walk over triangles, to be kept between discs.
#[derive(Clone, Debug, Default)]
pub struct Walk {
    /// Number of the last walk that visited each triangle.
    visited: Vec<u32>,
    walk: u32,
    queue: Vec<u32>,
}

impl Walk {
    /// Begins a walk over so many triangles.
    pub fn begin(&mut self, triangle_count: usize) {
        self.visited.resize(triangle_count, self.walk);
        if self.walk == u32::MAX {
            self.visited.fill(0);
            self.walk = 0;
        }
        self.walk += 1;
        self.queue.clear();
    }

    /// Puts a triangle on the walk, unless it has been there.
    pub fn visit(&mut self, triangle: u32) {
        let mark = &mut self.visited[triangle as usize];
        if *mark != self.walk {
            *mark = self.walk;
            self.queue.push(triangle);
        }
    }

    /// The `place`th triangle of the walk, if it has come so far.
    pub fn at(&self, place: usize) -> Option<u32> {
        self.queue.get(place).copied()
    }
}

impl Disc {
    /// Lays the disc of `radius` \[mm\] about `centre` (rest shape), whose tangent plane has the orthonormal `axes`, starting
    /// from the triangles `start`. It has no area where no tissue lies in it.
    pub fn lay(
        &mut self,
        surface: &Surface,
        (centre, axes, radius): (DVec3, [DVec3; 2], f64),
        start: impl IntoIterator<Item = u32>,
        walk: &mut Walk,
    ) {
        let plane = TangentPlane::new(centre, axes);
        self.members.clear();
        self.members.reserve(USUAL_DISC);
        self.rim.clear();
        self.rim.reserve(USUAL_DISC);
        walk.begin(surface.triangles.len());
        start.into_iter().for_each(|t| walk.visit(t));
        let (mut area, mut full_area, mut fibres) = (0.0, 0.0, Sym2::ZERO);
        let mut turning = Turning::default();
        let mut next = 0;
        while let Some(triangle) = walk.at(next) {
            next += 1;
            let t = triangle as usize;
            let x = surface.triangles.corners[t].map(|v| surface.vertices.rest_position[v as usize]);
            let (placed, is_flat) = plane.place(x);
            let overlap = disc_triangle_overlap(DVec2::ZERO, radius, placed);
            if !(overlap > LEAST_OVERLAP * radius * radius) {
                self.rim.push(triangle);
                continue;
            }
            let fibre = plane.direction(surface.triangles.fibre[t], x, is_flat);
            let square = Sym2::outer(fibre) * overlap;
            self.members.push(Member { triangle, along: square.xx, across: square.yy, mixed: square.xy });
            fibres += square;
            turning.add((placed[0] + placed[1] + placed[2]) / 3.0, fibre, overlap);
            area += overlap;
            full_area += surface.triangles.rest[t].area;
            surface.topology.neighbours[t].iter().filter(|&&n| n != NONE).for_each(|&n| walk.visit(n));
        }
        let edge = edge_of_equilateral(full_area / self.members.len() as f64);
        self.area = area;
        self.fibre = elementary::unit_at(fibres.principal_angle());
        self.fibre_turn = turning.gradient();
        self.edges_per_radius = radius / edge;
    }

    /// Mean Biot stress \[MPa\] at the current positions, in the disc's axes.
    pub fn stress(&self, surface: &Surface) -> Sym2 {
        let &Surface { vertices, triangles, is_planar, unstretched, ref fibres, .. } = surface;
        let gradient = |member: &Member| {
            let t = member.triangle as usize;
            let x = triangles.corners[t].map(|v| vertices.position[v as usize]);
            membrane::gradient(x, &triangles.rest[t])
        };
        let mut sum = Sym2::ZERO;
        for members in self.members.chunks(LANES) {
            let mut gradients = [(DVec3::X, DVec3::Y); LANES];
            gradients.iter_mut().zip(members).for_each(|(f, member)| *f = gradient(member));
            for (member, u) in members.iter().zip(stretches(&gradients, is_planar)) {
                let &Member { triangle, along, across, mixed } = member;
                let (law, unstretched) =
                    (triangles.law(triangle as usize), triangles.unstretched(triangle as usize, unstretched));
                let s = FibreLaw::stress(fibres.as_ref(), u, unstretched, (law.stress(u - unstretched), law));
                let twice = 2.0 * mixed * s.xy;
                sum += Sym2::new(
                    along * s.xx + across * s.yy - twice,
                    across * s.xx + along * s.yy + twice,
                    mixed * (s.xx - s.yy) + (along - across) * s.xy,
                );
            }
        }
        sum * (1.0 / self.area)
    }

    /// The triangles on which the disc depends.
    pub fn triangles(&self) -> impl Iterator<Item = u32> {
        self.members.iter().map(|member| member.triangle).chain(self.rim.iter().copied())
    }
}

/// The plane in which a disc or ring is laid out.
pub(in crate::systems::fracture) struct TangentPlane {
    centre: DVec3,
    axes: [DVec3; 2],
    pub normal: DVec3,
}

impl TangentPlane {
    /// The plane through `centre` with the orthonormal `axes`.
    pub(in crate::systems::fracture) fn new(centre: DVec3, axes: [DVec3; 2]) -> Self {
        Self { centre, axes, normal: axes[0].cross(axes[1]) }
    }

    /// A triangle in the plane, its corners at their true distances from the centre. Whether it lies in the plane anyhow.
    pub(in crate::systems::fracture) fn place(&self, x: [DVec3; 3]) -> ([DVec2; 3], bool) {
        let x = x.map(|p| p - self.centre);
        let placed = x.map(|d| DVec2::new(d.dot(self.axes[0]), d.dot(self.axes[1])));
        let heights = x.map(|d| d.dot(self.normal));
        if heights == [0.0; 3] {
            return (placed, true);
        }
        let at_distance = |i: usize| placed[i].normalize_or_zero() * x[i].length();
        ([0, 1, 2].map(|i| if heights[i] == 0.0 { placed[i] } else { at_distance(i) }), false)
    }

    /// A unit direction in a triangle, turned into the plane by the smallest rotation.
    pub(in crate::systems::fracture) fn direction(&self, fibre: DVec3, x: [DVec3; 3], is_flat: bool) -> DVec2 {
        let project = |v: DVec3| DVec2::new(v.dot(self.axes[0]), v.dot(self.axes[1]));
        if is_flat {
            return project(fibre).normalize_or(DVec2::X);
        }
        let n = (x[1] - x[0]).cross(x[2] - x[0]).normalize_or(self.normal);
        let sum = n + self.normal;
        let turned = fibre - sum * (self.normal.dot(fibre) / (1.0 + n.dot(self.normal)).max(f64::MIN_POSITIVE));
        project(turned).normalize_or(DVec2::X)
    }
}

/// Sums for the linear fit of the fibre's angle: isotropic least squares about the weighted mean.
#[derive(Default)]
struct Turning {
    reference: Option<DVec2>,
    weight: f64,
    place: DVec2,
    angle: f64,
    place_sq: f64,
    angle_place: DVec2,
}

impl Turning {
    fn add(&mut self, place: DVec2, fibre: DVec2, weight: f64) {
        let reference = *self.reference.get_or_insert(fibre);
        // Fibres are lines: the angle between two is in [−π/2, π/2]. Between equal ones it is zero.
        let sine = reference.perp_dot(fibre);
        let angle = if sine == 0.0 { 0.0 } else { elementary::atan(sine / reference.dot(fibre)) };
        self.weight += weight;
        self.place += place * weight;
        self.angle += angle * weight;
        self.place_sq += place.length_squared() * weight;
        self.angle_place += place * (angle * weight);
    }

    fn gradient(&self) -> DVec2 {
        let covariance = self.angle_place - self.place * (self.angle / self.weight);
        let variance = self.place_sq - self.place.length_squared() / self.weight;
        if variance > 0.0 { covariance * (2.0 / variance) } else { DVec2::ZERO }
    }
}
