//! The energy audit of what moves a body by force: rigid jaws, moving obstacles, and steps that do not go all of their way.

use glam::{DQuat, DVec3};
use rhexis::components::{
    Bending, Contact, Curve, Damping, Drag, EnergyAudit, EnergyBalance, Fibres, Grip, Grips, Hold, Jaws, Material,
    Path, Pose, Shape, Tearing,
};
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::settings::Settings;
use rhexis::simulation::{Grasp, Simulation, Solid};
use rhexis::storage::{Attached, BodyId, Vertices};

fn sheet(is_planar: bool) -> Membrane {
    let mesh = generate::grid(10.0, 10.0, 10, 10).unwrap();
    let sheet = Membrane::new("sheet", mesh, Material::allard_2009());
    let members = Attached::new(sheet.select(|p| p.x == 0.0).into_iter().map(|row| (row, DVec3::ZERO)));
    let hold = Hold { name: "left".into(), members, axes: [true; 3], curve: Curve::constant(0.0) };
    let sheet = sheet.hold(hold).with(Damping { time: 0.1 }).with(Drag { coefficient: 1e-4 });
    let sheet = sheet.with(EnergyAudit::default());
    if is_planar { sheet.planar() } else { sheet.with(Bending { stiffness: Some(1e-3) }) }
}

fn simulation() -> Simulation {
    Simulation::new(Settings { threads: 1, ..Settings::default() }).unwrap()
}

fn balance(simulation: &mut Simulation, body: BodyId) -> EnergyBalance {
    simulation.energy_balance(body).unwrap().unwrap()
}

/// Rounding of the terms of some hundred triangles over a hundred steps.
const CLOSED: f64 = 1e-11;

#[test]
fn rigid_jaws_of_a_script_do_their_work() {
    for is_planar in [true, false] {
        let mut simulation = simulation();
        let grip = Grip {
            name: "jaws".into(),
            from: 0.0,
            until: 80.0,
            material_point: DVec3::new(10.0, 5.0, 0.0),
            near_tip: None,
            jaws: Jaws { radius: 1.5, ..Jaws::default() },
            path: Path { points: vec![(0.0, DVec3::ZERO), (60.0, DVec3::new(1.0, 0.2, 0.0))] },
            turns: Path::default(),
        };
        let body = simulation.spawn(sheet(is_planar).with(Grips::new(vec![grip]))).unwrap();
        for _ in 0..100 {
            simulation.step(1.0).unwrap();
            let b = balance(&mut simulation, body);
            assert!(b.relative_imbalance() < CLOSED, "{b:?}");
        }
        let b = balance(&mut simulation, body);
        assert!(b.work_of_jaws > 0.0 && b.work_of_jaws > 0.5 * b.damping, "{b:?}");
    }
}

#[test]
fn jaws_that_turn_and_let_go_do_their_work() {
    for force_limit in [None, Some(0.02)] {
        let mut simulation = simulation();
        let body = simulation.spawn(sheet(false)).unwrap();
        let jaws = Jaws { radius: 1.5, force_limit, ..Jaws::default() };
        let at = DVec3::new(10.0, 5.0, 0.0);
        let forceps = simulation.spawn_forceps("forceps", jaws, Pose::at(at)).unwrap();
        simulation.close_forceps(forceps, body, &Grasp::Nearest { reach: 1.0 }).unwrap();
        let to = Pose { position: at + DVec3::new(0.5, 0.0, 1.0), orientation: DQuat::from_rotation_x(1.0) };
        simulation.move_forceps(forceps, to, 40.0).unwrap();
        for _ in 0..60 {
            simulation.step(1.0).unwrap();
            let b = balance(&mut simulation, body);
            assert!(b.relative_imbalance() < CLOSED, "{force_limit:?}: {b:?}");
        }
        assert!(balance(&mut simulation, body).work_of_jaws > 0.0);
        let is_open = simulation.forceps(forceps).unwrap().body.is_none();
        assert_eq!(is_open, force_limit.is_some());
    }
}

#[test]
fn jaws_in_static_solves_do_their_work() {
    let mut simulation = simulation();
    let body = simulation.spawn(sheet(true)).unwrap();
    let at = DVec3::new(10.0, 5.0, 0.0);
    let forceps = simulation.spawn_forceps("forceps", Jaws { radius: 1.5, ..Jaws::default() }, Pose::at(at)).unwrap();
    simulation.close_forceps(forceps, body, &Grasp::Nearest { reach: 1.0 }).unwrap();
    simulation.settle(0.0, 1e-11).unwrap();
    simulation.move_forceps(forceps, Pose::at(at + DVec3::X), 10.0).unwrap();
    (0..10).for_each(|_| _ = simulation.settle(1.0, 1e-11).unwrap());
    let b = balance(&mut simulation, body);
    // The hold stands still, and what jaws put in is stored, by the trapezoidal rule; imbalances of 1e-11 of the largest force are left.
    assert!(b.work_of_holds == 0.0 && b.work_of_jaws > 0.99 * b.stored.elastic, "{b:?}");
    assert!(b.relative_imbalance() < 1e-9, "{b:?}");
}

