//! From `[[bodies]]` to a membrane with its components.

use super::compartment::compartment;
use super::error::{Fault, not_negative, positive};
use super::fibre_field::fibres;
use super::fibre_law::{fibre_law, neo_hookean};
use super::files::Files;
use super::mesh_file::MeshFile;
use super::region::Surface;
use super::schema::{
    BodySpec, BranchSpec, CriterionSpec, EnergyCriterionSpec, FibreSpec, GradingSpec, MaterialSpec, RefinementSpec,
    SleepSpec, TearModeSpec, TearRateSpec, TearingSpec, TimeCurve,
};
use super::springs::{point_loads, springs};
use super::{grasp, held, mesh_file, per_triangle, shape};
use glam::DVec3;
use rhexis::components::{
    Bending, Branch, Contact, Damping, Drag, EdgeLoad, EdgeLoads, EnergyCriterion, Gravity, Grips, Material,
    PointLoads, PreStretch, Pressure, Refinement, Relaxation, SelfContact, Sleeping, TearMode, TearRate, Tearing,
    Toughness,
};
use rhexis::membrane::{BodyError, Membrane};
use std::collections::BTreeMap;

/// What all copies of a body have in common, and what takes long: read and made once.
pub(super) struct Sheet {
    /// The mesh with what its file says of it.
    pub file: MeshFile,
    /// Of a fibre file.
    pub fibres: Option<Vec<DVec3>>,
    /// What differs from triangle to triangle.
    pub per_triangle: per_triangle::PerTriangle,
    /// Largest way by which `planar` moved a vertex \[mm\].
    pub flattened: f64,
}

/// Makes or reads the mesh, and reads the file of fibres. `key` is the body's path in the file.
pub(super) fn sheet(spec: &BodySpec, files: &Files, key: &str) -> Result<Sheet, Fault> {
    let mut file = shape::mesh(&spec.mesh, &per_triangle::arrays(spec, key)?, files, &format!("{key}.mesh"))?;
    let mut fibres = match &spec.fibres {
        Some(FibreSpec::File(path)) => {
            let key = format!("{key}.fibres.file");
            let read = mesh_file::fibres_of(files, path).map_err(|error| shape::refused_file(&key, error))?;
            let by_triangle = file.by_triangle(read, &format!("the file {}", path.display()));
            Some(
                by_triangle
                    .map_err(|what| Fault::new(&key, what, "give one for each triangle, in the mesh's order"))?,
            )
        }
        _ => None,
    };
    if let Some(place) = &spec.place {
        shape::place(place, &mut file.mesh, fibres.as_deref_mut(), &format!("{key}.place"))?;
    }
    let flattened = if spec.planar { shape::flatten(&mut file.mesh, key)? } else { 0.0 };
    let per_triangle = per_triangle::read(spec, &file, files, key)?;
    Ok(Sheet { file, fibres, per_triangle, flattened })
}

/// A membrane, not yet spawned: the copy of this name.
pub(super) fn membrane(spec: &BodySpec, name: &str, sheet: &Sheet, key: &str) -> Result<Membrane, Fault> {
    let mesh = &sheet.file.mesh;
    let material = material(&spec.material, 0.0, &format!("{key}.material"))?;
    let mut membrane = Membrane::new(name, mesh.clone(), material);
    if let Some(spec) = &spec.grading {
        let grading = grading(spec, &format!("{key}.grading"))?;
        membrane = membrane.graded(move |at| grading(material, at));
    }
    if !spec.materials.is_empty() {
        membrane = parts(membrane, spec, (sheet, material), key)?;
    }
    if let Some(own) = &spec.fibres {
        membrane = membrane.fibres(fibres(own, sheet, &format!("{key}.fibres"))?);
    }
    if spec.planar {
        membrane = membrane.planar();
    }
    membrane = surroundings(membrane, spec, key)?;
    let tearing =
        spec.tearing.as_ref().map(|spec| tearing(spec, (&material, 0.0), &format!("{key}.tearing"))).transpose()?;
    let criterion = tip_criterion((&spec.tearing, &spec.energy_criterion), (&material, 0.0), key)?;
    membrane = per_triangle::values(membrane, (spec, sheet), (tearing.as_ref(), criterion.as_ref()), key)?;
    if let Some(tearing) = tearing {
        membrane = membrane.with(tearing);
    }
    if let Some(criterion) = criterion {
        membrane = membrane.with(criterion);
    }
    if let Some(refinement) = &spec.refinement {
        let key = format!("{key}.refinement");
        let Some(tearing) = &spec.tearing else {
            let what = "the mesh is refined around tear tips, and this body has none";
            return Err(Fault::new(key, what, "add a `tearing` table, or remove this one"));
        };
        membrane = membrane.with(self::refinement(refinement, tearing.radius, &key)?);
    }
    membrane = boundary_conditions(membrane, spec, &sheet.file, key)?;
    Ok(membrane)
}

