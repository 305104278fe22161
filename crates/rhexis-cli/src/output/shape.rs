//! Whether the arrays of a body belong together.

use super::OutputError;
use rhexis::components::Attributes;
use rhexis::frame::BodyFrame;
use std::path::Path;

/// Refuses a body whose arrays do not belong together, so that the writers may index freely.
pub(super) fn check_shape(path: &Path, body: &BodyFrame) -> Result<(), OutputError> {
    let (vertex_count, triangle_count) = (body.positions.len(), body.triangles.len());
    let lengths = [
        ("rest_positions", body.rest_positions.len(), vertex_count, false),
        ("stress", body.stress.len(), triangle_count, false),
        ("principal_stress", body.principal_stress.len(), triangle_count, false),
        ("fibres", body.fibres.len(), triangle_count, false),
        ("velocities", body.velocities.len(), vertex_count, true),
        ("forces", body.forces.len(), vertex_count, true),
        ("criterion", body.criterion.len(), triangle_count, true),
        ("attributes", body.attributes.as_ref().map_or(vertex_count, Attributes::len), vertex_count, false),
    ];
    for (name, found, wanted, is_optional) in lengths {
        if found != wanted && !(is_optional && found == 0) {
            return Err(OutputError::content(
                path,
                format!(
                    "body '{}' has {found} entries in `{name}` where {wanted} belong; fill the frame anew",
                    body.name
                ),
            ));
        }
    }
    match body.triangles.iter().position(|corners| corners.iter().any(|&v| v as usize >= vertex_count)) {
        None => Ok(()),
        Some(t) => Err(OutputError::content(
            path,
            format!(
                "triangle {t} of body '{}' has corners {:?} but there are {vertex_count} vertices; fill the frame anew",
                body.name, body.triangles[t]
            ),
        )),
    }
}
