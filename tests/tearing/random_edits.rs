//! Random walks of edits, undone now and then, against a naive twin: 100,000 edits in all, over flat, curved, closed and torn
//! meshes so small that everything is checked after each. A share of the edits is made where two lips meet, as a tear that goes on within
//! an edge makes them: glides, both lips split at one weight, a vertex ahead collapsed into the tip, flips.

use crate::meshes::twin::{Seen, Twin};
use crate::meshes::{self, Body, Random, Sheet};
use glam::DVec3;
use rhexis::components::{Curve, EdgeLoad, EdgeLoads, Increment, PointLoad, PointLoads};
use rhexis::math::smallest_angle;
use rhexis::storage::{
    Attached, Edit, EditRecord, Follow, Refusal, Tables, TipRow, Tips, Topology, TriangleRow, apply,
    measure::{linear_momentum, rest_corners, total_area, total_mass},
    outlook, undo,
};

/// A mesh to walk on.
struct Walk {
    sheet: Sheet,
    fibre: DVec3,
    /// Opened before the walk.
    tears: Vec<Vec<u32>>,
    /// All in one plane and of one material.
    is_flat: bool,
    /// Number of edits in ten that are made at a tip.
    tip_share: usize,
    /// Above so many triangles collapses are preferred, below splits.
    triangle_count: usize,
}

/// Everything that follows edits.
#[derive(Clone)]
struct Followers {
    members: Attached<DVec3>,
    topology: Topology,
    increment: Increment,
    tips: Tips,
    point_loads: PointLoads,
    rim_loads: EdgeLoads,
}

/// All that an undo has to bring back.
#[derive(Clone)]
struct State {
    body: Body,
    twin: Twin,
    followers: Followers,
}

#[derive(Default)]
struct Tally {
    applied: [usize; 7],
    boundary_collapses: usize,
    halved_lips: usize,
    collapses_into_tips: usize,
    refused: usize,
    undone: usize,
}

impl Tally {
    /// Counts an edit that was applied to a body.
    fn note(&mut self, edit: &Edit, before: &Body, is_at_tip: bool) {
        self.applied[kind(edit)] += 1;
        if let Edit::Collapse { vertex, .. } = *edit {
            self.boundary_collapses += usize::from(before.topology.is_boundary_vertex(vertex));
            self.collapses_into_tips += usize::from(is_at_tip);
        }
    }

    /// Whether every kind of edit was exercised in walks of `count` edits.
    fn check(&self, walk: &Walk, count: usize) {
        let Self { applied, boundary_collapses, halved_lips, collapses_into_tips, refused, undone } = self;
        println!(
            "applied {applied:?}, {boundary_collapses} collapses on the boundary, {collapses_into_tips} into a tip, \
             {halved_lips} pairs of lips split, {refused} refused, {undone} undone"
        );
        assert!(applied.iter().all(|&n| n >= count / 50), "every kind must be exercised: {applied:?}");
        assert!(*refused > count / 10 && *undone > count / 10, "refused {refused}, undone {undone}");
        // A closed or curved surface has straight stretches of boundary only where a tear was split or leads straight on.
        let least = if walk.is_flat { count / 50 } else { count / 1000 };
        assert!(*boundary_collapses > least, "{boundary_collapses}");
        let [glides, others] = [applied[6], (*halved_lips).min(*collapses_into_tips)];
        let share = count * walk.tip_share;
        assert!(glides > share / 40 && others > share / 400, "{glides} glides, {others} others at tips");
    }
}

fn kind(edit: &Edit) -> usize {
    match edit {
        Edit::SplitEdge { .. } => 0,
        Edit::SplitTriangle { .. } => 1,
        Edit::Flip { .. } => 2,
        Edit::Slide { .. } => 3,
        Edit::Open { .. } => 4,
        Edit::Collapse { .. } => 5,
        Edit::Glide { .. } => 6,
    }
}

