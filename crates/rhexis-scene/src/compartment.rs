//! The compartment of a body.

use super::error::{Fault, not_negative, positive};
use super::schema::{BodySpec, CompartmentSpec};
use rhexis::components::{Compartment, Content};
use rhexis::membrane::Membrane;
use rhexis::storage::{NONE, Topology};

/// Gives a body its compartment.
pub(super) fn compartment(
    membrane: Membrane,
    (spec, body): (&CompartmentSpec, &BodySpec),
    key: &str,
) -> Result<Membrane, Fault> {
    let at = |name: &str| format!("{key}.{name}");
    if body.planar {
        let what = "a body that `planar` keeps in its plane bounds no volume";
        return Err(Fault::new(key, what, "remove one of the two"));
    }
    if body.pressure.is_some() {
        let what = "the body has a `pressure` beside, and which side it is on would be unclear";
        return Err(Fault::new(key, what, "give a pressure in front of the triangles as `outside` of the compartment"));
    }
    let content = match (&spec.liquid, &spec.gas) {
        (Some(liquid), None) => Content {
            stiffness: positive(at("liquid.bulk_modulus"), liquid.bulk_modulus, "MPa")?,
            exponent: 1.0,
            density: positive(at("liquid.density"), liquid.density, "g/mm³")?,
        },
        (None, Some(gas)) => Content {
            exponent: within(at("gas.exponent"), gas.exponent, (1.0, 3.0))?,
            stiffness: positive(at("gas.ambient"), gas.ambient, "MPa")?,
            density: positive(at("gas.density"), gas.density, "g/mm³")?,
        },
        (Some(_), Some(_)) => return Err(Fault::new(key, "it has two contents", "keep one of `liquid` and `gas`")),
        (None, None) => {
            let hint = "give `liquid = { }` for water or `gas = { }` for air";
            return Err(Fault::new(key, "it has no content", hint));
        }
    };
    let leak = within(at("leak"), spec.leak, (0.0, 1.0))?;
    let chamber = not_negative(at("chamber"), spec.chamber, "mm³")?;
    if !spec.capped && has_rim(&membrane) {
        let what = "the mesh of the body has a rim: its side is open";
        let hint = "add `capped = true` to close every loop of the rim by a flat lid, or give a closed mesh";
        return Err(Fault::new(key, what, hint));
    }
    let (inflow, outside) = (spec.inflow.0.clone(), spec.outside.0.clone());
    Ok(membrane.with(Compartment { content, inflow, outside, leak, chamber }))
}

fn within(key: String, value: f64, (least, most): (f64, f64)) -> Result<f64, Fault> {
    if (least..=most).contains(&value) {
        return Ok(value);
    }
    let hint = format!("give a number from {least} to {most}");
    Err(Fault::new(key, format!("{value} is out of range"), hint))
}

fn has_rim(membrane: &Membrane) -> bool {
    let mesh = membrane.mesh();
    // A mesh that is no surface is refused with the body.
    let topology = Topology::new(mesh.positions.len(), &mesh.triangles);
    topology.is_ok_and(|topology| topology.neighbours.iter().flatten().any(|across| *across == NONE))
}
