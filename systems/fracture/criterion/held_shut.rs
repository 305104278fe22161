//! Centre of the field at a tip: elements hold a crack shut for a part of an edge behind the vertex of its tip.
//!
//! Linear triangles cannot open as √r does just behind a tip. They are too stiff there by a surplus of energy in proportion to
//! K²·(edge). A crack shorter by a part of an edge has released too little by as much: G·δ per thickness. Away from the tip the
//! solution is that of the shorter crack. The leading error of the displacement, r^(−½), is the derivative of the crack's field,
//! √r, by the place of its tip. So δ over the edge is a number of the element alone, almost of neither mesh nor material. A disc
//! about the point δ behind the vertex sees the field of a crack of the continuum about its middle.

use crate::math::{edge_of_equilateral, elementary};
use crate::systems::fracture::Surface;
use crate::systems::fracture::criterion::tip_disc::{Disc, Walk};
use crate::systems::kernels::fan::FanChart;
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, TAU};

/// δ in edges, where the edge is the size of the triangles around ([`local_edge`]). Measured against `tip_disc_average.json`
/// on structured, jittered, rotated and unstructured meshes with 3 to 9 edges per radius. Isotropic: 0.30 to 0.33 on average over
/// meshes of a kind, single meshes 0.25 to 0.37. Fibres ten times as stiff at 45° to the crack: 0.26 to 0.37.
const TIP_OFFSET: f64 = 0.32;

/// Edges per radius from which on the whole of δ counts, and up to which nothing does. A smaller disc sees the first triangles
/// only, not the field beyond them, and finds less than there is already about the vertex: by 30 % at a third of an edge.
const SEES_THE_FIELD: [f64; 2] = [0.5, 1.0];

/// A boundary that opens by less than this \[rad\] is a crack: stress at a notch of 90° still grows as r^−0.456
/// (Williams 1952), at a straight boundary not at all.
const WIDEST_CRACK: f64 = FRAC_PI_2;

/// The centre of the field in the chart of a vertex \[mm\], as offset from the vertex, for a disc of `radius` \[mm\]. It lies
/// behind the vertex along the bisector of the crack's lips; it is zero where there is no crack.
pub fn field_tip(surface: &Surface, (vertex, radius): (u32, f64), chart: &FanChart) -> DVec2 {
    let (from, to) = chart.range();
    if chart.is_closed() || TAU - (to - from) >= WIDEST_CRACK {
        return DVec2::ZERO;
    }
    let lips = [chart.spoke(0), chart.spoke(chart.spoke_count() - 1)];
    // Behind the last edge the crack may go another way, or end.
    let longest = lips[0].length().min(lips[1].length());
    let back = (lips[0].normalize_or_zero() + lips[1].normalize_or_zero()).normalize_or_zero();
    let edge = local_edge(surface, vertex);
    let [none, whole] = SEES_THE_FIELD;
    let part = ((radius / edge - none) / (whole - none)).clamp(0.0, 1.0);
    back * (TIP_OFFSET * edge * part).min(longest)
}

/// The centre of the field in the rest shape \[mm\], and its offset as [`field_tip`] gives it.
pub(in crate::systems::fracture) fn field_centre(
    surface: &Surface,
    at: (u32, f64),
    chart: &FanChart,
) -> (DVec3, DVec2) {
    let axes = chart.axes();
    let offset = field_tip(surface, at, chart);
    (surface.vertices.rest_position[at.0 as usize] + axes[0] * offset.x + axes[1] * offset.y, offset)
}

/// Lays the disc of `radius` \[mm\] about the centre of the field at a vertex; its fibre is that at the vertex.
pub fn lay_at_tip(disc: &mut Disc, surface: &Surface, (vertex, radius): (u32, f64), chart: &FanChart, walk: &mut Walk) {
    let axes = chart.axes();
    let (centre, offset) = field_centre(surface, (vertex, radius), chart);
    // The walk takes in all triangles by which the edge is measured, so that it depends on no others.
    disc.lay(surface, (centre, axes, radius), triangles_around(surface, vertex), walk);
    disc.fibre = elementary::unit_at(-disc.fibre_turn.dot(offset)).rotate(disc.fibre);
}

/// The size \[mm\] of the triangles at the corners of a vertex' fan, those nearer counted more often. Single fans are more
/// uneven than the zone that holds the crack shut: measured by these alone δ scatters twice as much.
fn local_edge(surface: &Surface, vertex: u32) -> f64 {
    let (mut area, mut count) = (0.0, 0.0);
    for t in triangles_around(surface, vertex) {
        area += surface.triangles.rest[t as usize].area;
        count += 1.0;
    }
    edge_of_equilateral(area / count)
}

/// The triangles at the corners of a vertex' fan, each as often as there are ways to it.
pub(in crate::systems::fracture) fn triangles_around<'s>(
    surface: &Surface<'s>,
    vertex: u32,
) -> impl Iterator<Item = u32> + 's {
    let &Surface { triangles, topology, .. } = surface;
    let at = move |v: u32| topology.incident[v as usize].iter().map(|&entry| entry / 3);
    at(vertex).flat_map(move |t| triangles.corners[t as usize]).flat_map(at)
}
