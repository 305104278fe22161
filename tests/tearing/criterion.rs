//! The tear criterion against independent reference values, and the properties it must have.

use glam::DVec2;
use rhexis::math::Sym2;
use rhexis::systems::kernels::failure::{
    Cone, Decision, Origin, Search, Sector, Strength, cannot_tear, direction_value, evaluate,
};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Rows of a reference file as columns by name; an empty field is NaN.
fn reference(name: &str) -> (csv::StringRecord, Vec<csv::StringRecord>) {
    let path = format!("{}/crates/rhexis-lab/tests/reference/{name}", env!("CARGO_MANIFEST_DIR"));
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(path).unwrap();
    let header = reader.headers().unwrap().clone();
    (header, reader.records().map(Result::unwrap).collect())
}

fn number(header: &csv::StringRecord, row: &csv::StringRecord, column: &str) -> f64 {
    let index = header.iter().position(|h| h == column).unwrap();
    if row[index].is_empty() { f64::NAN } else { row[index].parse().unwrap() }
}

fn direction(degrees: f64) -> DVec2 {
    DVec2::from_angle(degrees.to_radians())
}

/// Angle between two directions, or between two lines.
fn apart(a: f64, b: f64, period: f64) -> f64 {
    let d = (a - b).rem_euclid(period);
    d.min(period - d)
}

/// A fixed sequence of numbers in [0, 1): a linear congruence (Knuth's constants), upper bits.
struct Sequence(u64);

impl Sequence {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    fn stress(&mut self) -> Sym2 {
        Sym2::new(self.within(-1.0, 2.0), self.within(-1.0, 2.0), self.within(-1.0, 1.0))
    }

    /// Ratios up to 30 either way, exponents from 0.15 to 10, with the special ones α = 1 and σ̄_F = σ̄_T among them.
    fn strength(&mut self) -> Strength {
        let transverse = self.within(0.1, 1.0);
        let ratio = if self.next() < 0.1 { 1.0 } else { 30f64.powf(self.within(-0.6, 1.0)) };
        let exponent = if self.next() < 0.1 { 1.0 } else { 10f64.powf(self.within(-0.82, 1.0)) };
        Strength::new(transverse * ratio, transverse, exponent).unwrap()
    }

    fn direction(&mut self) -> DVec2 {
        DVec2::from_angle(self.within(-PI, PI))
    }

    fn cone(&mut self) -> Option<Cone> {
        let cone = Cone { previous: self.direction(), half_angle: self.within(0.05, PI) };
        (self.next() < 0.7).then_some(cone)
    }

    fn sector(&mut self) -> Option<Sector> {
        let from = self.within(-10.0, 10.0);
        let sector = Sector { from, to: from + self.within(0.1, TAU) };
        (self.next() < 0.3).then_some(sector)
    }
}

/// Asks the table, which must give the same winner, value and runner-up.
fn assert_found(search: &Search, stress: Sym2, fibre: DVec2, cone: Option<Cone>, sector: Option<Sector>) {
    let exact = evaluate(stress, fibre, search.strength(), cone, sector);
    let found = search.evaluate(stress, fibre, cone, sector);
    let case = format!("{search:?} {stress:?} {fibre:?} {cone:?} {sector:?}: {found:?} {exact:?}");
    let (Some(found), Some(exact)) = (found, exact) else { return assert_eq!(found, exact, "{case}") };
    // Values are good to some roundings of the largest |c|; under compression they cancel to nearly zero.
    let (high, low) = stress.principal_values();
    let size = exact.best.value.abs().max(1e-3 * high.abs().max(low.abs()) / search.strength().smallest());
    assert!((found.best.value - exact.best.value).abs() <= 1e-12 * size, "{case}");
    let (a, b) = (found.best.direction, exact.best.direction);
    // Equal maxima less than 2° apart are one decision, taken at either of them; flat ones are found to 1e-7 rad.
    let is_equal = (found.best.value - exact.best.value).abs() <= 1e-13 * size && a.dot(b).abs() > 0.999;
    assert!(a.perp_dot(b).abs() < 1e-7 || is_equal, "{case}");
    assert_eq!(found.runner_up.is_some(), exact.runner_up.is_some(), "{case}");
    if let (Some(a), Some(b)) = (found.runner_up, exact.runner_up) {
        assert!((a.value - b.value).abs() <= 1e-9 * size, "{case}");
    }
}

