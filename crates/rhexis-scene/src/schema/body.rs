//! `[[bodies]]`: a membrane and what it carries.

use super::compartment::CompartmentSpec;
use super::constraint::{BedSpec, ClampSpec, EdgeLoadSpec, GripSpec, HoldSpec, PointLoadSpec, RegionSpec, SpringSpec};
use super::per_triangle::PerTriangleSpec;
use super::tool::{BladeSpec, CutSpec, PunctureSpec};
use super::{Exactly, HolzapfelGasserOgdenSpec, MeshSpec, Numbers, Point, StiffeningFibresSpec, Strain, TimeCurve};
use rhexis::components::Curve;
use serde::Deserialize;
use serde::de::value::SeqAccessDeserializer;
use serde::de::{Deserializer, Error, SeqAccess, Unexpected, Visitor};
use std::fmt;
use std::path::PathBuf;

/// One of `[[bodies]]`. What is absent costs nothing.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BodySpec {
    /// Name in reports and files.
    pub name: String,
    /// Number of equal bodies, 1 to 10,000 in a scene, named `name-1`, `name-2` and so on; they do not feel each other. Default 1.
    #[serde(default = "one")]
    pub copies: u32,
    /// Keep it in the plane of its mesh. Default false.
    #[serde(default)]
    pub planar: bool,
    /// Its triangles.
    pub mesh: MeshSpec,
    /// Where the mesh is put: scaled, then turned, then moved. Regions, cuts and points are where it lies then.
    pub place: Option<PlaceSpec>,
    /// PNG or JPEG file for its texture coordinates in `output.gltf`; relative to the scene file.
    pub texture: Option<PathBuf>,
    /// Its elastic constants.
    pub material: MaterialSpec,
    /// Other materials of parts of it; a triangle has the last one whose region has all its corners.
    #[serde(default)]
    pub materials: Vec<PartSpec>,
    /// Anisotropy that grows with the distance from an axis.
    pub grading: Option<GradingSpec>,
    /// Where the fibres run; the mesh file's own, or along x, if absent.
    pub fibres: Option<FibreSpec>,
    /// What differs from triangle to triangle.
    pub per_triangle: Option<PerTriangleSpec>,
    /// Initial strain held by the surroundings: the drawn shape is under tension, a freed piece shrinks by it.
    pub pre_stretch: Option<Strain>,
    /// Fibres that stiffen as they are drawn out.
    pub stiffening_fibres: Option<StiffeningFibresSpec>,
    /// Law of its fibres by the invariants of Holzapfel, Gasser and Ogden.
    pub holzapfel_gasser_ogden: Option<HolzapfelGasserOgdenSpec>,
    /// Strain-rate damping β \[ms\], ≥ 0: the stress gains β · C : dU/dt.
    pub damping: Option<f64>,
    /// Branches by which its stress relaxes, up to four: the moduli of `material` are the instantaneous ones. Goes with the linear law.
    #[serde(default)]
    pub relaxation: Vec<BranchSpec>,
    /// Acceleration \[mm/ms²\]; the earth's is `[0, 0, -9.81e-3]`.
    pub gravity: Option<Point>,
    /// Drag of the surrounding fluid \[N·ms/mm³\], ≥ 0.
    pub drag: Option<f64>,
    /// Follower pressure along the normal \[MPa\], over time.
    pub pressure: Option<TimeCurve>,
    /// Closed volume behind the triangles, filled with a liquid or a gas that presses on them; goes without `pressure`.
    pub compartment: Option<CompartmentSpec>,
    /// Makes it resist bending.
    pub bending: Option<BendingSpec>,
    /// Makes it feel the obstacles.
    pub contact: Option<ContactSpec>,
    /// Makes it tear.
    pub tearing: Option<TearingSpec>,
    /// Lets its tear tips decide by energy.
    pub energy_criterion: Option<EnergyCriterionSpec>,
    /// Keeps the mesh fine around its tear tips.
    pub refinement: Option<RefinementSpec>,
    /// Lets it fall asleep when it is at rest.
    pub sleep: Option<SleepSpec>,
    /// State at time zero, if not at rest in the rest shape.
    pub initial: Option<InitialSpec>,
    /// Prescribed vertices.
    #[serde(default)]
    pub holds: Vec<HoldSpec>,
    /// Clamps that a force draws.
    #[serde(default)]
    pub clamps: Vec<ClampSpec>,
    /// Forces on vertices.
    #[serde(default)]
    pub point_loads: Vec<PointLoadSpec>,
    /// Forces on boundary edges.
    #[serde(default)]
    pub edge_loads: Vec<EdgeLoadSpec>,
    /// Springs to ground.
    #[serde(default)]
    pub springs: Vec<SpringSpec>,
    /// Grounds that the body is stuck to.
    #[serde(default)]
    pub beds: Vec<BedSpec>,
    /// Forceps.
    #[serde(default)]
    pub grips: Vec<GripSpec>,
    /// Notches and slits, made before the first step or at a time.
    #[serde(default)]
    pub cuts: Vec<CutSpec>,
    /// Slits by a needle at a time.
    #[serde(default)]
    pub punctures: Vec<PunctureSpec>,
    /// Blades that are drawn through the tissue.
    #[serde(default)]
    pub blades: Vec<BladeSpec>,
}

