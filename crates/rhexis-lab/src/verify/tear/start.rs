//! Starts by the coupled criterion (Leguillon 2002): a dog-bone parts at its strength, a notched sheet between that and what its
//! toughness carries, a hole tears on both sides.

use super::super::{Artifacts, Axes, Line, Row, Rows, VerifyError};
use super::cracked::{Cracked, Pattern, Tissue, even, refined, under_tension};
use super::pull::{Pulled, Start};
use glam::{DVec2, DVec3};
use rhexis::components::EnergyCriterion;
use rhexis::event::EventKind;
use rhexis::generate;
use rhexis::storage::TriangleMesh;
use std::f64::consts::PI;

/// Young's modulus of [`Tissue::isotropic`] \[MPa\].
const YOUNG: f64 = 3.0;

/// Toughness \[N/mm\] that gives a tissue of this strength \[MPa\] an Irwin length \[mm\].
fn toughness(strength: f64, irwin: f64) -> f64 {
    irwin * strength * strength / YOUNG
}

pub(crate) fn run(out: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("tear-start");
    dog_bone(&mut rows, out)?;
    notches(&mut rows, out)?;
    hole(&mut rows, out)?;
    rows.finish()
}

/// Width and length of the dog-bone's even part, length of its shoulders, edge of its mesh \[mm\], and how much wider its ends are.
const WIDTH: f64 = 12.0;
const EVEN: f64 = 10.0;
const SHOULDER: f64 = 20.0;
const EDGE: f64 = 0.4;
const WIDER: f64 = 1.2;
/// Strength of dog-bones and plates with a hole \[MPa\]: strains of 5 %.
const STRENGTH: f64 = 0.15;

/// Without a notch: strength is all that counts where the width is eight Irwin lengths. Where the shoulders begin stress is some 1 % above the mean (with shoulders of 12 mm 3 %).
fn dog_bone(rows: &mut Rows, out: &Artifacts) -> Result<(), VerifyError> {
    let patterns = if out.is_quick() { &Pattern::ALL[..1] } else { &Pattern::ALL[..] };
    let mut lines = Vec::new();
    for &pattern in patterns {
        let length = EVEN + 2.0 * SHOULDER;
        let mut mesh = pattern.mesh(DVec2::new(length, WIDTH), EDGE)?;
        mesh.positions.iter_mut().for_each(|p| *p = shaped(*p - DVec3::new(0.5 * length, 0.5 * WIDTH, 0.0)));
        let mut tissue = Tissue::isotropic(STRENGTH, 3.0 * EDGE);
        tissue.tearing.may_initiate = true;
        let energy = EnergyCriterion::new(even(toughness(STRENGTH, WIDTH / 8.0)));
        let sheet = tissue.membrane(mesh).with(energy);
        let area = WIDTH * tissue.material.thickness;
        let mut pulled = Pulled::new(sheet, 0.5 * length)?;
        let guess = pulled.guess(STRENGTH * area)?;
        let torn = pulled.until_torn(0.9 * guess, 0.0025 * guess, 200)?;
        let name = format!("dog-bone, {}", pattern.name());
        rows.relative(format!("{name}: mean stress at its start, of the strength"), torn.force / area, STRENGTH, 0.03);
        rows.ratio(format!("{name}: does not part"), f64::from(u8::from(torn.pieces == 0)), 0.0);
        lines.extend(torn.lines(&name));
    }
    out.paths("tear-start-dog-bone", "dog-bones: tears in the rest shape", &lines)
}

/// A point of the strip about the origin, widened towards its ends.
fn shaped(p: DVec3) -> DVec3 {
    let way = ((p.x.abs() - 0.5 * EVEN) / SHOULDER).clamp(0.0, 1.0);
    DVec3::new(p.x, p.y * (1.0 + 0.5 * (WIDER - 1.0) * (1.0 - (PI * way).cos())), 0.0)
}

