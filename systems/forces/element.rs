//! The triangles of a body as elements with their law.

use crate::math::{ElementState, FibreLaw, Sym2};
use crate::storage::Triangles;
use crate::systems::kernels::path_work::Element;

/// Law of a body's triangles, without the properties of each triangle.
#[derive(Clone, Copy, Debug)]
pub struct BodyLaw<'a> {
    /// Whether the body stays in its plane.
    pub is_planar: bool,
    /// The stretch of the body that is free of stress.
    pub unstretched: Sym2,
    /// Law of the fibres, if the body has one.
    pub fibres: Option<&'a FibreLaw>,
}

impl<'a> BodyLaw<'a> {
    /// A triangle with its law.
    pub fn element(self, triangles: &'a Triangles, t: usize) -> Element<'a> {
        let Self { is_planar, unstretched, fibres } = self;
        let (rest, stiffness) = (&triangles.rest[t], triangles.law(t));
        let (volume, beside) = (rest.area * triangles.thickness[t], triangles.stored_beside(t));
        let unstretched = triangles.unstretched(t, unstretched);
        Element { rest, stiffness, volume, is_planar, unstretched, beside, fibres }
    }

    /// Energy \[mJ\] that a triangle stores in a state.
    pub fn stored(self, triangles: &'a Triangles, t: usize, state: &ElementState) -> f64 {
        let element = self.element(triangles, t);
        element.volume * element.density(state)
    }
}
