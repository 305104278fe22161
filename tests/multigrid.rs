//! Multigrid: iterations that do not grow with the mesh.

mod common;

use glam::DVec3;
use rhexis::components::{ExternalStiffness, Fibres, Frames, Material, PreStretch, SolverScratch};
use rhexis::math::Sym2;
use rhexis::membrane::Membrane;
use rhexis::scene::{Document, generate};
use rhexis::settings::{LinearParams, Settings};
use rhexis::simulation::Simulation;
use rhexis::storage::{Topology, Triangles, TriangleMesh, Vertices};
use rhexis::systems::kernels::membrane;
use rhexis::systems::linear::{self, CgInfo, Inner, InnerSolver, Means, Operator};
use rhexis::systems::{corotation, linear::Factor};
use std::time::Instant;

/// One linear system.
struct System {
    vertices: Vertices,
    triangles: Triangles,
    topology: Topology,
    frames: Frames,
    external: Option<ExternalStiffness>,
    free: Vec<DVec3>,
    load: Vec<DVec3>,
    guess: Vec<DVec3>,
    inertia: f64,
    viscosity: f64,
}

/// A sheet of the figure's material, cut along `cuts` and brought to where `place` puts it.
fn sheet(mesh: TriangleMesh, is_planar: bool, cuts: &[Vec<DVec3>], place: impl Fn(DVec3) -> DVec3) -> System {
    let mut body = Membrane::new("sheet", mesh, Material::figure_2()).fibres(Fibres::at_degrees(45.0));
    if is_planar {
        body = body.planar();
    }
    let mut simulation = Simulation::new(Settings { threads: 1, ..Settings::default() }).unwrap();
    let body = simulation.spawn(body).unwrap();
    for cut in cuts {
        simulation.cut(body, cut).unwrap();
    }
    let world = simulation.world();
    let mut vertices = (*world.get::<&Vertices>(body).unwrap()).clone();
    let triangles = (*world.get::<&Triangles>(body).unwrap()).clone();
    let topology = (*world.get::<&Topology>(body).unwrap()).clone();
    for v in 0..vertices.len() {
        vertices.position[v] = place(vertices.rest_position[v]);
    }
    let frames = frames(&vertices, &triangles, is_planar, None);
    let n = vertices.len();
    let plane = if is_planar { DVec3::new(1.0, 1.0, 0.0) } else { DVec3::ONE };
    System {
        vertices,
        triangles,
        topology,
        frames,
        external: None,
        free: vec![plane; n],
        load: vec![DVec3::ZERO; n],
        guess: vec![DVec3::ZERO; n],
        inertia: 0.0,
        viscosity: 0.0,
    }
}

fn frames(vertices: &Vertices, triangles: &Triangles, is_planar: bool, pre_stretch: Option<&PreStretch>) -> Frames {
    let mut frames = Frames::default();
    corotation::evaluate(vertices, triangles, &mut frames, is_planar, pre_stretch);
    for (t, state) in frames.state.iter().enumerate() {
        let stretch = state.polar.stretch;
        frames.shear.push(membrane::shear_majorant(state.stress, stretch, &triangles.stiffness[t]));
        let s = membrane::second_piola(state.stress, stretch).positive_part();
        frames.normal.push(if is_planar { Sym2::ZERO } else { s });
    }
    frames
}

impl System {
    /// The figure's square with so many cells, stretched by a tenth, whose right edge moves by 0.01 mm.
    fn flat(cells: [usize; 2], is_planar: bool, cuts: &[Vec<DVec3>]) -> Self {
        Self::pulled(generate::grid(30.0, 30.0, cells[0], cells[1]).unwrap(), is_planar, cuts)
    }

    fn pulled(mesh: TriangleMesh, is_planar: bool, cuts: &[Vec<DVec3>]) -> Self {
        let mut system = sheet(mesh, is_planar, cuts, |p| DVec3::new(1.1 * p.x, p.y, p.z));
        for v in 0..system.free.len() {
            let x = system.vertices.rest_position[v].x;
            if x < 1e-9 || x > 30.0 - 1e-9 {
                system.free[v] = DVec3::ZERO;
                system.guess[v] = DVec3::new(if x > 1.0 { 0.01 } else { 0.0 }, 0.0, 0.0);
            }
        }
        system
    }

    /// A tear along an arc through most of the square.
    fn tear() -> Vec<Vec<DVec3>> {
        let at = |i: u32| {
            let s = f64::from(i) / 9.0;
            DVec3::new(15.0 + 5.0 * (3.0 * s).sin(), 30.0 - 27.0 * s, 0.0) /* nodes far apart */
        };
        vec![(0..=9).map(at).collect()]
    }

