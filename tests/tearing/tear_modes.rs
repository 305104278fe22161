//! What steers a tear: the last direction and its cone, the mode, symmetry; where a tear starts by itself.

use crate::common::{self, Advance, Run, SIDE, Square, off_line};
use glam::{DVec2, DVec3};
use rhexis::components::{Curve, Hold, Material, TearLog, TearMode, Tearing};
use rhexis::event::{Event, EventKind};
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::settings::{Advanced, LinearParams, Settings};
use rhexis::simulation::Simulation;
use rhexis::storage::{Attached, BodyId};

const TIP: DVec2 = DVec2::new(15.0, 27.0);

/// Linear solves to roundings: the default of 1e-4 lets mirror images drift apart by 1e-7 mm.
fn exact() -> Settings {
    Settings {
        advanced: Advanced { linear: LinearParams::by_residual(1e-12, 10_000), ..Advanced::default() },
        ..Settings::default()
    }
}

fn degrees(a: DVec2, b: DVec2) -> f64 {
    a.angle_to(b).abs().to_degrees()
}

/// The first `count` advances of a square with fibres at `fibre`, cone θ_P \[°\] and a notch that comes from 3 mm above and
/// `aside` \[mm\], after a static stretch to `start` \[mm\]. Every advance must lie in its cone.
fn steered(count: usize, fibre: f64, cone: f64, aside: f64, start: f64) -> Vec<Advance> {
    // M(40,40) has edges along all three notches.
    let mut square = Square::new([40, 40], fibre);
    square.tearing.cone = cone.to_radians();
    // By whole triangles: the first advances turn by all that the cone allows.
    square.tearing.mode = TearMode::Free;
    // Weak tissue, so that even a narrow cone is left at strains of a few per cent; the directions do not feel a common factor.
    square.tearing.strength_across_fibres *= 0.2;
    square.tearing.strength_along_fibres *= 0.2;
    let mouth = DVec3::new(15.0 + aside, SIDE, 0.0);
    square.notches = vec![[mouth, TIP.extend(0.0)]];
    let mut run = square.spawn(Settings::default());
    for u in (1..).map(|i| 0.5 * f64::from(i)).take_while(|&u| u <= start) {
        run.stretch_to(u);
    }
    run.run_until(100, |run| run.advances().len() >= count);
    run.assert_sound();
    let advances = run.advances();
    let mut previous = TIP - mouth.truncate();
    for advance in &advances {
        // acos near 1 has half the digits.
        assert!(degrees(previous, advance.direction) <= cone + 1e-5);
        previous = advance.direction;
    }
    advances
}

/// Angles between the advances and the fibre at 45°, down to the left \[°\].
fn off_fibre(advances: &[Advance]) -> Vec<f64> {
    advances.iter().map(|a| degrees(a.direction, -DVec2::ONE)).collect()
}

#[test]
fn the_cone_limits_the_turn_into_the_fibre() {
    // Straight down, 45° off the fibre: a cone of 45° or 90° lets the tear turn into it at once.
    for cone in [45.0, 90.0] {
        let found = off_fibre(&steered(4, 45.0, cone, 0.0, 0.0));
        assert!(found.iter().all(|&off| off < 1e-5), "{found:?}");
    }
    // One of 15° cannot: after k advances the tear is at least 45° − 15°·k off.
    let found = off_fibre(&steered(4, 45.0, 15.0, 0.0, 1.0));
    assert!(found[0] >= 30.0 - 1e-5 && found[1] >= 15.0 - 1e-5, "{found:?}");
}

#[test]
fn the_direction_of_the_notch_steers_the_tear() {
    // Across the fibre, 90° off: the same cones now need more turns. The axis follows the tear by one cone per R of its length.
    for (cone, start) in [(15.0, 1.0), (45.0, 0.5)] {
        let advances = steered(4, 45.0, cone, -3.0, start);
        let found = off_fibre(&advances);
        assert!((found[0] - (90.0 - cone)).abs() < 1e-5, "{found:?}");
        let turned = cone * advances[0].to.distance(TIP) / Square::new([40, 40], 45.0).tearing.radius;
        assert!(turned < cone && found[1] > found[0] - turned - 1e-5, "{turned}: {found:?}");
        match cone < 30.0 {
            // The largest criterion lies at the limit,
            true => assert!((found[1] - (found[0] - turned)).abs() < 1e-5, "{turned}: {found:?}"),
            // or within it, until the fibre is: there the tear stays.
            false => assert!(found[3] < 1e-5, "{found:?}"),
        }
    }
    // Both ways along the fibre lie at the limit of a cone of 90°: a tie, and marked as one.
    let wide = steered(1, 45.0, 90.0, -3.0, 0.0);
    assert!(wide[0].is_ambiguous && wide[0].direction.dot(DVec2::new(1.0, -1.0)).abs() < 1e-9);
    // Along the fibre: nothing to turn.
    for cone in [15.0, 90.0] {
        let found = off_fibre(&steered(4, 45.0, cone, 3.0, 0.0));
        assert!(found.iter().all(|&off| off < 1e-5), "{found:?}");
    }
}