/// The material at a time \[ms\].
pub(super) fn material(spec: &MaterialSpec, time: f64, key: &str) -> Result<Material, Fault> {
    let at = |name: &str| format!("{key}.{name}");
    let thickness = positive(at("thickness"), spec.thickness.at(time), "mm")?;
    let density = positive(at("density"), spec.density, "g/mm³")?;
    if let Some(material) = neo_hookean(spec, time, key)? {
        return Ok(material);
    }
    let MaterialSpec { young, poisson, young_fibre, young_transverse, poisson_major, shear_modulus, .. } = spec;
    let [young, young_fibre, young_transverse, shear_modulus] =
        [young, young_fibre, young_transverse, shear_modulus].map(|curve| curve.as_ref().map(|curve| curve.at(time)));
    let [poisson, poisson_major] = [*poisson, *poisson_major];
    let named = |values: [(&str, Option<f64>, &str); 4]| {
        values.into_iter().try_for_each(|(name, value, unit)| match value {
            Some(value) => positive(at(name), value, unit).map(|_| ()),
            None => Ok(()),
        })
    };
    named([
        ("young", young, "MPa"),
        ("young_fibre", young_fibre, "MPa"),
        ("young_transverse", young_transverse, "MPa"),
        ("shear_modulus", shear_modulus, "MPa"),
    ])?;
    let material = match (young, poisson, young_fibre, young_transverse, poisson_major, shear_modulus) {
        (Some(young), Some(poisson), None, None, None, None) => {
            if poisson <= -1.0 || poisson >= 1.0 {
                let what = format!("{poisson} is outside −1 to 1, where the energy of a membrane is positive");
                return Err(Fault::new(at("poisson"), what, "soft tissue is near 0.45"));
            }
            Material { density, ..Material::isotropic(young, poisson, thickness) }
        }
        (None, None, Some(young_fibre), Some(young_transverse), Some(poisson_major), shear_modulus) => {
            Material { young_fibre, young_transverse, poisson_major, shear_modulus, thickness, density }
        }
        _ => {
            let hint = "give `young` and `poisson` (isotropic), or `young_fibre`, `young_transverse`, `poisson_major` \
                        and optionally `shear_modulus`";
            return Err(Fault::new(key, "the elastic constants are incomplete or mixed", hint));
        }
    };
    material.stiffness().map_err(|error| inadmissible(key, &error))?;
    Ok(material)
}

fn inadmissible(key: &str, error: &rhexis::math::InadmissibleMaterial) -> Fault {
    let message = error.to_string();
    let (what, hint) = message.split_once(": it must").unwrap_or((&message, ""));
    Fault::new(format!("{key}.poisson_major"), what, format!("it must{hint}"))
}

/// Gives parts of a body their own materials.
fn parts(
    membrane: Membrane,
    spec: &BodySpec,
    (sheet, material): (&Sheet, Material),
    key: &str,
) -> Result<Membrane, Fault> {
    if spec.grading.is_some() {
        let hint = "keep one of the two";
        return Err(Fault::new(format!("{key}.materials"), "the material is graded, and parts have their own", hint));
    }
    let mesh = &sheet.file.mesh;
    let surface = Surface::new(&sheet.file);
    let mut list = vec![material; mesh.triangles.len()];
    for (i, part) in spec.materials.iter().enumerate() {
        let key = format!("{key}.materials.{i}");
        let own = self::material(&part.material, 0.0, &format!("{key}.material"))?;
        let mut is_in = vec![false; mesh.positions.len()];
        let rows = surface.vertices(&part.region, &format!("{key}.region"))?;
        rows.into_iter().for_each(|row| is_in[row as usize] = true);
        let mut is_any = false;
        for (entry, _) in list.iter_mut().zip(&mesh.triangles).filter(|(_, t)| t.iter().all(|&v| is_in[v as usize])) {
            (*entry, is_any) = (own, true);
        }
        if !is_any {
            let hint = "a triangle is in a region with all its corners: make it larger, or the mesh finer";
            return Err(Fault::new(format!("{key}.region"), "no triangle is in the region", hint));
        }
    }
    Ok(membrane.materials(list))
}

