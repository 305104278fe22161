//! Observable state of a simulation at one moment: plain arrays for pictures, files and tests.

use crate::components::Attributes;
use glam::{DMat3, DVec2, DVec3};

/// All bodies at one moment.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    /// Steps done.
    pub step: u64,
    /// Simulated time \[ms\].
    pub time: f64,
    /// The bodies, in order of spawning.
    pub bodies: Vec<BodyFrame>,
    /// Obstacles, in the order of their handles, then forceps and closed jaws.
    pub solids: Vec<SolidFrame>,
}

/// Kind of a [`SolidFrame`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolidKind {
    /// An obstacle.
    Obstacle,
    /// Forceps, or the closed jaws of a grip, as a ball of their radius.
    Jaws,
}

/// A rigid thing at one moment, as a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct SolidFrame {
    /// Kind of the solid.
    pub kind: SolidKind,
    /// Vertex positions \[mm\].
    pub positions: Vec<DVec3>,
    /// Vertex indices of the triangles, which face outwards. Of a plane the part under the bodies.
    pub triangles: Vec<[u32; 3]>,
    /// Middle of the solid \[mm\].
    pub at: DVec3,
    /// Force on the bodies in the last step \[N\].
    pub force: DVec3,
}

/// One body at one moment. Per-triangle arrays stand in the order of `triangles`.
#[derive(Clone, Debug, Default)]
pub struct BodyFrame {
    /// The body's name.
    pub name: String,
    /// Current vertex positions \[mm\].
    pub positions: Vec<DVec3>,
    /// Rest vertex positions \[mm\].
    pub rest_positions: Vec<DVec3>,
    /// Vertex velocities \[mm/ms\].
    pub velocities: Vec<DVec3>,
    /// Elastic forces of the membrane on the vertices \[N\]: without bending, damping, loads, contact and holds.
    pub forces: Vec<DVec3>,
    /// Vertex indices of the triangles.
    pub triangles: Vec<[u32; 3]>,
    /// Biot stress \[MPa\] per triangle, turned into space by the triangle's rotation.
    pub stress: Vec<DMat3>,
    /// In-plane principal values of the Biot stress \[MPa\], larger first.
    pub principal_stress: Vec<DVec2>,
    /// Current unit fibre direction per triangle.
    pub fibres: Vec<DVec3>,
    /// Largest criterion value per triangle from its own stress, without a previous direction; empty for a body that cannot tear.
    pub criterion: Vec<f64>,
    /// Numbers of the vertices of the host's own or of the mesh file, such as texture coordinates; none where the body carries none.
    pub attributes: Option<Attributes>,
    /// The tear tips.
    pub tips: Vec<TipFrame>,
}

/// A tear tip at one moment. Directions are unit vectors in space.
#[derive(Clone, Debug, Default)]
pub struct TipFrame {
    /// Current position \[mm\].
    pub position: DVec3,
    /// Direction of the last advance, if there was one.
    pub previous: Option<DVec3>,
    /// The direction in which the criterion is largest.
    pub direction: DVec3,
    /// The criterion there; above 1 the tear advances.
    pub value: f64,
    /// The criterion's polar curve over the admissible directions: (unit direction, c).
    pub curve: Vec<(DVec3, f64)>,
    /// Material force \[N/mm\]: the energy released per area of tear by an advance along d is its product with d.
    pub material_force: DVec3,
    /// Whether that decides where the tear goes: not where a stress or the field in a ring does.
    pub is_by_force: bool,
    /// Averaging radius R \[mm\].
    pub radius: f64,
}
