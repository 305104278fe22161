//! Observable state: the state of every body as plain arrays.

use super::Simulation;
use super::material_force::material_force;
use crate::components::{Attributes, Body, DecidedBy, EnergyCriterion, Forces, Frames, TearDecision, Tearing};
use crate::frame::{BodyFrame, Frame, TipFrame};
use crate::math::{ElementState, Sym2, elementary};
use crate::storage::{BodyId, Tips, Topology, Triangles, Uniform, Vertices};
use crate::systems::forces::assembly::membrane_forces;
use crate::systems::fracture::{
    EnergyReading, EnergyTerms, Surface, SurfaceQuery, TipMemory, energy_decision, strength, tip_decision,
};
use crate::systems::kernels::failure::{self, Search, Strength};
use glam::{DMat3, DVec2, DVec3};

/// Directions at which a tip's polar curve is sampled.
const CURVE_POINTS: usize = 180;

impl Simulation {
    /// The state of all bodies now. Costs one evaluation of every stress and force and, at each tip, of the criterion.
    pub fn frame(&self) -> Frame {
        let frames = self.bodies().into_iter().filter_map(|body| self.body_frame(body)).collect();
        Frame { step: self.report.step, time: self.report.time, bodies: frames, solids: self.solids() }
    }

    fn body_frame(&self, body: BodyId) -> Option<BodyFrame> {
        type Query<'a> = ((&'a Body, SurfaceQuery<'a>), (Option<(&'a Tearing, &'a Tips)>, Option<&'a EnergyCriterion>));
        let frames = &self.present_frames(body).ok()?;
        let mut query = self.world.query_one::<Query>(body.entity());
        let ((about, surface), (tearing, energy)) = query.get().ok()?;
        let surface = Surface::of(surface);
        let Surface { vertices, triangles, topology, .. } = surface;
        let principal = |state: ElementState| DVec2::from(state.stress.principal_values());
        let mut frame = BodyFrame {
            name: about.name.clone(),
            positions: vertices.position.clone(),
            rest_positions: vertices.rest_position.clone(),
            velocities: vertices.velocity.clone(),
            forces: self.pool.run(|| elastic_forces(triangles, topology, frames)),
            triangles: triangles.corners.clone(),
            stress: frames.states().map(stress_in_space).collect(),
            principal_stress: frames.states().map(principal).collect(),
            fibres: frames.states().map(|state| state.polar.fibre_axis).collect(),
            criterion: Vec::new(),
            attributes: self.world.get::<&Attributes>(body.entity()).ok().map(|attributes| (*attributes).clone()),
            tips: Vec::new(),
        };
        if let Some((tearing, tips)) = tearing {
            let search = Search::new(strength(tearing));
            let own = frames.states().zip(triangles.strength.iter());
            frame.criterion = own.map(|(state, factor)| own_criterion(state.stress, &search) / factor).collect();
            let mut memory = TipMemory::default();
            frame.tips = (0..tips.len())
                .filter_map(|tip| {
                    let (vertex, previous) = (tips.vertex[tip], tips.previous[tip]);
                    let place = (vertex, previous);
                    let at_rest = material_force(&surface, (tearing, energy), (tip, vertex), &mut memory);
                    let Some(terms) = energy.map(|energy| EnergyTerms { tearing, energy }) else {
                        let decision = tip_decision(&surface, tearing, tip, place, &mut memory)?;
                        return Some(tip_frame(&surface, frames, (tearing, previous, at_rest), &decision, None));
                    };
                    let (decision, reading) = energy_decision(&surface, terms, tip, place, &mut memory)?;
                    let energy = Some((reading, terms.toughness()));
                    Some(tip_frame(&surface, frames, (tearing, previous, at_rest), &decision, energy))
                })
                .collect();
        }
        Some(frame)
    }
}

/// Elastic forces of the membrane on the vertices \[N\].
fn elastic_forces(triangles: &Triangles, topology: &Topology, frames: &Frames) -> Vec<DVec3> {
    let mut forces = Forces::default();
    membrane_forces((triangles, topology), frames, |_| DVec3::ZERO, 0.0, &mut forces);
    forces.nodal
}

