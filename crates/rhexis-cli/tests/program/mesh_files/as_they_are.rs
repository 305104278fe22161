//! Files as programs write them: each case stands for a kind, with the counts and areas that a reader by itself gives.

use super::samples::{MSH, PLY, STL, data, good_files, read_bytes, square};
use glam::{DVec3, dvec3};
use rhexis::storage::TriangleMesh;
use rhexis_scene::mesh_file::{MeshFile, Reading, from_bytes_with, read};
use std::path::Path;

fn area(mesh: &TriangleMesh) -> f64 {
    let twice = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
        (b - a).cross(c - a).length()
    };
    0.5 * mesh.triangles.iter().map(twice).sum::<f64>()
}

fn with(name: &str, text: impl AsRef<[u8]>, reading: &Reading) -> MeshFile {
    from_bytes_with(Path::new(name), text.as_ref().to_vec(), reading).unwrap_or_else(|error| panic!("{error}"))
}

fn refusal(name: &str, text: impl AsRef<[u8]>) -> String {
    read_bytes(name, text).unwrap_err().to_string()
}

const L_SHAPE: &str = "v 0 0 0\nv 1 0 0\nv 1 0.4 0\nv 0.4 0.4 0\nv 0.4 1 0\nv 0 1 0\n";

/// From whichever corner and in whichever sense a polygon is written, it is filled by the same triangles.
#[test]
fn a_polygon_is_filled_the_same_from_every_corner() {
    let corners = [1, 2, 3, 4, 5, 6];
    let mut first: Option<Vec<[u32; 3]>> = None;
    for start in 0..6 {
        for backward in [false, true] {
            let mut face = corners;
            face.rotate_left(start);
            if backward {
                face.reverse();
            }
            let words: Vec<String> = face.iter().map(u32::to_string).collect();
            let mesh = read_bytes("a.obj", format!("{L_SHAPE}f {}\n", words.join(" "))).unwrap();
            // 1 × 0.4 and 0.4 × 0.6.
            assert!((area(&mesh) - 0.64).abs() < 1e-15, "{face:?}: {}", area(&mesh));
            let mut sets: Vec<[u32; 3]> = mesh.triangles.clone();
            sets.iter_mut().for_each(|t| t.sort_unstable());
            sets.sort_unstable();
            assert_eq!(first.get_or_insert_with(|| sets.clone()), &sets, "{face:?}");
        }
    }
}

/// Combs, stars, corners in the middle of a side and a bridge to a hole: areas by Gauss's formula, one triangle per corner less two.
#[test]
fn polygons_of_any_shape_are_filled() {
    let comb: Vec<[f64; 2]> = (0..20)
        .flat_map(|i| [[f64::from(i), 0.0], [f64::from(i) + 0.5, 5.0 + f64::from(i % 3)]])
        .chain([[20.0, 0.0], [20.0, -1.0], [0.0, -1.0]])
        .collect();
    let star: Vec<[f64; 2]> = (0..24)
        .map(|i| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / 24.0).sin_cos();
            let radius = if i % 2 == 0 { 1.0 } else { 0.2 };
            [radius * cos, radius * sin]
        })
        .collect();
    let straight = vec![[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [0.0, 1.0]];
    for outline in [comb, star, straight] {
        let gauss: f64 = (0..outline.len())
            .map(|i| {
                let ([x, y], [u, v]) = (outline[i], outline[(i + 1) % outline.len()]);
                0.5 * (x * v - u * y)
            })
            .sum();
        // Turned out of its plane, as a file may have it.
        let turn = glam::DMat3::from_axis_angle(dvec3(1.0, 2.0, -0.5).normalize(), 1.1);
        let points = outline.iter().map(|p| turn * dvec3(p[0], p[1], 3.0));
        let vertices: String = points.map(|p| format!("v {} {} {}\n", p.x, p.y, p.z)).collect();
        let face: Vec<String> = (1..=outline.len()).map(|i| i.to_string()).collect();
        let mesh = read_bytes("a.obj", format!("{vertices}f {}\n", face.join(" "))).unwrap();
        assert_eq!(mesh.triangles.len(), outline.len() - 2);
        assert!((area(&mesh) - gauss.abs()).abs() < 1e-12 * gauss.abs(), "{} for {gauss}", area(&mesh));
    }
    // A square of 4 with a hole of 1, cut open along the bridge from vertex 1 to vertex 5 and back.
    let ring = "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nv 1 1 0\nv 1 2 0\nv 2 2 0\nv 2 1 0\nf 1 2 3 4 1 5 6 7 8 5\n";
    let mesh = read_bytes("a.obj", ring).unwrap();
    assert_eq!((mesh.triangles.len(), area(&mesh)), (8, 15.0));
    // Many write a triangle as a quad with a corner twice.
    let mesh = read_bytes("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 3\n").unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 2]]);
}

