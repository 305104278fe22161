//! Tears at random, crossing each other until little is left: what must hold after every single one of them.

use crate::meshes::tears::{angles, assert_same, cutter, undo_all};
use crate::meshes::{self, Body, Random, Sheet};
use glam::{DQuat, DVec3};
use rhexis::components::{TearMode, TearSite};
use rhexis::event::Course;
use rhexis::storage::measure::{linear_momentum, rest_angles, total_area, total_mass};
use rhexis::systems::fracture::{TearRefusal, TearScratch};

/// What a storm of tears has done.
#[derive(Default, Debug)]
struct Tally {
    advances: usize,
    courses: [usize; Course::ALL.len()],
    /// Advances of free mode along an edge.
    free_edges: usize,
    starts: usize,
    cuts: usize,
    ends: usize,
    pieces: usize,
    /// Refused although there was a way to try.
    stuck: usize,
    least: f64,
}

impl Tally {
    fn add(&mut self, other: &Self) {
        self.advances += other.advances;
        self.starts += other.starts;
        self.cuts += other.cuts;
        self.ends += other.ends;
        self.pieces += other.pieces;
        self.stuck += other.stuck;
        self.free_edges += other.free_edges;
        self.least = self.least.min(other.least);
        self.courses.iter_mut().zip(other.courses).for_each(|(sum, count)| *sum += count);
    }
}

struct Storm {
    name: String,
    body: Body,
    random: Random,
    scratch: TearScratch,
    /// Vertex, last direction, ideal point.
    tips: Vec<(u32, DVec3, DVec3)>,
    pieces: usize,
    tally: Tally,
}

impl Storm {
    fn new(name: &str, sheet: &Sheet, seed: u8) -> Self {
        let mut random = Random::new(seed);
        let mut body = Body::new(sheet, DVec3::X);
        body.deform(&mut random);
        let pieces = body.topology.components().0;
        let (scratch, tips, tally) = (TearScratch::default(), Vec::new(), Tally::default());
        Self { name: format!("{name} {seed}"), body, random, scratch, tips, pieces, tally }
    }

    fn at(&self, row: u32) -> DVec3 {
        self.body.vertices.rest_position[row as usize]
    }

    fn normal(&self, vertex: u32) -> DVec3 {
        let triangle = self.body.topology.incident[vertex as usize][0] / 3;
        let [a, b, c] = self.body.triangles.corners[triangle as usize].map(|row| self.at(row));
        (b - a).cross(c - a).normalize()
    }

    fn turned(&mut self, vertex: u32, direction: DVec3, most: f64) -> DVec3 {
        DQuat::from_axis_angle(self.normal(vertex), self.random.between(-most, most)) * direction
    }

    fn any_direction(&mut self, vertex: u32) -> DVec3 {
        let one = self.normal(vertex).any_orthonormal_vector();
        self.turned(vertex, one, std::f64::consts::PI)
    }

    fn any_vertex(&mut self) -> u32 {
        self.random.below(self.body.vertices.len()) as u32
    }

    fn ended(&mut self, freed: Option<usize>) {
        self.pieces += usize::from(freed.is_some());
        self.tally.pieces += usize::from(freed.is_some());
    }

    fn note(&mut self, refusal: &TearRefusal) {
        self.tally.stuck += usize::from(matches!(refusal, TearRefusal::NoWay(_)));
    }

    fn advance(&mut self) {
        if self.tips.is_empty() {
            return self.start();
        }
        let k = self.random.below(self.tips.len());
        let (vertex, last, ideal) = self.tips[k];
        let wild = self.random.below(8) == 0;
        let direction = if wild { self.any_direction(vertex) } else { self.turned(vertex, last, 0.6) };
        let is_free = self.random.below(4) > 0;
        let mut mesh = self.body.mesh();
        let mut cutter = cutter(&mut mesh, &mut self.scratch);
        let done = if is_free {
            cutter.advance(vertex, direction).map(|advance| (advance, advance.to))
        } else {
            cutter.advance_along_edge(vertex, ideal, direction).map(|step| (step.advance, step.ideal))
        };
        match done {
            Ok((advance, ideal)) => {
                self.tally.advances += 1;
                self.tally.free_edges += usize::from(is_free && advance.course == Course::Edge);
                self.tally.courses[advance.course as usize] += 1;
                match advance.end {
                    Some(end) => {
                        self.tally.ends += 1;
                        self.tips.retain(|&(v, ..)| v != advance.vertex && v != vertex);
                        self.ended(end.freed);
                    }
                    None => self.tips[k] = (advance.vertex, direction, ideal),
                }
            }
            Err(refusal) => {
                self.note(&refusal);
                self.tips.swap_remove(k);
            }
        }
    }

