//! The fibres lead the tear: the same notch, sheets of different fibres. `cargo run --release --example fibre_angle`

use glam::DVec3;
use rhexis::components::{Curve, Damping, Fibres, Hold, Material, Tearing};
use rhexis::event::EventKind;
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::settings::Settings;
use rhexis::simulation::Simulation;
use rhexis::storage::Attached;

/// The end of the notch \[mm\].
const NOTCH: DVec3 = DVec3::new(15.0, 27.0, 0.0);

/// Tears four sheets.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    for degrees in [60.0, 75.0, 90.0, 105.0] {
        let end = tear(degrees)?;
        let way = NOTCH - end;
        let angle = way.y.atan2(way.x).to_degrees();
        println!("fibres at {degrees}°: the tear runs at {angle:.1}° to {end:.1}");
        assert!((angle - degrees).abs() < 5.0, "fibres at {degrees}°, tear at {angle}°");
    }
    Ok(())
}

/// Where the tear has got to in a sheet with these fibres.
fn tear(degrees: f64) -> Result<DVec3, Box<dyn std::error::Error>> {
    let mesh = generate::grid(30.0, 30.0, 30, 25)?;
    let mut sheet = Membrane::new("sheet", mesh, Material::allard_2009())
        .fibres(Fibres::at_degrees(degrees))
        .planar()
        .with(Tearing::default())
        .with(Damping { time: 0.1 });
    for (name, x, way) in [("left", 0.0, DVec3::NEG_X), ("right", 30.0, DVec3::X)] {
        let members = Attached::new(sheet.select(|p| p.x == x).into_iter().map(|vertex| (vertex, way)));
        sheet = sheet.hold(Hold { name: name.into(), members, axes: [true; 3], curve: Curve::ramp(1000.0, 3.0)? });
    }
    let mut simulation = Simulation::new(Settings::default())?;
    let body = simulation.spawn(sheet)?;
    simulation.cut(body, &[NOTCH.with_y(30.0), NOTCH])?;
    let mut reached = NOTCH;
    // Until it is 15 mm long, lest it runs along the rim.
    while simulation.time() < 1000.0 && reached.distance(NOTCH) < 15.0 {
        simulation.step(10.0)?;
        for event in simulation.drain_events() {
            if let EventKind::Advanced { to, .. } = event.kind {
                reached = to;
            }
        }
    }
    Ok(reached)
}
