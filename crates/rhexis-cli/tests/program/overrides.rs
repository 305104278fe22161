//! `--set`: what it changes, and whom its errors blame.

use super::scenes::SOUND;
use rhexis_scene::Document;
use rhexis_scene::schema::Mode;

#[test]
fn overrides_are_judged_like_the_file() {
    let set = |assignments: &[&str]| {
        let mut document = Document::new(SOUND, "strip.toml");
        assignments.iter().try_for_each(|a| document.set(a))?;
        document.scene().and_then(|scene| scene.check())
    };
    let summary = set(&["run.dt=5", "run.steps = 7", "bodies.0.mesh.grid.nx=8", "run.mode=static"]).unwrap();
    assert_eq!((summary.run.dt, summary.run.steps, summary.run.mode), (5.0, 7, Mode::Static));
    assert_eq!(summary.bodies[0].triangle_count, 32);
    // A table that the file does not have is made.
    assert!(set(&["output.pictures=0", "bodies.0.holds.0.curve=[[0, 0], [5, 1]]"]).is_ok());

    let refused = |assignment: &str| set(&["run.steps=3", assignment]).unwrap_err();
    for (assignment, what, hint) in [
        ("run.td=5", "unknown key `td`", "valid keys here: mode, dt, steps"),
        ("bodies.0.tearing.radios=1", "unknown key `radios`", "did you mean `radius`?"),
        ("bodies.3.planar=true", "`bodies` has the entries 0 to 0", "bodies.0"),
        ("run.dt.x=1", "`run.dt` is a single value", "leave out"),
        ("run.dt=-5", "-5 ms is not above zero", "above zero"),
        ("run.dt=inf", "not a finite number", "ordinary"),
        ("run.dt=soon", "invalid type: string", ""),
        ("bodies.0.holds.0.region={ x = 99 }", "selects no vertex", "tolerance"),
        ("run", "not of the form key=value", "--set run.dt=5"),
        ("=5", "not of the form key=value", "--set run.dt=5"),
    ] {
        let error = refused(assignment);
        assert!(error.what.contains(what) && error.hint.contains(hint), "{assignment}: {error}");
        assert!(error.origin.starts_with("--set ") && error.position.is_none(), "{assignment}: {error}");
        assert!(error.origin.contains(assignment.split('=').next().unwrap()), "{error}");
    }
    // What is found at a key above the one that was set, or at another, is still the override's fault.
    for (assignment, what) in [
        ("bodies.0.mesh.grid.nx=0", "the number of cells along x is 0"),
        ("bodies.0.mesh.grid.nx=abc", "invalid type"),
        ("bodies.0.mesh.grid.nx=90000000", "triangles"),
        ("bodies.0.material.young=5", "incomplete or mixed"),
        ("run.duration=5", "given twice"),
        ("scene.preset=none", "no preset `none`"),
        ("bodies.0.holds.0.region.x=77", "selects no vertex"),
        ("bodies.0.holds.0.name=right", "is taken by entry 0"),
        ("bodies.0.tearing.strength_across_fibres=5", "given twice"),
        ("bodies.0.copies=4000000000", "bodies, copies counted"),
    ] {
        // Others stand before and behind it.
        let error = set(&["run.accuracy=fast", assignment, "run.advanced.max_step_halvings=3"]).unwrap_err();
        assert_eq!((error.origin.as_str(), error.position), (&*format!("--set {assignment}"), None), "{error}");
        assert!(error.what.contains(what), "{error}");
    }
    // What was wrong before is not.
    let mut document = Document::new(SOUND.replacen("nx = 4", "nx = 0", 1), "strip.toml");
    document.set("bodies.0.mesh.grid.ny=3").unwrap();
    let error = document.scene().unwrap().check().unwrap_err();
    assert_eq!((error.origin.as_str(), error.position.map(|place| place.0)), ("strip.toml", Some(11)), "{error}");
    let deep = format!("{}x=1", "a.".repeat(100_000));
    assert!(refused(&deep).what.contains("key=value"));
}
