//! Makes a body tear.

/// How a tear advances through the mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TearMode {
    /// In any direction, by splitting triangles.
    #[default]
    Free,
    /// Along existing edges; no new triangles.
    Edge,
}

/// The tear criterion and how it is applied (Allard, Marchal, Cotin 2009, eq. 2–6, corrected). *Parameter.*
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tearing {
    /// Strength against tearing across the fibres σ̄_F \[MPa\], > 0.
    pub strength_fibre: f64,
    /// Strength against tearing along the fibres σ̄_T \[MPa\], > 0.
    pub strength_transverse: f64,
    /// Exponent α of the threshold between them, > 0; only α ≤ 1 makes the tear prefer the fibre sharply.
    pub exponent: f64,
    /// θ_P \[rad\]: the tear turns at most so far from its last direction. 90° by default.
    pub cone: f64,
    /// R \[mm\], > 0: the stress at a tip is its average over this disc. A material length; with the strength it implies a
    /// toughness. Where the mesh has fewer than three edges per R the report says so.
    pub radius: f64,
    /// Free or edge mode.
    pub mode: TearMode,
    /// Fastest advance of a tip \[mm/ms\].
    pub max_tear_speed: f64,
    /// Whether tears may start where nothing was cut, inside the tissue and at its boundary: at most one per body and pass of
    /// the step, at least 2R from every tip and from every vertex that a hold or a closed grip has hold of. Failure at a clamp
    /// is not modelled: the stress there is the clamp's, and singular at its corners; cut a notch where a tear is
    /// wanted. Without it only existing tips advance.
    pub may_initiate: bool,
}

impl Default for Tearing {
    /// The thresholds of the `fig2-tear` scene.
    fn default() -> Self {
        Self {
            strength_fibre: 0.8,
            strength_transverse: 0.05,
            exponent: 0.5,
            cone: std::f64::consts::FRAC_PI_2,
            radius: 1.5,
            mode: TearMode::Free,
            max_tear_speed: 0.1,
            may_initiate: false,
        }
    }
}
