//! The balance of momentum in scenes: holds, jaws, obstacles and loads give its rate, while tissue tears and is refined, too.

use rhexis_scene::catalog::CATALOG;
use rhexis_scene::{Document, Instance};

/// A skin with a slit over a ball that comes through, with friction, weight and drag.
const SLIT: &str = r#"
[scene]
name = "slit"

[run]
dt = 5
steps = 42

[run.advanced]
linear_tolerance = 1e-8

[[bodies]]
name = "skin"
mesh = { disc = { radius = 8, triangles = 600 } }
material = { young = 1, poisson = 0.4, thickness = 0.2 }
damping = 2
drag = 1e-5
gravity = [0, 0, -9.81e-3]
contact = { friction = 0.2 }

[[bodies.cuts]]
polyline = [[-1, 0.1, 0], [1, 0.1, 0]]

[bodies.tearing]
toughness_along_fibres = 0.001
toughness_across_fibres = 0.001
radius = 1

[bodies.refinement]
edge = 0.4
margin = 0.5

[[bodies.holds]]
name = "rim"
region = { boundary = true, except = { radius = [0, 3] } }

[[obstacles]]
sphere = { centre = [0, 0, -3.01], radius = 3 }
path = [[0, [0, 0, 0]], [300, [0, 0, 5]]]
"#;

/// Largest force of holds and obstacles over a window of a scene, and the largest unbalanced force in steps without action of the energy guard \[N\].
fn run(instance: &mut Instance, steps: usize) -> [f64; 2] {
    let (mut largest, mut missing) = (0.0_f64, 0.0_f64);
    for _ in 0..steps {
        instance.advance().unwrap();
        let simulation = &instance.simulation;
        for (place, &body) in instance.bodies.iter().enumerate() {
            let told = simulation.contact_forces(body).unwrap().into_iter().map(|(_, force)| force);
            let told = told.chain(simulation.reactions(body).unwrap().into_iter().map(|(_, force)| force));
            largest = told.map(|force| force.length()).fold(largest, f64::max);
            let report = &simulation.report().bodies[place];
            if !(report.is_step_limited || report.relaxed_vertices > 0) {
                let off = simulation.unbalanced_force(body).unwrap().unwrap().length();
                missing = missing.max(off);
            }
        }
    }
    [largest, missing]
}

#[test]
fn a_ball_and_the_rim_balance_while_the_ball_tears_a_slit_open() {
    let mut instance = Document::new(SLIT, "slit").scene().unwrap().instantiate().unwrap();
    let [force, missing] = run(&mut instance, 42);
    let torn: f64 = instance.simulation.world().query::<&rhexis::components::TearLog>().iter().map(|l| l.area).sum();
    println!("{missing} of {force} N, torn {torn} mm²");
    assert!(torn > 0.0 && missing < 1e-4 * force, "{missing} of {force} N, torn {torn} mm²");
}

#[test]
fn scenes_of_the_catalog_with_obstacles_balance_their_momentum() {
    let found = CATALOG.iter().filter(|entry| entry.text.contains("[[obstacles]]"));
    for entry in found {
        let mut document = Document::new(entry.text, entry.name);
        document.set("bodies.0.mesh.cap.triangles=1500").unwrap();
        // Missing is the residual of the solve: small ones leave little.
        document.set("run.advanced.linear_tolerance=1e-3").unwrap();
        document.set("run.advanced.stress_tolerance=5e-3").unwrap();
        let mut instance = document.scene().unwrap().instantiate().unwrap();
        let [force, missing] = run(&mut instance, 40);
        println!("{}: {missing} of {force} N", entry.name);
        assert!(force > 0.0 && missing < 1e-2 * force, "{}: {missing} of {force} N", entry.name);
    }
}
