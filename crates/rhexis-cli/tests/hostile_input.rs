//! Mesh files, scene files, `--set`, edits and the command line, with whatever bytes: refused with a reason, or sound; and never for more
//! memory than a multiple of the bytes. Fixed seeds; `tests/fuzz` has the same properties as targets for cargo-fuzz.

#[path = "../../rhexis-scene/tests/hostile/demands.rs"]
mod demands;
#[path = "../../rhexis-scene/tests/hostile/mod.rs"]
mod hostile;

use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use rhexis_scene::{Document, catalog, mesh_file};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};
use std::alloc::System;
use std::path::Path;

#[global_allocator]
static GLOBAL: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Numbers that break what does not look, and words that are none.
const WORDS: [&str; 24] = [
    "0",
    "-0",
    "-1",
    "1e400",
    "-1e400",
    "1e-400",
    "1e308",
    "1e150",
    "nan",
    "inf",
    "4294967295",
    "4294967296",
    "18446744073709551615",
    "18446744073709551616",
    "-9223372036854775808",
    "0.1",
    "1e-9",
    "[]",
    "{}",
    "[[[[[[[[1]]]]]]]]",
    "true",
    "\"\"",
    "''",
    "\u{0}",
];

fn runner(cases: u32) -> TestRunner {
    let config = Config { cases, failure_persistence: None, ..Config::default() };
    TestRunner::new_with_rng(config, TestRng::from_seed(RngAlgorithm::ChaCha, &[11; 32]))
}

fn word() -> impl Strategy<Value = &'static str> {
    prop::sample::select(WORDS.to_vec())
}

/// Bytes allocated while a mesh is read, and whether it was.
fn read(name: &str, bytes: &[u8]) -> (usize, bool) {
    let bytes = bytes.to_vec();
    let region = Region::new(GLOBAL);
    let is_read = mesh_file::from_bytes(Path::new(name), bytes).is_ok();
    (region.change().bytes_allocated, is_read)
}

/// A multiple of the bytes that no honest reading exceeds; other tests of this file may run meanwhile.
fn most(length: usize) -> usize {
    2000 * length + (256 << 20)
}

fn refused(name: &str, bytes: &[u8]) {
    let (taken, is_read) = read(name, bytes);
    let shown = String::from_utf8_lossy(&bytes[..bytes.len().min(300)]);
    assert!(!is_read, "{name} was read: {shown}");
    assert!(taken < most(bytes.len()), "{name}: {taken} bytes allocated for {}: {shown}", bytes.len());
}

