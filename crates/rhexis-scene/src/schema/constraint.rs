//! Regions of a body, and what holds, loads and grips it there.

use super::{Exactly, Interval, Point, TimeCurve, TimePath};
use serde::Deserialize;

/// Vertices by their rest position. All given conditions must hold.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RegionSpec {
    /// Every vertex.
    pub all: bool,
    /// x \[mm\]: a number or a range.
    pub x: Option<Interval>,
    /// y \[mm\].
    pub y: Option<Interval>,
    /// z \[mm\].
    pub z: Option<Interval>,
    /// Distance from the axis through `centre` along `axis` \[mm\].
    pub radius: Option<Interval>,
    /// A point of that axis \[mm\]. Default the origin.
    pub centre: Point,
    /// Direction of that axis. Default z.
    pub axis: Option<Point>,
    /// Only vertices on the mesh's boundary.
    pub boundary: bool,
    /// Only the vertex nearest to this point \[mm\].
    pub nearest: Option<Point>,
    /// Only these vertices, by their numbers from 0 in the order of the mesh.
    pub vertices: Option<Vec<u32>>,
    /// Only inside this box: its least and its greatest corner \[mm\].
    #[serde(rename = "box")]
    pub inside: Option<Exactly<Point, 2>>,
    /// Only inside this ball.
    pub sphere: Option<BallSpec>,
    /// Only this group of the mesh file: a physical group of Gmsh, a group or object of OBJ, a node or mesh of glTF.
    pub group: Option<String>,
    /// Only where an array of the mesh file has certain values.
    pub array: Option<ArrayRangeSpec>,
    /// In at least one of these regions.
    pub any: Option<Vec<RegionSpec>>,
    /// Not in this region.
    pub except: Option<Box<RegionSpec>>,
    /// Widens every range by so much \[mm\]. Default 1e-6.
    pub tolerance: Option<f64>,
}

/// Values of an array of a mesh file (VTK, PLY) that select vertices: their own, or those of a triangle at them.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ArrayRangeSpec {
    /// Name of the array, of one number a row.
    pub name: String,
    /// A number or a range.
    pub value: Interval,
}

/// A ball that selects vertices.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BallSpec {
    /// Centre \[mm\]. Default the origin.
    #[serde(default)]
    pub centre: Point,
    /// Radius \[mm\], ≥ 0.
    pub radius: f64,
}

/// One of `[[bodies.holds]]`: the vertices stand at rest position + curve(t) · move.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HoldSpec {
    /// Name in reports.
    pub name: String,
    /// Which vertices.
    pub region: RegionSpec,
    /// Held axes, some of `"xyz"` (default all). The others stay free.
    #[serde(default = "all_axes")]
    pub axes: String,
    /// How far they move at curve value 1; not at all if absent.
    #[serde(default, rename = "move")]
    pub movement: MoveSpec,
    /// Factor over time. Default 1.
    #[serde(default)]
    pub curve: TimeCurve,
    /// `rotate = [[time, [x, y, z]], …]`: by how much they are turned, before they move: along the axis, as long as the angle \[°\]; from a
    /// table also as quaternions ([`TableSpec`](super::TableSpec)).
    pub rotate: Option<TimePath>,
    /// A point of that axis \[mm\]. Default the origin.
    pub pivot: Option<Point>,
    /// Held along this direction, free across it. In place of `axes`.
    pub normal: Option<Point>,
    /// Free along this direction, held across it. In place of `axes`.
    pub line: Option<Point>,
}

/// One of `[[bodies.clamps]]`: vertices that move alike, without turning, by as much as a force on them makes. Exact, without a penalty. A clamp
/// counts as a hold in reports, where its reaction is the force on the body.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClampSpec {
    /// Name in reports. Default `clamp 0`, `clamp 1` and so on.
    pub name: Option<String>,
    /// Which vertices.
    pub region: RegionSpec,
    /// Force on all of them together \[N\], along clamped axes. Default none: the clamp keeps them together and goes with the tissue.
    #[serde(default)]
    pub force: Point,
    /// Clamped axes, some of `"xyz"` (default all). The others stay free for each vertex.
    #[serde(default = "all_axes")]
    pub axes: String,
    /// Factor of the force over time. Default 1.
    #[serde(default)]
    pub curve: TimeCurve,
}

/// `move`: offset + x·per_x + y·per_y + z·per_z of the rest position, \[mm\].
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MoveSpec {
    /// The same for all \[mm\].
    pub offset: Point,
    /// Per mm of rest x.
    pub per_x: Point,
    /// Per mm of rest y.
    pub per_y: Point,
    /// Per mm of rest z.
    pub per_z: Point,
}

