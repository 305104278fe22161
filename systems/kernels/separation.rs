//! Separation of tissue from its bed: traction against opening, bilinear (Camanho, Davila 2002).
//!
//! With the stiffness K, the strength σ and the energy G per area the traction grows as K·δ up to δ₀ = σ/K, and falls to zero at δ₁ = 2G/σ. Between them it
//! is (1 − d)·K·δ with a damage d that never falls. A front of bonds is about l = √(2·N·G)/σ long under the tension N (`docs/theory/bed.md`); with edges above l/3
//! the force of peeling would be a property of the mesh. A coarser mesh therefore has less strength and the same energy (Turon et al. 2007).

use crate::math::edge_of_equilateral;

/// Edges to a front at the least, at the tension N = G/2 of tissue that is folded back, the shortest front there is.
const EDGES_PER_FRONT: f64 = 3.0;

/// Law of a bond at a vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Separation {
    stiffness: f64,
    /// Largest traction \[MPa\].
    strength: f64,
    /// Openings at which it begins to come off, and is off \[mm\].
    first: f64,
    last: f64,
}

impl Separation {
    /// The law of a stiffness \[N/mm³\], a strength \[MPa\] and an energy \[N/mm\] at a vertex between triangles of this mean rest area \[mm²\].
    pub fn new(stiffness: f64, strength: f64, energy: f64, triangle: f64) -> Self {
        let strength = strength.min(energy / (EDGES_PER_FRONT * edge_of_equilateral(triangle)));
        let (first, last) = (strength / stiffness, 2.0 * energy / strength);
        Self { stiffness, strength, first, last }
    }

    /// Damage of a bond that is opened for the first time by so much \[mm\].
    pub fn damage(&self, opening: f64) -> f64 {
        let Self { stiffness, strength, first, last } = *self;
        if opening >= last {
            1.0
        } else if opening > first {
            (1.0 - strength * (last - opening) / ((last - first) * stiffness * opening)).clamp(0.0, 1.0)
        } else {
            0.0
        }
    }

    /// Part of the energy that a bond of this damage has taken.
    pub fn taken(&self, damage: f64) -> f64 {
        if damage == 0.0 {
            return 0.0;
        }
        let Self { stiffness, strength, first, last } = *self;
        let opening = strength * last / ((last - first) * stiffness * (1.0 - damage) + strength);
        ((opening - first) / (last - first)).clamp(0.0, 1.0)
    }

    /// Largest traction \[MPa\]: the strength, or less where the mesh is coarse.
    pub fn strength(&self) -> f64 {
        self.strength
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn law() -> Separation {
        Separation::new(1.25, 0.05, 0.01, 1e-4)
    }

    #[test]
    fn a_bond_takes_its_energy_and_no_more() {
        let law = law();
        let traction = |opening: f64| (1.0 - law.damage(opening)) * law.stiffness * opening;
        let steps = 100_000;
        let width = law.last / f64::from(steps);
        let work: f64 = (0..steps).map(|i| traction((f64::from(i) + 0.5) * width) * width).sum();
        // The midpoint rule is exact but for the two cells with a kink.
        assert!((work / 0.01 - 1.0).abs() < 1e-8, "{work}");
        let most = (0..steps).map(|i| traction(f64::from(i) * width)).fold(0.0, f64::max);
        assert!((most / 0.05 - 1.0).abs() < 1e-4 && traction(law.last) == 0.0, "{most}");
    }

    #[test]
    fn the_energy_taken_follows_the_work_less_what_is_stored() {
        let law = law();
        for opening in [0.1, 0.3, 0.7, 0.95].map(|part| part * law.last) {
            let damage = law.damage(opening);
            let traction = (1.0 - damage) * law.stiffness * opening;
            let work = 0.5 * law.strength * law.first + 0.5 * (law.strength + traction) * (opening - law.first);
            let taken = work - 0.5 * traction * opening;
            // Rounding of a few terms.
            assert!((law.taken(damage) * 0.01 - taken).abs() < 1e-15, "{opening}");
        }
        assert_eq!((law.taken(0.0), law.taken(1.0)), (0.0, 1.0));
    }

    #[test]
    fn a_coarse_mesh_has_less_strength_and_the_same_range_of_energy() {
        // An edge of 1 mm allows 0.01/3 MPa.
        let law = Separation::new(1.25, 0.05, 0.01, 0.25 * 3.0_f64.sqrt());
        assert!((law.strength() - 0.01 / 3.0).abs() < 1e-15 && (law.strength * law.last - 0.02).abs() < 1e-15);
    }
}
