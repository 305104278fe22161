//! From what a reader found to a surface that can be torn: joined, mended, turned, with the arrays that belong to it.

use glam::DVec3;

use super::decoration::decorate;
use super::defects::{Defects, mend};
use super::draft::{Array, Draft, On, Origin, is_fibre_name};
use super::fault::Fault;
use super::{MeshFile, Reading, Tidied, weld};
use rhexis::storage::{MeshError, TriangleMesh};

/// Rounding of coordinates with seven digits, as a part of the largest: what a format of single numbers cannot tell apart.
pub(super) const ROUNDING: f64 = 4.0 * f32::EPSILON as f64;

/// Why a surface is refused.
pub(super) enum Refusal {
    /// With its line.
    Fault(Fault),
    /// By the mesh itself.
    Mesh(MeshError),
    /// All that `repair` would mend.
    Defects(Defects),
}

impl From<MeshError> for Refusal {
    fn from(error: MeshError) -> Self {
        Self::Mesh(error)
    }
}

/// Joins, mends, turns, and scales to millimetres.
pub(super) fn finish(mut draft: Draft, reading: &Reading, scale: f64) -> Result<MeshFile, Refusal> {
    if draft.triangles.is_empty() {
        return Err(MeshError::Empty("triangles").into());
    }
    check_corners(&draft)?;
    draft.decoration.vertices = draft.positions.len();
    let mut tidied = Tidied::default();
    let mut sources = drop_unused(&mut draft);
    if let Some(vertex) = draft.positions.iter().position(|p| !p.is_finite()) {
        return Err(MeshError::NonFinitePosition { vertex, position: draft.positions[vertex] }.into());
    }
    join(&mut draft, &mut sources, reading, &mut tidied);
    draft.rows = (0..draft.triangles.len() as u32).collect();
    let of_file = draft.triangles.len();
    let defects = mend(&mut draft, &mut sources, reading.repair, reading.weld.unwrap_or(0.0));
    if !reading.repair && !defects.is_none() {
        return Err(Refusal::Defects(defects));
    }
    tidied.defects = defects;
    compact(&mut draft, &mut sources);
    if draft.triangles.is_empty() {
        return Err(MeshError::Empty("triangles").into());
    }
    let before = std::mem::take(&mut draft.triangles);
    let mesh =
        TriangleMesh { positions: std::mem::take(&mut draft.positions), triangles: before.clone(), fibres: None };
    let mut mesh = mesh.oriented()?;
    tidied.turned = mesh.triangles.iter().zip(&before).filter(|(now, before)| now != before).count();
    if reading.flip {
        mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    }
    for ((rows, before), now) in draft.textured.iter_mut().zip(&before).zip(&mesh.triangles) {
        *rows = now.map(|vertex| rows[before.iter().position(|own| *own == vertex).unwrap_or(0)]);
    }
    let groups = groups(&draft, &sources);
    keep_asked(&mut draft, reading);
    let decorated = decorate(&mut draft, &sources, &mesh);
    draft.passed_over.extend(decorated.left_out);
    let mut file = MeshFile {
        arrays: arrays(&mut draft, &sources, &mesh),
        passed_over: draft.passed_over.iter().cloned().collect(),
        groups,
        mesh,
        attributes: decorated.attributes,
        seams: decorated.seams,
        textured: decorated.textured,
        fibres_from: None,
        tidied,
        rows: std::mem::take(&mut draft.rows),
        triangles_of_file: of_file,
    };
    fibres(&mut file, reading)?;
    if scale != 1.0 {
        file.mesh.positions.iter_mut().for_each(|p| *p *= scale);
    }
    file.mesh.check()?;
    Ok(file)
}

fn check_corners(draft: &Draft) -> Result<(), Refusal> {
    let count = draft.positions.len();
    for (triangle, corners) in draft.triangles.iter().enumerate() {
        if let Some(&index) = corners.iter().find(|&&index| index as usize >= count) {
            if draft.origin == Origin::Line {
                let last = count.saturating_sub(1);
                let what =
                    format!("it names vertex {index}, but there are only {count} (0 to {last}); correct the index");
                return Err(Refusal::Fault(Fault::at(draft.places[triangle] as usize, what)));
            }
            return Err(MeshError::IndexOutOfRange { triangle, index, count }.into());
        }
    }
    Ok(())
}

/// Drops the vertices without triangles; the rows in the file of those that stay.
fn drop_unused(draft: &mut Draft) -> Vec<u32> {
    let mut sources = (0..draft.positions.len() as u32).collect();
    compact(draft, &mut sources);
    sources
}

fn compact(draft: &mut Draft, sources: &mut Vec<u32>) {
    let mut row = vec![u32::MAX; draft.positions.len()];
    draft.triangles.iter().flatten().for_each(|&corner| row[corner as usize] = 0);
    for (next, row) in row.iter_mut().filter(|row| **row == 0).enumerate() {
        *row = next as u32;
    }
    let is_used = |kept: &mut std::slice::Iter<u32>| kept.next().is_some_and(|row| *row != u32::MAX);
    let mut kept = row.iter();
    draft.positions.retain(|_| is_used(&mut kept));
    let mut kept = row.iter();
    sources.retain(|_| is_used(&mut kept));
    draft.triangles.iter_mut().flatten().for_each(|corner| *corner = row[*corner as usize]);
}

