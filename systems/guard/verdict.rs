//! The verdict on a solve's answer: it is kept, taken in part, corrected by a further Newton solve or refused.

use super::line_search::Fraction;
use super::local_relaxation::Extent;
use super::solved::{Bounds, Solved, Strained, Sums};
use super::{HALVED, LEAST_FRACTION, RELAXING, SUM_ROUNDING, place};
use crate::components::{CompartmentState, GuardLedger, Increment, LocalRelaxation, SolverScratch};
use crate::event::{GuardCause, GuardPlace};
use crate::systems::solver::Operator;
use glam::DVec3;

/// Remedies permitted for an answer that creates too much energy, and whether it is a Newton correction's.
pub(super) struct Permitted {
    /// Largest number of triangles from which the first local relaxation may start.
    pub triangles: usize,
    /// Whether the body may take a fraction of the answer.
    pub is_shortened: bool,
    /// Whether the answer is a Newton correction's.
    pub is_corrected: bool,
    /// Whether the body may get a Newton correction.
    pub is_solved_further: bool,
    /// Whether the step of the body may be undone.
    pub is_undone: bool,
}

/// An answer with the energies by which it is judged \[mJ\].
pub(super) struct Judged<'a> {
    pub solved: &'a Solved<'a>,
    pub holders: place::Holders<'a>,
    /// Spurious energy of earlier solves.
    pub before: f64,
    /// Spurious energy of this one.
    pub more: f64,
    /// Work of its residual.
    pub work: f64,
    /// Limit of the sum.
    pub most: f64,
}

/// Verdict on an answer, with the resulting spurious energy \[mJ\] and whether the local relaxation takes the answer's place.
pub(super) enum Verdict {
    /// The body takes the whole answer, or that of a local relaxation.
    Kept(f64, bool),
    /// The body takes this fraction of a corrector's answer.
    Searched(f64, f64),
    /// The body takes this fraction of the answer.
    StepLimited(f64, f64),
    /// The body takes this fraction of the answer or of a local relaxation's way, and gets a Newton correction from there.
    SolvedFurther(f64, f64, bool),
    /// The step of the body is undone.
    Refused,
}

