//! What is noted of every step: the rows of `series.csv` and the figures that the report adds up.

use glam::DVec3;
use rhexis::components::{Contact, EnergyBalance, EnergyCriterion, Grips, Holds, TearLog};
use rhexis::report::BodyReport;
use rhexis::storage::Tips;
use rhexis_scene::{Instance, Probe, ProbeKind};
use std::ops::Range;

/// The state after a step. The bodies' figures are added up; a named force keeps its body's name.
#[derive(Clone, Debug, Default)]
pub(super) struct Observation {
    /// Steps of the scene done.
    pub step: u64,
    /// Simulated time \[ms\].
    pub time: f64,
    /// Linear iterations of the step.
    pub iterations: u32,
    /// Newton iterations of the step.
    pub newton_iterations: u32,
    /// Largest relative residual of the last linear solves.
    pub residual: f64,
    /// Elastic energy \[mJ\].
    pub elastic: f64,
    /// Kinetic energy \[mJ\].
    pub kinetic: f64,
    /// Length torn or cut \[mm, rest shape\].
    pub torn: f64,
    /// Tips alive.
    pub tips: usize,
    /// Advances of tips in the step.
    pub advances: u32,
    /// Largest criterion value at a tip.
    pub criterion: f64,
    /// Largest energy released per area of tear at a tip, in its last direction, by the material force \[N/mm\].
    pub release: f64,
    /// Sums of the bodies' energy balances, where they are kept.
    pub balance: Option<EnergyBalance>,
    /// Each body's balance of energy, where it is kept, in the order of the scene's bodies.
    pub balances: Vec<Option<EnergyBalance>>,
    /// Surface energy that the toughness of bodies claims for what they have torn \[mJ\], where a body has one.
    pub surface_energy: Option<f64>,
    /// Largest overshoot of the toughness, G/G_c − 1, of the step's advances; none in a step without one.
    pub overshoot: Option<f64>,
    /// Force of every hold on its body \[N\].
    pub reactions: Vec<(String, DVec3)>,
    /// Force of every grip on the tissue \[N\].
    pub grips: Vec<(String, DVec3)>,
    /// Torque of every hold that turns on its body about its pivot, and of every grip that turns about its jaws \[N·mm\].
    pub torques: Vec<(String, DVec3)>,
    /// Position \[mm\] and largest principal stress \[MPa\] of every probe.
    pub probes: Vec<(String, DVec3, f64)>,
    /// Force across every section \[N\].
    pub sections: Vec<(String, DVec3)>,
    /// Force of every obstacle on the bodies \[N\]; none where no body feels them.
    pub obstacles: Vec<(String, DVec3)>,
    /// Centre of mass \[mm\] and velocity \[mm/ms\] of every rigid obstacle.
    pub rigid: Vec<(String, [DVec3; 2])>,
    /// Largest unbalanced force of a body that obstacles may push \[N\].
    pub unbalanced: f64,
    /// Volume \[mm³\], pressure \[MPa\] and leaked volume \[mm³\] of every compartment.
    pub compartments: Vec<(String, [f64; 3])>,
    /// Which of the reactions and which of the grips are those of each body, in the order of the scene's bodies.
    pub own: Vec<[Range<usize>; 2]>,
}

/// Names of forces as they stand in files.
fn named(body: &str, name: &str) -> String {
    format!("{body}/{name}")
}

/// Looks at the simulation as it stands.
pub(super) fn observe(instance: &mut Instance) -> Observation {
    let report = instance.simulation.report();
    let bodies: &[BodyReport] = if report.step == 0 { &[] } else { &report.bodies };
    let mut o = Observation {
        step: instance.step(),
        time: report.time,
        iterations: bodies.iter().map(|b| b.iterations).sum(),
        newton_iterations: bodies.iter().map(|b| b.newton_iterations).max().unwrap_or(0),
        residual: bodies.iter().map(|b| b.residual).fold(0.0, f64::max),
        ..Observation::default()
    };
    for body in instance.bodies.clone() {
        let name = super::report::body_name(instance, body);
        let before = [o.reactions.len(), o.grips.len()];
        let unbalanced = instance.simulation.unbalanced_force(body).ok().flatten();
        o.unbalanced = unbalanced.map_or(o.unbalanced, |force| o.unbalanced.max(force.length()));
        if let Ok(energies) = instance.simulation.energies(body) {
            o.elastic += energies.elastic;
            o.kinetic += energies.kinetic;
        }
        let balance = instance.simulation.energy_balance(body).ok().flatten();
        if let Some(balance) = &balance {
            o.balance.get_or_insert_default().add(balance);
        }
        o.balances.push(balance);
        if let Some(state) = instance.simulation.compartment(body) {
            o.compartments.push((name.clone(), [state.volume, state.pressure, state.leaked]));
        }
        let reactions = instance.simulation.reactions(body).unwrap_or_default();
        let torques = instance.simulation.torques(body).unwrap_or_default();
        o.torques.extend(torques.into_iter().map(|(hold, torque)| (named(&name, &hold), torque)));
        let world = instance.simulation.world();
        if let Ok(holds) = world.get::<&Holds>(body.entity()) {
            // Before the first step there are holds but no reactions yet.
            let forces = reactions.into_iter().map(|(_, force)| force).chain(std::iter::repeat(DVec3::ZERO));
            o.reactions.extend(holds.groups.iter().zip(forces).map(|(hold, force)| (named(&name, &hold.name), force)));
        }
        if let Ok(grips) = world.get::<&Grips>(body.entity()) {
            o.grips.extend(grips.pinches.iter().map(|pinch| (named(&name, &pinch.name), pinch.force)));
            let turning = grips.list.iter().zip(&grips.pinches).filter(|(grip, _)| !grip.turns.points.is_empty());
            o.torques.extend(turning.map(|(_, pinch)| (named(&name, &pinch.name), pinch.torque)));
        }
        o.own.push([before[0]..o.reactions.len(), before[1]..o.grips.len()]);
        if let Ok(log) = world.get::<&TearLog>(body.entity()) {
            o.torn += log.length;
            if world.satisfies::<&EnergyCriterion>(body.entity()) {
                *o.surface_energy.get_or_insert_default() += log.surface_energy.unwrap_or(0.0);
            }
        }
        if let Ok(tips) = world.get::<&Tips>(body.entity()) {
            o.tips += tips.len();
            o.criterion = tips.criterion.iter().copied().fold(o.criterion, f64::max);
        }
        let forces = instance.simulation.material_forces(body).unwrap_or_default();
        o.release = forces.iter().map(|force| force.along).fold(o.release, f64::max);
    }
    let simulation = &instance.simulation;
    for Probe { name, body, kind } in &instance.probes {
        match kind {
            ProbeKind::Point(point) => o.probes.extend(simulation.reading(*body, *point).map(|reading| {
                let stress = reading.stress.principal_values().0;
                (name.clone(), reading.position, stress)
            })),
            ProbeKind::Section(section) => {
                // The body is there, and the scene has judged the plane.
                let force = simulation.section_force(*body, section).unwrap_or(DVec3::NAN);
                o.sections.push((name.clone(), force));
            }
        }
    }
    o.rigid = instance.rigid_obstacles();
    let world = instance.simulation.world();
    if instance.bodies.iter().any(|&body| world.satisfies::<&Contact>(body.entity())) {
        o.obstacles = instance.obstacle_forces();
    }
    o
}

