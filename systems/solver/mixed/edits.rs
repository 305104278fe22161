//! Changes of the triangles by edits since the last solve: of those that the log of edits names, the corners are compared.
//! Those before stand in the partition, as rows.

use super::adjacency::neighbours;
use super::empty;
use super::order::Order;
use super::partition::Partition;
use crate::storage::{EditLog, Revision, Topology};

/// Order and patterns are rebuilt where more than one triangle in this many has changed since the last solve.
const TRIANGLES_PER_CHANGE: usize = 16;

/// Order and patterns are rebuilt where more than one triangle in this many has changed since the last rebuild. Rows out of order cost
/// iterations: on the tearing lens capsule none with this limit, an eighth more without it.
const MOST_IN_ALL: usize = 8;

/// The triangles that have other corners than at an earlier moment, of those before that there still are; ascending. `vertex` has the
/// vertices of the rows.
pub(super) fn changed(
    partition: &Partition,
    corners: &[[u32; 3]],
    (log, since): (&EditLog, Revision),
    vertex: &[u32],
) -> impl Iterator<Item = u32> {
    let kept = 0..partition.triangle_count().min(corners.len()) as u32;
    let differs = move |&t: &u32| partition.rows(t).map(|row| vertex[row as usize]) != corners[t as usize];
    kept.filter(move |&t| log.has_changed(t, since)).filter(differs)
}

/// The triangles that have changed and the rows that they concern. Scratch.
#[derive(Debug, Default)]
pub(super) struct Edits {
    /// Triangles with other corners than before, those that were added included; ascending.
    pub triangles: Vec<u32>,
    /// Number of triangles before; none as long as there have been no edits.
    pub count_before: usize,
    /// Per row, whether its neighbours or theirs may be others than before, or have other rows.
    pub is_touched: Vec<bool>,
    /// Vertices that have changed their rows.
    moved: Vec<u32>,
    /// Vertices with other neighbours than before, or whose neighbours have other rows; some of them more than once.
    touched: Vec<u32>,
}

impl Edits {
    /// Whether there have been edits.
    pub(super) fn have_been(&self) -> bool {
        self.count_before > 0
    }

