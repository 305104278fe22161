//! A body before it is spawned: mesh, material, fibres and whatever else it carries.

use crate::components::{
    Bending, Body, Contact, Drag, EnergyCriterion, ExternalStiffness, Fibres, Forces, Frames, Grips, Hold, Holds,
    HolzapfelGasserOgden, Increment, Material, Planar, PreStretch, Reactions, Refined, Refinement, Sleeping,
    SolverScratch, Springs, StiffeningFibres, TearDecisions, TearLog, Tearing,
};
use crate::math::{InadmissibleMaterial, RestTriangle, Sym2};
use crate::storage::{
    Broken, Mesh, MeshError, Tips, Topology, TriangleMesh, TriangleRow, Triangles, VertexRow, Vertices, measure,
};
use crate::systems::linear::{Factor, Folds, InnerSolver};
use crate::systems::tearing::{TearScratch, TipMemory};
use glam::DVec3;
use hecs::EntityBuilder;

/// Why a body is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BodyError {
    /// The mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The mesh, found while its topology was built.
    #[error("the mesh is not an oriented surface: {0}")]
    Topology(#[from] Broken),
    /// The material of a triangle.
    #[error("triangle {triangle}: {source}")]
    Material {
        /// The triangle's index.
        triangle: usize,
        /// What is wrong.
        source: InadmissibleMaterial,
    },
    /// A number outside its range.
    #[error("{what} is {value:?}: {must}")]
    OutOfRange {
        /// Which number.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        must: &'static str,
    },
    /// Refinement around the tips of a body that has none.
    #[error("refinement goes with tear tips and their averaging radius: let the body tear, or leave refinement out")]
    RefinementWithoutTearing,
    /// A criterion on energy for a body that does not tear.
    #[error("the energy criterion decides at tear tips: let the body tear, or leave it out")]
    EnergyCriterionWithoutTearing,
    /// Two laws of the fibres.
    #[error("fibres have one law: leave `StiffeningFibres` or `HolzapfelGasserOgden` out")]
    TwoFibreLaws,
    /// A neo-Hookean matrix with elastic constants of another law, in the triangle with this index.
    #[error("triangle {0}: a neo-Hookean matrix goes with the material that `Material::neo_hookean` gives")]
    NotNeoHookean(usize),
    /// Bending of a body that stays in its plane.
    #[error("a planar body does not bend: let it leave its plane, or leave bending out")]
    BendingInPlane,
    /// A fibre list of the wrong length.
    #[error("{given} fibre directions for {needed} triangles: give one per triangle, in the mesh's order")]
    FibreCount {
        /// Directions given.
        given: usize,
        /// Triangles.
        needed: usize,
    },
    /// A vertex row that does not exist.
    #[error("{what} names vertex {row}, but the mesh has {count} vertices")]
    NoSuchVertex {
        /// Who names it.
        what: String,
        /// The row.
        row: u32,
        /// Number of vertices.
        count: usize,
    },
    /// Two holds prescribe the same axis of the same vertex.
    #[error("holds `{first}` and `{second}` both prescribe axis {axis} of vertex {row}: let one of them go")]
    ContradictoryHolds {
        /// Name of the first hold.
        first: String,
        /// Name of the second hold.
        second: String,
        /// x, y or z.
        axis: char,
        /// The vertex.
        row: u32,
    },
}

/// A body to be spawned.
pub struct Membrane {
    name: String,
    mesh: TriangleMesh,
    material: Box<dyn Fn(DVec3) -> Material + Send + Sync>,
    fibres: Option<Fibres>,
    holds: Vec<Hold>,
    components: EntityBuilder,
}

impl Membrane {
    /// A membrane of one material. Its fibres are the mesh's own, or run along x where it has none, until
    /// [`fibres`](Self::fibres) says otherwise.
    pub fn new(name: impl Into<String>, mesh: TriangleMesh, material: Material) -> Self {
        Self {
            name: name.into(),
            mesh,
            material: Box::new(move |_| material),
            fibres: None,
            holds: Vec::new(),
            components: EntityBuilder::new(),
        }
    }

