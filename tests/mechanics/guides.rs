//! Holds along any direction, and clamps that a force draws.

use glam::{DQuat, DVec3};
use rhexis::components::{
    Curve, Damping, EnergyAudit, Fibres, Gravity, Guide, Hold, HoldGuides, HoldTurns, Holds, Material, Path, PointLoad,
    PointLoads, Turning,
};
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::settings::{Accuracy, Advanced, Preconditioner, Settings};
use rhexis::simulation::Simulation;
use rhexis::storage::{Attached, BodyId, TriangleMesh, Vertices};

const LENGTH: f64 = 12.0;
const WIDTH: f64 = 5.0;

fn mesh() -> TriangleMesh {
    generate::grid(LENGTH, WIDTH, 12, 5).unwrap()
}

fn hold(rows: Vec<u32>, name: &str, way: DVec3, axes: [bool; 3]) -> Hold {
    let members = Attached::new(rows.into_iter().map(|row| (row, way)));
    Hold { name: name.into(), members, axes, curve: Curve::ramp(10.0, 1.0).unwrap() }
}

fn at(x: f64) -> Vec<u32> {
    let rows = mesh().positions.into_iter().enumerate();
    rows.filter(|(_, p)| p.x == x).map(|(row, _)| row as u32).collect()
}

fn simulation(preconditioner: Preconditioner) -> Simulation {
    Simulation::new(Settings {
        threads: 1,
        advanced: Advanced { preconditioner, ..Settings::new(Accuracy::Accurate).advanced },
        ..Settings::new(Accuracy::Accurate)
    })
    .unwrap()
}

fn positions(simulation: &Simulation, body: BodyId) -> Vec<DVec3> {
    simulation.world().get::<&Vertices>(body.entity()).unwrap().position.clone()
}

fn farthest(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max)
}

/// A strip with slanted fibres, which shears as it is drawn: turned in space with its holds it does the same.
fn strip(turn: DQuat, right: Guide, is_planar: bool) -> Membrane {
    let TriangleMesh { positions, triangles, .. } = mesh();
    let positions = positions.into_iter().map(|p| turn * p).collect();
    let mesh = TriangleMesh { positions, triangles, fibres: None };
    let fibre = turn * DVec3::new(0.8, 0.6, 0.0);
    let material = Material { thickness: 0.1, ..Material::allard_2009() };
    let sheet = Membrane::new("strip", mesh, material).fibres(Fibres::Uniform(fibre)).with(Damping { time: 1.0 });
    let sheet = if is_planar { sheet.planar() } else { sheet.with(rhexis::components::Bending { stiffness: None }) };
    let left = hold(at(0.0), "left", DVec3::ZERO, [true; 3]);
    let right_hold = hold(at(LENGTH), "right", turn * DVec3::new(0.6, 0.0, 0.0), [true; 3]);
    sheet.hold(left).hold(right_hold).with(HoldGuides { list: vec![(1, right)] })
}

/// The strip with what only axes say.
fn straight(axes: [bool; 3], is_planar: bool) -> Membrane {
    let material = Material { thickness: 0.1, ..Material::allard_2009() };
    let sheet = Membrane::new("strip", mesh(), material).fibres(Fibres::Uniform(DVec3::new(0.8, 0.6, 0.0)));
    let sheet = sheet.with(Damping { time: 1.0 });
    let sheet = if is_planar { sheet.planar() } else { sheet.with(rhexis::components::Bending { stiffness: None }) };
    let left = hold(at(0.0), "left", DVec3::ZERO, [true; 3]);
    sheet.hold(left).hold(hold(at(LENGTH), "right", DVec3::new(0.6, 0.0, 0.0), axes))
}

