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
    pub fn over(self, span: f64) -> Decay {
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

/// Elastic law of one triangle over a span: its stress is `tangent`·C:(U − free), and its energy per volume
/// ½·(U − free):`tangent`·C:(U − free) + `beside`, which at the start of the span is the stored energy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Incremental {
    /// Stretch that is free of stress.
    pub free: Sym2,
    /// Energy per volume \[mJ/mm³\] beside that of the strain.
    pub beside: f64,
}

impl Incremental {
    /// From the stretch at the start of the span, the stretch at which the lasting spring is free of stress, and those of the branches less
    /// the identity.
    #[inline]
    pub fn new(
        law: &Orthotropic,
        decays: &[Decay],
        (start, lasting_free): (Sym2, Sym2),
        creep: impl Fn(usize) -> Sym2,
    ) -> Self {
        let (lasting, tangent) = (lasting(decays), tangent(decays));
        let strain = start - Sym2::IDENTITY;
        let square = |strain: Sym2| law.stress(strain).contract(strain);
        let long = start - lasting_free;
        let (mut stress, mut twice) = (long * lasting, lasting * square(long));
        for (i, decay) in decays.iter().enumerate() {
            let spring = strain - creep(i);
            stress = stress + spring * (decay.part * decay.kept);
            twice += decay.part * square(spring);
        }
        // Strain of one spring of stiffness `tangent` that has the stress of all where nothing grows.
        let whole = stress * (1.0 / tangent);
        Self { free: start - whole, beside: 0.5 * (twice - tangent * square(whole)) }
    }
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
            let found = Incremental::new(&law, &decays, (start, free), |i| creep[i]);
            let scale = tangent(&decays);
            let spring = |i: usize| start - Sym2::IDENTITY - creep[i];
            let after = |i: usize| decays[i].spring(spring(i), end - start);
            let long = 1.0 - 0.7;
            let sum = (end - free) * long + after(0) * 0.4 + after(1) * 0.3;
            let off = law.stress((end - found.free) * scale) - law.stress(sum);
            assert!(off.contract(off).sqrt() < 1e-13, "{off:?}");
            // Work of the law over the span is stored or dissipated.
            let square = |strain: Sym2| 0.5 * law.stress(strain).contract(strain);
            let stored = |u: Sym2, q: [Sym2; 2]| long * square(u - free) + 0.4 * square(q[0]) + 0.3 * square(q[1]);
            let energy = |u: Sym2| scale * square(u - found.free) + found.beside;
            assert!((energy(start) - stored(start, [spring(0), spring(1)])).abs() < 1e-14);
            let lost: f64 = (0..2).map(|i| decays[i].dissipated(&law, spring(i), end - start)).sum();
            let left = stored(end, [after(0), after(1)]);
            assert!(lost >= 0.0 && (energy(end) - left - lost).abs() < 1e-14, "{span} {lost}");
        }
    }
}
