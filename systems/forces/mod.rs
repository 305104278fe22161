//! Forces on the vertices and their derivatives, one system per kind; which vertices are held and where.

pub mod assembly;
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
