//! The catalog runs, and every kind of bad scene is refused with its place and a way to mend it.

use rhexis::components::{Obstacle, Shape};
use rhexis::storage::Vertices;
use rhexis_scene::{Document, Scene, SceneError, catalog};

#[test]
fn every_scene_of_the_catalog_checks_and_steps() {
    for entry in catalog::CATALOG {
        let mut document = Document::named(entry.name).unwrap();
        // The smallest meshes that the regions still fit: the physics is tested elsewhere.
        if entry.name.starts_with("capsulorhexis") {
            document.set("bodies.0.mesh.cap.triangles=1500").unwrap();
        }
        let scene = document.scene().unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(scene.name(), entry.name);
        assert!(!scene.about().is_empty() && scene.about().len() <= 90, "{}: one short line", entry.name);
        assert!(!scene.file().scene.reference.is_empty(), "{}: says where its numbers come from", entry.name);
        let summary = scene.check().unwrap_or_else(|e| panic!("{e}"));
        assert!(summary.run.steps >= 1 && summary.bodies.iter().all(|body| body.triangle_count > 0));

        let mut instance = scene.instantiate().unwrap();
        for _ in 0..3 {
            let report = instance.advance().unwrap_or_else(|e| panic!("{}: {e}", entry.name));
            assert!(!report.has_failed, "{}", entry.name);
        }
        for &body in &instance.bodies {
            let vertices = instance.simulation.world().get::<&Vertices>(body.entity()).unwrap();
            assert!(vertices.position.iter().all(|x| x.is_finite()), "{}", entry.name);
        }
    }
}

fn vertex_at(instance: &rhexis_scene::Instance, x: f64, y: f64) -> glam::DVec3 {
    let vertices = instance.simulation.world().get::<&Vertices>(instance.bodies[0].entity()).unwrap();
    let near = vertices.rest_position.iter().position(|p| (p.x - x).hypot(p.y - y) < 1e-9).unwrap();
    vertices.position[near] - vertices.rest_position[near]
}

#[test]
fn cooks_panel_lifts_by_the_listed_amount() {
    // Listed for these triangles and 1 N; the scene pulls with 0.01 N. The rest of the difference is the finite rotation of
    // 0.3 mm over 48 mm.
    for (name, listed) in [("cook", 23.736604465497233), ("cook-fibre", 5.501528302067323)] {
        let mut instance = Scene::named(name).unwrap().instantiate().unwrap();
        instance.advance().unwrap();
        let lift = vertex_at(&instance, 48.0, 52.0).y;
        assert!((lift / (0.01 * listed) - 1.0).abs() < 5e-3, "{name}: {lift}");
    }
}

#[test]
fn the_free_triangle_follows_the_listed_backward_euler_steps() {
    // reference: free_triangle.json, energy-gradient law, backward Euler, dt 0.02 ms, 100 steps; listed to rounding.
    let listed = [[0.11515982527104526, -0.07652454509021685], [1.2808132633848874, 0.19137536526485413]];
    let mut instance = Scene::named("free-triangle").unwrap().instantiate().unwrap();
    while !instance.is_finished() {
        instance.advance().unwrap();
    }
    assert_eq!(instance.step(), 100);
    let vertices = instance.simulation.world().get::<&Vertices>(instance.bodies[0].entity()).unwrap();
    for (x, listed) in vertices.position.iter().zip(listed) {
        // Newton stops at 1e-12 of the corner force in each of 100 steps.
        assert!((x.x - listed[0]).abs() < 1e-8 && (x.y - listed[1]).abs() < 1e-8, "{x}");
    }
}

#[test]
fn the_drum_swings_about_its_deflection() {
    // From rest under a sudden pressure the centre swings between 0 and about twice w0 = 0.01125 mm.
    let mut instance = Scene::named("drum").unwrap().instantiate().unwrap();
    let mut highest = 0.0_f64;
    for _ in 0..250 {
        instance.advance().unwrap();
        highest = highest.max(vertex_at(&instance, 0.0, 0.0).z);
    }
    // Higher modes add up to a tenth; 1.6 and 2.2 bracket one swing of a membrane.
    assert!((1.6..2.2).contains(&(highest / 0.01125)), "{highest}");
}

