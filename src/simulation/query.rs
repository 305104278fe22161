//! Queries of the surface: rays, nearest points.

use super::Simulation;
use crate::storage::{BodyId, TriangleKey, Triangles, VertexKey, Vertices};
use crate::systems::kernels::pick::{self, Picked};
use glam::DVec3;

/// A point of a body's surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The triangle.
    pub triangle: TriangleKey,
    /// Corners of the triangle.
    pub corners: [VertexKey; 3],
    /// Weights of the corners at the point, with sum 1.
    pub barycentric: [f64; 3],
    /// The point \[mm\].
    pub position: DVec3,
    /// Point of the tissue in the rest shape \[mm\]: where a [cut](Simulation::cut) or a grip is asked for.
    pub rest_position: DVec3,
    /// Unit normal of the triangle, from which its corners are seen counter-clockwise; zero for one without area.
    pub normal: DVec3,
    /// From the ray's origin along the ray, or from the point \[mm\].
    pub distance: f64,
}

/// Which shape of a surface is searched.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum At {
    /// As it lies now.
    Present,
    /// The rest shape.
    Rest,
}

impl Simulation {
    /// The first point within `max` \[mm\] where a ray meets a body's surface as it lies now, from either side. The direction may
    /// have any length. Looks at every triangle.
    ///
    /// `None` where it meets nothing, for an origin or direction that is not finite, and where there is no such body.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// let hit = simulation.cast_ray(body, DVec3::new(5.0, 5.0, 9.0), DVec3::NEG_Z, 20.0).expect("tissue");
    /// assert!((hit.distance - 9.0).abs() < 1e-9);
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn cast_ray(&self, body: BodyId, origin: DVec3, direction: DVec3, max: f64) -> Option<Hit> {
        self.pick(body, At::Present, |positions, corners| pick::meet(positions, corners, origin, direction, max))
    }

    /// The point of a body's surface as it lies now that is nearest to a point, no farther than `within` \[mm\]. Looks at
    /// every triangle.
    ///
    /// `None` where the surface is farther away, for a point that is not finite, and where there is no such body.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// let hit = simulation.nearest(body, DVec3::new(5.0, 5.0, 0.3), 1.0).expect("tissue");
    /// assert!((hit.distance - 0.3).abs() < 1e-9);
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn nearest(&self, body: BodyId, point: DVec3, within: f64) -> Option<Hit> {
        self.pick(body, At::Present, |positions, corners| pick::nearest(positions, corners, point, within))
    }

    /// The point of a surface that a search finds.
    pub(super) fn pick(
        &self,
        body: BodyId,
        at: At,
        pick: impl FnOnce(&[DVec3], &[[u32; 3]]) -> Option<Picked>,
    ) -> Option<Hit> {
        let mut query = self.world.query_one::<(&Vertices, &Triangles)>(body.entity());
        let (vertices, triangles) = query.get().ok()?;
        let searched = if at == At::Rest { &vertices.rest_position } else { &vertices.position };
        let Picked { triangle, weights, position, distance } = pick(searched, &triangles.corners)?;
        let rows = triangles.corners[triangle as usize];
        let [a, b, c] = rows.map(|row| vertices.position[row as usize]);
        let blend = |[a, b, c]: [DVec3; 3]| a * weights[0] + b * weights[1] + c * weights[2];
        let rest = rows.map(|row| vertices.rest_position[row as usize]);
        let [Some(p), Some(q), Some(r)] = rows.map(|row| vertices.key(row)) else { return None };
        Some(Hit {
            triangle: triangles.key(triangle)?,
            corners: [p, q, r],
            barycentric: weights,
            position: if at == At::Rest { blend([a, b, c]) } else { position },
            rest_position: blend(rest),
            normal: (b - a).cross(c - a).normalize_or_zero(),
            distance,
        })
    }
}
