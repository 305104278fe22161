//! A step allocates nothing once it is warm. One test alone in its process, without a harness: the counter sees every thread.

#[path = "../../../tests/common/mod.rs"]
mod common;

use common::Square;
use glam::DVec3;
use rhexis::components::{
    Bending, ChangeSet, Changes, Contact, Curve, Damping, Drag, EnergyCriterion, Fibres, Gravity, Guide, Hold,
    HoldGuides, Jaws, Material, Obstacle, Pose, Shape, Sleeping, TearLog, TearMode, Tearing, Toughness,
};
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::schedule::Place;
use rhexis::settings::{Accuracy, Advanced, Preconditioner, Settings, Tangent};
use rhexis::simulation::{DebugLines, FixedStep, Grasp, Simulation, normals};
use rhexis::storage::Vertices;
use rhexis_scene::Document;
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};
use std::alloc::System;

#[global_allocator]
static GLOBAL: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Allocations, growths included, while `work` runs.
fn allocations(work: impl FnOnce()) -> usize {
    let region = Region::new(GLOBAL);
    work();
    let change = region.change();
    change.allocations + change.reallocations
}

fn main() {
    let strong = Tearing { strength_across_fibres: 1e6, strength_along_fibres: 1e6, ..Tearing::default() };
    for (threads, preconditioner) in [
        (1, Preconditioner::IncompleteCholesky),
        (2, Preconditioner::IncompleteCholesky),
        (1, Preconditioner::Multigrid),
        (1, Preconditioner::Auto),
    ] {
        let square = Square { tearing: strong, ..Square::new([40, 34], 60.0) };
        let mut run = square.spawn(Settings {
            threads,
            advanced: Advanced { preconditioner, ..Advanced::default() },
            ..Settings::default()
        });
        for _ in 0..40 {
            run.simulation.step(1.0).unwrap();
        }
        let count = allocations(|| {
            for _ in 0..1000 {
                run.simulation.step(1.0).unwrap();
            }
        });
        println!("{threads} threads, {preconditioner:?}: {count} allocations in 1000 elastic steps");
        // The queue through which rayon lets a pool in has blocks of 63 places: one block per 63 steps.
        assert!(count <= if threads == 1 { 0 } else { 1000 / 63 + 2 }, "{threads} threads: {count}");
    }

    accurate_steps_allocate_nothing();
    guided_steps_allocate_nothing();
    an_embedding_loop_allocates_nothing();
    many_bodies_allocate_nothing();
    for is_bent in [false, true] {
        for newton_corrections in [0, 6] {
            a_guarded_step_allocates_nothing(is_bent, newton_corrections);
        }
    }
    a_fallback_to_the_rotated_tangent_allocates_nothing();
    for energy in [None, Some(EnergyCriterion::new(Toughness { along: 0.01, across: 10.0 }))] {
        a_tear_seldom_allocates(energy, TearMode::Free);
        a_tear_seldom_allocates(energy, TearMode::Glide);
    }
    a_refined_tear_hardly_allocates();
}

/// The lens capsule, coarser: tips advance, are refined around and coarsened behind.
fn a_refined_tear_hardly_allocates() {
    let mut document = Document::named("capsulorhexis").unwrap();
    for set in [
        "run.threads=1",
        "run.advanced.preconditioner=incomplete_cholesky",
        "bodies.0.mesh.cap.triangles=2500",
        "bodies.0.tearing.toughness_along_fibres=0.5",
    ] {
        document.set(set).unwrap();
    }
    let mut instance = document.scene().unwrap().instantiate().unwrap();
    let body = instance.bodies[0];
    let mut run = |steps: usize| {
        let advances =
            |simulation: &Simulation| simulation.world().get::<&TearLog>(body.entity()).unwrap().advance_count;
        let before = advances(&instance.simulation);
        let count = (0..steps).map(|_| {
            let count = allocations(|| {
                instance.advance().unwrap();
            });
            instance.simulation.drain_events();
            count
        });
        (count.sum::<usize>(), advances(&instance.simulation) - before)
    };
    // The mesh has grown to its budget, and most lists to their length, after two thirds of the steps.
    let warm_up = run(WARM_UP);
    let (count, advances) = run(STEPS - WARM_UP);
    println!("refined tear: {warm_up:?} allocations and advances at first, then {count} and {advances}");
    // Some forty edits go with every advance, and jaws close meanwhile. The matrix of the flap, which bends, still grows: each of its
    // lists takes an eighth more room once in a while. Per advance, none does.
    assert!(advances > 40 && count <= 6, "{count} allocations in {advances} advances");
}

const WARM_UP: usize = 1000;
const STEPS: usize = 1400;

