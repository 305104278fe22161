//! The solve in mixed precision gives what the one in double precision gives: one system of a torn capsule, whole runs, and
//! operators that are none.

use crate::common::{Square, state_bits};
use glam::DVec3;
use rhexis::components::{ExternalStiffness, Frames, FreeAxes, SolverScratch};
use rhexis::math::{ElementState, GeometricStiffness, Sym3};
use rhexis::settings::{Advanced, LinearParams, Precision, Preconditioner, Settings, Tangent};
use rhexis::simulation::Simulation;
use rhexis::storage::{BodyId, Topology, Triangles, Vertices};
use rhexis::systems::bending::BendingPasses;
use rhexis::systems::kernels::membrane;
use rhexis::systems::solver::{
    self, Available, CgError, CgInfo, MixedPreconditioner, MixedSolver, Operator, ProductMemory,
};
use rhexis_scene::Document;

/// Preconditioners of the mixed-precision solver.
const PRECONDITIONERS: [Preconditioner; 3] =
    [Preconditioner::BlockJacobi, Preconditioner::IncompleteCholesky, Preconditioner::Multigrid];

/// The capsule of the lead scene with a slack flap, and a load that bends it.
struct Torn {
    vertices: Vertices,
    triangles: Triangles,
    topology: Topology,
    frames: Frames,
    external: Option<ExternalStiffness>,
    free: FreeAxes,
    load: Vec<DVec3>,
    tangent: Tangent,
}

impl Torn {
    fn new() -> Self {
        Self::capsule(1500, 40)
    }

    fn capsule(triangles: u32, steps: u32) -> Self {
        let mut document = Document::named("capsulorhexis").unwrap();
        document.set(&format!("bodies.0.mesh.cap.triangles={triangles}")).unwrap();
        // Every seventh vertex has an axis or all of them prescribed.
        Self::after(steps, document, |v, _| match v % 21 {
            0 => DVec3::ZERO,
            7 => DVec3::new(1.0, 0.0, 1.0),
            14 => DVec3::new(1.0, 1.0, 0.0),
            _ => DVec3::ONE,
        })
    }

    /// The square of the figure in its plane instead, held at both sides.
    fn planar() -> Self {
        let is_held = |x: DVec3| x.x == 0.0 || x.x == 30.0;
        Self::after(20, Document::named("fig2-haptic").unwrap(), |_, x| {
            if is_held(x) { DVec3::ZERO } else { DVec3::new(1.0, 1.0, 0.0) }
        })
    }

    /// A scene after so many steps, with these axes free at a vertex of this number and place.
    fn after(steps: u32, document: Document, free: impl Fn(usize, DVec3) -> DVec3) -> Self {
        let mut instance = document.scene().unwrap().instantiate().unwrap();
        for _ in 0..steps {
            instance.advance().unwrap();
        }
        let world = instance.simulation.world();
        let body = instance.bodies[0];
        let vertices = (*world.get::<&Vertices>(body.entity()).unwrap()).clone();
        let load = (0..vertices.len()).map(|v| DVec3::new((v as f64).sin(), (1.7 * v as f64).cos(), 1.0) * 1e-4);
        Self {
            free: vertices.rest_position.iter().enumerate().map(|(v, x)| free(v, *x)).collect(),
            load: load.collect(),
            triangles: (*world.get::<&Triangles>(body.entity()).unwrap()).clone(),
            topology: (*world.get::<&Topology>(body.entity()).unwrap()).clone(),
            frames: (*world.get::<&Frames>(body.entity()).unwrap()).clone(),
            external: world.get::<&ExternalStiffness>(body.entity()).ok().map(|external| (*external).clone()),
            vertices,
            tangent: Tangent::Rotated,
        }
    }

