//! Fracture: criterion, nucleation, tip advance, cuts and refinement, all in the rest shape.
//!
//! An advance is decided in the chart of the tip's fan ([`TipChart`]) and planned without touching the mesh ([`plan_free`],
//! [`plan_edge`]). A [`Cutter`] carries it out: edits that bring a vertex onto the path, the opening of the edge to it, and flips
//! where they raise a small angle. Each edit leaves a record; an advance that cannot be done well enough is taken back by those
//! records and refused with a reason.

mod corrector;
pub mod criterion;
mod cut;
mod followers;
pub mod split;
pub mod topology;

pub use corrector::{CORRECTORS, advancing, unfinished};
pub use criterion::by_triangle::{factor_of, mean_around};
pub use criterion::coupled_criterion::{CoupledBuffers, CoupledCriterion};
pub use criterion::crack_field::CrackFrame;
pub use criterion::energy_decision::{EnergyReading, EnergyTerms, energy_decision};
pub use criterion::held_shut::{field_tip, lay_at_tip};
pub use criterion::shifted_disc::{MaterialForce, ShiftedDisc};
pub use criterion::tip_decision::{decision, strength, tip_decision, vertex_decision};
pub use criterion::tip_disc::{Disc, Walk};
pub use criterion::tip_memory::TipMemory;
pub use criterion::tip_stress::{DiscAverage, Surface, SurfaceQuery, disc_average};
pub(crate) use criterion::ultimate_stretch::beyond_stretch;
pub use cut::blade::CutOutcome;
pub use cut::edge::{EdgeAdvance, EdgePlan, plan_edge};
pub use cut::free::{Way, Ways, plan_free};
pub use cut::heading::turned_axis;
pub use cut::locate::distance_to_triangle;
pub use cut::nucleation::{NewTip, Slit};
pub use cut::tip::TipChart;
pub use followers::{Followers, FollowersQuery};
pub use topology::coarsen::{Coarsening, plan_coarsening};
pub use topology::ligaments::Ligaments;

use crate::event::Course;
use crate::storage::{Edit, EditRecord, Mesh, Refusal};
use glam::DVec3;
use std::fmt;

/// Limits on the shapes of triangle that a tear may leave. Tuned on random tears through structured, jittered and curved
/// meshes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// The first way whose triangles keep this angle \[rad\] is taken without looking at others; 28°. At 20° tears across
    /// tears leave a first percentile 2° to 4° lower and twice the triangles: slides are looked at less.
    pub good: f64,
    /// A path leaves its ray and snaps to a vertex only where an angle below this \[rad\] would be left otherwise; 14°.
    pub exact: f64,
    /// No angle below this \[rad\] is left, except where one was there before; 10°.
    pub least: f64,
    /// Largest turn \[rad\] away from the ray by a snap that is preferred to a poor exact path; 15°.
    pub snap: f64,
    /// Largest turn \[rad\] by a snap where there is no other way; 40°.
    pub widest_snap: f64,
    /// Largest turn \[rad\] by an edge that is opened where no other way is left, and by one in edge mode; 75°.
    pub widest_edge: f64,
    /// Pairs of triangles with an angle below this \[rad\] are flipped where that helps; 28°.
    pub flip: f64,
    /// No edge shorter than this \[mm\] is made, except where one as short was there before; 0 for any length.
    pub least_edge: f64,
}

impl Default for Quality {
    fn default() -> Self {
        Self {
            good: 28_f64.to_radians(),
            exact: 14_f64.to_radians(),
            least: 10_f64.to_radians(),
            snap: 15_f64.to_radians(),
            widest_snap: 40_f64.to_radians(),
            widest_edge: 75_f64.to_radians(),
            flip: 28_f64.to_radians(),
            least_edge: 0.0,
        }
    }
}

