//! A flap between two cuts, folded over and drawn ahead: F·((λ + 1)/2 − cos φ) = h·ΣG for its tips and the angle φ of the fold, which is
//! n·G_c·h where all of them tear at once. Tips take turns: while one tears the others are below, by as much as the last advance has
//! unloaded them.
//!
//! Without bending nothing asks for a narrower fold: the tears run straight ahead. With it a narrower flap gives back energy of its fold
//! and the tears converge (Hamm et al. 2008; Bayart et al. 2010) until it comes free as one piece.

use super::super::{Artifacts, Line, Row, Rows, VerifyError, bodies, largest};
use super::steady::{Step, judge_pull, median, steady, steady_steps};
use glam::{DVec2, DVec3};
use rhexis::components::{
    Bending, Curve, Damping, Drag, EnergyAudit, EnergyBalance, EnergyCriterion, Material, Refinement, TearMode,
    Tearing, Toughness,
};
use rhexis::event::EventKind;
use rhexis::membrane::Membrane;
use rhexis::settings::{Advanced, Preconditioner, Settings};
use rhexis::simulation::{Simulation, SimulationError};
use rhexis::storage::{BodyId, TipKey, Tips, Vertices};
use rhexis_scene::generate;
use std::f64::consts::PI;

/// Length and half the width of the sheet, whose other sides are held \[mm\].
const LENGTH: f64 = 26.0;
const HALF: f64 = 8.0;
/// Length of the cuts and half of what is between them \[mm\].
const CUT: f64 = 5.0;
const FLAP: f64 = 3.0;
/// Half of what the hand has hold of at the flap's end \[mm\]: little, so that the flap may turn towards the tip that is behind.
const HELD: f64 = 0.9;
const THICKNESS: f64 = 0.1;
/// Toughness \[N/mm\].
const TOUGHNESS: f64 = 0.05;
const EDGE: f64 = 0.35;
/// Way over: so many steps, its time \[ms\], and the height at its end \[mm\].
const TURNS: u32 = 32;
const OVER: f64 = 800.0;
const HEIGHT: f64 = 1.5;
/// Way ahead \[mm\] and its speed \[mm/ms\], twice that of the tears.
const AHEAD: f64 = 26.0;
const SPEED: f64 = 0.01;
/// Of the pull against what the tips release: what a disc of three edges leaves out of G, some 3 %, and the fold's damping.
const FORCE: f64 = 0.05;
/// Length of both tears after which the quick case ends \[mm\].
const QUICK: f64 = 5.0;
/// Long steps are taken where the criterion is below this.
const TAUT: f64 = 0.85;

/// A flap of one tissue.
struct Flap {
    name: &'static str,
    /// Young's modulus \[MPa\].
    young: f64,
    bends: bool,
    mode: TearMode,
    /// Time steps while it is taut and while it is slack \[ms\]; stiffer tissue gets its compliance from the fold.
    dt: [f64; 2],
}

const FLAPS: [Flap; 4] = [
    Flap { name: "without bending", young: 1.0, bends: false, mode: TearMode::Free, dt: [0.5, 4.0] },
    Flap { name: "with bending", young: 10.0, bends: true, mode: TearMode::Free, dt: [2.0, 8.0] },
    Flap { name: "without bending, tips glide", young: 1.0, bends: false, mode: TearMode::Glide, dt: [0.5, 4.0] },
    Flap { name: "with bending, tips glide", young: 10.0, bends: true, mode: TearMode::Glide, dt: [2.0, 8.0] },
];

/// The state before a step with an advance.
struct Pull {
    /// What the form takes from the pull, and what the tips release by the material force, over n·G_c·h.
    form: f64,
    release: f64,
    /// Work of the hand \[mJ\] and length torn \[mm\] until then.
    work: f64,
    torn: f64,
}

/// What the tears have shown.
#[derive(Default)]
struct Torn {
    pulls: Vec<Pull>,
    steps: Vec<Step>,
    balances: Vec<EnergyBalance>,
    /// Per tip, from the end of its cut on.
    paths: Vec<(TipKey, Vec<DVec2>)>,
    is_free: bool,
}

pub(crate) fn run(out: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("tear-flap");
    let mut lines = Vec::new();
    // The one that bends takes longer steps.
    let flaps = if out.is_quick() { &FLAPS[1..2] } else { &FLAPS[..] };
    for flap in flaps {
        let torn = flap.tear(if out.is_quick() { QUICK } else { f64::INFINITY })?;
        flap.judge(&mut rows, &torn, out.is_quick());
        for (number, (_, path)) in torn.paths.into_iter().enumerate() {
            lines.push(Line { name: format!("{}, tip {}", flap.name, number + 1), points: path });
        }
    }
    out.paths("tear-flap", "a flap folded over and drawn ahead: paths in the rest shape", &lines)?;
    rows.finish()
}

