//! Tears that start where there is no tip.

use super::{Tearer, add_tip};
use crate::components::{RefusedSite, TearDecision, TearSite};
use crate::event::{EventKind, Verdict};
use crate::storage::TipKey;
use crate::systems::fracture::{Slit, TearRefusal, TipChart};
use glam::DVec3;
use smallvec::SmallVec;

impl Tearer<'_> {
    /// Nucleates a tear at the site or, where the mesh refuses, at a corner of its triangle, and opens up to `length` \[mm\] at once.
    pub(super) fn nucleate(
        &mut self,
        site: TearSite,
        decision: &TearDecision,
        length: f64,
    ) -> Result<(), (TearSite, TearRefusal)> {
        let from = self.site_at(site);
        let slit = self.open_at(site, decision.fibre, decision.direction).map_err(|refusal| (site, refusal))?;
        self.log.nucleation_count += 1;
        self.log.ambiguous_count += u32::from(decision.is_ambiguous);
        let TearDecision { value: criterion, margin, is_ambiguous, .. } = *decision;
        let verdict = Some(Verdict { criterion, margin, is_ambiguous });
        self.finish_cut(slit.freed);
        let mut opening: SmallVec<[(TipKey, DVec3); 2]> = SmallVec::new();
        for tip in slit.tips {
            let at = self.mesh.vertices.rest_position[tip.vertex as usize];
            let direction = tip.direction;
            let tip = add_tip(self.tips, tip);
            self.log.pending.push(EventKind::Started { tip, at, verdict });
            opening.push((tip, direction));
        }
        for (tip, direction) in opening {
            self.open_further(tip, TearDecision { direction, ..*decision }, (from, length));
        }
        Ok(())
    }

    /// Opens the tissue at a site, or at a corner of the triangle, and records the energy that costs.
    pub(super) fn open_at(&mut self, site: TearSite, fibre: DVec3, direction: DVec3) -> Result<Slit, TearRefusal> {
        let mode = self.tearing.mode;
        let corners = match site {
            TearSite::Vertex(_) => None,
            TearSite::Triangle(triangle) => Some(self.mesh.triangles.corners[triangle as usize].map(TearSite::Vertex)),
        };
        let mut started = self.cut(|cutter| cutter.nucleate(site, direction, mode));
        for other in corners.into_iter().flatten() {
            if started.is_ok() {
                break;
            }
            started = self.cut(|cutter| cutter.nucleate(other, direction, mode)).or(started);
        }
        let slit = started?;
        let mut length = 0.0;
        for ends in slit.path.windows(2) {
            let rest = &self.mesh.vertices.rest_position;
            let way = rest[ends[1] as usize] - rest[ends[0] as usize];
            let thickness = 0.5 * (self.thickness_at(ends[0]) + self.thickness_at(ends[1]));
            length += way.length();
            let factor = 0.5 * (self.factor_at(ends[0]) + self.factor_at(ends[1]));
            self.log.note_area(way.length() * thickness, self.toughness(fibre, way.normalize_or(direction), factor));
        }
        self.log.length += length;
        self.log.note_angle(slit.smallest_angle);
        Ok(slit)
    }

    /// Advances a new tip until it is `length` \[mm\] from the start, to half an edge.
    fn open_further(&mut self, key: TipKey, decision: TearDecision, (from, length): (DVec3, f64)) {
        let edge = self.tearing.radius / decision.edges_per_radius;
        while let Some(tip) = self.tips.row(key).map(|row| row as usize)
            && let (vertex, ideal) = (self.tips.vertex[tip], self.tips.ideal[tip])
            && let at = self.mesh.vertices.rest_position[vertex as usize]
            && at.distance(from) + 0.5 * edge < length
            && let thickness = self.thickness_at(vertex)
            && let Ok(chart) = TipChart::new(&self.mesh, vertex)
            && let factor = self.factor_ahead(&chart, decision.direction)
            && let Ok((advance, ideal)) = self.cut_from(&chart, ideal, decision.direction)
        {
            self.record_advance(key, &decision, (&advance, thickness, factor), ideal);
        }
    }

    /// Position of a start \[mm, rest shape\].
    fn site_at(&self, site: TearSite) -> DVec3 {
        let at = |v: u32| self.mesh.vertices.rest_position[v as usize];
        match site {
            TearSite::Vertex(vertex) => at(vertex),
            TearSite::Triangle(t) => self.mesh.triangles.corners[t as usize].into_iter().map(at).sum::<DVec3>() / 3.0,
        }
    }

    /// Reports a start or ligament failure that was refused, unless the last one was refused at the same site.
    pub(super) fn tell_refused(
        &mut self,
        started: Result<(), (TearSite, TearRefusal)>,
        last: &mut Option<RefusedSite>,
    ) {
        let Err((site, refusal)) = started else { return *last = None };
        let row = match site {
            TearSite::Vertex(vertex) => vertex,
            TearSite::Triangle(triangle) => self.mesh.triangles.corners[triangle as usize][0],
        };
        let site = RefusedSite::of(site, self.mesh.vertices, self.mesh.triangles);
        if std::mem::replace(last, site) != site {
            self.refuse(None, self.mesh.vertices.rest_position[row as usize], &refusal);
        }
    }
}