/// Side of the notched sheets, half of their notch, R and the edge far from the notch \[mm\]. The finite width raises K by 0.2 %.
const SIDE: f64 = 40.0;
const NOTCH: f64 = 1.0;
const RADIUS: f64 = 0.2;
const FAR: f64 = 1.0;
/// Strength of the notched sheets \[MPa\]: strains of 1e-4.
const SMALL: f64 = 3e-4;
/// Half of the notch over Irwin's length; the ends are judged.
const NOTCHES: [f64; 6] = [0.1, 0.3, 0.5, 1.0, 3.0, 10.0];

/// From the strength where notches are short to √(E·G_c/πa) where they are long.
fn notches(rows: &mut Rows, out: &Artifacts) -> Result<(), VerifyError> {
    let all = if out.is_quick() { vec![NOTCHES[0], NOTCHES[5]] } else { NOTCHES.to_vec() };
    let mut found = Vec::new();
    for ratio in all {
        let griffith = 1.0 / (PI * ratio).sqrt();
        let wanted = griffith.min(1.0);
        let (mut low, mut high) = (0.8 * wanted, 1.2 * wanted);
        let what = format!("centre notch of {ratio} Irwin lengths: load");
        if tears_at(low, ratio)? || !tears_at(high, ratio)? {
            rows.ratio(format!("{what}, not within a fifth of the closed form"), f64::NAN, 0.0);
            continue;
        }
        while high - low > 5e-3 * wanted {
            let middle = 0.5 * (low + high);
            *if tears_at(middle, ratio)? { &mut high } else { &mut low } = middle;
        }
        let load = 0.5 * (low + high);
        found.push(DVec2::new(ratio.log10(), load));
        match ratio {
            0.1 => rows.relative(format!("{what}, of the strength"), load, 1.0, 0.05),
            10.0 => rows.relative(format!("{what}, of √(E·G_c/πa)"), load, griffith, 0.05),
            _ => rows.note(format!("{what} over that of both conditions at the notch"), load / coupled(ratio), "1"),
        }
    }
    let curve = |of: &dyn Fn(f64) -> f64| -> Vec<DVec2> {
        (0..=60).map(|i| -1.2 + 0.04 * f64::from(i)).map(|x| DVec2::new(x, of(10_f64.powf(x)))).collect()
    };
    let lines = vec![
        Line { name: "engine".to_owned(), points: found },
        Line { name: "strength or toughness".to_owned(), points: curve(&|a| (1.0 / (PI * a).sqrt()).min(1.0)) },
        Line { name: "both conditions at the notch".to_owned(), points: curve(&coupled) },
    ];
    let names = ["log10 of half the notch over Irwin's length", "load over strength"];
    let axes = Axes { title: "strength against notch length", names, is_isometric: false };
    out.plot("tear-start-notches", axes, &lines)
}

/// Load over strength at which the coupled criterion holds ahead of a notch, whose half is `ratio` Irwin lengths: the smallest
/// over all lengths ℓ of the larger of √(1 − (a/(a + ℓ))²) and √(2/π(2a + ℓ)).
fn coupled(ratio: f64) -> f64 {
    let at = |length: f64| {
        let strength = (1.0 - (ratio / (ratio + length)).powi(2)).sqrt();
        strength.max((2.0 / (PI * (2.0 * ratio + length))).sqrt())
    };
    (1..4000).map(|i| at(1e-3 * 1.003_f64.powi(i))).fold(f64::INFINITY, f64::min)
}

/// Whether the sheet tears under so many times its strength: by its notch, or anywhere else.
fn tears_at(times: f64, ratio: f64) -> Result<bool, VerifyError> {
    let mut tissue = Tissue::isotropic(SMALL, RADIUS);
    tissue.tearing.may_initiate = true;
    let size = DVec2::splat(SIDE);
    let sheet = under_tension(
        tissue.membrane(Pattern::Structured.mesh(size, FAR)?),
        size,
        times * SMALL,
        tissue.material.thickness,
    );
    let sheet =
        sheet.with(EnergyCriterion::new(even(toughness(SMALL, NOTCH / ratio)))).with(refined(4.0, 3.0 * RADIUS));
    let middle = 0.5 * size;
    let mut cracked = Cracked::new(sheet, [middle - DVec2::X * NOTCH, middle + DVec2::X * NOTCH])?;
    cracked.simulation.drain_events().for_each(drop);
    cracked.simulation.settle_and_tear(1.0, 1e-9, 1)?;
    let tears = |kind: &EventKind| matches!(kind, EventKind::Advanced { .. } | EventKind::Started { .. });
    Ok(cracked.simulation.drain_events().any(|event| tears(&event.kind)))
}

