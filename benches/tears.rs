//! What a tear costs beside the solve: the direction search, the stress average at a tip, a whole advance.
//!
//! `cargo bench --bench tears`. Compare medians of one run; a row counts items, so that its time per item is read off.

use divan::{Bencher, black_box, counter::ItemsCount};
use glam::DVec2;
use rhexis::math::Sym2;
use rhexis::systems::kernels::failure::{Cone, Search, Sector, Strength, evaluate};
use std::f64::consts::FRAC_PI_2;

fn main() {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().expect("no pool before this one");
    divan::main();
}

/// Stresses, fibres and previous directions as tips meet them: tension, a crack behind, a cone of 90°.
fn tips() -> Vec<(Sym2, DVec2, Cone, Sector)> {
    let mut state = 1_u64;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let tip = |_| {
        let p = next() * 6.0;
        let stress = Sym2::new(next(), next(), next() - 0.5);
        let sector = Sector { from: p - 3.1, to: p + 3.1 };
        (
            stress,
            DVec2::from_angle(6.0 * next()),
            Cone { previous: DVec2::from_angle(p), half_angle: FRAC_PI_2 },
            sector,
        )
    };
    (0..1000).map(tip).collect()
}

/// Exponents of the threshold; 1000 searches.
#[divan::bench(args = [0.3, 0.5, 1.0, 2.0])]
fn search_without_table(bencher: Bencher, exponent: f64) {
    let strength = Strength::new(0.8, 0.05, exponent).expect("positive");
    let tips = tips();
    bencher.counter(ItemsCount::new(tips.len())).bench_local(|| {
        for &(stress, fibre, cone, sector) in &tips {
            black_box(evaluate(black_box(stress), fibre, &strength, Some(cone), Some(sector)));
        }
    });
}

/// The same with the table.
#[divan::bench(args = [0.3, 0.5, 1.0, 2.0])]
fn search(bencher: Bencher, exponent: f64) {
    let search = Search::new(Strength::new(0.8, 0.05, exponent).expect("positive"));
    let tips = tips();
    bencher.counter(ItemsCount::new(tips.len())).bench_local(|| {
        for &(stress, fibre, cone, sector) in &tips {
            black_box(search.evaluate(black_box(stress), fibre, Some(cone), Some(sector)));
        }
    });
}

/// Preparing the table.
#[divan::bench(args = [0.5, 2.0])]
fn table(bencher: Bencher, exponent: f64) {
    let strength = Strength::new(0.8, 0.05, exponent).expect("positive");
    bencher.bench_local(|| Search::new(black_box(strength)));
}
