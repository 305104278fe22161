//! Forceps and pins that transforms move.

use crate::common::*;
use bevy::prelude::*;
use bevy_rhexis::rhexis::event::EventKind;
use bevy_rhexis::rhexis::prelude::{Jaws, Slip};
use bevy_rhexis::*;

const PLACE: Vec3 = Vec3::new(SIDE as f32 / 2.0 + 1.0, SIDE as f32 - 0.5, 0.2);

fn state(app: &App, forceps: Entity) -> ForcepsState {
    app.world().get::<ForcepsState>(forceps).unwrap().clone()
}

fn is_closed(app: &App, forceps: Entity) -> bool {
    app.world().get::<Forceps>(forceps).unwrap().is_closed
}

#[test]
fn forceps_grip_tear_and_let_go() {
    let mut app = app();
    let (tissue, body) = spawn(&mut app, Tissue::new(sheet("sheet")));
    notch(&mut app, body);
    let forceps = forceps(&mut app, PLACE);
    app.update();
    assert_eq!(state(&app, forceps).tissue, None);
    close(&mut app, forceps, true);
    app.update();
    assert_eq!(state(&app, forceps).tissue, Some(tissue));
    let (mut advances, mut peak) = (0, 0.0_f64);
    for _ in 0..150 {
        draw(&mut app, forceps, 1);
        peak = peak.max(state(&app, forceps).force.x);
        let events = messages::<TissueEvent>(&mut app);
        advances += events.iter().filter(|event| matches!(event.event.kind, EventKind::Advanced { .. })).count();
        assert!(events.iter().all(|event| event.tissue == Some(tissue)));
    }
    assert!(advances > 3 && peak > 0.01, "{advances} advances, {peak} N");
    assert_shows(&mut app, tissue);
    close(&mut app, forceps, false);
    app.update();
    let state = state(&app, forceps);
    assert_eq!((state.tissue, state.force.length()), (None, 0.0));
    assert_eq!(messages::<RhexisError>(&mut app), []);
}

#[test]
fn nothing_to_take_is_told_and_the_jaws_open_again() {
    let mut app = app();
    spawn(&mut app, Tissue::new(sheet("sheet")));
    let forceps = forceps(&mut app, Vec3::new(5.0, 5.0, 3.0));
    close(&mut app, forceps, true);
    app.update();
    let told = messages::<RhexisError>(&mut app);
    assert_eq!(told.len(), 1);
    let expected = format!(
        "entity {forceps} (`forceps`): forceps `forceps` find no tissue to take: come nearer, or give more reach"
    );
    assert_eq!(told[0].to_string(), expected);
    assert!(!is_closed(&app, forceps));
    app.update();
    assert_eq!(messages::<RhexisError>(&mut app), []);
}

#[test]
fn jaws_that_slip_are_open() {
    let mut app = app();
    let (tissue, _) = spawn(&mut app, Tissue::new(sheet("sheet")));
    let jaws = Jaws { force_limit: Some(1e-3), slip: Slip::LetGo, ..jaws() };
    let forceps = app.world_mut().spawn((Forceps::new(jaws, 1.0), Transform::from_translation(PLACE))).id();
    close(&mut app, forceps, true);
    app.update();
    assert_eq!(state(&app, forceps).tissue, Some(tissue));
    let mut slipped = false;
    for _ in 0..50 {
        draw(&mut app, forceps, 1);
        let events = messages::<TissueEvent>(&mut app);
        slipped |= events.iter().any(|event| matches!(event.event.kind, EventKind::Slipped { is_open: true, .. }));
    }
    assert!(slipped && !is_closed(&app, forceps));
    assert_eq!(state(&app, forceps).tissue, None);
}

#[test]
fn refused_jaws_are_told_once_and_taken_when_mended() {
    let mut app = app();
    spawn(&mut app, Tissue::new(sheet("sheet")));
    let jaws = Jaws { radius: -1.0, ..jaws() };
    let forceps = app.world_mut().spawn((Forceps::new(jaws, 1.0), Transform::from_translation(PLACE))).id();
    let mut told = Vec::new();
    for _ in 0..4 {
        app.update();
        told.extend(messages::<RhexisError>(&mut app));
    }
    assert_eq!(told.len(), 1, "{told:?}");
    assert!(told[0].to_string().contains("grip radius"), "{}", told[0]);
    app.world_mut().get_mut::<Forceps>(forceps).unwrap().jaws.radius = 1.0;
    app.update();
    assert!(state(&app, forceps).tool().is_some());
}

