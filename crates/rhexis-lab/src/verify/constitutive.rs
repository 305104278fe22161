//! The linear law against two independent derivations in 40 digits, and the published one of fibres against its formulas.

use super::reference::{csv, file};
use super::{Artifacts, Row, Rows, VerifyError, largest, published_law};
use glam::DMat3;
use rhexis::math::Orthotropic;

pub(super) fn run(_: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("constitutive");
    stiffness(&mut rows)?;
    let laminae =
        [([10.0, 1.0, 0.3, 0.5], file!("offaxis_0.csv")), ([138e3, 8960.0, 0.3, 7100.0], file!("offaxis_1.csv"))];
    for (constants, (name, text)) in laminae {
        off_axis(&mut rows, constants, name, text)?;
    }
    isotropy(&mut rows)?;
    admissibility(&mut rows);
    published_law::rows(&mut rows)?;
    rows.finish()
}

fn law([ef, et, nu, g]: [f64; 4]) -> Result<Orthotropic, VerifyError> {
    Orthotropic::new(ef, et, nu, g)
        .map_err(|source| rhexis::membrane::BodyError::Material { triangle: 0, source }.into())
}

fn stiffness(rows: &mut Rows) -> Result<(), VerifyError> {
    let (name, text) = file!("constitutive.csv");
    let mut errors = Vec::new();
    for [_, ef, et, nu, g, degrees, c11, c12, c13, c22, c23, c33, _] in csv(name, text)? {
        let c = law([ef, et, nu, g])?.voigt_matrix(degrees.to_radians());
        let wanted = [[c11, c12, c13], [c12, c22, c23], [c13, c23, c33]];
        let off = c.iter().flatten().zip(wanted.iter().flatten()).map(|(a, b)| (a - b).abs());
        errors.push(largest(off) / (c11 + c22));
    }
    // A few roundings, and those of the angle in radians at up to 180°.
    rows.ratio("stiffness matrix, 20 materials and angles, over C11 + C22", largest(errors), 1e-12);
    Ok(())
}

fn off_axis(rows: &mut Rows, constants: [f64; 4], name: &'static str, text: &str) -> Result<(), VerifyError> {
    let law = law(constants)?;
    let mut errors = Vec::new();
    for [degrees, young, poisson, coupling, shear] in csv(name, text)? {
        let compliance = DMat3::from_cols_array_2d(&law.voigt_matrix(degrees.to_radians())).inverse();
        let s = compliance.to_cols_array_2d();
        errors.push((1.0 / s[0][0] / young - 1.0).abs());
        errors.push((-s[0][1] / s[0][0] - poisson).abs());
        errors.push((s[0][2] / s[0][0] - coupling).abs());
        errors.push((1.0 / s[2][2] / shear - 1.0).abs());
    }
    // The file has 15 digits; the inverse loses the matrix' condition of about 50.
    rows.ratio(format!("off-axis moduli, {name}"), largest(errors), 1e-10);
    Ok(())
}

fn isotropy(rows: &mut Rows) -> Result<(), VerifyError> {
    let (young, poisson) = (3.0, 0.3);
    let law = law([young, young, poisson, Orthotropic::huber_shear_modulus(young, young, poisson)])?;
    let reference = law.voigt_matrix(0.0);
    let scale = reference[0][0] + reference[1][1];
    let errors = (0..720).map(|half| {
        let c = law.voigt_matrix(f64::from(half).to_radians() / 2.0);
        largest(c.iter().flatten().zip(reference.iter().flatten()).map(|(a, b)| (a - b).abs())) / scale
    });
    // Rounding only.
    rows.ratio("an isotropic material with the default G does not know its fibre angle", largest(errors), 1e-14);
    Ok(())
}

fn admissibility(rows: &mut Rows) {
    let refused = [
        [0.0, 1.0, 0.3, 0.5],
        [10.0, -1.0, 0.3, 0.5],
        [10.0, 1.0, 0.3, 0.0],
        [1.0, 1.0, 1.0, 0.5],
        [1.0, 10.0, 0.32, 0.5],
        [f64::NAN, 1.0, 0.3, 0.5],
        [10.0, 1.0, f64::NAN, 0.5],
    ];
    let accepted = [[1.0, 10.0, 0.31, 0.5], [10.0, 1.0, 3.1, 0.5], [10.0, 1.0, -0.3, 0.5]];
    let is_law = |[ef, et, nu, g]: &[f64; 4]| Orthotropic::new(*ef, *et, *nu, *g).is_ok();
    let wrong = refused.iter().filter(|m| is_law(m)).count() + accepted.iter().filter(|m| !is_law(m)).count();
    // A count: none may be judged wrongly.
    rows.ratio("materials judged wrongly on both sides of ν_F²·E_T/E_F = 1", wrong as f64, 0.0);
}