/// A polygon without area, and one with two corners at one place: counted with the triangles that have no area, not as a crossing.
#[test]
fn empty_polygons_are_counted_as_such() {
    let corners = "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 3 0 0\nv 0 1 0\nv 1 1 0\nv 1 1 0\nv 0.3 0.3 0\n";
    let message = refusal("a.obj", format!("{corners}f 1 2 6 5\nf 1 2 3 4\n"));
    assert!(message.contains("2 triangle(s) without area (line 10, line 10)"), "{message}");
    let message = refusal("a.obj", format!("{corners}f 1 2 6 7 5\n"));
    assert!(message.contains("1 triangle(s) without area (line 9)"), "{message}");
    let repair = Reading { repair: true, ..Reading::default() };
    let file = with("a.obj", format!("{corners}f 1 2 6 7 5\n"), &repair);
    assert_eq!((file.mesh.triangles.len(), area(&file.mesh), file.tidied.defects.empty), (2, 1.0, 1));
}

#[test]
fn polygons_that_cross_or_overlap_are_refused_by_line() {
    let corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.5 0\n";
    // A bow, and one that runs round twice.
    for face in ["1 3 2 4", "1 2 3 4 1 2 3 4"] {
        let message = refusal("a.obj", format!("{corners}f {face}\n"));
        assert!(message.contains("1 polygon(s) that cross themselves, are folded or overlap (line 6)"), "{message}");
        assert!(message.contains("repair = true"), "{message}");
    }
    // More than can be filled in their cube.
    let (count, ring) = (41, |i: usize| std::f64::consts::TAU * (2 * i) as f64 / 41.0);
    let star: String = (0..count).map(|i| format!("v {} {} 0\n", ring(i).cos(), ring(i).sin())).collect();
    let face: Vec<String> = (1..=count).map(|i| i.to_string()).collect();
    let message = refusal("a.obj", format!("{star}f {}\n", face.join(" ")));
    assert!(message.contains("a.obj:42: its 41 corners are too many for a polygon that crosses itself"), "{message}");
    assert!(message.contains("has 32 at the most; save it as triangles"), "{message}");
}

#[test]
fn folded_and_crossing_polygons_are_filled_by_repair_and_counted() {
    let repair = Reading { repair: true, ..Reading::default() };
    // A quad that is bent by more than 90 degrees along either diagonal, with a neighbour.
    let folded = "v 0.4 0.9 0.5\nv 0.6 0.2 0\nv 0.3 0.1 0.5\nv 1 0.7 0.2\nv 0.8 0 0.8\nf 1 2 3 4\nf 2 1 5\n";
    let file = with("a.obj", folded, &repair);
    assert_eq!((file.mesh.triangles.len(), file.tidied.defects.folded), (3, 1));
    let text = file.tidied.defects.text();
    assert!(text.contains("1 polygon(s) that cross themselves, are folded or overlap (line 6)"), "{text}");
    // Of both diagonals the one with the smaller area.
    let of = |triangles: [[usize; 3]; 2]| {
        let points = [dvec3(0.4, 0.9, 0.5), dvec3(0.6, 0.2, 0.0), dvec3(0.3, 0.1, 0.5), dvec3(1.0, 0.7, 0.2)];
        let twice = triangles.map(|t| (points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]).length());
        0.5 * (twice[0] + twice[1])
    };
    let (first, second) = (of([[0, 1, 2], [0, 2, 3]]), of([[0, 1, 3], [1, 2, 3]]));
    let neighbour = 0.5 * (dvec3(0.2, -0.7, -0.5)).cross(dvec3(0.4, -0.9, 0.3)).length();
    assert!((area(&file.mesh) - neighbour - first.min(second)).abs() < 1e-12, "{first} {second}");
    // One filling from every corner; a bow, a spike, a star, and one that runs round twice are read as well.
    let corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0 0\n";
    for face in ["1 3 2 4", "1 2 5 4", "1 2 3 4 1 2 3 4"] {
        let file = with("a.obj", format!("{corners}f {face}\n"), &repair);
        assert_eq!(file.tidied.defects.folded, 1, "{face}");
        file.mesh.check().unwrap_or_else(|error| panic!("{face}: {error}"));
    }
    let star: String = (0..5)
        .map(|i| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(2 * i) / 5.0).sin_cos();
            format!("v {cos} {sin} 0\n")
        })
        .collect();
    let file = with("a.obj", format!("{star}f 1 2 3 4 5\n"), &repair);
    assert_eq!((file.mesh.triangles.len(), file.tidied.defects.folded), (3, 1));
}

