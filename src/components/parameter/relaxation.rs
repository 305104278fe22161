//! Viscoelastic tissue.

use crate::components::BodyError;
use crate::components::check::{Check, Host, number};
use crate::math::Branch;
use crate::storage::MOST_BRANCHES;

/// Relaxation of the membrane's stress by a Prony series: generalised Maxwell branches in the axes of each triangle. The material's moduli are the
/// instantaneous ones, of which the parts of the branches fade away. A pre-stretch is that of tissue which has relaxed. Goes with the linear law;
/// bending stays elastic. *Parameter.*
///
/// ```
/// use rhexis::components::{Branch, Relaxation};
/// use rhexis::prelude::*;
///
/// let branches = vec![Branch { part: 0.5, time: 100.0 }];
/// let mesh = generate::grid(10.0, 10.0, 4, 4)?;
/// let sheet = Membrane::new("sheet", mesh, Material::allard_2009()).planar().with(Relaxation { branches });
/// let held = Hold::new("left", sheet.select(|p| p.x == 0.0));
/// let drawn = Hold::new("right", sheet.select(|p| p.x == 10.0)).moved(DVec3::X, Curve::constant(0.1));
/// let mut simulation = Simulation::new(Settings::default())?;
/// let body = simulation.spawn(sheet.hold(held).hold(drawn))?;
/// simulation.settle(0.0, 1e-9)?;
/// let at_once = simulation.reactions(body)?[1].1.x;
/// simulation.settle(1000.0, 1e-9)?;
/// let later = simulation.reactions(body)?[1].1.x;
/// assert!((later / at_once - 0.5).abs() < 1e-3);
/// # Ok::<(), rhexis::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Relaxation {
    /// Branches, up to four; their parts sum to less than 1.
    pub branches: Vec<Branch>,
}

impl Relaxation {
    /// Part of the instantaneous stiffness that stays for ever.
    pub fn lasting(&self) -> f64 {
        1.0 - self.branches.iter().map(|branch| branch.part).sum::<f64>()
    }
}

const NAME: &str = "Relaxation";
const PARTS: [&str; MOST_BRANCHES] = ["part of branch 1", "part of branch 2", "part of branch 3", "part of branch 4"];
const TIMES: [&str; MOST_BRANCHES] = ["time of branch 1", "time of branch 2", "time of branch 3", "time of branch 4"];

// Exponents of steps over such times are numbers.
const LEAST_TIME: f64 = 1e-100;
const MOST_TIME: f64 = 1e100;

impl Check for Relaxation {
    fn check(&self, _: &Host<'_>) -> Result<(), BodyError> {
        if self.branches.len() > MOST_BRANCHES {
            let what = "it has more than four branches: merge those of similar times";
            return Err(BodyError::Contradiction { component: NAME, what });
        }
        for ((branch, part), time) in self.branches.iter().zip(PARTS).zip(TIMES) {
            let is_part = branch.part > 0.0 && branch.part < 1.0;
            number(
                NAME,
                part,
                branch.part,
                (is_part, "it must be above 0 and below 1: leave a branch without a part out"),
            )?;
            let is_time = (LEAST_TIME..=MOST_TIME).contains(&branch.time);
            number(NAME, time, branch.time, (is_time, "it must be positive, from 1e-100 to 1e100 ms"))?;
        }
        let sum = 1.0 - self.lasting();
        let must = "it must be below 1, for a stiffness that lasts: lower the parts";
        number(NAME, "sum of the parts", sum, (self.lasting() > 0.0, must))
    }
}
