//! The same bits through Bevy as through the engine's own calls, and again from a recording.

use crate::common::*;
use bevy::prelude::*;
use bevy_rhexis::rhexis::components::{Changes, Grasp, Pose};
use bevy_rhexis::rhexis::prelude::*;
use bevy_rhexis::rhexis::replay::Recording;
use bevy_rhexis::*;
use rhexis_scene::Document;

const FRAMES: u32 = 80;
const GRIP: [f32; 3] = [11.0, 19.5, 0.25];

/// Where hand and forceps are in a frame.
fn hand_at(frame: u32) -> bevy::math::Vec3 {
    bevy::math::Vec3::new(0.04 * frame as f32, 0.0, 0.01 * frame as f32)
}

fn forceps_at(frame: u32) -> bevy::math::Vec3 {
    let [x, y, z] = GRIP;
    bevy::math::Vec3::new(x + 0.05 * frame as f32, y + 0.01 * frame as f32, z)
}

fn double(v: bevy::math::Vec3) -> DVec3 {
    DVec3::from_array(v.to_array().map(f64::from))
}

fn shell() -> Membrane {
    sheet("sheet").with(rhexis::components::Refinement::default())
}

/// The scene through Bevy: hash at the end, and what was recorded.
fn through_bevy() -> (String, Recording) {
    // Two steps a frame.
    let mut app = app_of(plugin(), 2 * DT as u64);
    // The first frame takes no time.
    app.update();
    let body = engine(&mut app).simulation_mut().spawn(shell().with(Changes::default())).unwrap();
    notch(&mut app, body);
    engine(&mut app).simulation_mut().record();
    let tissue = app.world_mut().spawn(Tissue::of_body(body)).id();
    let hand = hand(&mut app, tissue);
    let forceps = forceps(&mut app, forceps_at(0));
    for frame in 0..FRAMES {
        move_to(&mut app, hand, hand_at(frame));
        move_to(&mut app, forceps, forceps_at(frame));
        close(&mut app, forceps, (5..60).contains(&frame));
        app.update();
        assert_eq!(messages::<RhexisError>(&mut app), [], "frame {frame}");
    }
    assert_shows(&mut app, tissue);
    let mut world = engine(&mut app);
    let recording = world.simulation_mut().end_recording().unwrap();
    (world.simulation().hash().to_string(), recording)
}

/// The same by the engine's calls.
fn plain() -> (String, usize) {
    let mut simulation = Simulation::new(Settings::new(Accuracy::Game)).unwrap();
    let body = simulation.spawn(shell()).unwrap();
    let line = [DVec3::new(SIDE / 2.0, SIDE, 0.0), DVec3::new(SIDE / 2.0, SIDE - 4.0, 0.0)];
    simulation.cut(body, &line).unwrap();
    let view = simulation.view(body).unwrap();
    let all = view.vertex_keys.iter().zip(view.rest_positions);
    let side: Vec<_> = all.filter(|(_, p)| p.x == SIDE).map(|(key, _)| *key).collect();
    let forceps = simulation.spawn_forceps("forceps", jaws(), Pose::at(double(forceps_at(0)))).unwrap();
    simulation.pin(body, "hand", &side).unwrap();
    let mut hand = Pose::at(double(hand_at(0)));
    let mut advances = 0;
    for frame in 0..FRAMES {
        let is_held = (6..60).contains(&frame);
        let within = if is_held || frame == 60 { 2.0 * DT } else { 0.0 };
        simulation.move_forceps(forceps, Pose::at(double(forceps_at(frame))), within).unwrap();
        match frame {
            5 => _ = simulation.close_forceps(forceps, body, &Grasp::Nearest { reach: 1.0 }).unwrap(),
            60 => _ = simulation.open_forceps(forceps).unwrap(),
            _ => {}
        }
        let target = Pose::at(double(hand_at(frame)));
        for part in [0.5, 1.0] {
            let next = hand.towards(&target, part);
            simulation.move_pins(body, "hand", |pin| next.carry(hand.place(pin.place))).unwrap();
            hand = next;
            simulation.step(DT).unwrap();
        }
        advances += simulation.drain_events().filter(|event| matches!(event.kind, EventKind::Advanced { .. })).count();
    }
    (simulation.hash().to_string(), advances)
}

#[test]
fn the_same_hash_through_bevy_as_by_the_engines_calls_and_from_the_recording() {
    let (plain, advances) = plain();
    assert!(advances > 10, "{advances}");
    let (through, recording) = through_bevy();
    assert_eq!(through, plain);
    let bytes = recording.to_bytes().unwrap();
    let again = Recording::from_bytes(&bytes).unwrap().replay().unwrap();
    assert_eq!(again.hash().to_string(), plain);
    println!("{advances} advances, hash {plain}, recording of {} bytes", bytes.len());
}

/// The scene that `bindings/web/test/plan.json` begins with, and what native and WebAssembly builds reach by it.
#[test]
fn a_scene_of_the_catalog_has_the_hash_that_it_has_in_rust_and_in_the_browser() {
    let plan = include_str!("../../../web/test/plan.json");
    let entry = plan.lines().find(|line| line.contains("\"fig2-tear\",\"steps\":500,\"hash\"")).unwrap();
    let (_, hash) = entry.split_once("\"hash\":\"").unwrap();
    let instance = Document::named("fig2-tear").unwrap().scene().unwrap().instantiate().unwrap();
    assert_eq!(instance.run.dt, DT);
    let mut app = app();
    app.insert_resource(RhexisWorld::new(instance.simulation, DT, 1).unwrap().interpolated(false));
    let tissue = app.world_mut().spawn(Tissue::of_body(instance.bodies[0])).id();
    // The first frame takes no time.
    (0..=500).for_each(|_| app.update());
    assert_shows(&mut app, tissue);
    let world = engine(&mut app);
    assert!((world.simulation().time() - 500.0 * DT).abs() < 1e-6, "{} ms", world.simulation().time());
    assert_eq!(world.simulation().hash().to_string(), hash[..16]);
}
