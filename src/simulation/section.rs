//! Forces that a body bears across a plane of its rest shape.

use super::{Simulation, SimulationError};
use crate::math::{is_direction, is_place};
use crate::settings::OutOfRange;
use crate::storage::{BodyId, Triangles, Vertices};
use crate::systems::kernels::membrane;
use glam::DVec3;

/// Plane of the rest shape that cuts a body in two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Section {
    /// A point of the plane \[mm\].
    pub point: DVec3,
    /// Normal of the plane, of any length.
    pub normal: DVec3,
    /// Distance from `point` \[mm\], > 0, within which a triangle's centroid must lie; infinite for the whole plane.
    pub radius: f64,
}

impl Simulation {
    /// Force \[N\] of the tissue on the side of a section's normal on the tissue behind it, as the body stands: a pull is along the
    /// normal. It is the sum of stress × thickness × length along the line through the middles of the mesh's edges that the plane
    /// cuts, where the forces of the mesh balance exactly: with the holds of one side, the sum is zero at rest. Of the membrane alone,
    /// without bending and damping.
    ///
    /// # Errors
    /// If there is no such body, the normal has no direction, or the radius is not positive.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// use rhexis::simulation::Section;
    ///
    /// simulation.step(5.0)?;
    /// let section = Section { point: DVec3::new(5.0, 5.0, 0.0), normal: DVec3::X, radius: f64::INFINITY };
    /// println!("{} N", simulation.section_force(body, &section)?);
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn section_force(&self, body: BodyId, section: &Section) -> Result<DVec3, SimulationError> {
        section.check()?;
        let frames = self.present_frames(body)?;
        let mut query = self.world.query_one::<(&Vertices, &Triangles)>(body.entity());
        let (vertices, triangles) = query.get().map_err(|_| SimulationError::NoSuchBody)?;
        let Section { point, normal, radius } = *section;
        let mut sum = DVec3::ZERO;
        for (t, corners) in triangles.corners.iter().enumerate() {
            let at = corners.map(|v| vertices.rest_position[v as usize] - point);
            let is_behind = at.map(|p| p.dot(normal) <= 0.0);
            let is_cut = is_behind.contains(&true) && is_behind.contains(&false);
            if !is_cut || (at[0] + at[1] + at[2]).length() / 3.0 > radius {
                continue;
            }
            let (state, rest) = (frames.state(t), &triangles.rest[t]);
            let forces = membrane::nodal_forces(&state.polar, state.stress, rest, rest.area * triangles.thickness[t]);
            sum += forces.into_iter().zip(is_behind).filter(|(_, is_behind)| *is_behind).map(|(f, _)| f).sum::<DVec3>();
        }
        Ok(sum)
    }
}

impl Section {
    fn check(&self) -> Result<(), OutOfRange> {
        let Self { point, normal, radius } = self;
        let unless = OutOfRange::unless;
        let far = point.abs().max_element();
        unless(is_place(*point), "largest coordinate of a section's point", far, "it must be at most 1e75 mm")?;
        let what = "length of a section's normal";
        unless(is_direction(*normal), what, normal.length(), "it must be from 1e-75 to 1e75")?;
        unless(*radius > 0.0, "radius of a section", *radius, "it must be positive, or infinite")
    }
}