#[test]
fn heads_that_claim_billions_take_no_memory() {
    for count in ["4000000000", "4294967295", "18446744073709551615", "99999999999999999999999", "-1", "1e400", "nan"] {
        let vtk = |rest: &str| format!("# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\n{rest}");
        let square = "POINTS 3 float\n0 0 0 1 0 0 0 1 0\n";
        refused("a.vtk", vtk(&format!("POINTS {count} float\n0 0 0")).as_bytes());
        refused("a.vtk", vtk(&format!("{square}CELLS {count} {count}\n3 0 1 2\nCELL_TYPES 1\n5\n")).as_bytes());
        refused("a.vtk", vtk(&format!("{square}CELLS 1 4\n{count} 0 1 2\nCELL_TYPES 1\n5\n")).as_bytes());
        refused("a.vtk", vtk(&format!("{square}CELLS 1 4\n3 0 1 {count}\nCELL_TYPES 1\n5\n")).as_bytes());
        let binary = vtk(&format!("POINTS {count} double\n")).replace("ASCII", "BINARY");
        refused("a.vtk", binary.as_bytes());
        for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
            let ply = |vertices: &str, faces: &str, data: &str| {
                format!(
                    "ply\nformat {format} 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n\
                     element face {faces}\nproperty list uint int vertex_index\nend_header\n{data}"
                )
            };
            refused("a.ply", ply(count, "1", "0 0 0\n").as_bytes());
            refused("a.ply", ply("0", count, "3 0 0 0\n").as_bytes());
            // A list that is said to have so many entries: as text, and as the largest number there is.
            refused("a.ply", ply("0", "1", &format!("{count} 0 1 2\n")).as_bytes());
            refused("a.ply", &[ply("0", "1", "").as_bytes(), &[0xff; 64]].concat());
        }
        // The last vertex, in this format.
        if count != "-1" {
            refused("a.obj", format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 {count}\n").as_bytes());
        }
        refused("a.obj", format!("v 0 0 {count}\nv 1 0 0\nv 0 1 0\nf 1 2 4\n").as_bytes());
        refused("a.stl", format!("solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 {count}\n").as_bytes());
        let msh = |nodes: &str, elements: &str| {
            format!(
                "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n{nodes}\n$EndNodes\n$Elements\n{elements}\n$EndElements\n"
            )
        };
        let (nodes, elements) = ("1 3 1 3\n2 1 0 3\n1\n2\n3\n0 0 0\n1 0 0\n0 1 0", "1 1 1 1\n2 1 2 1\n1 1 2 3");
        refused("a.msh", msh(&format!("1 3 1 3\n2 1 0 {count}\n1\n2\n3\n0 0 0"), elements).as_bytes());
        refused("a.msh", msh(nodes, &format!("1 1 1 1\n2 1 2 {count}\n1 1 2 3")).as_bytes());
        refused("a.msh", msh(nodes, &format!("1 1 1 1\n2 1 2 1\n1 1 2 {count}")).as_bytes());
        let vtu = |points: &str, cells: &str, corner: &str| {
            format!(
                "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\"><Points>\
                 <DataArray type=\"Float32\" format=\"ascii\">0 0 0 1 0 0 0 1 0</DataArray></Points><Cells>\
                 <DataArray Name=\"connectivity\" format=\"ascii\">0 1 {corner}</DataArray><DataArray Name=\"offsets\" format=\"ascii\">3\
                 </DataArray><DataArray Name=\"types\" format=\"ascii\">5</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>"
            )
        };
        assert!(read("a.vtu", vtu("3", "1", "2").as_bytes()).1, "the file itself is good");
        refused("a.vtu", vtu(count, "1", "2").as_bytes());
        refused("a.vtu", vtu("3", count, "2").as_bytes());
        refused("a.vtu", vtu("3", "1", count).as_bytes());
    }
    for count in ["4000000000", "18446744073709551615", "-1", "nan"] {
        for (extension, text) in NEW_FORMATS {
            for (from, to) in [
                ("\n5 2 0", format!("\n{count} 2 0")),
                ("\n5 2 0", format!("\n5 {count} 0")),
                ("$Nodes\n4", format!("$Nodes\n{count}")),
                ("$Elements\n2", format!("$Elements\n{count}")),
                ("\n3\n2\n1 1", format!("\n{count}\n2\n1 1")),
                ("\n3\n2\n1 1", format!("\n3\n{count}\n1 1")),
                ("$PhysicalNames\n1", format!("$PhysicalNames\n{count}")),
                ("NumberOfPolys=\"1\"", format!("NumberOfPolys=\"{count}\"")),
                ("NumberOfPoints=\"4\"", format!("NumberOfPoints=\"{count}\"")),
                ("\"count\":3", format!("\"count\":{count}")),
                ("\"byteLength\":36,\"byteS", format!("\"byteLength\":36,\"byteOffset\":{count},\"byteS")),
                ("\"byteStride\":12", format!("\"byteStride\":{count}")),
                ("face 1", format!("face {count}")),
                ("\n4 0 1", format!("\n{count} 0 1")),
            ] {
                if text.contains(from) {
                    refused(&format!("a.{extension}"), text.replacen(from, &to, 1).as_bytes());
                }
            }
        }
    }
    let mut stl = vec![b' '; 80];
    stl.extend(u32::MAX.to_le_bytes());
    stl.extend([0; 50]);
    refused("a.stl", &stl);
}

/// A megabyte of numbers that a thousand pieces name, and one that would become a gigabyte.
#[test]
fn vtu_files_that_swell_are_refused() {
    let point_count = 87_000;
    let mut appended = (12 * point_count as u32).to_le_bytes().to_vec();
    appended.resize(4 + 12 * point_count, 0);
    let piece = format!(
        "<Piece NumberOfPoints=\"{point_count}\" NumberOfCells=\"0\"><Points><DataArray type=\"Float32\" format=\"appended\" offset=\"0\"/>\
         </Points><Cells><DataArray Name=\"types\" format=\"ascii\"></DataArray><DataArray Name=\"offsets\" format=\"ascii\"></DataArray>\
         </Cells></Piece>"
    );
    let file = |pieces: usize| {
        let head = "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid>";
        let tail = "</UnstructuredGrid><AppendedData encoding=\"raw\">_";
        let text = format!("{head}{}{tail}", piece.repeat(pieces));
        [text.as_bytes(), &appended, b"</AppendedData></VTKFile>"].concat()
    };
    let bytes = file(1000);
    let (taken, is_read) = read("a.vtu", &bytes);
    // 1,000 pieces would be 2 GB of numbers, and as much again as points.
    assert!(!is_read && taken < 1 << 30, "{taken} bytes allocated for {}", bytes.len());

    let zeros = miniz_oxide::deflate::compress_to_vec_zlib(&vec![0; 64 << 20], 9);
    let head = [1_u32, 64 << 20, 0, zeros.len() as u32].map(u32::to_le_bytes).concat();
    let text = base64::Engine::encode(&base64::engine::general_purpose::STANDARD, [head, zeros].concat());
    let bomb = format!(
        "<VTKFile type=\"UnstructuredGrid\" compressor=\"vtkZLibDataCompressor\"><UnstructuredGrid><Piece NumberOfPoints=\"0\" \
         NumberOfCells=\"0\"><Points><DataArray type=\"UInt8\" format=\"binary\">{text}</DataArray></Points></Piece></UnstructuredGrid></VTKFile>"
    );
    let (taken, is_read) = read("a.vtu", bomb.as_bytes());
    assert!(!is_read && taken < 1 << 30, "{taken} bytes allocated for {}", bomb.len());
}