fn random_edit(body: &Body, wanted: usize, random: &mut Random) -> Edit {
    let triangle = random.below(body.triangles.len()) as u32;
    let edge = random.below(3);
    let corners = body.triangles.corners[triangle as usize];
    let (vertex, other) = (corners[edge], corners[(edge + 1) % 3]);
    let shrink = if body.triangles.len() > wanted { 12 } else { 3 };
    match random.below(11 + shrink) {
        0..=2 => Edit::SplitEdge { triangle, edge, weight: random.unit() },
        3 => {
            let w = [random.between(0.1, 1.0), random.between(0.1, 1.0), random.between(0.1, 1.0)];
            let sum = w[0] + w[1] + w[2];
            Edit::SplitTriangle { triangle, weights: w.map(|w| w / sum) }
        }
        4..=5 => Edit::Flip { triangle, edge },
        6..=7 => Edit::Slide { vertex, towards: other, weight: random.between(0.0, 0.6) },
        8..=9 => {
            let mut path = vec![vertex];
            for _ in 0..=random.below(4) {
                let around = &body.topology.incident[path[path.len() - 1] as usize];
                let entry = around[random.below(around.len())];
                path.push(body.triangles.corners[(entry / 3) as usize][(entry as usize + 1) % 3]);
            }
            Edit::Open { path: path.into() }
        }
        10 => Edit::Glide { vertex, triangle, weights: random_weights(edge, random) },
        _ if random.below(2) == 0 => Edit::Collapse { vertex: other, into: vertex },
        _ => Edit::Collapse { vertex, into: other },
    }
}

/// Weights of a point in a triangle, now and then on one of its edges, of which a corner has 0.2 and more.
fn random_weights(corner: usize, random: &mut Random) -> [f64; 3] {
    let kept = random.between(0.2, 1.0);
    let share = if random.below(4) == 0 { 0.0 } else { random.unit() };
    let mut weights = [kept; 3];
    weights[(corner + 1) % 3] = (1.0 - kept) * share;
    weights[(corner + 2) % 3] = (1.0 - kept) * (1.0 - share);
    weights
}

/// Edits at a vertex where two lips meet, as a tear that goes on within an edge makes them.
fn edits_at_tip(body: &Body, (tip, [previous, next]): (u32, [u32; 2]), random: &mut Random) -> Vec<Edit> {
    let around = &body.topology.incident[tip as usize];
    let entry = around[random.below(around.len())];
    let (triangle, corner) = (entry / 3, entry as usize % 3);
    match random.below(10) {
        0..=4 => vec![Edit::Glide { vertex: tip, triangle, weights: random_weights(corner, random) }],
        5..=6 => {
            let weight = random.between(0.3, 0.7);
            let side = |from, to| body.topology.directed_edge(&body.triangles.corners, from, to).unwrap();
            let lips = [(side(tip, next), weight), (side(previous, tip), 1.0 - weight)];
            lips.map(|((triangle, edge), weight)| Edit::SplitEdge { triangle, edge, weight }).to_vec()
        }
        7..=8 => {
            vec![Edit::Collapse { vertex: body.triangles.corners[triangle as usize][(corner + 1) % 3], into: tip }]
        }
        _ => vec![Edit::Flip { triangle, edge: random.below(3) }],
    }
}

