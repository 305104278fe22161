//! The history of triangles that relax, and the elastic law that follows from it for a span of time.

use super::{EditRecord, Uniform, order};
use crate::math::{Decay, Orthotropic, PerRow, Sym2, stored_beside};
use glam::DVec3;
use smallvec::SmallVec;

/// Most branches that a body may have.
pub(crate) const MOST_BRANCHES: usize = 4;

/// History of a body that relaxes, beside its triangles: lists in the order of their rows.
#[derive(Clone, Debug, Default)]
pub struct Relaxing {
    /// Per branch and triangle the strain at which its spring is free of stress. State.
    pub creep: Vec<Vec<Sym2>>,
    /// Stretch at the start of the step.
    pub start: Vec<Sym2>,
    /// Stretch at the end of the step.
    pub end: Vec<Sym2>,
    /// Positions \[mm\] to which that belongs: a body that nobody has moved since starts from there. Empty after an edit.
    pub ended: Vec<DVec3>,
    /// Identity less the stretch that is free of stress in the present span.
    pub held: Vec<Sym2>,
    /// Stretch of the body at which the lasting springs are free of stress, but for the pre-stretch of each triangle.
    pub unstretched: Sym2,
    /// Elastic constants \[MPa\] within a step; those of the material between steps.
    pub law: Option<Uniform<Orthotropic>>,
    /// Branches over the present span.
    pub decays: SmallVec<[Decay; MOST_BRANCHES]>,
    /// Present span \[ms\]; none after an edit.
    pub span: Option<f64>,
    /// Rows that edits have removed, the last one last: kept for the undo.
    buried: Vec<Row>,
}

/// One row of all lists.
#[derive(Clone, Debug)]
struct Row {
    creep: SmallVec<[Sym2; MOST_BRANCHES]>,
    start: Sym2,
    held: Sym2,
    law: Option<Orthotropic>,
}

impl Relaxing {
    /// Sizes the lists to the numbers of triangles and branches: a new branch is free of stress in the rest shape.
    pub fn fit(&mut self, triangles: usize, branches: usize) {
        self.creep.resize(branches, Vec::new());
        self.creep.iter_mut().for_each(|list| list.resize(triangles, Sym2::ZERO));
        self.start.resize(triangles, Sym2::IDENTITY);
        self.end.resize(triangles, Sym2::IDENTITY);
        self.held.resize(triangles, Sym2::ZERO);
    }

    /// Largest strain of a spring at the start of the step.
    pub fn largest_spring(&self) -> f64 {
        let size = |(start, creep): (&Sym2, &Sym2)| {
            let spring = *start - Sym2::IDENTITY - *creep;
            spring.contract(spring).sqrt()
        };
        self.creep.iter().flat_map(|list| self.start.iter().zip(list)).map(size).fold(0.0, f64::max)
    }

    /// Follows an edit: a triangle that is cut off another has the history of that one.
    pub(super) fn apply(&mut self, record: &EditRecord) {
        self.forget();
        for new in &record.new_triangles {
            let row = self.row(new.parent as usize);
            self.push(row);
        }
        for removed in record.removed.iter().flat_map(|removed| &removed.triangles) {
            let row = self.row(removed.row as usize);
            self.swap_remove(removed.row as usize);
            self.buried.push(row);
        }
    }

    /// Takes the last edit back.
    pub(super) fn undo(&mut self, record: &EditRecord) {
        self.forget();
        for _ in &record.new_triangles {
            self.swap_remove(self.held.len() - 1);
        }
        for removed in record.removed.iter().flat_map(|removed| removed.triangles.iter().rev()) {
            let Some(row) = self.buried.pop() else { continue };
            self.push(row);
            self.swap(removed.row as usize);
        }
    }

    /// Drops the rows kept for the undo.
    pub(super) fn release(&mut self) {
        self.buried.clear();
    }