/// Holds along a direction do to a turned body what holds along an axis do to a straight one, in static solves and in steps.
#[test]
fn a_turned_body_with_its_guides_is_the_body_turned() {
    let about_z = DQuat::from_rotation_z(0.7);
    let in_space = DQuat::from_scaled_axis(DVec3::new(0.4, -0.9, 0.6));
    for (turn, is_planar) in [(about_z, true), (in_space, false)] {
        for is_across in [true, false] {
            let x = turn * DVec3::X;
            let y = turn * DVec3::Y;
            let (guide, axes) = if is_across {
                (Guide::Across(x), [true, false, false])
            } else {
                (Guide::Along(y), [true, false, true])
            };
            for is_static in [true, false] {
                let go = |sheet: Membrane| {
                    let mut simulation = simulation(Preconditioner::Auto);
                    let body = simulation.spawn(sheet).unwrap();
                    if is_static {
                        simulation.settle(10.0, 1e-11).unwrap();
                    } else {
                        (0..10).for_each(|_| _ = simulation.step(1.0).unwrap());
                    }
                    (positions(&simulation, body), simulation.reactions(body).unwrap()[1].1)
                };
                let (turned, of_turned) = go(strip(turn, guide.clone(), is_planar));
                let (plain, of_plain) = go(straight(axes, is_planar));
                let back: Vec<DVec3> = turned.iter().map(|p| turn.inverse() * *p).collect();
                let case = (is_planar, is_across, is_static);
                // Static solves come to 1e-11 of the largest force; steps solve to the tolerance of the accurate settings.
                let tolerance = if is_static { 1e-8 } else { 1e-4 };
                assert!(farthest(&back, &plain) < tolerance, "{case:?}: {:e} mm", farthest(&back, &plain));
                let force = of_plain.length();
                let apart = (turn.inverse() * of_turned - of_plain).length();
                assert!(apart < 1e3 * tolerance * force, "{case:?}: {apart:e} of {force} N");
                // The body has moved where it may, and only there.
                let gone =
                    at(LENGTH).into_iter().map(|row| turned[row as usize] - turn * mesh().positions[row as usize]);
                let aside: Vec<f64> = gone.clone().map(|u| u.dot(y).abs()).collect();
                assert!(aside.iter().any(|aside| *aside > 0.01), "{case:?}: {aside:?}");
                gone.for_each(|u| assert!((u.dot(x) - 0.6).abs() < 1e-12, "{case:?}: {u}"));
            }
        }
    }
}

fn clamped(force: DVec3, is_planar: bool) -> Membrane {
    let material = Material { thickness: 0.1, ..Material::allard_2009() };
    let sheet = Membrane::new("strip", mesh(), material).fibres(Fibres::Uniform(DVec3::new(0.8, 0.6, 0.0)));
    let sheet = if is_planar { sheet.planar() } else { sheet };
    let left = hold(at(0.0), "left", DVec3::ZERO, [true; 3]);
    let clamp = hold(at(LENGTH), "clamp", DVec3::ZERO, [true; 3]);
    let guide = Guide::Together { force, curve: Curve::constant(1.0) };
    sheet.hold(left).hold(clamp).with(HoldGuides { list: vec![(1, guide)] })
}

/// A clamp under a force comes to where a prescribed one has that force as its reaction; it does not turn, and its force is told.
#[test]
fn a_clamp_under_a_force_is_a_hold_with_that_reaction() {
    let force = DVec3::new(0.1, 0.03, 0.0);
    for preconditioner in [Preconditioner::Auto, Preconditioner::BlockJacobi] {
        let mut simulation = simulation(preconditioner);
        let body = simulation.spawn(clamped(force, true)).unwrap();
        let iterations = simulation.settle(10.0, 1e-11).unwrap().bodies[0].newton_iterations;
        // Newton's method converges as without a clamp: quadratically.
        assert!(iterations <= 8, "{iterations}");
        let gone = positions(&simulation, body);
        let gone: Vec<DVec3> =
            at(LENGTH).into_iter().map(|row| gone[row as usize] - mesh().positions[row as usize]).collect();
        let way = gone[0];
        // Alike to roundings of 12 mm.
        assert!(gone.iter().all(|u| u.distance(way) < 1e-13), "{gone:?}");
        assert!(way.x > 0.05, "{way}");
        let told = simulation.reactions(body).unwrap();
        assert!((told[1].1 - force).length() < 1e-9 && (told[0].1 + force).length() < 1e-9, "{told:?}");

        let mut prescribed = self::simulation(preconditioner);
        let material = Material { thickness: 0.1, ..Material::allard_2009() };
        let sheet =
            Membrane::new("strip", mesh(), material).fibres(Fibres::Uniform(DVec3::new(0.8, 0.6, 0.0))).planar();
        let left = hold(at(0.0), "left", DVec3::ZERO, [true; 3]);
        let sheet = sheet.hold(left).hold(hold(at(LENGTH), "right", way, [true; 3]));
        let other = prescribed.spawn(sheet).unwrap();
        prescribed.settle(10.0, 1e-11).unwrap();
        let reaction = prescribed.reactions(other).unwrap()[1].1;
        assert!((reaction - force).length() < 1e-9, "{reaction}");
        assert!(farthest(&positions(&simulation, body), &positions(&prescribed, other)) < 1e-8);
    }
}

