//! What can be read after a step, or a static solve, that was undone is what was there before; and no order of calls panics.

use crate::common::Square;
use glam::{DQuat, DVec3};
use rhexis::components::{
    Bending, Contact, Curve, EnergyAudit, Forces, Gravity, Grip, Grips, Hold, Jaws, Material, Path, PointLoad,
    PointLoads, Shape, TearDecisions,
};
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::schedule::Place;
use rhexis::settings::Settings;
use rhexis::simulation::{DebugLines, Haptics, Simulation, Solid};
use rhexis::snapshot::Snapshot;
use rhexis::storage::{Attached, BodyId, Tips};

fn simulation() -> Simulation {
    Simulation::new(Settings { threads: 1, ..Settings::default() }).unwrap()
}

/// A sheet drawn out at one edge, in rigid jaws at another place, on a plane.
fn sheet() -> Membrane {
    let mesh = generate::grid(4.0, 3.0, 8, 6).unwrap();
    let sheet = Membrane::new("sheet", mesh, Material::allard_2009());
    let members = Attached::new(sheet.select(|p| p.x == 0.0).into_iter().map(|row| (row, DVec3::NEG_X)));
    let curve = Curve::ramp(10.0, 0.2).unwrap();
    let grip = Grip {
        name: "jaws".into(),
        from: 0.0,
        until: f64::INFINITY,
        material_point: DVec3::new(4.0, 1.5, 0.0),
        near_tip: None,
        jaws: Jaws { radius: 0.6, ..Jaws::default() },
        path: Path { points: vec![(0.0, DVec3::ZERO), (10.0, DVec3::new(0.2, 0.1, 0.0))] },
        turns: Path::default(),
    };
    sheet
        .hold(Hold { name: "edge".into(), members, axes: [true; 3], curve })
        .with(Grips::new(vec![grip]))
        .with(Gravity { acceleration: DVec3::ZERO })
        .with(Contact::default())
        .with(EnergyAudit::default())
}

/// All that an outsider can read, as text: equal text is equal bits.
fn readings(simulation: &mut Simulation, body: BodyId) -> String {
    let jaws: Vec<[DVec3; 2]> = {
        let grips = simulation.world().get::<&Grips>(body.entity());
        grips.map_or(Vec::new(), |grips| grips.pinches.iter().map(|pinch| [pinch.force, pinch.torque]).collect())
    };
    let criterion = simulation.world().get::<&Tips>(body.entity()).map_or(Vec::new(), |tips| tips.criterion.clone());
    let decisions =
        simulation.world().get::<&TearDecisions>(body.entity()).map_or(Vec::new(), |found| found.tips.clone());
    let read = (
        simulation.reactions(body),
        jaws,
        simulation.contact_forces(body),
        (criterion, decisions),
        simulation.energies(body),
        simulation.energy_balance(body),
        simulation.time(),
    );
    format!("{read:?}")
}

/// The state as bytes would give it back; in builds without bytes as it is kept in memory.
fn read_back(simulation: &Simulation) -> Option<Snapshot> {
    #[cfg(feature = "snapshot")]
    return Snapshot::from_bytes(&simulation.snapshot().to_bytes().ok()?).ok();
    #[cfg(not(feature = "snapshot"))]
    return Some(simulation.snapshot());
}

type Spoil = fn(&mut Simulation, BodyId) -> bool;

/// What makes a step or a static solve fail, and is taken away again.
const SPOILS: [(&str, Spoil); 5] = [
    ("a step of 1e-200 ms", |simulation, _| simulation.step(1e-200).unwrap().has_failed),
    ("gravity beyond all numbers", |simulation, body| {
        simulation.entity_mut::<&mut Gravity>(body).unwrap().acceleration = DVec3::X * 1e200;
        let has_failed = simulation.step(1.0).unwrap().has_failed;
        simulation.entity_mut::<&mut Gravity>(body).unwrap().acceleration = DVec3::ZERO;
        has_failed
    }),
    ("a force that is no number", |simulation, _| {
        let spoil = |world: &mut hecs::World, _: &_| {
            world.query_mut::<&mut Forces>().into_iter().for_each(|forces| forces.nodal[7].x = f64::NAN);
            1
        };
        simulation.insert_system(Place::After("contact"), "spoil", spoil).unwrap();
        let has_failed = simulation.step(1.0).unwrap().has_failed;
        simulation.remove_system("spoil").unwrap();
        has_failed
    }),
    ("a static solve under infinite gravity", |simulation, body| {
        simulation.entity_mut::<&mut Gravity>(body).unwrap().acceleration = DVec3::X * 1e200;
        let has_failed = simulation.settle(1.0, 1e-9).is_err();
        simulation.entity_mut::<&mut Gravity>(body).unwrap().acceleration = DVec3::ZERO;
        has_failed
    }),
    ("a linear answer to a load of 1e300 N", |simulation, body| {
        let load = PointLoad { rows: vec![20], force: DVec3::X * 1e300, curve: Curve::constant(1.0) };
        simulation.world_mut().insert_one(body.entity(), PointLoads { groups: vec![load] }).unwrap();
        let has_failed = simulation.linear_response(1.0).is_err();
        simulation.world_mut().remove_one::<PointLoads>(body.entity()).unwrap();
        has_failed
    }),
];

