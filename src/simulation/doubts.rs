//! Likely slips in the input of a simulation: wrong units, missing holds. Nothing is refused for them.

use super::Simulation;
use crate::components::{
    Body, Contact, Curve, EdgeLoads, EnergyCriterion, Forceps, Gravity, Grips, Holds, Obstacle, ObstaclePath, Planar,
    PointLoads, Pressure, Refinement, Springs, Tearing,
};
use crate::math::edge_of_equilateral;
use crate::storage::{BodyId, Triangles, Vertices};
use glam::DVec3;
use std::collections::BTreeMap;

/// Young's modulus \[MPa\] above that of bone.
const STIFFEST: f64 = 2e4;

/// Densities \[g/mm³\] of foam and of the heaviest metal.
const DENSITIES: [f64; 2] = [1e-5, 0.025];

/// Accelerations \[mm/ms²\] of a hundredth and of ten times the earth's gravity.
const ACCELERATIONS: [f64; 2] = [9.81e-5, 9.81e-2];

/// Extents \[mm\] of a cell and of a room.
const EXTENTS: [f64; 2] = [0.1, 3000.0];

/// Thickness \[mm\] of a few layers of molecules, and the largest over the extent.
const THINNEST: f64 = 1e-4;
const THICKEST: f64 = 0.2;

/// Time steps \[ms\]: a hundredth of a frame, and half a second.
const TIME_STEPS: [f64; 2] = [0.1, 500.0];

/// Largest way of a hold per ms, over the extent of its body.
const FASTEST: f64 = 0.05;

/// Part of a run in which all of a motion is over, within some steps, and by which it outlasts the run.
const EARLY: f64 = 1.0 / 200.0;
const EARLY_STEPS: f64 = 5.0;

/// Part of the extent under which a motion is none.
const NO_MOTION: f64 = 1e-3;

/// Strength over stiffness that no tissue has.
const STRONGEST: f64 = 100.0;

/// Distance from its plane of a planar body, over the extent.
const OFF_PLANE: f64 = 1e-6;

/// A likely slip in the input of a simulation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Doubt {
    /// Kind of slip.
    pub kind: DoubtKind,
    /// The body; none where the doubt is about the whole simulation.
    pub body: Option<BodyId>,
    /// Finding and remedy in words.
    pub text: String,
}

