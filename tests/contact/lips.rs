//! Jaws hold what hangs together where they close: not the other lip of a cut, however near that is.

use glam::DVec3;
use rhexis::components::{Grip, Grips, Jaws, Material, Path, Pose};
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::settings::Settings;
use rhexis::simulation::{Grasp, Simulation};
use rhexis::storage::{BodyId, Vertices};

/// Beside the cut, nearer to it than the jaws' radius \[mm\].
const PLACE: DVec3 = DVec3::new(2.0, 5.3, 0.0);
const RADIUS: f64 = 0.5;

/// A sheet that is cut along y = 5 from its left edge to x = 6.
fn slit(sheet: impl FnOnce(Membrane) -> Membrane) -> (Simulation, BodyId) {
    let mesh = generate::grid(10.0, 10.0, 40, 40).unwrap();
    let mut simulation = Simulation::new(Settings { threads: 1, ..Settings::default() }).unwrap();
    let body = simulation.spawn(sheet(Membrane::new("sheet", mesh, Material::allard_2009()))).unwrap();
    simulation.cut(body, &[DVec3::new(0.0, 5.0, 0.0), DVec3::new(6.0, 5.0, 0.0)]).unwrap();
    (simulation, body)
}

/// Rest positions of what the jaws of a body hold, of the vertices on the cut only those of which both copies are held.
fn held(simulation: &Simulation, body: BodyId) -> (Vec<DVec3>, usize) {
    let world = simulation.world();
    let (grips, vertices) =
        (world.get::<&Grips>(body.entity()).unwrap(), world.get::<&Vertices>(body.entity()).unwrap());
    let held: Vec<DVec3> =
        grips.pinches[0].held.rows().iter().map(|&row| vertices.rest_position[row as usize]).collect();
    let twice = held.iter().enumerate().filter(|(i, p)| held[..*i].contains(p)).count();
    (held, twice)
}

#[test]
fn no_jaws_take_the_other_lip() {
    let script = Grip {
        name: "jaws".into(),
        from: 0.0,
        until: f64::INFINITY,
        material_point: PLACE,
        near_tip: None,
        jaws: Jaws { radius: RADIUS, ..Jaws::default() },
        path: Path::default(),
        turns: Path::default(),
    };
    let (mut simulation, body) = slit(|sheet| sheet.with(Grips::new(vec![script])));
    simulation.step(1.0).unwrap();
    let (of_script, twice) = held(&simulation, body);
    // All that lies within the radius on this side: 8 vertices of the grid, 0.25 mm apart, and the near lip.
    assert!(of_script.iter().all(|p| p.y >= 5.0) && twice == 0, "{of_script:?}");
    assert!(of_script.iter().any(|p| p.y == 5.0), "the near lip is within reach");

    let above = PLACE + DVec3::Z;
    let reach = 2.0;
    for grasp in
        [Grasp::Point(PLACE), Grasp::Nearest { reach }, Grasp::Ray { origin: above, direction: DVec3::NEG_Z, reach }]
    {
        let (mut simulation, body) = slit(|sheet| sheet);
        let jaws = Jaws { radius: RADIUS, ..Jaws::default() };
        let forceps = simulation.spawn_forceps("forceps", jaws, Pose::at(above)).unwrap();
        simulation.close_forceps(forceps, body, &grasp).unwrap();
        assert_eq!(held(&simulation, body).0, of_script, "{grasp:?}");
    }
}

#[test]
fn beyond_the_end_of_a_cut_jaws_take_both_sides() {
    let place = DVec3::new(6.1, 5.05, 0.0);
    let (mut simulation, body) = slit(|sheet| sheet);
    let jaws = Jaws { radius: RADIUS, ..Jaws::default() };
    let forceps = simulation.spawn_forceps("forceps", jaws, Pose::at(place)).unwrap();
    simulation.close_forceps(forceps, body, &Grasp::Point(place)).unwrap();
    let (held, twice) = held(&simulation, body);
    // Round the tip both lips hang together within the radius.
    assert!(held.iter().any(|p| p.y < 5.0 && p.x < 6.0) && held.iter().any(|p| p.y > 5.0 && p.x < 6.0));
    assert!(twice > 0, "{held:?}");
}
