//! Bending: the elastica on meshes of every kind, rest angles, derivatives, rigid motions, edits, threads.

use crate::meshes::Random;
use glam::{DQuat, DVec2, DVec3};
use rhexis::components::{Bending, Curve, Damping, EnergyAudit, Gravity, Hold, Material, Tearing};
use rhexis::membrane::{BodyError, Membrane};
use rhexis::settings::Settings;
use rhexis::simulation::Simulation;
use rhexis::storage::{Attached, BodyId, Topology, TriangleMesh, Triangles, Vertices};
use rhexis::systems::bending::{BendingPasses, DihedralAngles};
use rhexis_scene::generate;

const LENGTH: f64 = 10.0;
const WIDTH: f64 = 2.0;

/// 0.05 mm of E = 3 MPa: hardly stretched by what bends it.
fn material() -> Material {
    Material::isotropic(3.0, 0.0, 0.05)
}

/// A strip and its mirror image, joined at x = 0: where its middle is held, either half is clamped there.
fn mirrored(mesh: &TriangleMesh) -> TriangleMesh {
    let mut both = mesh.clone();
    let mut image = Vec::new();
    for &p in &mesh.positions {
        if p.x.abs() < 1e-9 {
            image.push(image.len() as u32);
        } else {
            image.push(both.positions.len() as u32);
            both.positions.push(DVec3::new(-p.x, p.y, p.z));
        }
    }
    // Rows of the vertices in the middle are their own.
    for (row, p) in mesh.positions.iter().enumerate() {
        if p.x.abs() < 1e-9 {
            image[row] = row as u32;
        }
    }
    both.triangles.extend(mesh.triangles.iter().map(|&[a, b, c]| [a, c, b].map(|v| image[v as usize])));
    both
}

fn held_in_the_middle(mesh: &TriangleMesh, bending: Bending) -> Membrane {
    let mut strip = Membrane::new("strip", mirrored(mesh), material()).with(bending);
    let members = Attached::new(strip.select(|p| p.x.abs() < 1e-9).into_iter().map(|v| (v, DVec3::ZERO)));
    strip = strip.hold(Hold { name: "clamp".into(), members, axes: [true; 3], curve: Curve::constant(0.0) });
    strip
}

/// Where the end of a clamped elastica under its own weight `q` per length is: shooting for the curvature at the clamp, by
/// bisection, with Runge and Kutta's rule in 2,000 steps. D·θ'' = −q·(L − s)·cos θ, θ(0) = 0, θ'(L) = 0; θ downwards.
fn elastica(q_over_d: f64) -> DVec2 {
    const STEPS: usize = 2000;
    let h = LENGTH / STEPS as f64;
    let rate = |s: f64, y: [f64; 4]| [y[1], -q_over_d * (LENGTH - s) * y[0].cos(), y[0].cos(), -y[0].sin()];
    let shoot = |curvature: f64| {
        let mut y = [0.0, curvature, 0.0, 0.0];
        for i in 0..STEPS {
            let s = i as f64 * h;
            let step = |k: [f64; 4], by: f64| std::array::from_fn(|j| y[j] + k[j] * by);
            let k1 = rate(s, y);
            let k2 = rate(s + 0.5 * h, step(k1, 0.5 * h));
            let k3 = rate(s + 0.5 * h, step(k2, 0.5 * h));
            let k4 = rate(s + h, step(k3, h));
            y = std::array::from_fn(|j| y[j] + h / 6.0 * (k1[j] + 2.0 * (k2[j] + k3[j]) + k4[j]));
        }
        y
    };
    let (mut low, mut high) = (0.0, 0.5 * q_over_d * LENGTH * LENGTH);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if shoot(middle)[1] < 0.0 { low = middle } else { high = middle }
    }
    let end = shoot(low);
    DVec2::new(end[2], end[3])
}

