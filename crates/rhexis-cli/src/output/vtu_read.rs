//! One body at one moment, read back from a ParaView file (.vtu) of [`write_vtu`](super::write_vtu).
//!
//! The format (XML, base64, appended and compressed data, limits on size) is read by [`rhexis_scene::mesh_file`]; here the arrays become a body.

use glam::{DMat3, DVec3};
use rhexis::frame::{BodyFrame, SolidFrame, SolidKind};
use rhexis_scene::mesh_file::{Grid, MeshFileError, On, read_grid};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why a ParaView file cannot be read as a body.
#[derive(Debug, Error)]
pub enum VtuError {
    /// The file cannot be read, or does not follow its format.
    #[error(transparent)]
    File(#[from] MeshFileError),
    /// An array that every body has is not in the file.
    #[error("{}: array {array:?} is missing; write the file again", path.display())]
    Missing {
        /// The file.
        path: PathBuf,
        /// Name of the array.
        array: &'static str,
    },
    /// An array has another number of components.
    #[error("{}: array {array:?} has {found} components where {wanted} belong; write the file again", path.display())]
    Components {
        /// The file.
        path: PathBuf,
        /// Name of the array.
        array: &'static str,
        /// Components of the array.
        found: usize,
        /// Components of a body's array of this name.
        wanted: usize,
    },
    /// An array has another number of rows than the grid has points or triangles.
    #[error("{}: array {array:?} has {found} rows where {wanted} belong; write the file again", path.display())]
    Rows {
        /// The file.
        path: PathBuf,
        /// Name of the array.
        array: &'static str,
        /// Rows of the array.
        found: usize,
        /// Points or triangles of the grid.
        wanted: usize,
    },
}

const NAMES: [&str; 7] = ["displacement", "velocity", "force", "stress", "principal_stress", "fibre", "criterion"];

/// Reads a body; velocities, forces and criterion are empty where the file has none. Name, attributes and tips are not in a file.
///
/// # Errors
/// The file cannot be read, does not follow its format, or lacks an array that every body has.
pub fn read_vtu(path: &Path) -> Result<BodyFrame, VtuError> {
    let grid = read_grid(path, &NAMES)?;
    let file = File { path, grid: &grid };
    let displacement = file.required(file.rows::<3>(On::Points, "displacement")?, "displacement")?;
    let velocities = file.rows::<3>(On::Points, "velocity")?.unwrap_or_default();
    let forces = file.rows::<3>(On::Points, "force")?.unwrap_or_default();
    let fibres = file.required(file.rows::<3>(On::Cells, "fibre")?, "fibre")?;
    let stress = file.required(file.rows::<9>(On::Cells, "stress")?, "stress")?;
    let principal_stress = file.required(file.rows::<2>(On::Cells, "principal_stress")?, "principal_stress")?;
    let criterion = file.rows::<1>(On::Cells, "criterion")?.unwrap_or_default().concat();
    Ok(BodyFrame {
        rest_positions: grid.positions.iter().zip(&displacement).map(|(x, u)| *x - DVec3::from(*u)).collect(),
        velocities: vectors(velocities),
        forces: vectors(forces),
        stress: stress.iter().map(|rows| DMat3::from_cols_array(rows).transpose()).collect(),
        principal_stress: principal_stress.into_iter().map(Into::into).collect(),
        fibres: vectors(fibres),
        criterion,
        positions: grid.positions,
        triangles: grid.triangles,
        ..BodyFrame::default()
    })
}

/// Reads obstacles and jaws.
///
/// # Errors
/// As [`read_vtu`].
pub fn read_solids(path: &Path) -> Result<Vec<SolidFrame>, VtuError> {
    let grid = read_grid(path, &["solid", "kind", "at", "force"])?;
    let file = File { path, grid: &grid };
    let place = file.required(file.rows::<1>(On::Cells, "solid")?, "solid")?.concat();
    let kind = file.required(file.rows::<1>(On::Cells, "kind")?, "kind")?.concat();
    let at = file.required(file.rows::<3>(On::Cells, "at")?, "at")?;
    let force = file.required(file.rows::<3>(On::Cells, "force")?, "force")?;
    let mut solids: Vec<SolidFrame> = Vec::new();
    for (t, corners) in grid.triangles.iter().enumerate() {
        if t == 0 || place[t] != place[t - 1] {
            solids.push(SolidFrame {
                kind: if kind[t] == 0.0 { SolidKind::Obstacle } else { SolidKind::Jaws },
                positions: Vec::new(),
                triangles: Vec::new(),
                at: DVec3::from(at[t]),
                force: DVec3::from(force[t]),
            });
        }
        solids.iter_mut().last().into_iter().for_each(|solid| solid.triangles.push(*corners));
    }
    for solid in &mut solids {
        // The rows of a solid stand together.
        let rows = || solid.triangles.iter().flatten().map(|&row| row as usize);
        let (first, last) = (rows().min().unwrap_or(0), rows().max().unwrap_or(0));
        solid.positions = grid.positions[first..=last].to_vec();
        solid.triangles.iter_mut().flatten().for_each(|row| *row -= first as u32);
    }
    Ok(solids)
}

fn vectors(rows: Vec<[f64; 3]>) -> Vec<DVec3> {
    rows.into_iter().map(DVec3::from).collect()
}

struct File<'a> {
    path: &'a Path,
    grid: &'a Grid,
}

impl File<'_> {
    /// The rows of an array of `N` components; `None` where the file has no such array.
    fn rows<const N: usize>(&self, on: On, array: &'static str) -> Result<Option<Vec<[f64; N]>>, VtuError> {
        let wanted = if on == On::Points { self.grid.positions.len() } else { self.grid.triangles.len() };
        let Some(values) = self.grid.arrays.iter().find(|values| values.on == on && values.name == array) else {
            // An array without rows does not tell its components, so the reader leaves it out.
            return Ok((wanted == 0).then(Vec::new));
        };
        let path = || self.path.to_owned();
        if values.components != N {
            return Err(VtuError::Components { path: path(), array, found: values.components, wanted: N });
        }
        let rows = values.values.as_chunks::<N>().0;
        if rows.len() != wanted {
            return Err(VtuError::Rows { path: path(), array, found: rows.len(), wanted });
        }
        Ok(Some(rows.to_vec()))
    }

    fn required<T>(&self, found: Option<T>, array: &'static str) -> Result<T, VtuError> {
        found.ok_or_else(|| VtuError::Missing { path: self.path.to_owned(), array })
    }
}
