//! Random edit sequences against a naive twin that is rebuilt from scratch after every edit.

mod meshes;

use glam::DVec3;
use meshes::{Body, Random, Sheet};
use rhexis::math::RestTriangle;
use rhexis::storage::{
    Attached, Broken, Edit, EditRecord, Follow, NONE, Refusal, Topology, apply,
    measure::{linear_momentum, rest_data, total_area, total_mass},
    undo,
};
use std::collections::HashMap;

/// Corners and positions only; every question is answered by looking at all triangles.
struct Twin {
    corners: Vec<[u32; 3]>,
    rest: Vec<DVec3>,
    now: Vec<DVec3>,
}

impl Twin {
    fn find(&self, from: u32, to: u32) -> Option<(usize, usize)> {
        let edge = |c: &[u32; 3]| (0..3).find(|&e| c[e] == from && c[(e + 1) % 3] == to);
        self.corners.iter().enumerate().find_map(|(t, c)| Some((t, edge(c)?)))
    }

    fn push_between(&mut self, weights: &[(u32, f64)]) -> u32 {
        for list in [&mut self.rest, &mut self.now] {
            let mut point = list[weights[0].0 as usize] * weights[0].1;
            for &(row, weight) in &weights[1..] {
                point += list[row as usize] * weight;
            }
            list.push(point);
        }
        self.rest.len() as u32 - 1
    }

    fn replaced(c: [u32; 3], old: u32, new: u32) -> [u32; 3] {
        c.map(|v| if v == old { new } else { v })
    }

    fn apply(&mut self, edit: &Edit) {
        match *edit {
            Edit::SplitEdge { triangle, edge, weight } => {
                let c = self.corners[triangle as usize];
                let (u, v) = (c[edge], c[(edge + 1) % 3]);
                let m = self.push_between(&[(u, 1.0 - weight), (v, weight)]);
                let other = self.find(v, u);
                self.corners.push(Self::replaced(c, u, m));
                self.corners[triangle as usize] = Self::replaced(c, v, m);
                if let Some((s, _)) = other {
                    let c = self.corners[s];
                    self.corners.push(Self::replaced(c, v, m));
                    self.corners[s] = Self::replaced(c, u, m);
                }
            }
            Edit::SplitTriangle { triangle, weights: w } => {
                let c = self.corners[triangle as usize];
                let m = self.push_between(&[(c[0], w[0]), (c[1], w[1]), (c[2], w[2])]);
                self.corners[triangle as usize] = [c[0], c[1], m];
                self.corners.extend([[m, c[1], c[2]], [c[0], m, c[2]]]);
            }
            Edit::Flip { triangle, edge } => {
                let c = self.corners[triangle as usize];
                let (u, v, o) = (c[edge], c[(edge + 1) % 3], c[(edge + 2) % 3]);
                let (s, f) = self.find(v, u).unwrap();
                let p = self.corners[s][(f + 2) % 3];
                self.corners[triangle as usize] = Self::replaced(c, v, p);
                self.corners[s] = Self::replaced(self.corners[s], u, o);
            }
            Edit::Slide { vertex, towards, weight } => {
                for list in [&mut self.rest, &mut self.now] {
                    let (a, b) = (list[vertex as usize], list[towards as usize]);
                    list[vertex as usize] = a * (1.0 - weight) + b * weight;
                }
            }
            Edit::Open { ref path } => {
                let cut = |a, b| path.windows(2).any(|p| p == [a, b] || p == [b, a]);
                let before = self.corners.clone();
                let loops = path.first() == path.last();
                for &v in &path[usize::from(loops)..] {
                    // Grow groups of triangles that share an uncut edge at v, by repeated merging.
                    let mut groups: Vec<Vec<usize>> =
                        (0..before.len()).filter(|&t| before[t].contains(&v)).map(|t| vec![t]).collect();
                    let joined = |a: &[usize], b: &[usize]| {
                        a.iter().any(|&t| {
                            before[t].iter().any(|&w| w != v && !cut(v, w) && b.iter().any(|&s| before[s].contains(&w)))
                        })
                    };
                    while let Some((i, j)) = (0..groups.len())
                        .flat_map(|i| (0..i).map(move |j| (i, j)))
                        .find(|&(i, j)| joined(&groups[i], &groups[j]))
                    {
                        let merged = groups.swap_remove(i);
                        groups[j].extend(merged);
                    }
                    groups.sort_by_key(|g| g.iter().min().copied());
                    for group in &groups[1..] {
                        let copy = self.push_between(&[(v, 1.0)]);
                        for &t in group {
                            let corner = before[t].iter().position(|&w| w == v).unwrap();
                            self.corners[t][corner] = copy;
                        }
                    }
                }
            }
        }
    }

