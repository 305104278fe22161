//! Contribution of bending to the material force: the change of its energy under the shift of the rest shape, at fixed
//! positions.
//!
//! Its energy is ½·φ·Q·φ summed over triangles, with mid-edge normals turned by differences of moments
//! ([`DihedralAngles`](crate::systems::bending::DihedralAngles)). Laws Q and turns follow the shift; the angles between triangles do not. Those at rest
//! follow as the curvature at rest stays where it is.

use crate::components::Bending;
use crate::storage::{NONE, measure::rest_corners};
use crate::systems::fracture::Surface;
use crate::systems::kernels::bending::{self, EdgeMatrix, Tilt};
use glam::{DVec2, DVec3};

/// A triangle of the disc, or one that borders on it.
#[derive(Clone, Copy, Debug, Default)]
struct Bend {
    triangle: u32,
    /// Q \[N·mm\].
    law: EdgeMatrix,
    /// Change of the law Q by shifts along the axes of the disc \[N\].
    shifted: [EdgeMatrix; 2],
    /// Angles at rest, and the change of their halves by shifts along the axes of the disc, at a fixed curvature \[1/mm\].
    rest: DVec3,
    shifted_rest: [DVec3; 2],
    /// Per edge the entry of the triangle across and its edge, if it is listed, and the rotation of the normal per difference
    /// of moments.
    across: [Option<(u32, usize)>; 3],
    turn: DVec3,
    /// Tilt of the triangle at the current positions.
    tilt: Tilt,
    /// Half the deviations of the angles from those at rest, and the moments of these \[N\].
    half: DVec3,
    moment: DVec3,
    /// Half the deviations of the angles, and their moments \[N\], with the mid-edge normals turned.
    angles: DVec3,
    balanced: DVec3,
    /// The change of the whole energy by half of an angle \[N·mm\].
    slope: DVec3,
}

/// The triangles of a disc that bend.
#[derive(Clone, Debug, Default)]
pub(in crate::systems::fracture) struct ShiftedFolds {
    /// Bending for which the triangles were laid.
    bending: Option<Bending>,
    bends: Vec<Bend>,
    /// Buffer of triangles to be laid.
    listed: Vec<Listed>,
    /// Triangles across the outermost edges, to which there are angles.
    beyond: Vec<u32>,
}

/// A triangle to be laid, whether it is there for its neighbours alone, the gradient of its weight \[1/mm\] and the axis of its frame.
type Listed = (u32, bool, DVec2, DVec2);

/// Triangles for which there is room from the start.
const USUAL_FOLDS: usize = 512;

impl ShiftedFolds {
    /// Removes all laid triangles.
    pub(in crate::systems::fracture) fn clear(&mut self) {
        self.bending = None;
        self.bends.clear();
        self.beyond.clear();
    }

    /// Bending for which the triangles were laid, if they were.
    pub(in crate::systems::fracture) fn bending(&self) -> Option<Bending> {
        self.bending
    }

    /// Lays out triangles with the gradient of their weight \[1/mm\] and the axis of their own frame, both in the axes of the disc.
    pub(in crate::systems::fracture) fn lay(
        &mut self,
        surface: &Surface,
        bending: &Bending,
        listed: impl Iterator<Item = (u32, DVec2, DVec2)>,
    ) {
        let Surface { vertices, triangles, topology, .. } = *surface;
        self.bending = Some(*bending);
        self.bends.clear();
        self.bends.reserve(USUAL_FOLDS);
        self.beyond.reserve(USUAL_FOLDS);
        self.listed.clear();
        self.listed.reserve(4 * USUAL_FOLDS);
        self.listed.extend(listed.map(|(triangle, fall, fibre)| (triangle, false, fall, fibre)));
        self.beyond.clear();
        // Those around have a part in the moments that turn normals.
        for place in 0..self.listed.len() {
            let around = topology.neighbours[self.listed[place].0 as usize].into_iter().filter(|&n| n != NONE);
            self.listed.extend(around.map(|n| (n, true, DVec2::ZERO, DVec2::X)));
        }
        // Triangles of the disc come before those around it.
        self.listed.sort_unstable_by_key(|&(triangle, is_around, ..)| (triangle, is_around));
        self.listed.dedup_by_key(|&mut (triangle, ..)| triangle);
        for &(triangle, _, fall, fibre) in &self.listed {
            let t = triangle as usize;
            let (rest, stiffness, h) = (&triangles.rest[t], &triangles.stiffness[t], triangles.thickness[t]);
            let scale = bending.scale(stiffness, h);
            let own = |v: DVec2| DVec2::new(v.dot(fibre), fibre.perp_dot(v));
            let shifted =
                [DVec2::X, DVec2::Y].map(|d| bending::law_under_shift(rest, stiffness, scale, (own(fall), own(d))));
            let law = bending::law(rest, stiffness, scale);
            let normal = |t: u32| normal(rest_corners(vertices, triangles.corners[t as usize]));
            let edge = |e: usize| {
                let [from, to] = [e, (e + 1) % 3].map(|i| vertices.rest_position[triangles.corners[t][i] as usize]);
                to - from
            };
            let angles = [0, 1, 2].map(|e| match topology.neighbours[t][e] {
                NONE => 0.0,
                n => bending::angle(normal(triangle), normal(n), edge(e)),
            });
            let angles = DVec3::from_array(angles);
            let shifted_rest =
                [DVec2::X, DVec2::Y].map(|d| bending::angles_under_shift(rest, angles * 0.5, (own(fall), own(d))));
            self.bends.push(Bend { triangle, law, shifted, rest: angles, shifted_rest, ..Bend::default() });
        }
        for place in 0..self.bends.len() {
            let t = self.bends[place].triangle;
            for e in 0..3 {
                self.bends[place].turn[e] = bending::TURN / self.bends[place].law[e];
                let (n, to) = (topology.neighbours[t as usize][e], triangles.corners[t as usize][(e + 1) % 3]);
                let Ok(other) = self.bends.binary_search_by_key(&n, |bend| bend.triangle) else {
                    self.beyond.extend((n != NONE).then_some(n));
                    continue;
                };
                let Some(f) = triangles.corners[n as usize].iter().position(|&v| v == to) else { continue };
                let turn = bending::TURN / (self.bends[place].law[e] + self.bends[other].law[f]);
                self.bends[place].across[e] = Some((other as u32, f));
                self.bends[place].turn[e] = turn;
            }
        }
    }