macro_rules! kinds {
    ($($(#[$doc:meta])* $kind:ident $name:literal,)*) => {
        /// Kind of a [`Doubt`].
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[non_exhaustive]
        pub enum DoubtKind {
            $($(#[$doc])* $kind,)*
        }

        impl DoubtKind {
            /// All kinds.
            pub const ALL: &[Self] = &[$(Self::$kind,)*];

            /// Name in scene files.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$kind => $name,)*
                }
            }
        }
    };
}

kinds! {
    /// A time step far from those of a frame.
    TimeStep "time-step",
    /// A motion or load that is over in a small part of the run, or faster than a hand.
    HastyMotion "hasty-motion",
    /// A run that ends in a small part of a motion or load.
    ShortRun "short-run",
    /// A material stiffer than bone.
    Stiffness "stiffness",
    /// A density that no tissue has.
    Density "density",
    /// A gravity far from the earth's.
    Gravity "gravity",
    /// A body too small or too large for tissue.
    Size "size",
    /// A thickness that makes no membrane.
    Thickness "thickness",
    /// A planar body with vertices off its plane.
    OffPlane "off-plane",
    /// A body at rest that nothing holds, moves or loads, or that falls.
    NoHolds "no-holds",
    /// A body whose vertices are all held.
    AllHeld "all-held",
    /// A pressure above the stiffness.
    Pressure "pressure",
    /// An averaging radius below an edge, or larger than the body.
    Radius "radius",
    /// A strength far above the stiffness.
    Strength "strength",
    /// A toughness for which no body of this size tears.
    Toughness "toughness",
}

impl Simulation {
    /// Likely slips in all that the world holds, for steps of `dt` \[ms\] over a `duration` \[ms\] if that is known. Nothing is refused for them. One that
    /// several bodies share is told of the first.
    ///
    /// # Examples
    /// ```
    /// use rhexis::prelude::*;
    ///
    /// let mut simulation = Simulation::new(Settings::default())?;
    /// let material = Material { young_fibre: 10e6, ..Material::allard_2009() }; // Pa, where MPa is meant.
    /// simulation.spawn(Membrane::new("sheet", generate::grid(30.0, 25.0, 12, 10)?, material))?;
    /// let names: Vec<&str> = simulation.doubts(0.016, None).iter().map(|doubt| doubt.kind.name()).collect();
    /// assert_eq!(names, ["time-step", "stiffness", "no-holds"]);
    /// # Ok::<(), rhexis::Error>(())
    /// ```
    pub fn doubts(&self, dt: f64, duration: Option<f64>) -> Vec<Doubt> {
        let mut list = Vec::new();
        let [least, most] = TIME_STEPS;
        if dt < least || dt > most {
            let text = format!("the time step is {} ms: times are in ms, and a frame at 60 Hz is 16.7", short(dt));
            list.push(Doubt { kind: DoubtKind::TimeStep, body: None, text });
        }
        let bodies = self.bodies();
        let surroundings = Surroundings {
            course: Course { dt, duration },
            has_obstacles: self.world.query::<&Obstacle>().iter().next().is_some(),
            touching: self.world.query::<&Contact>().iter().filter(|contact| contact.between_bodies).count(),
            has_tools: self.world.query::<&Forceps>().iter().next().is_some(),
        };
        let mut largest = 0.0_f64;
        // Findings but for the name, each with its place in the list and the number of bodies after the first.
        let mut alike: BTreeMap<Finding, (usize, usize)> = BTreeMap::new();
        for &body in &bodies {
            let mut query = self.world.query_one::<Parts>(body.entity());
            let Ok(parts) = query.get() else { continue };
            let sheet = Sheet::new(parts, surroundings);
            largest = largest.max(sheet.extent);
            let name = format!("`{}`", sheet.name());
            for (kind, text) in sheet.doubts() {
                let (_, more) = alike.entry((kind, text.replacen(&name, "", 1))).or_insert((list.len(), 0));
                *more += 1;
                if *more == 1 {
                    list.push(Doubt { kind, body: Some(body), text });
                }
            }
        }
        for (place, count) in alike.into_values().filter(|(_, count)| *count > 1) {
            list[place].text.push_str(&format!("; so for {} more", count - 1));
        }
        let mut paths = self.world.query::<&ObstaclePath>();
        let mut of_obstacles: Vec<_> = paths
            .iter()
            .filter_map(|path| {
                let points: Vec<_> = path.path.points.iter().map(|(time, at)| (*time, *at)).collect();
                hasty("the path of an obstacle", &points, (largest, f64::INFINITY), surroundings.course)
            })
            .collect();
        of_obstacles.sort_unstable();
        list.extend(of_obstacles.into_iter().map(|(kind, text)| Doubt { kind, body: None, text }));
        list
    }
}

/// Time step and duration of a run \[ms\].
#[derive(Clone, Copy)]
struct Course {
    dt: f64,
    duration: Option<f64>,
}

/// Facts about the simulation around a body.
#[derive(Clone, Copy)]
struct Surroundings {
    course: Course,
    has_obstacles: bool,
    /// Number of bodies that touch others.
    touching: usize,
    has_tools: bool,
}

type Parts<'a> = (
    (&'a Body, &'a Vertices, &'a Triangles, Option<&'a Planar>),
    (Option<&'a Holds>, Option<&'a Springs>, Option<&'a Grips>, Option<&'a Contact>),
    (Option<&'a Gravity>, Option<&'a Pressure>, Option<&'a PointLoads>, Option<&'a EdgeLoads>),
    (Option<&'a Tearing>, Option<&'a EnergyCriterion>, Option<&'a Refinement>),
);

type Finding = (DoubtKind, String);

/// A body that is judged.
struct Sheet<'a> {
    parts: Parts<'a>,
    surroundings: Surroundings,
    low: DVec3,
    high: DVec3,
    /// Longest side of the box around its rest shape \[mm\].
    extent: f64,
    /// Largest stiffness \[MPa\].
    stiffness: f64,
}

impl<'a> Sheet<'a> {
    fn new(parts: Parts<'a>, surroundings: Surroundings) -> Self {
        let (_, vertices, triangles, _) = parts.0;
        let unbounded = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) = vertices.rest_position.iter().fold(unbounded, |(low, high), p| (low.min(*p), high.max(*p)));
        let stiffness = triangles.stiffness.iter().map(|law| law.q11.max(law.q22)).fold(0.0, f64::max);
        Self { parts, surroundings, low, high, extent: (high - low).max_element(), stiffness }
    }

    fn doubts(&self) -> Vec<Finding> {
        if !(self.extent > 0.0) {
            return Vec::new();
        }
        let mut list = Vec::new();
        self.matter(&mut list);
        self.shape(&mut list);
        self.support(&mut list);
        // Next to a body of a wrong size any motion is large.
        let is_in_scale = !list.iter().any(|(kind, _)| *kind == DoubtKind::Size);
        self.motion(if is_in_scale { FASTEST } else { f64::INFINITY }, &mut list);
        self.tearing(&mut list);
        list
    }

    fn name(&self) -> &str {
        &self.parts.0.0.name
    }

    fn matter(&self, list: &mut Vec<Finding>) {
        let (name, triangles) = (self.name(), self.parts.0.2);
        if self.stiffness > STIFFEST {
            list.push((
                DoubtKind::Stiffness,
                format!(
                    "body `{name}` has a stiffness of {} MPa, above that of bone: moduli are in MPa, 1e6 Pa",
                    short(self.stiffness)
                ),
            ));
        }
        let [least, most] = DENSITIES;
        if let Some(density) = triangles.density.iter().find(|density| !(least..=most).contains(*density)) {
            let text =
                format!("body `{name}` has a density of {} g/mm³: that of water is 1e-3 (1000 kg/m³)", short(*density));
            list.push((DoubtKind::Density, text));
        }
        let (gravity, pressure, ..) = self.parts.2;
        let acceleration = gravity.map_or(0.0, |gravity| gravity.acceleration.length());
        let [least, most] = ACCELERATIONS;
        if acceleration > 0.0 && !(least..=most).contains(&acceleration) {
            let text = format!("gravity on body `{name}` is {} mm/ms²: the earth's is 9.81e-3", short(acceleration));
            list.push((DoubtKind::Gravity, text));
        }
        let most = pressure.map_or(0.0, |pressure| largest(&pressure.curve));
        if most > self.stiffness {
            let text = format!(
                "the pressure on body `{name}` is up to {} MPa, above its stiffness: 1 mmHg is 1.33e-4 MPa, 1 kPa 1e-3",
                short(most)
            );
            list.push((DoubtKind::Pressure, text));
        }
    }

    fn shape(&self, list: &mut Vec<Finding>) {
        let ((_, _, triangles, planar), name) = (self.parts.0, self.name());
        let [least, most] = EXTENTS;
        if !(least..=most).contains(&self.extent) {
            let text = format!("body `{name}` is {} mm large: lengths are in mm, 1e-3 m", short(self.extent));
            list.push((DoubtKind::Size, text));
        }
        let is_odd = |thickness: &&f64| **thickness < THINNEST || **thickness > THICKEST * self.extent;
        if let Some(thickness) = triangles.thickness.iter().find(is_odd) {
            let text = format!(
                "body `{name}` is {} mm thick and {} mm large: both are in mm, 1e-3 m or 1e3 µm",
                short(*thickness),
                short(self.extent)
            );
            list.push((DoubtKind::Thickness, text));
        }
        let depth = self.high.z - self.low.z;
        if planar.is_some() && depth > OFF_PLANE * self.extent {
            let text = format!(
                "body `{name}` is planar, with vertices up to {} mm off its plane, which act as if they lay in it: move them into it, or let it leave \
                 its plane",
                short(depth)
            );
            list.push((DoubtKind::OffPlane, text));
        }
    }

    fn support(&self, list: &mut Vec<Finding>) {
        let ((_, vertices, _, planar), (holds, springs, grips, contact), name) =
            (self.parts.0, self.parts.1, self.name());
        let mut free = vec![if planar.is_some() { [true, true, false] } else { [true; 3] }; vertices.len()];
        for hold in holds.iter().flat_map(|holds| &holds.groups) {
            for row in hold.members.rows() {
                let free = &mut free[*row as usize];
                *free = std::array::from_fn(|axis| free[axis] && !hold.axes[axis]);
            }
        }
        if free.iter().all(|free| *free == [false; 3]) {
            let text = format!("every vertex of body `{name}` is held: nothing is left to move; narrow the holds");
            list.push((DoubtKind::AllHeld, text));
        }
        let is_held = holds.is_some_and(|holds| holds.groups.iter().any(|hold| !hold.members.rows().is_empty()))
            || springs.is_some_and(|springs| !springs.anchors.rows().is_empty())
            || grips.is_some_and(|grips| !grips.list.is_empty())
            || contact.is_some() && self.surroundings.has_obstacles
            || contact.is_some_and(|contact| contact.between_bodies) && self.surroundings.touching > 1
            || self.surroundings.has_tools;
        let (gravity, _, points, edges) = self.parts.2;
        let is_thrown = vertices.velocity.iter().any(|velocity| *velocity != DVec3::ZERO);
        if is_held || is_thrown || points.is_some() || edges.is_some() {
            return;
        }
        let then = if gravity.is_some() { "and it falls" } else { "and nothing moves it" };
        list.push((
            DoubtKind::NoHolds,
            format!("nothing holds body `{name}`, {then}: give it a hold, a grip, springs, an obstacle with contact or a body to rest on"),
        ));
    }

    fn motion(&self, fastest: f64, list: &mut Vec<Finding>) {
        let ((holds, _, grips, _), name) = (self.parts.1, self.name());
        let (scale, course) = ((self.extent, fastest), self.surroundings.course);
        for hold in holds.iter().flat_map(|holds| &holds.groups) {
            let farthest = hold.members.values().iter().map(|offset| offset.length()).fold(0.0, f64::max);
            let points: Vec<_> =
                hold.curve.points().iter().map(|(time, value)| (*time, DVec3::X * (value * farthest))).collect();
            list.extend(hasty(&format!("hold `{}` of body `{name}`", hold.name), &points, scale, course));
        }
        for grip in grips.iter().flat_map(|grips| &grips.list) {
            list.extend(hasty(&format!("grip `{}` of body `{name}`", grip.name), &grip.path.points, scale, course));
        }
        let (_, pressure, points, edges) = self.parts.2;
        let of_points = points.iter().flat_map(|loads| &loads.groups).map(|load| ("a point load", &load.curve));
        let of_edges = edges.iter().flat_map(|loads| &loads.groups).map(|load| ("an edge load", &load.curve));
        let loads = pressure.iter().map(|pressure| ("the pressure", &pressure.curve)).chain(of_points).chain(of_edges);
        for (load, curve) in loads {
            let scale = largest(curve).max(f64::MIN_POSITIVE);
            let points: Vec<_> = curve.points().iter().map(|(time, value)| (*time, DVec3::X * *value)).collect();
            list.extend(hasty(&format!("{load} on body `{name}`"), &points, (scale, f64::INFINITY), course));
        }
    }

    fn tearing(&self, list: &mut Vec<Finding>) {
        let ((_, _, triangles, _), (tearing, energy, refinement), name) = (self.parts.0, self.parts.3, self.name());
        let Some(tearing) = tearing else { return };
        let area = triangles.rest.iter().map(|rest| rest.area).sum::<f64>() / triangles.len().max(1) as f64;
        let edge = edge_of_equilateral(area);
        if tearing.radius < edge && refinement.is_none() {
            let text = format!(
                "the averaging radius of body `{name}` is {} mm, less than its edges ({} mm in the mean): it wants three edges; take a larger one, a \
                 finer mesh, or refine at tips",
                short(tearing.radius),
                short(edge)
            );
            list.push((DoubtKind::Radius, text));
        } else if tearing.radius > self.extent {
            let text = format!(
                "the averaging radius of body `{name}` is {} mm, more than the body's {} mm: it is in mm",
                short(tearing.radius),
                short(self.extent)
            );
            list.push((DoubtKind::Radius, text));
        }
        let strength = tearing.strength_along_fibres.min(tearing.strength_across_fibres);
        if strength > STRONGEST * self.stiffness && strength.is_finite() {
            let text = format!(
                "the strength of body `{name}` is {} MPa, {} times its stiffness: strengths are in MPa, 1e6 Pa",
                short(strength),
                short(strength / self.stiffness)
            );
            list.push((DoubtKind::Strength, text));
        }
        let toughness = energy.map_or(0.0, |energy| energy.toughness.along.min(energy.toughness.across));
        if toughness > self.stiffness * self.extent && toughness.is_finite() {
            let text = format!(
                "the toughness of body `{name}` is {} N/mm, more than its stiffness times its size: it is in N/mm, 1e3 J/m²",
                short(toughness)
            );
            list.push((DoubtKind::Toughness, text));
        }
    }
}

