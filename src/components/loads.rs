//! Dead loads: forces that keep their direction in space.

use super::Curve;
use glam::DVec3;

/// Forces on single vertices. *Parameter.*
#[derive(Clone, Debug, PartialEq)]
pub struct PointLoad {
    /// Vertex rows.
    pub rows: Vec<u32>,
    /// Force on each of them at curve value 1 \[N\].
    pub force: DVec3,
    /// Factor over time.
    pub curve: Curve,
}

/// All point loads of a body. *Parameter.*
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointLoads {
    /// The loads.
    pub groups: Vec<PointLoad>,
}

/// A force per rest length along boundary edges, shared equally by each edge's ends. *Parameter.*
#[derive(Clone, Debug, PartialEq)]
pub struct EdgeLoad {
    /// Vertex rows of the edges.
    pub edges: Vec<[u32; 2]>,
    /// Force per rest length at curve value 1 \[N/mm\].
    pub traction: DVec3,
    /// Factor over time.
    pub curve: Curve,
}

/// All edge loads of a body. *Parameter.*
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EdgeLoads {
    /// The loads.
    pub groups: Vec<EdgeLoad>,
}
