//! Against `tip_fields.json`: quadrature and closed form of an independent program; cases with orthotropic and isotropic plates.

use super::*;
use serde_json::Value;

fn reference() -> Value {
    serde_json::from_str(include_str!("../../crates/rhexis-lab/tests/reference/tip_fields.json")).unwrap()
}

fn number(value: &Value, path: &str) -> f64 {
    value.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("no number at {path}"))
}

fn tensor(value: &Value, path: &str) -> Sym2 {
    let component = |i: usize| number(value, &format!("{path}/{i}"));
    Sym2::new(component(0), component(1), component(2))
}

/// The average over the sector |θ| ≤ φ by Simpson's rule, an independent quadrature: 2/(3φ)·∫f dθ.
fn sector(tip: &CrackTip, half_angle: f64) -> Modes {
    let n = 20_000;
    let mut sum = Modes { opening: Sym2::ZERO, sliding: Sym2::ZERO };
    for i in 0..=n {
        let weight = if i == 0 || i == n { 1.0 } else { f64::from(2 + 2 * (i % 2)) };
        let stress = tip.stress(half_angle * (2.0 * f64::from(i) / f64::from(n) - 1.0));
        sum.opening += stress.opening * weight;
        sum.sliding += stress.sliding * weight;
    }
    let scale = 2.0 / (3.0 * half_angle) * (2.0 * half_angle / f64::from(n)) / 3.0;
    Modes { opening: sum.opening * scale, sliding: sum.sliding * scale }
}

fn assert_near(found: Sym2, wanted: Sym2, what: &str) {
    let off = found - wanted;
    let worst = off.xx.abs().max(off.yy.abs()).max(off.xy.abs());
    // The file's own quadratures agree with its closed forms to 5e-15; Simpson's step of 3e-4 leaves 1e-14.
    assert!(worst < 1e-12, "{what}: {found:?} instead of {wanted:?}");
}

#[test]
fn averages_are_those_of_the_reference() {
    let file = reference();
    let isotropic = Orthotropic::new(3.0, 3.0, 0.3, 3.0 / 2.6).unwrap();
    let material = |key: &str| number(&file, &format!("/orthotropic/material/{key}"));
    let ortho = Orthotropic::new(material("EF"), material("ET"), material("nuF"), material("G")).unwrap();
    let mut cases = vec![(isotropic, 0.0, "/isotropic".to_owned()), (isotropic, 0.7, "/isotropic".to_owned())];
    for (i, case) in file.pointer("/orthotropic/cases").unwrap().as_array().unwrap().iter().enumerate() {
        let angle = number(case, "/fibre_to_crack_deg").to_radians();
        cases.push((ortho, angle, format!("/orthotropic/cases/{i}")));
        let release = |k1: f64, k2: f64| CrackTip::new(&ortho, angle).energy_release(k1, k2);
        assert!((release(1.0, 0.0) - number(case, "/G_over_KI2 (G_I = c K_I^2, pure K_I), 1~1MPa")).abs() < 1e-12);
        assert!((release(0.0, 1.0) - number(case, "/G_over_KII2 (pure K_II)")).abs() < 1e-12);
    }
    for (law, angle, path) in cases {
        let tip = CrackTip::new(&law, angle);
        let regions = [
            ("disc", tip.disc_average()),
            ("disc", sector(&tip, PI - 1e-15)),
            ("half_disc_ahead", sector(&tip, 0.5 * PI)),
            ("sector_+-45", sector(&tip, 0.25 * PI)),
        ];
        for (region, found) in regions {
            assert_near(found.opening, tensor(&file, &format!("{path}/{region}/K_I")), &format!("{path} {region} I"));
            assert_near(found.sliding, tensor(&file, &format!("{path}/{region}/K_II")), &format!("{path} {region} II"));
        }
    }
}

/// Westergaard's field (Williams 1957), which the double root must give exactly.
#[test]
fn isotropic_plates_have_the_classical_field() {
    let law = Orthotropic::new(3.0, 3.0, 0.3, 3.0 / 2.6).unwrap();
    let tip = CrackTip::new(&law, 0.4);
    for i in -20..=20 {
        let theta = 0.155 * f64::from(i);
        let ((s, c), (s3, c3)) = ((0.5 * theta).sin_cos(), (1.5 * theta).sin_cos());
        let opening = Sym2::new(c * (1.0 - s * s3), c * (1.0 + s * s3), c * s * c3);
        let sliding = Sym2::new(-s * (2.0 + c * c3), s * c * c3, c * (1.0 - s * s3));
        let found = tip.stress(theta);
        // The roots are split by √rounding, to which the field is smooth in their sum and product.
        assert_near(found.opening, opening, "opening");
        assert_near(found.sliding, sliding, "sliding");
    }
    assert!((tip.energy_release(2.0, 0.0) - 4.0 / 3.0).abs() < 1e-14, "G = K²/E");
    assert!((tip.energy_release(0.3, 0.4) - 0.25 / 3.0).abs() < 1e-14, "both modes alike, no mixed term");
}

