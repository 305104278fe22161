//! Where the fibres run.

use crate::math::elementary;
use glam::DVec3;
use std::sync::Arc;

/// A fibre direction for every triangle of a rest mesh. Directions are projected into the triangle's plane.
#[derive(Clone)]
pub enum Fibres {
    /// One direction everywhere.
    Uniform(DVec3),
    /// Circles about an axis through a point.
    Concentric {
        /// A point on the axis \[mm\].
        centre: DVec3,
        /// The axis' direction.
        axis: DVec3,
    },
    /// One direction per triangle, in the mesh's order.
    PerTriangle(Vec<DVec3>),
    /// A function of the triangle's rest centroid \[mm\].
    Function(Arc<dyn Fn(DVec3) -> DVec3 + Send + Sync>),
}

impl Fibres {
    /// A direction in the xy plane, `degrees` counter-clockwise from x.
    pub fn at_degrees(degrees: f64) -> Self {
        let (s, c) = elementary::sin_cos(degrees.to_radians());
        Self::Uniform(DVec3::new(c, s, 0.0))
    }

    /// The direction of the triangle `index` with this rest centroid; not yet projected, and zero where there is none (on
    /// the axis of concentric fibres).
    pub fn direction(&self, index: usize, centroid: DVec3) -> DVec3 {
        match self {
            Self::Uniform(d) => *d,
            Self::Concentric { centre, axis } => axis.cross(centroid - *centre),
            Self::PerTriangle(list) => list.get(index).copied().unwrap_or(DVec3::ZERO),
            Self::Function(f) => f(centroid),
        }
    }
}

impl std::fmt::Debug for Fibres {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Uniform(d) => write!(f, "Uniform({d})"),
            Self::Concentric { centre, axis } => write!(f, "Concentric {{ centre: {centre}, axis: {axis} }}"),
            Self::PerTriangle(list) => write!(f, "PerTriangle({} directions)", list.len()),
            Self::Function(_) => write!(f, "Function(..)"),
        }
    }
}
