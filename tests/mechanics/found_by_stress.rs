//! What `rhexis stress` has found, each as small as it came out.

use crate::noise::{noise, noises};
use glam::DVec3;
use rhexis::components::{
    Contact, Curve, Damping, Fibres, GuardLedger, Hold, Material, Obstacle, Shape, TearMode, Tearing,
};
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::settings::{Advanced, LinearParams, Preconditioner, Settings, Tangent};
use rhexis::simulation::Simulation;
use rhexis::storage::{Attached, BodyId, TriangleMesh, Triangles, Vertices, measure};

/// Stiff fibres in soft tissue.
fn stiff_fibres() -> Material {
    Material {
        young_fibre: 6.0,
        young_transverse: 0.09,
        poisson_major: 0.05,
        shear_modulus: Some(0.01),
        thickness: 0.1,
        density: 1e-3,
    }
}

fn spawn(settings: Settings, membrane: Membrane) -> (Simulation, BodyId) {
    let mut simulation = Simulation::new(Settings { threads: 1, ..settings }).unwrap();
    let body = simulation.spawn(membrane).unwrap();
    (simulation, body)
}

fn crumple(simulation: &mut Simulation, body: BodyId, size: f64, seed: usize, is_planar: bool) {
    let mut vertices = simulation.world().get::<&mut Vertices>(body.entity()).unwrap();
    for (v, x) in vertices.position.iter_mut().enumerate() {
        let by = noises(v, seed) * size;
        *x += if is_planar { by.with_z(0.0) } else { by };
    }
}

/// Steps a body that nothing acts on, and asks that it gains no more than a tenth and what belongs to that, while its mesh stays.
fn assert_gains_nothing(simulation: &mut Simulation, body: BodyId, dt: f64, steps: usize, slack: f64) {
    let mut start: Option<(f64, Vec<[u32; 3]>)> = None;
    for i in 0..steps {
        let report = simulation.step(dt).unwrap();
        assert!(!report.has_failed);
        let energies = simulation.energies(body).unwrap();
        let energy = energies.elastic + energies.kinetic;
        let corners = simulation.world().get::<&Triangles>(body.entity()).unwrap().corners.clone();
        match &start {
            Some((before, same)) if *same == corners => {
                assert!(energy <= 1.112 * (before + slack), "step {i} of {dt} ms: {energy:e} mJ, {before:e} at first");
            }
            _ => start = Some((energy, corners)),
        }
    }
}

/// What a strain of 1 % stores in a sheet of 4 × 4 mm of this material \[mJ\].
const SLACK: f64 = 0.5 * 16.0 * 0.1 * 6.09 * 1e-4;

#[test]
fn the_smallest_part_of_a_step_counts_what_its_near_triangles_create() {
    // A crumpled planar sheet that went only a part of its way doubled its energy: changes below a tenth were not counted there, which
    // turn over what is crushed.
    for seed in 0..40 {
        for dt in [1.0, 25.0, 100.0] {
            let mesh = generate::grid(4.0, 4.0, 5, 5).unwrap();
            let sheet = Membrane::new("sheet", mesh, stiff_fibres()).fibres(Fibres::at_degrees(30.0)).planar();
            let (mut simulation, body) = spawn(
                Settings { advanced: Advanced { max_step_halvings: 0, ..Advanced::default() }, ..Settings::default() },
                sheet,
            );
            crumple(&mut simulation, body, 4.0, seed, true);
            assert_gains_nothing(&mut simulation, body, dt, 12, SLACK);
        }
    }
}

