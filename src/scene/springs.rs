//! Springs to ground, from `[[bodies.springs]]`.

use super::error::{Fault, not_negative};
use super::region::Surface;
use super::schema::BodySpec;
use crate::components::{Anchor, Springs};
use crate::storage::{Attached, TriangleMesh};
use std::collections::BTreeMap;

/// All groups of springs as one set: where two groups meet at a vertex, their stiffnesses add.
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
    let anchor = |(row, stiffness)| (row, Anchor { point: mesh.positions[row as usize], stiffness });
    Ok(Springs { anchors: Attached::new(stiffness.into_iter().map(anchor)) })
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
