//! What calls do, against the engine itself.

#![allow(unsafe_code, reason = "pointers are handed over as C does")]

mod common;
use common::*;

use glam::DVec3;
use rhexis::components::{Gravity, Jaws, Pose, Tearing};
use rhexis::membrane::Membrane;
use rhexis::settings::Settings;
use rhexis::simulation::{Grasp, Simulation};
use rhexis::storage::TriangleMesh;
use rhexis_c::abi::*;
use rhexis_c::body::*;
use rhexis_c::component::*;
use rhexis_c::events::*;
use rhexis_c::haptics::*;
use rhexis_c::pins::*;
use rhexis_c::pointer::{Array, Buffer, Out};
use rhexis_c::saved::*;
use rhexis_c::shown::*;
use rhexis_c::status::*;
use rhexis_c::tools::*;
use rhexis_c::types::*;
use rhexis_c::world::*;
use rhexis_scene::Scene;
use std::ffi::CStr;

const NO_WORLD: RhexisWorld = RhexisWorld { bits: 0 };
const UP: RhexisVec3 = RhexisVec3 { x: 0.0, y: 0.0, z: 1.0 };

fn pose(x: f64, y: f64, z: f64) -> RhexisPose {
    RhexisPose { position: RhexisVec3 { x, y, z }, orientation: RhexisQuat { x: 0.0, y: 0.0, z: 0.0, w: 1.0 } }
}

fn forceps_at(world: RhexisWorld, pose: RhexisPose) -> RhexisEntity {
    let mut jaws = RhexisJaws { radius: -1.0, stiffness: -1.0, force_limit: -1.0, slides: 9 };
    ok(rhexis_jaws_init(out(&mut jaws)));
    jaws.stiffness = 0.2;
    let mut forceps = RhexisEntity::default();
    ok(rhexis_forceps_create(world, text(c"forceps"), input(&jaws), input(&pose), out(&mut forceps)));
    forceps
}

fn close(world: RhexisWorld, forceps: RhexisEntity, body: RhexisEntity) -> usize {
    let mut grasp =
        RhexisGrasp { kind: 9, reach: 0.0, point: UP, direction: UP, vertices: Array::NULL, vertex_count: 9 };
    ok(rhexis_grasp_init(out(&mut grasp)));
    let mut held = 0;
    ok(rhexis_forceps_close(world, forceps, body, input(&grasp), out(&mut held)));
    held
}

#[test]
fn the_material_of_a_body_changes_while_it_runs() {
    let mut world = NO_WORLD;
    ok(rhexis_world_from_scene(
        text(
            c"[scene]\nname = 'sheet'\n[run]\nmode = 'static'\ndt = 1\nsteps = 1\n[[bodies]]\nname = 'sheet'\nplanar = true\nmesh.grid = { width = 8, height = 8, nx = 4, ny = 4 }\nmaterial = { young = 1, poisson = 0.3, thickness = 0.1 }\n\
        [[bodies.holds]]\nname = 'left'\nregion = { x = 0 }\n[[bodies.holds]]\nname = 'right'\nregion = { x = 8 }\nmove = { offset = [1, 0, 0] }\n",
        ),
        text(c"sheet.toml"),
        out(&mut world),
    ));
    let mut body = RhexisEntity::default();
    ok(rhexis_find_body(world, text(c"sheet"), out(&mut body)));
    let pull = || {
        ok(rhexis_settle(world, 1.0, 1e-9, Out::NULL));
        let mut force = UP;
        ok(rhexis_reaction(world, body, text(c"right"), out(&mut force)));
        force.x
    };
    let before = pull();
    // SAFETY: every bit pattern of zeros is a description.
    let mut desc: RhexisBodyDesc = unsafe { std::mem::zeroed() };
    ok(rhexis_body_init(out(&mut desc)));
    (desc.young_fibre, desc.young_transverse, desc.shear_modulus) = (0.5, 0.5, 0.0);
    ok(rhexis_material_set(world, body, input(&desc)));
    // Equilibria are found to 1e-9.
    let after = pull();
    assert!((after / before - 0.5).abs() < 1e-6, "{before} {after}");
    desc.thickness = -1.0;
    refused(rhexis_material_set(world, body, input(&desc)), RhexisStatus::Refused, "thickness");
    refused(rhexis_material_set(world, RhexisEntity::default(), input(&desc)), RhexisStatus::InvalidHandle, "");
    ok(rhexis_world_destroy(world));
}

