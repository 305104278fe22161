//! A scene in a simulation, ready to run.

use super::build;
use super::changing::Changing;
use super::doctor::{self, MeshSummary};
use super::document::Parsed;
use super::error::{Fault, positive};
use super::probes::{self, Probe};
use super::schema::{BodySpec, Mode, OutputSpec, RunSpec};
use super::score::Scoring;
use super::seams::Seams;
use super::size::Demand;
use super::timed::{CutTold, Timed};
use super::{Scene, SceneError, beginning, breaking, copies, doubts, obstacle, settings};
use glam::DVec3;
use rhexis::components::{EnergyAudit, TearLog, Tearing, Toughness};
use rhexis::membrane::Membrane;
use rhexis::report::Report;
use rhexis::settings::Integrator;
use rhexis::simulation::{Doubt, SetError, Simulation, SimulationError};
use rhexis::snapshot::{Snapshot, SnapshotError};
use rhexis::storage::{BodyId, Tips, Topology, Triangles};
use std::sync::Arc;

/// The most steps of a run: a day's computing at 0.1 ms each.
pub const MOST_STEPS: u64 = 1_000_000_000;

/// A scene in a simulation.
pub struct Instance {
    /// The simulation, with all bodies and obstacles and the starting cuts made.
    pub simulation: Simulation,
    /// The bodies in the order of the file.
    pub bodies: Vec<BodyId>,
    /// The bytes of each body's texture, PNG or JPEG, for those that have one.
    pub textures: Vec<Option<Arc<Vec<u8>>>>,
    /// The seams of each body's texture, for those that have any.
    pub seams: Vec<Option<Arc<Seams>>>,
    /// What the mesh of each was like before it was cut.
    pub meshes: Vec<MeshSummary>,
    /// Probes of the scene, read after every step.
    pub probes: Vec<Probe>,
    /// Names of the obstacles, in the order of the file and of spawning.
    pub obstacles: Vec<String>,
    /// Likely slips of the scene, but for those that it allows.
    pub doubts: Vec<Doubt>,
    /// Contacts that could be and that the scene does not ask for, each with its remedy.
    pub not_felt: Vec<String>,
    /// Notes on obstacles: meshes narrower than the tissue's edges, which it may not feel, and those taken in metres.
    pub obstacle_notes: Vec<String>,
    /// How to run it.
    pub run: Run,
    /// What to write of it.
    pub output: OutputSpec,
    /// How courses of tears are scored, where the scene asks for it.
    pub scoring: Option<Scoring>,
    /// Cuts that were made so far, as the scene asked for them; in a resumed run, since it was resumed.
    pub cuts: Vec<CutTold>,
    /// Springs that broke in the last step, by body.
    pub broken_springs: Vec<(BodyId, usize)>,
    breaking: Vec<(BodyId, f64)>,
    timed: Timed,
    changing: Vec<(BodyId, Changing)>,
    step: u64,
    has_torn: bool,
}

/// How a scene is run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Run {
    /// Steps or equilibria.
    pub mode: Mode,
    /// Time step \[ms\].
    pub dt: f64,
    /// Number of steps at the most.
    pub steps: u64,
    /// Whether the run ends once a tear has begun and no tip is left.
    pub until_torn: bool,
    /// Whether the run ends once a tear has ended or a piece is free.
    pub until_ended: bool,
    /// Where a static solve ends, as a fraction of the largest corner force.
    pub static_tolerance: f64,
    /// How often tearing and equilibrium may alternate within one static step.
    pub static_advances: u32,
}

impl Scene {
    /// Builds the simulation.
    ///
    /// # Errors
    /// For a number out of its range, a refused mesh or material, a region that selects nothing, contradictory holds and a missing
    /// file. The error names the place in the text.
    pub fn instantiate(&self) -> Result<Instance, SceneError> {
        self.build().map_err(|fault| {
            let error = self.document.locate(&self.spans, fault);
            self.document.blame(error, |document| {
                let Parsed { file, spans, tables } = document.parse()?;
                let scene = Self { file, document, spans, tables };
                scene.build().map(|_| ()).map_err(|fault| scene.document.locate(&scene.spans, fault))
            })
        })
    }

