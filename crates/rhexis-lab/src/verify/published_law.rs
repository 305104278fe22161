//! The law of Holzapfel, Gasser and Ogden against its own formulas: strips and a square of the adventitia of an iliac artery.
//!
//! Constants of Gasser, Ogden and Holzapfel 2006 (J. R. Soc. Interface 3, 15): c = 7.64 kPa in c/2·(I₁ − 3), k₁ = 996.6 kPa, k₂ = 524.6,
//! κ = 0.226, families at ±49.98° from the circumference. What is wanted is computed here from principal stretches alone, with the
//! lateral stretch of a strip found by bisection.

use super::bodies::{exacting, hold_along, reaction, simulate};
use super::{Rows, VerifyError, largest};
use glam::DVec3;
use rhexis::components::{Curve, Fibres, HolzapfelGasserOgden, Material};
use rhexis::generate;
use rhexis::membrane::Membrane;

/// c and k₁ \[MPa\], k₂, the angle \[°\], κ.
const C: f64 = 7.64e-3;
const K1: f64 = 0.9966;
const K2: f64 = 524.6;
const DEGREES: f64 = 49.98;
const KAPPA: f64 = 0.226;

/// Length, width and thickness \[mm\].
const SIZE: [f64; 3] = [10.0, 4.0, 0.4];

/// First Piola–Kirchhoff stresses \[MPa\] at principal stretches, the first of which makes this angle \[rad\] with both families.
fn stresses([a, b]: [f64; 2], angle: f64) -> [f64; 2] {
    let (along, across) = (angle.cos().powi(2), angle.sin().powi(2));
    let (first, fourth) = (a * a + b * b + 1.0 / (a * b).powi(2), along * a * a + across * b * b);
    let e = KAPPA * (first - 3.0) + (1.0 - 3.0 * KAPPA) * (fourth - 1.0);
    let slope = if e > 0.0 { 2.0 * K1 * e * (K2 * e * e).exp() } else { 0.0 };
    let by_first = [2.0 * a - 2.0 / (a.powi(3) * b * b), 2.0 * b - 2.0 / (b.powi(3) * a * a)];
    let by_fourth = [2.0 * along * a, 2.0 * across * b];
    [0, 1].map(|i| (0.5 * C + slope * KAPPA) * by_first[i] + slope * (1.0 - 3.0 * KAPPA) * by_fourth[i])
}

/// The lateral stretch that leaves the sides free.
fn lateral(a: f64, angle: f64) -> f64 {
    let (mut low, mut high) = (0.3, 1.2);
    while 0.5 * (low + high) > low && 0.5 * (low + high) < high {
        let middle = 0.5 * (low + high);
        if stresses([a, middle], angle)[1] > 0.0 { high = middle } else { low = middle }
    }
    low
}

/// The body, with its left end and its lower corner or edge held, and its right end, and the upper one if asked to, drawn by a tenth per ms.
fn membrane(fibre_degrees: f64, is_biaxial: bool) -> Result<Membrane, VerifyError> {
    let [length, width, thickness] = SIZE;
    let mesh = generate::jittered(length, width, 10, 4, 5)?;
    let law = HolzapfelGasserOgden::symmetric(K1, K2, DEGREES, KAPPA);
    let material = Material::neo_hookean(C, thickness);
    let membrane = Membrane::new("strip", mesh, material).fibres(Fibres::at_degrees(fibre_degrees)).with(law).planar();
    let ramp = || Curve::ramp(10.0, 1.0).unwrap_or_else(|_| Curve::constant(1.0));
    let hold = |name: &str, axis: usize, at: f64, by: f64| {
        let axes = [axis == 0, axis == 1, false];
        let on = move |p: DVec3| {
            (p[axis] == at && (is_biaxial || axis == 0 || p.x == 0.0)).then_some(DVec3::AXES[axis] * by)
        };
        hold_along(&membrane, name, axes, ramp(), on)
    };
    let (left, bottom, right) =
        (hold("left", 0, 0.0, 0.0), hold("bottom", 1, 0.0, 0.0), hold("right", 0, length, length));
    let top = hold("top", 1, width, width);
    let membrane = membrane.hold(left).hold(bottom).hold(right);
    Ok(if is_biaxial { membrane.hold(top) } else { membrane })
}

pub(super) fn rows(rows: &mut Rows) -> Result<(), VerifyError> {
    let [length, width, thickness] = SIZE;
    let angle = DEGREES.to_radians();
    for (name, fibre_degrees, angle) in
        [("circumferential", 0.0, angle), ("axial", 90.0, std::f64::consts::FRAC_PI_2 - angle)]
    {
        let (mut simulation, body) = simulate(exacting(), membrane(fibre_degrees, false)?)?;
        let mut errors = Vec::new();
        // Up to a true stress of 1.6 MPa.
        for step in 1..=20 {
            simulation.settle(0.1, 1e-12)?;
            let stretch = 1.0 + 0.01 * f64::from(step);
            let wanted = stresses([stretch, lateral(stretch, angle)], angle)[0] * width * thickness;
            errors.push((reaction(&simulation, body, "right")?.x / wanted - 1.0).abs());
        }
        // Imbalance of 1e-12 of the forces of triangles, which are up to ten times that of the strip where fibres lie across.
        rows.ratio(format!("adventitia, {name} strip to 20 %: force"), largest(errors), 1e-8);
    }
    let (mut simulation, body) = simulate(exacting(), membrane(0.0, true)?)?;
    let mut errors = Vec::new();
    for step in 1..=8 {
        simulation.settle(0.1, 1e-12)?;
        let stretch = 1.0 + 0.01 * f64::from(step);
        let [along, across] = stresses([stretch; 2], angle);
        errors.push((reaction(&simulation, body, "right")?.x / (along * width * thickness) - 1.0).abs());
        errors.push((reaction(&simulation, body, "top")?.y / (across * length * thickness) - 1.0).abs());
    }
    rows.ratio("adventitia, equibiaxial to 8 %: forces", largest(errors), 1e-8);
    Ok(())
}