impl State {
    fn new(walk: &Walk, random: &mut Random, seen: &mut Seen) -> Self {
        let mut body = Body::new(&walk.sheet, walk.fibre);
        if !walk.is_flat {
            for row in 0..body.triangles.len() {
                body.triangles.thickness[row] *= random.between(0.8, 1.2);
                body.triangles.density[row] *= random.between(0.8, 1.2);
            }
            rhexis::storage::measure::rest_data(&mut body.mesh()).unwrap();
        }
        let rim: Vec<u32> = (0..body.vertices.len() as u32).filter(|&v| body.topology.is_boundary_vertex(v)).collect();
        let next = |v: u32| body.topology.next_boundary_vertex(&body.triangles.corners, v).unwrap();
        let edges = rim.iter().map(|&v| [v, next(v)]).collect();
        let rim_load = EdgeLoad { edges, traction: DVec3::X, curve: Curve::constant(1.0) };
        let mut rim_loads = EdgeLoads { groups: vec![rim_load] };
        for path in &walk.tears {
            rim_loads.follow(&apply(&mut body.mesh(), &Edit::Open { path: path.as_slice().into() }).unwrap());
        }
        body.deform(random);

        // The rim, and some vertices inside.
        let rest = &body.vertices.rest_position;
        let member = |v: u32| (v.is_multiple_of(5) || rim.contains(&v)).then_some(rest[v as usize]);
        let members: Vec<Option<DVec3>> = (0..rest.len() as u32).map(member).collect();
        let rows = (0..).zip(&members).filter_map(|(row, &value)| Some((row, value?)));
        let tips_of_tears = walk.tears.iter().flat_map(|path| [path[0], path[path.len() - 1]]);
        let marked: Vec<u32> = [1, 4, rest.len() as u32 - 1].into_iter().chain(tips_of_tears).collect();
        let mut tips = Tips::default();
        for &vertex in &marked {
            let (previous, ideal) = (DVec3::X, DVec3::ZERO);
            tips.push(TipRow {
                vertex,
                previous,
                ideal,
                criterion: 0.0,
                fall: 0.0,
                is_refused: false,
                is_coarse: false,
            });
        }
        let point_load = PointLoad { rows: marked.clone(), force: DVec3::X, curve: Curve::constant(1.0) };
        let followers = Followers {
            members: Attached::new(rows),
            topology: body.topology.clone(),
            // What blends as the rest positions do has to stay equal to them.
            increment: Increment { start: rest.clone(), ..Increment::default() },
            tips,
            point_loads: PointLoads { groups: vec![point_load] },
            rim_loads,
        };
        let marked = marked.iter().map(|&row| body.vertices.key(row).unwrap()).collect();
        let twin = Twin::new(&body, members, marked, seen);
        Self { body, twin, followers }
    }

    /// Applies an edit everywhere and checks everything.
    fn apply(
        &mut self,
        edit: &Edit,
        before: &Body,
        walk: &Walk,
        seen: &mut Seen,
        context: &str,
    ) -> Result<EditRecord, Refusal> {
        let expected = outlook(&self.body.mesh(), edit);
        let (area, energy) = (total_area(&before.triangles), before.elastic_energy());
        let record = match apply(&mut self.body.mesh(), edit) {
            Ok(record) => record,
            Err(refusal) => {
                assert_eq!(expected, Err(refusal), "{context}");
                self.twin.compare(&self.body, context);
                return Err(refusal);
            }
        };
        let ring = if let Edit::Collapse { vertex, .. } = *edit { Some(self.twin.ring(vertex)) } else { None };
        self.twin.apply(edit, &self.body, seen);
        self.twin.compare(&self.body, context);
        assert_eq!(self.body.mesh().validate(), Ok(()), "{context}");
        self.follow(&record, walk, context);

        let body = &self.body;
        // Sums of some 1e2 terms of one size round to about 1e-14; a lost triangle would show as 1e-5 or more.
        let relative = |a: f64, b: f64| (a - b).abs() / b.abs();
        assert!(relative(total_mass(&body.vertices), total_mass(&before.vertices)) < 1e-12, "{context}");
        let size: f64 = body.vertices.mass.iter().zip(&body.vertices.velocity).map(|(m, v)| m * v.length()).sum();
        let off = (linear_momentum(&body.vertices) - linear_momentum(&before.vertices)).length();
        assert!(off < 1e-12 * size, "{off:e} of {size:e}, {context}");
        let remaps =
            matches!(edit, Edit::Flip { .. } | Edit::Slide { .. } | Edit::Glide { .. } | Edit::Collapse { .. });
        if walk.is_flat || !remaps {
            assert!(relative(total_area(&body.triangles), area) < 1e-12, "{context}");
        }
        if walk.is_flat {
            assert!(body.triangles.density.iter().all(|&density| density == 1e-3), "{context}");
            assert!(relative(body.outlined_area(), 30.0) < 1e-12, "{context}");
        }
        if !remaps {
            // Gradients of triangles down to 1e-3 of the sheet's size carry rounding of 1e-13 into the strain.
            assert!(relative(body.elastic_energy(), energy) < 1e-11, "{context}");
        }
        if let Some(ring) = ring {
            self.check_collapse(before, &record, &ring, context);
        }
        if let Edit::Glide { vertex, .. } = *edit {
            self.check_glide(before, vertex, context);
        }
        let angle = |row: u32| smallest_angle(rest_corners(&body.vertices, body.triangles.corners[row as usize]));
        let is_shaped = |c: &&rhexis::storage::ChangedTriangle| match *edit {
            Edit::Collapse { vertex, .. } => c.before.corners.contains(&vertex),
            _ => true,
        };
        let new = record.first_triangle..record.first_triangle + record.new_triangles.len() as u32;
        let shaped = record.changed_triangles.iter().filter(is_shaped).map(|c| c.row).chain(new);
        let least = shaped.map(angle).fold(std::f64::consts::PI, f64::min);
        assert_eq!(expected.map(|outlook| outlook.smallest_angle), Ok(least), "{context}");
        Ok(record)
    }

