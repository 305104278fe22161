//! Dynamic steps with a Cholesky factor that is kept and renewed: the same steps as with block Jacobi, in a fraction of the
//! iterations, and the same bits for any number of threads.

use crate::common::{Run, Square, state_bits};
use glam::DVec3;
use rhexis::components::{Fibres, Gravity, Hold, Material, TearMode, Tearing};
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::settings::{Advanced, LinearParams, Preconditioner, Settings};
use rhexis::simulation::Simulation;
use rhexis::storage::Vertices;

fn settings(preconditioner: Preconditioner, threads: usize) -> Settings {
    let linear = LinearParams { tolerance: 1e-9, ..LinearParams::default() };
    let advanced = Advanced { preconditioner, linear, ..Advanced::default() };
    Settings { budget: None, threads, advanced, ..Settings::default() }
}

/// Steps the square and returns the iterations of every step.
fn iterations(run: &mut Run, steps: usize) -> Vec<u32> {
    (0..steps).map(|_| run.simulation.step(2.0).unwrap().bodies[0].iterations).collect()
}

/// Largest distance \[mm\] between the vertices of two runs.
fn distance(a: &Run, b: &Run) -> f64 {
    let positions = |run: &Run| run.simulation.world().get::<&Vertices>(run.body.entity()).unwrap().position.clone();
    let (a, b) = (positions(a), positions(b));
    assert_eq!(a.len(), b.len(), "the same edits");
    a.iter().zip(&b).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max)
}

#[test]
fn an_elastic_sheet_steps_alike_in_few_iterations() {
    let strong = Tearing { strength_across_fibres: 1e6, strength_along_fibres: 1e6, ..Tearing::default() };
    let square = Square { tearing: strong, ..Square::new([30, 26], 45.0) };
    let [mut plain, mut factored] =
        [Preconditioner::BlockJacobi, Preconditioner::Cholesky].map(|kind| square.spawn(settings(kind, 1)));
    let (few, many) = (iterations(&mut factored, 84), iterations(&mut plain, 84));
    println!("with the factor {few:?}, without {many:?}");
    if cfg!(feature = "direct") {
        // Ten with an old factor at the most, and one or two with the next.
        assert!(few.iter().all(|&n| n <= 12), "{few:?}");
    }
    // Every step leaves at most 1e-9 of an increment of some 0.01 mm; the conditioning of the sheet, 1e4, times 84 steps.
    let off = distance(&plain, &factored);
    assert!(off < 1e-5, "{off:e} mm");
}

#[test]
fn a_torn_sheet_tears_alike_across_edits() {
    let mut square = Square::new([30, 26], 60.0);
    // By whole triangles, which do not show the last digits of a solve.
    square.tearing.mode = TearMode::Free;
    let [mut plain, mut factored] =
        [Preconditioner::BlockJacobi, Preconditioner::Cholesky].map(|kind| square.spawn(settings(kind, 1)));
    let (mut few, mut many) = (0, 0);
    for run in [&mut plain, &mut factored] {
        run.stretch_to(0.8);
    }
    for step in 0..400 {
        let [a, b] = [&mut plain, &mut factored].map(|run| iterations(run, 1)[0]);
        // Once the tear runs through it is the tear's own instability that decides how far it comes in a step.
        if plain.log().end_count > 0 {
            break;
        }
        assert_eq!(plain.log().advance_count, factored.log().advance_count, "step {step}");
        (many, few) = (many + a, few + b);
    }
    println!("{} advances, {few} iterations, {many} without a factor", factored.log().advance_count);
    assert!(plain.log().advance_count > 5, "the state must be one after tears");
    if cfg!(feature = "direct") {
        assert!(few * 3 < many, "{few} against {many}");
    }
}