/// A scene that is right, with marks to break it at.
pub const SOUND: &str = r#"[scene]
name = "strip"

[run]
dt = 10
steps = 2

[[bodies]]
name = "tissue"
planar = true
mesh = { grid = { width = 4, height = 2, nx = 4, ny = 2 } }
material = { young_fibre = 10, young_transverse = 1, poisson_major = 0.3, thickness = 0.1 }
tearing = { strength_along_fibres = 0.1, strength_ratio = 2, radius = 0.5 }
holds = [
    { name = "left", region = { x = 0 } },
    { name = "right", region = { x = 4 }, move = { offset = [1, 0] }, curve = [[0, 0], [10, 1]] },
]
"#;

fn refusal(text: &str) -> SceneError {
    match Scene::parse(text, "strip.toml").and_then(|scene| scene.check()) {
        Ok(_) => panic!("not refused:\n{text}"),
        Err(error) => error,
    }
}

#[test]
fn a_rectangle_comes_in_every_pattern() {
    let corners = "corners = [[0, 0], [4, 0], [4, 2], [0, 2]], edge = 0.5";
    let jittered = "jittered = { width = 4, height = 2, nx = 8, ny = 4, seed = 7 }".to_owned();
    for mesh in
        [jittered, format!("lattice = {{ {corners}, degrees = 15 }}"), format!("unstructured = {{ {corners} }}")]
    {
        let text = SOUND.replacen("grid = { width = 4, height = 2, nx = 4, ny = 2 }", &mesh, 1);
        let body = &Scene::parse(&text, "strip.toml").unwrap().check().unwrap().bodies[0];
        assert_eq!((body.bounds.1, body.holds[0].1), (glam::DVec3::new(4.0, 2.0, 0.0), 5), "{mesh}");
    }
    let error = refusal(&SOUND.replace(
        "grid = { width = 4, height = 2, nx = 4, ny = 2 }",
        "lattice = { corners = [[0, 0], [4, 0]], edge = 1, degrees = 0 }",
    ));
    assert!(error.what.contains("outline has fewer than three corners") && error.hint.contains("in order"), "{error}");
}