#[test]
fn a_rigid_ball_falls_onto_a_sheet_and_tells_its_impulse() {
    let mut world = NO_WORLD;
    ok(rhexis_world_from_scene(
        text(
            c"[scene]\nname = 'ball'\n[run]\nmode = 'dynamic'\ndt = 2\nsteps = 1\n[[bodies]]\nname = 'sheet'\nmesh.grid = { width = 8, height = 8, nx = 8, ny = 8 }\nmaterial = { young = 1, poisson = 0.3, thickness = 0.1 }\ncontact = {}\n\
        [[bodies.holds]]\nname = 'rim'\nregion = { boundary = true }\n",
        ),
        text(c"ball.toml"),
        out(&mut world),
    ));
    let mut ball = RhexisEntity::default();
    ok(rhexis_obstacle_create(
        world,
        text(c"shape = { Sphere = { centre = [4, 4, 2.01], radius = 2 } }"),
        out(&mut ball),
    ));
    let mut rigid = RhexisRigid { mass: 9.0, ..RhexisRigid::default() };
    ok(rhexis_rigid(world, ball, out(&mut rigid)));
    assert_eq!(rigid, RhexisRigid::default());
    refused(rhexis_rigid_set(world, ball, text(c"velocity = [0, 0, 1]")), RhexisStatus::Scene, "give `mass`");
    refused(rhexis_rigid_set(world, ball, text(c"mass = 0")), RhexisStatus::Refused, "mass");
    refused(rhexis_rigid_set(world, ball, text(c"mas = 1")), RhexisStatus::Scene, "give `mass`");
    ok(rhexis_rigid_set(world, ball, text(c"mass = 0.5\nacceleration = [0, 0, -9.81e-3]")));
    for _ in 0..40 {
        ok(rhexis_step(world, 2.0, Out::NULL));
    }
    ok(rhexis_rigid(world, ball, out(&mut rigid)));
    assert!(rigid.mass == 0.5 && rigid.impulse.z > 0.0 && rigid.centre.z > 1.0, "{rigid:?}");
    ok(rhexis_rigid_set(world, ball, text(c"")));
    ok(rhexis_rigid(world, ball, out(&mut rigid)));
    assert_eq!(rigid.mass, 0.0);
    ok(rhexis_world_destroy(world));
}

#[test]
fn a_scene_has_the_same_hash_through_rust_and_c() {
    check_abi();
    let mut rust = Scene::named("fig2-tear").unwrap().instantiate().unwrap();
    let mut c = NO_WORLD;
    ok(rhexis_world_from_catalog(text(c"fig2-tear"), out(&mut c)));
    let (mut is_finished, mut report, mut advances) = (0, RhexisReport::default(), 0);
    while is_finished == 0 {
        rust.advance().unwrap();
        ok(rhexis_advance(c, out(&mut report)));
        ok(rhexis_is_finished(c, out(&mut is_finished)));
        assert_eq!(hash(c), rust.simulation.hash().0);
        assert_eq!(rust.is_finished(), is_finished == 1);
        advances += events(c).iter().filter(|event| event.kind == RHEXIS_EVENT_ADVANCED).count();
    }
    assert!(advances > 3, "it has torn");
    let body = first_body(c);
    let mut view = RhexisViewF64 { data: std::ptr::null(), count: 0 };
    ok(rhexis_positions(c, body, out(&mut view)));
    let there = rust.simulation.view(rust.bodies[0]).unwrap();
    let numbers: Vec<f64> = there.positions.iter().flat_map(|position| position.to_array()).collect();
    assert_eq!(seen(view.data, view.count), numbers);
    ok(rhexis_world_destroy(c));
}

fn first_body(world: RhexisWorld) -> RhexisEntity {
    let (mut bodies, mut count) = ([RhexisEntity::default(); 4], 0);
    ok(rhexis_bodies(world, buffer(&mut bodies), 4, out(&mut count)));
    assert_eq!(count, 1);
    bodies[0]
}

fn events(world: RhexisWorld) -> Vec<RhexisEvent> {
    let mut all = Vec::new();
    loop {
        // SAFETY: all numbers and pointers, which may be zero.
        let mut event: RhexisEvent = unsafe { std::mem::zeroed() };
        ok(rhexis_next_event(world, out(&mut event)));
        // SAFETY: the text of the last call.
        assert!(unsafe { CStr::from_ptr(event.text) }.to_str().is_ok());
        if event.kind == RHEXIS_EVENT_NONE {
            return all;
        }
        all.push(event);
    }
}

