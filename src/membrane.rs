//! A body before it is spawned: mesh, material, fibres and whatever else it carries.

#[doc(hidden)]
pub use crate::components::BodyError;
use crate::components::check::{Check, Host, number, positive};
use crate::components::{
    Bending, Body, Fibres, Hold, Holds, HolzapfelGasserOgden, Material, Planar, Refinement, Tearing,
};
use crate::math::{Orthotropic, RestTriangle, Sym2, is_direction};
use crate::registry::{check_changed, complete};
use crate::storage::{
    Broken, Mesh, MeshError, Topology, TriangleMesh, TriangleRow, Triangles, VertexRow, Vertices, measure,
};
use glam::DVec3;
use hecs::{EntityBuilder, EntityBuilderClone};
use std::sync::Arc;

/// Parameters that vary by triangle.
#[derive(Clone, Default)]
struct PerTriangle {
    material: Option<Vec<Material>>,
    thickness: Option<Vec<f64>>,
    strength: Option<Vec<f64>>,
    toughness: Option<Vec<f64>>,
    pre_stretch: Option<Vec<Sym2>>,
}

impl PerTriangle {
    fn check(&self, needed: usize) -> Result<(), BodyError> {
        let Self { material, thickness, strength, toughness, pre_stretch } = self;
        let lengths = [
            ("materials", material.as_ref().map(Vec::len)),
            ("thicknesses", thickness.as_ref().map(Vec::len)),
            ("strengths", strength.as_ref().map(Vec::len)),
            ("toughnesses", toughness.as_ref().map(Vec::len)),
            ("pre-stretches", pre_stretch.as_ref().map(Vec::len)),
        ];
        lengths.into_iter().try_for_each(|(what, given)| match given {
            Some(given) if given != needed => Err(BodyError::ValueCount { what, given, needed }),
            _ => Ok(()),
        })
    }
}

/// The value of a triangle where there is a list, else the default.
fn own<T: Copy>(list: &Option<Vec<T>>, triangle: usize, default: T) -> T {
    list.as_ref().and_then(|list| list.get(triangle)).copied().unwrap_or(default)
}

/// A body to be spawned. A clone of it is spawned as another body.
#[derive(Clone)]
pub struct Membrane {
    pub(crate) name: String,
    mesh: TriangleMesh,
    material: Arc<dyn Fn(DVec3) -> Material + Send + Sync>,
    fibres: Option<Fibres>,
    per_triangle: PerTriangle,
    holds: Vec<Hold>,
    components: EntityBuilderClone,
}

impl Membrane {
    /// A membrane of one material. Its fibres are the mesh's own, or run along x where it has none, until
    /// [`fibres`](Self::fibres) says otherwise.
    ///
    /// # Examples
    /// ```
    /// use rhexis::prelude::*;
    ///
    /// let sheet = Membrane::new("sheet", generate::grid(10.0, 10.0, 8, 8)?, Material::allard_2009());
    /// sheet.validate()?;
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn new(name: impl Into<String>, mesh: TriangleMesh, material: Material) -> Self {
        Self {
            name: name.into(),
            mesh,
            material: Arc::new(move |_| material),
            fibres: None,
            per_triangle: PerTriangle::default(),
            holds: Vec::new(),
            components: EntityBuilderClone::new(),
        }
    }

    /// A material that varies with the rest position \[mm\] of a triangle's centroid.
    #[must_use]
    pub fn graded(mut self, material: impl Fn(DVec3) -> Material + Send + Sync + 'static) -> Self {
        self.material = Arc::new(material);
        self
    }

    /// Sets the fibres.
    ///
    /// # Examples
    /// ```
    /// # use rhexis::prelude::*;
    /// # let sheet = Membrane::new("sheet", generate::grid(10.0, 10.0, 8, 8)?, Material::allard_2009());
    /// let sheet = sheet.fibres(Fibres::at_degrees(45.0));
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    #[must_use]
    pub fn fibres(mut self, fibres: Fibres) -> Self {
        self.fibres = Some(fibres);
        self
    }

