//! From `[[obstacles]]` to rigid bodies that stand, are displaced and turn.

use super::build::{direction, own_names};
use super::doctor::{IN_METRES, MeshSummary, is_in_metres, length};
use super::error::{Fault, positive};
use super::files::Files;
use super::instance::Run;
use super::mesh_on_file::Arrays;
use super::schema::{MeshSpec, ObstacleSpec, Point};
use glam::{DMat3, DVec3};
use rhexis::components::{Contact, Hull, Path, Rigid, Shape, Turning};
use rhexis::simulation::{Simulation, Solid};
use rhexis::storage::BodyId;
use std::sync::Arc;

/// Powers of the second moments in the search of an axis.
const POWERS: usize = 30;

/// Puts the obstacles into the world; their names, and widths \[mm\] of those of a mesh.
pub(super) fn spawn(
    simulation: &mut Simulation,
    specs: &[ObstacleSpec],
    run: Run,
    files: &Files,
) -> Result<(Vec<String>, Vec<Option<f64>>), Fault> {
    let name = |(i, spec): (usize, &ObstacleSpec)| spec.name.clone().unwrap_or_else(|| format!("obstacle-{i}"));
    let names: Vec<String> = specs.iter().enumerate().map(name).collect();
    own_names(names.iter().enumerate().map(|(i, name)| (format!("obstacles.{i}"), name.clone())))?;
    let mut widths = Vec::new();
    for (i, spec) in specs.iter().enumerate() {
        let key = format!("obstacles.{i}");
        let (shape, width) = shape(spec, files, &key)?;
        widths.push(width);
        let rigid = rigid(spec, &shape, &key)?;
        let turning = if rigid.is_some() { None } else { turning(spec, &shape, run, &key)? };
        let mut solid = Solid::new(shape);
        if let Some(rigid) = rigid {
            solid = solid.rigid(rigid);
        }
        if let Some(path) = &spec.path {
            solid = solid.path(path.0.clone());
        }
        if let Some(turning) = turning {
            solid = solid.turning(turning);
        }
        simulation.spawn_obstacle(solid).map_err(|error| Fault::new(key, error, "give numbers of an ordinary size"))?;
    }
    Ok((names, widths))
}

/// Notes on obstacles of a mesh that is narrower than the edges of a body that feels them.
pub(super) fn narrow<'a>(
    simulation: &Simulation,
    (names, widths): (&[String], &[Option<f64>]),
    bodies: impl Iterator<Item = (BodyId, &'a MeshSummary)>,
) -> Vec<String> {
    let feels = |body: BodyId| simulation.world().satisfies::<&Contact>(body.entity());
    let edge = bodies.filter(|(body, _)| feels(*body)).map(|(_, mesh)| mesh.edges[1]).fold(0.0, f64::max);
    let widths = names.iter().zip(widths).filter_map(|(name, width)| Some((name, (*width)?)));
    let note = |(name, width): (&String, f64)| {
        format!(
            "{name}: a mesh {} mm wide, narrower than the tissue's edges ({} mm in the mean), may pass between vertices, which alone feel it; \
             refine the tissue, or build the obstacle from `capsule`",
            length(width),
            length(edge)
        )
    };
    widths.filter(|(_, width)| *width < edge).map(note).collect()
}

/// Notes on obstacles of a mesh whose unit is that of its format.
pub(super) fn in_metres<'a>(specs: &'a [ObstacleSpec], names: &'a [String]) -> impl Iterator<Item = String> + 'a {
    let taken = specs.iter().zip(names).filter(|(spec, _)| spec.mesh.as_ref().is_some_and(is_in_metres));
    taken.map(|(_, name)| format!("{name}: {IN_METRES}"))
}

/// Width \[mm\] of a solid: the diameter of its vertices as they are seen along its longest principal axis.
fn width(positions: &[DVec3]) -> f64 {
    let centroid = positions.iter().sum::<DVec3>() / positions.len().max(1) as f64;
    let farthest = |points: &[DVec3], from: DVec3| {
        let by_distance = |a: &&DVec3, b: &&DVec3| a.distance_squared(from).total_cmp(&b.distance_squared(from));
        points.iter().max_by(by_distance).copied().unwrap_or(from)
    };
    // Powers of the second moments turn any direction to that axis.
    let turned = |axis: DVec3| positions.iter().map(|p| (p - centroid) * (p - centroid).dot(axis)).sum::<DVec3>();
    let start = (farthest(positions, centroid) - centroid).normalize_or_zero();
    let axis = (0..POWERS).fold(start, |axis, _| turned(axis).normalize_or(axis));
    let seen: Vec<DVec3> = positions.iter().map(|p| (p - centroid).reject_from(axis)).collect();
    let one = farthest(&seen, DVec3::ZERO);
    farthest(&seen, one).distance(one)
}

