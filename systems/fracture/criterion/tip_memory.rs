//! State that the criterion keeps between steps: the table of its search and, per tip, the chart and the disc, as long as no
//! edit touches their triangles. A resting tip then costs the stress in its disc and one search.

use crate::storage::{EditLog, Revision};
use crate::systems::fracture::criterion::crack_field::CrackFrame;
use crate::systems::fracture::criterion::held_shut::{field_tip, lay_at_tip, triangles_around};
use crate::systems::fracture::criterion::shifted_disc::ShiftedDisc;
use crate::systems::fracture::criterion::tip_disc::{Disc, Walk};
use crate::systems::fracture::criterion::tip_stress::{DiscAverage, Surface};
use crate::systems::fracture::topology::ligaments::Ligaments;
use crate::systems::kernels::failure::{Search, Strength};
use crate::systems::kernels::fan::FanChart;

/// *Derived.* The criterion's memory of one body; the topology's log of edits shows which parts are still valid.
#[derive(Clone, Debug, Default)]
pub struct TipMemory {
    search: Option<Box<Search>>,
    /// Charts and discs by the rows of the tips.
    places: Vec<Option<TipPlace>>,
    /// Discs of the material force by the rows of the tips, for bodies that decide by energy; empty otherwise.
    shifted: Vec<Kept<ShiftedDisc>>,
    /// Ligaments of a body that has torn.
    ligaments: Option<Box<Ligaments>>,
    /// Buffer for discs that are not kept.
    pub passing: Disc,
    /// Buffers of the walk.
    pub walk: Walk,
}

/// The surroundings of a tip.
#[derive(Clone, Debug)]
struct TipPlace {
    vertex: u32,
    radius: f64,
    /// Revision at which the surroundings were last found up to date.
    checked: Revision,
    chart: FanChart,
    disc: Disc,
}

/// A domain laid out around a tip, which follows from the rest shape alone.
#[derive(Clone, Debug, Default)]
struct Kept<T> {
    vertex: Option<u32>,
    radius: f64,
    /// Revision at which the domain was last found up to date.
    checked: Revision,
    domain: T,
}

/// A domain that depends on some triangles alone.
trait Domain: Default {
    /// Rows of the triangles.
    fn rows(&self) -> impl Iterator<Item = u32>;
}

impl Domain for ShiftedDisc {
    fn rows(&self) -> impl Iterator<Item = u32> {
        self.triangles()
    }
}

impl<T: Domain> Kept<T> {
    /// The entry kept at a tip.
    fn at(list: &mut Vec<Self>, tip: usize) -> &mut Self {
        if list.len() <= tip {
            list.resize_with(tip + 1, Self::default);
        }
        &mut list[tip]
    }

    /// Whether the domain has to be rebuilt; it counts as up to date from now on.
    fn is_due(&mut self, vertex: u32, radius: f64, log: &EditLog) -> bool {
        let is_known = self.vertex == Some(vertex) && self.radius == radius;
        let is_due = !is_known || log.have_changed(self.domain.rows(), self.checked);
        (self.vertex, self.radius, self.checked) = (Some(vertex), radius, log.now());
        is_due
    }
}

impl TipMemory {
    /// The search for these strengths.
    pub fn search(&mut self, strength: Strength) -> &Search {
        let kept = self.search.take().filter(|search| *search.strength() == strength);
        self.search.insert(kept.unwrap_or_else(|| Box::new(Search::new(strength))))
    }

    /// The ligaments of a body narrower than a radius \[mm\].
    pub fn ligaments(&mut self, surface: &Surface, radius: f64) -> &Ligaments {
        let ligaments = self.ligaments.get_or_insert_default();
        ligaments.find(surface, radius);
        ligaments
    }

    /// Finds for the `tip`th tip of a body, at `vertex`, the chart of its fan, the search for these strengths and the averages
    /// over its disc of this radius \[mm\]. `None` where its fan has no area.
    pub fn at_tip(
        &mut self,
        surface: &Surface,
        (tip, vertex): (usize, u32),
        strength: Strength,
        radius: f64,
    ) -> Option<(&FanChart, &Search, DiscAverage)> {
        self.look(surface, (tip, vertex), strength, radius)?;
        let place = self.places[tip].as_ref()?;
        Some((&place.chart, self.search.as_deref()?, DiscAverage::over(&place.disc, radius, surface)?))
    }

    /// The averages over the disc of radius R \[mm\] at a tip, as [`at_tip`](Self::at_tip) finds them.
    pub fn average(
        &mut self,
        surface: &Surface,
        at: (usize, u32),
        strength: Strength,
        radius: f64,
    ) -> Option<DiscAverage> {
        Some(self.at_tip(surface, at, strength, radius)?.2)
    }

    /// The disc of about `wanted` \[mm\] for the material force at the `tip`th tip of a body, at `vertex`, with the chart in whose axes it
    /// is laid. `None` where the fan has no area.
    pub fn shifted_disc(
        &mut self,
        surface: &Surface,
        (tip, vertex): (usize, u32),
        strength: Strength,
        (radius, wanted): (f64, f64),
    ) -> Option<(&FanChart, &mut ShiftedDisc)> {
        self.look(surface, (tip, vertex), strength, radius)?;
        let place = self.places[tip].as_ref()?;
        let disc_radius = ShiftedDisc::radius(wanted, radius / place.disc.edges_per_radius);
        let kept = Kept::at(&mut self.shifted, tip);
        kept.domain.make_room();
        let is_due = kept.is_due(vertex, disc_radius, &surface.topology.log);
        let fibre = place.disc.fibre;
        if is_due || !kept.domain.bends_as(surface) || kept.domain.frame().is_none_or(|frame| frame.fibre != fibre) {
            let frame = CrackFrame { fibre, tip: field_tip(surface, (vertex, radius), &place.chart) };
            let start = triangles_around(surface, vertex);
            kept.domain.lay(surface, ((vertex, place.chart.axes(), disc_radius), frame), start, &mut self.walk);
        }
        Some((&place.chart, &mut kept.domain))
    }

    /// Updates the memory of a tip; `None` where its fan has no area.
    fn look(&mut self, surface: &Surface, (tip, vertex): (usize, u32), strength: Strength, radius: f64) -> Option<()> {
        self.search(strength);
        if self.places.len() <= tip {
            self.places.resize_with(tip + 1, || None);
        }
        let log = &surface.topology.log;
        if !self.is_up_to_date(tip, vertex, radius, log) {
            let mut disc = self.places[tip].take().map_or_else(Disc::default, |place| place.disc);
            let chart = surface.chart(vertex)?;
            lay_at_tip(&mut disc, surface, (vertex, radius), &chart, &mut self.walk);
            self.places[tip] = Some(TipPlace { vertex, radius, checked: log.now(), chart, disc });
        }
        Some(())
    }

    fn is_up_to_date(&mut self, tip: usize, vertex: u32, radius: f64, log: &EditLog) -> bool {
        let Some(place) = &mut self.places[tip] else { return false };
        if place.vertex != vertex || place.radius != radius {
            return false;
        }
        if log.have_changed(place.disc.triangles(), place.checked) {
            return false;
        }
        place.checked = log.now();
        true
    }
}
