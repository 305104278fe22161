//! The disc at a tip lies about the point where the elements' field has its tip, behind the vertex: averages are those of the
//! continuum, and where there is no crack nothing moves.

use crate::meshes::{self, Body, Sheet};
use glam::{DVec2, DVec3};
use rhexis::components::{Curve, Fibres, Hold, Material, PreStretch, Tearing};
use rhexis::math::Sym2;
use rhexis::membrane::Membrane;
use rhexis::settings::Settings;
use rhexis::simulation::Simulation;
use rhexis::storage::{Attached, BodyId, Edit, Tips, Topology, TriangleMesh, Triangles, Vertices, apply};
use rhexis::systems::fracture::{Surface, TipMemory, field_tip};
use rhexis::systems::kernels::failure::Strength;
use rhexis_scene::generate;
use std::f64::consts::PI;

const SIDE: f64 = 30.0;
const RADIUS: f64 = 1.5;

/// Squares whose triangles have this size (edge of the equilateral one).
fn meshes_of_size(size: f64, seed: u64) -> [(&'static str, TriangleMesh); 4] {
    let corners = [DVec2::ZERO, DVec2::new(SIDE, 0.0), DVec2::splat(SIDE), DVec2::new(0.0, SIDE)];
    let cells = (SIDE / size * (2.0 / 3.0_f64.sqrt()).sqrt()).ceil() as usize;
    [
        ("structured", generate::grid(SIDE, SIDE, cells, cells).unwrap()),
        ("rotated", generate::lattice(&corners, size, 5.0 + 9.0 * seed as f64).unwrap()),
        ("jittered", generate::jittered(SIDE, SIDE, cells, cells, seed).unwrap()),
        ("unstructured", generate::unstructured(&corners, size, seed).unwrap()),
    ]
}

/// The square of `tip_disc_average.json`: a crack of 9 mm up from the middle of the bottom edge, each grip moved by 0.003 mm.
fn cracked(mesh: TriangleMesh, material: Material, fibre: f64) -> (Simulation, BodyId) {
    let mut sheet = Membrane::new("square", mesh, material).planar().fibres(Fibres::at_degrees(fibre));
    for (name, x, way) in [("left", 0.0, DVec3::NEG_X), ("right", SIDE, DVec3::X)] {
        let members = Attached::new(sheet.select(|p| p.x == x).into_iter().map(|row| (row, way)));
        let curve = Curve::ramp(1.0, 0.003).unwrap();
        sheet = sheet.hold(Hold { name: name.into(), members, axes: [true; 3], curve });
    }
    let mut simulation = Simulation::new(Settings::default()).unwrap();
    let body = simulation.spawn(sheet.with(Tearing { radius: RADIUS, ..Tearing::default() })).unwrap();
    simulation.cut(body, &[DVec3::new(15.0, 0.0, 0.0), DVec3::new(15.0, 9.0, 0.0)]).unwrap();
    simulation.linear_response(1.0).unwrap();
    (simulation, body)
}

/// Average stress in x and y at the first tip, and edges per radius.
fn average(simulation: &Simulation, body: BodyId) -> (Sym2, f64) {
    let world = simulation.world();
    let (vertices, triangles) =
        (world.get::<&Vertices>(body.entity()).unwrap(), world.get::<&Triangles>(body.entity()).unwrap());
    let (topology, tips) = (world.get::<&Topology>(body.entity()).unwrap(), world.get::<&Tips>(body.entity()).unwrap());
    let (is_planar, unstretched, fibres) = (true, PreStretch::unstretched(None), None);
    let surface = Surface {
        vertices: &vertices,
        triangles: &triangles,
        topology: &topology,
        is_planar,
        unstretched,
        fibres,
        bending: None,
    };
    let strength = Strength::new(2.0, 1.0, 0.5).unwrap();
    let mut memory = TipMemory::default();
    let (chart, _, average) = memory.at_tip(&surface, (0, tips.vertex[0]), strength, RADIUS).unwrap();
    let seen = |a: DVec3| DVec2::new(a.dot(chart.axes()[0]), a.dot(chart.axes()[1]));
    (average.stress.in_axes(seen(DVec3::X), seen(DVec3::Y)), average.edges_per_radius)
}

/// 5 % is asked for from three edges per radius on. What is reached is printed; the worst of all is 1.9 %: δ differs by a tenth
/// of an edge between kinds of mesh and laws. About the vertex itself the averages would be 4 to 9 % too high.
#[test]
fn the_average_at_a_tip_is_that_of_the_continuum() {
    let text = std::fs::read_to_string("../rhexis-lab/tests/reference/tip_disc_average.json").unwrap();
    let reference: serde_json::Value = serde_json::from_str(&text).unwrap();
    for (case, tissue, material, fibre) in
        [(0, "isotropic", Material::isotropic(3.0, 0.3, 0.1), 0.0), (1, "fibres at 45°", Material::allard_2009(), 45.0)]
    {
        let wanted = &reference["cases"][case]["rows"][1];
        assert_eq!(wanted["r"], RADIUS);
        let wanted = [0, 1, 2].map(|i| wanted["average_sxx_syy_sxy"][i].as_f64().unwrap());
        for edges in [3.0, 4.0] {
            let mut errors: [(&str, Vec<f64>); 4] = Default::default();
            for seed in 0..3 {
                for (kind, (name, mesh)) in meshes_of_size(RADIUS / edges, seed).into_iter().enumerate() {
                    let (simulation, body) = cracked(mesh, material, fibre);
                    let (s, found) = average(&simulation, body);
                    // Near a cut triangles are up to a tenth larger than on average.
                    assert!(found > 0.88 * edges && found < 1.1 * edges, "{name}: {found} edges per radius");
                    let off = [s.xx - wanted[0], s.yy - wanted[1], s.xy - wanted[2]].map(|e| e / wanted[0]);
                    let worst = off.into_iter().fold(0.0, |a: f64, e| if e.abs() > a.abs() { e } else { a });
                    errors[kind].0 = name;
                    errors[kind].1.push(100.0 * worst);
                }
            }
            for (name, errors) in errors {
                println!("{tissue}, {edges} edges per R, {name}: {errors:.2?} %");
                assert!(errors.iter().all(|e| e.abs() < 2.5), "{tissue} {edges} {name}: {errors:?}");
            }
        }
    }
}

fn surface(body: &Body) -> Surface<'_> {
    let Body { vertices, triangles, topology } = body;
    Surface {
        vertices,
        triangles,
        topology,
        is_planar: false,
        unstretched: Sym2::IDENTITY,
        fibres: None,
        bending: None,
    }
}

