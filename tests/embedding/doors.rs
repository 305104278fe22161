//! What reaches the engine is judged wherever it comes in: at spawning, by `set`, and at the next call after it was written past them.

use glam::{DMat3, DQuat, DVec3};
use rhexis::components::*;
use rhexis::generate;
use rhexis::math::Sym2;
use rhexis::membrane::Membrane;
use rhexis::schedule::Place;
use rhexis::settings::Settings;
use rhexis::simulation::{Grasp, MotionError, SetError, Simulation, Solid};
use rhexis::storage::{Attached, BodyId, Topology, TriangleMesh, Triangles, VertexKey, Vertices};
use std::sync::Arc;

pub(super) const NAN: DVec3 = DVec3::NAN;
/// The sheet has 20 vertices.
const MISSING: u32 = 99;

pub(super) fn simulation() -> Simulation {
    Simulation::new(Settings { threads: 1, ..Settings::default() }).unwrap()
}

fn sheet() -> Membrane {
    Membrane::new("sheet", generate::grid(4.0, 3.0, 4, 3).unwrap(), Material::allard_2009())
}

fn hold(rows: impl IntoIterator<Item = u32>) -> Hold {
    let members = Attached::new(rows.into_iter().map(|row| (row, DVec3::X)));
    Hold { name: "left".into(), members, axes: [true; 3], curve: Curve::ramp(10.0, 1.0).unwrap() }
}

/// A sheet that one side draws, after a step.
pub(super) fn drawn() -> (Simulation, BodyId) {
    let mut s = simulation();
    let sheet = sheet();
    let left = sheet.select(|p| p.x == 0.0);
    let body = s.spawn(sheet.hold(hold(left))).unwrap();
    s.step(1.0).unwrap();
    (s, body)
}

pub(super) fn point_loads(row: u32, force: DVec3) -> PointLoads {
    PointLoads { groups: vec![PointLoad { rows: vec![row], force, curve: Curve::constant(1.0) }] }
}

fn edge_loads(edge: [u32; 2]) -> EdgeLoads {
    EdgeLoads { groups: vec![EdgeLoad { edges: vec![edge], traction: DVec3::X * 1e-4, curve: Curve::constant(1.0) }] }
}

fn springs(row: u32, stiffness: f64) -> Springs {
    Springs { anchors: Attached::new([(row, Anchor::new(DVec3::ZERO, stiffness))]) }
}

fn pinched(row: u32) -> Grips {
    let mut grips = Grips::new(Vec::new());
    grips.pinches.push(Pinch { name: "jaws".into(), held: Attached::new([(row, DVec3::ZERO)]), ..Pinch::default() });
    grips
}

pub(super) fn sphere(radius: f64) -> Shape {
    Shape::Sphere { centre: DVec3::Z * 50.0, radius }
}

/// A state to compare: nothing of it has changed.
fn state(s: &Simulation, body: BodyId) -> String {
    let vertices = s.world().get::<&Vertices>(body.entity()).unwrap();
    format!("{:?} {:?} {:?} {}", vertices.position, vertices.velocity, s.reactions(body).unwrap(), s.time())
}

#[test]
fn a_body_with_rows_or_numbers_that_are_none_is_not_spawned() {
    let refused = |membrane: Membrane, says: &[&str]| {
        let error = simulation().spawn(membrane).unwrap_err().to_string();
        says.iter().for_each(|word| assert!(error.contains(word), "{error} should say {word}"));
    };
    refused(sheet().with(point_loads(MISSING, DVec3::X)), &["PointLoads", "vertex 99", "20 vertices"]);
    refused(sheet().with(point_loads(3, NAN)), &["body `sheet`: load 0: PointLoads", "force", "NaN", "finite"]);
    refused(sheet().with(Pressure { curve: Curve::constant(f64::NAN) }), &["Pressure", "curve", "NaN"]);
    refused(sheet().with(edge_loads([0, MISSING])), &["EdgeLoads", "vertex 99"]);
    // 6 and 7 are inside, 0 and 7 have no edge at all.
    refused(sheet().with(edge_loads([6, 7])), &["EdgeLoads", "6 to 7", "boundary"]);
    refused(sheet().with(edge_loads([0, 19])), &["EdgeLoads", "0 to 19", "boundary"]);
    refused(sheet().with(springs(MISSING, 1.0)), &["Springs", "vertex 99"]);
    refused(sheet().with(springs(3, -1.0)), &["Springs", "at vertex 3", "-1.0", "zero or more"]);
    refused(sheet().with(pinched(MISSING)), &["Grips", "jaws", "vertex 99"]);
    refused(sheet().with(Gravity { acceleration: NAN }), &["Gravity", "NaN"]);
    refused(
        sheet().with(PreStretch { strain: rhexis::math::Sym2 { xx: f64::NAN, yy: 0.0, xy: 0.0 } }),
        &["PreStretch"],
    );
    refused(sheet().hold(hold([MISSING])), &["hold `left`", "vertex 99"]);
    let grip = Grip {
        name: "hand".into(),
        from: 0.0,
        until: 1.0,
        material_point: NAN,
        near_tip: None,
        jaws: Jaws::default(),
        path: Path::default(),
        turns: Path::default(),
    };
    refused(sheet().with(Grips::new(vec![grip.clone()])), &["Grips", "material point"]);
    let path = Path { points: vec![(1.0, DVec3::ZERO), (0.0, DVec3::X)] };
    refused(sheet().with(Grips::new(vec![Grip { material_point: DVec3::ZERO, path, ..grip }])), &["Grips", "path"]);
}