/// Where the hand is, over time \[ms, mm\]: over on a spiral about the fold, then ahead above the sheet.
fn course() -> Vec<(f64, DVec3)> {
    let over = (0..=TURNS).map(|i| {
        let part = f64::from(i) / f64::from(TURNS);
        let (sin, cos) = (PI * part).sin_cos();
        let reach = CUT * (1.0 - 0.2 * part);
        (OVER * part, DVec3::new(CUT - reach * cos, 0.0, (reach * sin).max(HEIGHT * part)))
    });
    let end = (OVER + AHEAD / SPEED, DVec3::new(CUT + 0.8 * CUT + AHEAD, 0.0, HEIGHT));
    over.chain([end]).collect()
}

/// Where the hand is at a time.
fn hand(time: f64) -> DVec3 {
    let course = course();
    let piece = course.windows(2).find(|piece| piece[1].0 >= time);
    piece.map_or(DVec3::ZERO, |piece| piece[0].1.lerp(piece[1].1, (time - piece[0].0) / (piece[1].0 - piece[0].0)))
}

fn is_held(p: DVec3) -> bool {
    p.x == 0.0 && p.y.abs() < HELD
}

impl Flap {
    fn sheet(&self) -> Result<Membrane, VerifyError> {
        let corners = [[0.0, -HALF], [LENGTH, -HALF], [LENGTH, HALF], [0.0, HALF]].map(DVec2::from);
        let mesh = generate::unstructured(&corners, 0.8, 2)?;
        let mut sheet = Membrane::new("sheet", mesh, Material::isotropic(self.young, 0.3, THICKNESS))
            .with(Damping { time: if self.bends { 0.1 } else { 0.5 } })
            .with(Drag { coefficient: 1e-6 })
            .with(Tearing { mode: self.mode, radius: 1.0, ..Tearing::default() })
            .with(EnergyAudit::default())
            .with(EnergyCriterion::new(Toughness { along: TOUGHNESS, across: TOUGHNESS }))
            .with(Refinement { edges_per_radius: 1.0 / EDGE, budget: 6.0, ..Refinement::default() });
        if self.bends {
            sheet = sheet.with(Bending::default());
        }
        let is_rim = |p: DVec3| p.x == LENGTH || p.y.abs() == HALF;
        let frame = bodies::hold(&sheet, "frame", |p| is_rim(p).then_some(DVec3::ZERO));
        sheet = sheet.hold(frame);
        for (name, axes, axis) in [("hand", [true, true, false], DVec3::X), ("height", [false, false, true], DVec3::Z)]
        {
            let points = course().into_iter().map(|(time, at)| (time, at.dot(axis))).collect();
            let curve = Curve::new(points).unwrap_or_else(|_| Curve::constant(0.0));
            let hold = bodies::hold_along(&sheet, name, axes, curve, |p| is_held(p).then_some(axis));
            sheet = sheet.hold(hold);
        }
        Ok(sheet)
    }

    fn tear(&self, most: f64) -> Result<Torn, VerifyError> {
        let settings = Settings {
            threads: 1,
            advanced: Advanced { preconditioner: Preconditioner::Cholesky, ..Advanced::default() },
            ..Settings::default()
        };
        let (mut simulation, body) = bodies::simulate(settings, self.sheet()?)?;
        let mut torn = Torn::default();
        for y in [-FLAP, FLAP] {
            let cut = simulation.cut(body, &[DVec3::new(0.0, y, 0.0), DVec3::new(CUT, y, 0.0)])?;
            torn.paths.extend(cut.tips.iter().map(|tip| (*tip, vec![DVec2::new(CUT, y)])));
        }
        let (mut work, mut length) = (0.0, 0.0);
        let (mut before, mut state) = (DVec3::ZERO, [0.0; 2]);
        while simulation.time() < OVER + AHEAD / SPEED && !torn.is_free && length < most {
            let criterion = simulation
                .world()
                .get::<&Tips>(body.entity())
                .map_or(0.0, |tips| largest(tips.criterion.iter().copied()));
            let dt = self.dt[usize::from(criterion < TAUT)];
            simulation.step(dt)?;
            let pull = Pull { form: state[0], release: state[1], work, torn: length };
            let mut has_advanced = false;
            for event in simulation.drain_events() {
                match event.kind {
                    EventKind::Advanced { tip, from, to, .. } => {
                        has_advanced = true;
                        length += from.distance(to);
                        if let Some((_, path)) = torn.paths.iter_mut().find(|(key, _)| *key == tip) {
                            path.push(to.truncate());
                        }
                    }
                    EventKind::FragmentFreed { .. } => torn.is_free = true,
                    _ => {}
                }
            }
            if has_advanced {
                torn.pulls.push(pull);
            }
            let force = bodies::reaction(&simulation, body, "hand")? + bodies::reaction(&simulation, body, "height")?;
            work += 0.5 * (before + force).dot(hand(simulation.time()) - hand(simulation.time() - dt));
            before = force;
            let [tips, released] = tips_and_release(&simulation, body)?;
            let own = tips - hand(simulation.time());
            // The flap at rest goes from its tips against x; the fold turns that by φ.
            let cosine = own.x / own.length();
            let pull = force.length();
            let stretch = 1.0 + pull / (self.young * THICKNESS * 2.0 * FLAP);
            let all = 2.0 * TOUGHNESS;
            state = [pull * (0.5 * (stretch + 1.0) - cosine) / (all * THICKNESS), released.x / all];
            torn.steps.push(Step { torn: length, has_advanced, pull: state[0] });
            torn.balances.push(simulation.energy_balance(body)?.unwrap_or_default());
        }
        Ok(torn)
    }

