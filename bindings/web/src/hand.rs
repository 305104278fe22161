//! The hand: forceps that take hold of what a ray meets, are drawn towards a place and let go, and a blade along a line of sight.

use glam::DVec3;
use rhexis::components::{Jaws, Pose, Slip};
use rhexis::simulation::{Grasp, Hit};
use rhexis::storage::{BodyId, ForcepsId};
use rhexis_scene::schema::{GripSpec, TimeCurve};
use rhexis_scene::{Instance, Scene};

/// Radius of the jaws in mean edges, where the scene has no grip of its own: the triangles around a vertex.
const JAWS: f64 = 1.2;

/// How far the hand goes in a step at the most, in mean edges.
const PACE: f64 = 0.5;

/// Name of the forceps in events.
const NAME: &str = "hand";

/// Forceps on a body.
#[derive(Clone, Copy, Debug)]
pub struct Held {
    /// What they hold.
    pub body: BodyId,
    /// Where they are drawn to \[mm\].
    pub target: DVec3,
    is_planar: bool,
}

/// The hand's tools.
#[derive(Clone, Debug, Default)]
pub struct Hand {
    jaws: Jaws,
    /// The most it goes in a step \[mm\].
    pace: f64,
    /// How far a ray goes \[mm\].
    reach: f64,
    forceps: Option<ForcepsId>,
    held: Option<Held>,
}

impl Hand {
    /// A hand for a scene: with the jaws of a grip, or such as go with mesh and material of its first body.
    pub fn of(scene: &Scene, grip: Option<&GripSpec>, instance: &mut Instance) -> Self {
        let (edge, size) = sizes(instance);
        let jaws = match (grip, scene.file().bodies.first()) {
            (Some(grip), _) => Jaws { radius: grip.radius, stiffness: grip.stiffness, ..Jaws::default() },
            (None, Some(body)) => {
                let material = &body.material;
                let at_start = |curve: &TimeCurve| curve.0.at(0.0);
                let young = material.young_fibre.as_ref().or(material.young.as_ref()).map(at_start);
                let modulus = young.or(material.mu.as_ref().map(|mu| 3.0 * at_start(mu)));
                // As stiff as a strip of the tissue as wide as it is long.
                let stiffness = modulus.map(|modulus| modulus * at_start(&material.thickness));
                Jaws { radius: JAWS * edge, stiffness, ..Jaws::default() }
            }
            (None, None) => Jaws { radius: JAWS * edge, ..Jaws::default() },
        };
        let jaws = Jaws { force_limit: None, slip: Slip::LetGo, ..jaws };
        Self { jaws, pace: PACE * edge, reach: 1e3 * size, forceps: None, held: None }
    }

    /// What it holds.
    pub fn held(&self) -> Option<Held> {
        self.held
    }

    /// Radius of the jaws \[mm\].
    pub fn radius(&self) -> f64 {
        self.jaws.radius
    }

    /// The place of the jaws \[mm\], while they hold something.
    pub fn place(&self, instance: &Instance) -> Option<DVec3> {
        let forceps = instance.simulation.forceps(self.forceps.filter(|_| self.held.is_some())?).ok()?;
        Some(forceps.motion.at(instance.simulation.time()).position)
    }

    /// Force on the tissue in the last step \[N\].
    pub fn force(&self, instance: &Instance) -> DVec3 {
        let forceps = self.forceps.and_then(|forceps| instance.simulation.forceps(forceps).ok());
        forceps.map_or(DVec3::ZERO, |forceps| forceps.force)
    }

    /// The first place where a ray meets a body.
    pub fn pick(&self, instance: &Instance, origin: DVec3, direction: DVec3) -> Option<(BodyId, Hit)> {
        let cast = |&body: &BodyId| Some((body, instance.simulation.cast_ray(body, origin, direction, self.reach)?));
        let hits = instance.bodies.iter().filter_map(cast);
        hits.min_by(|a, b| a.1.distance.total_cmp(&b.1.distance))
    }