/// Fibres at 90°: the square with a notch from the left is the mirror image of that with a notch from the right.
#[test]
fn mirrored_notches_give_mirrored_paths() {
    for (cone, first, start) in [(15.0, -60.0, 1.0), (45.0, -90.0, 0.0)] {
        let [left, right] = [-3.0, 3.0].map(|aside| steered(6, 90.0, cone, aside, start));
        assert!((left[0].direction.to_angle().to_degrees() - first).abs() < 1e-5);
        assert_eq!(left.len(), right.len());
        for (l, r) in left.iter().zip(&right) {
            // Directions at a limit or along the fibre do not feel the solver's error: roundings remain.
            assert!(DVec2::new(SIDE - l.to.x, l.to.y).distance(r.to) < 1e-9);
        }
    }
}

fn in_mode(square: &Square, mode: TearMode, start: f64) -> Run {
    let mut square = square.clone();
    square.tearing.mode = mode;
    let mut run = square.spawn(Settings::default());
    run.stretch_to(start);
    run.tear_through();
    run.assert_sound();
    run
}

/// Where the mesh has an edge wherever the criterion wants to go, the modes cannot differ.
#[test]
fn edge_mode_on_an_aligned_mesh_gives_the_path_of_free_mode() {
    // M(40,40) has edges along x = 15, and along the diagonal through (15, 27).
    for (fibre, start) in [(90.0, 0.5), (45.0, 1.2)] {
        let square = Square::new([40, 40], fibre);
        let [free, edge] = [TearMode::Free, TearMode::Edge].map(|mode| in_mode(&square, mode, start).advances());
        assert_eq!(free.len(), edge.len());
        assert!(free.iter().zip(&edge).all(|(f, e)| f.to.distance(e.to) < 1e-9));
        assert!(free.iter().all(|a| off_line(a.to, TIP, fibre) < 1e-9));
    }
}

#[test]
fn edge_mode_stays_near_the_fibre_and_makes_no_triangle() {
    for (fibre, start) in [(60.0, 0.7), (75.0, 0.5)] {
        let square = Square::new([40, 34], fibre);
        let count = square.spawn(Settings::default()).triangle_count();
        let run = in_mode(&square, TearMode::Edge, start);
        assert_eq!(run.triangle_count(), count);
        let worst = run.advances().iter().map(|a| off_line(a.to, TIP, fibre)).fold(0.0, f64::max);
        println!("edge mode, {fibre}°: {:.2} edges off the line, end {}", worst / square.edge(), run.end());
        assert!(worst < square.edge());
    }
}

/// Under 180° about the centre the square with two notches is its own image, and so are its tears.
#[test]
fn two_opposite_notches_tear_alike() {
    let depth = 3.0 * SIDE / 26.0;
    let top = [DVec2::new(15.0, SIDE), DVec2::new(15.0, SIDE - depth)].map(|p| p.extend(0.0));
    let bottom = top.map(|p| DVec3::new(SIDE, SIDE, 0.0) - p);
    let square = Square { notches: vec![top, bottom], ..Square::new([30, 26], 45.0) };
    let mut run = square.spawn(exact());
    run.run_until(100, |run| !run.advances().is_empty());
    let advances = run.advances();
    assert_eq!(advances.len(), 2);
    assert!((advances[0].to + advances[1].to - DVec2::splat(SIDE)).length() < 1e-9);
    let vertices = run.vertices();
    let displacement = |v: usize| vertices.position[v] - vertices.rest_position[v];
    let mut worst = 0.0_f64;
    for v in 0..vertices.len() {
        let image = DVec3::new(SIDE, SIDE, 0.0) - vertices.rest_position[v];
        // Both copies of a parted vertex lie there; one of them must be the image.
        let at_image = (0..vertices.len()).filter(|&w| vertices.rest_position[w].distance(image) < 1e-9);
        let off = at_image.map(|w| (displacement(v) + displacement(w)).length()).fold(f64::INFINITY, f64::min);
        worst = worst.max(off);
    }
    // Linear solves to 1e-12 of displacements of 1 mm, over some forty steps.
    println!("symmetric to {worst:e} mm");
    assert!(worst < 1e-9);
}

