//! From `mesh = …` to a triangle mesh.

use super::error::{Fault, positive};
use super::schema::{MeshSpec, Point};
use super::{generate, mesh_file};
use crate::storage::TriangleMesh;
use glam::{DVec2, DVec3, Vec3Swizzles};
use std::path::Path;

/// Makes or reads the mesh; `folder` is where a relative path begins.
pub(super) fn mesh(spec: &MeshSpec, folder: &Path, key: &str) -> Result<TriangleMesh, Fault> {
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
        MeshSpec::File(f) => {
            let key = format!("{key}.file");
            let scale = positive(format!("{key}.scale"), f.scale, "")?;
            let mut mesh = mesh_file::read(&folder.join(&f.path)).map_err(|error| refused_file(&key, error))?;
            mesh.positions.iter_mut().for_each(|p| *p *= scale);
            return checked(mesh, &key);
        }
    };
    let mesh = generated.map_err(|error| split(key, error))?;
    checked(mesh, key)
}

/// The error of a mesh or fibre file, under the key `path` of its table where it has one.
pub(super) fn refused_file(key: &str, error: impl std::fmt::Display) -> Fault {
    let mut fault = split(&format!("{key}.path"), error);
    if fault.hint.is_empty() {
        fault.hint = "a relative path begins at the scene file's folder".to_owned();
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

/// Whether all vertices share one z, as a planar body needs.
pub(super) fn is_flat(mesh: &TriangleMesh) -> bool {
    let extent = mesh.positions.iter().map(|p| p.xy().abs().max_element()).fold(0.0, f64::max);
    let z = mesh.positions.first().map_or(0.0, |p| p.z);
    mesh.positions.iter().all(|p| (p.z - z).abs() <= 1e-9 * extent)
}