/// Buffers of a glTF file that name one file, the file itself at that.
#[test]
fn a_file_that_many_buffers_name_is_read_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("b.gltf");
    let buffers = vec!["{\"byteLength\":1,\"uri\":\"b.gltf\"}"; 12_000].join(",");
    let text = format!("{{\"asset\":{{\"version\":\"2.0\"}},\"buffers\":[{buffers}],\"meshes\":[],\"nodes\":[]}}");
    std::fs::write(&path, &text).unwrap();
    let region = Region::new(GLOBAL);
    let refused = mesh_file::read(&path).unwrap_err().to_string();
    let taken = region.change().bytes_allocated;
    assert!(refused.contains("no triangles") && taken < most(text.len()), "{taken} bytes allocated: {refused}");
}

#[test]
fn nesting_without_end_is_refused() {
    let deep = 100_000;
    refused("a.vtu", "<a>".repeat(deep).as_bytes());
    refused("a.vtu", (("<VTKFile>").to_owned() + &"<a>".repeat(deep) + &"</a>".repeat(deep) + "</VTKFile>").as_bytes());
    let entities: String = (1..30).map(|i| format!("<!ENTITY e{i} \"&e{};&e{};\">", i - 1, i - 1)).collect();
    refused("a.vtu", format!("<!DOCTYPE a [<!ENTITY e0 \"ha\">{entities}]><VTKFile>&e29;</VTKFile>").as_bytes());
    for text in [
        format!("a = {}", "[".repeat(deep)),
        format!("a = {}1{}", "[".repeat(deep), "]".repeat(deep)),
        format!("a = {}", "{ a = ".repeat(deep)),
        format!("{} = 1", vec!["a"; deep].join(".")),
        format!("[{}]\nb = 1", vec!["a"; deep].join(".")),
        format!("[{}]\nb = 1", "a".repeat(deep)),
    ] {
        let head = &text[..20];
        assert!(Document::new(&text, "deep").scene().is_err(), "{head}");
        let mut document = Document::named("fig2").unwrap();
        assert!(document.set(&text).is_err() || document.scene().is_err(), "--set {head}");
    }
}

/// Changes to a text: at a word or a line, by place.
fn changes() -> impl Strategy<Value = Vec<(u8, f64, &'static str)>> {
    prop::collection::vec((0_u8..5, 0.0..1.0, word()), 1..5)
}

fn changed(text: &str, changes: &[(u8, f64, &str)]) -> String {
    let mut text = text.to_owned();
    for &(kind, at, word) in changes {
        let numbers: Vec<(usize, usize)> = spans(&text);
        let lines: Vec<&str> = text.lines().collect();
        let (Some(line), Some(&(from, to))) =
            (lines.get((at * lines.len() as f64) as usize), numbers.get((at * numbers.len() as f64) as usize))
        else {
            break;
        };
        text = match kind {
            0..=2 => format!("{}{word}{}", &text[..from], &text[to..]),
            3 => text.replacen(line, "", 1),
            _ => text.replacen(line, &format!("{line}\n{line}"), 1),
        };
    }
    text
}

/// Where the numbers of a text stand.
fn spans(text: &str) -> Vec<(usize, usize)> {
    let mut spans = Vec::new();
    let mut start = None;
    for (at, c) in text.char_indices() {
        match (start, c.is_ascii_digit() || c == '.') {
            (None, true) => start = Some(at),
            (Some(from), false) => {
                spans.push((from, at));
                start = None;
            }
            _ => {}
        }
    }
    spans
}

