//! How much a scene asks for, judged before it is made: a few bytes of text can ask for more than any machine has.

use super::document::{children, join};
use super::error::Fault;
use super::generate::MOST_TRIANGLES;
use super::schema::{BodySpec, MeshSpec, OutputSpec};
use toml::de::{DeTable, DeValue};

/// The most bodies, copies counted.
const MOST_BODIES: u64 = 10_000;

/// The most points of curves and paths in all bodies.
pub(super) const MOST_POINTS: f64 = 1e7;

/// The most frames, and the most pictures: a file for each body each time.
const MOST_FILES: u64 = 100_000;

/// The most bytes of all frames.
const MOST_FRAME_BYTES: f64 = 1e12;

/// What a triangle takes in memory \[bytes\], its share of the vertices and the solver included (docs/performance.md).
pub(super) const BYTES_PER_TRIANGLE: f64 = 1000.0;

/// What a triangle takes in a frame \[bytes\].
const FRAME_BYTES_PER_TRIANGLE: f64 = 250.0;

/// What the bodies ask for together.
#[derive(Default)]
pub(super) struct Demand {
    bodies: u64,
    triangles: f64,
    points: f64,
}

impl Demand {
    /// What is known of the bodies before any mesh is made or read.
    ///
    /// # Errors
    /// At the body that is one too many.
    pub(crate) fn announced(specs: &[BodySpec]) -> Result<Self, Fault> {
        let mut demand = Self::default();
        for (i, spec) in specs.iter().enumerate() {
            demand.add(spec, &format!("bodies.{i}"), announced(&spec.mesh))?;
        }
        Ok(demand)
    }

    /// One body more with all its copies, of so many triangles each.
    ///
    /// # Errors
    /// Where that is more than a scene may have.
    pub(crate) fn add(&mut self, spec: &BodySpec, key: &str, triangles: f64) -> Result<(), Fault> {
        let copies = u64::from(spec.copies);
        self.bodies += copies;
        if copies == 0 || self.bodies > MOST_BODIES {
            let what = match copies {
                0 => "0 is no number of copies".to_owned(),
                _ => format!("that makes {} bodies, copies counted", self.bodies),
            };
            return Err(Fault::new(format!("{key}.copies"), what, format!("give 1 to {MOST_BODIES} in all")));
        }
        let budget = spec.refinement.as_ref().map_or(1.0, |refinement| refinement.budget.max(1.0));
        let most = MOST_TRIANGLES as f64;
        let copied = triangles * copies as f64;
        self.triangles += copied * budget;
        // A NaN budget is refused where it is read.
        if self.triangles > most {
            let (at, hint) = match () {
                _ if triangles > most => ("mesh", "choose a coarser mesh"),
                _ if copied > most => ("copies", "choose fewer copies or a coarser mesh"),
                _ if copied * budget > most => ("refinement.budget", "choose a smaller budget or a coarser mesh"),
                _ => ("mesh", "choose a coarser mesh, here or in the bodies before"),
            };
            let mut asked = format!("{} triangles", number(triangles));
            if copies > 1 {
                asked = format!("{copies} copies of {asked}");
            }
            if budget > 1.0 {
                asked += &format!(", up to {budget} times as many by refinement");
            }
            let what = format!(
                "{asked}: the scene would have {} triangles and take about {}; it may have {MOST_TRIANGLES}, which take {}",
                number(self.triangles),
                bytes(self.triangles * BYTES_PER_TRIANGLE),
                bytes(most * BYTES_PER_TRIANGLE)
            );
            return Err(Fault::new(format!("{key}.{at}"), what, hint));
        }
        let points = points(spec);
        self.points += points * copies as f64;
        if self.points > MOST_POINTS {
            let what = format!(
                "{copies} times {} points of curves and paths: the scene would have {}, which take {}; it may have {}",
                number(points),
                number(self.points),
                bytes(self.points * 16.0),
                number(MOST_POINTS)
            );
            return Err(Fault::new(format!("{key}.copies"), what, "choose fewer copies, or curves with fewer points"));
        }
        Ok(())
    }

