//! Vertices pinned, moved and let go between steps.

use crate::common::Square;
use glam::DVec3;
use rhexis::components::{Fibres, Material, Sleeping, Tearing};
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::settings::Settings;
use rhexis::simulation::{Pin, PinError, Simulation};
use rhexis::storage::{BodyId, VertexKey};

fn sheet() -> Membrane {
    let mesh = generate::grid(10.0, 10.0, 10, 10).unwrap();
    Membrane::new("sheet", mesh, Material::allard_2009()).fibres(Fibres::at_degrees(30.0)).planar()
}

fn at_x(simulation: &mut Simulation, body: BodyId, x: f64) -> Vec<VertexKey> {
    let view = simulation.view(body).unwrap();
    let is_there = |(_, p): &(&VertexKey, &DVec3)| p.x == x;
    view.vertex_keys.iter().zip(view.rest_positions).filter(is_there).map(|(key, _)| *key).collect()
}

#[test]
fn pins_hold_move_and_let_go() {
    let mut simulation = Simulation::new(Settings::default()).unwrap();
    let body = simulation.spawn(sheet().with(Sleeping::default())).unwrap();
    let (left, right) = (at_x(&mut simulation, body, 0.0), at_x(&mut simulation, body, 10.0));
    simulation.pin(body, "left", &left).unwrap();
    simulation.pin(body, "right", &right[..4]).unwrap();
    simulation.pin(body, "right", &right[4..]).unwrap();
    simulation.move_pins(body, "right", |pin| pin.place + DVec3::X * 0.1).unwrap();
    simulation.settle(1.0, 1e-9).unwrap();
    let reactions = simulation.reactions(body).unwrap();
    // The static tolerance, over some 0.1 N.
    assert!((reactions[0].1 + reactions[1].1).length() < 1e-8 && reactions[1].1.x > 1e-3, "{reactions:?}");
    let pins = simulation.pins(body, "right").unwrap();
    assert_eq!(pins.len(), 11);
    for Pin { vertex, rest_position, place } in pins {
        assert_eq!(place, rest_position + DVec3::X * 0.1);
        let view = simulation.view(body).unwrap();
        let row = view.vertex_keys.iter().position(|key| *key == vertex).unwrap();
        assert!(view.positions[row].distance(place) < 1e-12);
    }
    simulation.unpin(body, &right).unwrap();
    simulation.settle(1.0, 1e-9).unwrap();
    // Free on one side, nothing strains it.
    assert!(simulation.energies(body).unwrap().elastic < 1e-12);
    simulation.pin(body, "right", &right[..2]).unwrap();
    simulation.unpin_all(body, "right").unwrap();
    simulation.step(5.0).unwrap();
}

#[test]
fn copies_that_a_cut_makes_are_pinned_and_moved_too() {
    let mut simulation = Simulation::new(Settings::default()).unwrap();
    let body = simulation.spawn(sheet().with(Tearing::default())).unwrap();
    let right = at_x(&mut simulation, body, 10.0);
    simulation.pin(body, "right", &right).unwrap();
    simulation.cut(body, &[DVec3::new(10.0, 5.0, 0.0), DVec3::new(7.0, 5.0, 0.0)]).unwrap();
    let to = |pin: Pin| pin.rest_position + DVec3::Y * 0.2;
    simulation.move_pins(body, "right", to).unwrap();
    simulation.step(5.0).unwrap();
    let pins = simulation.pins(body, "right").unwrap();
    assert_eq!(pins.len(), 12);
    assert!(pins.iter().all(|pin| pin.place == pin.rest_position + DVec3::Y * 0.2));
}

#[test]
fn what_cannot_be_pinned_is_refused_and_nothing_changes() {
    let mut simulation = Simulation::new(Settings::default()).unwrap();
    let body = simulation.spawn(Square::new([10, 8], 0.0).elastic()).unwrap();
    let other = simulation.spawn(sheet()).unwrap();
    let (held, free) = (at_x(&mut simulation, body, 0.0), at_x(&mut simulation, body, 3.0));
    let beyond = *simulation.view(other).unwrap().vertex_keys.last().unwrap();
    let refused = simulation.pin(body, "mine", &[free[0], held[0]]);
    assert!(matches!(refused, Err(PinError::AlreadyHeld { ref hold, .. }) if hold == "left"), "{refused:?}");
    assert_eq!(simulation.pin(body, "mine", &[free[0], beyond]), Err(PinError::NoSuchVertex(beyond)));
    assert_eq!(simulation.pin(body, "left", &free), Err(PinError::FollowsCurve("left".into())));
    assert_eq!(simulation.pins(body, "mine"), Err(PinError::NoSuchHold("mine".into())));
    assert_eq!(simulation.unpin(body, &free[..1]), Err(PinError::NotPinned(free[0])));
    simulation.pin(body, "mine", &free).unwrap();
    let before = simulation.pins(body, "mine").unwrap();
    let some_nan = |pin: Pin| if pin.vertex == free[3] { DVec3::NAN } else { pin.place + DVec3::X };
    assert!(matches!(simulation.move_pins(body, "mine", some_nan), Err(PinError::NotFinite { .. })));
    assert_eq!(simulation.pins(body, "mine").unwrap(), before);
    simulation.despawn(body).unwrap();
    assert_eq!(simulation.pin(body, "mine", &free), Err(PinError::NoSuchBody));
}