#[test]
fn a_bad_scene_is_refused_with_line_reason_and_remedy() {
    assert!(Scene::parse(SOUND, "strip.toml").unwrap().check().is_ok());
    // (replace, by, line, in the message, in the hint)
    let cases = [
        ("young_fibre", "yuong_fibre", 12, "unknown key `yuong_fibre`", "did you mean `young_fibre`?"),
        ("young_fibre = 10", "young_fibre = -10", 12, "-10 MPa is not above zero", "above zero"),
        ("poisson_major = 0.3", "poisson_major = 3.5", 12, "ν_F²·E_T/E_F = 1.2", "|poisson_major| < 3.16"),
        ("poisson_major = 0.3", "poisson_major = nan", 12, "not a finite number", "ordinary number"),
        ("poisson_major = 0.3, ", "", 12, "incomplete or mixed", "`young` and `poisson`"),
        ("thickness = 0.1", "thickness = 1e999", 12, "not a finite number", ""),
        ("thickness = 0.1", "thickness = \"thin\"", 12, "invalid type: string", ""),
        ("grid = { width = 4, height = 2, nx = 4, ny = 2 }", "file = { path = \"no.vtu\" }", 11, "no.vtu", "path"),
        ("grid = { width = 4", "grid = { width = 0", 11, "width is 0 mm", ""),
        ("grid =", "gird =", 11, "unknown value `gird`", "did you mean `grid`?"),
        (
            "grid = { width = 4, height = 2, nx = 4, ny = 2 }",
            "inline = { positions = [[0, 0], [1, 0], [2, 0]], triangles = [[0, 1, 2]] }",
            11,
            "degenerate",
            "collapse",
        ),
        (
            "grid = { width = 4, height = 2, nx = 4, ny = 2 }",
            "inline = { positions = [[0, 0], [1, 0], [0, 1]], triangles = [[0, 1, 7]] }",
            11,
            "names vertex 7",
            "correct the index",
        ),
        (
            "grid = { width = 4, height = 2, nx = 4, ny = 2 }",
            "inline = { positions = [], triangles = [] }",
            11,
            "no vertices",
            "surface of triangles",
        ),
        ("region = { x = 0 }", "region = { x = 9 }", 15, "the body spans x 0 to 4, y 0 to 2", "tolerance"),
        ("region = { x = 0 }", "region = { }", 15, "says nothing", "all = true"),
        ("region = { x = 0 }", "region = { x = [0, 4] }", 16, "both prescribe x of vertex 4", "disjoint"),
        ("name = \"right\"", "name = \"left\"", 16, "taken by entry 0", "a name of its own"),
        ("{ x = 0 } }", "{ x = 0 }, axes = \"xw\" }", 15, "`xw` names no axes", "xyz"),
        ("[[0, 0], [10, 1]]", "[[0, 0], [0, 1]]", 16, "time must be larger", "ascending"),
        ("offset = [1, 0]", "offset = [1]", 16, "not a point", "[x, y]"),
        ("radius = 0.5", "radius = -0.5", 13, "-0.5 mm is not above zero", "above zero"),
        ("strength_ratio = 2, ", "", 13, "not at all", "`strength_across_fibres` or `strength_ratio`"),
        (
            "strength_ratio = 2",
            "toughness_along_fibres = 0.1",
            13,
            "incomplete or mixed",
            "both of `toughness_along_fibres`",
        ),
        (
            "strength_along_fibres = 0.1, strength_ratio = 2",
            "toughness_along_fibres = 0.1",
            13,
            "incomplete or mixed",
            "follows from the other",
        ),
        (
            "strength_along_fibres = 0.1, strength_ratio = 2",
            "toughness_along_fibres = 0.1, toughness_across_fibres = 0",
            13,
            "0 N/mm is not above zero",
            "above zero",
        ),
        ("holds = [", "cuts = [{ polyline = [[1, 1]] }]\nholds = [", 14, "no line", "two or more points"),
        (
            "holds = [",
            "cuts = [{ polyline = [[9, 9], [9, 8]] }]\nholds = [",
            14,
            "the cut was refused",
            "onto the body",
        ),
        (
            "holds = [",
            "cuts = [{ polyline = [[2, 0, 9], [2, 1, 9]] }]\nholds = [",
            14,
            "9 mm off the body",
            "onto the body",
        ),
        (
            "holds = [",
            "springs = [{ region = { x = 0 }, total = 1, per_area = 1 }]\nholds = [",
            14,
            "twice or not at all",
            "`total` [N/mm] or `per_area`",
        ),
        (
            "planar = true\n",
            "planar = true\ninitial = { spin = [1, 0, 0] }\n",
            11,
            "would leave its plane",
            "spin about z",
        ),
        ("steps = 2", "steps = 2\nduration = 5", 4, "given twice or not at all", "either `steps` or `duration`"),
        ("dt = 10\n", "", 4, "`dt` is missing", "add `dt = "),
        ("dt = 10", "dt = 0", 5, "0 ms is not above zero", "above zero"),
        ("dt = 10", "dt = = 10", 5, "", ""),
        ("[run]", "[run", 4, "", ""),
        ("thickness = 0.1", "thickness = 1e200", 12, "out of scale", "ordinary"),
        ("thickness = 0.1", "thickness = 1e-300", 8, "the mass of a triangle", "ordinary size"),
        (
            "planar = true\n",
            "planar = true\ninitial = { spin = [0, 0, 1e140], stretch = [[1e140, 0, 0], [0, 1, 0], [0, 0, 1]] }\n",
            11,
            "too large",
            "ordinary",
        ),
        ("nx = 4", "nx = -1", 11, "integer `-1`", "whole number"),
        ("nx = 4", "nx = 99999999999999999999", 11, "invalid", "whole number"),
        ("mesh = { grid = { width = 4, height = 2, nx = 4, ny = 2 } }", "mesh = 5", 11, "several kinds", "--show"),
        ("grid = { width = 4, height = 2, nx = 4, ny = 2 }", "file = 5", 11, "integer `5`", "a path in quotes"),
        ("grid = { width = 4, height = 2, nx = 4, ny = 2 }", "file = { pat = \"x.obj\" }", 11, "unknown key", "`path`"),
        (
            "grid = { width = 4, height = 2, nx = 4, ny = 2 }",
            "inline = { positions = [[0, 0], [1, 0], [1, 1], [0, 1]], triangles = [[0, 1, 2, 3], [0, 2, 3]] }",
            11,
            "a list of 4",
            "exactly 3",
        ),
        ("planar = true\n", "planar = true\npressure = 1\n", 11, "pressure", "remove one"),
        ("name = \"tissue\"", "name = \" \"", 9, "empty", "name of its own"),
        ("name = \"left\"", "name = \"\"", 15, "empty", "name of its own"),
        ("holds = [", "[[bodies]]\nname = \"tissue\"\nholds = [", 14, "`mesh` is missing", "add"),
        ("steps = 2", "duration = 1e100", 6, "more than 1000000000 steps", "larger dt"),
        ("steps = 2", "steps = 2000000000", 6, "more than 1000000000 steps", "fewer"),
        ("steps = 2", "steps = 2\nadvanced.newton_iterations = 1000000", 7, "too many", "1000 at most"),
    ];
    for (from, to, line, what, hint) in cases {
        let text = SOUND.replacen(from, to, 1);
        assert_ne!(text, SOUND, "{from} is not in the scene");
        let error = refusal(&text);
        let shown = error.to_string();
        assert_eq!(error.position.map(|p| p.0), Some(line), "{to}: {shown}");
        assert!(shown.starts_with(&format!("strip.toml:{line}:")), "{shown}");
        assert!(error.what.contains(what), "{to}: {shown}");
        assert!(error.hint.contains(hint), "{to}: {shown}");
    }
}

