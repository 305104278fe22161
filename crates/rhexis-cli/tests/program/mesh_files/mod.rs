//! Mesh files: each format gives the same surface, each fault its message, and hostile files an error instead of a panic.

mod as_they_are;
mod hanging;
mod hostile;
mod per_triangle;
mod reading;
mod samples;

use std::fs;
use std::path::Path;

use glam::{DVec3, dvec3};
use rhexis::components::Channel;
use rhexis::math::smallest_angle;
use rhexis::storage::TriangleMesh;
use rhexis_scene::mesh_file::{MeshFileError, Reading, from_bytes_with, read, read_fibres};

use samples::{
    DECORATED_OBJ, DECORATED_PLY, MSH, OBJ, PLY, STL, VTK, VTU, data, decorated_gltf, good_files, read_bytes, square,
};

fn with_fibres(fibres: [DVec3; 2]) -> TriangleMesh {
    TriangleMesh { fibres: Some(fibres.to_vec()), ..square() }
}

#[test]
fn every_format_gives_the_square() {
    let fibres = [DVec3::X, dvec3(0.0, 2.0, 0.0)];
    for (name, bytes) in good_files() {
        let mesh = read_bytes(name, bytes).unwrap_or_else(|error| panic!("{error}"));
        let expected = if name.contains(".vt") { with_fibres(fibres) } else { square() };
        assert_eq!(mesh, expected, "{name}");
    }
}

#[test]
fn decorated_files_give_the_same_colours_and_texture_coordinates() {
    let files =
        [("b.obj", DECORATED_OBJ.as_bytes().to_vec()), ("d.ply", DECORATED_PLY.into()), ("a.gltf", decorated_gltf())];
    for (name, bytes) in files {
        let file = from_bytes_with(Path::new(name), bytes, &Reading::default()).unwrap();
        let attributes = file.attributes.unwrap();
        let of = |channel: Channel| attributes.channel(channel).unwrap().map(<[f64]>::to_vec).collect::<Vec<_>>();
        // The texture coordinates of glTF count downwards.
        let up = |v: f64| if name == "a.gltf" { 1.0 - v } else { v };
        assert_eq!(
            of(Channel::TextureCoordinates),
            [[0.0, up(0.0)], [1.0, up(0.0)], [1.0, up(1.0)], [0.0, up(1.0)]],
            "{name}"
        );
        assert_eq!(of(Channel::Colour)[1], [0.0, 1.0, 0.0, 1.0], "{name}");
        assert!(of(Channel::Normal).iter().all(|normal| normal[2] > 0.99), "{name}");
    }
}

#[test]
fn windows_line_ends_and_capital_extensions() {
    for (name, text) in [("A.OBJ", OBJ), ("A.Msh", MSH), ("A.VTK", VTK), ("A.vtu", VTU), ("A.PLY", PLY), ("A.STL", STL)]
    {
        let mesh = read_bytes(name, text.replace('\n', "\r\n")).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(mesh.triangles, square().triangles, "{name}");
    }
}