    fn operator(&self) -> Operator<'_> {
        Operator {
            external: self.external.as_ref(),
            inertia: 1e-2,
            viscosity: 0.1,
            ..Operator::membrane((&self.vertices, &self.triangles, &self.topology, &self.frames), self.tangent)
        }
    }

    /// Prescribed motion of 0.01 mm, zero elsewhere.
    fn guess(&self) -> Vec<DVec3> {
        self.free.iter().map(|free| (DVec3::ONE - *free) * 0.01).collect()
    }

    fn solve(&self, tolerance: f64, kind: Option<MixedPreconditioner>) -> (Result<CgInfo, CgError>, Vec<DVec3>) {
        self.solve_from(self.guess(), tolerance, kind)
    }

    fn solve_from(
        &self,
        mut x: Vec<DVec3>,
        tolerance: f64,
        kind: Option<MixedPreconditioner>,
    ) -> (Result<CgInfo, CgError>, Vec<DVec3>) {
        let mut scratch = SolverScratch::default();
        scratch.free.clone_from(&self.free);
        scratch.residual.clone_from(&self.load);
        let mut memory = ProductMemory { corner: &mut Vec::new(), passes: &mut BendingPasses::default() };
        let mut mixed = MixedSolver::default();
        let mut available = Available { mixed: kind.map(|kind| (&mut mixed, kind)), ..Available::default() };
        let params = LinearParams::by_residual(tolerance, 20_000);
        let info = solver::solve(&self.operator(), &params, &mut available, &mut memory, &mut x, &mut scratch);
        (info, x)
    }

    /// |b − A·x| over what it is for the prescribed motion alone.
    fn relative_residual(&self, x: &[DVec3]) -> f64 {
        let norm = |x: &[DVec3]| {
            let mut memory = ProductMemory { corner: &mut Vec::new(), passes: &mut BendingPasses::default() };
            let mut product = vec![DVec3::ZERO; x.len()];
            self.operator().apply(x, &self.free, &mut memory, &mut product, &mut Vec::new());
            let rows = self.load.iter().zip(&product).zip(&self.free);
            rows.map(|((b, p), f)| ((*b - *p) * *f).length_squared()).sum::<f64>().sqrt()
        };
        norm(x) / norm(&self.guess())
    }
}

#[test]
fn a_guess_need_only_have_the_right_direction() {
    let torn = Torn::new();
    for kind in [None, Some(MixedPreconditioner::IncompleteCholesky)] {
        let (from_nothing, answer) = torn.solve(1e-8, kind);
        let from_nothing = from_nothing.unwrap().iterations;
        // The answer with its free part so many times too long; at the last its work is beyond all numbers, and it is dropped.
        for factor in [1.0, 3.0, -0.5, 1e9, 1e-9, 1e200] {
            let scaled = |(x, free): (&DVec3, &DVec3)| DVec3::select(free.cmpeq(DVec3::ZERO), *x, *x * factor);
            let guess = answer.iter().zip(&torn.free).map(scaled).collect();
            let (info, x) = torn.solve_from(guess, 1e-6, kind);
            let info = info.unwrap();
            let most = if factor < 1e100 { 0 } else { from_nothing };
            assert!(info.iterations <= most, "{kind:?}, {factor}: {info:?}");
            assert!(torn.relative_residual(&x) <= 1e-6, "{kind:?}, {factor}");
        }
    }
}

#[test]
fn every_tolerance_is_reached_and_prescribed_axes_stay() {
    let torn = Torn::new();
    for tolerance in [1e-2, 1e-4, 1e-8, 1e-12] {
        let mut iterations = Vec::new();
        for kind in [
            None,
            Some(MixedPreconditioner::BlockJacobi),
            Some(MixedPreconditioner::IncompleteCholesky),
            Some(MixedPreconditioner::Multigrid),
        ] {
            let (info, x) = torn.solve(tolerance, kind);
            let info = info.unwrap();
            iterations.push(info.iterations);
            assert!(info.relative_residual <= tolerance, "{kind:?} left {}", info.relative_residual);
            let residual = torn.relative_residual(&x);
            // Double precision carries its residual along: by 1e-12 rounding has taken it off the true one.
            let slack = if kind.is_none() { 3e-12 } else { 1e-14 };
            assert!(residual <= tolerance + slack, "{kind:?} at {tolerance}: {residual}");
            for ((x, guess), free) in x.iter().zip(torn.guess()).zip(&torn.free) {
                assert_eq!(*x * (DVec3::ONE - *free), guess * (DVec3::ONE - *free));
            }
        }
        println!("to {tolerance}: {iterations:?} iterations");
        // What factor and levels are for: the former needs a third to a fifth of the iterations.
        assert!(2 * iterations[2] < iterations[1] && 2 * iterations[3] < iterations[1], "{iterations:?}");
    }
}

/// From 8,192 triangles on the rows of a factor are dissected.
#[test]
fn a_factor_in_halves_leaves_as_few_iterations() {
    let torn = Torn::capsule(9000, 12);
    let [(halves, x), (jacobi, _)] = [MixedPreconditioner::IncompleteCholesky, MixedPreconditioner::BlockJacobi]
        .map(|kind| torn.solve(1e-4, Some(kind)));
    let (halves, jacobi) = (halves.unwrap().iterations, jacobi.unwrap().iterations);
    assert!(torn.relative_residual(&x) <= 1e-4);
    // As of rows in one piece, above.
    assert!(2 * halves < jacobi, "{halves} and {jacobi} iterations");
}