fn join(draft: &mut Draft, sources: &mut Vec<u32>, reading: &Reading, tidied: &mut Tidied) {
    let largest = draft.positions.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
    let by_itself = if draft.is_soup { Some(ROUNDING * largest) } else { None };
    let Some(tolerance) = reading.weld.or(by_itself) else { return };
    let first = weld::representatives(&draft.positions, tolerance);
    tidied.joined = first.iter().enumerate().filter(|(row, first)| *row != **first as usize).count();
    if tidied.joined > 0 {
        draft.triangles.iter_mut().flatten().for_each(|corner| *corner = first[*corner as usize]);
        // Groups name the vertices of the file, of which some are now others.
        draft.joined = sources.iter().zip(&first).map(|(&source, &first)| (source, sources[first as usize])).collect();
        compact(draft, sources);
    }
}

/// The vertices of each group by their rows now.
fn groups(draft: &Draft, sources: &[u32]) -> Vec<(String, Vec<u32>)> {
    let mut now: Vec<(u32, u32)> = sources.iter().zip(0..).map(|(&source, row)| (source, row)).collect();
    now.sort_unstable();
    let rows = |vertex: u32| {
        let joined = draft.joined.binary_search_by_key(&vertex, |(from, _)| *from);
        let vertex = joined.map_or(vertex, |place| draft.joined[place].1);
        let from = now.partition_point(|(source, _)| *source < vertex);
        now[from..].iter().take_while(move |(source, _)| *source == vertex).map(|(_, row)| *row)
    };
    let groups = draft.groups.iter().map(|(name, members)| {
        let mut members = members.clone();
        members.sort_unstable();
        members.dedup();
        let mut members: Vec<u32> = members.into_iter().flat_map(rows).collect();
        members.sort_unstable();
        members.dedup();
        (name.clone(), members)
    });
    groups.collect()
}

/// Leaves the arrays that were asked for by name, and of those with a usual name of fibres the first, cells before points.
fn keep_asked(draft: &mut Draft, reading: &Reading) {
    let is_fibres = |array: &Array| match &reading.fibres {
        Some(name) => array.name == *name,
        None => is_fibre_name(&array.name) && array.components == 3,
    };
    let of = |on: On| draft.arrays.iter().position(|array| array.on == on && is_fibres(array));
    let fibres = of(On::Cells).or_else(|| of(On::Points));
    let mut place = 0;
    let passed_over = &mut draft.passed_over;
    draft.arrays.retain(|array| {
        let is_kept = Some(place) == fibres || reading.arrays.contains(&array.name);
        place += 1;
        if !is_kept {
            passed_over.insert(array.name.clone());
        }
        is_kept
    });
}

/// The arrays with a row for each vertex and triangle that there is now.
fn arrays(draft: &mut Draft, sources: &[u32], mesh: &TriangleMesh) -> Vec<Array> {
    let rows_of = |on: On| if on == On::Points { sources } else { &draft.cells[..mesh.triangles.len()] };
    let kept = draft.arrays.iter().map(|array| {
        let rows = rows_of(array.on).iter();
        let values = rows.flat_map(|&row| {
            (0..array.components).map(move |c| {
                let at = row as usize * array.components + c;
                array.values.get(at).copied().unwrap_or(f64::NAN)
            })
        });
        Array { values: values.collect(), ..array.clone_head() }
    });
    kept.collect()
}

/// Takes the fibres from the array of the name that was asked for, or of a usual one.
fn fibres(file: &mut MeshFile, reading: &Reading) -> Result<(), Refusal> {
    let of_kind = |array: &&Array| match &reading.fibres {
        Some(name) => array.name == *name,
        None => is_fibre_name(&array.name) && array.components == 3,
    };
    let mut found: Vec<&Array> = file.arrays.iter().filter(of_kind).collect();
    found.sort_by_key(|array| array.on == On::Points);
    let Some(array) = found.first() else {
        let Some(name) = &reading.fibres else { return Ok(()) };
        return Err(Refusal::Fault(Fault::new(format!("the file has no array {name:?}; {}", file.array_names()))));
    };
    if array.components != 3 {
        let what = format!("the array {:?} has {} numbers a row; fibres take three", array.name, array.components);
        return Err(Refusal::Fault(Fault::new(what)));
    }
    file.fibres_from =
        Some(format!("{:?} of the file's {}", array.name, if array.on == On::Points { "points" } else { "cells" }));
    let at = |row: usize| DVec3::from_slice(&array.values[3 * row..3 * row + 3]);
    let fibres = match array.on {
        On::Cells => (0..file.mesh.triangles.len()).map(at).collect(),
        On::Points => {
            file.mesh.triangles.iter().map(|corners| mean_axis(corners.map(|corner| at(corner as usize)))).collect()
        }
    };
    file.mesh.fibres = Some(fibres);
    Ok(())
}

/// The mean of three directions whose sense means nothing: each is turned to the side of those before it.
fn mean_axis(directions: [DVec3; 3]) -> DVec3 {
    let sum = directions.iter().fold(DVec3::ZERO, |sum, d| {
        let unit = d.normalize_or_zero();
        if sum.dot(unit) < 0.0 { sum - unit } else { sum + unit }
    });
    // What is no number is refused with the mesh.
    if directions.iter().any(|d| d.is_nan()) { DVec3::NAN } else { sum }
}
