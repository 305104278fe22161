//! A circular hole in a plate under tension: the exact displacement of the infinite plate is prescribed on the outer square,
//! so the mesh' solution converges to the exact field.

use super::bodies;
use super::reference::{Json, csv, file};
use super::{Artifacts, Row, Rows, VerifyError, largest};
use glam::{DMat3, DVec2, DVec3};
use num_complex::Complex64;
use rhexis::components::{Fibres, Material};
use rhexis::generate;
use rhexis::math::{RestTriangle, Sym2};
use rhexis::membrane::Membrane;
use rhexis::settings::Settings;
use rhexis::storage::TriangleMesh;
use rhexis::systems::kernels::membrane::gradient;

pub(super) fn run(_: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("hole");
    let (name, text) = file!("hole.json");
    let ortho = Ortho::new(&Json::new(name, text)?)?;
    let exact = |x: DVec3| ortho.displacement(x);
    fields(&mut rows, "orthotropic", exact, &[file!("hole_field_45.csv")])?;
    let (name, text) = file!("hole_square_boundary_45.csv");
    let off =
        csv(name, text)?.into_iter().map(|[x, y, u, v]| exact(DVec3::new(x, y, 0.0)).distance(DVec3::new(u, v, 0.0)));
    // The file has 13 digits of 5 mm.
    rows.add("orthotropic: exact displacement on the square", largest(off), 1e-11, "mm");
    fields(&mut rows, "isotropic", kirsch, &[file!("hole_kirsch.csv")])?;

    let (name, text) = file!("hole_P1_convergence.json");
    let file = Json::new(name, text)?;
    // The listed isotropic row was made with a double root split by 1e-5, as its stress concentration of 3.00001 shows.
    converge(&mut rows, &file, "ortho", Ortho::MATERIAL, exact, 1e-8)?;
    converge(&mut rows, &file, "iso", Material::isotropic(3.0, 0.3, 1.0), kirsch, 1e-5)?;
    rows.finish()
}

