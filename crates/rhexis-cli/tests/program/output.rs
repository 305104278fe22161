//! Pictures and lists of ParaView files of invented bodies: files give the bodies back, and hostile content is refused.
//! The pictures stay in `target/tmp` to be looked at.

use crate::bodies::{Sheet, cap, sheet};
use glam::{DVec2, DVec3};
use rhexis::frame::{BodyFrame, Frame};
use rhexis_cli::output::{OutputError, PictureSettings, PvdWriter, View, render, write_vtu};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use tiny_skia::Pixmap;

fn picture_path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

fn drawn(name: &str, body: &BodyFrame, settings: &PictureSettings) -> Pixmap {
    let path = picture_path(name);
    render(&path, body, settings).unwrap();
    Pixmap::load_png(&path).unwrap()
}

fn rgb(picture: &Pixmap, x: u32, y: u32) -> [u8; 3] {
    let c = picture.pixel(x, y).unwrap().demultiply();
    [c.red(), c.green(), c.blue()]
}

/// Where the uncovered sheet lies on the default picture: its black rim is the only frame of the main view.
fn sheet_to_pixel(picture: &Pixmap, sheet: &Sheet) -> impl Fn(DVec2) -> (u32, u32) {
    // The rim of the left edge at mid-height, and of the bottom edge, found from outside.
    let dark = |x: u32, y: u32| rgb(picture, x, y).iter().all(|&v| v < 90);
    let middle = picture.height() / 2;
    let left = (0..picture.width()).find(|&x| dark(x, middle)).unwrap();
    let right = (left..1150).rev().find(|&x| dark(x, middle)).unwrap();
    let bottom = (0..1100).rev().find(|&y| dark((left + right) / 2 + 60, y)).unwrap();
    let scale = f64::from(right - left) / (sheet.high.x - sheet.low.x);
    let low = sheet.low;
    move |p| {
        let q = (p - low) * scale;
        ((f64::from(left) + q.x).round() as u32, (f64::from(bottom) - q.y).round() as u32)
    }
}

#[test]
fn a_torn_sheet_is_drawn_with_its_gap_open() {
    let sheet = sheet();
    let picture = drawn("sheet.png", &sheet.body, &PictureSettings::titled("fig2-tear, invented field", 482.5, 97, 2));
    assert_eq!((picture.width(), picture.height()), (1600, 1200));

    let at = sheet_to_pixel(&picture, &sheet);
    let (x, y) = at(sheet.in_gap);
    assert_eq!(rgb(&picture, x, y), [255; 3], "the gap shows the background");
    let (x, y) = at(sheet.in_body);
    assert_ne!(rgb(&picture, x, y), [255; 3], "the sheet beside the gap does not");

    // Stresses differ everywhere, so the colours must: strokes and text alone would give some hundred shades of grey.
    let colors: BTreeSet<[u8; 3]> = (0..picture.height())
        .flat_map(|y| (0..picture.width()).map(move |x| (x, y)))
        .map(|(x, y)| rgb(&picture, x, y))
        .filter(|c| c.iter().max().unwrap() - c.iter().min().unwrap() > 60)
        .collect();
    assert!(colors.len() > 1000, "{} colours", colors.len());
}

#[test]
fn colours_follow_the_stated_range() {
    let mut sheet = sheet();
    sheet.body.tips.clear();
    for p in &mut sheet.body.principal_stress {
        p.x = 0.5;
    }
    let plain = PictureSettings { show_fibres: false, show_tips: false, ..PictureSettings::default() };
    let color = |range| {
        let settings = PictureSettings { stress_range: Some(range), ..plain.clone() };
        let picture = drawn(&format!("range-{}.png", range[1]), &sheet.body, &settings);
        let (x, y) = sheet_to_pixel(&picture, &sheet)(sheet.in_body);
        // The brightest nearby, as a mesh edge may pass through the point.
        let near = (x - 4..=x + 4).flat_map(|x| (y - 4..=y + 4).map(move |y| (x, y)));
        near.map(|(x, y)| rgb(&picture, x, y)).max_by_key(|c| c.map(u32::from).iter().sum::<u32>()).unwrap()
    };
    // Viridis: dark violet at the low end, yellow at the high end.
    let [r, g, b] = color([0.0, 100.0]);
    assert!(r < 90 && g < 40 && b > 60 && b < 120, "{:?}", [r, g, b]);
    let [r, g, b] = color([0.0, 0.5]);
    assert!(r > 220 && g > 200 && b < 90, "{:?}", [r, g, b]);
}