/// A planar body has blocks of its own: they are those of space without what is zero there.
#[test]
fn a_plane_is_solved_as_space_is() {
    let mut sheet = Torn::planar();
    let flat = sheet.frames.clone();
    let geometric = (0..flat.len()).map(|t| flat.geometric_stiffness(t)).collect();
    let solid = Frames { solid: flat.states().collect(), geometric, ..Frames::default() };
    for tolerance in [1e-3, 1e-8] {
        let mut solve = |frames: &Frames| {
            sheet.frames.clone_from(frames);
            let (info, x) = sheet.solve(tolerance, Some(MixedPreconditioner::IncompleteCholesky));
            assert!(sheet.relative_residual(&x) <= tolerance);
            (info.unwrap().iterations, x)
        };
        let ((flat, x), (solid, reference)) = (solve(&flat), solve(&solid));
        println!("to {tolerance}: {flat} iterations in the plane, {solid} in space");
        // Sums of products are rounded in another order: that may move the end of the iterations by one in each round.
        assert!(flat.abs_diff(solid) <= 2, "{flat} and {solid} iterations");
        let largest = reference.iter().map(|x| x.length()).fold(0.0, f64::max);
        let off = x.iter().zip(&reference).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
        // Both are off by as much as their residuals allow, which the condition of the sheet makes some hundred times as large.
        assert!(off <= 300.0 * tolerance * largest, "{off} of {largest}");
    }
}

/// A planar solve of few iterations never leaves single precision: what it reports must still be the residual. The rounding of
/// numbers (6e-8) times the condition of the sheet is what it may be off by.
#[test]
fn the_residual_of_single_precision_is_the_true_one() {
    let sheet = Torn::planar();
    for tolerance in [1e-1, 1e-2, 1e-3, 1e-4] {
        let (info, x) = sheet.solve(tolerance, Some(MixedPreconditioner::Multigrid));
        let (reported, residual) = (info.unwrap().relative_residual, sheet.relative_residual(&x));
        println!("to {tolerance}: reports {reported:e}, is {residual:e}");
        assert!((reported - residual).abs() < 0.01 * tolerance, "reports {reported:e}, is {residual:e}");
    }
}

/// A loose solve in space ends with the recursive residual, but not beside a stiffness whose rounding is larger than that.
#[test]
fn the_recursive_residual_in_space_is_the_true_one() {
    let mut torn = Torn::new();
    let errors = |torn: &Torn| {
        [3e-1, 1e-1, 3e-2, 1e-2].map(|tolerance| {
            let (info, x) = torn.solve(tolerance, Some(MixedPreconditioner::IncompleteCholesky));
            let (reported, residual) = (info.unwrap().relative_residual, torn.relative_residual(&x));
            println!("to {tolerance}: reports {reported:e}, is {residual:e}");
            (reported - residual).abs() / residual
        })
    };
    let recursive = errors(&torn);
    // The estimated rounding is a hundredth of the residual at the most.
    assert!(recursive.iter().all(|error| *error < 0.01), "{recursive:?}");
    // One that is formed in double precision differs by the rounding of sums alone: a larger error shows that the recursive one was taken.
    assert!(recursive.iter().any(|error| *error > 1e-12), "{recursive:?}");
    let mut stiff = torn.external.take().unwrap_or_default();
    stiff.block.resize(torn.vertices.len(), Sym3::ZERO);
    stiff.block[1].diagonal = DVec3::splat(1e9);
    torn.external = Some(stiff);
    let formed = errors(&torn);
    assert!(formed.iter().all(|error| *error < 1e-12), "{formed:?}");
}

