//! The energy audit: what comes into a body is found again, each term summed by its own formula.

use crate::common::{GRIP_SPEED, Square};
use glam::DVec3;
use rhexis::components::{
    Anchor, Contact, Curve, Damping, Drag, EdgeLoad, EdgeLoads, EnergyAudit, EnergyBalance, Fibres, Gravity, Grip,
    Grips, Hold, Jaws, Material, Obstacle, Path, PointLoad, PointLoads, PreStretch, Pressure, Shape, Springs, TearMode,
};
use rhexis::event::EventKind;
use rhexis::generate;
use rhexis::math::Sym2;
use rhexis::membrane::Membrane;
use rhexis::settings::{Advanced, LinearParams, Settings, Tangent};
use rhexis::simulation::Simulation;
use rhexis::storage::{Attached, BodyId, Triangles, Vertices};

/// Sum of the sizes of all terms \[mJ\]: what roundings and tolerances are measured by.
fn scale(b: &EnergyBalance) -> f64 {
    let inside = [b.edits.elastic, b.edits.kinetic, b.stored.elastic, b.stored.kinetic];
    let others = [b.work_of_holds, b.work_of_loads, b.damping, b.drag, b.numerical_elastic, b.numerical_kinetic];
    inside.iter().chain(&others).chain(&[b.residual, b.released]).map(|term| term.abs()).sum()
}

fn balance(simulation: &mut Simulation, body: BodyId) -> EnergyBalance {
    simulation.energy_balance(body).unwrap().unwrap()
}

fn hold(sheet: &Membrane, name: &str, at: f64, to: DVec3) -> Hold {
    let members = Attached::new(sheet.select(|p| p.x == at).into_iter().map(|row| (row, to)));
    Hold { name: name.into(), members, axes: [true; 3], curve: Curve::ramp(20.0, 1.0).unwrap() }
}

/// A taut sheet in space, 20 × 16 mm, pulled and lifted at one end, under everything there is.
fn loaded_sheet() -> Membrane {
    let mesh = generate::grid(20.0, 16.0, 10, 8).unwrap();
    let sheet = Membrane::new("sheet", mesh, Material::allard_2009()).fibres(Fibres::at_degrees(30.0));
    let (left, right) =
        (hold(&sheet, "left", 0.0, DVec3::ZERO), hold(&sheet, "right", 20.0, DVec3::new(1.0, 0.2, 0.5)));
    let middle = sheet.select(|p| p.x > 7.0 && p.x < 13.0 && p.y > 5.0 && p.y < 11.0);
    let top = sheet.select(|p| p.y == 16.0);
    let anchors = sheet.select(|p| p.y == 0.0 && p.x > 0.0 && p.x < 20.0).into_iter();
    let anchor = |row: u32| Anchor::new(sheet.mesh().positions[row as usize] + DVec3::Z * 0.2, 0.01);
    let springs = Springs { anchors: Attached::new(anchors.map(|row| (row, anchor(row)))) };
    let point = PointLoad { rows: middle, force: DVec3::new(0.0, 1e-4, 2e-4), curve: Curve::ramp(30.0, 1.0).unwrap() };
    let edges = top.windows(2).map(|pair| [pair[0], pair[1]]).collect();
    let edge = EdgeLoad { edges, traction: DVec3::new(0.0, 1e-3, 0.0), curve: Curve::constant(1.0) };
    let grip = Grip {
        name: "forceps".into(),
        from: 4.0,
        until: 30.0,
        material_point: DVec3::new(6.0, 12.0, 0.0),
        near_tip: None,
        jaws: Jaws { radius: 2.5, stiffness: Some(0.02), ..Jaws::default() },
        path: Path { points: vec![(4.0, DVec3::ZERO), (30.0, DVec3::new(0.2, 0.4, 0.8))] },
        turns: Path::default(),
    };
    sheet
        .hold(left)
        .hold(right)
        .with(Gravity { acceleration: DVec3::new(0.0, 0.0, -9.81e-3) })
        .with(Pressure { curve: Curve::ramp(10.0, 2e-4).unwrap() })
        .with(PointLoads { groups: vec![point] })
        .with(EdgeLoads { groups: vec![edge] })
        .with(springs)
        .with(Grips::new(vec![grip]))
        .with(Contact { stiffness: Some(0.1), friction: 0.0, ..Contact::default() })
        .with(PreStretch { strain: Sym2::new(0.02, 0.01, 0.0) })
        .with(EnergyAudit::default())
}

