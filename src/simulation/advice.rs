//! Advice where no static equilibrium was found.

use super::Simulation;
use crate::components::{Bending, Body, Contact, Grips, Holds, Planar, PreStretch, Springs};
use crate::storage::{BodyId, Topology, Triangles, Vertices};
use glam::DVec3;

/// A body whose vertices lie this near to one plane, as a part of its extent, is flat.
const FLAT_BODY: f64 = 1e-9;

/// A triangle whose compressive stress is above this part of the body's largest stress is in compression.
const COMPRESSED: f64 = 0.01;

impl Simulation {
    /// Sentence on the obstacle to a body's equilibrium, where that is plain.
    pub(super) fn advice(&self, body: BodyId) -> Option<String> {
        self.free_piece(body).or_else(|| self.slack_sheet(body))
    }

    /// Names a piece that nothing holds.
    fn free_piece(&self, body: BodyId) -> Option<String> {
        type Query<'a> = (
            (&'a Body, &'a Vertices, &'a Triangles, &'a Topology),
            (Option<&'a Holds>, Option<&'a Springs>, Option<&'a Grips>, Option<&'a Contact>),
        );
        let mut query = self.world.query_one::<Query>(body.entity());
        let ((body, vertices, triangles, topology), (holds, springs, grips, contact)) = query.get().ok()?;
        if contact.is_some() || grips.is_some() {
            // Obstacles and jaws may hold a piece.
            return None;
        }
        let (count, pieces) = topology.components();
        let mut is_held = vec![false; count];
        let held = holds.iter().flat_map(|holds| &holds.groups).flat_map(|hold| hold.members.rows());
        let sprung = springs.iter().flat_map(|springs| springs.anchors.rows());
        for &row in held.chain(sprung) {
            let around = topology.incident.get(row as usize).into_iter().flatten();
            around.for_each(|&corner| is_held[pieces[corner as usize / 3] as usize] = true);
        }
        let free = is_held.iter().position(|held| !held)?;
        let of_piece = || pieces.iter().zip(triangles.corners.iter()).filter(|(piece, _)| **piece as usize == free);
        let triangle_count = of_piece().count();
        let corners = || of_piece().flat_map(|(_, corners)| corners).map(|&v| vertices.rest_position[v as usize]);
        let vertex = of_piece().flat_map(|(_, corners)| corners).min().copied().unwrap_or(0);
        let centre = corners().sum::<DVec3>() / (3 * triangle_count) as f64;
        Some(format!(
            "piece {free} of {count} of body `{}`, {triangle_count} triangle(s) with vertex {vertex} about ({:.3}, {:.3}, {:.3}) \
             mm, is held by nothing: hold it, give it springs, or leave it out",
            body.name, centre.x, centre.y, centre.z
        ))
    }

    /// Says of a sheet without stiffness across its plane that it is one.
    fn slack_sheet(&self, body: BodyId) -> Option<String> {
        type Query<'a> = (&'a Body, &'a Vertices, Option<&'a Planar>, Option<&'a Bending>, Option<&'a PreStretch>);
        let mut query = self.world.query_one::<Query>(body.entity());
        let (body, vertices, planar, bending, pre_stretch) = query.get().ok()?;
        if planar.is_some() || bending.is_some() || pre_stretch.is_some() || !is_flat(&vertices.position) {
            return None;
        }
        Some(format!(
            "body `{}` is a flat sheet without tension, which has no stiffness across its plane: give it `bending = {{}}` or a \
             `pre_stretch`, begin out of the plane, or keep it in it by `planar = true`",
            body.name
        ))
    }

    /// Says of a membrane without bending that part of it is in compression, as it is now.
    pub(super) fn compression(&self, body: BodyId) -> Option<String> {
        type Query<'a> = (&'a Body, Option<&'a Planar>, Option<&'a Bending>);
        let mut query = self.world.query_one::<Query>(body.entity());
        let (about, planar, bending) = query.get().ok()?;
        if planar.is_some() || bending.is_some() {
            return None;
        }
        let frames = &self.present_frames(body).ok()?;
        let stresses: Vec<(f64, f64)> = frames.states().map(|state| state.stress.principal_values()).collect();
        let largest = stresses.iter().map(|(high, low)| high.abs().max(low.abs())).fold(0.0, f64::max);
        let count = stresses.iter().filter(|(_, low)| *low < -COMPRESSED * largest).count();
        (count > 0).then(|| {
            format!(
                "{count} of {} triangles of body `{}` are in compression, where a membrane without bending buckles: give it \
                 `bending = {{}}` or a `pre_stretch`, or use a dynamic run",
                stresses.len(),
                about.name
            )
        })
    }
}

/// General advice for any body; `is_used_up` where the iterations were used up, without coming nearer.
pub(super) fn in_general(is_used_up: bool) -> String {
    let iterations = if is_used_up { "the iterations are used up and the imbalance no longer falls: " } else { "" };
    format!("{iterations}use smaller load steps, more holds, or a dynamic run")
}

/// Whether points lie in one plane.
fn is_flat(points: &[DVec3]) -> bool {
    let Some(&first) = points.first() else { return false };
    let offsets = || points.iter().map(|p| *p - first);
    let longest = offsets().max_by(|a, b| a.length_squared().total_cmp(&b.length_squared())).unwrap_or(DVec3::ZERO);
    let normals = offsets().map(|offset| longest.cross(offset));
    let normal = normals.max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
    let normal = normal.unwrap_or(DVec3::ZERO).normalize_or_zero();
    offsets().all(|offset| offset.dot(normal).abs() <= FLAT_BODY * longest.length())
}
