//! What the criterion keeps between steps: the table of its search and, per tip, the chart and the disc, as long as no edit
//! touches their triangles. A resting tip then costs the stress in its disc and one search.

use super::held_shut::{field_centre, lay_at_tip, triangles_around};
use super::ring::Ring;
use super::shifted_disc::{MaterialForce, ShiftedDisc};
use super::strands::Strands;
use super::tip_disc::{Disc, Walk};
use super::tip_stress::{DiscAverage, Surface};
use crate::storage::EditRecord;
use crate::systems::kernels::failure::{Search, Strength};
use crate::systems::kernels::fan::FanChart;

/// *Derived.* The criterion's memory of one body. Whoever replaces the body's tables replaces it by the default.
#[derive(Clone, Debug, Default)]
pub struct TipMemory {
    search: Option<Box<Search>>,
    /// By the rows of the tips.
    places: Vec<Option<TipPlace>>,
    /// The same for bodies that decide by energy; empty otherwise.
    rings: Vec<Kept<Ring>>,
    /// Discs for the material force, where it is asked for.
    shifted: Vec<Kept<ShiftedDisc>>,
    /// Of a body that has torn.
    strands: Option<Box<Strands>>,
    /// Number of edits so far, and per triangle the last one that has touched it.
    edits: u32,
    touched: Vec<u32>,
    /// For discs that are not kept.
    pub passing: Disc,
    /// Buffers.
    pub walk: Walk,
}

/// The surroundings of a tip.
#[derive(Clone, Debug)]
struct TipPlace {
    vertex: u32,
    radius: f64,
    /// [`TipMemory::edits`] when this was last found up to date.
    edits: u32,
    chart: FanChart,
    disc: Disc,
}

/// What is laid out around a tip, and follows from the rest shape alone.
#[derive(Clone, Debug, Default)]
struct Kept<T> {
    vertex: Option<u32>,
    radius: f64,
    /// [`TipMemory::edits`] when this was last found up to date.
    edits: u32,
    laid: T,
}

/// The edits of a body so far, and per triangle the last one that has touched it.
type Edits<'a> = (u32, &'a [u32]);

/// What depends on some triangles alone.
trait Laid: Default {
    /// Whether one of them is such.
    fn has(&self, is_such: impl Fn(u32) -> bool) -> bool;
}

impl Laid for Ring {
    fn has(&self, is_such: impl Fn(u32) -> bool) -> bool {
        self.triangles().any(is_such)
    }
}

impl Laid for ShiftedDisc {
    fn has(&self, is_such: impl Fn(u32) -> bool) -> bool {
        self.triangles().any(is_such)
    }
}

impl<T: Laid> Kept<T> {
    /// What is kept at a tip.
    fn at(list: &mut Vec<Self>, tip: usize) -> &mut Self {
        if list.len() <= tip {
            list.resize_with(tip + 1, Self::default);
        }
        &mut list[tip]
    }

    /// Whether it has to be laid out anew; it counts as up to date from now on.
    fn is_due(&mut self, vertex: u32, radius: f64, (edits, touched): Edits) -> bool {
        let is_known = self.vertex == Some(vertex) && self.radius == radius;
        let is_touched = |t: u32| touched.get(t as usize).is_none_or(|&edit| edit > self.edits);
        let is_due = !is_known || (self.edits != edits && self.laid.has(is_touched));
        (self.vertex, self.radius, self.edits) = (Some(vertex), radius, edits);
        is_due
    }
}

impl TipMemory {
    /// The search for these strengths.
    pub fn search(&mut self, strength: Strength) -> &Search {
        let kept = self.search.take().filter(|search| *search.strength() == strength);
        self.search.insert(kept.unwrap_or_else(|| Box::new(Search::new(strength))))
    }

    /// The strands of a body narrower than a radius \[mm\].
    pub fn strands(&mut self, surface: &Surface, radius: f64) -> &Strands {
        let strands = self.strands.get_or_insert_default();
        strands.find(surface, self.edits, radius);
        strands
    }

    /// For the `tip`th tip of a body, at `vertex`: the chart of its fan, the search for these strengths and the averages
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

