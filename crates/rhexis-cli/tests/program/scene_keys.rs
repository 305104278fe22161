//! Regions, total forces, obstacles with edges, and sentences for what there is not.

use glam::DVec3;
use rhexis::settings::{Accuracy, Settings};
use rhexis::storage::Vertices;
use rhexis_cli::output::{write_obj, write_ply};
use rhexis_scene::{Instance, Probe, ProbeKind, Scene, mesh_file};

fn scene(mode: &str, body: &str, more: &str) -> Result<Instance, String> {
    let text = format!(
        "[scene]\nname = 'w'\n[run]\nmode = '{mode}'\ndt = 1\nsteps = 1\n[[bodies]]\nname = 'b'\n\
         mesh = {{ grid = {{ width = 10, height = 10, nx = 4, ny = 4 }} }}\n\
         material = {{ young = 1, poisson = 0.3, thickness = 0.1 }}\n{body}\n{more}"
    );
    Scene::parse(&text, "w.toml").and_then(|scene| scene.instantiate()).map_err(|error| error.to_string())
}

const LEFT: &str = "[[bodies.holds]]\nname = 'left'\nregion = { x = 0 }\n";

#[test]
fn a_total_force_is_shared_and_adds_up() {
    let load = format!("{LEFT}[[bodies.point_loads]]\nregion = {{ x = 10 }}\ntotal = [0.1, 0, 0]\n");
    let mut instance = scene("static", "planar = true", &load).unwrap();
    instance.advance().unwrap();
    let reactions = instance.simulation.reactions(instance.bodies[0]).unwrap();
    // The static solve ends at 1e-9 of the largest corner force.
    assert!((reactions[0].1 + DVec3::X * 0.1).length() < 1e-8 || (reactions[0].1 - DVec3::X * 0.1).length() < 1e-8);
    let twice = load.replace("total", "force = [1, 0, 0]\ntotal");
    assert!(scene("static", "planar = true", &twice).err().unwrap().contains("given twice"));
}

#[test]
fn regions_select_by_lists_boxes_and_balls() {
    for (region, count) in [
        ("vertices = [0, 1, 2]", 3),
        ("box = [[0, 0, 0], [2.5, 10, 0]]", 10),
        ("sphere = { centre = [0, 0, 0], radius = 2.5 }", 3),
    ] {
        let hold = format!("[[bodies.holds]]\nname = 'h'\nregion = {{ {region} }}\n");
        let instance = scene("static", "", &hold).unwrap();
        let world = instance.simulation.world();
        let holds = world.get::<&rhexis::components::Holds>(instance.bodies[0].entity()).unwrap();
        assert_eq!(holds.groups[0].members.rows().len(), count, "{region}");
    }
    for (bad, what) in [
        ("vertices = [25]", "no vertex 25"),
        ("box = [[1, 0], [0, 0]]", "runs backwards"),
        ("sphere = { radius = -1 }", "-1"),
        ("group = 'inlet'", "no group \"inlet\": it has none"),
        ("array = { name = 'part', value = 1 }", "only mesh files have arrays"),
    ] {
        let hold = format!("[[bodies.holds]]\nname = 'h'\nregion = {{ {bad} }}\n");
        let refused = scene("static", "", &hold).err().unwrap();
        assert!(refused.contains(what), "{bad}: {refused}");
    }
}

#[test]
fn a_pre_stretch_may_be_a_tensor() {
    let strain = |text: &str| {
        let instance = scene("static", &format!("pre_stretch = {text}"), LEFT)?;
        let world = instance.simulation.world();
        Ok::<_, String>(world.get::<&rhexis::components::PreStretch>(instance.bodies[0].entity()).unwrap().strain)
    };
    assert_eq!(strain("[[0.1, 0.01], [0.01, 0.02]]"), strain("[0.1, 0.02, 0.01]"));
    assert!(strain("[[0.1, 0.01], [0.02, 0.02]]").unwrap_err().contains("symmetric tensor"));
}

#[test]
fn a_box_and_a_cylinder_hold_a_sheet() {
    for obstacle in [
        "box = { centre = [5, 5, -1.1], half = [4, 4, 1] }",
        "cylinder = { from = [5, 5, -2.1], to = [5, 5, -0.1], radius = 4 }",
        "cylinder = { from = [-9, 5, -4.1], to = [19, 5, -4.1], radius = 4 }",
    ] {
        let body = "gravity = [0, 0, -9.81e-3]\ndrag = 1e-4\ndamping = 1\ncontact = {}";
        let mut instance = scene("dynamic", body, &format!("[[obstacles]]\n{obstacle}\n")).unwrap();
        for _ in 0..60 {
            instance.advance().unwrap();
        }
        let vertices = instance.simulation.world().get::<&Vertices>(instance.bodies[0].entity()).unwrap();
        let middle = vertices.rest_position.iter().position(|p| *p == DVec3::new(5.0, 5.0, 0.0)).unwrap();
        // 60 ms of free fall are 17 mm; a penalty lets it in by less than a tenth of an edge.
        assert!((-0.35..0.01).contains(&vertices.position[middle].z), "{obstacle}: {}", vertices.position[middle]);
    }
    for bad in ["box = { centre = [0, 0], half = [1, 0, 1] }", "cylinder = { from = [0, 0], to = [0, 0], radius = 1 }"]
    {
        assert!(scene("dynamic", "contact = {}", &format!("[[obstacles]]\n{bad}\n")).is_err(), "{bad}");
    }
}

