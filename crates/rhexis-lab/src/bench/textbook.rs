//! Against the textbook: the same step with conjugate gradients in double precision, block Jacobi and plain instructions, at the
//! same error.

use super::clock::median;
use super::equal_error::{Reached, at_tolerance, loosest};
use super::trace::{Plan, Trace};
use super::{BenchError, Context, Depth, Table};

/// The stress error at which both are compared.
const LEVEL: f64 = 1e-3;

/// Cells, the measured times \[ms\], the factor that is wanted, and the depth from which on it is measured.
const SIZES: [([usize; 2], [f64; 3], f64, Depth); 3] = [
    ([30, 25], [40.0, 100.0, 10.0], 8.0, Depth::Quick),
    ([95, 79], [40.0, 80.0, 10.0], 15.0, Depth::Usual),
    ([300, 250], [5.0, 15.0, 5.0], 40.0, Depth::Full),
];

/// Either path is measured for so long, or once: what the machine does beside it is then in neither.
const SECONDS: f64 = 10.0;

const TEXTBOOK: [&str; 2] = ["run.advanced.preconditioner=block_jacobi", "run.advanced.precision=double"];

/// Measures both paths on the square in a trembling hand.
///
/// # Errors
/// Where a run fails.
pub fn textbook(context: &Context) -> Result<Vec<Table>, BenchError> {
    let figures = ["median_ms", "tolerance", "iterations", "stress_error", "noise", "ratio", "wanted"];
    let mut table = Table::new("textbook", context, &["triangles", "path"], &figures);
    table.remark(format!("fig2-haptic, one thread; each path at the loosest tolerance whose worst state has a stress error of {LEVEL:e} at most"));
    let sizes = SIZES.iter().filter(|(.., from)| *from <= context.depth);
    context.begin(3 * sizes.clone().count());
    for &([nx, ny], [from, until, every], wanted, _) in sizes {
        let sets = vec![format!("bodies.0.mesh.grid.nx={nx}"), format!("bodies.0.mesh.grid.ny={ny}")];
        let solver = Vec::new();
        let (scene, compared_until, is_chaotic) = ("fig2-haptic", until, false);
        let plan = Plan { scene, sets, solver, from, until, compared_until, every, is_chaotic };
        let triangles = (2 * nx * ny).to_string();
        context.now(format!("{triangles} triangles: reference"));
        let exact = Trace::record(&at_tolerance(&plan, 1e-9), 0.0)?;
        context.done();
        let seconds = if context.depth == Depth::Quick { 0.0 } else { SECONDS };
        context.now(format!("{triangles} triangles: default path"));
        let own = loosest(&plan, &exact, LEVEL, seconds)?;
        context.done();
        context.now(format!("{triangles} triangles: textbook path"));
        let mut plain = plan.clone();
        plain.sets.push("run.portable_instructions=true".to_owned());
        plain.solver.extend(TEXTBOOK.map(str::to_owned));
        let plain = loosest(&plain, &exact, LEVEL, seconds)?;
        context.done();
        let ratio = median(&plain.trace.step_ms) / median(&own.trace.step_ms);
        for (path, reached, ratio) in [("textbook", &plain, 1.0), ("default", &own, ratio)] {
            let Reached { tolerance, trace, errors } = reached;
            let figures =
                [median(&trace.step_ms), *tolerance, trace.iterations, errors.stress, trace.noise, ratio, wanted];
            table.add(&[&triangles, path], &figures);
        }
    }
    Ok(vec![table])
}
