//! Makes a body tear.

use crate::components::BodyError;
use crate::components::check::{Check, Host, number, positive};
use crate::math::{CrackTip, Orthotropic, elementary};
use std::f64::consts::FRAC_PI_2;

/// Growth of the toughness with the speed v of a tear: G_c·(1 + (v/v₀)ⁿ). Tips that glide follow it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct TearRate {
    /// v₀ \[mm/ms\], > 0: the speed at which the toughness has doubled.
    pub speed: f64,
    /// n, > 0.
    pub exponent: f64,
}

impl TearRate {
    /// (v/v₀)ⁿ: part of the toughness that a way \[mm\] in a time \[ms\] adds to it.
    pub(crate) fn added(self, way: f64, time: f64) -> f64 {
        elementary::pow(way / (self.speed * time), self.exponent)
    }
}

/// How a tear advances through the mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub enum TearMode {
    /// In any direction, by splitting triangles: whole triangles open at once, so that the force of a hand falls and climbs again.
    Free,
    /// Along existing edges; no new triangles.
    Edge,
    /// In any direction, by tips that glide within their triangles: between two edges the force is that of the toughness. Where a tip cannot
    /// glide (rims, junctions, borders of materials, held vertices, static solves) it advances as in free mode. Solves take an incomplete factor
    /// where they would take multigrid.
    #[default]
    Glide,
}

/// The tear criterion and how it is applied (Allard, Marchal, Cotin 2009, eq. 2–6, corrected). *Parameter.*
///
/// Give strengths where the stress at failure was measured and R is known as a length of the tissue (spacing of its fibres, size
/// of its defects). Where the energy of a long tear was measured, start from
/// [`from_toughness`](Self::from_toughness). Strength, R and toughness are tied: two of them imply the third, see
/// [`toughness`](Self::toughness). No tip that glides is faster than Rayleigh waves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tearing {
    /// Strength against tearing across the fibres σ̄_F \[MPa\], > 0.
    pub strength_across_fibres: f64,
    /// Strength against tearing along the fibres σ̄_T \[MPa\], > 0.
    pub strength_along_fibres: f64,
    /// Exponent α of the threshold between them, > 0; only α ≤ 1 makes the tear prefer the fibre sharply.
    pub exponent: f64,
    /// θ_P \[rad\]: the tear turns at most so far from its last direction. 90° by default.
    pub cone: f64,
    /// R \[mm\], > 0: the stress at a tip is its average over this disc. A material length; with the strength it implies a
    /// [`toughness`](Self::toughness). Where the mesh has fewer than three edges per R the report says so.
    pub radius: f64,
    /// Way of an advance through the mesh; tips glide by default.
    pub mode: TearMode,
    /// Growth of the toughness with speed; `None` for a constant one.
    pub rate: Option<TearRate>,
    /// Whether tears may start where nothing was cut, inside the tissue and at its boundary. At most one starts per body and pass
    /// of the step, at least 2R from every tip and from every vertex that a hold or a closed grip holds. Failure at a clamp is not
    /// modelled: the stress there is the clamp's, and singular at its corners; cut a notch where a tear is wanted. With an
    /// [`EnergyCriterion`](crate::components::EnergyCriterion) a start needs the energy of its opening as well as the strength, and
    /// opens a whole length at once. Without `may_initiate` only existing tips advance.
    pub may_initiate: bool,
    /// Greatest stretch that the tissue bears, > 1; off unless given. Beyond it tissue parts across the stretch without a tip.
    pub ultimate_stretch: Option<f64>,
    /// Largest margin, in \[0, 1), at which a notch tears both ways; off unless given. 1e-6 takes exact ties alone.
    pub branch_margin: Option<f64>,
}

impl Default for Tearing {
    /// The thresholds of the `fig2-tear` scene.
    fn default() -> Self {
        Self {
            strength_across_fibres: 0.8,
            strength_along_fibres: 0.05,
            exponent: 0.5,
            cone: std::f64::consts::FRAC_PI_2,
            radius: 1.5,
            mode: TearMode::Glide,
            rate: None,
            may_initiate: false,
            ultimate_stretch: None,
            branch_margin: None,
        }
    }
}