    /// The same with the ring of another radius \[mm\] about the same point.
    pub fn at_tip_with_ring(
        &mut self,
        surface: &Surface,
        (tip, vertex): (usize, u32),
        strength: Strength,
        (radius, ring_radius): (f64, f64),
    ) -> Option<(&FanChart, DiscAverage, &Ring)> {
        self.look(surface, (tip, vertex), strength, radius)?;
        Kept::at(&mut self.shifted, tip).laid.make_room();
        let place = self.places[tip].as_ref()?;
        let kept = Kept::at(&mut self.rings, tip);
        if kept.is_due(vertex, ring_radius, (self.edits, &self.touched)) {
            // About the point at which the disc lies, so that both see one field.
            let at = field_centre(surface, (vertex, radius), &place.chart).0;
            let start = triangles_around(surface, vertex);
            let frame = (at, place.chart.axes(), ring_radius);
            kept.laid.lay(surface, frame, place.disc.fibre, start, &mut self.walk);
        }
        let average = DiscAverage::over(&place.disc, radius, surface)?;
        Some((&place.chart, average, &kept.laid))
    }

    /// The material force \[N/mm\] at the `tip`th tip of a body, at `vertex`, on a disc of about `wanted` \[mm\], with the chart in
    /// whose axes it is. `None` where the fan has no area or the force is not finite.
    pub fn material_force(
        &mut self,
        surface: &Surface,
        (tip, vertex): (usize, u32),
        strength: Strength,
        (radius, wanted): (f64, f64),
    ) -> Option<(&FanChart, MaterialForce)> {
        self.look(surface, (tip, vertex), strength, radius)?;
        let place = self.places[tip].as_ref()?;
        let radius = ShiftedDisc::radius(wanted, radius / place.disc.edges_per_radius);
        let kept = Kept::at(&mut self.shifted, tip);
        if kept.is_due(vertex, radius, (self.edits, &self.touched)) || !kept.laid.bends_as(surface) {
            let start = triangles_around(surface, vertex);
            kept.laid.lay(surface, (vertex, place.chart.axes(), radius), start, &mut self.walk);
        }
        Some((&place.chart, kept.laid.force(surface)?))
    }

    /// Brings what is kept of a tip up to date; `None` where its fan has no area.
    fn look(&mut self, surface: &Surface, (tip, vertex): (usize, u32), strength: Strength, radius: f64) -> Option<()> {
        self.search(strength);
        if self.places.len() <= tip {
            self.places.resize_with(tip + 1, || None);
        }
        if !self.is_up_to_date(tip, vertex, radius) {
            let mut disc = self.places[tip].take().map_or_else(Disc::default, |place| place.disc);
            let chart = surface.chart(vertex)?;
            lay_at_tip(&mut disc, surface, (vertex, radius), &chart, &mut self.walk);
            self.places[tip] = Some(TipPlace { vertex, radius, edits: self.edits, chart, disc });
        }
        Some(())
    }

    fn is_up_to_date(&mut self, tip: usize, vertex: u32, radius: f64) -> bool {
        let Some(place) = &mut self.places[tip] else { return false };
        let (edits, touched) = (place.edits, &self.touched);
        let is_touched = |t: u32| touched.get(t as usize).is_none_or(|&edit| edit > edits);
        if place.vertex != vertex || place.radius != radius {
            return false;
        }
        if edits != self.edits && place.disc.triangles().any(is_touched) {
            return false;
        }
        place.edits = self.edits;
        true
    }

    /// Follows an edit.
    pub fn follow(&mut self, record: &EditRecord) {
        if self.edits == u32::MAX {
            (self.edits, self.places, self.rings, self.shifted) = (0, Vec::new(), Vec::new(), Vec::new());
            self.strands = None;
            self.touched.fill(0);
        }
        self.edits += 1;
        self.touched.resize(record.first_triangle as usize, 0);
        let removed = record.removed.iter().flat_map(|removed| &removed.triangles).map(|triangle| triangle.row);
        let changed = record.changed_triangles.iter().flat_map(|changed| [changed.row_before, changed.row]);
        for row in changed.chain(removed) {
            self.touched[row as usize] = self.edits;
        }
        self.touched.resize(record.triangle_count(), self.edits);
    }
}