    /// The triangles on which it depends.
    pub(in crate::systems::fracture) fn triangles(&self) -> impl Iterator<Item = u32> {
        self.bends.iter().map(|bend| bend.triangle).chain(self.beyond.iter().copied())
    }

    /// Finds angles and moments at the current positions, and the energy released per unit of shift along either axis \[N\].
    pub(in crate::systems::fracture) fn release(&mut self, surface: &Surface) -> DVec2 {
        let Surface { vertices, triangles, topology, .. } = *surface;
        let corners = |t: u32| triangles.corners[t as usize].map(|v| vertices.position[v as usize]);
        for bend in &mut self.bends {
            let least = bending::least_twice_area(triangles.rest[bend.triangle as usize].area);
            bend.tilt = Tilt::new(corners(bend.triangle), least);
        }
        for place in 0..self.bends.len() {
            let bend = &self.bends[place];
            let x = corners(bend.triangle);
            let half = [0, 1, 2].map(|e| {
                let across = match (bend.across[e], topology.neighbours[bend.triangle as usize][e]) {
                    // Either triangle sees the same angle.
                    (Some((other, f)), _) if (other as usize) < place => return self.bends[other as usize].half[f],
                    (Some((other, _)), _) => self.bends[other as usize].tilt.normal,
                    (None, NONE) => return 0.0,
                    (None, beyond) => normal(corners(beyond)),
                };
                0.5 * bending::shorter_way(
                    bending::angle(bend.tilt.normal, across, x[(e + 1) % 3] - x[e]) - bend.rest[e],
                )
            });
            let bend = &mut self.bends[place];
            bend.half = DVec3::from_array(half);
            bend.moment = bending::product(&bend.law, bend.half);
        }
        for place in 0..self.bends.len() {
            let bend = &self.bends[place];
            let angles = bend.half + self.turned(bend, |bend| bend.moment);
            self.bends[place].angles = angles;
            self.bends[place].balanced = bending::product(&self.bends[place].law, angles);
        }
        for place in 0..self.bends.len() {
            let bend = &self.bends[place];
            self.bends[place].slope =
                bending::product(&bend.law, bend.angles + self.turned(bend, |bend| bend.balanced));
        }
        let release = |axis: usize| -> f64 {
            self.bends.iter().map(|bend| self.straightened(bend, axis) - self.change(bend, axis)).sum()
        };
        DVec2::new(release(0), release(1))
    }

    /// The forces of bending on the corners of a triangle \[N\], as last found.
    pub(in crate::systems::fracture) fn forces(&self, triangle: u32) -> [DVec3; 3] {
        let Ok(place) = self.bends.binary_search_by_key(&triangle, |bend| bend.triangle) else {
            return [DVec3::ZERO; 3];
        };
        let bend = &self.bends[place];
        // Half an angle turns by half the tilt of either triangle.
        let moments = [0, 1, 2].map(|e| {
            bend.across[e].map_or(0.0, |(other, f)| 0.5 * (bend.slope[e] + self.bends[other as usize].slope[f]))
        });
        bend.tilt.along(DVec3::from_array(moments)).to_array().map(|along| bend.tilt.normal * -along)
    }

    /// Rotations of a triangle's mid-edge normals by the differences of moments. A free edge bears no moment.
    fn turned(&self, bend: &Bend, moment: impl Fn(&Bend) -> DVec3) -> DVec3 {
        let others = bend.across.map(|across| across.map_or(0.0, |(other, f)| moment(&self.bends[other as usize])[f]));
        (DVec3::from_array(others) - moment(bend)) * bend.turn
    }

    /// Energy that the angles at rest release \[N\] as they change by a unit of shift along an axis: each has its change from the curvature
    /// of either triangle.
    fn straightened(&self, bend: &Bend, axis: usize) -> f64 {
        let own = bend.shifted_rest[axis];
        let change = [0, 1, 2].map(|e| {
            bend.across[e].map_or(0.0, |(other, f)| 0.5 * (own[e] + self.bends[other as usize].shifted_rest[axis][f]))
        });
        bend.slope.dot(DVec3::from_array(change))
    }

    /// Change of ½·φ·Q·φ of a triangle \[N\] by a unit of shift along an axis. Of the angles φ half of those to its neighbours
    /// are fixed; the rotations of the mid-edge normals by the difference of the moments M are not.
    fn change(&self, bend: &Bend, axis: usize) -> f64 {
        let shifted = |bend: &Bend| bending::product(&bend.shifted[axis], bend.half);
        let mut changes = self.turned(bend, shifted);
        for e in 0..3 {
            let stiffer = bend.shifted[axis][e]
                + bend.across[e].map_or(0.0, |(other, f)| self.bends[other as usize].shifted[axis][f]);
            changes[e] -= bend.turn[e] / bending::TURN * stiffer * (bend.angles[e] - bend.half[e]);
        }
        0.5 * bend.angles.dot(bending::product(&bend.shifted[axis], bend.angles)) + bend.balanced.dot(changes)
    }
}

fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a).normalize_or_zero()
}
