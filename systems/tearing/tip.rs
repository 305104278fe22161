//! The fan of a vertex with its chart: where a tear may go from here.

use super::TearRefusal;
use crate::storage::{Fan, Mesh};
use crate::systems::kernels::fan::FanChart;
use glam::DVec3;
use smallvec::SmallVec;

/// The triangles around a vertex with their layout in a plane.
#[derive(Clone, Debug)]
pub struct TipChart {
    /// Row of the vertex.
    pub vertex: u32,
    /// The triangles.
    pub fan: Fan,
    /// Their layout.
    pub chart: FanChart,
}

impl TipChart {
    /// The chart at a vertex.
    ///
    /// # Errors
    /// [`TearRefusal::NoFan`].
    pub fn new(mesh: &Mesh<'_>, vertex: u32) -> Result<Self, TearRefusal> {
        let refusal = TearRefusal::NoFan { vertex };
        let &apex = mesh.vertices.rest_position.get(vertex as usize).ok_or(refusal)?;
        let fan = mesh.topology.fan(vertex);
        let count = fan.sectors.len() + usize::from(!fan.is_closed);
        let spokes: SmallVec<[DVec3; 10]> =
            (0..count).filter_map(|k| Some(mesh.vertices.rest_position[end(mesh, &fan, k)? as usize] - apex)).collect();
        let chart = FanChart::new(&spokes, fan.is_closed).ok_or(refusal)?;
        Ok(Self { vertex, fan, chart })
    }

    /// Row of the vertex at the end of a spoke.
    pub fn end(&self, mesh: &Mesh<'_>, spoke: usize) -> Option<u32> {
        end(mesh, &self.fan, spoke)
    }

    /// Whether a spoke has triangles on both sides, so that it can be opened.
    pub fn is_inside(&self, spoke: usize) -> bool {
        self.fan.is_closed || (spoke > 0 && spoke < self.fan.sectors.len())
    }
}

/// Spoke `k` runs along the first side of sector `k`; the last one along the second side of the last sector.
fn end(mesh: &Mesh<'_>, fan: &Fan, spoke: usize) -> Option<u32> {
    let (sector, side) = if spoke < fan.sectors.len() { (spoke, 1) } else { (fan.sectors.len().checked_sub(1)?, 2) };
    let (triangle, corner) = *fan.sectors.get(sector)?;
    Some(mesh.triangles.corners[triangle as usize][(corner + side) % 3])
}