/// Mass and motion of an obstacle that tissue pushes.
fn rigid(spec: &ObstacleSpec, shape: &Shape, key: &str) -> Result<Option<Rigid>, Fault> {
    let Some(mass) = spec.mass else {
        let motion = [("velocity", spec.velocity.is_some()), ("gravity", spec.gravity.is_some())];
        return match motion.into_iter().find(|(_, is_given)| *is_given) {
            Some((name, _)) => {
                let hint = "add `mass` [g] to make it a rigid body, or move it by `path`";
                Err(Fault::new(format!("{key}.{name}"), "an obstacle without a mass yields to nothing", hint))
            }
            None => Ok(None),
        };
    };
    let mass = positive(format!("{key}.mass"), mass, "g")?;
    if spec.path.is_some() || spec.rotate.is_some() || spec.pivot.is_some() {
        let hint = "remove `mass`, or `path`, `rotate` and `pivot`; `velocity` and `spin` are its motion at time zero";
        return Err(Fault::new(key, "a rigid body follows no path", hint));
    }
    let hint = "give a `box`, or remove `mass`";
    let solid = Rigid::of(shape, mass).ok_or_else(|| Fault::new(key, "a half space has no mass", hint))?;
    let of = |point: Option<Point>| point.map_or(DVec3::ZERO, |point| point.0);
    let spin = of(spec.spin).map(f64::to_radians);
    Ok(Some(Rigid { velocity: of(spec.velocity), spin, acceleration: of(spec.gravity), ..solid }))
}

/// How an obstacle turns, in radians.
fn turning(spec: &ObstacleSpec, shape: &Shape, run: Run, key: &str) -> Result<Option<Turning>, Fault> {
    let pivot = spec.pivot.map_or(shape.anchor(), |pivot| pivot.0);
    let radians = |degrees: DVec3| degrees.map(f64::to_radians);
    let points = match (&spec.rotate, spec.spin) {
        (None, None) if spec.pivot.is_some() => {
            let what = "a pivot is given, and no turn about it";
            return Err(Fault::new(format!("{key}.pivot"), what, "add `rotate` or `spin`, or remove it"));
        }
        (None, None) => return Ok(None),
        (Some(rotate), None) => rotate.0.points.iter().map(|&(time, degrees)| (time, radians(degrees))).collect(),
        (None, Some(spin)) => {
            let end = run.dt * run.steps.max(1) as f64;
            vec![(0.0, DVec3::ZERO), (end, radians(spin.0) * end)]
        }
        (Some(_), Some(_)) => {
            return Err(Fault::new(key, "the turn is given twice", "give either `rotate` [°] or `spin` [°/ms]"));
        }
    };
    Ok(Some(Turning { pivot, vectors: Path { points } }))
}

/// The solid within a closed mesh, and its width \[mm\].
fn hull(spec: &MeshSpec, files: &Files, key: &str) -> Result<(Shape, f64), Fault> {
    let key = format!("{key}.mesh");
    let file = super::shape::mesh(spec, &Arrays::default(), files, &key)?;
    let width = width(&file.mesh.positions);
    let (hull, centre) = Hull::new(file.mesh.positions, file.mesh.triangles).map_err(|error| {
        let hint = "close the mesh and let it face outwards (`weld`, `repair`, `flip`), or build the obstacle from \
                    `box`, `cylinder`, `sphere`, `ellipsoid` and `capsule`";
        Fault::new(key, error, hint)
    })?;
    Ok((Shape::Mesh { hull: Arc::new(hull), centre, axes: DMat3::IDENTITY }, width))
}

/// The shape of an obstacle, and the width \[mm\] of one of a mesh.
fn shape(spec: &ObstacleSpec, files: &Files, key: &str) -> Result<(Shape, Option<f64>), Fault> {
    let ObstacleSpec { plane, sphere, ellipsoid, capsule, cuboid, cylinder, mesh, .. } = spec;
    let axes = DMat3::IDENTITY;
    let shape = match (plane, sphere, ellipsoid, capsule, cuboid, cylinder, mesh) {
        (Some(p), None, None, None, None, None, None) => {
            Ok(Shape::Plane { point: p.point.0, normal: direction(p.normal.0, &format!("{key}.plane.normal"))? })
        }
        (None, Some(s), None, None, None, None, None) => {
            let radius = positive(format!("{key}.sphere.radius"), s.radius, "mm")?;
            Ok(Shape::Sphere { centre: s.centre.0, radius })
        }
        (None, None, Some(e), None, None, None, None) => {
            positive(format!("{key}.ellipsoid.half_axes"), e.half_axes.0.min_element(), "mm")?;
            Ok(Shape::Ellipsoid { centre: e.centre.0, half_axes: e.half_axes.0, axes })
        }
        (None, None, None, Some(c), None, None, None) => {
            let radius = positive(format!("{key}.capsule.radius"), c.radius, "mm")?;
            Ok(Shape::Capsule { ends: [c.from.0, c.to.0], radius })
        }
        (None, None, None, None, Some(b), None, None) => {
            positive(format!("{key}.box.half"), b.half.0.min_element(), "mm")?;
            Ok(Shape::Box { centre: b.centre.0, half: b.half.0, axes })
        }
        (None, None, None, None, None, Some(c), None) => {
            let radius = positive(format!("{key}.cylinder.radius"), c.radius, "mm")?;
            direction(c.to.0 - c.from.0, &format!("{key}.cylinder.to"))?;
            Ok(Shape::Cylinder { ends: [c.from.0, c.to.0], radius })
        }
        (None, None, None, None, None, None, Some(mesh)) => {
            return hull(mesh, files, key).map(|(shape, width)| (shape, Some(width)));
        }
        _ => {
            let hint = "give exactly one of `plane`, `sphere`, `ellipsoid`, `capsule`, `box`, `cylinder` and `mesh`";
            Err(Fault::new(key, "an obstacle has one shape", hint))
        }
    };
    shape.map(|shape| (shape, None))
}
