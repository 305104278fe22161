//! Values that a step computes and the next one overwrites. All *derived*: sized to the tables at the start of a step, never saved.

use crate::components::{PairSpring, RigidCoupling};
use crate::math::{CoupledStiffness, ElementState, FlatState, GeometricStiffness, Orthotropic, Sym2, Sym3};
use crate::storage::Triangles;
use crate::storage::room::grow;
use glam::DVec3;

/// Rotation, stretch and stress of every triangle, and its geometric stiffness. *Derived.*
#[derive(Debug, Default)]
pub struct Frames {
    /// Element states at the last evaluation; empty for planar bodies.
    pub solid: Vec<ElementState>,
    /// Element states of a planar body at the last evaluation; empty for others.
    pub flat: Vec<FlatState>,
    /// Geometric stiffness at the last evaluation; empty for planar bodies.
    pub geometric: Vec<GeometricStiffness>,
    /// Geometric stiffness of planar bodies, which have none out of the plane \[MPa\].
    pub in_plane: Vec<f64>,
    /// Tangent stiffness \[MPa\] at the last evaluation of a body with a [`FibreLaw`](crate::math::FibreLaw); empty without one.
    pub stiffened: Vec<CoupledStiffness>,
}

impl Frames {
    /// Makes the lists fit for so many triangles, of a planar body or not. Those that have to grow grow as far as there is `room` in the
    /// table of triangles.
    pub(crate) fn resize(&mut self, count: usize, room: usize, is_planar: bool) {
        let [solid, flat] = if is_planar { [0, count] } else { [count, 0] };
        size(&mut self.solid, (solid, room), ElementState::REST);
        size(&mut self.geometric, (solid, room), GeometricStiffness::default());
        size(&mut self.flat, (flat, room), ElementState::REST.into());
        size(&mut self.in_plane, (flat, room), 0.0);
    }

    /// Whether it was evaluated in a plane: no axis of a triangle has a part along z, and nothing is stiff along it.
    #[inline]
    pub fn is_planar(&self) -> bool {
        !self.flat.is_empty()
    }

    /// Number of triangles that have been evaluated.
    pub fn len(&self) -> usize {
        self.solid.len().max(self.flat.len())
    }

    /// Whether no triangle has been evaluated.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The state of a triangle.
    #[inline(always)]
    pub fn state(&self, t: usize) -> ElementState {
        match self.solid.get(t) {
            Some(state) => *state,
            None => self.flat[t].into(),
        }
    }

    /// The state of one triangle after the other.
    pub fn states(&self) -> impl ExactSizeIterator<Item = ElementState> + '_ {
        (0..self.len()).map(|t| self.state(t))
    }

    /// The geometric stiffness of a triangle.
    #[inline(always)]
    pub fn geometric_stiffness(&self, t: usize) -> GeometricStiffness {
        match self.geometric.get(t) {
            Some(geometric) => *geometric,
            None => GeometricStiffness { normal: Sym2::ZERO, in_plane: self.in_plane[t] },
        }
    }

    /// Stiffness \[MPa\] of a triangle at its state: that of the material unless it stiffens.
    #[inline(always)]
    pub fn stiffness<'a>(&'a self, triangles: &'a Triangles, t: usize) -> &'a Orthotropic {
        self.stiffened.get(t).map_or_else(|| triangles.law(t), |stiffened| &stiffened.law)
    }

    /// Shear couplings Q16 and Q26 \[MPa\] of a triangle at its state; zero without a fibre law.
    #[inline(always)]
    pub fn coupling(&self, t: usize) -> [f64; 2] {
        self.stiffened.get(t).map_or([0.0; 2], |stiffened| [stiffened.q16, stiffened.q26])
    }
}

impl Clone for Frames {
    fn clone(&self) -> Self {
        let mut frames = Self::default();
        frames.clone_from(self);
        frames
    }

    /// Copies into the lists that are there.
    fn clone_from(&mut self, source: &Self) {
        let Self { solid, flat, geometric, in_plane, stiffened } = source;
        self.solid.clone_from(solid);
        self.flat.clone_from(flat);
        self.geometric.clone_from(geometric);
        self.in_plane.clone_from(in_plane);
        self.stiffened.clone_from(stiffened);
    }
}

