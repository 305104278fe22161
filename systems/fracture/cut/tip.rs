//! The fan of a vertex with its chart: where a tear may go from here.

use crate::storage::{Fan, Mesh, Topology, Triangles, Vertices};
use crate::systems::fracture::TearRefusal;
use crate::systems::kernels::fan::FanChart;
use glam::DVec3;
use smallvec::SmallVec;

/// The triangles around a vertex with their layout in a plane.
#[derive(Clone, Debug)]
pub struct TipChart {
    /// Row of the vertex.
    pub vertex: u32,
    /// The triangles around the vertex.
    pub fan: Fan,
    /// Layout of the triangles in a plane.
    pub chart: FanChart,
}

impl TipChart {
    /// The chart at a vertex.
    ///
    /// # Errors
    /// [`TearRefusal::NoFan`].
    pub fn new(mesh: &Mesh<'_>, vertex: u32) -> Result<Self, TearRefusal> {
        let refusal = TearRefusal::NoFan { vertex };
        let tables = (&*mesh.vertices, &*mesh.triangles, &*mesh.topology);
        let (fan, chart) = fan_chart(tables, vertex).ok_or(refusal)?;
        Ok(Self { vertex, fan, chart })
    }

    /// Row of the vertex at the end of a spoke.
    pub fn end(&self, mesh: &Mesh<'_>, spoke: usize) -> Option<u32> {
        end(mesh.triangles, &self.fan, spoke)
    }

    /// Number of different spokes.
    pub fn spoke_count(&self) -> usize {
        self.chart.spoke_count() - usize::from(self.chart.is_closed())
    }

    /// Whether a spoke has triangles on both sides, so that it can be opened.
    pub fn is_inside(&self, spoke: usize) -> bool {
        self.fan.is_closed || (spoke > 0 && spoke < self.fan.sectors.len())
    }
}

/// The triangles around a vertex and their layout; `None` where there is no such vertex or its triangles have no area.
pub(in crate::systems::fracture) fn fan_chart(
    (vertices, triangles, topology): (&Vertices, &Triangles, &Topology),
    vertex: u32,
) -> Option<(Fan, FanChart)> {
    let &apex = vertices.rest_position.get(vertex as usize)?;
    let fan = topology.fan(vertex);
    let count = fan.sectors.len() + usize::from(!fan.is_closed);
    let spokes: SmallVec<[DVec3; 14]> = (0..count)
        .filter_map(|spoke| Some(vertices.rest_position[end(triangles, &fan, spoke)? as usize] - apex))
        .collect();
    let chart = FanChart::new(&spokes, fan.is_closed)?;
    Some((fan, chart))
}

/// Spoke `k` runs along the first side of sector `k`; the last one along the second side of the last sector.
fn end(triangles: &Triangles, fan: &Fan, spoke: usize) -> Option<u32> {
    let (sector, side) = if spoke < fan.sectors.len() { (spoke, 1) } else { (fan.sectors.len().checked_sub(1)?, 2) };
    let (triangle, corner) = *fan.sectors.get(sector)?;
    Some(triangles.corners[triangle as usize][(corner + side) % 3])
}
