//! What every system of a step costs, a split, a whole step, the memory of a body and the allocations of a step.

use super::clock::{Stopwatch, median, quantile};
use super::trace::{instantiate, triangle_count};
use super::{BenchError, Context, Depth, Table};
use rhexis::event::EventKind;
use rhexis::schedule::STEP;
use stats_alloc::{INSTRUMENTED_SYSTEM, Stats};

/// Triangles of the squares that are measured.
pub const SIZES: [usize; 4] = [1_500, 15_000, 150_000, 1_500_000];

/// A square and what it carries.
struct Configuration {
    name: &'static str,
    scene: &'static str,
    sets: &'static [&'static str],
    /// Steps before the measured ones, with the time after which they begin \[ms\].
    warm_up: u64,
    /// Steps that are measured on the smallest mesh; the larger have fewer.
    steps: u64,
    most_triangles: usize,
}

const CONFIGURATIONS: [Configuration; 3] = [
    Configuration {
        name: "elastic",
        scene: "fig2-haptic",
        sets: &[],
        warm_up: 40,
        steps: 200,
        most_triangles: usize::MAX,
    },
    Configuration {
        name: "elastic, incomplete Cholesky",
        scene: "fig2-haptic",
        sets: &["run.advanced.preconditioner=incomplete_cholesky"],
        warm_up: 5,
        steps: 200,
        most_triangles: usize::MAX,
    },
    // The tear begins after some 30 steps.
    Configuration {
        name: "tearing",
        scene: "fig2-tear",
        sets: &["run.until_torn=false", "run.steps=1000"],
        warm_up: 25,
        steps: 75,
        most_triangles: 200_000,
    },
];

/// Measures squares of about so many triangles with so many threads.
///
/// # Errors
/// Where a run fails.
pub fn systems(context: &Context, sizes: &[usize], threads: &[usize]) -> Result<Vec<Table>, BenchError> {
    let keys = ["configuration", "triangles", "threads"];
    let of_system = ["median_ms", "ns_per_triangle", "share"];
    let mut times = Table::new("systems", context, &[&keys[..], &["system"]].concat(), &of_system);
    times.remark("per step, on the wall; a system that is not listed finds no body that needs it and is skipped");
    let figures = [
        "median_ms",
        "p999_ms",
        "worst_ms",
        "process_ms",
        "split_ms",
        "advances",
        "bytes_per_triangle",
        "allocations_per_step",
    ];
    let mut steps = Table::new("steps", context, &keys, &figures);
    steps.remark("step: processor time on one thread, time on the wall on more; split: an advance of a tip with everything that follows the edits");
    steps.remark("bytes: what the simulation has on the heap after the last step, factors and reserves included");
    if bytes_in_use(INSTRUMENTED_SYSTEM.stats()) == 0 {
        steps.remark("bytes and allocations are not counted: this program has an allocator that does not count");
    }
    let is_measured = |configuration: &&Configuration, size: usize| size <= configuration.most_triangles;
    let runs: Vec<(usize, usize, &Configuration)> = sizes
        .iter()
        .flat_map(|&size| threads.iter().map(move |&count| (size, count)))
        .flat_map(|(size, count)| {
            CONFIGURATIONS.iter().filter(move |c| is_measured(c, size)).map(move |c| (size, count, c))
        })
        .collect();
    context.begin(runs.len());
    for (size, thread_count, configuration) in runs {
        context.now(format!("{}: {size} triangles, {thread_count} thread(s)", configuration.name));
        measure(context.depth, configuration, size, thread_count, &mut times, &mut steps)?;
        context.done();
    }
    Ok(vec![times, steps])
}

/// Cells of a square of about so many triangles, nearly square themselves: as the meshes of the catalog.
fn cells(triangles: usize) -> [usize; 2] {
    let nx = (0.5 * triangles as f64 * 1.2).sqrt().round().max(2.0);
    [nx as usize, (0.5 * triangles as f64 / nx).round().max(2.0) as usize]
}

fn bytes_in_use(stats: Stats) -> usize {
    stats.bytes_allocated.saturating_sub(stats.bytes_deallocated)
}