/// A sheet hung up by pins, cut, drawn by forceps, in C and in Rust, to the same bits.
#[test]
fn tools_do_what_they_do_in_rust() {
    let world = world();
    let body = sheet(world, 6);
    set(world, body, c"Tearing", c"strength_across_fibres = 0.05\nstrength_along_fibres = 0.01\nradius = 1.5");
    set(world, body, c"Gravity", c"acceleration = [0, 0, -9.81e-3]");
    let mut keys = RhexisViewU64 { data: std::ptr::null(), count: 0 };
    ok(rhexis_vertex_keys(world, body, out(&mut keys)));
    let keys = seen(keys.data, keys.count);
    ok(rhexis_pin(world, body, text(c"left"), array(&[keys[0], keys[7], keys[14]]), 3));
    let mut cut = RhexisCut::default();
    ok(rhexis_cut(world, body, array(&[3.0, 0.0, 0.0, 3.0, 2.0, 0.0]), 2, out(&mut cut)));
    assert!((cut.made - 2.0).abs() < 1e-9 && cut.tips == 1, "{cut:?}");
    let forceps = forceps_at(world, pose(5.0, 1.0, 0.3));
    let held = close(world, forceps, body);
    for step in 1..=20 {
        let to = pose(5.0 + 0.05 * f64::from(step), 1.0, 0.3 + 0.05 * f64::from(step));
        ok(rhexis_forceps_move(world, forceps, input(&to), 5.0));
        ok(rhexis_pins_shift(world, body, text(c"left"), RhexisVec3 { x: -0.01, y: 0.0, z: 0.0 }));
        ok(rhexis_step(world, 5.0, Out::NULL));
    }

    let (positions, triangles) = grid(6);
    let positions = positions.as_chunks::<3>().0.iter().map(|&p| DVec3::from_array(p)).collect();
    let mesh = TriangleMesh { positions, triangles: triangles.as_chunks::<3>().0.to_vec(), fibres: None };
    let material = rhexis::components::Material::allard_2009();
    let mut rust = Simulation::new(Settings { threads: 1, ..Settings::default() }).unwrap();
    let there = rust.spawn(Membrane::new("sheet", mesh, material)).unwrap();
    let (strength_across_fibres, strength_along_fibres, radius) = (0.05, 0.01, 1.5);
    rust.set(there, Tearing { strength_across_fibres, strength_along_fibres, radius, ..Tearing::default() }).unwrap();
    rust.set(there, Gravity { acceleration: DVec3::NEG_Z * 9.81e-3 }).unwrap();
    let pinned = [0, 7, 14].map(|row: usize| rust.view(there).unwrap().vertex_keys[row]);
    rust.pin(there, "left", &pinned).unwrap();
    rust.cut(there, &[DVec3::new(3.0, 0.0, 0.0), DVec3::new(3.0, 2.0, 0.0)]).unwrap();
    let jaws = Jaws { radius: 0.2, stiffness: Some(0.2), ..Jaws::default() };
    let tool = rust.spawn_forceps("forceps", jaws, Pose::at(DVec3::new(5.0, 1.0, 0.3))).unwrap();
    assert_eq!(rust.close_forceps(tool, there, &Grasp::Nearest { reach: 1.0 }).unwrap(), held);
    for step in 1..=20 {
        let to = DVec3::new(5.0 + 0.05 * f64::from(step), 1.0, 0.3 + 0.05 * f64::from(step));
        rust.move_forceps(tool, Pose::at(to), 5.0).unwrap();
        rust.move_pins(there, "left", |pin| pin.place + DVec3::new(-0.01, 0.0, 0.0)).unwrap();
        rust.step(5.0).unwrap();
    }
    assert_eq!(hash(world), rust.hash().0);

    // SAFETY: all numbers, which may be zero.
    let mut state: RhexisForcepsState = unsafe { std::mem::zeroed() };
    ok(rhexis_forceps_state(world, forceps, out(&mut state)));
    assert_eq!(state.force, rust.forceps(tool).unwrap().force.into());
    assert_eq!(state.body, body);
    ok(rhexis_forceps_open(world, forceps));
    let mut force = RhexisVec3::default();
    ok(rhexis_reaction(world, body, text(c"left"), out(&mut force)));
    assert_eq!(force, rust.reactions(there).unwrap()[0].1.into());
    ok(rhexis_world_destroy(world));
}