/// A ball with a mass lies on a held sheet, and its place is told; a velocity without a mass, a mass of zero, a mass beside a path and one of a plane are refused.
#[test]
fn a_ball_with_a_mass_lies_on_a_sheet() {
    let body = "contact = {}\ndamping = 1\n[[bodies.holds]]\nname = 'rim'\nregion = { boundary = true }\n";
    let ball = "[[obstacles]]\nname = 'ball'\nsphere = { centre = [5, 5, 2.01], radius = 2 }\n";
    let with = |keys: &str| scene("dynamic", "", &format!("{body}{ball}{keys}\n"));
    let mut instance = with("mass = 0.02\ngravity = [0, 0, -9.81e-3]").unwrap();
    for _ in 0..60 {
        instance.advance().unwrap();
    }
    let (name, [centre, velocity]) = instance.rigid_obstacles().remove(0);
    assert!(name == "ball" && (1.0..2.01).contains(&centre.z) && velocity.length() < 0.1, "{centre} {velocity}");
    for (keys, what) in [
        ("velocity = [0, 0, 1]", "add `mass`"),
        ("mass = 0", "mass"),
        ("mass = 1\npath = [[0, [0, 0, 0]], [1, [0, 0, 1]]]", "follows no path"),
    ] {
        let error = with(keys).err().unwrap();
        assert!(error.contains(what), "{error}");
    }
    let plane = "[[obstacles]]\nplane = { point = [0, 0, -1], normal = [0, 0, 1] }\nmass = 1\n";
    assert!(scene("dynamic", "contact = {}", plane).err().unwrap().contains("give a `box`"));
}

#[test]
fn what_there_is_not_is_refused_with_what_there_is() {
    for (body, more, what) in [
        ("contact = { self = true }", "", "self_contact = { radius"),
        ("prony = [[0.3, 100]]", "", "`relaxation"),
        ("relaxation = [{ part = 0.6, time = 5 }, { part = 0.4, time = 50 }]", "", "sum to 1"),
        ("relaxation = [{ part = 0.6, time = 0 }]", "", "bodies.0.relaxation.0.time"),
        ("relaxation = [{ part = 0.6, tau = 5 }]", "", "tau"),
        ("relaxation = [{ part = 0.6, time = 5 }]\nstiffening_fibres = { k1 = 1, k2 = 10 }", "", "linear law"),
        ("pressure = { volume = 100 }", "", "`compartment = { gas"),
        ("compartment = { capped = true, chamber = 10 }", "", "`liquid = { }`"),
        ("compartment = { liquid = { }, chamber = 10 }", "", "`capped = true`"),
        ("compartment = { liquid = { }, capped = true }", "", "`chamber`"),
        ("compartment = { liquid = { }, gas = { }, capped = true }", "", "two contents"),
        ("compartment = { gas = { exponent = 0.5 }, capped = true }", "", "bodies.0.compartment.gas.exponent"),
        ("compartment = { liquid = { }, leak = 2, capped = true }", "", "bodies.0.compartment.leak"),
        ("pressure = 0.01\ncompartment = { liquid = { }, capped = true }", "", "`outside`"),
        ("wind = [1, 0, 0]", "", "`drag`"),
        ("", "[[obstacles]]\nmesh = { file = 'tool.stl' }", "tool.stl"),
        ("", "[[obstacles]]\nmesh = { grid = { width = 1, height = 1, nx = 1, ny = 1 } }", "not closed"),
        ("", "[[bodies.springs]]\nregion = { all = true }\nper_area = 0.1\nbreak_force = 1", "`break_traction`"),
        ("", "[[bodies.clamps]]\nregion = { x = 10 }\naxes = 'y'\nforce = [1, 0, 0]", "which the clamp leaves free"),
        ("", "[[bodies.holds]]\nname = 's'\nregion = { x = 10 }\nnormal = [0, 0, 0]", "it has no direction"),
        (
            "",
            "[[bodies.holds]]\nname = 's'\nregion = { x = 10 }\nnormal = [1, 1, 0]\nline = [1, 0, 0]",
            "either `normal` or `line`",
        ),
        (
            "",
            "[[bodies.holds]]\nname = 's'\nregion = { x = 10 }\nnormal = [1, 1, 0]\naxes = 'x'",
            "both say what is held",
        ),
        ("planar = true", "[[bodies.holds]]\nname = 's'\nregion = { x = 10 }\nline = [0, 0, 1]", "out of the plane"),
        ("per_triangle = { strength = [1] }", "", "1 entries, and the mesh"),
        ("per_triangle = { strength = 'seam' }", "", "arrays are those of mesh files"),
        ("per_triangle = { thickness = 0.1 }", "", "an entry for each triangle"),
        ("", "[[bodies.holds]]\nname = 'h'\nregion = { x = 0 }\npivot = [1, 1, 0]", "no turn about it"),
        ("contact = {}", "[[obstacles]]\nsphere = { centre = [0, 0], radius = 1 }\npivot = [0, 0]", "no turn about it"),
        (
            "contact = {}",
            "[[obstacles]]\nsphere = { centre = [0, 0], radius = 1 }\nspin = [0, 0, 1]\nrotate = [[0, [0, 0, 0]]]",
            "given twice",
        ),
        ("stiffening_fibres = [{ k1 = 1, k2 = 10, degrees = 40 }]", "", "holzapfel_gasser_ogden"),
    ] {
        let refused = scene("static", body, more).err().unwrap();
        assert!(refused.contains(what), "{body}{more}: {refused}");
    }
}

