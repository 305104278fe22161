//! A new order of a body's rows changes where things are, and nothing of what they are.

use crate::common::{NOTCH, Run, Square};
use glam::DVec3;
use rhexis::components::{
    Anchor, Curve, EdgeLoad, EdgeLoads, Holds, PointLoad, PointLoads, Reactions, Refined, Refinement, RefusedSite,
    Springs, TearDecisions,
};
use rhexis::settings::Settings;
use rhexis::simulation::{Simulation, SimulationError};
use rhexis::storage::{Attached, Tips, TriangleKey, Triangles, VertexKey, Vertices};
use std::collections::BTreeMap;

fn settings() -> Settings {
    Settings { threads: 1, ..Settings::default() }
}

/// Of a held vertex.
type OffsetAndForce = ([u64; 3], [u64; 3]);

/// Everything of a body under keys, as bits.
#[derive(Debug, PartialEq)]
struct Meaning {
    vertices: BTreeMap<VertexKey, Vec<u64>>,
    triangles: BTreeMap<TriangleKey, ([VertexKey; 3], Vec<u64>)>,
    holds: Vec<BTreeMap<VertexKey, OffsetAndForce>>,
    springs: BTreeMap<VertexKey, u64>,
    loaded: Vec<VertexKey>,
    loaded_edges: Vec<[VertexKey; 2]>,
    tips: Vec<VertexKey>,
}

fn bits(v: DVec3) -> [u64; 3] {
    v.to_array().map(f64::to_bits)
}

fn meaning(run: &Run) -> Meaning {
    let world = run.simulation.world();
    let vertices = world.get::<&Vertices>(run.body.entity()).unwrap();
    let triangles = world.get::<&Triangles>(run.body.entity()).unwrap();
    let key = |row: u32| vertices.key(row).unwrap();
    let of_vertex =
        |v: usize| [vertices.position[v], vertices.velocity[v], vertices.rest_position[v]].map(bits).concat();
    let of_triangle = |t: usize| {
        let rest = &triangles.rest[t];
        let numbers = rest.gradients.iter().flat_map(|g| g.to_array()).chain([rest.area, triangles.thickness[t]]);
        let numbers = numbers.map(f64::to_bits).chain(bits(triangles.fibre[t])).collect();
        (triangles.corners[t].map(key), numbers)
    };
    let holds = world.get::<&Holds>(run.body.entity()).unwrap();
    let reactions = world.get::<&Reactions>(run.body.entity()).unwrap();
    let of_hold = |(hold, forces): (&rhexis::components::Hold, &Vec<DVec3>)| {
        assert!(hold.members.rows().is_sorted());
        let members = hold.members.rows().iter().zip(hold.members.values()).zip(forces);
        members.map(|((&row, &offset), &force)| (key(row), (bits(offset), bits(force)))).collect()
    };
    let springs = world.get::<&Springs>(run.body.entity()).unwrap();
    let anchors = springs.anchors.rows().iter().zip(springs.anchors.values());
    let edges = world.get::<&EdgeLoads>(run.body.entity()).unwrap();
    Meaning {
        vertices: (0..vertices.len()).map(|v| (key(v as u32), of_vertex(v))).collect(),
        triangles: (0..triangles.len()).map(|t| (triangles.key(t as u32).unwrap(), of_triangle(t))).collect(),
        holds: holds.groups.iter().zip(&reactions.groups).map(of_hold).collect(),
        springs: anchors.map(|(&row, anchor)| (key(row), anchor.stiffness.to_bits())).collect(),
        loaded: world.get::<&PointLoads>(run.body.entity()).unwrap().groups[0]
            .rows
            .iter()
            .map(|&row| key(row))
            .collect(),
        loaded_edges: edges.groups[0].edges.iter().map(|edge| edge.map(key)).collect(),
        tips: world.get::<&Tips>(run.body.entity()).unwrap().vertex.iter().map(|&row| key(row)).collect(),
    }
}