/// The material at a rest point \[mm\], from that of the body.
pub(super) fn grading(
    spec: &GradingSpec,
    key: &str,
) -> Result<impl Fn(Material, DVec3) -> Material + Send + Sync + use<>, Fault> {
    let ratio = positive(format!("{key}.ratio_at_rim"), spec.ratio_at_rim, "")?;
    let radius = positive(format!("{key}.radius"), spec.radius, "mm")?;
    let axis = direction(spec.axis.0, &format!("{key}.axis"))?;
    let centre = spec.centre.0;
    Ok(move |material: Material, at: DVec3| {
        let out = (at - centre).reject_from_normalized(axis).length();
        let root = (1.0 + (ratio - 1.0) * (out / radius).min(1.0)).sqrt();
        Material {
            young_fibre: material.young_fibre * root,
            young_transverse: material.young_transverse / root,
            ..material
        }
    })
}

/// Files and messages tell things of a kind apart by their names; each with its path in the file.
pub(super) fn own_names(named: impl Iterator<Item = (String, String)>) -> Result<(), Fault> {
    let mut first = BTreeMap::new();
    for (i, (key, name)) in named.enumerate() {
        let refuse = |what: String| Err(Fault::new(format!("{key}.name"), what, "give each a name of its own"));
        if name.trim().is_empty() {
            return refuse("the name is empty".to_owned());
        }
        if let Some(first) = first.get(&name) {
            return refuse(format!("the name `{name}` is taken by entry {first}"));
        }
        first.insert(name, i);
    }
    Ok(())
}

/// A unit vector.
pub(super) fn direction(vector: DVec3, key: &str) -> Result<DVec3, Fault> {
    vector.try_normalize().ok_or_else(|| Fault::new(key, "it has no direction", "give a vector that is not zero"))
}

/// The branches by which a body relaxes.
fn relaxation(specs: &[BranchSpec], key: &str) -> Result<Relaxation, Fault> {
    let branch = |(i, spec): (usize, &BranchSpec)| {
        let at = |name: &str| format!("{key}.relaxation.{i}.{name}");
        Ok(Branch { part: positive(at("part"), spec.part, "")?, time: positive(at("time"), spec.time, "ms")? })
    };
    let relaxation = Relaxation { branches: specs.iter().enumerate().map(branch).collect::<Result<_, Fault>>()? };
    if !(relaxation.lasting() > 0.0) {
        let what = format!("the parts sum to {}, and no stiffness would last", 1.0 - relaxation.lasting());
        return Err(Fault::new(format!("{key}.relaxation"), what, "lower the parts to a sum below 1"));
    }
    Ok(relaxation)
}