/// Where the field has its tip for a disc of this radius, as offset from the vertex in space.
fn offset(body: &Body, vertex: u32, radius: f64) -> DVec3 {
    let surface = surface(body);
    let chart = surface.chart(vertex).unwrap();
    let [e1, e2] = chart.axes();
    let offset = field_tip(&surface, (vertex, radius), &chart);
    e1 * offset.x + e2 * offset.y
}

fn vertex_at(body: &Body, p: DVec3) -> u32 {
    body.vertices.rest_position.iter().position(|q| q.distance(p) < 1e-9).unwrap() as u32
}

/// Opens the edges along a path of points.
fn open(body: &mut Body, path: &[DVec3]) -> u32 {
    let rows: Vec<u32> = path.iter().map(|&p| vertex_at(body, p)).collect();
    apply(&mut body.mesh(), &Edit::Open { path: rows.iter().copied().collect() }).unwrap();
    rows[rows.len() - 1]
}

#[test]
fn the_field_has_its_tip_behind_the_vertex_of_a_crack_and_nowhere_else() {
    let mut body = Body::new(&meshes::grid(8, 8, 8.0, 8.0), DVec3::X);
    for p in [DVec3::new(4.0, 4.0, 0.0), DVec3::ZERO, DVec3::new(3.0, 0.0, 0.0), DVec3::new(8.0, 8.0, 0.0)] {
        let vertex = vertex_at(&body, p);
        assert_eq!(offset(&body, vertex, 3.0), DVec3::ZERO, "{p}: inside, on the rim, at a corner");
    }
    // The size of a half square cell.
    let edge = (2.0 / 3.0_f64.sqrt()).sqrt();
    // A crack of one edge, then of two: the same tip of the field, a third of an edge behind.
    let at = |y: f64| DVec3::new(4.0, y, 0.0);
    for (path, back) in [(vec![at(0.0), at(1.0)], DVec3::NEG_Y), (vec![at(1.0), at(2.0)], DVec3::NEG_Y)] {
        let tip = open(&mut body, &path);
        let found = offset(&body, tip, 3.0);
        assert!(found.normalize().distance(back) < 1e-15 && (found.length() / edge - 0.32).abs() < 1e-12, "{found}");
    }
    // A disc of half an edge sees no field beyond the first triangles.
    let tip = vertex_at(&body, at(2.0));
    let [none, half, whole] = [0.5, 0.75, 1.0].map(|part| offset(&body, tip, part * edge).length() / edge);
    assert!(none == 0.0 && (half - 0.16).abs() < 1e-12 && (whole - 0.32).abs() < 1e-12);
    // Around a corner: behind the tip, along its last edge.
    let tip = open(&mut body, &[at(2.0), DVec3::new(5.0, 2.0, 0.0)]);
    assert!(offset(&body, tip, 3.0).normalize().distance(DVec3::NEG_X) < 1e-15);
}

