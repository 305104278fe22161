//! Correction of the pairs without a [proof](super::proof) that they have not met in a step.
//!
//! Where no direction tells them apart the nearest one holds both back, with equal impulses, until a gap is left. In the end the parts of a pair move
//! alike, and at last not at all, which is no motion through anything: so it ends.

use super::proof::Proof;
use super::search::{Owners, Sweep};
use super::{HeldTogether, Mesh, TESTS_PER_PROOF};
use crate::components::{
    Contact, FreeAxes, Grips, Increment, Layers, Pair, PairStart, Planar, SelfContact, SolveResult, SolverScratch,
};
use crate::storage::{Topology, Triangles, Vertices};
use crate::systems::{StepContext, work};
use glam::DVec3;

/// Rounds with planes, the last round with common motions, and the maximum; later rounds put vertices back to their start.
const PLANE_ROUNDS: u32 = 60;
const COMMON_ROUNDS: u32 = 120;
const MOST_ROUNDS: u32 = 200;

/// A correction over the radius from which on pairs are looked for again: it may have led to others.
const FAR: f64 = 0.25;

/// Searches with planes first, then with common motions first, and the maximum number; later ones put vertices back at once.
const PLANE_SEARCHES: u32 = 4;
const COMMON_SEARCHES: u32 = 7;
const MOST_SEARCHES: u32 = 10;

/// Parts of the answer's way that are tried where the search or the proofs of all of it end at their limit.
const PARTS: [f64; 3] = [0.25, 0.0625, 0.015625];

/// Bisections for the plane with equal impulses: to rounding.
const BISECTIONS: u32 = 60;

/// Pairs through each other in a solve's answer up to which no further solve is asked for.
const FEW: usize = 4;

/// How far a pair may be through each other, over the radius, without a further solve.
const SHALLOW: f64 = 0.5;

impl Layers {
    /// Box tests in the time of one proof for every pair; none where nothing has moved, since the list may then be longer than asked for.
    fn tests_of_proofs(&self, is_at_rest: bool) -> usize {
        if is_at_rest { 0 } else { TESTS_PER_PROOF * self.pairs.len() }
    }
}

/// A surface that moves in a step: one body, or several one after the other.
pub(super) struct Motion<'a> {
    /// Positions at the start of the step, and at rest \[mm\].
    pub start: &'a [DVec3],
    pub rest: &'a [DVec3],
    pub corners: &'a [[u32; 3]],
    pub owners: Owners<'a>,
    pub radii: Radii<'a>,
    /// Rest distance \[mm\] within which parts are not paired.
    pub band: f64,
    pub held: &'a HeldTogether,
}

/// Distances below which pairs repel each other.
#[derive(Clone, Copy)]
pub(super) enum Radii<'a> {
    /// The distance of one body \[mm\].
    Of(f64),
    /// Distances of several bodies \[mm\], and the body of every vertex.
    OfBodies(&'a [f64], &'a [u32]),
}

impl Radii<'_> {
    /// The distance of a pair \[mm\].
    pub(super) fn of(self, pair: &Pair) -> f64 {
        match self {
            Self::Of(radius) => radius,
            Self::OfBodies(radii, bodies) => {
                let [first, .., last] = pair.rows.map(|row| radii[bodies[row as usize] as usize]);
                0.5 * (first + last)
            }
        }
    }

    /// The largest of all \[mm\].
    pub(super) fn largest(self) -> f64 {
        match self {
            Self::Of(radius) => radius,
            Self::OfBodies(radii, _) => radii.iter().copied().fold(0.0, f64::max),
        }
    }
}

impl<'a> Motion<'a> {
    /// The motion of a body from the start of the step.
    pub(super) fn of_body(
        (vertices, triangles, topology): Mesh<'a>,
        start: &'a [DVec3],
        own: &SelfContact,
        held: &'a HeldTogether,
    ) -> Self {
        Self {
            start,
            rest: &vertices.rest_position,
            corners: &triangles.corners,
            owners: Owners::Of(topology),
            radii: Radii::Of(own.radius),
            band: own.band.unwrap_or(0.0),
            held,
        }
    }