#[test]
fn other_polygons_become_triangles() {
    let head =
        "# vtk DataFile Version 4.2\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n0 0 0 1 0 0 1 1 0.25 0 1 0\n";
    for (cell, triangles) in [
        ("CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n9\n", [[0, 1, 2], [0, 2, 3]]),
        ("CELLS 1 5\n4 0 1 3 2\nCELL_TYPES 1\n8\n", [[0, 1, 2], [0, 2, 3]]),
        ("CELLS 1 5\n4 0 1 3 2\nCELL_TYPES 1\n6\n", [[0, 1, 3], [3, 1, 2]]),
    ] {
        let mesh = read_bytes("a.vtk", format!("{head}{cell}CELL_DATA 1\nVECTORS fibre float\n0 1 0\n")).unwrap();
        assert_eq!(mesh.triangles, triangles);
        assert_eq!(mesh.fibres, Some(vec![DVec3::Y; 2]));
    }
    let pentagon = "v 0 0 0\nv 2 0 0\nv 3 2 0\nv 1 3 0\nv -1 2 0\nf 1 2 3 4 5\n";
    assert_eq!(read_bytes("a.obj", pentagon).unwrap().triangles, [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
    let quad = MSH.replace("2 1 2 2\n3 12 9 7\n4 12 7 8", "2 1 3 1\n3 12 9 7 8");
    assert_eq!(read_bytes("a.msh", quad).unwrap(), square());
}

#[test]
fn readers_orient_and_drop_unused_vertices() {
    let text = "v 0 0 0\nv 9 9 9\nv 1 0 0\nv 1 1 0.25\nv 0 1 0\nf 1 3 4\nf 1 5 4\n";
    assert_eq!(read_bytes("a.obj", text).unwrap(), square());
    let ply = PLY
        .replace("vertex 4", "vertex 5")
        .replace("end_header\n", "end_header\n7 7 7 0\n")
        .replace("4 0 1 2 3", "4 1 2 3 4");
    assert_eq!(read_bytes("a.ply", ply).unwrap(), square());
}

/// The message of a refused file, without the folder it lay in.
fn refusal(name: &str, bytes: impl AsRef<[u8]>) -> String {
    let message = read_bytes(name, bytes).expect_err("the file must be refused").to_string();
    message[message.find(name).unwrap()..].to_string()
}

#[test]
fn faults_name_file_line_and_cure() {
    let cases: &[(&str, String, &str)] = &[
        ("a.obj", OBJ.replace("v 1 1 0.25", "v 1 one 0.25"), "a.obj:5: a vertex needs three numbers"),
        ("a.obj", OBJ.replace("-4 -2 -1", "-4 -2 x"), "a.obj:13: a face needs"),
        ("a.obj", OBJ.replace("3//1", "7//1"), "a.obj:10: the face names vertex 7, but there are only 4"),
        ("a.obj", OBJ.replace("2/1/1", "/1/1"), "a.obj:10: a face needs"),
        ("a.obj", "v 0 0 0\n".into(), "a.obj: the mesh has no triangles"),
        (
            "a.obj",
            OBJ.replace("v 0 1 0", "v 0 nan 0"),
            "a.obj: vertex 3 has the position [0, NaN, 0]; give three numbers",
        ),
        ("a.msh", MSH.replace("4.1 0 8", "3.0 0 8"), "a.msh:2: MSH version 3.0 is not read; export version 4.1"),
        ("a.msh", MSH.replace("4.1 0 8", "4.1 0 99999999999999999999"), "a.msh:2: unknown number format"),
        ("a.msh", MSH.replace("$MeshFormat", "$Mesh"), "a.msh:1: not a Gmsh file"),
        ("a.msh", MSH.replace("1 1 0.25", "1 one 0.25"), "a.msh:17: An invalid node definition was encountered"),
        ("a.msh", MSH.replace("3 12 9 7", "3 12 9 70"), "a.msh: element 3 names node 70"),
        ("a.msh", MSH.replace("\n7\n8\n", "\n7\n7\n"), "a.msh: two nodes have the same tag"),
        ("a.msh", MSH.replace("2 1 2 2\n3 12 9 7\n4 12 7 8", "3 1 4 1\n3 12 9 7 8"), "a.msh: elements of type Tet4"),
        ("a.vtk", VTK.replace("# vtk", "# stk"), "a.vtk:1: not a VTK file"),
        ("a.vtk", VTK.replace("1 1 0.25 0 1 0", "1 1 0.25 0 one 0"), "a.vtk:7: \"one\" is not a number"),
        ("a.vtk", VTK.replace("POINTS 4", "POINTS 4000000000"), "a.vtk:5: 12000000000 numbers are announced"),
        ("a.vtk", VTK.replace("3 5 5", "3 5 10"), "a.vtk: cell 2: VTK cell type 10 is curved or solid"),
        ("a.vtk", VTK.replace("CELLS 3 11", "CELLS 4 11"), "a.vtk:11: the cell list does not hold 4 cells"),
        ("a.vtk", VTK.replace("UNSTRUCTURED_GRID", "STRUCTURED_GRID"), "a.vtk:4: the data set is STRUCTURED_GRID"),
        ("a.vtk", VTK.replace("3 0 2 3", "3 0 2 9"), "a.vtk: triangle 1 names vertex 9"),
        ("a.vtk", VTK.replace("0 2 0\n", "0 0 0\n"), "a.vtk: the fibre [0, 0, 0] of triangle 1"),
        ("a.vtu", VTU.replace("</Cells>", "</Cell>"), "a.vtu:10: "),
        ("a.vtu", VTU.replace("3 6<", "3 7<"), "a.vtu:3: the cell offsets and the connectivity do not fit"),
        (
            "a.vtu",
            VTU.replace("Points=\"4\"", "Points=\"4000000000\""),
            "a.vtu:5: array \"Points\": 12 numbers where 4000000000",
        ),
        ("a.vtu", VTU.replace("1 1 0.25", "1 1 x"), "a.vtu:5: array \"Points\": \"x\" is not a number"),
        ("a.vtu", VTU.replace("5 5", "5 22"), "a.vtu:3: cell 1: VTK cell type 22"),
        (
            "a.vtu",
            VTU.replace(" byte_order", " compressor=\"vtkLZ4DataCompressor\" byte_order"),
            "a.vtu:2: vtkLZ4DataCompressor",
        ),
        ("a.ply", PLY.replace("vertex 4", "vertex 4000000000"), "a.ply: the header promises 4000000000"),
        ("a.ply", PLY.replace("1 1 0.25 255", "1 1 up 255"), "a.ply:14: \"up\" is not a number"),
        ("a.ply", PLY.replace("element face 1", "element facet 1"), "a.ply: the header declares no element `face`"),
        ("a.ply", PLY.replace("4 0 1 2 3", "4 0 1 2 -3"), "a.ply:16: face 0: it has a negative vertex index"),
        ("a.stl", STL.replace("solid\n facet", "sold\n facet"), "a.stl: neither STL text"),
        (
            "a.stl",
            STL.replace("vertex 1 0 0", "vertex 1 0 NaN"),
            "a.stl: vertex 1 has the position [1, 0, NaN]; give three numbers",
        ),
        ("a.stl", format!("{STL}{STL}"), "a.stl: 2 double triangle(s) (line 18 as line 2, line 25 as line 9)"),
    ];
    for (name, text, expected) in cases {
        let message = refusal(name, text);
        assert!(message.starts_with(expected), "expected {expected:?}, got {message:?}");
    }
}

/// What a fan about the first corner would fill with triangles outside of the polygon, and cells that make none.
#[test]
fn polygons_are_filled_or_refused() {
    // Concave at vertex 4 (0.2, 0.2): one diagonal alone lies inside.
    let dart = "v 0.2 0.2 0\nv 0 2 0\nv 0 0 0\nv 2 0 0\n";
    for face in ["f 2 3 4 1\n", "f 3 4 1 2\n", "f 1 2 3 4\n", "f 4 1 2 3\n", "f 1 4 3 2\n"] {
        let mesh = read_bytes("a.obj", format!("{dart}{face}")).unwrap();
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
            0.5 * (b - a).cross(c - a).length()
        };
        // Two triangles with legs 2 and 0.2.
        assert!((mesh.triangles.iter().map(area).sum::<f64>() - 0.4).abs() < 1e-15, "{face}: {mesh:?}");
        assert_eq!(mesh.triangles.len(), 2);
    }
    let bow = "v 0 0 0\nv 1 1 0\nv 1 0 0\nv 0 1 0\n";
    let vtk = |cell: &str, kind: u32| {
        let head = "# vtk DataFile Version 4.2\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n0 0 0 1 1 0 1 0 0 0 1 0\n";
        format!("{head}CELLS 1 {}\n{cell}\nCELL_TYPES 1\n{kind}\n", cell.split(' ').count())
    };
    for (name, text, told) in [
        (
            "a.obj",
            format!("{bow}f 1 2 3 4\n"),
            "a.obj: 1 polygon(s) that cross themselves, are folded or overlap (line 5)",
        ),
        ("a.obj", format!("{bow}f 1 2 3\nf 2 4\n"), "a.obj:6: a face needs at least three"),
        ("a.obj", format!("{bow}f 1 2 3\nf 2\n"), "a.obj:6: a face needs at least three"),
        ("a.vtk", vtk("4 0 1 2 3", 9), "a.vtk: 1 polygon(s) that cross themselves, are folded or overlap (cell 0)"),
        ("a.vtk", vtk("4 0 1 2 3", 5), "a.vtk: cell 0: it has 4 corners, and a triangle has three"),
        ("a.vtk", vtk("3 0 1 2", 9), "a.vtk: cell 0: it has 3 corners, and a quad has four"),
        ("a.vtk", vtk("3 0 1 2", 8), "a.vtk: cell 0: it has 3 corners, and a quad has four"),
        ("a.vtk", vtk("2 0 1", 7), "a.vtk: cell 0: it has 2 corners, and at least three"),
        ("a.vtk", vtk("2 0 1", 6), "a.vtk: cell 0: it has 2 corners, and at least three"),
        ("a.ply", PLY.replace("4 0 1 2 3", "2 0 1"), "a.ply:16: face 0: it has 2 corners"),
        (
            "a.ply",
            PLY.replace("4 0 1 2 3", "4 0 2 1 3"),
            "a.ply: 1 polygon(s) that cross themselves, are folded or overlap (line 16)",
        ),
        (
            "a.msh",
            MSH.replace("2 1 2 2\n3 12 9 7\n4 12 7 8", "2 1 3 1\n3 12 7 9 8"),
            "a.msh: 1 polygon(s) that cross themselves, are folded or overlap (element 3)",
        ),
    ] {
        let message = refusal(name, text);
        assert!(message.starts_with(told), "expected {told:?}, got {message:?}");
    }
}

/// An index beyond the points of its piece would name a point of the next.
#[test]
fn the_corners_of_a_piece_are_its_own() {
    let piece = |points: &str, corners: &str| {
        format!(
            "<Piece NumberOfPoints=\"3\" NumberOfCells=\"1\"><Points><DataArray type=\"Float32\" format=\"ascii\">{points}</DataArray>\
             </Points><Cells><DataArray Name=\"connectivity\" format=\"ascii\">{corners}</DataArray>\n<DataArray Name=\"offsets\" \
             format=\"ascii\">3</DataArray><DataArray Name=\"types\" format=\"ascii\">5</DataArray></Cells></Piece>\n"
        )
    };
    let file = |first: &str| {
        let (a, b) = (piece("0 0 0 1 0 0 0 1 0", first), piece("1 0 0 2 0 0 1 1 0", "0 1 2"));
        format!("<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid>\n{a}{b}</UnstructuredGrid></VTKFile>")
    };
    assert_eq!(read_bytes("a.vtu", file("0 1 2")).unwrap().triangles, [[0, 1, 2], [3, 4, 5]]);
    let message = refusal("a.vtu", file("0 3 5"));
    assert!(message.starts_with("a.vtu:2: cell 0 names point 3, but its piece has only 3"), "{message}");
}

/// Every device and pipe may be endless, and a file larger than the memory.
#[cfg(unix)]
#[test]
fn only_regular_files_of_a_stated_size_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::os::unix::fs::symlink("/dev/zero", at("zero.obj")).unwrap();
    assert!(std::process::Command::new("mkfifo").arg(at("pipe.obj")).status().unwrap().success());
    // A hole of a terabyte takes no room on the disk.
    fs::File::create(at("hole.obj")).unwrap().set_len(1 << 40).unwrap();
    for (name, what) in [
        ("zero.obj", "not a regular file"),
        ("pipe.obj", "not a regular file"),
        (".", "not a regular file"),
        ("hole.obj", "it is larger than the 1024 MB that are read"),
    ] {
        let messages =
            [read(&at(name)).map(|_| ()), read_fibres(&at(name)).map(|_| ())].map(|r| r.unwrap_err().to_string());
        let [mesh, fibres] = messages;
        assert!(mesh.contains(what) || name == ".", "{mesh}");
        assert!(fibres.contains(what) && fibres.contains(name), "{fibres}");
    }
}