#[test]
fn the_table_finds_what_the_enumeration_finds() {
    let mut random = Sequence(10);
    let mut search = Search::new(Strength::new(1.0, 1.0, 1.0).unwrap());
    for case in 0..100_000 {
        if case % 20 == 0 {
            let near_one = 1.0 + 1e-6 * random.within(-1.0, 1.0);
            let spread = 0.05 * 80f64.powf(random.next());
            let exponent = [0.5, 1.0, 2.0, near_one, random.within(1.0, 2.0), spread, spread, spread][case / 20 % 8];
            let near_equal = 1.0 + 1e-9 * random.next();
            let spread = 1e3f64.powf(random.within(-1.0, 1.0));
            let ratio = [1.0, near_equal, spread, spread, spread][case / 20 % 5];
            search = Search::new(Strength::new(ratio, 1.0, exponent).unwrap());
        }
        let f = random.direction();
        let (x, y, small) = (random.within(-1.0, 1.0), random.within(-1.0, 1.0), 1e-11 * random.within(-1.0, 1.0));
        let stress = match case % 8 {
            // One principal stress; nearly hydrostatic; nearly on the fibre's axes, where mirror images nearly tie.
            0 => Sym2::outer(random.direction()) * x,
            1 => Sym2::new(x, x + small, small),
            2 => Sym2::new(x, y, small).in_axes(DVec2::new(f.x, -f.y), DVec2::new(f.y, f.x)),
            _ => random.stress(),
        };
        let (cone, sector) = (random.cone(), random.sector());
        assert_found(&search, stress, f, cone, sector);
    }
}

#[test]
fn all_reference_evaluations_agree() {
    let (header, rows) = reference("criterion.csv");
    assert_eq!(rows.len(), 134);
    let (mut worst_value, mut worst_angle, mut angles) = (0f64, 0f64, 0);
    for row in &rows {
        let n = |column| number(&header, row, column);
        let stress = Sym2::new(n("sx"), n("sy"), n("txy"));
        let strength = Strength::new(n("sigF"), n("sigT"), n("alpha")).unwrap();
        let previous = n("prev_deg");
        let cone = (!previous.is_nan())
            .then(|| Cone { previous: direction(previous), half_angle: n("thetaP_deg").to_radians() });
        let d = evaluate(stress, direction(n("fibre_deg")), &strength, cone, None).unwrap();
        let id = n("id");
        assert_found(&Search::new(strength), stress, direction(n("fibre_deg")), cone, None);

        // The file has 15 digits; c is compared on the scale of the largest |c| the stress can give.
        let (high, low) = stress.principal_values();
        let scale = high.abs().max(low.abs()) / strength.smallest();
        let value_error = (d.best.value - n("c_max")).abs() / scale.max(n("c_max").abs());
        worst_value = worst_value.max(value_error);
        assert!(value_error < 1e-10, "row {id}: {} against {}", d.best.value, n("c_max"));
        assert_eq!(d.tears(), n("tears") == 1.0, "row {id}");
        // One hydrostatic row is a tie only between directions less than 2° apart: a flat maximum, one decision.
        let spread = apart(n("d_deg"), n("d_deg_grid_1e-6rad_plus_kinks"), 360.0);
        let is_flat = (0.01..2.0).contains(&spread);
        assert_eq!(d.is_tie(), n("tie") == 1.0 && !is_flat, "row {id}: margin {}", d.margin());

        if n("tie") == 0.0 {
            angles += 1;
            let period = if cone.is_some() { TAU } else { PI };
            let error = apart(d.best.angle(), n("d_deg").to_radians(), period);
            worst_angle = worst_angle.max(error);
            assert!(error < 1e-6, "row {id}: {} against {}", d.best.angle().to_degrees(), n("d_deg"));
            let expected = match (&row[header.iter().position(|h| h == "where").unwrap()], strength) {
                ("cone_limit", _) => Origin::Limit,
                (_, s) if s.fibre == s.transverse => Origin::Principal,
                ("fibre_kink", _) => Origin::Kink,
                _ => Origin::Smooth,
            };
            assert_eq!(d.origin, expected, "row {id}");
        }
    }
    // Both are at rounding: also the angles of the flattest smooth maxima, since the root of c′ is sought and not the maximum.
    assert!(worst_value < 1e-13 && worst_angle < 1e-12 && angles == 127, "{worst_value} {worst_angle} {angles}");
}

