//! Tools at run time: forceps that the host moves, closes and opens, a needle and a blade.

use glam::{DQuat, DVec3};
use rhexis::components::{
    Curve, DecidedBy, Forces, Grips, Hold, Holds, Jaws, Material, PointLoad, PointLoads, Pose, PreStretch, Reactions,
    Slip, Tearing,
};
use rhexis::event::EventKind;
use rhexis::generate;
use rhexis::math::Sym2;
use rhexis::membrane::Membrane;
use rhexis::settings::{Advanced, LinearParams, Settings};
use rhexis::simulation::{Grasp, Simulation, ToolError};
use rhexis::storage::{Attached, Topology, Triangles, Vertices, validate};

const SIDE: f64 = 10.0;
const CENTRE: DVec3 = DVec3::new(5.0, 5.0, 0.0);

/// A square of 10 mm, its left edge clamped.
fn square(cells: usize) -> Membrane {
    let mesh = generate::grid(SIDE, SIDE, cells, cells).unwrap();
    let sheet = Membrane::new("sheet", mesh, Material::allard_2009());
    let members = Attached::new(sheet.select(|p| p.x == 0.0).into_iter().map(|row| (row, DVec3::ZERO)));
    sheet.hold(Hold { name: "left".into(), members, axes: [true; 3], curve: Curve::constant(0.0) })
}

fn rigid(radius: f64) -> Jaws {
    Jaws { radius, ..Jaws::default() }
}

/// The pose to which the jaws at the centre go: pulled, lifted and turned.
fn pulled() -> Pose {
    let turn = DQuat::from_rotation_z(0.2) * DQuat::from_rotation_x(0.3);
    Pose { position: CENTRE + DVec3::new(0.4, -0.1, 0.3), orientation: turn }
}

/// Statics: what acts on the sheet from outside adds up to nothing, forces and torques, for jaws of any stiffness. The tolerance is
/// the solve's residual of 1e-12 over some hundred vertices, with the reserve of a thousand.
#[test]
fn reactions_balance_the_loads() {
    for stiffness in [None, Some(1.0), Some(1e3)] {
        // Taut, so that it carries loads across.
        let sheet = square(10);
        let members = Attached::new(sheet.select(|p| p.x == SIDE).into_iter().map(|row| (row, DVec3::X)));
        let right = Hold { name: "right".into(), members, axes: [true; 3], curve: Curve::constant(0.02) };
        let sheet = sheet.hold(right).with(PreStretch { strain: Sym2::new(0.05, 0.05, 0.0) });
        let rows = sheet.select(|p| p.x == 8.0);
        let force = DVec3::new(2e-4, 1e-4, -3e-4);
        let load = PointLoad { rows: rows.clone(), force, curve: Curve::constant(1.0) };
        let mut simulation = Simulation::new(Settings::default()).unwrap();
        let body = simulation.spawn(sheet.with(PointLoads { groups: vec![load] })).unwrap();
        let jaws = Jaws { stiffness, ..rigid(1.6) };
        let forceps = simulation.spawn_forceps("forceps", jaws, Pose::at(CENTRE)).unwrap();
        simulation.close_forceps(forceps, body, &Grasp::Nearest { reach: 0.1 }).unwrap();
        simulation.move_forceps(forceps, pulled(), 5.0).unwrap();
        for _ in 0..5 {
            simulation.settle(1.0, 1e-12).unwrap();
        }
        let tool = simulation.forceps(forceps).unwrap();
        assert_eq!(tool.motion.at(simulation.time()), pulled());
        let world = simulation.world();
        let (holds, reactions) =
            (world.get::<&Holds>(body.entity()).unwrap(), world.get::<&Reactions>(body.entity()).unwrap());
        let vertices = world.get::<&Vertices>(body.entity()).unwrap();
        let groups = holds.groups.iter().zip(&reactions.groups);
        let held = groups.flat_map(|(hold, forces)| hold.members.rows().iter().zip(forces));
        let at = |row: u32| vertices.position[row as usize];
        let all = held.map(|(&row, &f)| (at(row), f)).chain(rows.iter().map(|&row| (at(row), force)));
        let (mut sum, mut torque) = (tool.force, tool.torque + pulled().position.cross(tool.force));
        for (point, force) in all {
            sum += force;
            torque += point.cross(force);
        }
        let scale = tool.force.length();
        assert!(scale > 0.1, "{scale}");
        assert!(sum.length() < 1e-9 * scale, "{stiffness:?}: {:e}", sum.length() / scale);
        assert!(torque.length() < 1e-9 * scale * SIDE, "{stiffness:?}: {:e}", torque.length() / scale / SIDE);
        assert!(tool.torque.length() > 1e-3, "the jaws' turn takes a torque");
    }
}

