//! Every system of the step by itself, on one thread: the notched fibrous square under load, with everything on it that a
//! body can carry.
//!
//! `cargo bench --bench systems`, one of them with `cargo bench --bench systems -- solve`. Compare medians of one run. Each
//! sample starts from the same state, the one in which the systems before it leave the body; `split` makes one advance
//! of a tip, with the edits of the mesh and everything that follows them.

mod fig2;

use divan::{Bencher, counter::ItemsCount};
use fig2::{LARGE, SMALL, hand, square};
use glam::DVec3;
use hecs::World;
use rhexis::components::{
    Anchor, Contact, Curve, Drag, EdgeLoad, EdgeLoads, Gravity, Grip, Grips, Holds, Increment, Jaws, Obstacle, Path,
    PointLoad, PointLoads, Pressure, Shape, Springs, TearLog, TearMode, Tearing,
};
use rhexis::schedule::{STEP, Stage, System};
use rhexis::settings::Settings;
use rhexis::simulation::Simulation;
use rhexis::storage::{Attached, BodyId, Tips, Topology, Triangles, Vertices};
use rhexis::systems::StepContext;

const SYSTEMS: [&str; 15] = [
    "hold",
    "corotation",
    "assembly",
    "gravity",
    "pressure",
    "point loads",
    "edge loads",
    "springs",
    "grip",
    "contact",
    "drag",
    "solve",
    "integrate",
    "criterion",
    "split",
];

fn main() {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().expect("no pool before this one");
    let names: Vec<&str> = fresh_step().iter().map(|system| system.name).collect();
    assert!(SYSTEMS.iter().all(|name| names.contains(name)), "the systems are those of the step: {names:?}");
    divan::main();
}

/// The systems of a step of one stage and one solve that tears, of a body that neither sleeps nor refines nor audits its energy.
fn fresh_step() -> Vec<System> {
    let runs = |system: &&System| {
        let is_of_all = !["refine", "sleep", "energy audit"].iter().any(|name| system.name.starts_with(name));
        let stages = [Stage::Begin, Stage::Evaluate, Stage::Solve, Stage::Solved, Stage::Decide, Stage::Tear];
        stages.contains(&system.stage) && is_of_all
    };
    STEP.iter().filter(runs).copied().collect()
}

/// The square with every component, at 1 % stretch; its tip wants to advance.
fn laden(cells: [usize; 2]) -> (Simulation, BodyId) {
    let mut simulation = Simulation::new(Settings { threads: 1, ..Settings::default() }).expect("threads");
    let body = square(cells, hand());
    let along_top = body.select(|p| p.y == 30.0 && p.x < 14.0);
    let everywhere = body.select(|_| true);
    let anchor = |&v: &u32| (v, Anchor::new(body.mesh().positions[v as usize], 1e-6));
    let anchors = Attached::new(everywhere.iter().map(anchor));
    let grip = Grip {
        name: "forceps".into(),
        near_tip: None,
        from: 0.0,
        until: f64::INFINITY,
        material_point: DVec3::new(7.0, 7.0, 0.0),
        jaws: Jaws { radius: 1.0, stiffness: Some(1e-4), ..Jaws::default() },
        path: Path { points: vec![(0.0, DVec3::ZERO)] },
        turns: Path::default(),
    };
    let factor = Curve::constant(1.0);
    let point_load = PointLoad { rows: along_top.clone(), force: DVec3::Y * 1e-6, curve: factor.clone() };
    let edges = along_top.windows(2).map(|pair| [pair[0], pair[1]]).collect();
    let edge_load = EdgeLoad { edges, traction: DVec3::Y * 1e-6, curve: factor };
    let body = body
        .with(Gravity { acceleration: DVec3::Y * -9.81e-3 })
        .with(Pressure { curve: Curve::constant(1e-6) })
        .with(PointLoads { groups: vec![point_load] })
        .with(EdgeLoads { groups: vec![edge_load] })
        .with(Springs { anchors })
        .with(Grips::new(vec![grip]))
        .with(Drag { coefficient: 1e-6 })
        .with(Contact { stiffness: Some(1.0), friction: 0.0, ..Contact::default() })
        // Weak enough that every sample's tip advances; no step before does, as the blade falls after them.
        .with(Tearing {
            strength_along_fibres: 1e-4,
            strength_across_fibres: 1e-3,
            mode: TearMode::Free,
            ..Tearing::default()
        });
    let body = simulation.spawn(body).expect("an admissible body");
    let centre = DVec3::new(15.0, 15.0, -1e4);
    simulation
        .spawn_obstacle(Obstacle { shape: Shape::Sphere { centre, radius: 1e4 - 1.0 } })
        .expect("an admissible obstacle");
    for _ in 0..20 {
        simulation.step(1.0).expect("a time step");
    }
    let notch = [DVec3::new(15.0, 30.0, 0.0), DVec3::new(15.0, 27.0, 0.0)];
    simulation.cut(body, &notch).expect("a notch");
    (simulation, body)
}