fn damped_sheet() -> Membrane {
    loaded_sheet().with(Damping { time: 0.3 }).with(Drag { coefficient: 1e-3 })
}

/// A ball that the sheet is pressed onto.
fn simulate(settings: Settings, sheet: Membrane) -> (Simulation, BodyId) {
    let mut simulation = Simulation::new(Settings { threads: 1, ..settings }).unwrap();
    let body = simulation.spawn(sheet).unwrap();
    let shape = Shape::Sphere { centre: DVec3::new(10.0, 8.0, 3.2), radius: 3.0 };
    simulation.spawn_obstacle(Obstacle { shape }).unwrap();
    (simulation, body)
}

fn schemes() -> [(&'static str, Settings); 5] {
    let exacting = LinearParams::by_residual(1e-13, 20_000);
    let linear = Settings { advanced: Advanced { linear: exacting, ..Advanced::default() }, ..Settings::default() };
    let newton =
        Settings { advanced: Advanced { newton_iterations: 60, newton_tolerance: 1e-12, ..linear.advanced }, ..linear };
    [
        ("one rotated solve", linear),
        ("one exact solve", Settings { advanced: Advanced { tangent: Tangent::Exact, ..linear.advanced }, ..linear }),
        ("converged with the rotated tangent", newton),
        (
            "converged with the exact tangent",
            Settings { advanced: Advanced { tangent: Tangent::Exact, ..newton.advanced }, ..newton },
        ),
        ("the default step", Settings::default()),
    ]
}

#[test]
fn every_step_under_every_load_closes_its_balance() {
    for (what, settings) in schemes() {
        for (with, sheet) in [("undamped", loaded_sheet()), ("damped", damped_sheet())] {
            let (mut simulation, body) = simulate(settings, sheet);
            let mut worst = 0.0_f64;
            for _ in 0..60 {
                simulation.step(0.5).unwrap();
                let b = balance(&mut simulation, body);
                worst = worst.max(b.imbalance().abs() / scale(&b));
            }
            let b = balance(&mut simulation, body);
            println!("{what}, {with}: {worst:.1e}\n  {b:?}");
            // Rounding of 160 triangles' terms over 60 steps. The default step leaves residuals of 1e-4; they are a term of the
            // balance, as is what a converged step leaves.
            assert!(worst < 1e-12, "{what}, {with}: {worst:.1e}");
            let dampings =
                if with == "damped" { b.damping.min(b.drag) > 0.0 } else { b.damping == 0.0 && b.drag == 0.0 };
            assert!(dampings && b.released == 0.0 && b.edits == Default::default(), "{b:?}");
        }
    }
}

/// Backward Euler takes energy wherever it is convex: in tension.
#[test]
fn the_converged_step_makes_no_energy_in_tension() {
    for dt in [10.0, 1.0, 0.1] {
        let mesh = generate::grid(30.0, 30.0, 12, 10).unwrap();
        let sheet = Membrane::new("sheet", mesh, Material::allard_2009()).fibres(Fibres::at_degrees(45.0)).planar();
        let (left, right) = (hold(&sheet, "left", 0.0, DVec3::ZERO), hold(&sheet, "right", 30.0, DVec3::X));
        let settings = schemes()[3].1;
        let (mut simulation, body) = simulate(settings, sheet.hold(left).hold(right).with(EnergyAudit::default()));
        let mut last = EnergyBalance::default();
        for _ in 0..40 {
            simulation.step(dt).unwrap();
            let b = balance(&mut simulation, body);
            // Rounding of the energies.
            let least = -1e-14 * scale(&b);
            assert!(b.numerical_elastic - last.numerical_elastic > least, "{b:?} after {last:?}");
            assert!(b.numerical_kinetic >= last.numerical_kinetic, "{b:?} after {last:?}");
            last = b;
        }
        assert!(last.numerical_elastic > 1e-3 * last.work(), "{last:?}");
    }
}

/// A balance that a wrong term leaves unmoved would check nothing.
#[test]
fn a_wrong_term_breaks_the_balance() {
    let (mut simulation, body) = simulate(Settings::default(), damped_sheet());
    (0..60).for_each(|_| assert!(!simulation.step(0.5).unwrap().has_failed));
    let right = balance(&mut simulation, body);
    let size = scale(&right);
    let terms: [fn(&mut EnergyBalance) -> &mut f64; 9] = [
        |b| &mut b.work_of_holds,
        |b| &mut b.work_of_loads,
        |b| &mut b.stored.elastic,
        |b| &mut b.stored.kinetic,
        |b| &mut b.damping,
        |b| &mut b.drag,
        |b| &mut b.numerical_elastic,
        |b| &mut b.numerical_kinetic,
        |b| &mut b.residual,
    ];
    for (i, term) in terms.into_iter().enumerate() {
        let mut wrong = right;
        *term(&mut wrong) *= 1.001;
        assert!(wrong.imbalance().abs() > 100.0 * right.imbalance().abs(), "term {i}: {right:?}");
    }
    // And so does a fault in what the engine does between and within steps.
    type Fault = fn(&mut Simulation, BodyId);
    let faults: [(&str, Fault); 3] = [
        ("a vertex is moved", |s, b| s.world().get::<&mut Vertices>(b.entity()).unwrap().position[30].x += 0.1),
        ("a vertex is stopped", |s, b| s.world().get::<&mut Vertices>(b.entity()).unwrap().velocity[40] = DVec3::ZERO),
        ("the sheet is thickened", |s, b| s.world().get::<&mut Triangles>(b.entity()).unwrap().thickness[50] *= 1.01),
    ];
    for (what, fault) in faults {
        let before = balance(&mut simulation, body).imbalance();
        fault(&mut simulation, body);
        simulation.step(0.5).unwrap();
        let change = (balance(&mut simulation, body).imbalance() - before).abs();
        assert!(change > 1e-9 * size, "{what}: {change:e} of {size:e}");
    }
}

#[test]
fn a_step_that_is_undone_and_halved_keeps_the_balance() {
    let mut run = Square::new([20, 16], 45.0).spawn(Settings::default());
    run.simulation.world_mut().insert_one(run.body.entity(), EnergyAudit::default()).unwrap();
    let away = Curve::new(vec![(0.0, 0.0), (7.0, 0.02), (7.5, 1e200)]).unwrap();
    run.simulation.world().get::<&mut rhexis::components::Holds>(run.body.entity()).unwrap().groups[0].curve = away;
    let report = run.simulation.step(10.0).unwrap();
    assert!(report.has_failed && report.rolled_back > 0 && report.time == 6.875, "{report:?}");
    let b = balance(&mut run.simulation, run.body);
    assert!(b.work() > 0.0 && b.imbalance().abs() < 1e-12 * scale(&b), "{b:?}");
}

/// Steps that are taken up again after advances, flips and slides, a static start: the whole tear is accounted for.
#[test]
fn a_dynamic_tear_keeps_the_balance() {
    for mode in [TearMode::Free, TearMode::Edge] {
        let mut square = Square::new([30, 26], 45.0);
        square.tearing.mode = mode;
        let mut run = square.spawn(Settings::default());
        run.simulation.world_mut().insert_one(run.body.entity(), EnergyAudit::default()).unwrap();
        run.stretch_to(1.2);
        let mut worst = 0.0_f64;
        while run.log().end_count == 0 {
            run.step();
            let b = balance(&mut run.simulation, run.body);
            worst = worst.max(b.imbalance().abs() / scale(&b));
            assert!(run.simulation.time() < 800.0);
        }
        let b = balance(&mut run.simulation, run.body);
        println!("{mode:?}: {worst:.1e}\n  {b:?}");
        // Rounding of 1,600 triangles' terms over the run; where a flap snaps back within a step, Gauss's rule adds its own.
        assert!(worst < 1e-11, "{worst:e}");
        // Openings alone change no energy, but for roundings.
        let edits = b.edits.elastic.abs().max(b.edits.kinetic.abs());
        assert_eq!(edits < 1e-13 * b.work(), mode == TearMode::Edge, "{b:?}");
    }
}

/// The energy that a static advance releases, told at each equilibrium, is what the work of the grips has not stored.
#[test]
fn a_static_tear_tells_what_every_advance_releases() {
    let mut square = Square::new([20, 16], 45.0);
    square.notches = vec![[DVec3::new(15.0, 30.0, 0.0), DVec3::new(15.0, 21.0, 0.0)]];
    let mut run = square.spawn(Settings::default());
    run.simulation.world_mut().insert_one(run.body.entity(), EnergyAudit::default()).unwrap();
    let mut released = Vec::new();
    while run.log().end_count == 0 {
        run.simulation.settle_and_tear(0.2 / GRIP_SPEED, 1e-8, 100).unwrap();
        let b = balance(&mut run.simulation, run.body);
        // The terms of a static solve add up whatever its tolerance: what it leaves counts as released.
        assert!(b.imbalance().abs() < 1e-12 * scale(&b), "{b:?}");
        released.extend(run.simulation.drain_events().filter_map(|e| match e.kind {
            EventKind::Released { energy, length } => Some((energy, length)),
            _ => None,
        }));
        assert!(run.simulation.time() * GRIP_SPEED < 3.0);
    }
    let b = balance(&mut run.simulation, run.body);
    println!("{} advances, {b:?}", released.len());
    assert!(
        released.len() > 3 && released.iter().all(|&(energy, length)| energy > 0.0 && length > 0.0),
        "{released:?}"
    );
    let length: f64 = released.iter().map(|r| r.1).sum();
    assert!((length - (run.log().length - 9.0)).abs() < 1e-9);
    let total: f64 = released.iter().map(|r| r.0).sum();
    let lost = b.work() - b.stored.elastic;
    // The trapezoidal rule of the grips' work over load steps of 0.2 mm.
    assert!((total / lost - 1.0).abs() < 1e-2, "{total} of {lost}");
    let freed = b.released - b.edits.elastic;
    // Roundings, and equilibria to 1e-8 of the largest force.
    assert!((total / freed - 1.0).abs() < 1e-6, "{total} of {freed}");
    // A cut at fixed grips releases energy as well.
    run.simulation.settle(10.0, 1e-8).unwrap();
    run.simulation.cut(run.body, &[DVec3::new(20.0, 0.0, 0.0), DVec3::new(20.0, 6.0, 0.0)]).unwrap();
    run.simulation.settle(0.0, 1e-8).unwrap();
    let told = run.simulation.drain_events().filter(|e| matches!(e.kind, EventKind::Released { .. })).count();
    let b = balance(&mut run.simulation, run.body);
    assert!(told == 1 && b.imbalance().abs() < 1e-12 * scale(&b), "{told} {b:?}");
}

/// Compression makes the exact tangent indefinite: the audit follows the tangent that took its place.
#[test]
fn a_step_that_falls_back_to_the_rotated_tangent_keeps_the_balance() {
    let mesh = generate::grid(20.0, 16.0, 10, 8).unwrap();
    let sheet = Membrane::new("sheet", mesh, Material::allard_2009()).fibres(Fibres::at_degrees(30.0));
    let (left, right) = (hold(&sheet, "left", 0.0, DVec3::ZERO), hold(&sheet, "right", 20.0, DVec3::NEG_X));
    let sheet = sheet.hold(left).hold(right).with(Damping { time: 0.3 }).with(EnergyAudit::default());
    let (mut simulation, body) = simulate(schemes()[1].1, sheet);
    for (i, x) in simulation.world().get::<&mut Vertices>(body.entity()).unwrap().position.iter_mut().enumerate() {
        x.z += 0.05 * (37.7 * i as f64).sin() * x.x * (20.0 - x.x) * 0.01;
    }
    let (mut fallbacks, mut worst) = (0, 0.0_f64);
    for _ in 0..20 {
        let fell_back = simulation.step(1.0).unwrap().bodies[0].fell_back;
        fallbacks += usize::from(fell_back);
        let b = balance(&mut simulation, body);
        worst = worst.max(b.imbalance().abs() / scale(&b));
    }
    let b = balance(&mut simulation, body);
    println!("{fallbacks} {worst:e} {b:?}");
    // The sheet buckles within a step or two, where Gauss's rule is off by 2e-9. Reactions from another tangent than that of
    // the solve are off by 6e-4.
    assert!(fallbacks > 5 && worst < 1e-8, "{fallbacks} fallbacks, {worst:e}");
}
