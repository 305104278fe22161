//! What acts on a run without being asked for stands in its report and its summary, and no number out of scale is printed as none.

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Stdio};

const STRIP: &str = r#"
[scene]
name = "strip"
[run]
dt = 5
steps = 40
[output]
pictures = 0
frames = 0
energy = true
[[bodies]]
name = "strip"
mesh = { grid = { width = 12, height = 12, nx = 12, ny = 12 } }
material = { young = 1, poisson = 0.3, thickness = 0.1 }
damping = 1
bending = { }
[bodies.tearing]
strength_along_fibres = 0.1
strength_ratio = 1
radius = 1.5
[[bodies.cuts]]
polyline = [[0, 6], [4, 6]]
[[bodies.holds]]
name = "top"
region = { y = 12 }
move = { offset = [0, 1, 0] }
curve = [[0, 0], [200, 4]]
[[bodies.holds]]
name = "bottom"
region = { y = 0 }
"#;

/// Runs the strip with some changes: exit code, what it printed, and its report and series.
fn run(folder: &Path, changes: &[&str]) -> (Option<i32>, String, String) {
    std::fs::write(folder.join("strip.toml"), STRIP).unwrap();
    let sets = changes.iter().flat_map(|change| ["--set", change]);
    let mut command = Command::new(env!("CARGO_BIN_EXE_rhexis"));
    let arguments: Vec<&str> = ["run", "strip.toml", "--out", "out"].into_iter().chain(sets).collect();
    let output = command.current_dir(folder).args(arguments).stdin(Stdio::null()).output().unwrap();
    let read = |name: &str| std::fs::read_to_string(folder.join("out").join(name)).unwrap_or_default();
    let printed = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap()).concat();
    (output.status.code(), printed, read("report.json") + &read("series.csv"))
}

fn report(folder: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(folder.join("out/report.json")).unwrap()).unwrap()
}

#[test]
fn a_tear_that_is_held_back_by_its_speed_is_a_note() {
    let folder = tempfile::tempdir().unwrap();
    // Waves of half a millimetre per millisecond, and a pull of 4 mm in 10 ms.
    let heavy =
        ["bodies.0.material.density=1", "bodies.0.holds.0.curve=[[0, 0], [10, 4]]", "run.dt=0.2", "run.steps=100"];
    let (code, printed, _) = run(folder.path(), &heavy);
    assert_eq!(code, Some(0), "{printed}");
    let report = report(folder.path());
    let tear = &report["bodies"][0]["tear"];
    let (steps, criterion) = (tear["held_back_steps"].as_u64().unwrap(), tear["held_back_criterion"].as_f64().unwrap());
    assert!(steps > 3 && criterion > 1.3, "{tear}");
    let note = format!(
        "tears were held back to the speed of Rayleigh waves in {steps} step(s), largest criterion {criterion:.3}"
    );
    assert!(printed.contains(&note) && report["caveats"].to_string().contains(&note), "{printed}");
    assert_eq!(report["events"]["held_back"], 1);
    let (_, printed, _) = run(folder.path(), &[]);
    assert!(!printed.contains("held back"), "{printed}");
}

#[test]
fn holds_that_stay_behind_their_hand_are_a_note() {
    let folder = tempfile::tempdir().unwrap();
    let jump = [
        "run.accuracy=\"game\"",
        "run.budget=60",
        "run.dt=16",
        "run.steps=20",
        "bodies.0.holds.0.move.offset=[0, 20, 15]",
        "bodies.0.holds.0.curve=[[0, 0], [80, 0], [96, 1]]",
    ];
    let (code, printed, _) = run(folder.path(), &jump);
    assert_eq!(code, Some(0), "{printed}");
    let solver = &report(folder.path())["solver"];
    let (ahead, most) = (&solver["hands_ahead"], solver["most_hand_ahead_mm"].as_f64().unwrap());
    // The hand goes 25 mm in step 6.
    assert!(ahead["first"] == 6 && most > 10.0 && most < 25.0, "{solver}");
    let note = format!(
        "the first being step 6: holds or jaws were up to {most:.3} mm behind their hands: the step was limited"
    );
    assert!(printed.contains(&note), "{printed}");
    let (_, printed, _) = run(folder.path(), &[]);
    assert!(!printed.contains("behind their hands"), "{printed}");
}

#[test]
fn decisions_by_the_material_force_are_told_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let criterion = "bodies.0.energy_criterion={ toughness_along_fibres = 1e3, toughness_across_fibres = 1e3 }";
    let (code, printed, _) =
        run(folder.path(), &[criterion, "bodies.0.tearing.strength_along_fibres=1e3", "run.steps=8"]);
    assert_eq!(code, Some(0), "{printed}");
    let report = report(folder.path());
    assert_eq!(report["bodies"][0]["tear"]["by_material_force"], 0);
    assert_eq!(
        report["bodies"][0]["tear"]["decisions"]["by_material_force"]["the ring meets another boundary than a straight crack's lips"],
        8
    );
}