#[test]
fn surfaces_that_cannot_be_used_are_refused() {
    let head = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.5 1\nv 2 0 0\n";
    let counts = |faces: &str| match read_bytes("a.obj", format!("{head}{faces}")) {
        Err(MeshFileError::Defects { defects, .. }) => {
            [defects.empty, defects.double, defects.crowded_edges, defects.third, defects.bowties]
        }
        other => panic!("{other:?}"),
    };
    assert_eq!(counts("f 1 2 3\nf 1 3 4\nf 1 3 5\n"), [0, 0, 1, 1, 0]);
    assert_eq!(counts("f 1 2 3\nf 2 3 1\n"), [0, 1, 0, 0, 0]);
    assert_eq!(counts("f 1 2 2\nf 1 2 3\n"), [1, 0, 0, 0, 0]);
    assert_eq!(counts("f 1 2 6\nf 1 2 3\n"), [1, 0, 0, 0, 0]);
    assert_eq!(counts("f 1 2 5\nf 1 3 4\n"), [0, 0, 0, 0, 1]);
    // All of them in one go.
    assert_eq!(counts("f 1 2 3\nf 1 3 4\nf 1 3 5\nf 3 2 1\nf 1 2 6\n"), [1, 1, 1, 1, 0]);
}

/// What goes round a vertex takes the square of its triangles; and a message is not as long as the file.
#[test]
fn crowded_vertices_and_edges_are_refused_in_few_words() {
    let spokes = |count: u32| -> String {
        let at = |i: u32| std::f64::consts::TAU * f64::from(i) / f64::from(count);
        let rim = (0..count).map(|i| format!("v {} {} 0\n", at(i).cos(), at(i).sin()));
        let faces = (0..count).map(|i| format!("f 1 {} {}\n", i + 2, (i + 1) % count + 2));
        ["v 0 0 0\n".to_owned()].into_iter().chain(rim).chain(faces).collect()
    };
    assert_eq!(read_bytes("a.obj", spokes(1000)).unwrap().triangles.len(), 1000);
    let message = refusal("a.obj", spokes(1001));
    assert!(message.starts_with("a.obj: vertex 0 has 1001 triangles, 1000 at the most"), "{message}");
    let pages = (0..5000).map(|i| format!("v 0 1 {i}\nf 1 2 {}\n", i + 3));
    let message = refusal("a.obj", format!("v 0 0 0\nv 1 0 0\n{}", pages.collect::<String>()));
    assert!(message.contains("more than two triangles (line 4, line 6, line 8 and 4997 more)"), "{message}");
}

