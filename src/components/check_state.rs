//! Checks of state: tables, their foundations, and values that a step remembers.

use super::check::{Check, Host, MOST_COUNTED};
use super::{
    Body, BodyError, EnergyAudit, FrictionContact, Increment, Planar, Reactions, Refined, TearDecisions, TearLog,
};
use crate::math::{MAX_COORDINATE, Sym2};
use crate::storage::{Broken, NONE, Tips, Topology, Triangles, Vertices};

fn misaligned(table: &'static str, column: Option<&'static str>) -> Result<(), BodyError> {
    column.map_or(Ok(()), |column| Err(BodyError::Topology(Broken::Misaligned { table, column })))
}

fn must(component: &'static str, is_right: bool, what: &'static str) -> Result<(), BodyError> {
    is_right.then_some(()).ok_or(BodyError::Contradiction { component, what })
}

/// The place of a body in the order is judged among all bodies.
impl Check for Body {
    fn check(&self, _: &Host<'_>) -> Result<(), BodyError> {
        Ok(())
    }
}

/// A mark.
impl Check for Planar {
    fn check(&self, _: &Host<'_>) -> Result<(), BodyError> {
        Ok(())
    }
}

impl Check for Vertices {
    fn check(&self, _: &Host<'_>) -> Result<(), BodyError> {
        must("Vertices", self.len() as u64 <= MOST_COUNTED, "there are more than 1073741824")?;
        misaligned("vertices", self.first_misaligned_column())?;
        let columns =
            [("position", &self.position), ("velocity", &self.velocity), ("rest_position", &self.rest_position)];
        for (column, values) in columns {
            if let Some(vertex) = values.iter().position(|value| !value.is_finite()) {
                return Err(BodyError::Topology(Broken::NotFinite { column, vertex: vertex as u32 }));
            }
        }
        match self.mass.iter().position(|&mass| !(mass > 0.0 && mass.is_finite())) {
            Some(vertex) => Err(BodyError::Topology(Broken::Mass { vertex: vertex as u32 })),
            None => Ok(()),
        }
    }
}

impl Check for Triangles {
    fn check(&self, host: &Host<'_>) -> Result<(), BodyError> {
        must("Triangles", self.len() as u64 <= MOST_COUNTED, "there are more than 1073741824")?;
        misaligned("triangles", self.first_misaligned_column())?;
        for (t, corners) in self.corners.iter().enumerate() {
            if let Some(&vertex) = corners.iter().find(|&&vertex| vertex as usize >= host.count) {
                return Err(BodyError::Topology(Broken::CornerRange { triangle: t as u32, vertex }));
            }
        }
        for t in 0..self.len() {
            let q = &self.stiffness[t];
            let is_stiff = q.q11 > 0.0 && q.q22 > 0.0 && q.q66 > 0.0 && q.q11 * q.q22 > q.q12 * q.q12;
            let is_finite = [q.q11, q.q22, q.q12, q.q66].iter().all(|q| q.is_finite());
            must("Triangles", is_stiff && is_finite, "the stiffness of a triangle is not positive definite")?;
            // Unit vectors are so to a few roundings.
            let is_unit = (self.fibre[t].length() - 1.0).abs() < 1e-9;
            must("Triangles", is_unit, "the fibre of a triangle is no unit vector")?;
            let is_thick = self.thickness[t] > 0.0 && self.density[t] > 0.0;
            let is_thick = is_thick && self.thickness[t].is_finite() && self.density[t].is_finite();
            must("Triangles", is_thick, "the thickness or density of a triangle is not positive and finite")?;
            let is_strong = |factor: f64| factor > 0.0 && factor.is_finite();
            let is_strong = is_strong(self.strength[t]) && is_strong(self.toughness[t]);
            must("Triangles", is_strong, "the strength or toughness of a triangle is not positive and finite")?;
            let Sym2 { xx, yy, xy } = self.pre_stretch[t];
            let is_held = [xx, yy, xy].iter().all(|strain| strain.abs() <= MAX_COORDINATE);
            must("Triangles", is_held, "the pre-stretch of a triangle is not finite, or above 1e75")?;
        }
        Ok(())
    }
}

