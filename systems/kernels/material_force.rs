//! The material force: the energy that a shift of the rest shape about a point releases at fixed positions (Eshelby 1951; Maugin 1993), by
//! the domain form of virtual crack extension (Parks 1974; Li, Shih, Needleman 1985).
//!
//! A disc's rest positions move by q·d, with a weight q that is 1 at its centre and 0 at its rim, and all vertices stay where they
//! are. A triangle's gradient then changes by −F·d⊗∇q and its volume by V·d·∇q, so that its energy V·W falls by g·d with
//!
//! g = V·(Fᵀ·P − W·1)·∇q = −Fᵀ·Σ qᵢ·fᵢ − V·W·∇q,
//!
//! fᵢ = −V·P·∇Nᵢ being its forces on its corners. No small strain, no flat disc and no law of its own enters: it is the derivative
//! of the discrete energy. Whatever else acts on the vertices, by d'Alembert −Σ fᵢ of the triangles around one, moves with the
//! material and does the work −F·q·d. So does the residual of a solve, whose rotations would else count in full.

use glam::{DVec2, DVec3};

/// A triangle at its present positions, in two orthonormal axes of its rest plane.
#[derive(Clone, Copy, Debug)]
pub struct Strained {
    /// Columns of F.
    pub gradient: [DVec3; 2],
    /// V·W: energy stored \[mJ\].
    pub energy: f64,
    /// Forces of the triangle on its corners \[N\].
    pub forces: [DVec3; 3],
}

/// Least sum of one and the cosine between normals for which there is a smallest rotation.
const OPPOSITE: f64 = 1e-3;

impl Strained {
    /// Normal of the triangle, as long as its present area over that at rest.
    #[inline]
    pub fn normal(&self) -> DVec3 {
        self.gradient[0].cross(self.gradient[1])
    }

    /// g of the triangle \[N\], with the weights of its corners and their gradient ∇q \[1/mm\] in the same axes.
    #[inline]
    pub fn release(&self, weights: [f64; 3], fall: DVec2) -> DVec2 {
        let [a, b, c] = self.forces;
        -pulled_back(self.gradient, a * weights[0] + b * weights[1] + c * weights[2]) - fall * self.energy
    }
}

/// The smallest rotation that turns the plane of a triangle into that of another normal, for vectors in the plane of the triangle.
#[derive(Clone, Copy, Debug)]
pub struct Unfolding {
    normal: DVec3,
    sum: DVec3,
}

impl Unfolding {
    /// From the plane of the unit normal `own` into that of `normal`: none where they are opposite, or zero.
    #[inline]
    pub fn between(own: DVec3, normal: DVec3) -> Self {
        let size = 1.0 + own.dot(normal);
        Self { normal, sum: if size > OPPOSITE { (own + normal) / size } else { DVec3::ZERO } }
    }

    /// A vector of the triangle's plane, turned.
    #[inline]
    pub fn apply(&self, v: DVec3) -> DVec3 {
        v - self.sum * self.normal.dot(v)
    }
}

/// Fᵀ·f: the loss of work of a force per unit shift of the rest shape along either axis \[N\].
#[inline]
pub fn pulled_back(gradient: [DVec3; 2], force: DVec3) -> DVec2 {
    DVec2::new(gradient[0].dot(force), gradient[1].dot(force))
}