#[test]
fn where_the_exact_tangent_gives_way_the_answer_is_judged_by_the_rotated_one() {
    // A crushed sheet is solved along the rotated tangent where the exact one is indefinite. The energy guard took the exact one's
    // geometric stiffness with it, and vertices that were relaxed locally went to 1.3 times the energy here, in `rhexis stress` to 1.6 times.
    for seed in 0..40 {
        for (dt, size) in [(0.2, 2.0), (1.0, 4.0), (30.0, 4.0)] {
            let mesh = generate::grid(4.0, 4.0, 5, 5).unwrap();
            let sheet = Membrane::new("sheet", mesh, stiff_fibres()).fibres(Fibres::at_degrees(30.0)).planar();
            let (mut simulation, body) = spawn(
                Settings {
                    advanced: Advanced { tangent: Tangent::Exact, ..Advanced::default() },
                    ..Settings::default()
                },
                sheet,
            );
            crumple(&mut simulation, body, size, seed, true);
            assert_gains_nothing(&mut simulation, body, dt, 20, SLACK);
        }
    }
}

#[test]
fn a_patch_counts_the_work_of_what_a_solve_leaves() {
    // Iterations that end far from the answer leave a residual larger than the load. Where a few vertices then went another way than the
    // solve's, its work along the difference was forgotten: crumpled sheets came to twice their energy, in `rhexis stress` to 24 times.
    for (young_fibre, iterations, dt) in [(1900.0, 5, 1.0), (19000.0, 20, 60.0)] {
        for seed in 0..8 {
            let mesh = generate::grid(4.0, 4.0, 9, 9).unwrap();
            let (young_transverse, thickness) = (6.0, 1.5e-3);
            let material = Material {
                young_fibre,
                young_transverse,
                poisson_major: 0.3,
                shear_modulus: Some(2.0),
                thickness,
                density: 1e-3,
            };
            let sheet = Membrane::new("sheet", mesh, material).fibres(Fibres::at_degrees(30.0));
            let linear = LinearParams { iterations, ..LinearParams::default() };
            let preconditioner = Preconditioner::Multigrid;
            let settings = Settings {
                advanced: Advanced { linear, max_step_halvings: 0, preconditioner, ..Advanced::default() },
                ..Settings::default()
            };
            let (mut simulation, body) = spawn(settings, sheet);
            crumple(&mut simulation, body, 1.0, seed, false);
            let slack = 0.5 * 16.0 * thickness * (young_fibre + young_transverse) * 1e-4;
            assert_gains_nothing(&mut simulation, body, dt, 8, slack);
        }
    }
}

#[test]
fn a_damped_body_that_goes_forth_and_back_within_a_step_gains_nothing() {
    // A second solve of the step goes back on some of the first one's way, and on what damping has taken for that.
    for seed in 0..20 {
        let mesh = generate::grid(4.0, 4.0, 5, 5).unwrap();
        let tearing = Tearing {
            strength_across_fibres: 0.3,
            strength_along_fibres: 1e-4,
            radius: 1.0,
            mode: TearMode::Edge,
            ..Tearing::default()
        };
        let sheet = Membrane::new("sheet", mesh, stiff_fibres()).fibres(Fibres::at_degrees(30.0));
        let (mut simulation, body) = spawn(Settings::default(), sheet.with(tearing).with(Damping { time: 80.0 }));
        simulation.cut(body, &[DVec3::new(1.1, 2.0, 0.0), DVec3::new(2.1, 2.2, 0.0)]).unwrap();
        crumple(&mut simulation, body, 3.0, seed, false);
        assert_gains_nothing(&mut simulation, body, 20.0, 12, SLACK);
    }
}

#[test]
fn a_damped_sheet_that_spins_gains_nothing_by_small_turns() {
    // A turn by 0.06 rad stretches by 0.18 %. Damping keeps that from going back, so that it adds up, step by step;
    // turns below a tenth were not looked at.
    for is_planar in [true, false] {
        let mesh = generate::grid(4.0, 4.0, 5, 5).unwrap();
        let mut sheet = Membrane::new("sheet", mesh, stiff_fibres()).fibres(Fibres::at_degrees(30.0));
        sheet = sheet.with(Damping { time: 1e4 });
        if is_planar {
            sheet = sheet.planar();
        }
        let (mut simulation, body) = spawn(Settings::default(), sheet);
        let spin = DVec3::Z * 0.06;
        {
            let mut vertices = simulation.world().get::<&mut Vertices>(body.entity()).unwrap();
            let Vertices { position, velocity, .. } = &mut *vertices;
            for (v, x) in velocity.iter_mut().zip(position) {
                *v = spin.cross(*x - DVec3::new(2.0, 2.0, 0.0));
            }
        }
        assert_gains_nothing(&mut simulation, body, 1.0, 60, SLACK);
    }
}

