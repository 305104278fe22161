//! Snapshots and recordings.

use crate::error::{Failure, guarded, refused};
use crate::world::{Run, World};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use rhexis::internal::bytes::{Kind, pack, unpack};
use rhexis::replay::Recording as EngineRecording;
use rhexis::snapshot::Snapshot as EngineSnapshot;
use rhexis_scene::measures::TearCourse;
use std::path::PathBuf;

/// State of a world at one moment.
#[pyclass(frozen, module = "rhexis", skip_from_py_object)]
pub(crate) struct Snapshot {
    pub(crate) value: EngineSnapshot,
    /// How far the scene of the world had come.
    progress: Option<(u64, bool)>,
    courses: Vec<TearCourse>,
}

impl Snapshot {
    fn alone(value: EngineSnapshot) -> Self {
        Self { value, progress: None, courses: Vec::new() }
    }
}

#[pymethods]
impl Snapshot {
    /// Time of the snapshot \[ms\].
    #[getter]
    fn time(&self) -> f64 {
        self.value.time()
    }

    /// Steps done until then.
    #[getter]
    fn step(&self) -> u64 {
        self.value.step()
    }

    /// The state as bytes; scene progress and courses are not in them.
    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = py.detach(|| guarded(|| self.value.to_bytes().map_err(refused)))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// A snapshot of bytes from anywhere: they are judged.
    #[staticmethod]
    fn from_bytes(py: Python<'_>, data: Vec<u8>) -> PyResult<Self> {
        Ok(Self::alone(py.detach(|| guarded(|| EngineSnapshot::from_bytes(&data).map_err(refused)))?))
    }

    /// Writes the state into a file.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        Ok(py.detach(|| guarded(|| self.value.save(&path).map_err(refused)))?)
    }

    /// A snapshot of a file.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        Ok(Self::alone(py.detach(|| guarded(|| EngineSnapshot::load(&path).map_err(refused)))?))
    }

    /// The state, the scene's progress and the courses, for `pickle` and `copy`.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Kept<'py>)> {
        let courses = (!self.courses.is_empty()).then(|| pack(Kind::Run, &self.courses)).transpose();
        let courses = courses.map_err(refused)?.map(|bytes| PyBytes::new(py, &bytes));
        let make = py.import("rhexis._rhexis")?.getattr("_snapshot")?;
        Ok((make, (self.to_bytes(py)?, self.progress, courses)))
    }

    fn __repr__(&self) -> String {
        format!("<rhexis.Snapshot: step {}, {} ms>", self.value.step(), self.value.time())
    }
}

/// Parts of a pickled snapshot: state, progress of the scene, courses.
type Kept<'py> = (Bound<'py, PyBytes>, Option<(u64, bool)>, Option<Bound<'py, PyBytes>>);

/// A snapshot of the parts that `pickle` has kept.
#[pyfunction(name = "_snapshot")]
pub(crate) fn unpickled(
    py: Python<'_>,
    data: Vec<u8>,
    progress: Option<(u64, bool)>,
    courses: Option<Vec<u8>>,
) -> PyResult<Snapshot> {
    let courses = courses.map_or(Ok(Vec::new()), |bytes| unpack(Kind::Run, &bytes)).map_err(refused)?;
    Ok(Snapshot { progress, courses, ..Snapshot::from_bytes(py, data)? })
}

/// Run that was written down.
#[pyclass(frozen, module = "rhexis", skip_from_py_object)]
pub(crate) struct Recording {
    value: EngineRecording,
}

#[pymethods]
impl Recording {
    /// Does once more what was recorded, to the same hash or to an error; a world of its end.
    fn replay(&self, py: Python<'_>) -> PyResult<World> {
        let end = py.detach(|| guarded(|| self.value.replay().map_err(refused)))?;
        Ok(World::keep(Run::Bare(Box::new(end))))
    }

    /// Hash of the end.
    #[getter]
    fn end(&self) -> u64 {
        self.value.end().0
    }

    /// Number of calls that were written down.
    fn __len__(&self) -> usize {
        self.value.inputs().len()
    }

    /// The run as bytes.
    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = py.detach(|| guarded(|| self.value.to_bytes().map_err(refused)))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// A recording of bytes from anywhere: they are judged.
    #[staticmethod]
    fn from_bytes(py: Python<'_>, data: Vec<u8>) -> PyResult<Self> {
        Ok(Self { value: py.detach(|| guarded(|| EngineRecording::from_bytes(&data).map_err(refused)))? })
    }

    /// Writes the run into a file.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        Ok(py.detach(|| guarded(|| self.value.save(&path).map_err(refused)))?)
    }

    /// A recording of a file.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        Ok(Self { value: py.detach(|| guarded(|| EngineRecording::load(&path).map_err(refused)))? })
    }
}

#[pymethods]
impl World {
    /// Takes a snapshot of the whole state, to go back to and to go on from to the same bits.
    fn snapshot(&self) -> PyResult<Snapshot> {
        self.look(|state| {
            let progress = match &state.run {
                Run::Scene(instance) => Some(instance.progress()),
                Run::Bare(_) => None,
            };
            Ok(Snapshot { value: state.simulation().snapshot(), progress, courses: state.courses.clone() })
        })
    }

    /// Goes back to a snapshot, of this world or of another one.
    fn restore(&self, py: Python<'_>, snapshot: &Snapshot) -> PyResult<()> {
        self.with(py, |state| {
            match &mut state.run {
                Run::Bare(simulation) => simulation.restore(&snapshot.value).map_err(refused)?,
                Run::Scene(instance) => {
                    let progress = snapshot.progress.unwrap_or((snapshot.value.step(), false));
                    instance.resume(&snapshot.value, progress).map_err(refused)?;
                }
            }
            state.events.clear();
            state.courses.clone_from(&snapshot.courses);
            Ok::<_, Failure>(())
        })
    }

    /// Writes down from now on what is done to the world.
    fn record(&self) -> PyResult<()> {
        self.look_mut(|state| {
            state.simulation_mut().record();
            Ok(())
        })
    }

    /// Ends the recording.
    fn end_recording(&self, py: Python<'_>) -> PyResult<Recording> {
        self.with(py, |state| {
            let none = || Failure::input("nothing is recorded: call record first");
            let value = state.simulation_mut().end_recording().ok_or_else(none)?;
            Ok::<_, Failure>(Recording { value })
        })
    }
}