    fn build(&self) -> Result<Instance, Fault> {
        let run = run(&self.file.run)?;
        if self.file.bodies.is_empty() {
            return Err(Fault::new("bodies", "there is no body", "add a [[bodies]] table"));
        }
        let settings = settings::of_run(&self.file.run)?;
        let output = output(&self.file.output, run)?;
        if self.file.output.energy
            && self.file.run.mode == Mode::Dynamic
            && settings.advanced.integrator != Integrator::BackwardEuler
        {
            let what = "the balance of energy is that of backward Euler";
            let hint = "leave it out, or give advanced.integrator = \"backward_euler\" in [run]";
            return Err(Fault::new("output.energy", what, hint));
        }
        let refused = |error| Fault::new("run.threads", error, "use fewer threads");
        let mut simulation = Simulation::new(settings).map_err(refused)?;
        let (mut bodies, mut meshes) = (Vec::new(), Vec::new());
        let (mut cuts, mut timed) = (Vec::new(), Timed::default());
        let specs = &self.file.bodies;
        // Before anything of that size is made.
        Demand::announced(specs)?.files(&output, run.steps)?;
        copies::check_names(specs)?;
        let (mut demand, files) = (Demand::default(), self.document.files());
        let scoring = output.scoring.as_deref().map(|scoring| Scoring::open(scoring, &files, "output.scoring"));
        let scoring = scoring.transpose()?;
        let (mut textures, mut seams, mut names) = (Vec::new(), Vec::new(), Vec::new());
        let (mut breaking, mut all_changing) = (Vec::new(), Vec::new());
        for (i, spec) in specs.iter().enumerate() {
            let key = &format!("bodies.{i}");
            let sheet = build::sheet(spec, &files, key)?;
            demand.add(spec, key, sheet.file.mesh.triangles.len() as f64)?;
            demand.files(&output, run.steps)?;
            let mesh = doctor::look(spec, &sheet.file, sheet.flattened);
            let texture = super::texture::read(spec, &sheet.file, &files, key)?;
            let limit = breaking::limit(spec, key)?;
            let changing = Changing::of(spec, key)?;
            let own_seams = Seams::of(&sheet.file).map(Arc::new);
            for name in copies::names(spec) {
                seams.push(own_seams.clone());
                textures.push(texture.clone());
                let membrane = build::membrane(spec, &name, &sheet, key)?;
                let body = self.spawn(&mut simulation, membrane, spec, key)?;
                for (i, cut) in spec.cuts.iter().enumerate().filter(|(_, cut)| cut.at.is_none()) {
                    let made = beginning::cut(&mut simulation, body, cut, &format!("{key}.cuts.{i}"))?;
                    cuts.push(CutTold::new(&name, format!("cuts.{i}"), 0.0, &Ok(made)));
                }
                timed.add(&mut simulation, (body, &name), spec, run.dt, key)?;
                breaking.extend(limit.map(|limit| (body, limit)));
                all_changing.extend(changing.clone().map(|changing| (body, changing)));
                bodies.push(body);
                names.push(name);
                meshes.push(mesh.clone());
            }
        }
        let (obstacles, widths) = obstacle::spawn(&mut simulation, &self.file.obstacles, run, &files)?;
        let felt = bodies.iter().copied().zip(&meshes);
        let mut obstacle_notes = obstacle::narrow(&simulation, (&obstacles, &widths), felt);
        obstacle_notes.extend(obstacle::in_metres(&self.file.obstacles, &obstacles));
        cuts.extend(timed.too_late(run.steps, run.dt * run.steps as f64));
        Ok(Instance {
            not_felt: doubts::not_felt(&simulation, &bodies),
            doubts: doubts::of(&simulation, run, &self.file.scene.allow)?,
            simulation,
            probes: probes::of(&self.file.probes, &bodies, &names)?,
            bodies,
            textures,
            seams,
            meshes,
            obstacles,
            obstacle_notes,
            run,
            output,
            scoring,
            cuts,
            broken_springs: Vec::new(),
            breaking,
            timed,
            changing: all_changing,
            step: 0,
            has_torn: false,
        })
    }

