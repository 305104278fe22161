//! Strengths, toughnesses and pre-stretches that differ from triangle to triangle.

use crate::common::{NOTCH, SIDE, Square};
use glam::DVec3;
use rhexis::components::{
    Curve, EnergyCriterion, Hold, HolzapfelGasserOgden, Material, PreStretch, Refinement, TearLog, Tearing, Toughness,
};
use rhexis::generate;
use rhexis::math::{GroundSubstance, Sym2};
use rhexis::membrane::{BodyError, Membrane};
use rhexis::settings::Settings;
use rhexis::simulation::Simulation;
use rhexis::storage::{Attached, BodyId, Triangles, Vertices};

/// A square drawn apart by steps of 10 ms.
fn run(membrane: Membrane, is_cut: bool, steps: usize) -> (Simulation, BodyId) {
    let mut simulation = Simulation::new(Settings { threads: 1, ..Settings::default() }).unwrap();
    let body = simulation.spawn(membrane).unwrap();
    if is_cut {
        simulation.cut(body, &NOTCH).unwrap();
    }
    (0..steps).for_each(|_| _ = simulation.step(10.0).unwrap());
    (simulation, body)
}

fn positions(simulation: &Simulation, body: BodyId) -> Vec<DVec3> {
    simulation.world().get::<&Vertices>(body.entity()).unwrap().position.clone()
}

fn length(simulation: &Simulation, body: BodyId) -> f64 {
    simulation.world().get::<&TearLog>(body.entity()).unwrap().length
}

/// Powers of two change no digits: the same factor everywhere is the body's own strength, bit for bit, on every way to a tear.
#[test]
fn one_factor_for_all_is_the_bodys_own() {
    let toughness = |factor: f64| Toughness { along: 0.02 * factor, across: 0.02 * factor };
    for way in 0..3 {
        let mut square = Square::isotropic([15, 12]);
        square.tearing.may_initiate = way == 1;
        let count = 2 * 15 * 12;
        let with_energy = |membrane: Membrane, factor: f64| {
            if way == 2 { membrane.with(EnergyCriterion::new(toughness(factor))) } else { membrane }
        };
        let mapped = with_energy(square.membrane(), 1.0).strengths(vec![0.5; count]).toughnesses(vec![0.25; count]);
        let weak = Tearing {
            strength_across_fibres: 0.5 * square.tearing.strength_across_fibres,
            strength_along_fibres: 0.5 * square.tearing.strength_along_fibres,
            ..square.tearing
        };
        let plain = with_energy(Square { tearing: weak, ..square.clone() }.membrane(), 0.25);
        let (mapped, plain) = (run(mapped, way != 1, 60), run(plain, way != 1, 60));
        assert!(length(&plain.0, plain.1) > 2.0, "{way}: {} mm", length(&plain.0, plain.1));
        assert_eq!(positions(&mapped.0, mapped.1), positions(&plain.0, plain.1), "{way}");
    }
}

/// A strip of a fifth of the strength, slanted off the way that the tear takes by itself.
fn seam(p: DVec3) -> bool {
    (p.x - 15.0 - 0.5 * (27.0 - p.y)).abs() < 1.4
}

/// The tear follows a seam that leads away from its own course; children have the factor of the triangle that they were part of, and
/// the account is that of what was cut.
#[test]
fn a_tear_follows_a_seam_and_children_inherit() {
    let square = Square::isotropic([30, 25]);
    let mesh = generate::grid(SIDE, SIDE, 30, 25).unwrap();
    let is_weak: Vec<bool> = mesh
        .triangles
        .iter()
        .map(|t| seam(t.iter().map(|&v| mesh.positions[v as usize]).sum::<DVec3>() / 3.0))
        .collect();
    let factors = |weak: f64| is_weak.iter().map(|is_weak| if *is_weak { weak } else { 1.0 }).collect::<Vec<f64>>();
    // Of what lies below the notch, the way that the tips have gone aside.
    let aside = |membrane: Membrane| {
        let (simulation, body) = run(membrane, true, 90);
        let world = simulation.world();
        let tips = world.get::<&rhexis::storage::Tips>(body.entity()).unwrap();
        let vertices = world.get::<&Vertices>(body.entity()).unwrap();
        let triangles = world.get::<&Triangles>(body.entity()).unwrap();
        let ends: Vec<DVec3> = tips.vertex.iter().map(|&v| vertices.rest_position[v as usize]).collect();
        let kinds = (0..triangles.len()).map(|t| (triangles.strength[t], triangles.rest[t].area)).collect::<Vec<_>>();
        (ends, length(&simulation, body), kinds)
    };
    let (straight, ..) = aside(square.membrane());
    let (ends, length, kinds) = aside(square.membrane().strengths(factors(0.2)));
    // Without a seam it goes down within an edge's length of the middle; with one it stays in the seam.
    assert!(straight.iter().all(|end| (end.x - 15.0).abs() < 1.2), "{straight:?}");
    assert!(length > 8.0 && ends.iter().all(|end| end.y < 21.0 && seam(*end)), "{length} mm: {ends:?}");
    assert!(kinds.len() > is_weak.len());
    assert!(kinds.iter().all(|(factor, _)| *factor == 0.2 || *factor == 1.0));
    // Cells of one size; a flip or slide across the seam's border would change its area.
    let weak: f64 = kinds.iter().filter(|(factor, _)| *factor == 0.2).map(|(_, area)| area).sum();
    let before = is_weak.iter().filter(|is_weak| **is_weak).count() as f64 * SIDE * SIDE / (2.0 * 30.0 * 25.0);
    assert!((weak - before).abs() < 0.05 * before, "{weak} mm² of {before}");
}