#[test]
fn a_clamped_strip_bends_by_its_weight_to_the_elastica() {
    let corners = [(0.0, 0.0), (LENGTH, 0.0), (LENGTH, WIDTH), (0.0, WIDTH)].map(|(x, y)| DVec2::new(x, y));
    let meshes = [
        ("grid", generate::grid(LENGTH, WIDTH, 40, 8).unwrap()),
        ("coarse grid", generate::grid(LENGTH, WIDTH, 20, 4).unwrap()),
        ("jittered", generate::jittered(LENGTH, WIDTH, 40, 8, 3).unwrap()),
        ("lattice", generate::lattice(&corners, 0.25, 17.0).unwrap()),
        ("unstructured", generate::unstructured(&corners, 0.25, 5).unwrap()),
        ("coarse unstructured", generate::unstructured(&corners, 0.5, 7).unwrap()),
    ];
    let stiffness = 1e-3;
    for (name, mesh) in &meshes {
        for q_over_d in [1e-4, 5e-3] {
            let weight = q_over_d * stiffness / (1e-3 * 0.05);
            let strip = held_in_the_middle(mesh, Bending { stiffness: Some(stiffness) });
            let mut simulation = Simulation::new(Settings::default()).unwrap();
            let body = simulation.spawn(strip.with(Gravity { acceleration: DVec3::NEG_Z * weight })).unwrap();
            let newton_iterations = simulation.settle(1.0, 1e-9).unwrap().bodies[0].newton_iterations;
            // The tangent leaves out how the angles' derivatives change: linear convergence, 4 to 11 iterations.
            assert!(newton_iterations <= 15, "{name}: {newton_iterations} iterations");
            let vertices = simulation.world().get::<&Vertices>(body.entity()).unwrap();
            let at_end = |v: &usize| vertices.rest_position[*v].x > LENGTH - 1e-9;
            let ends: Vec<DVec3> = (0..vertices.len()).filter(at_end).map(|v| vertices.position[v]).collect();
            let end = ends.iter().sum::<DVec3>() / ends.len() as f64;
            let exact = elastica(q_over_d);
            let off = DVec2::new(end.x, end.z).distance(exact) / exact.y.abs();
            // 0.1 % on the fine grid, 0.3 to 0.5 % on fine meshes of other kinds, 0.8 % on the coarse unstructured one.
            assert!(off < 0.01, "{name}: the end is {off:.4} of the deflection off {exact}");
        }
    }
}

/// A cap with its rest angles and a turned, noisy copy of its positions.
struct Cap {
    vertices: Vertices,
    triangles: Triangles,
    topology: Topology,
    folds: DihedralAngles,
    passes: BendingPasses,
}

const OWN: Bending = Bending { stiffness: None };

impl Cap {
    fn new() -> Self {
        let cap = generate::cap(10.0, 9.0, 300).unwrap();
        let mut simulation = Simulation::new(Settings::default()).unwrap();
        let material = Material { young_fibre: 3.0, ..Material::allard_2009() };
        let body = simulation.spawn(Membrane::new("cap", cap, material).with(OWN)).unwrap();
        let world = simulation.world();
        let vertices = (*world.get::<&Vertices>(body.entity()).unwrap()).clone();
        let triangles = (*world.get::<&Triangles>(body.entity()).unwrap()).clone();
        let topology = (*world.get::<&Topology>(body.entity()).unwrap()).clone();
        let (mut folds, mut passes) = (DihedralAngles::default(), BendingPasses::default());
        folds.refresh((&vertices, &triangles, &topology), &OWN, &mut passes);
        Self { vertices, triangles, topology, folds, passes }
    }

    /// Finds the angles at these positions.
    fn evaluate(&mut self, x: &[DVec3], factor: f64) {
        self.folds.evaluate(&self.triangles.corners, x, factor, &mut self.passes);
    }

    fn energy(&mut self, x: &[DVec3]) -> f64 {
        self.evaluate(x, 1.0);
        self.folds.energy()
    }

    fn forces(&mut self, x: &[DVec3]) -> Vec<DVec3> {
        self.evaluate(x, 1.0);
        let mut forces = vec![DVec3::ZERO; x.len()];
        let Self { triangles, topology, folds, passes, .. } = self;
        folds.add_forces(&triangles.corners, topology, |_| DVec3::ZERO, &mut forces, passes);
        forces
    }

    fn noisy(&self, size: f64) -> Vec<DVec3> {
        let mut random = Random::new(3);
        self.vertices.position.iter().map(|x| *x + random.vector(size)).collect()
    }
}

fn dot(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum()
}

