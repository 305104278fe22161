//! What a scene holds, for a look before it is run.

use super::doctor::{MeshSummary, length};
use super::instance::{Run, thresholds};
use super::schema::Mode;
use super::size::{BYTES_PER_TRIANGLE, bytes};
use super::timed::CutTold;
use super::{Scene, SceneError};
use glam::DVec3;
use rhexis::components::{Body, EnergyCriterion, Holds, Refinement, Tearing, Toughness};
use rhexis::simulation::{Doubt, Simulation};
use rhexis::storage::{BodyId, Tips, Triangles, Vertices};
use std::fmt;

/// What a scene holds, for a look before it is run.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// The scene's name.
    pub name: String,
    /// How it is run.
    pub run: Run,
    /// Its bodies.
    pub bodies: Vec<BodySummary>,
    /// Number of obstacles.
    pub obstacle_count: usize,
    /// Likely slips, but for those that the scene allows.
    pub doubts: Vec<Doubt>,
    /// Contacts that could be and that the scene does not ask for.
    pub not_felt: Vec<String>,
    /// Notes on obstacles that tissue may not feel.
    pub obstacle_notes: Vec<String>,
    /// Cuts made before the first step.
    pub cuts: Vec<CutTold>,
}

/// One body of a [`Summary`].
#[derive(Clone, Debug, PartialEq)]
pub struct BodySummary {
    /// Its name.
    pub name: String,
    /// Number of vertices, after the starting cuts.
    pub vertex_count: usize,
    /// Number of triangles, after the starting cuts.
    pub triangle_count: usize,
    /// Least and greatest rest coordinates \[mm\].
    pub bounds: (DVec3, DVec3),
    /// Each hold with its number of vertices.
    pub holds: Vec<(String, usize)>,
    /// Number of tear tips.
    pub tip_count: usize,
    /// Of a body that can tear: its thresholds and the toughness that they imply.
    pub tearing: Option<(Tearing, Toughness)>,
    /// Toughness \[N/mm\] at which tips advance, where energy decides.
    pub energy: Option<Toughness>,
    /// What differs from triangle to triangle, in words.
    pub varying: Vec<String>,
    /// Expected edges per averaging radius: by the mesh, and by the refinement where there is one.
    pub edges_per_radius: Option<(f64, Option<f64>)>,
    /// Its mesh before any cut.
    pub mesh: MeshSummary,
}

impl Scene {
    /// Judges the scene without running it: reads its files, builds its meshes and bodies and makes its cuts.
    ///
    /// # Errors
    /// For everything that [`instantiate`](Self::instantiate) refuses.
    pub fn check(&self) -> Result<Summary, SceneError> {
        let instance = self.instantiate()?;
        let bodies = instance.bodies.iter().zip(&instance.meshes);
        let bodies = bodies.filter_map(|(&body, mesh)| summary(&instance.simulation, body, mesh));
        Ok(Summary {
            name: self.file.scene.name.clone(),
            run: instance.run,
            bodies: bodies.collect(),
            obstacle_count: self.file.obstacles.len(),
            doubts: instance.doubts,
            not_felt: instance.not_felt,
            obstacle_notes: instance.obstacle_notes,
            cuts: instance.cuts,
        })
    }
}

fn summary(simulation: &Simulation, body: BodyId, mesh: &MeshSummary) -> Option<BodySummary> {
    let world = simulation.world();
    let vertices = world.get::<&Vertices>(body.entity()).ok()?;
    let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let held = world.get::<&Holds>(body.entity());
    Some(BodySummary {
        name: world.get::<&Body>(body.entity()).ok()?.name.clone(),
        vertex_count: vertices.len(),
        triangle_count: world.get::<&Triangles>(body.entity()).ok()?.len(),
        bounds: vertices.rest_position.iter().fold(start, |(low, high), p| (low.min(*p), high.max(*p))),
        holds: held.map_or(Vec::new(), |h| h.groups.iter().map(|g| (g.name.clone(), g.members.rows().len())).collect()),
        tip_count: world.get::<&Tips>(body.entity()).map_or(0, |tips| tips.len()),
        tearing: thresholds(simulation, body),
        energy: world.get::<&EnergyCriterion>(body.entity()).ok().map(|energy| energy.toughness),
        varying: varying(
            &*world.get::<&Triangles>(body.entity()).ok()?,
            world.get::<&Tearing>(body.entity()).ok().as_deref(),
            world.get::<&EnergyCriterion>(body.entity()).ok().as_deref(),
        ),
        edges_per_radius: world.get::<&Tearing>(body.entity()).ok().map(|tearing| {
            let refined = world.get::<&Refinement>(body.entity()).ok().map(|refinement| refinement.edges_per_radius);
            (tearing.radius / mesh.mean_size, refined)
        }),
        mesh: mesh.clone(),
    })
}

