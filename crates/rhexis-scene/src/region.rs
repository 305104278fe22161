//! Which vertices of a rest mesh a region selects.

use super::error::Fault;
use super::mesh_file::{Array, MeshFile, On};
use super::schema::{ArrayRangeSpec, Exactly, RegionSpec};
use glam::DVec3;
use rhexis::storage::TriangleMesh;

/// Widens ranges by default \[mm\]: more than the rounding of a generated coordinate, less than any edge.
const TOLERANCE: f64 = 1e-6;

/// Extent \[mm\] of a body that is likely to be in metres.
const SMALL: f64 = 0.1;

/// A rest mesh with its boundary, to be selected from.
pub(super) struct Surface<'a> {
    mesh: &'a TriangleMesh,
    file: &'a MeshFile,
    boundary_edges: Vec<[u32; 2]>,
    is_boundary: Vec<bool>,
}

impl<'a> Surface<'a> {
    /// Finds the boundary: the edges that belong to one triangle, in ascending order of their ends.
    pub(crate) fn new(file: &'a MeshFile) -> Self {
        let mesh = &file.mesh;
        let mut edges: Vec<[u32; 2]> = Vec::with_capacity(3 * mesh.triangles.len());
        for &[a, b, c] in &mesh.triangles {
            edges.extend([[a, b], [b, c], [c, a]].map(|[a, b]| [a.min(b), a.max(b)]));
        }
        edges.sort_unstable();
        let single = edges.chunk_by(|a, b| a == b).filter(|same| same.len() == 1);
        let boundary_edges: Vec<[u32; 2]> = single.map(|same| same[0]).collect();
        let mut is_boundary = vec![false; mesh.positions.len()];
        boundary_edges.iter().flatten().for_each(|&v| is_boundary[v as usize] = true);
        Self { mesh, file, boundary_edges, is_boundary }
    }

    /// The vertices of a region, ascending; never none.
    pub(crate) fn vertices(&self, region: &RegionSpec, key: &str) -> Result<Vec<u32>, Fault> {
        let is_inside = self.mask(region, key)?;
        let rows: Vec<u32> = (0..).zip(&is_inside).filter(|(_, inside)| **inside).map(|(row, _)| row).collect();
        if rows.is_empty() {
            return Err(self.selects_none("vertex", key));
        }
        Ok(rows)
    }

    /// The boundary edges with both ends in a region; never none.
    pub(crate) fn edges(&self, region: &RegionSpec, key: &str) -> Result<Vec<[u32; 2]>, Fault> {
        let is_inside = self.mask(region, key)?;
        let within = self.boundary_edges.iter().filter(|edge| edge.iter().all(|&v| is_inside[v as usize]));
        let edges: Vec<[u32; 2]> = within.copied().collect();
        if edges.is_empty() {
            return Err(self.selects_none("boundary edge", key));
        }
        Ok(edges)
    }

    /// Least and greatest coordinates \[mm\].
    pub(crate) fn bounds(&self) -> (DVec3, DVec3) {
        let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        self.mesh.positions.iter().fold(start, |(low, high), p| (low.min(*p), high.max(*p)))
    }

    fn selects_none(&self, what: &str, key: &str) -> Fault {
        let (low, high) = self.bounds();
        let spans = format!(
            "selects no {what}: the body spans x {} to {}, y {} to {}, z {} to {} mm",
            low.x, high.x, low.y, high.y, low.z, high.z
        );
        let units = if (high - low).max_element() < SMALL {
            "; lengths are in mm: for a mesh in metres give `unit = \"m\"` in its table"
        } else {
            ""
        };
        let hint = format!("move the region onto the body, or widen `tolerance` to reach the nearest vertices{units}");
        Fault::new(key, spans, hint)
    }

    /// The vertices of a list, ascending.
    fn listed(&self, region: &RegionSpec, key: &str) -> Result<Option<Vec<u32>>, Fault> {
        let Some(mut rows) = region.vertices.clone() else { return Ok(None) };
        let count = self.mesh.positions.len();
        if let Some(i) = rows.iter().position(|&row| row as usize >= count) {
            let what = format!("there is no vertex {}: the mesh has {count}", rows[i]);
            return Err(Fault::new(format!("{key}.vertices.{i}"), what, "count from 0, in the order of the mesh"));
        }
        rows.sort_unstable();
        Ok(Some(rows))
    }

