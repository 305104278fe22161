//! Closed volumes under bodies.

use super::TimeCurve;
use rhexis::components::Curve;
use serde::Deserialize;

/// `compartment = { liquid = { … } }` or `compartment = { gas = { … } }`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CompartmentSpec {
    /// Liquid content.
    pub liquid: Option<LiquidSpec>,
    /// Gas content.
    pub gas: Option<GasSpec>,
    /// Volume \[mm³/ms\] that flows in per time, over time; of a gas that at ambient pressure.
    #[serde(default = "none_over_time")]
    pub inflow: TimeCurve,
    /// Pressure \[MPa\] in front of the triangles and behind leaks, over time.
    #[serde(default = "none_over_time")]
    pub outside: TimeCurve,
    /// Coefficient of discharge of openings that tears make, from 0, tight, to 1; 0.6 for sharp edges.
    #[serde(default)]
    pub leak: f64,
    /// Volume \[mm³\] of rigid room beside that under the triangles; a flat body, without volume of its own, must have some.
    #[serde(default)]
    pub chamber: f64,
    /// Whether the boundary of the mesh is closed by flat lids; a mesh that has none is closed by itself.
    #[serde(default)]
    pub capped: bool,
}

/// Liquid in a compartment.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LiquidSpec {
    /// Bulk modulus \[MPa\], > 0; that of water is 2200.
    #[serde(default = "bulk_modulus_of_water")]
    pub bulk_modulus: f64,
    /// Density \[g/mm³\], > 0; that of water is 1e-3.
    #[serde(default = "density_of_water")]
    pub density: f64,
}

/// Gas in a compartment.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GasSpec {
    /// Exponent γ of p·V^γ, from 1, at constant temperature, to 3; 1.4 for air in a fast change.
    #[serde(default = "exponent_of_slow_gas")]
    pub exponent: f64,
    /// Ambient pressure beyond zero \[MPa\], > 0; that of the atmosphere is 0.101.
    #[serde(default = "atmosphere")]
    pub ambient: f64,
    /// Density at ambient pressure \[g/mm³\], > 0; that of air is 1.2e-6.
    #[serde(default = "density_of_air")]
    pub density: f64,
}

fn none_over_time() -> TimeCurve {
    TimeCurve(Curve::constant(0.0))
}

fn bulk_modulus_of_water() -> f64 {
    2200.0
}

fn density_of_water() -> f64 {
    1e-3
}

fn exponent_of_slow_gas() -> f64 {
    1.0
}

fn atmosphere() -> f64 {
    0.101325
}

fn density_of_air() -> f64 {
    1.2e-6
}