/// What of the triangles differs, from the least to the greatest.
fn varying(triangles: &Triangles, tearing: Option<&Tearing>, energy: Option<&EnergyCriterion>) -> Vec<String> {
    let range = |what: &str, values: &mut dyn Iterator<Item = f64>, own: f64, unit: &str| {
        let [least, greatest] =
            values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)]);
        if least < greatest {
            return Some(format!("{what} {least:.3e} to {greatest:.3e}{unit}"));
        }
        (least != own && least.is_finite()).then(|| format!("{what} {least:.3e}{unit}"))
    };
    let strength = tearing.map_or(0.0, |tearing| tearing.strength_along_fibres);
    let toughness = energy.map_or(0.0, |energy| energy.toughness.along);
    let (factors, tough) = (triangles.strength.iter(), triangles.toughness.iter());
    let (strains, thick) = (|| triangles.pre_stretch.iter(), triangles.thickness.get(0).copied().unwrap_or(0.0));
    let besides = " beside the body's";
    let lists = [
        range("thickness", &mut triangles.thickness.iter().copied(), thick, " mm"),
        range("strength along the fibres", &mut factors.map(|factor| factor * strength), strength, " MPa"),
        range("toughness along the fibres", &mut tough.map(|factor| factor * toughness), toughness, " N/mm"),
        range("pre-stretch along the fibres", &mut strains().map(|strain| strain.xx), 0.0, besides),
        range("pre-stretch across the fibres", &mut strains().map(|strain| strain.yy), 0.0, besides),
    ];
    lists.into_iter().flatten().collect()
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Run { mode, dt, steps, .. } = self.run;
        let kind = if mode == Mode::Static { "static" } else { "dynamic" };
        write!(f, "{}: {kind}, {steps} steps of {dt} ms", self.name)?;
        if self.obstacle_count > 0 {
            write!(f, ", {} obstacle(s)", self.obstacle_count)?;
        }
        for cut in &self.cuts {
            write!(f, "\n  {cut}")?;
        }
        for doubt in &self.doubts {
            write!(f, "\n  note: {}", doubt.text)?;
        }
        for contact in &self.not_felt {
            write!(f, "\n  not felt: {contact}")?;
        }
        for note in &self.obstacle_notes {
            write!(f, "\n  note: {note}")?;
        }
        for body in &self.bodies {
            let (low, high) = body.bounds;
            let size = high - low;
            write!(
                f,
                "\n  {}: {} vertices, {} triangles, {} × {} × {} mm",
                body.name,
                body.vertex_count,
                body.triangle_count,
                rounded(size.x),
                rounded(size.y),
                rounded(size.z)
            )?;
            for (name, count) in &body.holds {
                write!(f, ", hold `{name}` on {count}")?;
            }
            if body.tip_count > 0 {
                write!(f, ", {} tear tip(s)", body.tip_count)?;
            }
            if let Some((t, toughness)) = &body.tearing {
                let (transverse, fibre) = (t.strength_along_fibres, t.strength_across_fibres);
                let Toughness { along, across } = toughness;
                let way = |way: &str, strength: f64, toughness: f64| match body.energy {
                    Some(_) => format!("{way} the fibres at {strength:.3e} MPa"),
                    None => format!("{way} the fibres at {strength:.3e} MPa or {toughness:.3e} N/mm"),
                };
                let [along, across] = [way("along", transverse, *along), way("across", fibre, *across)];
                let kind = if body.energy.is_some() { "starts" } else { "tears" };
                write!(f, "\n    {kind} {along}, {across}, over a radius of {} mm", rounded(t.radius))?;
                if let Some(Toughness { along, across }) = body.energy {
                    write!(
                        f,
                        "\n    tips advance by energy: along the fibres at {along:.3e} N/mm, across at {across:.3e} N/mm"
                    )?;
                }
            }
            if !body.varying.is_empty() {
                write!(f, "\n    per triangle: {}", body.varying.join(", "))?;
            }
            if let Some((edges, refined)) = body.edges_per_radius {
                write!(f, "\n    about {edges:.1} edges per radius")?;
                let _ = refined.map_or(Ok(()), |most| write!(f, ", refined to {:.1} at tips", most.max(edges)));
                if refined.unwrap_or(0.0).max(edges) < 3.0 {
                    write!(f, ": figures want 3 or more; refine, or take a finer mesh")?;
                }
            }
            write!(f, "\n    {}", body.mesh)?;
        }
        let triangles: usize = self.bodies.iter().map(|body| body.triangle_count).sum();
        write!(f, "\n  about {} of memory; {}", bytes(triangles as f64 * BYTES_PER_TRIANGLE), work(triangles))?;
        Ok(())
    }
}

/// What a step costs beside the triangles it solves for (docs/performance.md): packs and a factor are as much as eleven iterations of
/// 11 ns per triangle, of which a step takes 10 to 100.
fn work(triangles: usize) -> String {
    let of = |iterations: f64| length(1.1e-5 * triangles as f64 * iterations);
    format!("a step is the work of 20 to 110 iterations, {} to {} ms on one thread of a desktop", of(20.0), of(110.0))
}

/// Thousandths of a millimetre, or four digits of what is shorter than one.
fn rounded(value: f64) -> String {
    if value.abs() < 1.0 { length(value) } else { ((value * 1e3).round() / 1e3).to_string() }
}
