//! Levels that follow edits: only rows near one are recomputed.
//!
//! Nodes stay nodes. A row that an edit has left without a node beside it becomes one, so that both sides of a tear
//! have nodes of their own on all levels as it goes on. Weights and patterns are functions of the nodes and of the
//! mesh: they are recomputed where either has changed, and equal those of a full rebuild with the same
//! nodes.

use super::super::adjacency::neighbours;
use super::super::edits::Edits;
use super::super::order::Order;
use super::super::partition::Partition;
use super::coarsen::Coarsening;
use super::galerkin;
use super::hierarchy::{Hierarchy, MOST_COARSE_SHARE, MOST_COARSEST};
use super::level::Level;
use super::marks::Mark;
use super::numbering::Numbering;
use super::transfer::Transfer;
use crate::storage::{Topology, Triangles, Vertices};

/// Data to remake levels from, beside the mesh: as they follow edits, they are not a function of it.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Choices {
    /// Rows in chunks and chunk size of every level's numbering.
    numbering: Vec<[u32; 2]>,
    /// Per level but the last the rows that are nodes of the next.
    nodes: Vec<Vec<u32>>,
}

impl Hierarchy {
    /// The choices that the levels are made of.
    pub(super) fn choices(&self) -> Choices {
        Choices {
            numbering: self.levels.iter().map(|level| level.numbering.kept()).collect(),
            nodes: self.transfers.iter().map(|transfer| transfer.coarsening.row.clone()).collect(),
        }
    }

    /// Levels of these choices, with so many rows on the finest; all but the choices comes with [`follow`](Self::follow). `None` where no
    /// levels can have them.
    pub(super) fn of_choices(choices: &Choices, row_count: usize) -> Option<Self> {
        let mut hierarchy = Self::default();
        let mut row_count = row_count;
        let mut nodes = choices.nodes.iter();
        for &kept in &choices.numbering {
            let numbering = Numbering::of_kept(kept, row_count)?;
            hierarchy.levels.push(Level { numbering, ..Level::default() });
            if let Some(nodes) = nodes.next() {
                let coarsening = Coarsening::of_nodes(nodes, row_count)?;
                row_count = nodes.len();
                hierarchy.transfers.push(Transfer::of(coarsening));
            }
        }
        (hierarchy.levels.len() == hierarchy.transfers.len() + 1).then_some(hierarchy)
    }

    /// Brings the levels up to edits, or remakes the data that belongs to their choices. `false` where a full rebuild is needed, and the
    /// present levels are of no use.
    pub(super) fn follow(
        &mut self,
        partition: &Partition,
        order: &Order,
        mesh: (&Vertices, &Triangles, &Topology),
        edits: Option<&Edits>,
    ) -> bool {
        let n = order.vertex.len();
        let is_dense = |level: &Level| level.numbering.count as usize <= MOST_COARSEST;
        let was_dense = self.levels.last().is_some_and(is_dense);
        let Some(finest) = self.levels.first_mut().filter(|finest| finest.numbering.count as usize <= n) else {
            return false;
        };
        finest.numbering.grow(n);
        let numbering = finest.numbering;
        self.number(order);
        self.marks.clear(n);
        let touched = edits.into_iter().flat_map(|edits| (0..).zip(&edits.is_touched).filter(|(_, is)| **is));
        for (place, _) in touched {
            self.marks.add(numbering.row(place) as usize, Mark::REACHED);
        }
        let Self { levels, marks, vertex, row, is_made, .. } = self;
        let (pattern, rows, (_, triangles, topology)) = (&mut levels[0].pattern, (&**vertex, &**row), mesh);
        match edits.filter(|_| *is_made) {
            Some(edits) => {
                pattern.follow(partition, rows, &triangles.corners, topology, edits, |row| !marks.is_any(row));
            }
            None => {
                pattern.rebuild(partition, rows, &triangles.corners, |v| neighbours(v, &triangles.corners, topology));
                marks.add_to_all(Mark::STALE);
            }
        }
        pattern.finish();
        self.find_places(mesh);
        self.is_made = self.levels[0].is_in_order(&self.marks)
            && (1..self.levels.len()).all(|coarse| self.follow_level(coarse))
            && (!was_dense || self.levels.last().is_some_and(is_dense));
        if self.is_made {
            self.fit_vectors();
        }
        self.is_made
    }

