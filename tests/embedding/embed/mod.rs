//! What a program that embeds the engine relies on.

mod haptic_blend;
mod haptics;
mod inspect;
mod mirror;
mod pins;
mod systems;

use crate::common::{DT, Square};
use glam::{DQuat, DVec3};
use rhexis::components::{Changes, Contact, Obstacle, Shape, TearMode};
use rhexis::settings::{Advanced, LinearParams, Settings};
use rhexis::simulation::{
    BodyView, DebugKind, DebugLines, FixedStep, Hit, MotionError, Simulation, SimulationError, normals,
};

/// A simulation can be a resource of a game engine.
#[test]
fn a_simulation_goes_from_thread_to_thread() {
    fn is_shared<T: Send + Sync + 'static>() {}
    is_shared::<Simulation>();
}

#[test]
fn a_clock_makes_the_same_steps_at_any_rate_of_pictures() {
    let mut clock = FixedStep::new(5.0, 4).unwrap();
    let mut total = 0;
    // 60 pictures a second for a second.
    for _ in 0..60 {
        total += clock.steps_after(1000.0 / 60.0).unwrap();
        assert!((0.0..1.0).contains(&clock.alpha()));
    }
    // 1000/60 is not exact: the last step may be due one picture later.
    assert!((199..=200).contains(&total) && clock.lost() == 0.0);
    // A second of standstill is not made good.
    assert_eq!(clock.steps_after(1000.0).unwrap(), 4);
    assert!((clock.lost() - 980.0).abs() < 5.0 + 1e-9 && clock.alpha() < 1.0);
    let before = clock;
    for bad in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(clock.steps_after(bad), Err(SimulationError::OutOfRange(_))));
    }
    assert_eq!(clock, before);
    assert!(FixedStep::new(0.0, 4).is_err() && FixedStep::new(f64::NAN, 4).is_err() && FixedStep::new(5.0, 0).is_err());
}

#[test]
fn pictures_between_steps_lie_between_them_through_tears() {
    // By whole triangles, one in a step: tips that glide collapse vertices.
    let mut square = Square::new([20, 16], 60.0);
    square.tearing.mode = TearMode::Free;
    let mut run = square.spawn(Settings { max_tear_passes: 0, ..Settings::default() });
    run.stretch_to(0.6);
    let (mut drawn, mut counts) = (Vec::new(), 0);
    for _ in 0..40 {
        let (before, keys) = {
            let view = run.simulation.view(run.body).unwrap();
            (view.positions.to_vec(), view.vertex_keys.to_vec())
        };
        run.step();
        let view = run.simulation.view(run.body).unwrap();
        counts += usize::from(view.positions.len() > before.len());
        view.positions_before(0.0, &mut drawn);
        assert_eq!(drawn, view.positions);
        view.positions_before(DT, &mut drawn);
        // Nothing removes or slides a vertex here that was drawn before, except slides, which move what they start from.
        assert_eq!(&view.vertex_keys[..keys.len()], keys);
        let off = drawn.iter().zip(&before).filter(|(drawn, before)| drawn.distance(**before) > 1e-12).count();
        assert!(off <= 6, "{off} vertices jump");
        let whole = drawn.clone();
        view.positions_before(0.25 * DT, &mut drawn);
        for ((at, start), end) in drawn.iter().zip(&whole).zip(view.positions) {
            assert!(at.distance(end.lerp(*start, 0.25)) < 1e-12);
        }
    }
    assert!(counts > 5, "{counts} steps with new vertices");
}

