//! The player: a cursor that wanders, grasps what it points at, draws it along, lets go, and cuts now and then.

use super::{Result, Summary};
use glam::{DVec2, DVec3};
use rhexis::components::{Jaws, Pose, Slip};
use rhexis::simulation::{Grasp, Simulation};
use rhexis::storage::{BodyId, ForcepsId};

/// Where the camera stands \[mm\], and how far it sees.
const EYE: DVec3 = DVec3::new(0.0, 0.0, 120.0);
const FAR: f64 = 500.0;
/// How far the cursor strays \[mm\], and how far it goes in a frame.
const REACH: f64 = 25.0;
const PACE: f64 = 2.0;
/// How much nearer than it was what is grasped is drawn \[mm\].
const PULL: f64 = 15.0;

/// Chances per frame.
const GRASPS: f64 = 0.1;
const LETS_GO: f64 = 0.02;
const CUTS: f64 = 0.004;
const OTHERS: f64 = 0.004;

/// Random numbers in [0, 1) (Marsaglia's xorshift), the same on every machine.
struct Dice(u64);

impl Dice {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn hits(&mut self, chance: f64) -> bool {
        self.next() < chance
    }
}

pub struct Mouse {
    dice: Dice,
    forceps: ForcepsId,
    cursor: DVec2,
    /// Distance at which it grasped \[mm\]; `None` with an open hand.
    held_at: Option<f64>,
}

impl Mouse {
    pub fn new(simulation: &mut Simulation, seed: u64) -> Result<Self> {
        let jaws = Jaws { radius: 1.0, stiffness: Some(0.2), force_limit: Some(0.5), slip: Slip::LetGo };
        let forceps = simulation.spawn_forceps("mouse", jaws, Pose::at(DVec3::ZERO))?;
        let dice = Dice(0x9e37_79b9_7f4a_7c15 ^ seed.wrapping_mul(0xd1b5_4a32_d192_ed03) | 1);
        Ok(Self { dice, forceps, cursor: DVec2::ZERO, held_at: None })
    }

    /// One frame of input, which the next step of `dt` \[ms\] carries out.
    pub fn play(&mut self, simulation: &mut Simulation, body: BodyId, dt: f64, summary: &mut Summary) -> Result<()> {
        let step = DVec2::new(self.dice.next(), self.dice.next()) * 2.0 - 1.0;
        self.cursor = (self.cursor + step * PACE).clamp(DVec2::splat(-REACH), DVec2::splat(REACH));
        let ahead = (DVec3::new(self.cursor.x, self.cursor.y - 10.0, 25.0) - EYE).normalize();
        match self.held_at {
            None if self.dice.hits(GRASPS) => self.grasp(simulation, body, ahead, summary)?,
            Some(_) if self.dice.hits(LETS_GO) => {
                simulation.open_forceps(self.forceps)?;
                self.held_at = None;
                summary.count("let go");
            }
            _ => {}
        }
        if let Some(distance) = self.held_at {
            simulation.move_forceps(self.forceps, Pose::at(EYE + ahead * (distance - PULL)), dt)?;
        }
        if self.dice.hits(CUTS) {
            let aside = (ahead + DVec3::new(0.03, 0.01, 0.0)).normalize();
            let [from, to] = [ahead, aside].map(|way| simulation.cast_ray(body, EYE, way, FAR));
            if let (Some(from), Some(to)) = (from, to) {
                // A cut that would leave the tissue, or part what is too small, is refused; the game goes on.
                let is_cut = simulation.cut(body, &[from.rest_position, to.rest_position]).is_ok();
                summary.count(if is_cut { "cut" } else { "cut refused" });
            }
        }
        Ok(())
    }

    fn grasp(&mut self, simulation: &mut Simulation, body: BodyId, ahead: DVec3, summary: &mut Summary) -> Result<()> {
        let Some(hit) = simulation.cast_ray(body, EYE, ahead, FAR) else {
            summary.count("missed");
            return Ok(());
        };
        simulation.move_forceps(self.forceps, Pose::at(hit.position), 0.0)?;
        let grasp = Grasp::Ray { origin: EYE, direction: ahead, reach: FAR };
        // What is held by others already cannot be grasped.
        let is_closed = simulation.close_forceps(self.forceps, body, &grasp).is_ok();
        self.held_at = is_closed.then_some(hit.distance);
        summary.count(if is_closed { "grasped" } else { "grasp refused" });
        Ok(())
    }

    /// How far the hand is ahead of its jaws \[mm\]; `None` with an open hand.
    pub fn hand_ahead(&self, simulation: &Simulation) -> Result<Option<f64>> {
        Ok(self.held_at.map(|_| simulation.hand_ahead(self.forceps)).transpose()?)
    }

    /// Whether the player wants the second sheet to come or go.
    pub fn wants_another(&mut self) -> bool {
        self.dice.hits(OTHERS)
    }

    /// Learns from the simulation whether it still holds something: jaws slip, and a level that is loaded has its own.
    pub fn look_again(&mut self, simulation: &Simulation) -> Result<()> {
        let is_holding = simulation.forceps(self.forceps)?.body.is_some();
        self.held_at = is_holding.then(|| self.held_at.unwrap_or(100.0));
        Ok(())
    }
}
