//! The same bits for any number of threads, for every run, and for a body alone or among others.

use crate::common::{self, Square, state_bits};
use rhexis::settings::Settings;
use rhexis::simulation::Simulation;
use rhexis::snapshot::StateHash;
use rhexis::storage::BodyId;

/// Steps after which each of the squares has torn.
const STEPS: usize = 16;

/// A square weak enough to tear within a few steps.
fn weak(cells: [usize; 2], fibre: f64) -> Square {
    let mut square = Square::new(cells, fibre);
    square.tearing.strength_across_fibres *= 0.2;
    square.tearing.strength_along_fibres *= 0.2;
    square
}

/// 6,000 triangles and 3,000 vertices: more than two chunks of 1,024 rows, so that threads do share the loops.
fn large() -> Square {
    weak([60, 50], 60.0)
}

/// The hash of the whole, and the bits of every body.
fn run(threads: usize, squares: &[Square]) -> (StateHash, Vec<Vec<u64>>) {
    let mut simulation = Simulation::new(Settings { threads, ..Settings::default() }).unwrap();
    assert_eq!(simulation.thread_count(), threads);
    let bodies: Vec<BodyId> = squares.iter().map(|square| square.spawn_into(&mut simulation)).collect();
    for _ in 0..STEPS {
        simulation.step(common::DT).unwrap();
    }
    for &body in &bodies {
        let advances = simulation.world().get::<&rhexis::components::TearLog>(body.entity()).unwrap().advance_count;
        assert!(advances > 2, "the state must be one after tears");
    }
    let bits = bodies.into_iter().map(|body| state_bits(&simulation, body)).collect();
    (simulation.hash(), bits)
}

#[test]
fn a_second_run_and_any_number_of_threads_give_the_same_bits() {
    let once = run(1, &[large()]);
    for threads in [1, 2, 3, 8] {
        assert!(run(threads, &[large()]) == once, "{threads} threads");
    }
}

/// In space, with the rows of an incomplete factor dissected, as a tear refines the mesh.
#[test]
fn halves_of_a_factor_give_the_same_bits_on_any_number_of_threads() {
    let run = |threads: usize, is_portable: bool| {
        let mut document = rhexis_scene::Document::named("capsulorhexis").unwrap();
        let changes = ["bodies.0.mesh.cap.triangles=9000", "bodies.0.tearing.toughness_along_fibres=0.3"];
        changes.into_iter().for_each(|change| document.set(change).unwrap());
        document.set(&format!("run.threads={threads}")).unwrap();
        document.set(&format!("run.portable_instructions={is_portable}")).unwrap();
        let mut instance = document.scene().unwrap().instantiate().unwrap();
        (0..160).for_each(|_| _ = instance.advance().unwrap());
        let advances =
            instance.simulation.world().get::<&rhexis::components::TearLog>(instance.bodies[0].entity()).unwrap();
        assert!(advances.advance_count > 2, "the state must be one after tears");
        drop(advances);
        instance.simulation.hash()
    };
    let once = run(1, false);
    for (threads, is_portable) in [(2, false), (3, true), (8, false)] {
        assert_eq!(run(threads, is_portable), once, "{threads} threads, portable instructions: {is_portable}");
    }
}

#[test]
fn bodies_in_one_world_do_not_touch_each_other() {
    let squares = [weak([30, 26], 90.0), weak([20, 16], 45.0)];
    let alone = squares.clone().map(|square| run(1, &[square]).1.remove(0));
    let [a, b] = squares;
    let (hash, both) = run(2, &[a.clone(), b.clone()]);
    assert!(both == alone);
    let (swapped, both) = run(2, &[b, a.clone()]);
    assert!(both == [alone[1].clone(), alone[0].clone()]);
    assert_ne!(hash, swapped, "the hash runs over the bodies in their order");
    assert!(run(2, &[a.clone(), a]).1 == [alone[0].clone(), alone[0].clone()]);
}
