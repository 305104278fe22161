//! The course of one case, and how it is judged.

use super::{Case, sheet};
use crate::bench::BenchError;
use glam::DVec3;
use rhexis::simulation::Simulation;
use rhexis::storage::{BodyId, Triangles, Vertices};

/// What a body may gain for its course to count as stable, over what is in it. No step of a sound method makes energy; what the linearised
/// turn of a step makes is bounded by the engine at a tenth, and this is a tenth of that.
const GAIN: f64 = 0.01;

/// What the engine itself promises: a tenth of what is in the body, of which a tenth is there again.
const PROMISED: f64 = 0.112;

/// The strain whose energy counts as being in a body, as in `systems/guard/mod.rs`.
const SLACK: f64 = 0.01;

/// How a course went, from good to bad.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Grade {
    /// Finite, at no time more than 1 % of energy made from nothing, every step as it was asked for.
    Stable,
    /// The same, but some steps were undone and retried in halves.
    Retried,
    /// Within the engine's promise, a tenth of energy made from nothing, or a body was step-limited lest it make more.
    HeldBack,
    /// More energy than that, a step that failed, or a number that is not finite.
    Unstable,
}

impl Grade {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Stable, Self::Retried, Self::HeldBack, Self::Unstable];

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Stable => "stable",
            Self::Retried => "retried",
            Self::HeldBack => "held back",
            Self::Unstable => "unstable",
        }
    }

    /// Its sign on the printed map.
    pub const fn sign(self) -> char {
        match self {
            Self::Stable => '.',
            Self::Retried => 'r',
            Self::HeldBack => 'h',
            Self::Unstable => 'X',
        }
    }
}

/// What a case came to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Course {
    /// Steps done; the course of an unstable case ends where it is lost.
    pub steps: u64,
    /// Steps of which a part was undone and retried.
    pub retried: u64,
    /// Steps in whose end the body went only a part of its way.
    pub held_back: u64,
    /// Steps that failed.
    pub failed: u64,
    /// Whether energies and positions stayed finite.
    pub is_finite: bool,
    /// The largest energy above that at the start, over that and what a strain of 1 % would store.
    pub largest_gain: f64,
    /// Energy at the end over that at the start; NaN where there was none.
    pub energy_left: f64,
    /// Angular momentum about x at the end over that at the start; NaN without rotation.
    pub spin_left: f64,
}

impl Course {
    /// How it went.
    pub fn grade(&self) -> Grade {
        if !self.is_finite || self.failed > 0 || !(self.largest_gain <= PROMISED) {
            Grade::Unstable
        } else if self.held_back > 0 || self.largest_gain > GAIN {
            Grade::HeldBack
        } else if self.retried > 0 {
            Grade::Retried
        } else {
            Grade::Stable
        }
    }
}

/// Runs a case.
pub(super) fn run(case: &Case, steps: u64) -> Result<Course, BenchError> {
    let (mut simulation, body) = sheet::simulation(case)?;
    let start = energy(&mut simulation, body)?;
    let scale = start + slack(&simulation, body);
    let spin = angular_momentum(&simulation, body);
    let mut course = Course { is_finite: true, ..Course::default() };
    let mut now = start;
    while course.steps < steps && course.grade() != Grade::Unstable {
        let report = simulation.step(case.dt)?;
        course.steps += 1;
        course.retried += u64::from(report.rolled_back > 0);
        course.held_back += u64::from(report.bodies.iter().any(|body| body.is_step_limited));
        course.failed += u64::from(report.has_failed);
        now = energy(&mut simulation, body)?;
        course.is_finite = now.is_finite();
        course.largest_gain = course.largest_gain.max((now - start) / scale);
    }
    course.energy_left = if start > 0.0 { now / start } else { f64::NAN };
    course.spin_left = if case.spin == 0.0 { f64::NAN } else { angular_momentum(&simulation, body) / spin };
    Ok(course)
}

/// Stored and of motion \[mJ\].
fn energy(simulation: &mut Simulation, body: BodyId) -> Result<f64, BenchError> {
    let energies = simulation.energies(body)?;
    Ok(energies.elastic + energies.kinetic)
}

/// What the body would store at the strain [`SLACK`] \[mJ\].
fn slack(simulation: &Simulation, body: BodyId) -> f64 {
    let Ok(triangles) = simulation.world().get::<&Triangles>(body.entity()) else { return 0.0 };
    let of = |t: usize| {
        let law = &triangles.stiffness[t];
        0.5 * triangles.rest[t].area * triangles.thickness[t] * (law.q11 + law.q22) * (SLACK * SLACK)
    };
    (0..triangles.len()).map(of).sum()
}

/// About x through the centre of mass \[g·mm²/ms\].
fn angular_momentum(simulation: &Simulation, body: BodyId) -> f64 {
    let Ok(vertices) = simulation.world().get::<&Vertices>(body.entity()) else { return f64::NAN };
    let rows = || vertices.position.iter().zip(&vertices.velocity).zip(&vertices.mass);
    let mass: f64 = vertices.mass.iter().sum();
    let centre = rows().map(|((x, _), m)| *x * *m).sum::<DVec3>() / mass;
    rows().map(|((x, v), m)| (*x - centre).cross(*v).x * m).sum()
}