/// A step with jaws of any stiffness is stable (a retry in halves is one that turns a sheet far), and the stiffer they
/// are the nearer it is to a constraint.
#[test]
fn every_stiffness_is_stable_and_leads_to_the_constraint() {
    let run = |stiffness: Option<f64>, settings: Settings| {
        let mut simulation = Simulation::new(settings).unwrap();
        let body = simulation.spawn(square(20)).unwrap();
        let jaws = Jaws { stiffness, ..rigid(1.0) };
        let forceps = simulation.spawn_forceps("forceps", jaws, Pose::at(CENTRE)).unwrap();
        simulation.close_forceps(forceps, body, &Grasp::Point(CENTRE)).unwrap();
        simulation.move_forceps(forceps, pulled(), 50.0).unwrap();
        for _ in 0..200 {
            let report = simulation.step(1.0).unwrap();
            assert!(!report.has_failed);
        }
        simulation.forceps(forceps).unwrap().force
    };
    // Halves are the same for every stiffness; where further solves end differs by what the jaws store.
    let loose = Settings { advanced: Advanced { newton_corrections: 0, ..Advanced::default() }, ..Settings::default() };
    let tight =
        Settings { advanced: Advanced { linear: LinearParams::by_residual(1e-12, 20_000), ..loose.advanced }, ..loose };
    let exact = run(None, tight);
    assert!(exact.length() > 0.1);
    let mut last = f64::INFINITY;
    for stiffness in [1.0, 1e2, 1e4, 1e6] {
        let error = run(Some(stiffness), tight).distance(exact) / exact.length();
        assert!(error < 0.1 * last, "{stiffness:e} N/mm: {error:e} after {last:e}");
        last = error;
    }
    // By one loose solve per step the force of a stiff spring, its stiffness times a tiny way, is off by more than a reaction.
    for (stiffness, limit) in [(None, 1e-3), (Some(1e6), 0.03), (Some(1e9), 0.03), (Some(1e12), 0.03)] {
        let error = run(stiffness, loose).distance(exact) / exact.length();
        assert!(error < limit, "{stiffness:?} N/mm: {error:e}");
    }
}

/// What is held follows the rigid motion of the jaws, and so does what cuts and refinement put between.
#[test]
fn what_is_held_follows_through_cuts() {
    let mut simulation = Simulation::new(Settings::default()).unwrap();
    let body = simulation.spawn(square(20).with(Tearing { radius: 1.5, ..Tearing::default() })).unwrap();
    let forceps = simulation.spawn_forceps("forceps", rigid(1.6), Pose::at(CENTRE)).unwrap();
    let count = simulation.close_forceps(forceps, body, &Grasp::Nearest { reach: 1e-6 }).unwrap();
    let check = |simulation: &Simulation, pose: Pose| {
        let world = simulation.world();
        let (grips, vertices) =
            (world.get::<&Grips>(body.entity()).unwrap(), world.get::<&Vertices>(body.entity()).unwrap());
        let held = &grips.pinches[0].held;
        for &row in held.rows() {
            // The rest shape is flat, and new vertices are put in linearly: only roundings.
            let wanted = pose.carry(vertices.rest_position[row as usize] - CENTRE);
            assert!(vertices.position[row as usize].distance(wanted) < 1e-12);
        }
        held.rows().len()
    };
    simulation.move_forceps(forceps, pulled(), 10.0).unwrap();
    simulation.step(10.0).unwrap();
    assert_eq!(check(&simulation, pulled()), count);
    simulation.cut(body, &[DVec3::new(10.0, 5.03, 0.0), DVec3::new(4.3, 5.21, 0.0)]).unwrap();
    let back = Pose { position: CENTRE, orientation: DQuat::from_rotation_y(0.1) };
    simulation.move_forceps(forceps, back, 10.0).unwrap();
    simulation.step(10.0).unwrap();
    assert!(check(&simulation, back) > count, "the cut adds nothing to the pinch");
    simulation.reorder(body).unwrap();
    simulation.step(10.0).unwrap();
    check(&simulation, back);

    // A sheet that nothing pulls any more comes to rest.
    simulation.open_forceps(forceps).unwrap();
    assert_eq!(simulation.forceps(forceps).unwrap().force, DVec3::ZERO);
    assert!(simulation.world().get::<&Grips>(body.entity()).unwrap().pinches.is_empty());
}

