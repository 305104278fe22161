//! Pictures, strips and films of runs and scenes, as a user makes them.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use tiny_skia::Pixmap;

fn rhexis(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_rhexis")).current_dir(folder).args(arguments).output().unwrap()
}

fn words(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn drawn(folder: &Path, arguments: &[&str]) -> String {
    let output = rhexis(folder, &[&["render"], arguments].concat());
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", words(&output.stderr));
    words(&output.stdout)
}

/// A run of a small capsule in `run`.
fn run(folder: &Path) {
    let set = ["--set", "bodies.0.mesh.cap.triangles=300", "--set", "output.pictures=0", "--set", "output.frames=5"];
    let made =
        rhexis(folder, &[&["run", "capsulorhexis", "--steps", "60", "--quiet", "--out", "run"], &set[..]].concat());
    assert!(made.status.success(), "{}", words(&made.stderr));
}

fn size(path: &Path) -> [u32; 2] {
    let pixels = Pixmap::load_png(path).unwrap();
    [pixels.width(), pixels.height()]
}

#[test]
fn a_run_is_drawn_from_several_sides_in_strips_and_films() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    run(folder);
    let said = drawn(folder, &["run", "--view", "top,side,perspective", "--size", "200"]);
    assert!(said.contains("run/render.png"), "{said}");
    let three = size(&folder.join("run/render.png"));
    assert!(three[0] > 600 && three[1] > 200, "{three:?}");
    drawn(folder, &["run", "--view", "top", "--size", "200", "--out", "one.png"]);
    assert!(size(&folder.join("one.png"))[0] < 400);

    drawn(folder, &["run", "--strip", "4", "--view", "top,perspective", "--size", "150"]);
    let strip = size(&folder.join("run/strip.png"));
    assert!(strip[0] > 600 && strip[1] > 200, "{strip:?}");

    let arguments = ["run", "--view", "top", "--circle", "5.25", "--no-mesh-lines", "--no-fibres", "--size", "150"];
    drawn(folder, &[&arguments[..], &["--film", "4"]].concat());
    let film = fs::read(folder.join("run/film.png")).unwrap();
    assert!(film.windows(4).any(|chunk| chunk == b"acTL"), "it is animated");
    assert_eq!(film.windows(4).filter(|chunk| *chunk == b"fcTL").count(), 4);

    let said = drawn(folder, &[&arguments[..], &["--frames", "3", "--out", "many"]].concat());
    assert!(said.contains("ffmpeg -framerate 12 -i many/frame-%04d.png"), "{said}");
    drawn(folder, &[&arguments[..], &["--frames", "2", "--out", "many"]].concat());
    let names: Vec<_> = fs::read_dir(folder.join("many")).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(names.len(), 2, "the third was of the film before: {names:?}");
    assert!(size(&folder.join("many/frame-0000.png")).iter().all(|side| side % 2 == 0), "as films want it");

    // The same frames give the same bytes; without the circle they give others.
    for name in ["a.png", "b.png"] {
        drawn(folder, &[&arguments[..], &["--out", name]].concat());
    }
    drawn(folder, &[&arguments[..3], &arguments[5..], &["--out", "c.png"]].concat());
    let [a, b, c] = ["a.png", "b.png", "c.png"].map(|name| fs::read(folder.join(name)).unwrap());
    assert!(a == b && a != c);
}

#[test]
fn a_scene_is_run_for_its_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let arguments = ["fig2-tear", "--steps", "40", "--size", "160", "--set", "bodies.0.fibres.degrees=60"];
    let said = drawn(folder, &[&arguments[..], &["--tips"]].concat());
    assert!(said.contains("out/fig2-tear/render.png"), "{said}");
    assert_eq!(fs::read_dir(folder.join("out/fig2-tear")).unwrap().count(), 1, "the picture alone");
    drawn(folder, &[&arguments[..], &["--at", "100,200,400", "--out", "three.png"]].concat());
    let three = size(&folder.join("three.png"));
    assert!(three[0] > 3 * 160, "{three:?}");
}

#[test]
fn what_cannot_be_drawn_is_refused_with_the_way_out() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let refused = |arguments: &[&str], wanted: &[&str]| {
        let output = rhexis(folder, &[&["render"], arguments].concat());
        let error = words(&output.stderr);
        assert!(!output.status.success() && wanted.iter().all(|word| error.contains(word)), "{arguments:?}: {error}");
        assert!(!error.contains("panicked"), "{error}");
    };
    fs::create_dir(folder.join("empty")).unwrap();
    refused(&["empty"], &["empty/frames.pvd", "output.frames"]);
    refused(&["nowhere.toml"], &["nowhere.toml"]);
    refused(&["fig2", "--view", "bottom"], &["perspective"]);
    refused(&["fig2", "--steps", "1", "--circle", "99", "--quiet"], &["does not lie on the body", "--circle"]);
    refused(&["fig2", "--film", "5", "--strip", "5"], &["--film"]);
    run(folder);
    refused(&["run", "--tips"], &["for a scene"]);
    let frame = fs::read_dir(folder.join("run")).unwrap().map(|entry| entry.unwrap().path());
    let frame = frame.filter(|path| path.extension().is_some_and(|end| end == "vtu")).max().unwrap();
    fs::write(&frame, "<VTKFile").unwrap();
    refused(&["run"], &[frame.file_name().unwrap().to_str().unwrap(), "run the scene anew"]);
}