/// Every parameter of a body, with right values.
fn set_all(s: &mut Simulation, body: BodyId) -> Result<(), SetError> {
    s.set(body, Holds { groups: vec![hold([0, 5])] })?;
    s.set(body, springs(3, 0.01))?;
    s.set(body, Grips::new(Vec::new()))?;
    s.set(body, point_loads(7, DVec3::Z * 1e-6))?;
    s.set(body, edge_loads([1, 2]))?;
    s.set(body, Damping { time: 1.0 })?;
    s.set(body, Gravity { acceleration: DVec3::NEG_Z * 1e-3 })?;
    s.set(body, Pressure { curve: Curve::constant(1e-6) })?;
    s.set(body, Drag { coefficient: 1e-6 })?;
    s.set(body, PreStretch { strain: rhexis::math::Sym2 { xx: 0.01, yy: 0.0, xy: 0.0 } })?;
    s.set(body, Contact::default())?;
    s.set(body, Bending { stiffness: Some(1e-4) })?;
    s.set(body, Tearing { radius: 0.5, ..Tearing::default() })?;
    s.set(body, EnergyCriterion::new(Toughness { along: 0.1, across: 0.5 }))?;
    s.set(body, Refinement::default())?;
    s.set(body, Sleeping::default())
}

#[test]
fn what_is_set_acts_as_what_was_spawned_with() {
    let mut set = simulation();
    let body = set.spawn(sheet()).unwrap();
    set_all(&mut set, body).unwrap();
    let mut spawned = simulation();
    let membrane = sheet()
        .hold(hold([0, 5]))
        .with(springs(3, 0.01))
        .with(Grips::new(Vec::new()))
        .with(point_loads(7, DVec3::Z * 1e-6))
        .with(edge_loads([1, 2]))
        .with(Damping { time: 1.0 })
        .with(Gravity { acceleration: DVec3::NEG_Z * 1e-3 })
        .with(Pressure { curve: Curve::constant(1e-6) })
        .with(Drag { coefficient: 1e-6 })
        .with(PreStretch { strain: rhexis::math::Sym2 { xx: 0.01, yy: 0.0, xy: 0.0 } })
        .with(Contact::default())
        .with(Bending { stiffness: Some(1e-4) })
        .with(Tearing { radius: 0.5, ..Tearing::default() })
        .with(EnergyCriterion::new(Toughness { along: 0.1, across: 0.5 }))
        .with(Refinement::default())
        .with(Sleeping::default());
    let other = spawned.spawn(membrane).unwrap();
    let notch = [DVec3::new(2.0, 0.0, 0.0), DVec3::new(2.0, 1.0, 0.0)];
    for (s, body) in [(&mut set, body), (&mut spawned, other)] {
        s.spawn_obstacle(Obstacle { shape: Shape::Sphere { centre: DVec3::NEG_Z * 1.5, radius: 1.5 } }).unwrap();
        s.cut(body, &notch).unwrap();
        (0..10).for_each(|_| assert!(!s.step(2.0).unwrap().has_failed));
    }
    assert_eq!(set.hash(), spawned.hash());
    // And each can be taken off again.
    assert!(matches!(set.unset::<Tearing>(body), Err(SetError::Rejected(_))), "refinement needs it");
    assert_eq!(set.unset::<Refinement>(body), Ok(true));
    assert_eq!(set.unset::<EnergyCriterion>(body), Ok(true));
    assert_eq!(set.unset::<Tearing>(body), Ok(true));
    assert_eq!(set.unset::<Tearing>(body), Ok(false));
    for was in [
        set.unset::<Holds>(body),
        set.unset::<Springs>(body),
        set.unset::<Grips>(body),
        set.unset::<PointLoads>(body),
        set.unset::<EdgeLoads>(body),
        set.unset::<Damping>(body),
        set.unset::<Gravity>(body),
        set.unset::<Pressure>(body),
        set.unset::<Drag>(body),
        set.unset::<PreStretch>(body),
        set.unset::<Contact>(body),
        set.unset::<Bending>(body),
        set.unset::<Sleeping>(body),
    ] {
        assert_eq!(was, Ok(true));
        assert!(!set.step(2.0).unwrap().has_failed);
    }
}

