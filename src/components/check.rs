//! How a component is judged: by one check in its own file, wherever it comes in.

use super::BodyError;
use crate::math::MAX_COORDINATE;
use crate::storage::{Topology, Triangles, Vertices};

/// More of anything than a run can count to: beyond, a sum would run over.
pub(crate) const MOST_COUNTED: u64 = 1 << 30;

/// The mesh of the body that is to carry a component; an obstacle or a tool has none.
#[derive(Clone, Copy, Default)]
pub struct Host<'a> {
    /// Number of vertices.
    pub count: usize,
    /// Triangles, and which of them meet at each vertex.
    pub surface: Option<(&'a Triangles, &'a Topology)>,
}

impl<'a> Host<'a> {
    /// A body's mesh, if all of it is there.
    pub fn new(vertices: Option<&'a Vertices>, surface: Option<(&'a Triangles, &'a Topology)>) -> Self {
        Self { count: vertices.map_or(0, Vertices::len), surface }
    }

    /// Judges vertex rows.
    pub fn rows<'r>(
        &self,
        component: &'static str,
        what: impl Fn() -> String,
        rows: impl IntoIterator<Item = &'r u32>,
    ) -> Result<(), BodyError> {
        match rows.into_iter().find(|&&row| row as usize >= self.count) {
            Some(&row) => Err(BodyError::NoSuchVertex { component, what: what(), row, count: self.count }),
            None => Ok(()),
        }
    }
}

/// Which kind of entity carries a component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Owner {
    Body,
    Obstacle,
    Forceps,
    Blade,
}

/// A component whose numbers and rows can be judged.
pub trait Check {
    /// Who carries it.
    const OWNER: Owner = Owner::Body;

    /// Judges it, as a part of the body that has this mesh.
    fn check(&self, host: &Host<'_>) -> Result<(), BodyError>;
}

/// Judges one number.
pub(crate) fn number(
    component: &'static str,
    what: &'static str,
    value: f64,
    (is_right, must): (bool, &'static str),
) -> Result<(), BodyError> {
    is_right.then_some(()).ok_or(BodyError::OutOfRange { component, what, row: None, value, must })
}

pub(crate) fn positive(component: &'static str, what: &'static str, value: f64) -> Result<(), BodyError> {
    number(component, what, value, (value > 0.0 && value.is_finite(), "it must be positive and finite"))
}

pub(crate) fn not_negative(component: &'static str, what: &'static str, value: f64) -> Result<(), BodyError> {
    number(component, what, value, (value >= 0.0 && value.is_finite(), "it must be zero or more, and finite"))
}

/// Judges all parts of a vector.
pub(crate) fn finite(
    component: &'static str,
    what: &'static str,
    values: impl IntoIterator<Item = f64>,
) -> Result<(), BodyError> {
    values.into_iter().try_for_each(|value| number(component, what, value, (value.is_finite(), "it must be finite")))
}

/// Judges all parts of a place or a strain, whose powers are taken.
pub(crate) fn place(
    component: &'static str,
    what: &'static str,
    values: impl IntoIterator<Item = f64>,
) -> Result<(), BodyError> {
    let is_right = |value: f64| (value.abs() <= MAX_COORDINATE, "it must be at most 1e75 in size");
    values.into_iter().try_for_each(|value| number(component, what, value, is_right(value)))
}

/// Judges a length.
pub(crate) fn length(component: &'static str, what: &'static str, value: f64) -> Result<(), BodyError> {
    number(component, what, value, (value > 0.0 && value <= MAX_COORDINATE, "it must be positive, and at most 1e75"))
}

/// Adds a vertex row to an out-of-range error.
pub(crate) fn at_row(row: u32) -> impl Fn(BodyError) -> BodyError {
    move |error| match error {
        BodyError::OutOfRange { component, what, value, must, .. } => {
            BodyError::OutOfRange { component, what, row: Some(row), value, must }
        }
        other => other,
    }
}
