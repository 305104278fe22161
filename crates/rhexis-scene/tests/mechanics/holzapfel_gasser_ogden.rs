//! The law as scene files write it.

use rhexis::components::{FibreFamily, GroundSubstance, HolzapfelGasserOgden};
use rhexis::simulation::Simulation;
use rhexis_scene::Document;

fn simulation(material: &str, more: &str) -> Result<Simulation, String> {
    let text = format!(
        "[scene]\nname = \"w\"\n[run]\nmode = \"static\"\ndt = 1\nsteps = 1\n[[bodies]]\nname = \"b\"\n\
         mesh = {{ grid = {{ width = 10, height = 10, nx = 4, ny = 4 }} }}\nmaterial = {{ {material}, thickness = 0.1 }}\n{more}\n\
         [[bodies.holds]]\nname = \"left\"\nregion = {{ x = 0 }}\n"
    );
    Document::new(text, "w.toml")
        .scene()
        .and_then(|scene| scene.instantiate())
        .map(|i| i.simulation)
        .map_err(|error| error.to_string())
}

fn law(material: &str, more: &str) -> HolzapfelGasserOgden {
    let simulation = simulation(material, more).unwrap();
    let found = simulation.world().query::<&HolzapfelGasserOgden>().iter().next().cloned();
    found.unwrap()
}

const SOFT: &str = "young = 1, poisson = 0.3";
const MATRIX: &str = "model = \"neo_hookean\", mu = 0.00764";

#[test]
fn numbers_of_papers_can_be_put_in() {
    let table = "holzapfel_gasser_ogden = { k1 = 0.9966, k2 = 524.6, degrees = [49.98, -49.98], kappa = 0.226 }";
    assert_eq!(law(MATRIX, table), HolzapfelGasserOgden::symmetric(0.9966, 524.6, 49.98, 0.226));
    assert_eq!(law(SOFT, table).matrix, GroundSubstance::Linear);
    let list = "holzapfel_gasser_ogden = [{ k1 = 1, k2 = 10, degrees = 40 }, { k1 = 2, k2 = 20 }]";
    let family = |k1, k2, degrees| FibreFamily { k1, k2, degrees, kappa: 0.0 };
    assert_eq!(law(SOFT, list).families, [family(1.0, 10.0, 40.0), family(2.0, 20.0, 0.0)]);
    assert_eq!(law(MATRIX, ""), HolzapfelGasserOgden { families: Vec::new(), matrix: GroundSubstance::NeoHookean });
}

#[test]
fn what_is_wrong_is_refused_with_what_to_write() {
    let wrong = [
        (SOFT, "stiffening_fibres = { k1 = 1, k2 = 10, kappa = 0.2 }", "dispersion", "holzapfel_gasser_ogden"),
        (SOFT, "stiffening_fibres = [{ k1 = 1, k2 = 10, degrees = 40 }]", "one family", "degrees = [40, -40]"),
        (SOFT, "stiffening_fibres = { k1 = 1, k2 = 10, degrees = 4 }", "no angle", "holzapfel_gasser_ogden"),
        (SOFT, "stiffening_fibres = { k1 = 1, k3 = 10 }", "k3", "k2"),
        (SOFT, "holzapfel_gasser_ogden = { k1 = 1, k2 = 10, kappa = 0.5 }", "kappa", "1/3"),
        (SOFT, "holzapfel_gasser_ogden = { k1 = 1, k2 = 10, degrees = [] }", "no angles", "[40, -40]"),
        (SOFT, "holzapfel_gasser_ogden = { k1 = 1 }", "k2", "add"),
        (MATRIX, "stiffening_fibres = { k1 = 1, k2 = 10 }", "linear law", "remove one"),
        (MATRIX, "grading = { ratio_at_rim = 2, radius = 5 }", "isotropic", "grading"),
        (MATRIX, "pre_stretch = 0.95", "pre-stretch", "0.9"),
        ("model = \"neo_hookean\"", "", "mu", "MPa"),
        ("model = \"neo_hookean\", mu = -1", "", "mu", "above zero"),
        ("model = \"neo_hookean\", mu = 1, young = 2", "", "one constant", "mu"),
        ("mu = 1", "", "neo-Hookean", "model"),
        ("model = \"mooney\", mu = 1", "", "mooney", "neo_hookean"),
    ];
    for (material, more, what, help) in wrong {
        let error = simulation(material, more).err().unwrap_or_else(|| panic!("accepted: {material} {more}"));
        assert!(error.contains(what) && error.contains(help), "{error}");
        assert!(error.starts_with("w.toml:"), "no place: {error}");
    }
}
