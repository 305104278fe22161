//! The clock by which steps are timed and solves are cut short: the system's, or none where the platform has none
//! (`wasm32-unknown-unknown`, where asking for it panics).

use std::time::Duration;

#[cfg(not(all(target_family = "wasm", target_os = "unknown")))]
type Ticks = std::time::Instant;

/// A clock that stands still.
#[cfg(all(target_family = "wasm", target_os = "unknown"))]
type Ticks = still::Still;

/// A moment, to be compared with others of the same run.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub(crate) struct Moment(Ticks);

impl Moment {
    /// The present one.
    pub(crate) fn now() -> Self {
        Self(Ticks::now())
    }

    /// Time since then; zero without a clock.
    pub(crate) fn elapsed(self) -> Duration {
        self.0.elapsed()
    }

    /// The moment so much later; `None` without a clock, or beyond its range.
    pub(crate) fn after(self, time: Duration) -> Option<Self> {
        self.0.checked_add(time).map(Self)
    }
}

#[cfg(all(target_family = "wasm", target_os = "unknown"))]
mod still {
    use std::time::Duration;

    #[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
    pub(super) struct Still;

    impl Still {
        pub(super) fn now() -> Self {
            Self
        }

        pub(super) fn elapsed(self) -> Duration {
            Duration::ZERO
        }

        pub(super) fn checked_add(self, _: Duration) -> Option<Self> {
            None
        }
    }
}
