//! Tearing of the `fig2` square.

use glam::DVec3;
use rhexis::components::{Curve, Damping, Fibres, Hold, Material, TearLog, Tearing};
use rhexis::membrane::Membrane;
use rhexis::scene::generate;
use rhexis::settings::Settings;
use rhexis::simulation::Simulation;
use rhexis::storage::Attached;

fn square(nx: usize, ny: usize, degrees: f64, tearing: Tearing) -> Membrane {
    let mesh = generate::grid(30.0, 30.0, nx, ny).unwrap();
    let membrane = Membrane::new("square", mesh, Material::figure_2()).fibres(Fibres::at_degrees(degrees)).planar();
    let side =
        |x: f64, to: f64| Attached::new(membrane.select(|p| p.x == x).into_iter().map(|row| (row, DVec3::X * to)));
    let curve = Curve::new(vec![(0.0, 0.0), (1000.0, 3.0)]).unwrap();
    let hold = |name: &str, members| Hold { name: name.into(), members, axes: [true; 3], curve: curve.clone() };
    let (left, right) = (hold("left", side(0.0, -1.0)), hold("right", side(30.0, 1.0)));
    membrane.hold(left).hold(right).with(tearing).with(Damping { time: 0.1 })
}

#[test]
fn tears_along_the_fibre() {
    for degrees in [45.0, 60.0, 75.0, 90.0, 30.0] {
        let tearing = Tearing { strength_fibre: if degrees == 30.0 { 1.6 } else { 0.8 }, ..Tearing::default() };
        let mut simulation = Simulation::new(Settings::default()).unwrap();
        let body = simulation.spawn(square(60, 50, degrees, tearing)).unwrap();
        let cut = simulation.cut(body, &[DVec3::new(15.0, 30.0, 0.0), DVec3::new(15.0, 27.0, 0.0)]).unwrap();
        println!("{cut:?}");
        let start = std::time::Instant::now();
        for _ in 0..110 {
            simulation.step(10.0).unwrap();
            for e in simulation.drain_events().collect::<Vec<_>>() {
                if !matches!(e.kind, rhexis::event::EventKind::Advanced { .. }) {
                    println!("{e:?}");
                }
            }
        }
        let frame = simulation.frame();
        rhexis::output::render(
            std::path::Path::new(&format!("/tmp/fig2tear{degrees}.png")),
            &frame.bodies[0],
            &Default::default(),
        )
        .unwrap();
        println!("{:?} {:?}", start.elapsed(), *simulation.world().get::<&TearLog>(body).unwrap());
    }
}
