//! `rhexis run`.

use super::account;
use super::checkpoint::{self, Checkpoint, OwnVersion};
use super::files::Files;
use super::inputs::Inputs;
use super::interrupt::{self, Interrupt};
use super::lock::Lock;
use super::moments::Moments;
use super::progress::Progress;
use super::report::{self, End, RunReport, Sources};
use super::series::{Observation, observe};
use super::summary::summary;
use super::tally::Tally;
use super::timings::Timings;
use super::{RunArgs, Stop, document, dump, outputs, say::complain, say::say};
use rhexis::components::{Grips, Tearing};
use rhexis::event::EventKind;
use rhexis::frame::Frame;
use rhexis_scene::measures::{TearAccount, TearCourse};
use rhexis_scene::schema::Mode;
use rhexis_scene::score::Scoring;
use rhexis_scene::{Instance, Scene};
use std::path::{Path, PathBuf};
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
    /// Of the bodies that can tear, in their order.
    accounts: Vec<TearAccount>,
    start: Instant,
    stepping: Duration,
    /// Steps in a row that have failed.
    failures: u32,
    snapshots: Snapshots,
    interrupt: Interrupt,
}

/// When the state is kept, where, and of which scene.
struct Snapshots {
    every: Option<u64>,
    folder: PathBuf,
    scene: u64,
    /// Hashes of the files that it reads.
    inputs: Vec<u64>,
}

/// Runs a scene and writes what it gives.
pub(super) fn run(args: &RunArgs) -> Result<(), Stop> {
    run_until(args, None)
}

/// The same, until that asks it to end; without one, until a signal does.
pub(super) fn run_until(args: &RunArgs, interrupt: Option<Interrupt>) -> Result<(), Stop> {
    let mut document = document(&args.scene)?;
    if let Some(threads) = args.threads {
        document.set(&format!("run.threads={threads}"))?;
    }
    let scene = document.scene()?;
    let fingerprint = fingerprint(args)?;
    let inputs = Inputs::of(&scene);
    let folder = args.out.clone().unwrap_or_else(|| PathBuf::from("out").join(file_name(scene.name())));
    let lock = || inputs.spare(args, &folder).and_then(|()| Lock::take(&folder));
    let resumed = if args.resume {
        checkpoint::expect(&folder)?;
        // Before the state is read: a run that goes on writes it.
        let lock = lock()?;
        Some((lock, Checkpoint::load(&folder, fingerprint, &inputs)?))
    } else {
        None
    };
    let mut instance = scene.instantiate()?;
    if let Some(steps) = args.steps {
        instance.run.steps = steps;
    }
    for doubt in &instance.doubts {
        complain(&format!("note: {}", doubt.text));
    }
    for contact in &instance.not_felt {
        complain(&format!("not felt: {contact}"));
    }
    let steps = instance.run.steps;
    let output = &instance.output;
    let moments = [(output.pictures, output.pictures_every), (output.frames, output.frames_every)];
    let moments = moments.map(|(count, every)| Moments {
        count: u64::from(count),
        steps,
        gap: every.map(|every| ((every / instance.run.dt).round() as u64).max(1)),
    });
    let (lock, kept) = match resumed {
        Some((lock, kept)) => (lock, Some(kept)),
        None => (lock()?, None),
    };
    outputs::prepare(args, &folder)?;
    let hashes = inputs.hashes()?;
    let interrupt = match interrupt {
        Some(interrupt) => interrupt,
        None => Interrupt::watch().inspect(|_| interrupt::outlive_file_limits())?,
    };
    let mut files = match &kept {
        Some(kept) => {
            if kept.progress.0 > steps {
                let done = kept.progress.0;
                let what = format!("the run in {} has done {done} steps, more than {steps}", folder.display());
                return Err(Stop::Failed(format!("{what}; ask for more with --steps, or begin anew without --resume")));
            }
            instance.resume(&kept.snapshot, kept.progress)?;
            Files::resume(lock, scene.name(), moments, &kept.marks)?
        }
        None => Files::create(lock, scene.name(), moments)?,
    };
    files.with_forces = instance.output.force_arrows;
    if args.record.is_some() {
        instance.simulation.record();
    }
    let last = observe(&mut instance);
    let world = instance.simulation.world();
    let drawn = instance.bodies.iter().filter(|&&body| world.satisfies::<(&Tearing, &Grips)>(body.entity()));
    let limits = instance.scoring.as_ref().map(Scoring::limits).unwrap_or_default();
    let courses =
        drawn.filter_map(|&body| Some(TearCourse::new(world, body, last.time)?.with_limits(limits))).collect();
    let courses = kept.as_ref().map_or(courses, |kept| kept.courses.clone());
    let torn = instance.bodies.iter().filter(|&&body| world.satisfies::<&Tearing>(body.entity()));
    let accounts = torn.map(|&body| TearAccount::new(world, body)).collect();
    let accounts = kept.as_ref().map_or(accounts, |kept| kept.accounts.clone());
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
        accounts,
        start: Instant::now().checked_sub(times[1]).unwrap_or_else(Instant::now),
        stepping: times[0],
        failures,
        snapshots: Snapshots { every: args.snapshots, folder: folder.clone(), scene: fingerprint, inputs: hashes },
        interrupt,
    };
    let progress = Progress::new(steps, args.quiet);
    let outcome = running.go(&progress, args.resume);
    progress.finish();
    running.end(args, &folder, outcome?)
}