/// Irwin's length of the plates with a hole \[mm\], whose radius is 1 mm, and R.
const IRWIN: f64 = 1.0;
const HOLE_RADIUS: f64 = 0.2;

/// A plate with a hole, pulled along x: cracks on either side, along y.
fn hole(rows: &mut Rows, out: &Artifacts) -> Result<(), VerifyError> {
    let points: &[usize] = if out.is_quick() { &[96] } else { &[64, 96, 128] };
    let mut lines = Vec::new();
    for &points in points {
        let name = format!("hole of {points} points");
        let mesh: TriangleMesh = generate::plate_with_hole(points)?;
        let mut tissue = Tissue::isotropic(STRENGTH, HOLE_RADIUS);
        tissue.tearing.may_initiate = true;
        let energy = EnergyCriterion::new(even(toughness(STRENGTH, IRWIN)));
        let mut pulled = Pulled::new(tissue.membrane(mesh).with(energy), 5.0)?;
        let guess = pulled.guess(STRENGTH * 10.0 * tissue.material.thickness)?;
        let torn = pulled.until_torn(0.3 * guess, 0.005 * guess, 100)?;
        rows.ratio(format!("{name}: cracks off two"), (torn.starts.len() as f64 - 2.0).abs(), 0.0);
        let [first, second] = &torn.starts[..] else { continue };
        let edge = 2.0 * PI / points as f64;
        let off = |start: &Start| {
            let tip = start.path.iter().map(|p| p.x.abs()).fold(0.0, f64::max);
            tip / edge
        };
        rows.add(format!("{name}: cracks off the line across the pull"), off(first).max(off(second)), 2.0, "edge");
        let ends = [first, second].map(|start| start.path.last().copied().unwrap_or(DVec2::NAN));
        rows.add(
            format!("{name}: ends off each other's mirror image"),
            (ends[0] + ends[1]).length() / edge,
            2.0,
            "edge",
        );
        rows.note(
            format!("{name}: mean stress at the start over strength"),
            torn.force / (10.0 * tissue.material.thickness * STRENGTH),
            "1",
        );
        rows.note(format!("{name}: the same in a wide plate"), wide_hole(IRWIN), "1");
        lines.extend(torn.lines(&name));
    }
    out.paths("tear-start-hole", "cracks at a hole of 1 mm, pulled along x", &lines)
}

/// Load over strength at which both conditions hold beside a hole of 1 mm in a wide plate, each by itself: stress by Kirsch, release
/// as of a straight rim.
fn wide_hole(irwin: f64) -> f64 {
    let stress = |x: f64| {
        let q = (1.0 + x).powi(-2);
        1.0 + 0.5 * q + 1.5 * q * q
    };
    let intensity = |a: f64| {
        let nodes = (0..100).map(|i| (f64::from(i) + 0.5) / 100.0);
        let weight = |s: f64| 2.0 * (1.0 + 0.6147 * s * s + 0.204 * s.powi(4)) * stress(a * (1.0 - s * s));
        (2.0 * a / PI).sqrt() * nodes.map(weight).sum::<f64>() / 100.0
    };
    let (mut released, mut best) = (0.0, f64::INFINITY);
    for i in 1..2000 {
        let a = 2e-3 * f64::from(i);
        released += 2e-3 * intensity(a - 1e-3).powi(2);
        best = (irwin * a / released).sqrt().max(1.0 / stress(a)).min(best);
    }
    best
}
