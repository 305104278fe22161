//! The square of Figure 2 as the benchmarks load it.
#![allow(dead_code)]

use glam::DVec3;
use rhexis::components::{Curve, Damping, Fibres, Hold, Material};
use rhexis::membrane::Membrane;
use rhexis::scene::generate;
use rhexis::storage::Attached;

/// Cells of the meshes: 1,500, 3,420, 6,000 and 15,010 triangles.
pub const SMALL: [usize; 2] = [30, 25];
pub const LESSER: [usize; 2] = [45, 38];
pub const MEDIUM: [usize; 2] = [60, 50];
pub const LARGE: [usize; 2] = [95, 79];

/// Duration of the hand's path \[ms\]; at rest afterwards.
pub const HAND_DURATION: u32 = 4000;

/// The square, its left edge held and its right edge led along x \[mm\].
pub fn square([nx, ny]: [usize; 2], right: Curve) -> Membrane {
    let mesh = generate::grid(30.0, 30.0, nx, ny).expect("a grid");
    let mut body = Membrane::new("square", mesh, Material::figure_2())
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

/// A hand at 1 ms steps: 1.5 mm within 100 ms, a tremor of 10 Hz and 0.3 mm, noise of 0.01 mm with a fixed seed.
pub fn hand() -> Curve {
    let mut state = 7_u64;
    let mut noise = || {
        // SplitMix64 (Steele, Lea, Flood 2014).
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    let at = |i: u32| {
        let t = f64::from(i);
        let tremor = 0.3 * (std::f64::consts::TAU * 0.01 * t).sin();
        (t, 1.5 * (t / 100.0).min(1.0) + tremor + if i == 0 { 0.0 } else { 0.01 * noise() })
    };
    Curve::new((0..=HAND_DURATION).map(at).collect()).expect("ascending times")
}
