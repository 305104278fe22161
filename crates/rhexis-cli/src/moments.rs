//! When to write a picture or a frame.

/// Moments spread evenly over a run, the first at the start, the last at its end; or one every so often.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moments {
    /// Their number.
    pub count: u64,
    /// Steps of the run.
    pub steps: u64,
    /// Steps from one to the next, in place of the number.
    pub gap: Option<u64>,
}

impl Moments {
    /// Whether one falls on the state after `step` steps. The end is not asked for here: a run may end early.
    pub(crate) fn is_due(&self, step: u64) -> bool {
        if let Some(gap) = self.gap {
            return step.is_multiple_of(gap);
        }
        let gaps = u128::from(self.count.saturating_sub(1));
        let passed = |step: u64| u128::from(step) * gaps / u128::from(self.steps.max(1));
        match step {
            0 => gaps > 0,
            _ => passed(step) > passed(step - 1),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_spread_from_the_first_to_the_last() {
        let due =
            |count, steps| (0..=steps).filter(|s| Moments { count, steps, gap: None }.is_due(*s)).collect::<Vec<_>>();
        assert_eq!(due(5, 100), [0, 25, 50, 75, 100]);
        assert_eq!(due(3, 5), [0, 3, 5]);
        assert!(due(0, 10).is_empty());
        assert!(due(1, 10).is_empty());
        // More moments than steps: every state once.
        assert_eq!(due(50, 3), [0, 1, 2, 3]);
        assert_eq!(due(2, 0), [0]);
        let every = Moments { count: 3, steps: 11, gap: Some(5) };
        assert_eq!((0..=11).filter(|s| every.is_due(*s)).collect::<Vec<_>>(), [0, 5, 10]);
    }
}