/// The one limit that `inf` takes away, as its description says.
#[test]
fn an_infinite_stress_tolerance_asks_for_none() {
    let with = |value: &str| {
        let text = SOUND.replacen("steps = 2", &format!("steps = 2\nadvanced.stress_tolerance = {value}"), 1);
        Scene::parse(&text, "strip.toml").and_then(|scene| scene.instantiate())
    };
    let mut instance = with("inf").unwrap();
    assert_eq!(instance.simulation.settings().advanced.linear.stress_tolerance, f64::INFINITY);
    assert!(!instance.advance().unwrap().has_failed);
    for value in ["-inf", "nan", "0.0", "-1.0"] {
        let error = with(value).err().unwrap();
        assert_eq!(error.position.map(|place| place.0), Some(7), "{error}");
    }
    let mut document = Document::new(SOUND, "strip.toml");
    document.set("run.advanced.stress_tolerance=inf").unwrap();
    document.scene().unwrap().instantiate().unwrap();
}

#[test]
fn columns_point_at_the_key() {
    let error = refusal(&SOUND.replacen("young_fibre = 10", "young_fibre = -1", 1));
    assert_eq!((error.position, error.key.as_str()), (Some((12, 14)), "bodies.0.material.young_fibre"));
}

#[test]
fn a_name_that_is_nearly_right_is_suggested() {
    let error = Scene::named("fig2-tare").unwrap_err();
    assert!(error.hint.contains("did you mean `fig2-tear`?"), "{error}");
    assert!(Document::open("no/such/file.toml").unwrap_err().what.contains("cannot be read"));
}

#[test]
fn files_are_looked_for_beside_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    let grid = "grid = { width = 4, height = 2, nx = 4, ny = 2 }";
    let text = SOUND.replacen(grid, "file = { path = \"mesh.obj\", scale = 2 }", 1);
    std::fs::write(&scene, text.replace("x = 4", "x = 8")).unwrap();
    std::fs::write(folder.path().join("mesh.obj"), "v 0 0 0\nv 4 0 0\nv 4 2 0\nv 0 2 0\nf 1 2 3\nf 1 3 4\n").unwrap();
    let summary = Scene::load(&scene).unwrap().check().unwrap();
    assert_eq!(summary.bodies[0].bounds.1, glam::DVec3::new(8.0, 4.0, 0.0));
    // The path alone will do where the file is in mm.
    let short = SOUND.replacen(grid, "file = \"mesh.obj\"", 1);
    std::fs::write(&scene, &short).unwrap();
    let summary = Scene::load(&scene).unwrap().check().unwrap();
    assert_eq!(summary.bodies[0].bounds.1, glam::DVec3::new(4.0, 2.0, 0.0));
    let error = Scene::load(&folder.path().join("mesh.obj")).unwrap_err();
    assert!(error.what.contains("is a mesh") && error.hint.contains("file = \"mesh.obj\""), "{error}");
    std::fs::write(folder.path().join("mesh.obj"), "v 0 0 0\nf 1 2 3\n").unwrap();
    let error = Scene::load(&scene).unwrap().check().unwrap_err();
    assert!(error.what.contains("mesh.obj") && error.position.is_some_and(|p| p.0 == 11), "{error}");
}

