//! What there is without a world: the catalog, meshes, verification.

use crate::arrays::{of_points, table};
use crate::error::{Answer, Failure, Kind, guarded, refused, unreadable};
use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rhexis::storage::TriangleMesh;
use rhexis_scene::catalog::CATALOG;
use rhexis_scene::mesh_file::{self, MeshFileError};
use std::path::PathBuf;

type Mesh<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<u32>>, Option<Bound<'py, PyArray2<f64>>>);

/// Features that this build has.
pub(crate) fn features() -> Vec<&'static str> {
    [("direct", cfg!(feature = "direct")), ("verify", cfg!(feature = "verify"))]
        .into_iter()
        .filter_map(|(name, is_there)| is_there.then_some(name))
        .collect()
}

fn mesh(py: Python<'_>, mesh: TriangleMesh) -> PyResult<Mesh<'_>> {
    let fibres = mesh.fibres.map(|fibres| of_points(py, &fibres)).transpose()?;
    Ok((of_points(py, &mesh.positions)?, table(py, 3, mesh.triangles.as_flattened().to_vec())?, fibres))
}

/// Scenes of the catalog: names, and one sentence about each.
#[pyfunction]
pub(crate) fn catalog(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let told = PyDict::new(py);
    CATALOG.iter().try_for_each(|entry| told.set_item(entry.name, entry.about()))?;
    Ok(told)
}

/// Text of a scene of the catalog.
#[pyfunction]
pub(crate) fn scene_text(name: &str) -> PyResult<&'static str> {
    Ok(rhexis_scene::catalog::find(name).map_err(unreadable)?.text)
}

/// A surface from a mesh file: vertices, triangles, fibres if it has any.
#[pyfunction]
pub(crate) fn read_mesh(py: Python<'_>, path: PathBuf) -> PyResult<Mesh<'_>> {
    let failed = |error: MeshFileError| Failure::new(Kind::File, error);
    mesh(py, py.detach(|| guarded(|| mesh_file::read(&path).map_err(failed)))?)
}

/// A rectangle in the plane z = 0: vertices, triangles, no fibres.
#[pyfunction]
pub(crate) fn grid(py: Python<'_>, width: f64, height: f64, nx: usize, ny: usize) -> PyResult<Mesh<'_>> {
    mesh(py, guarded(|| rhexis::generate::grid(width, height, nx, ny).map_err(refused))?)
}

/// A disc in the plane z = 0 of about so many triangles.
#[pyfunction]
pub(crate) fn disc(py: Python<'_>, radius: f64, triangles: usize) -> PyResult<Mesh<'_>> {
    mesh(py, guarded(|| rhexis::generate::disc(radius, triangles).map_err(refused))?)
}

/// A cap of a sphere of about so many triangles, its pole at the origin.
#[pyfunction]
pub(crate) fn cap(py: Python<'_>, curvature_radius: f64, diameter: f64, triangles: usize) -> PyResult<Mesh<'_>> {
    mesh(py, guarded(|| rhexis::generate::cap(curvature_radius, diameter, triangles).map_err(refused))?)
}

#[cfg(not(feature = "verify"))]
fn absent<R>() -> Answer<R> {
    let message = "this build is without `verify`: maturin build --features verify, or the program `rhexis verify`";
    Err(Failure::new(Kind::Unavailable, message))
}

/// Names of the comparisons with independent results, and what each shows.
#[pyfunction]
pub(crate) fn verify_cases(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    #[cfg(feature = "verify")]
    {
        let told = PyDict::new(py);
        rhexis_lab::verify::CASES.iter().try_for_each(|case| told.set_item(case.name, case.about))?;
        Ok(told)
    }
    #[cfg(not(feature = "verify"))]
    {
        let _ = py;
        Ok(absent()?)
    }
}

/// Compares the engine with independent results: rows of case, what, error, tolerance, unit, verdict.
#[pyfunction]
#[pyo3(signature = (case, quick = true))]
pub(crate) fn verify<'py>(py: Python<'py>, case: &str, quick: bool) -> PyResult<Vec<Bound<'py, PyDict>>> {
    #[cfg(feature = "verify")]
    {
        rows(py, case, quick)
    }
    #[cfg(not(feature = "verify"))]
    {
        let _ = (py, case, quick);
        Ok(absent()?)
    }
}

#[cfg(feature = "verify")]
fn rows<'py>(py: Python<'py>, case: &str, quick: bool) -> PyResult<Vec<Bound<'py, PyDict>>> {
    use rhexis_lab::verify::{Artifacts, CASES, Depth};
    let unknown = || {
        let near = rhexis_scene::nearest(case, CASES.iter().map(|case| case.name));
        let near = near.map_or(String::new(), |near| format!(": did you mean `{near}`?"));
        Failure::new(Kind::NotFound, format!("there is no case `{case}`{near}"))
    };
    let found = CASES.iter().find(|known| known.name == case).ok_or_else(unknown)?;
    let depth = if quick { Depth::Quick } else { Depth::Full };
    let artifacts = Artifacts { directory: None, depth };
    let failed = |error| Failure::new(Kind::NotSolved, format!("{case}: {error}"));
    let rows = py.detach(|| guarded(|| (found.run)(&artifacts).map_err(failed)))?;
    let told = rows.iter().map(|row| {
        let told = PyDict::new(py);
        told.set_item("case", row.case)?;
        told.set_item("what", &row.what)?;
        told.set_item("error", row.error)?;
        told.set_item("tolerance", (!row.is_informative()).then_some(row.tolerance))?;
        told.set_item("unit", row.unit)?;
        told.set_item("passes", row.passes())?;
        Ok(told)
    });
    told.collect()
}