/// Centre \[mm\] and radius \[mm\] of the thin part of a graded sheet.
const THIN: DVec3 = DVec3::new(12.0, 14.0, 0.0);
const THIN_RADIUS: f64 = 4.0;

/// A sheet of isotropic tissue under uniform uniaxial tension: only x is held at its ends, and y at one corner.
fn uniform_sheet(is_graded: bool) -> (Simulation, BodyId) {
    let mesh = generate::grid(SIDE, SIDE, 20, 16).unwrap();
    let tearing = Tearing {
        may_initiate: true,
        strength_across_fibres: 0.2,
        strength_along_fibres: 0.2,
        radius: 3.0,
        ..Tearing::default()
    };
    let thickness = move |p: DVec3| if is_graded && p.distance(THIN) < THIN_RADIUS { 0.06 } else { 0.1 };
    let mut membrane = Membrane::new("sheet", mesh, Material::isotropic(3.0, 0.3, 0.1))
        .graded(move |p| Material::isotropic(3.0, 0.3, thickness(p)))
        .planar()
        .with(tearing);
    let curve = Curve::new(vec![(0.0, 0.0), (1e4, 1e4 * common::GRIP_SPEED)]).unwrap();
    for (name, x, to) in [("left", 0.0, -1.0), ("right", SIDE, 1.0)] {
        let rows = membrane.select(|p| p.x == x).into_iter();
        let members = Attached::new(rows.map(|row| (row, DVec3::X * to)));
        membrane = membrane.hold(Hold { name: name.into(), members, axes: [true, false, false], curve: curve.clone() });
    }
    let corner = Attached::new([(0, DVec3::ZERO)]);
    membrane = membrane.hold(Hold { name: "corner".into(), members: corner, axes: [false, true, false], curve });
    let mut simulation = Simulation::new(Settings::default()).unwrap();
    let body = simulation.spawn(membrane).unwrap();
    (simulation, body)
}

fn starts(events: &[Event]) -> Vec<DVec3> {
    let start = |e: &Event| if let EventKind::Started { at, .. } = e.kind { Some(at) } else { None };
    events.iter().filter_map(start).collect()
}

/// The stress of the uniform sheet is E times the strain, exactly, so the load of the first start is known.
#[test]
fn a_sheet_without_a_notch_tears_where_the_criterion_exceeds_one_and_not_before() {
    let (mut simulation, _) = uniform_sheet(false);
    // Each grip moves half of the elongation.
    let load = 0.5 * SIDE * 0.2 / 3.0;
    // The static tolerance of 1e-10 leaves room for a bracket of 1e-6.
    for (part, is_torn) in [(0.5, false), (1.0 - 1e-6, false), (1.0 + 1e-6, true)] {
        let dt = part * load / common::GRIP_SPEED - simulation.time();
        simulation.settle_and_tear(dt, 1e-10, 1).unwrap();
        let events: Vec<Event> = simulation.drain_events().collect();
        assert_eq!(!starts(&events).is_empty(), is_torn, "at {part} of the load");
    }
}

#[test]
fn a_tear_starts_with_two_tips_in_the_thin_part_of_a_sheet() {
    let (mut simulation, body) = uniform_sheet(true);
    simulation.settle(0.7 / common::GRIP_SPEED, 1e-8).unwrap();
    let mut events: Vec<Event> = Vec::new();
    let advance_count = |s: &Simulation| s.world().get::<&TearLog>(body.entity()).unwrap().advance_count;
    while advance_count(&simulation) < 2 && simulation.time() < 330.0 {
        // So slowly that the tear runs before the rest of the sheet is loaded beyond its strength.
        simulation.step(1.0).unwrap();
        events.extend(simulation.drain_events());
    }
    // Both tips, once: at the edge of the thin part they rest. The tear is then as long as the averaging radius, which is
    // little of a stress concentration.
    assert_eq!(advance_count(&simulation), 2);
    // Tips raise no other tears around them.
    let [one, other] = starts(&events)[..] else { panic!("{events:?}") };
    let middle = 0.5 * (one + other);
    assert!(middle.distance(THIN) < THIN_RADIUS, "{middle}");
    // The pull is along x, so the slit runs along y.
    assert!((one - other).normalize().y.abs() > 0.99);
}
