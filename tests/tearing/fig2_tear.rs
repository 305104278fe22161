//! The `fig2-tear` square tears through along its fibres, or straight across where it is isotropic.

use crate::common::{DT, GRIP_SPEED, Run, SIDE, Square, off_line};
use glam::DVec2;
use rhexis::components::Holds;
use rhexis::event::EventKind;
use rhexis::settings::Settings;

const CELLS: [usize; 2] = [60, 50];
const TIP: DVec2 = DVec2::new(15.0, 27.0);

/// Tears a square through after a static stretch to `start` \[mm\] and checks all that a complete tear must show.
fn torn_through(square: &Square, start: f64) -> Run {
    let mut run = square.spawn(Settings::default());
    run.stretch_to(start);
    run.tear_through();
    run.assert_sound();
    assert_eq!(run.fragment_count(), 2);
    let freed = run.events.iter().filter(|e| matches!(e.kind, EventKind::FragmentFreed { .. })).count();
    assert_eq!((freed, run.log().fragment_count, run.log().refusal_count), (1, 1, 0));
    let advances = run.advances();
    assert!(advances.windows(2).all(|w| w[0].to == w[1].from), "one unbroken path");
    println!(
        "u {:.3}..{:.3} mm, end {}, {} advances, smallest angle {:.1}°, least margin {:.2}",
        advances[0].u,
        advances.last().unwrap().u,
        run.end(),
        advances.len(),
        run.log().smallest_angle.map_or(f64::NAN, f64::to_degrees),
        advances.iter().map(|a| a.margin).fold(1.0, f64::min),
    );
    run
}

/// The tear stays on the fibre line through the notch's end and leaves the square where that line does.
fn follows_the_fibre(square: &Square, start: f64, end: DVec2) -> Run {
    let run = torn_through(square, start);
    let off = |p: DVec2| off_line(p, TIP, square.fibre);
    let worst = run.advances().iter().map(|a| off(a.to)).fold(0.0, f64::max);
    println!(
        "{}°: off the line by {:.2e} edges, end off by {:.3}",
        square.fibre,
        worst / square.edge(),
        run.end().distance(end)
    );
    assert!(worst < square.edge());
    assert!(run.end().distance(end) < square.edge());
    assert!(run.advances().iter().all(|a| !a.is_ambiguous));
    run
}

#[test]
fn fibres_at_45_degrees_lead_the_tear_into_the_left_grip_whose_split_vertex_stays_gripped() {
    let run = follows_the_fibre(&Square::new(CELLS, 45.0), 1.3, DVec2::new(0.0, 12.0));
    let u = run.simulation.time() * GRIP_SPEED;
    let vertices = run.vertices();
    let world = run.simulation.world();
    let holds = world.get::<&Holds>(run.body.entity()).unwrap();
    let mut copies = 0;
    for (row, rest) in vertices.rest_position.iter().enumerate() {
        if rest.x == 0.0 {
            copies += usize::from(rest.truncate() == run.end());
            assert!(holds.groups[0].members.value(row as u32).is_some());
            // A prescribed position is reached by adding an increment: one rounding of 3 mm.
            assert!((vertices.position[row] - *rest).distance(glam::DVec3::X * -u) < 1e-14);
        }
    }
    assert_eq!(copies, 2);
}

#[test]
fn fibres_at_30_60_75_and_90_degrees_lead_the_tear() {
    let end = |degrees: f64| {
        let slope = degrees.to_radians().tan();
        let y = TIP.y - TIP.x * slope;
        if y > 0.0 { DVec2::new(0.0, y) } else { DVec2::new(TIP.x - TIP.y / slope, 0.0) }
    };
    for (degrees, start) in [(30.0, 1.0), (60.0, 0.7), (75.0, 0.5), (90.0, 0.5)] {
        let mut square = Square::new(CELLS, degrees);
        square.tearing.strength_across_fibres = if degrees == 30.0 { 1.6 } else { 0.8 };
        follows_the_fibre(&square, start, end(degrees));
    }
}

#[test]
fn an_isotropic_square_tears_straight_across() {
    let square = Square::isotropic(CELLS);
    let run = torn_through(&square, 0.75);
    let worst = run.advances().iter().map(|a| (a.to.x - 0.5 * SIDE).abs()).fold(0.0, f64::max);
    println!("isotropic: off by {worst:.2e}");
    assert!(worst < square.edge() && run.end().distance(DVec2::new(15.0, 0.0)) < square.edge());
}

/// Fibres along the pull leave two mirror directions equal: the first decision is a tie and marked as one.
#[test]
fn fibres_along_the_pull_are_marked_as_ambiguous() {
    // An even number of cells along x makes the mesh its own mirror image.
    let mut run = Square::new([40, 34], 0.0).spawn(Settings::default());
    run.stretch_to(0.7);
    run.run_until(60, |run| !run.advances().is_empty());
    let first = run.advances()[0];
    assert!(first.is_ambiguous && first.margin < 1e-9);
    run.assert_sound();
}

/// The load of the first tear in a static solve, from the criterion at two lower loads, and bracketed by attempts to tear.
fn static_load(square: &Square, expected: f64) -> f64 {
    let mut run = square.spawn(Settings::default());
    let [a, b] = [0.90, 0.95].map(|part| {
        run.stretch_to(part * expected);
        (run.simulation.frame().bodies[0].tips[0].value, part * expected)
    });
    let load = b.1 + (1.0 - b.0) * (b.1 - a.1) / (b.0 - a.0);
    // The criterion is nearly linear in the load: over the last 5 % its curvature is worth less than 0.1 %.
    for (part, tears) in [(0.998, false), (1.002, true)] {
        let dt = load * part / GRIP_SPEED - run.simulation.time();
        run.simulation.settle_and_tear(dt, 1e-8, 1).unwrap();
        assert_eq!(run.log().advance_count > 0, tears, "at {part} of {load} mm");
    }
    run.assert_sound();
    load
}

/// Loads on M(60, 50), M(120, 100) and M(240, 200) tend to these at first order, and those with the disc about the vertex do too,
/// from below. What is left here is the length of the notch: on the mesh it is a third of an edge shorter, which at 3 mm is
/// worth 3 %. An independent static prototype with the disc about the vertex found 0.66 and 0.88 mm.
#[test]
fn the_first_tear_comes_at_the_load_of_fine_meshes() {
    for (square, expected, start) in [(Square::new(CELLS, 90.0), 0.670, 0.6), (Square::isotropic(CELLS), 0.902, 0.8)] {
        let found = static_load(&square, expected);
        assert!((found / expected - 1.0).abs() < 0.05, "{found} instead of {expected}");
        let mut run = square.spawn(Settings::default());
        run.stretch_to(start);
        run.run_until(60, |run| run.log().advance_count > 0);
        let dynamic = run.advances()[0].u;
        println!("first tear at u = {found:.4} mm, in a dynamic run {dynamic:.2} mm");
        // Within the step of 0.03 mm in which it happens.
        assert!(dynamic >= found && dynamic < found + 1.5 * GRIP_SPEED * DT);
    }
}
