//! What a mesh is like, for a look before it is run.

use super::error::on_one_line;
use super::mesh_file::{Hanging, MeshFile, coincident, ends, hanging, millimetres};
use super::schema::{BodySpec, FibreSpec, FileSpec, MeshSpec};
use super::sets::Sets;
use rhexis::math::{elementary, smallest_angle};
use rhexis::storage::TriangleMesh;
use std::collections::BTreeMap;
use std::fmt;

/// The most hanging vertices that are named.
const NAMED: usize = 4;

/// Note on a mesh whose format gives its unit.
pub(super) const IN_METRES: &str = "the mesh is taken in metres, as glTF has it (1 unit is 1000 mm); `unit = \"m\"` in the mesh's table confirms this, \
    `unit = \"mm\"` takes the numbers as they are";

/// A mesh in figures, as it is before any cut.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct MeshSummary {
    /// Pieces that no edge joins.
    pub pieces: usize,
    /// Closed lines of edges with one triangle.
    pub boundary_loops: usize,
    /// Mean thickness \[mm\] of a piece that is closed and thin: the skin of a solid.
    #[serde(rename = "thin_solid_mm")]
    pub thin_solid: Option<f64>,
    /// Whether the mesh was taken in metres because its format has that unit.
    pub in_metres: bool,
    /// Vertices at the place of another, within 1e-9 of the extent.
    pub coincident: usize,
    /// Vertices on the edge of a triangle that does not have them.
    pub hanging: usize,
    /// The first of them, each with the edge.
    #[serde(skip)]
    pub hanging_at: Vec<String>,
    /// Vertices that reading joined to others.
    pub joined: usize,
    /// Triangles that reading turned over.
    pub turned: usize,
    /// What reading dropped and split, in words; empty for nothing.
    pub repaired: String,
    /// Largest way by which `planar` moved a vertex \[mm\].
    #[serde(rename = "flattened_mm")]
    pub flattened: f64,
    /// Smallest angle of a triangle \[°\].
    #[serde(rename = "smallest_angle_deg")]
    pub smallest_angle: f64,
    /// Shortest, mean and longest edge \[mm\].
    #[serde(rename = "edges_mm")]
    pub edges: [f64; 3],
    /// Where the fibres come from, in words.
    pub fibres: String,
    /// What its vertices carry, in words; empty for nothing.
    pub attributes: String,
    /// Vertices with several texture coordinates in the file: corners of triangles keep theirs in output files.
    pub seams: usize,
    /// Arrays of the file that nothing uses.
    pub unused_arrays: Vec<String>,
    /// Edge of the equilateral triangle with the mean area \[mm\].
    #[serde(rename = "mean_size_mm")]
    pub mean_size: f64,
}

/// Looks at a mesh.
pub(super) fn look(spec: &BodySpec, file: &MeshFile, flattened: f64) -> MeshSummary {
    let mesh = &file.mesh;
    let at = |v: u32| mesh.positions[v as usize];
    let lengths =
        mesh.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]].map(|[i, j]| at(i).distance(at(j))));
    let (mut shortest, mut sum, mut longest) = (f64::INFINITY, 0.0, 0.0_f64);
    for length in lengths {
        shortest = shortest.min(length);
        sum += length;
        longest = longest.max(length);
    }
    let count = mesh.triangles.len().max(1) as f64;
    let angles = mesh.triangles.iter().map(|t| smallest_angle(t.map(at)).to_degrees());
    let area: f64 =
        mesh.triangles.iter().map(|t| 0.5 * (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0])).length()).sum();
    let Outline { pieces, loops, thin_solid } = outline(mesh);
    let mut hanging = hanging(&mesh.positions, &mesh.triangles, 0.0);
    hanging.sort_by_key(|place| place.vertex);
    hanging.dedup_by_key(|place| place.vertex);
    MeshSummary {
        pieces,
        boundary_loops: loops,
        thin_solid,
        in_metres: is_in_metres(&spec.mesh),
        coincident: coincident(&mesh.positions),
        hanging: hanging.len(),
        hanging_at: hanging.iter().take(NAMED).map(|place| on_edge(mesh, place)).collect(),
        joined: file.tidied.joined,
        turned: file.tidied.turned,
        repaired: file.tidied.defects.text(),
        flattened,
        smallest_angle: angles.fold(f64::INFINITY, f64::min),
        edges: [shortest, sum / (3.0 * count), longest],
        fibres: on_one_line(&fibres(spec, file)).into_owned(),
        attributes: attributes(file),
        seams: file.seams,
        unused_arrays: file.passed_over.iter().map(|name| on_one_line(name).into_owned()).collect(),
        mean_size: (area / count * 4.0 / 3.0_f64.sqrt()).sqrt(),
    }
}