    /// A material that varies with the rest position \[mm\] of a triangle's centroid.
    #[must_use]
    pub fn graded(mut self, material: impl Fn(DVec3) -> Material + Send + Sync + 'static) -> Self {
        self.material = Box::new(material);
        self
    }

    /// Sets the fibres.
    #[must_use]
    pub fn fibres(mut self, fibres: Fibres) -> Self {
        self.fibres = Some(fibres);
        self
    }

    /// Keeps the body in the plane z = const.
    #[must_use]
    pub fn planar(self) -> Self {
        self.with(Planar)
    }

    /// Prescribes vertices.
    #[must_use]
    pub fn hold(mut self, hold: Hold) -> Self {
        self.holds.push(hold);
        self
    }

    /// Adds any component: loads, springs, damping, tearing, or one of your own.
    #[must_use]
    pub fn with(mut self, component: impl hecs::Component) -> Self {
        self.components.add(component);
        self
    }

    /// Indices of the vertices whose rest position fulfils a condition.
    pub fn select(&self, condition: impl Fn(DVec3) -> bool) -> Vec<u32> {
        let positions = self.mesh.positions.iter().enumerate();
        positions.filter(|(_, p)| condition(**p)).map(|(i, _)| i as u32).collect()
    }

    /// The mesh.
    pub fn mesh(&self) -> &TriangleMesh {
        &self.mesh
    }

    /// All components of the body, checked.
    pub(crate) fn build(mut self, order: u32) -> Result<EntityBuilder, BodyError> {
        self.mesh.check()?;
        check_holds(&self.holds, self.mesh.positions.len())?;
        self.check_components()?;
        let mut triangles = self.triangle_rows()?;
        if self.components.get::<&HolzapfelGasserOgden>().is_some_and(HolzapfelGasserOgden::replaces_linear) {
            let other = triangles.stiffness.iter().position(|law| !law.is_neo_hookean());
            other.map_or(Ok(()), |triangle| Err(BodyError::NotNeoHookean(triangle)))?;
        }
        let [vertex_room, triangle_room] = self.room();
        let mut vertices = Vertices::default();
        vertices.reserve(self.mesh.positions.len() + vertex_room);
        for &position in &self.mesh.positions {
            vertices.push(VertexRow { position, velocity: DVec3::ZERO, rest_position: position, mass: 0.0 });
        }
        let mut topology = Topology::new(vertices.len(), &self.mesh.triangles)?;
        let mut mesh = Mesh { vertices: &mut vertices, triangles: &mut triangles, topology: &mut topology };
        measure::rest_data(&mut mesh)?;

        topology.reserve(vertex_room, triangle_room);
        let start_count = triangles.len();
        let c = &mut self.components;
        c.add(Body { name: self.name, order });
        c.add_bundle((vertices, triangles, topology));
        c.add_bundle((
            Frames::default(),
            Forces::default(),
            Increment::default(),
            SolverScratch::default(),
            Factor::default(),
            InnerSolver::default(),
        ));
        c.add_bundle((TearLog::default(), TearScratch::default()));
        if !self.holds.is_empty() {
            c.add_bundle((Holds { groups: self.holds }, Reactions::default()));
        }
        if c.has::<Tearing>() {
            c.add_bundle((Tips::default(), TearDecisions::default(), TipMemory::default()));
        }
        if c.has::<Refinement>() {
            c.add(Refined { start_count, ..Refined::default() });
        }
        if c.has::<Bending>() {
            c.add(Folds::default());
        }
        if c.has::<Springs>() || c.has::<Grips>() || c.has::<Drag>() || c.has::<Contact>() {
            c.add(ExternalStiffness::default());
        }
        Ok(self.components)
    }

    /// Vertices and triangles that steps may add and for which there is room from the start. A refinement's budget counts within
    /// reason: it is no promise that all of it is used.
    fn room(&self) -> [usize; 2] {
        let counts = [self.mesh.positions.len(), self.mesh.triangles.len()];
        let of_tears = if self.components.has::<Tearing>() { counts.map(spare) } else { [0; 2] };
        let of_refinement = self.components.get::<&Refinement>().map_or(0, |refinement| {
            let most = refinement.most_added(counts[1]);
            (most.max(0) as usize).min(counts[1])
        });
        [of_tears[0].max(of_refinement.div_ceil(2)), of_tears[1].max(of_refinement)]
    }

