//! The smallest tear: a fibrous sheet is notched, pulled apart and watched. `cargo run --release --example hello_tear`

use glam::DVec3;
use rhexis::components::{Curve, Damping, Fibres, Hold, Material, Tearing};
use rhexis::event::EventKind;
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::settings::Settings;
use rhexis::simulation::Simulation;
use rhexis::storage::Attached;

/// Pulls until the tear has run into a boundary.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mesh = generate::grid(30.0, 30.0, 30, 25)?;
    let mut sheet = Membrane::new("sheet", mesh, Material::allard_2009())
        .fibres(Fibres::at_degrees(60.0))
        .planar()
        .with(Tearing::default())
        .with(Damping { time: 0.1 });
    for (name, x, way) in [("left", 0.0, DVec3::NEG_X), ("right", 30.0, DVec3::X)] {
        let members = Attached::new(sheet.select(|p| p.x == x).into_iter().map(|vertex| (vertex, way)));
        sheet = sheet.hold(Hold { name: name.into(), members, axes: [true; 3], curve: Curve::ramp(1000.0, 3.0)? });
    }

    let mut simulation = Simulation::new(Settings::default())?;
    let body = simulation.spawn(sheet)?;
    simulation.cut(body, &[DVec3::new(15.0, 30.0, 0.0), DVec3::new(15.0, 27.0, 0.0)])?;

    let mut end = None;
    while end.is_none() && simulation.time() < 1000.0 {
        let time = simulation.step(10.0)?.time;
        for event in simulation.drain_events() {
            match event.kind {
                EventKind::Advanced { to, criterion, .. } => println!("{time} ms: c = {criterion:.2}, now at {to:.2}"),
                EventKind::Ended { at, .. } => end = Some(at),
                other => println!("{time} ms: {other:?}"),
            }
        }
    }

    // Fibres at 60° lead from the end of the notch, (15, 27), down to the left edge near its foot.
    let end = end.ok_or("the sheet was not torn through")?;
    println!("torn through at {end:.2}");
    let off_fibre =
        (end - DVec3::new(15.0, 27.0, 0.0)).normalize().dot(Fibres::at_degrees(150.0).direction(0, end)).abs();
    assert!(off_fibre < 0.05, "the tear follows the fibres to 0.05 rad, not {off_fibre}");
    Ok(())
}
