//! Likely slips of a scene but for those that it allows, and contacts that it does not ask for.

use super::error::Fault;
use super::instance::{Instance, Run};
use super::schema::Mode;
use rhexis::components::{Body, Contact, Obstacle, Planar, Pressure, TearLog};
use rhexis::simulation::{Doubt, DoubtKind, Simulation};
use rhexis::storage::{BodyId, Topology};

/// The likely slips of a scene that it does not allow, each with the key that does.
pub(super) fn of(simulation: &Simulation, run: Run, allow: &[String]) -> Result<Vec<Doubt>, Fault> {
    let mut allowed = Vec::new();
    for (i, name) in allow.iter().enumerate() {
        let kind = DoubtKind::ALL.iter().find(|kind| kind.name() == name);
        allowed.push(*kind.ok_or_else(|| {
            let names: Vec<&str> = DoubtKind::ALL.iter().map(|kind| kind.name()).collect();
            let what = format!("there is no doubt `{}`", name.escape_debug());
            Fault::new(format!("scene.allow.{i}"), what, format!("give one of {}", names.join(", ")))
        })?);
    }
    if run.mode == Mode::Static {
        // Time only moves the curves.
        allowed.push(DoubtKind::TimeStep);
    }
    let mut list = simulation.doubts(run.dt, Some(run.dt * run.steps as f64));
    list.retain(|doubt| !allowed.contains(&doubt.kind));
    for Doubt { kind, text, .. } in &mut list {
        text.push_str(&format!(" (if it is meant: `allow = [\"{}\"]` in [scene])", kind.name()));
    }
    Ok(list)
}

/// Contacts that a simulation could have and was not asked for, each with its remedy.
pub(super) fn not_felt(simulation: &Simulation, bodies: &[BodyId]) -> Vec<String> {
    let world = simulation.world();
    let has_obstacles = world.query::<&Obstacle>().iter().next().is_some();
    let (mut of_obstacles, mut of_itself, mut of_others) = (Vec::new(), Vec::new(), Vec::new());
    for body in bodies {
        let mut query = world.query_one::<(&Body, Option<&Contact>, Option<&Planar>)>(body.entity());
        let Ok((body, contact, planar)) = query.get() else { continue };
        if has_obstacles && contact.is_none() {
            of_obstacles.push(format!("`{}`", body.name));
        }
        if planar.is_none() && contact.is_none_or(|contact| contact.self_contact.is_none()) {
            of_itself.push(format!("`{}`", body.name));
        }
        if bodies.len() > 1 && contact.is_none_or(|contact| !contact.between_bodies) {
            of_others.push(format!("`{}`", body.name));
        }
    }
    let mut list = Vec::new();
    if !of_obstacles.is_empty() {
        list.push(format!("obstacles by {}: `contact = {{}}` feels them", of_obstacles.join(", ")));
    }
    if !of_itself.is_empty() {
        let remedy = "`contact = { self_contact = { radius = … } }` keeps layers apart";
        list.push(format!("its own layers by {}: {remedy}", of_itself.join(", ")));
    }
    if !of_others.is_empty() {
        let remedy = "`between_bodies = true` beside `self_contact` in the `contact` of both keeps them apart";
        list.push(format!("other bodies by {}: {remedy}", of_others.join(", ")));
    }
    list
}

impl Instance {
    /// Notes on bodies under pressure that were closed, and are open: the pressure acts on as before.
    pub fn opened_under_pressure(&self) -> Vec<String> {
        let world = self.simulation.world();
        let note = |(body, mesh): (&BodyId, &super::MeshSummary)| {
            let mut query = world.query_one::<(&Body, &Topology, &Pressure)>(body.entity());
            let (about, topology, _) = query.get().ok()?;
            let has_rim = topology.neighbours.iter().flatten().any(|across| *across == u32::MAX);
            (mesh.boundary_loops == 0 && has_rim).then(|| {
                format!(
                    "{}: the closed body was opened, and its pressure still acts as given: nothing leaks out; end it by its curve, or give a `compartment` with a `leak`",
                    about.name
                )
            })
        };
        self.bodies.iter().zip(&self.meshes).filter_map(note).collect()
    }

    /// Notes on fragments of bodies under pressure, on which none acts any more.
    pub fn fragments_under_pressure(&self) -> Vec<String> {
        let note = |body: &BodyId| {
            let mut query = self.simulation.world().query_one::<(&Body, &TearLog, &Pressure)>(body.entity());
            let (about, log, _) = query.get().ok()?;
            (log.fragment_count > 0).then(|| {
                let count = log.fragment_count;
                format!("{}: {count} fragment(s) came free: the pressure acts on the largest piece alone", about.name)
            })
        };
        self.bodies.iter().filter_map(note).collect()
    }
}