    fn spawn(
        &self,
        simulation: &mut Simulation,
        membrane: Membrane,
        spec: &BodySpec,
        key: &str,
    ) -> Result<BodyId, Fault> {
        let body = simulation.spawn(membrane).map_err(|error| build::refused_body(spec, key, &error.source))?;
        if self.file.output.energy {
            // The body was spawned just now.
            let _ = simulation.world_mut().insert_one(body.entity(), EnergyAudit::default());
        }
        if let Some(initial) = &spec.initial {
            beginning::start(simulation, body, initial, spec.planar, &format!("{key}.initial"))?;
        }
        Ok(body)
    }
}

/// The output with numbers of pictures and frames for the times between them.
fn output(spec: &OutputSpec, run: Run) -> Result<OutputSpec, Fault> {
    let duration = run.dt * run.steps as f64;
    let count = |name: &str, every: Option<f64>, count: u32| {
        let Some(every) = every else { return Ok(count) };
        let every = positive(format!("output.{name}"), every, "ms")?;
        Ok((duration / every).floor().min(f64::from(u32::MAX - 1)) as u32 + 1)
    };
    Ok(OutputSpec {
        pictures: count("pictures_every", spec.pictures_every, spec.pictures)?,
        frames: count("frames_every", spec.frames_every, spec.frames)?,
        ..spec.clone()
    })
}

impl Instance {
    /// Does one step as the scene says.
    ///
    /// # Errors
    /// In static mode where no equilibrium is found; the last good state stands.
    pub fn advance(&mut self) -> Result<&Report, SimulationError> {
        self.timed.before(&mut self.simulation, self.step, &mut self.cuts);
        let start = self.simulation.time();
        for (body, changing) in &self.changing {
            changing.before(&mut self.simulation, *body, (start, start + self.run.dt)).map_err(
                |error| match error {
                    SetError::Rejected(rejected) => SimulationError::Written(rejected),
                    _ => SimulationError::NoSuchBody,
                },
            )?;
        }
        self.has_torn |= self.tip_count() > 0;
        match self.run.mode {
            Mode::Dynamic => self.simulation.step(self.run.dt)?,
            Mode::Static => {
                let Run { dt, static_tolerance, static_advances, .. } = self.run;
                self.simulation.settle_and_tear(dt, static_tolerance, static_advances)?
            }
        };
        self.step += 1;
        let Self { simulation, breaking, broken_springs, .. } = self;
        broken_springs.clear();
        let broken = breaking.iter().map(|&(body, limit)| (body, breaking::part(simulation, body, limit)));
        broken_springs.extend(broken.filter(|(_, count)| *count > 0));
        Ok(self.simulation.report())
    }

    /// Whether all steps are done, or the tear is through where the scene asks to stop there.
    pub fn is_finished(&self) -> bool {
        let is_torn = self.run.until_torn && self.has_torn && self.tip_count() == 0;
        is_torn || self.run.until_ended && self.has_ended() || self.step >= self.run.steps
    }

    fn has_ended(&self) -> bool {
        let world = self.simulation.world();
        let log = |&body: &BodyId| world.get::<&TearLog>(body.entity()).is_ok_and(|log| log.end_count > 0);
        self.bodies.iter().any(log)
    }

    /// How far the scene has come, beside the state of its simulation: steps done, and whether a tear has begun.
    pub fn progress(&self) -> (u64, bool) {
        (self.step, self.has_torn)
    }

