//! The disc about a tip whose rest shape is shifted for the material force ([`material_force`](crate::systems::kernels::material_force)).
//!
//! It is laid out in the rest shape and stays as it is until an edit touches its triangles; only the field in them changes from
//! step to step.

use crate::components::RingFault;
use crate::math::{ElementState, FibreLaw, Orthotropic, PerRow, RestTriangle, Sym2, elementary};
use crate::storage::NONE;
use crate::systems::fracture::Surface;
use crate::systems::fracture::criterion::crack_field::{CrackField, CrackFrame, MemberState};
use crate::systems::fracture::criterion::shifted_folds::ShiftedFolds;
use crate::systems::fracture::criterion::tip_disc::{TangentPlane, Walk};
use crate::systems::kernels::failure::TipField;
use crate::systems::kernels::material_force::{Strained, pulled_back};
use crate::systems::kernels::membrane_lanes::{CornerForces, States};
use crate::systems::kernels::{membrane, simd};
use glam::{DVec2, DVec3};
use smallvec::SmallVec;
use std::sync::atomic::AtomicBool;

/// The weight is 1 up to this part of the radius and falls to 0 at the radius: the triangles at the tip, whose field elements can
/// least follow, then do not enter.
const DISC_CORE: f64 = 0.4;

/// Fewest edges to the radius: the core is then about one of them.
const LEAST_DISC_EDGES: f64 = 3.0;
/// Most edges to the radius: the field ahead is the same for all discs, the field across for small ones alone, which bent lips,
/// jaws and other tears hardly reach.
const MOST_EDGES: f64 = 6.0;

/// cos 60°: a boundary that turns from a lip's first edge by more is no lip any more.
const COS_TURNED_OFF: f64 = 0.5;

/// Triangles for which a disc has room from the start: with six edges to the radius there are some 260 in it.
const USUAL_SHIFTED_DISC: usize = 512;

/// Slant of a force from the normal, in root mean squares of the tilts of the triangles, of which half the work is counted.
const TILTS: f64 = 2.0;

/// Triangles that are strained side by side: their states and forces fill 8 kB.
const PACK: usize = 32;

/// Vertices of no weight have no row among the disc's own.
const NO_ROW: u32 = u32::MAX;

/// The disc.
#[derive(Clone, Debug, Default)]
pub struct ShiftedDisc {
    members: Vec<Member>,
    /// Triangles that border on it and have no part in it.
    rim: Vec<u32>,
    /// Vertices of some weight.
    nodes: Vec<Node>,
    /// Bending triangles of the disc.
    folds: ShiftedFolds,
    /// Edges of boundaries in it.
    lips: Vec<[u32; 2]>,
    /// The field of a crack in it.
    field: CrackField,
    /// Mean thickness at its centre \[mm\].
    thickness: f64,
    /// Buffer of triangles strained side by side.
    pack: Pack,
}

/// A triangle of the disc.
#[derive(Clone, Copy, Debug)]
struct Member {
    triangle: u32,
    /// Unit direction of its own first axis in the axes of the disc.
    fibre: DVec2,
    /// q at its corners.
    weights: [f64; 3],
    /// ∇q \[1/mm\] in the axes of the disc.
    fall: DVec2,
    /// Rows of its corners among the nodes.
    nodes: [u32; 3],
}

/// A vertex of the disc, and the sums over its triangles.
#[derive(Clone, Copy, Debug)]
struct Node {
    vertex: u32,
    weight: f64,
    area: f64,
    /// Sum of the present areas as vectors, and of their sizes \[mm²\].
    normal: DVec3,
    present_area: f64,
    gradient: [DVec3; 2],
    force: DVec3,
}

impl Node {
    fn new(vertex: u32, weight: f64) -> Self {
        Self {
            vertex,
            weight,
            area: 0.0,
            normal: DVec3::ZERO,
            present_area: 0.0,
            gradient: [DVec3::ZERO; 2],
            force: DVec3::ZERO,
        }
    }

    /// Tangential part of the force, which does work as the material slides along the surface. The normal is uncertain by the tilt of the
    /// triangles, so that a slant of that size does no work.
    fn sliding(&self) -> DVec3 {
        let Some(normal) = self.normal.try_normalize() else { return self.force };
        let across = normal.dot(self.force);
        let along = self.force - normal * across;
        let level = self.normal.length() / self.present_area;
        let slant = elementary::powi(TILTS * across, 2) * (1.0 - level * level).max(0.0);
        let size = along.length_squared();
        if size > 0.0 { along * (size / (size + slant)) } else { DVec3::ZERO }
    }
}

