//! What a body is given before the first step: its initial state, and its cuts.

use super::error::Fault;
use super::schema::{CutSpec, InitialSpec};
use glam::{DMat3, DVec3};
use rhexis::components::Holds;
use rhexis::simulation::{Cut, CutError, Simulation, TearRefusal};
use rhexis::storage::{BodyId, Vertices};

/// The points of a cut's line.
pub(super) fn polyline(spec: &CutSpec, key: &str) -> Result<Vec<DVec3>, Fault> {
    let polyline: Vec<DVec3> = spec.polyline.iter().map(|point| point.0).collect();
    if polyline.len() < 2 || polyline.windows(2).any(|pair| pair[0] == pair[1]) {
        let hint = "give two or more points [x, y, z], no two in a row the same";
        return Err(Fault::new(format!("{key}.polyline"), "this is no line", hint));
    }
    Ok(polyline)
}

/// A notch or slit made before the first step.
pub(super) fn cut(simulation: &mut Simulation, body: BodyId, spec: &CutSpec, key: &str) -> Result<Cut, Fault> {
    let polyline = polyline(spec, key)?;
    let hint = "move its points onto the body or begin outside it; stay an edge away from the boundary and other cuts, or cut farther";
    let refused = |what: String| Fault::new(format!("{key}.polyline"), what, hint);
    let cut = simulation.cut(body, &polyline).map_err(|error| match (&error, held(simulation, body)) {
        (CutError::Refused(TearRefusal::NoRoom { .. }), Some((held, count))) => {
            let what = format!("the cut was refused: holds keep {held} of {count} vertices where they are");
            Fault::new(format!("{key}.polyline"), what, "narrow the regions of the holds")
        }
        _ => refused(error.to_string()),
    })?;
    // A line is taken at the nearest points of the surface; what is far from it was meant for another body.
    let length: f64 = polyline.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
    if cut.off_line > 0.5 * length {
        return Err(refused(format!("the line runs up to {} mm off the body", (cut.off_line * 1e3).round() / 1e3)));
    }
    Ok(cut)
}

/// Number of vertices that holds keep in their plane, and of all, where these are most.
fn held(simulation: &Simulation, body: BodyId) -> Option<(usize, usize)> {
    let mut query = simulation.world().query_one::<(&Vertices, &Holds)>(body.entity());
    let (vertices, holds) = query.get().ok()?;
    let mut is_held = vec![false; vertices.len()];
    for hold in holds.groups.iter().filter(|hold| hold.axes[0] && hold.axes[1]) {
        hold.members.rows().iter().for_each(|&row| is_held[row as usize] = true);
    }
    let held = is_held.iter().filter(|is_held| **is_held).count();
    (2 * held > vertices.len()).then_some((held, vertices.len()))
}

/// Sets the positions and velocities of `initial`.
pub(super) fn start(
    simulation: &mut Simulation,
    body: BodyId,
    spec: &InitialSpec,
    is_planar: bool,
    key: &str,
) -> Result<(), Fault> {
    let map =
        spec.stretch.map_or(DMat3::IDENTITY, |rows| DMat3::from_cols_array_2d(&rows.0.map(|row| row.0)).transpose());
    if map.determinant() <= 0.0 {
        let hint = "give a map that keeps volume and handedness: its determinant must be above zero";
        return Err(Fault::new(format!("{key}.stretch"), "the map flattens or mirrors the body", hint));
    }
    let (velocity, spin) = (spec.velocity.0, spec.spin.0);
    if is_planar && (velocity.z != 0.0 || spin.x != 0.0 || spin.y != 0.0 || map.col(2).truncate().length() != 0.0) {
        let hint = "give a velocity in x and y, a spin about z, and a stretch that keeps z apart";
        return Err(Fault::new(key, "a planar body would leave its plane", hint));
    }
    let Ok(mut vertices) = simulation.world().get::<&mut Vertices>(body.entity()) else { return Ok(()) };
    let vertices = &mut *vertices;
    vertices.position.iter_mut().for_each(|x| *x = map * *x);
    let mass: f64 = vertices.mass.iter().sum();
    let weighted = vertices.position.iter().zip(&vertices.mass).map(|(x, m)| *x * *m);
    let centre = weighted.sum::<DVec3>() / mass;
    for (v, x) in vertices.velocity.iter_mut().zip(&vertices.position) {
        *v = velocity + spin.cross(*x - centre);
    }
    if !vertices.position.iter().chain(&vertices.velocity).all(|a| a.length_squared().is_finite()) {
        return Err(Fault::new(
            key,
            "positions or velocities come out too large for a number",
            "give ordinary numbers",
        ));
    }
    Ok(())
}
