//! Undo and replay: a sheet is torn, taken back and torn otherwise; the whole of it is recorded and repeated to the same bits.
//! `cargo run --release --example replay`

use glam::DVec3;
use rhexis::components::{Curve, Fibres, Hold, Holds, Material, Tearing};
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::replay::Recording;
use rhexis::settings::Settings;
use rhexis::simulation::Simulation;
use rhexis::storage::Attached;

/// Tears, goes back, tears again, and replays.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mesh = generate::grid(30.0, 30.0, 20, 16)?;
    let mut sheet = Membrane::new("sheet", mesh, Material::allard_2009()).planar().with(Tearing::default());
    sheet = sheet.fibres(Fibres::at_degrees(60.0));
    for (name, x, way) in [("left", 0.0, DVec3::NEG_X), ("right", 30.0, DVec3::X)] {
        let members = Attached::new(sheet.select(|p| p.x == x).into_iter().map(|vertex| (vertex, way)));
        sheet = sheet.hold(Hold { name: name.into(), members, axes: [true; 3], curve: Curve::ramp(1000.0, 3.0)? });
    }

    let mut simulation = Simulation::new(Settings::default())?;
    simulation.record();
    let body = simulation.spawn(sheet)?;
    simulation.cut(body, &[DVec3::new(15.0, 30.0, 0.0), DVec3::new(15.0, 27.0, 0.0)])?;
    for _ in 0..30 {
        simulation.step(10.0)?;
    }
    let before = simulation.snapshot();
    for _ in 0..20 {
        simulation.step(10.0)?;
    }
    let torn = simulation.hash();

    // Undo; the same steps lead to the same bits.
    simulation.restore(&before)?;
    for _ in 0..20 {
        simulation.step(10.0)?;
    }
    assert_eq!(simulation.hash(), torn);

    // Undo once more; a hand that stays where it is leads elsewhere.
    simulation.restore(&before)?;
    let here = Curve::constant(0.9);
    simulation.entity_mut::<&mut Holds>(body)?.groups.iter_mut().for_each(|hold| hold.curve = here.clone());
    for _ in 0..20 {
        simulation.step(10.0)?;
    }
    assert_ne!(simulation.hash(), torn);

    // The recording, as bytes and back, repeats all of it.
    let bytes = simulation.end_recording().ok_or("nothing was recorded")?.to_bytes()?;
    let recording = Recording::from_bytes(&bytes)?;
    let again = recording.replay()?;
    assert_eq!(again.hash(), simulation.hash());
    println!("{} inputs in {} kB end with the hash {}", recording.inputs().len(), bytes.len() / 1000, again.hash());
    Ok(())
}