#[test]
fn a_triangle_beside_held_corners_is_put_outside_an_obstacle_by_no_more_than_twice_the_depth() {
    // What is in an obstacle after all solves is put outside by its free axes. Where little of them points outwards it went 1e50 mm in some
    // rounds, and from there to what is not finite, which nobody looked for.
    for (is_planar, height) in [(true, 2.9), (true, 2.6), (true, 1.0), (false, 0.5), (false, 2.5)] {
        for seed in 0..12 {
            let mesh = generate::grid(10.0, 10.0, 2, 2).unwrap();
            let mut sheet = Membrane::new("sheet", mesh, stiff_fibres()).fibres(Fibres::at_degrees(30.0));
            if is_planar {
                sheet = sheet.planar();
            }
            let held = sheet.select(|p| p.x < 9.0 || p.y < 4.0).into_iter().map(|v| (v, DVec3::ZERO));
            let members = Attached::new(held);
            let hold = Hold { name: "most".into(), members, axes: [true; 3], curve: Curve::constant(0.0) };
            let sheet = sheet.hold(hold).with(Contact { stiffness: Some(0.1), friction: 1.0, ..Contact::default() });
            let (mut simulation, body) = spawn(Settings::default(), sheet);
            let sphere = |centre| Shape::Sphere { centre, radius: 3.0 };
            let obstacle = simulation.spawn_obstacle(Obstacle { shape: sphere(DVec3::Z * 50.0) }).unwrap();
            for i in 0..6 {
                let by = noises(i, seed);
                let centre = DVec3::new(5.0 + 4.0 * by.x, 5.0 + 4.0 * by.y, height);
                simulation.move_obstacle(obstacle, sphere(centre)).unwrap();
                simulation.step(0.4).unwrap();
                let vertices = simulation.world().get::<&Vertices>(body.entity()).unwrap();
                let farthest = vertices.position.iter().map(|x| x.length()).fold(0.0, f64::max);
                assert!(farthest < 1e4, "planar {is_planar}, height {height}, seed {seed}: {farthest:e} mm");
            }
        }
    }
}

