//! Refinement around tear tips and coarsening behind them, before a solve: the criterion then judges the stress of a mesh that
//! is fine around every tip.

use crate::components::{
    Contact, EnergyAudit, FibreLaws, Planar, PreStretch, Refined, Refinement, SelfContact, SolveResult, TearDecisions,
    Tearing, fibre_law,
};
use crate::math::{FibreLaw, Sym2, edge_of_equilateral};
use crate::storage::{Edit, Mesh, NONE, Tips, Topology, Triangles, VertexKey, Vertices, apply, measure::rest_corners};
use crate::systems::contact::layers::may_collapse;
use crate::systems::fracture::{
    Coarsening, Cutter, Followers, FollowersQuery, Quality, Surface, TearScratch, TipMemory, Walk,
    distance_to_triangle, plan_coarsening,
};
use crate::systems::{StepContext, work};
use glam::DVec3;

/// Triangles with an angle below this \[rad\] are flipped where that helps; 14°. A flip strains the tissue anew, a bisection
/// does not, so only thin triangles left by a tear are worth it.
const FLIP: f64 = 0.244_346_095_279_206_1;

/// Multiple of the reach of refinement beyond which vertices are collapsed, so that a wavering tip does not change the mesh.
const BEHIND: f64 = 1.5;
/// Collapses leave no large triangle nearer than this multiple of the reach of refinement.
const CLEAR_OF_TIPS: f64 = 1.25;
/// Multiple of the reach of refinement beyond which vertices that could not be collapsed leave the list.
const FORGOTTEN: f64 = 5.0;

/// Refines bodies whose tips have come, gone or moved, and coarsens behind them where a step begins.
pub fn refine(world: &mut hecs::World, step: &StepContext) -> usize {
    let mut count = 0;
    type Query<'a> = (
        (&'a mut Vertices, &'a mut Triangles, &'a mut Topology),
        (&'a Refinement, &'a mut Refined, &'a Tearing, &'a mut Tips, &'a mut TearDecisions),
        (&'a mut TearScratch, Option<&'a mut TipMemory>, Option<&'a mut EnergyAudit>, &'a mut SolveResult),
        FollowersQuery<'a>,
        (Option<&'a Planar>, Option<&'a PreStretch>, FibreLaws<'a>, Option<&'a Contact>),
    );
    for (
        (vertices, triangles, topology),
        (refinement, refined, tearing, tips, decisions),
        (scratch, memory, audit, result),
        followers,
        (planar, pre_stretch, fibres, contact),
    ) in world.query_mut::<Query>()
    {
        if step.is_resumed && !decisions.may_advance_further {
            continue;
        }
        refined.is_put_off = false;
        let has_moved = notice(refined, tips, vertices);
        // Only where a step begins: taking a vertex out restores the momentum of the velocities that it begins with.
        let is_behind = refined.is_behind && !step.is_resumed;
        if !has_moved && !is_behind {
            continue;
        }
        count += 1;
        let is_planar = planar.is_some();
        let (unstretched, fibres) = (PreStretch::unstretched(pre_stretch), fibre_law(fibres, pre_stretch));
        let followers = Followers::of(followers, None);
        let walk = memory.map(|memory| &mut memory.walk);
        let mesh = Mesh { vertices, triangles, topology };
        let mut refiner = Refiner {
            mesh,
            followers,
            refinement,
            refined,
            tearing,
            tips,
            scratch,
            walk,
            is_planar,
            unstretched,
            fibres,
            own: contact.and_then(|contact| contact.self_contact),
            longest: 0.0,
            tests: 0,
        };
        if is_behind {
            // Decisions of the last step refer to rows that others take now.
            decisions.forget();
            refiner.coarsen();
            result.work = result.work.saturating_add(work::of_layers(refiner.tests, refiner.mesh.triangles.len()));
        }
        if has_moved {
            let triangles = refiner.mesh.triangles.len();
            let halvings = refiner.refine(step.budget.map(|budget| work::halvings_within(budget / 2, triangles)));
            result.work = result.work.saturating_add(work::of_halvings(halvings, triangles));
        }
        // Loads of the last step are of another mesh.
        if let Some(audit) = audit {
            audit.forget_loads();
        }
    }
    count
}

/// Whether tips have come, gone or moved since the last time; notes where they are.
fn notice(refined: &mut Refined, tips: &Tips, vertices: &Vertices) -> bool {
    let now = || {
        let at = |&row: &u32| vertices.rest_position[row as usize];
        tips.keys().iter().copied().zip(tips.vertex.iter().map(at))
    };
    if refined.tips.iter().copied().eq(now()) {
        return false;
    }
    refined.tips.clear();
    refined.tips.extend(now());
    refined.is_behind = true;
    true
}

/// Longest edge \[mm\] of triangles, as they are.
fn longest_edge(mesh: &Mesh<'_>) -> f64 {
    let of = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|v| mesh.vertices.position[v as usize]);
        a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a))
    };
    mesh.triangles.corners.iter().map(of).fold(0.0, f64::max).sqrt()
}