/// A bending that was taken off leaves nothing that a solve goes by: neither by the call nor by the world.
#[test]
fn what_is_taken_off_acts_no_more() {
    let fall = |mut s: Simulation, body: BodyId| {
        s.set(body, point_loads(7, DVec3::Z * 1e-4)).unwrap();
        (0..5).for_each(|_| assert!(!s.step(2.0).unwrap().has_failed));
        s.hash()
    };
    let bent = || {
        let (mut s, body) = drawn();
        s.set(body, Bending { stiffness: Some(1e-2) }).unwrap();
        (s, body)
    };
    let (plain, body) = drawn();
    let plain = fall(plain, body);
    let (mut s, body) = bent();
    assert_eq!(s.unset::<Bending>(body), Ok(true));
    assert_eq!(fall(s, body), plain);
    let (mut s, body) = bent();
    s.world_mut().remove_one::<Bending>(body.entity()).unwrap();
    assert_eq!(fall(s, body), plain);
}

#[test]
fn what_is_set_wrongly_changes_nothing_and_is_named() {
    let (mut s, body) = drawn();
    set_all(&mut s, body).unwrap();
    #[cfg(feature = "snapshot")]
    let before = s.snapshot().to_bytes().unwrap();
    let refused = |outcome: Result<(), SetError>, says: &[&str]| {
        let error = outcome.unwrap_err().to_string();
        let words = says.iter().chain(&["body `sheet`"]);
        words.for_each(|word| assert!(error.contains(word), "{error} should say {word}"));
    };
    refused(s.set(body, point_loads(MISSING, DVec3::X)), &["PointLoads", "vertex 99", "20"]);
    refused(s.set(body, point_loads(3, NAN)), &["PointLoads", "NaN"]);
    refused(s.set(body, edge_loads([6, 7])), &["EdgeLoads", "boundary"]);
    refused(s.set(body, springs(3, -1.0)), &["Springs", "vertex 3", "-1.0", "must be"]);
    refused(s.set(body, Holds { groups: vec![hold([3]), hold([3])] }), &["both prescribe"]);
    refused(s.set(body, pinched(MISSING)), &["Grips", "vertex 99"]);
    refused(
        s.set(body, Tearing { strength_across_fibres: -1.0, ..Tearing::default() }),
        &["Tearing", "strength_across_fibres", "-1.0"],
    );
    refused(s.set(body, Sleeping { strain: 0.0, ..Sleeping::default() }), &["Sleeping"]);
    refused(s.set(body, rhexis::math::StiffeningFibres { k1: -1.0, k2: 1.0 }), &["k1 of the stiffening fibres"]);
    refused(s.set(body, Obstacle { shape: sphere(1.0) }), &["Obstacle", "belongs to an obstacle"]);
    let gone = s.spawn_obstacle(Obstacle { shape: sphere(1.0) }).unwrap();
    assert!(matches!(s.set(gone, Damping { time: 1.0 }), Err(SetError::AnotherOwner { .. })));
    assert!(matches!(s.unset::<Obstacle>(gone), Err(SetError::Irremovable { .. })));
    s.despawn(gone).unwrap();
    assert_eq!(s.set(gone, Damping { time: 1.0 }), Err(SetError::NoSuchEntity));
    // Handles that have come and gone are remembered.
    #[cfg(feature = "snapshot")]
    assert!(s.snapshot().to_bytes().unwrap().len().abs_diff(before.len()) < 32);
    s.step(1.0).unwrap();
}

