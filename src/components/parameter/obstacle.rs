//! Rigid surroundings that a body cannot enter. An obstacle is an entity of its own; a body that carries [`Contact`] feels all.

use crate::components::Hull;
use crate::components::Path;
use crate::components::SelfContact;
use crate::components::Turning;
use crate::components::parameter::solid;
use glam::{DMat3, DVec3};
use std::sync::Arc;

/// The shape of an obstacle.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub enum Shape {
    /// The half space below a plane.
    Plane {
        /// A point of the plane \[mm\].
        point: DVec3,
        /// Unit normal, pointing out of the obstacle.
        normal: DVec3,
    },
    /// A ball.
    Sphere {
        /// Centre \[mm\].
        centre: DVec3,
        /// Radius \[mm\].
        radius: f64,
    },
    /// An ellipsoid.
    Ellipsoid {
        /// Centre \[mm\].
        centre: DVec3,
        /// Half axes \[mm\].
        half_axes: DVec3,
        /// Directions of its axes, as the columns of a rotation.
        axes: DMat3,
    },
    /// All within a distance of a segment: a cylinder with round ends.
    Capsule {
        /// Ends of the segment \[mm\].
        ends: [DVec3; 2],
        /// The distance \[mm\].
        radius: f64,
    },
    /// A box.
    Box {
        /// Centre \[mm\].
        centre: DVec3,
        /// Half edges \[mm\].
        half: DVec3,
        /// Directions of its edges, as the columns of a rotation.
        axes: DMat3,
    },
    /// A cylinder with flat ends.
    Cylinder {
        /// Middles of its ends \[mm\].
        ends: [DVec3; 2],
        /// Radius \[mm\].
        radius: f64,
    },
    /// The solid within a mesh, which vertices alone feel: a part thinner than an edge of a body may pierce it between them.
    Mesh {
        /// The solid, about the middle of its bounds.
        #[cfg_attr(feature = "snapshot", serde(with = "shared"))]
        hull: Arc<Hull>,
        /// Where that middle is \[mm\].
        centre: DVec3,
        /// Directions of its axes, as the columns of a rotation.
        axes: DMat3,
    },
}

/// A hull in bytes: several obstacles that share one are written with it each.
#[cfg(feature = "snapshot")]
mod shared {
    use super::{Arc, Hull};
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(super) fn serialize<S: Serializer>(hull: &Arc<Hull>, serializer: S) -> Result<S::Ok, S::Error> {
        hull.as_ref().serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Arc<Hull>, D::Error> {
        Hull::deserialize(deserializer).map(Arc::new)
    }
}

/// A rigid obstacle. *Parameter.*
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Obstacle {
    /// Where it is.
    pub shape: Shape,
}

/// Moves an obstacle: it is turned, then displaced. *Parameter.*
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct ObstaclePath {
    /// Where it is drawn, for a path that passes the origin.
    pub origin: Shape,
    /// By how much it is displaced over time.
    pub path: Path,
    /// How it turns, if it does.
    pub turning: Option<Turning>,
}

impl ObstaclePath {
    /// Shape of the obstacle at a time \[ms\].
    pub fn at(&self, time: f64) -> Shape {
        let turned = match &self.turning {
            Some(turning) => self.origin.turned(turning.at(time), turning.pivot),
            None => self.origin.clone(),
        };
        turned.moved_by(self.path.at(time))
    }
}

/// Makes a body feel obstacles: a penalty force along the obstacle's normal on every vertex inside, implicit in the step, and
/// friction. Where a triangle is longer than half the obstacle's least radius of curvature, its deepest point is held as well. So
/// an obstacle thinner than an edge does not pierce the body between vertices. Friction acts at vertices alone. In a static solve
/// the slip is the way since its start, as of one slow straight motion. *Parameter.*
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Contact {
    /// Penalty stiffness of obstacles per rest area \[N/mm³\], > 0: pressure over penetration. Without it thirty times the membrane's own
    /// stiffness at every vertex, for which a body at rest is less than a hundredth of an edge inside.
    pub stiffness: Option<f64>,
    /// Coefficient μ of Coulomb's friction with obstacles, ≥ 0.
    pub friction: f64,
    /// Contact of the body with itself; `None` for none.
    pub self_contact: Option<SelfContact>,
    /// Contact with other bodies that ask for it too, at the mean of both radii of `self_contact`, which it needs.
    pub between_bodies: bool,
}

impl Shape {
    /// The shape displaced.
    #[must_use]
    pub fn moved_by(&self, offset: DVec3) -> Self {
        match self.clone() {
            Self::Plane { point, normal } => Self::Plane { point: point + offset, normal },
            Self::Sphere { centre, radius } => Self::Sphere { centre: centre + offset, radius },
            Self::Ellipsoid { centre, half_axes, axes } => Self::Ellipsoid { centre: centre + offset, half_axes, axes },
            Self::Capsule { ends, radius } => Self::Capsule { ends: ends.map(|end| end + offset), radius },
            Self::Box { centre, half, axes } => Self::Box { centre: centre + offset, half, axes },
            Self::Cylinder { ends, radius } => Self::Cylinder { ends: ends.map(|end| end + offset), radius },
            Self::Mesh { hull, centre, axes } => Self::Mesh { hull, centre: centre + offset, axes },
        }
    }

