//! Rigid bodies that tissue pushes: mass properties and motion.

use crate::components::check::{finite, number, place, positive};
use crate::components::{BodyError, Shape};
use crate::math::Sym3;
use glam::{DMat3, DVec3};
use std::f64::consts::PI;

/// Motion of an obstacle that tissue pushes back. A step takes it as six more unknowns of the solve, moves the obstacle, and writes the
/// motion at its end. A host that has joints or contacts of its own sets place and motion before every step, and takes the impulse from it.
/// *State* of [`ObstacleMotion`](crate::components::ObstacleMotion).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Rigid {
    /// Mass \[g\], > 0.
    pub mass: f64,
    /// Inertia about the centre of mass in the axes of the world \[g·mm²\], positive definite.
    pub inertia: Sym3,
    /// Centre of mass \[mm\].
    pub centre: DVec3,
    /// Velocity of the centre of mass \[mm/ms\].
    pub velocity: DVec3,
    /// Angular velocity \[rad/ms\].
    pub spin: DVec3,
    /// Acceleration by all that is no contact with tissue \[mm/ms²\]: weight, 9.81e-3 along its direction.
    pub acceleration: DVec3,
    /// Impulse of the tissue in the last step \[N·ms\].
    pub impulse: DVec3,
    /// Moment of that impulse about the centre of mass \[N·mm·ms\].
    pub angular_impulse: DVec3,
}

impl Rigid {
    /// A homogeneous solid of a mass \[g\] at rest; `None` for the half space of a plane.
    ///
    /// ```
    /// use rhexis::{components::{Rigid, Shape}, glam::DVec3};
    /// let ball = Rigid::of(&Shape::Sphere { centre: DVec3::Z, radius: 5.0 }, 2.0).unwrap();
    /// assert_eq!((ball.centre, ball.inertia.diagonal), (DVec3::Z, DVec3::splat(20.0)));
    /// ```
    pub fn of(shape: &Shape, mass: f64) -> Option<Self> {
        let (centre, inertia) = match shape {
            Shape::Plane { .. } => return None,
            Shape::Sphere { centre, radius } => (*centre, Sym3::isotropic(0.4 * mass * radius * radius)),
            Shape::Ellipsoid { centre, half_axes, axes } => {
                (*centre, turned(across(*half_axes * *half_axes) * (mass / 5.0), *axes))
            }
            Shape::Box { centre, half, axes } => (*centre, turned(across(*half * *half) * (mass / 3.0), *axes)),
            Shape::Cylinder { ends: [a, b], radius } => {
                let (r_sq, length_sq) = (radius * radius, a.distance_squared(*b));
                let of_axes = (0.5 * mass * r_sq, mass * (3.0 * r_sq + length_sq) / 12.0);
                (a.midpoint(*b), about_axis(*b - *a, of_axes))
            }
            Shape::Capsule { ends: [a, b], radius } => (a.midpoint(*b), capsule(*b - *a, *radius, mass)),
            Shape::Mesh { hull, centre, axes } => {
                let (middle, inertia) = of_mesh(hull.surface(), mass);
                (*centre + *axes * middle, turned_inertia(inertia, *axes))
            }
        };
        let zero = DVec3::ZERO;
        Some(Self {
            mass,
            inertia,
            centre,
            velocity: zero,
            spin: zero,
            acceleration: zero,
            impulse: zero,
            angular_impulse: zero,
        })
    }

    pub(crate) fn check(&self, component: &'static str) -> Result<(), BodyError> {
        positive(component, "mass", self.mass)?;
        let moments = self.inertia.to_mat();
        let minors = [
            moments.x_axis.x,
            moments.x_axis.x * moments.y_axis.y - moments.x_axis.y * moments.x_axis.y,
            moments.determinant(),
        ];
        let is_definite = moments.is_finite() && minors.iter().all(|minor| *minor > 0.0 && minor.is_finite());
        number(
            component,
            "the determinant of the inertia",
            minors[2],
            (is_definite, "give a positive definite inertia"),
        )?;
        place(component, "centre of mass", self.centre.to_array())?;
        let rest = [self.velocity, self.spin, self.acceleration, self.impulse, self.angular_impulse];
        rest.into_iter().try_for_each(|value| finite(component, "motion", value.to_array()))
    }
}

/// Second moments along the axes as moments of inertia across them.
fn across(squares: DVec3) -> DVec3 {
    DVec3::splat(squares.element_sum()) - squares
}

