//! How a scene has its mesh file read: joined, mended, turned, placed; its fibres and its values per triangle; and what `check` says of it.

use super::as_they_are::MSH_2;
use super::samples::{PLY, VTU};
use glam::{DVec3, dvec3};
use rhexis::simulation::Simulation;
use rhexis::storage::{BodyId, TriangleMesh, Triangles};
use rhexis_scene::mesh_file::{MeshFile, Reading, from_bytes_with};
use rhexis_scene::{MeshSummary, Scene, SceneError};
use std::path::Path;

/// A scene of one body with these lines, whose files lie beside it; pulled by 5 % from `left` to `right` if it spans 0 to 1 along x.
pub(super) fn scene(files: &[(&str, &str)], lines: &str) -> Result<Scene, SceneError> {
    let folder = tempfile::tempdir().unwrap().keep();
    for (name, text) in files {
        std::fs::write(folder.join(name), text).unwrap();
    }
    let text = format!(
        "[scene]\nname = \"s\"\n[run]\nmode = \"static\"\ndt = 1\nsteps = 1\n[output]\npictures = 0\nframes = 0\n[[bodies]]\nname = \"b\"\n{lines}\n\
         [[bodies.holds]]\nname = \"left\"\nregion = {{ x = 0 }}\n[[bodies.holds]]\nname = \"right\"\nregion = {{ x = 1 }}\n\
         move = {{ offset = [0.05, 0, 0] }}\n"
    );
    let path = folder.join("s.toml");
    std::fs::write(&path, text).unwrap();
    Scene::load(&path)
}

pub(super) const MATERIAL: &str = "material = { young = 1, poisson = 0.3, thickness = 0.1 }\n";

pub(super) fn force(files: &[(&str, &str)], lines: &str) -> f64 {
    let mut instance = scene(files, lines).unwrap().instantiate().unwrap_or_else(|error| panic!("{error}"));
    instance.advance().unwrap();
    instance.simulation.reactions(instance.bodies[0]).unwrap()[1].1.x
}

pub(super) fn summary(files: &[(&str, &str)], lines: &str) -> (MeshSummary, String) {
    let summary = scene(files, lines).unwrap().check().unwrap_or_else(|error| panic!("{error}"));
    (summary.bodies[0].mesh.clone(), summary.to_string())
}

pub(super) fn refusal(files: &[(&str, &str)], lines: &str) -> String {
    scene(files, lines).and_then(|scene| scene.check()).unwrap_err().to_string()
}

fn with(name: &str, text: &str, reading: &Reading) -> MeshFile {
    from_bytes_with(Path::new(name), text.as_bytes().to_vec(), reading).unwrap_or_else(|error| panic!("{error}"))
}

/// Pulled by 5 %, E·h·width·strain is 0.005 N; held sides that cannot narrow make it stiffer by less than 1/(1 − ν²).
fn is_of_a_whole_square(force: f64) -> bool {
    (0.005..0.0055).contains(&force)
}

const SEAM: &str =
    "v 0 0 0\nv 0.5 0 0\nv 0.5 1 0\nv 0 1 0\nv 0.5 0 0\nv 1 0 0\nv 1 1 0\nv 0.5 1 0\nf 1 2 3 4\nf 5 6 7 8\n";