#[test]
fn the_tear_locks_onto_the_fibre_where_it_should() {
    let (header, rows) = reference("fibre_lock.csv");
    assert!(rows.len() > 50);
    for row in &rows {
        let n = |column| number(&header, row, column);
        let fibre = n("fibre_deg_to_load");
        let strength = Strength::new(n("sF_over_sT"), 1.0, n("alpha")).unwrap();
        for (transverse_stress, deviation, value) in [
            (0.0, n("deviation_deg_uniaxial"), n("c_uniaxial_sT1")),
            (2.0 / 3.0, n("deviation_deg_biaxial_1_0.667"), n("c_biaxial")),
        ] {
            // The file's biaxial stress is the ratio with three digits or more: its c is good to nine.
            let stress = Sym2::new(1.0, transverse_stress, 0.0);
            let d = evaluate(stress, direction(fibre), &strength, None, None).unwrap();
            assert_found(&Search::new(strength), stress, direction(fibre), None, None);
            assert!((d.best.value - value).abs() < 2e-9, "{row:?}: {}", d.best.value);
            // The printed deviation has four decimals, from a grid of 1e-4 degrees.
            let found = (d.best.angle().to_degrees() - fibre + 90.0).rem_euclid(180.0) - 90.0;
            let error = apart(found, deviation, 180.0);
            let mirrored = if d.is_tie() { apart(found, -deviation, 180.0) } else { error };
            assert!(error.min(mirrored) < 0.01, "{row:?}: {found} against {deviation}, {d:?}");
            if deviation == 0.0 {
                let locked = direction_value(stress, direction(fibre), &strength, direction(fibre));
                assert!((d.best.value - locked).abs() < 1e-15);
                assert_eq!(d.origin, Origin::Kink);
            }
        }
    }
}

/// Mode I and II singular fields at r = 1, K/√(2π) = 1 (Williams 1957), averaged over the angles |θ| ≤ `reach` (Simpson) and,
/// as r^(−1/2) over the area to radius 1, times 4/3.
fn averaged_tip_stress(k1: f64, k2: f64, reach: f64) -> Sym2 {
    let field = |theta: f64| {
        let (s, c) = (0.5 * theta).sin_cos();
        let (s3, c3) = (1.5 * theta).sin_cos();
        Sym2::new(
            k1 * c * (1.0 - s * s3) - k2 * s * (2.0 + c * c3),
            k1 * c * (1.0 + s * s3) + k2 * s * c * c3,
            k1 * c * s * c3 + k2 * c * (1.0 - s * s3),
        )
    };
    let steps = 2000;
    let weight = |i| if i == 0 || i == steps { 1.0 } else { 2.0 + 2.0 * f64::from(i % 2) };
    let sum = (0..=steps)
        .fold(Sym2::ZERO, |sum, i| sum + field(reach * (2.0 * f64::from(i) / f64::from(steps) - 1.0)) * weight(i));
    sum * (4.0 / 3.0 / (3.0 * f64::from(steps)))
}

#[test]
fn a_slanted_crack_kinks_as_computed() {
    let (header, rows) = reference("kink.csv");
    let strength = Strength::new(1.0, 1.0, 1.0).unwrap();
    for row in &rows {
        let n = |column: &str| number(&header, row, column);
        for (region, reach) in [("disc", PI), ("halfdisc", FRAC_PI_2), ("sector45", 0.25 * PI)] {
            let stress = averaged_tip_stress(n("KI_over_sig_sqrt_pi_a"), n("KII_over_sig_sqrt_pi_a"), reach);
            let cone = Cone { previous: DVec2::X, half_angle: FRAC_PI_2 };
            let d = evaluate(stress, DVec2::Y, &strength, Some(cone), None).unwrap();
            // The file's twelve digits; Simpson's error with 2000 steps is below 1e-12.
            let kink = n(&format!("kink_paper_{region}_deg"));
            assert!(
                (d.best.angle().to_degrees() - kink).abs() < 1e-8,
                "{region}: {}, {kink}",
                d.best.angle().to_degrees()
            );
            assert!((d.best.value - n(&format!("s1_{region}"))).abs() < 1e-10);
        }
    }
}