#[test]
fn a_static_failure_names_what_helps() {
    let flat =
        scene("static", "gravity = [0, 0, -9.81e-3]", "[[bodies.holds]]\nname = 'r'\nregion = { boundary = true }\n");
    let failed = flat.unwrap().advance().unwrap_err().to_string();
    assert!(failed.contains("flat sheet") && failed.contains("bending"), "{failed}");
    let text = "[scene]\nname = 'f'\n[run]\nmode = 'static'\ndt = 1\nsteps = 1\n[[bodies]]\nname = 'two'\n\
        mesh = { inline = { positions = [[0,0,0],[1,0,0],[1,1,0],[0,1,0],[0,3,0],[1,3,0],[1,4,0]], triangles = [[0,1,2],[0,2,3],[4,5,6]] } }\n\
        material = { young = 1, poisson = 0.3, thickness = 0.1 }\ngravity = [0.001, 0, 0]\n\
        [[bodies.holds]]\nname = 'left'\nregion = { x = 0, y = [0, 1] }\n";
    let failed = Scene::parse(text, "f.toml").unwrap().instantiate().unwrap().advance().unwrap_err().to_string();
    assert!(failed.contains("piece 1 of 2 of body `two`, 1 triangle(s) with vertex 4"), "{failed}");
    // Two iterations are not enough for a strain of a half and a shear of as much, and each comes nearer.
    let text = "[scene]\nname = 'f'\n[run]\nmode = 'static'\ndt = 1\nsteps = 1\nadvanced.static_iterations = 2\n[[bodies]]\nname = 'b'\n\
        planar = true\nmesh = { grid = { width = 10, height = 10, nx = 8, ny = 8 } }\n\
        material = { young = 1, poisson = 0.3, thickness = 0.1 }\n\
        [[bodies.holds]]\nname = 'left'\nregion = { x = 0 }\n\
        [[bodies.holds]]\nname = 'right'\nregion = { x = 10 }\nmove = { offset = [5, 5, 0] }\n";
    let failed = Scene::parse(text, "f.toml").unwrap().instantiate().unwrap().advance().unwrap_err().to_string();
    assert!(failed.contains("still falls") && failed.contains("raise `static_iterations`"), "{failed}");
    let enough = text.replace("advanced.static_iterations = 2\n", "");
    assert!(Scene::parse(&enough, "f.toml").unwrap().instantiate().unwrap().advance().is_ok());
}

/// A hold along a slanted direction and a clamp that a force draws, as scenes say them.
#[test]
fn holds_along_a_direction_and_clamps_under_a_force() {
    let skew = "[[bodies.holds]]\nname = 'left'\nregion = { x = 0 }\n\
        [[bodies.holds]]\nname = 'skew'\nregion = { x = 10 }\nnormal = [1, 1, 0]\nmove = { offset = [0.5, 0.5, 0] }\n";
    let mut instance = scene("static", "planar = true", skew).unwrap();
    instance.advance().unwrap();
    let (simulation, body) = (&instance.simulation, instance.bodies[0]);
    let vertices = simulation.world().get::<&Vertices>(body.entity()).unwrap();
    let rows: Vec<usize> = (0..vertices.len()).filter(|&v| vertices.rest_position[v].x == 10.0).collect();
    let gone = |v: usize| vertices.position[v] - vertices.rest_position[v];
    // Along (1, 1) by the offset's part; across it as the sheet will.
    assert!(rows.iter().all(|&v| (gone(v).x + gone(v).y - 1.0).abs() < 1e-12));
    assert!(rows.iter().any(|&v| (gone(v).x - gone(v).y).abs() > 0.01));
    let force = simulation.reactions(body).unwrap()[1].1;
    assert!((force.x - force.y).abs() < 1e-6 * force.length() && force.x > 0.0, "{force}");

    let clamp = "[[bodies.holds]]\nname = 'left'\nregion = { x = 0 }\n\
        [[bodies.clamps]]\nregion = { x = 10 }\nforce = [0.1, 0, 0]\n";
    let mut instance = scene("static", "", clamp).unwrap();
    instance.advance().unwrap();
    let (simulation, body) = (&instance.simulation, instance.bodies[0]);
    let vertices = simulation.world().get::<&Vertices>(body.entity()).unwrap();
    let rows: Vec<usize> = (0..vertices.len()).filter(|&v| vertices.rest_position[v].x == 10.0).collect();
    let gone = |v: usize| vertices.position[v] - vertices.rest_position[v];
    assert!(rows.iter().all(|&v| gone(v).distance(gone(rows[0])) < 1e-12));
    // Strain of F/(E·h·w) = 10 %, and less for the held sides, by 1/(1 − ν²) at the most.
    assert!((0.9..1.0).contains(&gone(rows[0]).x), "{}", gone(rows[0]));
    let told = simulation.reactions(body).unwrap();
    assert_eq!(told[1].0, "clamp 0");
    assert!((told[1].1.x - 0.1).abs() < 1e-6, "{told:?}");
}