/// The square with something on every kind of list, torn some way.
fn half_torn() -> Run {
    let mut run = Square::new([30, 26], 60.0).spawn(settings());
    let vertices = run.vertices();
    let rows =
        |at: fn(DVec3) -> bool| (0..).zip(&vertices.rest_position).filter(move |(_, p)| at(**p)).map(|(row, _)| row);
    let anchors = rows(|p| p.y == 0.0).map(|row: u32| (row, Anchor::new(DVec3::new(f64::from(row), 0.0, 0.0), 1e-9)));
    let springs = Springs { anchors: Attached::new(anchors) };
    let force = DVec3::new(0.0, -1e-9, 0.0);
    let point = PointLoad { rows: rows(|p| p.y == 15.0).collect(), force, curve: Curve::constant(1.0) };
    let bottom: Vec<u32> = rows(|p| p.y == 0.0).collect();
    let edges = bottom.windows(2).map(|w| [w[0], w[1]]).collect();
    let edge = EdgeLoad { edges, traction: force, curve: Curve::constant(1.0) };
    let world = run.simulation.world_mut();
    world
        .insert(run.body.entity(), (springs, PointLoads { groups: vec![point] }, EdgeLoads { groups: vec![edge] }))
        .unwrap();
    world.insert_one(run.body.entity(), rhexis::components::ExternalStiffness::default()).unwrap();
    run.stretch_to(0.6);
    run.run_until(60, |run| run.log().advance_count >= 6);
    run
}

#[test]
fn everything_means_what_it_meant() {
    let mut run = half_torn();
    assert!(run.log().end_count == 0, "half torn");
    let before = meaning(&run);
    let energies = run.simulation.energies(run.body).unwrap();
    run.simulation.reorder(run.body).unwrap();
    run.assert_sound();
    assert!(meaning(&run) == before);
    assert!(!before.tips.is_empty() && before.holds.len() == 2);
    // The same numbers, added up in another order.
    let after = run.simulation.energies(run.body).unwrap();
    assert!((after.elastic / energies.elastic - 1.0).abs() < 1e-13);
    let rows = run.vertices();
    run.simulation.reorder(run.body).unwrap();
    assert_eq!(run.vertices().keys(), rows.keys(), "a second time changes nothing");

    let nobody = run.body;
    run.simulation.despawn(nobody).unwrap();
    assert_eq!(run.simulation.reorder(nobody), Err(SimulationError::NoSuchBody));
}

#[test]
fn a_torn_body_goes_on_as_it_would_have() {
    let tear = |is_reordered: bool| {
        let mut run = half_torn();
        if is_reordered {
            run.simulation.reorder(run.body).unwrap();
        }
        run.tear_through();
        run.assert_sound();
        run
    };
    let [straight, sorted] = [false, true].map(tear);
    assert_eq!(sorted.fragment_count(), 2);
    assert_eq!(straight.log().advance_count, sorted.log().advance_count);
    // Sums in another order, and a factor made anew: solves of a tolerance of 1e-4 differ by as much, and so does the way.
    assert!(straight.end().distance(sorted.end()) < 0.02, "{} {}", straight.end(), sorted.end());
}

/// Coarsening takes away rows of which the last refused start and the decisions of the last step may tell.
#[test]
fn what_was_told_of_vertices_that_are_gone_is_no_matter() {
    let square = Square::new([30, 26], 60.0);
    let mut simulation = Simulation::new(settings()).unwrap();
    let body = simulation.spawn(square.membrane().with(Refinement::default())).unwrap();
    simulation.cut(body, &NOTCH).unwrap();
    let mut run = Run { simulation, body, events: Vec::new(), area: 0.0, mass: 0.0 };
    run.stretch_to(0.6);
    run.run_until(60, |run| run.log().advance_count >= 1);
    let made = run.simulation.world().get::<&Refined>(body.entity()).unwrap().made.clone();
    let is_gone = |run: &Run, key| run.vertices().row(key).is_none();
    run.run_until(60, |run| made.iter().any(|&key| is_gone(run, key)));
    let gone = *made.iter().find(|&&key| is_gone(&run, key)).unwrap();
    run.simulation.entity_mut::<&mut TearDecisions>(body).unwrap().refused_nucleation = Some(RefusedSite::Vertex(gone));
    run.simulation.reorder(body).unwrap();
    let decisions = run.simulation.world().get::<&TearDecisions>(body.entity()).unwrap();
    let count = run.vertices().len() as u32;
    assert!(decisions.tips.iter().flatten().all(|decision| decision.row < count));
}
