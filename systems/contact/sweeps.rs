//! Sweeps over all triangles until none moves a corner any more: after the first only those are looked at again whose corners have
//! moved since.

use crate::components::Sweeps;

impl Sweeps {
    /// Before the first sweep.
    pub(super) fn begin(&mut self) {
        self.motions = 0;
    }

    /// Whether a triangle has to be looked at again, which it then is.
    pub(super) fn is_due(&mut self, t: usize, corners: [usize; 3]) -> bool {
        if self.motions == 0 {
            return false;
        }
        let is_due = corners.iter().any(|&v| self.moved[v] > self.looked_at[t]);
        self.looked_at[t] = self.motions;
        is_due
    }

    /// A corner moves, of so many vertices and triangles.
    pub(super) fn note(&mut self, v: usize, (vertices, triangles): (usize, usize)) {
        if self.motions == 0 {
            for (stamps, count) in [(&mut self.moved, vertices), (&mut self.looked_at, triangles)] {
                stamps.clear();
                stamps.resize(count, 0);
            }
        }
        self.motions += 1;
        self.moved[v] = self.motions;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_triangle_is_due_when_a_corner_has_moved_since_it_was_looked_at() {
        let (mut sweeps, counts) = (Sweeps::default(), (4, 2));
        let corners = [[0, 1, 2], [1, 3, 2]];
        sweeps.begin();
        assert!(!sweeps.is_due(0, corners[0]));
        sweeps.note(3, counts);
        assert!(!sweeps.is_due(0, corners[0]) && sweeps.is_due(1, corners[1]) && !sweeps.is_due(1, corners[1]));
        sweeps.note(2, counts);
        assert!(sweeps.is_due(0, corners[0]) && sweeps.is_due(1, corners[1]));
        // Entries left by another body are discarded.
        sweeps.begin();
        assert!(!sweeps.is_due(1, corners[1]));
        sweeps.note(0, (8, 9));
        assert!(sweeps.is_due(8, [0, 6, 7]) && !sweeps.is_due(1, corners[1]));
    }
}
