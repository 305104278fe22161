//! The lead scene runs to its end. The tear follows the circle, closes on itself and frees the disc, on a mesh that is
//! refined around its tips and coarsened behind them. Drawn outwards it runs out to the rim. Whatever the hand does, one of
//! the two happens. Ignored tests print tables of `docs/capsulorhexis.md` whose runs no scene file has.

use glam::DVec3;
use rhexis::components::{Bending, EnergyCriterion, Grips, PreStretch, Refined, TearDecisions, TearLog, Tearing};
use rhexis::event::{Event, EventKind};
use rhexis::storage::{Tips, Topology, Triangles, Vertices, measure, validate};
use rhexis::systems::fracture::{EnergyTerms, Surface, TipMemory, energy_decision};
use rhexis_scene::measures::{CourseFigures, Outcome, TearCourse};
use rhexis_scene::{Document, Instance};
use std::f64::consts::TAU;

/// Half of the catalog's triangles: half of its cost.
const COARSE: [&str; 2] = ["bodies.0.mesh.cap.triangles=2500", "bodies.0.refinement.budget=2.2"];

/// The fewest triangles that the refinement resolves. Their flap, coarse as it is, whips too fast for the catalog's time step.
const FEW: [&str; 3] = ["bodies.0.mesh.cap.triangles=1500", "bodies.0.refinement.budget=3", "run.dt=5"];

/// A run-out that the hand draws all the way, over a lens in its place.
const HELD: [&str; 2] = ["bodies.0.grips.0.until=9000", "obstacles.0.sphere.radius=10"];

fn instance(scene: &str, sets: &[String]) -> Instance {
    let mut document = Document::named(scene).unwrap();
    sets.iter().for_each(|set| document.set(set).unwrap());
    document.scene().unwrap_or_else(|e| panic!("{e}")).instantiate().unwrap()
}

fn sets(list: &[&str]) -> Vec<String> {
    list.iter().map(|&set| set.to_owned()).collect()
}

/// Runs to the end; every step is sound, and what was refused in the end has advanced.
fn run(instance: &mut Instance) -> (CourseFigures, Vec<Event>) {
    let body = instance.bodies[0];
    let mut course = TearCourse::new(instance.simulation.world(), body, 0.0).unwrap();
    let mut all = Vec::new();
    while !instance.is_finished() {
        let report = instance.advance().unwrap();
        assert!(!report.has_failed);
        let events: Vec<Event> = instance.simulation.drain_events().collect();
        course.note(instance.simulation.world(), instance.simulation.time(), &events);
        all.extend(events);
    }
    let tip_of = |kind: &EventKind| match kind {
        EventKind::Refused { tip, .. } => *tip,
        _ => None,
    };
    let moved_on = |kind: &EventKind, key| match kind {
        EventKind::Advanced { tip, .. } | EventKind::Ended { tip, .. } => *tip == key,
        _ => false,
    };
    for (i, event) in all.iter().enumerate() {
        if let Some(key) = tip_of(&event.kind) {
            assert!(all[i..].iter().any(|later| moved_on(&later.kind, key)), "left unresolved: {event:?}");
        }
    }
    (course.figures(), all)
}

fn row(figures: &CourseFigures) -> String {
    let CourseFigures { outcome, opening, completion, largest_radius, grasps, time, force_rms, force_peak, .. } =
        figures;
    let shape = opening
        .map_or("–, –, –".into(), |o| format!("{:.2}, {:.3}, {:.2}", o.diameter, o.circularity, o.decentration));
    format!(
        "{outcome:?}: {shape}; {:.0}°, {largest_radius:.2} mm, {grasps} grasps, {:.1} s, {:.1} mN, {:.1} mN",
        completion.to_degrees(),
        1e-3 * time,
        1e3 * force_rms,
        1e3 * force_peak
    )
}