    /// Sets the material of each triangle, in the mesh's order.
    ///
    /// # Examples
    /// ```
    /// use rhexis::prelude::*;
    ///
    /// let mesh = generate::grid(10.0, 10.0, 8, 8)?;
    /// let (soft, stiff) = (Material::isotropic(1.0, 0.45, 0.1), Material::isotropic(20.0, 0.45, 0.1));
    /// let is_left = |corners: &[u32; 3]| corners.iter().all(|&v| mesh.positions[v as usize].x <= 5.0);
    /// let materials = mesh.triangles.iter().map(|corners| if is_left(corners) { soft } else { stiff }).collect();
    /// let sheet = Membrane::new("sheet", mesh, soft).materials(materials);
    /// sheet.validate()?;
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    #[must_use]
    pub fn materials(mut self, list: Vec<Material>) -> Self {
        self.per_triangle.material = Some(list);
        self
    }

    /// Sets the thickness \[mm\] of each triangle, in the mesh's order, in place of the material's.
    #[must_use]
    pub fn thicknesses(mut self, list: Vec<f64>) -> Self {
        self.per_triangle.thickness = Some(list);
        self
    }

    /// Sets the strengths of each triangle over those of [`Tearing`], > 0, in the mesh's order: a seam at 0.2 tears at a fifth.
    #[must_use]
    pub fn strengths(mut self, list: Vec<f64>) -> Self {
        self.per_triangle.strength = Some(list);
        self
    }

    /// Sets the toughnesses of each triangle over those of [`EnergyCriterion`](crate::components::EnergyCriterion), > 0, in the mesh's
    /// order.
    #[must_use]
    pub fn toughnesses(mut self, list: Vec<f64>) -> Self {
        self.per_triangle.toughness = Some(list);
        self
    }

    /// Sets a pre-stretch of each triangle beside [`PreStretch`](crate::components::PreStretch), in the axes (fibre, transverse), in the
    /// mesh's order.
    #[must_use]
    pub fn pre_stretches(mut self, list: Vec<Sym2>) -> Self {
        self.per_triangle.pre_stretch = Some(list);
        self
    }

    /// Keeps the body in the plane z = const.
    #[must_use]
    pub fn planar(self) -> Self {
        self.with(Planar)
    }

    /// Prescribes vertices.
    ///
    /// # Examples
    /// ```
    /// # use rhexis::prelude::*;
    /// # let sheet = Membrane::new("sheet", generate::grid(10.0, 10.0, 8, 8)?, Material::allard_2009());
    /// let rim = Attached::new(sheet.select(|p| p.x == 0.0).into_iter().map(|vertex| (vertex, DVec3::ZERO)));
    /// let curve = Curve::constant(1.0);
    /// let sheet = sheet.hold(Hold { name: "rim".into(), members: rim, axes: [true; 3], curve });
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    #[must_use]
    pub fn hold(mut self, hold: Hold) -> Self {
        self.holds.push(hold);
        self
    }