/// A scene with these lines under `[[obstacles]]`, the first of which is line 20.
fn with_obstacle(lines: &str) -> String {
    format!("{SOUND}\n[[obstacles]]\n{lines}\n")
}

#[test]
fn an_obstacle_goes_its_path() {
    let text =
        with_obstacle("sphere = { centre = [2, 1, -1], radius = 0.5 }\npath = [[0, [0, 0, 0]], [20, [0, 0, 4]]]");
    let mut instance = Scene::parse(&text, "strip.toml").unwrap().instantiate().unwrap();
    for centre in [1.0, 3.0] {
        instance.advance().unwrap();
        let mut found =
            instance.simulation.world().query::<&Obstacle>().iter().map(|o| o.shape.clone()).collect::<Vec<_>>();
        let centre = glam::DVec3::new(2.0, 1.0, centre);
        assert_eq!(found.pop(), Some(Shape::Sphere { centre, radius: 0.5 }));
    }
    let sphere = "sphere = { centre = [0, 0, 0], radius = 1 }";
    for (lines, line, what, hint) in [
        ("path = [[0, [0, 0, 0]]]", 19, "an obstacle has one shape", "exactly one"),
        (&format!("{sphere}\nplane = {{ point = [0, 0, 0], normal = [0, 0, 1] }}"), 19, "one shape", "exactly one"),
        (&format!("{sphere}\npath = [[0, [0, 0, 0]], [0, [1, 0, 0]]]"), 21, "time must be larger", "ascending"),
        (&format!("{sphere}\npath = [[0, 1], [1, 2]]"), 21, "not a path", "[[time, [x, y, z]], …]"),
        (&format!("{sphere}\npath = []"), 21, "at least one point", "[[time, [x, y, z]], …]"),
        (&format!("{sphere}\npaht = [[0, [0, 0, 0]]]"), 21, "unknown key `paht`", "did you mean `path`?"),
    ] {
        let error = refusal(&with_obstacle(lines));
        let told = error.to_string();
        assert!(told.contains(what) && told.contains(hint), "{lines}: {told}");
        assert!(told.contains(&format!("strip.toml:{line}")), "{lines}: {told}");
    }
}

#[test]
fn hostile_text_is_refused_not_survived_by_luck() {
    let deep_list = format!("x = {}{}", "[".repeat(100_000), "]".repeat(100_000));
    let deep_table = format!("x = {}1{}", "{ a = ".repeat(100_000), " }".repeat(100_000));
    let deep_key = format!("{}x = 1", "a.".repeat(100_000));
    for text in ["", "\0", "[scene]", "bodies = 3", "[[bodies]]", &deep_list, &deep_table, &deep_key] {
        let error = refusal(text);
        assert!(!error.what.is_empty());
    }
}

#[test]
fn copies_have_names_of_their_own_and_sleep_has_bounds() {
    let summary = Scene::named("many").unwrap().check().unwrap();
    let names: Vec<&str> = summary.bodies.iter().map(|body| body.name.as_str()).collect();
    assert_eq!((names.len(), names[0], names[63]), (64, "pulled-1", "resting-60"));
    for (assignment, key) in [
        ("bodies.0.copies=0", "bodies.0.copies"),
        ("bodies.1.copies=10001", "bodies.1.copies"),
        ("bodies.1.name=pulled", "bodies.1"),
        ("bodies.0.sleep.strain=0", "bodies.0.sleep.strain"),
        ("bodies.0.sleep.steps=0", "bodies.0.sleep.steps"),
    ] {
        let mut document = Document::named("many").unwrap();
        document.set(assignment).unwrap();
        let error = document.scene().unwrap().check().unwrap_err();
        assert!(error.key.starts_with(key) && !error.hint.is_empty(), "{assignment}: {error}");
    }
}