    fn start(&mut self) {
        let vertex = self.any_vertex();
        let direction = self.any_direction(vertex);
        let triangle = self.body.topology.incident[vertex as usize][0] / 3;
        let site = [TearSite::Vertex(vertex), TearSite::Triangle(triangle)][self.random.below(2)];
        let mode = [TearMode::Free, TearMode::Edge][self.random.below(2)];
        let before = self.body.triangles.len();
        match cutter(&mut self.body.mesh(), &mut self.scratch).nucleate(site, direction, mode) {
            Ok(slit) => {
                self.tally.starts += 1;
                assert!(mode == TearMode::Free || self.body.triangles.len() == before, "{}", self.name);
                self.tips.extend(slit.tips.iter().map(|tip| (tip.vertex, tip.direction, tip.ideal)));
                self.ended(slit.freed);
            }
            Err(refusal) => self.note(&refusal),
        }
    }

    fn cut(&mut self) {
        let count = 2 + self.random.below(4);
        let mut line = Vec::new();
        for _ in 0..count {
            let triangle = self.random.below(self.body.triangles.len());
            let [a, b, c] = self.body.triangles.corners[triangle].map(|row| self.at(row));
            let (p, q) = (self.random.unit(), self.random.unit());
            line.push(if p + q < 1.0 { a + (b - a) * p + (c - a) * q } else { a });
        }
        if self.random.below(4) == 0 {
            line.push(line[0]);
        }
        let strokes = cutter(&mut self.body.mesh(), &mut self.scratch).cut(&line);
        for cut in strokes.into_iter().flatten() {
            self.tally.cuts += 1;
            let tips = cut.tips.iter().map(|&(vertex, direction)| (vertex, direction, self.at(vertex)));
            let tips: Vec<_> = tips.collect();
            self.tips.extend(tips);
            cut.freed.iter().for_each(|&freed| self.ended(Some(freed)));
        }
    }

    /// One of everything at random, and what must hold after it.
    fn rage(&mut self, count: usize, is_flat: bool) {
        let start = self.body.clone();
        let (area, mass) = (total_area(&self.body.triangles), total_mass(&self.body.vertices));
        let momentum = linear_momentum(&self.body.vertices);
        let least = angles(&self.body).0.min(10.0);
        for event in 0..count {
            let before = self.scratch.records.len();
            match self.random.below(10) {
                0 => self.start(),
                1 => self.cut(),
                _ => self.advance(),
            }
            let name = &self.name;
            assert_eq!(self.body.mesh().validate(), Ok(()), "{name}, event {event}");
            if self.scratch.records.len() == before {
                continue;
            }
            assert_eq!(self.body.topology.components().0, self.pieces, "{name}, event {event}: every piece is told");
            let worst = rest_angles(&self.body.vertices, &self.body.triangles).fold(f64::INFINITY, f64::min);
            assert!(worst.to_degrees() >= least - 1e-9, "{name}, event {event}: {}°", worst.to_degrees());
            assert!(self.tips.iter().all(|&(vertex, ..)| self.body.topology.is_boundary_vertex(vertex)), "{name}");
        }
        self.tally.least = angles(&self.body).0;
        // Some thousand roundings of a sum of a thousand terms.
        if is_flat {
            assert!((total_area(&self.body.triangles) / area - 1.0).abs() < 1e-11, "{}", self.name);
        }
        assert!((total_mass(&self.body.vertices) / mass - 1.0).abs() < 1e-11, "{}", self.name);
        assert!((linear_momentum(&self.body.vertices) - momentum).length() < 1e-11 * mass, "{}", self.name);
        undo_all(&mut self.body, &self.scratch);
        assert_same(&self.body, &start);
    }
}

/// Storms over small meshes, down to two triangles, and over some that last longer.
fn storms(seeds: std::ops::Range<u8>, small: usize, large: usize) {
    let mut total = Tally { least: f64::INFINITY, ..Tally::default() };
    for seed in seeds {
        let sheets = [
            ("pair", meshes::grid(1, 1, 1.0, 1.0), true, small),
            ("strip", meshes::grid(5, 1, 5.0, 1.0), true, small),
            ("grid", meshes::grid(5, 4, 5.0, 4.0), true, small),
            ("jittered", meshes::jittered(12, 11, 12.0, 11.0, u64::from(seed)), true, large),
            ("unstructured", crate::unstructured(10.0, 1.0, u64::from(seed)), true, large),
            ("cap", meshes::cap(8), false, large),
            ("sphere", meshes::sphere(1 + usize::from(seed % 3)), false, large),
        ];
        for (name, sheet, is_flat, count) in sheets {
            let mut storm = Storm::new(name, &sheet, seed);
            storm.rage(count, is_flat);
            total.add(&storm.tally);
        }
    }
    println!("{total:?}");
    assert!(total.advances > 0 && total.starts > 0 && total.cuts > 0 && total.pieces > 0);
    // Tears that run into corners between lips where nothing fits must stay rare, however little is left of the tissue.
    assert!(20 * total.stuck < total.advances + total.starts, "{total:?}");
}

#[test]
fn nothing_breaks_whatever_is_torn() {
    storms(0..4, 40, 150);
}

/// A quarter of a million events.
#[test]
#[ignore = "a minute: cargo test --release --test tearing random_tears -- --ignored"]
fn nothing_breaks_in_a_long_storm() {
    storms(4..250, 40, 300);
}