/// The material force at a tip, in the axes in which its disc was laid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MaterialForce {
    /// Energy released per area of tear and direction \[N/mm\]: G(d) = release·d.
    pub release: DVec2,
    /// The part of the release that is the derivative of stored energy alone; the rest is carried by other forces on the disc.
    pub stored: DVec2,
}

impl ShiftedDisc {
    /// The radius of a disc that is wanted so large \[mm\], with edges of this size \[mm\] around the tip.
    pub fn radius(wanted: f64, edge: f64) -> f64 {
        wanted.max(LEAST_DISC_EDGES * edge).min(MOST_EDGES * edge)
    }

    /// Reserves room for the usual size of a disc, so that the first one that is laid while a tear runs does not allocate.
    pub fn make_room(&mut self) {
        if self.members.capacity() == 0 {
            self.members.reserve(USUAL_SHIFTED_DISC);
            self.nodes.reserve(USUAL_SHIFTED_DISC);
            self.rim.reserve(USUAL_SHIFTED_DISC);
            self.lips.reserve(USUAL_SHIFTED_DISC);
            self.field.make_room(USUAL_SHIFTED_DISC);
            self.pack.make_room();
        }
    }

    /// Lays the disc of `radius` \[mm\] about a vertex, whose tangent plane has the orthonormal `axes`, starting from the triangles
    /// `start` around it, and the crack in this `frame`. Boundaries other than the two lips that lead to the vertex stay where they are.
    pub fn lay(
        &mut self,
        surface: &Surface,
        ((vertex, axes, radius), frame): ((u32, [DVec3; 2], f64), CrackFrame),
        start: impl IntoIterator<Item = u32>,
        walk: &mut Walk,
    ) {
        let Surface { vertices, triangles, topology, .. } = *surface;
        let centre = vertices.rest_position[vertex as usize];
        let weight = |x: DVec3| ((1.0 - x.distance(centre) / radius) / (1.0 - DISC_CORE)).clamp(0.0, 1.0);
        self.members.clear();
        self.rim.clear();
        self.nodes.clear();
        self.lips.clear();
        self.field.clear(frame);
        walk.begin(triangles.len());
        start.into_iter().for_each(|t| walk.visit(t));
        let mut next = 0;
        while let Some(triangle) = walk.at(next) {
            next += 1;
            let t = triangle as usize;
            let corners = triangles.corners[t];
            if corners.iter().all(|&v| weight(vertices.rest_position[v as usize]) == 0.0) {
                continue;
            }
            for (edge, &neighbour) in topology.neighbours[t].iter().enumerate() {
                if neighbour == NONE {
                    self.lips.push([corners[edge], corners[(edge + 1) % 3]]);
                } else {
                    walk.visit(neighbour);
                }
            }
        }
        let still = self.still(surface, vertex);
        let plane = TangentPlane::new(centre, axes);
        let (mut area, mut volume) = (0.0, 0.0);
        for triangle in (0..next).filter_map(|place| walk.at(place)) {
            let t = triangle as usize;
            let corners = triangles.corners[t];
            let x = corners.map(|v| vertices.rest_position[v as usize]);
            let weights = [0, 1, 2].map(|i| if still.contains(&corners[i]) { 0.0 } else { weight(x[i]) });
            if weights == [0.0; 3] {
                self.rim.push(triangle);
                continue;
            }
            let is_flat = plane.place(x).1;
            let fibre = plane.direction(triangles.fibre[t], x, is_flat);
            let rest = &triangles.rest[t];
            let fall: DVec2 = rest.all_gradients().into_iter().zip(weights).map(|(own, weight)| own * weight).sum();
            let weighted = rest.area * weights.iter().sum::<f64>();
            area += weighted;
            volume += weighted * triangles.thickness[t];
            let nodes = [0, 1, 2].map(|i| self.node(corners[i], weights[i]));
            let fall = fibre.rotate(fall);
            self.members.push(Member { triangle, fibre, weights, fall, nodes });
            if fall != DVec2::ZERO {
                self.field.add(x, (&plane, rest.area, fall));
            }
        }
        let law = self.members.first().and_then(|member| triangles.stiffness.get(member.triangle as usize));
        let placed = |&[a, b]: &[u32; 2]| {
            let [a, b] = [a, b].map(|v| vertices.rest_position[v as usize]);
            let [a, b, _] = plane.place([a, b, b]).0;
            [a, b]
        };
        self.field.find_crack(law, (DISC_CORE * radius, radius), self.lips.iter().map(placed));
        self.thickness = volume / area;
        self.folds.clear();
        if let Some(bending) = surface.bending {
            let plain = self.rim.iter().map(|&triangle| (triangle, DVec2::ZERO, DVec2::X));
            let listed = self.members.iter().map(|m| (m.triangle, m.fall, m.fibre)).chain(plain);
            self.folds.lay(surface, bending, listed);
        }
    }