/// One of `relaxation`: a Maxwell branch of a Prony series.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BranchSpec {
    /// Part of the instantaneous stiffness that relaxes, > 0; all parts sum to less than 1.
    pub part: f64,
    /// Relaxation time \[ms\], > 0.
    pub time: f64,
}

/// `place = { scale, turn, about, move }`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlaceSpec {
    /// Factor on all lengths, > 0. Default 1.
    pub scale: Option<f64>,
    /// Rotation vector \[°\]: `[0, 0, 90]` is a quarter turn about z. Default none. Fibres of a file turn with the mesh.
    pub turn: Option<Point>,
    /// Point about which it is scaled and turned \[mm\]. Default the origin.
    pub about: Option<Point>,
    /// Displacement \[mm\]. Default none.
    #[serde(rename = "move")]
    pub displacement: Option<Point>,
}

/// One of `[[bodies.materials]]`: the material of a part.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PartSpec {
    /// The part.
    pub region: RegionSpec,
    /// Material of the part.
    pub material: MaterialSpec,
}

/// `material`: either `young` and `poisson`, or `young_fibre`, `young_transverse`, `poisson_major` and, if known,
/// `shear_modulus`; or `model = "neo_hookean"` and `mu`. Moduli and thickness may change over time, as tissue ages or dries: every step takes
/// those at its end. Not with `materials`, and not in them.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MaterialSpec {
    /// `"linear"` (default) or `"neo_hookean"`.
    #[serde(default)]
    pub model: MaterialModelSpec,
    /// Shear modulus μ \[MPa\] of a neo-Hookean material, > 0.
    pub mu: Option<TimeCurve>,
    /// Isotropic Young's modulus \[MPa\].
    pub young: Option<TimeCurve>,
    /// Isotropic Poisson ratio, −1 to 1.
    pub poisson: Option<f64>,
    /// Young's modulus along the fibre \[MPa\].
    pub young_fibre: Option<TimeCurve>,
    /// Young's modulus across the fibre \[MPa\].
    pub young_transverse: Option<TimeCurve>,
    /// Major Poisson ratio: strain across from stress along; its square times E_T/E_F must stay below 1.
    pub poisson_major: Option<f64>,
    /// Shear modulus \[MPa\]; Huber's √(E_F·E_T)/(2(1+√(ν_F·ν_T))) if absent.
    pub shear_modulus: Option<TimeCurve>,
    /// Thickness \[mm\]. It changes the mass, too. No curve with `per_triangle.thickness`.
    #[serde(deserialize_with = "one_thickness")]
    pub thickness: TimeCurve,
    /// Density \[g/mm³\]. Default 1e-3.
    #[serde(default = "density")]
    pub density: f64,
}

