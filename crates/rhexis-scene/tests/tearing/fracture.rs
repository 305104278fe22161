//! Toughness as input: what a user gives is what the engine tears at.

use rhexis::components::{Material, Tearing, Toughness};
use rhexis_scene::Scene;

const TOUGH: Toughness = Toughness { along: 0.02, across: 0.5 };

#[test]
fn a_scene_may_give_toughnesses() {
    let text = r#"
[scene]
name = "strip"
[run]
dt = 10
steps = 1
[[bodies]]
name = "tissue"
planar = true
mesh = { grid = { width = 4, height = 2, nx = 8, ny = 4 } }
material = { young_fibre = 10, young_transverse = 1, poisson_major = 0.3, shear_modulus = 0.5, thickness = 0.1 }
tearing = { toughness_along_fibres = 0.02, toughness_across_fibres = 0.5, radius = 0.5, exponent = 0.7 }
"#;
    let summary = Scene::parse(text, "strip.toml").unwrap().check().unwrap();
    let (found, implied) = summary.bodies[0].tearing.unwrap();
    let wanted = Tearing::from_toughness(TOUGH, &Material::allard_2009().stiffness().unwrap(), 0.5).unwrap();
    assert_eq!(found, Tearing { exponent: 0.7, ..wanted });
    // Square and square root.
    assert!((implied.along / TOUGH.along - 1.0).abs() < 1e-14 && (implied.across / TOUGH.across - 1.0).abs() < 1e-14);
    let shown = summary.to_string();
    assert!(shown.contains("2.000e-2 N/mm") && shown.contains("5.000e-1 N/mm") && shown.contains("0.5 mm"), "{shown}");
}

/// Isotropic: σ̄ = 1.0186·√(E·G_c)/√(2πR), the closed coefficient being 2/(3π)·24/5.
#[test]
fn toughness_becomes_the_strength_of_the_closed_form() {
    let material = Material::isotropic(3.0, 0.3, 0.1);
    let law = material.stiffness().unwrap();
    let found = Tearing::from_toughness(Toughness { along: 0.012, across: 0.03 }, &law, 0.75).unwrap();
    let coefficient = 16.0 / (5.0 * std::f64::consts::PI);
    let strength = |toughness: f64| coefficient * (3.0 * toughness / (std::f64::consts::TAU * 0.75)).sqrt();
    assert!((found.strength_along_fibres / strength(0.012) - 1.0).abs() < 1e-13);
    assert!((found.strength_across_fibres / strength(0.03) - 1.0).abs() < 1e-13);
    for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = Tearing::from_toughness(Toughness { across: value, ..TOUGH }, &law, 0.75).unwrap_err();
        assert!(error.to_string().starts_with("toughness across the fibres"), "{error}");
        assert!(Tearing::from_toughness(Toughness { along: value, ..TOUGH }, &law, 0.75).is_err());
    }
}
