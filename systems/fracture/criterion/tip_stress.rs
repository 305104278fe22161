//! Stress has a length at a tear's tip: its average over a disc of the material radius R in the rest shape.
//!
//! Tensors are averaged in one common frame, the tangent plane at the disc's centre, with uniform weight by area; triangles at
//! the rim count by their overlap with the disc ([`Disc`]).

use crate::components::{Bending, FibreLaws, Planar, PreStretch, fibre_law};
use crate::math::{ElementState, FibreLaw, Sym2};
use crate::storage::{Topology, Triangles, Vertices};
use crate::systems::forces::element::BodyLaw;
use crate::systems::fracture::criterion::tip_disc::{Disc, Walk};
use crate::systems::fracture::cut::tip::fan_chart;
use crate::systems::kernels::fan::FanChart;
use glam::{DVec2, DVec3};

/// A body's surface as the average needs it.
#[derive(Clone, Copy, Debug)]
pub struct Surface<'a> {
    /// Positions, current and at rest.
    pub vertices: &'a Vertices,
    /// Rest data, fibres and material.
    pub triangles: &'a Triangles,
    /// Neighbours of the triangles, for the walk.
    pub topology: &'a Topology,
    /// Whether the body stays in its plane.
    pub is_planar: bool,
    /// The stretch of the body that is free of stress.
    pub unstretched: Sym2,
    /// Law of the fibres, if the body has one.
    pub fibres: Option<FibreLaw>,
    /// Resistance to bending, if there is any.
    pub bending: Option<&'a Bending>,
}

/// Query of the components of which a body's surface is made.
pub type SurfaceQuery<'a> = (
    (&'a Vertices, &'a Triangles, &'a Topology),
    (Option<&'a Planar>, Option<&'a PreStretch>, FibreLaws<'a>, Option<&'a Bending>),
);

/// The averages over a disc, in its axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiscAverage {
    /// Biot stress \[MPa\].
    pub stress: Sym2,
    /// Unit mean fibre: the principal axis of the mean of f ⊗ f.
    pub fibre: DVec2,
    /// Gradient of the fibre's angle over the disc \[rad/mm\], by a linear fit.
    pub fibre_turn: DVec2,
    /// R \[mm\].
    pub radius: f64,
    /// Area of the disc that is tissue \[mm²\].
    pub area: f64,
    /// R over the mean edge length in the disc; under 3 the average is under-resolved.
    pub edges_per_radius: f64,
}

impl DiscAverage {
    /// The averages over a disc of this radius; `None` where no tissue lies in it.
    pub fn over(disc: &Disc, radius: f64, surface: &Surface) -> Option<Self> {
        let &Disc { area, fibre, fibre_turn, edges_per_radius, .. } = disc;
        let average = || Self { stress: disc.stress(surface), fibre, fibre_turn, radius, area, edges_per_radius };
        (area > 0.0).then(average)
    }
}

impl<'a> Surface<'a> {
    /// The surface of a body with these components.
    pub fn of(((vertices, triangles, topology), (planar, pre_stretch, fibres, bending)): SurfaceQuery<'a>) -> Self {
        let unstretched = PreStretch::unstretched(pre_stretch);
        let fibres = fibre_law(fibres, pre_stretch);
        Self { vertices, triangles, topology, is_planar: planar.is_some(), unstretched, fibres, bending }
    }
}

impl Surface<'_> {
    /// The law of its triangles.
    fn law(&self) -> BodyLaw<'_> {
        BodyLaw { is_planar: self.is_planar, unstretched: self.unstretched, fibres: self.fibres.as_ref() }
    }

    /// The chart of the fan around a vertex; `None` where the fan has no area.
    pub fn chart(&self, vertex: u32) -> Option<FanChart> {
        Some(fan_chart((self.vertices, self.triangles, self.topology), vertex)?.1)
    }

    /// Biot stress of a triangle at the current positions, in its frame (fibre, transverse).
    pub fn stress(&self, triangle: usize) -> Sym2 {
        self.state(triangle).stress
    }

    /// The state of a triangle at the current positions.
    pub fn state(&self, triangle: usize) -> ElementState {
        let x = self.triangles.corners[triangle].map(|v| self.vertices.position[v as usize]);
        self.law().element(self.triangles, triangle).state(x)
    }

    /// Energy stored in a triangle at a state \[mJ\].
    pub fn energy(&self, triangle: usize, state: &ElementState) -> f64 {
        let triangles = self.triangles;
        self.law().element(triangles, triangle).density(state)
            * triangles.rest[triangle].area
            * triangles.thickness[triangle]
    }
}

/// Averages over the disc of `radius` \[mm\] about `centre` (rest shape), whose tangent plane has the orthonormal `axes`.
/// The walk starts from the triangles `start`. `None` where no tissue lies in the disc.
pub fn disc_average(
    surface: &Surface,
    centre: DVec3,
    axes: [DVec3; 2],
    radius: f64,
    start: impl IntoIterator<Item = u32>,
    (disc, walk): (&mut Disc, &mut Walk),
) -> Option<DiscAverage> {
    disc.lay(surface, (centre, axes, radius), start, walk);
    DiscAverage::over(disc, radius, surface)
}