/// A body that is one clamp is a mass point: v = F·t/m, while gravity acts on it as well.
#[test]
fn a_body_that_is_one_clamp_falls_as_a_point() {
    let rows = (0..mesh().positions.len() as u32).collect();
    let force = DVec3::new(2e-4, 0.0, 1e-4);
    let guide = Guide::Together { force, curve: Curve::constant(1.0) };
    let down = DVec3::new(0.0, 0.0, -9.81e-3);
    let sheet = Membrane::new("plate", mesh(), Material::allard_2009())
        .hold(hold(rows, "all", DVec3::ZERO, [true; 3]))
        .with(HoldGuides { list: vec![(0, guide)] })
        .with(Gravity { acceleration: down })
        .with(EnergyAudit::default());
    // The audit is that of backward Euler, which is exact for a constant force.
    let mut simulation = Simulation::new(Settings { threads: 1, ..Settings::default() }).unwrap();
    let body = simulation.spawn(sheet).unwrap();
    (0..20).for_each(|_| _ = simulation.step(2.0).unwrap());
    let world = simulation.world();
    let vertices = world.get::<&Vertices>(body.entity()).unwrap();
    let mass: f64 = vertices.mass.iter().sum();
    let expected = (force / mass + down) * 40.0;
    assert!(vertices.velocity.iter().all(|v| (*v - expected).length() < 1e-9 * expected.length()), "{expected}");
    drop(vertices);
    // The clamp's work is that of its force; backward Euler dissipates, and says so.
    let balance = simulation.energy_balance(body).unwrap().unwrap();
    assert!(balance.imbalance().abs() < 1e-9 * balance.work(), "{balance:?}");
}

/// A clamp that nothing draws passes on the loads on its vertices, as if they were one.
#[test]
fn loads_on_a_clamp_act_on_all_of_it() {
    let force = DVec3::new(0.1, 0.03, 0.0);
    let corner = at(LENGTH)[0];
    let load = PointLoad { rows: vec![corner], force, curve: Curve::constant(1.0) };
    let settle = |sheet: Membrane| {
        let mut simulation = simulation(Preconditioner::Auto);
        let body = simulation.spawn(sheet).unwrap();
        simulation.settle(10.0, 1e-11).unwrap();
        positions(&simulation, body)
    };
    let by_load = settle(clamped(DVec3::ZERO, true).with(PointLoads { groups: vec![load] }));
    let by_force = settle(clamped(force, true));
    assert!(farthest(&by_load, &by_force) < 1e-8);
}

