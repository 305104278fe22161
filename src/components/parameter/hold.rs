//! Prescribed vertices: clamped edges, grips of a testing machine.

use crate::components::BodyError;
use crate::components::Curve;
use crate::components::check::{Check, Host, at_row, finite, number};
use crate::storage::Attached;
use glam::DVec3;

/// A group of vertices whose position is prescribed: rest position + curve(t) · offset. *Parameter.*
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Hold {
    /// Name in reports.
    pub name: String,
    /// The vertices, each with its displacement \[mm\] at curve value 1. Both copies of a duplicated vertex stay held.
    pub members: Attached<DVec3>,
    /// Which axes are prescribed; the others stay free.
    pub axes: [bool; 3],
    /// Factor of the offsets over time.
    pub curve: Curve,
}

/// All groups of prescribed vertices of a body. *Parameter.*
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Holds {
    /// The groups. No two prescribe the same axis of the same vertex.
    pub groups: Vec<Hold>,
}

impl Holds {
    /// The hold at a place that another component names.
    pub(in crate::components) fn at(&self, component: &'static str, place: u32) -> Result<&Hold, BodyError> {
        let hold = self.groups.get(place as usize);
        number(
            component,
            "the place of a hold",
            f64::from(place),
            (hold.is_some(), "it must be one of the body's holds"),
        )?;
        Ok(&self.groups[place as usize])
    }
}

impl Check for Holds {
    fn check(&self, host: &Host<'_>) -> Result<(), BodyError> {
        for hold in &self.groups {
            hold.curve.check("Holds")?;
            host.rows("Holds", || format!("hold `{}`", hold.name), hold.members.rows())?;
            for (&row, offset) in hold.members.rows().iter().zip(hold.members.values()) {
                finite("Holds", "offset", offset.to_array()).map_err(at_row(row))?;
            }
        }
        for (second, hold) in self.groups.iter().enumerate() {
            self.groups[..second].iter().try_for_each(|first| first.goes_with(hold))?;
        }
        Ok(())
    }
}

impl Hold {
    /// Vertices held at rest along all axes.
    ///
    /// # Examples
    /// ```
    /// use rhexis::prelude::*;
    ///
    /// let sheet = Membrane::new("sheet", generate::grid(10.0, 10.0, 8, 8)?, Material::allard_2009());
    /// let left = Hold::new("left", sheet.select(|p| p.x == 0.0));
    /// let right = Hold::new("right", sheet.select(|p| p.x == 10.0)).moved(DVec3::X, Curve::ramp(1000.0, 3.0)?);
    /// let sheet = sheet.hold(left).hold(right.along([true, false, false]));
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn new(name: impl Into<String>, vertices: impl IntoIterator<Item = u32>) -> Self {
        let members = Attached::new(vertices.into_iter().map(|vertex| (vertex, DVec3::ZERO)));
        Self { name: name.into(), members, axes: [true; 3], curve: Curve::constant(1.0) }
    }

    /// The hold with all vertices displaced by an offset \[mm\] times the curve.
    #[must_use]
    pub fn moved(self, offset: DVec3, curve: Curve) -> Self {
        let members = Attached::new(self.members.rows().iter().map(|&vertex| (vertex, offset)));
        Self { members, curve, ..self }
    }

    /// The hold along these axes only.
    #[must_use]
    pub fn along(self, axes: [bool; 3]) -> Self {
        Self { axes, ..self }
    }

    /// Whether no axis of any vertex is prescribed by another hold as well.
    fn goes_with(&self, second: &Self) -> Result<(), BodyError> {
        let Some(axis) = (0..3).find(|&axis| self.axes[axis] && second.axes[axis]) else { return Ok(()) };
        match self.members.rows().iter().find(|&&row| second.members.value(row).is_some()) {
            Some(&row) => Err(BodyError::ContradictoryHolds {
                first: self.name.clone(),
                second: second.name.clone(),
                axis: ['x', 'y', 'z'][axis],
                row,
            }),
            None => Ok(()),
        }
    }
}