    fn compare(&self, body: &Body, context: &str) {
        assert_eq!(self.corners, body.triangles.corners, "{context}");
        assert_eq!(self.rest, body.vertices.rest_position, "{context}");
        assert_eq!(self.now, body.vertices.position, "{context}");
        let mut incident = vec![Vec::new(); self.rest.len()];
        let mut mass = vec![0.0; self.rest.len()];
        let mut edges = HashMap::new();
        for (t, c) in self.corners.iter().enumerate() {
            let x = c.map(|v| self.rest[v as usize]);
            let rest = RestTriangle::new(x, body.triangles.fibre[t]).unwrap();
            assert_eq!(rest, body.triangles.rest[t], "{context}");
            for corner in 0..3 {
                incident[c[corner] as usize].push(3 * t as u32 + corner as u32);
                mass[c[corner] as usize] += rest.area * body.triangles.thickness[t] * body.triangles.density[t] / 3.0;
                edges.insert((c[corner], c[(corner + 1) % 3]), t as u32);
            }
        }
        assert_eq!(mass, body.vertices.mass, "{context}");
        assert!(incident.iter().eq(body.topology.incident.iter().map(|list| list.as_slice())), "{context}");
        for (t, c) in self.corners.iter().enumerate() {
            let expected = [0, 1, 2].map(|e| edges.get(&(c[(e + 1) % 3], c[e])).copied().unwrap_or(NONE));
            assert_eq!(expected, body.topology.neighbours[t], "{context}");
        }
    }
}

fn random_edit(body: &Body, random: &mut Random) -> Edit {
    let triangle = random.below(body.triangles.len()) as u32;
    let edge = random.below(3);
    match random.below(10) {
        0..=2 => Edit::SplitEdge { triangle, edge, weight: random.unit() },
        3 => {
            let w = [random.between(0.1, 1.0), random.between(0.1, 1.0), random.between(0.1, 1.0)];
            let sum = w[0] + w[1] + w[2];
            Edit::SplitTriangle { triangle, weights: w.map(|w| w / sum) }
        }
        4..=5 => Edit::Flip { triangle, edge },
        6 => {
            let c = body.triangles.corners[triangle as usize];
            Edit::Slide { vertex: c[edge], towards: c[(edge + 1) % 3], weight: random.between(0.0, 0.6) }
        }
        _ => {
            let mut path = vec![body.triangles.corners[triangle as usize][edge]];
            for _ in 0..=random.below(4) {
                let around = &body.topology.incident[path[path.len() - 1] as usize];
                let entry = around[random.below(around.len())];
                path.push(body.triangles.corners[(entry / 3) as usize][(entry as usize + 1) % 3]);
            }
            Edit::Open { path: path.into() }
        }
    }
}

fn kind(edit: &Edit) -> usize {
    match edit {
        Edit::SplitEdge { .. } => 0,
        Edit::SplitTriangle { .. } => 1,
        Edit::Flip { .. } => 2,
        Edit::Slide { .. } => 3,
        Edit::Open { .. } => 4,
    }
}

