//! Cuts by a polyline: what of it is cut, whatever lies in its way, and the same lips however it is given.

use super::meshes::Random;
use glam::DVec3;
use rhexis::components::Material;
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::settings::Settings;
use rhexis::simulation::{Cut, CutError, Simulation};
use rhexis::storage::{BodyId, TriangleMesh, Triangles, Vertices, measure};
use rhexis_scene::{Instance, Scene};
use std::f64::consts::PI;

const GRID: &str = "grid = { width = 10, height = 10, nx = 10, ny = 10 }";

fn scene(mesh: &str, more: &str) -> Result<Instance, String> {
    let text = format!(
        "[scene]\nname = 's'\n[run]\ndt = 1\nsteps = 4\n[[bodies]]\nname = 'b'\nplanar = true\nmesh = {{ {mesh} }}\n\
         material = {{ young = 1, poisson = 0.3, thickness = 0.1 }}\n\
         [[bodies.holds]]\nname = 'all'\nregion = {{ all = true }}\n{more}"
    );
    Scene::parse(&text, "s.toml").and_then(|scene| scene.instantiate()).map_err(|error| error.to_string())
}

fn cuts(polylines: &[&str]) -> String {
    polylines.iter().map(|line| format!("[[bodies.cuts]]\npolyline = {line}\n")).collect()
}

/// Asked and made \[mm\].
fn lengths(instance: &Instance) -> (f64, f64) {
    instance.cuts.iter().fold((0.0, 0.0), |(asked, made), cut| (asked + cut.asked, made + cut.made))
}

#[test]
fn a_cut_goes_on_behind_a_slit_a_hole_and_itself() {
    let crossing = scene(GRID, &cuts(&["[[2, 5], [8, 5]]", "[[5, 2], [5, 8]]"])).unwrap();
    // Points of the grid: exact but for roundings.
    assert!((lengths(&crossing).1 - 12.0).abs() < 1e-9, "{:?}", crossing.cuts);
    assert_eq!(crossing.cuts[1].strokes, 2);
    let across = scene("plate_with_hole = { points = 32 }", &cuts(&["[[-3, 0], [3, 0]]"])).unwrap();
    assert_eq!(across.cuts[0].strokes, 2);
    // A chord of the hole's 32 points lies 0.005 mm inside its circle.
    assert!((lengths(&across).1 - 4.0).abs() < 0.011, "{:?}", across.cuts);
    // A loop whose end crosses its beginning and goes on.
    let own = scene(GRID, &cuts(&["[[2, 5], [8, 5], [8, 8], [5, 8], [5, 2]]"])).unwrap();
    assert!((lengths(&own).1 - 18.0).abs() < 1e-9, "{:?}", own.cuts);
}

#[test]
fn a_cut_is_clipped_where_it_enters_and_outside_it_is_refused() {
    let entering = scene(GRID, &cuts(&["[[11, 15], [5, 6]]"])).unwrap();
    // From (7.667, 10) to (5, 6).
    assert!((lengths(&entering).1 - 4.807_4).abs() < 1e-3, "{:?}", entering.cuts);
    assert!((lengths(&entering).0 - 10.816_7).abs() < 1e-3);
    let outside = scene(GRID, &cuts(&["[[11, 15], [11, 5]]"])).err().unwrap();
    assert!(outside.contains("outside the body"), "{outside}");
}

#[test]
fn a_tee_is_cut_upwards_as_downwards() {
    for branch in ["[[5, 5], [5, 8]]", "[[5, 5], [5, 2]]", "[[5, 8], [5, 5]]", "[[5, 2], [5, 5]]"] {
        let tee = scene(GRID, &cuts(&["[[2, 5], [8, 5]]", branch])).unwrap();
        assert!((lengths(&tee).1 - 9.0).abs() < 1e-9, "{branch}: {:?}", tee.cuts);
    }
}

#[test]
fn a_line_of_many_points_is_thinned() {
    let points: Vec<String> =
        (0..100).map(|k| format!("[{}, {}]", 2.0 + 0.06 * k as f64, 4.3 + 0.01 * k as f64)).collect();
    let dense = scene(GRID, &cuts(&[&format!("[{}]", points.join(", "))])).unwrap();
    let ends = scene(GRID, &cuts(&["[[2.0, 4.3], [7.94, 5.29]]"])).unwrap();
    let ((asked, made), (_, of_ends)) = (lengths(&dense), lengths(&ends));
    assert!((asked - 6.0219).abs() < 1e-3 && (made - of_ends).abs() < 1e-9, "{asked} {made} {of_ends}");
}