/// Byte-order marks, carriage returns and Latin-1 in every format; UTF-16 as text.
#[test]
fn encodings_do_not_matter() {
    for (name, bytes) in good_files() {
        let plain = read_bytes(name, &bytes).unwrap();
        let marked = [b"\xef\xbb\xbf", bytes.as_slice()].concat();
        assert_eq!(read_bytes(name, marked).unwrap(), plain, "{name} with a mark");
        let Ok(text) = String::from_utf8(bytes) else { continue };
        if text.contains('\0') {
            continue;
        }
        assert_eq!(read_bytes(name, text.replace('\n', "\r\n")).unwrap(), plain, "{name} with CR LF");
        assert_eq!(read_bytes(name, text.replace('\n', "\r")).unwrap(), plain, "{name} with CR");
        let wide: Vec<u8> = std::iter::once(0xfeff).chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect();
        assert_eq!(read_bytes(name, wide).unwrap(), plain, "{name} in UTF-16");
    }
    let latin = [b"# Mod\xe8le\n".as_slice(), b"v 0 0 0\nv 1 0 0\nv 1 1 0.25\nv 0 1 0\nf 1 2 3 4\n"].concat();
    assert_eq!(read_bytes("a.obj", latin).unwrap(), square());
    let ply = PLY.replace("by hand", "\u{e8}").chars().map(|c| c as u8).collect::<Vec<u8>>();
    assert_eq!(read_bytes("a.ply", ply).unwrap(), square());
}

#[test]
fn a_line_goes_on_behind_a_backslash() {
    let text = "v 0 0 \\\n 0\nv 1 0 0\nv 1 1 0.25\nv 0 1 0\nf 1 2 \\\n 3 4\nf 1 2 9\n";
    assert!(refusal("a.obj", text).contains("a.obj:8: the face names vertex 9"));
    assert_eq!(read_bytes("a.obj", text.replace("f 1 2 9\n", "")).unwrap(), square());
    assert_eq!(
        read_bytes("a.obj", text.replace("f 1 2 9\n", "f 1 2 3 \\")).unwrap_err().to_string().matches("double").count(),
        1
    );
}

/// STL as programs write it: two words at the end, capitals, several solids, an empty line first, normals that are no numbers, and what
/// other programs put behind the last triangle.
#[test]
fn stl_of_every_dialect() {
    let variants = [
        STL.replace("endsolid", "end solid a").replace("endloop", "end loop").replace("endfacet", "end facet"),
        STL.to_uppercase(),
        format!("\n  \n{}", STL.replace("solid\n", "solid name of it\n")),
        STL.replacen(" endfacet\n", " endfacet\nendsolid a\nsolid b\n", 1),
        STL.replace("normal 0 0 1", "normal nan -nan(ind) nan"),
        STL.replace(" 1 0 0\n", " 1.0000001 0 0\n").replacen("vertex 0 0 0", "vertex 0 0 -0.0000001", 1),
    ];
    for text in variants {
        let mesh = read_bytes("a.stl", &text).unwrap_or_else(|error| panic!("{error}: {text}"));
        assert_eq!(mesh.triangles, square().triangles, "{text}");
    }
    let binary = super::samples::binary_stl(b"solid of a binary file");
    let mut longer = binary.clone();
    longer.extend([7; 33]);
    assert_eq!(read_bytes("a.stl", longer).unwrap(), read_bytes("a.stl", &binary).unwrap());
    let mut uncounted = super::samples::binary_stl(b"by a writer that never went back");
    uncounted[80..84].fill(0);
    assert_eq!(read_bytes("a.stl", uncounted).unwrap(), read_bytes("a.stl", binary).unwrap());
    // A seam whose sides differ in the last digit of single numbers is joined, one that differs in the fifth is not.
    let seam = |x: &str| STL.replacen("vertex 1 1 0.25", &format!("vertex {x} 1 0.25"), 1);
    assert_eq!(read_bytes("a.stl", seam("1.0000001")).unwrap().positions.len(), 4);
    assert!(refusal("a.stl", seam("1.00001")).contains("1 bowtie(s)"));
}