#[test]
fn what_is_lent_is_the_mesh() {
    let world = world();
    let body = sheet(world, 4);
    let uv = (0..50).map(|i| i.to_string()).collect::<Vec<_>>().join(", ");
    let toml = std::ffi::CString::new(format!("stride = 2\nvalues = [{uv}]")).unwrap();
    set(world, body, c"Attributes", &toml);
    ok(rhexis_track_changes(world, body));
    // SAFETY: all numbers and pointers, which may be zero.
    let mut changes: RhexisChanges = unsafe { std::mem::zeroed() };
    ok(rhexis_changes(world, body, out(&mut changes)));
    assert_eq!((changes.is_whole, changes.vertex_count, changes.triangle_count), (1, 25, 32));
    assert_eq!(seen(changes.vertices.data, changes.vertices.count), [0, 25]);
    ok(rhexis_cut(world, body, array(&[2.0, 0.0, 0.0, 2.0, 2.0, 0.0]), 2, Out::NULL));
    ok(rhexis_changes(world, body, out(&mut changes)));
    assert!(changes.is_whole == 0 && changes.vertex_count == 27 && changes.triangles.count > 0);
    assert_eq!(seen(changes.vertices.data, changes.vertices.count), [25, 27]);
    ok(rhexis_changes(world, body, out(&mut changes)));
    assert_eq!((changes.vertices.count, changes.triangles.count), (0, 0));

    let mut doubles = RhexisViewF64 { data: std::ptr::null(), count: 0 };
    let mut singles = RhexisViewF32 { data: std::ptr::null(), count: 0 };
    let mut rows = RhexisViewU32 { data: std::ptr::null(), count: 0 };
    let mut keys = RhexisViewU64 { data: std::ptr::null(), count: 0 };
    let mut stride = 0;
    ok(rhexis_attributes(world, body, out(&mut doubles), out(&mut stride)));
    assert_eq!((doubles.count, stride), (54, 2));
    ok(rhexis_attributes_f32(world, body, out(&mut singles), Out::NULL));
    let narrowed: Vec<f32> = seen(doubles.data, doubles.count).into_iter().map(|value| value as f32).collect();
    assert_eq!(seen(singles.data, singles.count), narrowed);
    for look in [rhexis_positions, rhexis_rest_positions, rhexis_velocities, rhexis_normals] {
        ok(look(world, body, out(&mut doubles)));
        assert_eq!(doubles.count, 81);
    }
    let normals = seen(doubles.data, doubles.count);
    assert!(normals.as_chunks::<3>().0.iter().all(|normal| *normal == [0.0, 0.0, 1.0]));
    ok(rhexis_positions_before(world, body, 0.0, out(&mut doubles)));
    ok(rhexis_positions_f32(world, body, out(&mut singles)));
    let narrowed: Vec<f32> = seen(doubles.data, doubles.count).into_iter().map(|value| value as f32).collect();
    assert_eq!(seen(singles.data, singles.count), narrowed);
    ok(rhexis_normals_f32(world, body, out(&mut singles)));
    assert_eq!(singles.count, 81);
    ok(rhexis_indices(world, body, out(&mut rows)));
    assert!(rows.count == 96 && seen(rows.data, rows.count).into_iter().all(|row| row < 27));
    ok(rhexis_vertex_keys(world, body, out(&mut keys)));
    assert_eq!(keys.count, 27);
    ok(rhexis_triangle_keys(world, body, out(&mut keys)));
    assert_eq!(keys.count, 32);
    ok(rhexis_world_destroy(world));
}

