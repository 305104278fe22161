//! A flap that lies on the sheet it is torn from: the lead scenes with contact between layers beside those without.

use super::contact::crossings;
use super::{Artifacts, Row, Rows, VerifyError};
use rhexis::components::Contact;
use rhexis_scene::Document;
use rhexis_scene::measures::{CourseFigures, Outcome, TearCourse};

/// Distance of layers \[mm\], above the thickness of the capsules, 0.011 and 0.015 mm.
const RADIUS: &str = "bodies.0.contact.self_contact.radius=0.02";

/// A scene of the catalog with changes.
type Run = (&'static str, &'static [&'static str]);

/// The mesh of fewest triangles, refined the most, with the longest step; its flap is the crudest.
const QUICK: &[Run] =
    &[("capsulorhexis", &["bodies.0.mesh.cap.triangles=1500", "bodies.0.refinement.budget=3", "run.dt=20"])];

const ALL: &[Run] = &[
    QUICK[0],
    ("capsulorhexis", &["bodies.0.mesh.cap.triangles=1500", "run.dt=20"]),
    ("capsulorhexis", &["bodies.0.mesh.cap.triangles=2500"]),
    ("capsulorhexis", &["bodies.0.mesh.cap.triangles=2500", "run.dt=5"]),
    ("capsulorhexis", &[]),
    ("capsulorhexis", &["run.dt=5"]),
    ("capsulorhexis-rescue", &[]),
    ("capsulorhexis-runout", &[]),
];

/// A run to its end.
struct Course {
    figures: CourseFigures,
    steps: u32,
    /// Steps after which layers were through each other, and the most edges at once.
    crossed: u32,
    most: u32,
}

fn run((scene, changes): Run, has_contact: bool) -> Result<Course, VerifyError> {
    let mut document = Document::named(scene)?;
    for change in changes.iter().chain(has_contact.then_some(&RADIUS)) {
        document.set(change)?;
    }
    let mut instance = document.scene()?.instantiate()?;
    let body = instance.bodies[0];
    let band = instance.simulation.world().get::<&Contact>(body.entity()).ok().and_then(|own| own.self_contact?.band);
    let mut course = TearCourse::new(instance.simulation.world(), body, 0.0);
    let (mut steps, mut crossed, mut most) = (0, 0, 0);
    while !instance.is_finished() {
        instance.advance()?;
        steps += 1;
        let events: Vec<_> = instance.simulation.drain_events().collect();
        if let Some(course) = &mut course {
            course.note(instance.simulation.world(), instance.simulation.time(), &events);
        }
        let now = band.map_or(0, |band| crossings(&instance.simulation, body, band));
        crossed += u32::from(now > 0);
        most = most.max(now);
    }
    let figures = course.map_or_else(CourseFigures::default, |course| course.figures());
    Ok(Course { figures, steps, crossed, most })
}

pub(super) fn run_all(out: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("contact-flap");
    for &case in if out.is_quick() { QUICK } else { ALL } {
        let on = [&[case.0], case.1].concat().join(" ");
        let [without, with] = [run(case, false)?, run(case, true)?];
        let differs = f64::from(u8::from(with.figures.outcome != without.figures.outcome));
        rows.add(format!("another outcome than without contact, {on}"), differs, 0.0, "");
        if let ([Some(a), Some(b)], Outcome::Closed) =
            ([&without, &with].map(|run| run.figures.opening.as_ref()), with.figures.outcome)
        {
            rows.add(
                format!("opening against that without contact, {on}"),
                (b.diameter - a.diameter).abs(),
                0.05,
                "mm",
            );
        }
        let forces = [&without, &with].map(|run| run.figures.force_rms);
        rows.relative(format!("force against that without contact, {on}"), forces[1], forces[0], 0.1);
        // A triangle that is halved at the rim of the band may lie through a layer that it was not kept from.
        let part = f64::from(with.crossed) / f64::from(with.steps);
        rows.ratio(format!("steps with crossings of up to {} edges, {on}", with.most), part, 0.01);
    }
    rows.finish()
}
