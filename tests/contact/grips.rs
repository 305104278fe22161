//! Forceps: a pinch pulls as hard as its stiffness says, however fine the mesh and whatever is cut between the jaws.

use glam::DVec3;
use rhexis::components::{Curve, Grip, Grips, Hold, Jaws, Material, Path};
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::settings::Settings;
use rhexis::simulation::Simulation;
use rhexis::storage::{Attached, Topology, Vertices};

/// Stiffness of the pinch \[N/mm\].
const STIFFNESS: f64 = 0.2;
/// Where the hand goes \[mm\] in 10 ms.
const HAND: DVec3 = DVec3::new(0.3, -0.1, 0.5);
const CENTRE: DVec3 = DVec3::new(5.0, 5.0, 0.0);

/// A square whose vertices are all held in place, pinched in the middle.
fn pinched(cells: usize) -> Membrane {
    let mesh = generate::grid(10.0, 10.0, cells, cells).unwrap();
    let sheet = Membrane::new("sheet", mesh, Material::allard_2009());
    let members = Attached::new(sheet.select(|_| true).into_iter().map(|row| (row, DVec3::ZERO)));
    let grip = Grip {
        name: "forceps".into(),
        from: 0.0,
        until: f64::INFINITY,
        material_point: CENTRE,
        near_tip: None,
        jaws: Jaws { radius: 1.6, stiffness: Some(STIFFNESS), ..Jaws::default() },
        path: Path { points: vec![(0.0, DVec3::ZERO), (10.0, HAND)] },
        turns: Path::default(),
    };
    let hold = Hold { name: "all".into(), members, axes: [true; 3], curve: Curve::constant(0.0) };
    sheet.hold(hold).with(Grips::new(vec![grip]))
}

#[test]
fn a_pinch_is_as_stiff_on_every_mesh_and_after_a_cut() {
    let mut counts = Vec::new();
    for cells in [10, 20, 40] {
        let mut simulation = Simulation::new(Settings::default()).unwrap();
        let body = simulation.spawn(pinched(cells)).unwrap();
        simulation.step(10.0).unwrap();
        // Nothing gives way, so the force is the pinch's stiffness times the hand's way: roundings of some dozen terms.
        let check = |simulation: &Simulation, what: &str| {
            let grips = simulation.world().get::<&Grips>(body.entity()).unwrap();
            let error = grips.pinches[0].force.distance(HAND * STIFFNESS) / (HAND.length() * STIFFNESS);
            assert!(error < 1e-13, "{cells} cells, {what}: {error:e}");
            grips.pinches[0].held.rows().to_vec()
        };
        let before = check(&simulation, "whole");
        simulation.cut(body, &[DVec3::new(10.0, 5.03, 0.0), DVec3::new(4.3, 5.21, 0.0)]).unwrap();
        simulation.step(1.0).unwrap();
        let held = check(&simulation, "cut");
        assert!(held.len() > before.len(), "the cut adds nothing to the pinch");
        counts.push(before.len());

        // What the cut has put between the held vertices is held; only at the rim of the pinch may a vertex be free.
        let world = simulation.world();
        let vertices = world.get::<&Vertices>(body.entity()).unwrap();
        let topology = world.get::<&Topology>(body.entity()).unwrap();
        let inner = 1.6 - 2.0 * 10.0 / cells as f64;
        let is_inside = |&row: &u32| vertices.rest_position[row as usize].distance(CENTRE) < inner;
        let free = (0..topology.incident.len() as u32).filter(is_inside).filter(|row| !held.contains(row));
        assert_eq!(free.collect::<Vec<_>>(), Vec::<u32>::new(), "{cells} cells");
    }
    assert!(counts[2] > 10 * counts[0], "{counts:?}");
}