    /// Whether its files can be written, over so many steps.
    ///
    /// # Errors
    /// For more pictures, frames or bytes of frames than a run may write.
    pub(crate) fn files(&self, output: &OutputSpec, steps: u64) -> Result<(), Fault> {
        let times = |count: u32| u64::from(count).min(steps + 1);
        for (name, count) in [("pictures", output.pictures), ("frames", output.frames)] {
            let files = times(count) * self.bodies;
            if files > MOST_FILES {
                let what = format!("{} times a file for each of {} bodies: {files} files", times(count), self.bodies);
                let hint = format!("choose fewer {name}, or 0 for none; a run may write {MOST_FILES} of them");
                return Err(Fault::new(format!("output.{name}"), what, hint));
            }
        }
        let size = times(output.frames) as f64 * self.triangles * FRAME_BYTES_PER_TRIANGLE;
        if size > MOST_FRAME_BYTES {
            let what = format!("{} frames of {} triangles would take {}", output.frames, self.triangles, bytes(size));
            let hint =
                format!("choose fewer frames, or 0 for none; a run may write {} of them", bytes(MOST_FRAME_BYTES));
            return Err(Fault::new("output.frames", what, hint));
        }
        Ok(())
    }
}

/// The triangles of a mesh that is yet to be made; zero where only making or reading it tells.
fn announced(mesh: &MeshSpec) -> f64 {
    let cells = |nx: usize, ny: usize| 2.0 * nx as f64 * ny as f64;
    match mesh {
        MeshSpec::Grid(g) => cells(g.nx, g.ny),
        MeshSpec::Jittered(g) => cells(g.nx, g.ny),
        MeshSpec::Quad(q) => cells(q.nx, q.ny),
        MeshSpec::Disc(d) => d.triangles as f64,
        MeshSpec::Cap(c) => c.triangles as f64,
        // As many layers of quads as a quarter of the points.
        MeshSpec::PlateWithHole(p) => cells(p.points, p.points / 4),
        MeshSpec::Inline(i) => i.triangles.len() as f64,
        // These generators bound what they make, and files have a largest size.
        MeshSpec::Lattice(_) | MeshSpec::Unstructured(_) | MeshSpec::File(_) => 0.0,
    }
}

/// Points of a body's curves and paths, which every copy has by itself.
fn points(spec: &BodySpec) -> f64 {
    let holds = spec.holds.iter().map(|hold| hold.curve.0.points().len());
    let point_loads = spec.point_loads.iter().map(|load| load.curve.0.points().len());
    let edge_loads = spec.edge_loads.iter().map(|load| load.curve.0.points().len());
    let pressure = spec.pressure.iter().map(|curve| curve.0.points().len());
    let compartment = spec.compartment.iter().flat_map(|own| [&own.inflow, &own.outside]);
    let compartment = compartment.map(|curve| curve.0.points().len());
    let curves: usize = holds.chain(point_loads).chain(edge_loads).chain(pressure).chain(compartment).sum();
    // An arc has a point for every degree at the most.
    let legs = spec.grips.iter().flat_map(|grip| &grip.path);
    let paths: f64 = legs.map(|leg| leg.arc.as_ref().map_or(1.0, |arc| arc.degrees.abs().max(1.0))).sum();
    curves as f64 + paths
}

/// The hand with which those of a table, read in order, have more points than a scene may have: a few words make a million each.
pub(super) fn hand_beyond(table: &DeTable<'_>, path: &str, points: &mut f64) -> Option<String> {
    let mut entries = table.iter().map(|(key, value)| (join(path, key.get_ref()), value.get_ref()));
    entries.find_map(|(path, value)| within(value, path, points))
}

fn within(value: &DeValue<'_>, path: String, points: &mut f64) -> Option<String> {
    if let (true, DeValue::Table(hand)) = (path.ends_with(".hand"), value) {
        // What is no number is refused where it is read.
        let time = |name: &str, default: f64| match hand.get(name).map(toml::Spanned::get_ref) {
            Some(DeValue::Float(time)) => time.as_str().parse().unwrap_or(0.0),
            Some(DeValue::Integer(time)) => i64::from_str_radix(time.as_str(), time.radix()).unwrap_or(0) as f64,
            _ => default,
        };
        // A hand that has too many by itself is refused with its own words; what is no number counts nothing.
        let count = time("duration", 0.0) / time("every", 1.0);
        *points += if count > 0.0 { count.min(1e6) } else { 0.0 };
        if *points > MOST_POINTS {
            return Some(path);
        }
    }
    children(value).into_iter().find_map(|(word, _, child)| within(child.get_ref(), join(&path, &word), points))
}

fn number(value: f64) -> String {
    if value < 1e9 { format!("{value:.0}") } else { format!("{value:.1e}") }
}

pub(super) fn bytes(count: f64) -> String {
    match count {
        _ if count >= 1e12 => format!("{:.0} TB", count * 1e-12),
        _ if count >= 1e9 => format!("{:.0} GB", count * 1e-9),
        _ if count >= 1e6 => format!("{:.0} MB", count * 1e-6),
        _ => format!("{:.0} kB", count * 1e-3),
    }
}