/// Never farther back than the crack's last edge.
#[test]
fn a_crack_shorter_than_what_is_held_shut_keeps_the_point_on_it() {
    let mut sheet = meshes::grid(8, 8, 8.0, 8.0);
    let tip = sheet.positions.iter().position(|p| *p == DVec3::new(4.0, 1.0, 0.0)).unwrap();
    sheet.positions[tip].y = 0.2;
    let mut body = Body::new(&sheet, DVec3::X);
    let tip = open(&mut body, &[DVec3::new(4.0, 0.0, 0.0), DVec3::new(4.0, 0.2, 0.0)]);
    assert!(offset(&body, tip, 3.0).distance(DVec3::new(0.0, -0.2, 0.0)) < 1e-15);
}

/// A fan of a disc with a notch that opens by so much about the direction −x, its vertex at the origin.
fn notched(opening: f64, rise: f64) -> Body {
    let count = 12;
    let mut sheet = Sheet { positions: vec![DVec3::ZERO], corners: Vec::new() };
    for i in 0..=count {
        let angle = (PI - 0.5 * opening) * (2.0 * f64::from(i) / f64::from(count) - 1.0);
        sheet.positions.push(DVec3::new(angle.cos(), angle.sin(), -rise));
    }
    sheet.corners = (0..count as u32).map(|i| [0, i + 1, i + 2]).collect();
    Body::new(&sheet, DVec3::X)
}

#[test]
fn a_notch_with_a_width_is_a_crack_as_long_as_it_is_narrow() {
    for (degrees, is_crack) in [(1e-9, true), (10.0, true), (60.0, true), (89.0, true), (91.0, false), (180.0, false)] {
        let found = offset(&notched(f64::to_radians(degrees), 0.0), 0, 3.0);
        assert_eq!(found != DVec3::ZERO, is_crack, "{degrees}°");
        assert!(!is_crack || found.normalize().distance(DVec3::NEG_X) < 1e-14, "{degrees}°: {found}");
    }
    // On a cone the point lies in the tangent plane of the vertex.
    let found = offset(&notched(0.1, 0.2), 0, 3.0);
    let body = notched(0.1, 0.2);
    let [e1, e2] = surface(&body).chart(0).unwrap().axes();
    let normal = e1.cross(e2);
    assert!(found.length() > 0.1 && found.dot(normal).abs() < 1e-15 && found.y.abs() < 1e-15 && found.x < 0.0);
}

/// Fibres that turn evenly along the crack: what the criterion gets is the fibre at the vertex, not that at the disc's centre.
#[test]
fn the_fibre_is_that_at_the_vertex() {
    // Turn per length; over the offset of 0.17 mm it is 0.017 rad.
    let turn = 0.1;
    let mut body = Body::new(&meshes::grid(40, 40, 20.0, 20.0), DVec3::X);
    let path: Vec<DVec3> = (0..=20).map(|j| DVec3::new(10.0, 0.5 * f64::from(j), 0.0)).collect();
    for t in 0..body.triangles.len() {
        let x = body.triangles.corners[t].map(|v| body.vertices.rest_position[v as usize]);
        let middle = (x[0] + x[1] + x[2]) / 3.0;
        body.triangles.fibre[t] = DVec2::from_angle(turn * (middle.y - 10.0)).extend(0.0);
    }
    let tip = open(&mut body, &path);
    assert!(offset(&body, tip, 3.0).length() > 0.15);
    let mut memory = TipMemory::default();
    let strength = Strength::new(2.0, 1.0, 0.5).unwrap();
    let (.., average) = memory.at_tip(&surface(&body), (0, tip), strength, 2.0).unwrap();
    // The middle of 200 triangles, cut by the rim, against that of the disc.
    assert!(average.fibre.to_angle().abs() < 1e-3, "{}", average.fibre.to_angle());
    assert!((average.fibre_turn - DVec2::new(0.0, turn)).length() < 0.01 * turn);
}
