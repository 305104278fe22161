//! A copy of a body's arrays that is kept by what the engine tells of its changes alone.

use crate::common::{DT, Square};
use glam::DVec3;
use proptest::prelude::Rng;
use proptest::test_runner::{RngAlgorithm, TestRng};
use rhexis::components::{Change, ChangeSet, Changes, Refined, Refinement, TearLog};
use rhexis::settings::Settings;
use rhexis::simulation::{BodyView, Simulation};
use rhexis::storage::{TriangleKey, VertexKey};
use std::collections::HashMap;

/// Two copies: one by the list of changes, one by the ranges of rows.
#[derive(Default)]
struct Mirror {
    triangles: Vec<[u32; 3]>,
    /// Rest positions stand for anything that belongs to vertices, such as texture coordinates: new ones are blended.
    rest: Vec<DVec3>,
    /// By triangle, something of the caller's own: the triangle at the start that it comes from.
    origin: Vec<u32>,
    copied_triangles: Vec<[u32; 3]>,
    copied_rest: Vec<DVec3>,
    removals: usize,
    vertex_keys: Vec<VertexKey>,
    triangle_keys: Vec<TriangleKey>,
}

impl Mirror {
    fn follow(&mut self, changes: &ChangeSet, view: &BodyView) {
        self.assert_destinations(changes, view);
        if changes.is_whole {
            self.triangles = view.triangles.to_vec();
            self.rest = view.rest_positions.to_vec();
            self.origin = (0..view.triangles.len() as u32).collect();
        }
        for change in &changes.list {
            match *change {
                Change::VertexAdded { row, parents } => {
                    assert_eq!(row as usize, self.rest.len());
                    self.rest.push(parents.blend(|parent| self.rest[parent as usize]));
                }
                Change::VertexMoved { row, parents } => {
                    self.rest[row as usize] = parents.blend(|parent| self.rest[parent as usize]);
                }
                Change::VertexRemoved { row } => {
                    self.rest.swap_remove(row as usize);
                    self.removals += 1;
                }
                Change::TriangleChanged { row, corners } => self.triangles[row as usize] = corners,
                Change::TriangleAdded { row, parent, corners } => {
                    assert_eq!(row as usize, self.triangles.len());
                    self.triangles.push(corners);
                    self.origin.push(self.origin[parent as usize]);
                }
                Change::TriangleRemoved { row } => {
                    self.triangles.swap_remove(row as usize);
                    self.origin.swap_remove(row as usize);
                }
            }
        }
        self.copied_rest.resize(changes.vertex_count as usize, DVec3::NAN);
        self.copied_triangles.resize(changes.triangle_count as usize, [0; 3]);
        for rows in &changes.vertices {
            let rows = rows.start as usize..rows.end as usize;
            self.copied_rest[rows.clone()].copy_from_slice(&view.rest_positions[rows]);
        }
        for rows in &changes.triangles {
            let rows = rows.start as usize..rows.end as usize;
            self.copied_triangles[rows.clone()].copy_from_slice(&view.triangles[rows]);
        }
    }

    /// Rows have gone where their keys are, and what was copied has its source's place.
    fn assert_destinations(&mut self, changes: &ChangeSet, view: &BodyView) {
        let rows: HashMap<_, _> = view.vertex_keys.iter().zip(0..).collect();
        let triangle_rows: HashMap<_, _> = view.triangle_keys.iter().zip(0..).collect();
        for (key, row) in self.vertex_keys.iter().zip(0..).filter(|_| !changes.is_whole) {
            assert_eq!(changes.vertex_destination(row), rows.get(key).copied());
        }
        for (key, row) in self.triangle_keys.iter().zip(0..).filter(|_| !changes.is_whole) {
            assert_eq!(changes.triangle_destination(row), triangle_rows.get(key).copied());
        }
        assert_eq!(changes.vertex_destination(u32::MAX), None);
        self.vertex_keys = view.vertex_keys.to_vec();
        self.triangle_keys = view.triangle_keys.to_vec();
    }

    fn assert_equal(&self, view: &BodyView) {
        let bits = |positions: &[DVec3]| positions.iter().map(|p| p.to_array().map(f64::to_bits)).collect::<Vec<_>>();
        assert_eq!(self.triangles, view.triangles);
        assert_eq!(self.copied_triangles, view.triangles);
        assert!(bits(&self.rest) == bits(view.rest_positions), "rest positions by the list");
        assert!(bits(&self.copied_rest) == bits(view.rest_positions), "rest positions by the ranges");
        assert_eq!(self.origin.len(), view.triangles.len());
    }
}

#[test]
fn a_mirror_of_the_changes_equals_the_arrays_bit_for_bit() {
    let (mut removals, mut advances, mut cuts) = (0, 0, 0);
    let (mut wholes, mut parts, mut most) = (0, 0, 0);
    for seed in 0..3 {
        let mut random = TestRng::from_seed(RngAlgorithm::ChaCha, &[seed; 32]);
        let mut unit = move || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
        let mut square = Square::new([24, 20], 180.0 * unit());
        square.tearing.strength_across_fibres *= 0.2;
        square.tearing.strength_along_fibres *= 0.2;
        square.tearing.radius *= 0.7;
        let mut simulation = Simulation::new(Settings { threads: 1, ..Settings::default() }).unwrap();
        let refinement = Refinement { edges_per_radius: 3.0, budget: 3.0, ..Refinement::default() };
        let body = simulation.spawn(square.membrane().with(refinement).with(Changes::default())).unwrap();
        let (mut mirror, mut changes) = (Mirror::default(), ChangeSet::default());
        let mut keep = |simulation: &mut Simulation| {
            simulation.drain_changes(body, &mut changes).unwrap();
            let view = simulation.view(body).unwrap();
            mirror.follow(&changes, &view);
            mirror.assert_equal(&view);
            wholes += usize::from(changes.is_whole);
            parts += usize::from(!changes.is_whole);
            most = most.max(changes.list.len());
            changes.is_whole
        };
        assert!(keep(&mut simulation), "the first time all is new");
        simulation.cut(body, &crate::common::NOTCH).unwrap();
        for step in 0..40 {
            simulation.step(DT).unwrap();
            if unit() < 0.15 {
                let [from, to] = [0, 1].map(|_| DVec3::new(5.0 + 20.0 * unit(), 3.0 + 24.0 * unit(), 0.0));
                cuts += usize::from(simulation.cut(body, &[from, to]).is_ok());
            }
            if step == 25 {
                simulation.reorder(body).unwrap();
            }
            // Not after every step, and never twice the same way.
            if unit() < 0.6 || step == 25 {
                let is_whole = keep(&mut simulation);
                assert!(is_whole || step != 25, "a new order makes all new");
            }
        }
        keep(&mut simulation);
        let world = simulation.world();
        advances += world.get::<&TearLog>(body.entity()).unwrap().advance_count;
        removals += world.get::<&Refined>(body.entity()).unwrap().removed_count;
        assert!(mirror.removals > 0 || world.get::<&Refined>(body.entity()).unwrap().removed_count == 0);
    }
    println!("{parts} lists of up to {most} changes, {wholes} times the whole");
    // The first time and after the new order, and few more where much was refined between two looks.
    assert!(wholes <= 3 * 4 && parts > 50, "{wholes} {parts}");
    assert!(removals > 20 && advances > 50 && cuts > 5, "{removals} removals, {advances} advances, {cuts} cuts");
}