/// What a tear takes is counted by the triangles that it cuts.
#[test]
fn the_account_knows_what_was_cut() {
    let tough = Toughness { along: 0.02, across: 0.02 };
    let square = Square::isotropic([15, 12]);
    let membrane = square.membrane().with(EnergyCriterion::new(tough)).toughnesses(vec![0.3; 2 * 15 * 12]);
    let (simulation, body) = run(membrane, true, 60);
    let log = simulation.world().get::<&TearLog>(body.entity()).unwrap();
    assert!(log.length > 2.0);
    // Sums of some tens of advances.
    let expected = log.area * 0.3 * 0.02;
    let claimed = log.surface_energy.unwrap();
    assert!((claimed / expected - 1.0).abs() < 1e-12, "{claimed} mJ of {expected}");
}

/// A pre-stretch of every triangle is that of the body, bit for bit, in the forces, the criterion, refinement and the energies.
#[test]
fn one_pre_stretch_for_all_is_the_bodys_own() {
    let strain = Sym2::new(0.03, 0.05, 0.01);
    for way in 0..3 {
        let square = Square::isotropic([15, 12]);
        let sheet = || {
            let curve = Curve::new(vec![(0.0, 0.0), (1e4, 30.0)]).unwrap();
            let sheet = if way == 1 { square.out_of_plane(curve) } else { square.membrane() };
            let sheet = if way == 0 { sheet } else { sheet.with(Refinement::default()) };
            if way == 2 { sheet.with(EnergyCriterion::new(Toughness { along: 0.02, across: 0.02 })) } else { sheet }
        };
        let (plain, body) = run(sheet().with(PreStretch { strain }), true, 40);
        let (mapped, other) = run(sheet().pre_stretches(vec![strain; 2 * 15 * 12]), true, 40);
        assert!(length(&plain, body) > 1.0, "{way}");
        assert_eq!(positions(&plain, body), positions(&mapped, other), "{way}");
        assert_eq!(plain.energies(body).unwrap(), mapped.energies(other).unwrap(), "{way}");
    }
}

/// A bar clamped at both ends, one half of which is held stretched by e: without a Poisson's ratio the law is linear in the stretch, and
/// the halves have one force E·h·w·e/2, the right one the strain e/2.
#[test]
fn a_half_under_pre_stretch_draws_the_other() {
    let (width, e) = (4.0, 0.1);
    let mesh = generate::grid(20.0, width, 10, 4).unwrap();
    let strains = mesh.triangles.iter().map(|t| {
        let x = t.iter().map(|&v| mesh.positions[v as usize].x).sum::<f64>() / 3.0;
        Sym2::new(if x < 10.0 { e } else { 0.0 }, 0.0, 0.0)
    });
    let strains = strains.collect();
    let material = Material::isotropic(2.0, 0.0, 0.1);
    let mut bar = Membrane::new("bar", mesh, material).planar().pre_stretches(strains);
    for (name, x) in [("left", 0.0), ("right", 20.0)] {
        let members = Attached::new(bar.select(|p| p.x == x).into_iter().map(|row| (row, DVec3::ZERO)));
        bar = bar.hold(Hold { name: name.into(), members, axes: [true; 3], curve: Curve::constant(0.0) });
    }
    let mut simulation = Simulation::new(Settings::default()).unwrap();
    let body = simulation.spawn(bar).unwrap();
    simulation.settle(1.0, 1e-12).unwrap();
    let force = simulation.reactions(body).unwrap()[1].1.x;
    let expected = 2.0 * 0.1 * width * 0.5 * e;
    assert!((force / expected - 1.0).abs() < 1e-9, "{force} N of {expected}");
    let middle = positions(&simulation, body).iter().map(|p| (p.x - (10.0 - 0.5 * e * 10.0)).abs()).fold(9.0, f64::min);
    assert!(middle < 1e-9, "{middle}");
    // And so in a snapshot, through bytes where the build has them.
    let snapshot = simulation.snapshot();
    #[cfg(feature = "snapshot")]
    let snapshot = rhexis::snapshot::Snapshot::from_bytes(&snapshot.to_bytes().unwrap()).unwrap();
    let mut other = Simulation::new(Settings::default()).unwrap();
    other.restore(&snapshot).unwrap();
    assert_eq!(other.hash(), simulation.hash());
}

#[test]
fn lists_of_another_length_and_a_second_pre_stretch_under_a_published_law_are_refused() {
    let sheet = || Square::isotropic([4, 4]).elastic();
    let spawned = |sheet: Membrane| {
        let refused = Simulation::new(Settings::default()).unwrap().spawn(sheet);
        refused.unwrap_err()
    };
    let error = spawned(sheet().strengths(vec![1.0; 3]));
    assert_eq!(error.source, BodyError::ValueCount { what: "strengths", given: 3, needed: 32 });
    assert!(spawned(sheet().toughnesses(vec![0.0; 32])).to_string().contains("not positive and finite"));
    let strains = vec![Sym2::new(f64::NAN, 0.0, 0.0); 32];
    assert!(spawned(sheet().pre_stretches(strains)).to_string().contains("not finite"));
    let law = HolzapfelGasserOgden::symmetric(1.0, 1.0, 30.0, 0.0);
    let law = HolzapfelGasserOgden { matrix: GroundSubstance::Linear, ..law };
    let strains = vec![Sym2::new(0.1, 0.0, 0.0); 32];
    let error = spawned(sheet().with(law).pre_stretches(strains)).to_string();
    assert!(error.contains("takes one pre-stretch for the whole body"), "{error}");
}
