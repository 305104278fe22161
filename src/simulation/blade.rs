//! Needle and blade while the simulation runs.

use super::{Cut, CutError, Hit, Simulation};
use crate::components::Blade;
use crate::replay::Input;
use crate::storage::{BladeId, BodyId, TipKey, Tips, Vertices};
use glam::DVec3;

impl Simulation {
    /// Punctures a body where its surface, as it lies now, is nearest to a point \[mm\]. A slit of a length \[mm, rest shape\] is
    /// cut about that place, along a direction of any length, which is laid into the surface. Its ends become tips where the body
    /// can tear.
    ///
    /// # Errors
    /// If the surface is farther away than `length`, if the direction is normal to it, for a point or direction that is not finite, and why the
    /// slit could not be cut; the body is as it was.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// let slit = simulation.puncture(body, DVec3::new(5.0, 5.0, 0.0), DVec3::X, 2.0)?;
    /// assert_eq!(slit.strokes.len(), 1);
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn puncture(&mut self, body: BodyId, point: DVec3, direction: DVec3, length: f64) -> Result<Cut, CutError> {
        self.validate_dirty()?;
        self.check_finite(body, "the point of the puncture", point)?;
        self.check_finite(body, "the direction of the puncture", direction)?;
        let hit = self.nearest(body, point, length).ok_or(CutError::NothingThere)?;
        let along = self.rest_direction(body, &hit, direction).ok_or(CutError::NothingThere)?;
        let half = along * (0.5 * length);
        self.cut(body, &[hit.rest_position - half, hit.rest_position + half])
    }

    /// Puts a blade into the world, out of any tissue.
    ///
    /// # Errors
    /// For a reach or a shortest cut that is not positive and finite.
    pub fn spawn_blade(&mut self, reach: f64, least: f64) -> Result<BladeId, CutError> {
        self.note(|| Input::SpawnBlade { reach, least });
        let is_right = |value: f64| value > 0.0 && value.is_finite();
        if !(is_right(reach) && is_right(least)) {
            return Err(CutError::BadBlade { reach, least });
        }
        Ok(self.world.spawn((Blade { reach, least, ..Blade::default() },)).into())
    }

    /// Draws the edge of a blade to a point of space \[mm\], where it cuts a body from where it was. Call it every frame: where
    /// the surface is out of its reach, or the body another one, the blade is lifted, and the next stroke begins anew. Strokes
    /// shorter than the blade's shortest cut are saved up; `None` then. A stroke that begins on the boundary makes a notch, one
    /// inside a slit.
    ///
    /// # Errors
    /// If there is no such blade or its edge is not finite, and why the cut was not made: the body is as it was, and a longer stroke may pass.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// let blade = simulation.spawn_blade(0.5, 1.0)?;
    /// simulation.draw_blade(blade, body, DVec3::new(3.0, 3.0, 0.0))?;
    /// let cut = simulation.draw_blade(blade, body, DVec3::new(6.0, 3.0, 0.0))?;
    /// assert!(cut.is_some());
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn draw_blade(&mut self, blade: BladeId, body: BodyId, edge: DVec3) -> Result<Option<Cut>, CutError> {
        self.note(|| Input::DrawBlade { blade, body, edge });
        self.validate_dirty()?;
        let tool = self.world.query_one_mut::<&Blade>(blade.entity()).map_err(|_| CutError::NoSuchBlade)?.clone();
        self.check_finite(body, "the edge of the blade", edge)?;
        let Some(hit) = self.nearest(body, edge, tool.reach) else {
            self.set_blade(blade, Blade { body: None, tip: None, ..tool });
            return Ok(None);
        };
        if tool.body != Some(body) {
            self.set_blade(blade, Blade { body: Some(body), from: hit.rest_position, tip: None, ..tool });
            return Ok(None);
        }
        let from = tool.tip.and_then(|tip| self.place_of_tip(body, tip)).unwrap_or(tool.from);
        if from.distance(hit.rest_position) < tool.least {
            return Ok(None);
        }
        let cut = self.make_cut(body, &[from, hit.rest_position])?;
        let end = cut.path.last().copied().unwrap_or(hit.rest_position);
        self.set_blade(blade, Blade { from: end, tip: cut.tips.last().copied(), ..tool });
        Ok(Some(cut))
    }

    fn set_blade(&mut self, blade: BladeId, state: Blade) {
        if let Ok(tool) = self.world.query_one_mut::<&mut Blade>(blade.entity()) {
            *tool = state;
        }
    }

    fn place_of_tip(&self, body: BodyId, tip: TipKey) -> Option<DVec3> {
        let (tips, vertices) =
            (self.world.get::<&Tips>(body.entity()).ok()?, self.world.get::<&Vertices>(body.entity()).ok()?);
        let vertex = tips.vertex[tips.row(tip)? as usize];
        Some(vertices.rest_position[vertex as usize])
    }

    /// A direction of space laid into a triangle, in the rest shape \[unit\].
    fn rest_direction(&self, body: BodyId, hit: &Hit, direction: DVec3) -> Option<DVec3> {
        let vertices = self.world.get::<&Vertices>(body.entity()).ok()?;
        let [a, b, c] = hit.corners.map(|key| vertices.row(key).map_or(0, |row| row as usize));
        let (now, rest) = (&vertices.position, &vertices.rest_position);
        let (p, q) = (now[b] - now[a], now[c] - now[a]);
        let along = direction.try_normalize()?.reject_from(hit.normal).try_normalize()?;
        // along = s·p + t·q by the reciprocal basis of the triangle.
        let area = p.cross(q).length_squared();
        let (s, t) = (along.cross(q).dot(p.cross(q)) / area, p.cross(along).dot(p.cross(q)) / area);
        ((rest[b] - rest[a]) * s + (rest[c] - rest[a]) * t).try_normalize()
    }
}
