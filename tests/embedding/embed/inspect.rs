//! What a host can ask for: tips, pieces, tools, places of the tissue, one kind of error.

use crate::common::{SIDE, Square};
use glam::DVec3;
use rhexis::components::ChangeSet;
use rhexis::prelude::*;
use rhexis::simulation::SimulationError;

#[test]
fn tips_and_pieces_are_those_of_the_tear() {
    let mut run = Square::new([20, 16], 60.0).spawn(Settings::default());
    let tip = run.simulation.tips(run.body).unwrap()[0];
    // The notch ends 3 mm under the rim, at a vertex that cuts may have slid to it.
    assert!(tip.rest_position.distance(DVec3::new(15.0, 27.0, 0.0)) < 1e-9, "{tip:?}");
    assert_eq!(run.simulation.fragments(run.body).unwrap().count(), 1);
    run.tear_through();
    assert!(run.simulation.tips(run.body).unwrap().is_empty());
    let fragments = run.simulation.fragments(run.body).unwrap();
    let view = run.simulation.view(run.body).unwrap();
    assert!(fragments.count() == 2 && fragments.of_triangle[0] == 0);
    // Both are there with all of the square's area, to a rounding per triangle.
    assert!((fragments.areas.iter().sum::<f64>() / (SIDE * SIDE) - 1.0).abs() < 1e-12);
    for (corners, piece) in view.triangles.iter().zip(&fragments.of_triangle) {
        assert!(corners.iter().all(|&v| fragments.of_vertex[v as usize] == *piece));
    }
    // The tear runs from the upper rim to the left one.
    let at = |x: f64| view.rest_positions.iter().position(|p| p.x == x && p.y == SIDE).unwrap();
    assert_ne!(fragments.of_vertex[at(0.0)], fragments.of_vertex[at(SIDE)]);
}

#[test]
fn copies_have_the_rest_position_of_their_source() {
    let mut run = Square::new([20, 16], 60.0).spawn(Settings::default());
    run.simulation.world_mut().insert_one(run.body.entity(), Changes::default()).unwrap();
    let mut changes = ChangeSet::default();
    run.simulation.drain_changes(run.body, &mut changes).unwrap();
    run.simulation.cut(run.body, &[DVec3::new(5.0, 0.0, 0.0), DVec3::new(5.0, 6.0, 0.0)]).unwrap();
    run.simulation.drain_changes(run.body, &mut changes).unwrap();
    let view = run.simulation.view(run.body).unwrap();
    let copies: Vec<_> = changes.copies().collect();
    assert!(copies.len() >= 3, "{copies:?}");
    // No row was removed, so that rows at the moment of a change are those of now; moved vertices move with their copies.
    assert!(copies.iter().all(|&(copy, source)| {
        view.rest_positions[copy as usize].distance(view.rest_positions[source as usize]) < 1e-12
    }));
}

#[test]
fn a_point_of_the_tissue_is_found_where_it_has_gone() {
    let mut run = Square::new([12, 12], 0.0).spawn(Settings::default());
    run.simulation.unset::<rhexis::components::Holds>(run.body).unwrap();
    run.simulation.teleport(run.body, DQuat::from_rotation_z(0.5), DVec3::new(3.0, -2.0, 0.0)).unwrap();
    let at = DVec3::new(4.3, 7.9, 0.0);
    let hit = run.simulation.current(run.body, at).unwrap();
    let expected = DQuat::from_rotation_z(0.5) * at + DVec3::new(3.0, -2.0, 0.0);
    // Roundings of coordinates up to 40 mm.
    assert!(hit.position.distance(expected) < 1e-12 && hit.rest_position.distance(at) < 1e-12, "{hit:?}");
    assert!(run.simulation.current(run.body, DVec3::NAN).is_none());
}

#[test]
fn tools_and_obstacles_are_listed_and_all_is_judged_on_request() {
    let mut run = Square::new([6, 6], 0.0).spawn(Settings::default());
    let simulation = &mut run.simulation;
    assert!(simulation.tools().is_empty() && simulation.obstacles().is_empty());
    let jaws = Jaws { radius: 0.5, stiffness: None, force_limit: None, slip: Slip::Slide };
    let forceps = simulation.spawn_forceps("forceps", jaws, Pose::at(DVec3::ZERO)).unwrap();
    let blade = simulation.spawn_blade(0.5, 1.0).unwrap();
    let shape = Shape::Sphere { centre: DVec3::new(0.0, 0.0, 9.0), radius: 1.0 };
    let obstacle = simulation.spawn_obstacle(Obstacle { shape }).unwrap();
    assert_eq!((simulation.tools(), simulation.obstacles()), (vec![forceps.entity(), blade.entity()], vec![obstacle]));
    simulation.validate().unwrap();
    simulation.world_mut().get::<&mut Tearing>(run.body.entity()).unwrap().radius = -1.0;
    let error = Error::from(simulation.validate().unwrap_err());
    assert!(matches!(error, Error::Simulation(SimulationError::Written(_))) && error.kind() == ErrorKind::InvalidInput);
    assert!(error.to_string().contains("Tearing"), "{error}");
}

/// A membrane is checked before it is spawned, and spawned as often as one likes.
#[test]
fn a_membrane_is_checked_and_cloned() {
    let sheet = Membrane::new("sheet", generate::grid(4.0, 4.0, 4, 4).unwrap(), Material::allard_2009()).planar();
    sheet.validate().unwrap();
    let wrong = sheet.clone().with(Damping { time: -1.0 });
    assert!(wrong.validate().unwrap_err().to_string().contains("Damping"));
    let mut simulation = Simulation::new(Settings::default()).unwrap();
    let bodies = [simulation.spawn(sheet.clone()).unwrap(), simulation.spawn(sheet).unwrap()];
    simulation.step(1.0).unwrap();
    let [a, b] = bodies.map(|body| simulation.view(body).unwrap().positions.to_vec());
    assert_eq!(a, b);
    let mut single = Vec::new();
    simulation.view(bodies[0]).unwrap().positions_f32(&mut single);
    assert!(single.len() == a.len() && single[7] == a[7].as_vec3().to_array());
}
