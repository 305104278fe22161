//! Tips that glide within their triangles: the force between two edges, saves in the middle of a tear, the ends of a tear.

use rhexis::components::TearLog;
use rhexis::event::{Event, EventKind};
use rhexis::simulation::Simulation;
use rhexis::storage::{BodyId, Topology, Triangles, Vertices, measure::total_mass, validate};
use rhexis_scene::{Instance, Scene};

/// A trouser of 8 × 16 mm, its legs pulled apart across the sheet: each leg takes G_c·h/2.
pub(crate) const TROUSER: &str = r#"
[scene]
name = "trouser"
[run]
dt = 20
steps = 120
threads = 1
[[bodies]]
name = "trouser"
mesh = { unstructured = { corners = [[-4, 0], [4, 0], [4, 16], [-4, 16]], edge = 0.5, seed = 8 } }
material = { young = 2.0, poisson = 0.4, thickness = 0.05 }
damping = 0.05
drag = 4e-7
bending = {}
tearing = { mode = "glide", toughness_along_fibres = 0.1, toughness_across_fibres = 0.1, exponent = 2, radius = 1.0 }
cuts = [{ polyline = [[0, 16], [0, 10]] }]
[[bodies.holds]]
name = "left"
region = { x = [-1.5, -0.001], y = 16.0 }
move = { offset = [0, -0.5, 1] }
curve = [[0, 0], [4000, 40]]
[[bodies.holds]]
name = "right"
region = { x = [0.001, 1.5], y = 16.0 }
move = { offset = [0, -0.5, -1] }
curve = [[0, 0], [4000, 40]]
"#;

/// G_c·h/2 \[N\].
const RIGHT: f64 = 0.5 * 0.1 * 0.05;

fn trouser() -> (Simulation, BodyId) {
    let scene = Scene::parse(TROUSER, "trouser.toml").unwrap();
    let Instance { simulation, bodies, .. } = scene.instantiate().unwrap();
    (simulation, bodies[0])
}

/// Length torn \[mm\], the cut included.
fn length(simulation: &Simulation, body: BodyId) -> f64 {
    simulation.world().get::<&TearLog>(body.entity()).unwrap().length
}

#[test]
fn a_hand_feels_the_toughness_between_two_edges_too_and_the_tear_ends_at_the_rim() {
    let (mut simulation, body) = trouser();
    let tables = |simulation: &Simulation| {
        let world = simulation.world();
        let vertices = world.get::<&Vertices>(body.entity()).unwrap();
        let triangles = world.get::<&Triangles>(body.entity()).unwrap();
        validate(&vertices, &triangles, &world.get::<&Topology>(body.entity()).unwrap()).unwrap();
        (total_mass(&vertices), triangles.rest.iter().map(|rest| rest.area).sum::<f64>())
    };
    let before = tables(&simulation);
    let mut forces = Vec::new();
    for _ in 0..120 {
        simulation.step(20.0).unwrap();
        if (8.0..14.5).contains(&length(&simulation, body)) {
            forces.push(simulation.reactions(body).unwrap()[0].1.z.abs() / RIGHT);
        }
    }
    forces.sort_by(f64::total_cmp);
    let (count, mean) = (forces.len(), forces.iter().sum::<f64>() / forces.len() as f64);
    let (low, high) = (forces[count / 10], forces[9 * count / 10]);
    println!("{count} steps: {mean:.3} of right in the mean, {low:.3} to {high:.3}");
    // Of the mean 3 % are asked, of the range from 10 to 90 % 8 %. By whole edges it is 0.40, 0.01 to 0.73.
    assert!((mean - 1.0).abs() < 0.03 && low > 0.92 && high < 1.08, "{mean} {low} {high}");
    assert_eq!(simulation.report().bodies[0].tip_count, 0);
    let events: Vec<Event> = simulation.drain_events().collect();
    assert!(events.iter().any(|event| matches!(event.kind, EventKind::FragmentFreed { .. })));
    let after = tables(&simulation);
    // Sums over a thousand triangles, and some hundred edits that keep them to rounding.
    assert!((after.0 - before.0).abs() < 1e-11 * before.0 && (after.1 - before.1).abs() < 1e-11 * before.1);
}

#[cfg(feature = "snapshot")]
#[test]
fn a_save_in_the_middle_of_a_glide_and_two_threads_give_the_same_bits() {
    let (mut simulation, body) = trouser();
    (0..50).for_each(|_| _ = simulation.step(20.0).unwrap());
    assert!(length(&simulation, body) > 7.0, "{}", length(&simulation, body));
    let bytes = simulation.snapshot().to_bytes().unwrap();
    let mut other = Simulation::from_snapshot(&rhexis::snapshot::Snapshot::from_bytes(&bytes).unwrap()).unwrap();
    let settings = rhexis::settings::Settings { threads: 2, ..*other.settings() };
    other.set_settings(settings).unwrap();
    for simulation in [&mut simulation, &mut other] {
        (0..12).for_each(|_| _ = simulation.step(20.0).unwrap());
    }
    assert_eq!(simulation.hash(), other.hash());
}

