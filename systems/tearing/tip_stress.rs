//! Stress has a length at a tear's tip: its average over a disc of the material radius R in the rest shape.
//!
//! Tensors are averaged in one common frame, the tangent plane at the disc's centre, with uniform weight by area; triangles at
//! the rim count by their overlap with the disc. They are found by walking from neighbour to neighbour, so the average
//! never reaches across a crack.

use super::tip::fan_chart;
use crate::components::TearDecisions;
use crate::math::Sym2;
use crate::storage::{NONE, Topology, Triangles, Vertices};
use crate::systems::kernels::{disc::disc_triangle_overlap, fan::FanChart, membrane};
use glam::{DVec2, DVec3};

/// Overlaps up to this part of R² are roundings: triangles anywhere may have them, and the walk would not end at the rim.
const LEAST_OVERLAP: f64 = 1e-13;

/// A body's surface as the average needs it.
#[derive(Clone, Copy, Debug)]
pub struct Surface<'a> {
    /// Positions, current and at rest.
    pub vertices: &'a Vertices,
    /// Rest data, fibres and material.
    pub triangles: &'a Triangles,
    /// For the walk.
    pub topology: &'a Topology,
    /// Whether the body stays in its plane.
    pub is_planar: bool,
    /// The stretch that is free of stress.
    pub unstretched: Sym2,
}

/// The averages over a disc, in its axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiscAverage {
    /// Biot stress \[MPa\].
    pub stress: Sym2,
    /// Unit mean fibre: the principal axis of the mean of f ⊗ f.
    pub fibre: DVec2,
    /// How the fibre's angle changes over the disc \[rad/mm\]: the gradient of a linear fit.
    pub fibre_turn: DVec2,
    /// R \[mm\].
    pub radius: f64,
    /// Area of the disc that is tissue \[mm²\].
    pub area: f64,
    /// R over the mean edge length in the disc; under 3 the average is under-resolved.
    pub edges_per_radius: f64,
}

impl Surface<'_> {
    /// The chart of the fan around a vertex; `None` where the fan has no area.
    pub fn chart(&self, vertex: u32) -> Option<FanChart> {
        Some(fan_chart((self.vertices, self.triangles, self.topology), vertex)?.1)
    }

    /// Biot stress of a triangle at the current positions, in its frame (fibre, transverse).
    pub fn stress(&self, triangle: usize) -> Sym2 {
        let (vertices, triangles) = (self.vertices, self.triangles);
        let x = triangles.corners[triangle].map(|v| vertices.position[v as usize]);
        let (rest, stiffness) = (&triangles.rest[triangle], &triangles.stiffness[triangle]);
        membrane::state(x, rest, stiffness, self.is_planar, self.unstretched).stress
    }
}

/// Averages over the disc of `radius` \[mm\] about `centre` (rest shape), whose tangent plane has the orthonormal `axes`.
/// The walk starts from the triangles `start`. `None` where no tissue lies in the disc.
pub fn disc_average(
    surface: &Surface,
    centre: DVec3,
    axes: [DVec3; 2],
    radius: f64,
    start: impl IntoIterator<Item = u32>,
    scratch: &mut TearDecisions,
) -> Option<DiscAverage> {
    let chart = TangentPlane { centre, axes, normal: axes[0].cross(axes[1]) };
    scratch.begin_walk(surface.triangles.len());
    start.into_iter().for_each(|t| scratch.visit(t));
    let (mut area, mut full_area, mut count) = (0.0, 0.0, 0.0);
    let (mut stress, mut fibres) = (Sym2::ZERO, Sym2::ZERO);
    let mut turning = Turning::default();
    while let Some(t) = scratch.next_visit() {
        let t = t as usize;
        let x = surface.triangles.corners[t].map(|v| surface.vertices.rest_position[v as usize]);
        let placed = x.map(|p| chart.place(p));
        let overlap = disc_triangle_overlap(DVec2::ZERO, radius, placed);
        if !(overlap > LEAST_OVERLAP * radius * radius) {
            continue;
        }
        let fibre = chart.direction(surface.triangles.fibre[t], (x[1] - x[0]).cross(x[2] - x[0]));
        let across = fibre.perp();
        // Axes of the disc, seen from the triangle's frame.
        let (e1, e2) = (DVec2::new(fibre.x, across.x), DVec2::new(fibre.y, across.y));
        stress += surface.stress(t).in_axes(e1, e2) * overlap;
        fibres += Sym2::outer(fibre) * overlap;
        turning.add((placed[0] + placed[1] + placed[2]) / 3.0, fibre, overlap);
        area += overlap;
        full_area += surface.triangles.rest[t].area;
        count += 1.0;
        surface.topology.neighbours[t].iter().filter(|&&n| n != NONE).for_each(|&n| scratch.visit(n));
    }
    // An equilateral triangle of the mean area has this edge.
    let edge = (full_area / count * 4.0 / 3.0_f64.sqrt()).sqrt();
    (area > 0.0).then(|| DiscAverage {
        stress: stress * (1.0 / area),
        fibre: DVec2::from_angle(fibres.principal_angle()),
        fibre_turn: turning.gradient(),
        radius,
        area,
        edges_per_radius: radius / edge,
    })
}

struct TangentPlane {
    centre: DVec3,
    axes: [DVec3; 2],
    normal: DVec3,
}

impl TangentPlane {
    /// A point of the surface in the plane, at its true distance from the centre.
    fn place(&self, p: DVec3) -> DVec2 {
        let d = p - self.centre;
        let flat = DVec2::new(d.dot(self.axes[0]), d.dot(self.axes[1]));
        let height = d.dot(self.normal);
        if height == 0.0 { flat } else { flat.normalize_or_zero() * d.length() }
    }

    /// A direction in a triangle with normal along `cross`, turned into the plane by the smallest rotation.
    fn direction(&self, fibre: DVec3, cross: DVec3) -> DVec2 {
        let n = cross.normalize_or(self.normal);
        let sum = n + self.normal;
        let turned = fibre - sum * (self.normal.dot(fibre) / (1.0 + n.dot(self.normal)).max(f64::MIN_POSITIVE));
        DVec2::new(turned.dot(self.axes[0]), turned.dot(self.axes[1])).normalize_or(DVec2::X)
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
        // Fibres are lines: the angle between two is in (−π/2, π/2].
        let (sine, cosine) = (reference.perp_dot(fibre), reference.dot(fibre));
        let angle = 0.5 * (2.0 * sine * cosine).atan2(cosine * cosine - sine * sine);
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