#[test]
fn along_and_across_the_fibre_the_criterion_has_its_limits() {
    let mut random = Sequence(1);
    for _ in 0..1000 {
        let (stress, f, s) = (random.stress(), random.direction(), random.strength());
        // Equal but for rounding of u·T·u, a few units in the last place of the largest component.
        let along = direction_value(stress, f, &s, f) - stress.normal_component(f.perp()) / s.transverse;
        let across = direction_value(stress, f, &s, f.perp()) - stress.normal_component(f) / s.fibre;
        assert!(along.abs() < 1e-14 / s.transverse && across.abs() < 1e-14 / s.fibre);
        assert_eq!((s.threshold(0.0), s.threshold(FRAC_PI_2)), (s.transverse, s.fibre));
    }
}

#[test]
fn with_equal_thresholds_it_is_the_largest_principal_stress() {
    let mut random = Sequence(2);
    for _ in 0..1000 {
        let (stress, f) = (random.stress(), random.direction());
        let s = Strength::new(0.37, 0.37, random.within(0.2, 5.0)).unwrap();
        for cone in [None, Some(Cone { previous: random.direction(), half_angle: FRAC_PI_2 })] {
            let d = evaluate(stress, f, &s, cone, None).unwrap();
            let (high, low) = stress.principal_values();
            assert!((d.best.value - high / 0.37).abs() < 1e-14 * (high.abs() + low.abs()) / 0.37);
            // The tear runs across the principal axis; the angle is as good as rounding over the spread of the values.
            let error = apart(d.best.angle(), stress.principal_angle() + FRAC_PI_2, PI);
            assert!(error < 1e-14 * (high.abs() + low.abs()) / (high - low) + 1e-14, "{error}");
            assert_eq!(d.origin, Origin::Principal);
        }
    }
}

fn is_admissible(d: DVec2, cone: Option<Cone>, sector: Option<Sector>, slack: f64) -> bool {
    cone.is_none_or(|c| d.dot(c.previous) >= c.half_angle.min(PI).cos() - slack)
        && sector.is_none_or(|s| {
            let turn = (d.to_angle() - s.from).rem_euclid(TAU);
            turn <= s.to - s.from + slack || turn >= TAU - slack
        })
}

#[test]
fn no_direction_of_a_fine_grid_beats_the_maximum() {
    let mut random = Sequence(3);
    let (mut limits, mut kinks, mut smooth, mut none) = (0, 0, 0, 0);
    for case in 0..2000 {
        let (stress, f, s) = (random.stress(), random.direction(), random.strength());
        let (cone, sector) = (random.cone(), random.sector());
        let mut grid: Vec<DVec2> = (0..1440).map(|i| direction(0.25 * f64::from(i))).collect();
        // Close to the fibre, where cusps hide, a grid in powers of ten.
        for exponent in 1..60 {
            let step = DVec2::from_angle(10f64.powf(-0.2 * f64::from(exponent)));
            for d in [f, -f, f.perp(), -f.perp()] {
                grid.extend([step.rotate(d), DVec2::new(step.x, -step.y).rotate(d)]);
            }
        }
        let admissible = grid.into_iter().filter(|d| is_admissible(*d, cone, sector, 0.0));
        let best = admissible.map(|d| direction_value(stress, f, &s, d)).fold(f64::NEG_INFINITY, f64::max);
        let Some(d) = evaluate(stress, f, &s, cone, sector) else {
            none += 1;
            assert_eq!(best, f64::NEG_INFINITY, "case {case}");
            continue;
        };
        match d.origin {
            Origin::Limit => limits += 1,
            Origin::Kink => kinks += 1,
            Origin::Smooth | Origin::Principal => smooth += 1,
        }
        // Rounding on the scale of the largest |c|, 2/0.06.
        assert!(d.best.value >= best - 1e-13 * 3.0 / s.smallest(), "case {case}: {} below {best}", d.best.value);
        for c in [Some(d.best), d.runner_up].into_iter().flatten() {
            assert!(is_admissible(c.direction, cone, sector, 2e-9), "case {case}");
            assert!((c.direction.length() - 1.0).abs() < 1e-15 * 4.0);
            // The value is that of the direction, but for the cusp: a direction rounded by 1e-16 next to the fibre has moved
            // by (1e-16)^0.15 = 4e-3 in w at worst, so kinks and the nearest directions are left out.
            if f.perp_dot(c.direction).abs() > 1e-6 {
                let value = direction_value(stress, f, &s, c.direction);
                assert!((c.value - value).abs() < 1e-9 * 3.0 / s.smallest(), "case {case}: {} {value}", c.value);
            }
        }
        if let Some(other) = d.runner_up {
            assert!(other.value <= d.best.value + 1e-12 * d.best.value.abs());
            assert!(other.direction.dot(d.best.direction) <= 2f64.to_radians().cos());
            assert!((0.0..).contains(&d.margin()));
        }
        if cannot_tear(stress, &s) {
            assert!(d.best.value <= 1.0 + 1e-14, "case {case}");
        }
    }
    // Every kind of maximum has been met often enough to mean something.
    assert!(limits > 100 && kinks > 100 && smooth > 100 && none > 10);
}

