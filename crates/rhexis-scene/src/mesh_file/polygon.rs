//! Polygons become triangles that fill them: the same ones from whichever corner the file begins.

use glam::{DVec2, DVec3};
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};
use std::collections::BTreeMap;

/// The most corners of a polygon; a fan of more would crowd a vertex many times over.
const MOST_CORNERS: usize = 10_000;

/// Below this part of the whole a triangle of the fan counts as empty: another way to fill the polygon may do better.
const THIN: f64 = 1e-6;

/// Twice the area of a triangle over the square of the polygon's size, at which it has none.
const EMPTY: f64 = 1e-12;

/// The most corners of a polygon that crosses itself, is folded or overlaps: its filling takes the cube of their number.
const MOST_FOLDED: usize = 32;

/// Area of the triangles over that along the mean normal, from which on a polygon is no surface that its plane shows.
const FOLDED: f64 = 1.5;

/// Difference of the triangles' areas and the polygon's, relative, that rounding explains.
const ROUNDING: f64 = 1e-6;

/// A polygon as triangles.
pub(super) struct Filled {
    /// Corners.
    pub triangles: Vec<[u32; 3]>,
    /// Whether it crosses itself, is folded or overlaps.
    pub is_folded: bool,
}

/// The triangles of a polygon. Convex ones are a fan about their corner of the lowest number; others the constrained Delaunay
/// triangulation in the plane of their mean normal. Those that cross themselves, are folded or overlap get the triangles of the least area.
///
/// # Errors
/// For a polygon of too many corners.
pub(super) fn triangles(positions: &[DVec3], corners: &[u32]) -> Result<Filled, String> {
    let mut corners = corners.to_vec();
    // A quad with a corner twice in a row is how many programs write a triangle.
    if corners.len() > 3 {
        corners.dedup();
        if corners.len() > 1 && corners.first() == corners.last() {
            corners.pop();
        }
    }
    let count = corners.len();
    let is_backward = start_at_lowest(&mut corners);
    let at = |corner: u32| positions.get(corner as usize).copied().filter(|p| p.is_finite());
    let points: Option<Vec<DVec3>> = corners.iter().map(|&corner| at(corner)).collect();
    // A single triangle, and corners that are no vertices or lie nowhere, are judged with the mesh as a whole.
    let (made, is_folded) = match points {
        Some(_) if count > MOST_CORNERS => return Err(too_many(count, "a polygon", MOST_CORNERS)),
        Some(points) if count > 3 => match fan_or_fill(&points) {
            Some(made) => (made, false),
            None if count > MOST_FOLDED => {
                return Err(too_many(count, "a polygon that crosses itself, is folded or overlaps", MOST_FOLDED));
            }
            None => (least_area(&points), true),
        },
        _ => ((1..count.saturating_sub(1)).map(|i| [0, i, i + 1]).collect(), false),
    };
    let triangles = made.into_iter().map(|triangle| {
        let [a, b, c] = triangle.map(|i| corners[i]);
        if is_backward { [a, c, b] } else { [a, b, c] }
    });
    Ok(Filled { triangles: triangles.collect(), is_folded })
}

fn too_many(count: usize, of: &str, most: usize) -> String {
    format!("its {count} corners are too many for {of}, which has {most} at the most; save it as triangles")
}

/// Rotates the list so that its lowest number is first, and turns it where the last is lower than the second; whether it did.
fn start_at_lowest(corners: &mut [u32]) -> bool {
    let lowest = (0..corners.len()).min_by_key(|&i| (corners[i], i)).unwrap_or(0);
    corners.rotate_left(lowest);
    let is_backward = corners.len() > 3 && corners[corners.len() - 1] < corners[1];
    if is_backward {
        corners[1..].reverse();
    }
    is_backward
}

fn fan_or_fill(points: &[DVec3]) -> Option<Vec<[usize; 3]>> {
    let fan = |i: usize| [0, i, i + 1];
    let area = |t: [usize; 3]| (points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]);
    let fans = 1..points.len() - 1;
    // Twice the area along the mean normal, by Newell's sum about the first corner.
    let whole: DVec3 = fans.clone().map(|i| area(fan(i))).sum();
    let least = THIN * whole.length_squared();
    let is_convex = least > 0.0 && turns_once(points, whole) && fans.clone().all(|i| area(fan(i)).dot(whole) > least);
    if is_convex {
        return Some(fans.map(fan).collect());
    }
    // Without any area it crosses nothing: its triangles are counted with the others that have none.
    let low = points.iter().fold(DVec3::INFINITY, |low, p| low.min(*p));
    let size = points.iter().map(|p| (*p - low).max_element()).fold(0.0, f64::max);
    if fans.clone().all(|i| area(fan(i)).length() <= EMPTY * size * size) {
        return Some(fans.map(fan).collect());
    }
    fill(points, whole, low, size)
}

