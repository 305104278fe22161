//! Refinement around tear tips and coarsening behind them.

mod common;

use common::{SIDE};
use glam::{DVec2, DVec3};
use hecs::Entity;
use rhexis::components::{
    Curve, Fibres, Hold, Material, Planar, PreStretch, Refined, Refinement, TearDecision, TearDecisions,
    Tearing,
};
use rhexis::membrane::Membrane;
use rhexis::scene::generate;
use rhexis::settings::Settings;
use rhexis::simulation::Simulation;
use rhexis::storage::{Attached, Tips, Topology, TriangleMesh, Triangles, Vertices, measure};
use rhexis::systems::tearing::{Surface, tip_decision};

/// The square of `tip_disc_average.json`: a crack of 9 mm up from the middle of the bottom edge, grips 0.003 mm apart each way.
fn cracked(mesh: TriangleMesh, material: Material, fibre: f64, radius: f64, refinement: Option<Refinement>) -> (Simulation, Entity) {
    let mut sheet = Membrane::new("square", mesh, material).planar().fibres(Fibres::at_degrees(fibre));
    for (name, x, way) in [("left", 0.0, DVec3::NEG_X), ("right", SIDE, DVec3::X)] {
        let members = Attached::new(sheet.select(|p| p.x == x).into_iter().map(|row| (row, way)));
        sheet = sheet.hold(Hold { name: name.into(), members, axes: [true; 3], curve: Curve::ramp(1.0, 0.003).unwrap() });
    }
    sheet = sheet.with(Tearing { radius, ..Tearing::default() });
    if let Some(refinement) = refinement {
        sheet = sheet.with(refinement);
    }
    let mut simulation = Simulation::new(Settings::default()).unwrap();
    let body = simulation.spawn(sheet).unwrap();
    simulation.cut(body, &[DVec3::new(15.0, 0.0, 0.0), DVec3::new(15.0, 9.0, 0.0)]).unwrap();
    (simulation, body)
}

/// What the criterion finds at the body's one tip.
fn decision(simulation: &Simulation, body: Entity) -> TearDecision {
    let world = simulation.world();
    let (vertices, triangles) = (world.get::<&Vertices>(body).unwrap(), world.get::<&Triangles>(body).unwrap());
    let (topology, tips) = (world.get::<&Topology>(body).unwrap(), world.get::<&Tips>(body).unwrap());
    let tearing = world.get::<&Tearing>(body).unwrap();
    let surface = Surface {
        vertices: &vertices,
        triangles: &triangles,
        topology: &topology,
        is_planar: world.get::<&Planar>(body).is_ok(),
        unstretched: PreStretch::unstretched(None),
    };
    tip_decision(&surface, &tearing, tips.vertex[0], tips.previous[0], &mut TearDecisions::default()).unwrap()
}

fn angles(simulation: &Simulation, body: Entity) -> Vec<f64> {
    let world = simulation.world();
    let (vertices, triangles) = (world.get::<&Vertices>(body).unwrap(), world.get::<&Triangles>(body).unwrap());
    let mut all: Vec<f64> = measure::rest_angles(&vertices, &triangles).map(f64::to_degrees).collect();
    all.sort_by(f64::total_cmp);
    all
}

fn meshes(edge: f64, seed: u64) -> [(&'static str, TriangleMesh); 4] {
    let corners = [DVec2::ZERO, DVec2::new(SIDE, 0.0), DVec2::splat(SIDE), DVec2::new(0.0, SIDE)];
    let n = (SIDE / edge).round() as usize;
    [
        ("grid", generate::grid(SIDE, SIDE, n, n).unwrap()),
        ("jittered", generate::jittered(SIDE, SIDE, n, n, seed).unwrap()),
        ("lattice", generate::lattice(&corners, edge, 17.0).unwrap()),
        ("unstructured", generate::unstructured(&corners, edge, seed).unwrap()),
    ]
}

#[test]
fn a_mesh_of_one_edge_per_radius_is_refined_until_the_disc_average_is_right() {
    let text = std::fs::read_to_string("tests/reference/tip_disc_average.json").unwrap();
    let reference: serde_json::Value = serde_json::from_str(&text).unwrap();
    for (case, material, fibre) in [(0, Material::isotropic(3.0, 0.3, 0.1), 0.0), (1, Material::figure_2(), 45.0)] {
        for row in 0..3 {
            let wanted = &reference["cases"][case]["rows"][row];
            let radius = wanted["r"].as_f64().unwrap();
            let [xx, yy, xy] = [0, 1, 2].map(|i| wanted["average_sxx_syy_sxy"][i].as_f64().unwrap());
            for (name, mesh) in meshes(radius, 3) {
                let off = |refinement: Option<Refinement>| {
                    let (mut simulation, body) = cracked(mesh.clone(), material, fibre, radius, refinement);
                    simulation.linear_response(1.0).unwrap();
                    let found = decision(&simulation, body);
                    let [e1, e2] = found.axes;
                    let e = |a: DVec3| DVec2::new(a.dot(e1), a.dot(e2));
                    let stress = found.stress.in_axes(e(DVec3::X), e(DVec3::Y));
                    let worst = [stress.xx - xx, stress.yy - yy, stress.xy - xy].map(f64::abs).into_iter().fold(0.0, f64::max);
                    let count = simulation.world().get::<&Triangles>(body).unwrap().len();
                    let angles = angles(&simulation, body);
                    format!("off {:.2} %, {:.2} edges, {count} triangles, angles {:.1} {:.1}", 100.0*worst/xx, found.edges_per_radius, angles[0], angles[angles.len() / 100])
                };
                println!("{case} r {radius} {name}: {:?} -> {:?}", off(None), off(Some(Refinement::default())));
            }
        }
    }
}