#[test]
fn the_tear_follows_the_circle_and_closes() {
    let mut instance = instance("capsulorhexis", &sets(&COARSE));
    let body = instance.bodies[0];
    let mass =
        |s: &rhexis::simulation::Simulation| measure::total_mass(&s.world().get::<&Vertices>(body.entity()).unwrap());
    let start_mass = mass(&instance.simulation);
    let (figures, events) = run(&mut instance);
    assert_eq!(figures.outcome, Outcome::Closed, "{}", row(&figures));
    let opening = figures.opening.unwrap();
    // 5.0 to 5.5 mm are asked of a surgeon, give or take what a slack flap scatters by: with tolerances 20 % apart this mesh gives 4.97 to
    // 5.17 mm.
    assert!((4.9..=5.5).contains(&opening.diameter), "{}", row(&figures));
    assert!(opening.circularity >= 0.9 && opening.decentration <= 0.3, "{}", row(&figures));
    assert!((3e-3..=30e-3).contains(&figures.force_rms), "{}", row(&figures));
    assert!((4..=7).contains(&figures.grasps) && figures.completion == TAU);
    let freed = events.iter().find_map(|event| match event.kind {
        EventKind::FragmentFreed { triangle_count } => Some(triangle_count),
        _ => None,
    });
    assert!(freed.is_some_and(|count| count > 500), "{freed:?}");

    let simulation = &instance.simulation;
    // Sums of some thousand masses: rounding only.
    assert!((mass(simulation) - start_mass).abs() < 1e-12 * start_mass);
    let world = simulation.world();
    let refined = world.get::<&Refined>(body.entity()).unwrap();
    assert!(refined.removed_count > 500, "{} vertices taken out of {}", refined.removed_count, refined.split_count);
    let log = world.get::<&TearLog>(body.entity()).unwrap();
    assert!(log.smallest_angle.unwrap().to_degrees() >= 10.0);
    let (vertices, triangles) =
        (world.get::<&Vertices>(body.entity()).unwrap(), world.get::<&Triangles>(body.entity()).unwrap());
    validate(&vertices, &triangles, &world.get::<&Topology>(body.entity()).unwrap()).unwrap();
}

#[test]
fn every_advance_takes_the_toughness_of_the_scene() {
    let [fewer, budget] = COARSE;
    let gliding = sets(&[fewer, budget, "bodies.0.tearing.mode=\"glide\""]);
    let (figures, events) = run(&mut instance("capsulorhexis", &gliding));
    let mut releases: Vec<f64> = events
        .iter()
        .filter_map(|event| match event.kind {
            EventKind::Advanced { release, criterion, .. } => release.map(|_| criterion * criterion),
            _ => None,
        })
        .collect();
    releases.sort_by(f64::total_cmp);
    let share = |part: f64| releases[(part * releases.len() as f64) as usize];
    // Energy over toughness before a move, the first of a step. A tip that runs moves from 0.95² on, by the load that it expects of the next
    // step; the hand loads it by some per cent a step.
    assert!(releases.len() > 100 && releases[0] >= 0.9, "{}", row(&figures));
    assert!((0.98..1.05).contains(&share(0.5)) && share(0.9) < 1.1, "{} {}", share(0.5), share(0.9));
    // By the hands of experts 9 mN RMS were measured, by those of novices 17.
    assert!((7e-3..=12e-3).contains(&figures.force_rms), "{}", row(&figures));
}

#[test]
fn let_go_of_it_runs_out_to_the_rim_by_itself() {
    let mut instance = instance("capsulorhexis-runout", &sets(&COARSE));
    let until = instance.simulation.world().get::<&Grips>(instance.bodies[0].entity()).unwrap().list[0].until;
    let (figures, events) = run(&mut instance);
    assert_eq!(figures.outcome, Outcome::RanOut, "{}", row(&figures));
    // The rim is a polygon in a circle of 4.9 mm. The tear goes straight there from 160°.
    assert!(figures.largest_radius > 4.85 && (0.4 * TAU..0.6 * TAU).contains(&figures.completion), "{}", row(&figures));
    let alone: f64 = events
        .iter()
        .filter(|event| event.time > until)
        .filter_map(|event| match event.kind {
            EventKind::Advanced { from, to, .. } => Some(from.distance(to)),
            _ => None,
        })
        .sum();
    // Most of the 1.9 mm to the rim.
    assert!(alone > 1.0, "{alone}");
}

#[test]
fn drawn_back_and_inwards_it_turns_round_and_drawn_inwards_alone_it_does_not() {
    let (figures, _) = run(&mut instance("capsulorhexis-rescue", &sets(&COARSE)));
    assert_eq!(figures.outcome, Outcome::Closed, "{}", row(&figures));
    // 3.10 mm had been cut.
    assert!(figures.largest_radius < 3.4, "{}", row(&figures));
    let central: Vec<String> = sets(&COARSE).into_iter().chain(["scene.preset=central".to_owned()]).collect();
    let (figures, _) = run(&mut instance("capsulorhexis-rescue", &central));
    assert_eq!(figures.outcome, Outcome::RanOut, "{}", row(&figures));
    assert!(figures.time < 5000.0 && figures.completion < 0.6 * TAU, "{}", row(&figures));
}

