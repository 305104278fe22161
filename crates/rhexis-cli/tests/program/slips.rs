//! Slips that are read without an error and spoil a run are told by the check, each with its own remedy; intended values can be allowed.

use rhexis::components::{Hold, Material};
use rhexis::membrane::Membrane;
use rhexis::settings::Settings;
use rhexis::simulation::{DoubtKind, Simulation};
use rhexis_scene::{Document, Scene, catalog};
use std::process::Command;

/// The scene of the tutorial on a mesh of its own.
const SCENE: &str = r#"
[scene]
name = "my"

[run]
dt = 10
duration = 2000
until_torn = true

[output]
pictures = 0

[[bodies]]
name = "tissue"
mesh = { grid = { width = 30, height = 30, nx = 24, ny = 24 } }
material = { young_fibre = 10, young_transverse = 1, poisson_major = 0.3, shear_modulus = 0.5, thickness = 0.1 }
fibres = { degrees = 60 }
planar = true
damping = 0.1

[bodies.tearing]
strength_along_fibres = 0.05
strength_across_fibres = 0.8
radius = 4
may_initiate = false

[[bodies.cuts]]
polyline = [[15, 32], [15, 27]]

[[bodies.holds]]
name = "left"
region = { x = [-1, 0.5] }
move = { offset = [-1, 0, 0] }
curve = [[0, 0], [2000, 8]]

[[bodies.holds]]
name = "right"
region = { x = [29.5, 31] }
move = { offset = [1, 0, 0] }
curve = [[0, 0], [2000, 8]]
"#;

/// The scene with texts in place of others.
fn changed(changes: &[(&str, &str)]) -> String {
    changes.iter().fold(SCENE.to_owned(), |text, (old, new)| {
        assert!(text.contains(old), "{old}");
        text.replace(old, new)
    })
}

fn doubts(text: &str) -> Vec<(DoubtKind, String)> {
    let summary = Scene::parse(text, "my.toml").unwrap().check().unwrap();
    summary.doubts.into_iter().map(|doubt| (doubt.kind, doubt.text)).collect()
}

#[test]
fn each_slip_is_told_with_its_remedy() {
    let without_holds = SCENE.split("[[bodies.holds]]").next().unwrap();
    let in_metres = [
        ("width = 30, height = 30", "width = 0.03, height = 0.03"),
        ("[[15, 32], [15, 27]]", "[[0.015, 0.032], [0.015, 0.027]]"),
        ("[-1, 0.5]", "[-1, 0.0005]"),
        ("[29.5, 31]", "[0.0295, 31]"),
    ];
    let cases: &[(&str, DoubtKind, &str)] = &[
        (&changed(&[("young_fibre = 10,", "young_fibre = 10e6,")]), DoubtKind::Stiffness, "MPa, 1e6 Pa"),
        (&changed(&[("young_fibre = 10,", "young_fibre = 50e3,")]), DoubtKind::Stiffness, "MPa, 1e6 Pa"),
        (&changed(&[("thickness = 0.1", "thickness = 0.1, density = 1000")]), DoubtKind::Density, "1e-3 (1000 kg/m³)"),
        (&changed(&[("thickness = 0.1", "thickness = 0.1, density = 1")]), DoubtKind::Density, "1e-3 (1000 kg/m³)"),
        (&changed(&[("damping = 0.1", "gravity = [0, -9.81, 0]")]), DoubtKind::Gravity, "9.81e-3"),
        (&changed(&[("damping = 0.1", "gravity = [0, -9.81e-6, 0]")]), DoubtKind::Gravity, "9.81e-3"),
        (&changed(&[("[2000, 8]", "[2, 8]")]), DoubtKind::HastyMotion, "times of curves are in ms"),
        (&changed(&[("[2000, 8]", "[1, 0.5]")]), DoubtKind::HastyMotion, "times of curves are in ms"),
        (
            &changed(&[("duration = 2000", "duration = 2"), ("dt = 10", "dt = 0.5")]),
            DoubtKind::ShortRun,
            "both are in ms",
        ),
        (&changed(&[("dt = 10", "dt = 0.01")]), DoubtKind::TimeStep, "a frame at 60 Hz is 16.7"),
        (&changed(&[("dt = 10", "dt = 0.016")]), DoubtKind::TimeStep, "a frame at 60 Hz is 16.7"),
        (without_holds, DoubtKind::NoHolds, "give it a hold"),
        (&changed(&[("radius = 4", "radius = 0.3")]), DoubtKind::Radius, "a finer mesh"),
        (&changed(&[("radius = 4", "radius = 400")]), DoubtKind::Radius, "it is in mm"),
        (&changed(&in_metres), DoubtKind::Size, "lengths are in mm"),
        (&changed(&[("thickness = 0.1", "thickness = 100")]), DoubtKind::Thickness, "1e3 µm"),
        (&changed(&[("thickness = 0.1", "thickness = 1e-5")]), DoubtKind::Thickness, "1e-3 m"),
        (
            &changed(&[("strength_along_fibres = 0.05", "strength_along_fibres = 5e4"), ("= 0.8", "= 8e5")]),
            DoubtKind::Strength,
            "MPa, 1e6 Pa",
        ),
        (&changed(&[("planar = true", "bending = {}\npressure = 2000")]), DoubtKind::Pressure, "1 kPa 1e-3"),
    ];
    for (text, kind, remedy) in cases {
        let found = doubts(text);
        assert!(found.iter().any(|(found, text)| found == kind && text.contains(remedy)), "{kind:?}: {found:#?}");
        // Allowed, it is told no more; nothing else is told in its place.
        let allowed = text.replace("name = \"my\"", &format!("name = \"my\"\nallow = [\"{}\"]", kind.name()));
        assert!(doubts(&allowed).iter().all(|(found, _)| found != kind));
    }
    assert_eq!(doubts(SCENE), []);
}

