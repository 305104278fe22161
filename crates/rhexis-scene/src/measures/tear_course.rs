//! The course of a tear around an axis, with the hand that drew it: how far it has come, how it ended, grasps, time and force.
//!
//! | figure | definition | source |
//! |---|---|---|
//! | completion angle | range of the angle about the axis that cuts and tips have passed, at most 360°; 360° once it has closed | part of the circle done, as training simulators score an unfinished rhexis |
//! | grasps, time | jaws closed; from the start to the end of the tear | Raval 2021: experts 3.9 to 6.5 grasps, 29 to 42 s |
//! | force | RMS and peak of the force at closed jaws, over the steps until the tear's end | fibre-Bragg forceps: experts 9 mN RMS, novices 17 |
//! | force of a grasp | mean, RMS and peak of its own steps | Han 2025: 9.7 to 12.4 mN mean per grasp, peak 19 |
//! | opening as it lies | the same figures as of the opening at rest, of the outline in space when it closes | a drawn capsule shrinks from its opening |
//! | largest radius | from the axis to the farthest point reached by a tip | run-out: past the zonules' insertion, or to the rim |
//!
//! A tear begins with a puncture near the axis, from which a cut leads outwards and round. The end of the cut that is left there is the
//! flap's inner end. Where it tears on, it is the flap that tears off, and no circle that is left.

use super::opening::{Axis, Opening, area_within, boundary_loops};
use glam::DVec3;
use hecs::World;
use rhexis::components::{Grips, Pinch};
use rhexis::event::{Event, EventKind};
use rhexis::storage::{BodyId, TipKey, Tips, Topology, Triangles, Vertices};
use std::f64::consts::{PI, TAU};

/// A tear ends on the rim where it is nearer to it than this part of the rim's mean radius.
const ON_RIM: f64 = 1e-6;

/// An end of the first cut is the flap's inner end that is nearer to the axis than this part of the cut's farthest point, if its other
/// end is not.
const INNER: f64 = 0.5;

/// How a tear around an axis has ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub enum Outcome {
    /// It has not.
    #[default]
    Unfinished,
    /// It has closed around the axis, and a piece is free.
    Closed,
    /// A tip has run out to the rim.
    RanOut,
    /// The flap has torn off: its inner end has torn on to the rim.
    TornOff,
}

/// The figures of a tear's course.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct CourseFigures {
    /// How it has ended.
    pub outcome: Outcome,
    /// The shape of the opening around the axis, in the rest shape.
    pub opening: Option<Opening>,
    /// The shape of the same outline in space, in the step in which it closed.
    pub opening_as_it_lies: Option<Opening>,
    /// \[rad\], at most 2π.
    pub completion: f64,
    /// Of tips, from the axis \[mm\].
    pub largest_radius: f64,
    /// Jaws closed until the end.
    pub grasps: u32,
    /// From the start to the end, or to now \[ms\].
    pub time: f64,
    /// Root mean square of the force at closed jaws \[N\].
    pub force_rms: f64,
    /// Peak of the force \[N\].
    pub force_peak: f64,
}

/// Force of one grasp on the tissue, from the closing of the jaws to their opening or to the end of the tear.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct GraspFigures {
    /// End of the first step of the grasp with closed jaws \[ms\].
    pub from: f64,
    /// End of the last step of the grasp \[ms\].
    pub until: f64,
    /// Mean of the force's amount over its steps \[N\].
    pub force_mean: f64,
    /// Root mean square of the force \[N\].
    pub force_rms: f64,
    /// Peak of the force \[N\].
    pub force_peak: f64,
    samples: u64,
}

impl GraspFigures {
    fn take(&mut self, time: f64, force: f64) {
        let count = self.samples as f64;
        self.force_mean = (self.force_mean * count + force) / (count + 1.0);
        self.force_rms = ((self.force_rms * self.force_rms * count + force * force) / (count + 1.0)).sqrt();
        self.force_peak = self.force_peak.max(force);
        self.until = time;
        self.samples += 1;
    }
}

