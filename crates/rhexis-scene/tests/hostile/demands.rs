//! A few bytes that ask for more than any machine has are refused before it is allocated; the work is bounded by the bytes.
//!
//! What is counted is bytes allocated, not time. Other tests of this process may run meanwhile, so bounds have room for them.

use rhexis_scene::{Document, mesh_file};
use stats_alloc::Region;
use std::path::Path;

/// Pieces whose arrays all name the appended block at offset 0, which holds nothing and has a long tail.
fn pieces_of_one_block(pieces: usize, encoding: &str) -> Vec<u8> {
    let piece = "<Piece NumberOfPoints=\"0\" NumberOfCells=\"0\"><Points><DataArray type=\"Float32\" format=\"appended\" offset=\"0\"/>\
                 </Points><Cells><DataArray Name=\"types\" type=\"UInt8\" format=\"appended\" offset=\"0\"/><DataArray Name=\"offsets\" \
                 type=\"UInt8\" format=\"appended\" offset=\"0\"/></Cells></Piece>";
    let mut block = vec![0; 4 + 400_000];
    if encoding == "base64" {
        block = base64::Engine::encode(&base64::engine::general_purpose::STANDARD, block).into_bytes();
    }
    let head = "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid>";
    let tail = format!("</UnstructuredGrid><AppendedData encoding=\"{encoding}\">_");
    let text = format!("{head}{}{tail}", piece.repeat(pieces));
    [text.as_bytes(), &block, b"</AppendedData></VTKFile>"].concat()
}

#[test]
fn an_appended_block_is_decoded_once() {
    for encoding in ["raw", "base64"] {
        let bytes = pieces_of_one_block(2000, encoding);
        let length = bytes.len();
        let region = Region::new(super::GLOBAL);
        let error = mesh_file::from_bytes(Path::new("a.vtu"), bytes).unwrap_err().to_string();
        let taken = region.change().bytes_allocated;
        assert!(error.contains("no triangles"), "{error}");
        // 6,000 arrays name 400 kB: decoding them for each would allocate 2.4 GB at the least.
        assert!(taken < 50 * length + (256 << 20), "{encoding}: {taken} bytes allocated for {length}");
    }
}

/// A scene of a body with these lines, the first of which is line 12.
fn scene(lines: &str) -> String {
    format!(
        "[scene]\nname = \"much\"\n[run]\ndt = 5\nsteps = 1000000\n[output]\npictures = 0\nframes = 0\n[[bodies]]\nname = \"b\"\n\
         material = {{ young = 1, poisson = 0.3, thickness = 0.1 }}\n{lines}\n"
    )
}