/// One body while it is refined.
struct Refiner<'a> {
    mesh: Mesh<'a>,
    followers: Followers<'a>,
    refinement: &'a Refinement,
    refined: &'a mut Refined,
    tearing: &'a Tearing,
    tips: &'a mut Tips,
    scratch: &'a mut TearScratch,
    walk: Option<&'a mut Walk>,
    is_planar: bool,
    unstretched: Sym2,
    fibres: Option<FibreLaw>,
    /// Contact with itself.
    own: Option<SelfContact>,
    /// Bound on the length of edges \[mm\] where there is contact, and box tests for it.
    longest: f64,
    tests: usize,
}

impl Refiner<'_> {
    /// Bisects triangles that are too large around the tips, each at most once per pass; returns the number of bisections. After `most` of
    /// them the next step continues.
    fn refine(&mut self, most: Option<usize>) -> usize {
        let before = self.refined.split_count;
        let radius = self.tearing.radius;
        let (edge, reach) = (self.refinement.edge(radius), self.refinement.reach(radius));
        loop {
            self.find_large(edge, reach);
            let (mut has_split, mut is_spent) = (false, false);
            let halvings = |refined: &Refined| (refined.split_count - before) as usize;
            let is_enough = |refined: &Refined| most.is_some_and(|most| halvings(refined) >= most);
            for place in 0..self.refined.queue.len() {
                if is_enough(self.refined) {
                    break;
                }
                is_spent = !self.halve(self.refined.queue[place].1, edge, &mut has_split);
                if is_spent {
                    self.refined.budget_hit_count += 1;
                    break;
                }
            }
            self.follow();
            if is_enough(self.refined) {
                // As if the tips had moved: they are looked at in the next step.
                self.refined.tips.clear();
                self.refined.is_put_off = true;
            }
            if is_spent || !has_split || is_enough(self.refined) {
                return halvings(self.refined);
            }
        }
    }

    fn follow(&mut self) {
        let tables = self.mesh.tables();
        self.scratch.records.iter().for_each(|record| self.refined.follow(record, tables));
        self.followers.follow(&mut self.scratch.records, &mut self.mesh, Some(self.tips));
    }

    /// Lists the triangles within `reach` \[mm\] of a tip that are larger than `edge` \[mm\], nearest first. Walks from neighbour to
    /// neighbour, so it never looks across a crack.
    fn find_large(&mut self, edge: f64, reach: f64) {
        self.refined.queue.clear();
        let Some(walk) = &mut self.walk else { return };
        for &vertex in &self.tips.vertex {
            let tip = self.mesh.vertices.rest_position[vertex as usize];
            walk.begin(self.mesh.triangles.len());
            self.mesh.topology.incident[vertex as usize].iter().for_each(|&entry| walk.visit(entry / 3));
            let mut place = 0;
            while let Some(t) = walk.at(place) {
                place += 1;
                let x = rest_corners(self.mesh.vertices, self.mesh.triangles.corners[t as usize]);
                let distance = distance_to_triangle(x, tip);
                if distance > reach {
                    continue;
                }
                if edge_of_equilateral(self.mesh.triangles.rest[t as usize].area) > edge {
                    self.refined.queue.push((distance, t));
                }
                let neighbours = self.mesh.topology.neighbours[t as usize];
                neighbours.into_iter().filter(|&n| n != NONE).for_each(|n| walk.visit(n));
            }
        }
        self.refined.queue.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    }

    /// Bisects a triangle along its propagation path, unless an earlier bisection has; `false` where the triangle budget is used up.
    fn halve(&mut self, triangle: u32, edge: f64, has_split: &mut bool) -> bool {
        let most = self.refinement.most_added(self.refined.start_count);
        let area = |mesh: &Mesh<'_>| mesh.triangles.rest[triangle as usize].area;
        let start = area(&self.mesh);
        while area(&self.mesh) == start && edge_of_equilateral(start) > edge {
            if self.refined.added + 2 > most {
                return false;
            }
            let before = self.mesh.triangles.len();
            let mut cutter = Cutter {
                mesh: &mut self.mesh,
                is_movable: &|_| false,
                quality: Quality { flip: FLIP, ..Quality::default() },
                scratch: self.scratch,
            };
            if cutter.bisect(triangle).is_err() {
                break;
            }
            *has_split = true;
            self.refined.split_count += 1;
            self.refined.added += (self.mesh.triangles.len() - before) as i64;
        }
        true
    }

    /// Takes out the vertices that were made since the start and that no tip needs, the newest first: they go as they came.
    fn coarsen(&mut self) {
        self.refined.is_behind = false;
        let mut made = std::mem::take(&mut self.refined.made);
        if self.refinement.may_coarsen {
            self.longest = self.own.map_or(0.0, |_| longest_edge(&self.mesh));
            made.reverse();
            made.retain(|&key| self.stays_listed(key));
            made.reverse();
        } else {
            made.clear();
        }
        self.refined.made = made;
    }

    /// Collapses a vertex where that is possible; returns whether it stays listed.
    fn stays_listed(&mut self, key: VertexKey) -> bool {
        let Some(row) = self.mesh.vertices.row(key) else { return false };
        let reach = self.refinement.reach(self.tearing.radius);
        let distance = self.distance_to_tips(|tip| tip.distance(self.mesh.vertices.rest_position[row as usize]));
        if distance < BEHIND * reach || !self.followers.can_spare(row) {
            return true;
        }
        match self.plan(row, reach) {
            Some(plan) if self.keeps_layers_apart(row, plan) && self.take_out(row, plan) => false,
            _ => distance < FORGOTTEN * reach,
        }
    }

    fn plan(&self, row: u32, reach: f64) -> Option<Coarsening> {
        let edge = self.refinement.edge(self.tearing.radius);
        let is_wanted = |x: [DVec3; 3], area: f64| {
            edge_of_equilateral(area) <= edge
                || self.distance_to_tips(|tip| distance_to_triangle(x, tip)) >= CLEAR_OF_TIPS * reach
        };
        let surface = Surface {
            vertices: self.mesh.vertices,
            triangles: self.mesh.triangles,
            topology: self.mesh.topology,
            is_planar: self.is_planar,
            unstretched: self.unstretched,
            fibres: self.fibres,
            bending: None,
        };
        let least = self.tearing.strength_along_fibres.min(self.tearing.strength_across_fibres);
        let strength = least * self.mesh.triangles.least_strength();
        plan_coarsening(&surface, row, strength, &is_wanted)
    }

    fn keeps_layers_apart(&mut self, row: u32, plan: Coarsening) -> bool {
        let Some(own) = self.own else { return true };
        let (vertices, triangles, topology) = (&*self.mesh.vertices, &*self.mesh.triangles, &*self.mesh.topology);
        let are_apart =
            may_collapse((vertices, triangles, topology), &own, (row, plan.into), (self.longest, &mut self.tests));
        if are_apart {
            let around =
                topology.incident[row as usize].iter().flat_map(|entry| triangles.corners[*entry as usize / 3]);
            let to = vertices.position[plan.into as usize];
            let edges = around.map(|v| vertices.position[v as usize].distance(to));
            self.longest = edges.fold(self.longest, f64::max);
        }
        are_apart
    }

    fn take_out(&mut self, vertex: u32, plan: Coarsening) -> bool {
        let before = self.mesh.triangles.len();
        let Ok(record) = apply(&mut self.mesh, &Edit::Collapse { vertex, into: plan.into }) else { return false };
        self.scratch.records.push(record);
        self.follow();
        self.refined.removed_count += 1;
        self.refined.energy_change += plan.energy_change;
        self.refined.added -= (before - self.mesh.triangles.len()) as i64;
        true
    }

    /// The least distance \[mm\] from a tip, as `to` measures it; infinite without tips.
    fn distance_to_tips(&self, to: impl Fn(DVec3) -> f64) -> f64 {
        let at = |&row: &u32| self.mesh.vertices.rest_position[row as usize];
        self.tips.vertex.iter().map(at).map(to).fold(f64::INFINITY, f64::min)
    }
}