#[test]
fn cuts_and_blades_come_at_their_times() {
    let more = "[[bodies.cuts]]\npolyline = [[5, 10], [5, 5]]\nat = 2\n";
    let mut instance = scene(GRID, more).unwrap();
    let made: Vec<usize> =
        (0..4).map(|_| instance.advance().map(|_| ()).map(|()| instance.cuts.len()).unwrap()).collect();
    assert_eq!(made, [0, 0, 1, 1]);
    assert!((lengths(&instance).1 - 5.0).abs() < 1e-9 && instance.cuts[0].time == 2.0);
    let late = scene(GRID, "[[bodies.cuts]]\npolyline = [[5, 10], [5, 5]]\nat = 9\n").unwrap();
    assert_eq!(late.cuts[0].to_string(), "b, cuts.0 at 9 ms: not made, the run ends at 4 ms");
    let more = "[[bodies.blades]]\npath = [[0, [5, 10, 0]], [3, [5, 5, 0]]]\nleast = 1\n";
    let mut instance = scene(GRID, more).unwrap();
    (0..4).for_each(|_| _ = instance.advance().unwrap());
    assert!((lengths(&instance).1 - 5.0).abs() < 1e-6, "{:?}", instance.cuts);
    let more = "[[bodies.punctures]]\nat = 1\npoint = [5, 5, 0]\ndirection = [1, 0, 0]\nlength = 2\n";
    let mut instance = scene(GRID, more).unwrap();
    (0..4).for_each(|_| _ = instance.advance().unwrap());
    assert!((lengths(&instance).1 - 2.0).abs() < 1e-9, "{:?}", instance.cuts);
    for (bad, key) in [("at = -1", "bodies.cuts"), ("at = 1e300", "bodies.cuts")] {
        let refused = scene(GRID, &format!("[[bodies.cuts]]\npolyline = [[5, 10], [5, 5]]\n{bad}\n")).err();
        assert!(refused.is_some_and(|why| why.contains("s.toml:")), "{bad} {key}");
    }
    for bad in ["reach = 0", "least = -1"] {
        let more = format!("[[bodies.blades]]\npath = [[0, [5, 10, 0]], [3, [5, 5, 0]]]\n{bad}\n");
        assert!(scene(GRID, &more).err().is_some_and(|why| why.contains("above zero")), "{bad}");
    }
}

fn cut(mesh: &TriangleMesh, before: &[Vec<DVec3>], lines: &[Vec<DVec3>]) -> Result<Vec<Cut>, CutError> {
    let (mut simulation, body) = sheet(mesh);
    before.iter().for_each(|line| _ = simulation.cut(body, line).unwrap());
    lines.iter().map(|line| simulation.cut(body, line)).collect()
}

fn sheet(mesh: &TriangleMesh) -> (Simulation, BodyId) {
    let mut simulation = Simulation::new(Settings { threads: 1, ..Settings::default() }).unwrap();
    let body = simulation.spawn(Membrane::new("b", mesh.clone(), Material::isotropic(1.0, 0.3, 0.1))).unwrap();
    (simulation, body)
}

fn smallest_angle(simulation: &Simulation, body: BodyId) -> f64 {
    let mut tables = simulation.world().query_one::<(&Vertices, &Triangles)>(body.entity());
    let (vertices, triangles) = tables.get().unwrap();
    measure::rest_angles(vertices, triangles).fold(f64::INFINITY, f64::min)
}

/// Short cuts, one after the other, on coarse meshes: what is moved out of a line's way is judged as the triangles along it are.
#[test]
fn no_cut_leaves_a_worse_angle_than_ten_degrees_anywhere() {
    let mut dice = Random::new(3);
    for mesh in [generate::grid(10.0, 10.0, 5, 4).unwrap(), generate::cap(10.0, 10.0, 60).unwrap()] {
        let low = mesh.positions.iter().fold(DVec3::MAX, |low, p| low.min(*p));
        let high = mesh.positions.iter().fold(DVec3::MIN, |high, p| high.max(*p));
        for round in 0..100 {
            let (mut simulation, body) = sheet(&mesh);
            for _ in 0..12 {
                let from = low + (high - low) * DVec3::new(dice.unit(), dice.unit(), dice.unit());
                let line = [from, from + dice.vector(0.8)];
                // Rounding of an angle that is just enough.
                let least = smallest_angle(&simulation, body).min(10_f64.to_radians()) * (1.0 - 1e-9);
                let cut = simulation.cut(body, &line);
                assert!(smallest_angle(&simulation, body) >= least, "{round}: {line:?}, {cut:?}");
            }
        }
    }
}