#[test]
fn a_torn_surface_is_read_back_from_obj_and_ply() {
    let cut = "[[bodies.cuts]]\npolyline = [[0, 5], [6, 5]]\n";
    let instance =
        scene("static", "", &format!("[[bodies.holds]]\nname = 'r'\nregion = {{ all = true }}\n{cut}")).unwrap();
    let frame = instance.simulation.frame();
    let folder = tempfile::tempdir().unwrap();
    let [obj, ply] = ["a.obj", "a.ply"].map(|name| folder.path().join(name));
    write_obj(&obj, &frame.bodies[0]).unwrap();
    write_ply(&ply, &frame.bodies[0]).unwrap();
    for path in [obj, ply] {
        let mesh = mesh_file::read(&path).unwrap();
        // The reader of OBJ numbers vertices as triangles use them.
        let corners = |positions: &[DVec3], triangles: &[[u32; 3]]| -> Vec<[DVec3; 3]> {
            triangles.iter().map(|corners| corners.map(|v| positions[v as usize])).collect()
        };
        let body = &frame.bodies[0];
        assert_eq!(mesh.positions.len(), body.positions.len(), "both lips are there");
        assert_eq!(corners(&mesh.positions, &mesh.triangles), corners(&body.positions, &body.triangles));
    }
}

/// `accuracy` names the library's presets; other keys take their places.
#[test]
fn presets_and_budgets_are_those_of_the_library() {
    let settings = |keys: &str| {
        let run = format!("mode = 'dynamic'\n{keys}");
        let text = format!(
            "[scene]\nname = 'w'\n[run]\n{run}\ndt = 1\nsteps = 1\n[[bodies]]\nname = 'b'\n\
             mesh = {{ grid = {{ width = 10, height = 10, nx = 4, ny = 4 }} }}\n\
             material = {{ young = 1, poisson = 0.3, thickness = 0.1 }}\n"
        );
        let instance = Scene::parse(&text, "w.toml").and_then(|scene| scene.instantiate());
        instance.map(|instance| *instance.simulation.settings()).map_err(|error| error.to_string())
    };
    for accuracy in Accuracy::ALL {
        let name = accuracy.name();
        assert_eq!(settings(&format!("accuracy = '{name}'")).unwrap(), Settings::new(accuracy), "{name}");
    }
    assert_eq!(settings("").unwrap(), Settings::default());
    let own =
        settings("accuracy = 'game'\nbudget = 40\nposition_tolerance = inf\nadvanced.max_step_halvings = 3").unwrap();
    assert_eq!(
        (own.budget, own.position_tolerance, own.advanced.max_step_halvings, own.max_tear_passes),
        (Some(40), f64::INFINITY, 3, 2)
    );
    for (old, new) in [
        ("resumes", "run.max_tear_passes"),
        ("corrections", "run.advanced.newton_corrections"),
        ("halvings", "run.advanced.max_step_halvings"),
        ("linear_tolerance", "run.advanced.linear_tolerance"),
        ("static_advances", "run.advanced.static_advances"),
    ] {
        let refused = settings(&format!("{old} = 3")).unwrap_err();
        assert!(
            refused.starts_with("w.toml:5:1:") && refused.contains(&format!("the key is now `{new}`")),
            "{refused}"
        );
    }
    assert_eq!(settings("budget = 0").unwrap().budget, None);
    assert!(settings("position_tolerance = 0").unwrap_err().contains("run.position_tolerance"));
}

#[test]
fn a_mesh_is_scaled_turned_and_moved() {
    let place = "place = { scale = 2, turn = [0, 0, 90], about = [5, 5], move = [0, 0, 3] }";
    let instance = scene("dynamic", place, LEFT.replace("x = 0", "x = -5").as_str()).unwrap();
    let vertices = instance.simulation.world().get::<&Vertices>(instance.bodies[0].entity()).unwrap();
    // The corner (0, 0) is 5 mm from the pivot along either axis: twice as far, a quarter turn on.
    assert!(vertices.rest_position[0].distance(DVec3::new(15.0, -5.0, 3.0)) < 1e-12);
    let refused = scene("dynamic", "place = { scale = 0 }", LEFT).err().unwrap();
    assert!(refused.contains("bodies.0.place.scale"), "{refused}");
    let refused = scene("dynamic", "planar = true\nplace = { turn = [90, 0, 0] }", LEFT).err().unwrap();
    assert!(refused.contains("not flat"), "{refused}");
}

#[test]
fn parts_of_a_body_have_their_own_material() {
    let stiff = "material = { young = 20, poisson = 0.3, thickness = 0.2 }";
    let parts = format!("[[bodies.materials]]\nregion = {{ x = [5, 10] }}\n{stiff}\n");
    let load = "[[bodies.point_loads]]\nregion = { x = 10 }\ntotal = [0.1, 0, 0]\n";
    let mut instance = scene("static", "planar = true", &format!("{parts}{LEFT}{load}")).unwrap();
    instance.advance().unwrap();
    let world = instance.simulation.world();
    let triangles = world.get::<&rhexis::storage::Triangles>(instance.bodies[0].entity()).unwrap();
    assert_eq!(triangles.thickness.iter().filter(|thickness| **thickness == 0.2).count(), 16);
    // F/(w·h·E)·l of two strips in a row, 5·0.01·(1/0.1 + 1/(0.2·20)); clamp and stiff part keep the soft one from narrowing, which makes it up to
    // 1/(1 − ν²) as stiff.
    let vertices = world.get::<&Vertices>(instance.bodies[0].entity()).unwrap();
    let way = vertices.position[14].x - vertices.rest_position[14].x;
    assert!((0.91 * 0.5125..0.5125).contains(&way), "{way}");
    for (parts, what) in [
        (parts.replace("[5, 10]", "[5, 5]"), "no triangle is in the region"),
        (parts.replace("young = 20", "young = -20"), "bodies.0.materials.0.material.young"),
    ] {
        let refused = scene("static", "planar = true", &format!("{parts}{LEFT}")).err().unwrap();
        assert!(refused.contains(what), "{refused}");
    }
}