fn accurate_steps_allocate_nothing() {
    let strong = Tearing { strength_across_fibres: 1e6, strength_along_fibres: 1e6, ..Tearing::default() };
    let settings = Settings {
        threads: 1,
        advanced: Advanced {
            preconditioner: Preconditioner::IncompleteCholesky,
            ..Settings::new(Accuracy::Accurate).advanced
        },
        ..Settings::new(Accuracy::Accurate)
    };
    let mut run = Square { tearing: strong, ..Square::new([40, 34], 60.0) }.spawn(settings);
    for _ in 0..4 {
        run.simulation.step(1.0).unwrap();
    }
    let count = allocations(|| {
        for _ in 0..50 {
            run.simulation.step(1.0).unwrap();
        }
    });
    assert_eq!(count, 0, "accurate steps");
}

/// A strip drawn by vertices that move along a direction, and by some that move alike.
fn guided_steps_allocate_nothing() {
    let right = Guide::Together { force: DVec3::new(0.01, 0.0, 0.0), curve: Curve::ramp(50.0, 1.0).unwrap() };
    for guide in [Guide::Along(DVec3::Y), Guide::Across(DVec3::X), right] {
        let mesh = generate::grid(6.0, 4.0, 6, 4).unwrap();
        let rows = |x: f64| (0..).zip(&mesh.positions).filter(move |(_, p)| p.x == x).map(|(row, _)| row);
        let (left, held) = (Hold::new("left", rows(0.0)), Hold::new("right", rows(6.0)));
        let material = Material { thickness: 0.1, ..Material::allard_2009() };
        let strip = Membrane::new("strip", mesh.clone(), material).hold(left).hold(held);
        let strip = strip.with(HoldGuides { list: vec![(1, guide.clone())] }).with(Damping { time: 1.0 });
        let advanced = Advanced { preconditioner: Preconditioner::BlockJacobi, ..Advanced::default() };
        let mut simulation = Simulation::new(Settings { threads: 1, advanced, ..Settings::default() }).unwrap();
        simulation.spawn(strip).unwrap();
        (0..4).for_each(|_| _ = simulation.step(5.0).unwrap());
        let count = allocations(|| (0..50).for_each(|_| _ = simulation.step(5.0).unwrap()));
        assert_eq!(count, 0, "guided steps, {guide:?}");
    }
}

/// All that a loop of pictures asks for, and a system of the caller's.
fn an_embedding_loop_allocates_nothing() {
    let strong = Tearing { strength_across_fibres: 1e6, strength_along_fibres: 1e6, ..Tearing::default() };
    let settings = Settings {
        threads: 1,
        advanced: Advanced { preconditioner: Preconditioner::IncompleteCholesky, ..Advanced::default() },
        ..Settings::default()
    };
    let mut run = Square { tearing: strong, ..Square::new([40, 34], 60.0) }.spawn(settings);
    let (simulation, body) = (&mut run.simulation, run.body);
    simulation.world_mut().insert_one(body.entity(), Changes::default()).unwrap();
    simulation.insert_system(Place::After("contact"), "mine", |_, _| 1).unwrap();
    let keys = simulation.view(body).unwrap().vertex_keys.to_vec();
    simulation.pin(body, "tool", &keys[700..720]).unwrap();
    let mut clock = FixedStep::new(1.0, 4).unwrap();
    let (mut changes, mut positions, mut shades, mut lines) =
        (ChangeSet::default(), Vec::new(), Vec::new(), Vec::new());
    let mut picture = |simulation: &mut Simulation| {
        for _ in 0..clock.steps_after(1.7).unwrap() {
            simulation.move_pins(body, "tool", |pin| pin.place + DVec3::Z * 0.0).unwrap();
            simulation.step(1.0).unwrap();
        }
        simulation.drain_events().for_each(drop);
        simulation.drain_changes(body, &mut changes).unwrap();
        clock.positions(simulation, body, &mut positions).unwrap();
        normals(&positions, simulation.view(body).unwrap().triangles, &mut shades);
        lines.clear();
        simulation.debug_lines(body, &DebugLines::all(1.0), &mut lines).unwrap();
        simulation.cast_ray(body, DVec3::ONE, DVec3::NEG_Z, 9.0).unwrap();
    };
    (0..5).for_each(|_| picture(simulation));
    let count = allocations(|| (0..100).for_each(|_| picture(simulation)));
    assert_eq!(count, 0, "pictures");
}

