//! Mesh generators. All surfaces face +z (their triangles run counter-clockwise seen from there).

use crate::math::elementary;
use std::f64::consts::TAU;

use glam::{DVec2, DVec3, dvec3};

use crate::storage::TriangleMesh;

/// The most triangles that a generator makes and a scene has, copies and refinement counted: some 5 GB, and minutes a step.
pub const MOST_TRIANGLES: usize = 5_000_000;

/// Why a generator refuses.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GenerateError {
    /// A length that is zero, negative or not a number.
    #[error("the {what} is {value} mm; it must be a finite length above zero")]
    Length {
        /// Name of the length.
        what: &'static str,
        /// Value of the length \[mm\].
        value: f64,
    },
    /// Too few pieces.
    #[error("the {what} is {value}; it must be at least {least}")]
    TooFew {
        /// Name of the count.
        what: &'static str,
        /// Value of the count.
        value: usize,
        /// The least it may be.
        least: usize,
    },
    /// Too many triangles.
    #[error("that would be more than {MOST_TRIANGLES} triangles; choose a coarser mesh")]
    TooMany,
    /// A count with a divisor.
    #[error("the {what} is {value}; it must be a multiple of {of}")]
    NotMultiple {
        /// Name of the count.
        what: &'static str,
        /// Value of the count.
        value: usize,
        /// The divisor.
        of: usize,
    },
    /// A cap wider than its sphere.
    #[error(
        "a cap {disc_diameter} mm across does not fit on a sphere of radius {curvature_radius} mm; at most twice the radius"
    )]
    CapTooWide {
        /// Radius of the sphere \[mm\].
        curvature_radius: f64,
        /// Diameter asked for \[mm\].
        disc_diameter: f64,
    },
    /// An angle that is not a number.
    #[error("the angle is {0}°; it must be finite")]
    Angle(f64),
    /// An outline that encloses nothing.
    #[error("the outline {0}; give the corners of a polygon in order, none twice, no side across another")]
    Outline(&'static str),
    /// The position function gave NaN or infinity.
    #[error("the position of vertex ({i}, {j}) is not finite")]
    NonFinitePosition {
        /// Column of the vertex.
        i: usize,
        /// Row of the vertex.
        j: usize,
    },
}

/// The structured mesh M(`nx`, `ny`) of the rectangle \[0, `width`\] × \[0, `height`\] \[mm\] in the plane z = 0. Vertex (i, j) has
/// index j·(nx+1)+i. The diagonal of cell (i, j) runs lower-left to upper-right if i+j is even, else upper-left to lower-right.
/// Mirror symmetry in x needs `nx` even, in y `ny` even, symmetry under 180° `nx + ny` even.
///
/// ```
/// let mesh = rhexis::generate::grid(30.0, 30.0, 30, 25)?;
/// assert_eq!((mesh.positions.len(), mesh.triangles.len()), (31 * 26, 1_500));
/// # Ok::<(), rhexis::generate::GenerateError>(())
/// ```
pub fn grid(width: f64, height: f64, nx: usize, ny: usize) -> Result<TriangleMesh, GenerateError> {
    let (width, height) = (length("width", width)?, length("height", height)?);
    mapped_grid(nx, ny, |s, t| dvec3(width * s, height * t, 0.0))
}

/// [`grid`] with its inner vertices moved at random by up to 0.11 of a cell along x and along y. Where cells are nearly square
/// the angles stay above 25°. The same `seed` gives the same mesh.
pub fn jittered(width: f64, height: f64, nx: usize, ny: usize, seed: u64) -> Result<TriangleMesh, GenerateError> {
    let mut mesh = grid(width, height, nx, ny)?;
    let mut random = Random::new(seed);
    let cell = dvec3(width / nx as f64, height / ny as f64, 0.0);
    for j in 1..ny {
        for i in 1..nx {
            let by = dvec3(random.unit() - 0.5, random.unit() - 0.5, 0.0);
            mesh.positions[j * (nx + 1) + i] += cell * by * (2.0 * JITTER);
        }
    }
    Ok(mesh)
}

/// Part of a cell by which [`jittered`] moves vertices.
const JITTER: f64 = 0.11;

