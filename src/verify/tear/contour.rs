//! Energy release rate and stress intensities at a tip from the field in a ring around it, as an energy-based criterion
//! would take them: domain forms of the J-integral (Li, Shih, Needleman 1985) and of the interaction integral (Yau, Wang,
//! Corten 1980). Axes of the crack: 1 ahead, 2 across.

use super::cracked::{Cracked, Tip, Tissue};
use crate::math::{Modes, RestTriangle, Sym2};
use crate::simulation::SimulationError;
use crate::storage::{Triangles, Vertices};
use crate::systems::kernels::membrane::gradient;
use crate::verify::VerifyError;
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// The ring's radius over R. A ring has no length of its own, but must lie in the tip's field and clear of its first triangles:
/// with twice R the loads of `tear-load` are met to 1.0 % at four edges per R and 2.2 % at two, with R to 1.3 % and 5.2 %.
pub const RINGS: f64 = 2.0;
/// The weight is 1 up to this part of the radius and falls to 0 at the radius: the triangles at the tip, whose stress is the
/// worst, then do not enter. Without such a core a ring of R meets the loads to 2.2 % and 6.0 %.
const CORE: f64 = 0.4;

/// What a ring tells.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Contour {
    /// J \[N/mm\]: energy released per area of a crack that goes straight on.
    pub release: f64,
    /// K_I \[MPa·√mm\], of isotropic tissue.
    pub opening: f64,
    /// K_II \[MPa·√mm\], of isotropic tissue.
    pub sliding: f64,
}

impl Contour {
    /// Integrates over the disc of `radius` \[mm\] about a tip, for displacements \[mm\] from rest.
    ///
    /// # Errors
    /// If the body is gone.
    pub fn around(
        cracked: &Cracked,
        displacement: &[DVec3],
        tip: &Tip,
        tissue: &Tissue,
        radius: f64,
    ) -> Result<Self, VerifyError> {
        let mut query = cracked.simulation.world().query_one::<(&Vertices, &Triangles)>(cracked.body);
        let (vertices, triangles) = query.get().map_err(|_| SimulationError::NoSuchBody)?;
        let axes = [tip.ahead, tip.ahead.perp()];
        let in_axes = |v: DVec3| DVec2::new(v.truncate().dot(axes[0]), v.truncate().dot(axes[1]));
        let weight = |v: u32| {
            let r = in_axes(vertices.rest_position[v as usize] - tip.at.extend(0.0)).length() / radius;
            ((1.0 - r) / (1.0 - CORE)).clamp(0.0, 1.0)
        };
        let fibre = DVec2::from_angle(tissue.fibre_degrees.to_radians());
        let fibre = DVec2::new(fibre.dot(axes[0]), fibre.dot(axes[1])).to_angle();
        let mut found = Self::default();
        for (corners, law) in triangles.corners.iter().zip(&triangles.stiffness) {
            let q = corners.map(weight);
            if q[0] == q[1] && q[1] == q[2] {
                continue;
            }
            let x = corners.map(|v| vertices.rest_position[v as usize]);
            let Some(rest) = RestTriangle::new(x, tip.ahead.extend(0.0)) else { continue };
            let (d1, d2) = gradient(corners.map(|v| displacement[v as usize]), &rest);
            let (d1, d2) = (in_axes(d1), in_axes(d2));
            let strain = Sym2::new(d1.x, d2.y, 0.5 * (d1.y + d2.x));
            let stress = law.stress(strain.in_axes_turned_by(fibre)).in_axes_turned_by(-fibre);
            let slope: DVec2 = rest.all_gradients().into_iter().zip(q).map(|(g, q)| g * q).sum();
            // (σ·∂₁u − W·e₁)·∇q
            let energy = 0.5 * stress.contract(strain);
            found.release += rest.area * (stress.apply(d1).dot(slope) - energy * slope.x);
            let place = in_axes((x[0] + x[1] + x[2]) / 3.0 - tip.at.extend(0.0));
            let young = tissue.material.young_fibre;
            for (k, field) in singular(place, young, tissue.material.poisson_major).into_iter().enumerate() {
                let mixed = stress.apply(field.slope).dot(slope) + field.stress.apply(d1).dot(slope);
                let part = 0.5 * young * rest.area * (mixed - field.stress.contract(strain) * slope.x);
                *[&mut found.opening, &mut found.sliding][k] += part;
            }
        }
        Ok(found)
    }

    /// Angle \[°\] by which a crack turns where its kink then releases most energy. With Nuismer's (1975) intensities of a short
    /// kink that is the direction of the largest hoop stress (Erdogan, Sih 1963): K_I·sin θ + K_II·(3·cos θ − 1) = 0.
    pub fn kink(&self) -> f64 {
        let (opening, sliding) = (self.opening, self.sliding);
        2.0 * (-2.0 * sliding).atan2(opening + (opening * opening + 8.0 * sliding * sliding).sqrt()).to_degrees()
    }
}

/// The field of one mode with K = 1 in an isotropic plate.
struct Singular {
    stress: Sym2,
    /// ∂u/∂x₁.
    slope: DVec2,
}

/// Opening and sliding mode (Williams 1957) in plane stress at a place relative to the tip.
fn singular(place: DVec2, young: f64, poisson: f64) -> [Singular; 2] {
    let (r, theta) = (place.length(), place.to_angle());
    let ((s, c), (s3, c3)) = ((0.5 * theta).sin_cos(), (1.5 * theta).sin_cos());
    let (sin, cos) = theta.sin_cos();
    let modes = Modes {
        opening: Sym2::new(c * (1.0 - s * s3), c * (1.0 + s * s3), c * s * c3),
        sliding: Sym2::new(-s * (2.0 + c * c3), s * c * c3, c * (1.0 - s * s3)),
    };
    let kappa = (3.0 - poisson) / (1.0 + poisson);
    let twice_shear = young / (1.0 + poisson);
    // u₂ = K·√(r/2π)/(2G)·f(θ), so ∂u₂/∂x₁ = K/√(2πr)/(2G)·(½·f·cos θ − f'·sin θ).
    let across = |f: f64, df: f64| (0.5 * f * cos - df * sin) / twice_shear;
    let opening = across(s * (kappa + 1.0 - 2.0 * c * c), 0.5 * c * (kappa + 1.0 - 2.0 * c * c) + 2.0 * s * s * c);
    let sliding = across(-c * (kappa - 1.0 - 2.0 * s * s), 0.5 * s * (kappa - 1.0 - 2.0 * s * s) + 2.0 * c * c * s);
    let scale = 1.0 / (TAU * r).sqrt();
    [(modes.opening, opening), (modes.sliding, sliding)].map(|(stress, turn)| Singular {
        stress: stress * scale,
        slope: DVec2::new((stress.xx - poisson * stress.yy) / young, turn) * scale,
    })
}
