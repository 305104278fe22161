//! Surfaces of obstacles and jaws, to look at.

use super::Simulation;
use crate::components::{Forceps, Grips, Obstacle, Shape};
use crate::frame::{SolidFrame, SolidKind};
use crate::math::elementary;
use crate::storage::Vertices;
use glam::{DMat3, DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Segments around an axis, and of a quarter of a circle along it.
const AROUND: u32 = 48;
const QUARTER: u32 = 12;

/// Squares along a side of a plane.
const SQUARES: u32 = 16;

/// A surface under construction.
#[derive(Default)]
struct Surface {
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

impl Simulation {
    /// Surfaces of all obstacles, in the order of their handles, then of forceps and closed jaws, each with its force on the bodies.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, _) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// let shape = Shape::Sphere { centre: DVec3::new(5.0, 5.0, -3.0), radius: 2.0 };
    /// simulation.spawn_obstacle(Solid::new(shape))?;
    /// let solids = simulation.solids();
    /// assert!(solids[0].positions.iter().all(|p| (p.distance(DVec3::new(5.0, 5.0, -3.0)) - 2.0).abs() < 1e-12));
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn solids(&self) -> Vec<SolidFrame> {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for vertices in self.world.query::<&Vertices>().iter() {
            for p in &vertices.position {
                (low, high) = (low.min(*p), high.max(*p));
            }
        }
        let about = if low.is_finite() { (0.5 * (low + high), (high - low).max_element()) } else { (DVec3::ZERO, 1.0) };
        let forces: Vec<_> =
            self.bodies().into_iter().filter_map(|body| self.contact_forces(body).ok()).flatten().collect();
        let mut list = Vec::new();
        for obstacle in self.obstacles() {
            let Ok(found) = self.world.get::<&Obstacle>(obstacle.entity()) else { continue };
            let Surface { positions, triangles } = Surface::of(&found.shape, about);
            let force = forces.iter().filter(|(of, _)| *of == obstacle).map(|(_, force)| *force).sum();
            let at = found.shape.anchor();
            list.push(SolidFrame { kind: SolidKind::Obstacle, positions, triangles, at, force });
        }
        let jaws = |at: DVec3, radius: f64, force: DVec3| {
            let Surface { positions, triangles } = Surface::ball(at, DVec3::splat(radius), DMat3::IDENTITY);
            SolidFrame { kind: SolidKind::Jaws, positions, triangles, at, force }
        };
        let time = self.time();
        for tool in self.tools() {
            let Ok(forceps) = self.world.get::<&Forceps>(tool) else { continue };
            list.push(jaws(forceps.motion.at(time).position, forceps.jaws.radius, forceps.force));
        }
        for body in self.bodies() {
            let Ok(grips) = self.world.get::<&Grips>(body.entity()) else { continue };
            let scripted = grips.pinches.iter().filter(|pinch| pinch.is_closed() && pinch.forceps.is_none());
            list.extend(scripted.map(|pinch| jaws(pinch.pose(time).position, pinch.jaws.radius, pinch.force)));
        }
        list
    }
}

impl Surface {
    /// The surface of a shape; of a plane the part about a point, of an extent \[mm\].
    fn of(shape: &Shape, (centre, extent): (DVec3, f64)) -> Self {
        match shape {
            Shape::Plane { point, normal } => {
                let middle = centre - *normal * normal.dot(centre - *point);
                let (u, v) = normal.any_orthonormal_pair();
                Self::grid(|i, j| middle + extent * ((i - 0.5) * u + (j - 0.5) * v), [SQUARES; 2])
            }
            Shape::Sphere { centre, radius } => Self::ball(*centre, DVec3::splat(*radius), DMat3::IDENTITY),
            Shape::Ellipsoid { centre, half_axes, axes } => Self::ball(*centre, *half_axes, *axes),
            Shape::Capsule { ends, radius } => {
                let length = ends[0].distance(ends[1]);
                let quarter = |from: f64, shift: f64| {
                    (0..=QUARTER).map(move |k| {
                        let angle = from + FRAC_PI_2 * f64::from(k) / f64::from(QUARTER);
                        elementary::unit_at(angle) * *radius + DVec2::Y * shift
                    })
                };
                let profile: Vec<DVec2> = quarter(-FRAC_PI_2, 0.0).chain(quarter(0.0, length)).collect();
                Self::revolved(&profile, ends[0], ends[1] - ends[0])
            }
            Shape::Cylinder { ends, radius } => {
                let length = ends[0].distance(ends[1]);
                let profile = [[0.0, 0.0], [*radius, 0.0], [*radius, length], [0.0, length]].map(DVec2::from_array);
                Self::revolved(&profile, ends[0], ends[1] - ends[0])
            }
            Shape::Box { centre, half, axes } => {
                let mut all = Self::default();
                for (axis, sign) in (0..3).flat_map(|axis| [(axis, 1.0), (axis, -1.0)]) {
                    let (u, v) = (DVec3::AXES[(axis + 1) % 3] * sign, DVec3::AXES[(axis + 2) % 3]);
                    let place = |i: f64, j: f64| {
                        let corner = DVec3::AXES[axis] * sign + (2.0 * i - 1.0) * u + (2.0 * j - 1.0) * v;
                        *centre + *axes * (corner * *half)
                    };
                    all.join(Self::grid(place, [1; 2]));
                }
                all
            }
            Shape::Mesh { hull, centre, axes } => {
                let (positions, triangles) = hull.surface();
                Self {
                    positions: positions.iter().map(|p| *centre + *axes * *p).collect(),
                    triangles: triangles.to_vec(),
                }
            }
        }
    }

    fn ball(centre: DVec3, half_axes: DVec3, axes: DMat3) -> Self {
        let profile: Vec<DVec2> = (0..=2 * QUARTER)
            .map(|k| elementary::unit_at(FRAC_PI_2 * (f64::from(k) / f64::from(QUARTER) - 1.0)))
            .collect();
        let mut ball = Self::revolved(&profile, DVec3::ZERO, DVec3::Z);
        ball.positions.iter_mut().for_each(|p| *p = centre + axes * (*p * half_axes));
        ball
    }

    /// The surface of a profile (distance from an axis, way along it) turned about the axis.
    fn revolved(profile: &[DVec2], start: DVec3, axis: DVec3) -> Self {
        let along = axis.try_normalize().unwrap_or(DVec3::Z);
        let (u, v) = along.any_orthonormal_pair();
        let last = (profile.len() - 1) as f64;
        let place = |i: f64, j: f64| {
            let p = profile[(j * last).round() as usize];
            let around = elementary::unit_at(TAU * i);
            start + p.x * (around.x * u + around.y * v) + p.y * along
        };
        Self::grid(place, [AROUND, last as u32])
    }

    /// A grid over the unit square, placed in space.
    fn grid(place: impl Fn(f64, f64) -> DVec3, [nx, ny]: [u32; 2]) -> Self {
        let part = |k: u32, of: u32| f64::from(k) / f64::from(of);
        let positions = (0..=ny).flat_map(|j| (0..=nx).map(move |i| (i, j)));
        let positions = positions.map(|(i, j)| place(part(i, nx), part(j, ny))).collect();
        let at = |i: u32, j: u32| j * (nx + 1) + i;
        let squares = (0..ny).flat_map(|j| (0..nx).map(move |i| (i, j)));
        let triangles = squares
            .flat_map(|(i, j)| {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                [[a, b, c], [a, c, d]]
            })
            .collect();
        Self { positions, triangles }
    }

    fn join(&mut self, other: Self) {
        let first = self.positions.len() as u32;
        self.positions.extend(other.positions);
        self.triangles.extend(other.triangles.into_iter().map(|corners| corners.map(|v| first + v)));
    }
}