#[test]
fn a_cap_is_drawn_obliquely_and_from_above() {
    let cap = cap();
    let settings = PictureSettings::titled("capsulorhexis, invented field", 12_345.0, 2469, 1);
    let oblique = drawn("cap-oblique.png", &cap, &settings);
    let above = drawn("cap-top.png", &cap, &PictureSettings { view: View::Top, ..settings.clone() });
    assert_ne!(oblique.data(), above.data());
    let small = drawn("cap-small.png", &cap, &PictureSettings { size: [400, 300], ..settings });
    assert_eq!((small.width(), small.height()), (400, 300));
}

#[test]
fn the_same_body_gives_the_same_bytes() {
    let body = cap();
    let files = ["same-a.png", "same-b.png"].map(picture_path);
    for path in &files {
        render(path, &body, &PictureSettings { size: [400, 300], ..PictureSettings::default() }).unwrap();
    }
    let [a, b] = files.map(|path| std::fs::read(path).unwrap());
    assert!(a == b);
}

#[test]
fn what_cannot_be_shown_is_refused_not_drawn() {
    let path = picture_path("refused.png");
    let _ = std::fs::remove_file(&path);
    let settings = PictureSettings::default();
    let good = sheet().body;

    let mut no_number = good.clone();
    no_number.positions[7].y = f64::NAN;
    let mut point = good.clone();
    point.positions.fill(DVec3::ONE);
    let mut short = good.clone();
    short.stress.pop();
    let mut dangling = good.clone();
    dangling.triangles[3][1] = u32::MAX;
    for (body, word) in [
        (BodyFrame::default(), "no triangles"),
        (no_number, "vertex 7"),
        (point, "no extent"),
        (short, "`stress`"),
        (dangling, "triangle 3"),
    ] {
        let message = render(&path, &body, &settings).unwrap_err().to_string();
        assert!(message.contains(word) && message.contains("refused.png"), "{message}");
    }
    for size in [[0, 1200], [1600, u32::MAX], [159, 1200]] {
        assert!(matches!(
            render(&path, &good, &PictureSettings { size, ..settings.clone() }),
            Err(OutputError::Content { .. })
        ));
    }
    assert!(!path.exists());
}

#[test]
fn hostile_values_are_drawn_without_panic() {
    let values = [f64::NAN, f64::INFINITY, -f64::INFINITY, 0.0, 1e300, -1e300, 1e-300];
    let mut body = sheet().body;
    for (t, &v) in (0..body.triangles.len()).zip(values.iter().cycle()) {
        body.principal_stress[t].x = v;
        body.fibres[t] = DVec3::splat(v);
    }
    let tip = body.tips[0].clone();
    for &v in &values {
        let mut hostile = tip.clone();
        hostile.value = v;
        hostile.radius = v;
        hostile.direction = DVec3::splat(v);
        hostile.previous = Some(DVec3::splat(v));
        hostile.curve.iter_mut().for_each(|(_, c)| *c = v);
        let mut elsewhere = hostile.clone();
        elsewhere.position = DVec3::splat(v);
        body.tips.extend([hostile, elsewhere]);
    }
    let ranges = [None, Some([f64::NAN, 1.0]), Some([1.0, 1.0]), Some([-1e300, 1e300]), Some([0.0, 1e-300])];
    let views = [View::Auto, View::Top, View::Oblique { azimuth: f64::NAN, elevation: 1e300 }];
    for (range, view) in ranges.into_iter().zip(views.into_iter().cycle()) {
        for first in 0..body.tips.len() {
            let mut one = body.clone();
            one.tips = body.tips[first..].to_vec();
            let settings =
                PictureSettings { size: [200, 160], stress_range: range, view, ..PictureSettings::default() };
            render(&picture_path("hostile.png"), &one, &settings).unwrap();
        }
    }
    body.positions.iter_mut().for_each(|x| x.y = 0.0);
    render(&picture_path("hostile.png"), &body, &PictureSettings { size: [200, 160], ..PictureSettings::default() })
        .unwrap();
}

