//! The content of a compartment, and the step that it is in.

use crate::components::check::{Check, Host, finite, not_negative, positive};
use crate::components::{BodyError, Compartment};
use crate::math::compartment::{Content, Filled, Outflow};
use crate::storage::{Attached, Closure, Revision, Topology, Triangles, Vertices};
use glam::DVec3;

/// Content of a [`Compartment`]. *State.*
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct CompartmentState {
    /// Volume \[mm³\], chamber included.
    pub volume: f64,
    /// Volume \[mm³\] of the content at ambient pressure.
    pub content: f64,
    /// Pressure \[MPa\] of the content beyond the ambient one.
    pub pressure: f64,
    /// Volume \[mm³\] that has leaked out; content that came in through leaks is taken off.
    pub leaked: f64,
    /// Area \[mm²\] of the leaks.
    pub opening: f64,
    /// Vertices of the lids' rims.
    pub(crate) rim: Attached<()>,
    /// Answer of the body \[mm/MPa\] to the pressure of the last step, from which the next solve for it begins.
    pub(crate) answer: Vec<DVec3>,
    /// *Derived*: the step under way.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub(crate) work: Box<CompartmentWork>,
}

/// Memory of a compartment within a step. *Derived.*
#[derive(Clone, Debug, Default)]
pub(crate) struct CompartmentWork {
    /// Boundary of the body.
    pub closure: Closure,
    /// Moment in the history of its edits at the end of the last step.
    pub revision: Revision,
    /// Stiffness in the operator.
    pub stiffness: VolumeStiffness,
    /// Answer of the body \[mm/MPa\] to the pressure in the last solve.
    pub answer: Vec<DVec3>,
    /// Last evaluation of the step; none between steps.
    pub trial: Option<Trial>,
    /// Pressure \[MPa\] on the body and gradient of the volume at the start of a static solve.
    pub start: (f64, Vec<DVec3>),
    /// Sums per chunk of triangles.
    pub partials: Vec<f64>,
}

/// Rank-one term k·g·gᵀ of the operator: the content's stiffness along the gradient of the volume.
#[derive(Clone, Debug, Default)]
pub struct VolumeStiffness {
    /// Gradient g of the volume by every vertex \[mm²\].
    pub gradient: Vec<DVec3>,
    /// k = −dp/dV \[MPa/mm³\].
    pub stiffness: f64,
    /// Pressure \[MPa\] of the evaluation beyond the one that was expected.
    pub ahead: f64,
}

/// Evaluation of a compartment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Trial {
    /// Law of the content.
    pub law: Content,
    /// Flow out of it over the span.
    pub out: Outflow,
    /// Content \[mm³\] with the inflow of the span.
    pub content: f64,
    /// Content \[mm³\] without it.
    pub start: f64,
    /// Inflow \[mm³\] of the span.
    pub inflow: f64,
    /// Pressure and derivatives at the evaluated volume.
    pub filled: Filled,
    /// gᵀ·u \[mm³\] for the displacement since the start of the step at the evaluation.
    pub way: f64,
    /// State at the end of the step.
    pub outcome: Outcome,
}

/// State at the end of a step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Outcome {
    /// Volume \[mm³\], chamber included.
    pub volume: f64,
    /// Pressure \[MPa\].
    pub pressure: f64,
    /// Content \[mm³\].
    pub content: f64,
    /// Volume \[mm³\] that has leaked.
    pub leaked: f64,
}

impl VolumeStiffness {
    /// gᵀ·u \[mm³\] for displacements u \[mm\].
    pub fn swept(&self, u: &[DVec3]) -> f64 {
        self.gradient.iter().zip(u).map(|(g, u)| g.dot(*u)).sum()
    }
}

impl Trial {
    /// State after a step over which the vertices sweep `way` \[mm³\] along the evaluated gradient: along the derivatives of the evaluation.
    pub(crate) fn outcome_of(&self, way: f64) -> Outcome {
        let Filled { pressure, stiffness, flow, flow_slope } = self.filled;
        let swept = way - self.way;
        let leaked = self.out.span * (flow + flow_slope * swept);
        // A linear answer may ask for more than there is.
        let leaked = leaked.min(self.content * (1.0 - 1e-6));
        Outcome { volume: 0.0, pressure: pressure - stiffness * swept, content: self.content - leaked, leaked }
    }

    /// State at a volume \[mm³\] that differs from that along the derivatives: leaks let the difference pass without resistance, lest the next step should
    /// press all of it through them.
    pub(crate) fn settled(&self, outcome: Outcome, volume: f64) -> Outcome {
        if self.out.span * self.out.area > 0.0 {
            let content = self.law.content(outcome.pressure, volume);
            return Outcome { volume, content, leaked: self.content - content, ..outcome };
        }
        Outcome { volume, ..outcome }
    }
}

impl Check for CompartmentState {
    fn check(&self, host: &Host<'_>) -> Result<(), BodyError> {
        const NAME: &str = "CompartmentState";
        positive(NAME, "volume", self.volume)?;
        positive(NAME, "content", self.content)?;
        finite(NAME, "pressure or leaked volume", [self.pressure, self.leaked])?;
        not_negative(NAME, "opening", self.opening)?;
        finite(NAME, "answer", self.answer.iter().flat_map(|answer| answer.to_array()))?;
        host.rows(NAME, || "a rim".to_owned(), self.rim.rows())
    }
}

impl CompartmentState {
    /// Stiffness of the content in the operator.
    pub(crate) fn stiffness(&self) -> &VolumeStiffness {
        &self.work.stiffness
    }

    /// Nodal force \[N\] that rounding of the volume alone leaves.
    pub(crate) fn rounding(&self) -> f64 {
        let VolumeStiffness { gradient, stiffness, .. } = &self.work.stiffness;
        let largest = gradient.iter().map(|g| g.length()).fold(0.0, f64::max);
        8.0 * f64::EPSILON * stiffness * self.content * largest
    }

    /// State of a compartment whose content is without pressure in the body as it is.
    pub(crate) fn new(
        compartment: &Compartment,
        (vertices, triangles, topology): (&Vertices, &Triangles, &Topology),
    ) -> Self {
        let mut state = Self::default();
        let closure = &mut state.work.closure;
        closure.find(triangles, topology);
        let volume = closure.volume(&triangles.corners, &vertices.position) + compartment.chamber;
        let rim = closure.loops().flatten().map(|vertex| (*vertex, ()));
        state.rim = Attached::new(rim);
        (state.volume, state.content) = (volume, volume);
        state
    }
}
