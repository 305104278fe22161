//! What there is without a world: the catalog, meshes, verification, work–precision.

use crate::arrays::{of_points, table};
use crate::error::{Failure, Kind, guarded, refused, unreadable};
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
    [("direct", rhexis::internal::HAS_FACTORS), ("verify", cfg!(feature = "verify"))]
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
fn absent(command: &str) -> PyErr {
    let message = format!(
        "this build is without the feature `verify`: maturin develop --release --features verify, or the program \
         `rhexis {command}`"
    );
    Failure::new(Kind::Unavailable, message).into()
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
        Err(absent("verify"))
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
        Err(absent("verify"))
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

/// Names of the work–precision cases, and the scene of each: a dictionary. Raises `rhexis.Error` (`unavailable`) in a build without
/// the feature `verify`.
#[pyfunction]
pub(crate) fn work_precision_cases(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    #[cfg(feature = "verify")]
    {
        let told = PyDict::new(py);
        rhexis_lab::bench::SCENES.iter().try_for_each(|case| told.set_item(case.name, case.scene))?;
        Ok(told)
    }
    #[cfg(not(feature = "verify"))]
    {
        let _ = py;
        Err(absent("bench work-precision"))
    }
}

/// Measures what meshes, solvers, tolerances, time steps and integrators cost in a case, and the error that they leave: the tables
/// of `rhexis bench work-precision`.
///
/// Returns a dictionary: `solvers` and `discretisation`, lists of one dictionary per row; `remarks`, a list of sentences;
/// `fma_gflops` [GFLOP/s] and `triad_gbs` [GB/s], the machine's speed. Figures end with their unit, errors without one are
/// relative, and NaN was not measured.
///
/// `depth` is `quick` (seconds), `usual` (minutes) or `full` (an hour and some GB). The directory receives the tables as CSV and
/// their plots; without one, nothing is left behind.
///
/// Raises `rhexis.Error`: `not_found` for an unknown case, `invalid_input` for an unknown depth, `file` where the directory cannot
/// be written, `not_solved` where a reference has no answer, `unavailable` in a build without the feature `verify`.
#[pyfunction]
#[pyo3(signature = (case, depth = "quick", directory = None))]
pub(crate) fn work_precision<'py>(
    py: Python<'py>,
    case: &str,
    depth: &str,
    directory: Option<PathBuf>,
) -> PyResult<Bound<'py, PyDict>> {
    #[cfg(feature = "verify")]
    {
        measured(py, case, depth, directory)
    }
    #[cfg(not(feature = "verify"))]
    {
        let _ = (py, case, depth, directory);
        Err(absent("bench work-precision"))
    }
}

#[cfg(feature = "verify")]
fn measured<'py>(py: Python<'py>, case: &str, depth: &str, directory: Option<PathBuf>) -> PyResult<Bound<'py, PyDict>> {
    use rhexis_lab::bench::{BenchError, Context, Depth, work_precision};
    let depth = match depth {
        "quick" => Depth::Quick,
        "usual" => Depth::Usual,
        "full" => Depth::Full,
        other => Err(Failure::input(format!("there is no depth `{other}`: quick, usual or full")))?,
    };
    let temporary = match directory {
        Some(_) => None,
        None => Some(py.import("tempfile")?.call_method0("TemporaryDirectory")?),
    };
    let directory = match (&temporary, directory) {
        (Some(temporary), _) => temporary.getattr("name")?.extract()?,
        (None, directory) => directory.unwrap_or_default(),
    };
    let failed = |error: BenchError| {
        let kind = match error {
            BenchError::Unknown(_) => Kind::NotFound,
            BenchError::Scene(_) => Kind::Scene,
            BenchError::Output(_) | BenchError::File { .. } => Kind::File,
            _ => Kind::NotSolved,
        };
        Failure::new(kind, error)
    };
    let names = [case.to_owned()];
    let tables = py.detach(|| guarded(|| work_precision(&Context::quiet(directory, depth), &names).map_err(failed)));
    if let Some(temporary) = temporary {
        temporary.call_method0("cleanup")?;
    }
    let (told, mut remarks) = (PyDict::new(py), Vec::new());
    for table in tables? {
        let which = table.name.rsplit('-').next().unwrap_or_default();
        let rows = table.rows.iter().map(|row| measured_row(py, &table.columns, table.key_count, row));
        told.set_item(which, rows.collect::<PyResult<Vec<_>>>()?)?;
        told.set_item("fma_gflops", table.yardsticks.fma_gflops)?;
        told.set_item("triad_gbs", table.yardsticks.triad_gbs)?;
        remarks.extend(table.remarks);
    }
    told.set_item("remarks", remarks)?;
    Ok(told)
}

/// A row with its fields as numbers, NaN for what was not measured.
#[cfg(feature = "verify")]
fn measured_row<'py>(
    py: Python<'py>,
    columns: &[String],
    key_count: usize,
    row: &[String],
) -> PyResult<Bound<'py, PyDict>> {
    let told = PyDict::new(py);
    for (place, (name, field)) in columns.iter().zip(row).enumerate() {
        match (name.as_str(), field.as_str()) {
            ("is_default", field) => told.set_item(name, field == "true")?,
            ("triangles", field) => told.set_item(name, field.parse::<u64>()?)?,
            ("tolerance" | "time_step", field) => told.set_item(name, field.parse::<f64>()?)?,
            (_, field) if place < key_count => told.set_item(name, field)?,
            (_, "") => told.set_item(name, f64::NAN)?,
            (_, field) => told.set_item(name, field.parse::<f64>()?)?,
        }
    }
    Ok(told)
}
