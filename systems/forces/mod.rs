//! Forces on the vertices and their derivatives, one system per kind; which vertices are held and where.

pub mod assembly;
pub mod compartment;
pub mod corners;
pub mod corotation;
pub mod drag;
pub mod element;
pub mod gravity;
pub mod hold;
pub mod loads;
pub mod pressure;
pub mod relaxation;
pub mod springs;

/// Ends a step: where it stands, `is_accepted`, the history of tissue that relaxes and the contents of compartments are those at its end.
pub fn end(world: &mut hecs::World, is_accepted: bool) {
    relaxation::end(world, is_accepted);
    compartment::end(world, is_accepted);
}
