//! Tears a mesh of your own: `cargo run --release --example own_mesh -- surface.obj` (or .msh, .vtu, .vtk, .ply, .stl; mm).
//! Without a file it takes a spherical cap. The rim's two halves are drawn apart along the mesh's longest side.

use glam::DVec3;
use rhexis::components::{Curve, Damping, Hold, Material, Tearing};
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::settings::Settings;
use rhexis::simulation::Simulation;
use rhexis::storage::{Attached, TriangleMesh};
use rhexis_scene::mesh_file;

/// Takes the file from the command line.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mesh = match std::env::args_os().nth(1) {
        Some(path) => mesh_file::read(path.as_ref())?,
        None => generate::cap(10.0, 9.8, 3000)?,
    };
    tear(mesh)
}

/// Draws the ends of a mesh apart until it has torn over a fifth of its width.
pub fn tear(mesh: TriangleMesh) -> Result<(), Box<dyn std::error::Error>> {
    let low = mesh.positions.iter().copied().reduce(DVec3::min).ok_or("no vertices")?;
    let high = mesh.positions.iter().copied().reduce(DVec3::max).ok_or("no vertices")?;
    let (middle, extent) = (0.5 * (low + high), high - low);
    // Pull along the longest axis, tear along the next.
    let mut axes = [DVec3::X, DVec3::Y, DVec3::Z];
    axes.sort_by(|a, b| extent.dot(*b).total_cmp(&extent.dot(*a)));
    let [pull, across, _] = axes;
    let (length, width) = (extent.dot(pull), extent.dot(across));
    println!("{} triangles, {length:.3} × {width:.3} mm", mesh.triangles.len());

    let tearing =
        Tearing { strength_along_fibres: 0.3, strength_across_fibres: 0.3, radius: width / 20.0, ..Tearing::default() };
    let mut body =
        Membrane::new("own mesh", mesh, Material::isotropic(3.0, 0.45, 0.05)).with(tearing).with(Damping { time: 0.1 });
    for (name, way) in [("low end", -pull), ("high end", pull)] {
        let end = body.select(|p| (p - middle).dot(way) > 0.45 * length);
        let members = Attached::new(end.into_iter().map(|vertex| (vertex, way)));
        let curve = Curve::ramp(1000.0, 0.2 * length)?;
        body = body.hold(Hold { name: name.into(), members, axes: [true; 3], curve });
    }

    let mut simulation = Simulation::new(Settings::default())?;
    let body = simulation.spawn(body)?;
    // A slit of a tenth of the width in the middle; the blade finds the nearest points of the surface.
    simulation.cut(body, &[middle - across * 0.05 * width, middle + across * 0.05 * width])?;
    let mut torn = 0.0;
    while torn < 0.2 * width && simulation.time() < 1000.0 {
        simulation.step(10.0)?;
        torn = simulation.world().get::<&rhexis::components::TearLog>(body.entity())?.length;
    }
    println!("torn over {torn:.3} mm at {} ms", simulation.time());
    assert!(torn >= 0.2 * width, "the slit grows to twice its length");
    Ok(())
}
