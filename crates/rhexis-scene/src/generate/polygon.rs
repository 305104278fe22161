//! Meshes of a polygon without a grid's structure: a lattice turned by any angle, and seeded points without any order.
//!
//! The border is divided evenly, corners exact; points inside keep off it, are relaxed, and the constrained Delaunay
//! triangulation of all of them is taken. Results must not depend on which of these a tear runs through.

use super::GenerateError;
use glam::DVec2;
use rhexis::internal::{Random, bounded, length};
use rhexis::math::{elementary, smallest_angle};
use rhexis::storage::TriangleMesh;
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

/// Inner points keep off the sides by this part of an edge; the altitude of an equilateral triangle is 0.87.
const OFF_BORDER: f64 = 0.6;
/// Darts keep this part of an edge apart. As many land then as a lattice of equilateral triangles has points.
const APART: f64 = 0.75;
/// Darts thrown per point that is expected to stick.
const DARTS: usize = 30;
/// Sweeps of relaxation; the smallest angle gains less than 1° from more.
const SWEEPS: usize = 20;
/// Random points are mended until every angle is this large \[°\], at most [`ROUNDS`] times: what relaxation cannot cure is a
/// vertex with four or eight neighbours, and shaking it loses it.
const GOOD: f64 = 27.0;
const ROUNDS: usize = 12;

/// A lattice of equilateral triangles with sides of about `edge` \[mm\], turned by `degrees` from x, in the plane z = 0 within
/// the polygon with the `corners` \[mm\]. Away from the border it is regular.
///
/// ```
/// use rhexis_scene::generate;
/// let square = [[0.0, 0.0], [30.0, 0.0], [30.0, 30.0], [0.0, 30.0]].map(glam::DVec2::from);
/// let mesh = generate::lattice(&square, 1.0, 20.0)?;
/// assert!(mesh.positions.iter().any(|p| *p == glam::DVec3::new(30.0, 30.0, 0.0)));
/// # Ok::<(), generate::GenerateError>(())
/// ```
///
/// # Errors
/// For an outline that is no simple polygon, an edge that is no length, and too many triangles.
pub fn lattice(corners: &[DVec2], edge: f64, degrees: f64) -> Result<TriangleMesh, GenerateError> {
    let outline = Outline::new(corners, edge)?;
    if !degrees.is_finite() {
        return Err(GenerateError::Angle(degrees));
    }
    let (low, high) = outline.bounds();
    let (centre, reach) = (0.5 * (low + high), 0.5 * low.distance(high));
    let along = elementary::unit_at(degrees.to_radians()) * edge;
    let aside = (along + along.perp() * 3.0_f64.sqrt()) * 0.5;
    let rows = (reach / (edge * 0.75_f64.sqrt())).ceil() as i64;
    let mut inner = Vec::new();
    for j in -rows..=rows {
        // Row j passes the outline's bounds between these places [edges]; the rest of it would be thrown away.
        let (from, to) = within(centre + aside * j as f64, along, low, high);
        for i in from.floor() as i64..=to.ceil() as i64 {
            inner.push(centre + along * i as f64 + aside * j as f64);
        }
    }
    inner.retain(|&p| outline.is_inside(p, OFF_BORDER * edge));
    // The border does not fit the lattice; what lies between them is relaxed.
    outline.relax(&mut inner, |p| !outline.is_inside(p, 2.0 * edge))?;
    outline.mesh(inner)
}

/// Between which multiples of `along` a line from `start` lies within a rectangle; the second is smaller where it never does.
fn within(start: DVec2, along: DVec2, low: DVec2, high: DVec2) -> (f64, f64) {
    (0..2).fold((f64::NEG_INFINITY, f64::INFINITY), |(from, to), axis| {
        let [a, b] = [low, high].map(|side| (side[axis] - start[axis]) / along[axis]);
        match along[axis] {
            // Beside the rectangle, or nowhere outside of it.
            0.0 if a.is_sign_positive() != b.is_sign_positive() || a.is_nan() || b.is_nan() => (from, to),
            0.0 => (f64::INFINITY, f64::NEG_INFINITY),
            _ => (from.max(a.min(b)), to.min(a.max(b))),
        }
    })
}