    /// Goes on from a snapshot of the same scene's simulation, and from its [`progress`](Self::progress) then.
    ///
    /// # Errors
    /// As [`Simulation::restore`].
    pub fn resume(&mut self, snapshot: &Snapshot, (step, has_torn): (u64, bool)) -> Result<(), SnapshotError> {
        self.simulation.restore(snapshot)?;
        self.bodies = self.simulation.bodies();
        (self.step, self.has_torn) = (step, has_torn);
        Ok(())
    }

    /// Steps of the scene done; a static one may have taken several equilibria.
    pub fn step(&self) -> u64 {
        self.step
    }

    /// The force \[N\] of every obstacle on the bodies in the last step, friction included, in the order of the file.
    pub fn obstacle_forces(&self) -> Vec<(String, DVec3)> {
        let obstacles = self.simulation.obstacles();
        let mut forces: Vec<(String, DVec3)> = self.obstacles.iter().map(|name| (name.clone(), DVec3::ZERO)).collect();
        for &body in &self.bodies {
            for (obstacle, force) in self.simulation.contact_forces(body).unwrap_or_default() {
                let place = obstacles.iter().position(|other| *other == obstacle);
                if let Some((_, sum)) = place.and_then(|place| forces.get_mut(place)) {
                    *sum += force;
                }
            }
        }
        forces
    }

    /// Centre of mass \[mm\] and velocity \[mm/ms\] of every rigid obstacle, in the order of the file.
    pub fn rigid_obstacles(&self) -> Vec<(String, [DVec3; 2])> {
        let named = self.obstacles.iter().zip(self.simulation.obstacles());
        let rigid = named.filter_map(|(name, obstacle)| Some((name, self.simulation.rigid(obstacle).ok()??)));
        rigid.map(|(name, rigid)| (name.clone(), [rigid.centre, rigid.velocity])).collect()
    }

    /// Tear tips that are alive, of all bodies.
    pub fn tip_count(&self) -> usize {
        let tips = |&body: &BodyId| self.simulation.world().get::<&Tips>(body.entity()).map_or(0, |tips| tips.len());
        self.bodies.iter().map(tips).sum()
    }
}

fn run(spec: &RunSpec) -> Result<Run, Fault> {
    let dt = positive("run.dt".to_owned(), spec.dt, "ms")?;
    let steps = match (spec.steps, spec.duration) {
        (Some(steps), None) => steps,
        // The relative 1e-9 keeps a duration that is a multiple of dt from gaining a step by rounding.
        (None, Some(duration)) => {
            (positive("run.duration".to_owned(), duration, "ms")? / dt * (1.0 - 1e-9)).ceil().max(1.0) as u64
        }
        _ => {
            let what = "the length of the run is given twice or not at all";
            return Err(Fault::new("run", what, "give either `steps` or `duration` [ms]"));
        }
    };
    if steps > MOST_STEPS {
        let key = if spec.steps.is_some() { "run.steps" } else { "run.duration" };
        let what = format!("that would be more than {MOST_STEPS} steps");
        return Err(Fault::new(key, what, "give fewer steps, a shorter duration or a larger dt"));
    }
    let static_tolerance = positive("run.advanced.static_tolerance".to_owned(), spec.advanced.static_tolerance, "")?;
    Ok(Run {
        mode: spec.mode,
        dt,
        steps,
        until_torn: spec.until_torn,
        until_ended: spec.until_ended,
        static_tolerance,
        static_advances: spec.advanced.static_advances,
    })
}

/// The thresholds of a body and the toughness that they imply by the law at its first tip, or at its first triangle.
pub fn thresholds(simulation: &Simulation, body: BodyId) -> Option<(Tearing, Toughness)> {
    let mut query = simulation.world().query_one::<(&Tearing, &Tips, &Topology, &Triangles)>(body.entity());
    let (tearing, tips, topology, triangles) = query.get().ok()?;
    let at_tip = tips.vertex.first().and_then(|&tip| topology.incident[tip as usize].first());
    let law = triangles.stiffness.get(at_tip.map_or(0, |&entry| entry as usize / 3))?;
    Some((*tearing, tearing.toughness(law)))
}