#[test]
fn components_and_settings_are_told_and_set_by_text() {
    let world = world();
    let body = sheet(world, 2);
    let (mut bytes, mut count) = ([0; 4096], 0);
    set(world, body, c"Tearing", c"radius = 1.25");
    refused(
        rhexis_get(world, body, text(c"Tearing"), Buffer::NULL, 0, out(&mut count)),
        RhexisStatus::BufferTooSmall,
        "the buffer has room for 0",
    );
    let needed = count;
    ok(rhexis_get(world, body, text(c"Tearing"), buffer(&mut bytes), needed, out(&mut count)));
    assert_eq!(count, needed);
    let toml = CStr::from_bytes_with_nul(&bytes[..count]).unwrap();
    assert!(toml.to_str().unwrap().contains("radius = 1.25\n"), "{toml:?}");
    set(world, body, c"Tearing", toml);
    let mut was_there = 9;
    ok(rhexis_unset(world, body, text(c"Tearing"), out(&mut was_there)));
    assert_eq!(was_there, 1);
    ok(rhexis_unset(world, body, text(c"Tearing"), out(&mut was_there)));
    assert_eq!(was_there, 0);
    let answer = rhexis_get(world, body, text(c"Tearing"), buffer(&mut bytes), 4096, out(&mut count));
    refused(answer, RhexisStatus::NotFound, "the entity has no component Tearing");
    let answer = rhexis_set(world, body, text(c"Tearings"), text(c""));
    refused(answer, RhexisStatus::NotFound, "did you mean `Tearing`?");
    let answer = rhexis_set(world, body, text(c"Tearing"), text(c"radios = 1"));
    refused(answer, RhexisStatus::Scene, "there is no key `radios`: did you mean `radius`?");
    let answer = rhexis_set(world, body, text(c"Tearing"), text(c"radius = -1"));
    refused(answer, RhexisStatus::Refused, "body `sheet`: Tearing");
    let answer = rhexis_set(world, body, text(c"Blade"), text(c""));
    refused(answer, RhexisStatus::Scene, "Blade: missing field");

    ok(rhexis_settings_set(world, text(c"max_tear_passes = 3\nadvanced.linear.tolerance = 1e-5")));
    ok(rhexis_set_budget(world, 40, 0.0));
    ok(rhexis_settings_get(world, buffer(&mut bytes), 4096, out(&mut count)));
    let toml = CStr::from_bytes_with_nul(&bytes[..count]).unwrap().to_str().unwrap();
    assert!(
        ["max_tear_passes = 3\n", "budget = 40\n", "tolerance = 0.00001"].iter().all(|line| toml.contains(line)),
        "{toml}"
    );
    ok(rhexis_doubts(world, 0.016, 0.0, buffer(&mut bytes), 4096, out(&mut count)));
    let doubts = CStr::from_bytes_with_nul(&bytes[..count]).unwrap().to_str().unwrap();
    assert!(doubts.lines().next().is_some_and(|line| line.contains("the time step is 0.016 ms")), "{doubts}");
    let answer = rhexis_set_budget(world, 40, f64::NAN);
    refused(answer, RhexisStatus::InvalidArgument, "a time of NaN ms");
    ok(rhexis_world_destroy(world));
}

/// Whose recordings are read follows from the features of the engine: another package of one build may have asked for `direct`.
#[test]
fn the_bit_of_factors_is_that_of_recordings() {
    // SAFETY: all numbers and pointers, which may be zero.
    let mut info: RhexisBuildInfo = unsafe { std::mem::zeroed() };
    ok(rhexis_build_info(out(&mut info)));
    let (world, mut recording) = (world(), RhexisRecording::default());
    ok(rhexis_record(world));
    ok(rhexis_record_end(world, out(&mut recording)));
    let mut bytes = RhexisViewU8 { data: std::ptr::null(), count: 0 };
    ok(rhexis_recording_bytes(recording, out(&mut bytes)));
    let marks = seen(bytes.data, bytes.count)[10];
    assert_eq!(info.features & RHEXIS_FEATURE_DIRECT != 0, marks & 1 != 0);
    ok(rhexis_recording_destroy(recording));
    ok(rhexis_world_destroy(world));
}

