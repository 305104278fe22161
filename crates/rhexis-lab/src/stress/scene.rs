//! A random scene of a case.

use super::dice::Dice;
use super::surface;
use glam::DVec3;
use rhexis::components::{
    Anchor, Bending, Bond, Changes, Contact, Curve, Damping, Drag, EnergyAudit, EnergyCriterion, Fibres, Gravity, Hold,
    Material, PointLoad, PointLoads, PreStretch, Pressure, Refinement, Rigid, SelfContact, Shape, Sleeping, Springs,
    TearMode, TearRate, Tearing, Toughness,
};
use rhexis::math::{Sym2, elementary};
use rhexis::membrane::Membrane;
use rhexis::settings::{Accuracy, Advanced, Integrator, LinearParams, Precision, Preconditioner, Settings, Tangent};
use rhexis::simulation::{Simulation, Solid};
use rhexis::storage::{Attached, BodyId, ObstacleId, Triangles, Vertices};
use std::f64::consts::PI;
use std::sync::Arc;

/// Iterations at the most of solves that may not take a factor.
const FEW: u32 = 100;

/// What a case begins with.
pub(super) struct Scene {
    pub simulation: Simulation,
    pub bodies: Vec<Actor>,
    pub obstacles: Vec<ObstacleId>,
    /// Nothing holds, pushes or feeds the bodies, and the engine's bound on energy applies.
    pub is_free: bool,
    /// About as long as the largest body \[mm\].
    pub size: f64,
}

/// A body of a case.
#[derive(Clone, Copy)]
pub(super) struct Actor {
    pub entity: BodyId,
    pub is_planar: bool,
}

/// Distance of a body's layers over the root of a triangle's area, where it touches itself.
const RADIUS: f64 = 0.2;

/// Traits that scenes have by their seeds.
#[derive(Clone, Copy)]
pub(super) struct Traits {
    /// Tips may glide.
    pub glides: bool,
    /// Bodies in space touch themselves.
    pub touches_itself: bool,
    /// Tissue pushes most obstacles.
    pub pushes: bool,
    /// Bodies in space touch each other; more scenes have several.
    pub meets: bool,
    /// Half of the bodies lie on beds.
    pub sticks: bool,
}

/// The scene that the dice say.
///
/// # Errors
/// What the engine refuses of it, which it should not.
pub(super) fn scene(
    dice: &mut Dice,
    threads: usize,
    Traits { glides, touches_itself, pushes, meets, sticks }: Traits,
) -> Result<Scene, String> {
    let is_free = dice.chance(0.35);
    let settings = settings(dice, threads);
    let mut simulation = Simulation::new(settings).map_err(|error| error.to_string())?;
    let mut bodies = Vec::new();
    let mut size: f64 = 0.0;
    for name in ["one", "two", "three"] {
        if bodies.is_empty() || dice.chance(if meets { 0.6 } else { 0.12 }) {
            let (membrane, is_planar, length) = membrane(name, dice, is_free, &settings);
            let entity = simulation.spawn(membrane).map_err(|error| error.to_string())?;
            if glides
                && let Ok(mut tearing) = simulation.world().get::<&mut Tearing>(entity.entity())
                && tearing.mode == TearMode::Free
            {
                tearing.mode = TearMode::Glide;
            }
            if touches_itself && !is_planar {
                let contact = simulation.world().get::<&Contact>(entity.entity()).map(|contact| *contact);
                let mean_area = simulation.world().get::<&Triangles>(entity.entity()).map_or(0.0, |triangles| {
                    triangles.rest.iter().map(|rest| rest.area).sum::<f64>() / triangles.len() as f64
                });
                let self_contact = Some(SelfContact::new(RADIUS * mean_area.sqrt()));
                let contact = Contact { self_contact, between_bodies: meets, ..contact.unwrap_or_default() };
                simulation.set(entity, contact).map_err(|error| error.to_string())?;
            }
            if sticks && dice.chance(0.5) {
                let bed = bed(dice, &simulation, entity);
                simulation.set(entity, bed).map_err(|error| error.to_string())?;
            }
            bodies.push(Actor { entity, is_planar });
            size = size.max(length);
        }
    }
    let mut obstacles = Vec::new();
    for _ in 0..if is_free { 0 } else { dice.below(3) } {
        let shape = shape(dice, size);
        let solid = match Rigid::of(&shape, if pushes { size * size * dice.decades(-7.0, 0.0) } else { 0.0 }) {
            Some(rigid) if pushes && dice.chance(0.7) => {
                let velocity = dice.point() * size * dice.decades(-5.0, -1.0);
                let acceleration = dice.point() * dice.decades(-4.0, -1.0);
                let spin = dice.point() * dice.decades(-4.0, -1.0);
                Solid::new(shape).rigid(Rigid { velocity, spin, acceleration, ..rigid })
            }
            _ => Solid::new(shape),
        };
        obstacles.push(simulation.spawn_obstacle(solid).map_err(|error| error.to_string())?);
    }
    // The invariant leaves out the energy of layers nearer than their radius.
    let is_free = is_free && !touches_itself;
    Ok(Scene { simulation, bodies, obstacles, is_free, size })
}