/// Follows the tears of one body from its present state on.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct TearCourse {
    body: BodyId,
    axis: Axis,
    rim: Vec<DVec3>,
    start: f64,
    /// Angles passed \[rad\], and that of every tip alive.
    passed: [f64; 2],
    tips: Vec<(TipKey, f64, DVec3)>,
    /// Tips at flaps' inner ends.
    inner_ends: Vec<TipKey>,
    squares: f64,
    samples: u64,
    grasps: Vec<GraspFigures>,
    /// Jaws that are closed, and which grasp it is.
    closed: Vec<(u64, usize)>,
    figures: CourseFigures,
}

impl TearCourse {
    /// Begins with the body as it is, after its first cuts or before, at a time \[ms\]. `None` for a body without a rim.
    pub fn new(world: &World, body: BodyId, time: f64) -> Option<Self> {
        let mut query = world.query_one::<(&Vertices, &Triangles, &Topology)>(body.entity());
        let (vertices, triangles, topology) = query.get().ok()?;
        let outline = |rows: &[u32]| rows.iter().map(|&v| vertices.rest_position[v as usize]).collect::<Vec<_>>();
        let rows = boundary_loops(triangles, topology);
        let loops: Vec<Vec<DVec3>> = rows.iter().map(|rows| outline(rows)).collect();
        let rim = (0..loops.len()).max_by(|&a, &b| area_within(&loops[a]).total_cmp(&area_within(&loops[b])))?;
        let axis = Axis::from_outline(&loops[rim])?;
        let mut course = Self {
            body,
            axis,
            rim: loops[rim].clone(),
            start: time,
            passed: [f64::INFINITY, f64::NEG_INFINITY],
            tips: Vec::new(),
            inner_ends: Vec::new(),
            squares: 0.0,
            samples: 0,
            grasps: Vec::new(),
            closed: Vec::new(),
            figures: CourseFigures::default(),
        };
        for slit in loops.iter().enumerate().filter(|(i, _)| *i != rim).map(|(_, slit)| slit) {
            let mut last = None;
            slit.iter().for_each(|&point| last = Some((course.pass(last, point), point)));
        }
        if let Ok(tips) = world.get::<&Tips>(body.entity()) {
            let radius = |v: u32| axis.offset(vertices.rest_position[v as usize]).length();
            let alive = || tips.keys().iter().zip(&tips.vertex);
            alive().for_each(|(&key, &v)| course.begin(key, vertices.rest_position[v as usize]));
            for slit in rows.iter().enumerate().filter(|(i, _)| *i != rim).map(|(_, slit)| slit) {
                let farthest = slit.iter().map(|&v| radius(v)).fold(0.0, f64::max);
                let mut inner = alive().filter(|(_, v)| slit.contains(v) && radius(**v) < INNER * farthest);
                if let (Some((&key, _)), None) = (inner.next(), inner.next()) {
                    course.inner_ends.push(key);
                }
            }
        }
        Some(course)
    }

    /// Takes a step in: the events that it has left, and the world after it. Nothing counts any more once the tear has ended.
    pub fn note(&mut self, world: &World, time: f64, events: &[Event]) {
        if self.figures.outcome != Outcome::Unfinished {
            return;
        }
        self.figures.time = time - self.start;
        if let Ok(grips) = world.get::<&Grips>(self.body.entity()) {
            self.figures.grasps = grips.grasp_count;
            self.note_grasps(&grips, time);
            self.figures.force_rms = (self.squares / self.samples.max(1) as f64).sqrt();
        }
        let body = self.body;
        for event in events.iter().filter(|event| event.body == body) {
            match &event.kind {
                EventKind::Started { tip, at, .. } => self.begin(*tip, *at),
                EventKind::Advanced { tip, to, .. } => self.go_on(*tip, *to),
                EventKind::Ended { tip, at, .. } if self.is_on_rim(*at) => {
                    let is_flap = self.inner_ends.contains(tip);
                    self.figures.outcome = if is_flap { Outcome::TornOff } else { Outcome::RanOut };
                    self.note_radius(*at);
                }
                EventKind::FragmentFreed { .. } => self.look_for_opening(world),
                _ => {}
            }
        }
    }

    /// The body.
    pub fn body(&self) -> BodyId {
        self.body
    }

    /// The figures up to now.
    pub fn figures(&self) -> CourseFigures {
        let passed = (self.passed[1] - self.passed[0]).clamp(0.0, TAU);
        let completion = if self.figures.outcome == Outcome::Closed { TAU } else { passed };
        CourseFigures { completion, ..self.figures }
    }

