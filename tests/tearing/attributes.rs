//! Numbers of the host's own at vertices follow every edit: what is linear in the rest position stays so, through cuts, tears, refinement,
//! coarsening and new orders of the rows.

use crate::common::{NOTCH, Run, SIDE, Square};
use crate::meshes::{self, Random};
use glam::DVec3;
use rhexis::components::{Attributes, Channel, Material, Refinement};
use rhexis::membrane::{BodyError, Membrane};
use rhexis::settings::Settings;
use rhexis::simulation::{SetError, Simulation};
use rhexis::storage::{BodyId, TriangleMesh};

/// A linear function with three numbers.
fn linear(p: DVec3) -> [f64; 3] {
    [0.5 + 0.1 * p.x - 0.07 * p.y, -2.0 + 0.3 * p.y + 0.2 * p.z, p.x + p.y - p.z]
}

fn of(positions: &[DVec3]) -> Attributes {
    Attributes::new(3, positions.iter().flat_map(|&p| linear(p)).collect())
}

/// The largest difference from the linear function.
fn off(simulation: &mut Simulation, body: BodyId) -> f64 {
    let view = simulation.view(body).unwrap();
    let attributes = view.attributes.unwrap();
    assert_eq!(attributes.len(), view.positions.len());
    let parts = (0..)
        .zip(view.rest_positions)
        .flat_map(|(row, &p)| attributes.of(row).iter().zip(linear(p)).map(|(found, exact)| (found - exact).abs()));
    parts.fold(0.0, f64::max)
}

fn settings() -> Settings {
    Settings { threads: 1, ..Settings::default() }
}

// Tolerance: values of up to 60, blended some dozen times over, each time to a rounding of 1e-14.
const ROUNDING: f64 = 1e-12;

#[test]
fn linear_attributes_stay_linear_through_tears_refinement_and_reordering() {
    let square = Square::new([30, 26], 60.0);
    let refinement = Refinement { edges_per_radius: 6.0, ..Refinement::default() };
    let membrane = square.membrane();
    let attributes = of(&membrane.mesh().positions);
    let mut simulation = Simulation::new(settings()).unwrap();
    let body = simulation.spawn(membrane.with(refinement).with(attributes)).unwrap();
    simulation.cut(body, &NOTCH).unwrap();
    assert!(off(&mut simulation, body) < ROUNDING);
    let mut run = Run { simulation, body, events: Vec::new(), area: 0.0, mass: 0.0 };
    let count = run.vertices().len();
    run.stretch_to(0.6);
    for round in 0..60 {
        run.step();
        if round % 7 == 3 {
            run.simulation.reorder(body).unwrap();
        }
        assert!(off(&mut run.simulation, body) < ROUNDING, "round {round}");
    }
    assert!(run.log().advance_count > 5 && run.vertices().len() > count + 100);
}

#[test]
fn linear_attributes_stay_linear_through_random_cuts_on_flat_and_curved_bodies() {
    let sheets = [meshes::jittered(14, 12, 30.0, 25.0, 3), meshes::cap(8), meshes::sphere(3), meshes::torus(18, 12)];
    for (seed, sheet) in (1..).zip(sheets) {
        let mut random = Random::new(seed);
        let (attributes, positions) = (of(&sheet.positions), sheet.positions.clone());
        let mesh = TriangleMesh { positions: sheet.positions, triangles: sheet.corners, ..TriangleMesh::default() };
        let membrane = Membrane::new("sheet", mesh, Material::allard_2009()).with(attributes);
        let mut simulation = Simulation::new(settings()).unwrap();
        let body = simulation.spawn(membrane).unwrap();
        let (mut made, mut point) = (0, || positions[random.below(positions.len())]);
        for round in 0..12 {
            // Two points of the surface and one between: what a cut cannot do it refuses.
            let (a, b) = (point(), point());
            let near = a.lerp(b, 0.3);
            made += usize::from(simulation.cut(body, &[a, near]).is_ok());
            if round % 5 == 2 {
                simulation.reorder(body).unwrap();
            }
            assert!(off(&mut simulation, body) < ROUNDING, "sheet {seed}, round {round}");
        }
        assert!(made >= 4, "sheet {seed}: {made} cuts");
    }
}

#[test]
fn a_parted_vertex_gets_a_copy_and_one_on_an_edge_the_mean_of_its_ends() {
    // A square of two triangles in which a cut along the diagonal needs new vertices only at its ends.
    let positions = vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
    let mesh = TriangleMesh { positions, triangles: vec![[0, 1, 2], [0, 2, 3]], ..TriangleMesh::default() };
    let colours =
        Attributes { stride: 5, values: (0..20).map(f64::from).collect(), channels: vec![(Channel::Colour, 0)] };
    let mut simulation = Simulation::new(settings()).unwrap();
    let body = simulation.spawn(Membrane::new("two", mesh, Material::allard_2009()).with(colours.clone())).unwrap();
    simulation.cut(body, &[DVec3::ZERO, DVec3::new(1.0, 1.0, 0.0)]).unwrap();
    let view = simulation.view(body).unwrap();
    let after = view.attributes.unwrap();
    assert_eq!(after.len(), view.positions.len());
    for (row, &p) in (0..).zip(view.rest_positions) {
        let old = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y].iter().position(|&q| q == p);
        if let Some(old) = old {
            assert_eq!(after.of(row), colours.of(old as u32), "row {row}");
        }
    }
    assert!(after.len() > 4, "the diagonal is parted");
    assert_eq!(after.channel(Channel::Colour).unwrap().count(), after.len());
    assert!(after.channel(Channel::Normal).is_none());
}