/// Counts of 64 bits, indices of any type, trailing bytes, capitals, strips.
#[test]
fn ply_of_every_dialect() {
    for kind in ["int64", "longlong", "uint64", "ulonglong", "uint32", "INT", "float"] {
        assert_eq!(
            read_bytes("a.ply", PLY.replace("uchar int vert", &format!("uchar {kind} vert"))).unwrap(),
            square()
        );
    }
    assert_eq!(read_bytes("a.ply", format!("{PLY}trailing words")).unwrap(), square());
    let strip = PLY.replace("element face 1", "element tristrips 1").replace("4 0 1 2 3", "4 1 2 0 3");
    let mesh = read_bytes("a.ply", strip).unwrap();
    assert_eq!((mesh.triangles.len(), area(&mesh)), (2, area(&square())));
    for (change, told) in [
        (PLY.replace("4 0 1 2 3", "4 0 1 2 0.5"), "a.ply:16: face 0: it has a negative vertex index"),
        (PLY.replace("4 0 1 2 3", "4 0 1 2 9"), "a.ply:16: it names vertex 9, but there are only 4"),
        (PLY.replace("4 0 1 2 3", "9 0 1 2 3"), "a.ply: the file ends within row 0 of element `face`"),
        (PLY.replace("property uchar red", "property colour red"), "a.ply:8: \"colour\" is no type of numbers"),
    ] {
        let message = refusal("a.ply", change);
        assert!(message.contains(told), "{message}");
    }
}

#[test]
fn off_with_and_without_its_frills() {
    let plain = "OFF\n4 2 5\n0 0 0\n1 0 0\n1 1 0.25\n0 1 0\n3 0 1 2\n3 0 2 3\n";
    for text in [
        plain.to_owned(),
        plain.replace("OFF\n4 2 5", "# made by hand\n\nOFF 4 2 0 # counts"),
        plain.replace("OFF\n", ""),
        plain.replace("OFF\n", "OFF"),
        plain.replace("OFF", "COFF").replace("0 1 0\n", "0 1 0 255 0 0 255\n"),
        plain.replace("3 0 1 2", "3  0 1 2 0.5 0.5 0.5").replace("4 2 5", "4 3 0").replace("3 0 2 3", "2 0 1\n3 0 2 3"),
        plain.replace("4 2 5", "4 1 0").replace("3 0 1 2\n3 0 2 3", "4 0 1 2 3"),
    ] {
        assert_eq!(read_bytes("a.off", &text).unwrap_or_else(|error| panic!("{error}: {text}")), square(), "{text}");
    }
    for (text, told) in [
        (plain.replace("0 2 3", "0 2 x"), "a.off:8: a face is its number of corners"),
        (plain.replace("1 1 0.25", "1 1"), "a.off:5: a vertex needs three numbers"),
        (plain.replace("3 0 2 3\n", ""), "a.off: the file ends before its last face"),
        (plain.replace("OFF", "OFF BINARY"), "a.off:1: binary OFF is not read; save it as text"),
        (plain.replace("OFF", "4OFF"), "a.off:1: 4OFF has other than three coordinates"),
        (plain.replace("0 2 3", "0 2 7"), "a.off:8: it names vertex 7"),
        ("nothing".to_owned(), "a.off:1: not an OFF file"),
    ] {
        let message = refusal("a.off", &text);
        assert!(message.contains(told), "{told}: {message}");
    }
}

pub const MSH_2: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n1 5 \"left side\"\n2 7 \"skin\"\n$EndPhysicalNames\n\
    $Nodes\n4\n12 0 0 0\n9 1 0 0\n7 1 1 0.25\n8 0 1 0\n$EndNodes\n\
    $Elements\n4\n1 15 2 0 1 12\n2 1 2 5 1 12 8\n3 2 2 7 1 12 9 7\n4 2 2 7 1 12 7 8\n$EndElements\n";

