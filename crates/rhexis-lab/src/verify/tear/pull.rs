//! A sheet about the origin drawn apart along x between grips that move little by little, in equilibria, until it tears.

use super::super::bodies;
use super::super::{Line, VerifyError};
use glam::{DVec2, DVec3};
use rhexis::components::Curve;
use rhexis::event::EventKind;
use rhexis::membrane::Membrane;
use rhexis::settings::{Advanced, Preconditioner, Settings};
use rhexis::simulation::Simulation;
use rhexis::storage::{BodyId, TipKey};

/// Displacement of either grip at the end of its curve \[mm\]; a time of 1 ms is one of 1 mm.
const MOST: f64 = 100.0;
/// Of the equilibria.
const TOLERANCE: f64 = 1e-9;

/// The sheet.
pub(super) struct Pulled {
    simulation: Simulation,
    body: BodyId,
    time: f64,
}

/// One start with the way of its tip, in the rest shape \[mm\].
#[derive(Clone, Debug, Default)]
pub(super) struct Start {
    /// From the first place of the tip on.
    pub path: Vec<DVec2>,
    tip: TipKey,
}

/// What has come of it.
#[derive(Clone, Debug, Default)]
pub(super) struct Torn {
    /// Force of a grip \[N\] in the equilibrium at which the first tear started.
    pub force: f64,
    /// Tips by starts, in order.
    pub starts: Vec<Start>,
    /// Pieces that came free.
    pub pieces: u32,
}

impl Torn {
    /// The tears as lines of a picture.
    pub(super) fn lines(&self, name: &str) -> Vec<Line> {
        self.starts.iter().map(|start| Line { name: name.to_owned(), points: start.path.clone() }).collect()
    }
}

impl Pulled {
    /// Grips at x = ±`half` \[mm\].
    pub(super) fn new(sheet: Membrane, half: f64) -> Result<Self, VerifyError> {
        let grip = |name: &str, side: f64| {
            let curve = Curve::ramp(MOST, MOST).unwrap_or_else(|_| Curve::constant(0.0));
            let is_held = move |p: DVec3| (p.x * side > half - 1e-9).then_some(DVec3::X * side);
            bodies::hold_along(&sheet, name, [true; 3], curve, is_held)
        };
        let (left, right) = (grip("left", -1.0), grip("right", 1.0));
        let settings = Settings {
            threads: 1,
            advanced: Advanced { preconditioner: Preconditioner::Cholesky, ..Advanced::default() },
            ..Settings::default()
        };
        let (simulation, body) = bodies::simulate(settings, sheet.hold(left).hold(right))?;
        Ok(Self { simulation, body, time: 0.0 })
    }

    /// The displacement of a grip \[mm\] at which it would have so much force \[N\], by that at a small one.
    pub(super) fn guess(&mut self, force: f64) -> Result<f64, VerifyError> {
        let small = 1e-2;
        self.go_to(small)?;
        Ok(small * force / self.force()?)
    }

    /// Draws on from one displacement in steps \[mm\] until a tear has started, then lets it go as far as it goes there in so many
    /// rounds. The displacement is at most three times the first.
    pub(super) fn until_torn(&mut self, from: f64, step: f64, rounds: u32) -> Result<Torn, VerifyError> {
        let mut torn = Torn::default();
        let mut to = from;
        while torn.starts.is_empty() && to < 3.0 * from.max(1e-9) + 100.0 * step {
            self.go_to(to)?;
            torn.force = self.force()?;
            self.simulation.settle_and_tear(0.0, TOLERANCE, rounds)?;
            for event in self.simulation.drain_events() {
                torn.note(&event.kind);
            }
            to += step;
        }
        Ok(torn)
    }

    fn go_to(&mut self, time: f64) -> Result<(), VerifyError> {
        self.simulation.settle(time - self.time, TOLERANCE)?;
        self.time = time;
        Ok(())
    }

    fn force(&self) -> Result<f64, VerifyError> {
        Ok(self.simulation.reactions(self.body)?.first().map_or(f64::NAN, |(_, force)| force.x.abs()))
    }
}

impl Torn {
    fn note(&mut self, kind: &EventKind) {
        match kind {
            EventKind::Started { tip, at, .. } => {
                self.starts.push(Start { path: vec![at.truncate()], tip: *tip });
            }
            EventKind::Advanced { tip, to, .. } => {
                let start = self.starts.iter_mut().find(|start| start.tip == *tip);
                start.into_iter().for_each(|start| start.path.push(to.truncate()));
            }
            EventKind::FragmentFreed { .. } => self.pieces += 1,
            _ => {}
        }
    }
}
