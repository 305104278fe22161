//! Generalised Maxwell elements: branches of a spring and a dashpot beside a spring that stays (Simo, Hughes 1998, ch. 10).

use super::{Orthotropic, Sym2, elementary};

/// A branch of a spring and a dashpot in series.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Branch {
    /// Part of the instantaneous stiffness that relaxes, > 0.
    pub part: f64,
    /// Relaxation time τ \[ms\], > 0: the stress of the branch falls to 1/e in it.
    pub time: f64,
}

/// A branch over one span of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decay {
    /// Part of the instantaneous stiffness.
    pub part: f64,
    /// e⁻ˣ with x = Δt/τ: the share of the spring's strain that is left after the span.
    pub kept: f64,
    /// (1 − e⁻ˣ)/x: the share of a strain that grows evenly over the span and is left at its end.
    pub taken: f64,
}

impl Branch {
    /// The branch over `span` \[ms\]: that of an elastic body where no time passes.
    pub(crate) fn over(self, span: f64) -> Decay {
        let x = span / self.time;
        let taken = if x > 0.0 { -elementary::exp_m1(-x) / x } else { 1.0 };
        Decay { part: self.part, kept: elementary::exp(-x), taken }
    }
}

impl Decay {
    /// Strain of the spring at the end of the span, from that at its start and the growth of the whole strain.
    #[inline]
    pub fn spring(self, before: Sym2, growth: Sym2) -> Sym2 {
        before * self.kept + growth * self.taken
    }

    /// Energy per volume \[mJ/mm³\] that the dashpot takes over the span: never negative.
    #[inline]
    pub fn dissipated(self, law: &Orthotropic, before: Sym2, growth: Sym2) -> f64 {
        let Self { part, kept, taken } = self;
        let (own, grown) = (law.stress(before), law.stress(growth));
        let fallen = (1.0 - kept * kept) * own.contract(before);
        let mixed = 2.0 * kept * (1.0 - taken) * own.contract(growth);
        0.5 * part * (fallen + mixed + taken * (1.0 - taken) * grown.contract(growth))
    }
}

/// Part of the stiffness that stays.
fn lasting(decays: &[Decay]) -> f64 {
    1.0 - decays.iter().map(|decay| decay.part).sum::<f64>()
}

/// The tangent at the end of the span over the instantaneous stiffness.
pub fn tangent(decays: &[Decay]) -> f64 {
    lasting(decays) + decays.iter().map(|decay| decay.part * decay.taken).sum::<f64>()
}

/// Weights of the stretch that is free of stress over a span, in which a triangle is elastic with the stiffness [`tangent`]·C.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FreeShape {
    /// Weight of the strain at the start of the span; zero where no time passes.
    pub start: f64,
    /// Weight of the strain at which the lasting spring is free of stress.
    pub lasting: f64,
    /// Factor on part and kept share of a branch, the weight of the strain at which its spring is.
    pub branch: f64,
}

impl FreeShape {
    /// Of branches over a span.
    pub fn of(decays: &[Decay]) -> Self {
        let (lasting, tangent) = (lasting(decays), tangent(decays));
        let grown: f64 = decays.iter().map(|decay| decay.part * (decay.taken - decay.kept)).sum();
        Self { start: grown / tangent, lasting: lasting / tangent, branch: 1.0 / tangent }
    }
}

/// Energy per volume \[mJ/mm³\] that a triangle with the instantaneous `law` stores at the start of a span, less that of the strain from the stretch
/// `free` by the stiffness [`tangent`]·C: constant over the span. `lasting_free` is the stretch at which the lasting spring is free of stress.
pub fn stored_beside(
    law: &Orthotropic,
    decays: &[Decay],
    [start, lasting_free, free]: [Sym2; 3],
    creep: impl Fn(usize) -> Sym2,
) -> f64 {
    let square = |strain: Sym2| law.stress(strain).contract(strain);
    let of_branch = |(i, decay): (usize, &Decay)| decay.part * square(start - Sym2::IDENTITY - creep(i));
    let springs = decays.iter().enumerate().map(of_branch).sum::<f64>();
    0.5 * (lasting(decays) * square(start - lasting_free) + springs - tangent(decays) * square(start - free))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_law_is_the_sum_of_the_springs() {
        let law = Orthotropic::new(10.0, 1.0, 0.3, 0.5).unwrap();
        let branches = [Branch { part: 0.4, time: 2.0 }, Branch { part: 0.3, time: 50.0 }];
        let creep = [Sym2::new(0.02, -0.01, 0.03), Sym2::new(-0.01, 0.04, 0.01)];
        let (start, end) = (Sym2::new(1.1, 0.95, 0.02), Sym2::new(1.2, 0.9, -0.05));
        let free = Sym2::new(0.98, 0.99, 0.01);
        for span in [0.0, 1e-6, 1.0, 30.0, 1e4] {
            let decays = branches.map(|branch| branch.over(span));
            let (scale, weights) = (tangent(&decays), FreeShape::of(&decays));
            let blend = (start - Sym2::IDENTITY) * weights.start + (free - Sym2::IDENTITY) * weights.lasting;
            let of_branch = |i: usize| creep[i] * (weights.branch * decays[i].part * decays[i].kept);
            let found = Sym2::IDENTITY + blend + of_branch(0) + of_branch(1);
            let beside = stored_beside(&law, &decays, [start, free, found], |i| creep[i]);
            let spring = |i: usize| start - Sym2::IDENTITY - creep[i];
            let after = |i: usize| decays[i].spring(spring(i), end - start);
            let long = 1.0 - 0.7;
            let sum = (end - free) * long + after(0) * 0.4 + after(1) * 0.3;
            let off = law.stress((end - found) * scale) - law.stress(sum);
            assert!(off.contract(off).sqrt() < 1e-13, "{off:?}");
            // Work of the law over the span is stored or dissipated.
            let square = |strain: Sym2| 0.5 * law.stress(strain).contract(strain);
            let stored = |u: Sym2, q: [Sym2; 2]| long * square(u - free) + 0.4 * square(q[0]) + 0.3 * square(q[1]);
            let energy = |u: Sym2| scale * square(u - found) + beside;
            assert!((energy(start) - stored(start, [spring(0), spring(1)])).abs() < 1e-14);
            let lost: f64 = (0..2).map(|i| decays[i].dissipated(&law, spring(i), end - start)).sum();
            let left = stored(end, [after(0), after(1)]);
            assert!(lost >= 0.0 && (energy(end) - left - lost).abs() < 1e-14, "{span} {lost}");
        }
    }
}
