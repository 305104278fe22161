//! What a run reads is what it was and stays what it is: changed inputs of a run that goes on, outputs in the place of inputs.

use std::path::Path;
use std::process::{Command, Output, Stdio};

fn rhexis(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rhexis"));
    command.current_dir(folder).args(arguments).stdin(Stdio::null()).output().unwrap()
}

fn outcome(folder: &Path, arguments: &[&str], code: i32) -> String {
    let output = rhexis(folder, arguments);
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {error}");
    error
}

const SCENE: &str = r#"
[scene]
name = "mine"
[run]
dt = 10.0
steps = 6
[output]
pictures = 0
frames = 0
[[bodies]]
name = "tissue"
planar = true
mesh = { file = "sheet.obj" }
fibres = { file = "fibres.txt" }
material = { young_fibre = 10, young_transverse = 1, poisson_major = 0.3, thickness = 0.1 }
holds = [
    { name = "left", region = { x = 0 } },
    { name = "right", region = { x = 2 }, move = { offset = [0.1, 0] }, curve = [[0, 0], [500, 1]] },
]
"#;

const MESH: &str = "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\nf 1 2 5 4\nf 2 3 6 5\n";

/// A scene with a mesh and a fibre file in a directory of their own.
fn scene() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [("mine.toml", SCENE), ("sheet.obj", MESH), ("fibres.txt", "1 0 0\n1 0 0\n1 0 0\n1 0 0\n")] {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

#[test]
fn a_run_goes_on_only_with_the_files_that_it_began_with() {
    let folder = scene();
    let base = ["run", "mine.toml", "--quiet", "--snapshots", "2", "--out", "o"];
    outcome(folder.path(), &[&base[..], &["--steps", "3"]].concat(), 0);
    let go_on = [&base[..], &["--resume"]].concat();
    let changes = [
        ("sheet.obj", MESH.replace("v 1 1 0", "v 1.1 1 0")),
        ("fibres.txt", "1 0 0\n1 0 0\n1 0 0\n0 1 0\n".to_owned()),
        // As another triangulation with fewer vertices: nothing that the snapshot itself could tell of is looked at before.
        ("sheet.obj", "v 0 0 0\nv 2 0 0\nv 0 1 0\nf 1 2 3\n".to_owned()),
        ("mine.toml", SCENE.replace("young_fibre = 10", "young_fibre = 11")),
    ];
    for (name, changed) in changes {
        let path = folder.path().join(name);
        let before = std::fs::read_to_string(&path).unwrap();
        assert_ne!(before, changed);
        std::fs::write(&path, changed).unwrap();
        let error = outcome(folder.path(), &go_on, 1);
        let is_named = error.contains(&format!("{name} has changed")) || error.contains("scene file, --set");
        assert!(is_named && error.contains("put it back") && error.contains("without --resume"), "{name}: {error}");
        std::fs::write(&path, before).unwrap();
    }
    // A comment is no change.
    std::fs::write(folder.path().join("mine.toml"), format!("# mine\n{SCENE}")).unwrap();
    outcome(folder.path(), &go_on, 0);
}

/// A glTF file of triangles whose corners lie in a buffer beside it.
fn gltf(buffer: &str, corners: &[[f32; 3]]) -> (String, Vec<u8>) {
    let (count, size) = (corners.len(), 12 * corners.len());
    let text = format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\"scene\":0,\"scenes\":[{{\"nodes\":[0]}}],\"nodes\":[{{\"mesh\":0}}],\
         \"meshes\":[{{\"primitives\":[{{\"attributes\":{{\"POSITION\":0}}}}]}}],\
         \"accessors\":[{{\"bufferView\":0,\"componentType\":5126,\"count\":{count},\"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[9,9,9]}}],\
         \"bufferViews\":[{{\"buffer\":0,\"byteLength\":{size}}}],\"buffers\":[{{\"byteLength\":{size},\"uri\":\"{buffer}\"}}]}}"
    );
    (text, corners.as_flattened().iter().flat_map(|number| number.to_le_bytes()).collect())
}

