//! `--dump`: the final state as CSV with 17 significant digits, which read back as the same bits.

use super::Stop;
use super::series::Observation;
use crate::frame::Frame;
use std::fs::File;
use std::path::Path;

fn digits(value: f64) -> String {
    format!("{value:.16e}")
}

/// Makes the directory that was given with an option.
pub(super) fn create(folder: &Path, option: &str) -> Result<(), Stop> {
    std::fs::create_dir_all(folder).map_err(|error| {
        let what = format!("cannot make the directory {}: {error}", folder.display());
        Stop::Failed(format!("{what}; choose another with {option}"))
    })
}

/// Writes `positions.csv`, `reactions.csv` and `stresses.csv` into `folder`, which exists.
///
/// # Errors
/// What could not be written.
pub(super) fn dump(folder: &Path, frame: &Frame, last: &Observation) -> Result<(), String> {
    let header = ["body", "vertex", "x_mm", "y_mm", "z_mm", "rest_x_mm", "rest_y_mm", "rest_z_mm"];
    let vertices = frame.bodies.iter().flat_map(|body| {
        body.positions.iter().zip(&body.rest_positions).enumerate().map(|(v, (x, rest))| {
            let numbers = x.to_array().into_iter().chain(rest.to_array()).map(digits);
            [body.name.clone(), v.to_string()].into_iter().chain(numbers).collect()
        })
    });
    table(&folder.join("positions.csv"), &header, vertices)?;

    let header = ["hold", "x_N", "y_N", "z_N"];
    let forces = last
        .reactions
        .iter()
        .chain(&last.grips)
        .map(|(name, force)| std::iter::once(name.clone()).chain(force.to_array().map(digits)).collect());
    table(&folder.join("reactions.csv"), &header, forces)?;

    let header = [
        "body",
        "triangle",
        "a",
        "b",
        "c",
        "xx_MPa",
        "yy_MPa",
        "zz_MPa",
        "yz_MPa",
        "xz_MPa",
        "xy_MPa",
        "principal_1_MPa",
        "principal_2_MPa",
    ];
    let stresses = frame.bodies.iter().flat_map(|body| {
        let rows = body.triangles.iter().zip(&body.stress).zip(&body.principal_stress).enumerate();
        rows.map(|(t, ((corners, s), p))| {
            let corners = corners.iter().map(u32::to_string);
            let (x, y, z) = (s.x_axis, s.y_axis, s.z_axis);
            let numbers = [x.x, y.y, z.z, z.y, z.x, y.x, p.x, p.y].map(digits);
            [body.name.clone(), t.to_string()].into_iter().chain(corners).chain(numbers).collect()
        })
    });
    table(&folder.join("stresses.csv"), &header, stresses)
}

fn table(path: &Path, header: &[&str], rows: impl Iterator<Item = Vec<String>>) -> Result<(), String> {
    let refused = |error: csv::Error| format!("cannot write {}: {error}; choose another with --dump", path.display());
    let file = File::create(path).map_err(|error| refused(error.into()))?;
    let mut writer = csv::Writer::from_writer(std::io::BufWriter::new(file));
    writer.write_record(header).map_err(refused)?;
    for row in rows {
        writer.write_record(row).map_err(refused)?;
    }
    writer.flush().map_err(|error| refused(error.into()))
}