    fn triangle_rows(&self) -> Result<Triangles, BodyError> {
        let needed = self.mesh.triangles.len();
        if let Some(Fibres::PerTriangle(list)) = &self.fibres
            && list.len() != needed
        {
            return Err(BodyError::FibreCount { given: list.len(), needed });
        }
        let mut triangles = Triangles::default();
        triangles.reserve(needed + self.room()[1]);
        for (t, &corners) in self.mesh.triangles.iter().enumerate() {
            let x = corners.map(|v| self.mesh.positions[v as usize]);
            let centroid = (x[0] + x[1] + x[2]) / 3.0;
            let material = (self.material)(centroid);
            positive("thickness", material.thickness)?;
            positive("density", material.density)?;
            let stiffness = material.stiffness().map_err(|source| BodyError::Material { triangle: t, source })?;
            let direction = match (&self.fibres, &self.mesh.fibres) {
                (Some(fibres), _) => fibres.direction(t, centroid),
                (None, Some(list)) => list[t],
                (None, None) => DVec3::X,
            };
            let normal = (x[1] - x[0]).cross(x[2] - x[0]).normalize_or_zero();
            let fibre = RestTriangle::axis(normal, direction, x[1] - x[0]);
            let rest = RestTriangle::new(x, fibre).ok_or(Broken::RestArea { triangle: t as u32 })?;
            let Material { thickness, density, .. } = material;
            enough_mass("the mass of a triangle in g", thickness * density * rest.area)?;
            triangles.push(TriangleRow { corners, rest, fibre, stiffness, thickness, density });
        }
        Ok(triangles)
    }

    /// Components whose parameters are to be judged, of a body with these vertices.
    #[cfg(feature = "snapshot")]
    pub(crate) fn of_components(name: String, positions: Vec<DVec3>, components: EntityBuilder) -> Self {
        let mesh = TriangleMesh { positions, ..TriangleMesh::default() };
        Self { components, ..Self::new(name, mesh, Material::figure_2()) }
    }

    /// Judges the numbers of the components.
    pub(crate) fn check_components(&self) -> Result<(), BodyError> {
        if let Some(t) = self.components.get::<&Tearing>() {
            positive("strength_fibre", t.strength_fibre)?;
            positive("strength_transverse", t.strength_transverse)?;
            positive("exponent", t.exponent)?;
            positive("cone", t.cone)?;
            positive("radius", t.radius)?;
            positive("max_tear_speed", t.max_tear_speed)?;
        }
        if let Some(r) = self.components.get::<&Refinement>() {
            if !self.components.has::<Tearing>() {
                return Err(BodyError::RefinementWithoutTearing);
            }
            let (edges, budget) = (r.edges_per_radius, r.budget);
            within("refinement edges_per_radius", edges, edges > 0.0, "it must be above 0 and at most 100")?;
            within("refinement budget", budget, budget >= 1.0, "it must be from 1 to 100")?;
            r.margin.map_or(Ok(()), |margin| not_negative("refinement margin", margin))?;
        }
        if let Some(e) = self.components.get::<&EnergyCriterion>() {
            if !self.components.has::<Tearing>() {
                return Err(BodyError::EnergyCriterionWithoutTearing);
            }
            positive("toughness along the fibres", e.toughness.along)?;
            positive("toughness across the fibres", e.toughness.across)?;
            within("energy criterion ring", e.ring, e.ring > 0.0, "it must be above 0 and at most 100")?;
        }
        if let Some(fibres) = self.components.get::<&StiffeningFibres>() {
            fibres.check().map_err(|(what, value, must)| BodyError::OutOfRange { what, value, must })?;
        }
        if let Some(law) = self.components.get::<&HolzapfelGasserOgden>() {
            if self.components.has::<StiffeningFibres>() {
                return Err(BodyError::TwoFibreLaws);
            }
            let held = self.components.get::<&PreStretch>().map_or(Sym2::ZERO, |p| p.strain);
            law.check(held).map_err(|(what, value, must)| BodyError::OutOfRange { what, value, must })?;
        }
        if let Some(b) = self.components.get::<&Bending>() {
            if self.components.has::<Planar>() {
                return Err(BodyError::BendingInPlane);
            }
            b.stiffness.map_or(Ok(()), |d| positive("bending stiffness", d))?;
        }
        if let Some(s) = self.components.get::<&Sleeping>() {
            positive("the strain of sleep", s.strain)?;
        }
        if let Some(c) = self.components.get::<&Contact>() {
            c.stiffness.map_or(Ok(()), |stiffness| positive("contact stiffness", stiffness))?;
            not_negative("contact friction", c.friction)?;
        }
        if let Some(d) = self.components.get::<&Drag>() {
            not_negative("drag coefficient", d.coefficient)?;
        }
        if let Some(d) = self.components.get::<&crate::components::Damping>() {
            not_negative("damping time", d.time)?;
        }
        if let Some(springs) = self.components.get::<&Springs>() {
            check_rows("springs", springs.anchors.rows(), self.mesh.positions.len())?;
            springs.anchors.values().iter().try_for_each(|a| not_negative("spring stiffness", a.stiffness))?;
        }
        if let Some(grips) = self.components.get::<&Grips>() {
            for grip in &grips.list {
                grip.jaws.check().map_err(|(what, value, must)| BodyError::OutOfRange { what, value, must })?;
            }
        }
        Ok(())
    }
}

