//! The law of Holzapfel, Gasser and Ogden: derivatives, symmetries, bodies at rest and in motion, and what is refused.

mod bodies;
mod law;

use rhexis::components::{Fibres, HolzapfelGasserOgden, Material};
use rhexis::generate;
use rhexis::membrane::Membrane;

/// The adventitia of an iliac artery (Gasser, Ogden, Holzapfel 2006).
fn adventitia() -> HolzapfelGasserOgden {
    HolzapfelGasserOgden::symmetric(0.9966, 524.6, 49.98, 0.226)
}

/// A sheet of it, 6 × 5 mm on a jittered mesh.
fn sheet(degrees: f64) -> Membrane {
    let mesh = generate::jittered(6.0, 5.0, 6, 5, 3).unwrap();
    let material = Material::neo_hookean(7.64e-3, 0.4);
    Membrane::new("sheet", mesh, material).fibres(Fibres::at_degrees(degrees)).with(adventitia())
}
