//! What is judged of a state that was read, so that no step can meet what its own kind would not have left.

use super::{Contents, Saved, SnapshotError};
use crate::components::{Blade, Body, Forceps, Grips, Increment, Jaws, Motion, Pinch, TearDecision};
use crate::membrane::Membrane;
use crate::simulation::check_settings;
use crate::storage::{Broken, Topology, Triangles, Vertices, validate};
use hecs::Entity;
use std::collections::HashSet;

/// More of anything than a run can count to: beyond, a sum would run over.
const MOST: u64 = 1 << 30;

/// Judges a state, and fills in what follows from the rest of it.
pub(super) fn complete(contents: &mut Contents) -> Result<(), SnapshotError> {
    check_settings(&contents.settings)?;
    let of_all = |what| SnapshotError::contradiction("the snapshot", what);
    if !contents.report.time.is_finite() || contents.report.step > u64::MAX / 2 {
        return Err(of_all("its time or its step is out of range"));
    }
    check_handles(contents)?;
    let mut orders = HashSet::new();
    for saved in &mut contents.entities {
        match &saved.body {
            Some(Body { order, .. }) => {
                if !orders.insert(*order) || *order >= contents.next_order || u64::from(contents.next_order) > MOST {
                    return Err(of_all("its bodies are not in one order"));
                }
                check_body(saved)?;
            }
            None if saved.obstacle.is_none() && saved.forceps.is_none() && saved.blade.is_none() => {
                return Err(of_all("an entity is neither a body nor an obstacle nor a tool"));
            }
            None if saved.vertices.is_some() || saved.scratch.is_some() || saved.increment.is_some() => {
                return Err(of_all("an obstacle or a tool has what only bodies have"));
            }
            None => check_thing(saved).map_err(of_all)?,
        }
    }
    Ok(())
}

/// Judges an obstacle or a tool.
fn check_thing(saved: &Saved) -> Result<(), &'static str> {
    let is_held = |forceps: &Forceps| is_sound(&forceps.motion, &forceps.jaws);
    if !saved.forceps.iter().all(is_held) {
        return Err("forceps are out of range");
    }
    let is_blade = |blade: &Blade| blade.reach > 0.0 && blade.least > 0.0 && blade.from.is_finite();
    saved.blade.iter().all(is_blade).then_some(()).ok_or("a blade is out of range")
}

/// Whether jaws and their motion are such as a host may give.
fn is_sound(motion: &Motion, jaws: &Jaws) -> bool {
    let are_times = motion.start.is_finite() && motion.end.is_finite() && motion.start <= motion.end;
    are_times && motion.from.is_sound() && motion.to.is_sound() && jaws.check().is_ok()
}

/// Every handle once, and none further out than there are: a table as long as the largest is made of them.
fn check_handles(contents: &Contents) -> Result<(), SnapshotError> {
    let handles = &contents.handles;
    let count = contents.entities.len() + handles.others.len() + handles.free.len();
    let others = handles.others.iter().chain(&handles.free).map(|&bits| Entity::from_bits(bits).map(Entity::id));
    let mut seen = HashSet::new();
    let is_right = |id: Option<u32>| id.is_some_and(|id| (id as usize) < count && seen.insert(id));
    let mut all = contents.entities.iter().map(|saved| Some(saved.entity.id())).chain(others);
    all.all(is_right)
        .then_some(())
        .ok_or_else(|| SnapshotError::contradiction("the snapshot", "its handles are not one each"))
}

/// Judges a body that is to be spawned.
pub(crate) fn check_spawned(saved: &mut Saved) -> Result<(), SnapshotError> {
    let is_known = saved.body.as_ref().is_some_and(|body| u64::from(body.order) < MOST);
    // A table of handles is as long as the largest of them.
    let is_near = u64::from(saved.entity.id()) < MOST >> 6;
    if !(is_known && is_near) {
        return Err(SnapshotError::contradiction("a body that was spawned", "it is none"));
    }
    check_body(saved)
}

fn check_body(saved: &mut Saved) -> Result<(), SnapshotError> {
    let name = saved.body.as_ref().map_or(String::new(), |body| body.name.clone());
    let wrong = |what| SnapshotError::contradiction(format!("body `{name}`"), what);
    let broken = |source: Broken| SnapshotError::Mesh { body: name.clone(), source };
    let (Some(vertices), Some(triangles)) = (&saved.vertices, &saved.triangles) else {
        return Err(wrong("it has no mesh"));
    };
    if vertices.len() as u64 > MOST || triangles.len() as u64 > MOST {
        return Err(wrong("its mesh is too large"));
    }
    let misaligned = |table, column| broken(Broken::Misaligned { table, column });
    if let Some(column) = vertices.first_misaligned_column() {
        return Err(misaligned("vertices", column));
    }
    if let Some(column) = triangles.first_misaligned_column() {
        return Err(misaligned("triangles", column));
    }
    let topology = Topology::new(vertices.len(), &triangles.corners).map_err(broken)?;
    validate(vertices, triangles, &topology).map_err(broken)?;
    check_materials(triangles).map_err(wrong)?;
    saved.topology = Some(topology);
    let (Some(increment), Some(_), Some(factor), Some(_), Some(log)) =
        (&saved.increment, &saved.scratch, &saved.factor, &saved.inner, &saved.tear_log)
    else {
        return Err(wrong("a part is missing that every body has"));
    };
    check_increment(increment, vertices).map_err(wrong)?;
    if !factor.is_sound(vertices.len()) {
        return Err(wrong("its Cholesky factor is of no mesh"));
    }
    let counts = [
        log.start_count,
        log.advance_count,
        log.detour_count,
        log.ambiguous_count,
        log.material_force_count,
        log.end_count,
        log.piece_count,
        log.refusal_count,
        log.held_shut_count,
    ];
    if counts.iter().any(|&count| u64::from(count) > MOST) || !log.length.is_finite() {
        return Err(wrong("its log counts what no run can do"));
    }
    check_rows(saved, vertices.len()).map_err(wrong)?;
    check_states(saved).map_err(wrong)?;
    let rest = vertices.rest_position.clone();
    let parameters = Membrane::of_components(name.clone(), rest, saved.clone().into_components());
    parameters.check_components().map_err(|source| SnapshotError::Body { body: name, source })
}