    fn judge(&self, rows: &mut Rows, torn: &Torn, is_quick: bool) {
        let what = |text: &str| format!("{}: {text}", self.name);
        let pulls = steady(&torn.pulls);
        let (Some(first), Some(last)) = (pulls.first(), pulls.last()) else {
            rows.ratio(what("does not tear"), f64::NAN, 0.0);
            return;
        };
        // The fold travels with tips that glide, and damping takes its part all the time; in free mode it waits for the next advance.
        let net = if self.mode == TearMode::Glide { 1.0 - torn.damped() } else { 1.0 };
        if self.mode == TearMode::Glide {
            rows.note(what("part of the work that damping takes"), torn.damped(), "1");
            let steps: Vec<Step> = torn.steps.iter().map(|step| Step { pull: net * step.pull, ..*step }).collect();
            judge_pull(rows, &what("without damping's part"), &steps, FORCE);
        }
        let off = (net * median(pulls.iter().map(|pull| pull.form / pull.release)) - 1.0).abs();
        let pull = what("pull before an advance against what both tips release, median");
        // The quick way is mostly that of coming taut.
        if is_quick && self.bends {
            rows.note(pull, off, "1");
        } else {
            rows.ratio(pull, off, FORCE);
        }
        rows.note(
            what("pull before an advance over that of two tips at once, median"),
            median(pulls.iter().map(|p| p.form)),
            "1",
        );
        rows.note(
            what("pull before an advance over that of two tips at once, most"),
            largest(pulls.iter().map(|p| p.form)),
            "1",
        );
        let area = (last.torn - first.torn) * THICKNESS;
        rows.note(
            what("work of the hand per area torn, over the toughness"),
            (last.work - first.work) / (area * TOUGHNESS),
            "1",
        );
        if !is_quick {
            let is_wrong = torn.is_free != self.bends;
            rows.ratio(
                what("comes free where it bends, and not where it does not"),
                f64::from(u8::from(is_wrong)),
                0.0,
            );
        }
        let ends = torn.paths.iter().filter_map(|(_, path)| Some((*path.first()?, *path.last()?)));
        let inwards = ends.map(|(from, to)| ((from.y.abs() - to.y.abs()) / (to.x - from.x)).atan().to_degrees());
        let inwards: Vec<f64> = inwards.collect();
        if self.bends {
            rows.note(what("tears turn inwards by"), median(inwards), "°");
        } else {
            // Two edges to either side over sixteen millimetres.
            let aside = |(_, path): &(TipKey, Vec<DVec2>)| largest(path.iter().map(|p| (p.y.abs() - FLAP).abs()));
            rows.add(what("off the line straight ahead"), largest(torn.paths.iter().map(aside)) / EDGE, 1.0, "edge");
        }
    }
}

impl Torn {
    /// Part of the work of the hands that damping takes, over the steady part.
    fn damped(&self) -> f64 {
        let steady = steady_steps(&self.steps);
        let last = steady.end.checked_sub(1).and_then(|last| self.balances.get(last));
        let Some((first, last)) = self.balances.get(steady.start).zip(last) else { return f64::NAN };
        let spent = last.since(first);
        spent.damping / spent.work()
    }
}

/// The middle of the tips now \[mm\], and the sum of the material forces at them \[N/mm\].
fn tips_and_release(simulation: &Simulation, body: BodyId) -> Result<[DVec3; 2], VerifyError> {
    let released = simulation.material_forces(body)?.iter().map(|tip| tip.force).sum();
    let mut query = simulation.world().query_one::<(&Vertices, &Tips)>(body.entity());
    let (vertices, tips) = query.get().map_err(|_| SimulationError::NoSuchBody)?;
    let middle = tips.vertex.iter().map(|&v| vertices.position[v as usize]).sum::<DVec3>() / tips.len() as f64;
    Ok([middle, released])
}
