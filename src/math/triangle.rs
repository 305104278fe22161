//! The rest triangle: its frame along the fibre, its area and the gradients of its shape functions.

use super::elementary;
use glam::{DVec2, DVec3};

/// Rest-shape data of a triangle for the mechanics. The frame's first axis is the fibre, so the fibre appears nowhere
/// else: it lives in the gradients.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct RestTriangle {
    /// ∇N₁ and ∇N₂ \[1/mm\] in axes (fibre, transverse); ∇N₀ = −∇N₁ − ∇N₂.
    pub gradients: [DVec2; 2],
    /// Rest area \[mm²\].
    pub area: f64,
}

impl RestTriangle {
    /// The rest triangle with corners `x` \[mm\] and a fibre direction, which is projected into the triangle's plane. A fibre
    /// along the normal has no projection; then the first edge takes its place. `None` for a triangle without area.
    pub fn new(x: [DVec3; 3], fibre: DVec3) -> Option<Self> {
        let (a, b) = (x[1] - x[0], x[2] - x[0]);
        let cross = a.cross(b);
        let twice_area = cross.length();
        if !(twice_area > 0.0 && twice_area.is_finite()) {
            return None;
        }
        let normal = cross / twice_area;
        let e1 = Self::axis(normal, fibre, a);
        let e2 = normal.cross(e1);
        let (a, b) = (DVec2::new(a.dot(e1), a.dot(e2)), DVec2::new(b.dot(e1), b.dot(e2)));
        let gradients = [DVec2::new(b.y, -b.x) / twice_area, DVec2::new(-a.y, a.x) / twice_area];
        gradients.iter().all(|g| g.is_finite()).then_some(Self { gradients, area: 0.5 * twice_area })
    }

    /// The unit projection of `fibre` into the plane with unit `normal`, or of `edge` where the fibre has none.
    pub fn axis(normal: DVec3, fibre: DVec3, edge: DVec3) -> DVec3 {
        let projected = fibre - normal * normal.dot(fibre);
        // A unit fibre within 1e-6 rad of the normal has no direction left in the plane.
        if projected.length_squared() > 1e-12 * fibre.length_squared() {
            projected.normalize()
        } else {
            edge.normalize()
        }
    }

    /// ∇N₀, ∇N₁, ∇N₂ \[1/mm\].
    #[inline]
    pub fn all_gradients(&self) -> [DVec2; 3] {
        [-self.gradients[0] - self.gradients[1], self.gradients[0], self.gradients[1]]
    }
}

/// Squared tangents nearer to each other than this part may stand for the same angle \[rad\].
const TANGENT_TIE: f64 = 1e-12;

/// The smallest interior angle of a triangle, before its root and arctangent are taken: those are wanted of one triangle
/// among many only, and to compare angles needs neither. It is 60° at the most, so squared tangents order it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmallestAngle {
    /// Square of the sine, times that of the product of the sides at the angle \[mm⁴\].
    sine_sq: f64,
    /// The cosine, times the product of the sides \[mm²\].
    cosine: f64,
}

impl SmallestAngle {
    /// Smallest angle of the triangle with corners `x` \[mm\].
    #[inline]
    pub fn new(x: [DVec3; 3]) -> Self {
        // It stands opposite to the shortest side.
        let side_sq = |i: usize| x[(i + 1) % 3].distance_squared(x[(i + 2) % 3]);
        let sides = [side_sq(0), side_sq(1), side_sq(2)];
        let i = if sides[0] <= sides[1] && sides[0] <= sides[2] { 0 } else { 1 + usize::from(sides[2] < sides[1]) };
        let (a, b) = (x[(i + 1) % 3] - x[i], x[(i + 2) % 3] - x[i]);
        Self { sine_sq: a.cross(b).length_squared(), cosine: a.dot(b) }
    }

    /// The smallest of several triangles; `None` without any.
    pub fn among(triangles: impl Iterator<Item = [DVec3; 3]>) -> Option<Self> {
        triangles.map(Self::new).reduce(Self::or_smaller)
    }

    /// The smaller of two angles; this one where they are alike.
    #[inline]
    pub fn or_smaller(self, other: Self) -> Self {
        if other.is_smaller_than(&self) { other } else { self }
    }

    /// Whether it is smaller than another: by more than roundings, or in radians.
    #[inline]
    pub fn is_smaller_than(&self, other: &Self) -> bool {
        let own = self.sine_sq * (other.cosine * other.cosine);
        let others = other.sine_sq * (self.cosine * self.cosine);
        if (own - others).abs() > TANGENT_TIE * others {
            own < others
        } else {
            self != other && self.radians() < other.radians()
        }
    }

    /// Whether it is smaller than the acute angle whose tangent has this square.
    #[inline]
    pub fn is_below_tangent_sq(&self, tangent_sq: f64) -> bool {
        self.sine_sq < tangent_sq * (self.cosine * self.cosine)
    }

    /// The angle \[rad\]; zero where the triangle has no area.
    pub fn radians(&self) -> f64 {
        elementary::atan2(self.sine_sq.sqrt(), self.cosine)
    }
}

/// The smallest interior angle \[rad\] of a triangle; zero where it has no area.
pub fn smallest_angle(x: [DVec3; 3]) -> f64 {
    SmallestAngle::new(x).radians()
}
