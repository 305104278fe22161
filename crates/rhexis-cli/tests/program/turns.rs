//! Regions by groups and arrays of mesh files, obstacles and holds that turn, and their forces and torques in files.

use glam::DVec3;
use rhexis::components::Holds;
use rhexis::storage::Vertices;
use rhexis_scene::{Instance, Scene};
use std::path::Path;
use std::process::Command;

fn scene(folder: &Path, mode: &str, body: &str, more: &str) -> Result<Instance, String> {
    let path = folder.join("s.toml");
    std::fs::write(&path, text(mode, body, more)).unwrap();
    Scene::load(&path).and_then(|scene| scene.instantiate()).map_err(|error| error.to_string())
}

fn text(mode: &str, body: &str, more: &str) -> String {
    format!(
        "[scene]\nname = 's'\n[run]\nmode = '{mode}'\ndt = 1\nsteps = 20\n[output]\npictures = 0\nframes = 0\n\
         [[bodies]]\nname = 'b'\nmaterial = {{ young = 1, poisson = 0.3, thickness = 0.1 }}\n{body}\n{more}"
    )
}

/// Four triangles: a square of 1 mm with its middle.
const VTK: &str = "# vtk DataFile Version 3.0\nsquare\nASCII\nDATASET POLYDATA\nPOINTS 5 float\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n\
    0.5 0.5 0\nPOLYGONS 4 16\n3 0 1 4\n3 1 2 4\n3 2 3 4\n3 3 0 4\nCELL_DATA 4\nSCALARS part int 1\nLOOKUP_TABLE default\n\
    1\n2\n3\n4\nPOINT_DATA 5\nSCALARS height float 1\nLOOKUP_TABLE default\n0\n1\n1\n0\n2\n";
const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.5 0\ng south\nf 1 2 5\ng east rest\nf 2 3 5\n\
    g rest\nf 3 4 5\nf 4 1 5\n";

fn held(folder: &Path, file: &str, region: &str) -> Result<Vec<u32>, String> {
    let hold = format!("[[bodies.holds]]\nname = 'h'\nregion = {{ {region} }}\n");
    let instance = scene(folder, "static", &format!("mesh = {{ file = '{file}' }}"), &hold)?;
    let holds = instance.simulation.world().get::<&Holds>(instance.bodies[0].entity()).unwrap();
    Ok(holds.groups[0].members.rows().to_vec())
}

#[test]
fn regions_are_read_from_groups_and_arrays_of_mesh_files() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("m.vtk"), VTK).unwrap();
    std::fs::write(folder.path().join("m.obj"), OBJ).unwrap();
    let held = |file: &str, region: &str| held(folder.path(), file, region);
    assert_eq!(held("m.obj", "group = 'south'").unwrap(), [0, 1, 4]);
    assert_eq!(held("m.obj", "any = [{ group = 'south' }, { group = 'east' }], boundary = true").unwrap(), [0, 1, 2]);
    let refused = held("m.obj", "group = 'sout'").unwrap_err();
    assert!(refused.contains("it has \"east\", \"rest\", \"south\"") && refused.contains("did you mean"), "{refused}");
    assert_eq!(held("m.vtk", "array = { name = 'part', value = [3, 4] }").unwrap(), [0, 2, 3, 4]);
    assert_eq!(held("m.vtk", "array = { name = 'height', value = 1 }").unwrap(), [1, 2]);
    let refused = held("m.vtk", "array = { name = 'weight', value = 1 }").unwrap_err();
    assert!(refused.contains("\"part\"") && refused.contains("\"height\""), "{refused}");
    // A load, a spring and an edge load take a region of the same kinds.
    let body = "mesh = { file = 'm.obj' }";
    let more = "[[bodies.point_loads]]\nregion = { group = 'east' }\ntotal = [1, 0]\n\
                [[bodies.springs]]\nregion = { group = 'south' }\ntotal = 1\n\
                [[bodies.edge_loads]]\nregion = { group = 'east' }\ntraction = [1, 0]\n";
    scene(folder.path(), "dynamic", body, more).unwrap();
}

const SQUARE: &str = "mesh = { grid = { width = 10, height = 10, nx = 8, ny = 8 } }";

