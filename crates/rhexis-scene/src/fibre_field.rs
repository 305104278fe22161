//! From `fibres` to a direction per triangle; those about an axis at an angle in the surface.

use super::build::{Sheet, direction};
use super::error::Fault;
use super::schema::{AxisSpec, FibreSpec};
use glam::DVec3;
use rhexis::components::Fibres;
use rhexis::math::elementary;
use rhexis::storage::TriangleMesh;

/// The fibres that a body asks for.
pub(super) fn fibres(spec: &FibreSpec, sheet: &Sheet, key: &str) -> Result<Fibres, Fault> {
    let mesh = &sheet.file.mesh;
    Ok(match spec {
        FibreSpec::Degrees(degrees) => Fibres::at_degrees(*degrees),
        FibreSpec::Direction(d) => Fibres::Uniform(direction(d.0, &format!("{key}.direction"))?),
        FibreSpec::Concentric(axis) => about_axis(Field::Concentric, axis, mesh, &format!("{key}.concentric"))?,
        FibreSpec::Radial(axis) => about_axis(Field::Radial, axis, mesh, &format!("{key}.radial"))?,
        FibreSpec::Helix(axis) => about_axis(Field::Helix, axis, mesh, &format!("{key}.helix"))?,
        FibreSpec::Array(_) => Fibres::PerTriangle(mesh.fibres.clone().unwrap_or_default()),
        FibreSpec::File(_) => Fibres::PerTriangle(sheet.fibres.clone().unwrap_or_default()),
    })
}

/// Which direction the angle counts from, and which it counts towards.
#[derive(Clone, Copy, PartialEq)]
enum Field {
    /// From the circles about the axis, towards outside.
    Concentric,
    /// From the way out, towards the circles.
    Radial,
    /// From the circles, along the axis.
    Helix,
}

/// The direction in each triangle. Both directions are laid into the triangle's plane first: the angle is one in the surface.
fn about_axis(field: Field, spec: &AxisSpec, mesh: &TriangleMesh, key: &str) -> Result<Fibres, Fault> {
    let centre = spec.centre.0;
    let axis = direction(spec.axis.0, &format!("{key}.axis"))?;
    if !spec.degrees.is_finite() {
        return Err(Fault::new(
            format!("{key}.degrees"),
            format!("{} is no angle", spec.degrees),
            "give a finite number",
        ));
    }
    // Circles are the field that there has always been.
    if spec.degrees == 0.0 && field != Field::Radial {
        return Ok(Fibres::Concentric { centre, axis });
    }
    let (sin, cos) = elementary::sin_cos(spec.degrees.to_radians());
    let of_triangle = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|corner| mesh.positions[corner as usize]);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let out = ((a + b + c) / 3.0 - centre).reject_from_normalized(axis);
        let [from, to] = match field {
            Field::Concentric => [axis.cross(out), out],
            Field::Radial => [out, axis.cross(out)],
            Field::Helix => [axis.cross(out), axis],
        };
        let flat = |v: DVec3| v.reject_from_normalized(normal).normalize_or_zero();
        let fibre = if normal == DVec3::ZERO { from } else { flat(from) * cos + flat(to) * sin };
        // On the axis there is no direction, and the triangle's first side will do.
        if fibre == DVec3::ZERO { b - a } else { fibre }
    };
    Ok(Fibres::PerTriangle(mesh.triangles.iter().map(of_triangle).collect()))
}