/// Triangles without any order, with edges of about `edge` \[mm\], in the plane z = 0 within the polygon with the `corners`
/// \[mm\]: random points that keep apart, relaxed. The same `seed` gives the same mesh.
///
/// # Errors
/// For an outline that is no simple polygon, an edge that is no length, and too many triangles.
pub fn unstructured(corners: &[DVec2], edge: f64, seed: u64) -> Result<TriangleMesh, GenerateError> {
    let outline = Outline::new(corners, edge)?;
    let mut random = Random::new(seed);
    let mut inner = outline.darts(&mut random);
    for _ in 0..ROUNDS {
        outline.relax(&mut inner, |_| true)?;
        let thin = outline.in_thin_triangles(&inner)?;
        if thin.is_empty() {
            return outline.mesh(inner);
        }
        for v in thin {
            let shaken = inner[v] + DVec2::new(random.unit() - 0.5, random.unit() - 0.5) * edge;
            if outline.is_inside(shaken, OFF_BORDER * edge) {
                inner[v] = shaken;
            }
        }
    }
    outline.relax(&mut inner, |_| true)?;
    outline.mesh(inner)
}

/// A simple polygon, counter-clockwise.
struct Outline {
    corners: Vec<DVec2>,
    /// Points on its sides about an edge apart, in order; the corners are among them.
    border: Vec<DVec2>,
    edge: f64,
}

impl Outline {
    fn new(corners: &[DVec2], edge: f64) -> Result<Self, GenerateError> {
        let edge = length("edge", edge)?;
        if corners.len() < 3 || !corners.iter().all(|p| p.is_finite()) {
            return Err(GenerateError::Outline("has fewer than three corners, or one that is not finite"));
        }
        let mut corners = corners.to_vec();
        let twice_area = |c: &[DVec2]| sides(c).map(|(a, b)| a.perp_dot(b)).sum::<f64>();
        if twice_area(&corners) < 0.0 {
            corners.reverse();
        }
        let mut outline = Self { corners, border: Vec::new(), edge };
        let (low, high) = outline.bounds();
        let size = (high - low) / edge;
        // Four triangles per square of the edge's length: more than any pattern has, and room for the grid of darts.
        let squares =
            (size.x + 2.0) * (size.y + 2.0) + sides(&outline.corners).map(|(a, b)| a.distance(b) / edge).sum::<f64>();
        bounded((squares < 1e9).then(|| 4 * squares as usize))?;
        for (a, b) in sides(&outline.corners) {
            let count = (a.distance(b) / edge).round().max(1.0);
            outline.border.extend((0..count as usize).map(|i| a + (b - a) * (i as f64 / count)));
        }
        Ok(outline)
    }

    fn bounds(&self) -> (DVec2, DVec2) {
        let start = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        self.corners.iter().fold(start, |(low, high), &p| (low.min(p), high.max(p)))
    }

