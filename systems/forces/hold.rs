//! Prescribed motion of vertices: holds, and jaws without a stiffness.

use crate::components::{
    Grips, Guide, Hold, HoldGuides, HoldTurns, Holds, Increment, Pinch, Planar, SolverScratch, Turning,
};
use crate::storage::Vertices;
use glam::DVec3;

/// Query of holds, with their turns and guides.
pub type Held<'a> = (Option<&'a Holds>, Option<&'a HoldTurns>, Option<&'a HoldGuides>);

/// Query of prescribed motion: holds, and jaws that are a constraint.
pub type Prescription<'a> = (Held<'a>, Option<&'a mut Grips>);

/// Marks the free axes, and puts a part of the remaining prescribed motion into the initial guess.
pub fn mark_axes(
    vertices: &Vertices,
    increment: &mut Increment,
    scratch: &mut SolverScratch,
    ((holds, turns, guides), grips): Prescription<'_>,
    planar: Option<&Planar>,
    (time, part): (f64, f64),
) {
    let free_axes = if planar.is_some() { DVec3::new(1.0, 1.0, 0.0) } else { DVec3::ONE };
    scratch.guide_constraints.clear();
    scratch.free.reset(vertices.len(), vertices.position.capacity(), free_axes);
    if planar.is_some() {
        increment.delta.iter_mut().for_each(|d| d.z = 0.0);
    }
    for (place, hold) in holds.map(|h| h.groups.as_slice()).unwrap_or_default().iter().enumerate() {
        let guide = guides.and_then(|guides| guides.of(place));
        if let Some(guide) = guide {
            scratch.guide_constraints.add(hold, guide, planar, time);
        }
        for (v, way) in ways(vertices, hold, turns.and_then(|turns| turns.of(place)), time) {
            let (wanted, guess) = (way * part, increment.delta[v]);
            let (axes, wanted) = match guide {
                None => (hold.axes, wanted),
                Some(Guide::Across(n)) => ([true; 3], guess + *n * n.dot(wanted - guess)),
                Some(Guide::Along(d)) => ([true; 3], wanted + *d * d.dot(guess - wanted)),
                // They come to one displacement from the rest shape below.
                Some(Guide::Together { .. }) => (hold.axes, guess + vertices.position[v] - vertices.rest_position[v]),
            };
            for axis in (0..3).filter(|&axis| axes[axis] && !(planar.is_some() && axis == 2 && guide.is_some())) {
                scratch.free.prescribe(v, axis);
                increment.delta[v][axis] = wanted[axis];
            }
        }
    }
    if !scratch.guide_constraints.is_empty() {
        level(vertices, increment, scratch, (holds, guides));
    }
    for pinch in grips.map(|g| g.pinches.as_mut_slice()).unwrap_or_default() {
        mark_pinched(vertices, increment, scratch, pinch, (time, part));
    }
}

/// Ways \[mm\] of a hold's vertices from where they are to where it wants them at a time \[ms\].
fn ways<'a>(
    vertices: &'a Vertices,
    hold: &'a Hold,
    turning: Option<&Turning>,
    time: f64,
) -> impl Iterator<Item = (usize, DVec3)> + 'a {
    let factor = hold.curve.at(time);
    let turning = turning.map(|turning| (turning.at(time), turning.pivot));
    hold.members.rows().iter().zip(hold.members.values()).map(move |(&row, &offset)| {
        let v = row as usize;
        let rest = vertices.rest_position[v];
        let turned = turning.map_or(rest, |(turn, pivot)| turn * (rest - pivot) + pivot);
        (v, turned + offset * factor - vertices.position[v])
    })
}

/// Largest distance \[mm\] of a vertex from where its hold, or jaws without a stiffness, want it at a time \[ms\].
pub fn behind(vertices: &Vertices, ((holds, turns, guides), grips): (Held<'_>, Option<&Grips>), time: f64) -> f64 {
    let mut most: f64 = 0.0;
    for (place, hold) in holds.map(|holds| holds.groups.as_slice()).unwrap_or_default().iter().enumerate() {
        let axes = DVec3::from_array(hold.axes.map(|axis| f64::from(u8::from(axis))));
        for (_, way) in ways(vertices, hold, turns.and_then(|turns| turns.of(place)), time) {
            let way = match guides.and_then(|guides| guides.of(place)) {
                None => way * axes,
                Some(Guide::Across(n)) => *n * n.dot(way),
                Some(Guide::Along(d)) => way - *d * d.dot(way),
                Some(Guide::Together { .. }) => DVec3::ZERO,
            };
            most = most.max(way.length());
        }
    }
    let pinches = grips.iter().flat_map(|grips| &grips.pinches).filter(|pinch| pinch.is_constraint());
    let targets = pinches.flat_map(|pinch| pinch.targets(pinch.motion.at(time)));
    targets.map(|(row, target)| target.distance(vertices.position[row as usize])).fold(most, f64::max)
}

/// Makes the displacements of vertices that move alike one, and of these again the rest of the step.
fn level(
    vertices: &Vertices,
    increment: &mut Increment,
    scratch: &SolverScratch,
    (holds, guides): (Option<&Holds>, Option<&HoldGuides>),
) {
    scratch.guide_constraints.level(&mut increment.delta);
    let (Some(holds), Some(guides)) = (holds, guides) else { return };
    for (place, hold) in holds.groups.iter().enumerate() {
        let Some(Guide::Together { .. }) = guides.of(place) else { continue };
        for &row in hold.members.rows() {
            let v = row as usize;
            let gone = vertices.position[v] - vertices.rest_position[v];
            let free = scratch.free[v];
            increment.delta[v] -=
                gone * (DVec3::ONE - free) * DVec3::from_array(hold.axes.map(|a| f64::from(u8::from(a))));
        }
    }
}

/// Prescribes the vertices held by jaws without a stiffness, along the axes that nothing else prescribes.
fn mark_pinched(
    vertices: &Vertices,
    increment: &mut Increment,
    scratch: &mut SolverScratch,
    pinch: &mut Pinch,
    (time, part): (f64, f64),
) {
    let mut prescribed = std::mem::take(&mut pinch.prescribed);
    prescribed.clear();
    if pinch.is_constraint() {
        for (row, target) in pinch.targets(pinch.motion.at(time)) {
            let v = row as usize;
            let axes = scratch.free[v];
            scratch.free.set(v, DVec3::ZERO);
            let wanted = (target - vertices.position[v]) * part;
            increment.delta[v] = DVec3::select(axes.cmpgt(DVec3::ZERO), wanted, increment.delta[v]);
            prescribed.push(axes);
        }
    }
    pinch.prescribed = prescribed;
}