/// All local maxima of the grid that are 2° from the best: what the runner-up must be.
#[test]
fn the_runner_up_is_the_best_other_local_maximum() {
    let mut random = Sequence(4);
    let mut found = 0;
    for case in 0..500 {
        let (stress, f, s) = (random.stress(), random.direction(), random.strength());
        let d = evaluate(stress, f, &s, None, None).unwrap();
        // A ring of lines that holds both kinks exactly: index 0 is f, index COUNT/2 is f⊥.
        const COUNT: usize = 7200;
        let at = |i: usize| match i % COUNT {
            0 => f,
            i if i == COUNT / 2 => f.perp(),
            i => DVec2::from_angle(PI * i as f64 / COUNT as f64).rotate(f),
        };
        let values: Vec<f64> = (0..COUNT).map(|i| direction_value(stress, f, &s, at(i))).collect();
        let best = (0..COUNT)
            .filter(|&i| values[i] > values[(i + 1) % COUNT] && values[i] > values[(i + COUNT - 1) % COUNT])
            .filter(|&i| at(i).dot(d.best.direction).abs() < 2.1f64.to_radians().cos())
            .map(|i| values[i])
            .fold(f64::NEG_INFINITY, f64::max);
        let runner_up = d.runner_up.map_or(f64::NEG_INFINITY, |c| c.value);
        // A smooth maximum lies up to half a step (2e-4 rad) from the grid: 1e-8 of a curvature of some tens; next to a cusp
        // the curvature is larger. Maxima narrower than a step are not on the grid at all, so the runner-up may be better.
        if best > f64::NEG_INFINITY {
            found += 1;
            assert!(runner_up >= best - 1e-9, "case {case}: {runner_up} below {best}");
        }
        if runner_up > best + 1e-3 * runner_up.abs() {
            let c = d.runner_up.unwrap().direction;
            assert!(f.perp_dot(c).abs() < 1e-3 || f.dot(c).abs() < 1e-3, "case {case}: {runner_up}, grid {best}");
        }
    }
    assert!(found > 50);
}

fn equal(a: &Decision, b: &Decision, turn: DVec2, value_factor: f64, tolerance: f64) -> bool {
    let same_line = turn.rotate(a.best.direction).perp_dot(b.best.direction).abs();
    let runner_ups = match (a.runner_up, b.runner_up) {
        (Some(x), Some(y)) => (x.value * value_factor - y.value).abs() < tolerance,
        (None, None) => true,
        _ => false,
    };
    // 1e-6 rad: a smooth maximum moves by rounding over its curvature, and random ones can be nearly flat.
    same_line < 1e-6 && (a.best.value * value_factor - b.best.value).abs() < tolerance && runner_ups
}

