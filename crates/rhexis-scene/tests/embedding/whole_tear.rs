//! A whole tear, repeated from a file: a capsulorhexis that a scripted hand has closed by four grasps.
//!
//! The recording takes no Cholesky factor, so that every build leads to the same bits on every machine.
#![cfg(feature = "snapshot")]

use glam::{DMat2, DVec2, DVec3};
use rhexis::components::{
    Bending, Contact, Curve, Damping, Drag, EnergyCriterion, Fibres, Hold, Jaws, Material, Obstacle, Pose, PreStretch,
    Refinement, Shape, TearLog, Tearing, Toughness,
};
use rhexis::event::{Event, EventKind};
use rhexis::generate;
use rhexis::math::{Sym2, elementary};
use rhexis::membrane::Membrane;
use rhexis::replay::Recording;
use rhexis::settings::{Advanced, Preconditioner, Settings};
use rhexis::simulation::{Grasp, Simulation};
use rhexis::storage::Attached;
use rhexis::storage::BodyId;
use rhexis_scene::measures::{Outcome, TearCourse};
use std::path::{Path, PathBuf};

/// With this in the environment, the hand tears again, and both files are written.
const UPDATE: &str = "RHEXIS_UPDATE_GOLDEN";

const HOW: &str = "If the change of the numbers is meant, record the tear anew and say in the commit why they change:
    RHEXIS_UPDATE_GOLDEN=1 cargo test --release -p rhexis-scene --test embedding whole_tear
If it is not meant, it is a bug: bisect it.";

/// Time step \[ms\].
const DT: f64 = 20.0;
/// Steps of the pause before a grasp, of the lift and of the arc.
const PAUSE: u32 = 6;
const LIFT: u32 = 10;
const ARC: u32 = 120;
/// Steps between two calls of the hand.
const PACE: u32 = 5;
/// Height \[mm\] and angle \[°\] by which the flap is drawn.
const HEIGHT: f64 = 0.5;
const ANGLE: f64 = 210.0;
/// Distance of the grasp from the tip \[mm\], and its directions \[°\] from inwards to backwards: the first with tissue is taken.
const REACH: f64 = 0.6;
const WAYS: [f64; 5] = [45.0, 22.0, 0.0, -22.0, -45.0];
/// Most grasps.
const GRASPS: u32 = 8;
/// Radius of curvature, radius of the rim and radius of the tear \[mm\].
const CURVATURE: f64 = 10.0;
const RIM: f64 = 4.9;
const TEAR: f64 = 2.65;

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/embedding/data").join(name)
}

/// A taut capsule on its lens, held at its rim, with a puncture that has left a short flap.
fn capsule() -> (Simulation, BodyId) {
    let advanced = Advanced { preconditioner: Preconditioner::IncompleteCholesky, ..Advanced::default() };
    let settings = Settings { threads: 1, advanced, ..Settings::default() };
    let mut simulation = Simulation::new(settings).unwrap();
    let mesh = generate::cap(CURVATURE, 2.0 * RIM, 500).unwrap();
    let material = Material {
        young_fibre: 3.0,
        young_transverse: 3.0,
        poisson_major: 0.45,
        shear_modulus: None,
        thickness: 0.015,
        density: 1e-3,
    };
    let toughness = Toughness { along: 0.7, across: 1.2 };
    let tearing = Tearing::from_toughness(toughness, &material.stiffness().unwrap(), 0.5).unwrap();
    let capsule = Membrane::new("capsule", mesh, material)
        .fibres(Fibres::Concentric { centre: DVec3::ZERO, axis: DVec3::Z })
        .with(PreStretch { strain: Sym2 { xx: 0.08, yy: 0.08, xy: 0.0 } })
        .with(Damping { time: 1.0 })
        .with(Drag { coefficient: 5e-3 })
        .with(Contact { stiffness: Some(5.0), friction: 0.0, ..Contact::default() })
        .with(Bending::default())
        .with(Tearing { cone: 60_f64.to_radians(), ..tearing })
        .with(EnergyCriterion::new(toughness))
        .with(Refinement { edges_per_radius: 2.0, budget: 2.5, ..Refinement::default() });
    let rim = capsule.select(|p| p.truncate().length() > 0.998 * RIM).into_iter().map(|row| (row, DVec3::ZERO));
    let members = Attached::new(rim);
    let capsule = capsule.hold(Hold { name: "rim".into(), members, axes: [true; 3], curve: Curve::constant(0.0) });
    let body = simulation.spawn(capsule).unwrap();
    let lens = Shape::Sphere { centre: DVec3::NEG_Z * CURVATURE, radius: CURVATURE };
    simulation.spawn_obstacle(Obstacle { shape: lens }).unwrap();
    // Outwards, then round by 30° and inwards by 0.05 mm, so that the tear comes back inside of its beginning.
    let at = |degrees: f64, radius: f64| {
        let out = elementary::unit_at(degrees.to_radians()) * radius;
        out.extend((CURVATURE * CURVATURE - radius * radius).sqrt() - CURVATURE)
    };
    let round = (0..=6).map(f64::from).map(|i| at(5.0 * i, TEAR - 0.05 * i / 6.0));
    let cut: Vec<DVec3> = [at(0.0, 1.2), at(0.0, 2.0)].into_iter().chain(round).collect();
    simulation.cut(body, &cut).unwrap();
    (simulation, body)
}

/// A tear and the hand that draws it.
struct Hand {
    simulation: Simulation,
    body: BodyId,
    course: TearCourse,
    /// Position of the tip that is followed \[mm\].
    tip: DVec3,
}