/// The displacements listed with the fields.
fn fields(
    rows: &mut Rows,
    what: &str,
    exact: impl Fn(DVec3) -> DVec3,
    files: &[(&'static str, &str)],
) -> Result<(), VerifyError> {
    for (name, text) in files {
        let off = csv(name, text)?
            .into_iter()
            .map(|[x, y, _, _, _, u, v]| exact(DVec3::new(x, y, 0.0)).distance(DVec3::new(u, v, 0.0)));
        // The files have 12 to 14 digits, coordinates too.
        rows.add(format!("{what}: exact displacement, {name}"), largest(off), 1e-10, "mm");
    }
    Ok(())
}

/// Displacement \[mm\] of an infinite isotropic plate (3 MPa, ν 0.3) with a hole of 1 mm under 1 MPa along x (Kirsch 1898;
/// Timoshenko and Goodier, Theory of Elasticity, art. 35).
fn kirsch(x: DVec3) -> DVec3 {
    let (young, nu) = (3.0, 0.3);
    let (r, angle) = (x.truncate().length(), x.y.atan2(x.x));
    let (shear, kappa) = (young / (2.0 * (1.0 + nu)), (3.0 - nu) / (1.0 + nu));
    let (s2, c2) = (2.0 * angle).sin_cos();
    let scale = 1.0 / (8.0 * shear);
    let radial = scale * (r * (kappa - 1.0 + 2.0 * c2) + 2.0 / r * (1.0 + c2 * (kappa + 1.0)) - 2.0 * c2 / r.powi(3));
    let hoop = scale * s2 * (-2.0 * r - 2.0 / r * (kappa - 1.0) - 2.0 / r.powi(3));
    let (s, c) = angle.sin_cos();
    DVec3::new(radial * c - hoop * s, radial * s + hoop * c, 0.0)
}

/// The orthotropic plate with fibres at 45° by Lekhnitskii's complex potentials.
struct Ortho {
    /// Compliances S11, S12, S16 \[1/MPa\] in x and y.
    compliance: [f64; 3],
    /// μ, A, p, q of the two potentials, as listed.
    potentials: [[Complex64; 4]; 2],
}

impl Ortho {
    const MATERIAL: Material = Material {
        young_fibre: 10.0,
        young_transverse: 1.0,
        poisson_major: 0.3,
        shear_modulus: Some(0.5),
        thickness: 1.0,
        density: 1e-3,
    };

    fn new(file: &Json) -> Result<Self, VerifyError> {
        let complex = |key: &str, k: usize| {
            let at = format!("/cases/1/potentials/{key}/{k}");
            Ok::<_, VerifyError>(Complex64::new(file.number(&format!("{at}/0"))?, file.number(&format!("{at}/1"))?))
        };
        let potential =
            |k: usize| Ok::<_, VerifyError>([complex("mu", k)?, complex("A", k)?, complex("p", k)?, complex("q", k)?]);
        let law = Self::MATERIAL.stiffness();
        let law = law.map_err(|source| rhexis::membrane::BodyError::Material { triangle: 0, source })?;
        let s = DMat3::from_cols_array_2d(&law.voigt_matrix(45_f64.to_radians())).inverse().to_cols_array_2d();
        Ok(Self { compliance: [s[0][0], s[0][1], s[0][2]], potentials: [potential(0)?, potential(1)?] })
    }

    /// Displacement \[mm\] under 1 MPa along x around a hole of 1 mm.
    fn displacement(&self, x: DVec3) -> DVec3 {
        let [s11, s12, s16] = self.compliance;
        let start = DVec3::new(s11 * x.x + 0.5 * s16 * x.y, s12 * x.y + 0.5 * s16 * x.x, 0.0);
        self.potentials.iter().fold(start, |u, &[mu, a, p, q]| {
            // z = ½[(1 − iμ)ζ + (1 + iμ)/ζ], the root outside the unit circle.
            let z = x.x + mu * x.y;
            let (b, c) = (1.0 - Complex64::I * mu, 1.0 + Complex64::I * mu);
            let root = (z * z - b * c).sqrt();
            let (zeta1, zeta2) = ((z + root) / b, (z - root) / b);
            let phi = a / if zeta1.norm_sqr() >= zeta2.norm_sqr() { zeta1 } else { zeta2 };
            u + DVec3::new(2.0 * (p * phi).re, 2.0 * (q * phi).re, 0.0)
        })
    }
}

fn converge(
    rows: &mut Rows,
    file: &Json,
    case: &str,
    material: Material,
    exact: impl Fn(DVec3) -> DVec3,
    tolerance: f64,
) -> Result<(), VerifyError> {
    let mut errors = Vec::new();
    let mut listed_errors = Vec::new();
    // The file lists three meshes of the orthotropic plate, then three of the isotropic one.
    let first = if case == "ortho" { 0 } else { 3 };
    for i in first..first + 3 {
        let wanted = |key: &str| file.number(&format!("/rows/{i}/{key}"));
        let n_t = wanted("n_t")?;
        let mesh = generate::plate_with_hole(n_t as usize)?;
        let membrane = Membrane::new("plate", mesh.clone(), material).fibres(Fibres::at_degrees(45.0)).planar();
        // The outermost layer of vertices: corners of the square are met to rounding only.
        let rim = bodies::hold(&membrane, "square", |p| (p.abs().max_element() > 5.0 - 1e-9).then(|| exact(p)));
        let settings = Settings { threads: 1, ..Settings::default() };
        let (mut simulation, body) = bodies::simulate(settings, membrane.hold(rim))?;
        let found = bodies::linear(&mut simulation, body)?;

        let field: Vec<DVec3> = mesh.positions.iter().map(|&p| exact(p)).collect();
        let off = largest(found.displacement.iter().zip(&field).map(|(u, e)| (*u - *e).abs().max_element()));
        let error = off / largest(field.iter().map(|e| e.abs().max_element()));
        let name = format!("{case}, {n_t} points round the hole");
        rows.relative(format!("{name}: energy"), found.energy, wanted("energy")?, tolerance);
        let listed = wanted("max_disp_err_rel")?;
        rows.ratio(format!("{name}: largest displacement error"), (error - listed).abs(), tolerance);
        let hoop = first_ring_hoop(&mesh, &found.displacement, material, n_t as u32);
        rows.relative(
            format!("{name}: largest hoop stress of the first ring"),
            hoop,
            wanted("first_ring_hoop_max")?,
            tolerance,
        );
        errors.push(error);
        listed_errors.push(listed);
    }
    if let ([_, a, b], [_, c, d]) = (&errors[..], &listed_errors[..]) {
        // The rate between the two finest meshes, against that of the listed errors.
        rows.ratio(
            format!("{case}: convergence rate against the listed"),
            ((a / b).log2() - (c / d).log2()).abs(),
            0.01,
        );
        rows.note(format!("{case}: convergence rate"), (a / b).log2(), "1");
    }
    Ok(())
}

/// The largest hoop stress \[MPa\] of the triangles with an edge on the hole, about their centroids.
fn first_ring_hoop(mesh: &TriangleMesh, u: &[DVec3], material: Material, n_t: u32) -> f64 {
    let Ok(law) = material.stiffness() else { return f64::NAN };
    let fibre = DVec3::new(1.0, 1.0, 0.0).normalize();
    let across = DVec3::new(-fibre.y, fibre.x, 0.0);
    let ring = mesh.triangles.iter().filter(|corners| corners.iter().filter(|&&v| v < n_t).count() == 2);
    let hoop = ring.filter_map(|corners| {
        let x = corners.map(|v| mesh.positions[v as usize]);
        let (d1, d2) = gradient(corners.map(|v| u[v as usize]), &RestTriangle::new(x, fibre)?);
        let strain = Sym2::new(fibre.dot(d1), across.dot(d2), 0.5 * (fibre.dot(d2) + across.dot(d1)));
        let centroid = (x[0] + x[1] + x[2]) / 3.0;
        let tangent = DVec3::new(-centroid.y, centroid.x, 0.0).normalize();
        Some(law.stress(strain).normal_component(DVec2::new(tangent.dot(fibre), tangent.dot(across))))
    });
    hoop.fold(f64::NEG_INFINITY, f64::max)
}
