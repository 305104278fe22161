//! Rhexis: an embeddable, data-oriented engine for the real-time tearing of fibre-reinforced soft-tissue membranes.
//!
//! A membrane is a triangle mesh with a thickness, a fibre direction and an orthotropic material per triangle. It is held, loaded,
//! gripped and cut. Where the stress at a tear's tip exceeds the strength of the tissue, the tear advances, through triangles or
//! along edges, in the direction that the criterion chooses. The strength depends on the angle to the fibres.
//!
//! # Goals, in this order
//! 1. **Never breaks.** No panic, no NaN out, no half-done edit. Bad input is refused with a reason and a remedy; a step that
//!    goes wrong is undone and retried; the same input gives the same bits on any number of threads.
//! 2. **Right.** The force is the gradient of an energy, the tear criterion's maximum is exact, the stress at a tip has a length
//!    of its own. Every formula names its source, and every departure from the paper is listed in [`theory`].
//! 3. **Fast at equal error.** Speed is judged at the error reached, never by a number of iterations.
//! 4. **Pleasant to embed.** It owns no loop, no window and no global; components that a body lacks cost nothing; everything you
//!    see is plain arrays.
//!
//! Not goals for now: volumetric meshes, rendering, running on a GPU.
//!
//! # The library in 20 lines
//! A square of 30 mm with fibres at 60° is notched at the top and pulled apart until it is torn through.
//!
//! ```
//! use rhexis::prelude::*;
//!
//! fn main() -> rhexis::Result<()> {
//!     let mesh = generate::grid(30.0, 30.0, 30, 25)?;
//!     let mut sheet = Membrane::new("sheet", mesh, Material::allard_2009()).planar().with(Tearing::default());
//!     sheet = sheet.fibres(Fibres::at_degrees(60.0));
//!     for (name, x, way) in [("left", 0.0, DVec3::NEG_X), ("right", 30.0, DVec3::X)] {
//!         let hold = Hold::new(name, sheet.select(|p| p.x == x)).moved(way, Curve::ramp(1000.0, 3.0)?);
//!         sheet = sheet.hold(hold);
//!     }
//!     let mut simulation = Simulation::new(Settings::default())?;
//!     let body = simulation.spawn(sheet)?;
//!     simulation.cut(body, &[DVec3::new(15.0, 30.0, 0.0), DVec3::new(15.0, 27.0, 0.0)])?;
//!     while simulation.fragments(body)?.count() == 1 {
//!         assert!(simulation.time() < 1000.0, "not torn through");
//!         simulation.step(10.0)?;
//!         for event in simulation.drain_events() {
//!             println!("{event:?}");
//!         }
//!     }
//!     Ok(())
//! }
//! ```
//!
//! [`Membrane`](membrane::Membrane) makes a body, [`components`] are its data, [`Simulation`](simulation::Simulation)
//! steps it, [`snapshot`](mod@snapshot) and [`replay`] go back and repeat, [`event`] and [`frame`](mod@frame) are the
//! output. A program that embeds it has slices and changes ([`Simulation::view`](simulation::Simulation::view)),
//! a clock ([`FixedStep`](simulation::FixedStep)), pins, rays, systems of its own and a haptic model
//! ([`Haptics`](simulation::Haptics)). The order of a step is one list, [`schedule::STEP`]. Units are fixed: mm, g, ms,
//! hence N, MPa, mJ.
//!
//! # Features
//! - `snapshot` (default): snapshots and recordings as bytes and files; in memory they are there without it.
//! - `direct`: a sparse Cholesky factor for static solves, several times as fast, and for dynamic solves that come to nothing without; it adds
//!   a minute of compile time. Without it small static solves use block Jacobi.
//!
//! Every set of features builds; builds with and without `direct` read each other's snapshots. Scene files (TOML), the catalog of scenes,
//! readers for OBJ, Gmsh, VTK, PLY and STL, and clinical measures of a tear are the crate `rhexis-scene`; the program `rhexis`, pictures
//! and ParaView files the crate `rhexis-cli`. A mesh is a [`TriangleMesh`](storage::TriangleMesh) of your own positions and triangles, or
//! one of [`generate`].

