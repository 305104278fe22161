//! What tips meet on their way, and how far they go in a step.

use crate::common::{GRIP_SPEED, Run, SIDE, Square, state_bits};
use crate::meshes::tears::{angles, cutter, nearest};
use crate::meshes::{self, Body};
use glam::{DVec2, DVec3};
use rhexis::components::{Curve, Grip, Grips, Hold, Jaws, Path, TearMode, Tearing};
use rhexis::event::{Event, EventKind};
use rhexis::membrane::Membrane;
use rhexis::settings::Settings;
use rhexis::simulation::Simulation;
use rhexis::storage::{Attached, Tips, measure};
use rhexis::systems::fracture::{TearRefusal, TearScratch};

fn mm(x: f64, y: f64) -> DVec3 {
    DVec3::new(x, y, 0.0)
}

/// An isotropic square with these cuts, pulled along x: tears run along y.
fn square(cells: [usize; 2], cuts: &[[DVec3; 2]]) -> Square {
    let mut square = Square::isotropic(cells);
    square.notches = cuts.to_vec();
    square.tearing.radius = 3.0;
    square
}

/// A body of the square that is drawn apart to `u` \[mm\] on either side, statically.
fn spawn(square: &Square, membrane: Membrane, settings: Settings, u: f64) -> Run {
    let mut simulation = Simulation::new(settings).unwrap();
    let body = simulation.spawn(membrane).unwrap();
    for cut in &square.notches {
        simulation.cut(body, cut).unwrap();
    }
    let events = simulation.drain_events().collect();
    let world = simulation.world();
    let area = measure::total_area(&world.get::<&rhexis::storage::Triangles>(body.entity()).unwrap());
    let mass = measure::total_mass(&world.get::<&rhexis::storage::Vertices>(body.entity()).unwrap());
    let mut run = Run { simulation, body, events, area, mass };
    run.stretch_to(u);
    run
}

fn of_kind(run: &Run, is_wanted: impl Fn(&EventKind) -> bool) -> Vec<&Event> {
    run.events.iter().filter(|event| is_wanted(&event.kind)).collect()
}

fn tip_count(run: &Run) -> usize {
    run.simulation.world().get::<&Tips>(run.body.entity()).unwrap().len()
}

#[test]
fn tips_that_meet_merge() {
    // Head on; a fraction of an edge aside.
    for (cells, aside) in [([20, 18], 0.0), ([20, 18], 0.4)] {
        let run = face_to_face(cells, aside, TearMode::Free);
        let log = run.log();
        assert_eq!((log.fragment_count, log.end_count, log.refusal_count), (1, 2, 0), "{cells:?} {aside}");
        assert_eq!((run.fragment_count(), tip_count(&run)), (2, 0), "{cells:?} {aside}");
        // Tips that glide may go past each other by less than an edge, as by whole triangles farther aside.
        assert_parted(&face_to_face(cells, aside, TearMode::Glide));
    }
    // Without symmetry one may end on the other's lip.
    for mode in [TearMode::Free, TearMode::Glide] {
        assert_parted(&face_to_face([21, 17], 0.2, mode));
    }
}

/// Farther aside they pass each other before one of them ends on the other's lip; the second may stay, or cut a lens out.
#[test]
fn tips_that_pass_each_other_part_the_sheet() {
    for aside in [0.75, 1.2, 2.0] {
        for mode in [TearMode::Free, TearMode::Glide] {
            assert_parted(&face_to_face([20, 18], aside, mode));
        }
    }
}

/// A sheet that two tips have parted.
fn assert_parted(run: &Run) {
    let log = run.log();
    println!("{} ended, {} pieces", log.end_count, run.fragment_count());
    assert!(log.fragment_count >= 1 && log.end_count >= 1 && log.refusal_count == 0, "{log:?}");
    assert_eq!(run.fragment_count() as u32, 1 + log.fragment_count);
    // A lens smaller than the disc leaves a notch that is a tip.
    assert_eq!(tip_count(run) as u32, 2 + log.renewed_count - log.end_count);
}

