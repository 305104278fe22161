//! Free mode: the ways in which a tear can follow a ray through its tip's fan.
//!
//! A way that stays on the ray is exact: an edge that lies on it, the split of the edge through which it leaves the fan,
//! or a vertex of that edge slid onto it. A snap leaves the ray for a vertex nearby and changes nothing else. Where neither
//! leaves good triangles there are detours: a wider snap, a part of the exact way, the edge that leads forward at all.

use crate::event::Course;
use crate::math::elementary;
use crate::storage::{Edit, Mesh};
use crate::systems::fracture::cut::relax::may_slide;
use crate::systems::fracture::{Quality, TearRefusal, TipChart};
use glam::DVec2;
use smallvec::{SmallVec, smallvec};

/// A spoke this close to the ray, as an angle \[rad\], lies on it: over an edge of 1 mm that is 1e-10 mm.
const ON_RAY: f64 = 1e-10;
/// A vertex is slid at most so far along an edge; beyond, the other end is nearer.
const LONGEST_SLIDE: f64 = 0.6;
/// Parts of the exact way after which a detour stops inside the triangle, in the order in which they are tried.
const PARTS: [f64; 2] = [0.5, 0.7];

/// One way on: the edits that bring a vertex onto the path; then the edge from the tip to that vertex is opened.
#[derive(Clone, Debug, PartialEq)]
pub struct Way {
    /// The edits before the opening.
    pub edits: SmallVec<[Edit; 2]>,
    /// Row of the vertex it leads to, which may be the first new one.
    pub reaches: u32,
    /// Angle \[rad\] between the ray and the way.
    pub deviation: f64,
    /// Kind of way.
    pub course: Course,
}

impl Way {
    /// An edge that is there.
    pub(in crate::systems::fracture) fn along_edge(reaches: u32, deviation: f64, course: Course) -> Self {
        Self { edits: SmallVec::new(), reaches, deviation, course }
    }
}

/// The ways on from a tip, best first in each list.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ways {
    /// Ways that stay on the ray, to the far side of the triangle.
    pub exact: SmallVec<[Way; 4]>,
    /// Existing vertices near the ray, nearest in angle first.
    pub snaps: SmallVec<[Way; 4]>,
    /// Detours, tried when all other ways fail.
    pub detours: SmallVec<[Way; 8]>,
}

impl Ways {
    /// A single exact way, without alternatives.
    pub(in crate::systems::fracture) fn only(way: Way) -> Self {
        Self { exact: smallvec![way], ..Self::default() }
    }
}

/// The ways on from a tip in a unit direction of its chart, by one triangle.
///
/// # Errors
/// [`TearRefusal::OutsideFan`].
pub fn plan_free(
    mesh: &Mesh<'_>,
    tip: &TipChart,
    direction: DVec2,
    quality: &Quality,
    is_movable: &dyn Fn(u32) -> bool,
) -> Result<Ways, TearRefusal> {
    let outside = TearRefusal::OutsideFan { vertex: tip.vertex };
    let exit = tip.chart.exit(direction).ok_or(outside)?;
    let (triangle, corner) = tip.fan.sectors[exit.sector];
    let new = mesh.vertices.len() as u32;

    let on_ray = [exit.sector, exit.sector + 1].into_iter().find(|&k| {
        let spoke = tip.chart.spoke(k);
        spoke.dot(direction) > 0.0 && spoke.perp_dot(direction).abs() <= ON_RAY * spoke.length()
    });
    if let Some(spoke) = on_ray {
        // Opening an edge changes no triangle's shape, so it needs no alternative.
        let reaches = tip.end(mesh, spoke).filter(|_| tip.is_inside(spoke)).ok_or(outside)?;
        return Ok(Ways::only(Way::along_edge(reaches, 0.0, Course::Exact)));
    }

    let mut ways = Ways::default();
    let edge = (corner + 1) % 3;
    let corners = mesh.triangles.corners[triangle as usize];
    let (a, b) = (corners[edge], corners[(edge + 1) % 3]);
    let split = |edit, course| Way { edits: smallvec![edit], reaches: new, deviation: 0.0, course };
    ways.exact.push(split(Edit::SplitEdge { triangle, edge, weight: exit.along }, Course::Exact));
    let mut slides = [(a, b, exit.along), (b, a, 1.0 - exit.along)];
    slides.sort_by(|x, y| x.2.total_cmp(&y.2));
    for (vertex, towards, weight) in slides {
        if weight <= LONGEST_SLIDE && is_movable(vertex) && may_slide(mesh, vertex) {
            let edits = smallvec![Edit::Slide { vertex, towards, weight }];
            ways.exact.push(Way { edits, reaches: vertex, deviation: 0.0, course: Course::Exact });
        }
    }
    let spokes = forward_spokes(mesh, tip, direction, quality.widest_edge);
    let near = spokes.partition_point(|&(deviation, _)| deviation <= quality.snap);
    let wide = spokes.partition_point(|&(deviation, _)| deviation <= quality.widest_snap);
    let to_spokes = |from: usize, to: usize, course| {
        spokes[from..to].iter().map(move |&(deviation, reaches)| Way::along_edge(reaches, deviation, course))
    };
    ways.snaps.extend(to_spokes(0, near, Course::Snapped));
    ways.detours.extend(PARTS.map(|part| {
        let mut weights = [0.0; 3];
        weights[corner] = 1.0 - part;
        weights[edge] = part * (1.0 - exit.along);
        weights[(edge + 1) % 3] = part * exit.along;
        split(Edit::SplitTriangle { triangle, weights }, Course::Part)
    }));
    ways.detours.extend(to_spokes(near, wide, Course::Snapped));
    ways.detours.extend(to_spokes(wide, spokes.len(), Course::Edge));
    Ok(ways)
}

/// The spokes that can be opened and turn away from the direction by at most `widest` \[rad\], nearest first: angle and end.
fn forward_spokes(mesh: &Mesh<'_>, tip: &TipChart, direction: DVec2, widest: f64) -> SmallVec<[(f64, u32); 8]> {
    let inside = (0..tip.spoke_count()).filter(|&spoke| tip.is_inside(spoke));
    let mut spokes: SmallVec<[(f64, u32); 8]> = inside
        .map(|spoke| (elementary::turn(tip.chart.spoke(spoke), direction).abs(), spoke))
        .filter(|&(deviation, _)| deviation <= widest)
        .filter_map(|(deviation, spoke)| Some((deviation, tip.end(mesh, spoke)?)))
        .collect();
    spokes.sort_by(|x, y| x.0.total_cmp(&y.0));
    spokes
}
