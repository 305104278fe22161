//! A scene about a mesh of one's own: a text to change, with numbers that go with the size of the mesh.

use glam::DVec3;
use rhexis_scene::mesh_file;
use std::path::Path;

/// What is not in the mesh file.
#[derive(Clone, Debug)]
pub struct Options {
    /// Unit of the file's coordinates: `"mm"`, `"cm"`, `"m"` or `"um"`.
    pub unit: String,
    /// Direction of the fibres, projected into each triangle.
    pub fibres: DVec3,
    /// Whether double, empty and third triangles are dropped.
    pub repair: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self { unit: "mm".to_owned(), fibres: DVec3::X, repair: true }
    }
}

/// Thickness and drag in parts of the size: those of the sheet of Figure 2, of 42 mm across.
const THINNESS: f64 = 0.1 / 42.0;

/// Averaging radius in mean edges, as in the scene `fig2-tear`.
const RADIUS: f64 = 1.5;

/// A mesh whose height is no more than this part of its extent is flat.
const FLAT: f64 = 1e-6;

/// Part of the height, from below, by which a closed surface is held.
const HELD: f64 = 0.1;

/// The text of a scene in which the mesh is held along its rim, or by its lowest part where it has none.
///
/// # Errors
/// Where the file is no usable mesh or the unit is not known.
pub fn text(name: &str, bytes: &[u8], options: &Options) -> Result<String, String> {
    let reading = mesh_file::Reading { repair: options.repair, ..mesh_file::Reading::default() };
    let file =
        mesh_file::from_bytes_with(Path::new(name), bytes.to_vec(), &reading).map_err(|error| error.to_string())?;
    let scale = match options.unit.as_str() {
        "mm" => 1.0,
        "cm" => 10.0,
        "m" => 1000.0,
        "um" => 1e-3,
        other => return Err(format!("the unit {other:?} is not known; give mm, cm, m or um")),
    };
    let mesh = &file.mesh;
    let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = mesh.positions.iter().fold(start, |(low, high), p| (low.min(*p), high.max(*p)));
    let (low, high) = (low * scale, high * scale);
    let (size, extent) = (high - low, (high - low).length());
    let at = |v: u32| mesh.positions.get(v as usize).copied().unwrap_or_default() * scale;
    let edges =
        mesh.triangles.iter().map(|&[a, b, c]| at(a).distance(at(b)) + at(b).distance(at(c)) + at(c).distance(at(a)));
    let edge = edges.sum::<f64>() / (3 * mesh.triangles.len().max(1)) as f64;
    let is_planar = size.z <= FLAT * extent;
    let region = if has_rim(&mesh.triangles) {
        "{ boundary = true }".to_owned()
    } else {
        format!("{{ z = [{}, {}] }}", low.z - edge, low.z + HELD * size.z)
    };
    let fibres = match (mesh.fibres.is_some(), options.fibres) {
        (true, _) => "# the fibres are those of the mesh file".to_owned(),
        (false, d) => format!("fibres = {{ direction = [{}, {}, {}] }}", d.x, d.y, d.z),
    };
    let shell = if is_planar { "planar = true" } else { "bending = { }" };
    let Options { unit, repair, .. } = options;
    let unit = if scale == 1e-3 { "scale = 1e-3".to_owned() } else { format!("unit = \"{unit}\"") };
    let (thickness, drag) = (rounded(THINNESS * extent), rounded(THINNESS * extent * 0.01));
    let radius = rounded(RADIUS * edge);
    let title = name.rsplit_once('.').map_or(name, |(stem, _)| stem).replace(['"', '\\', '\n', '\r'], "_");
    let path = name.replace(['"', '\\', '\n', '\r'], "_");
    Ok(format!(
        r#"# A mesh of one's own: numbers to change. Units: mm, g, ms, hence N and MPa.

[scene]
name = "{title}"
about = "a mesh of one's own, to be torn by hand"

[run]
dt = 10           # ms
steps = 1000000

[[bodies]]
name = "surface"
{shell}
mesh = {{ file = {{ path = "{path}", {unit}, repair = {repair} }} }}
material = {{ young_fibre = 10, young_transverse = 1, poisson_major = 0.3, shear_modulus = 0.5, thickness = {thickness} }}
{fibres}
damping = 1       # ms
drag = {drag}     # N·ms/mm³

[bodies.tearing]
strength_along_fibres = 0.05   # MPa, tearing along the fibres
strength_across_fibres = 0.8   # MPa, tearing across them
exponent = 0.5
cone_degrees = 90
radius = {radius}            # mm, one and a half mean edges
may_initiate = true

[[bodies.holds]]
name = "rim"
region = {region}
"#
    ))
}

/// Three digits: enough for a start, and easy to read.
fn rounded(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

/// Whether an edge has one triangle only.
fn has_rim(triangles: &[[u32; 3]]) -> bool {
    let mut edges: Vec<[u32; 2]> = triangles
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .map(|[a, b]| if a < b { [a, b] } else { [b, a] })
        .collect();
    edges.sort_unstable();
    let mut at = 0;
    while let Some(edge) = edges.get(at) {
        let count = edges[at..].iter().take_while(|other| *other == edge).count();
        if count == 1 {
            return true;
        }
        at += count;
    }
    false
}
