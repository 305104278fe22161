//! The energy of bending, and its share in a balance of energy.

use super::{BendingPasses, Body, DihedralAngles};
use crate::components::Bending;
use crate::storage::Topology;
use crate::systems::kernels::bending;
use glam::DVec3;

fn dot(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum()
}

impl DihedralAngles {
    /// The energy \[mJ\] of the angles last evaluated.
    pub fn energy(&self) -> f64 {
        let moment = |t: usize| bending::product(&self.rest[t].law, self.half(t));
        let turned = |t: usize| {
            let phi = self.half(t) + self.turned(t, moment);
            0.5 * phi.dot(bending::product(&self.rest[t].law, phi))
        };
        (0..self.rest.len()).map(turned).sum()
    }

    /// The energy \[mJ\] with the vertices at positions `x`, from rest data made anew, or brought up from those `before`.
    pub fn energy_at(body: Body<'_>, bending: &Bending, before: Option<&Self>, x: &[DVec3]) -> f64 {
        let (mut folds, mut passes) = (Self::default(), BendingPasses::default());
        if let Some(before) = before {
            (folds.rest, folds.made_of) = (before.rest.clone(), before.made_of.clone());
            (folds.edges, folds.groups) = (before.edges.clone(), before.groups.clone());
        }
        folds.refresh(body, bending, &mut passes);
        folds.evaluate(&body.1.corners, x, 1.0, &mut passes);
        folds.energy()
    }

    /// −f(x)·u \[mJ\] with the vertices at positions `x`.
    fn slope_at(
        &mut self,
        corners: &[[u32; 3]],
        topology: &Topology,
        (x, u): (&[DVec3], &[DVec3]),
        passes: &mut BendingPasses,
    ) -> f64 {
        self.evaluate(corners, x, 1.0, passes);
        let mut forces = vec![DVec3::ZERO; u.len()];
        self.add_forces(corners, topology, |_| DVec3::ZERO, &mut forces, passes);
        -dot(&forces, u)
    }

    /// Terms of the energy balance over a step from `start` by `u` that has been solved statically. In order: true work, work of
    /// the mean of the forces at both ends, dissipation, energy at the start and at the end.
    pub fn works_between_ends(body: Body<'_>, bending: &Bending, start: &[DVec3], u: &[DVec3]) -> [f64; 5] {
        let (vertices, triangles, topology) = body;
        let (mut folds, mut passes) = (Self::default(), BendingPasses::default());
        folds.refresh(body, bending, &mut passes);
        let corners = &triangles.corners;
        let ends = [start, &vertices.position];
        let mean = ends.map(|x| 0.5 * folds.slope_at(corners, topology, (x, u), &mut passes));
        let ends = [start, &vertices.position].map(|x| Self::energy_at(body, bending, None, x));
        [ends[1] - ends[0], mean[0] + mean[1], 0.0, ends[0], ends[1]]
    }

    /// Terms of the energy balance over a dynamic step whose last solve was at the displacement `at`, where the angles were
    /// last evaluated.
    pub fn works_of_step(
        &self,
        body: Body<'_>,
        bending: &Bending,
        start: &[DVec3],
        (at, u): (&[DVec3], &[DVec3]),
        is_exact: bool,
    ) -> [f64; 5] {
        let (vertices, triangles, topology) = body;
        let corners = &triangles.corners;
        let mut passes = BendingPasses::default();
        let mut product = |u: &[DVec3], is_exact: bool| {
            let mut product = vec![DVec3::ZERO; u.len()];
            self.add_product(corners, topology, u, is_exact, &mut product, &mut passes);
            product
        };
        let change: Vec<DVec3> = u.iter().zip(at).map(|(u, at)| *u - *at).collect();
        let (before, after) = (dot(&product(at, true), u), dot(&product(&change, is_exact), u));
        let mut forces = vec![DVec3::ZERO; u.len()];
        self.spread((1.0, 0.0), |_| DVec3::ZERO, (true, -1.0), (corners, topology), (&mut forces, &mut passes));
        let viscous = (self.factor - 1.0) / self.factor;
        let ends = [start, &vertices.position].map(|x| Self::energy_at(body, bending, None, x));
        let scheme = after * (1.0 - viscous) - dot(&forces, u);
        [ends[1] - ends[0], scheme, viscous * (before + after), ends[0], ends[1]]
    }
}
