//! Measurements of a body between steps: energies, reactions, stresses.

use super::{Simulation, SimulationError};
use crate::components::{
    Bending, Body, Energies, EnergyAudit, EnergyBalance, FibreLaws, Frames, Grips, HoldTurns, Holds, Planar,
    PreStretch, Reactions, SolverScratch, Turning, fibre_law,
};
use crate::storage::{BodyId, Topology, Triangles, Vertices};
use crate::systems::bending::DihedralAngles;
use crate::systems::forces::corotation;
use crate::systems::forces::element::BodyLaw;
use glam::DVec3;

impl Simulation {
    /// Energies of a body now.
    ///
    /// # Errors
    /// If there is no such body.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// simulation.step(5.0)?;
    /// assert!(simulation.energies(body)?.elastic >= 0.0);
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn energies(&self, body: BodyId) -> Result<Energies, SimulationError> {
        self.validate_if_dirty(body)?;
        let frames = self.present_frames(body)?;
        type Query<'a> = (
            (&'a Vertices, &'a Triangles, &'a Topology),
            (Option<&'a PreStretch>, FibreLaws<'a>),
            (Option<&'a Bending>, Option<&'a DihedralAngles>),
        );
        let mut query = self.world.query_one::<Query>(body.entity());
        let ((vertices, triangles, topology), (pre_stretch, fibres), (bending, folds)) =
            query.get().map_err(|_| SimulationError::NoSuchBody)?;
        let fibres = fibre_law(fibres, pre_stretch);
        let (is_planar, unstretched) = (frames.is_planar(), PreStretch::unstretched(pre_stretch));
        let law = BodyLaw { is_planar, unstretched, fibres: fibres.as_ref() };
        let elastic = frames.states().enumerate().map(|(t, state)| law.stored(triangles, t, &state));
        let kinetic = vertices.velocity.iter().zip(&vertices.mass).map(|(v, m)| 0.5 * m * v.length_squared());
        let body = (vertices, triangles, topology);
        let bent = bending.map_or(0.0, |bending| DihedralAngles::energy_at(body, bending, folds, &vertices.position));
        Ok(Energies { elastic: elastic.sum::<f64>() + bent, kinetic: kinetic.sum() })
    }

    /// The energy balance of a body since its first step; `None` for one without an [`EnergyAudit`].
    ///
    /// # Errors
    /// If there is no such body.
    pub fn energy_balance(&self, body: BodyId) -> Result<Option<EnergyBalance>, SimulationError> {
        self.validate_if_dirty(body)?;
        let mut query = self.world.query_one::<(&Vertices, Option<&EnergyAudit>)>(body.entity());
        let (_, audit) = query.get().map_err(|_| SimulationError::NoSuchBody)?;
        audit.map(|audit| Ok(audit.balance(self.energies(body)?))).transpose()
    }

    /// Sum of the forces \[N\] that a body's holds exert on it, one per hold, from the last step; zero before the first.
    ///
    /// # Errors
    /// If there is no such body.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// simulation.step(5.0)?;
    /// for (hold, force) in simulation.reactions(body)? {
    ///     println!("{hold}: {force} N");
    /// }
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn reactions(&self, body: BodyId) -> Result<Vec<(String, DVec3)>, SimulationError> {
        let mut query = self.world.query_one::<(&Body, Option<(&Holds, &Reactions)>)>(body.entity());
        let (_, held) = query.get().map_err(|_| SimulationError::NoSuchBody)?;
        let Some((holds, reactions)) = held else { return Ok(Vec::new()) };
        let sum = |group: usize| reactions.groups.get(group).map_or(DVec3::ZERO, |forces| forces.iter().sum());
        Ok(holds.groups.iter().enumerate().map(|(group, hold)| (hold.name.clone(), sum(group))).collect())
    }