/// Moments along axes in the axes of the world.
fn turned(moments: DVec3, axes: DMat3) -> Sym3 {
    Sym3::outer(axes.x_axis) * moments.x + Sym3::outer(axes.y_axis) * moments.y + Sym3::outer(axes.z_axis) * moments.z
}

/// A tensor turned with a body.
pub(crate) fn turned_inertia(tensor: Sym3, turn: DMat3) -> Sym3 {
    let m = turn * tensor.to_mat() * turn.transpose();
    Sym3 {
        diagonal: DVec3::new(m.x_axis.x, m.y_axis.y, m.z_axis.z),
        beside: DVec3::new(m.y_axis.z, m.z_axis.x, m.x_axis.y),
    }
}

/// Moments about an axis and across it.
fn about_axis(axis: DVec3, (along, beside): (f64, f64)) -> Sym3 {
    Sym3::isotropic(beside) + Sym3::outer(axis.normalize_or_zero()) * (along - beside)
}

/// A cylinder and two half balls.
fn capsule(axis: DVec3, radius: f64, mass: f64) -> Sym3 {
    let (length, r_sq) = (axis.length(), radius * radius);
    let volumes = [PI * r_sq * length, 4.0 / 3.0 * PI * r_sq * radius];
    let [cylinder, balls] = volumes.map(|volume| mass * volume / (volumes[0] + volumes[1]));
    let along = 0.5 * cylinder * r_sq + 0.4 * balls * r_sq;
    let beside = cylinder * (length * length / 12.0 + 0.25 * r_sq)
        + balls * (0.4 * r_sq + 0.25 * length * length + 0.375 * length * radius);
    about_axis(axis, (along, beside))
}

/// Centre of mass and inertia about it of the solid within a closed surface: sums over the tetrahedra between the origin and the triangles.
fn of_mesh((positions, triangles): (&[DVec3], &[[u32; 3]]), mass: f64) -> (DVec3, Sym3) {
    let (mut volume, mut first, mut second) = (0.0, DVec3::ZERO, Sym3::ZERO);
    for corners in triangles {
        let [a, b, c] = corners.map(|v| positions[v as usize]);
        let (sixfold, sum) = (a.dot(b.cross(c)), a + b + c);
        volume += sixfold / 6.0;
        first += sum * (sixfold / 24.0);
        second += (Sym3::outer(a) + Sym3::outer(b) + Sym3::outer(c) + Sym3::outer(sum)) * (sixfold / 120.0);
    }
    let centre = first / volume;
    let about_centre = second * (1.0 / volume) - Sym3::outer(centre);
    let trace = about_centre.diagonal.element_sum();
    (centre, (Sym3::isotropic(trace) - about_centre) * mass)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::components::Hull;
    use std::sync::Arc;

    /// A box as a mesh, away from its middle and turned, has the moments of the box: exact in both but for rounding.
    #[test]
    fn a_mesh_has_the_inertia_of_the_box_that_it_bounds() {
        let (half, centre) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(4.0, -5.0, 6.0));
        let axes = DMat3::from_rotation_z(0.3) * DMat3::from_rotation_x(1.1);
        let corner = |i: u32| DVec3::from_array([0, 1, 2].map(|k| if i >> k & 1 == 1 { 1.0 } else { -1.0 })) * half;
        let positions: Vec<DVec3> = (0..8).map(corner).collect();
        let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let (hull, _) = Hull::new(positions, triangles).unwrap();
        let mesh = Rigid::of(&Shape::Mesh { hull: Arc::new(hull), centre, axes }, 2.5).unwrap();
        let solid = Rigid::of(&Shape::Box { centre, half, axes }, 2.5).unwrap();
        assert!(mesh.centre.distance(solid.centre) < 1e-14);
        let off = mesh.inertia - solid.inertia;
        assert!(off.diagonal.length() + off.beside.length() < 1e-13, "{off:?}");
    }

    /// A short capsule has the moments of a ball; the difference is of the order of its length, 1e-9.
    #[test]
    fn a_capsule_without_length_is_a_ball() {
        let ball = Rigid::of(&Shape::Sphere { centre: DVec3::ZERO, radius: 2.0 }, 3.0).unwrap();
        let capsule = Rigid::of(&Shape::Capsule { ends: [DVec3::ZERO, DVec3::X * 1e-9], radius: 2.0 }, 3.0).unwrap();
        assert!((ball.inertia - capsule.inertia).diagonal.length() < 1e-7);
    }
}
