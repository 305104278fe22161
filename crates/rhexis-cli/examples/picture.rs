//! A picture of a stretched sheet with a notch. `cargo run --release --example picture`

use glam::DVec3;
use rhexis::components::{Curve, Fibres, Hold, Material, Tearing};
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::settings::Settings;
use rhexis::simulation::Simulation;
use rhexis::storage::Attached;
use rhexis_cli::output::{PictureSettings, render};

/// Draws into `target/picture.png`.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mesh = generate::grid(30.0, 30.0, 30, 25)?;
    let mut sheet = Membrane::new("sheet", mesh, Material::allard_2009()).planar().with(Tearing::default());
    sheet = sheet.fibres(Fibres::at_degrees(60.0));
    for (name, x, way) in [("left", 0.0, DVec3::NEG_X), ("right", 30.0, DVec3::X)] {
        let members = Attached::new(sheet.select(|p| p.x == x).into_iter().map(|vertex| (vertex, way)));
        sheet = sheet.hold(Hold { name: name.into(), members, axes: [true; 3], curve: Curve::ramp(1000.0, 3.0)? });
    }
    let mut simulation = Simulation::new(Settings::default())?;
    let body = simulation.spawn(sheet)?;
    simulation.cut(body, &[DVec3::new(15.0, 30.0, 0.0), DVec3::new(15.0, 27.0, 0.0)])?;
    for _ in 0..60 {
        simulation.step(10.0)?;
    }
    let frame = simulation.frame();
    std::fs::create_dir_all("target")?;
    let settings = PictureSettings::titled("picture", frame.time, frame.step, 1);
    render("target/picture.png".as_ref(), &frame.bodies[0], &settings)?;
    println!("target/picture.png: {} triangles", frame.bodies[0].triangles.len());
    Ok(())
}