/// Law of a material without its fibres.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MaterialModelSpec {
    /// Linear in the Biot strain, with any orthotropic constants.
    #[default]
    Linear,
    /// μ/2·(I₁ − 3), incompressible. Not with `grading` or `energy_criterion`.
    NeoHookean,
}

/// `grading`: E_F is multiplied and E_T divided by √g, so that √(E_F·E_T) stays; g grows linearly with the distance from the
/// axis, from 1 on it to `ratio_at_rim` at `radius`, and stays beyond.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GradingSpec {
    /// g at `radius`, > 0.
    pub ratio_at_rim: f64,
    /// Distance from the axis \[mm\], > 0.
    pub radius: f64,
    /// A point of the axis \[mm\]. Default the origin.
    #[serde(default)]
    pub centre: Point,
    /// Direction of the axis. Default z.
    #[serde(default = "along_z")]
    pub axis: Point,
}

/// `fibres`: exactly one of these.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FibreSpec {
    /// `{ degrees = 45 }`: in the xy plane, counter-clockwise from x.
    Degrees(f64),
    /// `{ direction = [x, y, z] }`, projected into each triangle.
    Direction(Point),
    /// `{ concentric = { centre, axis, degrees } }`: circles about an axis, by default the z axis, or spirals at an angle to them,
    /// towards outside.
    Concentric(AxisSpec),
    /// `{ radial = { centre, axis, degrees } }`: away from an axis, or at an angle to that, towards the circles.
    Radial(AxisSpec),
    /// `{ helix = { centre, axis, degrees } }`: circles about an axis that rise along it by an angle.
    Helix(AxisSpec),
    /// `{ array = "…" }`: of the mesh file, three numbers for each of its cells or points.
    Array(String),
    /// `{ file = "…" }`: one direction `x y z` per line, in the order of the triangles; relative to the scene file.
    File(PathBuf),
}

/// An axis, and an angle \[°\] in the surface.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AxisSpec {
    /// A point of the axis \[mm\]. Default the origin.
    #[serde(default)]
    pub centre: Point,
    /// Direction of the axis. Default z.
    #[serde(default = "along_z")]
    pub axis: Point,
    /// Angle in the surface \[°\], from the direction that names the field. Default 0.
    #[serde(default)]
    pub degrees: f64,
}

/// `bending`: `bending = {}` takes the stiffness that follows from the material and the thickness, E·h³/(12·(1 − ν²)) of an
/// isotropic one. Not for planar bodies.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BendingSpec {
    /// Stiffness D \[N·mm\], > 0.
    pub stiffness: Option<f64>,
}

/// `contact`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ContactSpec {
    /// Pressure per depth of penetration \[N/mm³\], > 0. Default thirty times the membrane's own stiffness at every vertex.
    pub stiffness: Option<f64>,
    /// Coefficient of Coulomb's friction with obstacles, ≥ 0. Default 0.
    #[serde(default)]
    pub friction: f64,
    /// Contact of the body with itself. Default none.
    pub self_contact: Option<SelfContactSpec>,
    /// Contact with other bodies that say so too, at the mean of the radii of `self_contact`, which it takes. Default no.
    #[serde(default)]
    pub between_bodies: bool,
}

/// `self_contact`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SelfContactSpec {
    /// Distance \[mm\] below which two layers repel each other, above 0 and at most half a mean edge.
    pub radius: f64,
    /// Rest distance \[mm\] within which vertices, and parts with them, do not touch, ≥ 0. Default one radius.
    pub band: Option<f64>,
}

/// How a tear runs through the mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TearModeSpec {
    /// In any direction, by splitting triangles.
    Free,
    /// Along existing edges.
    Edge,
    /// In any direction, by tips that glide within their triangles.
    #[default]
    Glide,
}