#[test]
fn changed_scenes_are_refused_or_step() {
    let scenes: Vec<&str> = catalog::CATALOG.iter().map(|entry| entry.text).collect();
    runner(400)
        .run(&(prop::sample::select(scenes), changes()), |(text, changes)| {
            hostile::scene(Document::new(changed(text, &changes), "changed.toml"));
            Ok(())
        })
        .unwrap();
}

#[test]
fn hostile_overrides_are_refused_or_step() {
    let keys = [
        "run.dt",
        "run.steps",
        "run.mode",
        "run.threads",
        "run.accuracy",
        "output.frames",
        "bodies.0.mesh",
        "bodies.0.mesh.grid.nx",
        "bodies.0.mesh.grid.width",
        "bodies.0.material.thickness",
        "bodies.0.material.young_fibre",
        "bodies.0.material.poisson_major",
        "bodies.0.fibres.degrees",
        "bodies.0.tearing.radius",
        "bodies.0.tearing.exponent",
        "bodies.0.damping",
        "bodies.0.holds",
        "bodies.0.holds.0.curve",
        "bodies.0.copies",
        "bodies.7.name",
        "obstacles",
        "scene.preset",
        "presets",
        "",
        ".",
        "a.b.c",
    ];
    let set = (prop::sample::select(keys.to_vec()), word()).prop_map(|(key, value)| format!("{key}={value}"));
    runner(300)
        .run(&(any::<u8>(), prop::collection::vec(set, 1..4)), |(which, sets)| {
            hostile::overrides(which, &sets.join("\n"));
            Ok(())
        })
        .unwrap();
}

#[test]
fn edits_from_any_bytes_are_refused_or_whole() {
    runner(3000)
        .run(&prop::collection::vec(any::<u8>(), 0..400), |bytes| {
            hostile::edits(&bytes);
            Ok(())
        })
        .unwrap();
}

/// Small files of the formats of which no program's own lies in `tests/data`.
const NEW_FORMATS: [(&str, &str); 9] = [
    ("off", "OFF\n5 2 0\n0 0 0\n1 0 0\n1 1 0.25\n0 1 0\n0.2 0.2 0\n4 0 1 2 4\n4 0 4 2 3\n"),
    ("obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.4 0.4 0\ng skin\nf 1 2 3 5 4\nf -3 \\\n-2 -1\n"),
    (
        "msh",
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n2 7 \"skin\"\n$EndPhysicalNames\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n\
         $EndNodes\n$Elements\n2\n1 2 2 7 1 1 2 3\n2 2 2 7 1 1 3 4\n$EndElements\n$ElementData\n1\n\"fibre\"\n1\n0\n3\n0\n3\n2\n1 1 0 0\n2 0 1 0\n\
         $EndElementData\n",
    ),
    (
        "vtp",
        "<VTKFile type=\"PolyData\"><PolyData><Piece NumberOfPoints=\"4\" NumberOfPolys=\"1\"><CellData><DataArray Name=\"f0\" format=\"ascii\">1 0 0\
         </DataArray></CellData><Points><DataArray format=\"ascii\">0 0 0 1 0 0 1 1 0 0 1 0</DataArray></Points><Polys>\
         <DataArray Name=\"connectivity\" format=\"ascii\">0 1 2 3</DataArray><DataArray Name=\"offsets\" format=\"ascii\">4</DataArray></Polys>\
         </Piece></PolyData></VTKFile>",
    ),
    (
        "gltf",
        "{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0,\"scale\":[2,2,2]}],\"meshes\":[{\"primitives\":\
         [{\"attributes\":{\"POSITION\":0},\"mode\":5}]}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3}],\
         \"bufferViews\":[{\"buffer\":0,\"byteLength\":36,\"byteStride\":12}],\"buffers\":[{\"byteLength\":36,\"uri\":\"data:;base64,\
         AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"}]}",
    ),
    (
        "ply",
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n\
         property list uchar int64 vertex_indices\nproperty float fibre_x\nproperty float fibre_y\nproperty float fibre_z\nend_header\n\
         0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3 1 0 0\n",
    ),
    (
        "obj",
        "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\nvt 0 0\nvt 1 0\nvt 1 1 0\nvn 0 0 1\nvn 0 0.1 1\nf 1/1/1 2/2/2 -1/-1/-1\n",
    ),
    (
        "ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty float nx\nproperty float ny\n\
         property float nz\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nproperty float u\nproperty float v\nelement face 1\n\
         property list uchar int vertex_indices\nend_header\n0 0 0 0 0 1 255 0 0 0 0\n1 0 0 0 0 1 0 255 0 1 0\n0 1 0 0 0 1 0 0 255 0 1\n3 0 1 2\n",
    ),
    (
        "gltf",
        "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"mesh\":0,\"scale\":[-1,2,2]}],\"meshes\":[{\"primitives\":[{\"attributes\":\
         {\"POSITION\":0,\"NORMAL\":0,\"TEXCOORD_0\":1,\"COLOR_0\":2}}]}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\
         \"count\":3},{\"bufferView\":0,\"componentType\":5123,\"type\":\"VEC2\",\"count\":3,\"normalized\":true},{\"bufferView\":0,\"componentType\":5121,\
         \"type\":\"VEC4\",\"count\":3,\"normalized\":true}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"buffers\":[{\"byteLength\":36,\
         \"uri\":\"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"}]}",
    ),
];

