//! Sheets with one straight crack under a small load, on three patterns of mesh, and what the criterion sees at their tips.
//!
//! At small strain everything is proportional to the load, so one linear solve tells the load at which a tear begins.

use super::super::VerifyError;
use super::super::bodies::{self, Linear};
use glam::{DVec2, DVec3};
use rhexis::components::{
    Curve, DecidedBy, EdgeLoad, EdgeLoads, EnergyCriterion, Fibres, Material, Refinement, TearDecision, Tearing,
    Toughness,
};
use rhexis::math::Sym2;
use rhexis::membrane::Membrane;
use rhexis::settings::{Advanced, Preconditioner, Settings};
use rhexis::simulation::{Simulation, SimulationError};
use rhexis::storage::{BodyId, Tips, Topology, TriangleMesh, Triangles, Vertices};
use rhexis::systems::fracture::{EnergyTerms, Surface, TipMemory, energy_decision, tip_decision};
use rhexis_scene::generate::{self, GenerateError};

/// How a mesh is laid out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Pattern {
    /// Cells of two triangles with alternating diagonals.
    Structured,
    /// The same with inner vertices moved at random.
    Jittered,
    /// No order at all.
    Unstructured,
}

impl Pattern {
    /// All of them.
    pub(super) const ALL: [Self; 3] = [Self::Structured, Self::Jittered, Self::Unstructured];

    /// For tables.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Structured => "structured",
            Self::Jittered => "jittered",
            Self::Unstructured => "unstructured",
        }
    }

    /// The rectangle from the origin to `size` \[mm\] in triangles as large as equilateral ones with sides of at most `edge`
    /// \[mm\], which is how the engine counts edges per averaging radius.
    ///
    /// # Errors
    /// For sizes that are no lengths, and too many triangles.
    pub(super) fn mesh(self, size: DVec2, edge: f64) -> Result<TriangleMesh, GenerateError> {
        // Half a square cell with this side has the area of the equilateral triangle.
        let cell = edge * (0.75_f64.sqrt()).sqrt();
        // Even numbers, so that a line of edges runs along the middle.
        let [nx, ny] = (size / cell).to_array().map(|cells| 2 * (0.5 * cells).ceil() as usize);
        match self {
            Self::Structured => generate::grid(size.x, size.y, nx, ny),
            Self::Jittered => generate::jittered(size.x, size.y, nx, ny, 1),
            Self::Unstructured => {
                let corners = [DVec2::ZERO, DVec2::new(size.x, 0.0), size, DVec2::new(0.0, size.y)];
                // Relaxed points leave triangles a little larger than asked for.
                generate::unstructured(&corners, UNSTRUCTURED * edge, 1)
            }
        }
    }
}

/// Part of the edge to ask of unstructured meshes for that edge: triangles come out larger by up to 1 %.
const UNSTRUCTURED: f64 = 0.99;

/// What is torn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tissue {
    /// Elastic constants and thickness.
    pub material: Material,
    /// Fibre angle from x \[°\].
    pub fibre_degrees: f64,
    /// Strengths and averaging radius.
    pub tearing: Tearing,
}

/// One toughness in all directions \[N/mm\].
pub(super) fn even(toughness: f64) -> Toughness {
    Toughness { along: toughness, across: toughness }
}

impl Tissue {
    /// An isotropic one, 3 MPa, 0.1 mm thick, which breaks at `strength` \[MPa\] averaged over `radius` \[mm\].
    pub(super) fn isotropic(strength: f64, radius: f64) -> Self {
        let tearing =
            Tearing { strength_across_fibres: strength, strength_along_fibres: strength, radius, ..Tearing::default() };
        Self { material: Material::isotropic(3.0, 0.3, 0.1), fibre_degrees: 0.0, tearing }
    }

    /// A body of it on a mesh, kept in its plane.
    pub(super) fn membrane(&self, mesh: TriangleMesh) -> Membrane {
        let membrane = Membrane::new("sheet", mesh, self.material).planar();
        membrane.fibres(Fibres::at_degrees(self.fibre_degrees)).with(self.tearing)
    }
}

/// Two opposite sides of a square clamped in grips that have moved apart: x = 0 by −`u` and x = `side` by `u` \[mm\].
pub(super) fn between_grips(membrane: Membrane, side: f64, u: f64) -> Membrane {
    let grip =
        |name: &str, at: f64, by: f64| bodies::hold(&membrane, name, move |p| (p.x == at).then_some(DVec3::X * by));
    let (left, right) = (grip("left", 0.0, -u), grip("right", side, u));
    membrane.hold(left).hold(right)
}

/// A rectangle from the origin to `size` \[mm\] under even tension along y, `stress` \[MPa\] in tissue of `thickness` \[mm\]. Its
/// feet are held as statics needs, without a reaction.
pub(super) fn under_tension(membrane: Membrane, size: DVec2, stress: f64, thickness: f64) -> Membrane {
    let side = |y: f64| {
        let mut rows = membrane.select(|p| p.y == y);
        let x = |row: &u32| membrane.mesh().positions[*row as usize].x;
        rows.sort_by(|a, b| x(a).total_cmp(&x(b)));
        rows.windows(2).map(|w| [w[0], w[1]]).collect::<Vec<[u32; 2]>>()
    };
    let pull = |y: f64, way: DVec3| EdgeLoad {
        edges: side(y),
        traction: way * (stress * thickness),
        curve: Curve::constant(1.0),
    };
    let groups = vec![pull(0.0, DVec3::NEG_Y), pull(size.y, DVec3::Y)];
    let still = Curve::constant(0.0);
    let foot = |name: &str, x: f64, axes: [bool; 3]| {
        bodies::hold_along(&membrane, name, axes, still.clone(), move |p| {
            (p.x == x && p.y == 0.0).then_some(DVec3::ZERO)
        })
    };
    let feet = [foot("left foot", 0.0, [true, true, false]), foot("right foot", size.x, [false, true, false])];
    feet.into_iter().fold(membrane, Membrane::hold).with(EdgeLoads { groups })
}