/// The topology of [`grid`] with vertex (i, j) at `position`(i/`nx`, j/`ny`) \[mm\].
pub fn mapped_grid(nx: usize, ny: usize, position: impl Fn(f64, f64) -> DVec3) -> Result<TriangleMesh, GenerateError> {
    at_least("number of cells along x", nx, 1)?;
    at_least("number of cells along y", ny, 1)?;
    let triangle_count = bounded(nx.checked_mul(ny).and_then(|cells| cells.checked_mul(2)))?;
    let mut mesh = TriangleMesh::default();
    for j in 0..=ny {
        for i in 0..=nx {
            let p = position(i as f64 / nx as f64, j as f64 / ny as f64);
            if !p.is_finite() {
                return Err(GenerateError::NonFinitePosition { i, j });
            }
            mesh.positions.push(p);
        }
    }
    mesh.triangles.reserve_exact(triangle_count);
    for j in 0..ny {
        for i in 0..nx {
            let a = (j * (nx + 1) + i) as u32;
            let (b, d) = (a + 1, a + nx as u32 + 1);
            let c = d + 1;
            let pair = if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] };
            mesh.triangles.extend(pair);
        }
    }
    Ok(mesh)
}

/// A flat disc of `radius` \[mm\] about the origin in the plane z = 0, with about `target_triangles`.
pub fn disc(radius: f64, target_triangles: usize) -> Result<TriangleMesh, GenerateError> {
    let radius = length("radius", radius)?;
    rings(target_triangles, |s| s, |s, direction| (direction * (radius * s)).extend(0.0))
}

/// A spherical cap with about `target_triangles`: the sphere has `curvature_radius` \[mm\] and its centre at
/// (0, 0, −`curvature_radius`), so that the pole is the origin; the rim is a circle `disc_diameter` \[mm\] across below it.
pub fn cap(curvature_radius: f64, disc_diameter: f64, target_triangles: usize) -> Result<TriangleMesh, GenerateError> {
    let radius = length("radius of curvature", curvature_radius)?;
    let diameter = length("diameter", disc_diameter)?;
    let sine = diameter / (2.0 * radius);
    if sine > 1.0 {
        return Err(GenerateError::CapTooWide { curvature_radius, disc_diameter });
    }
    let rim = elementary::asin(sine);
    let position = |s: f64, direction: DVec2| {
        // 1 − cos as 2 sin²: a nearly flat cap keeps its digits.
        let (height, out) = (elementary::sin(0.5 * rim * s), elementary::sin(rim * s));
        (direction * (radius * out)).extend(-2.0 * radius * height * height)
    };
    rings(target_triangles, |s| elementary::sin(rim * s) / rim, position)
}

/// The square \[−5, 5\]² mm with a circular hole of radius 1 mm about the origin, in the plane z = 0: `n_t` points round the hole
/// at equal angles (a multiple of 8, so that corners are met), `n_t`/4 layers of quads between circle and square, each split in two.
///
/// Vertex (j, i), layer j and angle i, has index j·n_t+i and lies at (1−g)·circle + g·square on the ray of its angle, with
/// g = s(1+4s)/5 and s = j/(n_t/4). The diagonal runs from (j, i) to (j+1, i+1).
pub fn plate_with_hole(n_t: usize) -> Result<TriangleMesh, GenerateError> {
    at_least("number of points round the hole", n_t, 8)?;
    if !n_t.is_multiple_of(8) {
        return Err(GenerateError::NotMultiple { what: "number of points round the hole", value: n_t, of: 8 });
    }
    let layers = n_t / 4;
    bounded(n_t.checked_mul(layers).and_then(|quads| quads.checked_mul(2)))?;
    let mut mesh = TriangleMesh::default();
    for j in 0..=layers {
        let s = j as f64 / layers as f64;
        let g = s * (1.0 + 4.0 * s) / 5.0;
        for i in 0..n_t {
            let circle = elementary::unit_at(TAU * i as f64 / n_t as f64);
            let square = circle * (5.0 / circle.abs().max_element());
            mesh.positions.push(((1.0 - g) * circle + g * square).extend(0.0));
        }
    }
    for j in 0..layers {
        for i in 0..n_t {
            let [a, b] = [i, (i + 1) % n_t].map(|i| (j * n_t + i) as u32);
            let [d, c] = [a, b].map(|inner| inner + n_t as u32);
            mesh.triangles.extend([[a, d, c], [a, c, b]]);
        }
    }
    Ok(mesh)
}

