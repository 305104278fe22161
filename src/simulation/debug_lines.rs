//! Hidden state of a body as coloured line segments: for debugging and teaching, made on request only.

use super::frame::RestToSpace;
use super::{Simulation, SimulationError};
use crate::components::{Contact, Grips, HoldTurns, Holds, Obstacle, TearDecisions};
use crate::math::elementary;
use crate::storage::{BodyId, Tips};
use crate::systems::fracture::{Surface, SurfaceQuery};
use glam::DVec3;

/// Kind of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum DebugKind {
    /// First axis of a triangle's frame, at right angles to the second: the fibre turned with the triangle, on one side only.
    FrameFibre,
    /// Second axis of a triangle's frame.
    FrameAcross,
    /// Normal of a triangle.
    Normal,
    /// The fibre through a triangle's centroid.
    Fibre,
    /// A principal stress that pulls.
    Tension,
    /// A principal stress that presses.
    Compression,
    /// The last direction of a tip.
    TipLast,
    /// The direction that the criterion prefers at a tip; as long as a triangle times the criterion's value.
    TipNext,
    /// From a vertex inside an obstacle to its surface.
    Contact,
    /// From a vertex to the point of the forceps that draws it.
    Grip,
    /// From a held vertex to where it is held, along held axes: it has length only where the body was not stepped since.
    Hold,
}

impl DebugKind {
    /// Red, green, blue, from 0 to 1: distinguishable by colour-blind eyes (Okabe, Ito 2008).
    pub fn colour(self) -> [f32; 3] {
        match self {
            Self::FrameFibre | Self::Tension => [0.84, 0.37, 0.0],
            Self::FrameAcross => [0.0, 0.62, 0.45],
            Self::Normal | Self::Compression => [0.0, 0.45, 0.7],
            Self::Fibre => [0.6, 0.6, 0.6],
            Self::TipLast => [0.0, 0.0, 0.0],
            Self::TipNext => [0.8, 0.47, 0.65],
            Self::Contact => [0.95, 0.9, 0.25],
            Self::Grip => [0.34, 0.71, 0.91],
            Self::Hold => [0.9, 0.62, 0.0],
        }
    }
}

/// A line segment in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DebugLine {
    /// One end \[mm\].
    pub from: DVec3,
    /// Second end of the line \[mm\].
    pub to: DVec3,
    /// Kind of the line.
    pub kind: DebugKind,
}

/// Which lines are wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DebugLines {
    /// Frames of the triangles: three lines each.
    pub frames: bool,
    /// Fibres: a line per triangle.
    pub fibres: bool,
    /// A cross of the principal stresses per triangle, each as long as the triangle at this stress \[MPa\].
    pub stress: Option<f64>,
    /// Tips.
    pub tips: bool,
    /// Contacts with obstacles.
    pub contacts: bool,
    /// Grips and holds.
    pub grips: bool,
}

impl DebugLines {
    /// All of them, with stress crosses as long as a triangle at so many MPa.
    pub fn all(stress: f64) -> Self {
        Self { frames: true, fibres: true, stress: Some(stress), tips: true, contacts: true, grips: true }
    }
}

