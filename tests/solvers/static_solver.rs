//! A static solve finds the same equilibrium with a sparse Cholesky factor as with block Jacobi, wherever that finds one.

use crate::common::{GRIP_SPEED, Square, state_bits};
use glam::DVec3;
use rhexis::components::{Curve, Fibres, Hold, Material, Pressure};
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::settings::{Advanced, LinearParams, Preconditioner, Settings};
use rhexis::simulation::Simulation;
use rhexis::storage::{Attached, BodyId, Vertices};

fn with(preconditioner: Preconditioner) -> Settings {
    Settings { threads: 1, advanced: Advanced { preconditioner, ..Advanced::default() }, ..Settings::default() }
}

fn positions(simulation: &Simulation, body: BodyId) -> Vec<DVec3> {
    simulation.world().get::<&Vertices>(body.entity()).unwrap().position.clone()
}

/// The largest distance \[mm\] between two equilibria, one per preconditioner, and the linear iterations each took.
fn compare(solve: impl Fn(Settings) -> (Simulation, BodyId)) -> (f64, [u32; 2]) {
    let [a, b] = [Preconditioner::BlockJacobi, Preconditioner::Cholesky].map(|preconditioner| {
        let (simulation, body) = solve(with(preconditioner));
        (positions(&simulation, body), simulation.report().bodies[0].iterations)
    });
    assert_eq!(a.0.len(), b.0.len());
    let off = a.0.iter().zip(&b.0).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
    println!("off {off:e} mm, iterations {} and {}", a.1, b.1);
    (off, [a.1, b.1])
}

/// With the feature the factor is in use: far fewer iterations.
fn assert_few(iterations: [u32; 2]) {
    if cfg!(feature = "direct") {
        assert!(iterations[1] * 5 < iterations[0], "{iterations:?}");
    }
}

fn held(membrane: &Membrane, name: &str, at: impl Fn(DVec3) -> bool, offset: DVec3) -> Hold {
    let members = Attached::new(membrane.select(at).into_iter().map(|v| (v, offset)));
    Hold { name: name.into(), members, axes: [true; 3], curve: Curve::ramp(1.0, 1.0).unwrap() }
}

/// A square of 30 mm pulled by 10 %, fibres at 45°.
fn taut(settings: Settings, is_planar: bool) -> (Simulation, BodyId) {
    let mesh = generate::grid(30.0, 30.0, 20, 16).unwrap();
    let mut square = Membrane::new("square", mesh, Material::allard_2009()).fibres(Fibres::at_degrees(45.0));
    if is_planar {
        square = square.planar();
    }
    let left = held(&square, "left", |p| p.x == 0.0, DVec3::X * -1.5);
    let right = held(&square, "right", |p| p.x == 30.0, DVec3::X * 1.5);
    let mut simulation = Simulation::new(settings).unwrap();
    let body = simulation.spawn(square.hold(left).hold(right)).unwrap();
    (simulation, body)
}

// Tolerances: Newton stops at 1e-10 of a corner force of 0.1 N, 1e-11 N. The softest way a sheet of 30 mm gives is that of a
// whole side, E·h = 0.1 N/mm with the imbalance of a thousand vertices at one sign: 1e-7 mm at the very most.

#[test]
fn a_taut_square_comes_to_the_same_rest() {
    for is_planar in [true, false] {
        let (off, iterations) = compare(|settings| {
            let (mut simulation, body) = taut(settings, is_planar);
            simulation.settle(1.0, 1e-10).unwrap();
            (simulation, body)
        });
        assert!(off < 1e-7, "{off:e}");
        assert_few(iterations);
    }
}

#[test]
fn a_linear_response_is_the_same() {
    let (off, iterations) = compare(|settings| {
        let (mut simulation, body) = taut(settings, true);
        simulation.linear_response(1.0).unwrap();
        (simulation, body)
    });
    // Both to a residual of 1e-13, times the condition of 1e4 and displacements of 1.5 mm.
    assert!(off < 1e-8, "{off:e}");
    assert_few(iterations);
}