impl Judged<'_> {
    /// Verdict and, where the limit is exceeded, the place that creates most.
    pub(super) fn verdict(
        &self,
        may: &Permitted,
        relaxation: &mut LocalRelaxation,
        sums: &mut Sums<'_>,
    ) -> (Verdict, Option<GuardPlace>) {
        let Self { solved, before, more, work, most, .. } = *self;
        let sum = before + more + work;
        if sum <= most {
            return (Verdict::Kept(sum, false), None);
        }
        let is_known = may.is_solved_further && may.is_corrected;
        let place = (!is_known).then(|| solved.place(work, more + work, self.holders, sums));
        // A sum that is no number is too much.
        let is_solved_further = may.is_solved_further && !may.is_shortened && sum.is_finite();
        let extent = Extent { triangles: may.triangles, is_partial: is_solved_further && may.triangles == usize::MAX };
        let verdict = match self.relax(relaxation, &extent, sum, sums) {
            Some(sum) if sum <= most => Verdict::Kept(sum, true),
            _ if may.is_shortened => self.shortened(sums),
            part if is_solved_further => {
                self.solved_further(may.is_corrected, sum, part.map(|less| (&*relaxation, less)), sums)
            }
            _ if !may.is_undone => Verdict::Kept(sum, false),
            _ => Verdict::Refused,
        };
        (verdict, place)
    }

    /// The operator of the solve, with the supports of the body.
    fn full(&self) -> Operator<'_> {
        let volume = self.holders.2.map(CompartmentState::stiffness);
        Operator { external: self.holders.1, volume, ..self.solved.operator }
    }

    /// Spurious energy \[mJ\] that a local relaxation leaves, whole or partial, where the size limits allow one.
    fn relax(&self, relaxation: &mut LocalRelaxation, extent: &Extent, sum: f64, sums: &mut Sums<'_>) -> Option<f64> {
        let full = self.full();
        relaxation.find(self.solved, &full, extent, (sum, self.most), |relaxation| {
            let more = relaxation.judged(self.solved).spurious_energy(1.0, sums);
            self.before + more + relaxation.residual_work(self.solved, &full, sums)
        })
    }

    /// Verdict on a corrector's answer that would raise the incremental potential: the fraction that lowers it, where that stays below the limit.
    pub(super) fn searched(&self, whole: &Strained, sums: &mut Sums<'_>) -> Option<Verdict> {
        let full = self.full();
        let potential = self.solved.potential(&full, (whole, self.work), sums.partials);
        // One that is no number is judged by the sum.
        if !(potential > SUM_ROUNDING * self.most) {
            return None;
        }
        self.solved.find_pull(&full, sums);
        let Fraction { fraction, created, .. } = self.solved.fraction(&full, sums);
        let sum = self.before + created;
        (sum <= self.most).then_some(Verdict::Searched(sum, fraction))
    }

    fn shortened(&self, sums: &mut Sums<'_>) -> Verdict {
        let Self { solved, before, work, most, .. } = *self;
        let bounds = Bounds { before, work, unsolved: solved.unsolved(sums.partials), most };
        let (mut fraction, mut sum) = solved.shorten(&bounds, HALVED, sums);
        // A body at rest would stay at rest: smaller fractions are tried.
        if fraction == 0.0 && solved.increment.start_velocity.iter().all(|v| *v == DVec3::ZERO) {
            (fraction, sum) = solved.shorten(&bounds, LEAST_FRACTION, sums);
        }
        if sum <= most { Verdict::StepLimited(sum, fraction) } else { Verdict::Refused }
    }

    /// Newton correction of an answer that creates `sum`; `part` is a partial local relaxation with the spurious energy that it leaves.
    fn solved_further(
        &self,
        is_corrected: bool,
        sum: f64,
        part: Option<(&LocalRelaxation, f64)>,
        sums: &mut Sums<'_>,
    ) -> Verdict {
        // The first answer carries the prescribed motion, and goes all its way.
        if !is_corrected {
            return match part {
                Some((_, less)) if less < sum => Verdict::SolvedFurther(less, 1.0, true),
                _ => Verdict::SolvedFurther(sum, 1.0, false),
            };
        }
        let full = self.full();
        self.solved.find_pull(&full, sums);
        let answer = self.solved.fraction(&full, sums);
        let relaxed = part.map(|(relaxation, _)| relaxation.judged(self.solved).fraction(&full, sums));
        let (found, is_relaxed) = match relaxed {
            Some(relaxed) if relaxed.potential < answer.potential => (relaxed, true),
            _ => (answer, false),
        };
        Verdict::SolvedFurther(self.before + found.created, found.fraction, is_relaxed)
    }
}

impl Verdict {
    /// Applies the verdict to the body. `limit` is that of the spurious energy in this step \[mJ\].
    pub(super) fn apply(
        self,
        place: Option<GuardPlace>,
        limit: f64,
        (increment, scratch, ledger): (&mut Increment, &mut SolverScratch, &mut GuardLedger),
    ) {
        let somewhere = place.unwrap_or(GuardPlace::nowhere(GuardCause::Membrane));
        if let Self::SolvedFurther(_, _, true) | Self::Kept(_, true) = self {
            increment.delta.copy_from_slice(&scratch.relaxation.way);
            increment.relaxed = increment.relaxed.max(scratch.relaxation.len() as u32);
        }
        if let Self::SolvedFurther(sum, fraction, _) = self {
            if let Some(place) = place {
                increment.guard.correct(place.cause);
            }
            increment.take_fraction(fraction);
            (ledger.spurious_energy, scratch.is_counted, scratch.to_correct) = (sum, true, Some(limit));
            return;
        }
        ledger.creates_energy = matches!(self, Self::Refused);
        *increment.creates_at = place;
        if let Self::Kept(sum, _) | Self::Searched(sum, _) | Self::StepLimited(sum, _) = self {
            (ledger.spurious_energy, scratch.is_counted) = (sum.max(0.0), true);
        }
        match self {
            Self::Kept(_, true) => {
                increment.is_fraction = true;
                ledger.relaxing = RELAXING;
                increment.guard.relax(somewhere);
            }
            Self::Searched(_, fraction) => {
                increment.is_fraction = true;
                increment.take_fraction(fraction);
            }
            Self::StepLimited(_, fraction) => {
                ledger.is_step_limited = true;
                let way = increment.prescribed_way(&scratch.free);
                if way > 0.0 {
                    // Zero would be no limit.
                    ledger.hold_pace = (fraction * way).max(f64::MIN_POSITIVE);
                }
                increment.is_fraction = true;
                increment.any_substep_limited = true;
                increment.guard.limit(somewhere, increment.delta.len());
                increment.take_fraction(fraction);
            }
            _ => {}
        }
    }
}
