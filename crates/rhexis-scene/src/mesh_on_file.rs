//! From `mesh = { file = … }` to a mesh where the scene wants it: read, scaled, turned and moved.

use super::error::{Fault, not_negative, positive};
use super::files::Files;
use super::mesh_file::{self, MeshFile, Reading};
use super::schema::{FileSpec, ReadingSpec};
use super::shape::refused_file;
use glam::{DMat3, DVec3};
use rhexis::components::{Attributes, Channel};
use rhexis::math::elementary;

/// The arrays of its file that a body asks for.
#[derive(Default)]
pub(super) struct Arrays {
    /// Fibres, where the scene names them.
    pub fibres: Option<String>,
    /// Others.
    pub others: Vec<String>,
}

/// Reads and places the mesh.
pub(super) fn read(spec: &FileSpec, arrays: &Arrays, files: &Files, key: &str) -> Result<MeshFile, Fault> {
    let ReadingSpec { scale, unit, rotate, translate, weld, repair, flip, fibres } = &spec.reading;
    let scale = match (scale, unit) {
        (Some(scale), None) => positive(format!("{key}.scale"), *scale, "")?,
        (None, unit) => unit.map_or_else(|| mesh_file::millimetres(&spec.path), |unit| unit.millimetres()),
        (Some(_), Some(_)) => {
            return Err(Fault::new(format!("{key}.scale"), "the unit is given twice", "give either `unit` or `scale`"));
        }
    };
    let weld = weld.map(|weld| not_negative(format!("{key}.weld"), weld, "mm")).transpose()?;
    let reading = Reading {
        scale: Some(scale),
        weld: weld.map(|weld| weld / scale),
        repair: *repair,
        flip: *flip,
        fibres: arrays.fibres.clone().or_else(|| fibres.clone()),
        arrays: arrays.others.clone(),
    };
    let read = mesh_file::mesh_of(files, &spec.path, &reading);
    let mut file = read.map_err(|error| refused_file(key, error))?;
    if let Some(angles) = rotate {
        let turn = turn(angles.0);
        file.mesh.positions.iter_mut().for_each(|p| *p = turn * *p);
        file.mesh.fibres.iter_mut().flatten().for_each(|fibre| *fibre = turn * *fibre);
        file.attributes.iter_mut().for_each(|attributes| turn_normals(attributes, turn));
    }
    if let Some(way) = translate {
        file.mesh.positions.iter_mut().for_each(|p| *p += way.0);
    }
    Ok(file)
}

fn turn_normals(attributes: &mut Attributes, turn: DMat3) {
    let Some(&(_, first)) = attributes.channels.iter().find(|(channel, _)| *channel == Channel::Normal) else { return };
    for row in attributes.values.chunks_exact_mut(attributes.stride) {
        let own = &mut row[first..first + 3];
        own.copy_from_slice(&(turn * DVec3::from_slice(own)).to_array());
    }
}

/// About x, then y, then z. Right angles are exact, so that what was flat stays so.
fn turn(degrees: DVec3) -> DMat3 {
    let [x, y, z] = degrees.to_array().map(|degrees| {
        let quarters = degrees / 90.0;
        match (quarters.fract() == 0.0).then(|| quarters.rem_euclid(4.0) as u32) {
            Some(0) => (0.0, 1.0),
            Some(1) => (1.0, 0.0),
            Some(2) => (0.0, -1.0),
            Some(_) => (-1.0, 0.0),
            None => elementary::sin_cos(degrees.to_radians()),
        }
    });
    let about_x = DMat3::from_cols(DVec3::X, DVec3::new(0.0, x.1, x.0), DVec3::new(0.0, -x.0, x.1));
    let about_y = DMat3::from_cols(DVec3::new(y.1, 0.0, -y.0), DVec3::Y, DVec3::new(y.0, 0.0, y.1));
    let about_z = DMat3::from_cols(DVec3::new(z.1, z.0, 0.0), DVec3::new(-z.0, z.1, 0.0), DVec3::Z);
    about_z * about_y * about_x
}