/// They are read as they stand.
#[test]
fn the_new_formats_are_good_before_they_are_changed() {
    for (extension, text) in NEW_FORMATS {
        let name = format!("a.{extension}");
        let read = mesh_file::from_bytes(Path::new(&name), text.as_bytes().to_vec());
        assert!(read.is_ok(), "{name}: {}", read.unwrap_err());
    }
}

#[test]
fn mesh_files_of_any_bytes_are_refused_or_sound() {
    let good: Vec<(&str, Vec<u8>)> =
        ["gmsh_patch.msh", "legacy_binary.vtk", "legacy_text.vtk", "appended_raw_zlib.vtu", "inline_zlib.vtu"]
            .map(|name| (name.rsplit('.').next().unwrap(), std::fs::read(format!("tests/data/{name}")).unwrap()))
            .into_iter()
            .chain(NEW_FORMATS.map(|(extension, text)| (extension, text.as_bytes().to_vec())))
            .collect();
    let change = (0_u8..3, 0.0..1.0, any::<u8>(), word());
    runner(1500)
        .run(&(prop::sample::select(good), prop::collection::vec(change, 1..6)), |((extension, mut bytes), changes)| {
            for (kind, at, byte, word) in changes {
                let at = (at * bytes.len() as f64) as usize;
                match kind {
                    0 => bytes[at] = byte,
                    1 => drop(bytes.splice(at..(at + usize::from(byte % 9)).min(bytes.len()), word.bytes())),
                    _ => bytes.truncate(at.max(1)),
                }
            }
            let region = Region::new(GLOBAL);
            hostile::mesh(extension, &bytes);
            let taken = region.change().bytes_allocated;
            prop_assert!(taken < most(bytes.len()), "{taken} bytes allocated for {}", bytes.len());
            Ok(())
        })
        .unwrap();
}

/// Whatever is typed: done, refused or wrong usage, and never a panic.
#[test]
fn command_lines_end_in_an_exit_code() {
    let folder = tempfile::tempdir().unwrap();
    // `/proc` takes no files, from nobody.
    let words = [
        "run",
        "scenes",
        "check",
        "replay",
        "verify",
        "bench",
        "compare",
        "fig2",
        "free-triangle",
        "constitutive",
        "--steps",
        "--set",
        "--show",
        "--out",
        "--resume",
        "--json",
        "--quiet",
        "--snapshots",
        "--record",
        "--dump",
        "--threads",
        "--timings",
        "--help",
        "--version",
        "run.steps=1",
        "run.dt=0",
        "a=b",
        "=",
        ".",
        "/proc",
        "no such file",
        "-",
        "--",
        "ä",
        "",
    ];
    let argument = prop_oneof![3 => prop::sample::select(words.to_vec()), 1 => word().prop_filter("no argument holds a zero", |w| *w != "\0")];
    runner(150)
        .run(&prop::collection::vec(argument, 0..7), |mut arguments| {
            // What would take minutes is not what is tried here, and a run of a step is enough.
            match arguments.first() {
                Some(&"verify") => arguments.insert(1, "constitutive"),
                Some(&"bench") => arguments.insert(1, "compare"),
                Some(&"run") => {
                    drop(arguments.splice(1..1, ["free-triangle", "--steps", "1", "--set", "output.pictures=0"]))
                }
                _ => {}
            }
            let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_rhexis"));
            command.current_dir(folder.path()).args(&arguments).stdin(std::process::Stdio::null());
            let output = command.output().unwrap();
            let error = String::from_utf8_lossy(&output.stderr);
            prop_assert!(matches!(output.status.code(), Some(0..=2)), "{arguments:?}: {:?} {error}", output.status);
            prop_assert!(!error.contains("panicked"), "{arguments:?}: {error}");
            prop_assert!(output.status.success() || !error.is_empty(), "{arguments:?} fails without a word");
            Ok(())
        })
        .unwrap();
}
