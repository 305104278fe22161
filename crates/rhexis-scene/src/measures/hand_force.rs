//! The force at a hand while a tear goes on: at every step, beside the force before its advances.
//!
//! An advance by a whole triangle lets the force fall, so that the mean over the steps may be far below the force at which the tear is
//! decided. The steps counted are those after the first advance up to the last, of one grasp where jaws close several times.

use glam::DVec3;

/// Force of a hold or of jaws, step by step.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct HandForce {
    /// Force at the end of the last step \[N\]; `None` where nothing was held.
    last: Option<DVec3>,
    /// Whether a tip has advanced during the grasp.
    has_advanced: bool,
    /// Forces of the steps since the last advance \[N\].
    pending: Vec<f64>,
    /// Largest change over one of these steps \[N\].
    pending_jump: f64,
    /// Forces of the steps up to the last advance \[N\].
    forces: Vec<f64>,
    /// Largest change over one of these steps \[N\].
    jump: f64,
    /// Sum of the forces before advances \[N\], and their number.
    before: (f64, u32),
}

/// Amount of the force over the steps of a tear, after the first advance up to the last.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct HandForceFigures {
    /// Number of steps.
    pub steps: usize,
    /// Mean \[N\].
    pub mean: f64,
    /// Quantiles of 10 and 90 % \[N\].
    pub range: [f64; 2],
    /// Largest change of the force, as a vector, from one step to the next \[N\].
    pub largest_jump: f64,
    /// Mean force at the end of the step before each advance \[N\]: the tear is decided at it.
    pub before_advances: f64,
}

impl HandForce {
    /// Takes in the force at the end of a step \[N\], `None` where nothing is held, and whether a tip has advanced in it.
    pub fn note(&mut self, force: Option<DVec3>, has_advanced: bool) {
        let before = std::mem::replace(&mut self.last, force);
        let Some(force) = force else {
            self.has_advanced = false;
            return self.forget();
        };
        if let Some(before) = before.filter(|_| self.has_advanced) {
            self.pending.push(force.length());
            self.pending_jump = self.pending_jump.max(force.distance(before));
            if has_advanced {
                self.forces.append(&mut self.pending);
                self.jump = self.jump.max(self.pending_jump);
                self.before = (self.before.0 + before.length(), self.before.1 + 1);
            }
        }
        if has_advanced {
            self.has_advanced = true;
            self.forget();
        }
    }

    /// The figures up to now; `None` where nothing was held from one advance to another.
    pub fn figures(&self) -> Option<HandForceFigures> {
        let mut sorted = self.forces.clone();
        sorted.sort_by(f64::total_cmp);
        Some(HandForceFigures {
            steps: sorted.len(),
            mean: sorted.iter().sum::<f64>() / sorted.len() as f64,
            range: [quantile(&sorted, 0.1)?, quantile(&sorted, 0.9)?],
            largest_jump: self.jump,
            before_advances: self.before.0 / f64::from(self.before.1),
        })
    }

    fn forget(&mut self) {
        self.pending.clear();
        self.pending_jump = 0.0;
    }
}

/// Quantile of sorted values, one of them; `None` without values.
fn quantile(sorted: &[f64], part: f64) -> Option<f64> {
    let place = (part * sorted.len().saturating_sub(1) as f64).round() as usize;
    sorted.get(place).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Force along an axis \[N\] and whether a tip has advanced, step by step; NaN where nothing is held.
    fn felt(steps: &[(f64, bool)]) -> Option<HandForceFigures> {
        let mut hand = HandForce::default();
        for &(force, has_advanced) in steps {
            hand.note((!force.is_nan()).then_some(DVec3::new(0.0, force, 0.0)), has_advanced);
        }
        hand.figures()
    }

    #[test]
    fn the_steps_counted_are_those_after_the_first_advance_up_to_the_last() {
        let saw = [(2.0, false), (9.0, false), (1.0, true), (5.0, false), (9.0, false), (1.0, true), (7.0, false)];
        let figures = felt(&saw).unwrap();
        assert_eq!((figures.steps, figures.mean, figures.range), (3, 5.0, [1.0, 9.0]));
        // The force falls from 9 to 1; it rose to 9 before the first advance, too, which is not counted.
        assert_eq!((figures.largest_jump, figures.before_advances), (8.0, 9.0));
    }

    #[test]
    fn a_change_between_two_grasps_is_no_jump() {
        let open = (f64::NAN, true);
        let grasps = [(3.0, true), (4.0, true), (30.0, false), open, (50.0, true), (52.0, false), (51.0, true)];
        let figures = felt(&grasps).unwrap();
        assert_eq!((figures.steps, figures.largest_jump), (3, 2.0));
        assert!((figures.mean - (4.0 + 52.0 + 51.0) / 3.0).abs() < 1e-12);
        assert!((figures.before_advances - (3.0 + 52.0) / 2.0).abs() < 1e-12);
    }

    #[test]
    fn without_two_advances_while_held_there_are_no_figures() {
        assert_eq!(felt(&[]), None);
        assert_eq!(felt(&[(1.0, false), (2.0, false)]), None);
        assert_eq!(felt(&[(1.0, false), (2.0, true), (3.0, false)]), None);
        assert_eq!(felt(&[(1.0, true), (f64::NAN, false), (3.0, true)]), None);
    }

    #[test]
    fn a_jump_is_that_of_the_vector_and_quantiles_are_values_of_the_list() {
        let mut hand = HandForce::default();
        hand.note(Some(DVec3::X), true);
        hand.note(Some(DVec3::Y), true);
        let figures = hand.figures().unwrap();
        assert!((figures.largest_jump - 2.0_f64.sqrt()).abs() < 1e-15 && figures.mean == 1.0);
        let ten: Vec<f64> = (0..=10).map(f64::from).collect();
        assert_eq!([0.1, 0.5, 0.9].map(|part| quantile(&ten, part)), [Some(1.0), Some(5.0), Some(9.0)]);
        assert_eq!(quantile(&[], 0.5), None);
    }
}
