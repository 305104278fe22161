//! Texture coordinates, normals and colours: read from mesh files, carried through cuts and tears, written as glTF, which the crate `gltf`
//! reads back.

use glam::{DVec3, Vec3, dvec3};
use rhexis::components::{Attributes, Channel};
use rhexis::frame::{BodyFrame, Frame};
use rhexis::generate;
use rhexis::simulation::Simulation;
use rhexis::storage::Vertices;
use rhexis_cli::output::{write_gltf, write_obj, write_ply};
use rhexis_scene::Document;
use rhexis_scene::mesh_file::{MeshFile, Reading, from_bytes_with};
use std::collections::BTreeSet;
use std::path::Path;

fn read(name: &str, bytes: impl Into<Vec<u8>>) -> MeshFile {
    from_bytes_with(Path::new(name), bytes.into(), &Reading::default()).unwrap_or_else(|error| panic!("{error}"))
}

fn channel(file: &MeshFile, channel: Channel) -> Vec<Vec<f64>> {
    let attributes = file.attributes.as_ref().unwrap();
    attributes.channel(channel).unwrap_or_else(|| panic!("no {}", channel.name())).map(<[f64]>::to_vec).collect()
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0 \nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvt 0.5 0.5\nvn 0 0 2\n";

#[test]
fn obj_gives_texture_coordinates_and_normals_by_corner() {
    let file = read("a.obj", format!("{SQUARE}f 1/1/1 2/2/1 3/3/1\nf -4/-5/-1 -2/-3/-1 -1/-2/-1\n"));
    assert_eq!(channel(&file, Channel::TextureCoordinates), [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    assert_eq!(channel(&file, Channel::Normal), [[0.0, 0.0, 1.0]; 4]);
    assert_eq!((file.seams, file.passed_over.len()), (0, 0));
}

/// The rule: the first texture coordinate of a vertex stands, and the vertex is counted.
#[test]
fn a_seam_keeps_the_first_texture_coordinate_and_is_counted() {
    let file = read("a.obj", format!("{SQUARE}f 1/1 2/2 3/3\nf 1/5 3/3 4/4\n"));
    assert_eq!(channel(&file, Channel::TextureCoordinates), [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    assert_eq!(file.seams, 1);
}

#[test]
fn what_not_every_vertex_has_is_left_out_and_told() {
    let file = read("a.obj", format!("{SQUARE}f 1/1 2/2 3/3\nf 1/1 3/3 4\n"));
    assert_eq!(file.attributes, None);
    assert_eq!(file.passed_over, ["texture coordinates (not at every vertex)"]);
    // Indices that are not there are none, as for programs that show the file.
    let file = read("a.obj", format!("{SQUARE}f 1/1/9 2/2/9 3/3/9\nf 1/1 3/99 4/4\n"));
    assert_eq!(channel(&file, Channel::TextureCoordinates)[2], [1.0, 1.0]);
    assert!(file.attributes.unwrap().channel(Channel::Normal).is_none());
}

#[test]
fn of_several_texture_coordinates_of_gltf_the_first_stand_and_the_others_are_named() {
    let corners: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let texture: [f32; 6] = [0.0, 1.0, 1.0, 1.0, 0.0, 0.0];
    let bytes: Vec<u8> = corners.iter().chain(&texture).flat_map(|number| number.to_le_bytes()).collect();
    let data = base64::Engine::encode(&base64::engine::general_purpose::STANDARD, bytes);
    let text = format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\"scene\":0,\"scenes\":[{{\"nodes\":[0]}}],\"nodes\":[{{\"mesh\":0}}],\
         \"meshes\":[{{\"primitives\":[{{\"attributes\":{{\"POSITION\":0,\"TEXCOORD_0\":1,\"TEXCOORD_1\":1}}}}]}}],\
         \"accessors\":[{{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[1,1,0]}},\
         {{\"bufferView\":1,\"componentType\":5126,\"count\":3,\"type\":\"VEC2\"}}],\
         \"bufferViews\":[{{\"buffer\":0,\"byteLength\":36}},{{\"buffer\":0,\"byteOffset\":36,\"byteLength\":24}}],\
         \"buffers\":[{{\"byteLength\":60,\"uri\":\"data:application/octet-stream;base64,{data}\"}}]}}"
    );
    let file = read("a.gltf", text);
    assert_eq!(channel(&file, Channel::TextureCoordinates), [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
    assert_eq!(file.passed_over, ["TEXCOORD_1 (of its kind the first set stands)"]);
}

#[test]
fn ply_gives_all_three_and_colours_from_bytes() {
    let head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty float nx\n\
                property float ny\nproperty float nz\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nproperty float s\n\
                property float t\nproperty float quality\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
    let rows = "0 0 0 0 0 1 255 0 51 0 0 7\n1 0 0 0 0 1 0 255 0 1 0 7\n0 1 0 0 0 1 0 0 255 0 0.5 7\n3 0 1 2\n";
    let file = read("a.ply", format!("{head}{rows}"));
    assert_eq!(channel(&file, Channel::TextureCoordinates), [[0.0, 0.0], [1.0, 0.0], [0.0, 0.5]]);
    assert_eq!(channel(&file, Channel::Normal), [[0.0, 0.0, 1.0]; 3]);
    assert_eq!(channel(&file, Channel::Colour)[0], [1.0, 0.0, 0.2, 1.0]);
    assert_eq!(file.passed_over, ["quality"]);
}

/// A triangle whose normals face the other side than its corners say: the triangle alone has no other opinion to follow, `flip` turns both.
#[test]
fn normals_lie_on_the_side_of_the_triangles() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 -1\nf 1//1 2//1 3//1\n";
    assert_eq!(channel(&read("a.obj", text), Channel::Normal), [[0.0, 0.0, 1.0]; 3]);
    let flipped = Reading { flip: true, ..Reading::default() };
    let file = from_bytes_with(Path::new("a.obj"), text.into(), &flipped).unwrap();
    assert_eq!(channel(&file, Channel::Normal), [[0.0, 0.0, -1.0]; 3]);
}

/// u and v as a linear function of the place.
fn uv(p: DVec3) -> [f64; 2] {
    [0.5 + p.x / 40.0, 0.25 + p.y / 50.0]
}

/// A body of this mesh, cut and bent, with texture coordinates, normals and colours.
fn torn() -> Frame {
    let mesh = generate::cap(10.0, 10.0, 400).unwrap();
    let values = mesh.positions.iter().flat_map(|&p| {
        let [u, v] = uv(p);
        let n = (p - dvec3(0.0, 0.0, p.z - 10.0)).normalize();
        [u, v, n.x, n.y, n.z, 0.2, 0.4, 0.6, 1.0]
    });
    let channels = vec![(Channel::TextureCoordinates, 0), (Channel::Normal, 2), (Channel::Colour, 5)];
    let attributes = Attributes { stride: 9, values: values.collect(), channels };
    let membrane = rhexis::membrane::Membrane::new("cap", mesh, rhexis::components::Material::allard_2009());
    let mut simulation = Simulation::new(rhexis::settings::Settings::default()).unwrap();
    let body = simulation.spawn(membrane.with(attributes)).unwrap();
    simulation.cut(body, &[dvec3(-3.1, 0.2, 0.0), dvec3(0.4, 1.0, 0.0), dvec3(3.3, -0.7, 0.0)]).unwrap();
    // Every vertex by another way, so that the lips part: a reader joins what lies at one place.
    let mut vertices = simulation.world_mut().get::<&mut Vertices>(body.entity()).unwrap();
    (0..).zip(&mut vertices.position).for_each(|(row, x)| x.z += 0.01 * x.x * x.x + 1e-3 * f64::from(row));
    drop(vertices);
    simulation.frame()
}

/// What another reader finds in a .glb file.
struct Found {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    uv: Vec<[f32; 2]>,
    colours: Vec<[f32; 4]>,
    indices: Vec<u32>,
    image: Option<usize>,
}

fn found(path: &Path) -> Found {
    let file = gltf::Gltf::from_slice(&std::fs::read(path).unwrap()).unwrap_or_else(|error| panic!("{error}"));
    let blob = file.blob.clone().unwrap();
    let mesh = file.document.meshes().next().unwrap();
    let primitive = mesh.primitives().next().unwrap();
    let reader = primitive.reader(|_| Some(&blob));
    let node = file.document.nodes().next().unwrap();
    assert_eq!(node.transform().decomposed().2, [1e-3; 3], "metres");
    Found {
        positions: reader.read_positions().unwrap().map(Vec3::from).collect(),
        normals: reader.read_normals().unwrap().map(Vec3::from).collect(),
        uv: reader.read_tex_coords(0).map_or(Vec::new(), |list| list.into_f32().collect()),
        colours: reader.read_colors(0).map_or(Vec::new(), |list| list.into_rgba_f32().collect()),
        indices: reader.read_indices().unwrap().into_u32().collect(),
        image: file.document.images().next().map(|image| match image.source() {
            gltf::image::Source::View { view, mime_type } => {
                assert_eq!(mime_type, "image/png");
                view.length()
            }
            gltf::image::Source::Uri { .. } => panic!("the image is in the file"),
        }),
    }
}

// Tolerance: single precision, of coordinates up to 10 mm.
#[test]
fn a_torn_body_as_gltf_is_what_another_reader_finds() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.glb");
    let frame = torn();
    let body: &BodyFrame = &frame.bodies[0];
    write_gltf(&path, body, Some(b"\x89PNG\r\n\x1a\n?")).unwrap();
    let found = found(&path);
    assert_eq!(found.indices, body.triangles.as_flattened());
    assert_eq!(found.positions, body.positions.iter().map(|p| p.as_vec3()).collect::<Vec<_>>());
    assert_eq!(found.image, Some(9));
    assert_eq!(found.colours.len(), body.positions.len());
    for (i, rest) in body.rest_positions.iter().enumerate() {
        let [u, v] = uv(*rest);
        assert!(
            (f64::from(found.uv[i][0]) - u).abs() < 1e-6 && (f64::from(1.0 - found.uv[i][1]) - v).abs() < 1e-6,
            "{i}"
        );
        assert!((found.normals[i].length() - 1.0).abs() < 1e-6, "{i}");
        assert!((found.colours[i][2] - 0.6).abs() < 1e-6);
    }
    // And by the engine's own, from which a scene would go on.
    let again = read("a.glb", std::fs::read(&path).unwrap());
    assert_eq!(again.seams, 0);
    assert!(again.mesh.positions.iter().zip(&body.positions).all(|(a, b)| a.distance(*b) < 1e-5));
    let back = channel(&again, Channel::TextureCoordinates);
    assert!(back.iter().zip(&body.rest_positions).all(|(found, rest)| (found[1] - uv(*rest)[1]).abs() < 1e-6));
}

/// Numbers of OBJ and of binary PLY read back to the same bits; the reader of OBJ numbers vertices as triangles use them.
#[test]
fn a_torn_body_as_obj_and_ply_keeps_its_texture_coordinates() {
    let folder = tempfile::tempdir().unwrap();
    let frame = torn();
    let body = &frame.bodies[0];
    let [obj, ply] = ["a.obj", "a.ply"].map(|name| folder.path().join(name));
    write_obj(&obj, body).unwrap();
    write_ply(&ply, body).unwrap();
    let carried = body.attributes.as_ref().unwrap();
    let carried: Vec<&[f64]> = carried.channel(Channel::TextureCoordinates).unwrap().collect();
    for path in [obj, ply] {
        let file = read(path.file_name().unwrap().to_str().unwrap(), std::fs::read(&path).unwrap());
        let back = channel(&file, Channel::TextureCoordinates);
        assert_eq!((back.len(), file.seams), (carried.len(), 0));
        let corners = file.mesh.triangles.iter().zip(&body.triangles);
        for (found, own) in corners.flat_map(|(found, own)| found.iter().zip(own)) {
            assert_eq!(back[*found as usize], carried[*own as usize], "{}", path.display());
        }
    }
}

/// Lips that lie on each other are joined when they are read: at one place and with one texture coordinate they are no seam.
#[test]
fn joined_vertices_are_a_seam_where_their_texture_coordinates_differ() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.glb");
    let mut frame = torn();
    let body = &mut frame.bodies[0];
    body.positions.clone_from(&body.rest_positions);
    write_gltf(&path, body, None).unwrap();
    let file = read("a.glb", std::fs::read(&path).unwrap());
    let places: BTreeSet<[u64; 3]> = body.positions.iter().map(|p| p.to_array().map(f64::to_bits)).collect();
    let on_lips = body.positions.len() - places.len();
    assert!(on_lips > 3);
    assert_eq!((file.tidied.joined, file.seams), (on_lips, 0));
    // The last vertex lies on a lip: it is one that the cut has added.
    let last = body.positions.len() - 1;
    body.attributes.as_mut().unwrap().values[9 * last] += 0.25;
    write_gltf(&path, body, None).unwrap();
    let file = read("a.glb", std::fs::read(&path).unwrap());
    assert_eq!(file.seams, 1);
}

#[test]
fn a_body_without_attributes_has_normals_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.glb");
    let mut frame = torn();
    frame.bodies[0].attributes = None;
    write_gltf(&path, &frame.bodies[0], None).unwrap();
    let found = found(&path);
    assert!(found.uv.is_empty() && found.colours.is_empty() && found.image.is_none());
    frame.bodies[0].attributes = Some(Attributes::new(1, vec![0.0; 3]));
    let error = write_gltf(&path, &frame.bodies[0], None).unwrap_err().to_string();
    assert!(error.contains("has 3 entries in `attributes` where"), "{error}");
    let error = write_gltf(&path, &BodyFrame::default(), None).unwrap_err().to_string();
    assert!(error.contains("no triangles"), "{error}");
}

/// The tutorial: an OBJ with a texture, groups and a hole becomes a torn glTF with its texture.
#[test]
fn the_textured_sheet_tears_and_keeps_its_texture() {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/textured/torn.toml");
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_rhexis"));
        let output = command.args(arguments).arg(&scene).current_dir(folder.path()).output().unwrap();
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{error}");
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    let told = run(&["check"]);
    assert!(
        told.contains("2 boundary loop(s)") && told.contains("vertices have texture coordinates, normals"),
        "{told}"
    );
    run(&["run", "--set", "output.pictures=0", "--quiet"]);
    let found = found(&folder.path().join("out/textured/surface-0.glb"));
    let start = read("sheet.obj", std::fs::read(scene.with_file_name("sheet.obj")).unwrap());
    assert_eq!(start.groups.len(), 3);
    assert!(found.positions.len() > start.mesh.positions.len() + 20, "it has torn");
    assert_eq!(found.image, Some(std::fs::metadata(scene.with_file_name("skin.png")).unwrap().len() as usize));
    // What is held has gone outwards and kept its texture coordinates, of which the file has four digits (of 16 mm); a torn vertex lies twice at
    // one of them.
    for (p, [u, v]) in found.positions.iter().zip(&found.uv) {
        assert!((-1e-6..=1.000001).contains(u) && (-1e-6..=1.000001).contains(v), "{u} {v}");
        if *u == 0.0 {
            assert!(p.x < -12.0 && (f64::from(1.0 - v) * 16.0 - 8.0 - f64::from(p.y)).abs() < 1e-3, "{p}");
        }
    }
    let mut places: Vec<[u32; 2]> = found.uv.iter().map(|uv| uv.map(f32::to_bits)).collect();
    places.sort_unstable();
    let twice = places.windows(2).filter(|pair| pair[0] == pair[1]).count();
    assert!(twice >= 8, "{twice} vertices on two lips");
}

#[test]
fn a_texture_is_judged_before_the_run() {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/textured/torn.toml");
    let refused = |set: &str| {
        let mut document = Document::load(&scene).unwrap();
        document.set(set).unwrap();
        document.scene().and_then(|scene| scene.instantiate()).map(|_| ()).unwrap_err().to_string()
    };
    let error = refused("bodies.0.texture=\"sheet.obj\"");
    assert!(error.contains("neither a PNG nor a JPEG"), "{error}");
    let error = refused("bodies.0.texture=\"absent.png\"");
    assert!(error.contains("absent.png"), "{error}");
    let error = refused("bodies.0.mesh={ grid = { width = 24, height = 16, nx = 12, ny = 8 } }");
    assert!(error.contains("no texture coordinates"), "{error}");
}

/// A sheet of 12 mm with two charts that meet at x = 6: u is x/12, and a quarter more beyond. Drawn apart until torn, refined around tips.
#[test]
fn texture_seams_are_kept_while_a_sheet_tears() {
    let folder = tempfile::tempdir().unwrap();
    let of = |x: f64, y: f64, is_beyond: bool| [x / 12.0 + if is_beyond { 0.25 } else { 0.0 }, y / 12.0];
    let mut text = String::new();
    for (y, x) in (0..13).flat_map(|y| (0..13).map(move |x| (y, x))) {
        text += &format!("v {x} {y} 0\n");
        for is_beyond in [false, true] {
            let [u, v] = of(f64::from(x), f64::from(y), is_beyond);
            text += &format!("vt {u} {v}\n");
        }
    }
    for (y, x) in (0..12).flat_map(|y| (0..12).map(move |x| (y, x))) {
        let corner = |dx: usize, dy: usize| {
            let vertex = 13 * (y + dy) + x + dx + 1;
            format!("{vertex}/{}", 2 * vertex - usize::from(x < 6))
        };
        text += &format!("f {} {} {} {}\n", corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1));
    }
    std::fs::write(folder.path().join("sheet.obj"), text).unwrap();
    let scene = "[scene]\nname = \"uv\"\n[run]\ndt = 5\nsteps = 60\nuntil_torn = true\n\
        [output]\npictures = 0\nframes = 1\ngltf = true\nobj = true\nply = true\n\
        [[bodies]]\nname = \"s\"\nmesh = { file = \"sheet.obj\" }\n\
        material = { young = 1, poisson = 0.3, thickness = 0.1 }\ndamping = 2\n\
        [bodies.tearing]\ntoughness_along_fibres = 0.002\ntoughness_across_fibres = 0.002\nradius = 1\n[bodies.refinement]\n\
        [[bodies.cuts]]\npolyline = [[0, 6.3], [3, 6.3]]\n\
        [[bodies.holds]]\nname = \"top\"\nregion = { y = 12 }\nmove = { offset = [0, 2, 0] }\ncurve = [[0, 0], [300, 1]]\n\
        [[bodies.holds]]\nname = \"bottom\"\nregion = { y = 0 }\nmove = { offset = [0, -2, 0] }\ncurve = [[0, 0], [300, 1]]\n";
    std::fs::write(folder.path().join("uv.toml"), scene).unwrap();
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_rhexis"));
    let output = command.args(["run", "uv.toml"]).current_dir(folder.path()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let out = folder.path().join("out/uv");
    let mut frames: Vec<_> = std::fs::read_dir(&out).unwrap().map(|entry| entry.unwrap().path()).collect();
    frames.retain(|path| path.extension().is_some_and(|extension| extension == "vtu"));
    frames.sort();
    let body = rhexis_cli::output::read_vtu(frames.last().unwrap()).unwrap();
    assert!(body.positions.len() > 13 * 13 + 20, "it has torn");
    let is_right = |triangle: usize, corner: usize, [u, v]: [f64; 2]| {
        let points = body.triangles[triangle].map(|vertex| body.rest_positions[vertex as usize]);
        let is_beyond = (points[0].x + points[1].x + points[2].x) / 3.0 > 6.0;
        let [a, b] = of(points[corner].x, points[corner].y, is_beyond);
        (a - u).abs() < 1e-6 && (b - v).abs() < 1e-6
    };
    // OBJ: the vertices of the body, and corners with a texture coordinate of their own.
    let obj = std::fs::read_to_string(out.join("surface-0.obj")).unwrap();
    let numbers = |line: &str| line.split(' ').map(|word| word.parse().unwrap()).collect::<Vec<f64>>();
    let uv: Vec<Vec<f64>> = obj.lines().filter_map(|line| line.strip_prefix("vt ")).map(numbers).collect();
    assert_eq!(obj.lines().filter(|line| line.starts_with("v ")).count(), body.positions.len());
    for (triangle, face) in obj.lines().filter_map(|line| line.strip_prefix("f ")).enumerate() {
        for (corner, word) in face.split(' ').enumerate() {
            let mut parts = word.split('/').map(|part| part.parse::<usize>().unwrap());
            assert_eq!(parts.next(), Some(body.triangles[triangle][corner] as usize + 1));
            let uv = &uv[parts.next().unwrap() - 1];
            assert!(is_right(triangle, corner, [uv[0], uv[1]]), "{triangle} {corner} {uv:?}");
        }
    }
    // glTF: a vertex for each of its texture coordinates, and normals without a crease.
    let found = found(&out.join("surface-0.glb"));
    assert!(found.positions.len() >= body.positions.len() + 13, "{}", found.positions.len());
    for (row, &vertex) in found.indices.iter().enumerate() {
        let [u, v] = found.uv[vertex as usize].map(f64::from);
        assert!(is_right(row / 3, row % 3, [u, 1.0 - v]), "{row} {u} {v}");
    }
    // Read again, it has its seam.
    let again = read("a.glb", std::fs::read(out.join("surface-0.glb")).unwrap());
    assert!(again.seams >= 13, "{}", again.seams);
    let ply = read("a.ply", std::fs::read(out.join("surface-0.ply")).unwrap());
    assert_eq!(channel(&ply, Channel::TextureCoordinates).len(), found.positions.len());
    let told = rhexis_scene::Scene::load(&folder.path().join("uv.toml")).unwrap().check().unwrap().to_string();
    assert!(told.contains("13 of them several texture coordinates"), "{told}");
}