#[test]
fn probes_read_place_and_stress() {
    let probe = "[[probes]]\nname = 'middle'\npoint = [5, 5]\n";
    let load = "[[bodies.point_loads]]\nregion = { x = 10 }\ntotal = [0.1, 0, 0]\n";
    let mut instance = scene("static", "planar = true", &format!("{LEFT}{load}{probe}")).unwrap();
    instance.advance().unwrap();
    let Probe { name, body, kind } = instance.probes[0].clone();
    let ProbeKind::Point(point) = kind else { panic!("{kind:?}") };
    let reading = instance.simulation.reading(body, point).unwrap();
    // 0.1 N over 10 mm × 0.1 mm.
    assert!(name == "middle" && (reading.stress.principal_values().0 / 0.1 - 1.0).abs() < 0.05, "{reading:?}");
    assert!(reading.position.x > 5.4 && reading.velocity == DVec3::ZERO);
    for (bad, what) in [("body = 'c'", "no body `c`"), ("at = [0, 0]", "unknown key `at`")] {
        assert!(scene("static", "", &format!("{LEFT}{probe}{bad}\n")).err().unwrap().contains(what));
    }
}

/// Forces of the sections of an instance, and of the first hold.
fn sections(instance: &Instance) -> (Vec<DVec3>, DVec3) {
    let force = |probe: &Probe| match &probe.kind {
        ProbeKind::Section(section) => instance.simulation.section_force(probe.body, section).unwrap(),
        ProbeKind::Point(_) => DVec3::NAN,
    };
    let held = instance.simulation.reactions(instance.bodies[0]).unwrap();
    (instance.probes.iter().map(force).collect(), held[0].1)
}

#[test]
fn a_section_bears_the_pull_on_a_flat_sheet() {
    let across = |x: f64| format!("[[probes]]\nname = 'x{x}'\npoint = [{x}, 0]\nsection = {{ normal = [2, 0] }}\n");
    let part = "[[probes]]\nname = 'part'\npoint = [6, 5]\nsection = { normal = [1, 0], radius = 2.4 }\n";
    let other = "[[probes]]\nname = 'other'\npoint = [6, 5]\nsection = { normal = [-1, 0] }\n";
    let along = "[[probes]]\nname = 'along'\npoint = [0, 4]\nsection = { normal = [0, 1] }\n";
    let load = "[[bodies.point_loads]]\nregion = { x = 10 }\ntotal = [0.1, 0, 0]\n";
    let probes = [across(1.0), across(5.0), across(9.0), part.into(), other.into(), along.into()].concat();
    // One hold lets the sheet narrow, so that the stress is the same everywhere.
    let free = LEFT.replace("x = 0 }", "x = 0 }\naxes = 'x'");
    let corner = "[[bodies.holds]]\nname = 'corner'\nregion = { x = 0, y = 0 }\naxes = 'y'\n";
    let mut instance = scene("static", "planar = true", &format!("{free}{corner}{load}{probes}")).unwrap();
    instance.advance().unwrap();
    let (forces, _) = sections(&instance);
    // The static solve ends at 1e-9 of the largest corner force.
    for force in &forces[..3] {
        assert!((*force - DVec3::X * 0.1).length() < 1e-8, "{force}");
    }
    // Of four rows of triangles the two in the middle lie within the radius.
    assert!((forces[3].x / forces[0].x - 0.5).abs() < 0.02, "{}", forces[3]);
    assert!((forces[4] + DVec3::X * 0.1).length() < 1e-8, "{}", forces[4]);
    // The load is not quite that of a uniform stress: it shears the sheet, and nothing draws it apart across.
    assert!(forces[5].y.abs() < 1e-8, "{}", forces[5]);
    for (bad, what) in [("normal = [0, 0]", "no direction"), ("normal = [1, 0], radius = 0", "not above zero")] {
        let probe = format!("[[probes]]\nname = 'p'\npoint = [0, 0]\nsection = {{ {bad} }}\n");
        let refused = scene("static", "planar = true", &format!("{LEFT}{probe}")).err().unwrap();
        assert!(refused.contains(what), "{refused}");
    }
}