#[test]
fn a_turned_hold_stands_where_it_is_turned_to_and_its_torque_is_that_of_the_energy() {
    let folder = tempfile::tempdir().unwrap();
    let turned = |degrees: f64| {
        let more = format!(
            "[[bodies.holds]]\nname = 'left'\nregion = {{ x = 0 }}\n[[bodies.holds]]\nname = 'right'\n\
             region = {{ x = 10 }}\nrotate = [[0, [0, 0, 0]], [1, [0, 0, {degrees}]]]\npivot = [10, 5]\n"
        );
        let mut instance = scene(folder.path(), "static", &format!("planar = true\n{SQUARE}"), &more).unwrap();
        instance.advance().unwrap();
        let body = instance.bodies[0];
        let energy = instance.simulation.energies(body).unwrap().elastic;
        (instance, energy)
    };
    let (instance, _) = turned(10.0);
    let body = instance.bodies[0];
    let torques = instance.simulation.torques(body).unwrap();
    let vertices = instance.simulation.world().get::<&Vertices>(body.entity()).unwrap();
    let (sin, cos) = 10_f64.to_radians().sin_cos();
    for (rest, x) in vertices.rest_position.iter().zip(&vertices.position).filter(|(rest, _)| rest.x == 10.0) {
        let arm = rest.y - 5.0;
        assert!((*x - DVec3::new(10.0 - sin * arm, 5.0 + cos * arm, 0.0)).length() < 1e-12, "{rest}: {x}");
    }
    // dE/dθ by central differences of half a degree: off by 1e-4 of the third derivative's share.
    let slope = (turned(10.5).1 - turned(9.5).1) / 1_f64.to_radians();
    let torque = torques[0].1.z;
    assert_eq!(torques[0].0, "right");
    assert!((torque - slope).abs() < 1e-3 * slope.abs() && slope > 0.0, "{torque} {slope}");
    let planar = "[[bodies.holds]]\nname = 'h'\nregion = { x = 0 }\nrotate = [[0, [0, 0, 0]], [1, [0, 9, 0]]]\n";
    let refused = scene(folder.path(), "static", &format!("planar = true\n{SQUARE}"), planar).err().unwrap();
    assert!(refused.contains("turns about z only"), "{refused}");
}

#[test]
fn an_obstacle_that_turns_takes_the_sheet_along_and_its_force_is_in_the_files() {
    let folder = tempfile::tempdir().unwrap();
    let body = format!("{SQUARE}\ncontact = {{}}\ndamping = 1\ndrag = 1e-4\npre_stretch = 0.05");
    let hold = "[[bodies.holds]]\nname = 'left'\nregion = { any = [{ x = 0 }, { x = 10 }] }\n";
    // A flap below the sheet, whose free end rises by 8 sin 20° = 2.7 mm.
    let flap =
        "[[obstacles]]\nname = 'flap'\nbox = { centre = [5, 5, -0.6], half = [4, 4, 0.5] }\npivot = [1, 5, -0.6]\n";
    for turn in ["rotate = [[0, [0, 0, 0]], [20, [0, -20, 0]]]", "spin = [0, -1, 0]"] {
        let mut instance = scene(folder.path(), "dynamic", &body, &format!("{hold}{flap}{turn}\n")).unwrap();
        for _ in 0..20 {
            instance.advance().unwrap();
        }
        let forces = instance.obstacle_forces();
        assert_eq!(forces[0].0, "flap");
        assert!(forces[0].1.z > 0.0, "{forces:?}");
        let vertices = instance.simulation.world().get::<&Vertices>(instance.bodies[0].entity()).unwrap();
        let (sin, cos) = 20_f64.to_radians().sin_cos();
        let mut highest = 0.0_f64;
        for x in &vertices.position {
            // Its upper face, in its own axes.
            let from = *x - DVec3::new(1.0, 5.0, -0.6);
            let (along, up) = (from.x * cos + from.z * sin, from.z * cos - from.x * sin);
            if (0.1..7.9).contains(&along) && (1.1..8.9).contains(&x.y) {
                // A penalty lets it in by less than a tenth of an edge of 1.25 mm.
                assert!(up > 0.5 - 0.125, "{turn}: {x} is {} mm inside", 0.5 - up);
            }
            highest = highest.max(x.z);
        }
        assert!(highest > 2.0, "{turn}: {highest}");
    }
    let more = format!("{hold}rotate = [[0, [0, 0, 0]], [20, [9, 0, 0]]]\npivot = [0, 5]\n{flap}spin = [0, -1, 0]\n");
    std::fs::write(folder.path().join("s.toml"), text("dynamic", &body, &more)).unwrap();
    let run = Command::new(env!("CARGO_BIN_EXE_rhexis")).current_dir(folder.path()).args(["run", "s.toml"]).output();
    assert!(run.as_ref().unwrap().status.success(), "{run:?}");
    let read = |name: &str| std::fs::read_to_string(folder.path().join("out/s").join(name)).unwrap();
    let header = read("series.csv").lines().next().unwrap().to_owned();
    assert!(header.contains("flap_z_N") && header.contains("b/left_torque_x_Nmm"), "{header}");
    let report: serde_json::Value = serde_json::from_str(&read("report.json")).unwrap();
    assert_eq!(report["obstacles"][0]["name"], "flap");
    assert!(report["obstacles"][0]["force_n"][2].as_f64().unwrap() > 0.0);
    assert!(report["bodies"][0]["reactions"][0]["torque_nmm"][0].as_f64().is_some());
}

