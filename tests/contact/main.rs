//! What touches a body: obstacles, forceps and other tools.

mod balance;
mod bodies;
mod contact;
mod contact_passing;
mod friction;
mod grips;
mod layers;
mod limited_grasps;
mod lips;
mod rigid;
mod tools;