/// Which corners lie on which vertex; that neighbours share an edge follows where it is made.
impl Check for Topology {
    fn check(&self, host: &Host<'_>) -> Result<(), BodyError> {
        let corners = host.surface.map_or(&[][..], |(triangles, _)| &triangles.corners);
        let is_sized = self.incident.len() == host.count && self.neighbours.len() == corners.len();
        must("Topology", is_sized, "it is of another mesh")?;
        let lies_there = |v: usize, entry: u32| {
            corners.get(entry as usize / 3).is_some_and(|corners| corners[entry as usize % 3] as usize == v)
        };
        let mut around = self.incident.iter().enumerate();
        let do_lie = around.all(|(v, around)| around.iter().all(|&entry| lies_there(v, entry)));
        let count: usize = self.incident.iter().map(|around| around.len()).sum();
        must("Topology", do_lie && count == 3 * corners.len(), "it is of other triangles than the body's")?;
        let is_there = |&other: &u32| other == NONE || (other as usize) < corners.len();
        let are_there = self.neighbours.as_flattened().iter().all(is_there);
        must("Topology", are_there, "it names a triangle that is not there")
    }
}

impl Check for Tips {
    fn check(&self, host: &Host<'_>) -> Result<(), BodyError> {
        misaligned("tips", self.first_misaligned_column())?;
        host.rows("Tips", || "a tip".to_owned(), &self.vertex)?;
        let mut directions = self.previous.iter().chain(&self.ideal);
        must("Tips", directions.all(|d| d.is_finite()), "a direction or place of a tip is not finite")
    }
}

impl Check for Increment {
    fn check(&self, host: &Host<'_>) -> Result<(), BodyError> {
        let Self { start, start_velocity, displacement, delta, .. } = self;
        // Before the first step there is none.
        let is_sized = |values: &Vec<_>| values.is_empty() || values.len() == host.count;
        let are_sized = start.len() == start_velocity.len() && [start, displacement].into_iter().all(is_sized);
        must("Increment", are_sized, "it is of another mesh")?;
        let mut values = [start, start_velocity, displacement, delta].into_iter().flatten();
        must("Increment", values.all(|value| value.is_finite()) && self.last.dt.is_finite(), "it is not finite")?;
        let rubbing = self.last.friction.iter().flat_map(|friction| &friction.end);
        let is_right = |contact: &FrictionContact| {
            let [last, before] = contact.slip;
            (contact.row as usize) < host.count
                && contact.normal_force.is_finite()
                && [contact.offset, last, before].iter().all(|value| value.is_finite())
        };
        must("Increment", rubbing.clone().all(is_right), "its friction is of another mesh or not finite")?;
        must("Increment", rubbing.is_sorted_by_key(FrictionContact::key), "its friction is not in order")
    }
}

/// Reactions of holds are reported, and no step reads them.
impl Check for Reactions {
    fn check(&self, _: &Host<'_>) -> Result<(), BodyError> {
        Ok(())
    }
}

impl Check for Refined {
    fn check(&self, _: &Host<'_>) -> Result<(), BodyError> {
        let is_right = self.start_count as u64 <= MOST_COUNTED && self.added.unsigned_abs() <= MOST_COUNTED;
        must("Refined", is_right, "it counts what no run can do")
    }
}

/// Rows are judged by the systems that read them.
impl Check for TearDecisions {
    fn check(&self, _: &Host<'_>) -> Result<(), BodyError> {
        Ok(())
    }
}

impl Check for TearLog {
    fn check(&self, _: &Host<'_>) -> Result<(), BodyError> {
        let counts = [
            self.nucleation_count,
            self.blocked_nucleation_count,
            self.advance_count,
            self.detour_count,
            self.ambiguous_count,
            self.material_force_count,
            self.end_count,
            self.fragment_count,
            self.refusal_count,
            self.held_shut_count,
            self.renewed_count,
            self.branch_count,
            self.parted_count,
        ];
        let is_right = counts.iter().all(|&count| u64::from(count) <= MOST_COUNTED) && self.length.is_finite();
        must("TearLog", is_right, "it counts what no run can do")
    }
}

/// A ledger: its terms are reported, and no step reads them.
impl Check for EnergyAudit {
    fn check(&self, _: &Host<'_>) -> Result<(), BodyError> {
        Ok(())
    }
}
