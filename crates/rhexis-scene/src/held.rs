//! Holds and clamps of a body: what they hold, how they turn, what they leave free.

use super::build::direction;
use super::error::Fault;
use super::region::Surface;
use super::schema::{BodySpec, ClampSpec, HoldSpec};
use glam::DVec3;
use rhexis::components::{Curve, Guide, Hold, HoldGuides, HoldTurns, Path, Turning};
use rhexis::membrane::Membrane;
use rhexis::storage::{Attached, TriangleMesh};

/// Gives a membrane its holds and clamps; `key` is the body's path in the scene.
pub(super) fn holds(
    mut membrane: Membrane,
    spec: &BodySpec,
    mesh: &TriangleMesh,
    surface: &Surface,
    key: &str,
) -> Result<Membrane, Fault> {
    let (mut turns, mut guides) = (Vec::new(), Vec::new());
    for (i, hold) in spec.holds.iter().enumerate() {
        let key = format!("{key}.holds.{i}");
        turns.extend(turn(hold, i, spec.planar, &key)?);
        guides.extend(guide(hold, spec.planar, &key)?.map(|guide| (i as u32, guide)));
        let rows = surface.vertices(&hold.region, &format!("{key}.region"))?;
        let m = &hold.movement;
        let offset = |p: DVec3| m.offset.0 + m.per_x.0 * p.x + m.per_y.0 * p.y + m.per_z.0 * p.z;
        membrane = membrane.hold(Hold {
            name: hold.name.clone(),
            members: Attached::new(rows.into_iter().map(|row| (row, offset(mesh.positions[row as usize])))),
            axes: axes(&hold.axes, &format!("{key}.axes"))?,
            curve: hold.curve.0.clone(),
        });
    }
    for (i, spec_of) in spec.clamps.iter().enumerate() {
        let key = format!("{key}.clamps.{i}");
        let rows = surface.vertices(&spec_of.region, &format!("{key}.region"))?;
        let (hold, guide) = clamp(spec_of, i, rows, &key)?;
        guides.push(((spec.holds.len() + i) as u32, guide));
        membrane = membrane.hold(hold);
    }
    if !turns.is_empty() {
        membrane = membrane.with(HoldTurns { list: turns });
    }
    Ok(if guides.is_empty() { membrane } else { membrane.with(HoldGuides { list: guides }) })
}

/// How a hold turns, with its place.
fn turn(hold: &HoldSpec, place: usize, is_planar: bool, key: &str) -> Result<Option<(u32, Turning)>, Fault> {
    let Some(rotate) = &hold.rotate else {
        let what = "a pivot is given, and no turn about it";
        let fault = || Fault::new(format!("{key}.pivot"), what, "add `rotate`, or remove it");
        return if hold.pivot.is_some() { Err(fault()) } else { Ok(None) };
    };
    let points: Vec<(f64, DVec3)> =
        rotate.0.points.iter().map(|&(t, degrees)| (t, degrees.map(f64::to_radians))).collect();
    if is_planar && points.iter().any(|(_, vector)| vector.truncate() != glam::DVec2::ZERO) {
        let what = "a planar body turns about z only";
        return Err(Fault::new(format!("{key}.rotate"), what, "give [0, 0, angle], or remove `planar`"));
    }
    let pivot = hold.pivot.map_or(DVec3::ZERO, |pivot| pivot.0);
    Ok(Some((place as u32, Turning { pivot, vectors: Path { points } })))
}

/// The motion that a hold leaves its vertices beside its axes.
fn guide(hold: &HoldSpec, is_planar: bool, key: &str) -> Result<Option<Guide>, Fault> {
    let (name, vector, guide): (_, _, fn(DVec3) -> Guide) = match (&hold.normal, &hold.line) {
        (None, None) => return Ok(None),
        (Some(normal), None) => ("normal", normal.0, Guide::Across),
        (None, Some(line)) => ("line", line.0, Guide::Along),
        (Some(_), Some(_)) => {
            let what = "it is held across a direction and along one";
            return Err(Fault::new(format!("{key}.line"), what, "give either `normal` or `line`"));
        }
    };
    let key = |name: &str| format!("{key}.{name}");
    if hold.axes != "xyz" {
        let what = format!("`axes` and `{name}` both say what is held");
        return Err(Fault::new(key("axes"), what, "keep one of the two"));
    }
    let unit = direction(vector, &key(name))?;
    if is_planar && unit.z != 0.0 {
        let what = "it leads out of the plane, in which `planar` keeps the body";
        return Err(Fault::new(key(name), what, "give a direction in x and y, or remove `planar`"));
    }
    Ok(Some(guide(unit)))
}

/// The hold of a clamp, and the force that draws it.
fn clamp(clamp: &ClampSpec, place: usize, rows: Vec<u32>, key: &str) -> Result<(Hold, Guide), Fault> {
    let axes = axes(&clamp.axes, &format!("{key}.axes"))?;
    let force = clamp.force.0;
    if let Some(axis) = (0..3).find(|&axis| force[axis] != 0.0 && !axes[axis]) {
        let what = format!("it draws along {}, which the clamp leaves free", ['x', 'y', 'z'][axis]);
        return Err(Fault::new(format!("{key}.force"), what, "clamp that axis, or load the region by `point_loads`"));
    }
    let name = clamp.name.clone().unwrap_or_else(|| format!("clamp {place}"));
    let members = Attached::new(rows.into_iter().map(|row| (row, DVec3::ZERO)));
    let hold = Hold { name, members, axes, curve: Curve::constant(1.0) };
    Ok((hold, Guide::Together { force, curve: clamp.curve.0.clone() }))
}

fn axes(text: &str, key: &str) -> Result<[bool; 3], Fault> {
    if text.is_empty() || text.chars().any(|c| !"xyz".contains(c)) {
        return Err(Fault::new(key, format!("`{text}` names no axes"), "write some of the letters xyz, as in \"xy\""));
    }
    Ok(['x', 'y', 'z'].map(|axis| text.contains(axis)))
}
