//! `rhexis run`.

use super::checkpoint::Checkpoint;
use super::course::CourseReport;
use super::files::Files;
use super::moments::Moments;
use super::progress::Progress;
use super::report::{self, End, RunReport, Sources};
use super::series::{Observation, observe};
use super::tally::Tally;
use super::timings::Timings;
use super::{RunArgs, Stop, document, dump, say::complain, say::say};
use crate::components::{Grips, Tearing};
use crate::frame::Frame;
use crate::report::TearCourse;
use crate::scene::schema::Mode;
use crate::scene::{Instance, Scene};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// A run is given up after so many failed steps in a row: what fails so often does not mend itself.
const MOST_FAILURES: u32 = 10;

/// A run in progress.
struct Running<'a> {
    scene: &'a Scene,
    overrides: &'a [String],
    instance: Instance,
    files: Files,
    tally: Tally,
    timings: Timings,
    last: Observation,
    /// Of the bodies that can tear and are gripped, in their order.
    courses: Vec<TearCourse>,
    start: Instant,
    stepping: Duration,
    /// Steps in a row that have failed.
    failures: u32,
    snapshots: Option<Snapshots>,
}

/// When the state is kept, where, and of which scene.
struct Snapshots {
    every: u64,
    folder: PathBuf,
    scene: u64,
}

/// Runs a scene and writes what it gives.
pub(super) fn run(args: &RunArgs) -> Result<(), Stop> {
    let mut document = document(&args.scene)?;
    if let Some(threads) = args.threads {
        document.set(&format!("run.threads={threads}"))?;
    }
    let scene = document.scene()?;
    let fingerprint = fingerprint(args)?;
    let mut instance = scene.instantiate()?;
    if let Some(steps) = args.steps {
        instance.run.steps = steps;
    }
    let folder = args.out.clone().unwrap_or_else(|| PathBuf::from("out").join(file_name(scene.name())));
    let steps = instance.run.steps;
    let moments = |count: u32| Moments { count: u64::from(count), steps };
    let (pictures, frames) = (moments(instance.output.pictures), moments(instance.output.frames));
    if let Some(folder) = &args.dump {
        // Now: what cannot be written is better known before the run than after it.
        dump::create(folder)?;
    }
    let kept = args.resume.then(|| Checkpoint::load(&folder, fingerprint)).transpose()?;
    let files = match &kept {
        Some(kept) => {
            instance.resume(&kept.snapshot, kept.progress)?;
            Files::resume(&folder, scene.name(), [pictures, frames], &kept.marks)?
        }
        None => Files::create(&folder, scene.name(), pictures, frames)?,
    };
    if args.record.is_some() {
        instance.simulation.record();
    }
    let last = observe(&mut instance);
    let world = instance.simulation.world();
    let drawn = instance.bodies.iter().filter(|&&body| world.satisfies::<(&Tearing, &Grips)>(body));
    let courses = drawn.filter_map(|&body| TearCourse::new(world, body, last.time)).collect();
    let courses = kept.as_ref().map_or(courses, |kept| kept.courses.clone());
    let times = kept.as_ref().map_or([Duration::ZERO; 2], |kept| kept.times);
    let failures = kept.as_ref().map_or(0, |kept| kept.failures);
    let mut running = Running {
        scene: &scene,
        overrides: &args.scene.set,
        instance,
        files,
        tally: kept.map_or_else(Tally::default, |kept| kept.tally),
        timings: Timings::new(),
        last,
        courses,
        start: Instant::now().checked_sub(times[1]).unwrap_or_else(Instant::now),
        stepping: times[0],
        failures,
        snapshots: args.snapshots.map(|every| Snapshots { every, folder: folder.clone(), scene: fingerprint }),
    };
    let progress = Progress::new(steps, args.quiet);
    let outcome = running.go(&progress, args.resume);
    progress.finish();
    let end = outcome?;
    let has_failed = matches!(end, End::Failed(_));
    if let (Some(path), Some(recording)) = (&args.record, running.instance.simulation.end_recording()) {
        recording.save(path)?;
    }

    let frame = running.frame();
    let tears = running.tally.events.started;
    running.files.frame(&frame, running.last.step, tears, true)?;
    let report = running.report(end);
    running.files.report(&report)?;
    if let Some(folder) = &args.dump {
        dump::dump(folder, &frame, &running.last)?;
    }
    if args.json {
        say(&serde_json::to_string_pretty(&report).map_err(|error| Stop::Failed(error.to_string()))?)?;
    } else if !args.quiet {
        say(&summary(&report))?;
        say(&format!("written to {}", folder.display()))?;
    }
    if args.timings {
        // With --json, standard output holds the report and nothing else.
        if args.json { complain(&running.timings.table()) } else { say(&running.timings.table())? }
    }
    match (has_failed, &report.end) {
        (true, End::Failed(reason)) => Err(Stop::Failed(reason.clone())),
        _ => Ok(()),
    }
}