/// At least `count` applied edits, every invariant after each, then everything undone.
fn run(sheet: &Sheet, fibre: DVec3, is_flat: bool, seed: u8, count: usize) {
    let mut random = Random::new(seed);
    let mut body = Body::new(sheet, fibre);
    body.deform(&mut random);
    let (room, triangle_room) = (2 * count, 2 * count);
    body.vertices.reserve(room);
    body.triangles.reserve(triangle_room);
    body.topology.reserve(room, triangle_room);
    let capacities =
        |b: &Body| (b.vertices.position.capacity(), b.triangles.rest.capacity(), b.topology.neighbours.capacity());
    let reserved = capacities(&body);
    let start = (body.vertices.clone(), body.triangles.clone(), body.topology.clone());
    let mut twin =
        Twin { corners: sheet.corners.clone(), rest: sheet.positions.clone(), now: body.vertices.position.clone() };
    let rim: Vec<(u32, DVec3)> = (0..body.vertices.len() as u32)
        .filter(|&v| body.topology.is_boundary_vertex(v))
        .map(|v| (v, body.vertices.rest_position[v as usize]))
        .collect();
    let mut members = Attached::new(rim);
    let start_members = members.clone();
    let mut follower = body.topology.clone();

    let mut records: Vec<EditRecord> = Vec::new();
    let mut applied = [0; 5];
    let mut refused = 0;
    while records.len() < count {
        let edit = random_edit(&body, &mut random);
        let area = total_area(&body.triangles);
        let (mass, momentum) = (total_mass(&body.vertices), linear_momentum(&body.vertices));
        let energy = body.elastic_energy();
        let context = format!("seed {seed}, edit {}: {edit:?}", records.len());
        let record = match apply(&mut body.mesh(), &edit) {
            Ok(record) => record,
            Err(_) => {
                refused += 1;
                if refused % 16 == 0 {
                    twin.compare(&body, &context);
                }
                continue;
            }
        };
        twin.apply(&edit);
        twin.compare(&body, &context);
        assert_eq!(body.mesh().validate(), Ok(()), "{context}");
        let tables = rhexis::storage::Tables { vertices: &body.vertices, triangles: &body.triangles };
        members.apply(&record, tables);
        follower.apply(&record, tables);

        // Sums of some 1e3 terms of one size round to about 1e-14; a lost triangle would show as 1e-5 or more.
        let relative = |a: f64, b: f64| (a - b).abs() / b.abs();
        assert!(relative(total_mass(&body.vertices), mass) < 1e-12, "{context}");
        let size: f64 = body.vertices.mass.iter().zip(&body.vertices.velocity).map(|(m, v)| m * v.length()).sum();
        assert!((linear_momentum(&body.vertices) - momentum).length() < 1e-12 * size, "{context}");
        let remaps = matches!(edit, Edit::Flip { .. } | Edit::Slide { .. });
        if is_flat || !remaps {
            assert!(relative(total_area(&body.triangles), area) < 1e-12, "{context}");
        }
        if !remaps {
            // Gradients of triangles down to 1e-3 of the sheet's size carry rounding of 1e-13 into the strain.
            assert!(relative(body.elastic_energy(), energy) < 1e-11, "{context}");
        }
        applied[kind(&edit)] += 1;
        records.push(record);
    }
    assert!(applied.iter().all(|&n| n >= count / 50), "every kind must be exercised: {applied:?}");
    assert!(refused > count / 10, "refusals must be exercised: {refused}");
    assert_eq!(capacities(&body), reserved, "reserved room must suffice");
    assert_eq!(follower, body.topology);
    if is_flat {
        for (&row, &value) in members.rows().iter().zip(members.values()) {
            assert_eq!(value, body.vertices.rest_position[row as usize], "a rim value follows its vertex");
        }
        assert!(members.rows().len() > start_members.rows().len());
    }

    let mut rebuilt = Body { vertices: body.vertices.clone(), triangles: body.triangles.clone(), ..body };
    rest_data(&mut rebuilt.mesh()).unwrap();
    assert_eq!(rebuilt.triangles.rest, body.triangles.rest);
    assert_eq!(rebuilt.vertices.mass, body.vertices.mass);
    body.topology = rebuilt.topology;

    for record in records.iter().rev() {
        undo(&mut body.mesh(), record).unwrap();
        let tables = rhexis::storage::Tables { vertices: &body.vertices, triangles: &body.triangles };
        members.undo(record, tables);
        follower.undo(record, tables);
    }
    assert_eq!(members, start_members);
    assert_eq!(follower, start.2);
    assert_eq!(body.topology, start.2);
    assert_eq!(body.vertices.keys(), start.0.keys());
    assert_eq!(body.triangles.keys(), start.1.keys());
    for row in 0..start.0.len() as u32 {
        assert_eq!(body.vertices.at(row), start.0.at(row));
    }
    for row in 0..start.1.len() as u32 {
        assert_eq!(body.triangles.at(row), start.1.at(row));
    }
}