/// The sum of all triangles' areas as vectors, from the normals' side.
#[test]
fn normals_are_those_of_the_surface() {
    let cap = rhexis::generate::cap(10.0, 5.0, 2000).unwrap();
    let mut found = Vec::new();
    normals(&cap.positions, &cap.triangles, &mut found);
    // A sphere's normals lie along its radii; between 2,000 triangles to the second order in their size, at the rim to the first.
    let centre = DVec3::ZERO;
    let apex = cap.positions.iter().map(|p| p.z).fold(f64::NEG_INFINITY, f64::max);
    let top = DVec3::Z * (apex - 10.0);
    let off = |(p, n): (&DVec3, &DVec3)| n.angle_between(*p - centre - top);
    let worst = cap.positions.iter().zip(&found).map(off).fold(0.0, f64::max);
    assert!(worst < 0.05, "{worst} rad");
    let flat = [DVec3::ZERO; 3];
    normals(&flat, &[[0, 1, 2]], &mut found);
    assert_eq!(found, [DVec3::ZERO; 3]);
}

#[test]
fn rays_find_what_lies_before_them() {
    let mut run = Square::new([20, 16], 60.0).spawn(Settings::default());
    let from = DVec3::new(4.0, 5.0, 7.0);
    let hit = run.simulation.cast_ray(run.body, from, DVec3::new(0.1, 0.2, -1.0), 100.0).unwrap();
    assert!((hit.position - DVec3::new(4.7, 6.4, 0.0)).length() < 1e-12 && hit.normal == DVec3::Z);
    assert!((hit.rest_position - hit.position).length() < 1e-12, "nothing has moved yet");
    let Hit { corners, barycentric, .. } = hit;
    let view: BodyView = run.simulation.view(run.body).unwrap();
    let row = |key| view.vertex_keys.iter().position(|k| *k == key).unwrap();
    let at: DVec3 = corners.iter().zip(barycentric).map(|(&key, weight)| view.positions[row(key)] * weight).sum();
    assert!(at.distance(hit.position) < 1e-12);
    let near = run.simulation.nearest(run.body, DVec3::new(4.7, 6.4, 3.0), 3.5).unwrap();
    assert!((near.distance - 3.0).abs() < 1e-12 && near.position.distance(hit.position) < 1e-12);
    assert!(run.simulation.nearest(run.body, from, 6.9).is_none());
    run.simulation.despawn(run.body).unwrap();
    assert!(run.simulation.nearest(run.body, from, 1e9).is_none());
}

#[test]
fn a_body_set_elsewhere_moves_as_it_would_have_here() {
    let square = Square::new([10, 8], 30.0);
    let sheet = || {
        let mesh = rhexis::generate::grid(30.0, 30.0, 10, 8).unwrap();
        rhexis::membrane::Membrane::new("free", mesh, square.material)
    };
    // Solved to what rounding allows, so that nothing but the place can differ.
    let linear = LinearParams::by_residual(1e-11, 2000);
    let mut simulation =
        Simulation::new(Settings { advanced: Advanced { linear, ..Advanced::default() }, ..Settings::default() })
            .unwrap();
    let [here, there] = [0, 1].map(|_| simulation.spawn(sheet()).unwrap());
    let (turn, shift) = (DQuat::from_rotation_y(1.0) * DQuat::from_rotation_x(0.3), DVec3::new(5.0, -80.0, 2.0));
    let spin = |x: DVec3| DVec3::new(-0.02 * x.y, 0.02 * x.x, 0.01);
    for body in [here, there] {
        simulation.set_velocity(body, spin).unwrap();
    }
    simulation.step(5.0).unwrap();
    simulation.teleport(there, turn, shift).unwrap();
    let mut drawn = Vec::new();
    simulation.view(there).unwrap().positions_before(4.0, &mut drawn);
    assert_eq!(drawn, simulation.view(there).unwrap().positions, "no picture shows it on its way");
    for _ in 0..20 {
        simulation.step(5.0).unwrap();
    }
    let positions = simulation.view(here).unwrap().positions.to_vec();
    let off = simulation
        .view(there)
        .unwrap()
        .positions
        .iter()
        .zip(&positions)
        .map(|(there, here)| there.distance(turn * *here + shift));
    // The residual over a motion of some millimetres in 20 steps, and what a body that hangs together loosely makes of it.
    let off = off.fold(0.0, f64::max);
    assert!(off < 1e-6, "{off} mm");

    let held = simulation.spawn(square.elastic()).unwrap();
    assert_eq!(simulation.teleport(held, DQuat::IDENTITY, DVec3::X), Err(MotionError::Held("left".into())));
    assert_eq!(simulation.teleport(held, turn, DVec3::X), Err(MotionError::OutOfPlane));
    assert_eq!(simulation.teleport(here, DQuat::IDENTITY, DVec3::NAN), Err(MotionError::NotFinite));
    assert_eq!(simulation.set_velocity(here, |_| DVec3::NAN), Err(MotionError::NotFinite));
    assert_eq!(simulation.set_velocity(held, |_| DVec3::Z), Err(MotionError::OutOfPlane));
}