impl Running<'_> {
    /// Steps to the end.
    fn go(&mut self, progress: &Progress, is_resumed: bool) -> Result<End, Stop> {
        if !is_resumed {
            self.events()?;
            self.files.row(&self.last, true)?;
            self.frames(false)?;
        }
        while !self.instance.is_finished() {
            let before = Instant::now();
            let outcome = self.instance.advance().map(|_| ());
            self.stepping += before.elapsed();
            if let Err(error) = outcome {
                self.last = observe(&mut self.instance);
                self.events()?;
                return Ok(End::Failed(error.to_string()));
            }
            self.last = observe(&mut self.instance);
            let settings = self.instance.simulation.settings();
            // A static solve sets its own limit and is judged by its imbalance.
            let tolerance = match self.instance.run.mode {
                Mode::Dynamic => settings.linear.tolerance,
                Mode::Static => f64::INFINITY,
            };
            let report = self.instance.simulation.report();
            self.tally.add(report, &self.last, tolerance);
            self.timings.add(report);
            self.failures = if report.has_failed { self.failures + 1 } else { 0 };
            let advanced_before = self.tally.events.advanced;
            self.events()?;
            self.files.row(&self.last, false)?;
            // The step in which the tear begins to run is one to see.
            self.frames(advanced_before == 0 && self.tally.events.advanced > 0)?;
            progress.show(&self.last, self.stepping);
            if self.failures == MOST_FAILURES {
                return Ok(given_up(self.failures));
            }
            self.keep()?;
        }
        if self.failures > 0 {
            return Ok(given_up(self.failures));
        }
        Ok(match self.last.step < self.instance.run.steps {
            true if self.instance.run.until_ended => End::TearEnded,
            true => End::TornThrough,
            false => End::Done,
        })
    }

    /// Keeps the state, where it is due.
    fn keep(&mut self) -> Result<(), Stop> {
        let Some(Snapshots { every, folder, scene }) = &self.snapshots else { return Ok(()) };
        if !self.last.step.is_multiple_of(*every) {
            return Ok(());
        }
        let kept = Checkpoint {
            scene: *scene,
            snapshot: self.instance.simulation.snapshot(),
            progress: self.instance.progress(),
            tally: self.tally.clone(),
            courses: self.courses.clone(),
            marks: self.files.marks()?,
            failures: self.failures,
            times: [self.stepping, self.start.elapsed()],
        };
        kept.save(folder)
    }

    fn events(&mut self) -> Result<(), Stop> {
        let events: Vec<_> = self.instance.simulation.drain_events().collect();
        for course in &mut self.courses {
            course.note(self.instance.simulation.world(), self.last.time, &events);
        }
        for event in &events {
            let body = report::body_name(&self.instance, event.body);
            self.tally.add_event(self.last.step, &body, &event.kind);
            self.files.event(self.last.step, &body, event)?;
        }
        Ok(())
    }

    fn frames(&mut self, is_special: bool) -> Result<(), Stop> {
        if self.files.wants_frame(self.last.step, is_special) {
            let frame = self.frame();
            self.files.frame(&frame, self.last.step, self.tally.events.started, is_special)?;
            let report = self.report(End::Running);
            self.files.report(&report)?;
        }
        Ok(())
    }

    /// The state now, numbered by the scene's steps: a static one may have taken several equilibria.
    fn frame(&mut self) -> Frame {
        Frame { step: self.last.step, ..self.instance.simulation.frame() }
    }

    fn report(&mut self, end: End) -> RunReport {
        let Self { scene, overrides, instance, tally, timings, last, courses, start, stepping, .. } = self;
        let (elapsed, stepping) = (start.elapsed(), *stepping);
        let sources = Sources { scene, overrides, tally, timings, last, courses, elapsed, stepping, end };
        let mut report = report::report(instance, sources);
        report.caveats.extend(self.files.notes.iter().cloned());
        report
    }
}