#[test]
fn a_closed_mesh_holds_a_sheet_as_the_box_that_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let corner = |i: u32| {
        [1.0, 9.0][(i & 1) as usize].to_string()
            + &format!(" {} {}\n", [1, 9][(i >> 1 & 1) as usize], [-8.1, -0.1][(i >> 2 & 1) as usize])
    };
    let corners: String = (0..8).map(|i| format!("v {}", corner(i))).collect();
    let faces = "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    std::fs::write(folder.path().join("tool.obj"), corners + faces).unwrap();
    let body = format!("{SQUARE}\ngravity = [0, 0, -9.81e-3]\ndrag = 1e-4\ndamping = 1\ncontact = {{}}");
    let run = |obstacle: &str| {
        let obstacle = format!(
            "[[obstacles]]\n{obstacle}\npath = [[0, [0, 0, 0]], [20, [0, 0, 1]]]\nrotate = [[0, [0, 0, 0]], [20, [5, 0, 0]]]\n"
        );
        let mut instance = scene(folder.path(), "dynamic", &body, &obstacle).unwrap();
        for _ in 0..20 {
            instance.advance().unwrap();
        }
        let z = |p: &Vertices| p.position.iter().map(|x| x.z).collect::<Vec<f64>>();
        let positions = z(&instance.simulation.world().get::<&Vertices>(instance.bodies[0].entity()).unwrap());
        (positions, instance.obstacle_forces()[0].1)
    };
    let (mesh, force) = run("mesh = { file = 'tool.obj' }");
    let (cuboid, of_box) = run("box = { centre = [5, 5, -4.1], half = [4, 4, 4] }");
    // Edges of 1.25 mm are short beside the box, so that triangles are left to their vertices there too, all but those that are stretched
    // over its rim.
    let off = mesh.iter().zip(&cuboid).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off < 1e-4, "{off}");
    assert!(force.z > 0.0 && (force - of_box).length() < 1e-3 * force.length(), "{force} {of_box}");
    let open = "[[obstacles]]\nmesh = { file = 'open.obj' }\n";
    std::fs::write(folder.path().join("open.obj"), OBJ).unwrap();
    let refused = scene(folder.path(), "dynamic", &body, open).err().unwrap();
    assert!(refused.contains("not closed: 4 edges") && refused.contains("`box`"), "{refused}");
}