/// The triangles of the least total area that a closed line of corners bounds: of a quad, those of the better diagonal.
fn least_area(points: &[DVec3]) -> Vec<[usize; 3]> {
    let count = points.len();
    let area = |a: usize, b: usize, c: usize| (points[b] - points[a]).cross(points[c] - points[a]).length();
    // Of the part between two corners, by the first and the last: its least area, and the third corner of the triangle at their line.
    let mut least = vec![(0.0, 0); count * count];
    for span in 2..count {
        for first in 0..count - span {
            let last = first + span;
            let with = |k: usize| least[first * count + k].0 + least[k * count + last].0 + area(first, k, last);
            let best = (first + 1..last).map(|k| (with(k), k)).min_by(|a, b| a.0.total_cmp(&b.0));
            least[first * count + last] = best.unwrap_or_default();
        }
    }
    let (mut made, mut parts) = (Vec::with_capacity(count), vec![(0, count - 1)]);
    while let Some((first, last)) = parts.pop() {
        if last > first + 1 {
            let middle = least[first * count + last].1;
            made.push([first, middle, last]);
            parts.extend([(first, middle), (middle, last)]);
        }
    }
    made
}

/// Whether no corner turns back: a fan whose triangles all face one way may still run round more than once.
fn turns_once(points: &[DVec3], normal: DVec3) -> bool {
    let count = points.len();
    let side = |i: usize| points[(i + 1) % count] - points[i % count];
    let total: f64 = (0..count)
        .map(|i| {
            let (a, b) = (side(i), side(i + 1));
            rhexis::math::elementary::atan2(a.cross(b).dot(normal.normalize_or_zero()), a.dot(b))
        })
        .sum();
    total < 1.5 * std::f64::consts::TAU
}

/// The triangulation of the inside of a polygon that need not be convex.
fn fill(points: &[DVec3], whole: DVec3, low: DVec3, size: f64) -> Option<Vec<[usize; 3]>> {
    let normal = whole.try_normalize()?;
    let along = normal.any_orthonormal_vector();
    let across = normal.cross(along);
    if !(size > 0.0 && size.is_finite()) {
        return None;
    }
    // The triangulation takes no numbers between zero and 1e-43.
    let flat = |p: DVec3| {
        let p = (p - low) / size;
        DVec2::new(along.dot(p), across.dot(p)).map(|x| if x.abs() < 1e-30 { 0.0 } else { x })
    };
    let flat: Vec<DVec2> = points.iter().map(|p| flat(*p)).collect();
    let mut net = ConstrainedDelaunayTriangulation::<Point2<f64>>::new();
    let mut corner_at = Vec::new();
    let mut handles = Vec::with_capacity(flat.len());
    for (corner, p) in flat.iter().enumerate() {
        let handle = net.insert(Point2::new(p.x, p.y)).ok()?;
        if handle.index() == corner_at.len() {
            corner_at.push(corner);
        }
        handles.push(handle);
    }
    // How often the outline runs along an edge: twice along the bridge to a hole.
    let mut walls: BTreeMap<[usize; 2], u32> = BTreeMap::new();
    let mut made = Vec::new();
    for (i, &from) in handles.iter().enumerate() {
        let to = handles[(i + 1) % handles.len()];
        if from == to {
            // Two corners at one place: the triangle between them is counted with those that have no area.
            let next = (i + 1) % handles.len();
            made.push([i, next, (next + 1) % handles.len()]);
            continue;
        }
        let key = [from.index().min(to.index()), from.index().max(to.index())];
        *walls.entry(key).or_default() += 1;
        if !net.exists_constraint(from, to) && !net.can_add_constraint(from, to) {
            return None;
        }
        net.add_constraint(from, to);
        // A corner that lies on the side of another splits it.
        if !net.exists_constraint(from, to) {
            return None;
        }
    }
    let mut inside: Vec<Option<bool>> = vec![None; net.num_all_faces()];
    let outer = net.outer_face().fix();
    inside[outer.index()] = Some(false);
    let mut neighbours: Vec<Vec<(usize, bool)>> = vec![Vec::new(); net.num_all_faces()];
    for edge in net.undirected_edges() {
        let edge = edge.as_directed();
        let [a, b] = [edge.face().fix().index(), edge.rev().face().fix().index()];
        let [p, q] = edge.vertices().map(|v| v.fix().index());
        let is_wall = walls.get(&[p.min(q), p.max(q)]).is_some_and(|times| times % 2 == 1);
        neighbours[a].push((b, is_wall));
        neighbours[b].push((a, is_wall));
    }
    let mut queue = vec![outer.index()];
    while let Some(face) = queue.pop() {
        let here = inside[face] == Some(true);
        for &(other, is_wall) in &neighbours[face] {
            match inside[other] {
                None => {
                    inside[other] = Some(here != is_wall);
                    queue.push(other);
                }
                Some(there) if there != (here != is_wall) => return None,
                Some(_) => {}
            }
        }
    }
    let mut filled = 0.0;
    for face in net.inner_faces().filter(|face| inside[face.fix().index()] == Some(true)) {
        let triangle = face.vertices().map(|v| corner_at[v.fix().index()]);
        let [a, b, c] = triangle.map(|i| flat[i]);
        filled += (b - a).perp_dot(c - a);
        made.push(triangle);
    }
    let expected = whole.length() / (size * size);
    let twice = |t: &[usize; 3]| (points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]).length();
    let is_folded = made.iter().map(twice).sum::<f64>() > FOLDED * whole.length();
    (!is_folded && (filled - expected).abs() <= ROUNDING * expected).then_some(made)
}