/// Bonds at most vertices, from some that nothing opens to some that come off at a touch.
fn bed(dice: &mut Dice, simulation: &Simulation, body: BodyId) -> Springs {
    let of_body = simulation.world().get::<&Vertices>(body.entity());
    let places = of_body.map(|vertices| vertices.position.clone()).unwrap_or_default();
    let stiffest = simulation
        .world()
        .get::<&Triangles>(body.entity())
        .map_or(1.0, |triangles| triangles.stiffness.iter().map(|law| law.q11.max(law.q22)).fold(0.0, f64::max));
    let bond = Bond::new(stiffest * dice.decades(-5.0, 0.0), stiffest * dice.decades(-6.0, 0.0));
    let stiffness = bond.usual_stiffness() * dice.decades(0.0, 2.0);
    let share = dice.between(0.2, 1.0);
    let rows = (0..).zip(places).filter(|_| dice.chance(share));
    Springs { anchors: Attached::new(rows.map(|(row, point)| (row, Anchor { point, stiffness, bond: Some(bond) }))) }
}

fn settings(dice: &mut Dice, threads: usize) -> Settings {
    let mut settings = Settings { threads, ..Settings::default() };
    settings.advanced.linear = match dice.below(6) {
        0 => LinearParams::by_residual(dice.decades(-8.0, -0.3), 2000),
        1 => LinearParams { iterations: 1 + dice.below(30) as u32, ..LinearParams::default() },
        _ => settings.advanced.linear,
    };
    if dice.chance(0.3) {
        let kinds = [Preconditioner::BlockJacobi, Preconditioner::IncompleteCholesky, Preconditioner::Multigrid];
        settings.advanced.preconditioner = kinds.get(dice.below(4)).copied().unwrap_or(Preconditioner::Cholesky);
    }
    if dice.chance(0.1) {
        settings.advanced.precision = Precision::Double;
    }
    // Without a factor what is ill-conditioned takes all the iterations there may be, and most of the time.
    if settings.advanced.precision == Precision::Double || settings.advanced.preconditioner != Preconditioner::Auto {
        settings.advanced.linear.iterations = settings.advanced.linear.iterations.min(FEW);
    }
    if dice.chance(0.2) {
        settings.advanced.max_step_halvings = dice.below(7) as u32;
        settings.max_tear_passes = dice.below(12) as u32;
    }
    if dice.chance(0.2) {
        let accurate = Settings { threads, ..Settings::new(Accuracy::Accurate) };
        let newton = Settings {
            advanced: Advanced { newton_iterations: 4, tangent: Tangent::Projected, ..settings.advanced },
            ..settings
        };
        let exact = Settings {
            advanced: Advanced {
                tangent: Tangent::Exact,
                newton_iterations: 1 + dice.below(3) as u32,
                ..settings.advanced
            },
            ..settings
        };
        settings = [accurate, newton, exact][dice.below(3)];
    }
    settings
}