/// What acts on the body as a whole.
fn surroundings(mut membrane: Membrane, spec: &BodySpec, key: &str) -> Result<Membrane, Fault> {
    let at = |name: &str| format!("{key}.{name}");
    if let Some(strain) = spec.pre_stretch {
        membrane = membrane.with(PreStretch { strain: strain.0 });
    }
    membrane = fibre_law(membrane, spec, key)?;
    if let Some(time) = spec.damping {
        membrane = membrane.with(Damping { time: not_negative(at("damping"), time, "ms")? });
    }
    if !spec.relaxation.is_empty() {
        membrane = membrane.with(relaxation(&spec.relaxation, key)?);
    }
    if let Some(acceleration) = spec.gravity {
        membrane = membrane.with(Gravity { acceleration: acceleration.0 });
    }
    if let Some(coefficient) = spec.drag {
        membrane = membrane.with(Drag { coefficient: not_negative(at("drag"), coefficient, "N·ms/mm³")? });
    }
    if let Some(curve) = &spec.pressure {
        if spec.planar {
            let what = "pressure pushes out of the plane, in which `planar` keeps the body";
            return Err(Fault::new(at("pressure"), what, "remove one of the two"));
        }
        membrane = membrane.with(Pressure { curve: curve.0.clone() });
    }
    if let Some(own) = &spec.compartment {
        membrane = compartment(membrane, (own, spec), &at("compartment"))?;
    }
    if let Some(bending) = &spec.bending {
        let stiffness = bending.stiffness.map(|d| positive(at("bending.stiffness"), d, "N·mm")).transpose()?;
        membrane = membrane.with(Bending { stiffness });
    }
    if let Some(contact) = &spec.contact {
        let stiffness = contact.stiffness.map(|k| positive(at("contact.stiffness"), k, "N/mm³")).transpose()?;
        let friction = not_negative(at("contact.friction"), contact.friction, "")?;
        let self_contact = match &contact.self_contact {
            Some(_) if spec.planar => {
                let what = "a body that `planar` keeps in its plane has no layers";
                return Err(Fault::new(at("contact.self_contact"), what, "remove one of the two"));
            }
            Some(own) => {
                let radius = positive(at("contact.self_contact.radius"), own.radius, "mm")?;
                let key = at("contact.self_contact.band");
                Some(SelfContact { radius, band: own.band.map(|band| not_negative(key, band, "mm")).transpose()? })
            }
            None => None,
        };
        let between_bodies = contact.between_bodies;
        if between_bodies && self_contact.is_none() {
            let what = "contact with other bodies takes the radius of `self_contact`";
            return Err(Fault::new(at("contact.between_bodies"), what, "add `self_contact = { radius = … }`"));
        }
        membrane = membrane.with(Contact { stiffness, friction, self_contact, between_bodies });
    }
    if let Some(SleepSpec { strain, steps }) = spec.sleep {
        if steps == 0 {
            return Err(Fault::new(at("sleep.steps"), "steps must be at least 1", "give 1 or more"));
        }
        let strain = positive(at("sleep.strain"), strain, "")?;
        membrane = membrane.with(Sleeping { strain, steps, ..Sleeping::default() });
    }
    Ok(membrane)
}

/// How a body tears whose material and thresholds are those at a time \[ms\].
pub(super) fn tearing(spec: &TearingSpec, present: (&Material, f64), key: &str) -> Result<Tearing, Fault> {
    let at = |name: &str| format!("{key}.{name}");
    let radius = positive(at("radius"), spec.radius, "mm")?;
    let thresholds = thresholds(spec, present, radius, key)?;
    let cone = positive(at("cone_degrees"), spec.cone_degrees, "°")?;
    if cone > 180.0 {
        return Err(Fault::new(at("cone_degrees"), format!("{cone}° is more than a half turn"), "give at most 180"));
    }
    let ultimate_stretch =
        spec.ultimate_stretch.map(|value| positive(at("ultimate_stretch"), value, "")).transpose()?;
    if let Some(stretch) = ultimate_stretch.filter(|stretch| *stretch <= 1.0) {
        let what = format!("{stretch} parts tissue that is not stretched");
        return Err(Fault::new(at("ultimate_stretch"), what, "give more than 1"));
    }
    let branch_margin = spec.branch_margin;
    if let Some(margin) = branch_margin.filter(|margin| !(0.0..1.0).contains(margin)) {
        let what = format!("branch_margin must be in [0, 1), not {margin}");
        return Err(Fault::new(at("branch_margin"), what, "give at least 0 and less than 1, such as 1e-6"));
    }
    Ok(Tearing {
        exponent: positive(at("exponent"), spec.exponent, "")?,
        cone: cone.to_radians(),
        mode: match spec.mode {
            TearModeSpec::Free => TearMode::Free,
            TearModeSpec::Edge => TearMode::Edge,
            TearModeSpec::Glide => TearMode::Glide,
        },
        rate: match spec.rate {
            Some(TearRateSpec { speed, exponent }) => Some(TearRate {
                speed: positive(at("rate.speed"), speed, "mm/ms")?,
                exponent: positive(at("rate.exponent"), exponent, "")?,
            }),
            None => None,
        },
        may_initiate: spec.may_initiate,
        ultimate_stretch,
        branch_margin,
        ..thresholds
    })
}