    /// The vertices of boundaries in the disc that are no lips of the tear that leads to `vertex`: a lip goes on along the boundary
    /// until that turns off.
    fn still(&self, surface: &Surface, vertex: u32) -> SmallVec<[u32; 64]> {
        let at = |v: u32| surface.vertices.rest_position[v as usize];
        let mut lips: SmallVec<[u32; 64]> = SmallVec::new();
        lips.push(vertex);
        for side in 0..2 {
            let (mut from, mut first) = (vertex, None);
            while let Some(&edge) = self.lips.iter().find(|edge| edge[side] == from) {
                let to = edge[1 - side];
                let way = (at(to) - at(from)).normalize_or_zero();
                if way.dot(*first.get_or_insert(way)) < COS_TURNED_OFF || lips.contains(&to) {
                    break;
                }
                lips.push(to);
                from = to;
            }
        }
        self.lips.iter().flatten().copied().filter(|v| !lips.contains(v)).collect()
    }

    /// The row of a vertex among the nodes.
    fn node(&mut self, vertex: u32, weight: f64) -> u32 {
        if weight == 0.0 {
            return NO_ROW;
        }
        // The walk goes round and round: a vertex comes up again soon after it came first.
        let known = self.nodes.iter().rposition(|node| node.vertex == vertex);
        known.unwrap_or_else(|| {
            self.nodes.push(Node::new(vertex, weight));
            self.nodes.len() - 1
        }) as u32
    }

    /// The triangles on which the disc depends: with bending also those around it.
    pub fn triangles(&self) -> impl Iterator<Item = u32> {
        let bends = self.folds.triangles();
        self.members.iter().map(|member| member.triangle).chain(self.rim.iter().copied()).chain(bends)
    }

    /// Whether the disc was laid for tissue that bends as this surface does.
    pub fn bends_as(&self, surface: &Surface) -> bool {
        self.folds.bending() == surface.bending.copied()
    }

    /// Directions for which the disc was laid.
    pub fn frame(&self) -> Option<CrackFrame> {
        self.field.frame()
    }

    /// The material force at the current positions; `None` where it is not finite.
    pub fn force(&mut self, surface: &Surface) -> Option<MaterialForce> {
        self.read(surface).map(|(force, _)| force)
    }

    /// Material force and crack field at the current positions, or the fault of the field; `None` where the force is not finite.
    pub fn read(&mut self, surface: &Surface) -> Option<(MaterialForce, Result<TipField, RingFault>)> {
        let Self { members, nodes, thickness, folds, field, pack, .. } = self;
        let has_crack = field.begin() && surface.fibres.is_none();
        for node in &mut *nodes {
            *node = Node::new(node.vertex, node.weight);
        }
        let bends = surface.bending.is_some();
        let mut stored = if bends { folds.release(surface) } else { DVec2::ZERO };
        for members in members.chunks(PACK) {
            pack.fill(members, surface);
            for (place, member) in members.iter().enumerate() {
                let (strained, area) = pack.strained(place, member, surface);
                let bent = if bends { folds.forces(member.triangle) } else { [DVec3::ZERO; 3] };
                let normal = if surface.is_planar { DVec3::ZERO } else { strained.normal() * area };
                let size = normal.length();
                for (corner, &node) in member.nodes.iter().enumerate() {
                    let Some(node) = nodes.get_mut(node as usize) else { continue };
                    node.area += area;
                    node.normal += normal;
                    node.present_area += size;
                    node.force += strained.forces[corner] + bent[corner];
                    for (sum, column) in node.gradient.iter_mut().zip(strained.gradient) {
                        *sum += column * area;
                    }
                }
                stored += strained.release(member.weights, member.fall);
                if has_crack && member.fall != DVec2::ZERO {
                    field.push(pack.state(place, member, &strained, surface));
                }
            }
        }
        let carried = |node: &Node| pulled_back(node.gradient, node.sliding()) * (node.weight / node.area);
        let carried: DVec2 = nodes.iter().map(carried).sum();
        let [release, stored] = [stored + carried, stored].map(|force| force / *thickness);
        let force = MaterialForce { release, stored };
        (release.is_finite() && stored.is_finite()).then(|| (force, field.read(surface)))
    }
}