/// A sheet of 44 by 30 mm whose edges of 2 mm are irregular and whose upper rim is a wave, and the height of that rim.
fn wavy_sheet() -> (TriangleMesh, fn(f64) -> f64) {
    let rim = |x: f64| 30.0 + 1.8 * (3.0 * PI * x / 44.0).sin();
    let mut mesh = generate::grid(44.0, 30.0, 22, 15).unwrap();
    let mut dice = Random::new(5);
    for p in &mut mesh.positions {
        let is_inside = p.x > 0.0 && p.x < 44.0 && p.y > 0.0 && p.y < 30.0;
        let jitter = if is_inside { dice.vector(0.45) } else { DVec3::ZERO };
        *p = DVec3::new(p.x, p.y * rim(p.x) / 30.0, 0.0) + jitter.with_z(0.0);
    }
    (mesh, rim)
}

/// A notch by somebody who does not know where exactly the rim is: beside it, on it, some tenths of an edge inside.
#[test]
fn a_notch_is_made_wherever_it_begins_near_the_rim() {
    let (mesh, rim) = wavy_sheet();
    let edge = 2.0;
    let mut refused = Vec::new();
    for inside in [-1.0, -0.1, 0.1, 0.3, 0.5, 0.8, 1.2] {
        for k in 0..100 {
            let x = 4.0 + 36.0 * (k as f64 + 0.37) / 100.0;
            let line = [DVec3::new(x, rim(x) - inside, 0.0), DVec3::new(x, rim(x) - 5.0, 0.0)];
            let (mut simulation, body) = sheet(&mesh);
            match simulation.cut(body, &line) {
                // An end goes half an edge at the most; a cut that left its line by more were another one.
                Ok(cut) => assert!(cut.off_line <= 0.5 * edge && (cut.made - 5.0).abs() < 2.0, "{inside} {x}: {cut:?}"),
                Err(error) => refused.push(format!("{inside} {x}: {error}")),
            }
        }
    }
    assert!(refused.is_empty(), "{} of 700: {refused:#?}", refused.len());
}

/// Largest distance \[mm\] of the points of some cuts from the lips of others.
fn apart(a: &[Cut], b: &[Cut]) -> f64 {
    let to_segment = |p: DVec3, s: &[DVec3]| {
        let along = ((p - s[0]).dot(s[1] - s[0]) / (s[1] - s[0]).length_squared()).clamp(0.0, 1.0);
        p.distance(s[0] + (s[1] - s[0]) * along)
    };
    let strokes = |cuts: &[Cut]| -> Vec<Vec<DVec3>> {
        let mut strokes = Vec::new();
        for cut in cuts {
            let mut rest = cut.path.as_slice();
            for &count in &cut.strokes {
                strokes.push(rest[..count].to_vec());
                rest = &rest[count..];
            }
        }
        strokes
    };
    let b = strokes(b);
    let to_b = |p: DVec3| b.iter().flat_map(|s| s.windows(2)).map(|s| to_segment(p, s)).fold(f64::INFINITY, f64::min);
    strokes(a).iter().flatten().map(|&p| to_b(p)).fold(0.0, f64::max)
}

/// A body with its mirror image across x = 0, earlier cuts, and how a point of the plane comes to lie on it.
struct Case {
    name: &'static str,
    mesh: TriangleMesh,
    before: Vec<Vec<DVec3>>,
    on_surface: fn(DVec3) -> DVec3,
    /// Lines begin and end within this distance \[mm\] from the middle, in x and in y.
    reach: f64,
    /// A point this near to the middle, in x and in y, is inside the body.
    inside: f64,
    /// Chords lie on the body.
    is_flat: bool,
    /// How near to the lips of the whole line those of its two parts are \[mm\].
    near_in_parts: f64,
}

/// Wedges \[rad\] below 15° are left to the mesh: it keeps angles of 10° where it can.
const SHARPEST: f64 = 15.0 * PI / 180.0;

/// Lips that are the same are this near to each other \[mm\]: roundings of lines of 10 mm, at crossings of 1e-3 rad at the least.
const ROUNDING: f64 = 1e-9;

fn mirrored(p: DVec3) -> DVec3 {
    DVec3::new(-p.x, p.y, p.z)
}

