//! The body: triangles by stress, dark boundary, short strokes along the fibres.

use super::Rgba;
use super::camera::{Area, Camera};
use super::canvas::{Canvas, Line};
use super::scale::Scale;
use glam::{DVec2, DVec3};
use rhexis::frame::{BodyFrame, SolidFrame, SolidKind};

/// Above this many triangles their edges would cover the colours.
const MAX_TRIANGLES_WITH_EDGES: usize = 20_000;
const BOUNDARY: Rgba = [15, 15, 20, 255];
const FIBRE: Rgba = [255, 255, 255, 235];
const FIBRE_HALO: Rgba = [0, 0, 0, 90];
/// Obstacles and jaws, which let the tissue behind them through.
const OBSTACLE: Rgba = [120, 132, 150, 80];
const JAWS: Rgba = [50, 52, 60, 120];

/// Something drawn, at its depth.
enum Piece {
    Triangle(usize),
    Solid([DVec3; 3], Rgba),
    Boundary([u32; 2]),
}

/// Edges that only one triangle has, ordered by their vertices.
pub(super) fn boundary_edges(triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let mut edges: Vec<[u32; 2]> =
        triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).map(|[a, b]| [a.min(b), a.max(b)]).collect();
    edges.sort_unstable();
    edges.chunk_by(|a, b| a == b).filter(|same| same.len() == 1).map(|same| same[0]).collect()
}

/// How a surface is drawn.
#[derive(Clone, Copy, Debug)]
pub(super) struct Style {
    /// Width of a thin line \[px\].
    pub weight: f64,
    /// Whether edges of triangles are drawn, of bodies that are not too fine.
    pub with_lines: bool,
    /// Opacity of what lies turned over, 0 to 1.
    pub turned_opacity: f64,
    /// Whether only what lies wholly in the area is drawn, to keep what flies off from covering the rest of the picture.
    pub is_confined: bool,
}

impl Style {
    pub(super) fn new(weight: f64) -> Self {
        Self { weight, with_lines: true, turned_opacity: 1.0, is_confined: false }
    }
}

/// Draws the part of a body and of the solids around it that lies in `area`, from back to front (painter's algorithm).
pub(super) fn draw(
    canvas: &mut Canvas,
    camera: &Camera,
    (body, solids): (&BodyFrame, &[SolidFrame]),
    scale: &Scale,
    area: Area,
    style: Style,
) {
    let weight = style.weight;
    let x = |v: u32| body.positions[v as usize];
    let is_curved = !is_flat(body, camera.toward);
    let with_edges = style.with_lines && body.triangles.len() <= MAX_TRIANGLES_WITH_EDGES;
    let opacity = opacities(body, style.turned_opacity);
    let is_seen = |points: &[DVec2]| match style.is_confined {
        true => points.iter().all(|&p| area.contains_nearly(p)),
        false => area.overlaps(points),
    };

    let triangles = body
        .triangles
        .iter()
        .enumerate()
        .map(|(t, corners)| (corners.iter().map(|&v| camera.depth(x(v))).sum::<f64>() / 3.0, Piece::Triangle(t)));
    let boundary = boundary_edges(&body.triangles).into_iter().map(|[a, b]| {
        // Half an edge nearer than it is: in front of the triangles around it, behind a flap that covers it.
        let lift = if is_curved { 0.5 * x(a).distance(x(b)) } else { f64::INFINITY };
        (0.5 * (camera.depth(x(a)) + camera.depth(x(b))) + lift, Piece::Boundary([a, b]))
    });
    let solids = solids.iter().flat_map(|solid| facing(solid, camera));
    let mut pieces: Vec<(f64, Piece)> = triangles.chain(boundary).chain(solids).collect();
    // Stable, so that pieces of equal depth keep the order of the mesh.
    pieces.sort_by(|a, b| a.0.total_cmp(&b.0));

    let edge = Line::new(0.8 * weight, [0, 0, 0, 70]);
    let rim = Line::new(2.2 * weight, BOUNDARY);
    for (_, piece) in pieces {
        match piece {
            Piece::Triangle(t) => {
                let corners = body.triangles[t].map(|v| camera.project(x(v)));
                if is_seen(&corners) {
                    let light = if is_curved { shade(body.triangles[t].map(x), camera) } else { 1.0 };
                    let [r, g, b, _] = lit(scale.color(body.principal_stress[t].x), light);
                    canvas.fill(&corners, [r, g, b, opacity.get(t).copied().unwrap_or(255)], false);
                    if with_edges {
                        canvas.stroke(&corners, true, edge);
                    }
                }
            }
            Piece::Solid(corners, [r, g, b, a]) => {
                let flat = corners.map(|x| camera.project(x));
                if area.overlaps(&flat) {
                    let [r, g, b, _] = lit([r, g, b, a], shade(corners, camera));
                    canvas.fill(&flat, [r, g, b, a], false);
                }
            }
            Piece::Boundary(ends) => {
                let ends = ends.map(|v| camera.project(x(v)));
                if is_seen(&ends) {
                    canvas.stroke(&ends, false, rim);
                }
            }
        }
    }
}

/// The triangles of a solid that face the viewer, each farther than it is by its own size: tissue that lies on it is in front.
fn facing(solid: &SolidFrame, camera: &Camera) -> impl Iterator<Item = (f64, Piece)> {
    let color = if solid.kind == SolidKind::Jaws { JAWS } else { OBSTACLE };
    solid.triangles.iter().filter_map(move |corners| {
        let corners = corners.map(|v| solid.positions[v as usize]);
        let [a, b, c] = corners;
        let is_facing = (b - a).cross(c - a).dot(camera.toward) > 0.0;
        let size = a.distance(b).max(b.distance(c)).max(c.distance(a));
        let depth = corners.map(|x| camera.depth(x)).iter().sum::<f64>() / 3.0 - size;
        is_facing.then_some((depth, Piece::Solid(corners, color)))
    })
}

