//! The material of a body, changed while it runs.

use super::{SetError, Simulation};
use crate::components::check::Check;
use crate::components::{Bending, BodyError, HolzapfelGasserOgden, Increment, Material};
use crate::event::WokenBy;
use crate::membrane::{check_bending, check_neo_hookean, enough_mass, law};
use crate::registry::{Rejected, owner_of, with_host};
use crate::replay::{Input, Materials};
use crate::storage::{BodyId, Topology, Triangles, Vertices, measure};
use crate::systems::fracture::TipMemory;
use glam::DVec3;
use std::mem::swap;

impl Simulation {
    /// Gives every triangle of a body another material: tissue that ages, dries or is treated. The material follows from the triangle's rest
    /// centroid \[mm\] and its present thickness \[mm\]; one of the whole body is `|_, _| material`. Positions, velocities, fibres and
    /// criteria stay; stresses, masses and the bending that follows from the material change at once. A body that sleeps is woken.
    ///
    /// # Errors
    /// For a body that is gone, constants that are no material, and one that the body's fibre law or bending refuses; nothing has changed then.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// let softened = Material { young_fibre: 5.0, ..Material::allard_2009() };
    /// simulation.set_material(body, |_, thickness| Material { thickness, ..softened })?;
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn set_material(&mut self, body: BodyId, of: impl Fn(DVec3, f64) -> Material) -> Result<(), SetError> {
        self.validate_dirty()?;
        let materials = self.materials(body, of)?;
        self.put_materials(body, materials)
    }

    fn materials(&self, body: BodyId, of: impl Fn(DVec3, f64) -> Material) -> Result<Materials, SetError> {
        let mut query = self.world.query_one::<(&Vertices, &Triangles)>(body.entity());
        let (vertices, triangles) = query.get().map_err(|_| SetError::NoSuchEntity)?;
        let mut materials = Materials::default();
        for (t, corners) in triangles.corners.iter().enumerate() {
            let [a, b, c] = measure::rest_corners(vertices, *corners);
            let material = of((a + b + c) / 3.0, triangles.thickness[t]);
            let law = law(&material, t).map_err(|source| self.rejected(body, source))?;
            materials.stiffness.push(law);
            materials.thickness.push(material.thickness);
            materials.density.push(material.density);
        }
        Ok(materials)
    }

    /// Gives the triangles of a body materials in the order of their rows.
    pub(super) fn put_materials(&mut self, body: BodyId, mut materials: Materials) -> Result<(), SetError> {
        self.note(|| Input::SetMaterial { body, to: Box::new(materials.clone()) });
        self.validate_dirty()?;
        let before = self.audited_energies(body);
        {
            let triangles = self.world.query_one_mut::<&mut Triangles>(body.entity());
            exchange(triangles.map_err(|_| SetError::NoSuchEntity)?, &mut materials);
        }
        if let Err(source) = self.check_materials(body) {
            if let Ok(triangles) = self.world.query_one_mut::<&mut Triangles>(body.entity()) {
                exchange(triangles, &mut materials);
            }
            return Err(self.rejected(body, source));
        }
        type Query<'a> = (&'a mut Vertices, &'a Triangles, &'a Topology, &'a mut Increment, Option<&'a mut TipMemory>);
        let found = self.world.query_one_mut::<Query>(body.entity());
        let (vertices, triangles, topology, increment, memory) = found.map_err(|_| SetError::NoSuchEntity)?;
        for (row, mass) in vertices.mass.iter_mut().enumerate() {
            *mass = measure::lumped_mass(triangles, topology, row as u32);
        }
        increment.slack_energy = None;
        // Discs about the tips have the laws of their triangles.
        if let Some(memory) = memory {
            *memory = TipMemory::default();
        }
        self.note_edited_energies(body, before);
        self.wake_by(body, WokenBy::Caller);
        Ok(())
    }

    fn check_materials(&self, body: BodyId) -> Result<(), BodyError> {
        let Ok(found) = self.world.entity(body.entity()) else { return Ok(()) };
        let Some(triangles) = found.get::<&Triangles>() else { return Ok(()) };
        with_host(found, |host| triangles.check(host))?;
        for t in 0..triangles.len() {
            let volume_density = triangles.thickness[t] * triangles.density[t];
            enough_mass("the mass of a triangle in g", volume_density * triangles.rest[t].area)?;
        }
        check_neo_hookean(found.get::<&HolzapfelGasserOgden>().as_deref(), &triangles)?;
        found.get::<&Bending>().map_or(Ok(()), |bending| check_bending(&bending, &triangles))
    }

    fn rejected(&self, body: BodyId, source: BodyError) -> SetError {
        let entity = body.entity();
        let owner = self.world.entity(entity).map_or_else(|_| String::new(), owner_of);
        Rejected { entity, owner, source }.into()
    }
}

/// Exchanges the materials of triangles for others. Columns keep the room that they have for rows to come.
fn exchange(triangles: &mut Triangles, materials: &mut Materials) {
    let Materials { stiffness, thickness, density } = materials;
    stiffness.take_room_of(&triangles.stiffness);
    thickness.take_room_of(&triangles.thickness);
    density.take_room_of(&triangles.density);
    swap(stiffness, &mut triangles.stiffness);
    swap(thickness, &mut triangles.thickness);
    swap(density, &mut triangles.density);
}
