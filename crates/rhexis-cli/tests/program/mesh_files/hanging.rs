//! Vertices on edges of triangles that do not have them: named, and split in by `repair`; lists of a repaired file; closed thin solids.

use super::reading::{MATERIAL, force, refusal, scene, summary};
use rhexis::storage::Triangles;
use rhexis_scene::mesh_file::{MeshFile, Reading, from_bytes_with};
use std::path::Path;

fn repaired(text: &str) -> MeshFile {
    let reading = Reading { repair: true, ..Reading::default() };
    from_bytes_with(Path::new("a.obj"), text.into(), &reading).unwrap_or_else(|error| panic!("{error}"))
}

/// A square of 1 mm in quads: left of x = 0.5 between the heights `left`, right of it between `right`, with the vertices of both there.
fn halves(left: &[f64], right: &[f64]) -> String {
    let mut points: Vec<[f64; 2]> = Vec::new();
    let mut faces = String::new();
    for (from, heights) in [(0.0, left), (0.5, right)] {
        let mut row = |x: f64, y: f64| {
            let found = points.iter().position(|p| *p == [x, y]);
            1 + found.unwrap_or_else(|| {
                points.push([x, y]);
                points.len() - 1
            })
        };
        for y in heights.windows(2) {
            let corners = [row(from, y[0]), row(from + 0.5, y[0]), row(from + 0.5, y[1]), row(from, y[1])];
            faces += &format!("f {} {} {} {}\n", corners[0], corners[1], corners[2], corners[3]);
        }
    }
    points.iter().map(|[x, y]| format!("v {x} {y} 0\n")).collect::<String>() + &faces
}

fn two_densities(left: usize, right: usize) -> String {
    let [left, right] = [left, right].map(|n| (0..=n).map(|i| i as f64 / n as f64).collect::<Vec<f64>>());
    halves(&left, &right)
}

fn body(repair: bool) -> String {
    format!("mesh = {{ file = {{ path = \"a.obj\", repair = {repair} }} }}\n{PLAIN}")
}

const PLAIN: &str = "material = { young = 1, poisson = 0, thickness = 0.1 }\nplanar = true\n";

/// A strip is E·h·w·ε = 1 MPa · 0.1 mm · 1 mm · 0.05, whatever the vertices at its middle.
#[test]
fn hanging_vertices_are_split_in_by_repair() {
    for (left, right, hanging) in [(1, 2, 1), (4, 1, 3), (2, 3, 3), (5, 7, 10)] {
        let text = two_densities(left, right);
        assert_eq!(repaired(&text).tidied.defects.hanging, hanging, "{left} {right}");
        let force = force(&[("a.obj", &text)], &body(true));
        assert!((force - 0.005).abs() < 1e-9, "{left} {right}: {force}");
        let (mesh, text) = summary(&[("a.obj", &text)], &body(true));
        assert_eq!((mesh.pieces, mesh.boundary_loops, mesh.hanging), (1, 1, 0), "{left} {right}");
        assert!(text.contains(&format!("repaired: {hanging} vertices on the edge of a triangle")), "{text}");
    }
    // The last digit of a file may keep a vertex off the edge.
    let skew = "v 0 0 0\nv 1 1 0\nv 0.333333 0.333334 0\nv 0 1 0\nv 1 0 0\nf 1 5 2\nf 1 3 4\nf 3 2 4\n";
    assert_eq!(repaired(skew).tidied.defects.hanging, 1);
    // A triangle without area that fills the slit is dropped, and the vertex split in.
    let filled =
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0.5 0 0\nv 0 -1 0\nv 1 -1 0\nf 1 2 3\nf 1 4 2\nf 1 5 4\nf 4 5 6\nf 4 6 2\n";
    let file = repaired(filled);
    assert_eq!((file.tidied.defects.empty, file.tidied.defects.hanging, file.mesh.triangles.len()), (1, 1, 5));
}

