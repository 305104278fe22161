//! Which law of its fibres a body has.

use crate::components::PreStretch;
use crate::math::{FibreLaw, HolzapfelGasserOgden, PreparedLaw, StiffeningFibres};
use hecs::Or;

/// Query of the component that makes a body's law more than linear.
pub type FibreLaws<'a> = Option<Or<&'a StiffeningFibres, &'a HolzapfelGasserOgden>>;

/// The law that a body's triangles have beside the linear one or in its place, ready for evaluation; none without such a component.
pub fn fibre_law(found: FibreLaws, pre_stretch: Option<&PreStretch>) -> Option<FibreLaw> {
    Some(match found? {
        Or::Left(fibres) => FibreLaw::Stiffening(*fibres),
        // A body that would have both is refused when it is spawned.
        Or::Right(law) | Or::Both(_, law) => {
            FibreLaw::Published(PreparedLaw::new(law, PreStretch::unstretched(pre_stretch)))
        }
    })
}