    /// The sweep to these positions, of parts of different bodies alone if asked for.
    pub(super) fn sweep<'b>(&'b self, x: &'b [DVec3], is_between: bool) -> Sweep<'b> {
        let between = match self.radii {
            Radii::OfBodies(_, bodies) if is_between => Some(bodies),
            _ => None,
        };
        let Self { start, rest, corners, owners, radii, band, .. } = *self;
        Sweep { x, start, rest, corners, owners, between, reach: radii.largest(), band }
    }

    /// Lists the pairs that the way to `x` has carried through each other. Returns true where another solve is to see them.
    pub(super) fn asks(&self, x: &[DVec3], is_between: bool, layers: &mut Layers) -> bool {
        self.sweep(x, is_between).find(layers);
        let Layers { pairs, starts, through, .. } = layers;
        let (mut count, mut deepest) = (0, 0.0_f64);
        for (pair, start) in pairs.iter().zip(starts.iter()).filter(|(pair, _)| !self.held.all(pair)) {
            let radius = self.radii.of(pair);
            if let Proof::Through { missing, .. } = Proof::new((pair, start), self.start, x, radius) {
                (count, deepest) = (count + 1, deepest.max(missing / radius));
                through.push(*pair);
            }
        }
        through.sort_unstable();
        through.dedup();
        layers.tests += layers.tests_of_proofs(self.start == x);
        count > FEW || deepest > SHALLOW
    }

    /// Holds the vertices back whose layers have passed through each other on the way to `x`, with `most` box tests as the limit, counted in `layers`.
    pub(super) fn hold_back(
        &self,
        (x, mass, free): (&mut [DVec3], &[f64], &FreeAxes),
        layers: &mut Layers,
        most: usize,
    ) {
        let before = x.to_vec();
        let mut mover = Mover { motion: self, mass, free, stamps: Vec::new(), motions: 0, tests: 0, most };
        let mut is_apart = mover.keep_apart(x, layers);
        let mut tests = mover.tests;
        for part in PARTS {
            if is_apart {
                break;
            }
            // A shorter way has fewer pairs, and the tissue comes nearer to its equilibrium by it.
            for (v, before) in before.iter().enumerate() {
                x[v] = *before + (self.start[v] - *before) * (1.0 - part) * free[v];
            }
            (mover.tests, mover.most) = (0, most / PARTS.len());
            is_apart = mover.keep_apart(x, layers);
            tests += mover.tests;
        }
        if !is_apart {
            layers.moved_as_one = true;
            mover.all_in_common(x);
        }
        layers.tests = tests;
    }
}

/// Whether the last solve has carried layers of a body through each other, so far or so often that another solve is to see it.
pub(in crate::systems::contact) fn asks(
    mesh: Mesh<'_>,
    start: &[DVec3],
    own: &SelfContact,
    (result, scratch, grips): (&mut SolveResult, &mut SolverScratch, Option<&Grips>),
) -> bool {
    let SolverScratch { free, contact: memory, .. } = scratch;
    let held = HeldTogether::new(mesh.0.len(), free, grips);
    let layers = &mut **memory.layers.get_or_insert_default();
    let asks = Motion::of_body(mesh, start, own, &held).asks(&mesh.0.position, false, layers);
    layers.count_work(result, mesh.1.len());
    asks
}

/// Holds layers back that have passed through each other in the step; those of bodies near each other in common with them.
pub fn keep_apart(world: &mut hecs::World, step: &StepContext) -> usize {
    type Query<'a> = (
        (&'a mut Vertices, &'a Triangles, &'a Topology, &'a mut Increment),
        (&'a mut SolveResult, &'a mut SolverScratch, Option<&'a Grips>, &'a Contact),
    );
    let mut count = 0;
    for ((vertices, triangles, topology, increment), (result, scratch, grips, contact)) in
        world.query_mut::<hecs::Without<Query, &Planar>>()
    {
        let is_alone = result.is_in_step && !scratch.contact.has_neighbours;
        let Some(own) = contact.self_contact.filter(|_| is_alone) else { continue };
        count += 1;
        let SolverScratch { free, contact: memory, .. } = scratch;
        let layers = &mut **memory.layers.get_or_insert_default();
        let held = HeldTogether::new(vertices.len(), free, grips);
        let mut x = vertices.position.clone();
        let most = work::tests_within(step.left(result), triangles.len());
        let mesh = (&*vertices, triangles, topology);
        let motion = Motion::of_body(mesh, &increment.start, &own, &held);
        motion.hold_back((&mut x, &vertices.mass, free), layers, most);
        layers.count_work(result, triangles.len());
        let held_back = adopt(&x, (vertices, increment), step);
        layers.held_back = layers.held_back.max(held_back);
    }
    count
}

