//! `--dump`: the final state as CSV with 17 significant digits, which read back as the same bits.

use super::Stop;
use super::series::Observation;
use glam::DVec3;
use rhexis::components::{Forces, TearDecision};
use rhexis::frame::Frame;
use rhexis::storage::{Tips, Vertices};
use rhexis_scene::Instance;
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

/// Its files.
pub(super) const NAMES: [&str; 5] = ["positions.csv", "reactions.csv", "stresses.csv", "vertices.csv", "tips.csv"];

/// Writes the [files](NAMES) into `folder`, which exists.
///
/// # Errors
/// What could not be written.
pub(super) fn dump(folder: &Path, instance: &mut Instance, frame: &Frame, last: &Observation) -> Result<(), String> {
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
    table(&folder.join("stresses.csv"), &header, stresses)?;
    vertices_and_tips(folder, instance)
}

/// Velocities and forces of the vertices, and what the criterion says at every tip.
fn vertices_and_tips(folder: &Path, instance: &mut Instance) -> Result<(), String> {
    let (mut vertices, mut tips) = (Vec::new(), Vec::new());
    for body in instance.bodies.clone() {
        let name = super::report::body_name(instance, body);
        let simulation = &mut instance.simulation;
        // The bodies of a scene exist.
        let elastic = simulation.elastic_forces(body).unwrap_or_default();
        let decisions = simulation.tip_decisions(body).unwrap_or_default();
        type Query<'a> = (&'a Vertices, &'a Forces, Option<&'a Tips>);
        let found = simulation.world_mut().query_one_mut::<Query>(body.entity());
        let Ok((table, forces, ends)) = found else { continue };
        for (v, velocity) in table.velocity.iter().enumerate() {
            // None where a tear or a state that was read has made other vertices since the last solve.
            let solved = forces.nodal.get(v).filter(|_| forces.nodal.len() == table.len());
            let mut row = vec![name.clone(), v.to_string(), digits(table.mass[v])];
            row.extend(
                numbers(Some(*velocity)).chain(numbers(elastic.get(v).copied())).chain(numbers(solved.copied())),
            );
            vertices.push(row);
        }
        let ends = ends.into_iter().flat_map(|ends| ends.vertex.iter().zip(&ends.previous));
        for (tip, ((vertex, previous), decision)) in ends.zip(decisions).enumerate() {
            let v = *vertex as usize;
            let mut row = vec![name.clone(), tip.to_string(), vertex.to_string()];
            row.extend(numbers(Some(table.position[v])).chain(numbers(Some(table.rest_position[v]))));
            row.extend(numbers((*previous != DVec3::ZERO).then_some(*previous)));
            row.extend(decided(decision));
            tips.push(row);
        }
    }
    let header = ["body", "vertex", "mass_g"].map(str::to_owned).into_iter();
    let vectors = ["velocity_{}_mm_per_ms", "elastic_{}_N", "solved_{}_N"].into_iter().flat_map(components);
    table(&folder.join("vertices.csv"), &header.chain(vectors).collect::<Vec<_>>(), vertices.into_iter())?;

    let header = ["body", "tip", "vertex"].map(str::to_owned).into_iter();
    let vectors = ["{}_mm", "rest_{}_mm", "previous_{}"].into_iter().flat_map(components);
    let stress = ["xx", "yy", "zz", "yz", "xz", "xy"].map(|entry| format!("{entry}_MPa"));
    let words = ["criterion", "margin", "is_ambiguous", "edges_per_radius", "decided_by"].map(str::to_owned);
    let header = header.chain(vectors).chain(stress).chain(components("direction_{}")).chain(words);
    table(&folder.join("tips.csv"), &header.collect::<Vec<_>>(), tips.into_iter())
}

/// Names of the components of a vector.
fn components(name: &str) -> [String; 3] {
    ["x", "y", "z"].map(|axis| name.replace("{}", axis))
}

/// The components of a vector; nothing where there is none.
fn numbers(vector: Option<DVec3>) -> impl Iterator<Item = String> {
    vector.map_or(Default::default(), |vector| vector.to_array().map(digits)).into_iter()
}

/// What the criterion has decided at a tip, in the rest shape, and by what.
fn decided(decision: Option<TearDecision>) -> Vec<String> {
    let Some(d) = decision else {
        let empty = std::iter::repeat_n(String::new(), 13);
        return empty.chain(["no admissible direction".to_owned()]).collect();
    };
    let [a, b] = d.axes;
    let (ta, tb) = (a * d.stress.xx + b * d.stress.xy, a * d.stress.xy + b * d.stress.yy);
    let entry = |i: usize, j: usize| ta[i] * a[j] + tb[i] * b[j];
    let stress = [entry(0, 0), entry(1, 1), entry(2, 2), entry(1, 2), entry(0, 2), entry(0, 1)].map(digits);
    let mut row: Vec<String> = stress.into_iter().chain(numbers(Some(d.direction))).collect();
    row.extend([digits(d.value), digits(d.margin), d.is_ambiguous.to_string()]);
    row.extend([digits(d.edges_per_radius), d.by.to_string()]);
    row
}

fn table(path: &Path, header: &[impl AsRef<[u8]>], rows: impl Iterator<Item = Vec<String>>) -> Result<(), String> {
    let refused = |error: csv::Error| format!("cannot write {}: {error}; choose another with --dump", path.display());
    let file = File::create(path).map_err(|error| refused(error.into()))?;
    let mut writer = csv::Writer::from_writer(std::io::BufWriter::new(file));
    writer.write_record(header).map_err(refused)?;
    for row in rows {
        writer.write_record(row).map_err(refused)?;
    }
    writer.flush().map_err(|error| refused(error.into()))
}