/// Least mass of a triangle \[g\]: sums and fractions of it keep all their digits.
const LEAST_MASS: f64 = 1e-290;

fn positive(what: &'static str, value: f64) -> Result<(), BodyError> {
    let is_right = value > 0.0 && value.is_finite();
    is_right.then_some(()).ok_or(BodyError::OutOfRange { what, value, must: "it must be positive and finite" })
}

/// Splits share masses out: what is near the least number would lose digits, or all of itself.
fn enough_mass(what: &'static str, value: f64) -> Result<(), BodyError> {
    let is_right = value >= LEAST_MASS && value.is_finite();
    is_right.then_some(()).ok_or(BodyError::OutOfRange { what, value, must: "it must be at least 1e-290, and finite" })
}

fn not_negative(what: &'static str, value: f64) -> Result<(), BodyError> {
    let is_right = value >= 0.0 && value.is_finite();
    is_right.then_some(()).ok_or(BodyError::OutOfRange { what, value, must: "it must be zero or more, and finite" })
}

/// At most 100, beside its own lower bound.
fn within(what: &'static str, value: f64, is_enough: bool, must: &'static str) -> Result<(), BodyError> {
    (is_enough && value <= 100.0).then_some(()).ok_or(BodyError::OutOfRange { what, value, must })
}

fn check_rows(what: &str, rows: &[u32], count: usize) -> Result<(), BodyError> {
    match rows.iter().find(|&&row| row as usize >= count) {
        Some(&row) => Err(BodyError::NoSuchVertex { what: what.to_owned(), row, count }),
        None => Ok(()),
    }
}

/// Rows to spare for tears among so many.
fn spare(count: usize) -> usize {
    256 + count / 16
}

/// Makes room for tears: the first of them is not to wait while whole columns move.
pub(crate) fn make_room(mesh: Mesh<'_>) {
    let (vertices, triangles) = (spare(mesh.vertices.len()), spare(mesh.triangles.len()));
    mesh.vertices.reserve(vertices);
    mesh.triangles.reserve(triangles);
    mesh.topology.reserve(vertices, triangles);
}

fn check_holds(holds: &[Hold], count: usize) -> Result<(), BodyError> {
    let mut holder: Vec<[Option<usize>; 3]> = vec![[None; 3]; count];
    for (h, hold) in holds.iter().enumerate() {
        check_rows(&format!("hold `{}`", hold.name), hold.members.rows(), count)?;
        for &row in hold.members.rows() {
            for axis in (0..3).filter(|&axis| hold.axes[axis]) {
                if let Some(first) = holder[row as usize][axis].replace(h) {
                    return Err(BodyError::ContradictoryHolds {
                        first: holds[first].name.clone(),
                        second: hold.name.clone(),
                        axis: ['x', 'y', 'z'][axis],
                        row,
                    });
                }
            }
        }
    }
    Ok(())
}
