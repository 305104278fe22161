//! Which rows of a level are nodes of the next coarser one: an independent set such that every other row has a neighbour in it.
//!
//! Rows are chosen one by one, those first that have the most neighbours already known not to be chosen (Ruge, Stüben 1987, first
//! pass). The set grows like a front, and on a regular grid takes about every second row along either axis. Rows at the boundary go
//! before all others. So both sides of a tear have nodes of their own, and no row at a boundary lies outside them.

use super::super::empty;
use super::super::pattern::BlockPattern;
use super::numbering::Numbering;

/// No node of the coarser level.
pub(super) const NO_NODE: u32 = u32::MAX;

/// Known not to be chosen.
const PASSED: u32 = u32::MAX - 1;

/// Largest number of passed neighbours told apart.
const MOST_PASSED: usize = 15;

/// Scratch of the choice.
#[derive(Debug, Default)]
pub(super) struct Coarsening {
    /// Per row its node on the coarser level, or [`NO_NODE`].
    pub node: Vec<u32>,
    /// Per node its row.
    pub row: Vec<u32>,
    passed: Vec<u8>,
    queue: [Vec<u32>; MOST_PASSED + 1],
}

impl Coarsening {
    /// Chooses anew.
    pub(super) fn rebuild(&mut self, pattern: &BlockPattern, numbering: Numbering, is_boundary: &[bool]) {
        let n = pattern.row_count();
        empty(&mut self.node, n);
        self.node.resize(n, NO_NODE);
        empty(&mut self.passed, n);
        self.passed.resize(n, 0);
        for of_boundary in [true, false] {
            // Those without passed neighbours in the order of places: the queues are stacks.
            for row in (0..n as u32).rev().map(|place| numbering.row(place)) {
                if is_boundary[row as usize] == of_boundary {
                    self.queue[usize::from(self.passed[row as usize]).min(MOST_PASSED)].push(row);
                }
            }
            self.select(pattern, is_boundary, of_boundary);
        }
        self.row.clear();
        for row in (0..n as u32).map(|place| numbering.row(place)) {
            let node = &mut self.node[row as usize];
            *node = if *node == PASSED {
                NO_NODE
            } else {
                self.row.push(row);
                self.row.len() as u32 - 1
            };
        }
    }

    /// Goes on after edits from the choice before them: rows that were added come last, nodes stay nodes. Of those that `is_near` an
    /// edit a row becomes one where no node is beside it, or, at a boundary, none of the boundary.
    pub(super) fn follow(&mut self, pattern: &BlockPattern, is_boundary: &[bool], is_near: impl Fn(usize) -> bool) {
        self.node.resize(pattern.row_count(), NO_NODE);
        for row in (0..pattern.row_count()).filter(|&row| is_near(row)) {
            let is_covered = |near: u32| {
                let near = near as usize;
                self.node[near] != NO_NODE && (is_boundary[near] || !is_boundary[row])
            };
            if self.node[row] == NO_NODE && !pattern.neighbours(row).any(is_covered) {
                self.node[row] = self.row.len() as u32;
                self.row.push(row as u32);
            }
        }
    }

    /// The choice of these nodes among so many rows; `None` where they are not each once among them, and fewer.
    pub(super) fn of_nodes(nodes: &[u32], row_count: usize) -> Option<Self> {
        let mut node = vec![NO_NODE; row_count];
        for (n, &row) in (0..).zip(nodes) {
            let place = node.get_mut(row as usize).filter(|node| **node == NO_NODE)?;
            *place = n;
        }
        let is_coarser = !nodes.is_empty() && nodes.len() < row_count;
        is_coarser.then(|| Self { node, row: nodes.to_vec(), ..Self::default() })
    }

    fn select(&mut self, pattern: &BlockPattern, is_boundary: &[bool], of_boundary: bool) {
        let mut level = MOST_PASSED;
        loop {
            let Some(row) = self.queue[level].pop() else {
                if level == 0 {
                    return;
                }
                level -= 1;
                continue;
            };
            // An entry from before its count rose, or of a row that is settled.
            if self.node[row as usize] != NO_NODE || usize::from(self.passed[row as usize]).min(MOST_PASSED) != level {
                continue;
            }
            self.node[row as usize] = row;
            for near in pattern.neighbours(row as usize) {
                if self.node[near as usize] != NO_NODE {
                    continue;
                }
                self.node[near as usize] = PASSED;
                for far in pattern.neighbours(near as usize) {
                    let passed = &mut self.passed[far as usize];
                    *passed = passed.saturating_add(1);
                    if self.node[far as usize] == NO_NODE && is_boundary[far as usize] == of_boundary {
                        let next = usize::from(*passed).min(MOST_PASSED);
                        self.queue[next].push(far);
                        level = level.max(next);
                    }
                }
            }
        }
    }
}