/// A notch from above and one from below, so far \[mm\] aside, until they have parted the sheet.
fn face_to_face(cells: [usize; 2], aside: f64, mode: TearMode) -> Run {
    let cuts = [[mm(15.0, 30.0), mm(15.0, 22.0)], [mm(15.0 + aside, 0.0), mm(15.0 + aside, 8.0)]];
    let mut square = square(cells, &cuts);
    square.tearing.mode = mode;
    let mut run = spawn(&square, square.membrane(), Settings::default(), 0.4);
    run.run_until(150, |run| run.log().fragment_count > 0);
    run.assert_sound();
    run
}

#[test]
fn a_tear_that_meets_a_lip_ends_there() {
    for (sheet, aside) in [(meshes::grid(20, 18, 20.0, 18.0), 0.0), (meshes::jittered(20, 18, 20.0, 18.0, 4), 0.3)] {
        let mut body = Body::new(&sheet, DVec3::X);
        let mut scratch = TearScratch::default();
        let slit = cutter(&mut body.mesh(), &mut scratch).cut(&[mm(6.3, 8.2), mm(13.8, 8.9)]).unwrap().remove(0);
        let mut tip = nearest(&body, mm(10.0, 0.0));
        let end = loop {
            let direction = mm(aside, 1.0).normalize();
            let advance = cutter(&mut body.mesh(), &mut scratch).advance(tip, direction).unwrap();
            tip = advance.vertex;
            if let Some(end) = advance.end {
                break end;
            }
        };
        assert_eq!((end.freed, body.topology.components().0, body.mesh().validate()), (None, 1, Ok(())));
        let [a, b] = [slit.path[0], slit.path[slit.path.len() - 1]];
        let at = body.vertices.rest_position[tip as usize];
        assert!((b - a).normalize().cross(at - a).length() < 1e-9, "on the slit, which nothing has moved: {at}");
        // The slit's own tips go on.
        for (vertex, direction) in slit.tips {
            let advance = cutter(&mut body.mesh(), &mut scratch).advance(vertex, direction).unwrap();
            assert_eq!(advance.end, None);
        }
        assert!(angles(&body).0 >= 10.0);
    }
}

#[test]
fn a_tear_that_meets_itself_frees_a_piece() {
    let mut body = Body::new(&meshes::jittered(20, 20, 20.0, 20.0, 1), DVec3::X);
    let mut scratch = TearScratch::default();
    let mut tip = nearest(&body, mm(10.0, 0.0));
    let mut direction = DVec3::Y;
    let mut count = 0;
    let end = loop {
        let advance = cutter(&mut body.mesh(), &mut scratch).advance(tip, direction).unwrap();
        assert_eq!(body.mesh().validate(), Ok(()));
        (tip, count) = (advance.vertex, count + 1);
        if let Some(end) = advance.end {
            break end;
        }
        // To the left all the time: a circle of radius 4 through (10, 4), into the straight part or its own beginning.
        let arm = advance.to - mm(6.0, 4.0);
        direction = if advance.to.y < 4.0 && count < 8 { DVec3::Y } else { DVec3::Z.cross(arm).normalize() };
    };
    assert!(end.freed.is_some_and(|freed| freed > 20), "{end:?}");
    assert_eq!(body.topology.components().0, 2);
    assert!(angles(&body).0 >= 10.0);
}