    /// The capsule of the lead scene, as it is at the start, under a load across.
    fn capsule(triangles: usize, steps: usize) -> Self {
        let mut document = Document::named("capsulorhexis").unwrap();
        document.set(&format!("bodies.0.mesh.cap.triangles={triangles}")).unwrap();
        document.set("run.dt=5").unwrap();
        let mut instance = document.scene().unwrap().instantiate().unwrap();
        for _ in 0..steps.max(1) {
            instance.advance().unwrap();
        }
        let world = instance.simulation.world();
        let body = instance.bodies[0];
        let vertices = (*world.get::<&Vertices>(body).unwrap()).clone();
        let triangles = (*world.get::<&Triangles>(body).unwrap()).clone();
        let frames = frames(&vertices, &triangles, false, world.get::<&PreStretch>(body).ok().as_deref());
        let n = vertices.len();
        let mut load = vec![DVec3::ZERO; n];
        let mut seed = 1_u64;
        let mut next = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        for v in 0..n {
            load[v] = DVec3::new(next(), next(), next()) * 1e-5;
            if vertices.rest_position[v].distance(DVec3::new(2.3, 0.5, -0.28)) < 0.2 {
                load[v] += DVec3::new(0.0, -1e-3, 1e-3);
            }
        }
        Self {
            topology: (*world.get::<&Topology>(body).unwrap()).clone(),
            external: world.get::<&ExternalStiffness>(body).ok().map(|e| (*e).clone()),
            free: vec![DVec3::ONE; n],
            guess: vec![DVec3::ZERO; n],
            inertia: 1.0 / 25.0,
            viscosity: 0.2,
            frames,
            vertices,
            triangles,
            load,
        }
    }

    fn operator(&self) -> Operator<'_> {
        Operator {
            vertices: &self.vertices,
            triangles: &self.triangles,
            topology: &self.topology,
            frames: &self.frames,
            external: self.external.as_ref(),
            inertia: self.inertia,
            viscosity: self.viscosity,
            is_exact: false,
        }
    }

    fn solve(&self, inner: &mut InnerSolver, tolerance: f64, kind: Inner) -> CgInfo {
        let mut scratch =
            SolverScratch { free: self.free.clone(), residual: self.load.clone(), ..SolverScratch::default() };
        let mut corner = vec![[DVec3::ZERO; 3]; self.triangles.len()];
        let mut x = self.guess.clone();
        let mut means = Means { factor: None, inner: Some((inner, kind)) };
        let params = LinearParams { tolerance, iterations: 20_000 };
        linear::solve(&self.operator(), &params, &mut means, &mut corner, &mut x, &mut scratch).unwrap()
    }
}

fn show(name: &str, system: &System) {
    let kinds = match std::env::var("KINDS").as_deref() {
        Ok("all") => vec![Inner::BlockJacobi, Inner::IncompleteCholesky, Inner::Multigrid],
        Ok("ic") => vec![Inner::IncompleteCholesky, Inner::Multigrid],
        _ => vec![Inner::Multigrid],
    };
    for kind in kinds {
        let mut inner = InnerSolver::default();
        let mut line = format!("{name} {} {kind:?}:", system.triangles.len());
        for tolerance in [1e-3, 1e-5, 1e-6] {
            let start = Instant::now();
            let info = system.solve(&mut inner, tolerance, kind);
            line += &format!("  {:.0e} {} its {:.1} ms", tolerance, info.iterations, start.elapsed().as_secs_f64() * 1e3);
        }
        println!("{line}");
    }
}

#[test]
fn figures() {
    let _ = std::any::type_name::<Factor>();
    let scenes = std::env::var("SCENES").unwrap_or("flat".into());
    let sizes: &[[usize; 2]] = &[[30, 25], [50, 50], [95, 79], [300, 250], [950, 790]];
    let most: usize = std::env::var("MOST").ok().and_then(|m| m.parse().ok()).unwrap_or(2);
    let least: usize = std::env::var("LEAST").ok().and_then(|m| m.parse().ok()).unwrap_or(0);
    let steps: usize = std::env::var("STEPS").ok().and_then(|m| m.parse().ok()).unwrap_or(900);
    for scene in scenes.split(',') {
        for cells in &sizes[least..most] {
            match scene {
                "flat" => show(scene, &System::flat(*cells, true, &[])),
                "taut" => show(scene, &System::flat(*cells, false, &[])),
                "torn" => show(scene, &System::flat(*cells, true, &System::tear())),
                "torn3" => show(scene, &System::flat(*cells, false, &System::tear())),
                "lattice" => {
                    let corner = [[0.0, 0.0], [30.0, 0.0], [30.0, 30.0], [0.0, 30.0]].map(glam::DVec2::from_array);
                    let edge = 30.0 / cells[0] as f64;
                    show(scene, &System::pulled(generate::unstructured(&corner, edge, 3).unwrap(), true, &[]));
                }
                "run" => {
                    let mut document = Document::named("capsulorhexis").unwrap();
                    document.set(&format!("bodies.0.mesh.cap.triangles={}", 2 * cells[0] * cells[1])).unwrap();
                    document.set("run.dt=5").unwrap();
                    document.set(&format!("run.preconditioner=\"{}\"", std::env::var("KIND").unwrap())).unwrap();
                    let mut instance = document.scene().unwrap().instantiate().unwrap();
                    let mut sums = vec![0; steps / 50 + 1];
                    for i in 0..steps {
                        instance.advance().unwrap();
                        sums[i / 50] += instance.simulation.report().bodies[0].iterations;
                    }
                    println!("its {:?}", sums.iter().map(|s| s / 50).collect::<Vec<_>>());
                }
                "cap" => show(scene, &System::capsule(2 * cells[0] * cells[1], 1)),
                "slack" => show(scene, &System::capsule(2 * cells[0] * cells[1], steps)),
                _ => unreachable!(),
            }
        }
    }
}