    /// The shape turned about a point \[mm\].
    #[must_use]
    pub fn turned(&self, turn: DMat3, pivot: DVec3) -> Self {
        let at = |p: DVec3| turn * (p - pivot) + pivot;
        match self.clone() {
            Self::Plane { point, normal } => Self::Plane { point: at(point), normal: turn * normal },
            Self::Sphere { centre, radius } => Self::Sphere { centre: at(centre), radius },
            Self::Ellipsoid { centre, half_axes, axes } => {
                Self::Ellipsoid { centre: at(centre), half_axes, axes: turn * axes }
            }
            Self::Capsule { ends, radius } => Self::Capsule { ends: ends.map(at), radius },
            Self::Box { centre, half, axes } => Self::Box { centre: at(centre), half, axes: turn * axes },
            Self::Cylinder { ends, radius } => Self::Cylinder { ends: ends.map(at), radius },
            Self::Mesh { hull, centre, axes } => Self::Mesh { hull, centre: at(centre), axes: turn * axes },
        }
    }

    /// Largest n·x \[mm\] of its points x along a unit vector n; `None` for a plane and a mesh.
    pub(crate) fn farthest(&self, n: DVec3) -> Option<f64> {
        let of_ends = |ends: &[DVec3; 2]| n.dot(ends[0]).max(n.dot(ends[1]));
        Some(match self {
            Self::Plane { .. } | Self::Mesh { .. } => return None,
            Self::Sphere { centre, radius } => n.dot(*centre) + radius,
            Self::Ellipsoid { centre, half_axes, axes } => n.dot(*centre) + (axes.transpose() * n * half_axes).length(),
            Self::Capsule { ends, radius } => of_ends(ends) + radius,
            Self::Box { centre, half, axes } => n.dot(*centre) + (axes.transpose() * n).abs().dot(*half),
            Self::Cylinder { ends, radius } => {
                of_ends(ends) + radius * (n - n.project_onto(ends[1] - ends[0])).length()
            }
        })
    }

    /// A point that goes with it \[mm\].
    pub fn anchor(&self) -> DVec3 {
        match *self {
            Self::Plane { point, .. } => point,
            Self::Sphere { centre, .. }
            | Self::Ellipsoid { centre, .. }
            | Self::Box { centre, .. }
            | Self::Mesh { centre, .. } => centre,
            Self::Capsule { ends: [a, b], .. } | Self::Cylinder { ends: [a, b], .. } => a.midpoint(b),
        }
    }

