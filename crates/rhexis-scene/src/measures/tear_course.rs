//! The course of a tear around an axis, with the hand that drew it: how far it has come, how it ended, grasps, time and force.
//!
//! | figure | definition | source |
//! |---|---|---|
//! | completion angle | range of the angle about the axis that cuts and tips have passed, at most 360°; 360° once it has closed | part of the circle done, as training simulators score an unfinished rhexis |
//! | grasps, time | jaws closed; from the start to the end of the tear | Raval 2021: experts 3.9 to 6.5 grasps, 29 to 42 s |
//! | force | RMS and peak of the force at closed jaws, over the steps until the tear's end | fibre-Bragg forceps: experts 9 mN RMS, novices 17 |
//! | force of a grasp | mean, RMS and peak of its own steps | Han 2025: 9.7 to 12.4 mN mean per grasp, peak 19 |
//! | opening as it lies | the same figures as of the opening at rest, of the outline in space when it closes | a drawn capsule shrinks from its opening |
//! | force × time | area between the force at closed jaws and a limit, where the force is above it, as a line between the ends of steps | 9 mN: Cutler et al. 2013, Invest Ophthalmol Vis Sci 54:1316 |
//! | tool path | way of closed jaws, by the ends of steps | odometers of training simulators |
//! | tremor | deviation of closed jaws above 2 Hz, RMS | Zheng et al. 2023, Transl Vis Sci Technol 12(3):32: experts 20, 24 and 12 µm by axis |
//! | zonule load | largest sum of the forces of the springs to ground that hold for ever, as a vector square to the axis: pre-stretch cancels out around the rim, and the sideways pull that tools put on them is left; the push of a lens along the axis is not in it | |
//! | spikes, optic overlap | of the outline at rest, see [`spikes`] and [`OpticOverlap`] | |
//! | largest radius | from the axis to the farthest point reached by a tip | run-out: past the zonules' insertion, or to the rim |
//!
//! A tear begins with a puncture near the axis, from which a cut leads outwards and round. The end of the cut that is left there is the
//! flap's inner end. Where it tears on, it is the flap that tears off, and no circle that is left.

use super::opening::{Axis, Opening, area_within, boundary_loops};
use super::outline::{OpticOverlap, spikes};
use super::tool_motion::{MotionSums, ToolMotion};
use glam::DVec3;
use hecs::World;
use rhexis::components::{Anchor, Grips, Pinch, Springs};
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
    /// Mean of the force \[N\].
    pub force_mean: f64,
    /// Force × time above [`Limits::force`] \[mN·s\].
    pub force_time_above: f64,
    /// Way of closed jaws \[mm\].
    pub tool_path: f64,
    /// Tremor \[mm\]; `None` where no grasp has lasted for a second.
    pub tremor: Option<f64>,
    /// Zonule load \[N\]; `None` for a body without springs that hold for ever.
    pub zonule_load: Option<f64>,
    /// Spikes of the opening, in the rest shape.
    pub spikes: Option<u32>,
    /// Overlap of the capsule with an optic of [`Limits::optic_diameter`], in the rest shape.
    pub optic: Option<OpticOverlap>,
}

/// Limits that figures of a course refer to.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
pub struct Limits {
    /// Force above which force × time counts \[N\].
    pub force: f64,
    /// Diameter of the optic \[mm\].
    pub optic_diameter: f64,
}

impl Default for Limits {
    /// 9 mN (Cutler et al. 2013) and the usual optic of 6 mm.
    fn default() -> Self {
        Self { force: 9e-3, optic_diameter: 6.0 }
    }
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

/// A pair of jaws that is closed.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "snapshot", derive(serde::Serialize, serde::Deserialize))]
struct ClosedJaws {
    key: u64,
    /// Index of the grasp.
    grasp: usize,
    /// Time \[ms\] and force \[N\] at the end of the last step.
    last: (f64, f64),
    motion: ToolMotion,
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
    closed: Vec<ClosedJaws>,
    motion: MotionSums,
    limits: Limits,
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
            motion: MotionSums::default(),
            limits: Limits::default(),
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

