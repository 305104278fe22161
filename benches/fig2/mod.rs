//! The square of Figure 2 as the benchmarks load it.
#![allow(dead_code, reason = "shared: each that takes it in uses a part")]

use glam::DVec3;
use rhexis::components::{Curve, Damping, Fibres, Hold, Material};
use rhexis::generate;
use rhexis::internal::Random;
use rhexis::math::elementary;
use rhexis::membrane::Membrane;
use rhexis::storage::Attached;
use std::f64::consts::TAU;

/// Cells of the meshes: 1,500 and 15,010 triangles.
pub const SMALL: [usize; 2] = [30, 25];
pub const LARGE: [usize; 2] = [95, 79];

/// The square, its left edge held and its right edge led along x \[mm\].
pub fn square([nx, ny]: [usize; 2], right: Curve) -> Membrane {
    let mesh = generate::grid(30.0, 30.0, nx, ny).expect("a grid");
    let mut body = Membrane::new("square", mesh, Material::allard_2009())
        .fibres(Fibres::at_degrees(45.0))
        .planar()
        .with(Damping { time: 0.1 });
    for (name, x, curve) in [("left", 0.0, Curve::constant(0.0)), ("right", 30.0, right)] {
        let rows = body.select(|p| p.x == x).into_iter();
        let members = Attached::new(rows.map(|row| (row, DVec3::X)));
        body = body.hold(Hold { name: name.into(), members, axes: [true; 3], curve });
    }
    body
}

/// The hand of the catalog's scene `fig2-haptic`: a ramp to 1.5 within 100 ms, a tremor of 0.3 at 10 Hz, noise of 0.01, a point every
/// millisecond.
pub fn hand() -> Curve {
    let mut random = Random::new(7);
    let mut noise = || 0.01 * (2.0 * random.unit() - 1.0);
    let pull = |t: f64| 1.5 * (t / 100.0).min(1.0) + 0.3 * elementary::sin(TAU * t / 100.0);
    let points = (0..=4000).map(|i| (f64::from(i), if i == 0 { 0.0 } else { pull(f64::from(i)) + noise() }));
    Curve::new(points.collect()).expect("a hand")
}
