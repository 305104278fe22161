//! The pull that tears a sheet between two points: F·(λ + 1)/2·(cos α₁ + cos α₂) = G_c·h, with α between the tear backwards and the way
//! from its tip to either point (Ibarra, Roman, Melo 2016); the tear follows a hyperbola.
//!
//! The form has a sheet that folds freely until both ways are one straight line. Triangles without a crease along that line
//! do not, and hold the tear shut the more the nearer both pulls are to opposite. The path is judged where the bands meet at 135°
//! or more; the pull is reported.

use super::super::{Artifacts, Line, Row, Rows, VerifyError, largest};
use super::square::{Square, length};
use super::steady::median;
use glam::{DVec2, DVec3};
use rhexis::event::EventKind;
use rhexis::simulation::SimulationError;
use rhexis::storage::{Tips, Vertices};

/// The points that are pulled apart: a vertex each \[mm\].
const FOCI: [DVec2; 2] = [DVec2::new(-20.0, 0.0), DVec2::new(20.0, 0.0)];
/// What the holds reach around them \[mm\].
const REACH: f64 = 0.35;
/// End of the cut \[mm\].
const START: DVec2 = DVec2::new(12.2, 3.0);
const THICKNESS: f64 = 0.1;
/// Drag \[N·ms/mm³\], and the relative changes of it with which the path is judged as well.
const DRAG: f64 = 2e-6;
const CHANGES: [f64; 2] = [-2e-4, 2e-4];
/// Tolerance of directions \[°\].
const OFF: f64 = 3.0;
/// Toughness \[N/mm\]: the bands stretch by some percent, more than which they are wide, less than which the sheet does not come taut.
const TOUGHNESS: f64 = 0.06;
/// Directions are taken over so much of the path \[mm\], as in `tear-shape`.
const CHORD: f64 = 2.0;
/// Angle between the bands \[°\] down to which the path is judged, and to which it runs.
const WIDE: f64 = 135.0;
const NARROWEST: f64 = 95.0;
/// Steps while the sheet is taut and while it is slack \[ms\], by the criterion.
const STEPS: [f64; 2] = [2.0, 10.0];
const TAUT: f64 = 0.85;

/// Angle between the ways to both points \[°\].
fn bands(tip: DVec2) -> f64 {
    (FOCI[0] - tip).angle_to(FOCI[1] - tip).abs().to_degrees()
}

/// G·h by the form over G_c·h, for a tip there.
struct Pull {
    tip: DVec2,
    form: f64,
}

/// The scene with a drag \[N·ms/mm³\].
fn scene(drag: f64) -> Result<Square, VerifyError> {
    let changes = [
        format!(
            "bodies.0.tearing={{ toughness_along_fibres = {TOUGHNESS}, toughness_across_fibres = {TOUGHNESS}, radius = 1 }}"
        ),
        "bodies.0.refinement={ edges_per_radius = 3.3, budget = 6 }".to_owned(),
        // Of which the hands would feel more than a percent otherwise.
        "bodies.0.damping=0.5".to_owned(),
        format!("bodies.0.drag={drag:e}"),
        format!("bodies.0.holds.0.region.radius=[0, {REACH}]"),
        format!("bodies.0.holds.1.region.radius=[0, {REACH}]"),
    ];
    Square::scene("two-points", &changes)
}

/// Angles between chords of a path and the hyperbola \[°\] where the bands meet at such an angle.
fn off(path: &[DVec2], among: std::ops::Range<f64>) -> Vec<f64> {
    turns(path).into_iter().filter(|(middle, _)| among.contains(&bands(*middle))).map(|(_, off)| off).collect()
}