/// What tips decide by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CriterionSpec {
    /// The energy that an advance releases, against the toughness.
    Energy,
    /// The stress averaged over the disc of `radius`, against the strength (the paper's criterion).
    Stress,
}

/// `tearing`: the criterion of Allard, Marchal and Cotin 2009, eq. 2–6, corrected.
///
/// Either strengths or toughnesses: strengths where the stress at failure was measured and `radius` is a length of the tissue,
/// toughnesses where the energy per area of tear was. `rhexis check` prints the ones that follow from the others. They may change over
/// time: every step takes those at its end.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TearingSpec {
    /// Strength against tearing along the fibres σ̄_T \[MPa\], > 0.
    pub strength_along_fibres: Option<TimeCurve>,
    /// Strength against tearing across the fibres σ̄_F \[MPa\], > 0. Give either this or `strength_ratio`.
    pub strength_across_fibres: Option<TimeCurve>,
    /// σ̄_F/σ̄_T, > 0.
    pub strength_ratio: Option<f64>,
    /// Toughness G_c \[N/mm\], > 0, of a crack along the fibres. With `material`'s constants, even under a `grading`.
    pub toughness_along_fibres: Option<TimeCurve>,
    /// Toughness G_c \[N/mm\], > 0, of a crack straight across the fibres.
    pub toughness_across_fibres: Option<TimeCurve>,
    /// `"energy"` or `"stress"`: what tips decide by. Default `"energy"` where toughnesses are given, `"stress"` where strengths are.
    pub criterion: Option<CriterionSpec>,
    /// Exponent α of the threshold between them, > 0. Default 0.5.
    #[serde(default = "exponent")]
    pub exponent: f64,
    /// The tear turns at most so far from its last direction: θ_P \[°\], above 0, at most 180. Default 90.
    #[serde(default = "cone_degrees")]
    pub cone_degrees: f64,
    /// Radius R \[mm\] of the disc over which the stress at a tip is averaged: a property of the tissue, not of the mesh.
    pub radius: f64,
    /// `"glide"` (default), `"free"` or `"edge"`.
    #[serde(default)]
    pub mode: TearModeSpec,
    /// Growth of the toughness with the speed of the tear. Off unless given.
    pub rate: Option<TearRateSpec>,
    /// Whether tears may start where nothing was cut. Default false.
    #[serde(default)]
    pub may_initiate: bool,
    /// Stretch above 1 beyond which tissue parts without a tip. Off unless given.
    pub ultimate_stretch: Option<f64>,
    /// Margin below which a notch tears both ways, at least 0 and below 1. Off unless given.
    pub branch_margin: Option<f64>,
}

/// `tearing.rate`: the toughness at the speed v is G_c·(1 + (v/speed)^exponent). Tips that glide follow it.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TearRateSpec {
    /// Speed at which the toughness has doubled \[mm/ms\], > 0.
    pub speed: f64,
    /// Exponent, > 0.
    pub exponent: f64,
}

/// `energy_criterion`: tips of a body with `tearing` advance where more energy would be released than their toughness, in the
/// direction where the release exceeds it most. The release comes from the field in a ring around the tip. Where the ring does not
/// have the field of one straight crack in a plane, it comes from the material force. `events.jsonl` says which it was. Starts need
/// both: the strengths of `tearing` along a whole length, and the energy of opening it. This table is for toughnesses beside
/// strengths, and for another ring; toughnesses in `tearing` do without.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EnergyCriterionSpec {
    /// Toughness G_c \[N/mm\], > 0, of a crack along the fibres; in between as strengths, with `exponent` of `tearing`. Both may change over
    /// time.
    pub toughness_along_fibres: TimeCurve,
    /// Toughness G_c \[N/mm\], > 0, of a crack straight across the fibres.
    pub toughness_across_fibres: TimeCurve,
    /// Radius of the ring over `radius` of `tearing`, above 0, at most 100. Default 2.
    #[serde(default = "ring")]
    pub ring: f64,
}