/// Moves the vertices that were held back, with their displacements and velocities; returns their number.
pub(super) fn adopt(x: &[DVec3], (vertices, increment): (&mut Vertices, &mut Increment), step: &StepContext) -> u32 {
    let mut held_back = 0;
    for (v, x) in x.iter().enumerate() {
        let moved = *x - vertices.position[v];
        if moved != DVec3::ZERO {
            held_back += 1;
            vertices.position[v] = *x;
            increment.displacement[v] += moved;
            increment.has_projected_vertices = true;
            vertices.velocity[v] = step.velocity_displacement(increment, v) * step.inv_effective_dt();
        }
    }
    held_back
}

/// Moves the vertices of pairs that are through each other.
struct Mover<'a> {
    motion: &'a Motion<'a>,
    mass: &'a [f64],
    free: &'a FreeAxes,
    /// Motions before the last of each vertex, counted from one.
    stamps: Vec<u32>,
    motions: u32,
    /// Box tests made, and the number after which the body moves as one.
    tests: usize,
    most: usize,
}

impl Mover<'_> {
    /// Holds back the parts of pairs that are through each other, wherever corrections lead. Whether that was done within the limits.
    fn keep_apart(&mut self, x: &mut [DVec3], layers: &mut Layers) -> bool {
        let motion = self.motion;
        let far = FAR * motion.radii.largest();
        for search in 0..MOST_SEARCHES {
            motion.sweep(x, false).find(layers);
            self.tests += std::mem::take(&mut layers.tests) + layers.tests_of_proofs(motion.start == x);
            if layers.are_too_many {
                return false;
            }
            let pairs = layers.pairs.iter().zip(&layers.starts).filter(|(pair, _)| !motion.held.all(pair));
            let pairs: Vec<(Pair, PairStart)> = pairs.map(|(pair, start)| (*pair, *start)).collect();
            let from = x.to_vec();
            let first_round = match search {
                0..PLANE_SEARCHES => 0,
                PLANE_SEARCHES..COMMON_SEARCHES => PLANE_ROUNDS,
                _ => COMMON_ROUNDS,
            };
            let were_apart = self.separate(x, &pairs, first_round);
            layers.are_apart = were_apart && pairs.len() == layers.pairs.len();
            if were_apart {
                break;
            }
            if self.tests > self.most {
                return false;
            }
            let ways = from.iter().zip(&*x).map(|(a, b)| a.distance_squared(*b));
            if !(ways.fold(0.0, f64::max) > far * far) {
                break;
            }
        }
        true
    }

    /// Separates pairs one after the other, until all are apart or the rounds are used up. Whether all were apart. From half of the tests on
    /// pairs move in common, from three quarters on not at all.
    fn separate(&mut self, x: &mut [DVec3], pairs: &[(Pair, PairStart)], first_round: u32) -> bool {
        let mut looked_at = vec![0_u32; pairs.len()];
        self.stamps.clear();
        self.stamps.resize(x.len(), 1);
        self.motions = 1;
        let mut were_apart = true;
        for round in first_round..MOST_ROUNDS {
            let before = self.motions;
            for ((pair, start), looked_at) in pairs.iter().zip(&mut looked_at) {
                if pair.rows.iter().all(|&row| self.stamps[row as usize] <= *looked_at) {
                    continue;
                }
                if self.tests > self.most {
                    return false;
                }
                self.tests += if *looked_at > 0 { TESTS_PER_PROOF } else { 0 };
                *looked_at = self.motions;
                let Motion { start: from, radii, .. } = self.motion;
                let proof = Proof::new((pair, start), from, x, radii.of(pair));
                were_apart &= proof == Proof::Apart;
                let Proof::Through { normal, target, .. } = proof else { continue };
                let least_round = match self.tests / (self.most / 4 + 1) {
                    0 | 1 => 0,
                    2 => PLANE_ROUNDS,
                    _ => COMMON_ROUNDS,
                };
                match round.max(least_round) {
                    0..PLANE_ROUNDS => self.by_plane(x, pair, (normal, target)),
                    PLANE_ROUNDS..COMMON_ROUNDS => self.in_common(x, pair),
                    _ => self.put_back(x, pair),
                }
            }
            if self.motions == before {
                break;
            }
        }
        were_apart
    }

    fn shift(&mut self, x: &mut [DVec3], v: usize, way: DVec3) {
        let way = way * self.free[v];
        if way != DVec3::ZERO {
            self.motions += 1;
            self.stamps[v] = self.motions;
            x[v] += way;
        }
    }

    /// Moves the vertices beyond a plane back to it, those of each part to its side of a gap; the plane is where both get equal impulses.
    fn by_plane(&mut self, x: &mut [DVec3], pair: &Pair, (normal, target): (DVec3, f64)) {
        let rows = pair.rows.map(|row| row as usize);
        let height = rows.map(|v| normal.dot(x[v]));
        let is_held = rows.map(|v| self.free[v] != DVec3::ONE);
        let half = 0.5 * target;
        // Way of a vertex along the normal for a plane at this height.
        let way = |i: usize, plane: f64| match i < pair.first() {
            true => (plane + half - height[i]).max(0.0),
            false => (plane - half - height[i]).min(0.0),
        };
        let impulse =
            |plane: f64| (0..4).map(|i| if is_held[i] { 0.0 } else { self.mass[rows[i]] * way(i, plane) }).sum::<f64>();
        let mut low = height.iter().copied().fold(f64::INFINITY, f64::min) - target;
        let mut high = height.iter().copied().fold(f64::NEG_INFINITY, f64::max) + target;
        // Vertices that are held bound the plane; between two parts that are held nothing can be done.
        for i in (0..4).filter(|&i| is_held[i]) {
            match i < pair.first() {
                true => high = high.min(height[i] - half),
                false => low = low.max(height[i] + half),
            }
        }
        if low > high {
            return;
        }
        // The impulse grows with the height of the plane.
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            if impulse(middle) > 0.0 { high = middle } else { low = middle }
        }
        let plane = 0.5 * (low + high);
        for (i, v) in rows.into_iter().enumerate() {
            self.shift(x, v, normal * way(i, plane));
        }
    }

    /// Gives the vertices of a pair one motion, that of their mass centre.
    fn in_common(&mut self, x: &mut [DVec3], pair: &Pair) {
        let rows = pair.rows.map(|row| row as usize);
        let mass: f64 = rows.iter().map(|&v| self.mass[v]).sum();
        let motion = rows.iter().map(|&v| (x[v] - self.motion.start[v]) * self.mass[v]).sum::<DVec3>() / mass;
        for v in rows {
            self.shift(x, v, self.motion.start[v] + motion - x[v]);
        }
    }

    /// Gives all vertices one motion, that of the mass centre.
    fn all_in_common(&mut self, x: &mut [DVec3]) {
        let mass: f64 = self.mass.iter().sum();
        let ways = x.iter().zip(self.motion.start).zip(self.mass).map(|((x, start), m)| (*x - *start) * *m);
        let motion = ways.sum::<DVec3>() / mass;
        self.stamps.resize(x.len(), 0);
        for v in 0..x.len() {
            self.shift(x, v, self.motion.start[v] + motion - x[v]);
        }
    }

    /// Puts the vertices of a pair back to where they started.
    fn put_back(&mut self, x: &mut [DVec3], pair: &Pair) {
        for v in pair.rows.map(|row| row as usize) {
            self.shift(x, v, self.motion.start[v] - x[v]);
        }
    }
}