#[test]
fn scenes_that_ask_for_terabytes_are_refused_before_they_get_them() {
    let grid = "mesh = { grid = { width = 6, height = 5, nx = 1, ny = 1 } }";
    let tearing = "tearing = { strength_along_fibres = 1, strength_ratio = 2, radius = 1 }";
    let hand =
        "holds = [{ name = \"h\", region = { x = 0 }, curve = { hand = { to = 1, within = 9, duration = 900000 } } }]";
    let disc = "mesh = { disc = { radius = 6, triangles = 300000 } }";
    let cases: [(String, &str, usize, &str, &str); 13] = [
        (grid.replace("nx = 1, ny = 1", "nx = 5000, ny = 5000"), "mesh", 12, "50000000 triangles", "50 GB"),
        (grid.replace("nx = 1, ny = 1", "nx = 4000000000, ny = 4000000000"), "mesh", 12, "3.2e19 triangles", "TB"),
        (grid.replace("grid", "jittered").replace("nx = 1,", "nx = 90000000,"), "mesh", 12, "180000000", "180 GB"),
        ("mesh = { disc = { radius = 6, triangles = 90000000 } }".into(), "mesh", 12, "90000000 triangles", "90 GB"),
        (
            "mesh = { cap = { curvature_radius = 9, diameter = 6, triangles = 9000000000 } }".into(),
            "mesh",
            12,
            "9.0e9 triangles",
            "9 TB",
        ),
        ("mesh = { plate_with_hole = { points = 80000 } }".into(), "mesh", 12, "3.2e9 triangles", "3 TB"),
        (
            "mesh = { quad = { corners = [[0, 0], [1, 0], [1, 1], [0, 1]], nx = 9000, ny = 9000 } }".into(),
            "mesh",
            12,
            "162000000 triangles",
            "162 GB",
        ),
        (format!("copies = 10000\n{disc}"), "copies", 12, "10000 copies of 300000 triangles", "3 TB"),
        (format!("copies = 4000000000\n{grid}"), "copies", 12, "4000000000 bodies", "10000 in all"),
        (
            format!("{disc}\n{tearing}\nrefinement = {{ budget = 90 }}"),
            "refinement.budget",
            14,
            "up to 90 times",
            "27 GB",
        ),
        (format!("copies = 10000\n{grid}\n{hand}"), "copies", 12, "10000 times 900001 points", "144 GB"),
        (
            "mesh = { unstructured = { corners = [[0, 0], [9e6, 0], [9e6, 9e6], [0, 9e6]], edge = 1 } }".into(),
            "mesh",
            12,
            "more than 5000000 triangles",
            "coarser",
        ),
        (
            "mesh = { lattice = { corners = [[0, 0], [9e6, 0], [9e6, 9e6], [0, 9e6]], edge = 1, degrees = 7 } }".into(),
            "mesh",
            12,
            "more than 5000000 triangles",
            "coarser",
        ),
    ];
    for (lines, key, line, what, more) in cases {
        refused(&scene(&lines), key, line, &[what, more]);
    }
    // A million points each: 200 of them would be 3 GB before any of them is looked at.
    let hands = hand
        .replace("holds = [{", "[[bodies.holds]]\n")
        .replace("}]", "")
        .replace(", region", "\nregion")
        .replace(", curve", "\ncurve");
    refused(
        &scene(&format!("{grid}\n{}", format!("{hands}\n").repeat(200))),
        "11.curve.hand",
        60,
        &["more than 10000000 points"],
    );
    let files = scene(&format!("copies = 5000\n{grid}"));
    refused(&files.replace("frames = 0", "frames = 50"), "output.frames", 8, &["250000 files", "100000"]);
    refused(&files.replace("pictures = 0", "pictures = 4000000000"), "output.pictures", 7, &["5000005000 files"]);
    let frames = scene("mesh = { grid = { width = 6, height = 5, nx = 1000, ny = 1000 } }");
    refused(&frames.replace("frames = 0", "frames = 90000"), "output.frames", 8, &["45 TB", "1 TB"]);
}

fn refused(text: &str, key: &str, line: usize, told: &[&str]) {
    let region = Region::new(super::GLOBAL);
    let error = Document::new(text, "much.toml").scene().and_then(|scene| scene.check()).unwrap_err();
    let taken = region.change().bytes_allocated;
    let shown = error.to_string();
    assert!(error.key.ends_with(key), "{key}: {shown}");
    assert_eq!(error.position.map(|place| place.0), Some(line), "{shown}");
    told.iter().for_each(|word| assert!(shown.contains(word), "{word}: {shown}"));
    // The hand's own curve has 900,000 points, copied a few times.
    assert!(taken < 512 << 20, "{taken} bytes allocated: {shown}");
}

/// An override is no longer for those before it.
#[test]
fn many_overrides_take_no_more_than_their_text() {
    let mut document = Document::new(scene("mesh = { grid = { width = 6, height = 5, nx = 1, ny = 1 } }"), "much.toml");
    for i in 0..4000 {
        document.set(&format!("run.steps={}", 1 + i)).unwrap();
    }
    document.set("run.td=5").unwrap();
    let region = Region::new(super::GLOBAL);
    let error = document.clone().scene().unwrap_err();
    let taken = region.change().bytes_allocated;
    assert_eq!(error.origin, "--set run.td=5", "{error}");
    // Behind spaces up to their places they would be 140 MB, once for the tree and once for the place of the error.
    assert!(taken < 100 << 20, "{taken} bytes allocated");
}

/// A strip has few triangles, however far the rows of a turned lattice would reach beyond it.
#[test]
fn a_lattice_takes_no_more_than_its_outline() {
    let strip = [[0.0, 0.0], [20_000.0, 0.0], [20_000.0, 2.0], [0.0, 2.0]].map(glam::DVec2::from);
    for degrees in [0.0, 30.0, 90.0, 137.0] {
        let region = Region::new(super::GLOBAL);
        let mesh = rhexis_scene::generate::lattice(&strip, 2.0, degrees).unwrap();
        let taken = region.change().bytes_allocated;
        assert!(mesh.triangles.len() > 15_000, "{}", mesh.triangles.len());
        // The square around the strip has 115 million places, twice 2 GB as the list grows; 20,000 triangles are triangulated 22 times.
        assert!(taken < 3 << 30, "{degrees}°: {taken} bytes allocated");
    }
}