impl Observation {
    /// The columns of `series.csv`.
    pub(crate) fn header(&self) -> Vec<String> {
        let fixed = [
            "step",
            "time_ms",
            "iterations",
            "newton_iterations",
            "residual",
            "elastic_mJ",
            "kinetic_mJ",
            "tear_length_mm",
            "tips",
            "advances",
            "max_criterion",
            "max_release_N_per_mm",
        ];
        let mut header: Vec<String> = fixed.map(str::to_owned).to_vec();
        let balance = self.balance.iter().flat_map(EnergyBalance::terms);
        header.extend(balance.map(|(name, _)| format!("{name}_mJ")));
        header.extend(self.balance.map(|_| "dissipated_mJ".to_owned()));
        for (name, _) in &self.compartments {
            header.extend(["volume_mm3", "pressure_MPa", "leaked_mm3"].map(|column| format!("{name}/{column}")));
        }
        if self.surface_energy.is_some() {
            header.extend(["of_which_surface_energy_mJ", "max_overshoot"].map(str::to_owned));
        }
        for (name, _) in self.reactions.iter().chain(&self.grips).chain(&self.obstacles) {
            header.extend(["x", "y", "z"].map(|axis| format!("{name}_{axis}_N")));
        }
        for (name, _) in &self.torques {
            header.extend(["x", "y", "z"].map(|axis| format!("{name}_torque_{axis}_Nmm")));
        }
        for (name, ..) in &self.probes {
            header.extend(["x_mm", "y_mm", "z_mm", "stress_MPa"].map(|column| format!("{name}/{column}")));
        }
        for (name, _) in &self.sections {
            header.extend(["x", "y", "z"].map(|axis| format!("{name}/force_{axis}_N")));
        }
        for (name, _) in &self.rigid {
            header.extend(["x", "y", "z"].map(|axis| format!("{name}_{axis}_mm")));
            header.extend(["x", "y", "z"].map(|axis| format!("{name}_velocity_{axis}_mm_per_ms")));
        }
        if !self.obstacles.is_empty() {
            header.push("unbalanced_force_N".to_owned());
        }
        header
    }

    /// The row under [`header`](Self::header). Shortest text that reads back as the same bits.
    pub(crate) fn row(&self) -> Vec<String> {
        let mut row = vec![
            self.step.to_string(),
            self.time.to_string(),
            self.iterations.to_string(),
            self.newton_iterations.to_string(),
            format!("{:e}", self.residual),
            format!("{:e}", self.elastic),
            format!("{:e}", self.kinetic),
            self.torn.to_string(),
            self.tips.to_string(),
            self.advances.to_string(),
            self.criterion.to_string(),
            format!("{:e}", self.release),
        ];
        row.extend(self.balance.iter().flat_map(EnergyBalance::terms).map(|(_, term)| format!("{term:e}")));
        row.extend(self.balance.map(|balance| format!("{:e}", balance.dissipated())));
        for (_, figures) in &self.compartments {
            row.extend(figures.map(|figure| format!("{figure:e}")));
        }
        if let Some(energy) = self.surface_energy {
            // A step without an advance has no overshoot, which is not one of zero.
            row.extend([format!("{energy:e}"), self.overshoot.unwrap_or(f64::NAN).to_string()]);
        }
        for (_, force) in self.reactions.iter().chain(&self.grips).chain(&self.obstacles) {
            row.extend(force.to_array().map(|f| format!("{f:e}")));
        }
        for (_, torque) in &self.torques {
            row.extend(torque.to_array().map(|t| format!("{t:e}")));
        }
        for (_, position, stress) in &self.probes {
            row.extend(position.to_array().into_iter().chain([*stress]).map(|value| format!("{value:e}")));
        }
        for (_, force) in &self.sections {
            row.extend(force.to_array().map(|f| format!("{f:e}")));
        }
        for (_, motion) in &self.rigid {
            row.extend(motion.iter().flat_map(DVec3::to_array).map(|value| format!("{value:e}")));
        }
        if !self.obstacles.is_empty() {
            row.push(format!("{:e}", self.unbalanced));
        }
        row
    }
}
