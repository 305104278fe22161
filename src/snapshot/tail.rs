//! The end of an entity's bytes: the solver's memory, of a body that relaxes relaxation and history, of one with a compartment that and its content.
//! Bytes without are those of older versions, which knew none.

use crate::components::{Compartment, CompartmentState, Relaxation};
use crate::math::Sym2;
use crate::systems::solver::MixedState;
#[cfg(feature = "snapshot")]
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Components that stand last.
#[derive(Clone, Default)]
pub(crate) struct Tail {
    /// Memory of the solvers in mixed precision.
    pub mixed: Option<MixedState>,
    /// Relaxation of a body that relaxes.
    pub relaxation: Option<Relaxation>,
    /// History of its branches: strains per triangle.
    pub creep: Vec<Vec<Sym2>>,
    /// Compartment under the body.
    pub compartment: Option<Compartment>,
    /// Content of the compartment.
    pub contents: Option<CompartmentState>,
}

/// Form of bytes that are written. The first two are those of an option.
#[cfg(feature = "snapshot")]
#[derive(Serialize)]
enum Written<'a> {
    None,
    Elastic(&'a MixedState),
    Relaxing(&'a Option<MixedState>, &'a Relaxation, &'a [Vec<Sym2>]),
    Filled(
        &'a Option<MixedState>,
        &'a Option<Relaxation>,
        &'a [Vec<Sym2>],
        &'a Compartment,
        &'a Option<CompartmentState>,
    ),
}

/// Form of bytes that are read.
#[cfg(feature = "snapshot")]
#[derive(Deserialize)]
enum Read {
    None,
    Elastic(MixedState),
    Relaxing(Option<MixedState>, Relaxation, Vec<Vec<Sym2>>),
    Filled(Option<MixedState>, Option<Relaxation>, Vec<Vec<Sym2>>, Box<Compartment>, Option<Box<CompartmentState>>),
}

#[cfg(feature = "snapshot")]
impl Serialize for Tail {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        match self {
            Self { mixed, relaxation, creep, compartment: Some(compartment), contents } => {
                Written::Filled(mixed, relaxation, creep, compartment, contents)
            }
            Self { mixed, relaxation: Some(relaxation), creep, .. } => Written::Relaxing(mixed, relaxation, creep),
            Self { mixed: Some(mixed), .. } => Written::Elastic(mixed),
            Self { mixed: None, .. } => Written::None,
        }
        .serialize(to)
    }
}

#[cfg(feature = "snapshot")]
impl<'de> Deserialize<'de> for Tail {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        Ok(match Read::deserialize(from)? {
            Read::None => Self::default(),
            Read::Elastic(mixed) => Self { mixed: Some(mixed), ..Self::default() },
            Read::Relaxing(mixed, relaxation, creep) => {
                Self { mixed, relaxation: Some(relaxation), creep, ..Self::default() }
            }
            Read::Filled(mixed, relaxation, creep, compartment, contents) => {
                Self { mixed, relaxation, creep, compartment: Some(*compartment), contents: contents.map(|own| *own) }
            }
        })
    }
}