/// Opacity of the triangles: less of those that lie turned over against how the body faced at rest. Empty where all are opaque.
fn opacities(body: &BodyFrame, turned: f64) -> Vec<u8> {
    let normal = |points: &[DVec3], corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|v| points[v as usize]);
        (b - a).cross(c - a)
    };
    let facing: DVec3 = body.triangles.iter().map(|corners| normal(&body.rest_positions, corners)).sum();
    if turned >= 1.0 || facing == DVec3::ZERO {
        return Vec::new();
    }
    let pale = (255.0 * turned.max(0.0)).round() as u8;
    let is_turned = |corners: &[u32; 3]| {
        normal(&body.rest_positions, corners).dot(facing) * normal(&body.positions, corners).dot(facing) < 0.0
    };
    body.triangles.iter().map(|corners| if is_turned(corners) { pale } else { 255 }).collect()
}

/// Strokes along the fibres of the triangles seen at `columns` × `rows` points of `area`.
pub(super) fn draw_fibres(
    canvas: &mut Canvas,
    camera: &Camera,
    body: &BodyFrame,
    area: Area,
    grid: [u32; 2],
    weight: f64,
) {
    let [columns, rows] = grid;
    let cell = area.size() / DVec2::new(f64::from(columns), f64::from(rows));
    let points: Vec<DVec2> = (0..rows)
        .flat_map(|j| (0..columns).map(move |i| DVec2::new(f64::from(i) + 0.5, f64::from(j) + 0.5)))
        .map(|p| area.low + p * cell)
        .collect();
    let half = 0.3 * cell.min_element() / camera.scale;
    let mut strokes = Vec::new();
    let mut ends = Vec::new();
    for (&p, seen) in points.iter().zip(visible(camera, body, &points)) {
        let Some(t) = seen else { continue };
        let along = camera.along(half * body.fibres[t]);
        if along.is_finite() && along.length() > 1.0 {
            strokes.push([p - along, p + along]);
            ends.extend([p - along, p + along]);
        }
    }
    // A stroke that leaves the body would look like a bridge over a tear.
    let seen = visible(camera, body, &ends);
    for (stroke, _) in strokes.iter().zip(seen.chunks_exact(2)).filter(|(_, ends)| ends.iter().all(Option::is_some)) {
        draw_fibre(canvas, *stroke, weight);
    }
}

pub(super) fn draw_fibre(canvas: &mut Canvas, ends: [DVec2; 2], weight: f64) {
    canvas.stroke_haloed(&ends, false, Line::new(1.7 * weight, FIBRE), FIBRE_HALO);
}

/// The triangle seen at each point: of those that cover it, the one nearest to the viewer.
fn visible(camera: &Camera, body: &BodyFrame, points: &[DVec2]) -> Vec<Option<usize>> {
    let mut by_row: Vec<usize> = (0..points.len()).collect();
    by_row.sort_by(|&a, &b| points[a].y.total_cmp(&points[b].y));
    let mut nearest = vec![(f64::NEG_INFINITY, None); points.len()];
    for (t, corners) in body.triangles.iter().enumerate() {
        let x = corners.map(|v| body.positions[v as usize]);
        let [a, b, c] = x.map(|x| camera.project(x));
        let area = (b - a).perp_dot(c - a);
        if area == 0.0 {
            continue;
        }
        let (low, high) = (a.y.min(b.y).min(c.y), a.y.max(b.y).max(c.y));
        let start = by_row.partition_point(|&k| points[k].y < low);
        for &k in by_row[start..].iter().take_while(|&&k| points[k].y <= high) {
            let p = points[k];
            let weights = [(b - p).perp_dot(c - p), (c - p).perp_dot(a - p), (a - p).perp_dot(b - p)].map(|w| w / area);
            if weights.iter().all(|&w| w >= 0.0) {
                let depth: f64 = weights.iter().zip(x).map(|(w, x)| w * camera.depth(x)).sum();
                if depth > nearest[k].0 {
                    nearest[k] = (depth, Some(t));
                }
            }
        }
    }
    nearest.into_iter().map(|(_, t)| t).collect()
}

/// Whether the body lies in a plane across `direction`, to one percent of its size.
pub(super) fn is_flat(body: &BodyFrame, direction: DVec3) -> bool {
    let used = || body.triangles.iter().flatten().map(|&v| body.positions[v as usize]);
    let low = used().fold(DVec3::INFINITY, DVec3::min);
    let high = used().fold(DVec3::NEG_INFINITY, DVec3::max);
    let heights = || used().map(|x| x.dot(direction));
    let height = heights().fold(f64::NEG_INFINITY, f64::max) - heights().fold(f64::INFINITY, f64::min);
    height <= 0.01 * (high - low).length()
}

/// Brightness of a triangle, the same from both sides.
fn shade([a, b, c]: [DVec3; 3], camera: &Camera) -> f64 {
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let normal = if normal.dot(camera.toward) < 0.0 { -normal } else { normal };
    // Mostly ambient: brightness must not be mistaken for stress.
    0.70 + 0.32 * normal.dot(camera.light()).max(0.0)
}

fn lit([r, g, b, a]: Rgba, light: f64) -> Rgba {
    let [r, g, b] = [r, g, b].map(|v| (f64::from(v) * light).round().clamp(0.0, 255.0) as u8);
    [r, g, b, a]
}
