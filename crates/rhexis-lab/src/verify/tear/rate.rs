//! Speed of a tear under a dead load where the toughness grows with speed: a trouser whose legs carry F tears at v₀·(2F/(h·G_c) − 1)^(1/n), on
//! any mesh and at any step.

use super::super::{Artifacts, Axes, Line, Row, Rows, VerifyError, bodies};
use super::hand_force::{LENGTH, Mesh, PULL, TISSUE, is_in_hand, legs};
use super::trouser::Triangles;
use glam::{DVec2, DVec3};
use rhexis::components::{Curve, PointLoad, PointLoads, TearLog, TearRate};
use rhexis::membrane::Membrane;
use rhexis::settings::Settings;
use rhexis::simulation::SimulationError;

/// Load of a leg over that which tears at rest.
const LOAD: f64 = 1.5;
/// The load grows over the time in which a steady tear goes so far \[mm\].
const GROWTH: f64 = 0.5;
/// Length torn over which the speed is fitted \[mm\]: the legs hang, and the foot is far.
const STEADY: std::ops::Range<f64> = 9.0..13.0;
/// Tolerance of the speed. G on discs of two to four edges is off by 1 %, and v = v₀·(G/G_c − 1) by three times as much.
const SPEED: f64 = 0.04;

/// A law, a mesh and a step.
#[derive(Clone, Copy)]
struct Case {
    rate: TearRate,
    /// Edge of the triangles around the tip where they are refined \[mm\].
    refined: Option<f64>,
    /// \[ms\].
    dt: f64,
    /// Seed of the unstructured mesh.
    seed: u64,
}

const fn case(speed: f64, exponent: f64, refined: Option<f64>, dt: f64) -> Case {
    Case { rate: TearRate { speed, exponent }, refined, dt, seed: 8 }
}

const CASES: [Case; 8] = [
    case(0.02, 1.0, None, 10.0),
    case(0.02, 1.0, Some(0.35), 5.0),
    case(0.02, 1.0, None, 1.0),
    case(0.02, 2.0, None, 5.0),
    case(0.02, 0.5, Some(0.35), 5.0),
    case(0.002, 1.0, Some(0.35), 10.0),
    case(0.2, 1.0, None, 1.0),
    case(0.2, 1.0, Some(0.35), 1.0),
];

/// Seeds of further meshes for the first case: readings at a tip beside an edit differ from mesh to mesh.
const MESHES: std::ops::RangeInclusive<u64> = 9..=16;

pub(crate) fn run(out: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("tear-rate");
    let mut lines = Vec::new();
    let mut cases = if out.is_quick() { CASES[..2].to_vec() } else { CASES.to_vec() };
    if !out.is_quick() {
        cases.extend(MESHES.map(|seed| Case { seed, ..CASES[0] }));
    }
    for case in cases {
        let right = case.rate.speed * (LOAD - 1.0).powf(1.0 / case.rate.exponent);
        let course = case.tear(right)?;
        let over = slope(&course) / right;
        let TearRate { speed, exponent } = case.rate;
        let mesh = case.refined.map_or_else(|| "edges of 0.5 mm".to_owned(), |edge| format!("refined to {edge} mm"));
        let which = if case.seed == CASES[0].seed { String::new() } else { format!(", mesh {}", case.seed) };
        let what = format!("v₀ {speed} mm/ms, exponent {exponent}, {mesh}{which}, dt {} ms", case.dt);
        rows.ratio(format!("{what}: speed over the law's, {over:.3}, off 1"), (over - 1.0).abs(), SPEED);
        let points = course.iter().map(|point| DVec2::new(point.x * right, point.y)).collect();
        lines.push(Line { name: what, points });
    }
    let names = ["time times the law's speed [mm]", "length torn [mm]"];
    out.plot("tear-rate", Axes { title: "tears under a dead load", names, is_isometric: false }, &lines)?;
    rows.finish()
}

impl Case {
    /// Length torn \[mm\] against time \[ms\].
    fn tear(&self, speed: f64) -> Result<Vec<DVec2>, VerifyError> {
        let (mut simulation, body) =
            bodies::simulate(Settings { threads: 1, ..Settings::default() }, self.sheet(speed)?)?;
        simulation.cut(body, &legs())?;
        let mut course: Vec<DVec2> = Vec::new();
        // The foot is reached after less than the whole length at the law's speed.
        while simulation.time() * speed < LENGTH && course.last().is_none_or(|last| last.y < STEADY.end) {
            simulation.step(self.dt)?;
            let gone = || VerifyError::Simulation(SimulationError::NoSuchBody);
            let torn = simulation.world().get::<&TearLog>(body.entity()).map_err(|_| gone())?.length;
            course.push(DVec2::new(simulation.time(), torn));
        }
        Ok(course)
    }

    fn sheet(&self, speed: f64) -> Result<Membrane, VerifyError> {
        let edge = if self.refined.is_some() { 1.0 } else { 0.5 };
        let mesh =
            Mesh { name: "unstructured", triangles: Triangles::Unstructured(self.seed), edge, refined: self.refined };
        let sheet = mesh.sheet(TISSUE, Some(self.rate))?;
        let load = |side: f64| {
            let rows = sheet.select(|p| is_in_hand(p, side));
            let force = DVec3::Z * (-side * LOAD * PULL / rows.len() as f64);
            let curve = Curve::ramp(GROWTH / speed, 1.0).unwrap_or_else(|_| Curve::constant(1.0));
            PointLoad { rows, force, curve }
        };
        let groups = vec![load(-1.0), load(1.0)];
        let foot = bodies::hold(&sheet, "foot", |p| (p.y == 0.0).then_some(DVec3::ZERO));
        Ok(sheet.with(PointLoads { groups }).hold(foot))
    }
}

/// Slope of the line through the steady points by least squares \[mm/ms\].
fn slope(course: &[DVec2]) -> f64 {
    let steady: Vec<DVec2> = course.iter().copied().filter(|point| STEADY.contains(&point.y)).collect();
    let mean = steady.iter().copied().sum::<DVec2>() / steady.len() as f64;
    let sum = |term: fn(DVec2) -> f64| steady.iter().map(|&point| term(point - mean)).sum::<f64>();
    sum(|p| p.x * p.y) / sum(|p| p.x * p.x)
}
