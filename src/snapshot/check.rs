//! Validation of a state that was read or is to be written, so that steps meet only states that a step could have left.

use super::{Contents, Saved, SnapshotError};
use crate::components::check::{Host, MOST_COUNTED};
use crate::components::{Body, BodyError, TearDecision};
use crate::storage::{Topology, validate};
use hecs::Entity;
use std::collections::HashSet;

/// Validates a state that was read, and derives the data that follow from the rest of it.
pub(super) fn complete(contents: &mut Contents) -> Result<(), SnapshotError> {
    let topologies = validate_contents(contents)?;
    contents.entities.iter_mut().zip(topologies).for_each(|(saved, topology)| saved.topology = topology);
    Ok(())
}

/// Judges a state. Gives the topology of every entity's mesh.
pub(super) fn validate_contents(contents: &Contents) -> Result<Vec<Option<Topology>>, SnapshotError> {
    contents.settings.validate()?;
    let of_all = |what| SnapshotError::contradiction("the snapshot", what);
    if !contents.report.time.is_finite() || contents.report.step > u64::MAX / 2 {
        return Err(of_all("its time or its step is out of range"));
    }
    check_handles(contents)?;
    let mut orders = HashSet::new();
    let judged = |saved: &Saved| match &saved.body {
        Some(Body { order, .. }) => {
            if !orders.insert(*order) || *order >= contents.next_order || u64::from(contents.next_order) > MOST_COUNTED
            {
                return Err(of_all("its bodies are not in one order"));
            }
            check_body(saved).map(Some)
        }
        None if saved.obstacle.is_none() && saved.forceps.is_none() && saved.blade.is_none() => {
            Err(of_all("an entity is neither a body nor an obstacle nor a tool"))
        }
        None if saved.vertices.is_some() || saved.solve.is_some() || saved.increment.is_some() => {
            Err(of_all("an obstacle or a tool has what only bodies have"))
        }
        None => {
            let owner = if saved.obstacle.is_some() { "an obstacle" } else { "a tool" };
            let refused = |source| SnapshotError::Component { owner: owner.to_owned(), source };
            saved.check(&Host::default()).map_err(refused).map(|()| None)
        }
    };
    contents.entities.iter().map(judged).collect()
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
pub(crate) fn check_spawned(saved: &Saved) -> Result<Topology, SnapshotError> {
    let is_known = saved.body.as_ref().is_some_and(|body| u64::from(body.order) < MOST_COUNTED);
    // A table of handles is as long as the largest of them.
    let is_near = u64::from(saved.entity.id()) < MOST_COUNTED >> 6;
    if !(is_known && is_near) {
        return Err(SnapshotError::contradiction("a body that was spawned", "it is none"));
    }
    check_body(saved)
}

/// Judges a body. Gives the topology of its mesh.
fn check_body(saved: &Saved) -> Result<Topology, SnapshotError> {
    let name = || saved.body.as_ref().map_or(String::new(), |body| body.name.clone());
    let wrong = |what| SnapshotError::contradiction(format!("body `{}`", name()), what);
    let refused = |source: BodyError| SnapshotError::Body { body: name(), source };
    let broken = |source| refused(BodyError::Topology(source));
    let (Some(vertices), Some(triangles)) = (&saved.vertices, &saved.triangles) else {
        return Err(wrong("it has no mesh"));
    };
    let topology = Topology::new(vertices.len(), &triangles.corners).map_err(broken)?;
    saved.check(&Host::new(Some(vertices), Some((triangles, &topology)))).map_err(refused)?;
    validate(vertices, triangles, &topology).map_err(broken)?;
    let (Some(_), Some(_), Some(factor), Some(_), Some(_)) =
        (&saved.increment, &saved.solve, &saved.factor, &saved.tail.mixed, &saved.tear_log)
    else {
        return Err(wrong("a part is missing that every body has"));
    };
    if !factor.is_sound() {
        return Err(wrong("its Cholesky factor is of no mesh"));
    }
    if saved.tail.relaxation.is_some() {
        let is_known = saved.tail.creep.iter().all(|list| {
            list.len() == triangles.len() && list.iter().all(|strain| strain.to_array().iter().all(|x| x.is_finite()))
        });
        if !is_known {
            return Err(wrong("the history of its relaxation is none of its triangles"));
        }
    }
    if saved.tail.compartment.is_some() != saved.tail.contents.is_some() {
        return Err(wrong("its compartment has no content, or a content no compartment"));
    }
    // One that sleeps keeps its decisions, of which no step asks anew.
    let asks = |decision: &TearDecision| !(decision.value <= 1.0);
    if saved.sleeping.as_ref().is_some_and(|sleeping| sleeping.is_asleep())
        && let Some(decisions) = &saved.tear_decisions
        && (decisions.tips.iter().flatten().any(asks)
            || decisions.nucleation.is_some()
            || decisions.ligament_failure.is_some())
    {
        return Err(wrong("it sleeps although it is to tear"));
    }
    Ok(topology)
}