#[test]
fn the_decision_does_not_depend_on_signs_rotation_or_units() {
    let mut random = Sequence(5);
    for case in 0..1000 {
        let (stress, f, s) = (random.stress(), random.direction(), random.strength());
        let (cone, sector) = (random.cone(), random.sector());
        let Some(d) = evaluate(stress, f, &s, cone, sector) else { continue };
        // Rounding of the turned input, 1e-15, enters through the cusp at cone limits near the fibre.
        let tolerance = 1e-10 / s.smallest();

        let flipped = evaluate(stress, -f, &s, cone, sector).unwrap();
        assert!(equal(&d, &flipped, DVec2::X, 1.0, tolerance), "case {case}: {d:?} {flipped:?}");
        assert!(d.best.direction.dot(flipped.best.direction) > 0.0, "case {case}");

        let angle = random.within(-PI, PI);
        let turn = DVec2::from_angle(angle);
        let turned = evaluate(
            stress.in_axes_turned_by(-angle),
            turn.rotate(f),
            &s,
            cone.map(|c| Cone { previous: turn.rotate(c.previous), ..c }),
            sector.map(|s| Sector { from: s.from + angle, to: s.to + angle }),
        )
        .unwrap();
        assert!(equal(&d, &turned, turn, 1.0, tolerance), "case {case}: {d:?} {turned:?}");
        assert!(cone.is_none() || turn.rotate(d.best.direction).dot(turned.best.direction) > 0.0, "case {case}");

        // A power of two changes no digit at all.
        let doubled = Strength { fibre: 4.0 * s.fibre, transverse: 4.0 * s.transverse, ..s };
        assert_eq!(evaluate(stress * 4.0, f, &doubled, cone, sector), Some(d));
        let loaded = evaluate(stress * 3.0, f, &s, cone, sector).unwrap();
        assert!(equal(&d, &loaded, DVec2::X, 3.0, 3.0 * tolerance), "case {case}");
    }
}

#[test]
fn with_strong_fibres_in_tension_the_tear_lies_between_principal_line_and_fibre() {
    let mut random = Sequence(6);
    for case in 0..1000 {
        let angle = random.within(-PI, PI);
        let stress = Sym2::new(random.within(0.5, 2.0), random.within(0.0, 0.5), 0.0).in_axes_turned_by(angle);
        let s = Strength::new(random.within(1.0, 10.0), 1.0, random.within(0.2, 4.0)).unwrap();
        let f = random.direction();
        let d = evaluate(stress, f, &s, None, None).unwrap().best.angle();
        let principal = stress.principal_angle() + FRAC_PI_2;
        let (arc, to_fibre, to_principal) =
            (apart(f.to_angle(), principal, PI), apart(d, f.to_angle(), PI), apart(d, principal, PI));
        // On the shorter arc the two distances add up to it; 1e-7 rad for the smooth maximiser's rounding.
        assert!((to_fibre + to_principal - arc).abs() < 1e-7, "case {case}");
    }
}

#[test]
fn a_mirror_tie_is_broken_by_the_stated_rule() {
    let s = Strength::new(3.0, 1.0, 1.0).unwrap();
    let stress = Sym2::new(1.0, 0.0, 0.0);
    // The load lies along the fibre: two maxima at ±76.76° (fibre_lock.csv).
    let free = evaluate(stress, DVec2::X, &s, None, None).unwrap();
    assert!(free.is_tie() && free.is_ambiguous());
    assert!((free.best.angle().to_degrees() - 76.7602).abs() < 0.01);
    for (previous, expected) in [(70.0, 76.7602), (110.0, 103.2398), (-70.0, -76.7602), (90.0, 76.7602)] {
        let cone = Cone { previous: direction(previous), half_angle: 1.0 };
        for f in [DVec2::X, -DVec2::X] {
            let d = evaluate(stress, f, &s, Some(cone), None).unwrap();
            assert!(d.is_tie() && (d.best.angle().to_degrees() - expected).abs() < 0.01, "{previous}: {d:?}");
        }
    }
    // A hydrostatic stress on equal thresholds: every direction is as good, so the tear goes straight on.
    let equal = Strength::new(1.0, 1.0, 1.0).unwrap();
    let cone = Cone { previous: direction(25.0), half_angle: 1.0 };
    let d = evaluate(Sym2::new(2.0, 2.0, 1e-16), direction(10.0), &equal, Some(cone), None).unwrap();
    assert!(d.is_tie() && (d.best.angle().to_degrees() - 25.0).abs() < 1e-12);
    // One rounding each of the rotation into the fibre's axes and of the mean.
    assert!((d.best.value - 2.0).abs() < 1e-15);
}

