//! Free mode: the ways in which a tear can follow a ray through its tip's fan.
//!
//! A way that stays on the ray is exact: an edge that lies on it, the split of the edge through which it leaves the fan,
//! or a vertex of that edge slid onto it. A snap leaves the ray for a vertex nearby and changes nothing else.

use super::{Quality, TearRefusal, TipChart};
use crate::storage::{Edit, Mesh};
use glam::DVec2;
use smallvec::{SmallVec, smallvec};

/// A spoke this close to the ray, as an angle \[rad\], lies on it: over an edge of 1 mm that is 1e-10 mm.
const ON_RAY: f64 = 1e-10;
/// A vertex is slid at most so far along an edge; beyond, the other end is nearer.
const LONGEST_SLIDE: f64 = 0.6;
/// Where the allowed length ends inside a triangle, it is used if it reaches this part of the way through.
const SHORTEST_PART: f64 = 0.5;

/// One way on: the edits that bring a vertex onto the path; then the edge from the tip to that vertex is opened.
#[derive(Clone, Debug, PartialEq)]
pub struct Way {
    /// The edits before the opening.
    pub edits: SmallVec<[Edit; 2]>,
    /// Row of the vertex it leads to, which may be the first new one.
    pub reaches: u32,
    /// Angle \[rad\] between the ray and the way.
    pub deviation: f64,
}

/// The ways on from a tip, best first in each list.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ways {
    /// Ways that stay on the ray.
    pub exact: SmallVec<[Way; 4]>,
    /// Existing vertices near the ray, nearest in angle first.
    pub snaps: SmallVec<[Way; 4]>,
    /// Length of the way along the ray \[mm\].
    pub distance: f64,
    /// Whether the way ends inside a triangle, because the allowed length does.
    pub is_part: bool,
}

/// The ways on from a tip in a unit direction of its chart, for at most `limit` \[mm\] where that ends in the second half of
/// the triangle; a slightly longer way to its far edge is not cut short.
///
/// # Errors
/// [`TearRefusal::OutsideFan`], [`TearRefusal::TooShort`].
pub fn plan_free(
    mesh: &Mesh<'_>,
    tip: &TipChart,
    direction: DVec2,
    limit: f64,
    quality: &Quality,
    is_movable: &dyn Fn(u32) -> bool,
) -> Result<Ways, TearRefusal> {
    let outside = TearRefusal::OutsideFan { vertex: tip.vertex };
    let exit = tip.chart.exit(direction).ok_or(outside)?;
    let mut ways = Ways { snaps: snaps(mesh, tip, direction, quality), distance: exit.distance, ..Ways::default() };
    let (triangle, corner) = tip.fan.sectors[exit.sector];
    let new = mesh.vertices.len() as u32;

    let on_ray = [exit.sector, exit.sector + 1].into_iter().find(|&k| {
        let spoke = tip.chart.spoke(k);
        spoke.dot(direction) > 0.0 && spoke.perp_dot(direction).abs() <= ON_RAY * spoke.length()
    });
    if let Some(spoke) = on_ray {
        let reaches = tip.end(mesh, spoke).filter(|_| tip.is_inside(spoke)).ok_or(outside)?;
        let part = part_of(limit, exit.distance)?;
        let way = match part {
            None => Way { edits: SmallVec::new(), reaches, deviation: 0.0 },
            Some(weight) => {
                let (triangle, edge) =
                    mesh.topology.directed_edge(&mesh.triangles.corners, tip.vertex, reaches).ok_or(outside)?;
                Way { edits: smallvec![Edit::SplitEdge { triangle, edge, weight }], reaches: new, deviation: 0.0 }
            }
        };
        ways.is_part = part.is_some();
        ways.exact.push(way);
        return Ok(ways);
    }

    let edge = (corner + 1) % 3;
    let corners = mesh.triangles.corners[triangle as usize];
    let (a, b) = (corners[edge], corners[(edge + 1) % 3]);
    let exact = |edits| Way { edits, reaches: new, deviation: 0.0 };
    if let Some(part) = part_of(limit, exit.distance)? {
        let mut weights = [0.0; 3];
        weights[corner] = 1.0 - part;
        weights[edge] = part * (1.0 - exit.along);
        weights[(edge + 1) % 3] = part * exit.along;
        ways.exact.push(exact(smallvec![Edit::SplitTriangle { triangle, weights }]));
        ways.is_part = true;
        return Ok(ways);
    }
    ways.exact.push(exact(smallvec![Edit::SplitEdge { triangle, edge, weight: exit.along }]));
    let mut slides = [(a, b, exit.along), (b, a, 1.0 - exit.along)];
    slides.sort_by(|x, y| x.2.total_cmp(&y.2));
    for (vertex, towards, weight) in slides {
        if weight <= LONGEST_SLIDE && is_movable(vertex) && !mesh.topology.is_boundary_vertex(vertex) {
            let edits = smallvec![Edit::Slide { vertex, towards, weight }];
            ways.exact.push(Way { edits, reaches: vertex, deviation: 0.0 });
        }
    }
    Ok(ways)
}

/// The part of the way that the limit allows; `None` for all of it.
fn part_of(limit: f64, way: f64) -> Result<Option<f64>, TearRefusal> {
    // A limit saved up from equal parts may miss the way by roundings.
    if limit >= way * (1.0 - 1e-9) {
        Ok(None)
    } else if limit >= SHORTEST_PART * way {
        Ok(Some(limit / way))
    } else {
        Err(TearRefusal::TooShort { way })
    }
}

fn snaps(mesh: &Mesh<'_>, tip: &TipChart, direction: DVec2, quality: &Quality) -> SmallVec<[Way; 4]> {
    let distinct = tip.chart.spoke_count() - usize::from(tip.chart.is_closed());
    let mut snaps: SmallVec<[Way; 4]> = SmallVec::new();
    for spoke in (0..distinct).filter(|&spoke| tip.is_inside(spoke)) {
        let deviation = tip.chart.spoke(spoke).angle_to(direction).abs();
        if let Some(reaches) = tip.end(mesh, spoke).filter(|_| deviation <= quality.widest_snap) {
            snaps.push(Way { edits: SmallVec::new(), reaches, deviation });
        }
    }
    snaps.sort_by(|x, y| x.deviation.total_cmp(&y.deviation));
    snaps
}