/// The columns that a split changes.
struct Saved {
    tables: (Vertices, Triangles, Topology, Increment),
    tears: (Tips, TearLog),
    followers: (Holds, Springs, Grips, EdgeLoads),
}

impl Saved {
    fn of(world: &World, body: BodyId) -> Self {
        fn one<T: hecs::Component + Clone>(world: &World, body: BodyId) -> T {
            T::clone(&*world.get::<&T>(body.entity()).expect("the body carries it"))
        }
        Self {
            tables: (one(world, body), one(world, body), one(world, body), one(world, body)),
            tears: (one(world, body), one(world, body)),
            followers: (one(world, body), one(world, body), one(world, body), one(world, body)),
        }
    }

    fn restore(&self, world: &mut World, body: BodyId) {
        // A clone has no reserve: without one the first edit would be timed copying whole columns.
        const RESERVE: usize = 64;
        let (mut vertices, mut triangles, mut topology, mut increment) = self.tables.clone();
        vertices.reserve(RESERVE);
        triangles.reserve(RESERVE);
        topology.reserve(RESERVE, RESERVE);
        let Increment { start, start_velocity, displacement, delta, .. } = &mut increment;
        [start, start_velocity, displacement, delta].into_iter().for_each(|column| column.reserve(RESERVE));
        let (mut holds, mut springs, grips, edge_loads) = self.followers.clone();
        holds.groups.iter_mut().for_each(|hold| hold.members.reserve(RESERVE));
        springs.anchors.reserve(RESERVE);
        world.insert(body.entity(), (vertices, triangles, topology, increment)).expect("the body lives");
        world.insert(body.entity(), self.tears.clone()).expect("the body lives");
        world.insert(body.entity(), (holds, springs, grips, edge_loads)).expect("the body lives");
    }
}

fn bench(bencher: Bencher, name: &str, cells: [usize; 2]) {
    let (mut simulation, body) = laden(cells);
    let step = StepContext::of_step(simulation.settings(), 1.0, simulation.time() + 1.0);
    let saved = Saved::of(simulation.world(), body);
    let systems = fresh_step();
    let (before, rest) = systems.split_at(systems.iter().position(|system| system.name == name).expect("a system"));
    let world = std::cell::RefCell::new(simulation.world_mut());
    // What stands before the solve is cheap and runs anew; from `integrate` on the state after the solve is kept.
    let is_after_solve = before.iter().any(|system| system.name == "solve");
    let prepare = || {
        let world = &mut **world.borrow_mut();
        saved.restore(world, body);
        before.iter().for_each(|system| {
            (system.run)(world, &step);
        });
    };
    prepare();
    let solved = Saved::of(&world.borrow(), body);
    bencher
        .counter(ItemsCount::new(2 * cells[0] * cells[1]))
        .with_inputs(|| if is_after_solve { solved.restore(&mut world.borrow_mut(), body) } else { prepare() })
        .bench_local_values(|()| {
            let count = (rest[0].run)(&mut world.borrow_mut(), &step);
            assert_eq!(count, 1, "the system has found its body");
        });
}

#[divan::bench(args = SYSTEMS, sample_count = 30, sample_size = 1)]
fn triangles_1500(bencher: Bencher, system: &str) {
    bench(bencher, system, SMALL);
}

#[divan::bench(args = SYSTEMS, sample_count = 15, sample_size = 1)]
fn triangles_15010(bencher: Bencher, system: &str) {
    bench(bencher, system, LARGE);
}