    /// Half of its least width \[mm\]; infinite for a plane, and for a mesh, which vertices alone feel.
    pub(crate) fn least_half_width(&self) -> f64 {
        match *self {
            Self::Plane { .. } | Self::Mesh { .. } => f64::INFINITY,
            Self::Sphere { radius, .. } | Self::Capsule { radius, .. } => radius,
            Self::Ellipsoid { half_axes, .. } => half_axes.min_element(),
            Self::Box { half, .. } => half.min_element(),
            Self::Cylinder { ends: [a, b], radius } => radius.min(0.5 * a.distance(b)),
        }
    }

    /// How far a point is from the middle over how far the surface is, along the same ray; `None` for a shape that is none with
    /// flat faces.
    pub(crate) fn gauge(&self, x: DVec3) -> Option<f64> {
        match *self {
            Self::Box { centre, half, axes } => Some(((axes.transpose() * (x - centre)).abs() / half).max_element()),
            Self::Cylinder { ends: [a, b], radius } => {
                let axis = (b - a).normalize_or_zero();
                let from_middle = x - a.midpoint(b);
                let along = from_middle.dot(axis);
                let out = (from_middle - axis * along).length();
                Some((out / radius).max(along.abs() / (0.5 * a.distance(b))))
            }
            _ => None,
        }
    }

    /// Whether the obstacle may reach into a ball: wherever it does, and for ellipsoids and capsules in some cases more.
    pub fn reaches(&self, ball_centre: DVec3, ball_radius: f64) -> bool {
        let extent = match *self {
            Self::Plane { point, normal } => return (ball_centre - point).dot(normal) <= ball_radius,
            Self::Sphere { radius, .. } => radius,
            Self::Ellipsoid { half_axes, .. } => half_axes.max_element(),
            Self::Capsule { ends: [a, b], radius } => 0.5 * a.distance(b) + radius,
            Self::Box { half, .. } => half.length(),
            Self::Cylinder { ends: [a, b], radius } => (0.25 * a.distance_squared(b) + radius * radius).sqrt(),
            Self::Mesh { ref hull, .. } => hull.radius(),
        };
        self.anchor().distance(ball_centre) <= extent + ball_radius
    }

    /// Signed distance \[mm\] (negative inside) and unit outward normal at the closest surface point. `None` at a centre, which
    /// has no normal.
    pub fn distance(&self, x: DVec3) -> Option<(f64, DVec3)> {
        let from_point = |point: DVec3, radius: f64| {
            let d = x - point;
            let length = d.length();
            (length > 0.0).then(|| (length - radius, d / length))
        };
        match *self {
            Self::Plane { point, normal } => Some(((x - point).dot(normal), normal)),
            Self::Sphere { centre, radius } => from_point(centre, radius),
            Self::Ellipsoid { centre, half_axes, axes } => {
                let local = axes.transpose() * (x - centre);
                let (closest, normal) = solid::closest_on_ellipsoid(local, half_axes);
                Some(((local - closest).dot(normal), axes * normal))
            }
            Self::Capsule { ends: [a, b], radius } => {
                let axis = b - a;
                let along = ((x - a).dot(axis) / axis.length_squared()).clamp(0.0, 1.0);
                from_point(if along.is_finite() { a + axis * along } else { a }, radius)
            }
            Self::Box { centre, half, axes } => {
                let (distance, normal) = solid::of_box(axes.transpose() * (x - centre), half);
                Some((distance, axes * normal))
            }
            Self::Cylinder { ends, radius } => solid::of_cylinder(x, ends, radius),
            Self::Mesh { ref hull, centre, axes } => {
                let (distance, normal) = hull.distance(axes.transpose() * (x - centre))?;
                Some((distance, axes * normal))
            }
        }
    }