fn size<T: Clone>(list: &mut Vec<T>, (count, room): (usize, usize), blank: T) {
    grow(list, count, room);
    list.resize(count, blank);
}

/// Nodal forces, and the buffer of corners from which they are summed. *Derived.*
#[derive(Clone, Debug, Default)]
pub struct Forces {
    /// Force per vertex \[N\].
    pub nodal: Vec<DVec3>,
    /// Scratch: contributions of triangles to their corners.
    pub corner: Vec<[DVec3; 3]>,
    /// Whether `scale` is asked for: where Newton's method iterates.
    pub(crate) has_scale: bool,
    /// The largest force of a triangle on one of its corners \[N\], of the membrane alone; zero where it is not asked for.
    pub scale: f64,
}

/// Stiffness of springs, grips, contact and drag: a symmetric block per vertex \[N/mm\]. *Derived.* Present only with one of them.
#[derive(Clone, Debug, Default)]
pub struct ExternalStiffness {
    /// −∂f/∂x per vertex.
    pub block: Vec<Sym3>,
    // Behind a pointer, lest the world keeps room for the lists wherever it has room for bodies.
    pub(crate) coupled: Box<Coupled>,
}

/// Stiffness that couples vertices.
#[derive(Clone, Debug, Default)]
pub(crate) struct Coupled {
    /// Springs between layers of the body that touch.
    pub pairs: Vec<PairSpring>,
    /// Their blocks on the diagonal, per vertex; empty without any.
    pub pair_block: Vec<Sym3>,
    /// Rigid obstacles in touch that the body moves.
    pub rigid: Vec<RigidCoupling>,
}

impl Coupled {
    /// Whether no vertices are coupled.
    pub(crate) fn is_empty(&self) -> bool {
        self.pairs.is_empty() && self.rigid.is_empty()
    }

    /// The coupling to an obstacle, by its place among all.
    pub(crate) fn of_obstacle(&self, place: u32) -> Option<&RigidCoupling> {
        self.rigid.iter().find(|coupling| coupling.place == place)
    }

    /// Adds the forces \[N\] of springs between layers and of rigid obstacles for a displacement \[mm\].
    pub(crate) fn add(&self, u: &[DVec3], out: &mut [DVec3]) {
        for spring in &self.pairs {
            let force = spring.force(u);
            for (&row, &weight) in spring.rows.iter().zip(&spring.weights) {
                out[row as usize] += force * weight;
            }
        }
        for coupling in &self.rigid {
            let seen = coupling.seen(u);
            for (row, columns) in &coupling.rows {
                out[*row as usize] -= RigidCoupling::back(columns, &seen);
            }
        }
    }

    /// Force \[N\] of both at one vertex.
    pub(crate) fn at(&self, v: usize, u: &[DVec3]) -> DVec3 {
        let mut force = DVec3::ZERO;
        if self.pair_block.get(v).is_some_and(|block| *block != Sym3::ZERO) {
            let ends = self
                .pairs
                .iter()
                .flat_map(|spring| spring.rows.iter().zip(&spring.weights).map(move |end| (spring, end)));
            let own = ends.filter(|(_, (row, _))| **row as usize == v);
            force += own.map(|(spring, (_, weight))| spring.force(u) * *weight).sum::<DVec3>();
        }
        for coupling in &self.rigid {
            let mut own = coupling.rows.iter().filter(|(row, _)| *row as usize == v).peekable();
            if own.peek().is_some() {
                let seen = coupling.seen(u);
                force -= own.map(|(_, columns)| RigidCoupling::back(columns, &seen)).sum::<DVec3>();
            }
        }
        force
    }

    /// Work \[mJ\] of rigid obstacles along one displacement by their forces for another.
    pub(crate) fn work_of_rigid(&self, by: impl Fn(usize) -> DVec3, along: &[DVec3]) -> f64 {
        let of_vertex = |coupling: &RigidCoupling, k: usize| {
            coupling.rows.iter().map(|(row, columns)| columns[k].dot(by(*row as usize))).sum::<f64>()
        };
        let of_one = |coupling: &RigidCoupling| {
            coupling.seen(along).iter().enumerate().map(|(k, seen)| of_vertex(coupling, k) * seen).sum::<f64>()
        };
        self.rigid.iter().map(of_one).sum()
    }
}