#[test]
fn the_projected_tangent_is_solved_in_single_precision_as_far() {
    let mut torn = Torn::new();
    torn.tangent = Tangent::Projected;
    for t in 0..torn.frames.len() {
        let ElementState { polar, stress } = torn.frames.state(t);
        let normal = membrane::second_piola(stress, polar.stretch).positive_part();
        let in_plane = membrane::spin_majorant(stress, polar.stretch, &torn.triangles.stiffness[t], [0.0; 2]);
        torn.frames.geometric[t] = GeometricStiffness { normal, in_plane };
    }
    let projected = torn.frames.geometric.iter().filter(|g| g.in_plane > 0.0).count();
    // A few of the slack flap; most of the capsule is taut, and there this is the exact tangent.
    assert!(projected > 5, "{projected}");
    // What the accurate settings ask for at the most.
    let (double, reference) = torn.solve(1e-10, None);
    let (mixed, x) = torn.solve(1e-10, Some(MixedPreconditioner::IncompleteCholesky));
    let (double, mixed) = (double.unwrap(), mixed.unwrap());
    println!("{} iterations in double precision, {} in mixed", double.iterations, mixed.iterations);
    // Double precision without a factor would take over with as many iterations again.
    assert!(mixed.relative_residual <= 1e-10 && mixed.iterations < double.iterations / 2);
    assert!(torn.relative_residual(&x) <= 1e-10 + 1e-14);
    let largest = reference.iter().map(|x| x.length()).fold(0.0, f64::max);
    let off = x.iter().zip(&reference).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
    // Residuals of 1e-10 times the condition of a slack flap, some 1e5.
    assert!(off < 1e-5 * largest, "{off} of {largest} mm");
}

#[test]
fn both_precisions_have_one_answer() {
    let torn = Torn::new();
    let (_, double) = torn.solve(1e-12, None);
    let largest = double.iter().map(|x| x.length()).fold(0.0, f64::max);
    for kind in
        [MixedPreconditioner::BlockJacobi, MixedPreconditioner::IncompleteCholesky, MixedPreconditioner::Multigrid]
    {
        let (_, mixed) = torn.solve(1e-12, Some(kind));
        let off = mixed.iter().zip(&double).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
        // Residuals of 1e-12 times the condition of a slack flap, some 1e5.
        assert!(off < 1e-7 * largest, "{kind:?}: {off} of {largest} mm");
    }
}

#[test]
#[cfg(feature = "direct")]
fn a_factor_on_the_spot_is_needed_for_sixteen_solves_however_often_it_is_renewed() {
    let torn = Torn::new();
    let (operator, mut factor) = (torn.operator(), solver::Factor::default());
    assert!(!factor.take_need());
    factor.renew_for_next(&operator, &torn.free).unwrap();
    let mut solves = 0;
    while factor.take_need() {
        solves += 1;
        // Sixteen, in which solves without it may have become easy again.
        assert!(solves <= 16);
        factor.renew(&operator, &torn.free).unwrap();
    }
    assert_eq!(solves, 16);
}

/// Stiff along skew directions, so that what is soft is but the rounding of that in single precision: factors of it may be of no use.
#[test]
fn a_factor_that_rounding_has_broken_costs_few_iterations() {
    let mut torn = Torn::new();
    let sound = torn.external.clone().unwrap();
    for stiffness in [1e3, 1e4, 1e5, 1e6, 1e7] {
        let external = torn.external.as_mut().unwrap();
        for (v, (block, sound)) in external.block.iter_mut().zip(&sound.block).enumerate() {
            let n = DVec3::new((v as f64).sin(), (1.7 * v as f64).cos(), 0.4).normalize();
            *block = *sound + Sym3::outer(n) * stiffness;
        }
        let (info, x) = torn.solve(1e-3, Some(MixedPreconditioner::IncompleteCholesky));
        let (iterations, residual) = (info.unwrap().iterations, torn.relative_residual(&x));
        println!("{stiffness:e}: {iterations} iterations leave {residual:e}");
        // Two rounds of 150 that come to nothing, each with a factor whose diagonal is raised further, and a third that serves.
        assert!(iterations < 400 && residual <= 1e-3, "{stiffness:e}: {iterations} iterations leave {residual:e}");
    }
}

#[test]
fn what_is_no_operator_is_named() {
    let kinds = [
        None,
        Some(MixedPreconditioner::BlockJacobi),
        Some(MixedPreconditioner::IncompleteCholesky),
        Some(MixedPreconditioner::Multigrid),
    ];
    let mut torn = Torn::new();
    let sound = torn.external.clone();
    // A spring that pushes away, stiffer than all that meets in the vertex.
    torn.external.as_mut().unwrap().block[1] = Sym3::isotropic(-10.0);
    for kind in kinds {
        let (info, _) = torn.solve(1e-4, kind);
        assert!(matches!(info, Err(CgError::Indefinite { .. })), "{kind:?}: {info:?}");
    }
    torn.external = sound.clone();
    torn.external.as_mut().unwrap().block[1].diagonal.x = f64::NAN;
    for kind in kinds {
        let (info, _) = torn.solve(1e-4, kind);
        assert!(matches!(info, Err(CgError::NotFinite { .. })), "{kind:?}: {info:?}");
    }
    torn.external = sound;
    torn.load[2].y = f64::INFINITY;
    for kind in kinds {
        let (info, _) = torn.solve(1e-4, kind);
        assert!(matches!(info, Err(CgError::NotFinite { .. })), "{kind:?}: {info:?}");
    }
}

