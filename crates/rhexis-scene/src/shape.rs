//! From `mesh = …` to a triangle mesh.

use super::error::{Fault, positive};
use super::files::Files;
use super::generate;
use super::mesh_file::MeshFile;
use super::mesh_on_file::{self, Arrays};
use super::schema::{MeshSpec, PlaceSpec, Point};
use glam::{DVec2, DVec3, Vec3Swizzles};
use rhexis::math::elementary;
use rhexis::storage::TriangleMesh;

/// Makes the mesh; a file is read elsewhere.
fn generated(spec: &MeshSpec, key: &str) -> Result<TriangleMesh, Fault> {
    let generated = match spec {
        MeshSpec::Grid(g) => generate::grid(g.width, g.height, g.nx, g.ny),
        MeshSpec::Jittered(g) => generate::jittered(g.width, g.height, g.nx, g.ny, g.seed),
        MeshSpec::Lattice(l) => generate::lattice(&flat(&l.corners), l.edge, l.degrees),
        MeshSpec::Unstructured(u) => generate::unstructured(&flat(&u.corners), u.edge, u.seed),
        MeshSpec::Disc(d) => generate::disc(d.radius, d.triangles),
        MeshSpec::Cap(c) => generate::cap(c.curvature_radius, c.diameter, c.triangles),
        MeshSpec::PlateWithHole(p) => generate::plate_with_hole(p.points),
        MeshSpec::Quad(q) => {
            let [a, b, c, d] = q.corners.0.map(|corner| corner.0);
            generate::mapped_grid(q.nx, q.ny, |s, t| bilinear([a, b, c, d], s, t))
        }
        MeshSpec::Inline(i) => {
            let positions = i.positions.iter().map(|p| p.0).collect();
            let mesh = TriangleMesh {
                positions,
                triangles: i.triangles.iter().map(|corners| corners.0).collect(),
                fibres: None,
            };
            return checked(mesh, &format!("{key}.inline"));
        }
        MeshSpec::File(_) => return Ok(TriangleMesh::default()),
    };
    let mesh = generated.map_err(|error| split(key, error))?;
    checked(mesh, key)
}

/// Makes or reads the mesh, with what its file says of it; `files` are where it is read from. `arrays` are asked of a file.
pub(super) fn mesh(spec: &MeshSpec, arrays: &Arrays, files: &Files, key: &str) -> Result<MeshFile, Fault> {
    match spec {
        MeshSpec::File(file) => {
            let key = format!("{key}.file");
            let file = mesh_on_file::read(file, arrays, files, &key)?;
            file.mesh.check().map_err(|error| split(&key, error))?;
            Ok(file)
        }
        spec => Ok(MeshFile { mesh: generated(spec, key)?, ..MeshFile::default() }),
    }
}

/// The error of a mesh or fibre file, under the key `path` of its table where it has one.
pub(super) fn refused_file(key: &str, error: impl std::fmt::Display) -> Fault {
    let mut fault = split(&format!("{key}.path"), error);
    if fault.hint.ends_with("check the path and the permissions") {
        fault.hint += "; a relative path begins at the scene file's folder";
    }
    fault
}

fn checked(mesh: TriangleMesh, key: &str) -> Result<TriangleMesh, Fault> {
    mesh.check().map_err(|error| split(key, error))?;
    Ok(mesh)
}

/// Messages of the mesh layer end in `; how to mend it`.
fn split(key: &str, error: impl std::fmt::Display) -> Fault {
    let message = error.to_string();
    match message.rsplit_once("; ") {
        Some((what, hint)) => Fault::new(key, what, hint),
        None => Fault::new(key, message, ""),
    }
}

fn flat(points: &[Point]) -> Vec<DVec2> {
    points.iter().map(|p| p.0.xy()).collect()
}

fn bilinear([a, b, c, d]: [DVec3; 4], s: f64, t: f64) -> DVec3 {
    a * ((1.0 - s) * (1.0 - t)) + b * (s * (1.0 - t)) + c * (s * t) + d * ((1.0 - s) * t)
}

/// The part of its extent within which a body is flattened.
const ALMOST_FLAT: f64 = 1e-6;

/// Scales, turns and moves a mesh, with its fibres and those of another list.
///
/// # Errors
/// For a scale that is not above zero.
pub(super) fn place(
    spec: &PlaceSpec,
    mesh: &mut TriangleMesh,
    fibres: Option<&mut [DVec3]>,
    key: &str,
) -> Result<(), Fault> {
    let scale = positive(format!("{key}.scale"), spec.scale.unwrap_or(1.0), "")?;
    let [turn, about, displacement] =
        [spec.turn, spec.about, spec.displacement].map(|point| point.unwrap_or_default().0);
    let angle = turn.length().to_radians();
    let turn = elementary::rotation(turn.try_normalize().unwrap_or(DVec3::Z), angle);
    for x in &mut mesh.positions {
        *x = about + turn * (*x - about) * scale + displacement;
    }
    for fibre in mesh.fibres.iter_mut().flatten().chain(fibres.into_iter().flatten()) {
        *fibre = turn * *fibre;
    }
    Ok(())
}

/// Makes a mesh that is flat across z but for rounding wholly so; the way by which vertices were moved \[mm\].
///
/// # Errors
/// For one that is not flat.
pub(super) fn flatten(mesh: &mut TriangleMesh, key: &str) -> Result<f64, Fault> {
    let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = mesh.positions.iter().fold(start, |(low, high), p| (low.min(*p), high.max(*p)));
    let size = high - low;
    let largest = mesh.positions.iter().map(|p| p.xy().abs().max_element()).fold(0.0, f64::max);
    if size.z <= 1e-9 * largest {
        return Ok(0.0);
    }
    let extent = size.xy().max_element();
    if size.z > ALMOST_FLAT * extent {
        let part = size.z / extent;
        let what = format!(
            "the mesh is not flat across z: its vertices spread over {:e} mm, {part:.1e} of its extent",
            size.z
        );
        let hint = match size.min_element() <= ALMOST_FLAT * size.max_element() {
            true if size.x < size.y => {
                "it is flat across x: give `rotate = [0, 90, 0]` where it is read, or remove `planar = true`"
            }
            true => "it is flat across y: give `rotate = [90, 0, 0]` where it is read, or remove `planar = true`",
            false => "remove `planar = true`, or give a mesh with one z (within 1e-6 of its extent)",
        };
        return Err(Fault::new(format!("{key}.planar"), what, hint));
    }
    let z = mesh.positions.first().map_or(0.0, |p| p.z);
    let moved = mesh.positions.iter().map(|p| (p.z - z).abs()).fold(0.0, f64::max);
    mesh.positions.iter_mut().for_each(|p| p.z = z);
    Ok(moved)
}
