//! What a body does not carry costs nothing: no system runs for it, no component is there, no time is reported.

use crate::common::Square;
use rhexis::components::{
    Bending, Changes, EnergyAudit, ExternalStiffness, Frames, Grips, Obstacle, Refined, Refinement, Sleeping, Springs,
    TearDecisions, Tearing,
};
use rhexis::settings::Settings;
use rhexis::simulation::Simulation;
use rhexis::storage::Tips;
use rhexis::systems::bending::DihedralAngles;
use rhexis::systems::fracture::TipMemory;

#[test]
fn a_scene_without_tearing_contact_and_loads_spends_nothing_on_them() {
    let mut simulation = Simulation::new(Settings::default()).unwrap();
    let square = Square::new([20, 16], 45.0);
    let body = simulation.spawn(square.elastic()).unwrap();
    for _ in 0..5 {
        let report = simulation.step(10.0).unwrap();
        let ran: Vec<&str> = report.systems.iter().filter(|s| s.bodies > 0).map(|s| s.name).collect();
        assert_eq!(
            ran,
            ["participants", "hold", "corotation", "assembly", "solve", "energy guard", "integrate", "solve: end"]
        );
        for system in report.systems.iter().filter(|system| system.bodies == 0) {
            assert!(system.time.is_zero(), "{} took {:?}", system.name, system.time);
        }
    }
    let world = simulation.world();
    let carried = [
        world.satisfies::<&Tearing>(body.entity())
            || world.satisfies::<&Tips>(body.entity())
            || world.satisfies::<&TearDecisions>(body.entity()),
        world.satisfies::<&TipMemory>(body.entity())
            || world.satisfies::<&Refinement>(body.entity())
            || world.satisfies::<&Refined>(body.entity()),
        world.satisfies::<&ExternalStiffness>(body.entity()) || world.satisfies::<&Springs>(body.entity()),
        world.satisfies::<&Bending>(body.entity()) || world.satisfies::<&DihedralAngles>(body.entity()),
        world.satisfies::<&Changes>(body.entity())
            || world.satisfies::<&Grips>(body.entity())
            || world.satisfies::<&Sleeping>(body.entity())
            || world.satisfies::<&EnergyAudit>(body.entity()),
    ];
    assert_eq!(carried, [false; 5], "no component that the body was not given");
    assert_eq!(world.get::<&Frames>(body.entity()).unwrap().stiffened.capacity(), 0, "no stiffness but the material's");
    assert_eq!(world.query::<&Obstacle>().iter().count(), 0);
}
