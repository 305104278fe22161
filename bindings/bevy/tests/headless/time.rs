//! Steps of one length under frames of any, and what is shown between them.

use crate::common::*;
use bevy::prelude::*;
use bevy_rhexis::*;

#[test]
fn a_frame_between_two_steps_shows_the_tissue_between_them() {
    let mut app = app_of(RhexisPlugin { is_interpolated: true, ..plugin() }, 4);
    let (tissue, body) = spawn(&mut app, Tissue::new(sheet("sheet")));
    let hand = hand(&mut app, tissue);
    let mut seen = Vec::new();
    for _ in 0..60 {
        app.world_mut().get_mut::<Transform>(hand).unwrap().translation.x += 0.02;
        app.update();
        let shown = positions(&app, tissue);
        let mut world = engine(&mut app);
        let alpha = world.clock().alpha();
        let (mut expected, mut before) = (Vec::new(), Vec::new());
        let view = world.simulation_mut().view(body).unwrap();
        view.positions_before((1.0 - alpha) * DT, &mut expected);
        view.positions_before(DT, &mut before);
        let last = view.positions;
        for (at, (shown, expected)) in shown.iter().zip(&expected).enumerate() {
            assert_eq!(*shown, expected.as_vec3().to_array());
            let line = before[at].lerp(last[at], alpha);
            assert!((line - *expected).length() < 1e-12);
        }
        seen.push(shown.iter().map(|p| p[0]).fold(0.0, f32::max));
    }
    // Two of five frames have no step, and the tissue still moves in every one.
    let ways: Vec<f32> = seen.windows(2).skip(10).map(|pair| pair[1] - pair[0]).collect();
    assert!(ways.iter().all(|way| *way > 0.01 && *way < 0.04), "{ways:?}");
}

#[test]
fn the_tissue_moves_alike_at_any_rate_of_frames() {
    let ends = [5, 10, 20].map(|frame| {
        let mut app = app_of(plugin(), frame);
        let (tissue, _) = spawn(&mut app, Tissue::new(sheet("sheet")));
        let hand = hand(&mut app, tissue);
        // So much that all have the same time behind them.
        let begin = engine(&mut app).simulation().time();
        while engine(&mut app).simulation().time() < begin + 400.0 {
            let way = 0.002 * frame as f32;
            app.world_mut().get_mut::<Transform>(hand).unwrap().translation.x += way;
            app.update();
        }
        let body = body(&app, tissue);
        engine(&mut app).simulation().reactions(body).unwrap()[1].1.x
    });
    assert!(ends.iter().all(|end| (end / ends[0] - 1.0).abs() < 0.1), "{ends:?}");
}

#[test]
fn time_can_be_paused_and_slowed() {
    let mut app = app();
    spawn(&mut app, Tissue::new(sheet("sheet")));
    app.world_mut().resource_mut::<Time<Virtual>>().set_relative_speed(0.5);
    let begin = engine(&mut app).simulation().time();
    (0..10).for_each(|_| app.update());
    let slow = engine(&mut app).simulation().time() - begin;
    assert!((slow - 50.0).abs() <= DT, "{slow}");
    app.world_mut().resource_mut::<Time<Virtual>>().pause();
    app.update();
    let begin = engine(&mut app).simulation().time();
    (0..10).for_each(|_| app.update());
    assert_eq!(engine(&mut app).simulation().time(), begin);
}

#[test]
fn what_does_not_fit_into_a_frame_is_lost() {
    let mut app = app_of(RhexisPlugin { most_steps: 2, ..plugin() }, 50);
    spawn(&mut app, Tissue::new(sheet("sheet")));
    (0..4).for_each(|_| app.update());
    let mut world = engine(&mut app);
    assert!(world.clock().lost() >= 90.0, "{}", world.clock().lost());
    assert!(world.simulation_mut().time() <= 100.0);
    assert!(world.step_time() > std::time::Duration::ZERO);
}

#[test]
fn a_world_in_metres_lies_where_it_is_told_to() {
    let turn = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
    let transform = Transform::from_xyz(1.0, 2.0, 3.0).with_rotation(turn).with_scale(bevy::math::Vec3::splat(1e-3));
    let mut app = app_of(RhexisPlugin { space: transform, ..plugin() }, 10);
    let (tissue, body) = spawn(&mut app, Tissue::new(sheet("sheet")));
    assert_eq!(*app.world().get::<Transform>(tissue).unwrap(), transform);
    // A corner of the sheet, in the world.
    let corner = transform.transform_point(bevy::math::Vec3::new(SIDE as f32, SIDE as f32, 0.0));
    let forceps = forceps(&mut app, corner);
    app.world_mut().get_mut::<Transform>(forceps).unwrap().rotation = turn;
    close(&mut app, forceps, true);
    app.update();
    let state = app.world().get::<ForcepsState>(forceps).unwrap().clone();
    assert_eq!(state.tissue, Some(tissue));
    let pose = state.pose().unwrap();
    assert!((pose.position - bevy_rhexis::rhexis::glam::DVec3::new(SIDE, SIDE, 0.0)).length() < 1e-3, "{pose:?}");
    assert!(pose.orientation.w > 0.999_999, "{pose:?}");
    let space = *engine(&mut app).space();
    let there = space.to_world(space.to_engine(corner));
    assert!(there.distance(corner) < 1e-6);
    assert!(engine(&mut app).simulation().world().contains(body.entity()));
}