#[test]
fn missing_files_and_unknown_formats() {
    let missing = read(Path::new("no/such/mesh.obj")).unwrap_err();
    assert!(matches!(missing, MeshFileError::Unreadable { .. }));
    assert!(missing.to_string().starts_with("cannot read no/such/mesh.obj: "));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("folder.obj");
    fs::create_dir(&path).unwrap();
    assert!(matches!(read(&path), Err(MeshFileError::Unreadable { .. })));
    for name in ["a.step", "a"] {
        assert!(
            refusal(name, "")
                .ends_with("save the mesh as one of .obj, .msh, .vtu, .vtk, .ply, .stl, .vtp, .off, .glb, .gltf")
        );
    }
}

#[test]
fn fibres_from_text() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("fibres.csv");
    let read_text = |text: &str| {
        fs::write(&path, text).unwrap();
        read_fibres(&path).map_err(|error| error.to_string())
    };
    let fibres = read_text("# x, y, z\n1, 0, 0\n\n0\t1 0.5 # second\r\n 0;0;-2\n").unwrap();
    assert_eq!(fibres, [DVec3::X, dvec3(0.0, 1.0, 0.5), dvec3(0.0, 0.0, -2.0)]);
    for (text, expected) in [
        ("1 0 0\n1 0\n", "fibres.csv:2: 2 numbers on the line; give three finite numbers"),
        ("x,y,z\n", "fibres.csv:1: \"x\" is not a number"),
        ("0 0 0\n", "fibres.csv:1: the fibre [0, 0, 0] has no direction"),
        ("1 inf 0\n", "fibres.csv:1: the fibre [1, inf, 0] has no direction"),
    ] {
        let message = read_text(text).unwrap_err();
        assert!(message.contains(expected), "{message}");
    }
    assert!(matches!(read_fibres(Path::new("no/such/file")), Err(MeshFileError::Unreadable { .. })));
}