    /// Brings the rows into another order, which has the old row of every new one.
    pub(super) fn sort(&mut self, rows: &[u32]) {
        self.forget();
        let Self { creep, start, end, held, .. } = self;
        creep.iter_mut().chain([start, end, held]).for_each(|list| order::sort(rows, list));
        self.law = None;
    }

    fn forget(&mut self) {
        self.span = None;
        self.ended.clear();
    }

    fn row(&self, t: usize) -> Row {
        Row {
            creep: self.creep.iter().map(|list| list[t]).collect(),
            start: self.start[t],
            held: self.held[t],
            law: self.law.as_ref().map(|law| law[t]),
        }
    }

    fn push(&mut self, Row { creep, start, held, law }: Row) {
        self.creep.iter_mut().zip(creep).for_each(|(list, own)| list.push(own));
        self.start.push(start);
        self.end.push(start);
        self.held.push(held);
        if let Some((list, own)) = self.law.as_mut().zip(law) {
            list.push(own);
        }
    }

    fn swap_remove(&mut self, t: usize) {
        let Self { creep, start, end, held, .. } = self;
        creep.iter_mut().chain([start, end, held]).for_each(|list| _ = list.swap_remove(t));
        if let Some(law) = &mut self.law {
            law.swap_remove(t);
        }
    }

    /// Swaps a row with the last one.
    fn swap(&mut self, t: usize) {
        let last = self.held.len() - 1;
        let Self { creep, start, end, held, .. } = self;
        creep.iter_mut().chain([start, end, held]).for_each(|list| list.swap(t, last));
        if let Some(law) = &mut self.law {
            law.swap(t, last);
        }
    }
}

impl super::Triangles {
    /// The stretch of a triangle that is free of stress, in a body whose own is `unstretched`.
    #[inline]
    pub fn unstretched(&self, triangle: usize, unstretched: Sym2) -> Sym2 {
        match &self.relaxing {
            None => unstretched - self.pre_stretch[triangle],
            Some(relaxing) => Sym2::IDENTITY - relaxing.held[triangle],
        }
    }

    /// The stretch that is free of stress as a part of the body and one of each triangle, for a kernel: the second is to be taken from the first.
    pub(crate) fn held(&self, unstretched: Sym2) -> (Sym2, PerRow<'_, Sym2>) {
        match &self.relaxing {
            None => (unstretched, self.pre_stretch.by_row()),
            Some(relaxing) => (Sym2::IDENTITY, PerRow::each(&relaxing.held)),
        }
    }

    /// Elastic constants \[MPa\] of a triangle over the present step.
    #[inline(always)]
    pub(crate) fn law(&self, triangle: usize) -> &Orthotropic {
        match self.relaxing.as_deref() {
            Some(Relaxing { law: Some(law), .. }) => &law[triangle],
            _ => &self.stiffness[triangle],
        }
    }

    /// Elastic constants \[MPa\] of all triangles over the present step.
    pub(crate) fn laws(&self) -> PerRow<'_, Orthotropic> {
        match self.relaxing.as_deref() {
            Some(Relaxing { law: Some(law), .. }) => law.by_row(),
            _ => self.stiffness.by_row(),
        }
    }

    /// Energy per volume \[mJ/mm³\] that branches of a triangle store beside that of its strain over the present step.
    #[inline]
    pub(crate) fn stored_beside(&self, triangle: usize) -> f64 {
        self.relaxing.as_ref().map_or(0.0, |relaxing| {
            let Relaxing { creep, start, held, unstretched, law, decays, .. } = &**relaxing;
            let start = if law.is_some() { start[triangle] } else { Sym2::IDENTITY };
            let lasting = *unstretched - self.pre_stretch[triangle];
            let stretches = [start, lasting, Sym2::IDENTITY - held[triangle]];
            stored_beside(&self.stiffness[triangle], decays, stretches, |branch| creep[branch][triangle])
        })
    }
}