/// Versions 1 and 2 of Gmsh's format, text and binary, with the names of physical groups.
#[test]
fn old_versions_of_gmsh() {
    let file = with("a.msh", MSH_2, &Reading::default());
    assert_eq!(file.mesh, square());
    assert_eq!(file.groups, [("left side".to_owned(), vec![0, 3]), ("skin".to_owned(), vec![0, 1, 2, 3])]);
    let first = "$NOD\n4\n12 0 0 0\n9 1 0 0\n7 1 1 0.25\n8 0 1 0\n$ENDNOD\n$ELM\n3\n1 15 1 1 1 12\n3 2 7 1 3 12 9 7\n4 2 7 1 3 12 7 8\n$ENDELM\n";
    assert_eq!(read_bytes("a.msh", first).unwrap(), square());
    for is_big in [false, true] {
        let int = |x: i32| if is_big { x.to_be_bytes() } else { x.to_le_bytes() };
        let real = |x: f64| if is_big { x.to_be_bytes() } else { x.to_le_bytes() };
        let mut bytes = b"$MeshFormat\n2.2 1 8\n".to_vec();
        bytes.extend(int(1));
        bytes.extend(b"\n$EndMeshFormat\n$Nodes\n4\n");
        for (tag, p) in (1..).zip(square().positions) {
            bytes.extend(int(tag));
            bytes.extend(p.to_array().map(real).concat());
        }
        bytes.extend(b"\n$EndNodes\n$Elements\n3\n");
        bytes.extend([1, 1, 2, 1, 5, 1, 1, 4].map(int).concat());
        bytes.extend([2, 2, 2, 2, 7, 1, 1, 2, 3, 3, 7, 1, 1, 3, 4].map(int).concat());
        bytes.extend(b"\n$EndElements\n");
        assert_eq!(read_bytes("a.msh", bytes).unwrap(), square(), "{is_big}");
    }
    for (text, told) in [
        (MSH_2.replace("2.2 0 8", "3.0 0 8"), "a.msh:2: MSH version 3.0 is not read; export version 4.1 or 2.2"),
        (MSH_2.replace("12 9 7\n", "12 9 70\n"), "a.msh:20: element 3 names node 70, which does not exist"),
        (MSH_2.replace("3 2 2 7 1 12 9 7", "3 4 2 7 1 12 9 7 8"), "a.msh:20: elements of type 4 are curved or solid"),
        (MSH_2.replace("1 1 0.25", "1 one 0.25"), "a.msh:13: \"one\" is not a number"),
        (MSH_2.replace("8 0 1 0\n$", "9 0 1 0\n$"), "a.msh: two nodes have the same tag"),
        (MSH_2.replace("$Elements\n4", "$Elements\n4000000000"), "a.msh:17: 4000000000 rows are announced"),
    ] {
        let message = refusal("a.msh", &text);
        assert!(message.contains(told), "{told}: {message}");
    }
    // Names of version 4.1, by its entities.
    let names = "$PhysicalNames\n1\n2 3 \"skin\"\n$EndPhysicalNames\n$Entities\n0 0 1 0\n1 0 0 0 1 1 0.25 1 3 0\n$EndEntities\n$Nodes";
    let file = with("a.msh", MSH.replacen("$Nodes", names, 1), &Reading::default());
    assert_eq!(file.groups, [("skin".to_owned(), vec![0, 1, 2, 3])]);
}

pub const VTP: &str = r#"<?xml version="1.0"?>
<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian">
 <PolyData><FieldData><Array type="String" Name="who" NumberOfTuples="1" format="ascii">109 101 0</Array></FieldData>
 <Piece NumberOfPoints="4" NumberOfVerts="1" NumberOfLines="1" NumberOfPolys="1" NumberOfStrips="1">
  <PointData><DataArray type="Float32" Name="height" format="ascii">0 0 1 1</DataArray></PointData>
  <CellData><DataArray type="Float32" Name="Fibre" NumberOfComponents="3" format="ascii">9 9 9 8 8 8 1 0 0 0 2 0</DataArray></CellData>
  <Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">0 0 0 1 0 0 1 1 0.25 0 1 0</DataArray></Points>
  <Verts><DataArray type="Int64" Name="connectivity" format="ascii">0</DataArray>
   <DataArray type="Int64" Name="offsets" format="ascii">1</DataArray></Verts>
  <Lines><DataArray type="Int64" Name="connectivity" format="ascii">0 1</DataArray>
   <DataArray type="Int64" Name="offsets" format="ascii">2</DataArray></Lines>
  <Polys><DataArray type="Int64" Name="connectivity" format="ascii">0 1 2</DataArray>
   <DataArray type="Int64" Name="offsets" format="ascii">3</DataArray></Polys>
  <Strips><DataArray type="Int64" Name="connectivity" format="ascii">0 2 3</DataArray>
   <DataArray type="Int64" Name="offsets" format="ascii">3</DataArray></Strips>
 </Piece></PolyData>