#[test]
fn beyond_the_limit_tissue_slides_or_is_let_go() {
    const LIMIT: f64 = 0.05;
    for slip in [Slip::Slide, Slip::LetGo] {
        let mut simulation = Simulation::new(Settings::default()).unwrap();
        let body = simulation.spawn(square(10)).unwrap();
        let jaws = Jaws { radius: 1.2, stiffness: Some(5.0), force_limit: Some(LIMIT), slip };
        let forceps = simulation.spawn_forceps("forceps", jaws, Pose::at(CENTRE)).unwrap();
        simulation.close_forceps(forceps, body, &Grasp::Point(CENTRE)).unwrap();
        simulation.move_forceps(forceps, Pose::at(CENTRE + DVec3::X * 2.0), 400.0).unwrap();
        let mut events = Vec::new();
        let mut peak: f64 = 0.0;
        for _ in 0..500 {
            simulation.step(1.0).unwrap();
            peak = peak.max(simulation.forceps(forceps).unwrap().force.length());
            events.extend(simulation.drain_events().map(|event| event.kind));
        }
        // One step's motion of 5 µm by 5 N/mm at the most above the limit.
        assert!((LIMIT..LIMIT + 0.026).contains(&peak), "{slip:?}: {peak}");
        let is_let_go = slip == Slip::LetGo;
        let told = |kind: &EventKind| matches!(kind, EventKind::Slipped { jaws, is_open, .. } if jaws == "forceps" && *is_open == is_let_go);
        assert!(events.first().is_some_and(told), "{slip:?}: {events:?}");
        let tool = simulation.forceps(forceps).unwrap();
        assert_eq!(tool.body.is_none(), is_let_go);
        let rest = tool.force.length();
        assert!(is_let_go || (0.5 * LIMIT..=1.01 * LIMIT).contains(&rest), "{rest}");
        // Open forceps close again.
        assert_eq!(simulation.close_forceps(forceps, body, &Grasp::Point(CENTRE)).is_ok(), is_let_go);
    }
}

#[test]
fn jaws_close_by_ray_by_nearest_point_and_by_region_or_say_why_not() {
    let mut simulation = Simulation::new(Settings::default()).unwrap();
    let body = simulation.spawn(square(10)).unwrap();
    let pose = Pose::at(DVec3::new(5.0, 5.0, 3.0));
    let forceps = simulation.spawn_forceps("forceps", rigid(0.5), pose).unwrap();
    let far = simulation.close_forceps(forceps, body, &Grasp::Nearest { reach: 2.9 });
    assert!(matches!(far, Err(ToolError::NothingThere { .. })));
    assert_eq!(simulation.close_forceps(forceps, body, &Grasp::Nearest { reach: 3.1 }), Ok(1));
    let again = simulation.close_forceps(forceps, body, &Grasp::Nearest { reach: 3.1 });
    assert!(matches!(again, Err(ToolError::Closed { .. })));
    simulation.open_forceps(forceps).unwrap();
    let ray = Grasp::Ray { origin: pose.position, direction: DVec3::new(1.0, 0.0, -3.0), reach: 10.0 };
    assert_eq!(simulation.close_forceps(forceps, body, &ray), Ok(1));
    let held = simulation.world().get::<&Grips>(body.entity()).unwrap().pinches[0].held.rows()[0];
    let rest = simulation.world().get::<&Vertices>(body.entity()).unwrap().rest_position[held as usize];
    assert_eq!(rest, DVec3::new(6.0, 5.0, 0.0));
    simulation.open_forceps(forceps).unwrap();
    let keys: Vec<_> =
        (60..70).filter_map(|row| simulation.world().get::<&Vertices>(body.entity()).unwrap().key(row)).collect();
    assert_eq!(simulation.close_forceps(forceps, body, &Grasp::Vertices(keys)), Ok(10));
    simulation.step(1.0).unwrap();
    // A body that is taken away, or a tool, leaves nothing behind.
    simulation.despawn(body).unwrap();
    simulation.step(1.0).unwrap();
    let body = simulation.spawn(square(4)).unwrap();
    simulation.close_forceps(forceps, body, &Grasp::Point(CENTRE)).unwrap();
    simulation.despawn(forceps).unwrap();
    assert!(simulation.world().get::<&Grips>(body.entity()).unwrap().pinches.is_empty());
    simulation.step(1.0).unwrap();
    assert_eq!(simulation.open_forceps(forceps), Err(ToolError::NoSuchForceps));

    let bad = Pose { orientation: DQuat::from_xyzw(0.0, 0.0, 0.0, 2.0), ..pose };
    assert!(matches!(simulation.spawn_forceps("bad", rigid(0.1), bad), Err(ToolError::BadPose { .. })));
    for jaws in [
        rigid(f64::NAN),
        Jaws { stiffness: Some(0.0), ..rigid(1.0) },
        Jaws { force_limit: Some(1.0), slip: Slip::Slide, ..rigid(1.0) },
    ] {
        assert!(matches!(simulation.spawn_forceps("bad", jaws, pose), Err(ToolError::OutOfRange { .. })));
    }
}