#[test]
fn random_edits_on_a_flat_sheet() {
    for seed in 1..=3 {
        run(&meshes::grid(10, 8, 30.0, 24.0), DVec3::new(1.0, 1.0, 0.0), true, seed, 1000);
    }
}

#[test]
fn random_edits_on_a_closed_surface() {
    for seed in 11..=12 {
        run(&meshes::sphere(2), DVec3::new(1.0, 0.5, 0.2), false, seed, 1000);
    }
}

#[test]
fn random_edits_on_a_cap() {
    for seed in 21..=22 {
        run(&meshes::cap(5), DVec3::new(0.3, 1.0, 0.0), false, seed, 1000);
    }
}

#[test]
fn a_refusal_names_its_reason_and_changes_nothing() {
    let sheet = meshes::grid(4, 4, 4.0, 4.0);
    let mut body = Body::new(&sheet, DVec3::X);
    let before = (body.vertices.clone(), body.triangles.clone(), body.topology.clone());
    let refuse = |body: &mut Body, edit: Edit| apply(&mut body.mesh(), &edit).unwrap_err();
    let open = |path: &[u32]| Edit::Open { path: path.into() };
    let split = |triangle, edge, weight| Edit::SplitEdge { triangle, edge, weight };

    assert_eq!(refuse(&mut body, split(99, 0, 0.5)), Refusal::NoSuchRow { what: "triangle", row: 99 });
    assert_eq!(refuse(&mut body, split(0, 3, 0.5)), Refusal::NoSuchEdge { from: NONE, to: NONE });
    for weight in [0.0, 1.0, -0.5, f64::NAN, f64::INFINITY] {
        assert!(matches!(refuse(&mut body, split(0, 0, weight)), Refusal::WeightOutOfRange { .. }));
    }
    assert!(matches!(refuse(&mut body, split(0, 0, 1e-6)), Refusal::WouldMakeSliver { .. }));
    let weights = [0.5, 0.5, 0.5];
    let edit = Edit::SplitTriangle { triangle: 0, weights };
    assert_eq!(refuse(&mut body, edit), Refusal::WeightOutOfRange { weight: 1.5 });
    assert_eq!(refuse(&mut body, Edit::Flip { triangle: 0, edge: 0 }), Refusal::BoundaryEdge { from: 0, to: 1 });
    // Triangle 0 is (0, 1, 6), its neighbour across the edge (1, 6) is (1, 2, 6): no convex quadrilateral.
    assert!(matches!(refuse(&mut body, Edit::Flip { triangle: 0, edge: 1 }), Refusal::WouldInvert { .. }));
    let slide = |vertex, towards, weight| Edit::Slide { vertex, towards, weight };
    assert_eq!(refuse(&mut body, slide(0, 6, 0.5)), Refusal::BoundaryVertex { vertex: 0 });
    assert_eq!(refuse(&mut body, slide(6, 24, 0.5)), Refusal::NoSuchEdge { from: 6, to: 24 });
    assert_eq!(refuse(&mut body, slide(6, 7000, 0.5)), Refusal::NoSuchRow { what: "vertex", row: 7000 });
    assert_eq!(refuse(&mut body, open(&[6, 7])), Refusal::NothingOpens);
    assert_eq!(refuse(&mut body, open(&[0, 1])), Refusal::BoundaryEdge { from: 0, to: 1 });
    assert_eq!(refuse(&mut body, open(&[6, 24])), Refusal::NoSuchEdge { from: 6, to: 24 });
    assert_eq!(refuse(&mut body, open(&[6, 7, 6])), Refusal::BadPath { count: 3 });
    assert_eq!(refuse(&mut body, open(&[])), Refusal::BadPath { count: 0 });
    assert_eq!(refuse(&mut body, open(&[6, u32::MAX])), Refusal::NoSuchRow { what: "vertex", row: u32::MAX });

    assert_eq!(body.topology, before.2);
    assert_eq!(body.vertices.position, before.0.position);
    assert_eq!(body.triangles.corners, before.1.corners);
}