#[test]
fn pins_draw_a_side_and_feel_it() {
    let mut app = app();
    let (tissue, body) = spawn(&mut app, Tissue::new(sheet("sheet")));
    let hand = hand(&mut app, tissue);
    app.update();
    draw(&mut app, hand, 20);
    let pins = app.world().get::<PinsState>(hand).unwrap().clone();
    assert_eq!(pins.count, 15);
    assert!(pins.force.x > 1e-3, "{}", pins.force);
    let rows = |app: &mut App| {
        let mut world = engine(app);
        let view = world.simulation_mut().view(body).unwrap();
        let all = view.positions.iter().zip(view.rest_positions);
        all.filter(|(_, rest)| rest.x == SIDE).map(|(at, rest)| (*at, *rest)).collect::<Vec<_>>()
    };
    let moved = rows(&mut app);
    assert!(moved.iter().all(|(at, rest)| (at.x - rest.x - 1.0).abs() < 1e-5), "{moved:?}");
    // Turned by a right angle about the transform's place, all of them.
    let mut transform = app.world_mut().get_mut::<Transform>(hand).unwrap();
    transform.rotation = Quat::from_rotation_z(0.1);
    app.update();
    let turned = rows(&mut app);
    for ((at, _), (before, _)) in turned.iter().zip(&moved) {
        let (x, y) = (before.x - 1.0, before.y);
        let expected = (1.0 + x * 0.1_f64.cos() - y * 0.1_f64.sin(), x * 0.1_f64.sin() + y * 0.1_f64.cos());
        assert!((at.x - expected.0).abs() < 1e-4 && (at.y - expected.1).abs() < 1e-4, "{at} {expected:?}");
    }
    // Without the component the side springs back.
    app.world_mut().entity_mut(hand).remove::<Pins>();
    (0..200).for_each(|_| app.update());
    assert!(rows(&mut app).iter().all(|(at, rest)| at.distance(*rest) < 0.2));
    assert_eq!(messages::<RhexisError>(&mut app), []);
}

#[test]
fn a_transform_that_is_not_finite_is_told_once_and_moves_nothing() {
    let mut app = app();
    let (tissue, _) = spawn(&mut app, Tissue::new(sheet("sheet")));
    let (hand, forceps) = (hand(&mut app, tissue), forceps(&mut app, PLACE));
    close(&mut app, forceps, true);
    draw(&mut app, hand, 2);
    for bad in [Vec3::new(f32::NAN, 0.0, 0.0), Vec3::splat(f32::INFINITY)] {
        let mut told = Vec::new();
        for entity in [hand, forceps] {
            move_to(&mut app, entity, bad);
        }
        for _ in 0..3 {
            app.update();
            told.extend(messages::<RhexisError>(&mut app));
        }
        let mut entities: Vec<_> = told.iter().filter_map(|error| error.entity).collect();
        entities.sort();
        let mut both = vec![hand, forceps];
        both.sort();
        assert_eq!(entities, both);
        assert!(told.iter().all(|error| error.cause == Cause::BadTransform), "{told:?}");
        move_to(&mut app, hand, Vec3::ZERO);
        move_to(&mut app, forceps, PLACE);
        app.update();
        assert_eq!(messages::<RhexisError>(&mut app), []);
    }
    assert!(positions(&app, tissue).iter().flatten().all(|x| x.is_finite()));
    // A scale of zero has no rotation.
    app.world_mut().get_mut::<Transform>(forceps).unwrap().scale = Vec3::ZERO;
    app.update();
    assert_eq!(messages::<RhexisError>(&mut app).len(), 1);
}

#[test]
fn pins_on_what_is_no_tissue_are_refused() {
    let mut app = app();
    let (tissue, _) = spawn(&mut app, Tissue::new(sheet("sheet")));
    let gone = app.world_mut().spawn_empty().id();
    app.world_mut().despawn(gone);
    let stale = app.world_mut().spawn((Name::new("hand"), Pins::within(gone, 1.0))).id();
    let far = app.world_mut().spawn((Pins::within(tissue, 1.0), Transform::from_xyz(0.0, 0.0, 9.0))).id();
    app.update();
    let mut told = messages::<RhexisError>(&mut app);
    told.sort_by_key(|error| error.entity);
    let causes: Vec<_> = told.iter().map(|error| (error.entity, error.cause.clone())).collect();
    assert!(causes.contains(&(Some(stale), Cause::NoSuchTissue(gone))), "{causes:?}");
    assert!(causes.contains(&(Some(far), Cause::NothingToPin(Some(1.0)))), "{causes:?}");
    assert!(told.iter().any(|error| error.to_string().contains("(`hand`)")));
    assert!(app.world().get::<Pins>(stale).is_none() && app.world().get::<Pins>(far).is_none());
    // Pins of a tissue that is despawned are told, and hold nothing.
    let hand = hand(&mut app, tissue);
    app.update();
    app.world_mut().despawn(tissue);
    app.update();
    let told = messages::<RhexisError>(&mut app);
    assert_eq!(told.len(), 1, "{told:?}");
    assert_eq!((told[0].entity, &told[0].cause), (Some(hand), &Cause::NoSuchTissue(tissue)));
}

#[test]
fn two_pins_of_one_name_hold_each_their_own() {
    let mut app = app();
    let (tissue, body) = spawn(&mut app, Tissue::new(sheet("sheet")));
    let first = hand(&mut app, tissue);
    let second = app.world_mut().spawn((Name::new("hand"), Pins::of_rest(tissue, |p| p.x == SIDE / 2.0))).id();
    draw(&mut app, first, 5);
    app.world_mut().despawn(first);
    draw(&mut app, second, 5);
    assert_eq!(messages::<RhexisError>(&mut app), []);
    let names: Vec<_> =
        engine(&mut app).simulation().reactions(body).unwrap().into_iter().map(|(name, _)| name).collect();
    assert_eq!(names, ["table".to_owned(), "hand".to_owned(), format!("hand {second}")]);
}