/// Refinement to so many edges per averaging radius, up to `margin` \[mm\] beyond it, of as many triangles as that takes.
pub(super) fn refined(edges_per_radius: f64, margin: f64) -> Refinement {
    Refinement { edges_per_radius, margin: Some(margin), budget: 100.0, ..Refinement::default() }
}

/// A tip as the criterion sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tip {
    /// Where it is \[mm\].
    pub at: DVec2,
    /// Unit direction in which the crack has come.
    pub ahead: DVec2,
    /// Mean stress over the disc, in x and y \[MPa\].
    pub stress: Sym2,
    /// Direction of the largest criterion.
    pub direction: DVec2,
    /// The criterion there.
    pub value: f64,
    /// Averaging radius over the mean edge in the disc.
    pub edges_per_radius: f64,
    /// The direction that the criterion on energy chooses, and its value; `None` where it leaves the decision to the stress.
    pub by_energy: Option<(DVec2, f64)>,
    /// Energy released per area of a crack that goes straight on \[N/mm\], from the ring; no number where it tells none.
    pub release: f64,
    /// The same by the material force, whose disc needs no field.
    pub by_force: f64,
}

impl Tip {
    fn new(at: DVec3, ahead: DVec3, decision: &TearDecision, energy: &TearDecision) -> Self {
        let axis = |a: DVec3| DVec2::new(a.dot(decision.axes[0]), a.dot(decision.axes[1]));
        Self {
            at: at.truncate(),
            ahead: ahead.truncate(),
            stress: decision.stress.in_axes(axis(DVec3::X), axis(DVec3::Y)),
            direction: decision.direction.truncate(),
            value: decision.value,
            edges_per_radius: decision.edges_per_radius,
            by_energy: (energy.by == DecidedBy::Energy).then(|| (energy.direction.truncate(), energy.value)),
            release: f64::NAN,
            by_force: f64::NAN,
        }
    }

    /// Angle \[°\] by which the criterion turns from the crack's direction, counter-clockwise.
    pub(super) fn kink(&self) -> f64 {
        self.ahead.angle_to(self.direction).to_degrees()
    }

    /// The same by energy; no number where there is none.
    pub(super) fn kink_by_energy(&self) -> f64 {
        self.by_energy.map_or(f64::NAN, |(direction, _)| self.ahead.angle_to(direction).to_degrees())
    }
}

/// A sheet with a crack.
pub(super) struct Cracked {
    /// The simulation.
    pub simulation: Simulation,
    /// Its only body.
    pub body: BodyId,
}

impl Cracked {
    /// Cuts a crack from the first point to the second \[mm\]; a first point on the rim makes a notch, else it has two tips.
    ///
    /// # Errors
    /// If the body or the cut is refused.
    pub(super) fn new(membrane: Membrane, crack: [DVec2; 2]) -> Result<Self, VerifyError> {
        let settings = Settings {
            threads: 1,
            advanced: Advanced { preconditioner: Preconditioner::Cholesky, ..Advanced::default() },
            ..Settings::default()
        };
        let (mut simulation, body) = bodies::simulate(settings, membrane)?;
        simulation.cut(body, &crack.map(|p| p.extend(0.0)))?;
        Ok(Self { simulation, body })
    }

    /// Answers the load linearly.
    ///
    /// # Errors
    /// Where the solve fails.
    pub(super) fn solve(&mut self) -> Result<Linear, VerifyError> {
        bodies::linear(&mut self.simulation, self.body)
    }

    /// What the criteria see at the tips now, that on energy with this toughness.
    ///
    /// # Errors
    /// If there is no such body.
    pub(super) fn tips(&self, toughness: Toughness) -> Result<Vec<Tip>, VerifyError> {
        type Query<'a> = ((&'a Vertices, &'a Triangles, &'a Topology), (&'a Tips, &'a Tearing));
        let mut query = self.simulation.world().query_one::<Query>(self.body.entity());
        let ((vertices, triangles, topology), (tips, tearing)) =
            query.get().map_err(|_| SimulationError::NoSuchBody)?;
        let surface = Surface {
            vertices,
            triangles,
            topology,
            is_planar: true,
            unstretched: Sym2::IDENTITY,
            fibres: None,
            bending: None,
        };
        let (energy, mut memory) = (EnergyCriterion::new(toughness), TipMemory::default());
        let seen = (0..tips.len()).filter_map(|tip| {
            let (vertex, previous) = (tips.vertex[tip], tips.previous[tip]);
            let decision = tip_decision(&surface, tearing, tip, (vertex, previous), &mut memory)?;
            let terms = EnergyTerms { tearing, energy: &energy };
            let (by_energy, _) = energy_decision(&surface, terms, tip, (vertex, previous), &mut memory)?;
            let field = terms.crack_field(&surface, (tip, vertex), &mut memory);
            let release = field.map_or(f64::NAN, |field| field.release());
            let by_force = terms
                .material_force(&surface, (tip, vertex), &mut memory)
                .map_or(f64::NAN, |([x, y], force)| force.release.dot(DVec2::new(previous.dot(x), previous.dot(y))));
            let at = vertices.rest_position[vertex as usize];
            Some(Tip { release, by_force, ..Tip::new(at, previous, &decision, &by_energy) })
        });
        Ok(seen.collect())
    }
}