    /// Other limits than the usual ones.
    #[must_use]
    pub fn with_limits(self, limits: Limits) -> Self {
        Self { limits, ..self }
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
        if let Some(load) = self.springs_pull(world) {
            self.figures.zonule_load = Some(self.figures.zonule_load.map_or(load, |largest| largest.max(load)));
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
        let (tool_path, tremor) = (self.motion.path, self.motion.tremor());
        CourseFigures { completion, tool_path, tremor, ..self.figures }
    }

    /// The grasps up to now, in the order in which jaws have closed.
    pub fn grasps(&self) -> &[GraspFigures] {
        &self.grasps
    }

    /// The axis around which angles and radii are measured.
    pub fn axis(&self) -> Axis {
        self.axis
    }

    /// Takes in force and place of every pair of closed jaws.
    fn note_grasps(&mut self, grips: &Grips, time: f64) {
        // Grips stand first and keep their place; a handle of forceps is never as small as that.
        let jaws = |(row, pinch): (usize, &Pinch)| {
            let key = pinch.forceps.map_or(row as u64, |f| f.entity().to_bits().get());
            (key, pinch.force.length(), pinch.motion.at(time).position)
        };
        let closed = || grips.pinches.iter().enumerate().filter(|(_, pinch)| pinch.is_closed()).map(jaws);
        self.closed.retain(|jaws| closed().any(|(key, ..)| key == jaws.key));
        for (key, force, place) in closed() {
            self.squares += force * force;
            self.samples += 1;
            self.figures.force_mean += (force - self.figures.force_mean) / self.samples as f64;
            self.figures.force_peak = self.figures.force_peak.max(force);
            let grasp = match self.closed.iter_mut().find(|jaws| jaws.key == key) {
                Some(jaws) => {
                    let (before, last) = std::mem::replace(&mut jaws.last, (time, force));
                    let over = [last, force].map(|force| force - self.limits.force);
                    self.figures.force_time_above += (time - before) * mean_above_zero(over);
                    jaws.motion.go_on(time, place, &mut self.motion);
                    jaws.grasp
                }
                None => {
                    let (grasp, motion) = (self.grasps.len(), ToolMotion::begin(time, place));
                    self.closed.push(ClosedJaws { key, grasp, last: (time, force), motion });
                    self.grasps.push(GraspFigures { from: time, ..GraspFigures::default() });
                    grasp
                }
            };
            self.grasps[grasp].take(time, force);
        }
    }

    /// Amount square to the axis of the sum of the forces \[N\] of springs to ground, but for bonds; `None` for a body without such springs.
    fn springs_pull(&self, world: &World) -> Option<f64> {
        let mut query = world.query_one::<(&Vertices, &Triangles, &Topology, &Springs)>(self.body.entity());
        let (vertices, triangles, topology, springs) = query.get().ok()?;
        let anchors = springs.anchors.rows().iter().zip(springs.anchors.values());
        let mut zonules = anchors.filter(|(_, anchor)| anchor.bond.is_none()).peekable();
        zonules.peek()?;
        let force = |(&row, anchor): (&u32, &Anchor)| {
            let (area, _) = topology.areas_at(triangles, row);
            (anchor.point - vertices.position[row as usize]) * (anchor.stiffness * area)
        };
        Some(zonules.map(force).sum::<DVec3>().reject_from_normalized(self.axis.direction).length())
    }

    fn look_for_opening(&mut self, world: &World) {
        let mut query = world.query_one::<(&Vertices, &Triangles, &Topology)>(self.body.entity());
        let Ok((vertices, triangles, topology)) = query.get() else { return };
        // It lies around the axis where its centroid is nearer to that than its own radius.
        let openings = Opening::of_body(vertices, triangles, topology, &self.axis);
        if let Some((opening, outline)) = openings.into_iter().find(|(o, _)| o.decentration < 0.5 * o.diameter) {
            let at_rest: Vec<DVec3> = outline.iter().map(|&v| vertices.rest_position[v as usize]).collect();
            self.figures.opening = Some(opening);
            self.figures.spikes = Some(spikes(&at_rest));
            self.figures.optic = Some(OpticOverlap::from_outline(&at_rest, &self.axis, self.limits.optic_diameter));
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

/// Mean of the positive part of a line between two values.
fn mean_above_zero([from, to]: [f64; 2]) -> f64 {
    let (least, largest) = (from.min(to), from.max(to));
    if least >= 0.0 {
        0.5 * (from + to)
    } else if largest <= 0.0 {
        0.0
    } else {
        0.5 * largest * largest / (largest - least)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Document;

    /// Force × time above 9 mN of a force \[N\] over the time \[ms\], with steps of `dt` for a second.
    fn above(dt: f64, force: impl Fn(f64) -> f64) -> f64 {
        let count = (1000.0 / dt) as u32;
        let over = |step: u32| force(f64::from(step) * dt) - Limits::default().force;
        (0..count).map(|step| dt * mean_above_zero([over(step), over(step + 1)])).sum()
    }

    #[test]
    fn force_times_time_is_the_area_above_the_limit() {
        // 5 mN above the limit for a second; below and at it nothing.
        assert!((above(10.0, |_| 14e-3) - 5.0).abs() < 1e-12);
        assert_eq!((above(10.0, |_| 8e-3), above(10.0, |_| 9e-3)), (0.0, 0.0));
        // A triangle up to 18 mN: half as high and half as long above the limit, at any step that meets its top.
        let triangle = |time: f64| 18e-3 * (1.0 - (time / 500.0 - 1.0).abs());
        for dt in [500.0, 125.0, 10.0] {
            assert!((above(dt, triangle) - 0.5 * 9.0 * 0.5).abs() < 1e-12, "{}", above(dt, triangle));
        }
    }

    #[test]
    fn zonules_take_the_pull_that_shifts_the_capsule() {
        let mut document = Document::named("capsulorhexis").unwrap();
        ["bodies.0.mesh.cap.triangles=1500", "bodies.0.refinement.budget=3"]
            .iter()
            .for_each(|set| document.set(set).unwrap());
        let mut instance = document.scene().unwrap().instantiate().unwrap();
        let body = instance.bodies[0];
        let mut course = TearCourse::new(instance.simulation.world(), body, 0.0).unwrap();
        course.note(instance.simulation.world(), 0.0, &[]);
        assert_eq!(course.figures().zonule_load, Some(0.0));
        for way in [DVec3::new(0.006, -0.008, 0.0), DVec3::new(0.001, 0.0, 0.0), DVec3::new(0.0, 0.0, 0.1)] {
            let vertices = instance.simulation.entity_mut::<&mut Vertices>(body).unwrap();
            let shifted = vertices.rest_position.iter().map(|&rest| rest + way).collect();
            vertices.position = shifted;
            course.note(instance.simulation.world(), 10.0, &[]);
            // The scene's zonules have 4 N/mm in all. The largest load stays, and a push along the axis does not count. Rounding only: the axis is that of the
            // rim's area.
            let load = course.figures().zonule_load.unwrap();
            assert!((load - 4.0 * 0.01).abs() < 1e-12, "{load}");
        }
    }
}
