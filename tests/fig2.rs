//! The square of Figure 2 against independent computations.

use glam::DVec3;
use rhexis::components::{Curve, Fibres, Hold, Material};
use rhexis::membrane::Membrane;
use rhexis::scene::generate;
use rhexis::settings::Settings;
use rhexis::simulation::Simulation;
use rhexis::storage::{Attached, Vertices};

fn square(nx: u32, ny: u32, curve: Curve) -> Membrane {
    let mesh = generate::grid(30.0, 30.0, nx as _, ny as _).unwrap();
    let membrane = Membrane::new("square", mesh, Material::figure_2()).fibres(Fibres::at_degrees(45.0)).planar();
    let side = |x: f64, to: f64| {
        let rows = membrane.select(|p| p.x == x);
        Attached::new(rows.into_iter().map(|row| (row, DVec3::X * to)))
    };
    let (left, right) = (side(0.0, -1.0), side(30.0, 1.0));
    let hold = |name: &str, members| Hold { name: name.into(), members, axes: [true; 3], curve: curve.clone() };
    let (left, right) = (hold("left", left), hold("right", right));
    membrane.hold(left).hold(right)
}

fn positions(file: &str) -> Vec<[f64; 2]> {
    let path = format!("{}/tests/reference/{file}", env!("CARGO_MANIFEST_DIR"));
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(path).unwrap();
    reader.deserialize().map(|r| r.unwrap()).collect()
}

#[test]
fn static_stretch_by_ten_percent_equals_the_reference() {
    for (nx, ny, energy, fx, fy) in [
        (30, 25, 0.857795744280297, 0.5630650578999432, 0.19705501587623636),
        (60, 50, 0.8457453510942242, 0.5552278101839748, 0.18922207471217503),
    ] {
        let mut simulation = Simulation::new(Settings::default()).unwrap();
        let body = simulation.spawn(square(nx, ny, Curve::ramp(1.0, 1.5).unwrap())).unwrap();
        let start = std::time::Instant::now();
        let report = simulation.settle(1.0, 1e-11).unwrap().clone();
        println!("{:?} {report:#?}", start.elapsed());
        let reference = positions(&format!("fig2_large_gradient_{nx}x{ny}.csv"));
        let found = simulation.world().get::<&Vertices>(body).unwrap().position.clone();
        let worst = found.iter().zip(&reference).map(|(x, r)| (x.x - r[0]).hypot(x.y - r[1])).fold(0.0, f64::max);
        let e = simulation.energies(body).unwrap().elastic;
        let reactions = simulation.reactions(body).unwrap();
        println!("{worst:e} {e} {energy} {reactions:?}");
        assert!(worst < 1e-7);
        assert!((e - energy).abs() < 1e-8 * energy);
        assert!((reactions[1].1.x - fx).abs() < 1e-7 * fx && (reactions[1].1.y - fy).abs() < 1e-7 * fx);
    }
}
