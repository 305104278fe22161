//! Why a body is refused, or a component of it.

use crate::math::InadmissibleMaterial;
use crate::storage::{Broken, MeshError};

/// Why a body is refused, or a component of a body, an obstacle or a tool.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BodyError {
    /// The mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The mesh, found while its topology was built.
    #[error("the mesh is not an oriented surface: {0}")]
    Topology(#[from] Broken),
    /// The material of a triangle.
    #[error("triangle {triangle}: {source}")]
    Material {
        /// The triangle's index.
        triangle: usize,
        /// Reason why the material is inadmissible.
        source: InadmissibleMaterial,
    },
    /// One of several loads.
    #[error("load {number}: {source}")]
    Load {
        /// Number of the load in the component, from 0.
        number: usize,
        /// Reason why it is refused.
        source: Box<BodyError>,
    },
    /// A number outside its range.
    #[error("{component}: {what}{} is {value:?}: {must}", at(*row))]
    OutOfRange {
        /// Name of the component.
        component: &'static str,
        /// Which number.
        what: &'static str,
        /// At which vertex, where it belongs to one.
        row: Option<u32>,
        /// Rejected value.
        value: f64,
        /// Requirement on the value.
        must: &'static str,
    },
    /// Refinement around the tips of a body that has none.
    #[error("refinement goes with tear tips and their averaging radius: let the body tear, or leave refinement out")]
    RefinementWithoutTearing,
    /// A criterion on energy for a body that does not tear.
    #[error("the energy criterion decides at tear tips: let the body tear, or leave it out")]
    EnergyCriterionWithoutTearing,
    /// Two laws of the fibres.
    #[error("fibres have one law: leave `StiffeningFibres` or `HolzapfelGasserOgden` out")]
    TwoFibreLaws,
    /// Relaxation beside a law of the fibres.
    #[error(
        "Relaxation goes with the linear law: leave it out, or leave out `StiffeningFibres` and `HolzapfelGasserOgden`"
    )]
    RelaxationOfFibreLaw,
    /// A published law of the fibres with a pre-stretch that differs from triangle to triangle.
    #[error(
        "`HolzapfelGasserOgden` takes one pre-stretch for the whole body: give `PreStretch`, or leave those of triangles out"
    )]
    PublishedLawPreStretched,
    /// A neo-Hookean matrix with elastic constants of another law, in the triangle with this index.
    #[error("triangle {0}: a neo-Hookean matrix goes with the material that `Material::neo_hookean` gives")]
    NotNeoHookean(usize),
    /// Contact with other bodies without the radius of the body's own layers.
    #[error("Contact: between_bodies takes the radius of self_contact: give that too, or leave between_bodies out")]
    BetweenBodiesWithoutRadius,
    /// Bending of a body that stays in its plane.
    #[error("a planar body does not bend: let it leave its plane, or leave bending out")]
    BendingInPlane,
    /// Values and triangles differ in number.
    #[error("{given} {what} for {needed} triangles: give one per triangle")]
    ValueCount {
        /// Kind of the values, in plural.
        what: &'static str,
        /// How many were given.
        given: usize,
        /// How many the mesh takes.
        needed: usize,
    },
    /// Attributes and vertices differ in number.
    #[error(
        "Attributes: {given} numbers for {vertices} vertices with {stride} each: give stride × vertices, and a stride of 1 or more"
    )]
    AttributeCount {
        /// How many numbers were given.
        given: usize,
        /// Numbers per vertex.
        stride: usize,
        /// Number of vertices.
        vertices: usize,
    },
    /// A fibre list of the wrong length.
    #[error("{given} fibre directions for {needed} triangles: give one per triangle, in the mesh's order")]
    FibreCount {
        /// Directions given.
        given: usize,
        /// Triangles.
        needed: usize,
    },
    /// A vertex row that does not exist.
    #[error("{component}: {what} names vertex {row}, but the mesh has {count} vertices")]
    NoSuchVertex {
        /// Name of the component.
        component: &'static str,
        /// Who names it.
        what: String,
        /// The row.
        row: u32,
        /// Number of vertices.
        count: usize,
    },
    /// An edge that does not exist, or lies inside the surface.
    #[error("{component}: {what} names the edge from vertex {} to {}: it must be one of the boundary", edge[0], edge[1])]
    NoSuchEdge {
        /// Name of the component.
        component: &'static str,
        /// Who names it.
        what: String,
        /// Rows of its ends.
        edge: [u32; 2],
    },
    /// Two holds prescribe the same axis of the same vertex.
    #[error("holds `{first}` and `{second}` both prescribe axis {axis} of vertex {row}: let one of them go")]
    ContradictoryHolds {
        /// Name of the first hold.
        first: String,
        /// Name of the second hold.
        second: String,
        /// x, y or z.
        axis: char,
        /// The vertex.
        row: u32,
    },
    /// Parts that do not fit together.
    #[error("{component}: {what}")]
    Contradiction {
        /// Name of the component.
        component: &'static str,
        /// Contradiction, and how to mend it.
        what: &'static str,
    },
}

fn at(row: Option<u32>) -> String {
    row.map_or(String::new(), |row| format!(" at vertex {row}"))
}