/// A factor of the sheet before it has turned serves as well after: it is turned with the tissue.
#[test]
fn a_body_that_turns_keeps_its_factor() {
    let tight = settings(Preconditioner::Cholesky, 1);
    let settings = Settings { advanced: Advanced { linear: LinearParams::default(), ..tight.advanced }, ..tight };
    let mut simulation = Simulation::new(settings).unwrap();
    let mesh = generate::grid(30.0, 30.0, 30, 26).unwrap();
    let sheet = Membrane::new("sheet", mesh, Material::allard_2009()).fibres(Fibres::at_degrees(45.0)).planar();
    let body = simulation.spawn(sheet).unwrap();
    {
        let mut vertices = simulation.world().get::<&mut Vertices>(body.entity()).unwrap();
        let Vertices { position, velocity, .. } = &mut *vertices;
        position.iter().zip(velocity).for_each(|(x, u)| *u = DVec3::Z.cross(*x - DVec3::new(15.0, 15.0, 0.0)) * 0.01);
    }
    // Two radians.
    let iterations: Vec<u32> = (0..200).map(|_| simulation.step(1.0).unwrap().bodies[0].iterations).collect();
    println!("{iterations:?}");
    if cfg!(feature = "direct") {
        // With more it would have been renewed.
        assert!(iterations.iter().all(|&n| n <= 10), "{iterations:?}");
    }
}

/// Where the residual is hardly asked for, a factor of an earlier state is not taken for good before the stress is: a new one is made.
#[test]
fn a_factor_made_on_the_spot_goes_as_far_as_the_stress_asks() {
    let linear = LinearParams { tolerance: 1.0, stress_tolerance: 1e-8, ..LinearParams::default() };
    let settings = Settings {
        threads: 1,
        advanced: Advanced { preconditioner: Preconditioner::Cholesky, linear, ..Advanced::default() },
        ..Settings::default()
    };
    let mut run = Square::new([30, 26], 60.0).spawn(settings);
    run.stretch_to(0.8);
    for step in 0..200 {
        let error = run.simulation.step(2.0).unwrap().bodies[0].stress_error;
        // What is asked for, as the step itself estimates it.
        assert!(error <= 1e-8, "step {step}: {error:e}");
    }
    assert!(run.log().advance_count > 2, "the state must be one that factors do not outlast");
}

#[test]
fn any_number_of_threads_gives_the_same_bits_across_renewals() {
    let state = |threads| {
        let mut run = Square::new([50, 44], 60.0).spawn(settings(Preconditioner::Cholesky, threads));
        run.stretch_to(0.85);
        iterations(&mut run, 120);
        assert!(run.log().advance_count > 2, "the state must be one after tears");
        state_bits(&run.simulation, run.body)
    };
    assert!(state(1) == state(2));
}

/// Fallback factors and iterations of every step of a slack sheet under its weight, hung by a rim.
fn fallback_factors(dt: f64) -> Vec<[u32; 2]> {
    let linear = LinearParams::by_residual(1e-9, 20_000);
    let advanced = Advanced { linear, ..Advanced::default() };
    let mut simulation = Simulation::new(Settings { threads: 1, advanced, ..Settings::default() }).unwrap();
    let mesh = generate::grid(20.0, 20.0, 12, 12).unwrap();
    let sheet = Membrane::new("sheet", mesh, Material { thickness: 0.015, ..Material::allard_2009() });
    let hold = Hold::new("rim", sheet.select(|p| p.y == 20.0));
    let weight = Gravity { acceleration: DVec3::new(0.0, -9.81e-3, 2e-3) };
    simulation.spawn(sheet.fibres(Fibres::at_degrees(30.0)).hold(hold).with(weight)).unwrap();
    let step = |_| {
        let body = &simulation.step(dt).unwrap().bodies[0];
        [body.fallback_factors, body.iterations]
    };
    (0..6).map(step).collect()
}

#[test]
fn factors_made_on_the_spot_are_counted() {
    let (easy, hard) = (fallback_factors(0.1), fallback_factors(1e4));
    println!("[factors, iterations] of short steps {easy:?}, of long ones {hard:?}");
    assert!(easy.iter().all(|&[factors, _]| factors == 0), "{easy:?}");
    // Without the feature `direct` there is none to make.
    assert_eq!(hard.iter().any(|&[factors, _]| factors > 0), cfg!(feature = "direct"), "{hard:?}");
}
