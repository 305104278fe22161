//! Ways of a tear through the mesh: advances, cuts, and the geometry that they are planned by.

pub(super) mod advance;
pub(super) mod blade;
pub(super) mod cut_line;
pub(super) mod edge;
pub(super) mod embedded;
pub(super) mod free;
pub(super) mod glide;
pub(super) mod heading;
pub(super) mod least_edge;
pub(super) mod locate;
pub(super) mod nucleation;
pub(super) mod place;
pub(super) mod relax;
pub(super) mod tip;
pub(super) mod variants;
