//! Where the energy of a body goes.
//!
//! Over every step, with the step's displacement u, the discrete equation times u reads
//! work = Δelastic + Δkinetic + Δcontent + damping + relaxation + drag + leak + numerical + residual + unbalanced + released,
//! and between steps edits at unchanged positions add `edits`. Each term is summed from its own formula, none is the remainder of
//! the others: the imbalance that remains tells of a wrong force, tangent, reaction or edit.

use glam::DVec3;

/// Relative change of the energy below which it is the rounding of sums over triangles.
const ROUNDING: f64 = 1e-12;

/// Energies of a body \[mJ\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Energies {
    /// Elastic energy of the membrane, relative to its stress-free shape.
    pub elastic: f64,
    /// Kinetic energy.
    pub kinetic: f64,
}

impl std::ops::Sub for Energies {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self { elastic: self.elastic - other.elastic, kinetic: self.kinetic - other.kinetic }
    }
}

/// Energy that a body has received, given away and stored since its audit began, all \[mJ\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EnergyBalance {
    /// Work of the holds on the body: reaction · prescribed displacement.
    pub work_of_holds: f64,
    /// Work of jaws without a stiffness on the body: their force on each vertex · its displacement.
    pub work_of_jaws: f64,
    /// Work on the body of all else that acts from outside: gravity, pressure, also that outside a compartment, point and edge loads, springs, jaws with a stiffness and
    /// contact, with the force that the scheme has put in. Energy stored by springs and contact counts as given back.
    pub work_of_loads: f64,
    /// Elastic and kinetic energy that edits of the mesh have put in at unchanged positions. Splits and openings change
    /// neither; flips and slides interpolate the state. The elastic energy of edits by tips that glide is in `released`.
    pub edits: Energies,
    /// Change of the elastic and kinetic energy from the start of the audit to now.
    pub stored: Energies,
    /// Dissipated by strain-rate damping along the step's straight way: dt·v·C·v, ≥ 0. In a long step it may exceed the available
    /// energy; the numerical elastic term then gives the excess back.
    pub damping: f64,
    /// Dissipated by the dashpots of [`Relaxation`](crate::components::Relaxation), ≥ 0. Energy that their springs store is elastic energy.
    pub relaxation: f64,
    /// Dissipated by drag, ≥ 0.
    pub drag: f64,
    /// Energy that the inflow of a [`Compartment`](crate::components::Compartment) has brought.
    pub(crate) inflow: f64,
    /// Energy that leaks of a compartment have taken.
    pub(crate) leak: f64,
    /// Change of the energy that the content of a compartment stores, over the steps.
    pub(crate) content: f64,
    /// Taken by the scheme from the energy of a content, or given back where negative: its work on the body is that of the pressure at the end of each step.
    pub(crate) numerical_content: f64,
    /// Taken by the scheme from the elastic energy, or given back where negative: (its force − the true one along the step) · displacement.
    /// Steps longer than a tear takes to spring open dissipate here the energy that it releases.
    /// In static solves, the error of the trapezoidal rule of the works over a load step.
    pub numerical_elastic: f64,
    /// Taken by the scheme from the kinetic energy: ½·(v₁ − v₀)·M·(v₁ − v₀) of backward Euler; in static solves all of it.
    pub numerical_kinetic: f64,
    /// Work of the residual forces of the solves: residual · displacement.
    pub residual: f64,
    /// Work of forces that a dynamic step leaves unbalanced because its increment is not the solve's answer as it is. The energy
    /// guard takes only a fraction of the answer, or vertices are put back outside an obstacle. Force · displacement; positive is
    /// taken from the body.
    pub unbalanced: f64,
    /// Elastic energy released by tears in static solves and by tips that glide. Static solves relax unbalanced forces: their work
    /// is ½·force·displacement from the nodal forces at both ends, as Rybicki and Kanninen (1977) close a crack, and where nothing else
    /// has moved on, with the quadrature's correction for forces that do not fall linearly. Of a glide: the fall of the elastic energy by its
    /// moves at fixed positions, and the scheme's elastic share of the step in which the field relaxes after them.
    pub released: f64,
}

impl EnergyBalance {
    /// Work of holds, jaws, loads and inflow \[mJ\].
    pub fn work(&self) -> f64 {
        self.work_of_holds + self.work_of_jaws + self.work_of_loads + self.inflow
    }

    /// The imbalance over the largest other term; zero where nothing has happened.
    pub fn relative_imbalance(&self) -> f64 {
        self.over_largest(self.imbalance())
    }

    /// The work of unbalanced forces over the largest term; zero where nothing has happened.
    pub fn relative_unbalanced(&self) -> f64 {
        self.over_largest(self.unbalanced)
    }

    fn over_largest(&self, term: f64) -> f64 {
        let others = self.terms().into_iter().filter(|(name, _)| *name != "imbalance");
        let largest = others.map(|(_, term)| term.abs()).fold(0.0, f64::max);
        if largest > 0.0 { term.abs() / largest } else { 0.0 }
    }