/// A mesh by another program (tests/data/README.md): nothing about it was arranged to suit this one.
#[test]
fn an_independent_mesh_of_a_tissue_patch() {
    let mesh = read(&data("gmsh_patch.msh")).unwrap();
    assert_eq!(mesh.check(), Ok(()));
    assert_eq!((mesh.positions.len(), mesh.triangles.len()), (3_497, 6_795));
    let corners = |t: &[u32; 3]| t.map(|corner| mesh.positions[corner as usize]);
    let angle = mesh.triangles.iter().map(|t| smallest_angle(corners(t)).to_degrees()).fold(f64::INFINITY, f64::min);
    // 42.289° by this formula; the file holds 16 digits.
    assert!((angle - 42.289).abs() < 5e-4, "{angle}");
    let faces_up = mesh.triangles.iter().all(|t| {
        let [a, b, c] = corners(t);
        (b - a).cross(c - a).z > 0.0
    });
    assert!(faces_up);
    let (low, high) =
        mesh.positions.iter().fold((DVec3::MAX, DVec3::MIN), |(low, high), p| (low.min(*p), high.max(*p)));
    // The outline overshoots its control points a little, and Gmsh leaves rounding in z.
    let size = high - low;
    assert!((size.x - 20.0).abs() < 0.3 && (size.y - 14.0).abs() < 0.3 && size.z < 1e-12, "{size}");
}