#[test]
fn what_is_read_after_a_failure_is_what_was_there_before() {
    for (what, spoil) in SPOILS {
        let mut simulation = simulation();
        let body = simulation.spawn(sheet()).unwrap();
        let plane = Shape::Plane { point: DVec3::NEG_Z * 0.01, normal: DVec3::Z };
        let up = Path { points: vec![(0.0, DVec3::ZERO), (10.0, DVec3::Z * 0.1)] };
        simulation.spawn_obstacle(Solid::new(plane).path(up)).unwrap();
        (0..5).for_each(|_| _ = simulation.step(1.0).unwrap());
        let before = readings(&mut simulation, body);
        assert!(!before.contains("NaN") && simulation.contact_forces(body).unwrap().len() == 1, "{before}");
        assert!(spoil(&mut simulation, body), "{what} does not fail");
        assert_eq!(readings(&mut simulation, body), before, "{what}");
        let report = format!("{:?}", simulation.report().bodies);
        assert!(!report.contains("NaN") && !report.contains("inf,"), "{what}: {report}");
        assert!(read_back(&simulation).is_some(), "{what}");
        let frame = format!("{:?}", simulation.frame());
        assert!(!frame.contains("NaN"), "{what}");
        // And it goes on.
        assert!(!simulation.step(1.0).unwrap().has_failed, "{what}");
    }
}

#[test]
fn tips_keep_their_criterion_through_a_failed_step() {
    let mut run = Square::new([12, 10], 60.0).spawn(Settings { threads: 1, ..Settings::default() });
    (0..10).for_each(|_| _ = run.simulation.step(10.0).unwrap());
    let before = readings(&mut run.simulation, run.body);
    assert!(before.contains("TearDecision"));
    run.simulation.world_mut().insert_one(run.body.entity(), Gravity { acceleration: DVec3::X * 1e200 }).unwrap();
    assert!(run.simulation.step(10.0).unwrap().has_failed);
    assert_eq!(readings(&mut run.simulation, run.body), before);
}

#[test]
fn no_order_of_calls_panics_on_a_body_that_bends() {
    type Call = fn(&mut Simulation, BodyId, &mut Haptics);
    let calls: [Call; 10] = [
        |simulation, body, haptics| {
            let coupling = simulation.coupling_of_pins(body, "needle").unwrap();
            let model = haptics.model(simulation, body, &coupling).unwrap();
            assert!(model.stiffness.is_finite() && model.stiffness.determinant() > 0.0);
        },
        |simulation, body, _| _ = simulation.cut(body, &[DVec3::new(0.0, 1.3, 0.0), DVec3::new(1.4, 1.3, 0.0)]),
        |simulation, _, _| simulation.restore(&simulation.snapshot()).unwrap(),
        |simulation, _, _| {
            let snapshot = read_back(simulation).unwrap();
            simulation.restore(&snapshot).unwrap();
        },
        |simulation, body, _| simulation.reorder(body).unwrap(),
        |simulation, body, _| simulation.teleport(body, DQuat::from_rotation_x(0.3), DVec3::Y).unwrap(),
        |simulation, _, _| _ = simulation.step(1.0).unwrap(),
        |simulation, _, _| _ = simulation.settle(0.0, 1e-6),
        |simulation, _, _| _ = simulation.linear_response(1.0),
        |simulation, body, _| {
            simulation.energies(body).unwrap();
            simulation.reactions(body).unwrap();
            let mut lines = Vec::new();
            simulation.debug_lines(body, &DebugLines::all(0.1), &mut lines).unwrap();
            simulation.view(body).unwrap().positions_before(0.5, &mut Vec::new());
            simulation.frame();
        },
    ];
    for first in 0..calls.len() {
        for second in 0..calls.len() {
            let mut simulation = simulation();
            let sheet = Membrane::new("sheet", generate::grid(4.0, 4.0, 4, 4).unwrap(), Material::allard_2009());
            let body = simulation.spawn(sheet.with(Bending { stiffness: Some(1e-2) })).unwrap();
            let keys = simulation.view(body).unwrap().vertex_keys.to_vec();
            simulation.pin(body, "needle", &[keys[22], keys[23], keys[17]]).unwrap();
            let mut haptics = Haptics::new(10.0);
            for call in [first, second, 0, first, 0] {
                calls[call](&mut simulation, body, &mut haptics);
            }
        }
    }
}