/// Reason why a tear does not advance; the mesh is as it was.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TearRefusal {
    /// An edit was refused.
    #[error(transparent)]
    Edit(#[from] Refusal),
    /// The vertex lies inside the surface, where a tear has to be started before it can advance.
    #[error("vertex {vertex} lies inside the surface and is no tip")]
    NotATip {
        /// Row of the vertex.
        vertex: u32,
    },
    /// The vertex does not exist, or its triangles have no area.
    #[error("vertex {vertex} has no fan of triangles")]
    NoFan {
        /// Row of the vertex.
        vertex: u32,
    },
    /// The direction leaves the surface, or runs along its boundary.
    #[error("the direction does not lie inside the fan of vertex {vertex}")]
    OutsideFan {
        /// Row of the tip.
        vertex: u32,
    },
    /// No vertex can be put at a point of a cut, or on an edge, without too small an angle.
    #[error("a vertex there would leave an angle of {:.1}°", angle.to_degrees())]
    NoRoom {
        /// The best smallest angle found \[rad\].
        angle: f64,
    },
    /// Every way was tried, and none leaves triangles that are good enough.
    #[error("no way leaves good triangles: {0}")]
    NoWay(Tried),
    /// Edge mode: no edge leads forward.
    #[error("no edge of vertex {vertex} leads forward")]
    NoForwardEdge {
        /// Row of the tip.
        vertex: u32,
    },
    /// No part of a cut's line lies inside the body.
    #[error("the line lies outside the body, or along its boundary, over its whole length")]
    OutsideBody,
    /// A cut needs two points that are finite and differ.
    #[error("a cut needs at least two different points")]
    BadPolyline,
    /// A cut does not come nearer to its next point.
    #[error("the cut does not reach its point {point}")]
    NoProgress {
        /// Index of the point in the polyline.
        point: usize,
    },
}

/// Results of the ways that were tried.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tried {
    /// Best smallest angle \[rad\] that a way of each course would have left, in the order of [`Course::ALL`]; zero where
    /// the mesh refused an edit, `None` where there was no such way.
    pub angles: [Option<f64>; Course::ALL.len()],
    /// The last reason why the mesh refused an edit.
    pub refusal: Option<Refusal>,
}

impl Tried {
    fn note(&mut self, course: Course, angle: f64) {
        let best = &mut self.angles[course as usize];
        *best = Some(best.map_or(angle, |a| a.max(angle)));
    }
}

impl fmt::Display for Tried {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, (course, angle)) in Course::ALL.iter().zip(self.angles).enumerate() {
            let separator = if i == 0 { "" } else { ", " };
            match angle {
                None => write!(f, "{separator}{course} none")?,
                Some(angle) => write!(f, "{separator}{course} {:.1}°", angle.to_degrees())?,
            }
        }
        self.refusal.map_or(Ok(()), |refusal| write!(f, "; {refusal}"))
    }
}

/// One advance of a tear. Positions are in the rest shape \[mm\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Advance {
    /// Position of the tip before the advance.
    pub from: DVec3,
    /// Position of the tip after the advance.
    pub to: DVec3,
    /// Row of the vertex it reached: the new tip, unless the tear has ended.
    pub vertex: u32,
    /// Angle \[rad\] between the wanted direction and the way taken; zero where the path is exact.
    pub deviation: f64,
    /// Course of the advance: the wanted way, or which other one.
    pub course: Course,
    /// Smallest angle \[rad\] of the triangles whose shape the advance has changed; π where it has changed none.
    pub smallest_angle: f64,
    /// Set where the tear has run into a boundary: the outer rim, another tear, or itself.
    pub end: Option<End>,
}

impl Advance {
    /// Length of the advance \[mm\].
    pub fn length(&self) -> f64 {
        self.from.distance(self.to)
    }
}

/// The end of a tear at a boundary. Every tip at the vertex it has reached is gone as well.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct End {
    /// Number of triangles of the smaller part, where the surface has come apart.
    pub freed: Option<usize>,
}

/// Buffers of a cutter, to be kept between events so that these do not allocate. *Derived.*
#[derive(Clone, Debug, Default)]
pub struct TearScratch {
    /// The edits done, in order. The caller clears them after the followers have followed.
    pub records: Vec<EditRecord>,
    best: Vec<Edit>,
    marks: Vec<u8>,
    queues: [Vec<u32>; 2],
}

/// Advances, starts and cuts tears in a mesh.
pub struct Cutter<'c, 'm> {
    /// The mesh.
    pub mesh: &'c mut Mesh<'m>,
    /// Whether a vertex may be moved in the rest shape to make room for a path: not where something holds it.
    pub is_movable: &'c dyn Fn(u32) -> bool,
    /// Limits on triangle shapes.
    pub quality: Quality,
    /// Buffers, and the records of the edits done.
    pub scratch: &'c mut TearScratch,
}