#![cfg_attr(not(test), warn(clippy::disallowed_methods, unreachable_pub))]
#![cfg_attr(not(test), warn(clippy::expect_used, clippy::panic, clippy::unreachable, clippy::unwrap_used))]

mod clock;
pub mod components;
mod error;
pub mod event;
pub mod frame;
pub mod generate;
#[doc(hidden)]
pub mod internal;
pub mod math;
pub mod membrane;
pub mod prelude;
mod registry;
pub mod replay;
pub mod report;
pub mod settings;
pub mod simulation;
pub mod snapshot;
mod source;
pub mod storage;
pub mod units;

#[doc(hidden)]
#[path = "../systems/mod.rs"]
pub mod systems;

pub use error::{Error, ErrorKind, Result};
pub use systems::step::schedule;
pub use {glam, hecs};

/// Compiles the Rust of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
mod readme {}

// Of two definitions of a link the first counts: here the module, in the file the chapter beside it.
/// [elasticity]: crate::theory::elasticity
/// [fibres]: crate::theory::fibres
/// [relaxation]: crate::theory::relaxation
/// [compartment]: crate::theory::compartment
/// [bending]: crate::theory::bending
/// [contact]: crate::theory::contact
/// [integration]: crate::theory::integration
/// [solver]: crate::theory::solver
/// [holds]: crate::theory::holds
/// [bed]: crate::theory::bed
/// [energy]: crate::theory::energy
/// [sleep]: crate::theory::sleep
/// [criterion]: crate::theory::criterion
/// [release]: crate::theory::release
/// [starts]: crate::theory::starts
/// [advance]: crate::theory::advance
/// [departures]: crate::theory::departures
#[doc = include_str!("../docs/theory/README.md")]
pub mod theory {
    #[doc = include_str!("../docs/theory/elasticity.md")]
    pub mod elasticity {}
    #[doc = include_str!("../docs/theory/fibres.md")]
    pub mod fibres {}
    /// [balance]: crate::theory::energy#energy-balance
    /// [sleep]: crate::theory::sleep
    #[doc = include_str!("../docs/theory/relaxation.md")]
    pub mod relaxation {}
    /// [balance]: crate::theory::energy#energy-balance
    #[doc = include_str!("../docs/theory/compartment.md")]
    pub mod compartment {}
    #[doc = include_str!("../docs/theory/bending.md")]
    pub mod bending {}
    #[doc = include_str!("../docs/theory/contact.md")]
    pub mod contact {}
    #[doc = include_str!("../docs/theory/integration.md")]
    pub mod integration {}
    #[doc = include_str!("../docs/theory/solver.md")]
    pub mod solver {}
    #[doc = include_str!("../docs/theory/holds.md")]
    pub mod holds {}
    #[doc = include_str!("../docs/theory/bed.md")]
    pub mod bed {}
    #[doc = include_str!("../docs/theory/energy.md")]
    pub mod energy {}
    #[doc = include_str!("../docs/theory/sleep.md")]
    pub mod sleep {}
    #[doc = include_str!("../docs/theory/criterion.md")]
    pub mod criterion {}
    /// [energy paid by a tear]: crate::theory::advance#energy-paid-by-a-tear
    /// [starts]: crate::theory::starts
    #[doc = include_str!("../docs/theory/release.md")]
    pub mod release {}
    /// [strength or toughness]: crate::theory::criterion#strength-or-toughness
    #[doc = include_str!("../docs/theory/starts.md")]
    pub mod starts {}
    /// [stress or energy]: crate::theory::release
    #[doc = include_str!("../docs/theory/advance.md")]
    pub mod advance {}
    /// [tangent]: crate::theory::elasticity#tangent
    #[doc = include_str!("../docs/theory/departures.md")]
    pub mod departures {}
}