/// Biot stress turned into space by the triangle's rotation.
fn stress_in_space(state: ElementState) -> DMat3 {
    let (a, b, t) = (state.polar.fibre_axis, state.polar.transverse_axis, state.stress);
    let (ta, tb) = (a * t.xx + b * t.xy, a * t.xy + b * t.yy);
    let column = |i: usize| ta * a[i] + tb * b[i];
    DMat3::from_cols(column(0), column(1), column(2))
}

/// The criterion of a triangle's own stress; its frame lies along the fibre.
fn own_criterion(stress: Sym2, search: &Search) -> f64 {
    search.evaluate(stress, DVec2::X, None, None).map_or(0.0, |d| d.best.value)
}

fn tip_frame(
    surface: &Surface,
    frames: &Frames,
    (tearing, previous, material_force): (&Tearing, DVec3, DVec3),
    decision: &TearDecision,
    energy: Option<(EnergyReading, Strength)>,
) -> TipFrame {
    let [e1, e2] = decision.axes;
    let fibre = DVec2::new(decision.fibre.dot(e1), decision.fibre.dot(e2));
    let strength = strength(tearing);
    let (fan, chart) = (surface.topology.fan(decision.row), surface.chart(decision.row));
    let is_admissible = |rest: DVec3, flat: DVec2| {
        let is_in_fan = chart.as_ref().is_none_or(|c| c.sector(flat).is_some());
        is_in_fan && (previous == DVec3::ZERO || rest.dot(previous) >= elementary::cos(tearing.cone) - 1e-9)
    };
    let turn = RestToSpace::at(surface, frames, decision);
    let curve = (0..CURVE_POINTS)
        .filter_map(|i| {
            let flat = elementary::unit_at(std::f64::consts::TAU * i as f64 / CURVE_POINTS as f64);
            let rest = e1 * flat.x + e2 * flat.y;
            let factor = |factors: &Uniform<f64>| {
                let sector = chart.as_ref().and_then(|c| c.sector(flat));
                sector.and_then(|sector| fan.sectors.get(sector)).map_or(1.0, |&(t, _)| factors[t as usize])
            };
            let value = match &energy {
                Some((reading, toughness)) => {
                    reading.value(toughness, flat) / factor(&surface.triangles.toughness).sqrt()
                }
                None => {
                    failure::direction_value(decision.stress, fibre, &strength, flat)
                        / factor(&surface.triangles.strength)
                }
            };
            is_admissible(rest, flat).then(|| (turn.apply(rest), value))
        })
        .collect();
    TipFrame {
        position: surface.vertices.position[decision.row as usize],
        previous: (previous != DVec3::ZERO).then(|| turn.apply(previous)),
        direction: turn.apply(decision.direction),
        value: decision.value,
        curve,
        material_force: turn.apply(material_force),
        is_by_force: matches!(decision.by, DecidedBy::MaterialForce(_)),
        radius: tearing.radius,
    }
}

/// The rotation of the tissue ahead of a tip, by which rest directions are drawn in space: that of the triangle into which
/// the chosen direction points, or of the tip's first.
pub(super) struct RestToSpace {
    rest: [DVec3; 3],
    space: [DVec3; 3],
}

impl RestToSpace {
    fn at(surface: &Surface, frames: &Frames, decision: &TearDecision) -> Self {
        let fan = surface.topology.fan(decision.row);
        let chart = surface.chart(decision.row);
        let sector = chart.and_then(|c| c.sector(c.to_chart(decision.direction))).unwrap_or(0);
        let t = fan.sectors.get(sector).map_or(0, |&(t, _)| t as usize);
        Self::of_triangle(surface.vertices, surface.triangles, frames.state(t), t)
    }

    /// The rotation of one triangle.
    pub(super) fn of_triangle(vertices: &Vertices, triangles: &Triangles, state: ElementState, t: usize) -> Self {
        let x = triangles.corners[t].map(|v| vertices.rest_position[v as usize]);
        let fibre = triangles.fibre[t];
        let normal = (x[1] - x[0]).cross(x[2] - x[0]).normalize_or(DVec3::Z);
        let polar = state.polar;
        let (a, b) = (polar.fibre_axis, polar.transverse_axis);
        Self { rest: [fibre, normal.cross(fibre), normal], space: [a, b, a.cross(b)] }
    }

    pub(super) fn apply(&self, rest: DVec3) -> DVec3 {
        (0..3).map(|i| self.space[i] * self.rest[i].dot(rest)).sum()
    }
}