#[test]
fn a_seam_is_told_and_joined() {
    let plain = format!("mesh = {{ file = \"a.obj\" }}\n{MATERIAL}");
    let (mesh, text) = summary(&[("a.obj", SEAM)], &plain);
    assert_eq!((mesh.pieces, mesh.boundary_loops, mesh.coincident, mesh.joined), (2, 2, 2, 0));
    assert!(
        text.contains("2 piece(s), 2 boundary loop(s)") && text.contains("2 vertices lie where others do"),
        "{text}"
    );
    let joined = format!("mesh = {{ file = {{ path = \"a.obj\", weld = 1e-6 }} }}\n{MATERIAL}");
    let (mesh, text) = summary(&[("a.obj", SEAM)], &joined);
    assert_eq!((mesh.pieces, mesh.boundary_loops, mesh.coincident, mesh.joined), (1, 1, 0, 2));
    assert!(text.contains("2 vertices joined") && !text.contains("note:"), "{text}");
    let force = force(&[("a.obj", SEAM)], &joined);
    assert!(is_of_a_whole_square(force), "{force}");
    // Farther apart than the tolerance: as they are; and a tolerance in mm of a file in another unit.
    let near = SEAM.replacen("v 0.5 0 0\nv 1 0", "v 0.50001 0 0\nv 1 0", 1);
    let near = near.replacen("v 0.5 1 0\nf", "v 0.50001 1 0\nf", 1);
    let (mesh, _) = summary(&[("a.obj", &near)], &joined);
    assert_eq!((mesh.pieces, mesh.joined, mesh.coincident), (2, 0, 0));
    let metres: String = near
        .lines()
        .map(|line| match line.strip_prefix("v ") {
            Some(numbers) => {
                let numbers = numbers.split(' ').map(|word| (word.parse::<f64>().unwrap() * 1e-3).to_string());
                format!("v {}\n", numbers.collect::<Vec<_>>().join(" "))
            }
            None => format!("{line}\n"),
        })
        .collect();
    let table = "mesh = { file = { path = \"a.obj\", unit = \"m\", weld = 1e-3 } }\n";
    assert_eq!(summary(&[("a.obj", &metres)], &format!("{table}{MATERIAL}")).0.joined, 2);
}

/// Joining is linear work and makes what a comparison of all pairs makes.
#[test]
fn joining_is_that_of_all_pairs() {
    let points: Vec<DVec3> = (0..400)
        .map(|i| {
            let at = |k: u64| ((i * k) % 97) as f64 / 97.0;
            dvec3(at(31), at(57), at(11)) * 0.2
        })
        .collect();
    let tolerance = 0.02;
    let mut first: Vec<usize> = Vec::new();
    for (row, p) in points.iter().enumerate() {
        let near = (0..row).find(|&other| first[other] == other && points[other].distance(*p) <= tolerance);
        first.push(near.unwrap_or(row));
    }
    let kept = first.iter().enumerate().filter(|(row, first)| row == *first).count();
    // Each point has a triangle of its own, far off, so that it is used.
    let mut text = String::new();
    for (i, p) in points.iter().enumerate() {
        text += &format!("v {} {} {}\nv {i} 5 5\nv {i} 5 9\n", p.x, p.y, p.z);
        text += &format!("f {} {} {}\n", 3 * i + 1, 3 * i + 2, 3 * i + 3);
    }
    let reading = Reading { weld: Some(tolerance), repair: true, ..Reading::default() };
    let file = with("a.obj", &text, &reading);
    assert_eq!(file.tidied.joined, points.len() - kept);
}