    /// Brings a coarser level up to the finer one; returns whether it can go on.
    fn follow_level(&mut self, coarse: usize) -> bool {
        let Self { levels, transfers, marks, next_marks, .. } = self;
        let (fine, coarse) = levels.split_at_mut(coarse);
        let (transfer, fine, coarse) = (&mut transfers[fine.len() - 1], &fine[fine.len() - 1], &mut coarse[0]);
        transfer.coarsening.follow(&fine.pattern, &fine.is_boundary, |row| marks.is_reached(row));
        let nodes = transfer.coarsening.row.len();
        if nodes as f64 > MOST_COARSE_SHARE * fine.pattern.row_count() as f64 {
            return false;
        }
        transfer.follow(&fine.pattern, &fine.places, marks, next_marks);
        coarse.numbering.grow(nodes);
        galerkin::follow_pattern(&mut coarse.pattern, &fine.pattern, transfer, next_marks);
        coarse.copy_places(fine, &transfer.coarsening.row);
        std::mem::swap(marks, next_marks);
        coarse.is_in_order(marks)
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::adjacency::Adjacency;
    use super::super::super::edits::changed;
    use super::super::level::FREE;
    use super::*;
    use crate::components::Material;
    use crate::membrane::Membrane;
    use crate::settings::Settings;
    use crate::simulation::Simulation;
    use crate::storage::{Revision, TriangleMesh};
    use glam::{DVec3, Vec4};

    const CELLS: [u32; 2] = [120, 100];

    /// A sheet of 24,000 triangles, six chunks of rows, that is cut a little further at each call; the tables after every cut.
    fn cuts(mut after: impl FnMut((&Vertices, &Triangles, &Topology))) {
        let [nx, ny] = CELLS;
        let place = |v: u32| DVec3::new(f64::from(v % (nx + 1)), f64::from(v / (nx + 1)), 0.0);
        let cell = |i: u32| {
            let a = i / nx * (nx + 1) + i % nx;
            [[a, a + 1, a + nx + 2], [a, a + nx + 2, a + nx + 1]]
        };
        let positions = (0..(nx + 1) * (ny + 1)).map(place).collect();
        let mesh = TriangleMesh { positions, triangles: (0..nx * ny).flat_map(cell).collect(), fibres: None };
        let mut simulation = Simulation::new(Settings { threads: 1, ..Settings::default() }).unwrap();
        let body = simulation.spawn(Membrane::new("sheet", mesh, Material::allard_2009())).unwrap();
        let at = |i: u32| {
            let s = f64::from(i) / 12.0;
            DVec3::new(60.0 + 18.0 * (5.0 * s).sin(), 100.0 - 85.0 * s, 0.0)
        };
        for i in 0..12 {
            let mut tables = simulation.world().query_one::<(&Vertices, &Triangles, &Topology)>(body.entity());
            after(tables.get().unwrap());
            drop(tables);
            simulation.cut(body, &[at(i), at(i + 1)]).unwrap();
        }
    }

    #[test]
    fn levels_that_follow_are_those_of_their_choices_found_anew() {
        let (mut order, mut partition, mut edits) = (Order::default(), Partition::default(), Edits::default());
        let (mut hierarchy, mut adjacency) = (Hierarchy::default(), Adjacency::default());
        let (mut followed, mut nodes, mut since) = (0, Vec::new(), Revision::default());
        cuts(|mesh| {
            let (_, Triangles { corners, .. }, topology) = mesh;
            let log = &topology.log;
            if !adjacency.is_found() {
                adjacency.rebuild(corners, topology);
                order.rebuild(corners, &adjacency, 0);
                partition.rebuild(corners, &order.row);
                hierarchy.rebuild(&partition, &order, mesh);
                assert!(hierarchy.levels[0].numbering != Numbering::single(order.vertex.len()));
            } else {
                let choices = hierarchy.choices();
                let mut pending = Hierarchy::of_choices(&choices, order.vertex.len()).unwrap();
                let list = |since| changed(&partition, corners, (log, since), &order.vertex).collect::<Vec<_>>();
                assert_eq!(list(since), list(Revision::default()), "by the log, and by all corners");
                assert!(edits.find(&partition, corners, (topology, since), &mut order));
                partition.rebuild(corners, &order.row);
                assert!(hierarchy.follow(&partition, &order, mesh, Some(&edits)));
                // From the choices before the edits, and from those after them.
                assert!(pending.follow(&partition, &order, mesh, Some(&edits)));
                assert_equal(&hierarchy, &pending);
                let mut anew = Hierarchy::of_choices(&hierarchy.choices(), order.vertex.len()).unwrap();
                assert!(anew.follow(&partition, &order, mesh, None));
                assert_equal(&hierarchy, &anew);
                followed += 1;
            }
            nodes.push(hierarchy.transfers[0].coarsening.row.len());
            since = log.now();
        });
        assert_eq!(followed, 11);
        // The cut passes some hundred vertices by, on either side of which every second or third is a node.
        let added = nodes[11] - nodes[0];
        assert!((30..200).contains(&added), "{nodes:?}");
    }

    /// Springs between neighbours on so many levels that the coarser ones are cycled through twice.
    #[test]
    fn two_cycles_are_symmetric_and_positive_and_know_the_product_with_the_answer() {
        let mut hierarchy = Hierarchy::default();
        cuts(|mesh| {
            if !hierarchy.levels.is_empty() {
                return;
            }
            let (mut order, mut partition, mut adjacency) =
                (Order::default(), Partition::default(), Adjacency::default());
            let (_, Triangles { corners, .. }, topology) = mesh;
            adjacency.rebuild(corners, topology);
            order.rebuild(corners, &adjacency, 0);
            partition.rebuild(corners, &order.row);
            hierarchy.rebuild(&partition, &order, mesh);
        });
        assert!(hierarchy.levels.len() > 4);
        let spring = |k: f32| [Vec4::X * k, Vec4::Y * k, Vec4::Z * k];
        let pattern = &hierarchy.levels[0].pattern;
        let diagonal: Vec<_> =
            (0..pattern.row_count()).map(|row| spring(pattern.neighbours(row).count() as f32 + 1e-3)).collect();
        let lower = vec![spring(-1.0); pattern.column.len()];
        assert!(hierarchy.set(&diagonal, &lower, &vec![FREE; diagonal.len()]));
        let dot = |a: &[Vec4], b: &[Vec4]| a.iter().zip(b).map(|(a, b)| f64::from(a.dot(*b))).sum::<f64>();
        let [a, b] = [0.37_f32, 0.0113].map(|k| {
            let wave = |row: usize| Vec4::new((k * row as f32).sin(), (2.0 * k * row as f32).cos(), 0.5, 0.0);
            let r: Vec<Vec4> = (0..diagonal.len()).map(wave).collect();
            let product = hierarchy.forward_sweep(|row| r[row]);
            hierarchy.backward_sweep(|row| r[row]);
            (product, hierarchy.answer().to_vec(), r)
        });
        // Ten thousand terms, of which each is rounded to 6e-8 some ten times; most are of one sign.
        for (product, answer, r) in [&a, &b] {
            assert!(*product > 0.0 && (product - dot(r, answer)).abs() < 1e-5 * product, "{product}");
        }
        let ([ab, ba], size) = ([dot(&a.1, &b.2), dot(&b.1, &a.2)], (a.0 * b.0).sqrt());
        assert!((ab - ba).abs() < 1e-5 * size, "{ab} and {ba} of {size}");
    }

    fn assert_equal(a: &Hierarchy, b: &Hierarchy) {
        assert_eq!(a.choices(), b.choices());
        for (level, (a, b)) in a.levels.iter().zip(&b.levels).enumerate() {
            assert_eq!(a.numbering, b.numbering, "level {level}");
            assert!(a.places == b.places && a.is_boundary == b.is_boundary, "level {level}");
            assert!(a.pattern.equals(&b.pattern), "level {level}");
        }
        for (a, b) in a.transfers.iter().zip(&b.transfers) {
            let other = a.parts.iter().zip(&b.parts).enumerate().find(|(_, (a, b))| a != b);
            assert!(other.is_none() && a.parts.len() == b.parts.len(), "{other:?}");
            assert!((0..a.coarsening.row.len()).all(|node| a.support(node) == b.support(node)));
            assert_eq!(a.coarsening.node, b.coarsening.node);
        }
    }

    #[test]
    fn choices_that_no_levels_can_have_are_refused() {
        let good = Choices { numbering: vec![[9, 31], [3, 31]], nodes: vec![vec![0, 4, 8]] };
        assert!(Hierarchy::of_choices(&good, 9).is_some() && Hierarchy::of_choices(&good, 8).is_none());
        let numbering = good.numbering.clone();
        for nodes in [vec![vec![0, 4, 9]], vec![vec![0, 4, 4]], vec![(0..9).collect()], vec![vec![]], vec![]] {
            assert!(Hierarchy::of_choices(&Choices { numbering: numbering.clone(), nodes }, 9).is_none());
        }
        assert!(Hierarchy::of_choices(&Choices::default(), 0).is_none());
    }
}
