//! Dead loads: forces that keep their direction in space.

use crate::components::BodyError;
use crate::components::Curve;
use crate::components::check::{Check, Host, finite};
use crate::storage::{Edit, EditRecord, Topology, Triangles};
use glam::DVec3;

/// Forces on single vertices. *Parameter.*
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
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
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct PointLoads {
    /// The loads.
    pub groups: Vec<PointLoad>,
}

impl PointLoads {
    /// Follows an edit: a loaded vertex keeps its load, and one that is collapsed hands it on to the vertex it goes into.
    pub fn follow(&mut self, record: &EditRecord) {
        for row in self.groups.iter_mut().flat_map(|group| &mut group.rows) {
            *row = record.heir(*row);
        }
    }
}

/// A force per rest length along boundary edges, shared equally by each edge's ends. *Parameter.*
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
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
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct EdgeLoads {
    /// The loads.
    pub groups: Vec<EdgeLoad>,
}

impl EdgeLoads {
    /// Follows an edit. A loaded edge that was split is loaded in both halves, and one whose ends an opening renamed under its new
    /// ends. Of two that a collapse joins the whole is loaded if the part that stays was.
    pub fn follow(&mut self, record: &EditRecord) {
        for (row, parents) in record.created().filter(|_| record.has_split_boundary()) {
            let [from, to] = *parents.rows() else { continue };
            for edges in self.groups.iter_mut().map(|group| &mut group.edges) {
                if let Some(place) = edges.iter().position(|&[a, b]| [a, b] == [from, to] || [b, a] == [from, to]) {
                    let [a, b] = edges[place];
                    edges[place] = [a, row];
                    edges.push([row, b]);
                }
            }
        }
        if let Edit::Open { .. } = record.edit {
            for edge in self.groups.iter_mut().flat_map(|group| &mut group.edges) {
                *edge = renamed(record, *edge);
            }
        }
        if record.removed.is_some() {
            for edges in self.groups.iter_mut().map(|group| &mut group.edges) {
                for edge in &mut *edges {
                    *edge = edge.map(|row| record.heir(row));
                }
                edges.retain(|[a, b]| a != b);
            }
        }
    }
}

/// The ends of a boundary edge after an opening: those of the one triangle that it belongs to.
fn renamed(record: &EditRecord, [a, b]: [u32; 2]) -> [u32; 2] {
    for changed in &record.changed_triangles {
        let before = changed.before.corners;
        for i in 0..3 {
            let j = (i + 1) % 3;
            if [before[i], before[j]] == [a, b] {
                return [changed.corners[i], changed.corners[j]];
            }
            if [before[j], before[i]] == [a, b] {
                return [changed.corners[j], changed.corners[i]];
            }
        }
    }
    [a, b]
}

impl Check for PointLoads {
    fn check(&self, host: &Host<'_>) -> Result<(), BodyError> {
        for (k, load) in self.groups.iter().enumerate() {
            host.rows("PointLoads", || format!("load {k}"), &load.rows)?;
            check_numbers("PointLoads", (k, "force", load.force), &load.curve)?;
        }
        Ok(())
    }
}

impl Check for EdgeLoads {
    fn check(&self, host: &Host<'_>) -> Result<(), BodyError> {
        for (k, load) in self.groups.iter().enumerate() {
            let what = || format!("load {k}");
            host.rows("EdgeLoads", what, load.edges.as_flattened())?;
            check_numbers("EdgeLoads", (k, "traction", load.traction), &load.curve)?;
            let is_boundary = |edge: &&[u32; 2]| host.surface.is_none_or(|surface| is_on_boundary(surface, **edge));
            if let Some(&edge) = load.edges.iter().find(|edge| !is_boundary(edge)) {
                return Err(BodyError::NoSuchEdge { component: "EdgeLoads", what: what(), edge });
            }
        }
        Ok(())
    }
}

/// Judges the numbers of one load.
fn check_numbers(
    component: &'static str,
    (number, what, value): (usize, &'static str, DVec3),
    curve: &Curve,
) -> Result<(), BodyError> {
    let checked = finite(component, what, value.to_array()).and_then(|()| curve.check(component));
    checked.map_err(|source| BodyError::Load { number, source: Box::new(source) })
}

/// Whether exactly one triangle has an edge: those inside would not follow when they are split.
fn is_on_boundary((triangles, topology): (&Triangles, &Topology), [a, b]: [u32; 2]) -> bool {
    let has_both = |&&entry: &&u32| {
        let corners = triangles.corners.get(entry as usize / 3);
        a != b && corners.is_some_and(|corners| corners.contains(&b))
    };
    topology.incident.get(a as usize).is_some_and(|around| around.iter().filter(has_both).count() == 1)
}
