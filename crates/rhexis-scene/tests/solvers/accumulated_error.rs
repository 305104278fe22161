//! How far a run is from one whose linear systems are solved tightly.
//!
//! A slack capsule is chaotic: two runs part within some tens of steps at any tolerance, as a crumpled flap falls this way or that.
//! So the ends of two whole runs say nothing about the solver. What a solver can answer for is the error that it adds. So windows
//! of the run are taken, all of the same state at their start. In each the scene's own tolerances and tight ones go on side by
//! side. What parts them after so many steps is the error accumulated in these.

use glam::DVec3;
use rhexis::components::TearDecisions;
use rhexis::math::Sym2;
use rhexis::settings::{Advanced, LinearParams, Settings};
use rhexis::simulation::Simulation;
use rhexis::storage::Tips;
use rhexis::storage::Vertices;
use rhexis_scene::{Document, Instance};

/// Steps of a window, and from the start of one to that of the next.
const WINDOW: usize = 25;
const STRIDE: u64 = 100;

/// After so many steps the windows are compared.
const AFTER: [usize; 5] = [1, 2, 5, 10, 25];

fn capsule() -> Instance {
    let mut document = Document::named("capsulorhexis").unwrap();
    for set in ["bodies.0.mesh.cap.triangles=1500", "bodies.0.refinement.budget=3", "run.threads=1"] {
        document.set(set).unwrap();
    }
    document.scene().unwrap().instantiate().unwrap()
}

/// The mean stress about the tip that is nearest to tearing, and where that is in the rest shape.
fn tip(simulation: &Simulation) -> Option<(DVec3, Sym2)> {
    let body = simulation.bodies()[0];
    let world = simulation.world();
    let (tips, vertices) = (world.get::<&Tips>(body.entity()).unwrap(), world.get::<&Vertices>(body.entity()).unwrap());
    let decisions = world.get::<&TearDecisions>(body.entity()).unwrap();
    let known = tips.vertex.iter().zip(&decisions.tips).filter_map(|(&v, decision)| Some((v, decision.as_ref()?)));
    let (v, decision) = known.max_by(|(_, a), (_, b)| a.value.total_cmp(&b.value))?;
    Some((vertices.rest_position[v as usize], decision.stress))
}

fn norm(t: Sym2) -> f64 {
    t.xx.hypot(t.yy).hypot(std::f64::consts::SQRT_2 * t.xy)
}

fn quantile(sorted: &[f64], part: f64) -> f64 {
    sorted[((sorted.len() - 1) as f64 * part).round() as usize]
}

#[test]
#[ignore = "minutes: cargo test --release --test solvers accumulated_error -- --ignored --nocapture"]
fn the_stress_at_the_tip_is_that_of_tight_solves() {
    let mut instance = capsule();
    let dt = instance.run.dt;
    let mut errors: [Vec<f64>; AFTER.len()] = Default::default();
    let mut parted = [0; AFTER.len()];
    while !instance.is_finished() {
        if instance.step() % STRIDE != STRIDE / 2 {
            instance.advance().unwrap();
            instance.simulation.drain_events();
            continue;
        }
        let mut tight = Simulation::from_snapshot(&instance.simulation.snapshot()).unwrap();
        let settings = *tight.settings();
        tight
            .set_settings(Settings {
                advanced: Advanced { linear: LinearParams::by_residual(1e-9, 20_000), ..settings.advanced },
                ..settings
            })
            .unwrap();
        for step in 1..=WINDOW {
            if instance.is_finished() {
                break;
            }
            instance.advance().unwrap();
            tight.step(dt).unwrap();
            instance.simulation.drain_events();
            tight.drain_events();
            let Some(place) = AFTER.iter().position(|&after| after == step) else { continue };
            match (tip(&instance.simulation), tip(&tight)) {
                (Some((at, stress)), Some((other, tight))) if at == other => {
                    errors[place].push(norm(stress - tight) / norm(tight));
                }
                (None, None) => {}
                // Ahead or behind by an advance.
                _ => parted[place] += 1,
            }
        }
    }
    println!("| steps | compared | median | 90 % | worst | advances apart |\n|---|---|---|---|---|---|");
    for (place, after) in AFTER.into_iter().enumerate() {
        let sorted = &mut errors[place];
        sorted.sort_by(f64::total_cmp);
        let [median, most, worst] = [0.5, 0.9, 1.0].map(|part| 100.0 * quantile(sorted, part));
        println!("| {after} | {} | {median:.2} % | {most:.2} % | {worst:.2} % | {} |", sorted.len(), parted[place]);
        // Beyond, the crumpled flap has parted by itself.
        assert!(after > 10 || median < 1.0, "after {after} steps {median} %");
    }
}