#[test]
fn hanging_vertices_are_named_and_left_without_repair() {
    let text = halves(&[0.0, 0.25, 0.75, 1.0], &[0.0, 0.25, 0.5, 0.75, 1.0]);
    let (mesh, told) = summary(&[("a.obj", &text)], &body(false));
    assert_eq!((mesh.hanging, mesh.repaired.as_str()), (1, ""));
    assert!(told.contains("1 vertices lie on edges of triangles that do not have them"), "{told}");
    assert!(told.contains("at (0.5, 0.5, 0) on the edge from (0.5, 0.25, 0) to (0.5, 0.75, 0) of triangle"), "{told}");
    assert!(told.contains("`repair = true`"), "{told}");
    assert!(force(&[("a.obj", &text)], &body(false)) < 0.00499);
    assert!((force(&[("a.obj", &text)], &body(true)) - 0.005).abs() < 1e-9);
    // Where the ends of the edge are bowties the file is refused, by both names.
    let message = refusal(&[("a.obj", &two_densities(1, 2))], &body(false));
    assert!(message.contains("2 bowtie(s)"), "{message}");
    let named =
        "1 vertices on the edge of a triangle that does not have them (at (0.500000, 0.500000, 0.000000) line 9)";
    assert!(message.contains(named), "{message}");
    // Vertices that meet do not hang, nor do those of lips parted at equal places.
    for (left, right) in [(1, 1), (3, 3)] {
        assert_eq!(summary(&[("a.obj", &two_densities(left, right))], &body(false)).0.hanging, 0);
    }
}

/// Lines of a list are those of the file, whichever triangles `repair` has dropped or split.
#[test]
fn lists_count_the_triangles_of_the_file_after_repair() {
    // A double triangle first, and one that is split at a hanging vertex last.
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0 0\nv 0.5 -1 0\nv 0 -1 0\nv 1 -1 0\n\
        f 1 3 4\nf 3 4 1\nf 7 6 1\nf 1 6 5\nf 5 6 2\nf 2 6 8\nf 1 2 3\n";
    let list = "per_triangle = { thickness = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7] }\n";
    let fibres = "fibres = { file = \"f.txt\" }\n";
    let directions: String = (0..7).map(|i| format!("1 {i} 0\n")).collect();
    let files = [("a.obj", text), ("f.txt", directions.as_str())];
    let instance = scene(&files, &format!("{}{list}{fibres}", body(true))).unwrap().instantiate().unwrap();
    let triangles = instance.simulation.world().get::<&Triangles>(instance.bodies[0].entity()).unwrap();
    let thickness: Vec<f64> = (0..7).map(|t| triangles.thickness[t]).collect();
    assert_eq!(thickness, [0.1, 0.3, 0.4, 0.5, 0.6, 0.7, 0.7]);
    let message = refusal(&files, &format!("{}per_triangle = {{ thickness = [1, 2] }}\n", body(true)));
    assert!(message.contains("the list has 2 entries, and the mesh 7 triangles"), "{message}");
    let files = [("a.obj", text), ("f.txt", "1 0 0\n")];
    let message = refusal(&files, &format!("{}{fibres}", body(true)));
    assert!(message.contains("f.txt has 1 entries, and the mesh 7 triangles"), "{message}");
}

/// A plate of 1 x 10 mm with its skin closed is a thin solid; a block and an open box are not.
#[test]
fn a_closed_thin_solid_is_said_to_be_one() {
    let slab = |height: f64| {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 10.0], [0.0, 10.0]];
        let vertices = [0.0, height].map(|z| corners.map(|[x, y]| format!("v {x} {y} {z}\n")).concat()).concat();
        format!("{vertices}f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n")
    };
    let lines = format!("mesh = {{ file = \"a.obj\" }}\n{MATERIAL}");
    let told = |text: &str| summary(&[("a.obj", text)], &lines);
    // Twice the volume over the area of all faces.
    let (mesh, text) = told(&slab(0.05));
    let thickness = 2.0 * 0.5 / (20.0 + 2.0 * 0.05 * 11.0);
    assert!(mesh.thin_solid.is_some_and(|found| (found - thickness).abs() < 1e-12), "{:?}", mesh.thin_solid);
    assert!(text.contains("the skin of a thin solid (0.04739 mm in the mean"), "{text}");
    assert_eq!(told(&slab(2.0)).0.thin_solid, None);
    assert_eq!(told(&slab(0.05).replace("f 4 3 2 1\n", "")).0.thin_solid, None);
}
