//! Which numbers of obstacles are refused.

use crate::components::BodyError;
use crate::components::check::{Check, Host, Owner, length, not_negative, number, place, positive};
use crate::components::{Contact, Obstacle, ObstaclePath, Shape};
use glam::{DMat3, DVec3};

impl Shape {
    /// Judges its numbers as a part of a component.
    pub(crate) fn check(&self, component: &'static str) -> Result<(), BodyError> {
        let point = |what, point: DVec3| place(component, what, point.to_array());
        let rotation = |axes: DMat3| {
            let off =
                (axes.transpose() * axes - DMat3::IDENTITY).to_cols_array().into_iter().map(f64::abs).sum::<f64>();
            let is_rotation = off < 1e-6 && axes.determinant() > 0.0;
            number(component, "the determinant of the axes", axes.determinant(), (is_rotation, "give a rotation"))
        };
        match *self {
            Self::Plane { point: at, normal } => {
                point("a point of the plane", at)?;
                let norm = normal.length();
                // Unit vectors that were read from text or turned are so to some digits.
                let is_unit = (norm - 1.0).abs() < 1e-6;
                number(component, "the length of the normal", norm, (is_unit, "it must be 1: normalize it"))
            }
            Self::Sphere { centre, radius } => {
                point("centre", centre)?;
                length(component, "radius", radius)
            }
            Self::Ellipsoid { centre, half_axes, axes } => {
                point("centre", centre)?;
                rotation(axes)?;
                half_axes.to_array().into_iter().try_for_each(|axis| length(component, "half axis", axis))
            }
            Self::Capsule { ends, radius } => {
                ends.into_iter().try_for_each(|end| point("end", end))?;
                length(component, "radius", radius)
            }
            Self::Box { centre, half, axes } => {
                point("centre", centre)?;
                rotation(axes)?;
                half.to_array().into_iter().try_for_each(|edge| length(component, "half edge", edge))
            }
            Self::Cylinder { ends, radius } => {
                ends.into_iter().try_for_each(|end| point("end", end))?;
                length(component, "radius", radius)?;
                length(component, "length", ends[0].distance(ends[1]))
            }
            Self::Mesh { centre, axes, .. } => {
                point("centre", centre)?;
                rotation(axes)
            }
        }
    }
}

impl Check for Obstacle {
    const OWNER: Owner = Owner::Obstacle;

    fn check(&self, _: &Host<'_>) -> Result<(), BodyError> {
        self.shape.check("Obstacle")
    }
}

impl Check for ObstaclePath {
    const OWNER: Owner = Owner::Obstacle;

    fn check(&self, _: &Host<'_>) -> Result<(), BodyError> {
        self.origin.check("ObstaclePath")?;
        self.path.check("ObstaclePath")?;
        let Some(turning) = &self.turning else { return Ok(()) };
        turning.check("ObstaclePath")
    }
}

impl Check for Contact {
    fn check(&self, host: &Host<'_>) -> Result<(), BodyError> {
        self.stiffness.map_or(Ok(()), |stiffness| positive("Contact", "contact stiffness", stiffness))?;
        not_negative("Contact", "contact friction", self.friction)?;
        if self.between_bodies && self.self_contact.is_none() {
            return Err(BodyError::BetweenBodiesWithoutRadius);
        }
        self.self_contact.map_or(Ok(()), |own| own.check(host))
    }
}
