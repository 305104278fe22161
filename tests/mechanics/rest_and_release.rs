//! What a body does that is left to itself: at rest it stays, spinning it keeps its angular momentum as far as the integrator promises,
//! taut it comes to rest from noise, and let go from any collapse it comes back to a shape without stress.

use crate::noise::noises;
use glam::{DMat3, DVec3};
use rhexis::components::{Curve, Damping, Drag, Fibres, Hold, Material};
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::settings::{Accuracy, Advanced, Integrator, LinearParams, Settings, Tangent};
use rhexis::simulation::Simulation;
use rhexis::storage::{Attached, BodyId, Triangles, Vertices};

/// Side of the sheets \[mm\].
const SIDE: f64 = 10.0;
const CENTRE: DVec3 = DVec3::new(0.5 * SIDE, 0.5 * SIDE, 0.0);

fn sheet(cells: usize) -> Membrane {
    let mesh = generate::grid(SIDE, SIDE, cells, cells).unwrap();
    Membrane::new("sheet", mesh, Material::allard_2009()).fibres(Fibres::at_degrees(30.0))
}

fn spawn(settings: Settings, membrane: Membrane) -> (Simulation, BodyId) {
    let mut simulation = Simulation::new(Settings { threads: 1, ..settings }).unwrap();
    let body = simulation.spawn(membrane).unwrap();
    (simulation, body)
}

/// Sets position and velocity from number and rest position.
fn set(simulation: &Simulation, body: BodyId, motion: impl Fn(usize, DVec3) -> (DVec3, DVec3)) {
    let mut vertices = simulation.world().get::<&mut Vertices>(body.entity()).unwrap();
    for v in 0..vertices.len() {
        (vertices.position[v], vertices.velocity[v]) = motion(v, vertices.rest_position[v]);
    }
}

fn positions(simulation: &Simulation, body: BodyId) -> Vec<DVec3> {
    simulation.world().get::<&Vertices>(body.entity()).unwrap().position.clone()
}

// ---------------------------------------------------------------------------------------------------------------- rest

/// Steps a sheet at rest and asks that no bit of its state has changed: a state that a step leaves as it is it leaves for ever.
fn assert_rests(settings: Settings, membrane: Membrane, dt: f64, steps: usize) {
    let (mut simulation, body) = spawn(settings, membrane);
    let start = positions(&simulation, body);
    for _ in 0..steps {
        simulation.step(dt).unwrap();
    }
    let vertices = simulation.world().get::<&Vertices>(body.entity()).unwrap();
    let moved = start.iter().zip(&vertices.position).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
    assert!(moved == 0.0 && vertices.velocity.iter().all(|v| *v == DVec3::ZERO), "moved by {moved:e} mm at {dt} ms");
}

/// Anisotropic sheets in a plane, in space, and turned and far from the origin.
fn resting() -> [Membrane; 3] {
    let turned = {
        let mut mesh = generate::jittered(SIDE, SIDE, 3, 3, 5).unwrap();
        let turn = DMat3::from_axis_angle(DVec3::new(2.0, 1.0, -2.0) / 3.0, 1.1);
        mesh.positions.iter_mut().for_each(|x| *x = turn * *x + DVec3::new(70.0, -20.0, 30.0));
        Membrane::new("turned", mesh, Material::allard_2009()).fibres(Fibres::Uniform(turn * DVec3::new(0.6, 0.8, 0.0)))
    };
    [sheet(2).planar(), sheet(2), turned]
}

#[test]
fn a_free_sheet_at_rest_stays_at_rest() {
    for settings in [Settings::default(), Settings::new(Accuracy::Accurate)] {
        for dt in [0.01, 1.0, 100.0] {
            resting().into_iter().for_each(|membrane| assert_rests(settings, membrane, dt, 100));
        }
    }
}

#[test]
#[ignore = "minutes: cargo test --release --test mechanics -- --ignored million"]
fn for_a_million_steps() {
    resting().into_iter().for_each(|membrane| assert_rests(Settings::default(), membrane, 100.0, 1_000_000));
}

// ---------------------------------------------------------------------------------------------------------------- spin