    /// Who is not in the ring of a collapse keeps state and material, wherever the rows went.
    fn check_collapse(&self, before: &Body, record: &EditRecord, ring: &std::collections::HashSet<u32>, context: &str) {
        let removed = record.removed.as_ref().unwrap();
        for row in 0..before.vertices.len() as u32 {
            let after = record.vertex_after(row);
            assert_eq!(self.body.vertices.row(before.vertices.key(row).unwrap()), after, "{context}");
            assert_eq!(after.is_none(), row == removed.vertex, "{context}");
            if let Some(after) = after {
                let velocity = self.body.vertices.velocity[after as usize];
                assert!(ring.contains(&row) || velocity == before.vertices.velocity[row as usize], "{context}");
            }
        }
        for row in 0..before.triangles.len() as u32 {
            let after = record.triangle_after(row);
            assert_eq!(self.body.triangles.row(before.triangles.key(row).unwrap()), after, "{context}");
            if let Some(after) = after {
                let (old, new) = (before.triangles.at(row), self.body.triangles.at(after));
                assert_remapped(before, (&old, &new), old.corners.contains(&removed.vertex), context);
            }
        }
    }

    /// A glide leaves the topology, state and material away from the tip as they were, and two lips of equal length.
    fn check_glide(&self, before: &Body, tip: u32, context: &str) {
        let body = &self.body;
        assert_eq!(body.topology, before.topology, "{context}");
        let ring = self.twin.ring(tip);
        for row in (0..body.vertices.len() as u32).filter(|row| !ring.contains(row)) {
            assert_eq!(body.vertices.at(row), before.vertices.at(row), "{context}");
        }
        for row in 0..body.triangles.len() as u32 {
            let (old, new) = (before.triangles.at(row), body.triangles.at(row));
            assert_remapped(before, (&old, &new), old.corners.contains(&tip), context);
            assert!(old.corners.contains(&tip) || old == new, "{context}");
        }
        let (_, ends) = *before.tips().iter().find(|(row, _)| *row == tip).unwrap_or_else(|| panic!("{context}"));
        let length = |row: u32| self.twin.rest[tip as usize].distance(self.twin.rest[row as usize]);
        assert!((length(ends[0]) - length(ends[1])).abs() < 1e-12, "{context}");
    }

