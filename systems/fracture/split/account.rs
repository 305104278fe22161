//! Account of advances: length, area and toughness of each way, and the event that tells it.

use super::Tearer;
use crate::components::{DecidedBy, TearDecision, TearMode};
use crate::event::{Course, EventKind, TearCost};
use crate::math::elementary;
use crate::storage::{TipKey, TipRow};
use crate::systems::fracture::{Advance, End, EnergyTerms, TipChart, factor_of, mean_around, turned_axis};
use glam::DVec3;

impl Tearer<'_> {
    /// Records an advance, with the thickness \[mm\] of the sheet at its start, into a triangle with this factor of the body's
    /// toughness.
    pub(super) fn record_advance(
        &mut self,
        key: TipKey,
        decision: &TearDecision,
        (advance, thickness, factor): (&Advance, f64, f64),
        ideal: DVec3,
    ) {
        let cost = self.go_on(key, decision, (advance, thickness, factor), ideal);
        self.log.advance_count += 1;
        let wanted = if self.tearing.mode == TearMode::Edge { Course::Edge } else { Course::Exact };
        self.log.detour_count += u32::from(advance.course != wanted);
        self.log.ambiguous_count += u32::from(decision.is_ambiguous);
        self.log.material_force_count += u32::from(matches!(decision.by, DecidedBy::MaterialForce(_)));
        self.log.pending.push(EventKind::Advanced {
            tip: key,
            from: advance.from,
            to: advance.to,
            direction: decision.direction,
            criterion: decision.value,
            margin: decision.margin,
            is_ambiguous: decision.is_ambiguous,
            by: decision.by,
            release: decision.release,
            cost,
            course: advance.course,
        });
        self.finish_cut(advance.end.and_then(|End { freed }| freed));
    }

    /// Adds a move to the tip's advance of this step.
    pub(super) fn lengthen_advance(&mut self, key: TipKey, decision: &TearDecision, way: (&Advance, f64, f64)) {
        let (to, tip) = (way.0.to, self.tips.row(key));
        let ideal = tip.map_or(to, |tip| self.tips.ideal[tip as usize]);
        let more = self.go_on(key, decision, way, ideal);
        let mut told = self.log.pending.iter_mut().rev();
        let advance = told.find_map(|event| match event {
            EventKind::Advanced { tip, to, cost, .. } if *tip == key => Some((to, cost)),
            _ => None,
        });
        let Some((end, cost)) = advance else { return };
        *end = to;
        if let (Some(cost), Some(more)) = (cost, more) {
            let area = cost.area + more.area;
            let mean = |a: f64, b: f64| (a * cost.area + b * more.area) / area;
            let (toughness, overshoot) = (mean(cost.toughness, more.toughness), mean(cost.overshoot, more.overshoot));
            *cost = TearCost { area, toughness, overshoot };
        }
    }

    /// Moves a tip along a way, and adds that to the length and the area torn; its cost.
    fn go_on(
        &mut self,
        key: TipKey,
        decision: &TearDecision,
        (advance, thickness, factor): (&Advance, f64, f64),
        ideal: DVec3,
    ) -> Option<TearCost> {
        let tip = self.tips.row(key)?;
        let length = advance.length();
        let area = length * 0.5 * (thickness + self.thickness_at(advance.vertex));
        let way = (advance.to - advance.from).normalize_or(decision.direction);
        let toughness = self.toughness(decision.fibre, way, factor);
        self.log.note_area(area, toughness);
        let overshoot = decision.value * decision.value - 1.0;
        let before = self.tips.at(tip);
        self.tips.set(
            tip,
            TipRow {
                vertex: advance.vertex,
                previous: turned_axis(before.previous, decision.direction, length, self.tearing),
                ideal,
                criterion: decision.value,
                is_refused: false,
                ..before
            },
        );
        self.log.length += length;
        self.log.note_angle(advance.smallest_angle);
        toughness.map(|toughness| TearCost { area, toughness, overshoot })
    }

    /// Mean thickness of the triangles around a vertex \[mm\].
    pub(super) fn thickness_at(&self, vertex: u32) -> f64 {
        let around = &self.mesh.topology.incident[vertex as usize];
        let thickness = around.iter().map(|entry| self.mesh.triangles.thickness[(entry / 3) as usize]);
        thickness.sum::<f64>() / around.len().max(1) as f64
    }

    /// Toughness over the body's of the triangle that a direction leads into from a tip.
    pub(super) fn factor_ahead(&self, tip: &TipChart, direction: DVec3) -> f64 {
        let factors = &self.mesh.triangles.toughness;
        let sector = tip.chart.sector(tip.chart.to_chart(direction));
        sector.map_or(1.0, |sector| factor_of(factors, &tip.fan, sector))
    }

    /// Mean toughness over the body's of the triangles around a vertex.
    pub(super) fn factor_at(&self, vertex: u32) -> f64 {
        mean_around(&self.mesh.triangles.toughness, &self.mesh.topology.incident[vertex as usize])
    }

    /// Toughness against a tear in a unit direction \[N/mm\], of a body that has one, where it is `factor` times the body's.
    pub(super) fn toughness(&self, fibre: DVec3, way: DVec3, factor: f64) -> Option<f64> {
        let terms = EnergyTerms { tearing: self.tearing, energy: self.energy? };
        let delta = elementary::atan2(fibre.cross(way).length(), fibre.dot(way).abs());
        Some(terms.toughness().threshold(delta) * factor)
    }
}
