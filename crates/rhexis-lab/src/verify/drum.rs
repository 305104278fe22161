//! Out of the plane: taut strings, drums and inflated strips.
//!
//! A tension N in a flat sheet is given in one of two ways. As a pre-stretch ε₀ = C⁻¹·N/h of the flat sheet, which is then
//! free of strain: the stress is exactly N/h, as the classical membrane equation has it. Or by stretching a smaller sheet and
//! holding its edges; then the vibration is governed by the second Piola–Kirchhoff stress in the rest shape, which is where
//! the `prestretched_…` entries differ from the others.

use super::bodies::{self, Snapshot};
use super::modes::lowest_frequencies;
use super::reference::{Json, file};
use super::{Artifacts, Row, Rows, VerifyError};
use glam::DVec3;
use rhexis::components::{Curve, Fibres, FreeAxes, Material, PreStretch, Pressure};
use rhexis::generate;
use rhexis::math::Sym2;
use rhexis::membrane::Membrane;
use rhexis::settings::{Advanced, Settings};
use rhexis::storage::TriangleMesh;

pub(super) fn run(_: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("membrane");
    let (name, text) = file!("membrane.json");
    let file = Json::new(name, text)?;
    taut_frequencies(&mut rows, &file)?;
    stretched_frequencies(&mut rows, &file)?;
    small_pressure(&mut rows, &file)?;
    large_pressure(&mut rows, &file)?;
    hencky(&mut rows, &file)?;
    rows.finish()
}

fn one_thread() -> Settings {
    Settings { threads: 1, ..Settings::default() }
}

/// A sheet of Figure 2's material with fibres along x under the tensions \[N/mm\] along x and y.
fn taut(mesh: TriangleMesh, tension: [f64; 2]) -> Result<Membrane, VerifyError> {
    let material = Material::allard_2009();
    let law = material.stiffness().map_err(|source| rhexis::membrane::BodyError::Material { triangle: 0, source })?;
    let [tx, ty] = tension.map(|t| t / material.thickness);
    let determinant = law.q11 * law.q22 - law.q12 * law.q12;
    let strain =
        Sym2::new((law.q22 * tx - law.q12 * ty) / determinant, (law.q11 * ty - law.q12 * tx) / determinant, 0.0);
    Ok(Membrane::new("sheet", mesh, material).fibres(Fibres::at_degrees(0.0)).with(PreStretch { strain }))
}

/// A strip of `n` cells along x, one cell wide, all diagonals alike. Every inner vertex has three triangles, so a deflection
/// that does not vary across the strip sees exactly the chain of elements that the file lists.
fn strip(length: f64, n: usize) -> TriangleMesh {
    let step = length / n as f64;
    let width = 2.0;
    let row = |y: f64| (0..=n).map(move |i| DVec3::new(if i == n { length } else { step * i as f64 }, y, 0.0));
    let positions = row(0.0).chain(row(width)).collect();
    let triangles = (0..n as u32).flat_map(|a| {
        let d = a + n as u32 + 1;
        [[a, a + 1, d + 1], [a, d + 1, d]]
    });
    TriangleMesh { positions, triangles: triangles.collect(), fibres: None }
}

/// Frees z where the condition holds.
fn out_of_plane(body: &Snapshot, is_free: impl Fn(DVec3) -> bool) -> FreeAxes {
    body.vertices.rest_position.iter().map(|&p| if is_free(p) { DVec3::Z } else { DVec3::ZERO }).collect()
}

fn taut_frequencies(rows: &mut Rows, file: &Json) -> Result<(), VerifyError> {
    let (length, tension) = (file.number("/strip_frequency/a")?, file.number("/strip_frequency/T")?);
    let (mut simulation, body) = bodies::simulate(one_thread(), taut(strip(length, 20), [tension, 0.0])?)?;
    let snapshot = Snapshot::new(&mut simulation, body)?;
    let free = out_of_plane(&snapshot, |p| p.x > 0.0 && p.x < length);
    let found = lowest_frequencies(&snapshot, &free, 1)?;
    // The same chain of 20 elements with lumped mass.
    rows.relative(
        "taut strip of 20 cells: frequency",
        found[0],
        file.number("/strip_frequency/discrete_P1_n20_chain_lumped")?,
        1e-8,
    );

    let number = |key: &str| file.number(&format!("/rectangle_frequency/{key}"));
    let (a, b, tension) = (number("a")?, number("b")?, [number("Tx")?, number("Ty")?]);
    let meshes = "/rectangle_frequency/P1_on_M(n,n)";
    for i in 0..file.len(meshes)? {
        if !file.is_true(&format!("{meshes}/{i}/lumped")) {
            continue;
        }
        let n = file.number(&format!("{meshes}/{i}/n"))? as usize;
        let (mut simulation, body) = bodies::simulate(one_thread(), taut(generate::grid(a, b, n, n)?, tension)?)?;
        let snapshot = Snapshot::new(&mut simulation, body)?;
        let free = out_of_plane(&snapshot, |p| p.x > 0.0 && p.x < a && p.y > 0.0 && p.y < b);
        let found = lowest_frequencies(&snapshot, &free, 1)?;
        // The mesh' own frequency.
        rows.relative(
            format!("taut rectangle M({n},{n}): frequency"),
            found[0],
            file.number(&format!("{meshes}/{i}/f1"))?,
            1e-8,
        );
    }
    Ok(())
}