    /// Adds any component: loads, springs, damping, tearing, or one of your own. One that cannot be cloned is put in after spawning, by
    /// [`world_mut`](crate::simulation::Simulation::world_mut).
    ///
    /// # Examples
    /// ```
    /// # use rhexis::prelude::*;
    /// # let sheet = Membrane::new("sheet", generate::grid(10.0, 10.0, 8, 8)?, Material::allard_2009());
    /// let sheet = sheet.with(Tearing::default()).with(Bending { stiffness: None }).with(Damping { time: 1.0 });
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    #[must_use]
    pub fn with(mut self, component: impl hecs::Component + Clone) -> Self {
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

    /// Checks mesh, material and components as [`spawn`](crate::simulation::Simulation::spawn) does.
    ///
    /// # Errors
    /// Names the rejected parameter and the range it must lie in.
    pub fn validate(&self) -> Result<(), BodyError> {
        self.clone().build(0).map(|_| ())
    }

    /// All components of the body, checked.
    pub(crate) fn build(mut self, order: u32) -> Result<EntityBuilder, BodyError> {
        self.mesh.check()?;
        let mut triangles = self.triangle_rows()?;
        check_neo_hookean(self.components.get::<&HolzapfelGasserOgden>(), &triangles)?;
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
        if let Some(bending) = self.components.get::<&Bending>() {
            check_bending(bending, &triangles)?;
        }
        let mut entity = EntityBuilder::new();
        entity.add_bundle(&self.components.build());
        let c = &mut entity;
        c.add(Body { name: self.name, order });
        c.add_bundle((vertices, triangles, topology));
        if !self.holds.is_empty() {
            let mut groups = c.get::<&Holds>().map_or(Vec::new(), |holds| holds.groups.clone());
            groups.append(&mut self.holds);
            c.add(Holds { groups });
        }
        let surface = c.get::<&Triangles>().zip(c.get::<&Topology>());
        let host = Host::new(c.get::<&Vertices>(), surface);
        surface.map_or(Ok(()), |(triangles, _)| triangles.check(&host))?;
        check_changed(c, &host)?;
        complete(c);
        Ok(entity)
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
        self.per_triangle.check(needed)?;
        let mut triangles = Triangles::default();
        triangles.reserve(needed + self.room()[1]);
        for (t, &corners) in self.mesh.triangles.iter().enumerate() {
            let x = corners.map(|v| self.mesh.positions[v as usize]);
            let centroid = (x[0] + x[1] + x[2]) / 3.0;
            let mut material = own(&self.per_triangle.material, t, (self.material)(centroid));
            material.thickness = own(&self.per_triangle.thickness, t, material.thickness);
            let stiffness = law(&material, t)?;
            let direction = match (&self.fibres, &self.mesh.fibres) {
                (Some(fibres), _) => fibres.direction(t, centroid),
                (None, Some(list)) => list[t],
                (None, None) => DVec3::X,
            };
            // Concentric fibres have no direction on their axis: an edge gives it.
            if direction != DVec3::ZERO && !is_direction(direction) {
                return Err(MeshError::BadFibre { triangle: t, fibre: direction }.into());
            }
            let normal = (x[1] - x[0]).cross(x[2] - x[0]).normalize_or_zero();
            let fibre = RestTriangle::axis(normal, direction, x[1] - x[0]);
            let rest = RestTriangle::new(x, fibre).ok_or(Broken::RestArea { triangle: t as u32 })?;
            let Material { thickness, density, .. } = material;
            enough_mass("the mass of a triangle in g", thickness * density * rest.area)?;
            let PerTriangle { strength, toughness, pre_stretch, .. } = &self.per_triangle;
            triangles.push(TriangleRow {
                corners,
                rest,
                fibre,
                stiffness,
                thickness,
                density,
                pre_stretch: own(pre_stretch, t, Sym2::ZERO),
                strength: own(strength, t, 1.0),
                toughness: own(toughness, t, 1.0),
            });
        }
        Ok(triangles)
    }
}

/// The law of a triangle's material.
pub(crate) fn law(material: &Material, triangle: usize) -> Result<Orthotropic, BodyError> {
    positive("Material", "thickness", material.thickness)?;
    positive("Material", "density", material.density)?;
    material.stiffness().map_err(|source| BodyError::Material { triangle, source })
}

/// Refuses a linear matrix where the published law takes its place.
pub(crate) fn check_neo_hookean(fibres: Option<&HolzapfelGasserOgden>, triangles: &Triangles) -> Result<(), BodyError> {
    if !fibres.is_some_and(HolzapfelGasserOgden::replaces_linear) {
        return Ok(());
    }
    let other = triangles.stiffness.iter().position(|law| !law.is_neo_hookean());
    other.map_or(Ok(()), |triangle| Err(BodyError::NotNeoHookean(triangle)))
}

/// Least mass of a triangle \[g\]: sums and fractions of it keep all their digits.
const LEAST_MASS: f64 = 1e-290;

/// Splits share masses out: masses near the smallest normal number would lose digits, or all of itself.
pub(crate) fn enough_mass(what: &'static str, value: f64) -> Result<(), BodyError> {
    let is_right = value >= LEAST_MASS && value.is_finite();
    number("Material", what, value, (is_right, "it must be at least 1e-290, and finite"))
}

/// Judges the bending stiffness of every triangle: its inverse is needed.
pub(crate) fn check_bending(bending: &Bending, triangles: &Triangles) -> Result<(), BodyError> {
    let (what, must) = ("the bending stiffness of a triangle in N·mm", "it must be from 1e-100 to 1e100");
    (0..triangles.len()).try_for_each(|t| {
        let (h, q) = (triangles.thickness[t], &triangles.stiffness[t]);
        let value = bending.stiffness.unwrap_or_else(|| h * h * h / 12.0 * q.q11.min(q.q22).min(q.q66));
        number("Bending", what, value, ((1e-100..=1e100).contains(&value), must))
    })
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
