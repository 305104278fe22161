//! Opening the edges along a path.
//!
//! Duplicating a vertex once per component of its fan leaves one fan per vertex, so no bowtie can remain. Every edge of the path
//! ends in a duplicated vertex, unless the path is a single edge with both ends inside, which is refused.

use super::{Draft, are_vertices};
use crate::storage::{Mesh, Parents, Refusal, TriangleRow, VertexRow};
use smallvec::SmallVec;

pub(super) fn open(mesh: &Mesh<'_>, path: &[u32]) -> Result<Draft, Refusal> {
    check(mesh, path)?;
    let is_cut = |a: u32, b: u32| path.windows(2).any(|p| (p[0], p[1]) == (a, b) || (p[1], p[0]) == (a, b));
    let is_loop = path.first() == path.last();
    let vertices = if is_loop { &path[1..] } else { path };

    let mut draft = Draft::default();
    for &vertex in vertices {
        for component in extra_components(mesh, vertex, is_cut) {
            let row = (mesh.vertices.len() + draft.new_vertices.len()) as u32;
            let copy = VertexRow { mass: 0.0, ..mesh.vertices.at(vertex) };
            draft.new_vertices.push((Parents::duplicate(vertex), copy));
            for (triangle, corner) in component {
                changed_row(mesh, &mut draft, triangle).corners[corner] = row;
            }
        }
    }
    if draft.new_vertices.is_empty() {
        return Err(Refusal::NothingOpens);
    }
    draft.changed.sort_unstable_by_key(|&(t, _)| t);
    Ok(draft)
}

fn check(mesh: &Mesh<'_>, path: &[u32]) -> Result<(), Refusal> {
    are_vertices(mesh, path)?;
    let is_loop = path.len() > 3 && path.first() == path.last();
    let simple = if is_loop { &path[1..] } else { path };
    let repeats = simple.iter().enumerate().any(|(i, v)| simple[..i].contains(v));
    if path.len() < 2 || repeats {
        return Err(Refusal::BadPath { count: path.len() });
    }
    for edge in path.windows(2) {
        let (from, to) = (edge[0], edge[1]);
        let there = mesh.topology.directed_edge(&mesh.triangles.corners, from, to);
        let back = mesh.topology.directed_edge(&mesh.triangles.corners, to, from);
        match (there, back) {
            (Some(_), Some(_)) => {}
            (None, None) => return Err(Refusal::NoSuchEdge { from, to }),
            _ => return Err(Refusal::BoundaryEdge { from, to }),
        }
    }
    Ok(())
}

type Sectors = SmallVec<[(u32, usize); 12]>;

/// The components into which the cut edges part a vertex's fan, without the one that keeps the vertex (that with the
/// lowest triangle row), in the order of their lowest rows.
fn extra_components(mesh: &Mesh<'_>, vertex: u32, is_cut: impl Fn(u32, u32) -> bool) -> SmallVec<[Sectors; 2]> {
    let fan = mesh.topology.fan(vertex);
    let mut components: SmallVec<[Sectors; 2]> = SmallVec::new();
    components.push(Sectors::new());
    let mut is_last_cut = false;
    for &(triangle, corner) in &fan.sectors {
        if is_last_cut {
            components.push(Sectors::new());
        }
        if let Some(component) = components.last_mut() {
            component.push((triangle, corner));
        }
        is_last_cut = is_cut(vertex, mesh.triangles.corners[triangle as usize][(corner + 2) % 3]);
    }
    if fan.is_closed && !is_last_cut && components.len() > 1 {
        let tail = components.pop().unwrap_or_default();
        components[0].extend(tail);
    }
    components.sort_by_key(|component| component.iter().map(|&(triangle, _)| triangle).min());
    components.remove(0);
    components
}

fn changed_row<'d>(mesh: &Mesh<'_>, draft: &'d mut Draft, triangle: u32) -> &'d mut TriangleRow {
    let place = draft.changed.iter().position(|&(t, _)| t == triangle).unwrap_or_else(|| {
        draft.changed.push((triangle, mesh.triangles.at(triangle)));
        draft.changed.len() - 1
    });
    &mut draft.changed[place].1
}
