//! Where solves whose time was up have stopped, so that the step can be repeated.

/// The stops of a step's solves in their order, and those that a repetition is to make instead of looking at the clock. *Derived.*
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Stops {
    /// Per round of iterations with a limit of time, after how many of them it was up; [`NEVER`](Self::NEVER) where it was not.
    taken: Vec<u32>,
    script: Vec<u32>,
}

impl Stops {
    /// Time was not up.
    pub const NEVER: u32 = u32::MAX;

    /// Before a step; with a script it stops where this says.
    pub fn begin(&mut self, script: &[u32]) {
        self.taken.clear();
        self.script.clear();
        self.script.extend_from_slice(script);
    }

    /// The stops since then.
    pub fn taken(&self) -> &[u32] {
        &self.taken
    }

    /// Before a round of iterations with a limit of time: the stop that the script says.
    pub fn next_round(&mut self) -> Option<u32> {
        let stop = self.script.get(self.taken.len()).copied();
        self.taken.push(Self::NEVER);
        stop
    }

    /// After a round that has stopped because time was up.
    pub fn note(&mut self, iterations: u32, is_late: bool) {
        if is_late && let Some(last) = self.taken.last_mut() {
            *last = iterations;
        }
    }
}