impl Running<'_> {
    /// Writes and prints what there is at the end. Whatever cannot be written, the rest is.
    fn end(mut self, args: &RunArgs, folder: &Path, end: End) -> Result<(), Stop> {
        let mut faults = Vec::new();
        if let (Some(path), Some(recording)) = (&args.record, self.instance.simulation.end_recording())
            && let Err(error) = recording.save(path)
        {
            faults.push(format!("cannot write {error}; choose another file with --record"));
        }
        let frame = self.frame();
        self.files.frame(&frame, self.last.step, self.tally.events.started, true);
        let output = &self.instance.output;
        self.files.surfaces(&frame, &self.instance.seams, [output.obj, output.ply]);
        let report = self.report(end);
        self.files.report(&report);
        if self.instance.output.gltf {
            self.files.gltf(&frame, &self.instance.seams, &self.instance.textures);
        }
        if let Some(folder) = &args.dump
            && let Err(error) = dump::dump(folder, &mut self.instance, &frame, &self.last)
        {
            faults.push(error);
        }
        faults.extend(self.files.lasting_faults());
        let said = self.say(args, folder, &report);
        if let End::Failed(reason) = &report.end {
            faults.insert(0, reason.clone());
        }
        match (faults.is_empty(), report.end) {
            (false, _) => Err(Stop::Failed(faults.join("\nerror: "))),
            (true, End::Interrupted) => Err(Stop::Interrupted),
            (true, _) => said,
        }
    }

    /// Prints what was asked for.
    fn say(&self, args: &RunArgs, folder: &Path, report: &RunReport) -> Result<(), Stop> {
        if args.json {
            say(&serde_json::to_string_pretty(report).map_err(|error| Stop::Failed(error.to_string()))?)?;
        } else if !args.quiet {
            say(&summary(report))?;
            say(&format!("written to {}", folder.display()))?;
        }
        if args.timings {
            // With --json, standard output holds the report and nothing else.
            if args.json { complain(&self.timings.table()) } else { say(&self.timings.table())? }
        }
        Ok(())
    }

    /// Steps to the end.
    fn go(&mut self, progress: &Progress, is_resumed: bool) -> Result<End, Stop> {
        if !is_resumed {
            self.events();
            self.files.row(&self.last, true)?;
            self.frames(false);
        }
        while !self.instance.is_finished() {
            let before = Instant::now();
            let outcome = self.instance.advance().map(|_| ());
            self.stepping += before.elapsed();
            if let Err(error) = outcome {
                self.last = observe(&mut self.instance);
                self.events();
                return Ok(End::Failed(error.to_string()));
            }
            self.last = observe(&mut self.instance);
            let settings = self.instance.simulation.settings();
            // A static solve sets its own limit and is judged by its imbalance.
            let residual = match self.instance.run.mode {
                Mode::Dynamic => settings.advanced.linear.tolerance,
                Mode::Static => f64::INFINITY,
            };
            let tolerances = [residual, settings.position_tolerance];
            let report = self.instance.simulation.report();
            self.tally.add(report, &self.last, tolerances);
            self.timings.add(report);
            self.failures = if report.has_failed { self.failures + 1 } else { 0 };
            let advanced_before = self.tally.events.advanced;
            self.events();
            self.files.row(&self.last, false)?;
            // The step in which the tear begins to run is one to see.
            self.frames(advanced_before == 0 && self.tally.events.advanced > 0);
            progress.show(&self.last, self.stepping);
            if self.failures == MOST_FAILURES {
                return Ok(given_up(self.failures));
            }
            let is_interrupted = self.interrupt.is_asked() && !self.instance.is_finished();
            if is_interrupted || self.snapshots.every.is_some_and(|every| self.last.step.is_multiple_of(every)) {
                self.keep();
            }
            self.files.untold().iter().for_each(|fault| progress.complain(fault));
            if is_interrupted {
                return Ok(End::Interrupted);
            }
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

    /// Keeps the state to go on from. Where the files lag behind it, or it cannot be written, the one before stays.
    fn keep(&mut self) {
        let Snapshots { folder, scene, inputs, .. } = &self.snapshots;
        let Some(marks) = self.files.marks() else {
            let what = format!("no snapshot of step {}: rows of earlier steps wait to be written", self.last.step);
            return self.files.fault(checkpoint::NAME, what);
        };
        let kept = Checkpoint {
            version: OwnVersion,
            scene: *scene,
            snapshot: self.instance.simulation.snapshot(),
            progress: self.instance.progress(),
            tally: self.tally.clone(),
            courses: self.courses.clone(),
            accounts: self.accounts.clone(),
            marks,
            failures: self.failures,
            times: [self.stepping, self.start.elapsed()],
            inputs: inputs.clone(),
        };
        match kept.save(folder) {
            Ok(()) => self.files.mended(checkpoint::NAME),
            Err(error) => {
                let what = format!("cannot write {error}; make room, or choose another directory with --out");
                self.files.fault(checkpoint::NAME, what);
            }
        }
    }

    fn events(&mut self) {
        let events: Vec<_> = self.instance.simulation.drain_events().collect();
        for course in &mut self.courses {
            course.note(self.instance.simulation.world(), self.last.time, &events);
        }
        for event in &events {
            let body = report::body_name(&self.instance, event.body);
            self.tally.add_event(self.last.step, &body, &event.kind);
            self.files.event(self.last.step, &body, event);
            if let EventKind::Advanced { cost, .. } = event.kind {
                self.last.advances += 1;
                let Some(cost) = cost else { continue };
                let overshoot = self.last.overshoot.get_or_insert(cost.overshoot);
                *overshoot = overshoot.max(cost.overshoot);
            }
        }
        let Self { instance, files, last, accounts, .. } = self;
        for account in accounts {
            let index = instance.bodies.iter().position(|&body| body == account.body());
            let balance = index.and_then(|index| last.balances.get(index).copied().flatten());
            if let Some(span) = account.note(instance.simulation.world(), last.time, &events, balance) {
                let body = report::body_name(instance, account.body());
                files.event_line(&account::line(last.step, &body, &span));
            }
        }
        for &(body, count) in &instance.broken_springs {
            let body = report::body_name(instance, body);
            let line = serde_json::json!({ "step": last.step, "time_ms": last.time, "body": body, "kind": "springs_broke", "count": count });
            files.event_line(&line);
        }
    }

    fn frames(&mut self, is_special: bool) {
        if self.files.wants_frame(self.last.step, is_special) {
            let frame = self.frame();
            self.files.frame(&frame, self.last.step, self.tally.events.started, is_special);
            let report = self.report(End::Running);
            self.files.report(&report);
        }
    }

    /// The state now, numbered by the scene's steps: a static one may have taken several equilibria.
    fn frame(&mut self) -> Frame {
        let mut frame = Frame { step: self.last.step, ..self.instance.simulation.frame() };
        let output = &self.instance.output;
        for body in &mut frame.bodies {
            if !output.velocities {
                body.velocities.clear();
            }
            if !output.forces {
                body.forces.clear();
            }
        }
        frame
    }

    fn report(&mut self, end: End) -> RunReport {
        let Self { scene, overrides, instance, tally, timings, last, courses, accounts, start, stepping, .. } = self;
        let (elapsed, stepping) = (start.elapsed(), *stepping);
        let sources = Sources { scene, overrides, tally, timings, last, courses, accounts, elapsed, stepping, end };
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
pub(super) fn file_name(name: &str) -> String {
    let plain: String =
        name.chars().map(|c| if c.is_alphanumeric() || "-_".contains(c) { c } else { '_' }).take(60).collect();
    if plain.is_empty() { "scene".to_owned() } else { plain }
}