/// Stretches a rectangle with held edges and finds its lowest frequency.
fn stretched(a: f64, b: f64, n: usize, stretch: [f64; 2], is_strip: bool) -> Result<f64, VerifyError> {
    let mesh = if is_strip { strip(a, n) } else { generate::grid(a, b, n, n)? };
    let membrane = Membrane::new("sheet", mesh, Material::allard_2009()).fibres(Fibres::at_degrees(0.0));
    let (mut simulation, body) = bodies::simulate(one_thread(), membrane)?;
    // A uniform stretch of the rectangle is in equilibrium: it may be set at once.
    bodies::set_motion(&mut simulation, body, |_, x| {
        (DVec3::new(x.x * stretch[0], x.y * stretch[1], 0.0), DVec3::ZERO)
    })?;
    let snapshot = Snapshot::new(&mut simulation, body)?;
    let free = out_of_plane(&snapshot, |p| p.x > 0.0 && p.x < a && (is_strip || p.y > 0.0 && p.y < b));
    Ok(lowest_frequencies(&snapshot, &free, 1)?[0])
}

fn stretched_frequencies(rows: &mut Rows, file: &Json) -> Result<(), VerifyError> {
    let number = |key: &str| file.number(&format!("/prestretched_strip_frequency/{key}"));
    let (length, stretch, exact) = (number("L0")?, number("lam")?, number("f_kHz/0")?);
    let n = 20;
    let found = stretched(length, 0.0, n, [stretch, 1.0], true)?;
    // The chain's own factor: its frequency is (2n/π)·sin(π/(2n)) of the string's.
    let chain =
        (std::f64::consts::FRAC_PI_2 / f64::from(n as u32)).sin() / (std::f64::consts::FRAC_PI_2 / f64::from(n as u32));
    rows.relative("stretched strip of 20 cells: frequency", found, exact * chain, 1e-9);

    let number = |key: &str| file.number(&format!("/prestretched_rectangle_frequency/{key}"));
    let (a, b, stretch) = (number("a")?, number("b")?, [number("lx")?, number("ly")?]);
    let coarse = stretched(a, b, 20, stretch, false)?;
    let fine = stretched(a, b, 40, stretch, false)?;
    // Second order in the mesh size: extrapolation leaves the fourth.
    rows.relative("stretched rectangle: frequency, extrapolated", (4.0 * fine - coarse) / 3.0, number("f11")?, 1e-5);
    Ok(())
}

fn with_pressure(membrane: Membrane, pressure: f64) -> Membrane {
    membrane.with(Pressure { curve: Curve::constant(pressure) })
}

/// Deflection of the centre of a taut rectangle \[mm\], linear.
fn centre(a: f64, b: f64, n: usize, tension: [f64; 2], pressure: f64) -> Result<f64, VerifyError> {
    let membrane = bodies::hold_rim(taut(generate::grid(a, b, n, n)?, tension)?, a, b);
    let (mut simulation, body) = bodies::simulate(one_thread(), with_pressure(membrane, pressure))?;
    let found = bodies::linear(&mut simulation, body)?;
    Ok(found.displacement[(n / 2) * (n + 1) + n / 2].z)
}