fn largest(forces: &[DVec3]) -> f64 {
    forces.iter().map(|f| f.length()).fold(0.0, f64::max)
}

#[test]
fn the_force_is_the_gradient_of_the_energy() {
    let mut cap = Cap::new();
    // Angles up to a radian.
    let x = cap.noisy(0.15);
    let mut random = Random::new(7);
    let u: Vec<DVec3> = x.iter().map(|_| random.vector(1.0)).collect();
    let step = 1e-5;
    let moved = |by: f64| -> Vec<DVec3> { x.iter().zip(&u).map(|(x, u)| *x + *u * by).collect() };
    let slope = (cap.energy(&moved(step)) - cap.energy(&moved(-step))) / (2.0 * step);
    let force = dot(&cap.forces(&x), &u);
    // Differences over 1e-5 of angles that change by 10 rad per mm are right to 1e-8, and rounding adds as much.
    assert!((slope + force).abs() < 1e-6 * slope.abs(), "{slope} against {force}");
}

#[test]
fn the_tangents_are_symmetric_semidefinite_and_one_majorises_the_other() {
    let mut cap = Cap::new();
    let x = cap.noisy(0.15);
    cap.evaluate(&x, 1.0);
    let mut random = Random::new(11);
    let mut vector = || -> Vec<DVec3> { x.iter().map(|_| random.vector(1.0)).collect() };
    let mut passes = BendingPasses::default();
    let mut product = |u: &[DVec3], is_exact: bool| {
        let mut product = vec![DVec3::ZERO; u.len()];
        cap.folds.add_product(&cap.triangles.corners, &cap.topology, u, is_exact, &mut product, &mut passes);
        product
    };
    for _ in 0..5 {
        let (u, w) = (vector(), vector());
        for is_exact in [false, true] {
            let (uw, wu) = (dot(&product(&u, is_exact), &w), dot(&product(&w, is_exact), &u));
            let scale = dot(&product(&u, is_exact), &u);
            assert!(scale > 0.0 && (uw - wu).abs() < 1e-12 * scale, "{uw} against {wu}");
        }
        // Hundreds of entries of size one: rounding.
        let all = product(&u, true);
        let at = |v: usize| cap.folds.product_at(v, &cap.triangles.corners, &cap.topology, &u, true);
        let off = (0..u.len()).map(|v| at(v).distance(all[v])).fold(0.0, f64::max);
        assert!(off < 1e-12 * largest(&all), "{off}");
    }
    // Along smooth shapes the turn of the mid-edge normals takes some of the stiffness away, never adds any.
    let smooth: Vec<DVec3> = x.iter().map(|x| DVec3::Z * (0.3 * x.x).sin() * (0.2 * x.y).cos()).collect();
    let [majorant, exact] = [false, true].map(|is_exact| dot(&product(&smooth, is_exact), &smooth));
    assert!(exact < majorant && exact > 0.5 * majorant, "{exact} of {majorant}");
}

#[test]
fn a_motion_leaves_over_what_energy_forces_and_tangent_say() {
    let mut cap = Cap::new();
    let x = cap.noisy(0.15);
    let mut random = Random::new(13);
    let u: Vec<DVec3> = x.iter().map(|_| random.vector(0.05)).collect();
    let end: Vec<DVec3> = x.iter().zip(&u).map(|(x, u)| *x + *u).collect();
    let change = cap.energy(&end) - cap.energy(&x);
    let forces = dot(&cap.forces(&x), &u);
    // With damping that holds a third as much as bending.
    cap.evaluate(&x, 1.3);
    for is_exact in [false, true] {
        let mut product = vec![DVec3::ZERO; u.len()];
        cap.folds.add_product(&cap.triangles.corners, &cap.topology, &u, is_exact, &mut product, &mut cap.passes);
        let pull = dot(&product, &u);
        let found = cap.folds.spurious_energy(
            &cap.triangles.corners,
            (u.len(), |v| [u[v], end[v]]),
            None,
            is_exact,
            (&mut Vec::new(), &mut cap.passes),
        );
        // Hundreds of terms of the size of the largest: rounding.
        let expected = change + forces - pull;
        assert!((found - expected).abs() < 1e-12 * pull, "exact {is_exact}: {found} for {expected}");
    }
}