    fn follow(&mut self, record: &EditRecord, walk: &Walk, context: &str) {
        let Self { body, twin, followers } = self;
        let tables = Tables { vertices: &body.vertices, triangles: &body.triangles };
        followers.members.apply(record, tables);
        followers.topology.apply(record, tables);
        followers.increment.follow(record);
        followers.tips.follow(record);
        followers.point_loads.follow(record);
        followers.rim_loads.follow(record);

        assert_eq!(followers.topology, body.topology, "{context}");
        let members = followers.members.rows().iter().zip(followers.members.values());
        let expected = (0..).zip(&twin.members).filter_map(|(row, &value)| Some((row, value?)));
        assert!(members.map(|(&row, &value)| (row, value)).eq(expected), "{context}");
        assert_eq!(followers.increment.start, body.vertices.rest_position, "{context}");
        let marked: Vec<u32> = twin.marked.iter().map(|&key| body.vertices.row(key).unwrap()).collect();
        assert_eq!(followers.tips.vertex, marked, "{context}");
        assert_eq!(followers.point_loads.groups[0].rows, marked, "{context}");
        let loaded = &followers.rim_loads.groups[0].edges;
        let mut length = 0.0;
        for &[a, b] in loaded {
            let side = |from, to| body.topology.directed_edge(&body.triangles.corners, from, to);
            assert!(side(a, b).is_some() && side(b, a).is_none(), "no rim from {a} to {b}, {context}");
            length += twin.rest[a as usize].distance(twin.rest[b as usize]);
        }
        if walk.is_flat {
            // The whole rim of a rectangle of 6 × 5 is loaded, whatever its vertices.
            assert!((length - 22.0).abs() < 1e-12, "{length}, {context}");
        }
    }

    fn undo(&mut self, record: &EditRecord, earlier: Self, context: &str) {
        let (gone, back) = (self.body.clone(), &earlier.body);
        undo(&mut self.body.mesh(), record).unwrap();
        let Self { body, followers, .. } = &mut *self;
        let tables = Tables { vertices: &body.vertices, triangles: &body.triangles };
        followers.members.undo(record, tables);
        followers.topology.undo(record, tables);
        assert_eq!(followers.members, earlier.followers.members, "{context}");
        assert_eq!(followers.topology, earlier.followers.topology, "{context}");
        assert_eq!(body.topology, back.topology, "{context}");
        assert_eq!(body.mesh().validate(), Ok(()), "{context}");
        assert_eq!(body.vertices.keys(), back.vertices.keys(), "{context}");
        assert_eq!(body.triangles.keys(), back.triangles.keys(), "{context}");
        assert_eq!(body.vertices.buried(), back.vertices.buried(), "{context}");
        assert_eq!(body.triangles.buried(), back.triangles.buried(), "{context}");
        assert!((0..back.vertices.len() as u32).all(|row| body.vertices.at(row) == back.vertices.at(row)), "{context}");
        let same = |row| body.triangles.at(row) == back.triangles.at(row);
        assert!((0..back.triangles.len() as u32).all(same), "{context}");
        // What the edit had added is dead.
        let dead = gone.vertices.keys().iter().filter(|&&key| back.vertices.row(key).is_none());
        assert!(dead.into_iter().all(|&key| body.vertices.row(key).is_none()), "{context}");
        (self.twin, self.followers) = (earlier.twin, earlier.followers);
    }
}

/// A triangle that an edit has moved takes values from its neighbours', one that it has not keeps its own.
fn assert_remapped(before: &Body, (old, new): (&TriangleRow, &TriangleRow), has_moved: bool, context: &str) {
    assert_eq!(old.stiffness, new.stiffness, "{context}");
    if !has_moved || before.triangles.is_uniform() {
        assert_eq!((old.fibre, old.thickness, old.density), (new.fibre, new.thickness, new.density), "{context}");
    }
    let least = before.triangles.thickness.iter().copied().fold(f64::INFINITY, f64::min);
    let most = before.triangles.thickness.iter().copied().fold(0.0, f64::max);
    let width = most - least;
    assert!((least - width..=most + width).contains(&new.thickness), "{context}");
    assert!((new.fibre.length() - 1.0).abs() < 1e-12, "{context}");
}