#[test]
fn the_corners_of_an_octahedron_stay_where_cuts_would_have_them_slide() {
    // A vertex near a cut was moved onto it although it stood out of the surface: a quarter of the area was gone after some cuts.
    let positions = vec![DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
    let positions: Vec<DVec3> = positions.into_iter().map(|x| x * DVec3::new(8.0, 6.0, 5.0)).collect();
    let triangles = vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    let mut cuts = 0;
    for seed in 0..60 {
        let mesh =
            TriangleMesh { positions: positions.clone(), triangles: triangles.clone(), ..TriangleMesh::default() };
        let body = Membrane::new("octahedron", mesh, stiff_fibres()).fibres(Fibres::Uniform(DVec3::new(1.0, 2.0, 3.0)));
        let (mut simulation, body) = spawn(Settings::default(), body.with(Tearing::default()));
        let area = |simulation: &Simulation| {
            measure::total_area(&simulation.world().get::<&Triangles>(body.entity()).unwrap())
        };
        let before = area(&simulation);
        for i in 0..4 {
            let at = |k: usize| {
                let part = 0.5 + 0.5 * noise(7 * seed + 1000 * i + k);
                let corners = triangles[(seed + i + 3 * k) % 8].map(|v: u32| positions[v as usize]);
                corners[0].lerp(corners[1], part).lerp(corners[2], 0.3 + 0.4 * part)
            };
            cuts += usize::from(simulation.cut(body, &[at(0), at(1)]).is_ok());
        }
        let after = area(&simulation);
        assert!((after - before).abs() <= 1e-9 * before, "seed {seed}: {after} mm², {before} at first");
    }
    assert!(cuts > 20, "{cuts}");
}

/// The bound that excludes gains of energy as `rhexis stress` had them in case 5588, and with six corrections in seed 2.
///
/// Where nothing feeds a body, a solve raises its energy E by its spurious energy at most. The ledger sums that: S, and the bounds U of solves
/// that were not summed. A solve is accepted where S ≤ L and U ≤ L/10, with the limit L = (E + W)/10 and the energy W of a strain of 1 %. Any
/// other is undone and leaves E as it was. A correction is judged by the limit of the solve that it corrects, with all energy created since, so
/// that the number of corrections does not enter. Hence no accepted solve gains more than 0.11·(E + W). The test asks for this ledger and for
/// the bound of `rhexis stress` after every step.
#[test]
fn the_ledger_stays_below_its_limit_whatever_the_number_of_corrections() {
    const LEDGER: f64 = 0.11;
    let mut acted = [0; 3];
    for corrections in [0, 1, 6, 10] {
        for seed in 0..6 {
            for (dt, size, is_planar) in [(1.0, 4.0, true), (30.0, 2.0, false), (100.0, 4.0, false)] {
                let mesh = generate::grid(4.0, 4.0, 5, 5).unwrap();
                let mut sheet = Membrane::new("sheet", mesh, stiff_fibres()).fibres(Fibres::at_degrees(30.0));
                if is_planar {
                    sheet = sheet.planar();
                }
                let advanced = Advanced { newton_corrections: corrections, ..Advanced::default() };
                let (mut simulation, body) = spawn(Settings { advanced, ..Settings::default() }, sheet);
                crumple(&mut simulation, body, size, seed, is_planar);
                if !is_planar {
                    // A corner that is held still takes no energy in; a body that may spin gets no corrections.
                    let corner = simulation.view(body).unwrap().vertex_keys[0];
                    simulation.pin(body, "corner", &[corner]).unwrap();
                }
                let energy = |simulation: &Simulation| {
                    let energies = simulation.energies(body).unwrap();
                    energies.elastic + energies.kinetic
                };
                let start = energy(&simulation);
                for step in 0..20 {
                    let report = simulation.step(dt).unwrap();
                    let guard = report.bodies[0].guard;
                    acted[0] += guard.refusals();
                    acted[1] += guard.corrections();
                    acted[2] += guard.relaxations();
                    let what = format!("{corrections} corrections, seed {seed}, step {step} of {dt} ms");
                    let now = energy(&simulation);
                    let most = 1.112 * (start + SLACK);
                    assert!(now <= most, "{what}: {now:e} mJ, {start:e} at first");
                    let ledger = simulation.world().get::<&GuardLedger>(body.entity()).unwrap();
                    let spurious = ledger.spurious_energy;
                    assert!(spurious <= LEDGER * (most + SLACK), "{what}: {spurious:e} mJ are spurious, of {start:e}");
                }
            }
        }
    }
    assert!(acted.iter().all(|count| *count > 0), "undone, corrected, relaxed: {acted:?}");
}

#[cfg(feature = "snapshot")]
#[test]
fn a_snapshot_of_a_body_just_set_elsewhere_is_read_back() {
    // Velocities of a start were left that had been taken away.
    let mesh = generate::grid(4.0, 4.0, 3, 3).unwrap();
    let sheet = Membrane::new("sheet", mesh, stiff_fibres()).fibres(Fibres::at_degrees(30.0));
    let (mut simulation, body) = spawn(Settings::default(), sheet);
    for i in 0..3 {
        simulation.step(1.0).unwrap();
        simulation.teleport(body, glam::DQuat::from_rotation_y(0.3), DVec3::splat(f64::from(i))).unwrap();
        let bytes = simulation.snapshot().to_bytes().unwrap();
        let read = rhexis::snapshot::Snapshot::from_bytes(&bytes).unwrap();
        let mut restored = Simulation::from_snapshot(&read).unwrap();
        simulation.step(2.0).unwrap();
        restored.step(2.0).unwrap();
        assert_eq!(restored.hash(), simulation.hash());
    }
}
