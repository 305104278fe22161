//! From `per_triangle` and `fibres = { array = … }` to what differs from triangle to triangle.

use super::error::Fault;
use super::mesh_file::MeshFile;
use super::mesh_on_file::Arrays;
use super::schema::{BodySpec, FibreSpec, MeshSpec, RegionSpec};
use rhexis::membrane::Membrane;

/// The arrays that a body asks of its mesh file; `key` is the body's path in the scene.
///
/// # Errors
/// Where its mesh is no file.
pub(super) fn arrays(spec: &BodySpec, key: &str) -> Result<Arrays, Fault> {
    let fibres = match &spec.fibres {
        Some(FibreSpec::Array(name)) => Some(name.clone()),
        _ => None,
    };
    let mut others: Vec<String> = spec.per_triangle.iter().filter_map(|arrays| arrays.thickness.clone()).collect();
    let count = others.len();
    regions(spec).for_each(|region| arrays_of(region, &mut others));
    let asked = [(fibres.is_some(), "fibres.array"), (spec.per_triangle.is_some(), "per_triangle")];
    if others.len() > count && !matches!(spec.mesh, MeshSpec::File(_)) {
        let what = "a region asks for an array, and only mesh files have arrays";
        return Err(Fault::new(key, what, "give `mesh = { file = … }`, or a region by x, y, z"));
    }
    match asked.iter().find(|(is_asked, _)| *is_asked) {
        Some((_, name)) if !matches!(spec.mesh, MeshSpec::File(_)) => {
            let what = "arrays are those of mesh files, and this mesh is none";
            Err(Fault::new(format!("{key}.{name}"), what, "give `mesh = { file = … }`"))
        }
        _ => Ok(Arrays { fibres, others }),
    }
}

/// All regions of a body.
fn regions(spec: &BodySpec) -> impl Iterator<Item = &RegionSpec> {
    let holds = spec.holds.iter().map(|hold| &hold.region);
    let loads = spec.point_loads.iter().map(|load| &load.region);
    let edges = spec.edge_loads.iter().map(|load| &load.region);
    holds.chain(loads).chain(edges).chain(spec.springs.iter().map(|spring| &spring.region))
}

fn arrays_of(region: &RegionSpec, names: &mut Vec<String>) {
    names.extend(region.array.iter().map(|array| array.name.clone()));
    region.any.iter().flatten().chain(region.except.as_deref()).for_each(|region| arrays_of(region, names));
}

/// Gives a membrane the values of its triangles.
///
/// # Errors
/// For an array that is not there, of more than one number a row, or of a value out of its range.
pub(super) fn values(mut membrane: Membrane, spec: &BodySpec, file: &MeshFile, key: &str) -> Result<Membrane, Fault> {
    // And what the file gives its vertices.
    if let Some(attributes) = &file.attributes {
        membrane = membrane.with(attributes.clone());
    }
    let Some(arrays) = &spec.per_triangle else { return Ok(membrane) };
    let not_yet = [
        ("strength", &arrays.strength, "the strengths of `tearing`"),
        ("toughness", &arrays.toughness, "the toughnesses of `tearing`"),
        ("pre_stretch", &arrays.pre_stretch, "`pre_stretch` of the body"),
    ];
    if let Some((name, _, instead)) = not_yet.iter().find(|(_, array, _)| array.is_some()) {
        let what = format!("the {} of a body is one for all its triangles", name.replace('_', "-"));
        let hint = format!("give {instead}; thickness can differ from triangle to triangle");
        return Err(Fault::new(format!("{key}.per_triangle.{name}"), what, hint));
    }
    if let Some(name) = &arrays.thickness {
        membrane = membrane.thicknesses(one_each(
            file,
            name,
            spec.material.thickness,
            &format!("{key}.per_triangle.thickness"),
        )?);
    }
    Ok(membrane)
}

/// A positive number for each triangle; `default` where the array has none.
fn one_each(file: &MeshFile, name: &str, default: f64, key: &str) -> Result<Vec<f64>, Fault> {
    let mut values =
        file.per_triangle(name, 1).map_err(|what| Fault::new(key, what, "name an array with one number a row"))?;
    for (triangle, value) in values.iter_mut().enumerate() {
        if value.is_nan() {
            *value = default;
        }
        if !(*value > 0.0 && value.is_finite()) {
            let what = format!("the array {name:?} has {value} at triangle {triangle}");
            return Err(Fault::new(key, what, "give positive numbers, or NaN for the body's own"));
        }
    }
    Ok(values)
}