/// What tells the scene from others: its values, but for the threads, which change no result.
fn fingerprint(args: &RunArgs) -> Result<u64, Stop> {
    let mut document = document(&args.scene)?;
    document.set("run.threads=1")?;
    Ok(document.scene()?.fingerprint())
}

/// The end of a run whose last steps all failed.
fn given_up(failures: u32) -> End {
    End::Failed(format!(
        "the last {failures} step(s) left no usable state; take a smaller run.dt or more damping, and look for a number \
         of the scene that is far out of scale"
    ))
}

/// A name that is one folder on every system.
fn file_name(name: &str) -> String {
    let plain: String =
        name.chars().map(|c| if c.is_alphanumeric() || "-_".contains(c) { c } else { '_' }).take(60).collect();
    if plain.is_empty() { "scene".to_owned() } else { plain }
}

/// The few lines at the end.
fn summary(report: &RunReport) -> String {
    let end = match &report.end {
        End::Running => "interrupted",
        End::Done => "done",
        End::TornThrough => "torn through",
        End::TearEnded => "the tear has ended",
        End::Failed(_) => "FAILED",
    };
    let mut lines = vec![format!(
        "{}: {end} after {} of {} steps, {:.6} ms simulated in {:.2} s ({:.3} × real time)",
        report.scene,
        report.steps,
        report.steps_planned,
        report.simulated_ms,
        report.stepping_s,
        report.real_time_factor
    )];
    for body in &report.bodies {
        lines.push(format!(
            "  {}: {} triangles, elastic {:.6} mJ, kinetic {:.3e} mJ",
            body.name, body.triangles, body.elastic_mj, body.kinetic_mj
        ));
        for r in &body.reactions {
            // Adding zero turns a rounded −0 into 0.
            let [x, y, z] = r.force_n.map(|f| (f * 1e6).round() * 1e-6 + 0.0);
            lines.push(format!("    {}: {x:.6}, {y:.6}, {z:.6} N", r.name));
        }
        for grip in body.grips.iter().filter(|grip| grip.peak_n > 0.0) {
            lines.push(format!("    {}: {:.2} mN rms, {:.2} mN peak", grip.name, 1e3 * grip.rms_n, 1e3 * grip.peak_n));
        }
        lines.extend(body.course.as_ref().map(CourseReport::summary));
        if let Some(tear) = &body.tear {
            lines.push(format!(
                "    torn {:.3} mm in {} advances, {} tip(s) left, {} ended, {} piece(s) free",
                tear.length_mm,
                tear.advances,
                tear.tips.len(),
                tear.ended,
                tear.pieces_freed
            ));
            if let Some(refinement) = &tear.refinement {
                lines.push(format!(
                    "    refined by {} splits, coarsened by {} vertices; {} triangles more than at the start and torn, {} allowed",
                    refinement.splits,
                    refinement.vertices_removed,
                    refinement.triangles_added,
                    refinement.most_triangles_added
                ));
            }
        }
    }
    lines.extend(report.caveats.iter().map(|caveat| format!("  note: {caveat}")));
    lines.join("\n")
}
