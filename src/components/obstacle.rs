//! Rigid surroundings that a body cannot enter. An obstacle is an entity of its own; a body that carries [`Contact`] feels all.

use glam::DVec3;

/// The shape of an obstacle.
#[derive(Clone, Copy, Debug, PartialEq)]
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
    /// An ellipsoid with axes along x, y, z.
    Ellipsoid {
        /// Centre \[mm\].
        centre: DVec3,
        /// Half axes \[mm\].
        half_axes: DVec3,
    },
}

/// A rigid obstacle. *Parameter.*
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Obstacle {
    /// Where it is.
    pub shape: Shape,
}

/// Makes a body feel obstacles, without friction: a penalty force along the obstacle's normal, implicit in the step.
/// *Parameter.*
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Contact {
    /// Penalty stiffness per rest area \[N/mm³\], > 0: pressure over penetration.
    pub stiffness: f64,
}

impl Shape {
    /// Whether the obstacle may reach into a ball: wherever it does, and for ellipsoids in some cases more.
    pub fn reaches(&self, ball_centre: DVec3, ball_radius: f64) -> bool {
        match *self {
            Self::Plane { point, normal } => (ball_centre - point).dot(normal) <= ball_radius,
            Self::Sphere { centre, radius } => centre.distance(ball_centre) <= radius + ball_radius,
            Self::Ellipsoid { centre, half_axes } => {
                centre.distance(ball_centre) <= half_axes.max_element() + ball_radius
            }
        }
    }

    /// Signed distance \[mm\] (negative inside) and unit outward normal at the closest surface point; for an ellipsoid to
    /// first order, f/|∇f| of its implicit function, exact on the surface. `None` at a centre, which has no normal.
    pub fn distance(&self, x: DVec3) -> Option<(f64, DVec3)> {
        match *self {
            Self::Plane { point, normal } => Some(((x - point).dot(normal), normal)),
            Self::Sphere { centre, radius } => {
                let d = x - centre;
                let length = d.length();
                (length > 0.0).then(|| (length - radius, d / length))
            }
            Self::Ellipsoid { centre, half_axes } => {
                let scaled = (x - centre) / half_axes;
                let level = scaled.length();
                let gradient = scaled / half_axes / level;
                let steepness = gradient.length();
                (level > 0.0 && steepness > 0.0).then(|| ((level - 1.0) / steepness, gradient / steepness))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_right_on_and_near_the_surface() {
        let e = Shape::Ellipsoid { centre: DVec3::new(0.0, 0.0, -3.0), half_axes: DVec3::new(4.0, 4.0, 2.0) };
        let (d, n) = e.distance(DVec3::new(0.0, 0.0, -0.999)).unwrap();
        // On an axis the first-order distance is exact.
        assert!((d - 0.001).abs() < 1e-12 && (n - DVec3::Z).length() < 1e-12);
        let s = Shape::Sphere { centre: DVec3::ZERO, radius: 2.0 };
        assert_eq!(s.distance(DVec3::new(0.0, 1.0, 0.0)), Some((-1.0, DVec3::Y)));
        assert_eq!(s.distance(DVec3::ZERO), None);
    }
}