/// Strengths and R, from strengths or from toughnesses.
fn thresholds(
    spec: &TearingSpec,
    (material, time): (&Material, f64),
    radius: f64,
    key: &str,
) -> Result<Tearing, Fault> {
    let at = |name: &str| format!("{key}.{name}");
    let TearingSpec {
        strength_along_fibres,
        strength_across_fibres,
        strength_ratio,
        toughness_along_fibres,
        toughness_across_fibres,
        ..
    } = spec;
    let now = |curve: &Option<TimeCurve>| curve.as_ref().map(|curve| curve.at(time));
    match (
        now(strength_along_fibres),
        now(strength_across_fibres),
        *strength_ratio,
        now(toughness_along_fibres),
        now(toughness_across_fibres),
    ) {
        (Some(transverse), fibre, ratio, None, None) => {
            let strength_along_fibres = positive(at("strength_along_fibres"), transverse, "MPa")?;
            let strength_across_fibres = match (fibre, ratio) {
                (Some(strength), None) => positive(at("strength_across_fibres"), strength, "MPa")?,
                (None, Some(ratio)) => strength_along_fibres * positive(at("strength_ratio"), ratio, "")?,
                _ => {
                    let what = "the strength across the fibres is given twice or not at all";
                    return Err(Fault::new(key, what, "give either `strength_across_fibres` or `strength_ratio`"));
                }
            };
            Ok(Tearing { strength_across_fibres, strength_along_fibres, radius, ..Tearing::default() })
        }
        (None, None, None, Some(along), Some(across)) => {
            let along = positive(at("toughness_along_fibres"), along, "N/mm")?;
            let across = positive(at("toughness_across_fibres"), across, "N/mm")?;
            let law = material.stiffness().map_err(|error| inadmissible(key, &error))?;
            let tearing = Tearing::from_toughness(Toughness { along, across }, &law, radius);
            tearing.map_err(|error| Fault::new(key, error, "give numbers of an ordinary size"))
        }
        _ => {
            let hint = "give `strength_along_fibres` with `strength_across_fibres` or `strength_ratio` [MPa], or both of \
                        `toughness_along_fibres` and `toughness_across_fibres` [N/mm]; one kind follows from the other through `radius`";
            Err(Fault::new(key, "strengths and toughnesses are incomplete or mixed", hint))
        }
    }
}

/// What tips decide by, where that is energy.
pub(super) fn tip_criterion(
    (tearing, energy): (&Option<TearingSpec>, &Option<EnergyCriterionSpec>),
    (material, time): (&Material, f64),
    key: &str,
) -> Result<Option<EnergyCriterion>, Fault> {
    let at = format!("{key}.energy_criterion");
    match (energy, tearing) {
        (Some(_), None) => {
            let what = "the criterion on energy decides at tear tips, and this body has none";
            Err(Fault::new(at, what, "add a `tearing` table, or remove this one"))
        }
        (Some(_), Some(TearingSpec { criterion: Some(CriterionSpec::Stress), .. })) => {
            let what = "`tearing` lets the stress decide, and this table the energy";
            Err(Fault::new(at, what, "remove this table, or `criterion` in `tearing`"))
        }
        (Some(energy), Some(_)) => energy_criterion(energy, time, &at).map(Some),
        (None, Some(tearing)) => {
            let is_tough = tearing.toughness_along_fibres.is_some();
            if tearing.criterion.map_or(!is_tough, |criterion| criterion == CriterionSpec::Stress) {
                return Ok(None);
            }
            let key = format!("{key}.tearing");
            let thresholds = thresholds(tearing, (material, time), tearing.radius, &key)?;
            let toughness = match (&tearing.toughness_along_fibres, &tearing.toughness_across_fibres) {
                (Some(along), Some(across)) => Toughness { along: along.at(time), across: across.at(time) },
                _ => thresholds.toughness(&material.stiffness().map_err(|error| inadmissible(&key, &error))?),
            };
            Ok(Some(EnergyCriterion::new(toughness)))
        }
        (None, None) => Ok(None),
    }
}

fn energy_criterion(spec: &EnergyCriterionSpec, time: f64, key: &str) -> Result<EnergyCriterion, Fault> {
    let at = |name: &str| format!("{key}.{name}");
    let along = positive(at("toughness_along_fibres"), spec.toughness_along_fibres.at(time), "N/mm")?;
    let across = positive(at("toughness_across_fibres"), spec.toughness_across_fibres.at(time), "N/mm")?;
    let ring = positive(at("ring"), spec.ring, "")?;
    if ring > 100.0 {
        let what = format!("a ring of {ring} averaging radii is too wide");
        return Err(Fault::new(at("ring"), what, "give 100 at most; 2 serves"));
    }
    Ok(EnergyCriterion { toughness: Toughness { along, across }, ring })
}