fn membrane(name: &str, dice: &mut Dice, is_free: bool, settings: &Settings) -> (Membrane, bool, f64) {
    let (mut mesh, is_flat) = surface::surface(dice);
    let is_planar = is_flat && dice.chance(0.4);
    if !is_planar {
        let (turn, shift) = (dice.rotation(false), dice.point() * 10.0);
        mesh.positions.iter_mut().for_each(|x| *x = turn * *x + shift);
    }
    let (low, high) = (surface::lowest(&mesh.positions), surface::highest(&mesh.positions));
    let size = low.distance(high);
    let across = dice.decades(-2.0, 1.0);
    let ratio = dice.decades(0.0, 4.0);
    let part = if dice.chance(0.5) { dice.between(0.0, 0.9) } else { 1.0 - dice.decades(-4.0, -1.0) };
    let material = Material {
        young_fibre: across * ratio,
        young_transverse: across,
        // ν_F·ν_T < 1 with ν_T = ν_F·E_T/E_F.
        poisson_major: part * ratio.sqrt(),
        shear_modulus: Some(across * dice.decades(-1.0, 1.0)),
        thickness: dice.decades(-3.0, 1.0),
        density: 1e-3 * dice.decades(-0.5, 0.5),
    };
    let rest = mesh.positions.clone();
    let mut body = Membrane::new(name, mesh, material).fibres(match dice.below(3) {
        0 => Fibres::Uniform(dice.direction()),
        1 => Fibres::Concentric { centre: low.midpoint(high), axis: dice.direction() },
        _ => {
            let (one, other, wave) = (dice.direction(), dice.direction(), 10.0 / size);
            Fibres::Function(Arc::new(move |x| one + other * elementary::sin(wave * x.dot(one))))
        }
    });
    if is_planar {
        body = body.planar();
    }
    if dice.chance(0.65) {
        body = tearing(body, dice, across, size);
    }
    if !is_planar && dice.chance(0.3) {
        body = body.with(Bending { stiffness: dice.chance(0.5).then(|| across * dice.decades(-6.0, 0.0)) });
    }
    if dice.chance(0.4) {
        body = body.with(Damping { time: dice.decades(-3.0, 2.0) });
    }
    if dice.chance(0.3) {
        body = body.with(Drag { coefficient: dice.decades(-7.0, -1.0) });
    }
    if dice.chance(0.3) {
        body = body.with(Sleeping { strain: dice.decades(-7.0, -2.0), ..Sleeping::default() });
    }
    if dice.chance(0.2) {
        body = body.with(Changes::default());
    }
    if dice.chance(0.2) && settings.advanced.integrator == Integrator::BackwardEuler {
        body = body.with(EnergyAudit::default());
    }
    if dice.chance(0.15) {
        let [xx, yy, xy] = [(); 3].map(|()| dice.between(-0.05, 0.2));
        body = body.with(PreStretch { strain: Sym2 { xx, yy, xy } });
    }
    if !is_free {
        body = outside(body, dice, (is_planar, size), &rest, across * material.thickness);
    }
    (body, is_planar, size)
}

fn tearing(mut body: Membrane, dice: &mut Dice, young: f64, size: f64) -> Membrane {
    let radius = size * dice.decades(-1.5, -0.3);
    body = body.with(Tearing {
        strength_across_fibres: young * dice.decades(-2.0, 1.0),
        strength_along_fibres: young * dice.decades(-3.0, 0.0),
        exponent: dice.decades(-1.0, 0.5),
        cone: dice.between(0.2, PI),
        radius,
        mode: if dice.chance(0.7) { TearMode::Free } else { TearMode::Edge },
        rate: Some(dice.decades(-2.0, 2.0)).filter(|&speed| speed < 1.0).map(|speed| TearRate { speed, exponent: 1.0 }),
        may_initiate: dice.chance(0.35),
        ..Tearing::default()
    });
    if dice.chance(0.4) {
        let margin = dice.chance(0.5).then(|| radius * dice.between(0.0, 2.0));
        let (edges_per_radius, budget) = (dice.between(0.5, 6.0), dice.between(1.0, 6.0));
        body = body.with(Refinement { edges_per_radius, margin, budget, may_coarsen: dice.chance(0.7) });
    }
    if dice.chance(0.15) {
        let (along, across) = (young * radius * dice.decades(-4.0, 0.0), young * radius * dice.decades(-4.0, 1.0));
        body = body.with(EnergyCriterion { toughness: Toughness { along, across }, ring: dice.between(0.5, 4.0) });
    }
    body
}

