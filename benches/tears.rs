//! What a tear costs beside the solve: the direction search, the stress average at a tip, a whole advance.
//!
//! `cargo bench --bench tears`. Compare medians of one run; a row counts items, so that its time per item is read off.

mod fig2;

use divan::{Bencher, black_box, counter::ItemsCount};
use fig2::{LARGE, SMALL, hand, square};
use glam::{DVec2, DVec3};
use rhexis::components::{Bending, EnergyCriterion, Tearing, Toughness};
use rhexis::math::Sym2;
use rhexis::settings::Settings;
use rhexis::simulation::Simulation;
use rhexis::storage::{BodyId, EditRecord, Mesh, Tips, Topology, Triangles, Vertices, undo};
use rhexis::systems::fracture::{
    CrackFrame, Cutter, Disc, EnergyTerms, Quality, ShiftedDisc, Surface, TearScratch, TipMemory, Walk,
    energy_decision, lay_at_tip, strength,
};
use rhexis::systems::kernels::failure::{Cone, Search, Sector, Strength, evaluate};
use std::cell::RefCell;
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

/// Cells of a mesh with 150,080 triangles.
const LARGEST: [usize; 2] = [300, 250];

/// The notched square at 1 % stretch.
fn notched(cells: [usize; 2], tearing: Tearing) -> (Simulation, BodyId) {
    let mut simulation = Simulation::new(Settings { threads: 1, ..Settings::default() }).expect("threads");
    let body = simulation.spawn(square(cells, hand()).with(tearing)).expect("an admissible body");
    for _ in 0..5 {
        simulation.step(4.0).expect("a time step");
    }
    let notch = [DVec3::new(15.0, 30.0, 0.0), DVec3::new(15.0, 27.0, 0.0)];
    simulation.cut(body, &notch).expect("a notch");
    (simulation, body)
}

/// Calls `f` with the surface of a notched square that has so many edges per radius, and its tip.
fn at_tip(edges_per_radius: f64, f: impl FnOnce(&Surface, u32, f64)) {
    let (simulation, body) = notched(LARGE, Tearing { strength_along_fibres: 1e9, ..Tearing::default() });
    let world = simulation.world();
    let vertices = &*world.get::<&Vertices>(body.entity()).expect("a body");
    let triangles = &*world.get::<&Triangles>(body.entity()).expect("a body");
    let topology = &*world.get::<&Topology>(body.entity()).expect("a body");
    let tip = world.get::<&Tips>(body.entity()).expect("a body that tears").vertex[0];
    let surface = Surface {
        vertices,
        triangles,
        topology,
        is_planar: true,
        unstretched: Sym2::IDENTITY,
        fibres: None,
        bending: None,
    };
    f(&surface, tip, edges_per_radius * 30.0 / LARGE[0] as f64);
}

/// The walk over a disc with its overlaps, for a tip that has just arrived; items are triangles visited.
#[divan::bench(args = [3.0, 6.0, 12.0])]
fn disc_first_visit(bencher: Bencher, edges_per_radius: f64) {
    at_tip(edges_per_radius, |surface, tip, radius| {
        let (mut disc, mut walk) = (Disc::default(), Walk::default());
        let chart = surface.chart(tip).expect("a fan");
        let mut lay = || {
            lay_at_tip(&mut disc, surface, (tip, radius), &chart, &mut walk);
            disc.triangles().count()
        };
        let count = lay();
        bencher.counter(ItemsCount::new(count)).bench_local(lay);
    });
}

/// The stress in the disc of a tip that rests; items are triangles visited.
#[divan::bench(args = [3.0, 6.0, 12.0])]
fn disc_at_rest(bencher: Bencher, edges_per_radius: f64) {
    at_tip(edges_per_radius, |surface, tip, radius| {
        let mut disc = Disc::default();
        let chart = surface.chart(tip).expect("a fan");
        lay_at_tip(&mut disc, surface, (tip, radius), &chart, &mut Walk::default());
        bencher.counter(ItemsCount::new(disc.triangles().count())).bench_local(|| disc.stress(black_box(surface)));
    });
}