#[test]
fn the_smallest_meshes_tear() {
    // Two triangles with the diagonal from (0, 0) to (1, 1): the other two corners have a single triangle each.
    let mut body = Body::new(&meshes::grid(1, 1, 1.0, 1.0), DVec3::X);
    let mut scratch = TearScratch::default();
    let across = mm(-1.0, 1.0).normalize();
    let first = cutter(&mut body.mesh(), &mut scratch).advance(1, across).unwrap();
    assert_eq!((first.end, first.to.distance(mm(0.5, 0.5)) < 1e-15), (None, true));
    let second = cutter(&mut body.mesh(), &mut scratch).advance(first.vertex, across).unwrap();
    assert_eq!(second.end.unwrap().freed, Some(2));
    assert_eq!((body.topology.components().0, body.mesh().validate()), (2, Ok(())));
    // Along the diagonal, from the corner where two triangles meet.
    let mut body = Body::new(&meshes::grid(1, 1, 1.0, 1.0), DVec3::X);
    let along = cutter(&mut body.mesh(), &mut scratch).advance(0, mm(1.0, 1.0).normalize()).unwrap();
    assert_eq!((along.end.unwrap().freed, body.mesh().validate()), (Some(1), Ok(())));
    // A single triangle: from each corner to the far side.
    let mut body = Body::new(
        &meshes::Sheet { positions: vec![mm(0.0, 0.0), mm(1.0, 0.0), mm(0.5, 0.9)], corners: vec![[0, 1, 2]] },
        DVec3::X,
    );
    scratch.records.clear();
    let split = cutter(&mut body.mesh(), &mut scratch).advance(0, mm(0.75, 0.45).normalize()).unwrap();
    assert_eq!((split.end.unwrap().freed, body.triangles.len(), body.mesh().validate()), (Some(1), 2, Ok(())));
    let stuck = cutter(&mut body.mesh(), &mut scratch).advance_along_edge(0, DVec3::ZERO, DVec3::X);
    assert_eq!(stuck, Err(TearRefusal::NoForwardEdge { vertex: 0 }), "edge mode has no edge inside a lone triangle");
}

/// What has hold of a vertex has hold of both lips: the tear goes on, stays shut there, and says so.
#[test]
fn a_held_vertex_on_the_path_is_kept_shut_and_told() {
    let cuts = [[mm(15.0, 30.0), mm(15.0, 26.0)]];
    let square = square([20, 20], &cuts);
    let pinned = square.membrane().select(|p| p.distance(mm(15.0, 15.0)) < 1e-9);
    let pin = Hold {
        name: "pin".into(),
        members: Attached::new(pinned.iter().map(|&row| (row, DVec3::ZERO))),
        axes: [true; 3],
        curve: Curve::constant(0.0),
    };
    let grip = Grip {
        name: "forceps".into(),
        near_tip: None,
        from: 0.0,
        until: f64::INFINITY,
        material_point: mm(15.0, 15.0),
        jaws: Jaws { radius: 0.1, stiffness: Some(1000.0), ..Jaws::default() },
        path: Path { points: vec![(0.0, DVec3::ZERO)] },
        turns: Path::default(),
    };
    for (what, membrane) in
        [("hold", square.membrane().hold(pin)), ("grip", square.membrane().with(Grips::new(vec![grip])))]
    {
        let mut run = spawn(&square, membrane, Settings::default(), 0.5);
        run.run_until(100, |run| run.log().end_count > 0);
        run.assert_sound();
        let shut: Vec<DVec3> = run
            .events
            .iter()
            .filter_map(|e| if let EventKind::HeldShut { at } = e.kind { Some(at) } else { None })
            .collect();
        assert_eq!(shut.len() as u32, run.log().held_shut_count);
        assert_eq!((shut.len(), run.fragment_count()), (1, 2), "{what}");
        assert!(shut[0].distance(mm(15.0, 15.0)) < 1e-9);
        let vertices = run.vertices();
        let copies: Vec<usize> =
            (0..vertices.len()).filter(|&v| vertices.rest_position[v].distance(shut[0]) < 1e-9).collect();
        let gap = vertices.position[copies[0]].distance(vertices.position[copies[1]]);
        println!("{what}: the lips are {gap:.1e} mm apart");
        // The hold is rigid; the grip's springs carry the sheet's 0.5 N or so.
        assert!(copies.len() == 2 && gap < if what == "hold" { 1e-14 } else { 0.05 }, "{what}: {gap}");
    }
}