/// Concentric rings about a centre. `girth`(s) is the circumference of the ring at the fraction `s` of the way out, over 2π
/// and over the length of the whole way; `position` takes the fraction and the unit direction.
///
/// The number of vertices of a ring is proportional to its girth, so that triangles are nearly equilateral everywhere. Each
/// ring is turned against the last by a golden section of its spacing: no line of edges runs straight outwards, where it would
/// offer a tear a preferred direction.
fn rings(
    target: usize,
    girth: impl Fn(f64) -> f64,
    position: impl Fn(f64, DVec2) -> DVec3,
) -> Result<TriangleMesh, GenerateError> {
    at_least("number of triangles", target, 24)?;
    bounded(Some(target))?;
    // A ring of equilateral triangles k layers out has 2π·(√3/2)·k = 5.44 k vertices; 5.7 keeps the first ring a hexagon.
    let ideal = 5.7;
    let girths =
        |layers: usize| (1..=layers).map(|k| layers as f64 * girth(k as f64 / layers as f64)).collect::<Vec<_>>();
    // Ring k makes as many triangles inwards as it has vertices, and as many outwards unless it is the rim.
    let spacing = |girths: &[f64]| {
        let rim = girths.last().copied().unwrap_or(1.0);
        target as f64 / (2.0 * girths.iter().sum::<f64>() - rim)
    };
    let misfit = |layers: usize| elementary::ln(spacing(&girths(layers)) / ideal).abs();
    let guess = ((target as f64 / ideal).sqrt() as usize).max(2);
    // A hemisphere needs up to 1.3 times the layers of a disc with as many triangles.
    let layers = (guess..=guess + guess / 2 + 1).min_by(|&a, &b| misfit(a).total_cmp(&misfit(b))).unwrap_or(guess);
    let girths = girths(layers);
    let per_girth = spacing(&girths);

    let mut mesh = TriangleMesh { positions: vec![position(0.0, DVec2::X)], ..Default::default() };
    let mut inner = Ring { first: 0, count: 1, phase: 0.0 };
    for (k, girth) in girths.iter().enumerate() {
        let count = ((per_girth * girth).round() as usize).max(5);
        let outer =
            Ring { first: mesh.positions.len(), count, phase: (GOLDEN * (k + 1) as f64).fract() / count as f64 };
        let s = (k + 1) as f64 / layers as f64;
        mesh.positions.extend((0..count).map(|i| position(s, outer.direction(i))));
        stitch(&inner, &outer, &mut mesh.triangles);
        inner = outer;
    }
    Ok(mesh)
}

/// The golden section, whose multiples are spread most evenly over \[0, 1).
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// A ring of equally spaced vertices; angles in turns.
struct Ring {
    first: usize,
    count: usize,
    phase: f64,
}

impl Ring {
    fn direction(&self, i: usize) -> DVec2 {
        elementary::unit_at(TAU * (self.phase + i as f64 / self.count as f64))
    }

    /// The middle of the edge from vertex `i` to the next.
    fn middle(&self, i: i64) -> f64 {
        self.phase + (i as f64 + 0.5) / self.count as f64
    }

    fn vertex(&self, i: i64) -> u32 {
        (self.first as i64 + i.rem_euclid(self.count as i64)) as u32
    }
}

/// Fills the strip between two rings: each edge is joined to the vertex of the other ring whose angle is nearest to its middle.
fn stitch(inner: &Ring, outer: &Ring, triangles: &mut Vec<[u32; 3]>) {
    if inner.count == 1 {
        triangles.extend((0..outer.count as i64).map(|j| [inner.vertex(0), outer.vertex(j), outer.vertex(j + 1)]));
        return;
    }
    // Going once round from the middle of the edge before inner vertex 0, where the outer vertex nearest in angle is `first`.
    let first = ((inner.middle(-1) - outer.phase) * outer.count as f64 - 0.5).ceil() as i64;
    let (mut i, mut j) = (0, first);
    while i < inner.count as i64 || j < first + outer.count as i64 {
        let inner_left = i < inner.count as i64;
        let outer_left = j < first + outer.count as i64;
        if outer_left && (!inner_left || outer.middle(j) < inner.middle(i)) {
            triangles.push([inner.vertex(i), outer.vertex(j), outer.vertex(j + 1)]);
            j += 1;
        } else {
            triangles.push([inner.vertex(i), outer.vertex(j), inner.vertex(i + 1)]);
            i += 1;
        }
    }
}

/// SplitMix64 (Steele, Lea, Flood 2014): the same numbers for a seed on any machine and with any version of any crate.
#[doc(hidden)]
pub struct Random(u64);

impl Random {
    /// Numbers of a seed.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// In \[0, 1).
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// A length \[mm\] above zero, or the error that names it.
#[doc(hidden)]
pub fn length(what: &'static str, value: f64) -> Result<f64, GenerateError> {
    if value > 0.0 && value.is_finite() { Ok(value) } else { Err(GenerateError::Length { what, value }) }
}

fn at_least(what: &'static str, value: usize, least: usize) -> Result<(), GenerateError> {
    if value >= least { Ok(()) } else { Err(GenerateError::TooFew { what, value, least }) }
}

/// A number of triangles that is not too large.
#[doc(hidden)]
pub fn bounded(triangle_count: Option<usize>) -> Result<usize, GenerateError> {
    triangle_count.filter(|count| *count <= MOST_TRIANGLES).ok_or(GenerateError::TooMany)
}

#[cfg(test)]
#[path = "generate_tests.rs"]
mod tests;