#[test]
fn a_load_on_the_fibres_axes_gives_a_kink_or_a_mirror_tie() {
    let mut random = Sequence(9);
    let mut ties = 0;
    for case in 0..3000 {
        // σ_FT = 0 exactly, where H starts in a multiple of π; α = 2 makes its slope vanish there too.
        let s =
            Strength { exponent: [0.5, 1.0, 1.5, 2.0, 3.0, random.within(0.1, 5.0)][case % 6], ..random.strength() };
        let stress = Sym2::new(random.within(-1.0, 1.0), random.within(-1.0, 1.0), 0.0);
        let d = evaluate(stress, DVec2::X, &s, None, None).unwrap();
        // Within 1° of an axis the mirror images are one decision.
        let is_on_axis = d.best.direction.x.abs().min(d.best.direction.y.abs()) < 1f64.to_radians().sin();
        assert!(is_on_axis || d.is_tie(), "case {case}: {d:?}");
        ties += usize::from(!is_on_axis);
    }
    assert!(ties > 300, "{ties}");
}

#[test]
fn a_kink_at_the_very_limit_counts_as_inside() {
    // p ⊥ f, θ_P = 90°: cos 90° is not 0 in floating point, and α = 0.2 makes the cusp as sharp as can be.
    let s = Strength::new(2.0, 0.5, 0.2).unwrap();
    let mut random = Sequence(7);
    for _ in 0..200 {
        let f = random.direction();
        let stress = Sym2::outer(f.perp());
        for sign in [1.0, -1.0] {
            let cone = Cone { previous: f.perp() * sign, half_angle: FRAC_PI_2 };
            let d = evaluate(stress, f, &s, Some(cone), None).unwrap();
            assert_eq!(d.origin, Origin::Kink);
            assert!((d.best.value - 2.0).abs() < 1e-14);
        }
        // The same for a fan bounded by edges along the fibre.
        let from = f.to_angle();
        let d = evaluate(stress, f, &s, None, Some(Sector { from: from + 1e-12, to: from + 1.0 })).unwrap();
        assert_eq!((d.origin, d.best.direction.dot(f) > 0.0), (Origin::Kink, true));
    }
}

#[test]
fn hostile_input_gives_no_decision_or_a_finite_one() {
    let odd = [f64::NAN, f64::INFINITY, -f64::INFINITY, 0.0, -0.0, 1e300, -1e300, 1e-300, 5e-324, 1.0, -1.0, 1e-17];
    let mut random = Sequence(8);
    let mut pick = || odd[(random.next() * odd.len() as f64) as usize];
    let mut decided = 0;
    for _ in 0..200_000 {
        let stress = Sym2::new(pick(), pick(), pick());
        let (f, p) = (DVec2::new(pick(), pick()), DVec2::new(pick(), pick()));
        let strength = Strength { fibre: pick(), transverse: pick(), exponent: pick() };
        let cone = (pick() != 1.0).then(|| Cone { previous: p, half_angle: pick() });
        let sector = (pick() == 1.0).then(|| Sector { from: pick(), to: pick() });
        cannot_tear(stress, &strength);
        if let Some(d) = evaluate(stress, f, &strength, cone, sector) {
            decided += 1;
            for c in [Some(d.best), d.runner_up].into_iter().flatten() {
                assert!(c.value.is_finite() && c.direction.is_finite() && c.angle().is_finite(), "{d:?}");
            }
            assert!(!d.margin().is_nan());
        }
        assert!(
            Strength::new(strength.fibre, strength.transverse, strength.exponent).is_ok_and(|s| s.smallest() > 0.0)
                == [strength.fibre, strength.transverse, strength.exponent].iter().all(|x| *x > 0.0 && x.is_finite())
        );
    }
    assert!(decided > 100);
}

#[test]
fn nothing_is_decided_where_nothing_is_admissible() {
    let s = Strength::new(2.0, 1.0, 0.5).unwrap();
    let cone = Some(Cone { previous: DVec2::X, half_angle: 0.3 });
    let away = Some(Sector { from: 0.4, to: 2.0 });
    assert_eq!(evaluate(Sym2::IDENTITY, DVec2::Y, &s, cone, away), None);
    let touching = Some(Sector { from: 0.3, to: 2.0 });
    let d = evaluate(Sym2::IDENTITY, DVec2::Y, &s, cone, touching).unwrap();
    assert!((d.best.angle() - 0.3).abs() < 1e-9 && d.runner_up.is_none());
}