/// A ball that is pushed through a clamped skin until that tears, in steps long enough for vertices to have to be put outside.
#[test]
fn putting_tissue_outside_a_moving_obstacle_is_a_term_of_its_own() {
    let mut simulation = simulation();
    let skin = Membrane::new("skin", generate::disc(15.0, 500).unwrap(), Material::isotropic(1.0, 0.4, 0.2));
    let rim = skin.select(|p| p.length() > 14.99);
    let members = Attached::new(rim.into_iter().map(|row| (row, DVec3::ZERO)));
    let tearing =
        Tearing { strength_across_fibres: 0.35, strength_along_fibres: 0.35, may_initiate: true, ..Tearing::default() };
    let skin = skin
        .hold(Hold { name: "rim".into(), members, axes: [true; 3], curve: Curve::constant(0.0) })
        .with(tearing)
        .with(Damping { time: 2.0 })
        .with(Drag { coefficient: 1e-4 })
        .with(Contact { stiffness: None, friction: 0.2, ..Contact::default() })
        .with(EnergyAudit::default());
    let body = simulation.spawn(skin).unwrap();
    let shape = Shape::Sphere { centre: DVec3::new(0.3, 0.1, -3.01), radius: 3.0 };
    simulation
        .spawn_obstacle(Solid::new(shape).path(Path { points: vec![(0.0, DVec3::ZERO), (500.0, DVec3::Z * 20.0)] }))
        .unwrap();
    let mut any_vertex_projected = false;
    for _ in 0..200 {
        let report = simulation.step(5.0).unwrap();
        any_vertex_projected |= report.bodies[0].any_vertex_projected;
        let b = balance(&mut simulation, body);
        // Quadrature of the true work of triangles that spring open far in one step.
        assert!(b.relative_imbalance() < 1e-5, "{:e}: {b:?}", b.relative_imbalance());
    }
    let b = balance(&mut simulation, body);
    println!("{b:?}");
    assert!(any_vertex_projected && b.unbalanced != 0.0, "{b:?}");
}

/// A crumpled sheet that nothing holds: its steps go only a part of their way, or some of its vertices are relaxed locally.
#[test]
fn steps_that_do_not_go_the_solves_way_close_their_balance() {
    let mut simulation = simulation();
    let mesh = generate::grid(10.0, 10.0, 8, 8).unwrap();
    let sheet = Membrane::new("crumpled", mesh, Material { thickness: 0.015, ..Material::allard_2009() });
    let body = simulation.spawn(sheet.fibres(Fibres::at_degrees(30.0)).with(EnergyAudit::default())).unwrap();
    for (v, x) in simulation.entity_mut::<&mut Vertices>(body).unwrap().position.iter_mut().enumerate() {
        let phase = v as f64;
        *x += DVec3::new((7.1 * phase).sin(), (3.3 * phase).sin(), (5.7 * phase).sin()) * 5.0;
    }
    let mut parts = 0;
    for _ in 0..25 {
        let report = &simulation.step(20.0).unwrap().bodies[0];
        parts += u32::from(report.any_substep_limited || report.relaxed_vertices > 0);
        let b = balance(&mut simulation, body);
        // Quadrature along the ways of triangles that are turned over.
        assert!(b.relative_imbalance() < 1e-4, "{:e}: {b:?}", b.relative_imbalance());
    }
    let b = balance(&mut simulation, body);
    assert!(parts > 0 && b.unbalanced != 0.0, "{parts} steps: {b:?}");
}

/// A spike that hangs on a sheet by one side, drawn out tenfold: one solve would whip it about and create energy. It alone finds its own
/// way in halves of the step, and nothing goes a part of its way.
#[test]
fn a_spike_at_an_edge_holds_nobody_up() {
    let mut simulation = simulation();
    let mut mesh = generate::grid(10.0, 10.0, 20, 20).unwrap();
    let [a, b] = [10, 11];
    let tip = mesh.positions.len() as u32;
    let middle = (mesh.positions[a] + mesh.positions[b]) * 0.5;
    mesh.positions.push(middle - DVec3::Y * 0.15);
    mesh.triangles.push([b as u32, a as u32, tip]);
    let sheet = Membrane::new("sheet", mesh, Material { thickness: 0.015, ..Material::allard_2009() });
    let body = simulation.spawn(sheet.with(EnergyAudit::default())).unwrap();
    simulation.entity_mut::<&mut Vertices>(body).unwrap().position[tip as usize] += DVec3::new(1.5, -0.5, 0.8);
    let mut relaxed = 0;
    for _ in 0..25 {
        let report = simulation.step(20.0).unwrap();
        assert!(report.rolled_back <= 1 && !report.bodies[0].any_substep_limited, "{report:?}");
        relaxed = relaxed.max(report.bodies[0].relaxed_vertices);
        let b = balance(&mut simulation, body);
        // Quadrature along the way of the spike, which is turned over.
        assert!(b.relative_imbalance() < 1e-4, "{:e}: {b:?}", b.relative_imbalance());
    }
    // Itself and what is around it, of 442.
    assert!((1..=24).contains(&relaxed), "{relaxed} vertices");
    let (edge, spike) = {
        let vertices = simulation.world().get::<&Vertices>(body.entity()).unwrap();
        let at = |v: usize| vertices.position[v];
        (at(a).distance(at(b)), at(a).distance(at(tip as usize)))
    };
    // It is back in shape: 0.5 mm and 0.29 mm at rest.
    assert!((edge - 0.5).abs() < 0.05 && (spike - 0.292).abs() < 0.05, "{edge} {spike}");
}