/// Several bodies side by side, pulled, falling asleep, asleep.
fn many_bodies_allocate_nothing() {
    let strong = Tearing { strength_across_fibres: 1e6, strength_along_fibres: 1e6, ..Tearing::default() };
    let settings = Settings {
        threads: 2,
        advanced: Advanced { preconditioner: Preconditioner::IncompleteCholesky, ..Advanced::default() },
        ..Settings::default()
    };
    let mut simulation = Simulation::new(settings).unwrap();
    let bodies: Vec<_> = (0..8)
        .map(|i| {
            let square = Square { tearing: strong, ..Square::new([20, 16], 60.0) };
            let still = Curve::ramp(20.0, 0.3).unwrap();
            let membrane = if i < 4 { square.membrane() } else { square.membrane_along(still) };
            simulation.spawn(membrane.with(Sleeping::default())).unwrap()
        })
        .collect();
    for _ in 0..60 {
        simulation.step(1.0).unwrap();
    }
    simulation.drain_events();
    assert_eq!(simulation.report().bodies.iter().filter(|body| body.is_asleep).count(), 4);
    let steps = |simulation: &mut Simulation, count: usize| {
        allocations(|| {
            for _ in 0..count {
                simulation.step(1.0).unwrap();
            }
        })
    };
    // rayon's queue, as above.
    let count = steps(&mut simulation, 300);
    assert!(count <= 300 / 63 + 2, "four of eight asleep: {count}");
    simulation.wake(bodies[7]).unwrap();
    let count = steps(&mut simulation, 100);
    // And the list of events grows.
    assert!(count <= 100 / 63 + 4, "one wakes and falls asleep again: {count}");
}

/// A slack sheet, hung by two corners and jerked by a third, whose steps the energy guard undoes, halves, limits, corrects and relaxes.
fn a_guarded_step_allocates_nothing(is_bent: bool, newton_corrections: u32) {
    const DT: f64 = 1000.0 / 60.0;
    let mesh = generate::grid(20.0, 20.0, 20, 20).unwrap();
    let mut sheet = Membrane::new("sheet", mesh, Material { thickness: 0.015, ..Material::allard_2009() })
        .fibres(Fibres::at_degrees(30.0))
        .with(Damping { time: 1.0 })
        .with(Gravity { acceleration: DVec3::new(0.0, -9.81e-3, 0.0) });
    if is_bent {
        sheet = sheet.with(Bending::default()).with(Contact::default()).with(Drag { coefficient: 1e-5 });
    }
    let preconditioner = Preconditioner::IncompleteCholesky;
    let advanced = Advanced { preconditioner, newton_corrections, max_step_halvings: 3, ..Advanced::default() };
    let mut simulation = Simulation::new(Settings { threads: 1, advanced, ..Settings::default() }).unwrap();
    let body = simulation.spawn(sheet).unwrap();
    let ball = Shape::Sphere { centre: DVec3::new(10.0, 10.0, -6.0), radius: 5.0 };
    simulation.spawn_obstacle(Obstacle { shape: ball }).unwrap();
    let keys = simulation.view(body).unwrap().vertex_keys;
    let corners = [keys[20 * 21], keys[21 * 21 - 1]];
    simulation.pin(body, "corners", &corners).unwrap();
    let forceps =
        simulation.spawn_forceps("hand", Jaws { radius: 1.5, ..Jaws::default() }, Pose::at(DVec3::ZERO)).unwrap();
    simulation.close_forceps(forceps, body, &Grasp::Point(DVec3::ZERO)).unwrap();
    // Attempts undone and halved, corrected, relaxed locally and limited, and allocations in these steps.
    let mut run = |steps: std::ops::Range<u32>| {
        let (mut acted, mut count) = ([0; 4], 0);
        for step in steps {
            if step % 8 == 0 {
                let k = f64::from(step);
                let jerk = DVec3::new((1.7 * k).sin(), (2.3 * k).cos(), (3.1 * k).sin()) * 15.0;
                simulation.move_forceps(forceps, Pose::at(jerk), DT).unwrap();
            }
            count += allocations(|| _ = simulation.step(DT).unwrap());
            let guard = &simulation.report().bodies[0].guard;
            let now = [guard.refusals(), guard.corrections(), guard.relaxations(), guard.limitations()];
            acted.iter_mut().zip(now).for_each(|(sum, now)| *sum += now);
            simulation.drain_events().for_each(drop);
        }
        (acted, count)
    };
    // The first attempt that is undone keeps a copy of the body, and so on.
    let warm_up = run(0..240);
    let (acted, count) = run(240..480);
    println!("guarded, bent {is_bent}, {newton_corrections} corrections: {warm_up:?} at first, then {acted:?} {count}");
    let [undone, corrected, relaxed, limited] = acted;
    let has_acted = if newton_corrections > 0 { corrected > 0 } else { undone > 0 && limited > 0 };
    assert!(relaxed > 0 && has_acted, "undone, corrected, relaxed, limited: {acted:?}");
    assert_eq!(count, 0, "guarded steps, bent {is_bent}, {newton_corrections} corrections");
}

