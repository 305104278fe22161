//! The three tables of a body: vertices, triangles, tear tips. Columns stand in the order of who touches them:
//! state that every step rewrites, then rest data that only a topology edit rewrites.

use super::table::table;
use super::{EditRecord, Relaxing, Uniform};
use crate::math::{Orthotropic, RestTriangle, Sym2};
use glam::DVec3;

table! {
    /// The vertices of a body. *State.* 80 bytes a row.
    pub struct Vertices, row VertexRow, key VertexKey {
        /// Current position \[mm\].
        position: Vec<DVec3>,
        /// Current velocity \[mm/ms\].
        velocity: Vec<DVec3>,
        /// Position in the rest shape \[mm\]; cuts are made there.
        rest_position: Vec<DVec3>,
        /// Lumped mass \[g\]: a third of each incident triangle's, summed in the order of triangle rows.
        mass: Vec<f64>,
    }
}

table! {
    /// The triangles of a body. *State.* 52 bytes a row while all are made of the same, with fibres along one direction; else up to 112 more.
    pub struct Triangles, row TriangleRow, key TriangleKey {
        /// Rows of the three vertices, counter-clockwise seen from the side the normal points to.
        corners: Vec<[u32; 3]>,
        /// Shape-function gradients in the fibre's frame and the rest area; follows from corners, rest positions, fibre.
        rest: Vec<RestTriangle>,
        /// Unit fibre direction in the rest shape.
        fibre: Uniform<DVec3>,
        /// Elastic constants in the fibre's frame \[MPa\].
        stiffness: Uniform<Orthotropic>,
        /// Thickness \[mm\].
        thickness: Uniform<f64>,
        /// Density \[g/mm³\].
        density: Uniform<f64>,
        /// Pre-stretch beside the body's own, in the axes (fibre, transverse).
        pre_stretch: Uniform<Sym2>,
        /// Strengths over those of the body.
        strength: Uniform<f64>,
        /// Toughnesses over those of the body.
        toughness: Uniform<f64>,
        ..
        /// History of a body that relaxes; follows edits by itself.
        relaxing: Option<Box<Relaxing>>,
    }
}

table! {
    /// The tear tips of a body: where a tear may advance. *State.*
    pub struct Tips, row TipRow, key TipKey {
        /// Row of the vertex at the tip, which lies on the boundary that the tear has made.
        vertex: Vec<u32>,
        /// Unit direction of the last advance in the rest shape; zero where there was none.
        previous: Vec<DVec3>,
        /// Edge mode: the point \[mm, rest shape\] where the tear would be if it could leave the edges. Of tips that glide the place at the
        /// last evaluation of the criterion.
        ideal: Vec<DVec3>,
        /// Criterion value max c(d) at the last evaluation; the tear advances where it exceeds 1.
        criterion: Vec<f64>,
        /// Fall of G/G_c per length of the tear \[1/mm\] of a tip that glides, negative while it rests; 0 where it is not known.
        fall: Vec<f64>,
        /// Whether the last advance that the criterion asked for was refused.
        is_refused: Vec<bool>,
        /// Whether it was said that the mesh is too coarse for R here.
        is_coarse: Vec<bool>,
    }
}

/// Largest relative difference of the materials of two triangles that are alike.
const ALIKE: f64 = 0.2;
/// Smallest cosine of the angle between the fibres of two triangles that are alike: 45°.
const ALONG: f64 = std::f64::consts::FRAC_1_SQRT_2;

impl TriangleRow {
    /// Whether no border of materials runs between two triangles: their values may be taken for those of one smooth field.
    pub fn is_alike(&self, other: &Self) -> bool {
        let moduli = |q: Orthotropic| [q.q11, q.q12, q.q22, q.q66];
        let strains = |e: Sym2| [e.xx, e.yy, e.xy];
        let close = |x: f64, y: f64| (x - y).abs() <= ALIKE * x.abs().max(y.abs());
        moduli(self.stiffness).into_iter().zip(moduli(other.stiffness)).all(|(x, y)| close(x, y))
            && close(self.thickness, other.thickness)
            && close(self.density, other.density)
            && close(self.strength, other.strength)
            && close(self.toughness, other.toughness)
            && strains(self.pre_stretch).into_iter().zip(strains(other.pre_stretch)).all(|(x, y)| close(x, y))
            && self.fibre.dot(other.fibre).abs() >= ALONG
    }
}

impl Triangles {
    /// Whether all triangles have one fibre, one material and one pre-stretch.
    pub fn is_uniform(&self) -> bool {
        let Self { fibre, stiffness, thickness, density, pre_stretch, strength, toughness, .. } = self;
        let numbers = [thickness, density, strength, toughness];
        numbers.iter().all(|column| column.is_uniform())
            && fibre.is_uniform()
            && stiffness.is_uniform()
            && pre_stretch.is_uniform()
    }

    /// Whether some triangle has a pre-stretch beside the body's own.
    pub(crate) fn are_pre_stretched(&self) -> bool {
        !self.pre_stretch.is_uniform() || self.pre_stretch.get(0).is_some_and(|&strain| strain != Sym2::ZERO)
    }

    /// The smallest of the strengths over those of the body: 1 where it is uniform.
    pub(crate) fn least_strength(&self) -> f64 {
        if self.strength.is_uniform() {
            return self.strength.get(0).copied().unwrap_or(1.0);
        }
        self.strength.iter().copied().fold(f64::INFINITY, f64::min)
    }
}

impl Tips {
    /// Follows an edit: a tip stays with its vertex, or with the one that it was collapsed into.
    pub fn follow(&mut self, record: &EditRecord) {
        for vertex in &mut self.vertex {
            *vertex = record.heir(*vertex);
        }
    }
}
