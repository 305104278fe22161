//! Contents of a simulation: tips, fragments, obstacles, tools, and where a point of the tissue is now.

use super::query::At;
use super::{Hit, Simulation, SimulationError};
use crate::components::{Blade, Forceps, Obstacle};
use crate::registry::{validate, validate_all};
use crate::storage::{BodyId, ObstacleId, TipKey, Tips, Triangles, VertexKey, Vertices};
use crate::systems::kernels::pick;
use glam::DVec3;
use hecs::{Component, Entity};

/// A tear tip of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tip {
    /// Key of the tip, as events name it.
    pub key: TipKey,
    /// The vertex at which it stands.
    pub vertex: VertexKey,
    /// Where that is now \[mm\].
    pub position: DVec3,
    /// Where that is in the rest shape \[mm\].
    pub rest_position: DVec3,
    /// Unit direction of its last advance in the rest shape.
    pub direction: DVec3,
}

/// The fragments into which a body has come apart, numbered by their first triangle.
#[derive(Clone, Debug, PartialEq)]
pub struct Fragments {
    /// The fragment of every triangle, by row.
    pub of_triangle: Vec<u32>,
    /// The fragment of every vertex, by row; `u32::MAX` for one without a triangle.
    pub of_vertex: Vec<u32>,
    /// Area of every fragment in the rest shape \[mm²\].
    pub areas: Vec<f64>,
}

impl Fragments {
    fn of(vertex_count: usize, triangles: &Triangles) -> Self {
        // The first vertex that each is known to hang together with.
        let mut first: Vec<u32> = (0..vertex_count as u32).collect();
        let find = |first: &mut [u32], vertex: u32| {
            let mut v = vertex;
            while first[v as usize] != v {
                first[v as usize] = first[first[v as usize] as usize];
                v = first[v as usize];
            }
            v
        };
        for &[a, b, c] in &triangles.corners {
            let [a, b, c] = [a, b, c].map(|v| find(&mut first, v));
            let least = a.min(b).min(c);
            [a, b, c].into_iter().for_each(|v| first[v as usize] = least);
        }
        let mut fragments =
            Self { of_triangle: Vec::new(), of_vertex: vec![u32::MAX; vertex_count], areas: Vec::new() };
        let mut number = vec![u32::MAX; vertex_count];
        for (corners, rest) in triangles.corners.iter().zip(&triangles.rest) {
            let root = find(&mut first, corners[0]) as usize;
            if number[root] == u32::MAX {
                number[root] = fragments.areas.len() as u32;
                fragments.areas.push(0.0);
            }
            fragments.of_triangle.push(number[root]);
            fragments.areas[number[root] as usize] += rest.area;
            corners.iter().for_each(|&v| fragments.of_vertex[v as usize] = number[root]);
        }
        fragments
    }

    /// Number of fragments.
    pub fn count(&self) -> usize {
        self.areas.len()
    }
}

impl Simulation {
    /// The fragments into which a body has come apart.
    ///
    /// # Errors
    /// If there is no such body.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// simulation.cut(body, &[DVec3::new(5.0, -1.0, 0.0), DVec3::new(5.0, 11.0, 0.0)])?;
    /// assert_eq!(simulation.fragments(body)?.count(), 2);
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn fragments(&self, body: BodyId) -> Result<Fragments, SimulationError> {
        let mut query = self.world.query_one::<(&Vertices, &Triangles)>(body.entity());
        let (vertices, triangles) = query.get().map_err(|_| SimulationError::NoSuchBody)?;
        Ok(Fragments::of(vertices.len(), triangles))
    }

    /// The tear tips of a body; none of one that does not tear.
    ///
    /// # Errors
    /// If there is no such body.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// simulation.cut(body, &[DVec3::new(0.0, 5.0, 0.0), DVec3::new(4.0, 5.0, 0.0)])?;
    /// assert_eq!(simulation.tips(body)?.len(), 1);
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn tips(&self, body: BodyId) -> Result<Vec<Tip>, SimulationError> {
        let mut query = self.world.query_one::<(&Vertices, Option<&Tips>)>(body.entity());
        let (vertices, tips) = query.get().map_err(|_| SimulationError::NoSuchBody)?;
        let Some(tips) = tips else { return Ok(Vec::new()) };
        let tip = |row: usize| {
            let vertex = tips.vertex[row] as usize;
            Some(Tip {
                key: tips.key(row as u32)?,
                vertex: vertices.key(tips.vertex[row])?,
                position: vertices.position[vertex],
                rest_position: vertices.rest_position[vertex],
                direction: tips.previous[row],
            })
        };
        Ok((0..tips.len()).filter_map(tip).collect())
    }

    /// All obstacles, in the order of their handles.
    pub fn obstacles(&self) -> Vec<ObstacleId> {
        self.carriers::<Obstacle>().into_iter().map(ObstacleId::from).collect()
    }

    /// All forceps and blades, in the order of their handles.
    pub fn tools(&self) -> Vec<Entity> {
        let mut tools = self.carriers::<Forceps>();
        tools.extend(self.carriers::<Blade>());
        tools.sort_by_key(|tool| tool.id());
        tools
    }

    fn carriers<C: Component>(&self) -> Vec<Entity> {
        let mut found: Vec<Entity> = self.world.query::<(Entity, &C)>().iter().map(|(entity, _)| entity).collect();
        found.sort_by_key(|entity| entity.id());
        found
    }

    /// Where the point of the tissue is now that lies nearest to a point \[mm\] of the rest shape: its `position`, triangle and weights.
    /// Where lips of a tear lie on each other in the rest shape, that of the first triangle. Looks at every triangle. `None` for a point
    /// that is not finite, and where there is no such body.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// let hit = simulation.current(body, DVec3::new(5.0, 5.0, 0.0)).expect("a body");
    /// println!("the middle is at {} now", hit.position);
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn current(&self, body: BodyId, rest_point: DVec3) -> Option<Hit> {
        self.pick(body, At::Rest, |rest, corners| pick::nearest(rest, corners, rest_point, f64::INFINITY))
    }

    /// Checks all bodies, obstacles and tools as the next step would: numbers, tables and consistency between components.
    ///
    /// # Errors
    /// Names the first entity, component and row that is refused, and the condition it must meet.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// simulation.validate()?;
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn validate(&self) -> Result<(), SimulationError> {
        let bodies = self.bodies();
        bodies.into_iter().try_for_each(|body| validate(&self.world, body.entity()))?;
        Ok(validate_all(&self.world)?)
    }
}