    /// Takes hold of what a ray meets first; the place, or nothing where it meets none.
    ///
    /// # Errors
    /// Where what is there cannot be held.
    pub fn grip(
        &mut self,
        instance: &mut Instance,
        planar: &[bool],
        (origin, direction): (DVec3, DVec3),
    ) -> Result<Option<DVec3>, String> {
        self.open(instance);
        let Some((body, hit)) = self.pick(instance, origin, direction) else { return Ok(None) };
        let forceps = self.forceps(instance)?;
        let words = |error: rhexis::simulation::ToolError| error.to_string();
        instance.simulation.move_forceps(forceps, Pose::at(hit.position), 0.0).map_err(words)?;
        let grasp = Grasp::Ray { origin, direction, reach: self.reach };
        instance.simulation.close_forceps(forceps, body, &grasp).map_err(words)?;
        let place = instance.bodies.iter().position(|&other| other == body);
        let is_planar = place.and_then(|place| planar.get(place)).copied().unwrap_or(false);
        self.held = Some(Held { body, target: hit.position, is_planar });
        Ok(Some(hit.position))
    }

    fn forceps(&mut self, instance: &mut Instance) -> Result<ForcepsId, String> {
        let known = self.forceps.filter(|&forceps| instance.simulation.forceps(forceps).is_ok());
        let forceps = match known {
            Some(forceps) => forceps,
            None => {
                let made = instance.simulation.spawn_forceps(NAME, self.jaws, Pose::at(DVec3::ZERO));
                made.map_err(|error| error.to_string())?
            }
        };
        self.forceps = Some(forceps);
        Ok(forceps)
    }

    /// Draws what is held towards a place \[mm\]; a planar body stays in its plane. Whether anything is held.
    pub fn draw(&mut self, target: DVec3) -> bool {
        match &mut self.held {
            Some(held) if target.is_finite() => {
                let z = if held.is_planar { held.target.z } else { target.z };
                held.target = target.truncate().extend(z);
                true
            }
            _ => false,
        }
    }

    /// Lets go.
    pub fn open(&mut self, instance: &mut Instance) {
        self.held = None;
        if let Some(forceps) = self.forceps {
            // What is no forceps any more holds nothing.
            let _ = instance.simulation.open_forceps(forceps);
        }
    }

    /// Forgets what it holds, for a state in which it may hold nothing.
    pub fn forget(&mut self) {
        self.held = None;
    }

    /// Moves the jaws by their pace towards their target, within the step to come.
    pub fn drive(&mut self, instance: &mut Instance) {
        let (Some(held), Some(forceps), Some(place)) = (self.held, self.forceps, self.place(instance)) else { return };
        let next = place + (held.target - place).clamp_length_max(self.pace);
        let dt = instance.run.dt;
        // The forceps exist and the pose is finite.
        let _ = instance.simulation.move_forceps(forceps, Pose::at(next), dt);
    }

    /// Learns whether the jaws still hold something.
    pub fn look(&mut self, instance: &Instance) {
        let forceps = self.forceps.and_then(|forceps| instance.simulation.forceps(forceps).ok());
        if forceps.is_none_or(|forceps| forceps.body.is_none()) {
            self.held = None;
        }
    }

    /// Cuts a slit between the places where two rays meet the same body; its length in the rest shape \[mm\].
    ///
    /// # Errors
    /// Where they meet none or two, and where the cut is refused.
    pub fn cut(&self, instance: &mut Instance, rays: [(DVec3, DVec3); 2]) -> Result<f64, String> {
        let [from, to] = rays.map(|(origin, direction)| self.pick(instance, origin, direction));
        let (Some((body, from)), Some((other, to))) = (from, to) else {
            return Err("the cut begins or ends beside the tissue: draw it from tissue to tissue".to_owned());
        };
        if body != other {
            return Err("the cut goes from one body to another: draw it on one".to_owned());
        }
        let cut = instance.simulation.cut(body, &[from.rest_position, to.rest_position]);
        cut.map(|cut| cut.made).map_err(|error| error.to_string())
    }
}

/// Mean edge at rest and size of the first body \[mm\].
fn sizes(instance: &mut Instance) -> (f64, f64) {
    let Some(&body) = instance.bodies.first() else { return (1.0, 1.0) };
    let Ok(view) = instance.simulation.view(body) else { return (1.0, 1.0) };
    let at = |v: u32| view.rest_positions.get(v as usize).copied().unwrap_or_default();
    let edges =
        view.triangles.iter().map(|&[a, b, c]| at(a).distance(at(b)) + at(b).distance(at(c)) + at(c).distance(at(a)));
    let edge = edges.sum::<f64>() / (3 * view.triangles.len().max(1)) as f64;
    let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = view.rest_positions.iter().fold(start, |(low, high), p| (low.min(*p), high.max(*p)));
    (edge, (high - low).length())
}