#[test]
fn an_advance_is_told_once_per_step_and_tip() {
    let (mut simulation, body) = trouser();
    let mut told = 0;
    for _ in 0..60 {
        let before = length(&simulation, body);
        simulation.step(20.0).unwrap();
        let advances: Vec<f64> = simulation
            .drain_events()
            .filter_map(|event| match event.kind {
                EventKind::Advanced { from, to, .. } => Some(from.distance(to)),
                _ => None,
            })
            .collect();
        assert!(advances.len() <= 1, "{advances:?}");
        let gone = length(&simulation, body) - before;
        assert_eq!(advances.is_empty(), gone == 0.0);
        // A way of several moves is longer than the line between its ends, by the little that they turn.
        advances.iter().for_each(|&line| assert!((0.9 * gone..=gone * (1.0 + 1e-12)).contains(&line), "{line} {gone}"));
        told += advances.len();
    }
    assert!(told > 10, "{told}");
}

/// The trouser under dead loads of 1.5 times the toughness on its legs, with a toughness that doubles at 0.02 mm/ms, its foot held.
fn loaded(density: f64) -> (Simulation, BodyId) {
    let [head, _] = TROUSER.split_once("[[bodies.holds]]").map(|(head, rest)| [head, rest]).unwrap();
    let head = head.replace("radius = 1.0", "radius = 1.0, rate = { speed = 0.02, exponent = 1 }");
    let head = head.replace("thickness = 0.05", &format!("thickness = 0.05, density = {density}"));
    let load = |side: &str, pull: f64| {
        format!(
            "[[bodies.point_loads]]\nregion = {{ x = {side}, y = 16.0 }}\ntotal = [0, 0, {pull}]\ncurve = [[0, 0], [50, 1]]\n"
        )
    };
    let (left, right) = (load("[-1.5, -0.001]", 1.5 * RIGHT), load("[0.001, 1.5]", -1.5 * RIGHT));
    let text = format!("{head}{left}{right}[[bodies.holds]]\nname = \"foot\"\nregion = {{ y = 0.0 }}\n");
    let Instance { simulation, bodies, .. } = Scene::parse(&text, "loaded.toml").unwrap().instantiate().unwrap();
    (simulation, bodies[0])
}

#[test]
fn a_dead_load_tears_at_the_speed_of_the_law_at_any_step() {
    for dt in [10.0, 5.0] {
        let (mut simulation, body) = loaded(1e-3);
        let mut steady: Vec<(f64, f64)> = Vec::new();
        while length(&simulation, body) < 13.0 && simulation.time() < 1500.0 {
            simulation.step(dt).unwrap();
            let torn = length(&simulation, body);
            if torn >= 9.0 {
                steady.push((simulation.time(), torn));
            }
        }
        let ((start, first), (end, last)) = (steady[0], steady[steady.len() - 1]);
        let speed = (last - first) / (end - start);
        println!("dt {dt} ms: {speed:.5} mm/ms");
        // v = v₀·(2F/(h·G_c) − 1) = 0.01 mm/ms. G is off by 1 % on a disc of two edges: v by 3 %; a step in which the tip rests by 2 %.
        assert!((speed / 0.01 - 1.0).abs() < 0.05, "dt {dt} ms: {speed} mm/ms");
    }
}

#[test]
fn no_tear_is_faster_than_rayleigh_waves() {
    // Shear waves of √(0.714 MPa/ρ): 0.027 mm/ms.
    let (mut simulation, body) = loaded(1e3);
    let fastest = 0.874 * (2.0_f64 / 2.8 / 1e3).sqrt();
    let tearing = *simulation.world().get::<&rhexis::components::Tearing>(body.entity()).unwrap();
    simulation.set(body, rhexis::components::Tearing { rate: None, ..tearing }).unwrap();
    // Drawn apart by 6 mm within one step: the toughness is exceeded many times.
    let mut held_back = 0;
    for _ in 0..40 {
        let before = length(&simulation, body);
        simulation.step(2.0).unwrap();
        let way = length(&simulation, body) - before;
        assert!(way <= 2.0 * fastest * (1.0 + 1e-9), "{way} mm in a step");
        held_back = simulation.report().bodies[0].tear_held_back;
    }
    println!("{held_back} steps held back, {} mm torn", length(&simulation, body) - 6.0);
}