/// Cut through, a clamp holds both sides; saved and read, it goes on to the same bits.
#[test]
fn a_clamp_keeps_what_is_cut_and_is_saved() {
    let mut simulation = simulation(Preconditioner::Auto);
    let body = simulation.spawn(clamped(DVec3::new(0.05, 0.0, 0.0), true).with(Damping { time: 1.0 })).unwrap();
    simulation.step(1.0).unwrap();
    simulation.cut(body, &[DVec3::new(LENGTH, 2.0, 0.0), DVec3::new(8.0, 2.0, 0.0)]).unwrap();
    let snapshot = simulation.snapshot();
    let step = |simulation: &mut Simulation| {
        (0..5).for_each(|_| _ = simulation.step(1.0).unwrap());
        simulation.hash()
    };
    let hash = step(&mut simulation);
    let mut other = self::simulation(Preconditioner::Auto);
    // Through bytes where the build has them.
    #[cfg(feature = "snapshot")]
    let snapshot = rhexis::snapshot::Snapshot::from_bytes(&snapshot.to_bytes().unwrap()).unwrap();
    other.restore(&snapshot).unwrap();
    assert_eq!(step(&mut other), hash);
    let world = simulation.world();
    let vertices = world.get::<&Vertices>(body.entity()).unwrap();
    let gone = |row: usize| vertices.position[row] - vertices.rest_position[row];
    let ends = (0..vertices.len()).filter(|&row| vertices.rest_position[row].x == LENGTH);
    let ends: Vec<DVec3> = ends.map(gone).collect();
    assert!(ends.len() == 7 && ends.iter().all(|u| u.distance(ends[0]) < 1e-13 && u.x > 0.0), "{ends:?}");
}

/// In equilibrium under a clamp's force, steps of two stages stay there.
#[test]
fn a_clamp_in_equilibrium_stays_there_in_accurate_steps() {
    let mut simulation = Simulation::new(Settings { threads: 1, ..Settings::new(Accuracy::Accurate) }).unwrap();
    let body = simulation.spawn(clamped(DVec3::new(0.05, 0.0, 0.0), true)).unwrap();
    simulation.settle(0.0, 1e-11).unwrap();
    let before = positions(&simulation, body);
    (0..20).for_each(|_| _ = simulation.step(1.0).unwrap());
    // An equilibrium to 1e-11 of the largest force, left by twenty solves to 1e-10 of theirs.
    assert!(farthest(&before, &positions(&simulation, body)) < 1e-8);
}

/// Guides and turns that their holds or the plane contradict are refused, in words that say what to do; nothing is spawned.
#[test]
fn guides_that_contradict_their_holds_are_refused() {
    let along = || Guide::Along(DVec3::X);
    let together = || Guide::Together { force: DVec3::X, curve: Curve::constant(1.0) };
    let turns = |place, vector| {
        let turning = Turning { pivot: DVec3::ZERO, vectors: Path { points: vec![(0.0, vector)] } };
        HoldTurns { list: vec![(place, turning)] }
    };
    let sheet = |axes, guide, planar| {
        let right = hold(at(LENGTH), "right", DVec3::ZERO, axes);
        let sheet = Membrane::new("strip", mesh(), Material::allard_2009()).hold(right);
        let sheet = if planar { sheet.planar() } else { sheet };
        sheet.with(HoldGuides { list: vec![(0, guide)] })
    };
    let cases = [
        (sheet([true; 3], along(), false).with(HoldGuides { list: vec![(1, along())] }), "the place of a hold"),
        (sheet([true, false, true], along(), false), "mark all three"),
        (sheet([true; 3], Guide::Across(DVec3::Z), true), "in x and y"),
        (sheet([true; 3], together(), false).with(turns(0, DVec3::Z)), "does not turn"),
        (sheet([true; 3], along(), false).with(turns(1, DVec3::Z)), "the place of a hold"),
        (sheet([true; 3], along(), true).with(turns(0, DVec3::X)), "about z alone"),
    ];
    let mut simulation = simulation(Preconditioner::Auto);
    for (membrane, wanted) in cases {
        let error = simulation.spawn(membrane).unwrap_err().to_string();
        assert!(error.contains(wanted), "{error}");
    }
    // Nor is a hold taken away from under its guide.
    let body = simulation.spawn(sheet([true; 3], along(), false)).unwrap();
    let error = simulation.set(body, Holds::default()).unwrap_err().to_string();
    assert!(error.contains("HoldGuides: the place of a hold is 0"), "{error}");
    simulation.step(1.0).unwrap();
}