#[test]
fn a_cut_through_a_tip_ends_it() {
    let square = square([20, 18], &[[mm(15.0, 30.0), mm(15.0, 22.0)], [mm(5.0, 22.0), mm(25.0, 22.0)]]);
    let run = spawn(&square, square.membrane(), Settings::default(), 0.0);
    // The slit goes through the notch's end, or into it: whichever, no tip stays behind on a lip.
    assert!(run.log().end_count > 0, "{:?}", run.events);
    let world = run.simulation.world();
    let tips = world.get::<&Tips>(run.body.entity()).unwrap();
    for &vertex in &tips.vertex {
        assert!(run.vertices().rest_position[vertex as usize].distance(mm(15.0, 22.0)) > 1.0);
    }
    // From a tip on: the tear goes on, its tip stands at the end.
    let square = self::square([20, 18], &[[mm(15.0, 30.0), mm(15.0, 22.0)], [mm(15.0, 22.0), mm(17.0, 18.0)]]);
    let run = spawn(&square, square.membrane(), Settings::default(), 0.0);
    assert_eq!((run.log().end_count, tip_count(&run)), (0, 1));
}

/// Four tips, in the order of their rows within each pass of a step, and the same bits on one thread and on two.
#[test]
fn several_tips_advance_in_one_step_in_a_fixed_order() {
    let cuts = [
        [mm(7.5, 30.0), mm(7.5, 26.0)],
        [mm(22.5, 30.0), mm(22.5, 26.0)],
        [mm(7.5, 0.0), mm(7.5, 4.0)],
        [mm(22.5, 0.0), mm(22.5, 4.0)],
    ];
    let square = square([20, 20], &cuts);
    let runs = [1, 2].map(|threads| {
        let mut run = spawn(&square, square.membrane(), Settings { threads, ..Settings::default() }, 0.9);
        run.run_until(100, |run| run.advances().len() >= 12);
        run
    });
    assert_eq!(state_bits(&runs[0].simulation, runs[0].body), state_bits(&runs[1].simulation, runs[1].body));
    let keys = |run: &Run| -> Vec<_> {
        run.events
            .iter()
            .filter_map(|e| if let EventKind::Advanced { tip, .. } = e.kind { Some((e.step, tip)) } else { None })
            .collect()
    };
    assert_eq!(keys(&runs[0]), keys(&runs[1]));
    let first_step: Vec<_> = keys(&runs[0]);
    let (step, first) = first_step[0];
    assert!(
        first_step[1..4].iter().all(|&(s, tip)| s == step && tip != first),
        "all four in the first step: {first_step:?}"
    );
    assert!(first_step[..4].windows(2).all(|w| w[0].1 < w[1].1), "in the order of their rows: {first_step:?}");
}

/// A tear that too few passes cut short goes on in the next step; more than those needed change nothing.
#[test]
fn resumes_beyond_those_needed_change_nothing() {
    let mut square = square([20, 18], &[[mm(15.0, 30.0), mm(15.0, 26.0)]]);
    square.tearing.mode = TearMode::Free;
    let run = |resumes: u32| {
        let mut run =
            spawn(&square, square.membrane(), Settings { max_tear_passes: resumes, ..Settings::default() }, 1.1);
        let mut was_cut_short = false;
        for _ in 0..3 {
            run.step();
            was_cut_short |= run.simulation.report().bodies[0].is_tear_cut_short;
        }
        (run, was_cut_short)
    };
    let [(few, short), (enough, is_short), (many, _)] = [1, 40, 100].map(run);
    assert!(short && !is_short);
    assert!(few.log().length < enough.log().length);
    assert_eq!(state_bits(&enough.simulation, enough.body), state_bits(&many.simulation, many.body));
    assert_eq!(enough.log(), many.log());
}