/// A drum that turns under a taut strip slides: what it drags it with is Coulomb's μ·N, in the files as in the reactions.
#[test]
fn a_turning_drum_drags_by_its_friction() {
    let body = "mesh = { grid = { width = 10, height = 4, nx = 20, ny = 4 } }\ncontact = { friction = 0.3 }\n\
                damping = 2\ndrag = 1e-3\npre_stretch = [0.1, 0]\n";
    let more = "[[bodies.holds]]\nname = 'left'\nregion = { x = 0 }\n[[bodies.holds]]\nname = 'right'\nregion = { x = 10 }\n\
                [[obstacles]]\nname = 'drum'\ncylinder = { from = [5, -1, -4.05], to = [5, 5, -4.05], radius = 4 }\n\
                path = [[0, [0, 0, 0]], [40, [0, 0, 0.4]]]\npivot = [5, 0, -4.05]\nspin = [0, 0.02, 0]\n";
    let text = text("dynamic", body, more).replace("dt = 1\nsteps = 20", "dt = 2\nsteps = 60\naccuracy = 'accurate'");
    let mut instance = Scene::parse(&text, "s.toml").unwrap().instantiate().unwrap();
    (0..60).for_each(|_| _ = instance.advance().unwrap());
    let force = instance.obstacle_forces()[0].1;
    let held: DVec3 = instance.simulation.reactions(instance.bodies[0]).unwrap().iter().map(|(_, force)| *force).sum();
    assert!(force.z > 1e-3);
    // The plane of the strip leaves the level by 0.07 at the drum: tanh(μφ)/tan φ is μ to 2e-3, and so is what vertices leave of the arc.
    assert!((force.x / force.z - 0.3).abs() < 0.006, "{force}");
    // Drag and inertia have died down.
    assert!((force + held).length() < 0.01 * force.z, "{force} {held}");
}

/// The end of a rod that turns about its own axis and pushes into a taut disc twists it by Σ μ·N·r over what it touches.
#[test]
fn a_turning_rod_twists_what_it_pushes() {
    let body = "mesh = { disc = { radius = 5, triangles = 600 } }\ncontact = { friction = 0.3 }\n\
                damping = 2\ndrag = 1e-3\npre_stretch = 0.1\n";
    let more = "[[bodies.holds]]\nname = 'rim'\nregion = { boundary = true }\nrotate = [[0, [0, 0, 0]], [1, [0, 0, 0]]]\n\
                [[obstacles]]\nname = 'rod'\ncylinder = { from = [0, 0, -3.05], to = [0, 0, -0.05], radius = 2 }\n\
                path = [[0, [0, 0, 0]], [40, [0, 0, 0.4]]]\npivot = [0, 0, 0]\nspin = [0, 0, 0.02]\n";
    let text = text("dynamic", body, more).replace("dt = 1\nsteps = 20", "dt = 2\nsteps = 40\naccuracy = 'accurate'");
    let text = text.replace("poisson = 0.3", "poisson = 0");
    let mut instance = Scene::parse(&text, "s.toml").unwrap().instantiate().unwrap();
    (0..40).for_each(|_| _ = instance.advance().unwrap());
    let (simulation, body) = (&instance.simulation, instance.bodies[0]);
    let torque = simulation.torques(body).unwrap()[0].1.z;
    let force = instance.obstacle_forces()[0].1;
    let vertices = simulation.world().get::<&Vertices>(body.entity()).unwrap();
    // Thirty times the membrane's own E·h at each vertex under the rod's end, which stands at 0.35 mm.
    let (stiffness, top) = (30.0 * 0.1, 0.35);
    let (mut pushed, mut twisted, mut unsure) = (0.0, 0.0, 0.0);
    for x in vertices.position.iter().filter(|x| x.z < top && x.truncate().length() < 2.0) {
        pushed += stiffness * (top - x.z);
        twisted += 0.3 * stiffness * (top - x.z) * x.truncate().length();
        // A way along the surface is found to enter from such a depth on: a hundred spheres do not lead to less.
        unsure += if top - x.z < 1e-8 { stiffness * (top - x.z) } else { 0.0 };
    }
    assert!(pushed > 0.01 && (force.z - pushed).abs() <= 1e-9 * pushed + unsure, "{force} {pushed} {unsure}");
    assert!(force.truncate().length() < 1e-3 * force.z, "{force}");
    // The rim is held against it, to the tolerance of the accurate settings and what has not died down.
    assert!((torque / twisted + 1.0).abs() < 0.005, "{torque} {twisted}");
}

