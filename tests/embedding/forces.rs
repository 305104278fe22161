//! Forces of one step: as loads while it lasts, then gone; they follow edits and act in static solves.

use crate::doors::{NAN, drawn, point_loads};
use glam::DVec3;
use rhexis::components::PointLoads;
use rhexis::simulation::{ForceError, Simulation};
use rhexis::storage::{BodyId, VertexKey, Vertices};

#[test]
fn a_force_acts_for_one_step() {
    let force = DVec3::new(1e-4, 2e-4, 3e-4);
    let run = |push: &dyn Fn(&mut Simulation, BodyId), take: &dyn Fn(&mut Simulation, BodyId)| {
        let (mut s, body) = drawn();
        push(&mut s, body);
        s.step(1.0).unwrap();
        take(&mut s, body);
        s.step(1.0).unwrap();
        s.hash()
    };
    let apply = |s: &mut Simulation, body| {
        let key = s.view(body).unwrap().vertex_keys[7];
        s.apply_force(body, key, force * 0.25).unwrap();
        s.apply_force(body, key, force * 0.75).unwrap();
    };
    let nothing = |_: &mut Simulation, _| {};
    let applied = run(&apply, &nothing);
    let load = |s: &mut Simulation, body| s.set(body, point_loads(7, force)).unwrap();
    let unload = |s: &mut Simulation, body| _ = s.unset::<PointLoads>(body).unwrap();
    // 0.25 and 0.75 of it add up to all of it only to rounding: one call for the comparison to the bit.
    let whole = |s: &mut Simulation, body| {
        let key = s.view(body).unwrap().vertex_keys[7];
        s.apply_force(body, key, force).unwrap();
    };
    assert_eq!(run(&whole, &nothing), run(&load, &unload));
    assert_ne!(applied, run(&nothing, &nothing));

    let (mut s, body) = drawn();
    let key = s.view(body).unwrap().vertex_keys[7];
    for bad in [NAN, DVec3::INFINITY] {
        assert!(matches!(s.apply_force(body, key, bad), Err(ForceError::NotFinite { .. })));
    }
    s.apply_force(body, key, DVec3::X * 1e308).unwrap();
    assert!(s.apply_force(body, key, DVec3::X * 1e308).is_err(), "their sum is not finite");
    assert_eq!(s.apply_force(body, VertexKey::default(), force), Err(ForceError::NoSuchVertex(VertexKey::default())));
    let _ = s.step(1.0).unwrap();
    assert!(!s.step(1.0).unwrap().has_failed, "a failed step uses it up as well");
}

#[test]
fn a_force_follows_edits_and_acts_in_static_solves() {
    let at = |s: &Simulation, body, key: VertexKey| {
        let vertices = s.world().get::<&Vertices>(body).unwrap();
        vertices.position[vertices.row(key).unwrap() as usize]
    };
    // Sorting the rows and cutting elsewhere leave the force where it was given.
    let mut moved = [DVec3::ZERO; 2];
    for edited in [false, true] {
        let (mut s, body) = drawn();
        let key = s.view(body).unwrap().vertex_keys[7];
        let start = at(&s, body.entity(), key);
        s.apply_force(body, key, DVec3::Z * 1e-3).unwrap();
        if edited {
            s.reorder(body).unwrap();
            s.cut(body, &[DVec3::new(4.0, 2.5, 0.0), DVec3::new(3.5, 2.5, 0.0)]).unwrap();
        }
        s.step(0.1).unwrap();
        moved[usize::from(edited)] = at(&s, body.entity(), key) - start;
    }
    // The cut is far away, and the step short: nearly the same acceleration.
    assert!(moved[0].z > 0.0 && (moved[1].z / moved[0].z - 1.0).abs() < 1e-2, "{moved:?}");

    let (mut s, body) = drawn();
    let key = s.view(body).unwrap().vertex_keys[9];
    s.settle(0.0, 1e-9).unwrap();
    let rest = at(&s, body.entity(), key);
    s.apply_force(body, key, DVec3::X * 1e-4).unwrap();
    s.settle(0.0, 1e-9).unwrap();
    let pushed = at(&s, body.entity(), key);
    assert!(pushed.x > rest.x, "{pushed} {rest}");
    s.settle(0.0, 1e-9).unwrap();
    // Two equilibria without it differ by their tolerance.
    assert!(at(&s, body.entity(), key).distance(rest) < 1e-6 * pushed.distance(rest).max(1e-3), "it was used up");
}