/// Fracture toughness G_c \[N/mm = mJ/mm² = kJ/m²\]: the energy that a long opening crack takes per area of crack, that is per
/// length and thickness. A sheet twice as thick takes twice the energy per length at the same G_c.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Toughness {
    /// Toughness against a crack that runs along the fibres.
    pub along: f64,
    /// Toughness against a crack that runs straight across the fibres.
    pub across: f64,
}

/// Toughness that is not positive and finite.
///
/// ```
/// use rhexis::components::{InadmissibleToughness, Material, Tearing, Toughness};
/// let law = Material::allard_2009().stiffness()?;
/// let refused = Tearing::from_toughness(Toughness { along: 0.0, across: 0.5 }, &law, 0.5);
/// assert_eq!(refused, Err(InadmissibleToughness { direction: "along", value: 0.0 }));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("toughness {direction} the fibres is {value:?} N/mm: it must be positive and finite")]
pub struct InadmissibleToughness {
    /// `"along"` or `"across"`.
    pub direction: &'static str,
    /// Rejected toughness \[N/mm\].
    pub value: f64,
}

impl Tearing {
    /// Strengths that make long cracks in a plate of `law` advance at the given toughness: σ̄ = k·K_c/√(2πR), where K_c is the
    /// stress intensity that releases G_c and k the disc average of the field there ([`CrackTip`]). R is then a length of
    /// the computation: it should be small against cracks and specimen and at least three edges of the mesh. Everything
    /// else as by default.
    ///
    /// ```
    /// use rhexis::components::{Material, Tearing, Toughness};
    /// let law = Material::allard_2009().stiffness()?;
    /// let tearing = Tearing::from_toughness(Toughness { along: 0.02, across: 0.5 }, &law, 0.5)?;
    /// let back = tearing.toughness(&law);
    /// assert!((back.along - 0.02).abs() < 1e-12 && (back.across - 0.5).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// Unless both are positive and finite.
    pub fn from_toughness(toughness: Toughness, law: &Orthotropic, radius: f64) -> Result<Self, InadmissibleToughness> {
        for (direction, value) in [("along", toughness.along), ("across", toughness.across)] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(InadmissibleToughness { direction, value });
            }
        }
        Ok(Self {
            strength_along_fibres: CrackTip::new(law, 0.0).strength(toughness.along, radius),
            strength_across_fibres: CrackTip::new(law, FRAC_PI_2).strength(toughness.across, radius),
            radius,
            ..Self::default()
        })
    }

    /// Whether tips glide in a step: a static solve opens whole triangles.
    pub(crate) fn glides(&self, is_static: bool) -> bool {
        self.mode == TearMode::Glide && !is_static
    }

    /// The toughness that the strengths and R imply in a plate of `law`: at which long cracks along the fibres, and straight
    /// across them, reach the criterion. It grows with R; a threshold of stress has no toughness of its own.
    pub fn toughness(&self, law: &Orthotropic) -> Toughness {
        Toughness {
            along: CrackTip::new(law, 0.0).toughness(self.strength_along_fibres, self.radius),
            across: CrackTip::new(law, FRAC_PI_2).toughness(self.strength_across_fibres, self.radius),
        }
    }
}

impl Check for Tearing {
    fn check(&self, _: &Host<'_>) -> Result<(), BodyError> {
        let numbers = [
            ("strength_across_fibres", self.strength_across_fibres),
            ("strength_along_fibres", self.strength_along_fibres),
            ("exponent", self.exponent),
            ("cone", self.cone),
            ("radius", self.radius),
        ];
        let rate = self.rate.map(|rate| [("rate.speed", rate.speed), ("rate.exponent", rate.exponent)]);
        let mut numbers = numbers.into_iter().chain(rate.into_iter().flatten());
        numbers.try_for_each(|(what, value)| positive("Tearing", what, value))?;
        if let Some(stretch) = self.ultimate_stretch {
            let is_right = stretch > 1.0 && stretch.is_finite();
            number("Tearing", "ultimate_stretch", stretch, (is_right, "it must be finite and above 1"))?;
        }
        self.branch_margin.map_or(Ok(()), |margin| {
            let is_right = (0.0..1.0).contains(&margin);
            number("Tearing", "branch_margin", margin, (is_right, "it must be at least 0 and below 1"))
        })
    }
}