    /// Whether a point lies inside and at least `margin` \[mm\] off every side.
    fn is_inside(&self, p: DVec2, margin: f64) -> bool {
        let mut is_inside = false;
        for (a, b) in sides(&self.corners) {
            let nearest = a + (b - a) * ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
            if p.distance(nearest) < margin {
                return false;
            }
            // Crossings with the ray to the right: an odd number from inside.
            if (a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * ((p.y - a.y) / (b.y - a.y)) {
                is_inside = !is_inside;
            }
        }
        is_inside
    }

    /// Random points at least [`APART`] from each other, and hardly a place left for one more.
    fn darts(&self, random: &mut Random) -> Vec<DVec2> {
        let apart = APART * self.edge;
        let (low, high) = self.bounds();
        // At most one point lies in a cell.
        let cell = apart * 0.5_f64.sqrt();
        let [columns, rows] = ((high - low) / cell).to_array().map(|cells| cells as usize + 1);
        let mut taken: Vec<Option<DVec2>> = vec![None; columns * rows];
        let mut points = Vec::new();
        for _ in 0..DARTS * columns * rows / 2 {
            let p = low + (high - low) * DVec2::new(random.unit(), random.unit());
            let [i, j] = ((p - low) / cell).to_array().map(|place| place as usize);
            let near = |count: usize, at: usize| at.saturating_sub(2)..(at + 3).min(count);
            let is_free = near(rows, j).all(|j| {
                near(columns, i).all(|i| taken[j * columns + i].is_none_or(|other| other.distance(p) >= apart))
            });
            if is_free && self.is_inside(p, OFF_BORDER * self.edge) {
                taken[j * columns + i] = Some(p);
                points.push(p);
            }
        }
        points
    }

    /// Moves points to the mean of the circumcentres of the triangles around them, weighted by area (optimal Delaunay
    /// triangulation: Chen, Xu 2004, eq. 4.10), where that keeps off the border.
    fn relax(&self, inner: &mut [DVec2], is_movable: impl Fn(DVec2) -> bool) -> Result<(), GenerateError> {
        let first = self.border.len();
        for _ in 0..SWEEPS {
            let mut sums = vec![(DVec2::ZERO, 0.0); inner.len()];
            for triangle in self.triangles(inner)? {
                let [a, b, c] = triangle.map(|v| self.point(v, inner));
                let (u, v) = (b - a, c - a);
                let area = u.perp_dot(v);
                let centre = a * area + (u * v.length_squared() - v * u.length_squared()).perp() * 0.5;
                for corner in triangle.into_iter().filter(|&corner| corner >= first) {
                    let (sum, weight) = &mut sums[corner - first];
                    (*sum, *weight) = (*sum + centre, *weight + area);
                }
            }
            for (p, (sum, weight)) in inner.iter_mut().zip(sums) {
                let centre = sum / weight;
                if is_movable(*p) && self.is_inside(centre, 0.5 * OFF_BORDER * self.edge) {
                    *p = centre;
                }
            }
        }
        Ok(())
    }

    /// Which inner points are corners of a triangle with an angle under [`GOOD`], in ascending order.
    fn in_thin_triangles(&self, inner: &[DVec2]) -> Result<Vec<usize>, GenerateError> {
        let first = self.border.len();
        let mut triangles = self.triangles(inner)?;
        let is_thin = |t: &[usize; 3]| smallest_angle(t.map(|v| self.point(v, inner).extend(0.0))) < GOOD.to_radians();
        triangles.retain(is_thin);
        let mut thin: Vec<usize> = triangles.into_iter().flatten().filter_map(|v| v.checked_sub(first)).collect();
        thin.sort_unstable();
        thin.dedup();
        Ok(thin)
    }

    fn point(&self, v: usize, inner: &[DVec2]) -> DVec2 {
        self.border.get(v).copied().unwrap_or_else(|| inner[v - self.border.len()])
    }

    /// Triangles of the border's points and those inside, numbered in this order, counter-clockwise.
    fn triangles(&self, inner: &[DVec2]) -> Result<Vec<[usize; 3]>, GenerateError> {
        let crossed = GenerateError::Outline("meets itself");
        let count = self.border.len();
        let points = self.border.iter().chain(inner).map(|p| Point2::new(p.x, p.y)).collect();
        let pieces = (0..count).map(|i| [i, (i + 1) % count]).collect();
        let mut meets_itself = false;
        let all =
            ConstrainedDelaunayTriangulation::<Point2<f64>>::try_bulk_load_cdt(points, pieces, |_| meets_itself = true)
                .map_err(|_| crossed.clone())?;
        if meets_itself || all.num_vertices() != count + inner.len() || all.num_constraints() != count {
            return Err(crossed);
        }
        let mut triangles: Vec<[usize; 3]> =
            all.inner_faces().map(|face| face.vertices().map(|vertex| vertex.index())).collect();
        triangles.retain(|&corners| {
            let [a, b, c] = corners.map(|v| self.point(v, inner));
            // A straight side is bent by roundings: between its points and their chord there is nothing.
            let is_flat = (b - a).perp_dot(c - a) < 1e-9 * self.edge * (b - a).length();
            !is_flat && self.is_inside((a + b + c) / 3.0, 0.0)
        });
        Ok(triangles)
    }

    /// The mesh, its vertices numbered in rows from the bottom so that neighbours lie near each other in memory.
    fn mesh(&self, inner: Vec<DVec2>) -> Result<TriangleMesh, GenerateError> {
        let triangles = self.triangles(&inner)?;
        let points: Vec<DVec2> = self.border.iter().copied().chain(inner).collect();
        let row = |p: DVec2| (p.y / self.edge).floor();
        let mut order: Vec<usize> = (0..points.len()).collect();
        order.sort_by(|&a, &b| {
            let (a, b) = (points[a], points[b]);
            row(a).total_cmp(&row(b)).then(a.x.total_cmp(&b.x)).then(a.y.total_cmp(&b.y))
        });
        let mut number = vec![0; points.len()];
        order.iter().enumerate().for_each(|(new, &old)| number[old] = new as u32);
        let mut triangles: Vec<[u32; 3]> = triangles.into_iter().map(|t| t.map(|v| number[v])).collect();
        triangles.sort_by_key(|t| t.iter().copied().min());
        Ok(TriangleMesh { positions: order.iter().map(|&v| points[v].extend(0.0)).collect(), triangles, fibres: None })
    }
}

fn sides(corners: &[DVec2]) -> impl Iterator<Item = (DVec2, DVec2)> {
    corners.iter().copied().zip(corners.iter().copied().cycle().skip(1))
}

#[cfg(test)]
#[path = "polygon_tests.rs"]
mod tests;