#[test]
fn a_needle_punctures_and_a_blade_cuts_on() {
    let mut simulation = Simulation::new(Settings::default()).unwrap();
    let body = simulation.spawn(square(20).with(Tearing { radius: 1.5, ..Tearing::default() })).unwrap();
    let cut = simulation.puncture(body, CENTRE + DVec3::Z * 0.2, DVec3::new(1.0, 1.0, 0.5), 1.0).unwrap();
    let ends = [cut.path[0], cut.path[cut.path.len() - 1]];
    let along = DVec3::new(1.0, 1.0, 0.0).normalize() * 0.5;
    assert!(ends[0].distance(CENTRE - along) < 1e-9 && ends[1].distance(CENTRE + along) < 1e-9, "{ends:?}");
    assert_eq!(cut.tips.len(), 2);
    assert!(simulation.puncture(body, CENTRE + DVec3::Z * 2.0, DVec3::X, 1.0).is_err());

    // Out of reach, then down at x = 2 and along a quarter of a circle in steps that are shorter than the shortest cut.
    let blade = simulation.spawn_blade(0.2, 0.4).unwrap();
    let point = |angle: f64| DVec3::new(8.0 - 3.0 * angle.cos(), 8.0 - 3.0 * angle.sin(), 0.1);
    assert_eq!(simulation.draw_blade(blade, body, point(0.0) + DVec3::Z), Ok(None));
    let (mut count, mut length, mut end) = (0, 0.0, None);
    for i in 0..=60 {
        if let Some(cut) = simulation.draw_blade(blade, body, point(f64::from(i) * 0.02)).unwrap() {
            assert!(end.is_none_or(|end: DVec3| end.distance(cut.path[0]) < 1e-9), "a gap between two strokes");
            length += cut.path.windows(2).map(|w| w[0].distance(w[1])).sum::<f64>();
            end = cut.path.last().copied();
            count += 1;
        }
    }
    // An arc of 3.6 mm in chords of 0.4 to 0.46 mm; what is left of it is saved up.
    assert!(count >= 7 && (length - 3.6).abs() < 0.5, "{count} cuts, {length} mm");
    // One tear: begun by the first cut, which has two ends, led on by the others.
    let (mut started, mut led, mut way) = (Vec::new(), Vec::new(), None);
    for event in simulation.drain_events() {
        match event.kind {
            EventKind::Started { tip, .. } => started.push(tip),
            EventKind::Advanced { tip, from, to, by, .. } => {
                assert!(
                    by == DecidedBy::Blade && way.is_none_or(|way| way == from),
                    "{by}: from {from}, after {way:?}"
                );
                (led, way) = ([led, vec![tip]].concat(), Some(to));
            }
            EventKind::Cut { asked, made, strokes } => {
                assert!((asked - made).abs() < 1e-9 && strokes == 1, "{made} of {asked} mm in {strokes}");
            }
            other => panic!("{other:?}"),
        }
    }
    // Those of the needle came before.
    assert_eq!(started.len(), 4);
    assert!(led.len() >= 6 && led.iter().all(|tip| *tip == started[3]), "{led:?} of {started:?}");
    assert_eq!(way, end);
    let world = simulation.world();
    let (vertices, triangles) =
        (world.get::<&Vertices>(body.entity()).unwrap(), world.get::<&Triangles>(body.entity()).unwrap());
    validate(&vertices, &triangles, &world.get::<&Topology>(body.entity()).unwrap()).unwrap();
    assert!(world.get::<&Forces>(body.entity()).is_ok());
    drop((vertices, triangles));
    simulation.step(1.0).unwrap();
}