/// An octahedron, whose triangles face outwards.
fn octahedron() -> TriangleMesh {
    let positions = vec![DVec3::X, DVec3::Y, DVec3::NEG_X, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
    let triangles = (0..4).flat_map(|i| [[i, (i + 1) % 4, 4], [(i + 1) % 4, i, 5]]).collect();
    TriangleMesh {
        positions: positions.into_iter().map(|p| p + dvec3(100.0, 0.0, 0.0)).collect(),
        triangles,
        fibres: None,
    }
}

fn obj(mesh: &TriangleMesh) -> String {
    let vertices = mesh.positions.iter().map(|p| format!("v {} {} {}\n", p.x, p.y, p.z));
    let faces = mesh.triangles.iter().map(|t| format!("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1));
    vertices.chain(faces).collect()
}

fn volume(mesh: &TriangleMesh) -> f64 {
    let of = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
        a.dot(b.cross(c)) / 6.0
    };
    mesh.triangles.iter().map(of).sum()
}

#[test]
fn closed_pieces_face_outwards_and_open_ones_as_most_do() {
    for turned in [vec![0], vec![3, 5], (0..8).collect(), (0..7).collect()] {
        let mut mesh = octahedron();
        turned.iter().for_each(|&t: &usize| mesh.triangles[t].swap(1, 2));
        let file = with("a.obj", &obj(&mesh), &Reading::default());
        assert_eq!((file.mesh.clone(), file.tidied.turned), (octahedron(), turned.len()));
        let file = with("a.obj", &obj(&mesh), &Reading { flip: true, ..Reading::default() });
        // The volume of two pyramids of base 2 and height 1.
        assert!((volume(&file.mesh) + 4.0 / 3.0).abs() < 1e-12, "{}", volume(&file.mesh));
    }
    let strip = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 2 0\nv 1 2 0\nf 1 3 2\nf 2 4 3\nf 3 4 5\nf 4 6 5\n";
    let file = with("a.obj", strip, &Reading::default());
    assert_eq!((file.mesh.triangles[0], file.tidied.turned), ([0, 1, 2], 1));
}

#[test]
fn repairing_drops_and_splits_and_says_what() {
    // A square whose faces are there twice, one without area, a fin at the diagonal, and a triangle at corner 3 alone.
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.5 1\nv 2 2 0\nv 1 2 0\nv 0.5 0 0\n\
        f 1 2 3\nf 1 3 4\nf 1 3 5\nf 3 2 1\nf 1 8 2\nf 3 6 7\nf 4 4 1\n";
    let plain = format!("mesh = {{ file = \"a.obj\" }}\n{MATERIAL}");
    let message = refusal(&[("a.obj", text)], &plain);
    for told in [
        "2 triangle(s) without area (line 13, line 15)",
        "1 double triangle(s) (line 12 as line 9)",
        "1 edge(s) of more than two triangles (line 9, line 10, line 11)",
        "1 bowtie(s): vertices that join triangles without a common edge (at (1.000000, 1.000000, 0.000000) line 14)",
        "repair = true",
    ] {
        assert!(message.contains(told), "{told}: {message}");
    }
    let table = format!("mesh = {{ file = {{ path = \"a.obj\", repair = true }} }}\n{MATERIAL}");
    let (mesh, shown) = summary(&[("a.obj", text)], &table);
    assert_eq!((mesh.pieces, mesh.coincident), (2, 1), "the copy of corner 3 lies on it");
    assert!(shown.contains("repaired: 2 triangle(s) without area"), "{shown}");
    let file = with("a.obj", text, &Reading { repair: true, ..Reading::default() });
    assert_eq!(file.mesh.triangles.len(), 3);
    assert_eq!(file.mesh.positions.len(), 7);
    assert!(is_of_a_whole_square(force(&[("a.obj", text)], &table)));
    // A fan of bowties: every fan but the first gets its own copy.
    let spokes: String = (0..5).map(|i| format!("v {} 1 0\nv {} 1.5 0\n", 2 * i, 2 * i)).collect();
    let faces: String = (0..5).map(|i| format!("f 1 {} {}\n", 2 * i + 2, 2 * i + 3)).collect();
    let file = with("a.obj", &format!("v 9 0 0\n{spokes}{faces}"), &Reading { repair: true, ..Reading::default() });
    assert_eq!((file.mesh.positions.len(), file.tidied.defects.bowties), (15, 1));
}

#[test]
fn a_mesh_is_placed_where_the_scene_wants_it() {
    // The square of 1 m, upright across y, behind x = 2 m.
    let upright = "v 2 0 0\nv 3 0 0\nv 3 0 1\nv 2 0 1\nf 1 2 3 4\n";
    let table =
        "mesh = { file = { path = \"a.obj\", unit = \"m\", rotate = [-90, 0, 0], translate = [-2000, 0, 3] } }\n";
    let instance = scene(&[("a.obj", upright)], &format!("{table}{MATERIAL}planar = true"));
    let error = instance.unwrap().check().unwrap_err().to_string();
    assert!(error.contains("selects no vertex: the body spans x 0 to 1000, y 0 to 1000, z 3 to 3 mm"), "{error}");
    let table = table.replace("\"m\"", "\"mm\"").replace("-2000", "-2");
    assert!(is_of_a_whole_square(force(&[("a.obj", upright)], &format!("{table}{MATERIAL}planar = true"))));
    let both = "mesh = { file = { path = \"a.obj\", unit = \"m\", scale = 2 } }\n";
    assert!(refusal(&[("a.obj", upright)], &format!("{both}{MATERIAL}")).contains("give either `unit` or `scale`"));
    let unknown = "mesh = { file = { path = \"a.obj\", unit = \"mile\" } }\n";
    let message = refusal(&[("a.obj", upright)], &format!("{unknown}{MATERIAL}"));
    assert!(message.contains("mile") && message.contains("mm"), "{message}");
    let message = refusal(&[("a.obj", upright)], &format!("mesh = {{ file = \"a.obj\" }}\n{MATERIAL}planar = true"));
    assert!(message.contains("spread over 1e0 mm") && message.contains("rotate = [90, 0, 0]"), "{message}");
}

#[test]
fn what_is_almost_flat_is_flattened() {
    let almost = "v 0 0 0\nv 10 0 0.000004\nv 10 10 0.000002\nv 0 10 0\nf 1 2 3 4\n";
    let table = format!("mesh = {{ file = {{ path = \"a.obj\", scale = 0.1 }} }}\n{MATERIAL}planar = true");
    let (mesh, text) = summary(&[("a.obj", almost)], &table);
    assert!((mesh.flattened - 4e-7).abs() < 1e-20 && text.contains("flattened by up to 4.000e-7 mm"), "{text}");
    assert!(is_of_a_whole_square(force(&[("a.obj", almost)], &table)));
    let message = refusal(&[("a.obj", &almost.replace("0.000004", "0.004"))], &table);
    assert!(message.contains("not flat across z: its vertices spread over 4e-4 mm, 4.0e-4 of its extent"), "{message}");
}

/// Fibres of each name, on cells and on points, in each format; and a key for another name.
#[test]
fn fibres_are_found_by_their_usual_names() {
    let expected = Some(vec![DVec3::X, dvec3(0.0, 2.0, 0.0)]);
    for name in ["fibre", "fiber", "fibres", "fibers", "f0", "Fibers", "FIBRE", "F0"] {
        let file = with("a.vtu", &VTU.replace("Name=\"fibre\"", &format!("Name=\"{name}\"")), &Reading::default());
        assert_eq!(file.mesh.fibres, expected, "{name}");
        assert_eq!(file.fibres_from, Some(format!("{name:?} of the file's cells")));
    }
    let other = VTU.replace("Name=\"fibre\"", "Name=\"sheet\"");
    let file = with("a.vtu", &other, &Reading::default());
    assert_eq!((file.mesh.fibres.clone(), file.passed_over.clone()), (None, vec!["sheet".to_owned()]));
    let named = Reading { fibres: Some("sheet".into()), ..Reading::default() };
    assert_eq!(with("a.vtu", &other, &named).mesh.fibres, expected);
    let error = from_bytes_with(Path::new("a.vtu"), VTU.as_bytes().to_vec(), &named).unwrap_err().to_string();
    assert!(error.contains("the file has no array \"sheet\"; it has \"fibre\""), "{error}");
    // On points: the mean of the axes, whichever way each points.
    let on_points = "<PointData><DataArray type=\"Float32\" Name=\"f0\" NumberOfComponents=\"3\" format=\"ascii\">1 0 0 -1 0 0 0 1 0 1 0 0</DataArray>\
        </PointData><CellData>";
    let file = with("a.vtu", &other.replace("<PointData/><CellData>", on_points), &Reading::default());
    assert_eq!(file.mesh.fibres, Some(vec![dvec3(2.0, 1.0, 0.0), dvec3(2.0, 1.0, 0.0)]));
    // Gmsh's element data, as the array library of Python has it printed, and node data.
    let data = "$ElementData\n1\n\"Fibre\"\n1\n0.0\n3\n0\n3\n2\n3 np.float64(1.0) np.float64(0.0) 0\n4 0 2 0\n$EndElementData\n";
    assert_eq!(with("a.msh", &format!("{MSH_2}{data}"), &Reading::default()).mesh.fibres, expected);
    let later = data.replace("0.0\n3", "1.0\n3").replace("(1.0)", "(7.0)");
    assert_eq!(
        with("a.msh", &format!("{MSH_2}{data}{later}"), &Reading::default()).mesh.fibres,
        expected,
        "the first time"
    );
    let data = "$NodeData\n1\n\"f0\"\n1\n0.0\n3\n0\n3\n4\n12 1 0 0\n9 1 0 0\n7 1 0 0\n8 1 0 0\n$EndNodeData\n";
    assert_eq!(
        with("a.msh", &format!("{MSH_2}{data}"), &Reading::default()).mesh.fibres,
        Some(vec![DVec3::X * 3.0; 2])
    );
    let ply = PLY
        .replace(
            "vertex_indices\n",
            "vertex_indices\nproperty float fibre_x\nproperty float fibre_y\nproperty float fibre_z\n",
        )
        .replace("4 0 1 2 3", "4 0 1 2 3 0 0 1");
    assert_eq!(with("a.ply", &ply, &Reading::default()).mesh.fibres, Some(vec![DVec3::Z; 2]));
}

#[test]
fn the_check_says_where_fibres_come_from() {
    let material = "material = { young_fibre = 10, young_transverse = 1, poisson_major = 0.3, thickness = 0.1 }\n";
    let flat = VTU.replace("0.25", "0").replace("1 0 0 0 2 0<", "0 1 0 0 2 0<");
    let plain = format!("mesh = {{ file = \"a.vtu\" }}\n{material}");
    let across = force(&[("a.vtu", &flat.replace("\"fibre\"", "\"fibers\""))], &plain);
    assert!(across < 0.0060, "as across fibres of 1 MPa: {across}");
    let (_, text) = summary(&[("a.vtu", &flat)], &plain);
    assert!(text.contains("fibres from the array \"fibre\" of the file's cells"), "{text}");
    let other = flat.replace("\"fibre\"", "\"sheet\"");
    let (mesh, text) = summary(&[("a.vtu", &other)], &plain);
    assert_eq!(mesh.unused_arrays, ["sheet"]);
    assert!(text.contains("no array of fibres that is known by its name; arrays not used: sheet"), "{text}");
    assert!(force(&[("a.vtu", &other)], &plain) > 0.045, "along x, of 10 MPa");
    for line in ["fibres = { array = \"sheet\" }", "mesh.file = { path = \"a.vtu\", fibres = \"sheet\" }"] {
        let lines = if line.starts_with("mesh") { format!("{line}\n{material}") } else { format!("{plain}{line}") };
        assert_eq!(force(&[("a.vtu", &other)], &lines), across, "{line}");
    }
    let message = refusal(&[("a.vtu", &flat)], &format!("{plain}fibres = {{ array = \"none\" }}"));
    assert!(message.contains("the file has no array \"none\""), "{message}");
    let grid = "mesh = { grid = { width = 1, height = 1, nx = 2, ny = 2 } }\n";
    let message = refusal(&[], &format!("{grid}{material}fibres = {{ array = \"none\" }}"));
    assert!(message.contains("arrays are those of mesh files"), "{message}");
}

/// A remedy that fits: the folder is named where the file is not found, and nowhere else.
#[test]
fn remedies_fit() {
    let plain = format!("mesh = {{ file = \"a.vtk\" }}\n{MATERIAL}");
    let message = refusal(&[], &plain);
    assert!(message.contains("a relative path begins at the scene file's folder"), "{message}");
    let pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 123\n";
    let message = refusal(&[("a.vtk", pointer)], &plain);
    assert!(
        message.contains("a Git LFS pointer: fetch the file itself") && !message.contains("relative path"),
        "{message}"
    );
}

#[test]
fn thickness_comes_from_an_array() {
    let array = "<DataArray type=\"Float64\" Name=\"thick\" format=\"ascii\">0.3 0.3</DataArray></CellData>";
    let file = VTU.replace("0.25", "0").replace("</CellData>", array);
    let lines = format!("mesh = {{ file = \"a.vtu\" }}\n{MATERIAL}");
    let own = force(&[("a.vtu", &file)], &lines);
    let mapped = format!("{lines}per_triangle = {{ thickness = \"thick\" }}");
    let thrice = force(&[("a.vtu", &file)], &mapped);
    assert!((thrice / own - 3.0).abs() < 1e-9, "{thrice} {own}");
    // What is no number is the body's own thickness.
    let half = file.replace("0.3 0.3", "NaN 0.3");
    let instance = scene(&[("a.vtu", &half)], &mapped).unwrap().instantiate().unwrap();
    let triangles = instance.simulation.world().get::<&Triangles>(instance.bodies[0].entity()).unwrap();
    assert_eq!([0, 1].map(|t| triangles.thickness[t]), [0.1, 0.3]);
    for (file, lines, told) in [
        (&file, mapped.replace("thick\"", "thin\""), "the mesh has no array \"thin\": it has \"fibre\", \"thick\""),
        (&file, mapped.replace("\"thick\"", "\"fibre\""), "the array \"fibre\" has 3 numbers for a triangle, not 1"),
        (&file.replace("0.3 0.3", "0.3 -1"), mapped.clone(), "the array \"thick\" has -1 at triangle 1"),
        (
            &file,
            format!("{lines}per_triangle = {{ toughness = \"thick\" }}"),
            "a toughness is asked when it tears, and this body does not",
        ),
        (&file, lines.replace("0.1 }", "[0.1, 0.2] }"), "values per triangle are `per_triangle = { thickness"),
        (
            &file,
            lines.replace("0.1 }", "{ file = \"t.txt\" } }"),
            "values per triangle are `per_triangle = { thickness",
        ),
    ] {
        let message = refusal(&[("a.vtu", file)], &lines);
        assert!(message.contains(told), "{told}: {message}");
    }
}

/// The fibres of a body, and the centroid and normal of each triangle at rest.
fn fibres(simulation: &Simulation, body: BodyId, mesh: &TriangleMesh) -> Vec<(DVec3, DVec3, DVec3)> {
    let triangles = simulation.world().get::<&Triangles>(body.entity()).unwrap();
    let of = |t: usize| {
        let [a, b, c] = mesh.triangles[t].map(|v| mesh.positions[v as usize]);
        (triangles.fibre[t], (a + b + c) / 3.0, (b - a).cross(c - a).normalize())
    };
    (0..mesh.triangles.len()).map(of).collect()
}

/// The angle in the surface between the fibre and the direction that the field is named after, on a disc and on a tube.
#[test]
fn fields_about_an_axis_have_their_angle_everywhere() {
    let disc = rhexis::generate::disc(1.0, 500).unwrap();
    let about_z = |p: DVec3| (DVec3::Z.cross(p).normalize(), p.with_z(0.0).normalize());
    for degrees in [0.0_f64, 30.0, 90.0, -60.0] {
        for name in ["concentric", "radial"] {
            let lines = format!(
                "mesh = {{ disc = {{ radius = 1, triangles = 500 }} }}\n{MATERIAL}fibres = {{ {name} = {{ degrees = {degrees:?} }} }}"
            );
            let scene = format!("[scene]\nname = \"s\"\n[run]\ndt = 1\nsteps = 1\n[[bodies]]\nname = \"b\"\n{lines}\n");
            let instance = Scene::parse(&scene, "s.toml").unwrap().instantiate().unwrap();
            for (fibre, centroid, _) in fibres(&instance.simulation, instance.bodies[0], &disc) {
                let (around, out) = about_z(centroid);
                let [from, to] = if name == "radial" { [out, around] } else { [around, out] };
                let expected = from * degrees.to_radians().cos() + to * degrees.to_radians().sin();
                assert!(fibre.dot(expected).abs() > 1.0 - 1e-12, "{name} {degrees}: {fibre} for {expected}");
            }
        }
    }
    // A tube about x, of flat strips.
    let (n, m) = (24, 6);
    let at = |i: usize, j: usize| {
        let (sin, cos) = (std::f64::consts::TAU * i as f64 / n as f64).sin_cos();
        dvec3(j as f64 * 0.4, cos, sin)
    };
    let row = |i: usize, j: usize| (i % n * (m + 1) + j) as u32;
    let positions = (0..n).flat_map(|i| (0..=m).map(move |j| (i, j))).map(|(i, j)| at(i, j)).collect();
    let cells = (0..n).flat_map(|i| (0..m).map(move |j| (i, j)));
    let triangles = cells.flat_map(|(i, j)| {
        let (a, b, c, d) = (row(i, j), row(i + 1, j), row(i + 1, j + 1), row(i, j + 1));
        [[a, b, c], [a, c, d]]
    });
    let tube = TriangleMesh { positions, triangles: triangles.collect(), fibres: None };
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("tube.obj"), obj(&tube)).unwrap();
    for degrees in [0.0_f64, 35.0, 90.0] {
        let text = format!(
            "[scene]\nname = \"s\"\n[run]\ndt = 1\nsteps = 1\n[[bodies]]\nname = \"b\"\nmesh = {{ file = \"tube.obj\" }}\n{MATERIAL}\
             fibres = {{ helix = {{ axis = [1, 0, 0], degrees = {degrees:?} }} }}\n"
        );
        std::fs::write(folder.path().join("s.toml"), text).unwrap();
        let instance = Scene::load(&folder.path().join("s.toml")).unwrap().instantiate().unwrap();
        for (fibre, _, normal) in fibres(&instance.simulation, instance.bodies[0], &tube) {
            assert!(fibre.dot(normal).abs() < 1e-12);
            // The pitch to the axis: exact, for a flat strip runs along it.
            assert!((fibre.x.abs() - degrees.to_radians().sin().abs()).abs() < 1e-12, "{degrees}: {fibre}");
        }
    }
}

#[test]
fn the_check_is_a_doctor_of_meshes() {
    let lines = "mesh = { grid = { width = 1, height = 0.5, nx = 60, ny = 30 } }\nplanar = true\n\
        material = { young = 1, poisson = 0.3, thickness = 0.1 }\n\
        tearing = { strength_along_fibres = 1, strength_ratio = 2, radius = 0.05 }\n\
        energy_criterion = { toughness_along_fibres = 0.25, toughness_across_fibres = 0.75 }\nrefinement = { edges_per_radius = 5 }\n\
        cuts = [{ polyline = [[0.3, 0.25], [0.6, 0.25]] }]";
    let summary = scene(&[], lines).unwrap().check().unwrap();
    let mesh = &summary.bodies[0].mesh;
    assert_eq!((mesh.pieces, mesh.boundary_loops, mesh.coincident), (1, 1, 0), "before the cut");
    assert!((mesh.smallest_angle - 45.0).abs() < 1e-9, "{}", mesh.smallest_angle);
    let text = summary.to_string();
    for told in [
        // A sixtieth of a millimetre.
        "edges 0.01667 to 0.02357 mm",
        "smallest angle 45.0°",
        "tips advance by energy: along the fibres at 2.500e-1 N/mm, across at 7.500e-1 N/mm",
        "starts along the fibres at 1.000e0 MPa",
        "edges per radius, refined to 5.0 at tips",
        "of memory; a step is the work of",
        "fibres along x",
    ] {
        assert!(text.contains(told), "{told}: {text}");
    }
    // Without the criterion of energy the strengths decide.
    let by_stress =
        lines.replace("energy_criterion = { toughness_along_fibres = 0.25, toughness_across_fibres = 0.75 }\n", "");
    let text = scene(&[], &by_stress).unwrap().check().unwrap().to_string();
    assert!(text.contains("tears along the fibres at 1.000e0 MPa or ") && !text.contains("by energy"), "{text}");
    let coarse = by_stress
        .replace("refinement = { edges_per_radius = 5 }\n", "")
        .replace("nx = 60, ny = 30", "nx = 20, ny = 10");
    let text = scene(&[], &coarse).unwrap().check().unwrap().to_string();
    assert!(text.contains("figures want 3 or more"), "{text}");
}

/// A run says what its check says: in its summary and in its report.
#[test]
fn a_run_tells_of_seams() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.obj"), SEAM).unwrap();
    let text = format!(
        "[scene]\nname = \"s\"\n[run]\ndt = 1\nsteps = 1\n[output]\npictures = 0\nframes = 0\n[[bodies]]\nname = \"b\"\n\
         mesh = {{ file = \"a.obj\" }}\n{MATERIAL}"
    );
    std::fs::write(folder.path().join("s.toml"), text).unwrap();
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_rhexis"));
    let output = command.current_dir(folder.path()).args(["run", "s.toml"]).output().unwrap();
    let printed = String::from_utf8(output.stdout).unwrap();
    let report: serde_json::Value =
        serde_json::from_slice(&std::fs::read(folder.path().join("out/s/report.json")).unwrap()).unwrap();
    let told = "2 vertices lie where others do, and the mesh is in 2 piece(s) with 2 boundary loop(s)";
    assert!(printed.contains(told) && report["caveats"].to_string().contains(told), "{printed}");
    assert_eq!(report["bodies"][0]["mesh"]["coincident"], 2);
}