#[test]
fn a_section_of_a_bent_sheet_balances_its_hold() {
    for cells in [4, 9] {
        // One of two opposite edges is drawn up, aside and turned: the sheet twists, and is stressed unevenly.
        let text = format!(
            "[scene]\nname = 'w'\n[run]\nmode = 'static'\ndt = 1\nsteps = 4\n[[bodies]]\nname = 'b'\n\
             mesh = {{ grid = {{ width = 10, height = 10, nx = {cells}, ny = {cells} }} }}\n\
             material = {{ young = 1, poisson = 0.3, thickness = 0.1 }}\nfibres = {{ degrees = 30 }}\npre_stretch = 0.1\n\
             [[bodies.holds]]\nname = 'left'\nregion = {{ x = 0 }}\n\
             [[bodies.holds]]\nname = 'right'\nregion = {{ x = 10 }}\nmove = {{ offset = [2, 0.7, 4] }}\ncurve = [[0, 0], [4, 1]]\n\
             rotate = [[0, [0, 0, 0]], [4, [20, 0, 10]]]\npivot = [10, 5, 0]\n\
             [[probes]]\nname = 'near'\npoint = [2, 5]\nsection = {{ normal = [1, 0.2] }}\n\
             [[probes]]\nname = 'far'\npoint = [7, 5]\nsection = {{ normal = [1, -0.2] }}\n"
        );
        let mut instance = Scene::parse(&text, "w.toml").and_then(|scene| scene.instantiate()).unwrap();
        (0..4).for_each(|_| _ = instance.advance().unwrap());
        let (forces, held) = sections(&instance);
        // The cut is made where the mesh's forces balance: no error of the mesh is left, only that of the solve, 1e-9 of the
        // largest corner force at each of up to a hundred vertices.
        for force in forces {
            assert!(force.length() > 0.1 && (force + held).length() < 1e-7, "{cells}: {force} {held}");
        }
    }
}

/// A sheet at a constant stretch of a tenth, with a material and more of a body.
fn stretched(mode: &str, material: &str, body: &str) -> Result<Instance, String> {
    let text = format!(
        "[scene]\nname = 'w'\n[run]\nmode = '{mode}'\ndt = 2\nsteps = 20\nadvanced.linear_tolerance = 1e-10\n[[bodies]]\nname = 'b'\n\
         mesh = {{ grid = {{ width = 10, height = 10, nx = 4, ny = 4 }} }}\nplanar = true\ninitial = {{ stretch = [[1.1, 0, 0], [0, 1, 0], [0, 0, 1]] }}\n\
         material = {{ {material} }}\n{body}\n{LEFT}\
         [[bodies.holds]]\nname = 'right'\nregion = {{ x = 10 }}\nmove = {{ offset = [1, 0, 0] }}\n\
         [[bodies.holds]]\nname = 'sides'\nregion = {{ x = [1, 9], any = [{{ y = 0 }}, {{ y = 10 }}] }}\naxes = 'y'\n"
    );
    Scene::parse(&text, "w.toml").and_then(|scene| scene.instantiate()).map_err(|error| error.to_string())
}

fn pull(instance: &Instance) -> f64 {
    instance.simulation.reactions(instance.bodies[0]).unwrap()[1].1.x
}

#[test]
fn a_modulus_that_changes_over_time_changes_the_force_at_every_step() {
    let whole = "young = 2, poisson = 0.3, thickness = 0.1";
    let curve = "[[0, 1], [10, 1], [30, 0.5]]";
    let of = |factor: f64, at: f64| factor * (1.0 - 0.5 * ((at - 10.0) / 20.0).clamp(0.0, 1.0));
    let grading = "grading = { ratio_at_rim = 3, radius = 8 }";
    for (mode, material, body) in [
        (
            "static",
            format!("young = {}, poisson = 0.3, thickness = 0.1", curve.replace("1]", "2]").replace("0.5]", "1]")),
            "",
        ),
        (
            "dynamic",
            format!("young = {}, poisson = 0.3, thickness = 0.1", curve.replace("1]", "2]").replace("0.5]", "1]")),
            "",
        ),
        (
            "static",
            format!("young = 2, poisson = 0.3, thickness = {}", curve.replace("1]", "0.1]").replace("0.5]", "0.05]")),
            "",
        ),
        (
            "static",
            format!("young = {}, poisson = 0.3, thickness = 0.1", curve.replace("1]", "2]").replace("0.5]", "1]")),
            grading,
        ),
    ] {
        let mut constant = stretched("static", whole, body).unwrap();
        constant.advance().unwrap();
        let before = pull(&constant);
        let mut instance = stretched(mode, &material, body).unwrap();
        for step in 1..=20 {
            instance.advance().unwrap();
            // The solve is to 1e-10 of its right-hand side.
            let expected = of(before, 2.0 * f64::from(step));
            assert!(
                (pull(&instance) / expected - 1.0).abs() < 1e-7,
                "{mode} {material} {step}: {} {expected}",
                pull(&instance)
            );
        }
        assert!(!instance.simulation.report().has_failed);
    }
}

#[test]
fn tissue_that_stiffens_at_rest_is_no_energy_of_the_step() {
    let material = "young = [[0, 1], [4, 1], [8, 100]], poisson = 0.3, thickness = 0.1";
    let mut instance = stretched("dynamic", material, "damping = 1").unwrap();
    for _ in 0..20 {
        instance.advance().unwrap();
        assert_eq!(instance.simulation.report().rolled_back, 0);
    }
    let soft = stretched("static", "young = 1, poisson = 0.3, thickness = 0.1", "").and_then(|mut instance| {
        instance.advance().map_err(|error| error.to_string())?;
        Ok(pull(&instance))
    });
    assert!((pull(&instance) / soft.unwrap() / 100.0 - 1.0).abs() < 1e-6);
}