    /// Unbalanced force \[N\] of a body in the last step: the rate of its momentum less its loads, [reactions](Self::reactions), forces of
    /// [grips](Grips) and [contact forces](Self::contact_forces). It is the residual of the solve, unless the energy guard has shortened the
    /// step or jaws have let go in it. Of a step taken in parts it is that of the last part. `None` before the first step of this process, and
    /// for a body without [`Contact`](crate::components::Contact). Forces of systems of your own count if they are added before `grip`.
    ///
    /// # Errors
    /// If there is no such body.
    ///
    /// # Examples
    /// ```
    /// # let (mut simulation, body) = rhexis::internal::example()?;
    /// # use rhexis::prelude::*;
    /// use rhexis::components::Contact;
    ///
    /// simulation.set(body, Contact::default())?;
    /// simulation.step(5.0)?;
    /// assert!(simulation.unbalanced_force(body)?.is_some_and(|force| force.length() < 1e-3));
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn unbalanced_force(&self, body: BodyId) -> Result<Option<DVec3>, SimulationError> {
        let held: DVec3 = self.reactions(body)?.into_iter().map(|(_, force)| force).sum();
        let pushed: DVec3 = self.contact_forces(body)?.into_iter().map(|(_, force)| force).sum();
        let mut query = self.world.query_one::<(&SolverScratch, Option<&Grips>, Option<&Planar>)>(body.entity());
        let (scratch, grips, planar) = query.get().map_err(|_| SimulationError::NoSuchBody)?;
        let gripped: DVec3 = grips.iter().flat_map(|grips| &grips.pinches).map(|pinch| pinch.force).sum();
        let mut reported = held + pushed + gripped;
        if planar.is_some() {
            reported.z = 0.0;
        }
        Ok(scratch.momentum.balance.map(|balance| balance.rate - balance.loads - reported))
    }

    /// The torque \[N·mm\] of every turned hold on a body about its pivot, in the order of the holds.
    ///
    /// # Errors
    /// If there is no such body.
    pub fn torques(&self, body: BodyId) -> Result<Vec<(String, DVec3)>, SimulationError> {
        let mut query =
            self.world.query_one::<(&Body, &Vertices, Option<(&Holds, &HoldTurns, &Reactions)>)>(body.entity());
        let (_, vertices, held) = query.get().map_err(|_| SimulationError::NoSuchBody)?;
        let Some((holds, turns, reactions)) = held else { return Ok(Vec::new()) };
        let torque = |(place, turning): &(u32, Turning)| {
            let hold = holds.groups.get(*place as usize)?;
            let forces = reactions.groups.get(*place as usize).map(Vec::as_slice).unwrap_or_default();
            let arms = hold.members.rows().iter().map(|&row| vertices.position[row as usize] - turning.pivot);
            Some((hold.name.clone(), arms.zip(forces).map(|(arm, force)| arm.cross(*force)).sum()))
        };
        Ok(turns.list.iter().filter_map(torque).collect())
    }

    /// Brings [`Frames`] up to the current positions: stresses for whoever looks between steps.
    ///
    /// # Errors
    /// If there is no such body.
    pub fn refresh(&mut self, body: BodyId) -> Result<(), SimulationError> {
        let found = self.world.query_one_mut::<&mut Frames>(body.entity());
        let mut frames = found.map(std::mem::take).map_err(|_| SimulationError::NoSuchBody)?;
        let refreshed = self.evaluate_into(body, &mut frames);
        if let Ok(place) = self.world.query_one_mut::<&mut Frames>(body.entity()) {
            *place = frames;
        }
        refreshed
    }

    /// Frames of a body at its present positions, for whoever may not write them down.
    pub(super) fn present_frames(&self, body: BodyId) -> Result<Frames, SimulationError> {
        let mut frames = Frames::default();
        self.evaluate_into(body, &mut frames).map(|()| frames)
    }

    fn evaluate_into(&self, body: BodyId, frames: &mut Frames) -> Result<(), SimulationError> {
        type Query<'a> = ((&'a Vertices, &'a Triangles), (Option<&'a Planar>, Option<&'a PreStretch>, FibreLaws<'a>));
        self.validate_tables_if_dirty(body)?;
        let mut query = self.world.query_one::<Query>(body.entity());
        let ((vertices, triangles), (planar, pre_stretch, fibres)) =
            query.get().map_err(|_| SimulationError::NoSuchBody)?;
        let (is_planar, fibres) = (planar.is_some(), fibre_law(fibres, pre_stretch));
        let fibres = fibres.as_ref();
        self.pool.run(|| corotation::evaluate(vertices, triangles, frames, is_planar, pre_stretch, fibres));
        Ok(())
    }
}
