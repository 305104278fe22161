//! The frames that a run has written, read back: the list (`frames.pvd`) and the bodies (`.vtu`).

use super::Moment;
use crate::Stop;
use glam::{DVec2, DVec3};
use rhexis::frame::BodyFrame;
use std::path::{Path, PathBuf};
use vtkio::Vtk;
use vtkio::model::{Attribute, DataSet, IOBuffer, UnstructuredGridPiece, VertexNumbers};

/// A moment of the list: its time \[ms\] and a file per body.
pub(super) struct Entry {
    pub time: f64,
    files: Vec<PathBuf>,
}

/// The moments of a run's directory, in their order.
///
/// # Errors
/// Where it has none.
pub(super) fn entries(run: &Path) -> Result<Vec<Entry>, Stop> {
    let path = run.join("frames.pvd");
    let failed = |what: &dyn std::fmt::Display| {
        let help = "give a directory of `rhexis run --set output.frames=60`, or the scene itself";
        Stop::Failed(format!("{}: {what}; {help}", path.display()))
    };
    let text = std::fs::read_to_string(&path).map_err(|error| failed(&error))?;
    let mut entries: Vec<Entry> = Vec::new();
    for line in text.lines().filter(|line| line.trim_start().starts_with("<DataSet ")) {
        let word = |name: &str| line.split_once(&format!(" {name}=\""))?.1.split('"').next();
        let time = word("timestep").and_then(|time| time.parse().ok()).filter(|time: &f64| time.is_finite());
        let (Some(time), Some(file)) = (time, word("file")) else {
            return Err(failed(&"a frame without time or file"));
        };
        let file = run.join(file.replace("&amp;", "&"));
        match entries.last_mut() {
            Some(last) if last.time == time => last.files.push(file),
            _ => entries.push(Entry { time, files: vec![file] }),
        }
    }
    if entries.is_empty() { Err(failed(&"it lists no frames")) } else { Ok(entries) }
}

/// Reads a moment.
///
/// # Errors
/// For a file that cannot be read or is not one of a run.
pub(super) fn read(entry: &Entry) -> Result<Moment, Stop> {
    let bodies = entry.files.iter().map(|file| body(file)).collect::<Result<Vec<_>, _>>()?;
    Ok(Moment { time: entry.time, body: super::together(bodies) })
}

fn body(file: &Path) -> Result<BodyFrame, Stop> {
    let failed = |what: &dyn std::fmt::Display| {
        Stop::Failed(format!("{}: {what}; run the scene anew, or render it in place of the directory", file.display()))
    };
    let text = std::fs::read(file).map_err(|error| failed(&error))?;
    let vtk = Vtk::parse_xml(&text[..]).map_err(|error| failed(&error))?;
    let DataSet::UnstructuredGrid { pieces, .. } = vtk.data else { return Err(failed(&"it is no unstructured grid")) };
    let mut whole = Vec::new();
    for piece in pieces {
        let piece = piece.into_loaded_piece_data(None).map_err(|error| failed(&error))?;
        whole.push(grid(piece).ok_or_else(|| failed(&"arrays are missing or do not go together"))?);
    }
    Ok(super::together(whole))
}

/// A body from its arrays; `None` where they do not go together.
fn grid(piece: UnstructuredGridPiece) -> Option<BodyFrame> {
    let positions = vectors(&piece.points)?;
    let VertexNumbers::XML { connectivity, .. } = piece.cells.cell_verts else { return None };
    let corners: Vec<u32> = connectivity.iter().map(|&v| u32::try_from(v).ok()).collect::<Option<_>>()?;
    let (triangles, rest) = corners.as_chunks::<3>();
    if !rest.is_empty() || corners.iter().any(|&v| v as usize >= positions.len()) {
        return None;
    }
    let displacement = vectors(array(&piece.data.point, "displacement")?)?;
    let principal = numbers(array(&piece.data.cell, "principal_stress")?)?;
    let fibres = vectors(array(&piece.data.cell, "fibre")?)?;
    let principal_stress: Vec<DVec2> = principal.as_chunks::<2>().0.iter().map(|&p| p.into()).collect();
    let count = triangles.len();
    let fits = displacement.len() == positions.len()
        && [principal_stress.len(), fibres.len()].iter().all(|&length| length == count);
    fits.then(|| BodyFrame {
        rest_positions: positions.iter().zip(&displacement).map(|(x, u)| *x - *u).collect(),
        positions,
        triangles: triangles.to_vec(),
        principal_stress,
        fibres,
        ..BodyFrame::default()
    })
}

fn array<'a>(attributes: &'a [Attribute], name: &str) -> Option<&'a IOBuffer> {
    attributes.iter().find_map(|attribute| match attribute {
        Attribute::DataArray(array) if array.name == name => Some(&array.data),
        _ => None,
    })
}

fn numbers(buffer: &IOBuffer) -> Option<Vec<f64>> {
    match buffer {
        IOBuffer::F64(numbers) => Some(numbers.clone()),
        _ => None,
    }
}

fn vectors(buffer: &IOBuffer) -> Option<Vec<DVec3>> {
    let numbers = numbers(buffer)?;
    let (vectors, rest) = numbers.as_chunks::<3>();
    rest.is_empty().then(|| vectors.iter().map(|&v| v.into()).collect())
}
