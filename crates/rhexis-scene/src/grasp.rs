//! From the legs of a hand's path to a polyline over time.

use super::error::{Fault, not_negative, positive};
use super::schema::{ArcSpec, GripSpec, NearTipSpec};
use glam::{DVec2, DVec3};
use rhexis::components::{Grip, Jaws, NearTip, Path, Slip};
use rhexis::math::elementary;

/// An arc is run in straight pieces of at most this angle \[°\]: at the capsule's 2.6 mm radius the chord stays within 0.1 µm.
const ARC_PIECE: f64 = 1.0;

/// One grip.
pub(super) fn grip(spec: &GripSpec, is_planar: bool, key: &str) -> Result<Grip, Fault> {
    if spec.until <= spec.from {
        let what = format!("the release at {} ms is not after the grasp at {} ms", spec.until, spec.from);
        return Err(Fault::new(format!("{key}.until"), what, "let `until` be later than `from`"));
    }
    let mut points = vec![(spec.from, spec.at.0)];
    for (i, leg) in spec.path.iter().enumerate() {
        let key = format!("{key}.path.{i}");
        let &(start, hand) = points.last().unwrap_or(&(spec.from, spec.at.0));
        if leg.end <= start {
            let what = format!("the leg ends at {} ms but begins at {start} ms", leg.end);
            return Err(Fault::new(format!("{key}.end"), what, "give ascending times, all after `from`"));
        }
        match (leg.to, leg.by, &leg.arc) {
            (Some(to), None, None) => points.push((leg.end, to.0)),
            (None, Some(by), None) => points.push((leg.end, hand + by.0)),
            (None, None, Some(arc)) => arc_points(arc, hand, start, leg.end, &format!("{key}.arc"), &mut points)?,
            _ => return Err(Fault::new(key, "a leg goes one way", "give exactly one of `to`, `by` and `arc`")),
        }
    }
    Ok(Grip {
        name: spec.name.clone(),
        from: spec.from,
        until: spec.until,
        material_point: spec.at.0,
        near_tip: spec.near_tip.as_ref().map(|near| near_tip(near, spec.at.0)),
        jaws: jaws(spec, key)?,
        path: Path { points },
        turns: turns(spec, is_planar, key)?,
    })
}

/// Rotation vectors of the hand \[rad\].
fn turns(spec: &GripSpec, is_planar: bool, key: &str) -> Result<Path, Fault> {
    let Some(rotate) = &spec.rotate else { return Ok(Path::default()) };
    if is_planar && rotate.0.points.iter().any(|(_, vector)| vector.truncate() != DVec2::ZERO) {
        let what = "the hand turns a planar body about z only";
        return Err(Fault::new(format!("{key}.rotate"), what, "give [0, 0, angle], or remove `planar`"));
    }
    let radians = |&(time, degrees): &(f64, DVec3)| (time, degrees.map(f64::to_radians));
    Ok(Path { points: rotate.0.points.iter().map(radians).collect() })
}

fn jaws(spec: &GripSpec, key: &str) -> Result<Jaws, Fault> {
    let or_none = |name: &str, value: Option<f64>, unit: &str| {
        value.map(|value| positive(format!("{key}.{name}"), value, unit)).transpose()
    };
    let jaws = Jaws {
        radius: not_negative(format!("{key}.radius"), spec.radius, "mm")?,
        stiffness: or_none("stiffness", spec.stiffness, "N/mm")?,
        force_limit: or_none("force_limit", spec.force_limit, "N")?,
        slip: if spec.slides { Slip::Slide } else { Slip::LetGo },
    };
    let refused = |(_, _, must)| Fault::new(format!("{key}.slides"), "nothing tells how far", must);
    jaws.check().map_err(refused)?;
    Ok(jaws)
}

fn near_tip(spec: &NearTipSpec, at: DVec3) -> NearTip {
    let axis = spec.axis.map_or(DVec3::Z, |axis| axis.0);
    let heading = spec.heading.map_or(axis.cross(at), |heading| heading.0);
    NearTip { behind: spec.behind, left: spec.left, axis, heading }
}

fn arc_points(
    arc: &ArcSpec,
    from: DVec3,
    start: f64,
    end: f64,
    key: &str,
    points: &mut Vec<(f64, DVec3)>,
) -> Result<(), Fault> {
    let axis = arc.axis.map_or(DVec3::Z, |axis| axis.0).try_normalize().ok_or_else(|| {
        Fault::new(format!("{key}.axis"), "the axis has no direction", "give a vector that is not zero")
    })?;
    if arc.degrees.abs() > 36_000.0 {
        let what = format!("{}° is more than a hundred turns", arc.degrees);
        return Err(Fault::new(format!("{key}.degrees"), what, "give the angle in degrees, at most 36000"));
    }
    let offset = from - arc.centre.0;
    let outward = offset.reject_from_normalized(axis).normalize_or_zero();
    let pieces = (arc.degrees.abs() / ARC_PIECE).ceil().max(1.0);
    for k in 1..=pieces as u32 {
        let s = f64::from(k) / pieces;
        let turn = elementary::rotation(axis, (arc.degrees * s).to_radians());
        let hand = arc.centre.0 + turn * (offset + outward * (arc.outward * s)) + axis * (arc.rise * s);
        points.push((start + (end - start) * s, hand));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Grip, Fault> {
        let head = "name = 'g'\nat = [2, 0]\nfrom = 10\nuntil = 50\nradius = 0.1\nstiffness = 1\n";
        grip(&toml::from_str(&format!("{head}{text}")).unwrap(), false, "grip")
    }

    #[test]
    fn legs_follow_each_other() {
        let path = "path = [{ by = [0, 0, 1], end = 20 }, { arc = { degrees = 90, rise = 0.5 }, end = 40 }]";
        let grip = parse(path).unwrap();
        let close = |time: f64, p: DVec3| assert!((grip.path.at(time) - p).length() < 1e-12, "{}", grip.path.at(time));
        close(10.0, DVec3::new(2.0, 0.0, 0.0));
        close(20.0, DVec3::new(2.0, 0.0, 1.0));
        let (s, c) = 45_f64.to_radians().sin_cos();
        close(30.0, DVec3::new(2.0 * c, 2.0 * s, 1.25));
        close(60.0, DVec3::new(0.0, 2.0, 1.5));
    }

    #[test]
    fn refuses_a_leg_without_time_or_with_two_ways() {
        assert_eq!(parse("path = [{ to = [0, 0], end = 5 }]").unwrap_err().key, "grip.path.0.end");
        assert_eq!(parse("path = [{ to = [0, 0], by = [1, 0], end = 20 }]").unwrap_err().key, "grip.path.0");
    }
}