#[test]
fn a_quasi_static_tear_runs_until_no_tip_asks_and_says_if_it_may_not() {
    let cuts = [[mm(15.0, 30.0), mm(15.0, 26.0)], [mm(15.0, 0.0), mm(15.0, 4.0)]];
    let square = square([20, 18], &cuts);
    let mut run = spawn(&square, square.membrane(), Settings::default(), 0.7);
    let dt = 1.2 / GRIP_SPEED - run.simulation.time();
    let report = run.simulation.settle_and_tear(dt, 1e-8, 2).unwrap();
    assert!(report.bodies[0].is_tear_cut_short);
    let some = run.log().advance_count;
    assert_eq!(some, 4, "both tips in each round");
    // Under fixed grips the notches run together, unstably, and that comes to an end by itself.
    let report = run.simulation.settle_and_tear(0.0, 1e-8, 1000).unwrap();
    assert!(!report.bodies[0].is_tear_cut_short);
    run.events.extend(run.simulation.drain_events());
    run.assert_sound();
    assert_eq!((tip_count(&run), run.fragment_count(), run.log().refusal_count), (0, 2, 0));
}

/// A corner that nothing holds comes free, and the rest still finds its equilibrium.
#[test]
fn a_piece_without_a_hold_is_no_obstacle_to_equilibrium() {
    let square = square([20, 18], &[]);
    let mut run = spawn(&square, square.membrane(), Settings::default(), 0.1);
    let loop_around: Vec<DVec3> = (0..=8)
        .map(|k| mm(15.0, 15.0) + 5.0 * DVec2::from_angle(0.3 + std::f64::consts::TAU * f64::from(k) / 8.0).extend(0.0))
        .collect();
    let cut = run.simulation.cut(run.body, &loop_around).unwrap();
    assert_eq!((cut.fragment_count, run.fragment_count()), (1, 2));
    run.simulation.settle_and_tear(0.05 / GRIP_SPEED, 1e-8, 10).unwrap();
    run.step();
    run.assert_sound();
}

#[test]
fn a_coarse_mesh_is_told_once_per_tip() {
    let mut square = square([20, 18], &[[mm(15.0, 30.0), mm(15.0, 26.0)], [mm(15.0, 0.0), mm(15.0, 4.0)]]);
    let told = |run: &Run| of_kind(run, |kind| matches!(kind, EventKind::UnderResolved { .. })).len();
    for (radius, count) in [(6.0, 0), (2.0, 2)] {
        square.tearing.radius = radius;
        let mut run = spawn(&square, square.membrane(), Settings::default(), 0.9);
        run.run_until(60, |run| run.advances().len() >= 8);
        assert_eq!(told(&run), count, "R = {radius} mm");
    }
}

/// Where a sheet tears by itself.
fn started(square: &Square, is_thin: impl Fn(DVec3) -> bool + Send + Sync + 'static) -> Run {
    let material = square.material;
    let membrane = square.membrane().graded(move |p| {
        let mut material = material;
        material.thickness *= if is_thin(p) { 0.6 } else { 1.0 };
        material
    });
    let mut run = spawn(square, membrane, Settings::default(), 0.5);
    run.run_until(200, |run| run.log().nucleation_count > 0);
    run
}

fn initiating(cells: [usize; 2], mode: TearMode) -> Square {
    let mut square = square(cells, &[]);
    square.tearing = Tearing { may_initiate: true, mode, ..square.tearing };
    square
}

#[test]
fn a_tear_starts_at_a_weak_boundary_with_one_tip_and_inside_with_two() {
    for mode in [TearMode::Free, TearMode::Edge] {
        let square = initiating([20, 18], mode);
        for (thin, tips) in [(mm(15.0, 0.0), 1), (mm(15.0, 15.0), 2)] {
            let run = started(&square, move |p| p.distance(thin) < 4.0);
            let starts: Vec<DVec3> = run
                .events
                .iter()
                .filter_map(|e| match e.kind {
                    EventKind::Started { at, verdict, .. } => verdict.map(|_| at),
                    _ => None,
                })
                .collect();
            assert_eq!((starts.len(), tip_count(&run)), (tips, tips), "{mode:?} {thin}");
            assert!(starts.iter().all(|at| at.distance(thin) < 4.0 + square.edge()), "{mode:?} {thin}: {starts:?}");
            if mode == TearMode::Edge {
                assert_eq!(run.triangle_count(), 2 * 20 * 18, "edge mode makes no triangle");
            }
            run.assert_sound();
        }
    }
}