/// The same line refined tenfold, reversed, mirrored and split in two leaves the same lips.
fn check_lips(case: &Case, rounds: usize) {
    let Case { mesh, before, .. } = case;
    let mut image = mesh.clone();
    image.positions.iter_mut().for_each(|p| *p = mirrored(*p));
    image.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    let image_before: Vec<Vec<DVec3>> = before.iter().map(|l| l.iter().map(|p| mirrored(*p)).collect()).collect();
    let mut dice = Random::new(11);
    let mut made = 0;
    let mut bad = Vec::new();
    for round in 0..rounds {
        let count = 2 + round % 3;
        let mut place = || case.reach * (2.0 * dice.unit() - 1.0);
        let line: Vec<DVec3> = (0..count).map(|_| (case.on_surface)(DVec3::new(place(), place(), 0.0))).collect();
        let Ok(plain) = cut(mesh, before, std::slice::from_ref(&line)) else { continue };
        made += 1;
        if case.is_flat && plain[0].off_line > ROUNDING {
            // The mesh has no room for good triangles along the line, or it begins or ends beside the rim.
            continue;
        }
        if line.windows(3).any(|p| (p[1] - p[0]).angle_between(p[2] - p[1]) > PI - SHARPEST) {
            continue;
        }
        let mut compare = |what: &str, near: f64, other: Result<Vec<Cut>, CutError>, back: fn(DVec3) -> DVec3| {
            let mut other = match other {
                Ok(other) => other,
                Err(error) => {
                    bad.push(format!("{} {round} {what} {line:?}: {error}", case.name));
                    return;
                }
            };
            other.iter_mut().flat_map(|cut| &mut cut.path).for_each(|p| *p = back(*p));
            let length = |cuts: &[Cut]| cuts.iter().map(|cut| cut.made).sum::<f64>();
            let off = apart(&plain, &other).max(apart(&other, &plain));
            let longer = length(&other) - length(&plain);
            if off > near || longer.abs() > 10.0 * near {
                bad.push(format!("{} {round} {what} {line:?}: {off:e} mm apart, {longer:e} mm longer", case.name));
            }
        };
        let pairs = line.windows(2);
        let refined = pairs.flat_map(|pair| (0..10).map(|k| pair[0].lerp(pair[1], f64::from(k) / 10.0)));
        let refined: Vec<DVec3> = refined.chain(line.last().copied()).collect();
        compare("refined", ROUNDING, cut(mesh, before, &[refined]), |p| p);
        compare("reversed", ROUNDING, cut(mesh, before, &[line.iter().rev().copied().collect()]), |p| p);
        let turned = line.iter().map(|p| mirrored(*p)).collect();
        compare("mirrored", ROUNDING, cut(&image, &image_before, &[turned]), mirrored);
        let middle = line[1];
        if count > 2 && middle.x.abs().max(middle.y.abs()) < case.inside {
            compare("split", case.near_in_parts, cut(mesh, before, &[line[..2].to_vec(), line[1..].to_vec()]), |p| p);
        }
    }
    assert!(bad.is_empty(), "{} bad:\n{}", bad.len(), bad.join("\n"));
    // Random lines pass as near to vertices that may not move as they like, where nothing fits between.
    assert!(made * 10 >= rounds * 8, "{}: {made} of {rounds}", case.name);
}

fn on_a_plate(name: &'static str, before: Vec<Vec<DVec3>>) -> Case {
    let mut mesh = generate::grid(10.0, 10.0, 12, 11).unwrap();
    mesh.positions.iter_mut().for_each(|p| *p -= DVec3::new(5.0, 5.0, 0.0));
    let on_surface = |p| p;
    Case { name, mesh, before, on_surface, reach: 6.0, inside: 4.5, is_flat: true, near_in_parts: ROUNDING }
}

#[test]
fn the_same_line_given_otherwise_leaves_the_same_lips_on_a_plate() {
    check_lips(&on_a_plate("flat", vec![]), 60);
}

#[test]
fn the_same_line_given_otherwise_leaves_the_same_lips_on_a_torn_plate() {
    let slit = vec![DVec3::new(-1.9, -3.0, 0.0), DVec3::new(1.7, 3.1, 0.0)];
    check_lips(&on_a_plate("torn", vec![slit]), 60);
}

#[test]
fn the_same_line_given_otherwise_leaves_the_same_lips_on_a_cap() {
    let mesh = generate::cap(10.0, 10.0, 600).unwrap();
    let on_surface = |p: DVec3| DVec3::new(p.x, p.y, (100.0 - p.x * p.x - p.y * p.y).sqrt() - 10.0);
    // A part may be cut from another end than the whole line was, and a way over the triangles from either end leaves that of the
    // other by some sagittas of an edge of 0.6 mm, h²/(8·R) = 5 µm.
    let case = Case {
        name: "cap",
        is_flat: false,
        mesh,
        before: vec![],
        on_surface,
        reach: 3.4,
        inside: 3.4,
        near_in_parts: 0.02,
    };
    check_lips(&case, 60);
}

/// A run that goes on compares all that its scene was read from.
#[test]
fn all_files_that_a_scene_reads_are_named() {
    let text = "[scene]\nname = 's'\n[run]\ndt = 1\nsteps = 1\n[[bodies]]\nname = 'b'\nmesh = { file = 'm.obj' }\n\
                material = { young = 1, poisson = 0.3, thickness = 0.1 }\nfibres = { file = 'f.txt' }\n\
                per_triangle = { thickness = { file = 'h.txt' }, strength = 'array' }\n";
    let files = Scene::parse(text, "s.toml").unwrap().data_files();
    let names: Vec<_> = files.iter().filter_map(|file| file.file_name()?.to_str()).collect();
    assert_eq!(names, ["f.txt", "h.txt", "m.obj"]);
}