/// Judges a motion by its points \[ms; mm, or a load\], by its scale with the largest part of that per ms, and by the run.
fn hasty(
    name: &str,
    points: &[(f64, DVec3)],
    (scale, fastest): (f64, f64),
    Course { dt, duration }: Course,
) -> Option<Finding> {
    let (Some((first, from)), Some((last, _))) = (points.first(), points.last()) else { return None };
    let way = points.iter().map(|(_, at)| at.distance(*from)).fold(0.0, f64::max);
    if !(way > NO_MOTION * scale) {
        return None;
    }
    let is_fast = |pair: &[(f64, DVec3)]| {
        let ([(t, a), (u, b)], most) = ([pair[0], pair[1]], fastest * scale);
        a.distance(b) > most * (u - t) && a.distance(b) > fastest * scale
    };
    if let Some(pair) = points.windows(2).find(|pair| is_fast(pair)) {
        let (way, time) = (pair[0].1.distance(pair[1].1), pair[1].0 - pair[0].0);
        let text = format!("{name} moves by {} mm within {} ms: times of curves are in ms", short(way), short(time));
        return Some((DoubtKind::HastyMotion, text));
    }
    let is_early = |duration: &f64| *last > 0.0 && last - first <= (EARLY * duration).min(EARLY_STEPS * dt);
    if let Some(duration) = duration.filter(is_early) {
        let text = format!(
            "{name} has all its way within {} ms of {}: times of curves are in ms",
            short(last - first),
            short(duration)
        );
        return Some((DoubtKind::HastyMotion, text));
    }
    let duration = duration.filter(|duration| *duration < EARLY * last)?;
    let text =
        format!("{name} goes on to {} ms, and the run ends at {} ms: both are in ms", short(*last), short(duration));
    Some((DoubtKind::ShortRun, text))
}

/// Largest value of a curve, whatever its sign.
fn largest(curve: &Curve) -> f64 {
    curve.points().iter().map(|(_, value)| value.abs()).fold(0.0, f64::max)
}

/// A number to four digits.
fn short(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}