fn refinement(spec: &RefinementSpec, radius: f64, key: &str) -> Result<Refinement, Fault> {
    let at = |name: &str| format!("{key}.{name}");
    let (name, edges_per_radius) = match (spec.edges_per_radius, spec.edge) {
        (Some(edges), None) => ("edges_per_radius", positive(at("edges_per_radius"), edges, "")?),
        (None, Some(edge)) => ("edge", radius / positive(at("edge"), edge, "mm")?),
        (None, None) => ("edges_per_radius", Refinement::default().edges_per_radius),
        (Some(_), Some(_)) => {
            return Err(Fault::new(key, "the fineness is given twice", "give either `edges_per_radius` or `edge`"));
        }
    };
    if edges_per_radius > 100.0 {
        let what = format!("{edges_per_radius} edges per averaging radius are too many");
        return Err(Fault::new(at(name), what, "give 100 at most; 3 to 6 serve"));
    }
    if !(1.0..=100.0).contains(&spec.budget) {
        let hint = "give the largest number of triangles as a multiple of those at the start, 1 to 100";
        return Err(Fault::new(at("budget"), format!("{} is outside 1 to 100", spec.budget), hint));
    }
    let margin = spec.margin.map(|margin| not_negative(at("margin"), margin, "mm")).transpose()?;
    Ok(Refinement { edges_per_radius, margin, budget: spec.budget, may_coarsen: spec.may_coarsen })
}

/// What acts on parts of the body.
fn boundary_conditions(mut membrane: Membrane, spec: &BodySpec, file: &MeshFile, key: &str) -> Result<Membrane, Fault> {
    let (mesh, surface) = (&file.mesh, Surface::new(file));
    let own = |kind: &str, names: Vec<&String>| {
        own_names(names.into_iter().enumerate().map(|(i, name)| (format!("{key}.{kind}.{i}"), name.clone())))
    };
    let clamps = spec.clamps.iter().filter_map(|clamp| clamp.name.as_ref());
    own("holds", spec.holds.iter().map(|hold| &hold.name).chain(clamps).collect())?;
    own("grips", spec.grips.iter().map(|grip| &grip.name).collect())?;
    membrane = held::holds(membrane, spec, mesh, &surface, key)?;
    if !spec.point_loads.is_empty() {
        let mut groups = Vec::new();
        for (i, load) in spec.point_loads.iter().enumerate() {
            groups.extend(point_loads(load, mesh, &surface, &format!("{key}.point_loads.{i}"))?);
        }
        membrane = membrane.with(PointLoads { groups });
    }
    if !spec.edge_loads.is_empty() {
        let groups = spec.edge_loads.iter().enumerate().map(|(i, load)| {
            let edges = surface.edges(&load.region, &format!("{key}.edge_loads.{i}.region"))?;
            Ok(EdgeLoad { edges, traction: load.traction.0, curve: load.curve.0.clone() })
        });
        membrane = membrane.with(EdgeLoads { groups: groups.collect::<Result<_, Fault>>()? });
    }
    if !(spec.springs.is_empty() && spec.beds.is_empty()) {
        membrane = membrane.with(springs(spec, mesh, &surface, key)?);
    }
    if !spec.grips.is_empty() {
        let grips =
            spec.grips.iter().enumerate().map(|(i, grip)| grasp::grip(grip, spec.planar, &format!("{key}.grips.{i}")));
        membrane = membrane.with(Grips::new(grips.collect::<Result<_, Fault>>()?));
    }
    Ok(membrane)
}

/// What spawning found, under the key that caused it.
pub(super) fn refused_body(spec: &BodySpec, key: &str, error: &BodyError) -> Fault {
    match error {
        BodyError::ContradictoryHolds { first, second, axis, row } => {
            let at = spec.holds.iter().position(|hold| hold.name == *second).unwrap_or(0);
            let what = format!("holds `{first}` and `{second}` both prescribe {axis} of vertex {row}");
            let hint = "make their regions disjoint (`except`), or let one of them leave that axis free (`axes`)";
            Fault::new(format!("{key}.holds.{at}"), what, hint)
        }
        BodyError::FibreCount { .. } => {
            let message = error.to_string();
            let (what, hint) = message.split_once(": ").unwrap_or((&message, ""));
            Fault::new(format!("{key}.fibres"), what, hint)
        }
        BodyError::Material { .. } => Fault::new(format!("{key}.grading"), error, "choose a ratio nearer to 1"),
        BodyError::BendingInPlane => {
            Fault::new(format!("{key}.planar"), error, "take out `planar = true`, or `bending`")
        }
        BodyError::OutOfRange { .. } => Fault::new(key, error, "give numbers of an ordinary size"),
        _ => Fault::new(key, error, "mend the mesh where the message points"),
    }
}