#[test]
fn a_cap_under_pressure_comes_to_the_same_rest() {
    let (off, iterations) = compare(|settings| {
        let mesh = generate::cap(10.0, 12.0, 800).unwrap();
        let rim = mesh.positions.iter().map(|p| p.truncate().length()).fold(0.0, f64::max);
        let cap = Membrane::new("cap", mesh, Material::allard_2009()).fibres(Fibres::at_degrees(30.0));
        let hold = held(&cap, "rim", |p| p.truncate().length() > rim - 1e-9, DVec3::ZERO);
        let cap = cap.hold(hold).with(Pressure { curve: Curve::ramp(1.0, 2e-4).unwrap() });
        let mut simulation = Simulation::new(Settings {
            advanced: Advanced { static_iterations: 400, ..settings.advanced },
            ..settings
        })
        .unwrap();
        let body = simulation.spawn(cap).unwrap();
        simulation.settle(1.0, 1e-9).unwrap();
        (simulation, body)
    });
    assert!(off < 1e-6, "{off:e}");
    assert_few(iterations);
}

/// A square of 7 mm cut out of a taut sheet: it springs back, is held by nothing any more, and makes the stiffness singular.
#[test]
fn a_piece_that_nothing_holds_does_not_keep_the_rest_from_its_equilibrium() {
    let [a, b] = [Preconditioner::BlockJacobi, Preconditioner::Cholesky].map(|preconditioner| {
        let (mut simulation, body) = taut(with(preconditioner), true);
        simulation.settle(1.0, 1e-10).unwrap();
        let corners = [[10.2, 10.2], [17.1, 10.2], [17.1, 17.1], [10.2, 17.1], [10.2, 10.2]];
        let cut = simulation.cut(body, &corners.map(|[x, y]| DVec3::new(x, y, 0.0))).unwrap();
        assert_eq!(cut.fragment_count, 1);
        simulation.settle(0.0, 1e-10).unwrap();
        (positions(&simulation, body), simulation.frame().bodies[0].rest_positions.clone())
    });
    // The frame has one place to be; the piece may lie anywhere, but it has no reason to leave.
    let is_inside = |p: &DVec3| (10.2 - 1e-6..17.1 + 1e-6).contains(&p.x) && (10.2 - 1e-6..17.1 + 1e-6).contains(&p.y);
    let pairs = || a.0.iter().zip(&b.0).zip(&a.1);
    let frame = pairs().filter(|(_, rest)| !is_inside(rest)).map(|((a, b), _)| a.distance(*b)).fold(0.0, f64::max);
    let piece = pairs().filter(|(_, rest)| is_inside(rest)).map(|((a, b), _)| a.distance(*b)).fold(0.0, f64::max);
    println!("frame off {frame:e} mm, piece off {piece:e} mm");
    assert!(frame < 1e-7, "{frame:e}");
    assert!(piece < 1.0, "{piece:e}");
}

#[test]
fn a_body_that_is_held_everywhere_moves_as_it_is_told() {
    let (off, iterations) = compare(|settings| {
        let mesh = generate::grid(3.0, 3.0, 3, 3).unwrap();
        let sheet = Membrane::new("sheet", mesh, Material::allard_2009());
        let hold = held(&sheet, "all", |_| true, DVec3::Y);
        let mut simulation = Simulation::new(settings).unwrap();
        let body = simulation.spawn(sheet.hold(hold)).unwrap();
        simulation.settle(1.0, 1e-9).unwrap();
        (simulation, body)
    });
    assert_eq!((off, iterations), (0.0, [0, 0]));
}

/// The factor of one step serves the next ones, and gives what block Jacobi gives.
#[test]
fn dynamic_steps_may_use_a_factor_too() {
    let (off, iterations) = compare(|settings| {
        let linear = LinearParams::by_residual(1e-10, 5000);
        let (mut simulation, body) =
            taut(Settings { advanced: Advanced { linear, ..settings.advanced }, ..settings }, true);
        for _ in 0..10 {
            simulation.step(0.1).unwrap();
        }
        (simulation, body)
    });
    // Ten steps solved to 1e-10 of displacements of 0.15 mm each, times the condition of 1e3.
    assert!(off < 1e-6, "{off:e}");
    assert_few(iterations);
}

/// 6,000 triangles that tear: more than two chunks of 1,024 rows, so that threads do share the loops.
#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let [one, two] = [1, 2].map(|threads| {
        let mut square = Square::new([60, 50], 60.0);
        square.tearing.strength_across_fibres *= 0.2;
        square.tearing.strength_along_fibres *= 0.2;
        let mut run = square.spawn(Settings { threads, ..Settings::default() });
        run.simulation.settle_and_tear(0.5 / GRIP_SPEED, 1e-8, 3).unwrap();
        assert!(run.log().advance_count > 2, "the state must be one after tears");
        state_bits(&run.simulation, run.body)
    });
    assert!(one == two);
}