</VTKFile>
"#;

#[test]
fn polygonal_data_as_xml() {
    let fibres = Some(vec![DVec3::X, dvec3(0.0, 2.0, 0.0)]);
    let file = with("a.vtp", VTP, &Reading::default());
    assert_eq!(file.mesh, TriangleMesh { fibres, ..square() });
    assert_eq!(file.passed_over, ["height"]);
    let message = refusal("a.vtp", VTP.replace(">0 1 2<", ">0 1 9<"));
    assert!(message.contains("a.vtp:4: cell 2 names point 9, but its piece has only 4"), "{message}");
}

/// Arrays of strings, in text and binary, and of single bits.
#[test]
fn legacy_vtk_with_strings() {
    let text = "# vtk DataFile Version 5.1\nt\nASCII\nDATASET POLYDATA\nFIELD FieldData 2\nmeta 1 1 double\n1.5\nMETADATA\nINFORMATION 0\n\n\
        who 1 2 string\nme%20too\nyou\n\nPOINTS 4 double\n0 0 0 1 0 0 1 1 0.25 0 1 0\nPOLYGONS 3 6\nOFFSETS vtktypeint64\n0 3 6\n\
        CONNECTIVITY vtktypeint64\n0 1 2 0 2 3\nCELL_DATA 2\nSCALARS FIBERS double 3\nLOOKUP_TABLE default\n1 0 0 0 2 0\n\
        FIELD FieldData 1\nname 1 2 string\na\nb\nSCALARS mark bit\nLOOKUP_TABLE default\n1 0\n";
    let fibres = Some(vec![DVec3::X, dvec3(0.0, 2.0, 0.0)]);
    assert_eq!(read_bytes("a.vtk", text).unwrap(), TriangleMesh { fibres: fibres.clone(), ..square() });
    let mut binary =
        b"# vtk DataFile Version 5.1\nt\nBINARY\nDATASET POLYDATA\nFIELD FieldData 1\nwho 1 2 string\n".to_vec();
    binary.extend(b"\xc2me");
    // A length of 70 needs two bytes.
    binary.extend([0x80, 70]);
    binary.extend([b'x'; 70]);
    binary.extend(b"\nPOINTS 4 double\n");
    binary.extend(square().positions.iter().flat_map(|p| p.to_array()).flat_map(f64::to_be_bytes));
    binary.extend(b"\nPOLYGONS 3 6\nOFFSETS vtktypeint64\n");
    binary.extend([0_i64, 3, 6].map(i64::to_be_bytes).concat());
    binary.extend(b"\nCONNECTIVITY vtktypeint64\n");
    binary.extend([0_i64, 1, 2, 0, 2, 3].map(i64::to_be_bytes).concat());
    binary.extend(b"\nCELL_DATA 2\nSCALARS mark bit\nLOOKUP_TABLE default\n\x80\nVECTORS f0 double\n");
    binary.extend([1.0, 0.0, 0.0, 0.0, 2.0, 0.0].map(f64::to_be_bytes).concat());
    assert_eq!(read_bytes("a.vtk", binary).unwrap(), TriangleMesh { fibres, ..square() });
}