/// About the centre of mass \[g·mm²/ms\].
fn angular_momentum(simulation: &Simulation, body: BodyId) -> DVec3 {
    let vertices = simulation.world().get::<&Vertices>(body.entity()).unwrap();
    let rows = || vertices.position.iter().zip(&vertices.velocity).zip(&vertices.mass);
    let mass: f64 = vertices.mass.iter().sum();
    let centre = rows().map(|((x, _), m)| *x * *m).sum::<DVec3>() / mass;
    rows().map(|((x, v), m)| (*x - centre).cross(*v) * *m).sum()
}

/// The part of its angular momentum that a free sheet has after so many steps of `angle` radians each.
fn kept(settings: Settings, axis: DVec3, angle: f64, steps: usize) -> f64 {
    let (mut simulation, body) = spawn(settings, sheet(6));
    set(&simulation, body, |_, x| (x, axis.cross(x - CENTRE) * angle));
    let start = angular_momentum(&simulation, body);
    for _ in 0..steps {
        simulation.step(1.0).unwrap();
    }
    angular_momentum(&simulation, body).dot(start) / start.length_squared()
}

const AXES: [DVec3; 3] = [DVec3::X, DVec3::Z, DVec3::new(0.6, 0.0, 0.8)];

fn tight(settings: Settings) -> Settings {
    let linear = LinearParams::by_residual(1e-12, 20_000);
    Settings {
        advanced: Advanced {
            linear,
            tangent: Tangent::Projected,
            newton_iterations: 30,
            newton_tolerance: 1e-11,
            ..settings.advanced
        },
        ..settings
    }
}

#[test]
fn the_default_step_keeps_the_spin_in_the_plane_and_gains_none_out_of_it() {
    // In the plane the tangent exerts no torque: only what a linear solve leaves of its residual is lost, 1e-10 a step.
    let settings = Settings {
        advanced: Advanced { linear: LinearParams::by_residual(1e-10, 20_000), ..Advanced::default() },
        ..Settings::default()
    };
    for angle in [0.001, 0.01, 0.1] {
        let kept = kept(settings, DVec3::Z, angle, 300);
        assert!((kept - 1.0).abs() < 1e-7, "{angle} rad: {kept}");
    }
    for (axis, angle) in [(DVec3::X, 0.001), (DVec3::X, 0.1), (AXES[2], 0.01)] {
        // The tension that the tangential way of a step brings holds the sheet in its plane as it was: it brakes.
        let kept = kept(settings, axis, angle, 100);
        assert!(kept < 1.0 + 1e-9 && kept > 0.0, "{axis}, {angle} rad: {kept}");
    }
}

#[test]
fn a_converged_step_of_backward_euler_loses_the_square_of_its_angle() {
    // x₁×v₁ = x₀×v₀ + Δt·v₁×v₀: the torque is none about x₁. Half of it in the first step, which begins with v₀ tangential.
    for axis in AXES {
        let (angle, steps) = (0.01, 100);
        let lost = 1.0 - kept(tight(Settings::default()), axis, angle, steps);
        // About a slanted axis the tensor of inertia takes part; what is lost stays under the square.
        let most = angle * angle * steps as f64;
        assert!(lost < most && lost > 0.8 * most, "{axis}: {lost:e} of {most:e}");
    }
}

#[test]
fn tr_bdf2_keeps_the_spin_to_the_fourth_order_of_its_angle() {
    let tr_bdf2 = Settings {
        advanced: Advanced { integrator: Integrator::TrBdf2, ..Advanced::default() },
        ..Settings::default()
    };
    for axis in AXES {
        // At first, while the centrifugal tension builds up, 0.2 of the square; from then on 0.02 of the fourth power a step.
        let lost = 1.0 - kept(tight(tr_bdf2), axis, 0.01, 200);
        assert!(lost.abs() < 3e-5, "{axis}: {lost:e}");
        // Two iterations leave something of their own.
        let accurate = 1.0 - kept(Settings::new(Accuracy::Accurate), axis, 0.01, 200);
        assert!(accurate.abs() < 1e-3, "{axis}, accurate: {accurate:e}");
    }
}

// --------------------------------------------------------------------------------------------------------------- noise