/// Whether the scene leaves the unit of a file to a format that has metres.
pub(super) fn is_in_metres(mesh: &MeshSpec) -> bool {
    let MeshSpec::File(FileSpec { path, reading }) = mesh else { return false };
    reading.scale.is_none() && reading.unit.is_none() && millimetres(path) != 1.0
}

/// A hanging vertex in words.
fn on_edge(mesh: &TriangleMesh, &Hanging { vertex, triangle, side, .. }: &Hanging) -> String {
    let at = |vertex: u32| {
        let [x, y, z] = mesh.positions[vertex as usize].to_array().map(length);
        format!("({x}, {y}, {z})")
    };
    let [from, to] = ends(mesh.triangles[triangle], side);
    format!("vertex {vertex} at {} on the edge from {} to {} of triangle {triangle}", at(vertex), at(from), at(to))
}

fn attributes(file: &MeshFile) -> String {
    let channels = file.attributes.iter().flat_map(|attributes| &attributes.channels);
    channels.map(|(channel, _)| channel.name()).collect::<Vec<_>>().join(", ")
}

fn fibres(spec: &BodySpec, file: &MeshFile) -> String {
    let own = match (&spec.fibres, &file.fibres_from) {
        (None, Some(from)) => format!("from the array {from}"),
        (None, None) => match spec.mesh {
            MeshSpec::File(_) => "along x: the file has no array of fibres that is known by its name".to_owned(),
            _ => "along x".to_owned(),
        },
        (Some(FibreSpec::Array(_)), from) => format!("from the array {}", from.as_deref().unwrap_or_default()),
        (Some(FibreSpec::File(path)), _) => format!("from the file {}", path.display()),
        (Some(FibreSpec::Degrees(degrees)), _) => format!("at {degrees}° from x"),
        (Some(FibreSpec::Direction(d)), _) => format!("along {}", d.0),
        (Some(FibreSpec::Concentric(a)), _) => format!("concentric, {}° outwards", a.degrees),
        (Some(FibreSpec::Radial(a)), _) => format!("radial, at {}°", a.degrees),
        (Some(FibreSpec::Helix(a)), _) => format!("helical, rising by {}°", a.degrees),
    };
    match (&spec.fibres, &file.fibres_from) {
        (Some(FibreSpec::Array(_)), _) | (None, _) | (_, None) => own,
        (Some(_), Some(from)) => format!("{own}, in place of the array {from}"),
    }
}

/// The outline of a mesh.
struct Outline {
    /// Sets of triangles that share edges.
    pieces: usize,
    /// Loops of edges with one triangle.
    loops: usize,
    /// Mean thickness \[mm\] of the thinnest solid that a piece without a rim encloses, if it is thin.
    thin_solid: Option<f64>,
}

/// Thickness of a thin solid at the most, as a part of the side of a square as large as each of the two faces.
const THIN: f64 = 0.1;

fn outline(mesh: &TriangleMesh) -> Outline {
    let mut halves: Vec<([u32; 2], u32)> = Vec::with_capacity(3 * mesh.triangles.len());
    for (triangle, &[a, b, c]) in (0..).zip(&mesh.triangles) {
        halves.extend([[a, b], [b, c], [c, a]].map(|[i, j]| ([i.min(j), i.max(j)], triangle)));
    }
    halves.sort_unstable();
    let mut pieces = Sets::new(mesh.triangles.len());
    // In a manifold each vertex has no boundary edge or two: its loops are the sets that those edges join.
    let mut rim = Sets::new(mesh.positions.len());
    let mut is_rim = vec![false; mesh.positions.len()];
    for group in halves.chunk_by(|a, b| a.0 == b.0) {
        match group {
            [only] => {
                rim.join(only.0[0], only.0[1]);
                only.0.iter().for_each(|&v| is_rim[v as usize] = true);
            }
            [first, others @ ..] => others.iter().for_each(|other| pieces.join(first.1, other.1)),
            [] => {}
        }
    }
    let thin_solid = thin_solid(mesh, &mut pieces, &is_rim);
    Outline { pieces: pieces.count(|_| true), loops: rim.count(|v| is_rim[v]), thin_solid }
}