/// G is the work of closing: half of the stress ahead times the opening behind. Off axes the modes are coupled.
#[test]
fn energy_release_is_a_positive_form_that_turns_with_the_crack() {
    let law = Orthotropic::new(10.0, 1.0, 0.3, 0.5).unwrap();
    let release = |angle: f64, k1: f64, k2: f64| CrackTip::new(&law, angle).energy_release(k1, k2);
    for i in 0..=12 {
        let angle = 0.25 * f64::from(i);
        let mixed = 0.5 * (release(angle, 1.0, 1.0) - release(angle, 1.0, -1.0));
        let (opening, sliding) = (release(angle, 1.0, 0.0), release(angle, 0.0, 1.0));
        assert!(opening > 0.0 && 4.0 * opening * sliding > mixed * mixed);
        // The mirror image of the plate slides the other way.
        assert!((release(-angle, 0.7, 0.4) - release(angle, 0.7, -0.4)).abs() < 1e-13);
    }
}

#[test]
fn strength_and_toughness_are_inverse_to_each_other() {
    // From nearly isotropic to fibres a thousand times as stiff, with a weak and a strong shear.
    for (young, shear) in [(1.000_001, 0.4), (10.0, 0.5), (1e3, 0.1), (1e3, 30.0)] {
        let law = Orthotropic::new(young, 1.0, 0.3, shear).unwrap();
        for angle in [0.0, 0.5, 0.5 * PI] {
            let tip = CrackTip::new(&law, angle);
            let toughness = tip.toughness(0.05, 1.5);
            assert!(toughness > 0.0 && (tip.strength(toughness, 1.5) / 0.05 - 1.0).abs() < 1e-14);
            // Sharp fields of strong anisotropy too: Simpson's rule with steps of 3e-4 and roots 1e-2 apart is good to 1e-9.
            let off = tip.disc_average().opening - sector(&tip, PI - 1e-15).opening;
            assert!(off.xx.abs().max(off.yy.abs()) < 1e-8, "{young} {shear} {angle}: {off:?}");
        }
    }
}

/// J over a circle about the tip: ∫ (W·cos θ − n·σ·∂₁u) r dθ, of the field alone and of pairs of fields.
#[test]
fn slopes_release_the_energy_and_give_the_intensities_back() {
    let isotropic = Orthotropic::new(3.0, 3.0, 0.3, 3.0 / 2.6).unwrap();
    let fibrous = Orthotropic::new(10.0, 1.0, 0.25, 0.8).unwrap();
    for (law, angle) in [(isotropic, 0.0), (isotropic, 0.4), (fibrous, 0.0), (fibrous, 0.7), (fibrous, -1.2)] {
        let tip = CrackTip::new(&law, angle);
        let strain = |stress: Sym2| law.strain(stress.in_axes_turned_by(angle)).in_axes_turned_by(-angle);
        let field = |[opening, sliding]: [f64; 2], theta: f64| {
            let (stress, slope) = (tip.stress(theta), tip.slope(theta));
            (stress.opening * opening + stress.sliding * sliding, slope.opening * opening + slope.sliding * sliding)
        };
        let interaction = |a: [f64; 2], b: [f64; 2]| {
            // The stress has a root's singularity in θ nowhere inside, so the midpoint rule converges at second order.
            let n = 40_000;
            let step = TAU / f64::from(n);
            let part = |i: i32| {
                let theta = -PI + (f64::from(i) + 0.5) * step;
                let ((s, u), (t, v)) = (field(a, theta), field(b, theta));
                let normal = DVec2::from_angle(theta);
                (s.contract(strain(t)) * normal.x - s.apply(normal).dot(v) - t.apply(normal).dot(u)) * step / TAU
            };
            (0..n).map(part).sum::<f64>()
        };
        for k in [[1.0, 0.0], [0.0, 1.0], [1.0, -0.6]] {
            let release = 0.5 * interaction(k, k);
            let wanted = tip.energy_release(k[0], k[1]);
            // Second order of a step of 2e-4.
            assert!((release / wanted - 1.0).abs() < 1e-6, "{angle}: {release} instead of {wanted}");
            let back = tip.intensities([interaction(k, [1.0, 0.0]), interaction(k, [0.0, 1.0])]);
            assert!((back[0] - k[0]).abs() < 1e-6 && (back[1] - k[1]).abs() < 1e-6, "{angle}: {back:?} {k:?}");
        }
    }
}