#[test]
fn a_flap_that_tears_off_is_no_tear_that_runs_out() {
    // Left on its circle and drawn outwards by 40°, the flap tears on from its inner end, straight over the pole to the far rim.
    let on_lens = |radius: f64, angle: f64| {
        let (s, c) = angle.sin_cos();
        format!("[{}, {}, {}]", radius * c, radius * s, (100.0 - radius * radius).sqrt() - 10.0)
    };
    let circle = (0..=15).map(|i| on_lens(2.65 - 0.05 * f64::from(i) / 15.0, f64::from(10 * i).to_radians()));
    let points: Vec<String> = [1.2, 2.0].map(|radius| on_lens(radius, 0.0)).into_iter().chain(circle).collect();
    let mut all = sets(&FEW);
    all.push(format!("bodies.0.cuts.0.polyline=[{}]", points.join(", ")));
    all.extend(sets(&HELD));
    all.push("bodies.0.grips.0.path.1.by=[6.13, -5.14, 0.3]".to_owned());
    let (figures, events) = run(&mut instance("capsulorhexis-runout", &all));
    assert_eq!(figures.outcome, Outcome::TornOff, "{}", row(&figures));
    // The cut's tips are reported in the order of its points.
    let mut started = events.iter().filter_map(|event| match event.kind {
        EventKind::Started { tip, at, .. } => Some((tip, at.truncate().length())),
        _ => None,
    });
    let (inner, radius) = started.next().unwrap();
    assert!((radius - 1.2).abs() < 0.01, "{radius}");
    assert!(events.iter().any(|event| matches!(event.kind, EventKind::Ended { tip, .. } if tip == inner)));
}

#[test]
fn what_tips_remember_of_their_discs_follows_every_edit() {
    // Bending reads a ring of triangles around the disc as well, and refinement edits them while the disc itself stays as it is.
    let mut instance = instance("capsulorhexis", &sets(&FEW));
    let body = instance.bodies[0];
    let mut compared = 0;
    for _ in 0..120 {
        instance.advance().unwrap();
        let has_edited = instance.simulation.drain_events().count() > 0;
        let world = instance.simulation.world();
        let mut query = world.query_one::<(
            (&Vertices, &Triangles, &Topology, &Tips, &TearDecisions),
            (&Tearing, &EnergyCriterion, &PreStretch, &Bending),
        )>(body.entity());
        let ((vertices, triangles, topology, tips, decisions), (tearing, energy, pre_stretch, bending)) =
            query.get().unwrap();
        let unstretched = PreStretch::unstretched(Some(pre_stretch));
        let surface = Surface {
            vertices,
            triangles,
            topology,
            is_planar: false,
            unstretched,
            fibres: None,
            bending: Some(bending),
        };
        let mut memory = TipMemory::default();
        for (tip, kept) in decisions.tips.iter().enumerate().filter(|_| !has_edited) {
            let place = (tips.vertex[tip], tips.previous[tip]);
            let anew = energy_decision(&surface, EnergyTerms { tearing, energy }, tip, place, &mut memory);
            assert_eq!(kept.map(|kept| kept.release), anew.map(|(anew, _)| anew.release));
            compared += 1;
        }
    }
    assert!(compared > 50, "{compared}");
}

#[test]
#[ignore = "minutes: cargo test --release --test capsulorhexis -- --ignored time_step"]
fn diameter_and_force_are_those_of_every_mesh_and_time_step() {
    let mut diameters = Vec::new();
    let mut forces = Vec::new();
    for (triangles, budget, dt) in
        [(1500, 3.0, 5), (2500, 2.2, 10), (5000, 1.6, 10), (5000, 1.6, 5), (20000, 1.6, 10), (20000, 1.6, 5)]
    {
        let size = [
            format!("bodies.0.mesh.cap.triangles={triangles}"),
            format!("bodies.0.refinement.budget={budget}"),
            format!("run.dt={dt}"),
        ];
        let (figures, _) = run(&mut instance("capsulorhexis", &size));
        diameters.push(figures.opening.unwrap().diameter);
        forces.push(figures.force_rms);
    }
    let spread = |values: &[f64]| {
        let (least, largest) = values.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), &v| (a.min(v), b.max(v)));
        (largest - least) / (largest + least)
    };
    // Half of the range over the middle.
    assert!(spread(&diameters) <= 0.03, "{diameters:?}");
    assert!(spread(&forces) <= 0.1, "{forces:?}");
}