    /// Dissipated energy \[mJ\]: damping, relaxation, drag and the scheme's share together. Steps are checked that it does not fall.
    pub fn dissipated(&self) -> f64 {
        self.damping + self.relaxation + self.drag + self.numerical()
    }

    /// The scheme's share \[mJ\]: negative where damping took more than its linearised step had, and the scheme gave that back.
    pub fn numerical(&self) -> f64 {
        self.numerical_elastic + self.numerical_kinetic
    }

    /// Energy received but not accounted for \[mJ\]: zero but for rounding, quadrature, and the reactions of a Newton iteration
    /// that stopped short of its tolerance, which are those before its last solve.
    pub fn imbalance(&self) -> f64 {
        let came = self.work() + self.edits.elastic + self.edits.kinetic;
        let kept = self.stored.elastic + self.stored.kinetic + self.content;
        let lost = self.damping + self.relaxation + self.leak + self.numerical_content;
        came - kept - lost - self.drag - self.numerical() - self.residual - self.unbalanced - self.released
    }

    /// All terms with their names, as they stand in files, and the imbalance \[mJ\].
    pub fn terms(&self) -> [(&'static str, f64); 19] {
        [
            ("work_of_holds", self.work_of_holds),
            ("work_of_jaws", self.work_of_jaws),
            ("work_of_loads", self.work_of_loads),
            ("edits", self.edits.elastic + self.edits.kinetic),
            ("elastic_change", self.stored.elastic),
            ("kinetic_change", self.stored.kinetic),
            ("damping", self.damping),
            ("relaxation", self.relaxation),
            ("drag", self.drag),
            ("inflow", self.inflow),
            ("leak", self.leak),
            ("content_change", self.content),
            ("numerical_content", self.numerical_content),
            ("numerical_elastic", self.numerical_elastic),
            ("numerical_kinetic", self.numerical_kinetic),
            ("residual", self.residual),
            ("unbalanced", self.unbalanced),
            ("released", self.released),
            ("imbalance", self.imbalance()),
        ]
    }

    /// The balance of the time since an earlier one of the same body.
    pub fn since(&self, earlier: &Self) -> Self {
        let mut since = *self;
        since.add_times(earlier, -1.0);
        since
    }

    /// Adds the terms of a later span of time.
    pub fn add(&mut self, other: &Self) {
        self.add_times(other, 1.0);
    }

    fn add_times(&mut self, other: &Self, factor: f64) {
        let pairs = [
            (&mut self.work_of_holds, other.work_of_holds),
            (&mut self.work_of_jaws, other.work_of_jaws),
            (&mut self.work_of_loads, other.work_of_loads),
            (&mut self.edits.elastic, other.edits.elastic),
            (&mut self.edits.kinetic, other.edits.kinetic),
            (&mut self.stored.elastic, other.stored.elastic),
            (&mut self.stored.kinetic, other.stored.kinetic),
            (&mut self.damping, other.damping),
            (&mut self.relaxation, other.relaxation),
            (&mut self.drag, other.drag),
            (&mut self.inflow, other.inflow),
            (&mut self.leak, other.leak),
            (&mut self.content, other.content),
            (&mut self.numerical_content, other.numerical_content),
            (&mut self.numerical_elastic, other.numerical_elastic),
            (&mut self.numerical_kinetic, other.numerical_kinetic),
            (&mut self.residual, other.residual),
            (&mut self.unbalanced, other.unbalanced),
            (&mut self.released, other.released),
        ];
        pairs.into_iter().for_each(|(sum, term)| *sum += factor * term);
    }
}

/// Keeps the energy balance of a body from its first step on. *State.* A body without it spends no time on it.
///
/// A step may be redone after tears have advanced, or undone. So its terms stand aside, with the changes by edits of its start
/// and of its end, until the next step begins.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct EnergyAudit {
    /// Energies when the audit began.
    pub(crate) initial: Option<Energies>,
    /// Terms of the steps that stand, and edits of the starts of this one.
    pub(crate) settled: Box<EnergyBalance>,
    /// Terms of this step, as it was last carried out.
    pub(crate) step: Box<EnergyBalance>,
    /// Energies at the start and the end of this step, on the mesh on which it was last carried out.
    pub(crate) ends: [Energies; 2],
    /// Energy change of this step's start by edits since then: counts if the step is redone or undone.
    pub(crate) edits_of_start: Energies,
    /// The last equilibrium, until a dynamic step follows.
    pub(crate) equilibrium: Option<Equilibrium>,
    /// Displacement at which the forces below were evaluated \[mm\].
    pub(crate) displacement: Vec<DVec3>,
    /// Nodal forces of loads \[N\]; while they are being put on those of the membrane.
    pub(crate) loads: Vec<DVec3>,
    /// Nodal forces of membrane and loads at the start of a static solve \[N\]. Loads that move on with time begin as they were at the
    /// last equilibrium; where there is none, or the mesh has changed since, they are put on at once.
    pub(crate) start: [Vec<DVec3>; 2],
    /// Sums per chunk of triangles.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub(crate) partials: Vec<Shares>,
    /// *Derived*: how this step counts the energy of tips that glide.
    #[cfg_attr(feature = "snapshot", serde(skip))]
    pub(crate) glide: GlideShare,
}