impl Simulation {
    /// Adds the lines of a body to a buffer. Stresses are those now: this evaluates them.
    ///
    /// # Errors
    /// If there is no such body.
    pub fn debug_lines(
        &self,
        body: BodyId,
        which: &DebugLines,
        into: &mut Vec<DebugLine>,
    ) -> Result<(), SimulationError> {
        self.validate_tables_if_dirty(body)?;
        type Query<'a> = (
            SurfaceQuery<'a>,
            (
                Option<(&'a Tips, &'a TearDecisions)>,
                Option<&'a Contact>,
                Option<&'a Grips>,
                (Option<&'a Holds>, Option<&'a HoldTurns>),
            ),
        );
        let time = self.report.time;
        let mut query = self.world.query_one::<Query>(body.entity());
        let (surface, (tips, contact, grips, (holds, turns))) = query.get().map_err(|_| SimulationError::NoSuchBody)?;
        let surface = &Surface::of(surface);
        let vertices = surface.vertices;
        let mut push = |kind, from, to| into.push(DebugLine { from, to, kind });
        of_triangles(which, surface, &mut push);
        if let Some((tips, decisions)) = tips.filter(|_| which.tips) {
            of_tips(tips, decisions, surface, &mut push);
        }
        if which.contacts && contact.is_some() {
            for obstacle in &mut self.world.query::<&Obstacle>() {
                for &at in &vertices.position {
                    if let Some((depth, normal)) = obstacle.shape.distance(at).filter(|(distance, _)| *distance < 0.0) {
                        push(DebugKind::Contact, at, at - normal * depth);
                    }
                }
            }
        }
        for pinch in grips.filter(|_| which.grips).into_iter().flat_map(|grips| &grips.pinches) {
            for (row, target) in pinch.targets(pinch.pose(time)) {
                let Some(&at) = vertices.position.get(row as usize) else { continue };
                push(DebugKind::Grip, at, target);
            }
        }
        let holds = holds.filter(|_| which.grips).into_iter().flat_map(|holds| &holds.groups);
        for (place, hold) in holds.enumerate() {
            let turning = turns.and_then(|turns| turns.of(place)).map(|turning| (turning.at(time), turning.pivot));
            let held = DVec3::from_array(hold.axes.map(|a| f64::from(u8::from(a))));
            for (&row, &offset) in hold.members.rows().iter().zip(hold.members.values()) {
                let v = row as usize;
                let Some((&at, &rest)) = vertices.position.get(v).zip(vertices.rest_position.get(v)) else { continue };
                let rest = turning.map_or(rest, |(turn, pivot)| turn * (rest - pivot) + pivot);
                push(DebugKind::Hold, at, at + (rest + offset * hold.curve.at(time) - at) * held);
            }
        }
        Ok(())
    }
}

fn of_triangles(which: &DebugLines, surface: &Surface<'_>, push: &mut impl FnMut(DebugKind, DVec3, DVec3)) {
    if !(which.frames || which.fibres || which.stress.is_some()) {
        return;
    }
    let Surface { vertices, triangles, .. } = surface;
    for t in 0..triangles.len() {
        let state = surface.state(t);
        let [a, b, c] = triangles.corners[t].map(|v| vertices.position[v as usize]);
        let (centre, size) = ((a + b + c) / 3.0, triangles.rest[t].area.sqrt());
        let (fibre, across) = (state.polar.fibre_axis, state.polar.transverse_axis);
        if which.frames {
            let axes = [
                (DebugKind::FrameFibre, fibre),
                (DebugKind::FrameAcross, across),
                (DebugKind::Normal, fibre.cross(across)),
            ];
            axes.into_iter().for_each(|(kind, axis)| push(kind, centre, centre + axis * (0.3 * size)));
        }
        if which.fibres {
            push(DebugKind::Fibre, centre - fibre * (0.4 * size), centre + fibre * (0.4 * size));
        }
        if let Some(full) = which.stress.filter(|full| *full > 0.0) {
            let angle = elementary::unit_at(state.stress.principal_angle());
            let (first, second) = state.stress.principal_values();
            let first_axis = fibre * angle.x + across * angle.y;
            let second_axis = across * angle.x - fibre * angle.y;
            for (value, axis) in [(first, first_axis), (second, second_axis)] {
                let kind = if value < 0.0 { DebugKind::Compression } else { DebugKind::Tension };
                let half = axis * (0.5 * size * value.abs() / full);
                push(kind, centre - half, centre + half);
            }
        }
    }
}

fn of_tips(
    tips: &Tips,
    decisions: &TearDecisions,
    surface: &Surface<'_>,
    push: &mut impl FnMut(DebugKind, DVec3, DVec3),
) {
    let Surface { vertices, triangles, topology, .. } = surface;
    for (tip, &vertex) in tips.vertex.iter().enumerate() {
        let at = vertices.position[vertex as usize];
        // The rotation of the tissue around the tip, by its first triangle.
        let Some(&entry) = topology.incident[vertex as usize].first() else { continue };
        let t = entry as usize / 3;
        let turn = RestToSpace::of_triangle(vertices, triangles, surface.state(t), t);
        let size = triangles.rest[t].area.sqrt();
        push(DebugKind::TipLast, at - turn.apply(tips.previous[tip]) * size, at);
        if let Some(decision) = decisions.tips.get(tip).copied().flatten().filter(|decision| decision.row == vertex) {
            push(DebugKind::TipNext, at, at + turn.apply(decision.direction) * (size * decision.value));
        }
    }
}