/// `refinement`: triangles around tear tips are halved until they are small enough for the averaging radius R of `tearing`, and
/// joined again where tips have gone. The size of a triangle is the edge of the equilateral one with its area.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RefinementSpec {
    /// R over the largest size of a triangle around a tip, above 0, at most 100. Default 4; from 3 on a tip's stress is that of
    /// the tissue, not of the mesh.
    pub edges_per_radius: Option<f64>,
    /// That size itself \[mm\], > 0. Give either this or `edges_per_radius`.
    pub edge: Option<f64>,
    /// How far beyond R the mesh is kept fine \[mm\], ≥ 0. Default R/2.
    pub margin: Option<f64>,
    /// Most triangles, as a multiple of those at the start, 1 to 100; what tears and cuts add is not counted. Default 1.6.
    #[serde(default = "budget")]
    pub budget: f64,
    /// Whether vertices that were added are taken out again behind the tips. Default true.
    #[serde(default = "may_coarsen")]
    pub may_coarsen: bool,
}

/// `sleep`: while the body would hardly move, no time is spent on it; whatever acts on it wakes it. `sleep = {}` takes the
/// defaults. A body whose energy is audited stays awake.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SleepSpec {
    /// Largest strain of the motion that it gives up, > 0. Default 1e-5.
    #[serde(default = "sleep_strain")]
    pub strain: f64,
    /// Steps for which it must have moved by less, 1 or more. Default 10.
    #[serde(default = "sleep_steps")]
    pub steps: u32,
}

/// `initial`: x = stretch · X, then a spin about the centre of mass and a common velocity.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InitialSpec {
    /// Linear map from rest to initial positions, by rows; the identity if absent.
    pub stretch: Option<Exactly<Exactly<f64, 3>, 3>>,
    /// Common velocity \[mm/ms\].
    #[serde(default)]
    pub velocity: Point,
    /// Angular velocity about the centre of mass \[rad/ms\].
    #[serde(default)]
    pub spin: Point,
}

/// One number or a curve; for lists per triangle, which people write there, the error says where they go.
fn one_thickness<'de, D: Deserializer<'de>>(deserializer: D) -> Result<TimeCurve, D::Error> {
    const SHAPE: &str = "one number in mm, or a curve over time; values per triangle are `per_triangle = { thickness = … }`, beside it: an array of the mesh file, a list or { file = \"…\" }";
    struct Read;
    impl<'de> Visitor<'de> for Read {
        type Value = TimeCurve;
        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str(SHAPE)
        }
        fn visit_f64<E: Error>(self, value: f64) -> Result<TimeCurve, E> {
            Ok(TimeCurve(Curve::constant(value)))
        }
        fn visit_i64<E: Error>(self, value: i64) -> Result<TimeCurve, E> {
            self.visit_f64(value as f64)
        }
        fn visit_seq<A: SeqAccess<'de>>(self, access: A) -> Result<TimeCurve, A::Error> {
            let numbers = Numbers::deserialize(SeqAccessDeserializer::new(access))?;
            match numbers.flat() {
                Some(_) => Err(A::Error::invalid_type(Unexpected::Seq, &self)),
                None => TimeCurve::through(&numbers).map_err(A::Error::custom),
            }
        }
    }
    deserializer.deserialize_any(Read)
}

fn one() -> u32 {
    1
}

fn sleep_strain() -> f64 {
    1e-5
}

fn sleep_steps() -> u32 {
    10
}

fn density() -> f64 {
    1e-3
}

fn exponent() -> f64 {
    0.5
}

fn cone_degrees() -> f64 {
    90.0
}

fn ring() -> f64 {
    2.0
}

fn budget() -> f64 {
    1.6
}

fn may_coarsen() -> bool {
    true
}

fn along_z() -> Point {
    Point(glam::DVec3::Z)
}
