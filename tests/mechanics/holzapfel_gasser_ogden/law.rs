//! The law at a stretch: derivatives of its energy, symmetries, limits.

use rhexis::components::{FibreFamily, GroundSubstance, HolzapfelGasserOgden, Material};
use rhexis::math::{CoupledStiffness, Orthotropic, PreparedLaw, Sym2};

const MU: f64 = 0.7;

/// Numbers in −1..1 without any pattern that matters: a linear congruential sequence.
fn numbers() -> impl FnMut() -> f64 {
    let mut state = 11_u64;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

fn law(kappa: f64, degrees: &[f64], matrix: GroundSubstance) -> HolzapfelGasserOgden {
    let family = |&degrees: &f64| FibreFamily { k1: 0.3, k2: 1.5, degrees, kappa };
    HolzapfelGasserOgden { families: degrees.iter().map(family).collect(), matrix }
}

fn laws() -> Vec<HolzapfelGasserOgden> {
    let angles: [&[f64]; 4] = [&[], &[20.0], &[35.0, -35.0], &[0.0, 90.0, 41.0, -43.0]];
    let of = |angles: &[f64], kappa| {
        [law(kappa, angles, GroundSubstance::NeoHookean), law(kappa, angles, GroundSubstance::Linear)]
    };
    angles.iter().flat_map(|angles| [0.0, 0.15, 1.0 / 3.0].into_iter().flat_map(|kappa| of(angles, kappa))).collect()
}

/// Stretches by −25 to 45 % with shear.
fn stretch(next: &mut impl FnMut() -> f64) -> Sym2 {
    Sym2::new(1.1 + 0.35 * next(), 1.1 + 0.35 * next(), 0.25 * next())
}

fn voigt(c: &CoupledStiffness, rate: Sym2) -> Sym2 {
    c.law.coupled_stress([c.q16, c.q26], rate)
}

const NONE: Orthotropic = Orthotropic { q11: 0.0, q12: 0.0, q22: 0.0, q66: 0.0 };
const RATES: [Sym2; 3] = [Sym2::new(1.0, 0.0, 0.0), Sym2::new(0.0, 1.0, 0.0), Sym2::new(0.0, 0.0, 0.5)];

fn size(a: Sym2) -> f64 {
    a.contract(a).sqrt()
}

#[test]
fn stress_and_stiffness_are_the_derivatives_of_the_energy() {
    let mut next = numbers();
    let h = 1e-5;
    for law in laws() {
        for unstretched in [Sym2::IDENTITY, Sym2::new(0.93, 1.02, 0.03)] {
            let law = PreparedLaw::new(&law, unstretched);
            for _ in 0..40 {
                let u = stretch(&mut next);
                let (stress, c) = (law.stress(u, MU), law.answer(u, &NONE, MU).1);
                let scale = size(stress).max(1e-2);
                for rate in RATES {
                    let [low, high] = [u - rate * h, u + rate * h];
                    let slope = (law.energy(high, MU) - law.energy(low, MU)) / (2.0 * h);
                    // h²/6 of third derivatives, some ten times the stress, and rounding over h.
                    assert!((slope - stress.contract(rate)).abs() < 1e-8 * scale, "{law:?} {u:?}: {slope} {stress:?}");
                    let change = (law.stress(high, MU) - law.stress(low, MU)) * (0.5 / h);
                    let off = size(change - voigt(&c, rate));
                    // As above; a family that begins to act within 2h jumps.
                    assert!(off < 1e-7 * (1.0 + size(change)), "{law:?} {u:?}: {change:?} {:?}", voigt(&c, rate));
                }
            }
        }
    }
}

/// W of one law in the principal invariants, in the formulas of the papers.
fn plain(u: Sym2, kappa: f64, degrees: &[f64]) -> f64 {
    let c = [u.xx * u.xx + u.xy * u.xy, u.yy * u.yy + u.xy * u.xy, u.xy * (u.xx + u.yy)];
    let first = c[0] + c[1] + 1.0 / (c[0] * c[1] - c[2] * c[2]);
    let family = |degrees: &f64| {
        let (y, x) = degrees.to_radians().sin_cos();
        let fourth = x * x * c[0] + y * y * c[1] + 2.0 * x * y * c[2];
        let e = f64::max(kappa * (first - 3.0) + (1.0 - 3.0 * kappa) * (fourth - 1.0), 0.0);
        0.3 / (2.0 * 1.5) * ((1.5 * e * e).exp() - 1.0)
    };
    0.5 * MU * (first - 3.0) + degrees.iter().map(family).sum::<f64>()
}

#[test]
fn the_energy_is_that_of_the_papers_to_the_last_digits_of_small_strains() {
    let mut next = numbers();
    for kappa in [0.0, 0.15, 1.0 / 3.0] {
        let angles = [35.0, -35.0];
        let law = PreparedLaw::new(&law(kappa, &angles, GroundSubstance::NeoHookean), Sym2::IDENTITY);
        for _ in 0..100 {
            let u = stretch(&mut next);
            let (found, wanted) = (law.energy(u, MU), plain(u, kappa, &angles));
            // The plain formulas have the rounding of invariants near 3, and an exponential that of its argument.
            assert!((found - wanted).abs() < 1e-14 * (1.0 + wanted), "{found} {wanted}");
        }
        // A strain of 1e-8: the plain formulas lose all digits, half of C of the strain twice does not.
        let strain = Sym2::new(1e-8, -2e-8, 5e-9);
        let linear = Material::neo_hookean(MU, 1.0).stiffness().unwrap();
        let found = law.energy(Sym2::IDENTITY + strain, MU);
        let fibres = 0.5
            * 0.3
            * angles
                .map(|a: f64| {
                    let (y, x) = a.to_radians().sin_cos();
                    let fourth = 2.0 * (x * x * strain.xx + y * y * strain.yy + 2.0 * x * y * strain.xy);
                    ((1.0 - 3.0 * kappa) * fourth).max(0.0).powi(2)
                })
                .iter()
                .sum::<f64>();
        let wanted = 0.5 * linear.stress(strain).contract(strain) + fibres;
        // What is left out is of the order of the strain.
        assert!((found / wanted - 1.0).abs() < 1e-6, "{found} {wanted}");
    }
}

#[test]
fn a_full_dispersion_is_isotropic_and_symmetric_families_are_mirrored() {
    let mut next = numbers();
    let isotropic = PreparedLaw::new(&law(1.0 / 3.0, &[20.0, -65.0], GroundSubstance::NeoHookean), Sym2::IDENTITY);
    let mirrored = PreparedLaw::new(&law(0.15, &[35.0, -35.0], GroundSubstance::NeoHookean), Sym2::IDENTITY);
    for _ in 0..50 {
        let (u, turn) = (stretch(&mut next), 3.0 * next());
        let (stress, turned) = (isotropic.stress(u, MU), isotropic.stress(u.in_axes_turned_by(turn), MU));
        // Rounding of some ten products, of stresses up to 1 MPa.
        assert!(size(stress.in_axes_turned_by(turn) - turned) < 1e-13, "{stress:?} {turned:?}");
        let flip = |a: Sym2| Sym2::new(a.xx, a.yy, -a.xy);
        assert!(size(flip(mirrored.stress(u, MU)) - mirrored.stress(flip(u), MU)) < 1e-13);
        let (a, b) = (mirrored.answer(u, &NONE, MU).1, mirrored.answer(flip(u), &NONE, MU).1);
        assert!((a.q16 + b.q16).abs() + (a.q26 + b.q26).abs() + (a.law.q12 - b.law.q12).abs() < 1e-12);
    }
}

#[test]
fn families_act_in_tension_alone_and_the_rest_state_is_linear() {
    let fibres = PreparedLaw::new(&law(0.0, &[0.0], GroundSubstance::Linear), Sym2::IDENTITY);
    assert_eq!(fibres.stress(Sym2::new(0.9, 1.3, 0.0), MU), Sym2::ZERO);
    assert!(fibres.stress(Sym2::new(1.1, 0.7, 0.0), MU).xx > 0.0);
    for unstretched in [Sym2::IDENTITY, Sym2::new(0.9, 0.95, 0.02)] {
        let law = PreparedLaw::new(&law(0.1, &[30.0, -30.0], GroundSubstance::NeoHookean), unstretched);
        assert_eq!(law.stress(unstretched, MU), Sym2::ZERO);
        assert_eq!(law.energy(unstretched, MU), 0.0);
    }
    let matrix = PreparedLaw::new(&law(0.0, &[], GroundSubstance::NeoHookean), Sym2::IDENTITY);
    let c = matrix.answer(Sym2::IDENTITY, &NONE, MU).1;
    assert!((c.law.q11 - 4.0 * MU).abs() + (c.law.q12 - 2.0 * MU).abs() + (c.law.q66 - MU).abs() < 1e-14, "{c:?}");
    assert_eq!([c.q16, c.q26], [0.0; 2]);
}

#[test]
fn crushed_and_drawn_out_without_end_it_stays_finite_continuous_and_semidefinite() {
    let mut next = numbers();
    let h = 1e-6;
    let law = PreparedLaw::new(&law(0.15, &[35.0, -35.0], GroundSubstance::NeoHookean), Sym2::IDENTITY);
    for size_of in [1e-12, 1e-3, 0.05, 0.2, 0.4, 1.0, 3.0, 1e3, 1e9] {
        for _ in 0..40 {
            // Mirrored ones too, as bodies in a plane have them.
            let u = Sym2::new(size_of * next(), size_of * next(), size_of * next());
            let (energy, stress, c) = (law.energy(u, MU), law.stress(u, MU), law.answer(u, &NONE, MU).1);
            assert!(energy.is_finite() && stress.is_finite() && energy >= 0.0, "{u:?} {energy}");
            for _ in 0..5 {
                let rate = Sym2::new(next(), next(), next());
                let bound = voigt(&c, rate).contract(rate);
                assert!(bound >= 0.0, "{u:?} {c:?}");
                if size_of > 3.0 {
                    continue;
                }
                let change = (law.stress(u + rate * h, MU) - law.stress(u - rate * h, MU)) * (0.5 / h);
                // Rounding over h, and h of what jumps where a family begins to act or the area passes its limit.
                assert!(change.contract(rate) <= bound * (1.0 + 1e-3) + 1e-4 * (1.0 + size(stress)), "{u:?}");
            }
        }
    }
    // Through the least area and the largest exponent, E = 3/√k₂: no jumps.
    let along = |s: f64| Sym2::new(s, s, 0.0);
    let edges = [0.2_f64.sqrt(), {
        let (mut low, mut high) = (1.0, 2.5);
        let strain = |s: f64| 0.15 * (2.0 * s * s + s.powi(-4) - 3.0) + 0.55 * (s * s - 1.0);
        (0..80).for_each(|_| {
            let middle = 0.5 * (low + high);
            if strain(middle) > 3.0 / 1.5_f64.sqrt() { high = middle } else { low = middle }
        });
        low
    }];
    for s in edges {
        let (low, high) = (along(s * (1.0 - 1e-11)), along(s * (1.0 + 1e-11)));
        let (a, b) = (law.stress(low, MU), law.stress(high, MU));
        assert!(size(a - b) < 1e-8 * size(a), "{s}: {a:?} {b:?}");
        assert!((law.energy(low, MU) / law.energy(high, MU) - 1.0).abs() < 1e-8, "{s}");
    }
}
