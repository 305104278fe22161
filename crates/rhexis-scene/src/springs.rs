//! What is shared by rest area: springs to ground and total forces.

use super::error::{Fault, not_negative, positive};
use super::region::Surface;
use super::schema::{BodySpec, PointLoadSpec};
use rhexis::components::{Anchor, Bond, PointLoad, Springs};
use rhexis::storage::{Attached, TriangleMesh};
use std::collections::BTreeMap;

/// All groups of springs and beds as one set: where two groups of springs meet at a vertex, their stiffnesses add.
pub(super) fn springs(
    spec: &BodySpec,
    mesh: &TriangleMesh,
    surface: &Surface<'_>,
    key: &str,
) -> Result<Springs, Fault> {
    let mut stiffness: BTreeMap<u32, f64> = BTreeMap::new();
    for (i, group) in spec.springs.iter().enumerate() {
        let key = format!("{key}.springs.{i}");
        let rows = surface.vertices(&group.region, &format!("{key}.region"))?;
        let per_area = match (group.total, group.per_area) {
            (Some(total), None) => not_negative(format!("{key}.total"), total, "N/mm")? / tributary_area(mesh, &rows),
            (None, Some(per_area)) => not_negative(format!("{key}.per_area"), per_area, "N/mm³")?,
            _ => {
                let what = "the stiffness is given twice or not at all";
                return Err(Fault::new(key, what, "give either `total` [N/mm] or `per_area` [N/mm³]"));
            }
        };
        rows.into_iter().for_each(|row| *stiffness.entry(row).or_default() += per_area);
    }
    let anchor = |(row, stiffness)| (row, Anchor::new(mesh.positions[row as usize], stiffness));
    let mut anchors: BTreeMap<u32, Anchor> = stiffness.into_iter().map(anchor).collect();
    for (i, bed) in spec.beds.iter().enumerate() {
        let key = format!("{key}.beds.{i}");
        let (energy, strength) = (
            positive(format!("{key}.energy"), bed.energy, "N/mm")?,
            positive(format!("{key}.strength"), bed.strength, "MPa")?,
        );
        let bond = Bond::new(strength, energy);
        let stiffness = bed.stiffness.unwrap_or(bond.usual_stiffness());
        if !(stiffness >= 0.1 * bond.usual_stiffness() && stiffness.is_finite()) {
            let what = format!("{stiffness} N/mm³ take more than the energy before the strength is reached");
            return Err(Fault::new(
                format!("{key}.stiffness"),
                what,
                "leave it out, or give strength² / (2 · energy) or more",
            ));
        }
        for row in surface.vertices(&bed.region, &format!("{key}.region"))? {
            let anchor = Anchor { point: mesh.positions[row as usize], stiffness, bond: Some(bond) };
            if anchors.insert(row, anchor).is_some() {
                let what = format!("vertex {row} has springs or another bed already");
                return Err(Fault::new(
                    format!("{key}.region"),
                    what,
                    "let the regions of springs and beds share no vertex",
                ));
            }
        }
    }
    Ok(Springs { anchors: Attached::new(anchors) })
}

/// A third of the rest area of the triangles at each of the vertices \[mm²\]; rows ascend.
fn tributary_area(mesh: &TriangleMesh, rows: &[u32]) -> f64 {
    let parts = mesh.triangles.iter().map(|corners| {
        let [a, b, c] = corners.map(|v| mesh.positions[v as usize]);
        let members = corners.iter().filter(|v| rows.binary_search(v).is_ok()).count();
        (b - a).cross(c - a).length() / 6.0 * members as f64
    });
    parts.sum()
}

/// The groups of one of `[[bodies.point_loads]]`; a total force has one for each share.
pub(super) fn point_loads(
    load: &PointLoadSpec,
    mesh: &TriangleMesh,
    surface: &Surface<'_>,
    key: &str,
) -> Result<Vec<PointLoad>, Fault> {
    let rows = surface.vertices(&load.region, &format!("{key}.region"))?;
    let curve = || load.curve.0.clone();
    match (load.force, load.total) {
        (Some(force), None) => Ok(vec![PointLoad { rows, force: force.0, curve: curve() }]),
        (None, Some(total)) => {
            let whole = tributary_area(mesh, &rows);
            let mut areas = vec![0.0; rows.len()];
            for corners in &mesh.triangles {
                let [a, b, c] = corners.map(|v| mesh.positions[v as usize]);
                let third = (b - a).cross(c - a).length() / 6.0;
                corners.iter().filter_map(|v| rows.binary_search(v).ok()).for_each(|at| areas[at] += third);
            }
            // Equal shares are one group; areas are positive, so that their bits are in their order.
            let mut shares: BTreeMap<u64, Vec<u32>> = BTreeMap::new();
            for (row, area) in rows.into_iter().zip(areas) {
                shares.entry((area / whole).to_bits()).or_default().push(row);
            }
            let group = |(share, rows)| PointLoad { rows, force: total.0 * f64::from_bits(share), curve: curve() };
            Ok(shares.into_iter().map(group).collect())
        }
        _ => {
            let what = "the force is given twice or not at all";
            Err(Fault::new(key, what, "give either `force` on each vertex or `total` on all of them [N]"))
        }
    }
}