#[test]
fn a_body_that_sleeps_wakes_when_something_is_set() {
    let mut s = simulation();
    let body = s.spawn(sheet().with(Sleeping::default())).unwrap();
    let is_asleep = |s: &Simulation| s.world().get::<&Sleeping>(body.entity()).unwrap().is_asleep();
    (0..200).for_each(|_| _ = s.step(5.0));
    assert!(is_asleep(&s));
    assert!(s.set(body, Gravity { acceleration: NAN }).is_err() && is_asleep(&s));
    s.set(body, Gravity { acceleration: DVec3::Z * 1e-3 }).unwrap();
    assert!(!is_asleep(&s));
    s.step(5.0).unwrap();
    assert!(s.world().get::<&Vertices>(body.entity()).unwrap().position[0].z > 0.0);
}

/// Writes something past the calls: the next step refuses it by name, nothing has changed, no other call panics, and mended it goes on.
fn written(says: &[&str], write: impl Fn(&mut Simulation, BodyId), mend: impl Fn(&mut Simulation, BodyId)) {
    let (mut s, body) = drawn();
    let keys: Vec<VertexKey> = s.world().get::<&Vertices>(body.entity()).unwrap().keys().to_vec();
    s.world_mut().insert_one(body.entity(), springs(3, 0.01)).unwrap();
    s.step(1.0).unwrap();
    let before = state(&s, body);
    write(&mut s, body);
    for _ in 0..2 {
        let error = s.step(1.0).unwrap_err().to_string();
        says.iter().for_each(|word| assert!(error.contains(word), "{error} should say {word}"));
    }
    assert!(
        s.settle(1.0, 1e-9).is_err() && s.settle_and_tear(1.0, 1e-9, 2).is_err() && s.linear_response(1.0).is_err()
    );
    assert!(s.cut(body, &[DVec3::new(2.0, 0.0, 0.0), DVec3::new(2.0, 1.0, 0.0)]).is_err());
    assert!(s.reorder(body).is_err() && s.pin(body, "pin", &keys[12..13]).is_err());
    assert!(s.unpin(body, &keys[..1]).is_err() && s.move_pins(body, "pin", |pin| pin.place).is_err());
    assert!(s.teleport(body, glam::DQuat::IDENTITY, DVec3::ZERO).is_err());
    assert!(s.set_velocity(body, |_| DVec3::ZERO).is_err() && s.apply_force(body, keys[0], DVec3::X).is_err());
    assert!(s.energies(body).is_err());
    let forceps = s.spawn_forceps("forceps", Jaws::default(), Pose::default()).unwrap();
    assert!(s.close_forceps(forceps, body, &Grasp::Vertices(vec![keys[5]])).is_err());
    let _ = (s.frame(), s.coupling_of_grip(body, 0), s.contact_forces(body), s.view(body).map(|_| ()));
    assert_eq!(state(&s, body), before);
    #[cfg(feature = "snapshot")]
    if let Ok(bytes) = s.snapshot().to_bytes() {
        rhexis::snapshot::Snapshot::from_bytes(&bytes).expect("what is written can be read again");
    }
    mend(&mut s, body);
    assert!(!s.step(1.0).unwrap().has_failed);
    assert_ne!(state(&s, body), before);
    #[cfg(feature = "snapshot")]
    rhexis::snapshot::Snapshot::from_bytes(&s.snapshot().to_bytes().unwrap()).unwrap();
}

fn insert<C: hecs::Component + Clone>(component: C) -> impl Fn(&mut Simulation, BodyId) {
    move |s, body| s.world_mut().insert_one(body.entity(), component.clone()).unwrap()
}

fn remove<C: hecs::Component>(s: &mut Simulation, body: BodyId) {
    drop(s.world_mut().remove_one::<C>(body.entity()).unwrap());
}