/// A hand that errs: another place and pull at each grasp, and a sway by up to 0.15 mm with a period of some seconds.
fn perturb(grips: &mut Grips, seed: u64) {
    let mut state = seed;
    let mut random = || {
        // SplitMix64 (Steele, Lea, Flood 2014), in [-1, 1).
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    for grip in &mut grips.list {
        let near = grip.near_tip.as_mut().unwrap();
        near.behind += 0.1 * random();
        near.left += 0.1 * random();
        let sway = DVec3::new(random(), random(), random()) * 0.15;
        let (pull, period, phase) = (1.0 + 0.1 * random(), 2500.0 * (1.5 + 0.5 * random()), TAU * random());
        let from = grip.from;
        let start = grip.path.at(from);
        for (time, hand) in &mut grip.path.points {
            let swing = (TAU * (*time - from) / period + phase).sin() - phase.sin();
            *hand = start + (*hand - start) * pull + sway * swing;
        }
    }
}

#[test]
#[ignore = "minutes: cargo test --release --test capsulorhexis -- --ignored --nocapture hands"]
fn ten_hands_that_err_end_honestly() {
    for seed in 1..=10 {
        let mut sets = sets(&COARSE);
        // Time for another grasp's worth of pull: a slower tear is no third way to end.
        sets.push("run.duration=34000".to_owned());
        let mut instance = instance("capsulorhexis", &sets);
        let body = instance.bodies[0];
        perturb(instance.simulation.entity_mut::<&mut Grips>(body).unwrap(), seed);
        let (figures, _) = run(&mut instance);
        println!("| {seed} | {} |", row(&figures));
        assert_ne!(figures.outcome, Outcome::Unfinished, "seed {seed}");
    }
}

#[test]
#[ignore = "minutes: cargo test --release --test capsulorhexis -- --ignored --nocapture trends"]
fn the_trends() {
    let pull = |degrees: f64| {
        let (s, c) = degrees.to_radians().sin_cos();
        format!("bodies.0.grips.0.path.1.by=[{:.3}, {:.3}, 0.3]", 8.0 * c, 8.0 * s)
    };
    let series = [
        ("pull [° over the opening]", [20.0, 45.0, 70.0, 90.0].map(|angle| (angle, pull(angle)))),
        ("pre-stretch", [0.06, 0.08, 0.1, 0.12].map(|value| (value, format!("bodies.0.pre_stretch={value}")))),
        (
            "lens raised [mm]",
            [0.0, 0.05, 0.1, 0.2].map(|rise| (rise, format!("obstacles.0.sphere.radius={}", 10.0 + rise))),
        ),
    ];
    for (what, values) in series {
        for (value, change) in values {
            let mut all = sets(&FEW);
            all.extend(sets(&HELD));
            all.push(change);
            let (figures, _) = run(&mut instance("capsulorhexis-runout", &all));
            println!("| {what} | {value} | {} |", row(&figures));
        }
    }
}

/// Fourteen grasps of 2 s that each lift the flap by 0.3 mm and draw it straight on by 3 mm, at an angle over the opening to the tear's
/// direction.
fn straight_grasps(degrees: f64) -> String {
    let (s, c) = degrees.to_radians().sin_cos();
    let grasp = |k: u32| {
        let from = 200 + 2000 * k;
        format!(
            "{{ name = \"grasp {}\", at = [2.3, 0, -0.2681], near_tip = {{ behind = 0.35, left = 0.35 }}, from = {from}, \
             until = {}, radius = 0.2, stiffness = 0.2, path = [{{ by = [0, 0, 0.3], end = {} }}, \
             {{ by = [{:.4}, {:.4}, 0.3], end = {} }}] }}",
            k + 1,
            from + 1800,
            from + 450,
            -3.0 * s,
            3.0 * c,
            from + 1800
        )
    };
    format!("bodies.0.grips=[{}]", (0..14).map(grasp).collect::<Vec<_>>().join(", "))
}

#[test]
#[ignore = "minutes: cargo test --release --test capsulorhexis -- --ignored --nocapture angles"]
fn the_angles_of_a_hand_that_no_fibre_guides() {
    let isotropic =
        ["bodies.0.grading.ratio_at_rim=1", "bodies.0.tearing.toughness_across_fibres=0.7", "run.duration=28200"];
    for degrees in [30.0, 45.0, 60.0, 80.0, 110.0] {
        let mut all = sets(&FEW);
        all.extend(sets(&isotropic));
        all.push(straight_grasps(degrees));
        let (figures, _) = run(&mut instance("capsulorhexis", &all));
        println!("| {degrees}° | {} |", row(&figures));
    }
}