#[test]
fn the_list_of_files_is_whole_after_every_frame() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.pvd");
    let mut list = PvdWriter::create(&path).unwrap();
    let text = || std::fs::read_to_string(&path).unwrap();
    assert!(text().contains("</Collection>") && !text().contains("<DataSet"));

    let mut second = cap();
    second.name = "a/b <\"&>".to_owned();
    let mut frame = Frame { step: 0, time: 0.0, bodies: vec![sheet().body, second], solids: Vec::new() };
    for step in 1..=3 {
        frame.step = step;
        frame.time = 2.5 * step as f64;
        let files = list.write_frame(&frame).unwrap();
        assert_eq!(files.len(), 2);
        // What is listed exists, relative to the list, and the text is closed.
        let listed: Vec<String> = text()
            .lines()
            .filter_map(|line| Some(line.split_once("file=\"")?.1.split_once('"')?.0.to_owned()))
            .collect();
        assert_eq!(listed.len(), 2 * step as usize);
        assert!(listed.iter().all(|name| folder.path().join(name).is_file()), "{listed:?}");
        assert!(text().trim_end().ends_with("</VTKFile>"));
        assert!(text().contains(&format!("timestep=\"{}\" part=\"1\"", frame.time)));
    }
    assert!(text().contains("name=\"a/b &lt;&quot;&amp;&gt;\""));
    assert!(list.append(f64::NAN, &[]).is_err());
    let left: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(left.len(), 7, "six frames and the list, no leftovers: {left:?}");
}

#[test]
fn an_error_names_the_file_and_the_fix() {
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("missing").join("body.vtu");
    let message = write_vtu(&missing, &sheet().body).unwrap_err().to_string();
    assert!(message.contains("body.vtu") && message.contains("create the directory"), "{message}");

    let taken = folder.path().join("taken.png");
    std::fs::create_dir(&taken).unwrap();
    let message = render(&taken, &sheet().body, &PictureSettings::default()).unwrap_err().to_string();
    assert!(message.contains("taken.png") && message.contains("a directory has this name"), "{message}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "no leftovers");
}

#[test]
fn solids_are_read_back_as_they_were() {
    let text = "[scene]\nname = 'w'\n[run]\ndt = 5\nsteps = 1\n[[bodies]]\nname = 'b'\n\
        mesh = { grid = { width = 10, height = 10, nx = 4, ny = 4 } }\n\
        material = { young = 1, poisson = 0.3, thickness = 0.1 }\ngravity = [0, 0, -9.81e-3]\ncontact = {}\n\
        [[obstacles]]\nbox = { centre = [5, 5, -1], half = [4, 4, 1] }\n\
        [[obstacles]]\nsphere = { centre = [5, 5, 9], radius = 2 }\n";
    let mut instance = rhexis_scene::Scene::parse(text, "w.toml").unwrap().instantiate().unwrap();
    instance.advance().unwrap();
    let solids = instance.simulation.frame().solids;
    assert!(solids.len() == 2 && solids[0].force.z > 0.0 && solids[1].force == DVec3::ZERO);
    // Of every solid the surface faces outwards.
    for solid in &solids {
        let outwards = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|v| solid.positions[v as usize]);
            (b - a).cross(c - a).dot(a + b + c - 3.0 * solid.at)
        };
        assert!(solid.triangles.iter().map(outwards).all(|volume| volume > -1e-9));
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("solids.vtu");
    rhexis_cli::output::write_solids(&path, &solids).unwrap();
    assert_eq!(rhexis_cli::output::read_solids(&path).unwrap(), solids);
}