#[test]
fn thresholds_change_over_time_with_the_material() {
    let tearing =
        "tearing = { toughness_along_fibres = [[0, 1e-3], [20, 4e-3]], toughness_across_fibres = 2e-3, radius = 2 }";
    let mut instance =
        stretched("static", "young = [[0, 2], [40, 1]], poisson = 0.3, thickness = 0.1", tearing).unwrap();
    for _ in 0..5 {
        instance.advance().unwrap();
    }
    let world = instance.simulation.world();
    let energy = world.get::<&rhexis::components::EnergyCriterion>(instance.bodies[0].entity()).unwrap();
    // At 10 ms, to the rounding of a curve.
    let near = |value: f64, wanted: f64| (value / wanted - 1.0).abs() < 1e-12;
    assert!(near(energy.toughness.along, 2.5e-3) && near(energy.toughness.across, 2e-3), "{energy:?}");
    let own = world.get::<&rhexis::components::Tearing>(instance.bodies[0].entity()).unwrap();
    let at_once = "tearing = { toughness_along_fibres = 2.5e-3, toughness_across_fibres = 2e-3, radius = 2 }";
    let constant = stretched("static", "young = 1.75, poisson = 0.3, thickness = 0.1", at_once).unwrap();
    let there = constant.simulation.world().get::<&rhexis::components::Tearing>(constant.bodies[0].entity()).unwrap();
    assert!(near(own.strength_along_fibres, there.strength_along_fibres), "{own:?}");
    assert!(near(own.strength_across_fibres, there.strength_across_fibres), "{own:?}");
}

#[test]
fn a_changing_material_is_resumed_and_replayed_to_the_same_bits() {
    let material = "young = [[0, 1], [30, 2]], poisson = 0.3, thickness = [[4, 0.1], [20, 0.08]]";
    let tearing =
        "tearing = { strength_along_fibres = [[0, 5], [40, 4]], strength_ratio = 2, radius = 2 }\ndamping = 1";
    let mut whole = stretched("dynamic", material, tearing).unwrap();
    whole.simulation.record();
    (0..12).for_each(|_| _ = whole.advance().unwrap());
    let recording = whole.simulation.end_recording().unwrap();
    let recording = rhexis::replay::Recording::from_bytes(&recording.to_bytes().unwrap()).unwrap();
    assert_eq!(recording.replay().unwrap().hash(), whole.simulation.hash());
    let mut half = stretched("dynamic", material, tearing).unwrap();
    (0..6).for_each(|_| _ = half.advance().unwrap());
    let mut resumed = stretched("dynamic", material, tearing).unwrap();
    let bytes = half.simulation.snapshot().to_bytes().unwrap();
    resumed.resume(&rhexis::snapshot::Snapshot::from_bytes(&bytes).unwrap(), half.progress()).unwrap();
    (6..12).for_each(|_| _ = resumed.advance().unwrap());
    assert_eq!(resumed.simulation.hash(), whole.simulation.hash());
}

#[test]
fn curves_that_are_no_material_are_refused_by_time_and_key() {
    for (material, body, what) in [
        (
            "young = [[0, 1], [5, -1]], poisson = 0.3, thickness = 0.1",
            "",
            "bodies.0.material.young: at 5 ms: -1 MPa is not above zero",
        ),
        ("young = 1, poisson = 0.3, thickness = [[0, 0.1], [5, 0]]", "", "bodies.0.material.thickness: at 5 ms"),
        ("young = 1, poisson = 0.3, thickness = [0.1, 0.2]", "", "per_triangle"),
        ("young = 'soft', poisson = 0.3, thickness = 0.1", "", "give a number, a list of points"),
        (
            "young_fibre = [[0, 4], [10, 1]], young_transverse = 1.5, poisson_major = 0.9, thickness = 0.1",
            "",
            "bodies.0.material.poisson_major: at 10 ms",
        ),
        (
            "young = [[0, 1], [5, 2]], poisson = 0.3, thickness = 0.1",
            "[[bodies.materials]]\nregion = { all = true }\nmaterial = { young = 1, poisson = 0.3, thickness = 0.1 }\n",
            "that of a whole body",
        ),
        (
            "young = 1, poisson = 0.3, thickness = 0.1",
            "tearing = { strength_along_fibres = [[0, 1], [3, 0]], strength_ratio = 1, radius = 1 }",
            "bodies.0.tearing.strength_along_fibres: at 3 ms",
        ),
    ] {
        let refused = stretched("static", material, body).err().unwrap();
        assert!(refused.contains(what), "{refused}");
    }
}

