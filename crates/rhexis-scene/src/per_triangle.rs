//! From `per_triangle` and `fibres = { array = … }` to what differs from triangle to triangle.

use super::build::Sheet;
use super::error::Fault;
use super::files::Files;
use super::mesh_file::{self, MeshFile};
use super::mesh_on_file::Arrays;
use super::schema::{BodySpec, FibreSpec, MeshSpec, Numbers, RegionSpec, Strain, Values};
use super::shape::refused_file;
use rhexis::components::{EnergyCriterion, Tearing};
use rhexis::math::Sym2;
use rhexis::membrane::Membrane;

/// Values for each triangle, by rows.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Rows {
    values: Vec<f64>,
    /// How many a triangle has.
    width: usize,
    /// Where they come from, in words.
    from: String,
}

/// What a body gives its triangles, read once for all its copies.
#[derive(Clone, Debug, Default)]
pub(super) struct PerTriangle {
    thickness: Option<Rows>,
    strength: Option<Rows>,
    toughness: Option<Rows>,
    pre_stretch: Option<Rows>,
}

/// The arrays that a body asks of its mesh file; `key` is the body's path in the scene.
///
/// # Errors
/// Where its mesh is no file.
pub(super) fn arrays(spec: &BodySpec, key: &str) -> Result<Arrays, Fault> {
    let fibres = match &spec.fibres {
        Some(FibreSpec::Array(name)) => Some(name.clone()),
        _ => None,
    };
    let given = spec.per_triangle.iter().flat_map(|spec| spec.given());
    let mut asked: Vec<(String, String)> = given
        .filter_map(|(name, values)| match values {
            Values::Array(array) => Some((format!("per_triangle.{name}"), array.clone())),
            _ => None,
        })
        .collect();
    asked.extend(fibres.iter().map(|name| ("fibres.array".to_owned(), name.clone())));
    let is_file = matches!(spec.mesh, MeshSpec::File(_));
    if let Some((name, _)) = asked.first().filter(|_| !is_file) {
        let what = "arrays are those of mesh files, and this mesh is none";
        return Err(Fault::new(format!("{key}.{name}"), what, "give `mesh = { file = … }`, or a list of values"));
    }
    let mut others: Vec<String> =
        asked.into_iter().filter(|(name, _)| name != "fibres.array").map(|(_, array)| array).collect();
    let count = others.len();
    regions(spec).for_each(|region| arrays_of(region, &mut others));
    if others.len() > count && !is_file {
        let what = "a region asks for an array, and only mesh files have arrays";
        return Err(Fault::new(key, what, "give `mesh = { file = … }`, or a region by x, y, z"));
    }
    Ok(Arrays { fibres, others })
}

/// All regions of a body.
fn regions(spec: &BodySpec) -> impl Iterator<Item = &RegionSpec> {
    let holds = spec.holds.iter().map(|hold| &hold.region);
    let loads = spec.point_loads.iter().map(|load| &load.region);
    let edges = spec.edge_loads.iter().map(|load| &load.region);
    let holds = holds.chain(spec.clamps.iter().map(|clamp| &clamp.region));
    let holds = holds.chain(spec.materials.iter().map(|part| &part.region));
    let beds = spec.beds.iter().map(|bed| &bed.region);
    holds.chain(loads).chain(edges).chain(spec.springs.iter().map(|spring| &spring.region)).chain(beds)
}

fn arrays_of(region: &RegionSpec, names: &mut Vec<String>) {
    names.extend(region.array.iter().map(|array| array.name.clone()));
    region.any.iter().flatten().chain(region.except.as_deref()).for_each(|region| arrays_of(region, names));
}

/// Reads what a body gives its triangles.
///
/// # Errors
/// For an array or file that is not there, or with another number of rows than triangles.
pub(super) fn read(spec: &BodySpec, file: &MeshFile, files: &Files, key: &str) -> Result<PerTriangle, Fault> {
    let mut read = PerTriangle::default();
    for (name, values) in spec.per_triangle.iter().flat_map(|spec| spec.given()) {
        let rows = rows(values, file, files, &format!("{key}.per_triangle.{name}"))?;
        let place = match name {
            "thickness" => &mut read.thickness,
            "strength" => &mut read.strength,
            "toughness" => &mut read.toughness,
            _ => &mut read.pre_stretch,
        };
        *place = Some(rows);
    }
    Ok(read)
}

fn rows(values: &Values, file: &MeshFile, files: &Files, key: &str) -> Result<Rows, Fault> {
    let (lists, from) = match values {
        Values::Array(name) => {
            let found = file.per_triangle(name);
            let (values, width) = found.map_err(|what| Fault::new(key, what, "name one of its arrays"))?;
            return Ok(Rows { values, width, from: format!("the array {name:?}") });
        }
        Values::List(list) => (list.iter().map(entry).collect::<Vec<_>>(), "the list".to_owned()),
        Values::File(path) => {
            let lines = mesh_file::rows_of(files, path);
            let lines = lines.map_err(|error| refused_file(&format!("{key}.file"), error))?;
            (lines.into_iter().map(|(_, values)| values).collect(), format!("the file {}", path.display()))
        }
    };
    let by_triangle = file.by_triangle(lists, &from);
    let lists = by_triangle.map_err(|what| Fault::new(key, what, "give one for each triangle, in the mesh's order"))?;
    let width = lists.first().map_or(0, Vec::len);
    if let Some(row) = lists.iter().position(|list| list.len() != width) {
        let what = format!("{from} has {} numbers for triangle {row}, and {width} for the first", lists[row].len());
        return Err(Fault::new(key, what, "give the same count for each"));
    }
    Ok(Rows { values: lists.into_iter().flatten().collect(), width, from })
}