/// What holds, pushes and draws.
fn outside(
    mut body: Membrane,
    dice: &mut Dice,
    (is_planar, size): (bool, f64),
    rest: &[DVec3],
    tension: f64,
) -> Membrane {
    let in_plane = |v: DVec3| if is_planar { v.with_z(0.0) } else { v };
    if dice.chance(0.6) {
        let way = in_plane(dice.direction());
        let along: Vec<f64> = rest.iter().map(|x| x.dot(way)).collect();
        let (least, most) = along.iter().fold((f64::MAX, f64::MIN), |(a, b), &s| (a.min(s), b.max(s)));
        let edge = 0.1 * (most - least);
        for (name, is_end) in [("far", true), ("near", false)] {
            let is_held = |s: f64| if is_end { s > most - edge } else { s < least + edge };
            let offset = in_plane(dice.point()) * size * dice.decades(-3.0, 0.5);
            let rows = along.iter().enumerate().filter(|&(_, &s)| is_held(s)).map(|(row, _)| row as u32);
            let members = Attached::new(rows.map(|row| (row, offset)));
            let curve = Curve::ramp(dice.decades(-1.0, 3.0), 1.0).unwrap_or_else(|_| Curve::constant(1.0));
            body = body.hold(Hold { name: name.into(), members, axes: [true; 3], curve });
        }
    }
    if dice.chance(0.15) {
        let anchor = |row: usize, dice: &mut Dice| {
            let point = rest[row] + in_plane(dice.point()) * 0.1 * size;
            (row as u32, Anchor::new(point, tension * dice.decades(-3.0, 3.0)))
        };
        let anchors: Vec<_> =
            (0..rest.len()).flat_map(|row| if dice.chance(0.3) { Some(anchor(row, dice)) } else { None }).collect();
        body = body.with(Springs { anchors: Attached::new(anchors) });
    }
    if dice.chance(0.2) {
        let rows = (0..rest.len() as u32).filter(|_| dice.chance(0.1)).collect();
        // Up to a hundred times what tears the tissue.
        let force = in_plane(dice.direction()) * (tension * size * dice.decades(-4.0, 2.0));
        let group = PointLoad { rows, force, curve: Curve::constant(1.0) };
        body = body.with(PointLoads { groups: vec![group] });
    }
    if dice.chance(0.25) {
        body = body.with(Gravity { acceleration: in_plane(dice.point()) * dice.decades(-3.0, 1.0) });
    }
    if !is_planar && dice.chance(0.2) {
        let most = tension / size * dice.decades(-3.0, 2.0);
        body = body.with(Pressure { curve: Curve::constant(most) });
    }
    if dice.chance(0.5) {
        let stiffness = dice.chance(0.4).then(|| tension * dice.decades(-2.0, 3.0));
        body = body.with(Contact { stiffness, friction: dice.between(0.0, 1.5), ..Contact::default() });
    }
    body
}

/// Any obstacle in a scene of this size \[mm\].
pub(super) fn shape(dice: &mut Dice, size: f64) -> Shape {
    let centre = dice.point() * size;
    let radius = size * dice.decades(-1.5, 0.3);
    match dice.below(4) {
        0 => Shape::Plane { point: centre, normal: dice.direction() },
        1 => Shape::Sphere { centre, radius },
        2 => Shape::Ellipsoid {
            centre,
            half_axes: DVec3::from_array([(); 3].map(|()| radius * dice.decades(-1.0, 0.5))),
            axes: glam::DMat3::IDENTITY,
        },
        _ => Shape::Capsule { ends: [centre, centre + dice.point() * size], radius },
    }
}
