//! Arrays that show the engine's own memory: nothing is copied, unless an array outlives the state that it shows.
//!
//! The only file of this crate with unsafe code. A column of a body's table is lent as it lies in memory. Whoever may change a world gets
//! it after [`Loans::hand_over`]: a column that an array still shows becomes the array's own, as it is, and the engine goes on with a copy.
//! So memory that an array shows is not written to, moved or freed before the last array that shows it is gone.

#![allow(unsafe_code, reason = "an array borrows memory that Rust owns")]

use crate::error::{Answer, Failure};
use numpy::ndarray::ArrayView2;
use numpy::{Element, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use rhexis::glam::DVec3;
use rhexis::hecs::World;
use rhexis::simulation::BodyView;
use rhexis::storage::{BodyId, Triangles, Vertices};
use std::sync::{Arc, OnceLock, Weak};

// Points are lent as their numbers.
const _: () = assert!(size_of::<DVec3>() == 3 * size_of::<f64>() && align_of::<DVec3>() == align_of::<f64>());

/// What is lent of a body.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Column {
    Positions,
    RestPositions,
    Velocities,
    Corners,
}

/// Memory that was handed over.
enum Kept {
    Points { _memory: Vec<DVec3> },
    Corners { _memory: Vec<[u32; 3]> },
}

impl Column {
    /// Takes the column's memory out of the world, which goes on with a copy.
    fn take(self, world: &World, body: BodyId) -> Option<Kept> {
        let points = |column: fn(&mut Vertices) -> &mut Vec<DVec3>| {
            let mut vertices = world.get::<&mut Vertices>(body.entity()).ok()?;
            Some(Kept::Points { _memory: out_of(column(&mut vertices)) })
        };
        match self {
            Self::Positions => points(|vertices| &mut vertices.position),
            Self::RestPositions => points(|vertices| &mut vertices.rest_position),
            Self::Velocities => points(|vertices| &mut vertices.velocity),
            Self::Corners => {
                let mut triangles = world.get::<&mut Triangles>(body.entity()).ok()?;
                Some(Kept::Corners { _memory: out_of(&mut triangles.corners) })
            }
        }
    }
}

fn out_of<T: Clone>(column: &mut Vec<T>) -> Vec<T> {
    let copy = column.clone();
    std::mem::replace(column, copy)
}

/// A column that arrays show: the engine's until it is handed over.
struct Loan {
    kept: OnceLock<Kept>,
}

/// What arrays of one loan have as their base: it lives as long as they do.
#[pyclass(frozen, module = "rhexis")]
struct Lent {
    _loan: Arc<Loan>,
}

/// Loans of a world since it was last changed.
#[derive(Default)]
pub(crate) struct Loans {
    all: Vec<(BodyId, Column, Weak<Loan>)>,
}

impl Loans {
    /// Hands over what arrays still show. Nothing of it is the engine's afterwards.
    pub(crate) fn hand_over(&mut self, world: &World) {
        for (body, column, loan) in self.all.drain(..) {
            let Some(loan) = loan.upgrade() else { continue };
            // The body is there: nothing has changed the world since. If it were not, its memory would be gone under an array.
            let Some(kept) = column.take(world, body) else { std::process::abort() };
            // It was not handed over before: this loan has left the list.
            let _ = loan.kept.set(kept);
        }
    }

    fn of(&mut self, body: BodyId, column: Column) -> Arc<Loan> {
        self.all.retain(|(.., loan)| loan.strong_count() > 0);
        let known = self.all.iter().find(|(of, which, _)| (*of, *which) == (body, column));
        if let Some(loan) = known.and_then(|(.., loan)| loan.upgrade()) {
            return loan;
        }
        let loan = Arc::new(Loan { kept: OnceLock::new() });
        self.all.push((body, column, Arc::downgrade(&loan)));
        loan
    }

    /// A read-only array of the positions, rest positions or velocities of a body, shape (n, 3).
    pub(crate) fn points<'py>(
        &mut self,
        py: Python<'py>,
        body: BodyId,
        column: Column,
        points: &[DVec3],
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        // SAFETY: a point is three numbers, by the assertion above and `repr(C)`.
        let numbers = unsafe { std::slice::from_raw_parts(points.as_ptr().cast::<f64>(), 3 * points.len()) };
        self.array(py, body, column, numbers)
    }

    /// A read-only array of the corners of the triangles, shape (m, 3).
    pub(crate) fn corners<'py>(
        &mut self,
        py: Python<'py>,
        body: BodyId,
        view: &BodyView<'_>,
    ) -> PyResult<Bound<'py, PyArray2<u32>>> {
        self.array(py, body, Column::Corners, view.triangles.as_flattened())
    }

    fn array<'py, T: Element>(
        &mut self,
        py: Python<'py>,
        body: BodyId,
        column: Column,
        numbers: &[T],
    ) -> PyResult<Bound<'py, PyArray2<T>>> {
        let shown = shaped(numbers)?;
        let base = Bound::new(py, Lent { _loan: self.of(body, column) })?;
        // SAFETY: the memory is the engine's until the world is changed, and that of the loan from then on; the array has the loan as its
        // base. Nothing writes there meanwhile, the array neither: it is made read-only before anyone sees it.
        let array = unsafe { PyArray2::borrow_from_array(&shown, base.into_any()) };
        Ok(array.try_readwrite()?.make_nonwriteable().as_any().clone().cast_into()?)
    }
}

fn shaped<T>(numbers: &[T]) -> Answer<ArrayView2<'_, T>> {
    ArrayView2::from_shape((numbers.len() / 3, 3), numbers).map_err(Failure::input)
}