#[test]
fn a_vertex_with_three_triangles_keeps_them() {
    let mut body = Body::new(&meshes::grid(3, 3, 3.0, 3.0), DVec3::X);
    let third = 1.0 / 3.0;
    let split = Edit::SplitTriangle { triangle: 7, weights: [third; 3] };
    let record = apply(&mut body.mesh(), &split).unwrap();
    let [a, b, _] = record.new_triangles[1].corners;
    assert_eq!(b, record.first_vertex);
    let edge = body.topology.directed_edge(&body.triangles.corners, a, b).unwrap();
    let flip = Edit::Flip { triangle: edge.0, edge: edge.1 };
    assert!(matches!(apply(&mut body.mesh(), &flip), Err(Refusal::EdgeExists { .. })));
}

#[test]
fn only_the_last_edit_can_be_undone() {
    let mut body = Body::new(&meshes::grid(3, 3, 3.0, 3.0), DVec3::X);
    let first = apply(&mut body.mesh(), &Edit::SplitEdge { triangle: 4, edge: 0, weight: 0.5 }).unwrap();
    let second = apply(&mut body.mesh(), &Edit::SplitEdge { triangle: 9, edge: 0, weight: 0.5 }).unwrap();
    assert_eq!(undo(&mut body.mesh(), &first), Err(Refusal::NotTheLast));
    assert_eq!(undo(&mut body.mesh(), &second), Ok(()));
    assert_eq!(undo(&mut body.mesh(), &second), Err(Refusal::NotTheLast));
    assert_eq!(undo(&mut body.mesh(), &first), Ok(()));
}

#[test]
fn a_loop_frees_a_disc_and_leaves_single_fans() {
    let mut body = Body::new(&meshes::grid(6, 6, 6.0, 6.0), DVec3::X);
    let ring: Vec<u32> = vec![16, 17, 18, 25, 32, 31, 30, 23, 16];
    apply(&mut body.mesh(), &Edit::Open { path: ring.into() }).unwrap();
    assert_eq!(body.topology.components().0, 2);
    assert_eq!(body.mesh().validate(), Ok(()));
}

#[test]
fn the_validator_names_what_is_broken() {
    let fresh = || Body::new(&meshes::grid(3, 3, 3.0, 3.0), DVec3::X);
    let mut body = fresh();
    body.vertices.velocity.pop();
    assert_eq!(body.mesh().validate(), Err(Broken::Misaligned { table: "vertices", column: "velocity" }));
    let mut body = fresh();
    body.topology.neighbours[4][0] = 7;
    assert_eq!(body.mesh().validate(), Err(Broken::Neighbours { triangle: 4 }));
    let mut body = fresh();
    body.topology.incident[5].swap(0, 1);
    assert_eq!(body.mesh().validate(), Err(Broken::Incidence { vertex: 5 }));
    let mut body = fresh();
    body.vertices.position[3].y = f64::NAN;
    assert_eq!(body.mesh().validate(), Err(Broken::NotFinite { column: "position", vertex: 3 }));
    let mut body = fresh();
    body.vertices.rest_position[5].x += 1e-9;
    assert!(matches!(body.mesh().validate(), Err(Broken::RestData { .. })));
    let mut body = fresh();
    body.vertices.mass[2] *= 1.0 + 1e-15;
    assert_eq!(body.mesh().validate(), Err(Broken::Mass { vertex: 2 }));
    let mut body = fresh();
    body.triangles.corners[0].swap(0, 1);
    assert!(matches!(body.mesh().validate(), Err(Broken::EdgeUsedTwice { .. })));
    assert!(Topology::new(0, &[]).is_ok());
}