#[test]
fn a_body_that_is_held_everywhere_or_off_its_plane_is_told() -> rhexis::Result<()> {
    let mut mesh = rhexis::generate::grid(10.0, 10.0, 4, 4)?;
    mesh.positions[12].z = 0.1;
    let sheet = Membrane::new("sheet", mesh, Material::allard_2009()).planar().hold(Hold::new("all", 0..25));
    let mut simulation = Simulation::new(Settings::default())?;
    let body = simulation.spawn(sheet)?;
    let doubts = simulation.doubts(16.0, None);
    let kinds: Vec<_> = doubts.iter().map(|doubt| (doubt.kind, doubt.body)).collect();
    assert_eq!(kinds, [(DoubtKind::OffPlane, Some(body)), (DoubtKind::AllHeld, Some(body))]);
    assert!(doubts[0].text.contains("up to 0.1 mm off its plane"), "{}", doubts[0].text);
    Ok(())
}

#[test]
fn all_slips_of_a_scene_are_told_at_once() {
    let text =
        changed(&[("young_fibre = 10,", "young_fibre = 10e6,"), ("dt = 10", "dt = 0.01"), ("[2000, 8]", "[2, 8]")]);
    let kinds: Vec<DoubtKind> = doubts(&text).into_iter().map(|(kind, _)| kind).collect();
    let hasty = DoubtKind::HastyMotion;
    assert_eq!(kinds, [DoubtKind::TimeStep, DoubtKind::Stiffness, hasty, hasty]);
}

#[test]
fn no_scene_of_the_catalog_is_doubted() {
    for entry in catalog::CATALOG {
        let scene = Document::named(entry.name).unwrap().scene().unwrap();
        assert_eq!(scene.check().unwrap().doubts, [], "{}", entry.name);
    }
}

#[test]
fn a_message_points_where_the_mistake_is() {
    let cases = [
        (changed(&[("planar = true", "planar = true\nbending = {}")]), "does not bend", "take out `planar = true`"),
        (changed(&[("[[bodies.holds]]", "[[bodies.fixed]]")]), "`fixed`", "[[bodies.holds]]"),
        (changed(&[("pictures = 0", "every = 100")]), "`every`", "`frames_every`"),
        (changed(&[("damping = 0.1", "gravity = -9.81")]), "in place of a vector", "[0, 0, -9.81e-3]"),
        (changed(&[("width = 30, height = 30", "width = 0.03, height = 0.03")]), "selects no vertex", "unit = \"m\""),
        (changed(&[("name = \"my\"", "name = \"my\"\nallow = [\"radii\"]")]), "no doubt `radii`", "radius"),
    ];
    for (text, what, hint) in cases {
        let error = Scene::parse(&text, "my.toml").and_then(|scene| scene.check()).unwrap_err();
        assert!(error.what.contains(what) && error.hint.contains(hint), "{error}");
        assert!(error.position.is_some(), "{error}");
    }
}

#[test]
fn contacts_that_are_not_asked_for_are_told() {
    let not_felt = |text: &str| Scene::parse(text, "my.toml").unwrap().check().unwrap().not_felt;
    assert_eq!(not_felt(SCENE), Vec::<String>::new());
    let in_space = changed(&[("planar = true", "bending = {}")]);
    assert!(not_felt(&in_space)[0].contains("its own layers by `tissue`"));
    let ball = format!("{in_space}[[obstacles]]\nsphere = {{ centre = [15, 15, -3], radius = 2 }}\n");
    assert!(not_felt(&ball)[0].contains("obstacles by `tissue`: `contact = {}`"));
    let felt = ball.replace("bending = {}", "bending = {}\ncontact = { self_contact = { radius = 0.1 } }");
    assert_eq!(not_felt(&felt), Vec::<String>::new());
    let two = felt.clone()
        + "[[bodies]]\nname = \"other\"\nplanar = true\nmesh = { grid = { width = 9, height = 9, nx = 3, ny = 3 } }\n\
         material = { young = 1, poisson = 0.3, thickness = 0.1 }\ncontact = {}\n";
    assert!(not_felt(&two)[0].contains("other bodies by"));
}

#[test]
fn a_cut_that_holds_refuse_names_the_holds() {
    let folder = tempfile::tempdir().unwrap();
    let rhexis = |arguments: &[&str]| {
        Command::new(env!("CARGO_BIN_EXE_rhexis")).current_dir(folder.path()).args(arguments).output().unwrap()
    };
    // The surface of the tutorial, whose vertices do not stand in rows.
    assert!(rhexis(&["run", "fig2", "--steps", "1", "--set", "output.obj=true", "--out", "."]).status.success());
    let held = [
        ("grid = { width = 30, height = 30, nx = 24, ny = 24 }", "file = \"surface-0.obj\""),
        ("[-1, 0.5]", "[-1, 15]"),
        ("[29.5, 31]", "[15.1, 31]"),
    ];
    std::fs::write(folder.path().join("my.toml"), changed(&held)).unwrap();
    let output = rhexis(&["check", "my.toml"]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(!output.status.success() && said.contains("holds keep 793 of 806 vertices"), "{said}");
}