/// A sheet that is pushed together: the exact tangent is indefinite, and the rotated one takes its place.
fn a_fallback_to_the_rotated_tangent_allocates_nothing() {
    let mesh = generate::grid(20.0, 16.0, 10, 8).unwrap();
    let sheet = Membrane::new("sheet", mesh, Material::allard_2009()).fibres(Fibres::at_degrees(30.0));
    let rim = |x: f64| sheet.select(|p| p.x == x);
    let (left, right) = (Hold::new("left", rim(0.0)), Hold::new("right", rim(20.0)));
    let right = right.moved(DVec3::NEG_X, Curve::ramp(20.0, 1.0).unwrap());
    let sheet = sheet.hold(left).hold(right).with(Damping { time: 0.3 });
    let preconditioner = Preconditioner::IncompleteCholesky;
    let advanced = Advanced { preconditioner, tangent: Tangent::Exact, ..Advanced::default() };
    let mut simulation = Simulation::new(Settings { threads: 1, advanced, ..Settings::default() }).unwrap();
    let body = simulation.spawn(sheet).unwrap();
    for (i, x) in simulation.world().get::<&mut Vertices>(body.entity()).unwrap().position.iter_mut().enumerate() {
        x.z += 0.05 * (37.7 * i as f64).sin() * x.x * (20.0 - x.x) * 0.01;
    }
    let mut run = |steps: u32| {
        let (mut fallbacks, mut count) = (0, 0);
        for _ in 0..steps {
            count += allocations(|| fallbacks += u32::from(simulation.step(1.0).unwrap().bodies[0].fell_back));
            simulation.drain_events().for_each(drop);
        }
        (fallbacks, count)
    };
    let (warm_up, (fallbacks, count)) = (run(3), run(17));
    println!("fallbacks to the rotated tangent, with their allocations: {warm_up:?}, then {fallbacks} and {count}");
    assert!(fallbacks > 3 && count == 0, "{count} allocations in {fallbacks} fallbacks");
}

fn a_tear_seldom_allocates(energy: Option<EnergyCriterion>, mode: TearMode) {
    let settings = Settings {
        threads: 1,
        // One move in a step: with as many as it takes the tear would be through in five.
        max_tear_passes: 0,
        advanced: Advanced { preconditioner: Preconditioner::IncompleteCholesky, ..Advanced::default() },
        ..Settings::default()
    };
    let mut square = Square::new([40, 34], 60.0);
    square.tearing.mode = mode;
    let mut run = square.spawn(settings);
    if let Some(energy) = energy {
        run.simulation.world_mut().insert_one(run.body.entity(), energy).unwrap();
    }
    run.stretch_to(if energy.is_some() { 0.4 } else { 0.65 });
    // The first dynamic step after static ones.
    run.simulation.step(2.0).unwrap();
    let mut advances: Vec<usize> = Vec::new();
    let mut is_next = false;
    while run.log().end_count == 0 {
        assert!(run.simulation.time() < 2000.0);
        let before = run.log().advance_count;
        let count = allocations(|| {
            run.simulation.step(2.0).unwrap();
        });
        run.simulation.drain_events();
        let has_advanced = run.log().advance_count > before;
        match advances.last_mut() {
            _ if has_advanced => advances.push(count),
            // The first solve on the torn mesh.
            Some(last) if is_next => *last += count,
            _ => assert_eq!(count, 0, "a step without an advance, after {} advances", advances.len()),
        }
        is_next = has_advanced;
    }
    println!("allocations in the steps with an advance and the next: {advances:?}");
    // What the step keeps per vertex grows in the first, to where the tables have room from the start; what it keeps per triangle, five
    // lists, where the first triangle is added; the disc of the energy criterion grows now and then. After that not even the last advance allocates,
    // which walks the piece that it frees; but a tip that glides makes vertices with more triangles than their lists have room for, one in some
    // thirty steps.
    assert!(advances.len() > 30, "{advances:?}");
    let (first, later) = advances.split_at(10);
    let rare = if mode == TearMode::Glide { later.len() / 20 } else { 0 };
    let seldom = later.iter().filter(|&&count| count > 0).count();
    let [first, later] = [first, later].map(|counts| counts.iter().sum::<usize>());
    assert!(first < 30 && seldom <= rare && later <= 2 * rare, "{advances:?}");
}