    /// Where a way from a point outside to another first meets the surface: the point \[mm\] and the normal there. In steps of the
    /// distance, which never passes the surface (Hart 1996).
    pub fn entry(&self, from: DVec3, to: DVec3) -> Option<(DVec3, DVec3)> {
        const MOST_MARCHES: u32 = 100;
        let length = from.distance(to);
        let mut done = 0.0;
        for _ in 0..MOST_MARCHES {
            let x = if length > 0.0 { from.lerp(to, done / length) } else { from };
            let (distance, normal) = self.distance(x)?;
            if distance <= 1e-9 * length {
                return Some((x, normal));
            }
            done += distance;
            if done >= length {
                return None;
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_right_on_and_near_the_surface() {
        let e = Shape::Ellipsoid {
            centre: DVec3::new(0.0, 0.0, -3.0),
            half_axes: DVec3::new(4.0, 4.0, 2.0),
            axes: DMat3::IDENTITY,
        };
        let (d, n) = e.distance(DVec3::new(0.0, 0.0, -0.999)).unwrap();
        // Beside a plane of symmetry it is taken to be off it by 1e-12 of the half axes.
        assert!((d - 0.001).abs() < 1e-12 && (n - DVec3::Z).length() < 1e-12);
        let s = Shape::Sphere { centre: DVec3::ZERO, radius: 2.0 };
        assert_eq!(s.distance(DVec3::new(0.0, 1.0, 0.0)), Some((-1.0, DVec3::Y)));
        assert_eq!(s.distance(DVec3::ZERO), None);
    }

    #[test]
    fn a_turned_shape_has_the_distances_of_the_turned_points() {
        let turning = Turning {
            pivot: DVec3::new(1.0, -2.0, 0.5),
            vectors: Path { points: vec![(0.0, DVec3::ZERO), (2.0, DVec3::new(0.4, -1.0, 2.0))] },
        };
        let turn = turning.at(1.5);
        assert!((turn.transpose() * turn - DMat3::IDENTITY).to_cols_array().iter().all(|off| off.abs() < 1e-15));
        let (centre, ends) = (DVec3::new(0.3, 0.2, -1.0), [DVec3::ZERO, DVec3::new(1.0, 2.0, 0.5)]);
        let (half, axes) = (DVec3::new(1.0, 2.0, 0.7), DMat3::IDENTITY);
        let shapes = [
            Shape::Plane { point: centre, normal: DVec3::Z },
            Shape::Sphere { centre, radius: 0.8 },
            Shape::Ellipsoid { centre, half_axes: half, axes },
            Shape::Capsule { ends, radius: 0.4 },
            Shape::Box { centre, half, axes },
            Shape::Cylinder { ends, radius: 0.6 },
        ];
        for shape in shapes {
            for i in 1..50 {
                let at = |k: f64| 3.0 * (f64::from(i) * k).sin();
                let x = DVec3::new(at(1.1), at(2.3), at(3.7));
                let (distance, normal) = shape.distance(x).unwrap();
                let turned = shape.turned(turn, turning.pivot);
                let there = turned.distance(turn * (x - turning.pivot) + turning.pivot).unwrap();
                assert!((there.0 - distance).abs() < 1e-9, "{shape:?} at {x}: {distance} {there:?}");
                assert!((there.1 - turn * normal).length() < 1e-6, "{shape:?} at {x}: {normal} {there:?}");
            }
        }
    }

    #[test]
    fn a_way_into_a_shape_meets_it_where_it_first_does() {
        let capsule = Shape::Capsule { ends: [DVec3::NEG_X, DVec3::X], radius: 0.5 };
        let (point, normal) = capsule.entry(DVec3::new(0.3, 0.0, 10.0), DVec3::new(0.3, 0.0, -10.0)).unwrap();
        assert!((point - DVec3::new(0.3, 0.0, 0.5)).length() < 1e-6 && (normal - DVec3::Z).length() < 1e-6);
        assert_eq!(capsule.entry(DVec3::new(3.0, 0.0, 10.0), DVec3::new(3.0, 0.0, -10.0)), None);
        assert_eq!(capsule.distance(DVec3::new(3.0, 0.0, 0.0)), Some((1.5, DVec3::X)));
    }
}
