//! Absurd values in every component, by every way in: no panic, nothing that is not finite comes out, and the last good state stays.
#![cfg(feature = "snapshot")]

use glam::{DMat3, DQuat, DVec3};
use rhexis::components::*;
use rhexis::generate;
use rhexis::math::{StiffeningFibres, Sym2};
use rhexis::membrane::Membrane;
use rhexis::replay::Recording;
use rhexis::settings::{Advanced, Settings};
use rhexis::simulation::{Parameter, Simulation, SimulationError, Solid};
use rhexis::snapshot::Snapshot;
use rhexis::storage::{Attached, TipRow, Tips, Triangles, Vertices};

/// SplitMix64 (Steele, Lea, Flood 2014).
struct Dice(u64);

impl Dice {
    fn below(&mut self, count: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % count as u64) as usize
    }

    /// Every other one is ordinary, so that one wrong number is met among right ones.
    fn number(&mut self) -> f64 {
        const ABSURD: [f64; 12] =
            [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0, 0.0, -0.0, 1e308, -1e308, 1e-308, 1e150, 1e12, 1e-12];
        const ORDINARY: [f64; 4] = [1.0, 0.5, 0.1, 1e-3];
        if self.below(2) == 0 { ABSURD[self.below(ABSURD.len())] } else { ORDINARY[self.below(ORDINARY.len())] }
    }

    fn some(&mut self) -> Option<f64> {
        (self.below(3) > 0).then(|| self.number())
    }

    fn point(&mut self) -> DVec3 {
        DVec3::new(self.number(), self.number(), self.number())
    }

    /// Mostly rows of the body's 20 vertices.
    fn row(&mut self) -> u32 {
        [0, 1, 7, 12, 19, 20, 99, u32::MAX][self.below(8)]
    }

    fn rows(&mut self) -> Vec<u32> {
        (0..self.below(4)).map(|_| self.row()).collect()
    }

    fn attached<T: rhexis::storage::Attachment>(&mut self, value: impl Fn(&mut Self) -> T) -> Attached<T> {
        let rows = self.rows();
        let members: Vec<(u32, T)> = rows.into_iter().map(|row| (row, value(self))).collect();
        Attached::new(members)
    }

    fn curve(&mut self) -> Curve {
        Curve::constant(self.number())
    }

    fn jaws(&mut self) -> Jaws {
        let slip = if self.below(2) == 0 { Slip::LetGo } else { Slip::Slide };
        Jaws { radius: self.number(), stiffness: self.some(), force_limit: self.some(), slip }
    }

    fn pose(&mut self) -> Pose {
        let orientation = [DQuat::IDENTITY, DQuat::from_xyzw(self.number(), 0.0, 0.0, 1.0)][self.below(2)];
        Pose { position: self.point(), orientation }
    }

    fn path(&mut self) -> Path {
        Path { points: (0..self.below(3)).map(|_| (self.number(), self.point())).collect() }
    }

    fn shape(&mut self) -> Shape {
        match self.below(4) {
            0 => Shape::Plane { point: self.point(), normal: [DVec3::Z, self.point()][self.below(2)] },
            1 => Shape::Sphere { centre: self.point(), radius: self.number() },
            2 => {
                let (centre, half_axes) = (self.point(), self.point());
                let axes = if half_axes.x < 0.5 { DMat3::from_diagonal(half_axes) } else { DMat3::IDENTITY };
                Shape::Ellipsoid { centre, half_axes, axes }
            }
            _ => Shape::Capsule { ends: [self.point(), self.point()], radius: self.number() },
        }
    }

    fn grips(&mut self) -> Grips {
        let grip = |dice: &mut Self| Grip {
            name: "grip".into(),
            from: dice.number(),
            until: dice.number(),
            material_point: dice.point(),
            near_tip: (dice.below(2) == 0).then(|| NearTip {
                behind: dice.number(),
                left: dice.number(),
                axis: dice.point(),
                heading: dice.point(),
            }),
            jaws: dice.jaws(),
            path: dice.path(),
            turns: dice.path(),
        };
        let mut grips = Grips::new((0..self.below(3)).map(|_| grip(self)).collect());
        if self.below(2) == 0 {
            let held = self.attached(Self::point);
            grips.pinches.push(Pinch { held, jaws: self.jaws(), origin: self.pose(), ..Pinch::default() });
        } else if self.below(3) == 0 {
            grips.pinches.clear();
        }
        grips
    }

    fn hold(&mut self) -> Hold {
        let axes = [true, self.below(2) == 0, self.below(2) == 0];
        Hold { name: "hold".into(), members: self.attached(Self::point), axes, curve: self.curve() }
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Way {
    Set,
    World,
    Entity,
}

/// Puts a component in; whether that was refused at once.
fn put<C: Parameter>(s: &mut Simulation, entity: hecs::Entity, way: Way, component: C) -> bool {
    match way {
        Way::Set => return s.set(entity, component).is_err(),
        Way::World => s.world_mut().insert_one(entity, component).unwrap(),
        Way::Entity => match s.entity_mut::<&mut C>(entity) {
            Ok(there) => *there = component,
            Err(_) => return s.set(entity, component).is_err(),
        },
    }
    false
}

/// Number of kinds of [`absurd`].
const KINDS: usize = 22;

/// Puts something absurd in; whether that was refused at once.
fn absurd(kind: usize, s: &mut Simulation, actors: [hecs::Entity; 4], way: Way, d: &mut Dice) -> bool {
    let [body, obstacle, forceps, blade] = actors;
    match kind {
        0 => {
            let groups = (0..d.below(3)).map(|_| d.hold()).collect();
            put(s, body, way, Holds { groups })
        }
        1 => {
            let anchors = d.attached(|d| Anchor::new(d.point(), d.number()));
            put(s, body, way, Springs { anchors })
        }
        2 => {
            let grips = d.grips();
            put(s, body, way, grips)
        }
        3 => {
            let groups = vec![PointLoad { rows: d.rows(), force: d.point(), curve: d.curve() }];
            put(s, body, way, PointLoads { groups })
        }
        4 => {
            let edges = (0..d.below(3)).map(|_| [d.row(), d.row()]).collect();
            put(s, body, way, EdgeLoads { groups: vec![EdgeLoad { edges, traction: d.point(), curve: d.curve() }] })
        }
        5 => put(s, body, way, Damping { time: d.number() }),
        6 => put(s, body, way, Gravity { acceleration: d.point() }),
        7 => put(s, body, way, Pressure { curve: d.curve() }),
        8 => put(s, body, way, Drag { coefficient: d.number() }),
        9 => put(s, body, way, PreStretch { strain: Sym2 { xx: d.number(), yy: d.number(), xy: d.number() } }),
        10 => put(s, body, way, StiffeningFibres { k1: d.number(), k2: d.number() }),
        11 => {
            let self_contact = d.some().map(|radius| SelfContact { radius, band: d.some() });
            let between_bodies = self_contact.is_some() && d.below(2) == 0;
            put(s, body, way, Contact { stiffness: d.some(), friction: d.number(), self_contact, between_bodies })
        }
        12 => put(s, body, way, Bending { stiffness: d.some() }),
        13 => {
            let tearing = Tearing {
                strength_across_fibres: d.number(),
                strength_along_fibres: d.number(),
                exponent: d.number(),
                cone: d.number(),
                radius: d.number(),
                may_initiate: d.below(2) == 0,
                ..Tearing::default()
            };
            put(s, body, way, tearing)
        }
        14 => {
            let toughness = Toughness { along: d.number(), across: d.number() };
            put(s, body, way, EnergyCriterion { toughness, ring: d.number() })
        }
        15 => {
            let (edges_per_radius, margin, budget) = (d.number(), d.some(), d.number());
            put(s, body, way, Refinement { edges_per_radius, margin, budget, may_coarsen: d.below(2) == 0 })
        }
        16 => put(s, body, way, Sleeping { strain: d.number(), steps: d.row(), ..Sleeping::default() }),
        17 => put(s, obstacle, way, Obstacle { shape: d.shape() }),
        18 => {
            let (origin, path) = (d.shape(), d.path());
            let turn = |path: &Path| Turning { pivot: path.points[0].1, vectors: path.clone() };
            let turning = (path.points.len() == 1).then(|| turn(&path));
            put(s, obstacle, way, ObstaclePath { origin, path, turning })
        }
        19 => {
            let motion = Motion { from: d.pose(), to: d.pose(), start: d.number(), end: d.number() };
            put(s, forceps, way, Forceps { jaws: d.jaws(), motion, ..Forceps::default() })
        }
        20 => put(s, blade, way, Blade { reach: d.number(), least: d.number(), from: d.point(), ..Blade::default() }),
        _ => {
            state(s, body, d);
            false
        }
    }
}

/// Absurd state, for which there is one way only.
fn state(s: &mut Simulation, body: hecs::Entity, d: &mut Dice) {
    let at = d.below(20);
    match d.below(9) {
        0 => s.entity_mut::<&mut Vertices>(body).unwrap().position[at] = d.point(),
        1 => s.entity_mut::<&mut Vertices>(body).unwrap().velocity[at] = d.point(),
        2 => s.entity_mut::<&mut Vertices>(body).unwrap().mass[at] = d.number(),
        3 => drop(s.entity_mut::<&mut Vertices>(body).unwrap().position.pop()),
        4 => s.entity_mut::<&mut Triangles>(body).unwrap().corners[at] = [d.row(), d.row(), d.row()],
        5 => {
            let mut tips = Tips::default();
            tips.push(TipRow {
                vertex: d.row(),
                previous: d.point(),
                ideal: d.point(),
                criterion: d.number(),
                fall: d.number(),
                is_refused: false,
                is_coarse: false,
            });
            s.world_mut().insert_one(body, tips).unwrap();
        }
        6 => {
            let forces = StepForces { list: vec![(d.row(), d.point())] };
            s.world_mut().insert_one(body, forces).unwrap();
        }
        7 => s.world_mut().insert(body, (Frames::default(), Forces::default(), Reactions::default())).unwrap(),
        _ => {
            let swept = ObstacleMotion::at(d.shape());
            s.world_mut().insert_one(body, swept).unwrap();
        }
    }
}

fn good() -> (Simulation, [hecs::Entity; 4]) {
    let mut s = Simulation::new(Settings {
        threads: 1,
        advanced: Advanced { max_step_halvings: 2, ..Advanced::default() },
        ..Settings::default()
    })
    .unwrap();
    let sheet = Membrane::new("sheet", generate::grid(4.0, 3.0, 4, 3).unwrap(), Material::allard_2009());
    let members = Attached::new(sheet.select(|p| p.x == 0.0).into_iter().map(|row| (row, DVec3::X)));
    let hold = Hold { name: "left".into(), members, axes: [true; 3], curve: Curve::ramp(10.0, 0.1).unwrap() };
    let sheet = sheet.hold(hold).with(Tearing { radius: 1.0, ..Tearing::default() }).with(Contact::default());
    let body = s.spawn(sheet).unwrap();
    let below = Shape::Sphere { centre: DVec3::new(2.0, 1.5, -2.0), radius: 1.9 };
    let path = Path { points: vec![(0.0, DVec3::ZERO), (100.0, DVec3::Z)] };
    let obstacle = s.spawn_obstacle(Solid::new(below).path(path)).unwrap();
    let forceps = s.spawn_forceps("forceps", Jaws { radius: 0.5, ..Jaws::default() }, Pose::at(DVec3::X)).unwrap();
    let blade = s.spawn_blade(0.5, 0.5).unwrap();
    s.cut(body, &[DVec3::new(2.0, 0.0, 0.0), DVec3::new(2.0, 1.0, 0.0)]).unwrap();
    (0..3).for_each(|_| _ = s.step(2.0).unwrap());
    (s, [body.entity(), obstacle.entity(), forceps.entity(), blade.entity()])
}

/// All that a host reads of a body.
fn read(s: &mut Simulation, body: hecs::Entity) -> (String, bool) {
    let view = s.view(body.into()).unwrap();
    let is_finite = view.positions.iter().chain(view.velocities).all(|x| x.is_finite());
    let mut text = format!("{:?} {:?} {:?}", view.positions, view.velocities, view.triangles);
    text += &format!(" {:?} {}", s.reactions(body.into()).unwrap(), s.time());
    (text, is_finite)
}

fn try_all(seed: u64, cases: usize, is_recorded: bool) -> [usize; 3] {
    let (mut s, actors) = good();
    let start = s.snapshot();
    let body = actors[0];
    let mut dice = Dice(seed);
    let [mut at_once, mut later, mut accepted] = [0; 3];
    if is_recorded {
        s.record();
    }
    for case in 0..cases {
        s.restore(&start).unwrap();
        let (before, _) = read(&mut s, body);
        let way = [Way::Set, Way::World, Way::Entity][dice.below(3)];
        let kind = case % KINDS;
        if absurd(kind, &mut s, actors, way, &mut dice) {
            at_once += 1;
            assert_eq!(read(&mut s, body).0, before, "case {case}: refused, and something has changed");
            assert!(!s.step(2.0).unwrap().has_failed, "case {case}");
            continue;
        }
        let written = read(&mut s, body).0;
        match s.step(2.0).map(|report| report.has_failed) {
            Err(SimulationError::Written(refused)) => {
                later += 1;
                assert!(way != Way::Set || kind == KINDS - 1, "case {case}: accepted by set, then {refused}");
                assert_eq!(read(&mut s, body).0, written, "case {case}: {refused}");
                let _ = (s.settle(1.0, 1e-6).is_err(), s.energies(body.into()), s.frame(), s.snapshot().to_bytes());
                assert_eq!(read(&mut s, body).0, written, "case {case}: {refused}");
            }
            Err(error) => panic!("case {case}: {error}"),
            Ok(_) => {
                accepted += 1;
                for _ in 0..2 {
                    let (told, stood) = (s.reactions(body.into()).unwrap(), read(&mut s, body).0);
                    let has_failed = s.step(2.0).unwrap().has_failed;
                    assert!(read(&mut s, body).1, "case {case}: not finite");
                    let energies = s.energies(body.into()).unwrap();
                    assert!(
                        has_failed || (energies.elastic + energies.kinetic).is_finite(),
                        "case {case}: {energies:?}"
                    );
                    // A failed step leaves the reactions of the last good state: of its last good part, if there was one.
                    let reactions = s.reactions(body.into()).unwrap();
                    assert!(reactions.iter().all(|(_, force)| force.is_finite()), "case {case}");
                    let has_moved = read(&mut s, body).0 != stood;
                    assert!(
                        !has_failed || has_moved || reactions == told,
                        "case {case}: {reactions:?}, before {told:?}"
                    );
                }
                let _ = (s.settle(1.0, 1e-6).is_err(), s.frame());
                assert!(read(&mut s, body).1, "case {case}: not finite after a static solve");
            }
        }
    }
    if is_recorded {
        let end = s.end_recording().unwrap();
        let recording = Recording::from_bytes(&end.to_bytes().unwrap()).unwrap();
        assert_eq!(recording.replay().unwrap().hash(), recording.end());
    }
    [at_once, later, accepted]
}

#[test]
fn absurd_values_are_refused_or_contained() {
    let [at_once, later, accepted] = try_all(1, 1500, false);
    // All three ends are met often.
    assert!(at_once > 150 && later > 300 && accepted > 100, "{at_once} {later} {accepted}");
}

#[test]
fn absurd_values_are_repeated_by_recordings() {
    try_all(2, 200, true);
}

#[test]
fn a_recording_with_rows_that_are_not_there_is_refused_where_it_was() {
    let (mut s, [body, ..]) = good();
    s.record();
    s.entity_mut::<&mut Holds>(body).unwrap().groups[0].members = Attached::new([(777, DVec3::X)]);
    assert!(s.step(1.0).is_err());
    // Nobody mends it: all that follows is refused here and there.
    assert!(
        s.reorder(body.into()).is_err() && s.unpin_all(body.into(), "left").is_err() && s.settle(1.0, 1e-9).is_err()
    );
    assert!(s.cut(body.into(), &[DVec3::new(0.0, 1.5, 0.0), DVec3::new(1.0, 1.5, 0.0)]).is_err());
    let recording = s.end_recording().unwrap();
    let recording = Recording::from_bytes(&recording.to_bytes().unwrap()).unwrap();
    assert_eq!(recording.replay().unwrap().hash(), s.hash());
}

#[test]
fn a_state_that_could_not_be_read_again_is_not_written() {
    let (mut s, [body, ..]) = good();
    s.set(body, Refinement::default()).unwrap();
    s.step(1.0).unwrap();
    s.world_mut().remove_one::<Tearing>(body).unwrap();
    let error = s.snapshot().to_bytes().unwrap_err().to_string();
    assert!(error.contains("`sheet`") && error.contains("refinement"), "{error}");
    assert!(s.step(1.0).is_err());
    s.record();
    let error = s.end_recording().unwrap().to_bytes().unwrap_err().to_string();
    assert!(error.contains("refinement"), "{error}");
    s.unset::<Refinement>(body).unwrap();
    s.step(1.0).unwrap();
    Snapshot::from_bytes(&s.snapshot().to_bytes().unwrap()).unwrap();
}