#[test]
fn noise_on_a_taut_sheet_decays_at_any_time_step() {
    for settings in [Settings::default(), Settings::new(Accuracy::Accurate)] {
        for dt in [0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0] {
            let membrane = sheet(8);
            let ends = membrane.select(|p| p.x == 0.0 || p.x == SIDE).into_iter();
            let rest = membrane.mesh().positions.clone();
            let members = Attached::new(ends.map(|v| (v, DVec3::X * (0.1 * (rest[v as usize].x - 0.5 * SIDE)))));
            let hold = Hold { name: "ends".into(), members, axes: [true; 3], curve: Curve::constant(1.0) };
            let (mut simulation, body) = spawn(settings, membrane.hold(hold));
            simulation.settle(0.0, 1e-10).unwrap();
            let start = positions(&simulation, body);
            let is_free = |x: DVec3| x.x > 0.0 && x.x < SIDE;
            set(&simulation, body, |v, x| (start[v], if is_free(x) { noises(v, 1) * 1e-6 } else { DVec3::ZERO }));
            let size = |s: &Simulation| {
                let vertices = s.world().get::<&Vertices>(body.entity()).unwrap();
                vertices.velocity.iter().map(|v| v.length_squared()).sum::<f64>().sqrt()
            };
            let before = size(&simulation);
            (0..80).for_each(|_| _ = simulation.step(dt).unwrap());
            let left = size(&simulation) / before;
            assert!(left < 1.0, "{dt} ms: {left}");
        }
    }
}

// ------------------------------------------------------------------------------------------------------------- release

#[derive(Clone, Copy, Debug, PartialEq)]
enum Collapse {
    /// All vertices within 1e-9 mm of one point.
    Point,
    /// All vertices in one point.
    Exact,
    /// Anywhere: about half of the triangles of a planar body are inverted.
    Anywhere,
    /// Mirrored as a whole, but for 1e-6 mm.
    Mirrored,
    /// A third of the vertices thrown by one and a half edges.
    Thrown,
    /// Pressed together by half along both axes.
    Half,
    /// In a line.
    Line,
}

const COLLAPSES: [Collapse; 7] = [
    Collapse::Point,
    Collapse::Exact,
    Collapse::Anywhere,
    Collapse::Mirrored,
    Collapse::Thrown,
    Collapse::Half,
    Collapse::Line,
];

impl Collapse {
    fn of(self, v: usize, x: DVec3, edge: f64, seed: usize) -> DVec3 {
        let by = noises(v, seed);
        match self {
            Self::Point => CENTRE + by * 1e-9,
            Self::Exact => CENTRE,
            Self::Anywhere => CENTRE + by * (0.5 * SIDE),
            Self::Mirrored => DVec3::new(SIDE - x.x, x.y, 0.0) + by * 1e-6,
            Self::Thrown if by.x > 0.3 => x + noises(v, seed + 7).normalize() * (1.5 * edge),
            Self::Thrown => x,
            Self::Half => CENTRE + (x - CENTRE) * 0.5 + by * 1e-6,
            Self::Line => DVec3::new(x.x, CENTRE.y, 0.0) + by * 1e-9,
        }
    }
}

/// The largest strain of an edge.
fn edge_strain(simulation: &Simulation, body: BodyId) -> f64 {
    let vertices = simulation.world().get::<&Vertices>(body.entity()).unwrap();
    let triangles = simulation.world().get::<&Triangles>(body.entity()).unwrap();
    let edges = triangles.corners.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
    let strain = |(a, b): (u32, u32)| {
        let [a, b] = [a as usize, b as usize];
        let length = vertices.position[a].distance(vertices.position[b]);
        (length / vertices.rest_position[a].distance(vertices.rest_position[b]) - 1.0).abs()
    };
    edges.map(strain).fold(0.0, f64::max)
}

/// How far the vertices are from the rest shape moved rigidly in the plane to where the body is \[mm\].
fn off_rest_shape(simulation: &Simulation, body: BodyId) -> f64 {
    let vertices = simulation.world().get::<&Vertices>(body.entity()).unwrap();
    let mean = |of: &[DVec3]| of.iter().sum::<DVec3>() / of.len() as f64;
    let (from, to) = (mean(&vertices.rest_position), mean(&vertices.position));
    let pairs = || vertices.rest_position.iter().zip(&vertices.position).map(|(a, b)| (*a - from, *b - to));
    // The best turn in the plane (Kabsch 1976, in two dimensions).
    let (cos, sin) = pairs().fold((0.0, 0.0), |(c, s), (a, b)| (c + a.dot(b), s + a.cross(b).z));
    let turn = DMat3::from_rotation_z(sin.atan2(cos));
    pairs().map(|(a, b)| (turn * a).distance(b)).fold(0.0, f64::max)
}