#[test]
fn states_and_runs_are_kept_and_repeated() {
    let world = world();
    let body = sheet(world, 3);
    set(world, body, c"Gravity", c"acceleration = [0, 0, -9.81e-3]");
    ok(rhexis_record(world));
    ok(rhexis_step(world, 5.0, Out::NULL));
    let mut snapshot = RhexisSnapshot::default();
    ok(rhexis_snapshot_take(world, out(&mut snapshot)));
    let middle = hash(world);
    ok(rhexis_step(world, 5.0, Out::NULL));
    let end = hash(world);
    let mut recording = RhexisRecording::default();
    ok(rhexis_record_end(world, out(&mut recording)));
    refused(rhexis_record_end(world, out(&mut recording)), RhexisStatus::Refused, "nothing is recorded");

    let mut bytes = RhexisViewU8 { data: std::ptr::null(), count: 0 };
    ok(rhexis_snapshot_bytes(snapshot, out(&mut bytes)));
    let mut written = seen(bytes.data, bytes.count);
    let mut again = RhexisSnapshot::default();
    ok(rhexis_snapshot_from_bytes(array(&written), written.len(), out(&mut again)));
    let mut other = NO_WORLD;
    ok(rhexis_world_from_snapshot(again, out(&mut other)));
    assert_eq!(hash(other), middle);
    ok(rhexis_step(other, 5.0, Out::NULL));
    assert_eq!(hash(other), end);
    ok(rhexis_restore(world, snapshot));
    assert_eq!(hash(world), middle);
    // The body has its handle still.
    let mut view = RhexisViewF64 { data: std::ptr::null(), count: 0 };
    ok(rhexis_positions(world, body, out(&mut view)));

    ok(rhexis_recording_bytes(recording, out(&mut bytes)));
    let run = seen(bytes.data, bytes.count);
    let mut repeated = RhexisRecording::default();
    ok(rhexis_recording_from_bytes(array(&run), run.len(), out(&mut repeated)));
    let mut replayed = NO_WORLD;
    ok(rhexis_replay(repeated, out(&mut replayed)));
    ok(rhexis_replay(repeated, Out::NULL));
    assert_eq!(hash(replayed), end);

    let last = written.len() - 1;
    written[last] ^= 1;
    let answer = rhexis_snapshot_from_bytes(array(&written), written.len(), out(&mut again));
    refused(answer, RhexisStatus::Refused, "damaged");
    ok(rhexis_snapshot_destroy(snapshot));
    refused(rhexis_restore(world, snapshot), RhexisStatus::InvalidHandle, "is destroyed");
    ok(rhexis_recording_destroy(recording));
    [world, other, replayed].into_iter().for_each(|world| ok(rhexis_world_destroy(world)));
}

#[test]
fn a_haptic_thread_feels_the_tissue() {
    let world = world();
    let body = sheet(world, 6);
    let mut keys = RhexisViewU64 { data: std::ptr::null(), count: 0 };
    ok(rhexis_vertex_keys(world, body, out(&mut keys)));
    let keys = seen(keys.data, keys.count);
    ok(rhexis_pin(world, body, text(c"rim"), array(&keys), 7));
    let mut haptics = RhexisHaptics::default();
    ok(rhexis_haptics_create(5.0, out(&mut haptics)));
    let mut receiver = RhexisReceiver::default();
    ok(rhexis_receiver_create(haptics, 5.0, out(&mut receiver)));
    let (mut model, mut force) = (RhexisHapticModel::default(), RhexisVec3::default());
    let answer = rhexis_receiver_latest(receiver, out(&mut model));
    refused(answer, RhexisStatus::NotFound, "no model has been sent yet");
    let forceps = forceps_at(world, pose(3.0, 3.0, 0.0));
    let answer = rhexis_haptics_model(haptics, world, forceps, out(&mut model));
    refused(answer, RhexisStatus::Refused, "hold nothing");
    close(world, forceps, body);
    ok(rhexis_forceps_move(world, forceps, input(&pose(3.0, 3.0, 0.5)), 5.0));
    ok(rhexis_step(world, 5.0, Out::NULL));
    ok(rhexis_haptics_model(haptics, world, forceps, out(&mut model)));
    ok(rhexis_step(world, 5.0, Out::NULL));
    ok(rhexis_haptics_refresh(haptics, world, forceps, out(&mut model)));
    let felt = std::thread::spawn(move || {
        let (mut latest, mut force) = (RhexisHapticModel::default(), RhexisVec3::default());
        ok(rhexis_receiver_latest(receiver, out(&mut latest)));
        ok(rhexis_receiver_force(receiver, 1.0, latest.position, out(&mut force)));
        latest
    });
    assert_eq!(felt.join().unwrap(), model);
    ok(rhexis_haptic_force_at(input(&model), model.position, out(&mut force)));
    assert_eq!(force, model.force);
    ok(rhexis_haptics_model_of_pins(haptics, world, body, text(c"rim"), Out::NULL));
    let answer = rhexis_receiver_force(receiver, f64::NAN, model.position, out(&mut force));
    refused(answer, RhexisStatus::InvalidArgument, "both must be finite");
    ok(rhexis_haptics_destroy(haptics));
    ok(rhexis_receiver_latest(receiver, out(&mut model)));
    ok(rhexis_receiver_destroy(receiver));
    ok(rhexis_world_destroy(world));
}