#[test]
fn a_long_list_of_changes_that_nobody_drains_loses_no_attributes() {
    let mut run = Square::new([12, 10], 0.0).spawn(settings());
    let attributes = of(&run.vertices().rest_position);
    run.simulation.set(run.body, attributes).unwrap();
    run.simulation.world_mut().insert_one(run.body.entity(), rhexis::components::Changes::default()).unwrap();
    let before = run.vertices().len();
    for i in 1..12 {
        let x = SIDE * f64::from(i) / 12.0 + 0.3;
        let _ = run.simulation.cut(run.body, &[DVec3::new(x, 0.0, 0.0), DVec3::new(x, 0.8 * SIDE, 0.0)]);
    }
    assert!(run.vertices().len() > before + 50);
    assert!(off(&mut run.simulation, run.body) < ROUNDING);
}

#[test]
fn attributes_are_judged_at_every_door() {
    let square = Square::new([4, 4], 0.0);
    let spawn = |attributes: Attributes| {
        let mut simulation = Simulation::new(settings()).unwrap();
        let result: Result<BodyId, BodyError> =
            simulation.spawn(square.membrane().with(attributes)).map_err(|error| error.source);
        result.map(|body| (simulation, body))
    };
    let count = square.membrane().mesh().positions.len();
    let error = spawn(Attributes::new(2, vec![0.0; 7])).map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("Attributes: 7 numbers") && error.contains("stride × vertices"), "{error}");
    assert!(spawn(Attributes::new(0, Vec::new())).is_err());
    let (mut simulation, body) = spawn(Attributes::new(2, vec![0.0; 2 * count])).unwrap();
    let mut bad = Attributes::new(2, vec![0.0; 2 * count]);
    bad.values[2 * 3 + 1] = f64::NAN;
    let error = simulation.set(body, bad.clone()).unwrap_err().to_string();
    assert_eq!(error, "body `square`: Attributes: a number at vertex 3 is NaN: it must be finite");
    let beyond = Attributes { channels: vec![(Channel::Normal, 0)], ..Attributes::new(2, vec![0.0; 2 * count]) };
    let error = simulation.set(body, beyond).unwrap_err();
    assert!(matches!(error, SetError::Rejected(_)), "{error}");
    // Past the calls.
    simulation.world_mut().insert_one(body.entity(), bad).unwrap();
    let error = simulation.step(10.0).unwrap_err().to_string();
    assert!(error.contains("body `square`: Attributes: a number at vertex 3"), "{error}");
    assert!(simulation.unset::<Attributes>(body).unwrap());
    assert!(simulation.view(body).unwrap().attributes.is_none());
    simulation.step(10.0).unwrap();
}

/// Of the bits of a body, not of the host's numbers.
#[test]
fn a_tear_goes_the_same_way_with_and_without_attributes() {
    let ways = [false, true].map(|has| {
        let mut run = Square::new([20, 18], 60.0).spawn(settings());
        if has {
            let attributes = of(&run.vertices().rest_position);
            run.simulation.set(run.body, attributes).unwrap();
        }
        run.stretch_to(0.6);
        run.run_until(80, |run| run.log().advance_count >= 4);
        run.simulation.hash()
    });
    assert_eq!(ways[0], ways[1]);
}

#[cfg(feature = "snapshot")]
#[test]
fn attributes_are_in_snapshots_and_recordings() {
    use rhexis::snapshot::Snapshot;
    let mut run = Square::new([8, 6], 0.0).spawn(settings());
    run.simulation.record();
    let attributes = of(&run.vertices().rest_position);
    run.simulation.set(run.body, attributes).unwrap();
    let bytes = run.simulation.snapshot().to_bytes().unwrap();
    let mut again = Simulation::from_snapshot(&Snapshot::from_bytes(&bytes).unwrap()).unwrap();
    again.cut(run.body, &[DVec3::new(10.0, 0.0, 0.0), DVec3::new(10.0, 9.0, 0.0)]).unwrap();
    assert!(off(&mut again, run.body) < ROUNDING);
    // A restored one has the numbers of its own moment.
    run.simulation.cut(run.body, &[DVec3::new(20.0, 0.0, 0.0), DVec3::new(20.0, 9.0, 0.0)]).unwrap();
    run.simulation.restore(&Snapshot::from_bytes(&bytes).unwrap()).unwrap();
    assert!(off(&mut run.simulation, run.body) < ROUNDING);
    let recording = run.simulation.end_recording().unwrap();
    let mut replayed = recording.replay().unwrap();
    assert!(off(&mut replayed, run.body) < ROUNDING);
}