pub(crate) fn run(out: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("tear-two-points");
    let mut square = scene(DRAG)?;
    let narrowest = if out.is_quick() { WIDE } else { NARROWEST };
    let (path, pulls) = tear(&mut square, narrowest)?;
    if path.len() < 2 {
        rows.ratio("nothing torn", f64::NAN, 0.0);
        return rows.finish();
    }
    rows.note("torn", length(&path), "mm");
    for (name, from, to) in [("135° or more", WIDE, 180.0), ("95° to 135°", NARROWEST, WIDE)] {
        let among = |tip: DVec2| (from..to).contains(&bands(tip));
        let off = off(&path, from..to);
        let judged = if from == WIDE { OFF } else { f64::INFINITY };
        if !off.is_empty() {
            rows.add(format!("bands at {name}: off the hyperbola, median"), median(off), judged, "°");
        }
        let forms: Vec<f64> = pulls.iter().filter(|pull| among(pull.tip)).map(|pull| pull.form).collect();
        if !forms.is_empty() {
            rows.note(format!("bands at {name}: pull before an advance over the form's, median"), median(forms), "1");
        }
    }
    // A sheet that snaps from slack to taut may take another path by a change of rounding's size: none is to be far off.
    for change in if out.is_quick() { &[][..] } else { &CHANGES } {
        let (path, _) = tear(&mut scene(DRAG * (1.0 + change))?, WIDE)?;
        let off = median(off(&path, WIDE..180.0));
        rows.add(format!("drag times 1 + {change:e}: off the hyperbola, median"), off, OFF, "°");
    }
    let sum = |p: DVec2| p.distance(FOCI[0]) - p.distance(FOCI[1]);
    rows.note(
        "change of r_A − r_B, constant on a hyperbola",
        largest(path.iter().map(|&p| (sum(p) - sum(START)).abs())),
        "mm",
    );
    out.paths(
        "tear-two-points",
        "a sheet torn between two points, by energy",
        &[Line { name: "path".into(), points: path }],
    )?;
    rows.finish()
}

/// Middles of chords, and the angles between them and the gradient of the sum of the distances \[°\].
fn turns(path: &[DVec2]) -> Vec<(DVec2, f64)> {
    let chord = |(i, from): (usize, &DVec2)| {
        let to = path[i..].iter().find(|to| to.distance(*from) >= CHORD)?;
        let middle = from.midpoint(*to);
        let gradient = FOCI.iter().map(|focus| (middle - focus).normalize()).sum::<DVec2>();
        Some((middle, gradient.angle_to(to - from).abs().to_degrees()))
    };
    path.iter().enumerate().map_while(chord).collect()
}

fn tear(square: &mut Square, narrowest: f64) -> Result<(Vec<DVec2>, Vec<Pull>), VerifyError> {
    let body = square.body();
    let simulation = &mut square.instance.simulation;
    let (mut path, mut pulls) = (vec![START], Vec::new());
    let (mut tip, mut form) = (START, 0.0);
    // The scene's hands move for so long.
    while bands(tip) > narrowest && simulation.time() < 6000.0 {
        let criterion =
            simulation.world().get::<&Tips>(body.entity()).map_or(0.0, |tips| largest(tips.criterion.iter().copied()));
        simulation.step(STEPS[usize::from(criterion < TAUT)])?;
        let before = path.len();
        path.extend(simulation.drain_events().filter_map(|event| match event.kind {
            EventKind::Advanced { to, .. } => Some(to.truncate()),
            _ => None,
        }));
        if path.len() > before {
            pulls.push(Pull { tip, form });
        }
        let forces: Vec<DVec3> = simulation.reactions(body)?.iter().map(|(_, force)| *force).collect();
        let mut query = simulation.world().query_one::<(&Vertices, &Tips)>(body.entity());
        let (vertices, tips) = query.get().map_err(|_| SimulationError::NoSuchBody)?;
        let (Some(&row), Some(&ahead)) = (tips.vertex.first(), tips.previous.first()) else { break };
        let places = |v: usize| (vertices.rest_position[v], vertices.position[v]);
        let (rest, now) = places(row as usize);
        tip = rest.truncate();
        let released = FOCI.iter().zip(&forces).map(|(focus, force)| {
            let held = (0..vertices.len()).find(|&v| vertices.rest_position[v].truncate().distance(*focus) <= REACH);
            let (held, hand) = held.map_or((DVec3::NAN, DVec3::NAN), places);
            let stretch = hand.distance(now) / held.distance(rest);
            force.length() * 0.5 * (stretch + 1.0) * (rest - held).normalize().dot(ahead)
        });
        form = released.sum::<f64>() / (TOUGHNESS * THICKNESS);
    }
    Ok((path, pulls))
}