/// All that the memory does for a resting tip: is it up to date, and the stress.
#[divan::bench(args = [3.0, 6.0])]
fn memory_at_rest(bencher: Bencher, edges_per_radius: f64) {
    at_tip(edges_per_radius, |surface, tip, radius| {
        let mut memory = TipMemory::default();
        let strength = strength(&Tearing::default());
        bencher.bench_local(|| memory.at_tip(surface, (0, tip), strength, radius).map(|(.., average)| average.stress));
    });
}

/// A decision by energy at a resting tip: is the memory up to date, the integrals over the ring of 2R, the search of the direction.
#[divan::bench(args = [3.0, 4.0])]
fn energy_at_rest(bencher: Bencher, edges_per_radius: f64) {
    at_tip(edges_per_radius, |surface, tip, radius| {
        let tearing = &Tearing { radius, ..Tearing::default() };
        let energy = &EnergyCriterion::new(Toughness { along: 0.02, across: 0.5 });
        let (terms, mut memory) = (EnergyTerms { tearing, energy }, TipMemory::default());
        let mut decide = || energy_decision(surface, terms, 0, (tip, DVec3::NEG_Y), &mut memory);
        assert!(decide().is_some());
        bencher.bench_local(decide);
    });
}

/// The material force at a tip that rests, of a membrane in space; items are triangles of the disc.
#[divan::bench(args = [3.0, 6.0])]
fn material_force(bencher: Bencher, edges_per_radius: f64) {
    shifted_disc(bencher, edges_per_radius, None);
}

/// The same with bending.
#[divan::bench(args = [3.0, 6.0])]
fn material_force_with_bending(bencher: Bencher, edges_per_radius: f64) {
    shifted_disc(bencher, edges_per_radius, Some(&Bending::default()));
}

fn shifted_disc(bencher: Bencher, edges_per_radius: f64, bending: Option<&Bending>) {
    at_tip(edges_per_radius, |surface, tip, radius| {
        let surface = &Surface { is_planar: false, bending, ..*surface };
        let (mut disc, mut walk) = (ShiftedDisc::default(), Walk::default());
        let axes = surface.chart(tip).expect("a fan").axes();
        let start = surface.topology.incident[tip as usize].iter().map(|entry| entry / 3);
        let frame = CrackFrame { fibre: DVec2::X, tip: DVec2::ZERO };
        disc.lay(surface, ((tip, axes, radius), frame), start, &mut walk);
        let count = disc.triangles().count();
        bencher.counter(ItemsCount::new(count)).bench_local(|| disc.force(black_box(surface)));
    });
}

/// An advance of a tip by one triangle: ways, edits, opening, flips. It is undone before the next, so everything is warm.
/// Arguments are the numbers of triangles.
#[divan::bench(args = [SMALL, LARGE, LARGEST].map(|[nx, ny]| 2 * nx * ny), sample_count = 300, sample_size = 1)]
fn advance(bencher: Bencher, triangle_count: usize) {
    let cells = [SMALL, LARGE, LARGEST].into_iter().find(|[nx, ny]| 2 * nx * ny == triangle_count);
    let (mut simulation, body) = notched(cells.expect("one of them"), Tearing::default());
    let tip = simulation.world().get::<&Tips>(body.entity()).expect("a body that tears").vertex[0];
    let tables = simulation.world_mut().query_one_mut::<(&mut Vertices, &mut Triangles, &mut Topology)>(body.entity());
    let (vertices, triangles, topology) = tables.expect("a body");
    let mesh = RefCell::new(Mesh { vertices, triangles, topology });
    let scratch = RefCell::new(TearScratch::default());
    let is_movable = |v: u32| v != tip;
    let mut angle = 0.0_f64;
    bencher
        .with_inputs(|| {
            let records = &mut scratch.borrow_mut().records;
            records.drain(..).rev().for_each(|record: EditRecord| undo(&mut mesh.borrow_mut(), &record).expect("last"));
            // The golden angle spreads the directions over 120° about the notch's.
            angle = (angle + 1.294) % 2.1;
            DVec2::from_angle(-0.2 - 0.5 * std::f64::consts::PI + 1.05 - angle).extend(0.0)
        })
        .bench_local_values(|direction| {
            let (mesh, scratch) = (&mut *mesh.borrow_mut(), &mut *scratch.borrow_mut());
            let mut cutter = Cutter { mesh, is_movable: &is_movable, quality: Quality::default(), scratch };
            cutter.advance(tip, direction).expect("an advance")
        });
}