#[test]
fn forces_of_any_size_are_in_range() {
    let mut torn = Torn::new();
    let sound = torn.load.clone();
    let (_, expected) = torn.solve(1e-6, Some(MixedPreconditioner::IncompleteCholesky));
    // The answer is the sum of that to the load and that to the prescribed motion: without load, and with one far out of the
    // range of single precision.
    torn.load = sound.iter().map(|_| DVec3::ZERO).collect();
    let (info, unloaded) = torn.solve(1e-6, Some(MixedPreconditioner::IncompleteCholesky));
    assert!(info.unwrap().relative_residual <= 1e-6);
    torn.load = sound.iter().map(|load| *load * 1e60).collect();
    let (info, loaded) = torn.solve(1e-6, Some(MixedPreconditioner::IncompleteCholesky));
    assert!(info.unwrap().relative_residual <= 1e-6);
    let largest = expected.iter().map(|x| x.length()).fold(0.0, f64::max);
    for ((expected, unloaded), loaded) in expected.iter().zip(&unloaded).zip(&loaded) {
        // Residuals of 1e-6 times the condition.
        assert!((*loaded * 1e-60 + *unloaded - *expected).length() < 0.1 * largest);
    }
}

/// 3,000 vertices and more than two chunks of triangles: threads do share the loops.
fn run(settings: Settings, steps: usize) -> (Simulation, BodyId) {
    let mut square = Square::new([60, 50], 60.0);
    square.tearing.strength_across_fibres *= 0.2;
    square.tearing.strength_along_fibres *= 0.2;
    let mut run = square.spawn(settings);
    for _ in 0..steps {
        run.step();
    }
    assert!(steps < 10 || run.log().advance_count > 2, "the state must be one after tears");
    (run.simulation, run.body)
}

#[test]
fn threads_and_instructions_leave_the_bits_alone() {
    for preconditioner in PRECONDITIONERS {
        let settings = Settings {
            threads: 1,
            advanced: Advanced { preconditioner, ..Advanced::default() },
            ..Settings::default()
        };
        let bits = |settings: Settings| {
            let (simulation, body) = run(settings, 16);
            state_bits(&simulation, body)
        };
        let once = bits(settings);
        assert!(bits(Settings { threads: 2, ..settings }) == once, "{preconditioner:?}, two threads");
        assert!(bits(Settings { portable_instructions: true, ..settings }) == once, "{preconditioner:?}, portable");
    }
}

#[test]
fn a_run_is_that_of_double_precision_within_the_tolerance() {
    let positions = |preconditioner, precision, tolerance| {
        let linear = LinearParams::by_residual(tolerance, 20_000);
        // Before the first tear, which would make a difference of one advance out of any.
        let (simulation, body) = run(
            Settings {
                threads: 1,
                advanced: Advanced { linear, preconditioner, precision, ..Advanced::default() },
                ..Settings::default()
            },
            5,
        );
        simulation.world().get::<&Vertices>(body.entity()).unwrap().position.clone()
    };
    let off = |a: &[DVec3], b: &[DVec3]| a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
    let tight = positions(Preconditioner::BlockJacobi, Precision::Double, 1e-12);
    for preconditioner in PRECONDITIONERS {
        let mixed = off(&positions(preconditioner, Precision::Mixed, 1e-12), &tight);
        // Five steps of 0.03 mm: 1e-12 of it times the condition of the sheet, some 1e4.
        assert!(mixed < 1e-9, "{preconditioner:?}: {mixed} mm");
        for tolerance in [1e-3, 1e-5] {
            let double = off(&positions(Preconditioner::BlockJacobi, Precision::Double, tolerance), &tight);
            let mixed = off(&positions(preconditioner, Precision::Mixed, tolerance), &tight);
            println!("{preconditioner:?} at {tolerance}: {mixed:e} mm, in double precision {double:e} mm");
            // The same residual leaves an error of the same size; its shape depends on the iterations.
            assert!(mixed < 3.0 * double, "{preconditioner:?}: {mixed} against {double} mm");
        }
    }
}