#[test]
fn angles_at_the_end_of_a_motion_serve_only_there() {
    let mut cap = Cap::new();
    let x = cap.noisy(0.15);
    let mut random = Random::new(17);
    let end: Vec<DVec3> = x.iter().map(|x| *x + random.vector(0.05)).collect();
    let mut elsewhere = end.clone();
    elsewhere[40].x += 1e-9;
    for at in [&end, &elsewhere] {
        cap.evaluate(&x, 1.0);
        let motion = |v: usize| [end[v] - x[v], end[v]];
        let memory = (&mut Vec::new(), &mut cap.passes);
        cap.folds.spurious_energy(&cap.triangles.corners, (x.len(), motion), None, false, memory);
        // As found by one that knows of no motion, to the last bit.
        assert!(cap.forces(at) == Cap::new().forces(at));
    }
    // New rest angles, or another mesh: as if there had been none.
    cap.vertices.rest_position[40].z += 0.1;
    let stiffer = Bending { stiffness: Some(0.1) };
    let tables = (&cap.vertices, &cap.triangles, &cap.topology);
    cap.folds.refresh(tables, &stiffer, &mut cap.passes);
    let (mut anew, mut fresh) = (DihedralAngles::default(), BendingPasses::default());
    anew.refresh(tables, &stiffer, &mut fresh);
    let mut forces = [vec![DVec3::ZERO; end.len()], vec![DVec3::ZERO; end.len()]];
    let both = [(&mut cap.folds, &mut cap.passes), (&mut anew, &mut fresh)];
    for ((folds, passes), forces) in both.into_iter().zip(&mut forces) {
        folds.evaluate(&cap.triangles.corners, &end, 1.0, passes);
        folds.add_forces(&cap.triangles.corners, &cap.topology, |_| DVec3::ZERO, forces, passes);
    }
    assert!(largest(&forces[0]) > 0.0 && forces[0] == forces[1]);
}

#[test]
fn rest_and_rigid_motions_exert_no_force_and_no_motion_a_torque() {
    let mut cap = Cap::new();
    let scale = {
        let x = cap.noisy(0.15);
        largest(&cap.forces(&x))
    };
    let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 2.0);
    let rigid: Vec<DVec3> = cap.vertices.position.iter().map(|x| turn * *x + DVec3::new(3.0, -2.0, 5.0)).collect();
    // Angles are known to rounding, and stiffnesses over heights are the scale.
    assert!(largest(&cap.forces(&rigid)) < 1e-12 * scale);
    let x = cap.noisy(0.15);
    let turned: Vec<DVec3> = x.iter().map(|x| turn * *x).collect();
    let (forces, of_turned) = (cap.forces(&x), cap.forces(&turned));
    let off = forces.iter().zip(&of_turned).map(|(a, b)| (turn * *a).distance(*b)).fold(0.0, f64::max);
    assert!(off < 1e-11 * scale, "{off}");
    assert!(forces.iter().sum::<DVec3>().length() < 1e-11 * scale);
    assert!(forces.iter().zip(&x).map(|(f, x)| x.cross(*f)).sum::<DVec3>().length() < 1e-10 * scale);
}

#[test]
fn a_folded_sheet_rests_at_its_rest_angle() {
    // Folded by 100° along x = 5.
    let direction = DVec3::new((100_f64).to_radians().cos(), 0.0, (100_f64).to_radians().sin());
    let fold = |x: f64, y: f64| {
        let along = 10.0 * x;
        let crease = DVec3::new(along.min(5.0), 4.0 * y, 0.0);
        crease + direction * (along - 5.0).max(0.0)
    };
    let mesh = generate::mapped_grid(20, 8, fold).unwrap();
    let mut simulation = Simulation::new(Settings::default()).unwrap();
    let body = simulation.spawn(Membrane::new("sheet", mesh, material()).with(OWN)).unwrap();
    for _ in 0..20 {
        simulation.step(1.0).unwrap();
    }
    let vertices = simulation.world().get::<&Vertices>(body.entity()).unwrap();
    let moved = vertices.position.iter().zip(&vertices.rest_position).map(|(x, rest)| x.distance(*rest));
    // Forces of rounding on a sheet that nothing holds.
    assert!(moved.fold(0.0, f64::max) < 1e-9);
}