/// One of `[[bodies.point_loads]]`: a force on each vertex of a region, or on all of them together.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PointLoadSpec {
    /// Which vertices.
    pub region: RegionSpec,
    /// Force on each \[N\]. Give either this or `total`.
    pub force: Option<Point>,
    /// Force on all of them together \[N\], shared by rest area.
    pub total: Option<Point>,
    /// Factor over time. Default 1.
    #[serde(default)]
    pub curve: TimeCurve,
}

/// One of `[[bodies.edge_loads]]`: a force per rest length on the boundary edges with both ends in a region.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EdgeLoadSpec {
    /// Which edges.
    pub region: RegionSpec,
    /// \[N/mm\]: a stress times the thickness.
    pub traction: Point,
    /// Factor over time. Default 1.
    #[serde(default)]
    pub curve: TimeCurve,
}

/// One of `[[bodies.springs]]`: springs to the rest position. Give either stiffness.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpringSpec {
    /// Which vertices.
    pub region: RegionSpec,
    /// Of all of them together \[N/mm\], shared by rest area.
    pub total: Option<f64>,
    /// Per rest area of the vertices (a third of their triangles') \[N/mm³\].
    pub per_area: Option<f64>,
    /// Force per rest area \[MPa\] above which a spring breaks for good, after the step in which it was; the same for all springs of a body. Default none.
    pub break_traction: Option<f64>,
}

/// One of `[[bodies.beds]]`: bonds to the ground on which tissue lies at the start, which come off by an energy.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BedSpec {
    /// Which vertices.
    pub region: RegionSpec,
    /// Energy per area \[N/mm\] that takes them off: 0.01 N/mm = 10 J/m².
    pub energy: f64,
    /// Largest traction \[MPa\]. A mesh too coarse for it takes less, with the same energy.
    pub strength: f64,
    /// Stiffness per area \[N/mm³\] before they come off. Default 5 · strength² / energy, a tenth of their range.
    pub stiffness: Option<f64>,
}

/// One of `[[bodies.grips]]`: forceps that take the tissue, move by their path and let go.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GripSpec {
    /// Name in reports.
    pub name: String,
    /// Where the tissue is taken, in the rest shape \[mm\].
    pub at: Point,
    /// Takes the tissue beside the tear's tip instead; `at` is then the place for which the path is given.
    pub near_tip: Option<NearTipSpec>,
    /// Time of the grasp \[ms\].
    pub from: f64,
    /// Time of the release \[ms\].
    pub until: f64,
    /// Pinch radius \[mm\], ≥ 0; the nearest vertex is always taken.
    pub radius: f64,
    /// Stiffness of the whole pinch \[N/mm\], > 0, shared by rest area. Default none: what is held follows the hand exactly.
    pub stiffness: Option<f64>,
    /// Force \[N\], > 0, beyond which the tissue slips. Default none.
    pub force_limit: Option<f64>,
    /// Whether tissue that slips slides between the jaws, which takes a stiffness; else (default) they let go of it.
    #[serde(default)]
    pub slides: bool,
    /// The hand's path from `at`: what is held moves by the hand's displacement.
    pub path: Vec<LegSpec>,
    /// `rotate = [[time, [x, y, z]], …]`: by how much the hand is turned about where it is, as an obstacle's `rotate`: along the axis, as long as the
    /// angle \[°\]. What is held turns with it from the grasp on. Default: the hand does not turn.
    pub rotate: Option<TimePath>,
}

/// A place beside the tip with the largest criterion at the time of the grasp. The path is turned with it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NearTipSpec {
    /// How far behind the tip \[mm\].
    pub behind: f64,
    /// How far to the left of the tear \[mm\], negative to the right.
    #[serde(default)]
    pub left: f64,
    /// Axis about which the path is turned. Default z.
    pub axis: Option<Point>,
    /// The tear's direction for which the path is given. Default counter-clockwise about the axis at `at`.
    pub heading: Option<Point>,
}

/// A leg of a hand's path: exactly one of `to`, `by` and `arc`, and when it ends.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LegSpec {
    /// Time at which the leg ends \[ms\]; it begins where the last one ended, the first one at `from`.
    pub end: f64,
    /// Straight to this point \[mm\].
    pub to: Option<Point>,
    /// Straight by this vector \[mm\].
    pub by: Option<Point>,
    /// Along an arc.
    pub arc: Option<ArcSpec>,
}

/// An arc about an axis, run at constant speed.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ArcSpec {
    /// A point of the axis \[mm\]. Default the origin.
    #[serde(default)]
    pub centre: Point,
    /// Direction of the axis. Default z.
    pub axis: Option<Point>,
    /// How far \[°\]; counter-clockwise about the axis if positive.
    pub degrees: f64,
    /// How far the hand rises along the axis meanwhile \[mm\]. Default 0.
    #[serde(default)]
    pub rise: f64,
    /// How far it moves away from the axis meanwhile \[mm\]; negative moves inwards. Default 0.
    #[serde(default)]
    pub outward: f64,
}

fn all_axes() -> String {
    "xyz".to_owned()
}