#[test]
fn names_and_paths_with_line_breaks_are_refused_and_shown_on_one_line() {
    let probe = |name: &str| format!("{LEFT}[[probes]]\nname = {name}\npoint = [5, 5]\n");
    for (body, more, key) in [
        ("", probe(r#""tip\nstep,time""#), "probes.0.name"),
        ("", probe("'''tip\nstep'''"), "probes.0.name"),
        ("", probe(r#""tip\u2028""#), "probes.0.name"),
        ("", LEFT.replace("'left'", r#""le\u001b[2Jft""#), "bodies.0.holds.0.name"),
        (r#"fibres = { file = "a\rb.txt" }"#, LEFT.to_owned(), "bodies.0.fibres.file"),
        (r#"texture = "a\u0007.png""#, LEFT.to_owned(), "bodies.0.texture"),
    ] {
        let refused = scene("static", body, &more).err().unwrap();
        let is_told = refused.contains(&format!("{key}: `")) && refused.contains("` has a line break or a control");
        assert!(is_told && refused.starts_with("w.toml:") && refused.lines().count() == 2, "{refused:?}");
    }
    // A key cannot be refused before it is named.
    let refused = scene("static", r#""yo\nung\u001b[0m" = 1"#, LEFT).err().unwrap();
    assert!(refused.contains(r"yo\u000aung\u001b[0m") && refused.lines().count() == 2, "{refused:?}");
    // Sentences have as many lines as they like.
    let text = "[scene]\nname = 'w'\nabout = \"one\\n\"\nreference = '''two\nlines'''\n[run]\ndt = 1\nsteps = 1\n[[bodies]]\nname = 'b'\n\
                mesh = { grid = { width = 10, height = 10, nx = 4, ny = 4 } }\nmaterial = { young = 1, poisson = 0.3, thickness = 0.1 }\n";
    Scene::parse(text, "w.toml").unwrap();
}

#[test]
fn pictures_and_frames_are_made_every_so_often() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["run", "fig2", "--set", "output.pictures=0", "--set", "output.frames_every=100", "--out"];
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_rhexis"));
    let output = command.args(arguments).arg(folder.path()).args(["--set", "run.dt=20", "--steps", "13"]);
    assert!(output.output().unwrap().status.success());
    let list = std::fs::read_to_string(folder.path().join("frames.pvd")).unwrap();
    let times: Vec<&str> = list.split("timestep=\"").skip(1).filter_map(|part| part.split('"').next()).collect();
    // The state at the end is written, too.
    assert_eq!(times, ["0", "100", "200", "260"]);
}

#[test]
fn springs_break_at_their_traction() {
    // A quarter of the sheet's springs would have to bear the pull alone: all break, from the pulled side on.
    let springs = "[[bodies.springs]]\nregion = { all = true }\nper_area = 0.01\nbreak_traction = 1e-3\n";
    let pull = "[[bodies.holds]]\nname = 'pull'\nregion = { x = 10 }\nmove = { offset = [1, 0, 0] }\ncurve = [[0, 0], [100, 5]]\n";
    let mut instance =
        scene("dynamic", "planar = true\ndamping = 1\ndrag = 1e-4", &format!("{springs}{pull}")).unwrap();
    let count = |instance: &Instance| {
        let world = instance.simulation.world();
        world.get::<&rhexis::components::Springs>(instance.bodies[0].entity()).unwrap().anchors.rows().len()
    };
    let (mut broken, mut at_once) = (0, 0);
    assert_eq!(count(&instance), 25);
    for _ in 0..400 {
        instance.advance().unwrap();
        at_once = instance.broken_springs.iter().map(|(_, count)| *count).sum();
        broken += at_once;
        assert_eq!(count(&instance) + broken, 25);
    }
    // At 0.1 mm the five held ones break, at the latest; where nothing is held any more nothing breaks.
    assert!(broken == 25 && at_once == 0, "{broken}");
    let two = springs.to_owned() + &springs.replace("1e-3", "2e-3");
    assert!(scene("dynamic", "planar = true", &format!("{two}{pull}")).err().unwrap().contains("at one traction"));
}

#[test]
fn a_bed_lets_go_by_its_energy() {
    let bed = "[[bodies.beds]]\nregion = { all = true }\nenergy = 0.01\nstrength = 2e-3\n";
    let pull = "[[bodies.holds]]\nname = 'pull'\nregion = { x = 10 }\nmove = { offset = [1, 0, 0] }\ncurve = [[0, 0], [2000, 40]]\n";
    let mut instance = scene("dynamic", "planar = true\ndamping = 1\ndrag = 1e-4", &format!("{bed}{pull}")).unwrap();
    let of = |instance: &Instance| instance.simulation.bed(instance.bodies[0]).unwrap();
    let whole = of(&instance);
    // A square of 10 mm, in cells of 2.5 mm that allow 1.2e-3 MPa.
    assert!((whole.area - 100.0).abs() < 1e-12 && (whole.off, whole.energy) == (0.0, 0.0), "{whole:?}");
    assert!(whole.resolved > 0.5 && whole.resolved < 0.7, "{whole:?}");
    for _ in 0..1500 {
        instance.advance().unwrap();
        if of(&instance).off == whole.area {
            break;
        }
    }
    // All of it is off, and has taken its energy.
    let gone = of(&instance);
    assert!(gone.off == whole.area && (gone.energy - 1.0).abs() < 1e-12, "{gone:?}");

    let refused = |more: &str| scene("dynamic", "planar = true", more).err().unwrap();
    let springs = "[[bodies.springs]]\nregion = { x = 0 }\nper_area = 0.01\n";
    assert!(refused(&format!("{bed}{springs}")).contains("has springs or another bed already"));
    let soft = refused(&format!("{bed}stiffness = 1e-4\n"));
    assert!(soft.contains("beds.0.stiffness") && soft.contains("strength² / (2 · energy)"), "{soft}");
    assert!(refused(&bed.replace("0.01", "0")).contains("beds.0.energy"));
    assert!(refused(&bed.replace("energy = 0.01", "adhesion = 0.01")).contains("beds"));
}