#[test]
fn rest_angles_follow_tears_and_refinement_as_if_made_anew() {
    let cap = generate::cap(10.0, 9.0, 400).unwrap();
    let tearing = Tearing { radius: 0.5, ..Tearing::default() };
    let refinement = rhexis::components::Refinement { edges_per_radius: 2.0, ..Default::default() };
    let body = Membrane::new("cap", cap, Material::allard_2009()).with(OWN).with(tearing).with(refinement);
    let mut simulation = Simulation::new(Settings::default()).unwrap();
    let body = simulation.spawn(body).unwrap();
    for cut in 0..4 {
        let at = |radius: f64, degrees: f64| {
            let (s, c) = degrees.to_radians().sin_cos();
            DVec3::new(radius * c, radius * s, -radius * radius / 20.0)
        };
        let turn = 80.0 * f64::from(cut);
        simulation.cut(body, &[at(1.5, turn), at(2.5, turn + 15.0), at(3.2, turn + 30.0)]).unwrap();
        simulation.step(1.0).unwrap();
        simulation.step(1.0).unwrap();
        let count = simulation.world().get::<&Triangles>(body.entity()).unwrap().len();
        assert!(count > 400, "{count}");
        let world = simulation.world_mut();
        type Query<'a> = (&'a Vertices, &'a Triangles, &'a Topology, &'a mut DihedralAngles, &'a mut BendingPasses);
        let (vertices, triangles, topology, folds, passes) = world.query_one_mut::<Query>(body.entity()).unwrap();
        let tables = (vertices, triangles, topology);
        folds.refresh(tables, &OWN, passes);
        let mut anew = DihedralAngles::default();
        anew.refresh(tables, &OWN, passes);
        assert!(folds.has_rest_of(&anew), "after cut {cut}");
    }
}

/// A strip that swings down, with a balance of energy.
fn swung(threads: usize, mesh: &TriangleMesh) -> (Simulation, BodyId) {
    let strip = held_in_the_middle(mesh, Bending { stiffness: Some(1e-3) });
    let strip = strip.with(Gravity { acceleration: DVec3::NEG_Z * 0.02 });
    let strip = strip.with(EnergyAudit::default()).with(Damping { time: 2.0 });
    let mut simulation = Simulation::new(Settings { threads, ..Settings::default() }).unwrap();
    let body = simulation.spawn(strip).unwrap();
    for _ in 0..40 {
        simulation.step(2.0).unwrap();
    }
    (simulation, body)
}

#[test]
fn a_balance_of_energy_counts_bending_and_threads_change_no_bit() {
    let mesh = generate::jittered(LENGTH, WIDTH, 40, 16, 3).unwrap();
    let (simulation, body) = swung(1, &mesh);
    let (other, other_body) = swung(2, &mesh);
    let same = |a: &Vertices, b: &Vertices| a.position == b.position && a.velocity == b.velocity;
    let positions = (*simulation.world().get::<&Vertices>(body.entity()).unwrap()).clone();
    assert!(same(&positions, &other.world().get::<&Vertices>(other_body.entity()).unwrap()));
    let end = positions.position.iter().map(|x| x.z).fold(0.0, f64::min);
    assert!(end < -1.0, "it has swung by {end} mm");
    let balance = simulation.energy_balance(body).unwrap().unwrap();
    let scale = balance.work_of_loads.abs();
    // Every term comes from a formula of its own; the sum is off by rounding of thousands of terms in 40 steps.
    assert!(balance.imbalance().abs() < 1e-9 * scale, "{balance:?}");
    assert!(balance.damping > 0.0);
}

#[test]
fn what_cannot_bend_is_refused() {
    let mesh = || generate::grid(4.0, 4.0, 4, 4).unwrap();
    let mut simulation = Simulation::new(Settings::default()).unwrap();
    let planar = Membrane::new("sheet", mesh(), material()).planar().with(OWN);
    assert_eq!(simulation.spawn(planar).unwrap_err().source, BodyError::BendingInPlane);
    let negative = Membrane::new("sheet", mesh(), material()).with(Bending { stiffness: Some(-1.0) });
    assert!(matches!(
        simulation.spawn(negative).unwrap_err().source,
        BodyError::OutOfRange { component: "Bending", .. }
    ));
}
