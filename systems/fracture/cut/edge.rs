//! Edge mode: a tear along existing edges that stays near an ideal point, which moves as the criterion wants.

use crate::event::Course;
use crate::math::elementary;
use crate::storage::Mesh;
use crate::systems::fracture::cut::advance::Opening;
use crate::systems::fracture::{Advance, Cutter, Quality, TearRefusal, TipChart, Way, Ways};
use glam::{DVec2, DVec3};

/// The edge to open next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgePlan {
    /// Row of the vertex at its end.
    pub reaches: u32,
    /// Angle \[rad\] between the direction and the edge.
    pub deviation: f64,
    /// Position that the tear would then have \[mm, rest shape\] if it could leave the edges.
    pub ideal: DVec3,
}

/// An advance in edge mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeAdvance {
    /// The advance.
    pub advance: Advance,
    /// The new ideal point \[mm, rest shape\]. The previous direction of the next decision is the direction that was asked for,
    /// not that of the edge.
    pub ideal: DVec3,
}

/// The edge that leads forward, turning by at most `quality.widest_edge`, and ends nearest to the ray from the ideal
/// point; of equal ones the one that gains more, then the one that comes first counter-clockwise.
///
/// # Errors
/// [`TearRefusal::NoForwardEdge`].
pub fn plan_edge(
    mesh: &Mesh<'_>,
    tip: &TipChart,
    ideal: DVec3,
    direction: DVec2,
    quality: &Quality,
) -> Result<EdgePlan, TearRefusal> {
    let [e1, e2] = tip.chart.axes();
    let apex = mesh.vertices.rest_position[tip.vertex as usize];
    let start = DVec2::new((ideal - apex).dot(e1), (ideal - apex).dot(e2));
    let forward = elementary::cos(quality.widest_edge);
    let mut best: Option<(f64, f64, usize)> = None;
    for spoke in (0..tip.spoke_count()).filter(|&spoke| tip.is_inside(spoke)) {
        let end = tip.chart.spoke(spoke);
        let gain = (end - start).dot(direction);
        if end.dot(direction) < forward * end.length() || gain <= 0.0 {
            continue;
        }
        let miss = direction.perp_dot(end - start).abs();
        // Roundings must not make mirror images different.
        let tie = 1e-9 * end.length();
        let is_better = |(m, g, _): (f64, f64, usize)| miss < m - tie || (miss <= m + tie && gain > g + tie);
        if best.is_none_or(is_better) {
            best = Some((miss, gain, spoke));
        }
    }
    let refusal = TearRefusal::NoForwardEdge { vertex: tip.vertex };
    let (_, gain, spoke) = best.ok_or(refusal)?;
    let end = tip.chart.spoke(spoke);
    let reaches = tip.end(mesh, spoke).ok_or(refusal)?;
    // From the vertex reached, so that the point stays near a curved surface.
    let aside = start + direction * gain - end;
    let ideal = mesh.vertices.rest_position[reaches as usize] + e1 * aside.x + e2 * aside.y;
    Ok(EdgePlan { reaches, deviation: elementary::turn(end, direction).abs(), ideal })
}

impl Cutter<'_, '_> {
    /// Advances a tear in edge mode by one edge, from its ideal point in a unit direction of the rest shape.
    ///
    /// # Errors
    /// Why it does not advance; the mesh is as it was.
    pub fn advance_along_edge(
        &mut self,
        vertex: u32,
        ideal: DVec3,
        direction: DVec3,
    ) -> Result<EdgeAdvance, TearRefusal> {
        let tip = TipChart::new(self.mesh, vertex)?;
        self.advance_along_edge_from(&tip, ideal, direction)
    }

    /// Advances a tear along mesh edges from a tip whose chart fits the present mesh.
    ///
    /// # Errors
    /// As [`advance_along_edge`](Self::advance_along_edge).
    pub fn advance_along_edge_from(
        &mut self,
        tip: &TipChart,
        ideal: DVec3,
        direction: DVec3,
    ) -> Result<EdgeAdvance, TearRefusal> {
        if tip.fan.is_closed {
            return Err(TearRefusal::NotATip { vertex: tip.vertex });
        }
        let plan = plan_edge(self.mesh, tip, ideal, tip.chart.to_chart(direction), &self.quality)?;
        let ways = Ways::only(Way::along_edge(plan.reaches, plan.deviation, Course::Edge));
        // Nothing is to be flipped here: edge mode keeps the triangles it finds.
        let flip = std::mem::replace(&mut self.quality.flip, 0.0);
        let advance = self.take(tip, &ways, &Opening::After(&[tip.vertex]));
        self.quality.flip = flip;
        Ok(EdgeAdvance { advance: advance?, ideal: plan.ideal })
    }
}