impl Hand {
    fn new((simulation, body): (Simulation, BodyId)) -> Self {
        let course = TearCourse::new(simulation.world(), body, simulation.time()).unwrap();
        let tips = simulation.tips(body).unwrap().into_iter().map(|tip| tip.position);
        // The tear begins on the circle, the puncture inside of it.
        let out = |tip: &DVec3| tip.truncate().length();
        let tip = tips.max_by(|a, b| out(a).total_cmp(&out(b))).unwrap();
        Self { simulation, body, course, tip }
    }

    /// Steps; returns whether the tear has ended.
    fn step(&mut self) -> bool {
        assert!(!self.simulation.step(DT).unwrap().has_failed);
        let events: Vec<Event> = self.simulation.drain_events().collect();
        self.course.note(self.simulation.world(), self.simulation.time(), &events);
        let tips = self.simulation.tips(self.body).unwrap().into_iter().map(|tip| tip.position);
        self.tip = tips.min_by(|a, b| a.distance(self.tip).total_cmp(&b.distance(self.tip))).unwrap_or(self.tip);
        self.course.figures().outcome != Outcome::Unfinished
    }

    /// Place on the flap beside the tip, seen from above.
    fn place(&self) -> DVec3 {
        let inwards = -self.tip.truncate().normalize();
        let hit = WAYS.into_iter().find_map(|degrees| {
            let way = elementary::unit_at(degrees.to_radians());
            let way = DMat2::from_cols(way, DVec2::new(-way.y, way.x)) * inwards * REACH;
            self.simulation.cast_ray(self.body, (self.tip.truncate() + way).extend(30.0), DVec3::NEG_Z, 60.0)
        });
        hit.expect("tissue beside the tip").position
    }

    /// Takes the flap beside the tip, lifts it and draws it round; returns whether the tear has ended.
    fn grasp(&mut self) -> bool {
        (0..PAUSE).for_each(|_| _ = self.step());
        let place = self.place();
        let jaws = Jaws { radius: 0.25, stiffness: Some(0.2), ..Jaws::default() };
        let forceps = self.simulation.spawn_forceps("hand", jaws, Pose::at(place)).unwrap();
        self.simulation.close_forceps(forceps, self.body, &Grasp::Nearest { reach: 0.5 }).unwrap();
        for step in 0..LIFT + ARC {
            if step % PACE == 0 {
                let next = step + PACE;
                let part = |from: u32, of: u32| (f64::from(next.saturating_sub(from)) / f64::from(of)).min(1.0);
                let turn = elementary::unit_at(part(LIFT, ARC) * ANGLE.to_radians());
                let round = DMat2::from_cols(turn, DVec2::new(-turn.y, turn.x)) * place.truncate();
                let to = round.extend(place.z + HEIGHT * part(0, LIFT));
                self.simulation.move_forceps(forceps, Pose::at(to), f64::from(PACE) * DT).unwrap();
            }
            if self.step() {
                return true;
            }
        }
        self.simulation.despawn(forceps).unwrap();
        false
    }
}

/// The tear, closed by the hand.
fn recorded() -> Recording {
    let (mut simulation, body) = capsule();
    simulation.record();
    let mut hand = Hand::new((simulation, body));
    assert!((0..GRASPS).any(|_| hand.grasp()), "the tear has not ended after {GRASPS} grasps");
    hand.simulation.end_recording().unwrap()
}

/// The recording on file, marked as one of this build.
fn on_file() -> Recording {
    /// Place in the head, and bit there, of the mark of builds with factors.
    const MARK: (usize, u8) = (10, 1);
    let mut bytes = std::fs::read(data("closed.rec")).unwrap();
    let own = if rhexis::internal::HAS_FACTORS { MARK.1 } else { 0 };
    bytes[MARK.0] = bytes[MARK.0] & !MARK.1 | own;
    Recording::from_bytes(&bytes).unwrap_or_else(|error| panic!("{error}\n{HOW}"))
}

/// The outcome of a recording that is repeated to its end, as text.
fn outcome(recording: &Recording) -> String {
    let start = Simulation::from_snapshot(recording.start()).unwrap();
    let mut course = TearCourse::new(start.world(), start.bodies()[0], start.time()).unwrap();
    assert_eq!(course.figures().outcome, Outcome::Unfinished);
    // The hash of the end is compared here.
    let mut simulation = recording.replay().unwrap_or_else(|error| panic!("{error}\n{HOW}"));
    let events: Vec<Event> = simulation.drain_events().collect();
    course.note(simulation.world(), simulation.time(), &events);
    let figures = course.figures();
    let log = simulation.world().get::<&TearLog>(start.bodies()[0].entity()).unwrap();
    let advances = events.iter().filter(|event| matches!(event.kind, EventKind::Advanced { .. })).count();
    assert_eq!(log.advance_count as usize, advances);
    format!(
        "hash {}\ntime {} ms\n{:?}, {} grasps\n{advances} advances\ntorn length {} mm\n{:?}\n",
        simulation.hash(),
        simulation.time(),
        figures.outcome,
        figures.grasps,
        log.length,
        figures.opening,
    )
}

#[test]
fn a_closed_tear_is_repeated_to_its_bits_and_outcome() {
    if std::env::var_os(UPDATE).is_some() {
        let recording = recorded();
        recording.save(data("closed.rec")).unwrap();
        std::fs::write(data("closed.txt"), outcome(&recording)).unwrap();
        return;
    }
    let then = std::fs::read_to_string(data("closed.txt")).unwrap();
    let now = outcome(&on_file());
    assert!(now.contains("Closed"), "{now}");
    assert_eq!(now, then, "{HOW}");
}