#[test]
fn what_was_written_past_the_calls_is_refused_at_the_next_step() {
    written(&["`sheet`", "PointLoads", "vertex 99"], insert(point_loads(MISSING, DVec3::X)), remove::<PointLoads>);
    written(&["PointLoads", "NaN"], insert(point_loads(3, NAN)), remove::<PointLoads>);
    written(&["EdgeLoads", "vertex 99"], insert(edge_loads([0, MISSING])), remove::<EdgeLoads>);
    written(&["EdgeLoads", "boundary"], insert(edge_loads([6, 7])), remove::<EdgeLoads>);
    written(&["Grips", "vertex 99"], insert(pinched(MISSING)), remove::<Grips>);
    written(
        &["Tearing", "strength_across_fibres"],
        insert(Tearing { strength_across_fibres: -1.0, ..Tearing::default() }),
        remove::<Tearing>,
    );
    written(&["refinement goes with"], insert(Refinement::default()), remove::<Refinement>);
    written(&["Gravity"], insert(Gravity { acceleration: DVec3::INFINITY }), remove::<Gravity>);
    let move_springs = |row: u32| {
        move |s: &mut Simulation, body| s.entity_mut::<&mut Springs>(body).unwrap().anchors = springs(row, 0.01).anchors
    };
    written(&["`sheet`", "Springs", "vertex 99"], move_springs(MISSING), move_springs(3));
    let move_holds = |rows: Vec<u32>| {
        move |s: &mut Simulation, body| s.entity_mut::<&mut Holds>(body).unwrap().groups = vec![hold(rows.clone())]
    };
    written(&["`sheet`", "hold `left`", "vertex 99"], move_holds(vec![MISSING]), move_holds(vec![0, 5]));
    let set_x = |x: f64| move |s: &mut Simulation, body| s.entity_mut::<&mut Vertices>(body).unwrap().mass[7] = x;
    let (s, body) = drawn();
    let mass = s.world().get::<&Vertices>(body.entity()).unwrap().mass[7];
    written(&["mass of vertex 7"], set_x(f64::NAN), set_x(mass));
    let corners =
        |row: u32| move |s: &mut Simulation, body| s.entity_mut::<&mut Triangles>(body).unwrap().corners[0][0] = row;
    let first = s.world().get::<&Triangles>(body.entity()).unwrap().corners[0][0];
    written(&["triangle 0 refers to vertex 99"], corners(MISSING), corners(first));
    let topology = (*s.world().get::<&Topology>(body.entity()).unwrap()).clone();
    written(&["Topology", "another mesh"], insert(Topology::default()), insert(topology));
}

#[test]
fn a_component_written_without_its_companions_works() {
    let mut set = drawn();
    let mut written = drawn();
    for (k, (s, body)) in [&mut set, &mut written].into_iter().enumerate() {
        let grips = Grips::new(Vec::new());
        if k == 0 {
            s.set(*body, springs(3, 0.1)).unwrap();
            s.set(*body, Bending { stiffness: Some(1e-4) }).unwrap();
            s.set(*body, Drag { coefficient: 1e-5 }).unwrap();
            s.set(*body, grips).unwrap();
            s.set(*body, Tearing { radius: 0.5, ..Tearing::default() }).unwrap();
            s.set(*body, Refinement::default()).unwrap();
        } else {
            let added = (springs(3, 0.1), Bending { stiffness: Some(1e-4) }, Drag { coefficient: 1e-5 }, grips);
            s.world_mut().insert(body.entity(), added).unwrap();
            let tearing = Tearing { radius: 0.5, ..Tearing::default() };
            s.world_mut().insert(body.entity(), (tearing, Refinement::default())).unwrap();
        }
        s.cut(*body, &[DVec3::new(2.0, 0.0, 0.0), DVec3::new(2.0, 1.0, 0.0)]).unwrap();
        (0..10).for_each(|_| _ = s.step(2.0).unwrap());
        assert!(s.world().get::<&rhexis::storage::Tips>(body.entity()).is_ok_and(|tips| tips.len() == 1));
    }
    assert_eq!(set.0.hash(), written.0.hash());
}

#[test]
fn a_system_that_writes_what_is_refused_ends_the_step_with_the_last_state_standing() {
    for place in ["hold", "assembly", "sleep", "solve", "criterion", "split"] {
        let (mut s, body) = drawn();
        s.set(body, springs(3, 0.01)).unwrap();
        s.step(1.0).unwrap();
        let before = state(&s, body);
        let bad = move |world: &mut hecs::World, _: &rhexis::systems::StepContext| {
            world.query_mut::<&mut Springs>().into_iter().for_each(|s| s.anchors = springs(MISSING, 1.0).anchors);
            1
        };
        s.insert_system(Place::Before(place), "bad", bad).unwrap();
        for _ in 0..2 {
            let error = s.step(1.0).unwrap_err().to_string();
            assert!(error.contains("`sheet`") && error.contains("vertex 99"), "before {place}: {error}");
            assert!(s.settle(1.0, 1e-9).is_err(), "before {place}");
        }
        assert!(s.report().has_failed);
        // Reactions are those of the last solve, which a step may have made before it was called off.
        let positions = |state: &str| state.split("[(").next().unwrap().to_owned();
        assert_eq!(positions(&state(&s, body)), positions(&before), "before {place}");
        s.remove_system("bad").unwrap();
        assert!(s.step(1.0).is_err(), "what it has written is still there");
        s.set(body, springs(3, 0.01)).unwrap();
        assert!(!s.step(1.0).unwrap().has_failed);
    }
}

