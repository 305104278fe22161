//! Texture coordinates along seams, where a vertex has several: those of a torn and refined surface are found on the surface of the file.

use super::mesh_file::MeshFile;
use super::sets::Sets;
use glam::{DVec2, DVec3};
use std::collections::HashMap;

/// The most cells that the longest edge spans, so that a few long ones do not fill the search.
const MOST_CELLS: f64 = 16.0;

/// A surface with seams of its texture, as it was read.
#[derive(Debug)]
pub struct Seams {
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    textured: Vec<[[f64; 2]; 3]>,
    /// Of each triangle: triangles between which there is no seam have the same.
    charts: Vec<u32>,
    /// Triangles by the cells that their boxes touch.
    cells: HashMap<[i64; 3], Vec<u32>>,
    side: f64,
}

impl Seams {
    /// The seams of a mesh file; `None` without any.
    pub(super) fn of(file: &MeshFile) -> Option<Self> {
        let textured = file.textured.clone()?;
        let (positions, triangles) = (file.mesh.positions.clone(), file.mesh.triangles.clone());
        let at = |vertex: u32| positions[vertex as usize];
        let lengths =
            || triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).map(|[a, b]| at(a).distance(at(b)));
        let longest = lengths().fold(0.0, f64::max);
        let side = (lengths().sum::<f64>() / (3 * triangles.len()) as f64).max(longest / MOST_CELLS);
        let mut seams =
            Self { charts: charts(&triangles, &textured), cells: HashMap::new(), side, positions, triangles, textured };
        for triangle in 0..seams.triangles.len() {
            let corners = seams.corners_of(triangle as u32);
            let low = seams.cell(corners[0].min(corners[1]).min(corners[2]));
            let high = seams.cell(corners[0].max(corners[1]).max(corners[2]));
            for x in low[0]..=high[0] {
                for y in low[1]..=high[1] {
                    (low[2]..=high[2]).for_each(|z| seams.cells.entry([x, y, z]).or_default().push(triangle as u32));
                }
            }
        }
        Some(seams)
    }

    /// The texture coordinates of the corners of triangles, whose rest positions lie on the surface.
    pub fn textured(&self, rest_positions: &[DVec3], triangles: &[[u32; 3]]) -> Vec<[[f64; 2]; 3]> {
        let of = |corners: &[u32; 3]| {
            let points = corners.map(|vertex| rest_positions.get(vertex as usize).copied().unwrap_or_default());
            let centre = (points[0] + points[1] + points[2]) / 3.0;
            let chart = self.nearest(centre, None).map(|triangle| self.charts[triangle as usize]);
            points.map(|point| self.nearest(point, chart).map_or([0.0; 2], |triangle| self.at(triangle, point)))
        };
        triangles.iter().map(of).collect()
    }

    fn corners_of(&self, triangle: u32) -> [DVec3; 3] {
        self.triangles[triangle as usize].map(|vertex| self.positions[vertex as usize])
    }

    fn cell(&self, point: DVec3) -> [i64; 3] {
        (point / self.side).floor().to_array().map(|x| x as i64)
    }

    /// The triangle nearest to a point, of a chart if one is given.
    fn nearest(&self, point: DVec3, chart: Option<u32>) -> Option<u32> {
        let is_of_chart = |triangle: &u32| chart.is_none_or(|chart| self.charts[*triangle as usize] == chart);
        let distance = |triangle: u32| {
            let corners = self.corners_of(triangle);
            let inside = weights(corners, point).map(|weight| weight.max(0.0));
            let sum: f64 = inside.iter().sum();
            (corners[0] * inside[0] + corners[1] * inside[1] + corners[2] * inside[2]).distance(point * sum) / sum
        };
        let by_distance = |a: &u32, b: &u32| distance(*a).total_cmp(&distance(*b)).then(a.cmp(b));
        let cell = self.cell(point);
        let around = (0..27).map(|i| [i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1]);
        let near =
            around.filter_map(|step| self.cells.get(&[0, 1, 2].map(|axis| cell[axis].saturating_add(step[axis]))));
        let near = near.flatten().copied().filter(is_of_chart).min_by(by_distance);
        // A point beside the surface: all triangles are looked at.
        near.or_else(|| (0..self.triangles.len() as u32).filter(is_of_chart).min_by(by_distance))
    }

    /// The texture coordinate at a point in or beside a triangle.
    fn at(&self, triangle: u32, point: DVec3) -> [f64; 2] {
        let textured = self.textured[triangle as usize].map(DVec2::from);
        let [a, b, c] = weights(self.corners_of(triangle), point);
        (textured[0] * a + textured[1] * b + textured[2] * c).to_array()
    }
}

/// Weights of the corners at a point's foot in the plane of a triangle.
fn weights([a, b, c]: [DVec3; 3], point: DVec3) -> [f64; 3] {
    let (ab, ac, ap) = (b - a, c - a, point - a);
    let normal = ab.cross(ac);
    let area = normal.length_squared();
    if area == 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let (of_b, of_c) = (ap.cross(ac).dot(normal) / area, ab.cross(ap).dot(normal) / area);
    [1.0 - of_b - of_c, of_b, of_c]
}

/// The chart of each triangle: neighbours with the same texture coordinates at their common edge are in one.
fn charts(triangles: &[[u32; 3]], textured: &[[[f64; 2]; 3]]) -> Vec<u32> {
    let mut edges: HashMap<[u32; 2], (u32, [[f64; 2]; 2])> = HashMap::new();
    let mut charts = Sets::new(triangles.len());
    for (triangle, (corners, uv)) in (0..).zip(triangles.iter().zip(textured)) {
        for side in 0..3 {
            let next = (side + 1) % 3;
            let (mut edge, mut own) = ([corners[side], corners[next]], [uv[side], uv[next]]);
            if edge[0] > edge[1] {
                edge.reverse();
                own.reverse();
            }
            match edges.get(&edge) {
                Some((other, same)) if *same == own => charts.join(triangle, *other),
                Some(_) => {}
                None => _ = edges.insert(edge, (triangle, own)),
            }
        }
    }
    (0..triangles.len() as u32).map(|triangle| charts.first(triangle)).collect()
}
