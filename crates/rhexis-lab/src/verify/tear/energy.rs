//! The energy balance of whole tears, dynamic and quasi-static: every term of the audit, and what each advance releases.

use crate::verify::{Artifacts, Axes, Line, Row, Rows, VerifyError, largest};
use glam::DVec2;
use rhexis::components::EnergyBalance;
use rhexis::event::EventKind;
use rhexis::simulation::SimulationError;
use rhexis_scene::{Document, Instance};

/// Thickness of the sheets of the catalog's tears \[mm\].
const THICKNESS: f64 = 0.1;

/// A tear from the catalog.
struct Tear {
    name: &'static str,
    scene: &'static str,
    /// Load steps of the static tear \[ms\]; the dynamic ones take the scene's.
    dt: Option<f64>,
}

pub(crate) fn run(out: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("tear-energy");
    for tear in [
        Tear { name: "45°, dynamic", scene: "fig2-tear", dt: None },
        Tear { name: "isotropic, dynamic", scene: "fig2-tear-iso", dt: None },
        // 0.075 mm per load step, two and a half times the scene's.
        Tear { name: "45°, quasi-static", scene: "fig2-tear-stable", dt: Some(25.0) },
    ] {
        let course = tear.run(if out.is_quick() { [20, 17] } else { [60, 50] })?;
        course.judge(&mut rows, &tear);
        let title = format!("energy balance, {} ({})", tear.name, tear.scene);
        let axes = Axes { title: &title, names: ["time [ms]", "energy [mJ]"], is_isometric: false };
        out.plot(&format!("tear-energy-{}", tear.scene), axes, &course.curves())?;
    }
    rows.finish()
}

/// The balance after every step, and what advances have released, with their lengths.
struct Course {
    balances: Vec<(f64, EnergyBalance)>,
    released: Vec<[f64; 2]>,
    is_torn: bool,
}

impl Tear {
    fn run(&self, [nx, ny]: [usize; 2]) -> Result<Course, VerifyError> {
        let mut document = Document::named(self.scene)?;
        document.set(&format!("bodies.0.mesh.grid.nx={nx}"))?;
        document.set(&format!("bodies.0.mesh.grid.ny={ny}"))?;
        document.set("output.energy=true")?;
        ["run.threads=1", "run.advanced.preconditioner=cholesky"]
            .into_iter()
            .try_for_each(|change| document.set(change))?;
        if let Some(dt) = self.dt {
            document.set(&format!("run.dt={dt}"))?;
        }
        let mut instance: Instance = document.scene()?.instantiate()?;
        let mut course = Course { balances: Vec::new(), released: Vec::new(), is_torn: false };
        let body = instance.bodies[0];
        while !instance.is_finished() {
            instance.advance()?;
            let balance = instance.simulation.energy_balance(body)?.ok_or(SimulationError::NoSuchBody)?;
            course.balances.push((instance.simulation.time(), balance));
            for event in instance.simulation.drain_events() {
                match event.kind {
                    EventKind::Released { energy, length } => course.released.push([energy, length]),
                    EventKind::Ended { .. } => course.is_torn = true,
                    _ => {}
                }
            }
        }
        Ok(course)
    }
}

impl Course {
    fn judge(&self, rows: &mut Rows, tear: &Tear) {
        let what = |text: &str| format!("{}: {text}", tear.name);
        let Some(&(time, end)) = self.balances.last() else { return };
        rows.ratio(what("not torn through"), f64::from(u8::from(!self.is_torn)), 0.0);
        // Every term is exact but for rounding and the quadrature of the true force, which is off where a step carries a
        // triangle through large strains at once: 2e-11 where the isotropic sheet springs open in one step.
        let off = |(_, b): &(f64, EnergyBalance)| b.imbalance().abs() / b.work().abs();
        rows.ratio(what("imbalance over the work, worst moment"), largest(self.balances.iter().map(off)), 1e-8);
        rows.ratio(what("imbalance over the work, at the end"), off(&(time, end)), 1e-8);
        let dissipated = self.balances.iter().map(|(_, b)| (-b.damping.min(b.drag).min(b.numerical_kinetic)).max(0.0));
        rows.add(what("energy made by damping, drag or inertia"), largest(dissipated), 0.0, "mJ");
        for (name, term) in end.terms() {
            rows.note(what(&name.replace('_', " ")), term, "mJ");
        }
        if self.released.is_empty() {
            return;
        }
        let energies = self.released.iter().map(|r| r[0]);
        let total: f64 = energies.clone().sum();
        let rates: Vec<f64> = self.released.iter().map(|[energy, length]| energy / (THICKNESS * length)).collect();
        // The difference of energies that the events tell, against the works: the grips', by the trapezoidal rule over load
        // steps of 0.075 mm, and those of the freed forces, to the equilibria's 1e-9 of the largest force.
        rows.relative(
            what("energy released by the advances, against work less elastic energy"),
            total,
            end.work() - end.stored.elastic,
            1e-2,
        );
        let freed = end.released - end.edits.elastic;
        rows.relative(what("energy released by the advances, against work of the freed forces"), total, freed, 1e-6);
        let gained = rates.iter().map(|rate| (-rate).max(0.0));
        rows.add(what("energy taken up by an advance, per area torn"), largest(gained), 0.0, "N/mm");
        let by_size = |pick: fn(f64, f64) -> f64, start: f64| rates.iter().copied().fold(start, pick);
        rows.note(what("energy released per area torn, least"), by_size(f64::min, f64::INFINITY), "N/mm");
        rows.note(what("energy released per area torn, most"), by_size(f64::max, 0.0), "N/mm");
        let length: f64 = self.released.iter().map(|r| r[1]).sum();
        rows.note(what("energy released per area torn, mean"), total / (THICKNESS * length), "N/mm");
        rows.note(what("equilibria after advances"), self.released.len() as f64, "1");
    }

    fn curves(&self) -> Vec<Line> {
        type Term = fn(&EnergyBalance) -> f64;
        let terms: [(&str, Term); 7] = [
            ("work", EnergyBalance::work),
            ("elastic", |b| b.stored.elastic),
            ("kinetic", |b| b.stored.kinetic),
            ("damping", |b| b.damping),
            ("numerical", EnergyBalance::numerical),
            ("released", |b| b.released),
            ("edits", |b| b.edits.elastic + b.edits.kinetic),
        ];
        let line = |&(name, term): &(&str, Term)| Line {
            name: name.to_owned(),
            points: self.balances.iter().map(|(time, b)| DVec2::new(*time, term(b))).collect(),
        };
        terms.iter().map(line).collect()
    }
}
