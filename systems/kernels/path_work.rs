//! Elastic energy of a triangle along a straight path of its corners, and the work that the path costs. That is the integral of the
//! true force, by Gauss's rule with five points (exact to the ninth degree).

use super::membrane;
use crate::math::{ElementState, FibreLaw, Orthotropic, RestTriangle, Sym2};
use glam::DVec3;

/// Points and weights of Gauss's rule on \[0, 1\] (Abramowitz and Stegun 1964, table 25.4).
const GAUSS_OF_UNIT: [(f64, f64); 5] = [
    (0.046_910_077_030_668_0, 0.118_463_442_528_094_54),
    (0.230_765_344_947_158_45, 0.239_314_335_249_683_24),
    (0.5, 0.284_444_444_444_444_44),
    (0.769_234_655_052_841_5, 0.239_314_335_249_683_24),
    (0.953_089_922_969_332, 0.118_463_442_528_094_54),
];

/// Parts of a path on each of which the rule is used, where fibres stiffen.
const PANELS: u16 = 8;

/// Parts of a path where the rule with [`PANELS`] is further off than [`ROUGH`] of the energies at the ends.
const MOST_PANELS: u16 = 256;
const ROUGH: f64 = 1e-9;

/// Constants of a triangle along a path.
#[derive(Clone, Copy, Debug)]
pub struct Element<'a> {
    /// Rest shape.
    pub rest: &'a RestTriangle,
    /// Elastic constants.
    pub stiffness: &'a Orthotropic,
    /// A·h \[mm³\].
    pub volume: f64,
    /// Whether the normal is +z.
    pub is_planar: bool,
    /// Stretch that is free of stress.
    pub unstretched: Sym2,
    /// Energy per volume \[mJ/mm³\] beside that of the strain.
    pub beside: f64,
    /// Law of the fibres, if the body has one.
    pub fibres: Option<&'a FibreLaw>,
}

impl Element<'_> {
    /// Rotation, stretch and the whole stress with corners at `x`.
    pub fn state(&self, x: [DVec3; 3]) -> ElementState {
        let state = membrane::state(x, self.rest, self.stiffness, self.is_planar, self.unstretched);
        let (fibres, stretch, linear) = (self.fibres, state.polar.stretch, (state.stress, self.stiffness));
        ElementState { stress: FibreLaw::stress(fibres, stretch, self.unstretched, linear), ..state }
    }

    /// Elastic energy with corners at `x` \[mJ\].
    pub fn energy(&self, x: [DVec3; 3]) -> f64 {
        self.volume * self.density(&self.state(x))
    }

    /// Energy per volume of the rest shape W \[mJ/mm³\] in a state of this triangle, whose stress T is ∂W/∂U.
    pub fn density(&self, state: &ElementState) -> f64 {
        let law = (self.is_planar, self.unstretched, self.fibres);
        0.5 * membrane::twice_energy(state, self.stiffness, law) + self.beside
    }

    /// −force · `u` with corners at `x` \[mJ\]: the derivative of the energy along `u`.
    pub fn slope(&self, x: [DVec3; 3], u: [DVec3; 3]) -> f64 {
        let ElementState { polar, stress } = self.state(x);
        self.volume * stress.contract(membrane::stretch_rate(&polar, self.rest, u))
    }

    /// ∫ −force · `u` ds over the path `x` + s·`u` \[mJ\].
    pub fn work(&self, x: [DVec3; 3], u: [DVec3; 3]) -> f64 {
        let at = |s: f64| std::array::from_fn(|i| x[i] + u[i] * s);
        let panel = |from: f64, length: f64| {
            GAUSS_OF_UNIT.iter().map(|&(s, weight)| weight * self.slope(at(from + s * length), u)).sum::<f64>() * length
        };
        let panels = |count: u16| {
            let length = 1.0 / f64::from(count);
            (0..count).map(|i| panel(f64::from(i) * length, length)).sum::<f64>()
        };
        // Where fibres begin to be drawn out the force has a kink, of which the rule is off by a part of the square of a panel.
        let sum = if self.fibres.is_some() { panels(PANELS) } else { panels(1) };
        // A triangle that is nearly turned over, or much stretched, in one step: its force does not run along a polynomial. Whether it does
        // the energies at the ends tell; the sum is of forces all the same.
        let [from, to] = [self.energy(x), self.energy(at(1.0))];
        let is_rough = !((sum - (to - from)).abs() <= ROUGH * (from.abs() + to.abs()));
        if is_rough { panels(MOST_PANELS) } else { sum }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::StiffeningFibres;

    #[test]
    fn work_along_a_path_is_the_change_of_energy() {
        let corners = [DVec3::ZERO, DVec3::new(1.0, 0.1, 0.0), DVec3::new(0.3, 0.9, 0.0)];
        let rest = RestTriangle::new(corners, DVec3::new(0.6, 0.8, 0.0)).unwrap();
        let stiffness = Orthotropic::new(10.0, 1.0, 0.3, 0.5).unwrap();
        let unstretched = Sym2::IDENTITY - Sym2::new(0.05, 0.02, 0.01);
        let u = [DVec3::new(0.05, -0.1, 0.2), DVec3::new(0.3, 0.1, 0.0), DVec3::new(-0.1, 0.2, 0.1)];
        let stiffening = FibreLaw::Stiffening(StiffeningFibres { k1: 5.0, k2: 8.0 });
        for fibres in [None, Some(&stiffening)] {
            let (rest, stiffness) = (&rest, &stiffness);
            let element = Element { rest, stiffness, volume: 0.1, is_planar: false, unstretched, beside: 0.0, fibres };
            let risen = element.energy(std::array::from_fn(|i| corners[i] + u[i])) - element.energy(corners);
            let work = element.work(corners, u);
            // A stretch by 30 % with a turn of 0.2 rad: Gauss's rule is off in the tenth power of a fraction of that.
            assert!((work - risen).abs() < 1e-10 * risen, "{work} {risen}");
            let step = 1e-5;
            let way = |s: f64| element.energy(std::array::from_fn(|i| corners[i] + u[i] * s));
            let slope = (way(step) - way(-step)) / (2.0 * step);
            assert!((element.slope(corners, u) - slope).abs() < 1e-9 * slope.abs());
        }
    }
}