/// Lets a body go from a collapse, in a fluid that takes its motion away, and steps until it is free of stress.
fn release(collapse: Collapse, is_planar: bool, settings: Settings, dt: f64, seed: usize) {
    let what = format!("{collapse:?}, planar {is_planar}, {dt} ms, seed {seed}");
    let cells = 5;
    let mut membrane = sheet(cells).with(Drag { coefficient: 1e-3 }).with(Damping { time: 0.05 });
    if is_planar {
        membrane = membrane.planar();
    }
    let (mut simulation, body) = spawn(settings, membrane);
    let in_plane = |x: DVec3| if is_planar { x.with_z(0.0) } else { x };
    set(&simulation, body, |v, x| (in_plane(collapse.of(v, x, SIDE / cells as f64, seed)), DVec3::ZERO));
    // Strains of 1e-6 over 14 mm. A mirrored body has the right lengths from the first.
    let off = |s: &Simulation| if is_planar { off_rest_shape(s, body) / (10.0 * SIDE) } else { 0.0 };
    let far = |s: &Simulation| edge_strain(s, body).max(off(s));
    let steps = (1..=3000).find(|&i| {
        // In space the last strains are those of folds that open: they go with the square of what is left of a fold, its force with the
        // cube, so that they fall as 1/t only, to 1e-5 within 300 ms. The rest of the way is gone in long steps.
        let dt = if is_planar || i <= 1000 { dt } else { 100.0 };
        assert!(!simulation.step(dt).unwrap().has_failed, "{what}");
        far(&simulation) < 1e-6
    });
    println!("{what}: {steps:?} steps");
    assert!(steps.is_some(), "{what}: {:e}", far(&simulation));
}

#[test]
fn a_planar_body_comes_back_to_its_rest_shape_from_any_collapse() {
    for collapse in COLLAPSES {
        for dt in [0.1, 1.0, 10.0, 100.0] {
            (0..3).for_each(|seed| release(collapse, true, Settings::default(), dt, seed));
        }
    }
}

#[test]
fn a_body_in_space_comes_back_to_its_lengths_from_any_collapse() {
    for collapse in COLLAPSES {
        for dt in [0.1, 1.0, 10.0, 100.0] {
            // In long steps some collapses open only if their last resorts grow shorter.
            let seeds = if dt == 100.0 { 25 } else { 3 };
            (0..seeds).for_each(|seed| release(collapse, false, Settings::default(), dt, seed));
        }
    }
}

#[test]
fn fibres_however_stiff_that_are_crushed_buckle_at_any_time_step() {
    for dt in [0.1, 1.0, 10.0, 100.0] {
        // Of the stability map: in steps of 100 ms no part of the way that is worth a name was free of gain.
        let mesh = generate::jittered(SIDE, SIDE, 6, 6, 1).unwrap();
        let (young_fibre, thickness, density) = (1e4, 0.1, 1e-3);
        let material = Material { young_fibre, thickness, density, shear_modulus: None, ..Material::allard_2009() };
        let sheet = Membrane::new("sheet", mesh, material).fibres(Fibres::at_degrees(30.0));
        let shift = |x: DVec3| DVec3::X * (0.5 * (CENTRE.x - x.x));
        let rest = sheet.mesh().positions.clone();
        let ends = sheet.select(|p| p.x == 0.0 || p.x == SIDE).into_iter().map(|v| (v, shift(rest[v as usize])));
        let (name, members) = ("ends".into(), Attached::new(ends));
        let hold = Hold { name, members, axes: [true, false, false], curve: Curve::constant(1.0) };
        let (mut simulation, body) = spawn(Settings::default(), sheet.hold(hold));
        let noise = |v: f64| DVec3::new(0.0, (78.233 * v).sin(), (37.719 * v).sin()) * 1e-3;
        set(&simulation, body, |v, x| (x + shift(x) + noise(v as f64), DVec3::ZERO));
        let back = (0..1000).find(|_| {
            assert!(!simulation.step(dt).unwrap().has_failed, "{dt} ms");
            edge_strain(&simulation, body) < 1e-5
        });
        println!("{dt} ms: its lengths are back after {back:?} steps");
        assert!(back.is_some(), "{dt} ms: {:e}", edge_strain(&simulation, body));
    }
}
