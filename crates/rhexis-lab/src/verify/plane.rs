//! Linear plane stress with linear triangles: Cook's membrane and the square of Figure 2 under a small pull. The listed
//! numbers are the exact solutions of the same meshes, so they must be met to rounding.

use super::bodies;
use super::reference::{Json, csv, file};
use super::{Artifacts, Row, Rows, VerifyError, largest};
use glam::DVec3;
use rhexis::components::{Curve, EdgeLoad, EdgeLoads, Fibres, Material};
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::settings::Settings;
use rhexis::storage::TriangleMesh;

/// The finest mesh of the square is left out: it costs more than all others together.
const MOST_CELLS: f64 = 128.0 * 128.0;

fn one_thread() -> Settings {
    Settings { threads: 1, ..Settings::default() }
}

pub(super) fn cook(_: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("cook");
    let (name, text) = file!("cook.json");
    let file = Json::new(name, text)?;
    let isotropic =
        Material::isotropic(file.number("/cases/iso/material/E")?, file.number("/cases/iso/material/nu")?, 1.0);
    let constant = |key: &str| file.number(&format!("/cases/aniso/material/{key}"));
    let aniso = bodies::material([constant("EF")?, constant("ET")?, constant("nuF")?, constant("G")?], 1.0, 1e-3);
    for (case, material) in [("iso", isotropic), ("aniso", aniso)] {
        for i in 0..file.len(&format!("/cases/{case}/P1"))? {
            let wanted = |key: &str| file.number(&format!("/cases/{case}/P1/{i}/{key}"));
            let n = wanted("n")?;
            if n * n > MOST_CELLS {
                continue;
            }
            let found = cook_on_mesh(n as u32, material)?;
            // The mesh's own solution: what is left is the solver's residual of 1e-13 times the condition of the stiffness.
            let mut worst = [
                found.at_centre.y / wanted("uy_C")? - 1.0,
                found.at_centre.x / wanted("ux_C")? - 1.0,
                found.at_top.y / wanted("uy_top")? - 1.0,
                found.energy / wanted("energy")? - 1.0,
            ];
            worst.iter_mut().for_each(|e| *e = e.abs());
            rows.ratio(format!("{case}, {n} × {n} cells: displacements and energy"), largest(worst), 1e-8);
            rows.note(format!("{case}, {n} × {n} cells: residual of the solve"), found.residual, "1");
        }
    }
    rows.finish()
}

struct Cook {
    at_centre: DVec3,
    at_top: DVec3,
    energy: f64,
    residual: f64,
}

fn cook_on_mesh(n: u32, material: Material) -> Result<Cook, VerifyError> {
    let mesh = generate::mapped_grid(n as usize, n as usize, |s, t| {
        let (low, high) = (44.0 * s, 44.0 + 16.0 * s);
        DVec3::new(48.0 * s, low + (high - low) * t, 0.0)
    })?;
    let vertex = |i: u32, j: u32| j * (n + 1) + i;
    let edges = (0..n).map(|j| [vertex(n, j), vertex(n, j + 1)]).collect();
    // 1 N over the edge of 16 mm.
    let load = EdgeLoad { edges, traction: DVec3::Y / 16.0, curve: Curve::constant(1.0) };
    let membrane = Membrane::new("cook", mesh, material).fibres(Fibres::at_degrees(45.0)).planar();
    let clamp = bodies::hold(&membrane, "left", |p| (p.x == 0.0).then_some(DVec3::ZERO));
    let membrane = membrane.hold(clamp).with(EdgeLoads { groups: vec![load] });
    let (mut simulation, body) = bodies::simulate(one_thread(), membrane)?;
    let found = bodies::linear(&mut simulation, body)?;
    let [at_centre, at_top] = [n / 2, n].map(|j| found.displacement[vertex(n, j) as usize]);
    Ok(Cook { at_centre, at_top, energy: found.energy, residual: found.residual })
}

pub(super) fn fig2_small(_: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("fig2-small");
    let (name, text) = file!("fig2_small.json");
    let file = Json::new(name, text)?;
    let probes = [file!("fig2_small_iso.csv"), file!("fig2_small_aniso.csv")];
    for ((case, material), (name, text)) in
        [("iso", Material::isotropic(3.0, 0.3, 0.1)), ("aniso", Material::allard_2009())].into_iter().zip(probes)
    {
        let probes: Vec<[f64; 4]> = csv(name, text)?;
        for i in 0..file.len(&format!("/results/{case}/P1_on_M"))? {
            let wanted = |key: &str| file.number(&format!("/results/{case}/P1_on_M/{i}/{key}"));
            let (nx, ny) = (wanted("nx")? as usize, wanted("ny")? as usize);
            if (nx * ny) as f64 > MOST_CELLS {
                continue;
            }
            let pull = file.number("/u")?;
            let mesh = generate::grid(30.0, 30.0, nx, ny)?;
            let membrane = Membrane::new("square", mesh.clone(), material).fibres(Fibres::at_degrees(45.0)).planar();
            let side = |at: f64, name: &str, by: f64| {
                bodies::hold(&membrane, name, move |p| (p.x == at).then_some(DVec3::X * by))
            };
            let (left, right) = (side(0.0, "left", -pull), side(30.0, "right", pull));
            let (mut simulation, body) = bodies::simulate(one_thread(), membrane.hold(left).hold(right))?;
            let found = bodies::linear(&mut simulation, body)?;
            let grip = bodies::reaction(&simulation, body, "right")?;
            let (fx, fy) = (wanted("Fx")?, wanted("Fy")?);
            let off = [(grip.x - fx) / fx, (grip.y - fy) / fx, found.energy / wanted("energy")? - 1.0];
            // As for Cook's membrane.
            rows.ratio(format!("{case}, M({nx},{ny}): grip force and energy"), largest(off.map(f64::abs)), 1e-8);
            let errors = probes.iter().map(|p| {
                let off = interpolate(&mesh, &found.displacement, p[0], p[1]) - DVec3::new(p[2], p[3], 0.0);
                off.abs().max_element() / pull
            });
            let errors = largest(errors) - wanted("max_disp_err_over_u")?;
            // The probes are listed with 12 digits.
            rows.ratio(format!("{case}, M({nx},{ny}): discretisation error at 49 points"), errors.abs(), 1e-8);
        }
    }
    rows.finish()
}

/// The linear interpolation of vertex values at a point of a plane mesh; zero outside.
fn interpolate(mesh: &TriangleMesh, values: &[DVec3], x: f64, y: f64) -> DVec3 {
    let p = DVec3::new(x, y, 0.0);
    for corners in &mesh.triangles {
        let [a, b, c] = corners.map(|v| mesh.positions[v as usize]);
        let area = (b - a).cross(c - a).z;
        let (wb, wc) = ((p - a).cross(c - a).z / area, (b - a).cross(p - a).z / area);
        let wa = 1.0 - wb - wc;
        // Points on an edge belong to both sides.
        if wa.min(wb).min(wc) >= -1e-12 {
            let [ua, ub, uc] = corners.map(|v| values[v as usize]);
            return ua * wa + ub * wb + uc * wc;
        }
    }
    DVec3::ZERO
}