    /// The vertices of a group of the mesh file, ascending.
    fn grouped(&self, region: &RegionSpec, key: &str) -> Result<Option<&'a [u32]>, Fault> {
        let Some(name) = &region.group else { return Ok(None) };
        if let Some((_, rows)) = self.file.groups.iter().find(|(own, _)| own == name) {
            return Ok(Some(rows));
        }
        let names: Vec<String> = self.file.groups.iter().map(|(own, _)| format!("{own:?}")).collect();
        let has = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
        let what = format!("the mesh has no group {name:?}: it has {has}");
        let hint = match super::nearest(name, self.file.groups.iter().map(|(own, _)| own.as_str())) {
            Some(near) => format!("did you mean {near:?}?"),
            None if names.is_empty() => {
                "groups are those of Gmsh, OBJ and glTF files; give `vertices`, `box`, `sphere` or ranges of x, y, z"
                    .into()
            }
            None => "name one of these".into(),
        };
        Err(Fault::new(format!("{key}.group"), what, hint))
    }

    /// Which vertices have such values in an array of the mesh file, or a triangle with such a value.
    fn valued(&self, array: &ArrayRangeSpec, key: &str) -> Result<Vec<bool>, Fault> {
        let ArrayRangeSpec { name, value } = array;
        let refuse =
            |what: String| Fault::new(format!("{key}.array.name"), what, "name an array with one number a row");
        let Array { on, components, values, .. } = self.file.array(name).map_err(refuse)?;
        if *components != 1 {
            return Err(refuse(format!("the array {name:?} has {components} numbers a row, not 1")));
        }
        if let Some(row) = values.iter().position(|number| number.is_nan()) {
            let on = if *on == On::Points { "point" } else { "triangle" };
            return Err(refuse(format!("the array {name:?} is NaN at {on} {row}")));
        }
        let is_one = |number: &f64| value.contains(*number, 0.0);
        Ok(match on {
            On::Points => values.iter().map(is_one).collect(),
            On::Cells => {
                let mut mask = vec![false; self.mesh.positions.len()];
                let within = self.mesh.triangles.iter().zip(values).filter(|(_, number)| is_one(number));
                within.flat_map(|(corners, _)| corners).for_each(|&v| mask[v as usize] = true);
                mask
            }
        })
    }

    fn mask(&self, region: &RegionSpec, key: &str) -> Result<Vec<bool>, Fault> {
        let RegionSpec { all, x, y, z, radius, centre, axis, boundary, nearest, any, except, tolerance, .. } = region;
        let says_nothing = !all
            && !boundary
            && [x, y, z, radius].iter().all(|range| range.is_none())
            && nearest.is_none()
            && [region.vertices.is_some(), region.inside.is_some(), region.sphere.is_some()] == [false; 3]
            && [region.group.is_some(), region.array.is_some()] == [false; 2]
            && any.is_none()
            && except.is_none();
        if says_nothing {
            let hint = "give x, y, z, radius, boundary, nearest, vertices, box, sphere, group, array, any or except, \
                        or all = true for the whole body";
            return Err(Fault::new(key, "the region says nothing", hint));
        }
        let tolerance = super::error::not_negative(format!("{key}.tolerance"), tolerance.unwrap_or(TOLERANCE), "mm")?;
        let axis = axis.map_or(DVec3::Z, |axis| axis.0);
        let axis = axis.try_normalize().ok_or_else(|| {
            Fault::new(format!("{key}.axis"), "the axis has no direction", "give a vector that is not zero")
        })?;
        let nearest = nearest.and_then(|point| {
            let distances = self.mesh.positions.iter().map(|p| p.distance_squared(point.0)).enumerate();
            distances.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(row, _)| row)
        });
        let listed = self.listed(region, key)?;
        let grouped = self.grouped(region, key)?;
        let valued = region.array.as_ref().map(|array| self.valued(array, key)).transpose()?;
        let (inside, sphere) = (region.inside, region.sphere);
        if let Some(ball) = sphere {
            super::error::not_negative(format!("{key}.sphere.radius"), ball.radius, "mm")?;
        }
        if let Some(Exactly([low, high])) = inside
            && low.0.cmpgt(high.0).any()
        {
            let hint = "give the least x, y, z first, then the greatest";
            return Err(Fault::new(format!("{key}.box"), "the box runs backwards", hint));
        }
        let within = |row: usize, p: DVec3| {
            let out = (p - centre.0).reject_from_normalized(axis).length();
            [(x, p.x), (y, p.y), (z, p.z), (radius, out)]
                .iter()
                .all(|(range, value)| range.is_none_or(|range| range.contains(*value, tolerance)))
                && (!boundary || self.is_boundary[row])
                && nearest.is_none_or(|nearest| nearest == row)
                && listed.as_ref().is_none_or(|rows| rows.binary_search(&(row as u32)).is_ok())
                && grouped.is_none_or(|rows| rows.binary_search(&(row as u32)).is_ok())
                && valued.as_ref().is_none_or(|mask| mask.get(row).is_some_and(|is_one| *is_one))
                && inside.is_none_or(|Exactly([low, high])| {
                    p.cmpge(low.0 - tolerance).all() && p.cmple(high.0 + tolerance).all()
                })
                && sphere.is_none_or(|ball| p.distance(ball.centre.0) <= ball.radius + tolerance)
        };
        let mut mask: Vec<bool> = self.mesh.positions.iter().enumerate().map(|(row, p)| within(row, *p)).collect();
        if let Some(list) = any {
            let mut union = vec![false; mask.len()];
            for (i, region) in list.iter().enumerate() {
                let part = self.mask(region, &format!("{key}.any.{i}"))?;
                union.iter_mut().zip(part).for_each(|(u, p)| *u |= p);
            }
            mask.iter_mut().zip(union).for_each(|(m, u)| *m &= u);
        }
        if let Some(region) = except {
            let part = self.mask(region, &format!("{key}.except"))?;
            mask.iter_mut().zip(part).for_each(|(m, p)| *m &= !p);
        }
        Ok(mask)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate;

    fn rows(text: &str) -> Result<Vec<u32>, Fault> {
        // 3 × 2 vertices, row-major from the lower left.
        let mesh = generate::grid(2.0, 1.0, 2, 1).unwrap();
        let array = |name: &str, on, values: Vec<f64>| Array { name: name.into(), on, components: 1, values };
        let arrays = vec![
            array("part", On::Cells, vec![1.0, 1.0, 2.0, 2.0]),
            array("height", On::Points, vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0]),
            array("holed", On::Points, vec![0.0, 1.0, 2.0, 3.0, 4.0, f64::NAN]),
        ];
        let groups = vec![("inlet".to_owned(), vec![0, 3]), ("outlet".to_owned(), vec![2, 5])];
        let file = MeshFile { mesh, arrays, groups, ..MeshFile::default() };
        Surface::new(&file).vertices(&toml::from_str(text).unwrap(), "region")
    }

    #[test]
    fn conditions_combine() {
        assert_eq!(rows("x = 0").unwrap(), [0, 3]);
        assert_eq!(rows("x = [0.5, 2]\ny = 1.0").unwrap(), [4, 5]);
        assert_eq!(rows("nearest = [1.2, 0.9]").unwrap(), [4]);
        assert_eq!(rows("any = [{ x = 0 }, { x = 2 }]\nexcept = { y = 0 }").unwrap(), [3, 5]);
        assert_eq!(rows("radius = [0, 1]").unwrap(), [0, 1, 3]);
        assert_eq!(rows("x = 0.9\ntolerance = 0.2").unwrap(), [1, 4]);
        assert_eq!(rows("boundary = true").unwrap().len(), 6);
        assert_eq!(rows("vertices = [4, 1, 4]").unwrap(), [1, 4]);
        assert_eq!(rows("box = [[0, 0, 0], [1, 0.5, 0]]").unwrap(), [0, 1]);
        assert_eq!(rows("sphere = { centre = [2, 0], radius = 1 }").unwrap(), [1, 2, 5]);
    }

    #[test]
    fn groups_and_arrays_of_the_file_select() {
        assert_eq!(rows("group = 'inlet'").unwrap(), [0, 3]);
        assert_eq!(rows("any = [{ group = 'inlet' }, { group = 'outlet' }]\ny = 1").unwrap(), [3, 5]);
        assert_eq!(rows("array = { name = 'height', value = [2, 4] }").unwrap(), [2, 3, 4]);
        // The triangles of the left square.
        assert_eq!(rows("array = { name = 'part', value = 1 }").unwrap(), [0, 1, 3, 4]);
        let fault = rows("group = 'inlett'").unwrap_err();
        assert!(fault.what.contains("it has \"inlet\", \"outlet\"") && fault.hint.contains("\"inlet\""), "{fault:?}");
        let fault = rows("array = { name = 'x', value = 1 }").unwrap_err();
        assert!(fault.what.contains("it has \"part\", \"height\", \"holed\""), "{}", fault.what);
        let fault = rows("array = { name = 'holed', value = 1 }").unwrap_err();
        assert_eq!(fault.what, "the array \"holed\" is NaN at point 5");
    }

    #[test]
    fn an_empty_selection_says_where_the_body_is() {
        let fault = rows("x = 5").unwrap_err();
        assert!(fault.what.contains("x 0 to 2, y 0 to 1, z 0 to 0 mm"), "{}", fault.what);
        assert_eq!(rows("vertices = [0, 6]").unwrap_err().key, "region.vertices.1");
        assert_eq!(rows("box = [[1, 0], [0, 1]]").unwrap_err().key, "region.box");
        assert_eq!(rows("sphere = { radius = -1 }").unwrap_err().key, "region.sphere.radius");
        assert!(rows("").unwrap_err().what.contains("says nothing"));
    }
}