/// Some triangles of the disc side by side, as the kernels of the step take them, and the results of these.
#[derive(Clone, Debug, Default)]
struct Pack {
    corners: Vec<[u32; 3]>,
    rest: Vec<RestTriangle>,
    stiffness: Vec<Orthotropic>,
    pre_stretch: Vec<Sym2>,
    beside: Vec<f64>,
    thickness: Vec<f64>,
    state: Vec<ElementState>,
    forces: Vec<[DVec3; 3]>,
}

impl Pack {
    fn make_room(&mut self) {
        self.corners.reserve(PACK);
        self.rest.reserve(PACK);
        self.stiffness.reserve(PACK);
        self.pre_stretch.reserve(PACK);
        self.beside.reserve(PACK);
        self.thickness.reserve(PACK);
        self.state.reserve(PACK);
        self.forces.reserve(PACK);
    }

    /// Strains the triangles of some members.
    fn fill(&mut self, members: &[Member], surface: &Surface) {
        let Self { corners, rest, stiffness, pre_stretch, beside, thickness, state, forces } = self;
        corners.clear();
        rest.clear();
        stiffness.clear();
        pre_stretch.clear();
        beside.clear();
        thickness.clear();
        let triangles = surface.triangles;
        let (unstretched, held) = triangles.held(surface.unstretched);
        for member in members {
            let t = member.triangle as usize;
            corners.push(triangles.corners[t]);
            rest.push(triangles.rest[t]);
            stiffness.push(*triangles.law(t));
            pre_stretch.push(held[t]);
            beside.push(triangles.stored_beside(t));
            thickness.push(triangles.thickness[t]);
        }
        state.resize(members.len(), ElementState::REST);
        forces.resize(members.len(), [DVec3::ZERO; 3]);
        let (is_planar, has_faded) = (surface.is_planar, AtomicBool::new(false));
        let (position, law) = (&surface.vertices.position, PerRow::each(stiffness));
        let own = PerRow::each(pre_stretch);
        let states =
            States { corners, position, rest, stiffness: law, is_planar, unstretched, pre_stretch: own, has_faded };
        simd::run(&states, 0, state);
        if let Some(fibres) = &surface.fibres {
            for ((state, stiffness), own) in state.iter_mut().zip(stiffness).zip(pre_stretch) {
                let unstretched = unstretched - *own;
                let linear = (state.stress, &*stiffness);
                state.stress = FibreLaw::stress(Some(fibres), state.polar.stretch, unstretched, linear);
            }
        }
        simd::run(&CornerForces { state, rest, thickness: PerRow::each(thickness) }, 0, forces);
    }

    /// Strain state of a member's triangle, in the axes of the disc, and its area at rest \[mm²\].
    fn strained(&self, place: usize, member: &Member, surface: &Surface) -> (Strained, f64) {
        let (rest, stiffness) = (&self.rest[place], &self.stiffness[place]);
        let x = self.corners[place].map(|v| surface.vertices.position[v as usize]);
        let (f1, f2) = membrane::gradient(x, rest);
        let unstretched = surface.triangles.held(surface.unstretched).0 - self.pre_stretch[place];
        let law = (surface.is_planar, unstretched, surface.fibres.as_ref());
        let twice = membrane::twice_energy(&self.state[place], stiffness, law);
        let energy = (0.5 * twice + self.beside[place]) * rest.area * self.thickness[place];
        let DVec2 { x: c, y: s } = member.fibre;
        let gradient = [f1 * c - f2 * s, f1 * s + f2 * c];
        (Strained { gradient, energy, forces: self.forces[place] }, rest.area)
    }

    /// State of a member's triangle for the field of a crack, in the axes of the disc.
    fn state(&self, place: usize, member: &Member, strained: &Strained, surface: &Surface) -> MemberState {
        let DVec2 { x: c, y: s } = member.fibre;
        let turned = |tensor: Sym2| tensor.in_axes(DVec2::new(c, -s), DVec2::new(s, c));
        let state = &self.state[place];
        let free = surface.triangles.held(surface.unstretched).0 - self.pre_stretch[place];
        let stretch = [state.polar.stretch, free].map(turned);
        MemberState { gradient: strained.gradient, stress: turned(state.stress), stretch }
    }
}
