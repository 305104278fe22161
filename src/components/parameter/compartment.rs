//! A closed volume under a body.

use crate::components::check::{Check, Host, finite, not_negative, number, positive};
use crate::components::{BodyError, Curve};
use crate::math::compartment::Content;

/// Closed volume behind the triangles of a body, into which their normals do not point, with a content that presses on them. Boundary loops that exist when
/// the component is set are lids, flat at their mean place; loops that tears open later are leaks. Of a body in several pieces it is under the largest one.
/// *Parameter.*
///
/// ```
/// use rhexis::components::Compartment;
/// use rhexis::prelude::*;
///
/// let disc = Membrane::new("disc", generate::disc(5.0, 200)?, Material::allard_2009());
/// let rim = Hold::new("rim", disc.select(|p| p.length() > 4.99));
/// let inflow = Curve::constant(0.05);
/// let compartment = Compartment { inflow, chamber: 100.0, ..Compartment::default() };
/// let mut simulation = Simulation::new(Settings::default())?;
/// let body = simulation.spawn(disc.hold(rim).with(compartment))?;
/// simulation.step(5.0)?;
/// let volume = simulation.compartment(body).map(|state| state.volume);
/// assert!(volume.is_some_and(|volume| (volume - 100.25).abs() < 1e-3));
/// # Ok::<(), rhexis::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Compartment {
    /// Liquid or gas.
    pub content: Content,
    /// Volume \[mm³/ms\], without pressure, that flows in per time.
    pub inflow: Curve,
    /// Pressure \[MPa\] in front of the triangles and behind leaks.
    pub outside: Curve,
    /// Coefficient of discharge of leaks: 0 for tight ones, 0.6 for sharp edges.
    pub leak: f64,
    /// Volume \[mm³\] of rigid room beside that under the triangles.
    pub chamber: f64,
}

impl Default for Compartment {
    /// Tight, full of water, without inflow and without pressure outside.
    fn default() -> Self {
        let none = Curve::constant(0.0);
        Self { content: Content::default(), inflow: none.clone(), outside: none, leak: 0.0, chamber: 0.0 }
    }
}

impl Compartment {
    /// Volume \[mm³\] that flows in from one time to another \[ms\].
    pub(crate) fn inflow(&self, from: f64, to: f64) -> f64 {
        let knots = self.inflow.points().iter().map(|point| point.0).filter(|time| *time > from && *time < to);
        let mut before = from;
        let part = |time: f64| {
            let span = time - before;
            let mean = 0.5 * (self.inflow.at(before) + self.inflow.at(time));
            before = time;
            span * mean
        };
        knots.chain([to]).map(part).sum()
    }
}

const NAME: &str = "Compartment";

impl Check for Compartment {
    fn check(&self, _: &Host<'_>) -> Result<(), BodyError> {
        let Content { stiffness, exponent, density } = self.content;
        positive(NAME, "stiffness of the content", stiffness)?;
        positive(NAME, "density", density)?;
        let is_exponent = (1.0..=3.0).contains(&exponent);
        number(NAME, "exponent", exponent, (is_exponent, "it must be from 1 to 3"))?;
        self.inflow.check(NAME)?;
        self.outside.check(NAME)?;
        let is_coefficient = (0.0..=1.0).contains(&self.leak);
        number(NAME, "leak", self.leak, (is_coefficient, "a coefficient of discharge is from 0 to 1"))?;
        not_negative(NAME, "chamber", self.chamber)
    }
}

/// Volume \[mm³\] at which a compartment can begin.
pub(crate) fn check_volume(volume: f64) -> Result<(), BodyError> {
    finite(NAME, "volume", [volume])?;
    let must = "it must be positive, behind triangles whose normals point out of it: turn their corners around, or give the `chamber` beside them";
    number(NAME, "volume", volume, (volume > 0.0, must))
}