fn entry(numbers: &Numbers) -> Vec<f64> {
    match numbers {
        Numbers::One(value) => vec![*value],
        Numbers::List(list) => list.iter().flat_map(entry).collect(),
    }
}

/// Gives a membrane the values of its triangles, where the body as a whole has these terms of tearing.
///
/// # Errors
/// For a value out of its range, and where there is nothing that it could differ from.
pub(super) fn values(
    mut membrane: Membrane,
    (spec, sheet): (&BodySpec, &Sheet),
    (tearing, energy): (Option<&Tearing>, Option<&EnergyCriterion>),
    key: &str,
) -> Result<Membrane, Fault> {
    // And what the file gives its vertices.
    if let Some(attributes) = &sheet.file.attributes {
        membrane = membrane.with(attributes.clone());
    }
    let PerTriangle { thickness, strength, toughness, pre_stretch } = &sheet.per_triangle;
    let at = |name: &str| format!("{key}.per_triangle.{name}");
    if let Some(rows) = thickness {
        membrane = membrane.thicknesses(positive(rows, spec.material.thickness.at(0.0), &at("thickness"))?);
    }
    if let Some(rows) = pre_stretch {
        membrane = membrane.pre_stretches(strains(rows, spec.pre_stretch, &at("pre_stretch"))?);
    }
    for (name, rows) in [("strength", strength), ("toughness", toughness)] {
        if let (Some(_), None) = (rows, tearing) {
            let what = format!("a {name} is asked when it tears, and this body does not");
            return Err(Fault::new(at(name), what, "add a `tearing` table, or remove this one"));
        }
    }
    let Some(tearing) = tearing else { return Ok(membrane) };
    let over = |list: Vec<f64>, own: f64| list.into_iter().map(|value| value / own).collect::<Vec<f64>>();
    let own = tearing.strength_along_fibres;
    let strengths = strength.as_ref().map(|rows| positive(rows, own, &at("strength"))).transpose()?;
    let strengths = strengths.map(|list| over(list, own));
    // Thresholds that follow from toughnesses, or these from them, still do in every triangle: G_c grows with the strength's square.
    let is_derived = spec.energy_criterion.is_none();
    let of_tearing = spec.tearing.as_ref().and_then(|spec| spec.toughness_along_fibres.as_ref());
    let of_tearing = of_tearing.map(|curve| curve.at(0.0));
    let own = energy.map(|energy| energy.toughness.along).or(of_tearing);
    let toughnesses = match (toughness, own) {
        (Some(rows), Some(own)) => Some(over(positive(rows, own, &at("toughness"))?, own)),
        (Some(_), None) => {
            let what = "this body tears by its strengths, and has no toughness";
            let hint = "give `strength` per triangle, or toughnesses in `tearing` or `energy_criterion`";
            return Err(Fault::new(at("toughness"), what, hint));
        }
        (None, _) => None,
    };
    let squares = |list: &Vec<f64>| list.iter().map(|factor| factor * factor).collect();
    let roots = |list: &Vec<f64>| list.iter().map(|factor| factor.sqrt()).collect();
    let of_strengths = strengths.as_ref().filter(|_| is_derived && energy.is_some()).map(squares);
    let of_toughnesses = toughnesses.as_ref().filter(|_| is_derived).map(roots);
    if let Some(list) = strengths.or(of_toughnesses) {
        membrane = membrane.strengths(list);
    }
    if let Some(list) = toughnesses.or(of_strengths) {
        membrane = membrane.toughnesses(list);
    }
    Ok(membrane)
}

/// A positive number for each triangle; `default` where there is none.
fn positive(rows: &Rows, default: f64, key: &str) -> Result<Vec<f64>, Fault> {
    let Rows { values, width, from } = rows;
    if *width != 1 {
        let what = format!("{from} has {width} numbers for a triangle, not 1");
        return Err(Fault::new(key, what, "give one number for each"));
    }
    let own = |(triangle, &value): (usize, &f64)| {
        let value = if value.is_nan() { default } else { value };
        if value > 0.0 && value.is_finite() {
            return Ok(value);
        }
        let what = format!("{from} has {value} at triangle {triangle}");
        Err(Fault::new(key, what, "give positive numbers, or NaN for the body's own"))
    };
    values.iter().enumerate().map(own).collect()
}

/// What each triangle has beside the body's own pre-stretch.
fn strains(rows: &Rows, own: Option<Strain>, key: &str) -> Result<Vec<Sym2>, Fault> {
    let Rows { values, width, from } = rows;
    let own = own.map_or(Sym2::ZERO, |strain| strain.0);
    let hint = "give one number, or along, across and shear in the fibre's axes; NaN for the body's own";
    let strain = |(triangle, row): (usize, &[f64])| {
        let strain = match *row {
            [all] => Sym2::new(all, all, 0.0),
            [along, across] => Sym2::new(along, across, 0.0),
            [along, across, shear] => Sym2::new(along, across, shear),
            // A tensor by rows.
            [along, shear, other, across] if shear == other || shear.is_nan() => Sym2::new(along, across, shear),
            [_, _, _, _] => {
                let what = format!("{from} has a tensor at triangle {triangle} that is not symmetric");
                return Err(Fault::new(key, what, hint));
            }
            _ => {
                let what = format!("{from} has {} numbers for a triangle, not 1, 2, 3 or 4", row.len());
                return Err(Fault::new(key, what, hint));
            }
        };
        if row.iter().any(|value| value.is_nan()) {
            return Ok(Sym2::ZERO);
        }
        if row.iter().any(|value| value.is_infinite()) {
            let what = format!("{from} is not finite at triangle {triangle}");
            return Err(Fault::new(key, what, hint));
        }
        Ok(strain - own)
    };
    values.chunks(*width).enumerate().map(strain).collect()
}