fn thin_solid(mesh: &TriangleMesh, pieces: &mut Sets, is_rim: &[bool]) -> Option<f64> {
    let origin = *mesh.positions.first()?;
    // Of each piece its volume and area; none where it has a rim.
    let mut solids: BTreeMap<u32, Option<(f64, f64)>> = BTreeMap::new();
    for (triangle, corners) in (0..).zip(&mesh.triangles) {
        let [a, b, c] = corners.map(|v| mesh.positions[v as usize] - origin);
        let solid = solids.entry(pieces.first(triangle)).or_insert(Some((0.0, 0.0)));
        if corners.iter().any(|&v| is_rim[v as usize]) {
            *solid = None;
        }
        if let Some((volume, area)) = solid {
            *volume += a.dot(b.cross(c)) / 6.0;
            *area += 0.5 * (b - a).cross(c - a).length();
        }
    }
    let thin = solids.into_values().flatten().filter_map(|(volume, area)| {
        let thickness = 2.0 * volume.abs() / area;
        (thickness < THIN * (0.5 * area).sqrt()).then_some(thickness)
    });
    thin.min_by(f64::total_cmp)
}

impl MeshSummary {
    /// What is likely to be a mistake: reported by the check, the report and the summary of a run.
    pub fn doubts(&self) -> Vec<String> {
        let mut list = Vec::new();
        if self.in_metres {
            list.push(IN_METRES.into());
        }
        if self.coincident > 0 {
            list.push(format!(
                "{} vertices lie where others do, and the mesh is in {} piece(s) with {} boundary loop(s): coincident vertices are not \
                 joined; `weld` in the mesh's table joins them",
                self.coincident, self.pieces, self.boundary_loops
            ));
        }
        if self.hanging > 0 {
            let more = match self.hanging - self.hanging_at.len() {
                0 => String::new(),
                more => format!(" and {more} more"),
            };
            list.push(format!(
                "{} vertices lie on edges of triangles that do not have them, where the surface is slit: {}{more}; `repair = true` in the \
                 mesh's table splits them in",
                self.hanging,
                self.hanging_at.join(", ")
            ));
        }
        if let Some(thickness) = self.thin_solid.map(length) {
            list.push(format!(
                "the mesh is closed, the skin of a thin solid ({thickness} mm in the mean, twice its volume over its area): as a membrane it is \
                 two sheets with nothing between; give the middle surface, with `thickness = {thickness}` in `material`"
            ));
        }
        list
    }
}

impl fmt::Display for MeshSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [shortest, mean, longest] = self.edges.map(length);
        write!(
            f,
            "{} piece(s), {} boundary loop(s), edges {shortest} to {longest} mm (mean {mean}), smallest angle {:.1}°",
            self.pieces, self.boundary_loops, self.smallest_angle
        )?;
        let told = [(self.joined, "vertices joined"), (self.turned, "triangle(s) turned over")];
        for (count, what) in told.into_iter().filter(|(count, _)| *count > 0) {
            write!(f, ", {count} {what}")?;
        }
        if self.flattened > 0.0 {
            write!(f, ", flattened by up to {} mm", length(self.flattened))?;
        }
        if !self.repaired.is_empty() {
            write!(f, "\n    repaired: {}", self.repaired)?;
        }
        write!(f, "\n    fibres {}", self.fibres)?;
        if !self.attributes.is_empty() {
            write!(f, "; vertices have {}", self.attributes)?;
            if self.seams > 0 {
                write!(f, ", {} of them several texture coordinates, which output files keep", self.seams)?;
            }
        }
        if !self.unused_arrays.is_empty() {
            write!(f, "; arrays not used: {}", self.unused_arrays.join(", "))?;
        }
        self.doubts().iter().try_for_each(|doubt| write!(f, "\n    note: {doubt}"))
    }
}

/// A length \[mm\] to four digits, however small.
pub(super) fn length(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let digits = 4 - 1 - elementary::log10(value.abs()).floor() as i32;
    let factor = elementary::pow(10.0, f64::from(digits));
    let rounded = if factor.is_finite() && factor > 0.0 { (value * factor).round() / factor } else { value };
    if (1e-5..1e7).contains(&value.abs()) { rounded.to_string() } else { format!("{value:.3e}") }
}
