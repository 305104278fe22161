//! The Python interface of the membrane-tearing engine `rhexis`: the module `rhexis._rhexis`.
//!
//! A world is behind a lock that no call waits for; its steps run without the interpreter's lock. Arrays that Python gets are copies of its
//! own, or lent by the rules of `lent`. No panic crosses the boundary. `README.md` beside the sources has the rules.

#![deny(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::expect_used, clippy::panic, clippy::unreachable, clippy::unwrap_used))]

mod arrays;
mod body;
mod component;
mod course;
mod entity;
mod error;
mod events;
mod lent;
mod library;
mod pins;
mod report;
mod saved;
mod shown;
mod toml_form;
mod tools;
mod world;

use pyo3::prelude::*;

/// The engine as Python sees it.
#[pymodule]
fn _rhexis(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("FEATURES", library::features())?;
    module.add("ERROR_KINDS", error::Kind::ALL.map(|(_, name)| name))?;
    module.add("Error", module.py().get_type::<error::Error>())?;
    module.add_class::<world::World>()?;
    module.add_class::<entity::Entity>()?;
    module.add_class::<report::Report>()?;
    module.add_class::<saved::Snapshot>()?;
    module.add_class::<saved::Recording>()?;
    module.add_function(wrap_pyfunction!(saved::unpickled, module)?)?;
    module.add_function(wrap_pyfunction!(component::component_names, module)?)?;
    module.add_function(wrap_pyfunction!(library::catalog, module)?)?;
    module.add_function(wrap_pyfunction!(library::scene_text, module)?)?;
    module.add_function(wrap_pyfunction!(library::read_mesh, module)?)?;
    module.add_function(wrap_pyfunction!(library::grid, module)?)?;
    module.add_function(wrap_pyfunction!(library::disc, module)?)?;
    module.add_function(wrap_pyfunction!(library::cap, module)?)?;
    module.add_function(wrap_pyfunction!(library::verify, module)?)?;
    module.add_function(wrap_pyfunction!(library::verify_cases, module)?)?;
    module.add_function(wrap_pyfunction!(library::work_precision, module)?)?;
    module.add_function(wrap_pyfunction!(library::work_precision_cases, module)?)?;
    Ok(())
}