/// Walks of 250 edits each, until `count` were applied.
fn run(walk: &Walk, seed: u8, count: usize) {
    const LONGEST: usize = 250;
    let mut random = Random::new(seed);
    let mut tally = Tally::default();
    while tally.applied.iter().sum::<usize>() < count {
        let mut seen = Seen::default();
        let mut state = State::new(walk, &mut random, &mut seen);
        let mut done: Vec<(EditRecord, State)> = Vec::new();
        for step in 0..LONGEST {
            let context = format!("seed {seed}, {:?} done, step {step}", tally.applied);
            match random.below(40) {
                0..=1 => {
                    for _ in 0..random.below(done.len() + 1) {
                        let (record, earlier) = done.pop().unwrap();
                        state.undo(&record, earlier, &context);
                        tally.undone += 1;
                    }
                    continue;
                }
                2 => {
                    done.clear();
                    state.body.mesh().release();
                    state.followers.members.release();
                    assert!(state.body.vertices.buried().is_empty() && state.body.triangles.buried().is_empty());
                    continue;
                }
                _ => {}
            }
            let tips = if random.below(10) < walk.tip_share { state.body.tips() } else { Vec::new() };
            let is_at_tip = !tips.is_empty();
            let edits = if is_at_tip {
                edits_at_tip(&state.body, tips[random.below(tips.len())], &mut random)
            } else {
                vec![random_edit(&state.body, walk.triangle_count, &mut random)]
            };
            let first = done.len();
            for edit in &edits {
                let earlier = state.clone();
                match state.apply(edit, &earlier.body, walk, &mut seen, &format!("{context}: {edit:?}")) {
                    Ok(record) => {
                        tally.note(edit, &earlier.body, is_at_tip);
                        done.push((record, earlier));
                    }
                    Err(_) => {
                        tally.refused += 1;
                        break;
                    }
                }
            }
            tally.halved_lips += usize::from(edits.len() == 2 && done.len() == first + 2);
        }
    }
    tally.check(walk, count);
}

fn flat() -> Walk {
    let sheet = meshes::grid(6, 5, 6.0, 5.0);
    Walk { sheet, fibre: DVec3::new(1.0, 1.0, 0.0), tears: Vec::new(), is_flat: true, tip_share: 1, triangle_count: 60 }
}

#[test]
fn on_a_flat_sheet() {
    run(&flat(), 1, 20_000);
}

#[test]
fn on_a_torn_sheet() {
    // A notch from the lower rim, and a slit inside.
    run(&Walk { tears: vec![vec![2, 9, 16], vec![18, 25, 32]], tip_share: 5, ..flat() }, 2, 20_000);
}

#[test]
fn on_a_cap() {
    let fibre = DVec3::new(0.3, 1.0, 0.0);
    run(
        &Walk { sheet: meshes::cap(3), fibre, tears: Vec::new(), is_flat: false, tip_share: 2, triangle_count: 54 },
        3,
        20_000,
    );
}

#[test]
fn on_a_sphere() {
    let fibre = DVec3::new(1.0, 0.5, 0.2);
    run(
        &Walk { sheet: meshes::sphere(1), fibre, tears: Vec::new(), is_flat: false, tip_share: 2, triangle_count: 40 },
        4,
        20_000,
    );
}

#[test]
fn on_a_torus() {
    let fibre = DVec3::new(1.0, 0.5, 0.2);
    run(
        &Walk {
            sheet: meshes::torus(7, 5),
            fibre,
            tears: Vec::new(),
            is_flat: false,
            tip_share: 2,
            triangle_count: 70,
        },
        5,
        20_000,
    );
}