#[test]
fn forceps_that_turn_carry_what_they_hold_and_their_torque_is_in_the_files() {
    let folder = tempfile::tempdir().unwrap();
    let body = format!("planar = true\n{SQUARE}\ndamping = 1\ndrag = 1e-4");
    let rim = "[[bodies.holds]]\nname = 'rim'\nregion = { boundary = true }\n";
    // A turn of 30° about a point that moves by a millimetre.
    let grip = |more: &str| {
        format!(
            "[[bodies.grips]]\nname = 'jaws'\nat = [5, 5]\nfrom = 0\nuntil = 30\nradius = 1.9\n\
             path = [{{ by = [1, 0, 0], end = 20 }}]\nrotate = [[0, [0, 0, 10]], [20, [0, 0, 40]]]\n{more}"
        )
    };
    let text = format!("{rim}{}", grip(""));
    let mut whole = scene(folder.path(), "dynamic", &body, &text).unwrap();
    whole.simulation.record();
    let mut half = None;
    for step in 0..20 {
        if step == 9 {
            half = Some((whole.simulation.snapshot().to_bytes().unwrap(), whole.progress()));
        }
        whole.advance().unwrap();
    }
    let world = whole.simulation.world();
    {
        let vertices = world.get::<&Vertices>(whole.bodies[0].entity()).unwrap();
        let grips = world.get::<&rhexis::components::Grips>(whole.bodies[0].entity()).unwrap();
        let held = grips.pinches[0].held.rows();
        assert!(held.len() > 4, "{held:?}");
        for &row in held {
            let arm = vertices.rest_position[row as usize] - DVec3::new(5.0, 5.0, 0.0);
            let (sin, cos) = 30_f64.to_radians().sin_cos();
            let expected = DVec3::new(6.0 + cos * arm.x - sin * arm.y, 5.0 + sin * arm.x + cos * arm.y, 0.0);
            // A constraint is exact to the rounding of the step's increments.
            assert!(vertices.position[row as usize].distance(expected) < 1e-9, "{row}");
        }
        assert!(grips.pinches[0].torque.z > 0.0 && grips.pinches[0].force.x > 0.0, "{:?}", grips.pinches[0]);
    }
    let recording = whole.simulation.end_recording().unwrap().to_bytes().unwrap();
    let replayed = rhexis::replay::Recording::from_bytes(&recording).unwrap().replay().unwrap();
    assert_eq!(replayed.hash(), whole.simulation.hash());
    let mut resumed = scene(folder.path(), "dynamic", &body, &text).unwrap();
    let (bytes, progress) = half.unwrap();
    resumed.resume(&rhexis::snapshot::Snapshot::from_bytes(&bytes).unwrap(), progress).unwrap();
    (9..20).for_each(|_| _ = resumed.advance().unwrap());
    assert_eq!(resumed.simulation.hash(), whole.simulation.hash());
    let springy = scene(folder.path(), "dynamic", &body, &format!("{rim}{}", grip("stiffness = 50\n"))).unwrap();
    let mut springy = springy;
    (0..20).for_each(|_| _ = springy.advance().unwrap());
    let world = springy.simulation.world();
    let grips = world.get::<&rhexis::components::Grips>(springy.bodies[0].entity()).unwrap();
    assert!(grips.pinches[0].torque.z > 0.0, "{:?}", grips.pinches[0]);
    let refused = text.replace("[0, 0, 40]", "[0, 9, 0]");
    let refused = scene(folder.path(), "dynamic", &body, &refused).err().unwrap();
    assert!(refused.contains("about z only"), "{refused}");
    scene(folder.path(), "dynamic", &body, &text).unwrap();
    let run = Command::new(env!("CARGO_BIN_EXE_rhexis")).current_dir(folder.path()).args(["run", "s.toml"]).output();
    assert!(run.as_ref().unwrap().status.success(), "{run:?}");
    let series = std::fs::read_to_string(folder.path().join("out/s/series.csv")).unwrap();
    assert!(series.lines().next().unwrap().contains("b/jaws_torque_z_Nmm"), "{series}");
}
