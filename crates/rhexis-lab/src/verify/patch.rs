//! Constant strain on an irregular anisotropic mesh: a linear solve, and a finite stretch under a large rotation.

use super::bodies::{self, Snapshot};
use super::reference::{Json, file};
use super::{Artifacts, Row, Rows, VerifyError, largest};
use glam::DVec3;
use rhexis::components::Fibres;
use rhexis::membrane::Membrane;
use rhexis::settings::Settings;
use rhexis::storage::TriangleMesh;

pub(super) fn run(_: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("patch");
    let (name, text) = file!("patch.json");
    let file = Json::new(name, text)?;
    linear(&mut rows, &file)?;
    large_rotation(&mut rows, &file)?;
    rows.finish()
}

fn membrane(file: &Json) -> Result<Membrane, VerifyError> {
    let corners = |t: usize| {
        let v = file.numbers(&format!("/triangles/{t}"))?;
        Ok([v[0] as u32, v[1] as u32, v[2] as u32])
    };
    let triangles = (0..file.len("/triangles")?).map(corners).collect::<Result<_, VerifyError>>()?;
    let mesh = TriangleMesh { positions: file.vectors("/vertices")?, triangles, fibres: None };
    let constants = [
        file.number("/material/EF")?,
        file.number("/material/ET")?,
        file.number("/material/nuF")?,
        file.number("/material/G")?,
    ];
    let material = bodies::material(constants, file.number("/thickness")?, 1e-3);
    Ok(Membrane::new("patch", mesh, material).fibres(Fibres::at_degrees(file.number("/theta_deg")?)))
}

fn linear(rows: &mut Rows, file: &Json) -> Result<(), VerifyError> {
    let a = file.vectors("/linear/displacement_gradient_A (u = A X)")?;
    let exact = |x: DVec3| DVec3::new(a[0].dot(x), a[1].dot(x), 0.0);
    let boundary = file.number("/n_boundary")? as usize;
    let membrane = membrane(file)?.planar();
    let rim: Vec<DVec3> = membrane.mesh().positions[..boundary].to_vec();
    let hold = bodies::hold(&membrane, "boundary", |p| rim.contains(&p).then(|| exact(p)));
    let rest = membrane.mesh().positions.clone();
    let (mut simulation, body) = bodies::simulate(Settings { threads: 1, ..Settings::default() }, membrane.hold(hold))?;
    let found = bodies::linear(&mut simulation, body)?;

    let off = found.displacement.iter().zip(&rest).map(|(u, x)| u.distance(exact(*x)));
    // The solve goes to 1e-13 of displacements of 0.02 mm: 1e-12 of the patch' 10 mm is far above both.
    rows.add("linear: displacement", largest(off), 1e-11, "mm");
    let wanted = file.vectors("/linear/internal_forces_N (interior must vanish)")?;
    let off = found.reaction.iter().zip(&wanted).map(|(r, f)| r.distance(*f));
    // Forces are 1e-3 N: rounding and the solver's 1e-13.
    rows.add("linear: forces, zero in the interior", largest(off), 1e-11, "N");
    rows.relative("linear: energy", found.energy, file.number("/linear/elastic_energy_mJ")?, 1e-12);
    Ok(())
}

fn large_rotation(rows: &mut Rows, file: &Json) -> Result<(), VerifyError> {
    let (mut simulation, body) = bodies::simulate(Settings { threads: 1, ..Settings::default() }, membrane(file)?)?;
    let x = file.vectors("/large_rotation/x")?;
    bodies::set_motion(&mut simulation, body, |v, _| (x[v], DVec3::ZERO))?;
    let snapshot = Snapshot::new(&mut simulation, body)?;
    let forces = snapshot.elastic_forces();

    let wanted = file.vectors("/large_rotation/forces_energy_gradient_N")?;
    // The file holds the gradient of the energy, the engine the force, which is its negative.
    let off = forces.iter().zip(&wanted).map(|(f, g)| (*f + *g).length());
    // Rounding of corner forces of 0.3 N is 1e-16; the bound is the property that every co-rotational code should have.
    rows.add("large rotation: forces of the energy's gradient", largest(off), 1e-11, "N");
    let interior = forces.iter().skip(file.number("/n_boundary")? as usize).map(|f| f.length());
    rows.add("large rotation: interior forces", largest(interior), 1e-11, "N");
    let torque: DVec3 = snapshot.vertices.position.iter().zip(&forces).map(|(x, f)| x.cross(*f)).sum();
    // Forces of 0.06 N at arms of 12 mm: rounding is 1e-16 of their sum.
    rows.add("large rotation: net torque", torque.length(), 1e-13, "N·mm");
    let energy = simulation.energies(body)?.elastic;
    // Rounding of the positions is 1e-16 of 12 mm, over a strain of 0.08 and an edge of 1.5 mm.
    rows.relative("large rotation: energy", energy, file.number("/large_rotation/energy_mJ")?, 1e-12);
    let stress = file.numbers("/large_rotation/stress_in_polar_frame")?;
    let degrees = file.number("/theta_deg")?;
    let off = snapshot.frames.states().map(|s| {
        let t = s.stress.in_axes_turned_by(-degrees.to_radians());
        largest([t.xx - stress[0], t.yy - stress[1], t.xy - stress[2]].map(f64::abs))
    });
    // As the energy, of a stress of 0.5 MPa.
    rows.add("large rotation: stress of every triangle", largest(off), 1e-12, "MPa");
    Ok(())
}
