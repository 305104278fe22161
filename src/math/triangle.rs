//! The rest triangle: its frame along the fibre, its area and the gradients of its shape functions.

use glam::{DVec2, DVec3};

/// What the mechanics needs of a triangle's rest shape. The frame's first axis is the fibre, so the fibre appears nowhere
/// else: it lives in the gradients.
#[derive(Clone, Copy, Debug, PartialEq)]
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

/// The smallest interior angle \[rad\] of a triangle; zero where it has no area.
pub fn smallest_angle(x: [DVec3; 3]) -> f64 {
    // It stands opposite to the shortest side, so one arctangent will do.
    let side_sq = |i: usize| x[(i + 1) % 3].distance_squared(x[(i + 2) % 3]);
    let sides = [side_sq(0), side_sq(1), side_sq(2)];
    let i = if sides[0] <= sides[1] && sides[0] <= sides[2] { 0 } else { 1 + usize::from(sides[2] < sides[1]) };
    let (a, b) = (x[(i + 1) % 3] - x[i], x[(i + 2) % 3] - x[i]);
    a.cross(b).length().atan2(a.dot(b))
}