fn small_pressure(rows: &mut Rows, file: &Json) -> Result<(), VerifyError> {
    for (what, key) in [("square", "pressure_square_linear"), ("rectangle", "pressure_rectangle_linear")] {
        let number = |name: &str| file.number(&format!("/{key}/{name}"));
        let a = number("a")?;
        let b = number("b").unwrap_or(a);
        let tension = match number("T") {
            Ok(t) => [t, t],
            Err(_) => [number("Tx")?, number("Ty")?],
        };
        let exact = number("w_centre")?;
        let coarse = centre(a, b, 20, tension, number("p")?)?;
        let fine = centre(a, b, 40, tension, number("p")?)?;
        let rate = ((coarse - exact) / (fine - exact)).log2();
        rows.relative(format!("pressure on a taut {what}, M(40,40)"), fine, exact, 3e-4);
        rows.ratio(format!("pressure on a taut {what}: rate, distance from 2"), (rate - 2.0).abs(), 0.1);
        rows.relative(format!("pressure on a taut {what}, extrapolated"), (4.0 * fine - coarse) / 3.0, exact, 2e-5);
    }
    let number = |name: &str| file.number(&format!("/pressure_circle_linear/{name}"));
    let (radius, tension) = (number("R")?, number("T")?);
    let mesh = generate::disc(radius, 4_000)?;
    let membrane = taut(mesh, [tension, tension])?;
    let rim = bodies::hold(&membrane, "rim", |p| (p.length() > radius - 1e-9).then_some(DVec3::ZERO));
    let (mut simulation, body) = bodies::simulate(one_thread(), with_pressure(membrane.hold(rim), number("p")?))?;
    let found = bodies::linear(&mut simulation, body)?;
    // 26 rings: a polygon of 160 sides has 0.03 % less area than its circle, the mesh error is (1/26)² of order one.
    rows.relative("pressure on a taut disc of 4,000 triangles", found.displacement[0].z, number("w0")?, 1.5e-3);
    Ok(())
}

fn large_pressure(rows: &mut Rows, file: &Json) -> Result<(), VerifyError> {
    let entries = [
        ("flat strip, inflated", "strip_pressure_large_flat_unstretched"),
        ("stretched strip, inflated", "strip_pressure_large_prestretched"),
    ];
    for (what, key) in entries {
        let number = |name: &str| file.number(&format!("/{key}/{name}"));
        let (length, stretch, exact) = (number("L")?, number("lam0")?, number("w_centre")?);
        for (i, n) in [10, 20, 40].into_iter().enumerate() {
            let rest = length / stretch;
            let membrane =
                Membrane::new("strip", strip(rest, n), Material::allard_2009()).fibres(Fibres::at_degrees(0.0));
            let ends = bodies::hold(&membrane, "ends", |p| {
                (p.x == 0.0 || p.x == rest).then(|| DVec3::X * (p.x / rest * (length - rest)))
            });
            let across = bodies::hold_along(&membrane, "across", [false, true, false], Curve::constant(1.0), |p| {
                (p.x > 0.0 && p.x < rest).then_some(DVec3::ZERO)
            });
            let membrane = with_pressure(membrane.hold(ends).hold(across), number("p")?);
            let (mut simulation, body) = bodies::simulate(
                Settings { advanced: Advanced { static_iterations: 400, ..one_thread().advanced }, ..one_thread() },
                membrane,
            )?;
            // A flat sheet without tension has no stiffness out of its plane: the start is near the answer.
            bodies::set_motion(&mut simulation, body, |_, x| {
                let s = x.x / rest;
                (DVec3::new(x.x * stretch, x.y, exact * 4.0 * s * (1.0 - s)), DVec3::ZERO)
            })?;
            simulation.settle(1.0, 1e-10)?;
            let x = bodies::positions(&simulation, body)?;
            let middle = 0.5 * (x[n / 2].z + x[n / 2 + n + 1].z);
            let chain = number(&format!("chain_n10_20_40/{i}"))?;
            // A triangle hands its load to its corners in thirds, the chain in halves: along a curved strip that is a shift of
            // the load by a sixth of a cell, to the left on one side and to the right on the other.
            rows.relative(format!("{what}, {n} cells: against the chain"), middle, chain, 1e-5);
            rows.note(format!("{what}, {n} cells: against the exact arc"), (middle / exact - 1.0).abs(), "1");
        }
    }
    Ok(())
}

fn hencky(rows: &mut Rows, file: &Json) -> Result<(), VerifyError> {
    let number = |name: &str| file.number(&format!("/hencky_circle/{name}"));
    let (radius, exact) = (number("R")?, number("w0")?);
    let mesh = generate::disc(radius, 2_000)?;
    let membrane = Membrane::new("disc", mesh, Material::isotropic(number("E")?, number("nu")?, number("h")?));
    let rim = bodies::hold(&membrane, "rim", |p| (p.length() > radius - 1e-9).then_some(DVec3::ZERO));
    let membrane = with_pressure(membrane.hold(rim), number("p")?);
    let (mut simulation, body) = bodies::simulate(
        Settings { advanced: Advanced { static_iterations: 400, ..one_thread().advanced }, ..one_thread() },
        membrane,
    )?;
    bodies::set_motion(&mut simulation, body, |_, x| {
        (x + DVec3::Z * (exact * (1.0 - x.length_squared() / radius.powi(2))), DVec3::ZERO)
    })?;
    simulation.settle(1.0, 1e-8)?;
    let found = bodies::positions(&simulation, body)?[0].z;
    // Föppl's theory of moderate slopes: the file expects a difference of the order of 0.6 %, to which 18 rings add 0.3 %.
    rows.relative("inflated disc against Hencky's solution", found, exact, 1e-2);
    Ok(())
}
