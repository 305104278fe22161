//! Numbers outside their ranges, of settings and of arguments.

/// A number outside its range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{what} is {value:?}: {must}")]
pub struct OutOfRange {
    /// Name of the setting or argument.
    pub what: &'static str,
    /// Value given for the setting.
    pub value: f64,
    /// Condition that the value must meet.
    pub must: &'static str,
}

impl OutOfRange {
    /// Refuses a number unless it is right.
    pub(crate) fn unless(is_right: bool, what: &'static str, value: f64, must: &'static str) -> Result<(), Self> {
        is_right.then_some(()).ok_or(Self { what, value, must })
    }

    /// Rejects a value that is no valid tolerance.
    pub(crate) fn unless_tolerance(what: &'static str, value: f64) -> Result<(), Self> {
        Self::unless(value >= 0.0 && value.is_finite(), what, value, "it must be zero or more, and finite")
    }
}
