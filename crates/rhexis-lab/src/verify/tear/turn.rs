//! Turn of the path of a gliding tip: forceps tear an isotropic capsule along a smooth curve.

use super::super::{Artifacts, Line, Row, Rows, VerifyError};
use super::square::Square;
use glam::DVec3;
use rhexis::event::EventKind;
use rhexis::storage::TipKey;

/// Length of path from one direction to the next \[mm\].
const CHORD: f64 = 0.05;
/// Root mean square of the turns \[°\]: the hand's own circle of 2.6 mm turns by 1.1°.
const TURN: f64 = 2.0;
/// Time of two grasps, and of the beginning of the first \[ms\].
const TIMES: [f64; 2] = [9400.0, 2000.0];

pub(crate) fn run(out: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("tear-turn");
    let duration = TIMES[usize::from(out.is_quick())];
    let changes = [
        "bodies.0.mesh.cap.triangles=1500".to_owned(),
        "bodies.0.refinement.budget=3".to_owned(),
        // One toughness for all directions.
        "bodies.0.tearing.toughness_across_fibres=0.7".to_owned(),
        "bodies.0.tearing.mode=\"glide\"".to_owned(),
        format!("run.duration={duration}"),
    ];
    let mut capsule = Square::scene("capsulorhexis", &changes)?;
    let mut paths: Vec<(TipKey, Vec<DVec3>)> = Vec::new();
    while !capsule.instance.is_finished() {
        capsule.instance.advance()?;
        for event in capsule.instance.simulation.drain_events() {
            let EventKind::Advanced { tip, from, to, .. } = event.kind else { continue };
            match paths.iter_mut().find(|(key, _)| *key == tip) {
                Some((_, path)) => path.push(to),
                None => paths.push((tip, vec![from, to])),
            }
        }
    }
    let path = paths.into_iter().map(|(_, path)| path).max_by_key(Vec::len).unwrap_or_default();
    let places = spaced(&path);
    let turns = turns(&places);
    let rms = (turns.iter().map(|turn| turn * turn).sum::<f64>() / turns.len() as f64).sqrt();
    rows.note("length of the path", CHORD * places.len() as f64, "mm");
    rows.add(format!("turn of the path per {CHORD} mm, root mean square"), rms, TURN, "°");
    rows.note(format!("turn of the path per {CHORD} mm, largest"), super::super::largest(turns), "°");
    let points = places.iter().map(|place| place.truncate()).collect();
    out.paths("tear-turn", "path of a gliding tip in an isotropic capsule", &[Line { name: "path".into(), points }])?;
    rows.finish()
}

/// Points of a path at one distance along it.
fn spaced(path: &[DVec3]) -> Vec<DVec3> {
    let mut places: Vec<DVec3> = path.first().copied().into_iter().collect();
    // From the last place to the beginning of the piece.
    let mut passed = 0.0;
    for piece in path.windows(2) {
        let length = piece[0].distance(piece[1]);
        let mut next = CHORD - passed;
        while next <= length {
            places.push(piece[0].lerp(piece[1], next / length));
            next += CHORD;
        }
        passed = length - (next - CHORD);
    }
    places
}

/// Angles between the directions from place to place \[°\].
fn turns(places: &[DVec3]) -> Vec<f64> {
    places.windows(3).map(|three| (three[1] - three[0]).angle_between(three[2] - three[1]).to_degrees()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_circle_turns_by_its_curvature_however_it_is_cut() {
        let circle = |count: u32| -> Vec<DVec3> {
            let at = |i| f64::from(i) / f64::from(count);
            (0..=count).map(|i| 2.6 * DVec3::new(at(i).cos(), at(i).sin(), 0.0)).collect()
        };
        for count in [7, 1000] {
            let places = spaced(&circle(count));
            let sum: f64 = turns(&places).iter().sum();
            // 1 rad along 2.6 mm, but for the ends.
            assert!((places.len() as f64 * CHORD - 2.6).abs() < 0.06 && (sum - 57.3).abs() < 9.0, "{count}: {sum}");
        }
    }
}