/// The energy of tips that glide, within a step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct GlideShare {
    /// Whether tips of the body glide.
    pub is_on: bool,
    /// Whether the step starts with moves after which the field has not relaxed.
    pub is_relaxing: bool,
    /// The scheme's elastic share that counts as released \[mJ\].
    pub relaxed: f64,
}

/// Contributions of triangles to the terms of a step, all \[mJ\].
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Shares {
    /// The true work along the step.
    pub work: f64,
    /// The scheme's work.
    pub scheme: f64,
    /// Dissipated by strain-rate damping.
    pub damping: f64,
    /// Elastic energy at the start.
    pub start: f64,
    /// Elastic energy at the end.
    pub end: f64,
}

impl std::ops::AddAssign for Shares {
    fn add_assign(&mut self, other: Self) {
        self.work += other.work;
        self.scheme += other.scheme;
        self.damping += other.damping;
        self.start += other.start;
        self.end += other.end;
    }
}

impl std::iter::Sum for Shares {
    fn sum<I: Iterator<Item = Self>>(shares: I) -> Self {
        shares.fold(Self::default(), |mut sum, share| {
            sum += share;
            sum
        })
    }
}

/// A static equilibrium.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Equilibrium {
    /// When \[ms\].
    pub time: f64,
    /// Elastic energy \[mJ\].
    pub elastic: f64,
    /// Length torn and cut by then \[mm\].
    pub torn: f64,
}

impl EnergyAudit {
    /// The balance so far, for a body whose energies are now `energies`; all zero before the first step.
    pub fn balance(&self, energies: Energies) -> EnergyBalance {
        let mut balance = *self.settled;
        balance.add(&self.step);
        balance.stored = self.initial.map_or(Energies::default(), |initial| energies - initial);
        balance
    }

    /// Whether the static solve under way begins with the loads of an earlier equilibrium.
    pub(crate) fn begins_loaded(&self) -> bool {
        !self.start[1].is_empty()
    }

    /// Settles the terms of the last step and begins a new one, whose tips glide or not.
    pub(crate) fn settle(&mut self, glides: bool) {
        let step = std::mem::take(&mut *self.step);
        self.settled.add(&step);
        let moved = std::mem::take(&mut self.edits_of_start);
        self.glide = GlideShare { is_on: glides, is_relaxing: glides && moved.elastic != 0.0, relaxed: 0.0 };
    }

    /// Takes the terms of a dynamic step. While the field relaxes after tips have glided, the scheme's elastic share is released by them.
    pub(crate) fn note_step(&mut self, mut terms: EnergyBalance) {
        self.glide.relaxed = 0.0;
        if self.glide.is_relaxing {
            self.glide.relaxed = std::mem::take(&mut terms.numerical_elastic);
            terms.released += self.glide.relaxed;
        }
        *self.step = terms;
    }

    /// Energy changes of the step's start and of its end by edits after it.
    pub(crate) fn note_tear(&mut self, [start, end]: [Energies; 2]) {
        let is_rounding = |edits: Energies, of: Energies| edits.elastic.abs() < ROUNDING * of.elastic;
        if self.glide.is_on && is_rounding(start, self.ends[0]) && is_rounding(end, self.ends[1]) {
            self.edits_of_start = Energies { elastic: 0.0, ..start };
            self.step.edits = end;
            return;
        }
        self.edits_of_start = start;
        self.step.edits = end;
        if self.glide.is_on {
            self.step.edits.elastic = 0.0;
            self.step.released = self.glide.relaxed - end.elastic;
        }
    }

    /// Forgets the last equilibrium's loads, which belong to another mesh after a change.
    pub(crate) fn forget_loads(&mut self) {
        self.loads.clear();
    }

    /// The body is elsewhere: its loads are others, and it is not in equilibrium with them.
    pub(crate) fn forget_equilibrium(&mut self) {
        self.forget_loads();
        self.equilibrium = None;
    }

    /// A cut between steps has changed the energies at unchanged positions.
    pub(crate) fn note_edits(&mut self, edits: Energies) {
        self.settled.add(&EnergyBalance { edits, ..EnergyBalance::default() });
    }

    /// Undoes the step: no term of the attempt is left.
    pub(crate) fn undo_step(&mut self) {
        self.void_step();
        self.ends = [Energies::default(); 2];
        self.displacement.clear();
        self.forget_loads();
        self.start.iter_mut().for_each(Vec::clear);
    }

    /// The step is redone from its start, or undone: its terms and the edits of its end are void, those of its start count.
    pub(crate) fn void_step(&mut self) {
        let mut edits = std::mem::take(&mut self.edits_of_start);
        if self.glide.is_on {
            self.glide.is_relaxing |= edits.elastic != 0.0;
            self.settled.released -= std::mem::take(&mut edits.elastic);
        }
        self.note_edits(edits);
        *self.step = EnergyBalance::default();
        self.equilibrium = None;
    }
}