#[test]
fn a_run_goes_on_only_with_the_buffers_of_its_gltf_files() {
    let folder = tempfile::tempdir().unwrap();
    let square = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let (text, corners) = gltf("sheet.bin", &square);
    std::fs::write(folder.path().join("sheet.gltf"), text).unwrap();
    std::fs::write(folder.path().join("sheet.bin"), &corners).unwrap();
    let (apex, a, b, c) = ([1.0, 0.5, -1.0], [0.0, 0.0, -2.0], [2.0, 0.0, -2.0], [1.0, 2.0, -2.0]);
    let (text, solid) = gltf("tool.bin", &[a, c, b, a, b, apex, b, c, apex, c, a, apex]);
    std::fs::write(folder.path().join("tool.gltf"), text).unwrap();
    std::fs::write(folder.path().join("tool.bin"), &solid).unwrap();
    let file = SCENE.replace("\"sheet.obj\"", "{ path = \"sheet.gltf\", unit = \"mm\" }");
    let file = file.replace("fibres = { file = \"fibres.txt\" }\n", "");
    let tool = "[[obstacles]]\nname = 'tool'\nmesh = { file = { path = 'tool.gltf' } }\n";
    std::fs::write(folder.path().join("mine.toml"), format!("{file}{tool}")).unwrap();
    let base = ["run", "mine.toml", "--quiet", "--snapshots", "2", "--out", "o"];
    outcome(folder.path(), &[&base[..], &["--steps", "3"]].concat(), 0);
    let go_on = [&base[..], &["--resume"]].concat();
    for (name, bytes) in [("sheet.bin", &corners), ("tool.bin", &solid)] {
        let mut changed = bytes.clone();
        // The lowest bit of a coordinate.
        changed[12] ^= 1;
        std::fs::write(folder.path().join(name), changed).unwrap();
        let error = outcome(folder.path(), &go_on, 1);
        assert!(error.contains(&format!("{name} has changed")), "{error}");
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    outcome(folder.path(), &go_on, 0);
    // The tool's unit is that of its format, which its scene does not confirm.
    let report = std::fs::read_to_string(folder.path().join("o/report.json")).unwrap();
    assert!(report.contains("tool: the mesh is taken in metres, as glTF has it"), "{report}");
    let confirmed = tool.replace("'tool.gltf'", "'tool.gltf', unit = 'mm'");
    std::fs::write(folder.path().join("mine.toml"), format!("{file}{confirmed}")).unwrap();
    let check = rhexis_scene::Scene::load(&folder.path().join("mine.toml")).unwrap().check().unwrap();
    assert!(!check.to_string().contains("in metres"), "{check}");
}

#[test]
fn a_run_does_not_go_on_to_fewer_steps_than_it_has_done() {
    let folder = scene();
    outcome(folder.path(), &["run", "mine.toml", "--quiet", "--snapshots", "2"], 0);
    let error = outcome(folder.path(), &["run", "mine.toml", "--quiet", "--resume", "--steps", "5"], 1);
    assert!(error.contains("has done 6 steps, more than 5") && error.contains("--steps"), "{error}");
    let error = outcome(folder.path(), &["replay", "gone.rec"], 1);
    assert_eq!(error.matches("gone.rec").count(), 1, "{error}");
    assert!(error.contains("--record"), "{error}");
}

#[test]
fn no_output_takes_the_place_of_an_input() {
    let folder = scene();
    let at = |name: &str| folder.path().join(name);
    std::fs::create_dir(at("frames")).unwrap();
    // The mesh is a frame of an earlier run, the fibres lie where a dump goes.
    std::fs::copy(at("sheet.obj"), at("frames/sheet.obj")).unwrap();
    std::fs::create_dir(at("dump")).unwrap();
    std::fs::copy(at("fibres.txt"), at("dump/tips.csv")).unwrap();
    let dumped = SCENE.replace("fibres.txt", "dump/tips.csv");
    std::fs::write(at("dumped.toml"), dumped).unwrap();
    std::fs::create_dir(at("named")).unwrap();
    std::fs::write(at("named/series.csv"), SCENE.replace("file = \"", "file = \"../")).unwrap();
    std::fs::hard_link(at("mine.toml"), at("link.rec")).unwrap();
    std::fs::write(at("scene.rec.part"), SCENE).unwrap();
    let contents = || -> Vec<Vec<u8>> {
        let names = ["mine.toml", "sheet.obj", "fibres.txt", "dump/tips.csv", "named/series.csv", "scene.rec.part"];
        names.map(|name| std::fs::read(at(name)).unwrap()).into()
    };
    let before = contents();
    let cases: [(&[&str], &str, &str); 8] = [
        (&["mine.toml", "--record", "mine.toml"], "mine.toml", "--record"),
        (&["mine.toml", "--record", "./sheet.obj"], "sheet.obj", "--record"),
        (&["mine.toml", "--record", "fibres.txt"], "fibres.txt", "--record"),
        (&["mine.toml", "--record", "link.rec"], "link.rec", "--record"),
        (&["scene.rec.part", "--record", "scene.rec"], "scene.rec.part", "--record"),
        (&["mine.toml", "--out", "mine.toml"], "mine.toml is a file", "--out"),
        (&["dumped.toml", "--dump", "dump"], "dump/tips.csv", "--dump"),
        (&["./named/series.csv", "--out", "named"], "named/series.csv", "--out"),
    ];
    for (arguments, named, option) in cases {
        let error = outcome(folder.path(), &[&["run"], arguments].concat(), 1);
        assert!(error.contains(named) && error.contains(option), "{arguments:?}: {error}");
        assert!(contents() == before, "{arguments:?}");
        assert!(!at("out/mine").exists(), "{arguments:?}: before the run");
    }
}

#[test]
fn a_frame_of_an_earlier_run_that_is_the_mesh_is_not_taken_away() {
    let folder = scene();
    let with_frames = SCENE.replace("frames = 0", "frames = 2");
    std::fs::write(folder.path().join("mine.toml"), &with_frames).unwrap();
    outcome(folder.path(), &["run", "mine.toml", "--quiet"], 0);
    let frame = "out/mine/frames-0-tissue-000000.vtu";
    std::fs::write(folder.path().join("mine.toml"), with_frames.replace("sheet.obj", frame)).unwrap();
    let error = outcome(folder.path(), &["run", "mine.toml", "--quiet"], 1);
    assert!(error.contains(frame) && error.contains("--out"), "{error}");
    assert!(folder.path().join(frame).exists());
    outcome(folder.path(), &["run", "mine.toml", "--quiet", "--out", "other"], 0);
}

#[test]
fn what_cannot_be_written_at_the_end_is_said_before_the_run() {
    let folder = scene();
    for name in ["taken.rec", "o/report.json", "d/vertices.csv", "part.rec.part"] {
        std::fs::create_dir_all(folder.path().join(name)).unwrap();
    }
    let cases: [(&[&str], &str, &str); 7] = [
        (&["--out", "o"], "o/report.json", "--out"),
        (&["--out", "a", "--dump", "d"], "d/vertices.csv", "--dump"),
        (&["--out", "a", "--record", "taken.rec"], "taken.rec", "--record"),
        (&["--out", "a", "--record", "part.rec"], "part.rec", "--record"),
        (&["--out", "a", "--record", "a"], "a: it is a directory", "--record"),
        // In the place of another output.
        (&["--out", "a", "--record", "./a/../a/series.csv"], "series.csv", "--record"),
        (&["--out", "a", "--dump", "e", "--record", "e/tips.csv"], "tips.csv", "--record"),
    ];
    for (arguments, named, option) in cases {
        let error = outcome(folder.path(), &[&["run", "mine.toml"], arguments].concat(), 1);
        assert!(error.contains(named) && error.contains(option), "{arguments:?}: {error}");
        assert!(!folder.path().join("a/series.csv").exists() && !folder.path().join("o/series.csv").exists());
    }
    // Commands of minutes, too, know it before they begin.
    std::fs::write(folder.path().join("file"), "").unwrap();
    for command in
        [&["stress", "--minutes", "60"][..], &["stability", "--full"], &["verify", "tear"], &["bench", "targets"]]
    {
        let error = outcome(folder.path(), &[command, &["--out", "file"]].concat(), 1);
        assert!(error.contains("file") && error.contains("--out"), "{command:?}: {error}");
    }
    // What was only tried is not left behind.
    assert_eq!(std::fs::read_dir(folder.path().join("e")).unwrap().count(), 0);
}

#[test]
fn the_stress_need_not_be_asked_for() {
    let folder = scene();
    outcome(folder.path(), &["run", "mine.toml", "--quiet", "--set", "run.advanced.stress_tolerance=inf"], 0);
    let written =
        SCENE.replace("steps = 6", "steps = 6\nadvanced.stress_tolerance = inf\nadvanced.linear_tolerance = 1e-10");
    std::fs::write(folder.path().join("mine.toml"), written).unwrap();
    outcome(folder.path(), &["run", "mine.toml", "--quiet", "--json"], 0);
    for (value, reason) in [("-inf", "finite"), ("nan", "finite"), ("0", "above zero"), ("-1", "above zero")] {
        let error = outcome(
            folder.path(),
            &["check", "mine.toml", "--set", &format!("run.advanced.stress_tolerance={value}")],
            1,
        );
        assert!(error.contains(reason), "{value}: {error}");
    }
    for key in ["run.advanced.linear_tolerance", "run.dt", "run.advanced.newton_tolerance", "bodies.0.damping"] {
        let error = outcome(folder.path(), &["check", "mine.toml", "--set", &format!("{key}=inf")], 1);
        assert!(error.contains("not a finite number"), "{key}: {error}");
    }
}