#[test]
fn numbers_out_of_scale_are_refused_with_their_range_or_leave_numbers() {
    let folder = tempfile::tempdir().unwrap();
    for change in ["material.young=1e-170", "material.young=1e150", "bending.stiffness=1e-310"] {
        let (code, printed, _) = run(folder.path(), &[&format!("bodies.0.{change}"), "run.steps=3"]);
        assert_eq!(code, Some(1), "{change}: {printed}");
        assert!(printed.contains("1e-100 to 1e100"), "{change}: {printed}");
    }
    for change in [
        "run.dt=1e-155",
        "run.dt=1e150",
        "bodies.0.material.thickness=1e-30",
        "bodies.0.material.thickness=1e100",
        "bodies.0.material.density=1e-280",
        "bodies.0.tearing.radius=1e-10",
        "bodies.0.tearing.radius=1e-300",
        "bodies.0.tearing.strength_along_fibres=1e150",
        "bodies.0.tearing.exponent=1e3",
        "bodies.0.holds.0.move.offset=[0, 1e200, 0]",
    ] {
        for mode in ["dynamic", "static"] {
            let mode = format!("run.mode=\"{mode}\"");
            let (code, printed, files) = run(folder.path(), &[change, &mode, "run.steps=3", "output.pictures=1"]);
            assert!(matches!(code, Some(0 | 1)) && !printed.contains("panicked"), "{change}, {mode}: {printed}");
            let text = format!("{printed}{files}");
            let odd = text.split(|c: char| !c.is_ascii_alphanumeric()).find(|word| ["NaN", "inf"].contains(word));
            assert_eq!(odd, None, "{change}, {mode}");
        }
    }
}

/// A needle of 0.4 mm with four sides, 5 mm long, as an OBJ file.
const NEEDLE: &str = "v -0.2 -0.2 0\nv 0.2 -0.2 0\nv 0.2 0.2 0\nv -0.2 0.2 0\nv -0.2 -0.2 -5\nv 0.2 -0.2 -5\nv 0.2 0.2 -5\nv -0.2 0.2 -5\n\
    f 1 2 3\nf 1 3 4\nf 8 7 6\nf 8 6 5\nf 2 1 5\nf 2 5 6\nf 3 2 6\nf 3 6 7\nf 4 3 7\nf 4 7 8\nf 1 4 8\nf 1 8 5\n";

#[test]
fn a_mesh_narrower_than_the_edges_of_the_tissue_that_feels_it_is_a_note() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("needle.obj"), NEEDLE).unwrap();
    let felt = STRIP.replace("damping = 1\n", "damping = 1\ncontact = { }\n");
    let obstacle =
        "[[obstacles]]\nname = \"needle\"\nmesh = { file = { path = \"needle.obj\", translate = [2, 2, -0.1] } }\n";
    let told = |scene: &str| {
        std::fs::write(folder.path().join("scene.toml"), scene).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_rhexis"));
        let output = command.current_dir(folder.path()).args(["check", "scene.toml"]).output().unwrap();
        let printed = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap()).concat();
        assert_eq!(output.status.code(), Some(0), "{printed}");
        printed.contains("note: needle: a mesh 0.5657 mm wide, narrower than the tissue's edges (1.138 mm in the mean)")
    };
    assert!(told(&format!("{felt}{obstacle}")));
    // Tissue without contact feels none, and a wide one is felt.
    assert!(!told(&format!("{STRIP}{obstacle}")));
    assert!(!told(&format!("{felt}{}", obstacle.replace("translate", "scale = 4, translate"))));
}

#[test]
fn layers_that_overlap_are_a_note_and_a_planar_body_has_none() {
    let folder = tempfile::tempdir().unwrap();
    // Two squares of 2 mm that cross.
    let mesh = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 0.5 -1\nv 1.1 1.5 -1\nv 1.1 1.5 1\nv 1 0.5 1\n\
                f 1 2 3\nf 1 3 4\nf 5 6 7\nf 5 7 8\n";
    std::fs::write(folder.path().join("crossed.obj"), mesh).unwrap();
    let scene = "[scene]\nname = 'crossed'\n[run]\ndt = 5\nsteps = 2\n[output]\npictures = 0\nframes = 0\n[[bodies]]\nname = 'crossed'\n\
                 mesh = { file = 'crossed.obj' }\nmaterial = { young = 1, poisson = 0.3, thickness = 0.1 }\n\
                 contact = { self_contact = { radius = 0.05, band = 0 } }\n";
    let path = folder.path().join("crossed.toml");
    let run = |text: &str| {
        std::fs::write(&path, text).unwrap();
        let out = folder.path().join("out");
        let mut command = Command::new(env!("CARGO_BIN_EXE_rhexis"));
        let done = command.args(["run"]).arg(&path).arg("--out").arg(&out).stdin(Stdio::null()).output().unwrap();
        let text = [done.stdout, done.stderr].map(|bytes| String::from_utf8(bytes).unwrap()).concat();
        (done.status.success(), text)
    };
    let (is_done, printed) = run(scene);
    assert!(is_done && printed.contains("layers of a body overlapped in up to"), "{printed}");
    let (is_done, printed) = run(&scene.replace("radius = 0.05", "radius = 2"));
    assert!(!is_done && printed.contains("half a mean edge"), "{printed}");
    let (is_done, printed) = run(&scene.replace("name = 'crossed'\nmesh", "name = 'crossed'\nplanar = true\nmesh"));
    assert!(!is_done && printed.contains("planar"), "{printed}");
}