/// A .glb of the square in two triangles with vertices of their own, as programs write it that keep normals apart; its node is moved.
pub fn glb() -> Vec<u8> {
    let corners = [0, 1, 2, 0, 2, 3].map(|v| square().positions[v]);
    let mut binary: Vec<u8> = [0_u16, 1, 2, 3, 4, 5].map(u16::to_le_bytes).concat();
    binary.extend(corners.iter().flat_map(|p| p.as_vec3().to_array()).flat_map(f32::to_le_bytes));
    let json = "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"children\":[1],\"translation\":[5,0,0]},\
         {\"mesh\":0,\"name\":\"skin\",\"translation\":[-5,0,0]}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":1},\"indices\":0}]}],\
         \"accessors\":[{\"bufferView\":0,\"componentType\":5123,\"type\":\"SCALAR\",\"count\":6},\
         {\"bufferView\":1,\"componentType\":5126,\"type\":\"VEC3\",\"count\":6,\"min\":[0,0,0],\"max\":[1,1,0.25]}],\
         \"bufferViews\":[{\"buffer\":0,\"byteLength\":12},{\"buffer\":0,\"byteOffset\":12,\"byteLength\":72}],\
         \"buffers\":[{\"byteLength\":84}]}";
    let json = format!("{json}{}", " ".repeat((4 - json.len() % 4) % 4));
    let mut out = b"glTF".to_vec();
    out.extend([2, 28 + json.len() as u32 + binary.len() as u32, json.len() as u32].map(u32::to_le_bytes).concat());
    out.extend(b"JSON");
    out.extend(json.bytes());
    out.extend((binary.len() as u32).to_le_bytes());
    out.extend(b"BIN\0");
    out.extend(binary);
    out
}

#[test]
fn gltf_binary_and_text() {
    let file = with("a.glb", glb(), &Reading::default());
    // The format is in metres.
    let metres = TriangleMesh { positions: square().positions.iter().map(|p| *p * 1000.0).collect(), ..square() };
    assert_eq!(file.mesh, metres);
    let scaled = with("a.glb", glb(), &Reading { scale: Some(2.0), ..Reading::default() });
    assert_eq!(scaled.mesh.positions[2], dvec3(2.0, 2.0, 0.5));
    assert_eq!(file.groups, [("skin".to_owned(), vec![0, 1, 2, 3])]);
    assert_eq!(file.tidied.joined, 2);
    let bytes = glb();
    let json_length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let json = String::from_utf8(bytes[20..20 + json_length].to_vec()).unwrap();
    let data = base64::Engine::encode(&base64::engine::general_purpose::STANDARD, &bytes[28 + json_length..]);
    let uri = format!("{{\"byteLength\":84,\"uri\":\"data:application/octet-stream;base64,{data}\"}}");
    let text = json.replace("{\"byteLength\":84}", &uri);
    assert_eq!(read_bytes("a.gltf", &text).unwrap(), square());
    // Beside the file.
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.bin"), &bytes[28 + json_length..]).unwrap();
    let beside = json.replace("{\"byteLength\":84}", "{\"byteLength\":84,\"uri\":\"a.bin\"}");
    std::fs::write(folder.path().join("a.gltf"), &beside).unwrap();
    assert_eq!(read(&folder.path().join("a.gltf")).unwrap(), metres);
    for (text, told) in [
        (beside.clone(), "cannot read the buffer \"a.bin\""),
        (beside.replace("a.bin", "../a.bin"), "the buffer \"../a.bin\" lies elsewhere"),
        (text.replace("\"count\":6,\"min\"", "\"count\":7,\"min\""), "accessor 1 reaches beyond its buffer"),
        (text.replace("\"children\":[1]", "\"children\":[1,0]"), "node 0 does not exist, or stands in two places"),
        (text.replace("\"POSITION\":1", "\"POSITION\":9"), "accessor 9 does not exist"),
        (
            text.replace("\"scene\":0", "\"extensionsRequired\":[\"KHR_draco_mesh_compression\"]"),
            "needs the extension KHR_draco",
        ),
        (text.replace("\"asset\"", "asset"), "not the JSON of glTF 2.0"),
    ] {
        let message = refusal("a.gltf", &text);
        assert!(message.contains(told), "{told}: {message}");
    }
}

#[test]
fn what_is_no_mesh_is_named() {
    let pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 123\n";
    for extension in rhexis_scene::mesh_file::EXTENSIONS {
        let name = format!("a.{extension}");
        let message = refusal(&name, pointer);
        assert!(message.contains("a Git LFS pointer: fetch the file itself"), "{message}");
        assert!(refusal(&name, "<!DOCTYPE html><html>").contains("a web page: download the file itself"));
        assert!(refusal(&name, b"\x1f\x8b\x08\x00more").contains("compressed with gzip: unpack it first"));
    }
}

#[test]
fn samples_of_other_programs_still_count_the_same() {
    let file = with("a.msh", std::fs::read(data("gmsh_patch.msh")).unwrap(), &Reading::default());
    assert_eq!((file.mesh.positions.len(), file.mesh.triangles.len()), (3_497, 6_795));
    assert_eq!((file.tidied.joined, file.tidied.turned), (0, 0));
}
