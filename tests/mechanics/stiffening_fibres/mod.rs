//! Fibres that stiffen: derivatives of their energy, patches, strips, motion, tears, and what is refused.

mod bodies;
mod derivatives;

use rhexis::components::{Fibres, Material, StiffeningFibres};
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::settings::Settings;
use rhexis::simulation::Simulation;
use rhexis::storage::BodyId;

const FIBRES: StiffeningFibres = StiffeningFibres { k1: 6.0, k2: 9.0 };

/// A sheet of 6 × 5 mm on a jittered mesh.
fn sheet(degrees: f64) -> Membrane {
    let mesh = generate::jittered(6.0, 5.0, 6, 5, 3).unwrap();
    Membrane::new("sheet", mesh, Material::allard_2009()).fibres(Fibres::at_degrees(degrees)).with(FIBRES)
}

fn simulate(settings: Settings, membrane: Membrane) -> (Simulation, BodyId) {
    let mut simulation = Simulation::new(Settings { threads: 1, ..settings }).unwrap();
    let body = simulation.spawn(membrane).unwrap();
    (simulation, body)
}