    /// Lists the triangles changed since an earlier revision and updates `order`. `false`, with the order unchanged, where a rebuild is due.
    pub(super) fn find(
        &mut self,
        partition: &Partition,
        corners: &[[u32; 3]],
        (topology, since): (&Topology, Revision),
        order: &mut Order,
    ) -> bool {
        let Self { triangles, count_before, is_touched, moved, touched } = self;
        let (rows_before, rows) = (order.row.len(), topology.incident.len());
        let before = partition.triangle_count();
        let most = (before / TRIANGLES_PER_CHANGE).max(1);
        if before == 0 || corners.len().abs_diff(before) > most || rows_before.abs_diff(rows) > most {
            return false;
        }
        let vertices = |rows: [u32; 3]| rows.map(|row| order.vertex[row as usize]);
        empty(triangles, most + 1);
        let changed = changed(partition, corners, (&topology.log, since), &order.vertex);
        triangles.extend(changed.chain(before as u32..corners.len() as u32).take(most + 1));
        let changed = order.changed + triangles.len();
        if triangles.len() > most || changed > corners.len() / MOST_IN_ALL {
            return false;
        }
        // Corners before and after.
        empty(touched, 6 * most);
        let gone = corners.len() as u32..before as u32;
        let of_old = triangles.iter().copied().filter(|&t| (t as usize) < before).chain(gone);
        let of_old = of_old.flat_map(|t| vertices(partition.rows(t)));
        touched.extend(of_old.chain(triangles.iter().flat_map(|&t| corners[t as usize])));
        order.changed = changed;
        *count_before = before;
        empty(moved, most);
        order.follow(rows, triangles, corners, moved);
        empty(is_touched, rows);
        is_touched.resize(rows, false);
        for &v in &*moved {
            touched.push(v);
            touched.extend(neighbours(v, corners, topology));
        }
        // A vertex that is gone has no row.
        for &v in touched.iter().filter(|v| (**v as usize) < rows) {
            is_touched[order.row[v as usize] as usize] = true;
            neighbours(v, corners, topology).for_each(|w| is_touched[order.row[w as usize] as usize] = true);
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::super::adjacency::Adjacency;
    use super::super::partition;
    use super::super::pattern::BlockPattern;
    use super::*;

    /// Corners of a grid with `n` cells to a side.
    fn grid(n: u32) -> Vec<[u32; 3]> {
        let cell = |i: u32| {
            let a = i / n * (n + 1) + i % n;
            [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]
        };
        (0..n * n).flat_map(cell).collect()
    }

    fn vertex_count(corners: &[[u32; 3]]) -> usize {
        corners.iter().flatten().max().map_or(0, |&v| v as usize + 1)
    }

    /// Cuts a corner off triangle `t`, at a new vertex inside it. Or takes the last vertex out if such a cut has made it, and puts
    /// the last triangles in the places of those that vanish, as the tables do.
    fn edit(corners: &mut Vec<[u32; 3]>, made: &mut Vec<[u32; 3]>, t: usize, removes: bool) {
        if removes && let Some(parent) = made.pop() {
            let last = vertex_count(corners) as u32 - 1;
            let mut around = (0..corners.len()).filter(|&t| corners[t].contains(&last));
            let [a, b, c] = std::array::from_fn(|_| around.next().unwrap());
            corners[a] = parent;
            corners.swap_remove(c);
            corners.swap_remove(b);
            return;
        }
        let ([a, b, c], new) = (corners[t], vertex_count(corners) as u32);
        made.push([a, b, c]);
        corners[t] = [a, b, new];
        corners.extend([[b, c, new], [c, a, new]]);
    }

    #[test]
    fn a_pattern_that_follows_edits_equals_one_found_anew() {
        [BlockPattern::default, BlockPattern::filled].into_iter().for_each(|empty| follows_edits(empty, |_| 0));
    }

    /// Edits come to either half, and the tables' way to close gaps takes triangles from the second to the first.
    #[test]
    fn subdomains_stay_apart_under_edits() {
        follows_edits(BlockPattern::filled, |corners| partition::cut(corners.len()));
    }

    fn follows_edits(empty: fn() -> BlockPattern, cut: fn(&[[u32; 3]]) -> u32) {
        let mut corners = grid(40);
        let mut topology = Topology::new(vertex_count(&corners), &corners).unwrap();
        let (mut order, mut partition, mut pattern) = (Order::default(), Partition::default(), empty());
        let mut adjacency = Adjacency::default();
        adjacency.rebuild(&corners, &topology);
        order.rebuild(&corners, &adjacency, cut(&corners));
        partition.rebuild(&corners, &order.row);
        pattern.rebuild(&partition, (&order.vertex, &order.row), &corners, |v| adjacency.of(v));
        let (mut edits, mut made, mut rebuilds) = (Edits::default(), Vec::new(), 0);
        for step in 0..120_usize {
            for i in 0..1 + step % 3 {
                let t = (step * 7919 + i * 104_729) % corners.len();
                edit(&mut corners, &mut made, t, step % 5 > 2);
            }
            topology = Topology::new(vertex_count(&corners), &corners).unwrap();
            if edits.find(&partition, &corners, (&topology, Revision::default()), &mut order) {
                partition.rebuild(&corners, &order.row);
                let stays = |row: usize| !edits.is_touched[row];
                pattern.follow(&partition, (&order.vertex, &order.row), &corners, &topology, &edits, stays);
            } else {
                rebuilds += 1;
                adjacency.rebuild(&corners, &topology);
                order.rebuild(&corners, &adjacency, cut(&corners));
                partition.rebuild(&corners, &order.row);
                pattern.rebuild(&partition, (&order.vertex, &order.row), &corners, |v| adjacency.of(v));
            }
            assert_eq!(order.vertex.len(), topology.incident.len());
            let rows = order.vertex.len();
            assert!(order.dissection.are_of(rows, partition.all_rows()), "step {step}");
            assert!(
                cut(&corners) == 0 || order.dissection.ranges(rows).iter().all(|part| part.len() > 30),
                "step {step}"
            );
            assert!((0..).zip(&order.vertex).all(|(row, &v)| order.row[v as usize] == row), "step {step}");
            let mut anew = empty();
            anew.rebuild(&partition, (&order.vertex, &order.row), &corners, |v| neighbours(v, &corners, &topology));
            assert!(pattern.equals(&anew), "step {step}");
        }
        assert!((1..20).contains(&rebuilds), "{rebuilds}");
    }

    #[test]
    fn too_many_edits_leave_the_order_as_it_was() {
        let corners = grid(10);
        let topology = Topology::new(vertex_count(&corners), &corners).unwrap();
        let (mut order, mut partition, mut adjacency) = (Order::default(), Partition::default(), Adjacency::default());
        adjacency.rebuild(&corners, &topology);
        order.rebuild(&corners, &adjacency, 0);
        partition.rebuild(&corners, &order.row);
        let turned: Vec<[u32; 3]> = corners.iter().map(|&[a, b, c]| [b, c, a]).collect();
        let rows = order.row.clone();
        let since = (&topology, Revision::default());
        assert!(!Edits::default().find(&partition, &turned, since, &mut order));
        assert!(!Edits::default().find(&Partition::default(), &corners, since, &mut order));
        assert_eq!(order.row, rows);
    }
}