fn check_materials(triangles: &Triangles) -> Result<(), &'static str> {
    for t in 0..triangles.len() {
        let q = &triangles.stiffness[t];
        let is_stiff = q.q11 > 0.0 && q.q22 > 0.0 && q.q66 > 0.0 && q.q11 * q.q22 > q.q12 * q.q12;
        let is_finite = [q.q11, q.q22, q.q12, q.q66].iter().all(|q| q.is_finite());
        // Unit vectors are so to a few roundings.
        let is_unit = (triangles.fibre[t].length() - 1.0).abs() < 1e-9;
        if !(is_stiff && is_finite && is_unit && triangles.thickness[t] > 0.0 && triangles.density[t] > 0.0) {
            return Err("a triangle's material is none");
        }
    }
    Ok(())
}

fn check_increment(increment: &Increment, vertices: &Vertices) -> Result<(), &'static str> {
    let Increment { start, start_velocity, displacement, delta, .. } = increment;
    // Before the first step there is none.
    let is_sized = |values: &Vec<_>| values.is_empty() || values.len() == vertices.len();
    if start.len() != start_velocity.len() || ![start, displacement].into_iter().all(is_sized) {
        return Err("its step is one of another mesh");
    }
    let mut values = [start, start_velocity, displacement, delta].into_iter().flatten();
    if !values.all(|value| value.is_finite()) || !increment.dt.is_finite() {
        return Err("its step is not finite");
    }
    Ok(())
}

/// Whether every row that a component names is there.
fn check_rows(saved: &Saved, count: usize) -> Result<(), &'static str> {
    let is_there = |&row: &u32| (row as usize) < count;
    let are_there = |is: bool, what| is.then_some(()).ok_or(what);
    if let Some(holds) = &saved.holds {
        let mut rows = holds.groups.iter().flat_map(|group| group.members.rows());
        are_there(rows.all(is_there), "a hold names a vertex that is not there")?;
    }
    if let Some(Grips { list, pinches, grasp_count }) = &saved.grips {
        let mut rows = pinches.iter().flat_map(|pinch| pinch.held.rows());
        are_there(pinches.len() >= list.len() && rows.all(is_there), "a grip names a vertex that is not there")?;
        let is_right = |pinch: &Pinch| is_sound(&pinch.motion, &pinch.jaws) && pinch.origin.is_sound();
        are_there(u64::from(*grasp_count) <= MOST && pinches.iter().all(is_right), "jaws are out of range")?;
    }
    if let Some(loads) = &saved.point_loads {
        let mut rows = loads.groups.iter().flat_map(|load| &load.rows);
        are_there(rows.all(is_there), "a load names a vertex that is not there")?;
    }
    if let Some(loads) = &saved.edge_loads {
        let mut rows = loads.groups.iter().flat_map(|load| load.edges.as_flattened());
        are_there(rows.all(is_there), "a load names a vertex that is not there")?;
    }
    if let Some(tips) = &saved.tips {
        let is_aligned = tips.first_misaligned_column().is_none();
        are_there(is_aligned && tips.vertex.iter().all(is_there), "a tip is at a vertex that is not there")?;
        let mut directions = tips.previous.iter().chain(&tips.ideal);
        are_there(directions.all(|d| d.is_finite()), "a tip has a direction that is none")?;
    }
    Ok(())
}

/// What bodies that sleep, are refined or are solved for remember.
fn check_states(saved: &Saved) -> Result<(), &'static str> {
    if let Some(sleeping) = &saved.sleeping {
        let counts = [sleeping.steps, sleeping.slumber.quiet_steps, sleeping.slumber.wait];
        if counts.iter().any(|&count| u64::from(count) > MOST) {
            return Err("its sleep counts what no run can do");
        }
        // One that sleeps keeps its decisions, of which no step asks anew.
        let asks = |decision: &TearDecision| !(decision.value <= 1.0);
        if sleeping.is_asleep()
            && let Some(decisions) = &saved.tear_decisions
            && (decisions.tips.iter().flatten().any(asks) || decisions.start.is_some())
        {
            return Err("it sleeps although it is to tear");
        }
    }
    if let Some(refined) = &saved.refined
        && (refined.start_count as u64 > MOST || refined.added.unsigned_abs() > MOST)
    {
        return Err("its refinement counts what no run can do");
    }
    Ok(())
}
