//! Tools of a hand: forceps, whose jaws the host or a script moves.

pub mod grip;
mod pinch_selection;

pub use pinch_selection::PinchSelection;