fn measure(
    depth: Depth,
    configuration: &Configuration,
    size: usize,
    thread_count: usize,
    times: &mut Table,
    steps: &mut Table,
) -> Result<(), BenchError> {
    let before = bytes_in_use(INSTRUMENTED_SYSTEM.stats());
    let [nx, ny] = cells(size);
    let mut sets: Vec<String> = configuration.sets.iter().map(|&set| set.to_owned()).collect();
    sets.extend([format!("bodies.0.mesh.grid.nx={nx}"), format!("bodies.0.mesh.grid.ny={ny}")]);
    sets.push(format!("run.threads={thread_count}"));
    let mut instance = instantiate(configuration.scene, &sets)?;
    let triangles = triangle_count(&instance.simulation, instance.bodies[0]);
    let larger = (size / 15_000).max(1) as u64;
    let warm_up = if size > 200_000 { 3 } else { configuration.warm_up };
    let step_count =
        if depth == Depth::Quick { 10 } else { (configuration.steps / larger).clamp(5, configuration.steps) };
    // A tear has to be met, however large the mesh.
    let step_count = if configuration.name == "tearing" && depth != Depth::Quick {
        configuration.steps.min(30 + step_count)
    } else {
        step_count
    };
    for _ in 0..warm_up {
        instance.advance()?;
        instance.simulation.drain_events();
    }
    let mut of_system = vec![Vec::new(); STEP.len()];
    let (mut of_step, mut of_process, mut of_split) = (Vec::new(), Vec::new(), Vec::new());
    let (mut allocations, mut advances) = (0, 0);
    let split = STEP.iter().position(|system| system.name == "split").unwrap_or(0);
    for _ in 0..step_count {
        let (stats, watch) = (INSTRUMENTED_SYSTEM.stats(), Stopwatch::start());
        instance.advance()?;
        let (elapsed, change) = (watch.elapsed(), INSTRUMENTED_SYSTEM.stats() - stats);
        allocations += change.allocations + change.reallocations;
        of_step.push(if thread_count == 1 { elapsed.thread } else { elapsed.wall });
        of_process.push(elapsed.process);
        let report = instance.simulation.report();
        for (times, system) in of_system.iter_mut().zip(&report.systems) {
            if system.bodies > 0 {
                times.push(1e3 * system.time.as_secs_f64());
            }
        }
        let split_ms = 1e3 * report.systems[split].time.as_secs_f64();
        let events = instance.simulation.drain_events();
        let count = events.filter(|event| matches!(event.kind, EventKind::Advanced { .. })).count();
        if count > 0 {
            of_split.push(split_ms / count as f64);
            advances += count;
        }
    }
    let bytes = bytes_in_use(INSTRUMENTED_SYSTEM.stats()).saturating_sub(before) as f64;
    let (count, thread_count) = (triangles.to_string(), thread_count.to_string());
    let medians: Vec<f64> = of_system.iter().map(|times| median(times)).collect();
    let total: f64 = medians.iter().filter(|ms| ms.is_finite()).sum();
    for (system, ms) in STEP.iter().zip(medians).filter(|(_, ms)| ms.is_finite()) {
        let keys = [configuration.name, &count, &thread_count, system.name];
        times.add(&keys, &[ms, 1e6 * ms / triangles as f64, ms / total]);
    }
    let counted = |value: f64| if bytes > 0.0 { value } else { f64::NAN };
    let figures = [
        median(&of_step),
        quantile(&of_step, 0.999),
        quantile(&of_step, 1.0),
        median(&of_process),
        median(&of_split),
        advances as f64,
        counted(bytes / triangles as f64),
        counted(allocations as f64 / step_count as f64),
    ];
    steps.add(&[configuration.name, &count, &thread_count], &figures);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meshes_have_about_the_size_that_is_asked_for() {
        assert_eq!(cells(1_500), [30, 25]);
        for size in SIZES {
            let [nx, ny] = cells(size);
            assert!((2 * nx * ny).abs_diff(size) < size / 50, "{nx} × {ny}");
        }
    }
}
