//! Choosing the edge along which a vertex may be taken out of the mesh.
//!
//! Taking a vertex out strains the triangles around it anew, so it must be one that the mesh can spare. The shape stays, in the
//! rest surface and in space, angles stay good, and the elastic energy of the triangles changes little.

use crate::math::{FibreLaw, RestTriangle, smallest_angle};
use crate::storage::{Fan, Triangles};
use crate::systems::fracture::Surface;
use crate::systems::kernels::path_work::Element;
use glam::DVec3;
use smallvec::SmallVec;

/// The smallest angle \[rad\] left by a collapse is at least this, or no smaller than before; 20°.
const GOOD: f64 = 0.349_065_850_398_865_9;
/// Cosine of the largest turn of a triangle's normal in the rest shape: 10°.
const FLAT_AT_REST: f64 = 0.984_807_753_012_208;
/// Cosine of the largest turn of a triangle's normal in space: 20°. Folds stay.
const FLAT_IN_SPACE: f64 = 0.939_692_620_785_908_4;
/// The elastic energy around the vertex may change by this part. It is of second order in the change of the stress: 5 % stand
/// for 22 % of the stress, the error that linear triangles of a mesh that is not refined have as well (up to 16 % in `fig2`).
const ENERGY: f64 = 0.05;
/// The elastic energy may also change by the energy of a stress of this part of the least strength: where that little changes,
/// nothing tears. Tuned, with [`ENERGY`], on `fig2-tear` at 60° and 90°. There vertices taken out behind the tip change 0.5 %
/// of the energy, and all those that go at once when the tear has ended 1.5 % more.
const FAINT: f64 = 0.2;

/// A vertex that can be taken out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coarsening {
    /// Row of the vertex that it is to be collapsed into.
    pub into: u32,
    /// Change of the elastic energy \[mJ\].
    pub energy_change: f64,
}

/// The best way to take a vertex out; `None` where there is none good enough. `is_wanted` judges each triangle that would be
/// left, by its rest corners and rest area; `strength` is the least one \[MPa\].
pub fn plan_coarsening(
    surface: &Surface,
    vertex: u32,
    strength: f64,
    is_wanted: &dyn Fn([DVec3; 3], f64) -> bool,
) -> Option<Coarsening> {
    let fan = surface.topology.fan(vertex);
    // Vertices between triangles of different properties stay where they are.
    if !are_uniform(surface.triangles, &fan) {
        return None;
    }
    let corners = &surface.triangles.corners;
    let end = |&(t, corner): &(u32, usize), step: usize| corners[t as usize][(corner + step) % 3];
    // A vertex on the boundary can only go along it.
    let ends: SmallVec<[u32; 12]> = if fan.is_closed {
        fan.sectors.iter().map(|sector| end(sector, 1)).collect()
    } else {
        fan.sectors.first().map(|s| end(s, 1)).into_iter().chain(fan.sectors.last().map(|s| end(s, 2))).collect()
    };
    let before = fan.sectors.iter().map(|&(t, _)| smallest_angle(surface.rest(t))).fold(f64::INFINITY, f64::min);
    let mut ways: SmallVec<[(f64, u32); 12]> = SmallVec::new();
    for into in ends {
        let left = || fan.sectors.iter().filter(move |(t, _)| !corners[*t as usize].contains(&into));
        let angle =
            left().map(|&(t, i)| smallest_angle(surface.with_corner(t, i, into).0)).fold(f64::INFINITY, f64::min);
        if angle >= GOOD.min(before) && left().all(|&(t, i)| surface.keeps_its_place(t, i, into, is_wanted)) {
            ways.push((angle, into));
        }
    }
    ways.sort_by(|a, b| b.0.total_cmp(&a.0));
    ways.into_iter().find_map(|(_, into)| {
        let energy_change = surface.energy_change(&fan.sectors, into, strength)?;
        Some(Coarsening { into, energy_change })
    })
}

/// Whether the triangles of a fan have one thickness, strength, toughness and pre-stretch.
fn are_uniform(triangles: &Triangles, fan: &Fan) -> bool {
    let Triangles { thickness, strength, toughness, pre_stretch, .. } = triangles;
    let mut rows = fan.sectors.iter().map(|&(t, _)| t as usize);
    let Some(first) = rows.next() else { return true };
    let numbers = [thickness, strength, toughness];
    let are_alike = numbers.iter().all(|column| column.is_uniform()) && pre_stretch.is_uniform();
    are_alike
        || rows.all(|t| numbers.iter().all(|column| column[t] == column[first]) && pre_stretch[t] == pre_stretch[first])
}

impl Surface<'_> {
    fn rest(&self, t: u32) -> [DVec3; 3] {
        self.triangles.corners[t as usize].map(|v| self.vertices.rest_position[v as usize])
    }

    /// Rest and current corners of a triangle with another vertex as one of them.
    fn with_corner(&self, t: u32, corner: usize, row: u32) -> ([DVec3; 3], [DVec3; 3]) {
        let mut rows = self.triangles.corners[t as usize];
        rows[corner] = row;
        (rows.map(|v| self.vertices.rest_position[v as usize]), rows.map(|v| self.vertices.position[v as usize]))
    }

    fn keeps_its_place(&self, t: u32, corner: usize, row: u32, is_wanted: &dyn Fn([DVec3; 3], f64) -> bool) -> bool {
        let now = self.triangles.corners[t as usize].map(|v| self.vertices.position[v as usize]);
        let (new_rest, new_now) = self.with_corner(t, corner, row);
        let normal = |x: [DVec3; 3]| (x[1] - x[0]).cross(x[2] - x[0]);
        let turns_little = |a: DVec3, b: DVec3, limit: f64| a.dot(b) >= limit * a.length() * b.length();
        turns_little(normal(self.rest(t)), normal(new_rest), FLAT_AT_REST)
            && turns_little(normal(now), normal(new_now), FLAT_IN_SPACE)
            && is_wanted(new_rest, 0.5 * normal(new_rest).length())
    }

    /// Change of the elastic energy \[mJ\] of a fan whose vertex goes into another; `None` where it is too large.
    fn energy_change(&self, sectors: &[(u32, usize)], into: u32, strength: f64) -> Option<f64> {
        let (mut before, mut after, mut faint) = (0.0, 0.0, 0.0);
        for &(t, corner) in sectors {
            let triangle = self.triangles.at(t);
            let energy = |rest: &RestTriangle, now: [DVec3; 3]| {
                let &Self { is_planar, unstretched, ref fibres, .. } = self;
                let unstretched = self.triangles.unstretched(t as usize, unstretched);
                let (stiffness, volume) = (self.triangles.law(t as usize), rest.area * triangle.thickness);
                let (beside, fibres) = (self.triangles.stored_beside(t as usize), fibres.as_ref());
                Element { rest, stiffness, volume, is_planar, unstretched, beside, fibres }.energy(now)
            };
            before += energy(&triangle.rest, triangle.corners.map(|v| self.vertices.position[v as usize]));
            let stress = FAINT * strength;
            let along = triangle.stiffness.q11 + self.fibres.as_ref().map_or(0.0, FibreLaw::first_stiffness);
            let stiffness = along.max(triangle.stiffness.q22);
            faint += 0.5 * triangle.rest.area * triangle.thickness * stress * stress / stiffness;
            if !triangle.corners.contains(&into) {
                let (rest, now) = self.with_corner(t, corner, into);
                after += energy(&RestTriangle::new(rest, triangle.fibre)?, now);
            }
        }
        let change: f64 = after - before;
        (change.abs() <= faint.max(ENERGY * before)).then_some(change)
    }
}