/// Refusal of numbers whose squares or products overflow, at every door.
#[test]
fn places_and_strains_beyond_powers_are_refused_where_they_come_in() {
    for size in [1e76, 1e154, 1e155, 1e307, f64::MAX, f64::INFINITY, f64::NAN] {
        let far = DVec3::new(0.0, size, 0.0);
        let mut s = simulation();
        let mut mesh = generate::grid(4.0, 3.0, 4, 3).unwrap();
        mesh.positions[7].x = size;
        let refused = s.spawn(Membrane::new("sheet", mesh, Material::allard_2009())).unwrap_err().to_string();
        assert!(refused.contains("vertex 7") && refused.contains("at most 1e75"), "{refused}");
        for (what, solid) in [
            ("a point of the plane", Solid::new(Shape::Plane { point: far, normal: DVec3::Z })),
            ("centre", Solid::new(Shape::Sphere { centre: far, radius: 1.0 })),
            ("radius", Solid::new(sphere(size))),
            ("end", Solid::new(Shape::Capsule { ends: [DVec3::ZERO, far], radius: 1.0 })),
            ("end", Solid::new(Shape::Cylinder { ends: [DVec3::ZERO, far], radius: 1.0 })),
            (
                "half edge",
                Solid::new(Shape::Box { centre: DVec3::ZERO, half: DVec3::splat(size), axes: DMat3::IDENTITY }),
            ),
            ("a point of the path", Solid::new(sphere(1.0)).path(Path { points: vec![(0.0, far)] })),
        ] {
            let refused = s.spawn_obstacle(solid).unwrap_err().to_string();
            assert!(refused.contains(what) && refused.contains("at most 1e75"), "{size}: {refused}");
        }
        let (mut s, body) = drawn();
        let held = PreStretch { strain: Sym2::new(size, 0.0, 0.0) };
        let refused = s.set(body.entity(), held).unwrap_err().to_string();
        assert!(refused.contains("`sheet`") && refused.contains("strain") && refused.contains("1e75"), "{refused}");
        s.unset::<Holds>(body.entity()).unwrap();
        let places = |s: &Simulation| s.world().get::<&Vertices>(body.entity()).unwrap().position.clone();
        let before = places(&s);
        assert!(s.teleport(body, DQuat::IDENTITY, far).is_err() && places(&s) == before, "{size}");
        assert!(s.spawn_forceps("jaws", Jaws::default(), Pose::at(far)).is_err(), "{size}");
    }
    // Many ways of which each alone would do.
    let (mut s, body) = drawn();
    s.unset::<Holds>(body.entity()).unwrap();
    let way = DVec3::X * 4e74;
    assert!(s.teleport(body, DQuat::IDENTITY, way).is_ok() && s.teleport(body, DQuat::IDENTITY, way).is_ok());
    assert_eq!(s.teleport(body, DQuat::IDENTITY, way), Err(MotionError::NotFinite));
    for scale in [1e-200, 1e-160, 1e160, 1e200] {
        assert!(s.teleport(body, DQuat::from_rotation_z(0.3) * scale, DVec3::ZERO).is_err(), "{scale}");
    }
}

/// A direction too short or too long for squares would silently become that of an edge.
#[test]
fn fibres_without_a_direction_are_refused() {
    for fibre in [DVec3::X * 1e-308, DVec3::X * 1e-160, DVec3::X * 1e160, DVec3::X * 1e308, NAN] {
        let list = vec![fibre; 24];
        for fibres in
            [Fibres::Uniform(fibre), Fibres::PerTriangle(list.clone()), Fibres::Function(Arc::new(move |_| fibre))]
        {
            let refused = simulation().spawn(sheet().fibres(fibres)).unwrap_err().to_string();
            assert!(refused.contains("triangle 0") && refused.contains("no direction"), "{fibre}: {refused}");
        }
        let mesh = TriangleMesh { fibres: Some(list), ..generate::grid(4.0, 3.0, 4, 3).unwrap() };
        let refused = simulation().spawn(Membrane::new("sheet", mesh, Material::allard_2009())).unwrap_err();
        assert!(refused.to_string().contains("no direction"), "{fibre}: {refused}");
    }
    // Circles have no direction on their axis.
    simulation().spawn(sheet().fibres(Fibres::PerTriangle(vec![DVec3::ZERO; 24]))).unwrap();
}
