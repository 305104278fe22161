//! Arrays of NumPy, in and out.

use crate::error::{Answer, Failure};
use numpy::ndarray::Array2;
use numpy::{PyArray1, PyArray2, PyArrayDescrMethods, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;
use rhexis::glam::DVec3;

fn as_array<'py>(what: &str, value: &Bound<'py, PyAny>, dtype: Option<&str>) -> Answer<Bound<'py, PyUntypedArray>> {
    let wrong = |error: PyErr| Failure::input(format!("{what}: {error}"));
    let numpy = value.py().import("numpy").map_err(wrong)?;
    // NumPy hands masked numbers over like plain ones.
    let has_mask = numpy.getattr("ma").and_then(|ma| value.is_instance(&ma.getattr("MaskedArray")?)).map_err(wrong)?;
    if has_mask {
        return Err(Failure::input(format!("{what}: the array has a mask: fill it or select from it first")));
    }
    let array = numpy.call_method1("ascontiguousarray", (value, dtype)).map_err(wrong)?;
    array.cast_into().map_err(|error| Failure::input(format!("{what}: {error}")))
}

fn of_three(what: &str, array: &Bound<'_, PyUntypedArray>) -> Answer<()> {
    match array.shape() {
        [_, 3] => Ok(()),
        shape => Err(Failure::input(format!("{what}: the shape is {shape:?}, it must be (n, 3)"))),
    }
}

fn numbers<T: numpy::Element + Clone>(what: &str, array: &Bound<'_, PyUntypedArray>) -> Answer<Vec<T>> {
    let array = array.cast::<numpy::PyArrayDyn<T>>().map_err(|error| Failure::input(format!("{what}: {error}")))?;
    array.to_vec().map_err(|error| Failure::input(format!("{what}: {error}")))
}

/// Points from an array of shape (n, 3).
pub(crate) fn points(what: &str, value: &Bound<'_, PyAny>) -> Answer<Vec<DVec3>> {
    let array = as_array(what, value, None)?;
    // NumPy would drop the imaginary part, count seconds, and read numbers out of text.
    if matches!(array.dtype().kind(), b'c' | b'M' | b'm' | b'S' | b'U') {
        return Err(Failure::input(format!("{what}: the numbers must be real, as numpy.float64")));
    }
    let array = as_array(what, &array, Some("float64"))?;
    of_three(what, &array)?;
    let numbers = numbers::<f64>(what, &array)?;
    Ok(numbers.as_chunks::<3>().0.iter().map(|&point| DVec3::from_array(point)).collect())
}

/// Whole numbers ≥ 0 from an array of any shape; others are refused, not rounded.
fn whole(what: &str, array: &Bound<'_, PyUntypedArray>) -> Answer<Vec<u64>> {
    match array.dtype().kind() {
        _ if array.is_empty() => Ok(Vec::new()),
        b'u' => numbers(what, &as_array(what, array, Some("uint64"))?),
        b'i' => {
            let all = numbers::<i64>(what, &as_array(what, array, Some("int64"))?)?;
            let negative = |number: i64| Failure::input(format!("{what}: {number} is below zero"));
            all.into_iter().map(|number| u64::try_from(number).map_err(|_| negative(number))).collect()
        }
        _ => Err(Failure::input(format!("{what}: the numbers must be of an integer type, as numpy.uint32"))),
    }
}

/// Corners of triangles from an array of shape (m, 3).
pub(crate) fn triangles(what: &str, value: &Bound<'_, PyAny>) -> Answer<Vec<[u32; 3]>> {
    let array = as_array(what, value, None)?;
    of_three(what, &array)?;
    let large = |number: u64| Failure::input(format!("{what}: {number} is no row of a vertex"));
    let rows: Answer<Vec<u32>> =
        whole(what, &array)?.into_iter().map(|number| u32::try_from(number).map_err(|_| large(number))).collect();
    Ok(rows?.as_chunks::<3>().0.to_vec())
}

/// Keys from an array of shape (n,).
pub(crate) fn keys(what: &str, value: &Bound<'_, PyAny>) -> Answer<Vec<u64>> {
    let array = as_array(what, value, None)?;
    match array.shape() {
        [_] => whole(what, &array),
        shape => Err(Failure::input(format!("{what}: the shape is {shape:?}, it must be (n,)"))),
    }
}

/// An array of shape (n, width) of Python's own.
pub(crate) fn table<T: numpy::Element>(
    py: Python<'_>,
    width: usize,
    numbers: Vec<T>,
) -> Answer<Bound<'_, PyArray2<T>>> {
    let array = Array2::from_shape_vec((numbers.len() / width.max(1), width), numbers);
    array.map(|array| PyArray2::from_owned_array(py, array)).map_err(Failure::input)
}

/// Points as an array of shape (n, 3).
pub(crate) fn of_points<'py>(py: Python<'py>, points: &[DVec3]) -> Answer<Bound<'py, PyArray2<f64>>> {
    let mut numbers = Vec::with_capacity(3 * points.len());
    points.iter().for_each(|point| numbers.extend_from_slice(&point.to_array()));
    table(py, 3, numbers)
}

/// Points as an array of shape (n, 3) in single precision.
pub(crate) fn of_points_f32<'py>(py: Python<'py>, points: &[DVec3]) -> Answer<Bound<'py, PyArray2<f32>>> {
    let mut numbers = Vec::with_capacity(3 * points.len());
    points.iter().for_each(|point| numbers.extend_from_slice(&point.as_vec3().to_array()));
    table(py, 3, numbers)
}

/// A vector as an array of shape (3,).
pub(crate) fn of_vector(py: Python<'_>, vector: DVec3) -> Bound<'_, PyArray1<f64>> {
    PyArray1::from_slice(py, &vector.to_array())
}