#[test]
fn debug_lines_show_what_there_is() {
    let square = Square::new([20, 16], 60.0);
    let mut run = square.spawn(Settings::default());
    run.step();
    let floor = Obstacle { shape: Shape::Plane { point: DVec3::Z * 0.1, normal: DVec3::Z } };
    run.simulation.spawn_obstacle(floor).unwrap();
    run.simulation
        .world_mut()
        .insert_one(run.body.entity(), Contact { stiffness: Some(0.1), friction: 0.0, ..Contact::default() })
        .unwrap();
    let (mut lines, mut none) = (Vec::new(), Vec::new());
    run.simulation.debug_lines(run.body, &DebugLines::all(0.5), &mut lines).unwrap();
    let nothing = DebugLines { frames: false, fibres: false, stress: None, tips: false, contacts: false, grips: false };
    run.simulation.debug_lines(run.body, &nothing, &mut none).unwrap();
    assert!(none.is_empty());
    let count = |kind| lines.iter().filter(|line| line.kind == kind).count();
    let view = run.simulation.view(run.body).unwrap();
    for kind in [DebugKind::FrameFibre, DebugKind::FrameAcross, DebugKind::Normal, DebugKind::Fibre] {
        assert_eq!(count(kind), view.triangles.len());
    }
    assert_eq!(count(DebugKind::Tension) + count(DebugKind::Compression), 2 * view.triangles.len());
    assert_eq!((count(DebugKind::TipLast), count(DebugKind::TipNext)), (1, 1));
    assert_eq!((count(DebugKind::Contact), count(DebugKind::Hold)), (view.positions.len(), 2 * 17));
    for line in &lines {
        assert!(line.from.is_finite() && line.to.is_finite());
        match line.kind {
            DebugKind::Contact => assert!((line.to - line.from - DVec3::Z * 0.1).length() < 1e-12),
            DebugKind::Hold => assert!(line.from.distance(line.to) < 1e-9, "a step has brought it there"),
            DebugKind::Fibre => {
                let along = (line.to - line.from).normalize();
                assert!(along.dot(DVec3::new(0.5, 0.75_f64.sqrt(), 0.0)) > 0.99, "fibres at 60°");
            }
            _ => {}
        }
    }
}

#[test]
fn only_a_body_that_asks_for_it_keeps_a_list() {
    let mut run = Square::new([10, 8], 60.0).spawn(Settings::default());
    let mut changes = rhexis::components::ChangeSet::default();
    assert_eq!(run.simulation.drain_changes(run.body, &mut changes), Err(SimulationError::NoSuchComponents));
    run.simulation.world_mut().insert_one(run.body.entity(), Changes::default()).unwrap();
    run.simulation.drain_changes(run.body, &mut changes).unwrap();
    assert!(changes.is_whole && changes.vertices.iter().eq([&(0..changes.vertex_count)]));
    run.simulation.drain_changes(run.body, &mut changes).unwrap();
    assert!(changes.is_empty() && changes.triangles.is_empty());
}