/// A start counts as progress: the tear that has begun is followed to its equilibrium.
#[test]
fn a_quasi_static_start_is_followed_until_no_tip_asks() {
    let square = initiating([20, 18], TearMode::Free);
    let material = square.material;
    let membrane = square.membrane().graded(move |p| {
        let mut material = material;
        material.thickness *= if p.distance(mm(15.0, 15.0)) < 4.0 { 0.6 } else { 1.0 };
        material
    });
    let mut run = spawn(&square, membrane, Settings::default(), 0.7);
    let dt = 0.9 / GRIP_SPEED - run.simulation.time();
    let report = run.simulation.settle_and_tear(dt, 1e-8, 1000).unwrap();
    assert!(!report.bodies[0].is_tear_cut_short);
    run.events.extend(run.simulation.drain_events());
    run.assert_sound();
    let log = run.log();
    println!("{log:?}");
    assert!(log.nucleation_count > 0 && log.advance_count > 0 && log.refusal_count == 0, "{log:?}");
    let tips = run.simulation.frame().bodies[0].tips.iter().map(|tip| tip.value).fold(0.0, f64::max);
    assert!(tips <= 1.0, "{tips}");
}

/// The corners of the grips are singular, but no tear starts there: the square fails elsewhere, at a higher load.
#[test]
fn no_tear_starts_at_a_clamp() {
    let square = initiating([20, 18], TearMode::Free);
    let run = started(&square, |_| false);
    for event in &run.events {
        if let EventKind::Started { at, .. } = event.kind {
            println!("started at {at}, u = {:.2} mm", event.time * GRIP_SPEED);
            // One tip of a start may run back towards the clamp by an edge.
            assert!(
                at.x > square.tearing.radius - square.edge() && at.x < SIDE - square.tearing.radius + square.edge()
            );
        }
    }
}

#[test]
fn starts_keep_their_distance_from_each_other() {
    let square = initiating([20, 18], TearMode::Free);
    let mut run = started(&square, |p| p.distance(mm(8.0, 15.0)) < 3.0 || p.distance(mm(22.0, 15.0)) < 3.0);
    run.run_until(30, |run| run.log().nucleation_count >= 2);
    let starts: Vec<(u64, DVec3)> = run
        .events
        .iter()
        .filter_map(|e| if let EventKind::Started { at, .. } = e.kind { Some((e.step, at)) } else { None })
        .collect();
    let apart = starts
        .iter()
        .flat_map(|&(s, p)| starts.iter().filter(move |&&(t, _)| s != t).map(move |&(_, q)| p.distance(q)));
    // But for the two edges of a slit.
    assert!(apart.fold(f64::INFINITY, f64::min) > 2.0 * square.tearing.radius - 2.0 * square.edge(), "{starts:?}");
    run.assert_sound();
}

/// Tissue so weak that it tears everywhere: until nothing hangs together, and nothing breaks in the program.
#[test]
fn a_sheet_torn_to_shreds_stays_sound() {
    for (mode, material) in [(TearMode::Free, 0), (TearMode::Edge, 0), (TearMode::Free, 1), (TearMode::Edge, 1)] {
        let mut square = if material == 0 { initiating([12, 11], mode) } else { Square::new([12, 11], 30.0) };
        square.notches.clear();
        square.tearing = Tearing { may_initiate: true, mode, radius: 1.0, ..square.tearing };
        let mut run = spawn(&square, square.membrane(), Settings::default(), 0.8);
        for step in 0..150 {
            run.step();
            if step % 10 == 0 {
                run.assert_sound();
            }
        }
        run.assert_sound();
        let log = run.log();
        println!("{mode:?}: {log:?}, {} pieces", run.fragment_count());
        // Tears as long as the sheet is high, from many places.
        assert!(log.nucleation_count > 3 && log.length > 30.0, "{log:?}");
        assert_eq!(run.fragment_count() as u32, 1 + log.fragment_count);
        assert!(mode == TearMode::Free || run.triangle_count() == 2 * 12 * 11);
    }
}