    /// The grasps up to now, in the order in which jaws have closed.
    pub fn grasps(&self) -> &[GraspFigures] {
        &self.grasps
    }

    /// The axis around which angles and radii are measured.
    pub fn axis(&self) -> Axis {
        self.axis
    }

    /// Takes in the force at every pair of closed jaws.
    fn note_grasps(&mut self, grips: &Grips, time: f64) {
        // Grips stand first and keep their place; a handle of forceps is never as small as that.
        let jaws = |(row, pinch): (usize, &Pinch)| {
            (pinch.forceps.map_or(row as u64, |f| f.entity().to_bits().get()), pinch.force.length())
        };
        let closed = || grips.pinches.iter().enumerate().filter(|(_, pinch)| pinch.is_closed()).map(jaws);
        self.closed.retain(|(key, _)| closed().any(|(other, _)| other == *key));
        for (key, force) in closed() {
            self.squares += force * force;
            self.samples += 1;
            self.figures.force_peak = self.figures.force_peak.max(force);
            let known = self.closed.iter().find(|(other, _)| *other == key).map(|&(_, grasp)| grasp);
            let grasp = known.unwrap_or_else(|| {
                self.closed.push((key, self.grasps.len()));
                self.grasps.push(GraspFigures { from: time, ..GraspFigures::default() });
                self.grasps.len() - 1
            });
            self.grasps[grasp].take(time, force);
        }
    }

    fn look_for_opening(&mut self, world: &World) {
        let mut query = world.query_one::<(&Vertices, &Triangles, &Topology)>(self.body.entity());
        let Ok((vertices, triangles, topology)) = query.get() else { return };
        // It lies around the axis where its centroid is nearer to that than its own radius.
        let openings = Opening::of_body(vertices, triangles, topology, &self.axis);
        if let Some((opening, outline)) = openings.into_iter().find(|(o, _)| o.decentration < 0.5 * o.diameter) {
            self.figures.opening = Some(opening);
            let present: Vec<DVec3> = outline.iter().map(|&v| vertices.position[v as usize]).collect();
            self.figures.opening_as_it_lies = Opening::from_outline(&present, &self.axis);
            self.figures.outcome = Outcome::Closed;
        }
    }

    fn begin(&mut self, tip: TipKey, at: DVec3) {
        let angle = self.pass(None, at);
        self.tips.push((tip, angle, at));
        self.note_radius(at);
    }

    fn go_on(&mut self, tip: TipKey, to: DVec3) {
        let last = self.tips.iter().position(|(key, ..)| *key == tip);
        let angle = self.pass(last.map(|i| (self.tips[i].1, self.tips[i].2)), to);
        match last {
            Some(i) => self.tips[i] = (tip, angle, to),
            None => self.tips.push((tip, angle, to)),
        }
        self.note_radius(to);
    }

    /// Counts in the angle of a point and returns it: continued from the one before it, else the nearest to the angles already passed.
    fn pass(&mut self, last: Option<(f64, DVec3)>, point: DVec3) -> f64 {
        let offset = self.axis.offset(point);
        let angle = match last {
            Some((angle, before)) => angle + self.axis.turn(self.axis.offset(before), offset),
            None => {
                let zero = self.axis.direction.any_orthonormal_vector();
                let angle = self.axis.turn(zero, offset);
                let middle = 0.5 * (self.passed[0] + self.passed[1]);
                if middle.is_finite() { angle - TAU * ((angle - middle + PI) / TAU).floor() } else { angle }
            }
        };
        self.passed = [self.passed[0].min(angle), self.passed[1].max(angle)];
        angle
    }

    fn note_radius(&mut self, point: DVec3) {
        self.figures.largest_radius = self.figures.largest_radius.max(self.axis.offset(point).length());
    }

    fn is_on_rim(&self, point: DVec3) -> bool {
        let ends = self.rim.iter().zip(self.rim.iter().cycle().skip(1));
        let distance = |(&a, &b): (&DVec3, &DVec3)| {
            let along = ((point - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
            point.distance(a.lerp(b, along))
        };
        let size = self.axis.offset(self.rim[0]).length();
        ends.map(distance).fold(f64::INFINITY, f64::min) <= ON_RIM * size
    }
}
