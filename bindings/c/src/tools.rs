//! Forceps, blade and needle, cuts, and what they point at.

use crate::pointer::{Array, In, Out, Text};
use crate::status::{Answer, Failure, RhexisStatus, call, refused};
use crate::types::*;
use crate::world::with;
use glam::DVec3;
use rhexis::components::{Jaws, Slip};
use rhexis::simulation::{Grasp, Hit};
use rhexis::storage::{BladeId, ForcepsId, VertexKey};
use slotmap::KeyData;

/// Jaws close about the point of the surface nearest to them.
pub const RHEXIS_GRASP_NEAREST: u32 = 0;
/// Jaws close about the first point of the surface on a ray.
pub const RHEXIS_GRASP_RAY: u32 = 1;
/// Jaws close about a point of the rest shape.
pub const RHEXIS_GRASP_POINT: u32 = 2;
/// Jaws close on the vertices given, and no others.
pub const RHEXIS_GRASP_VERTICES: u32 = 3;

/// The key of a vertex; bits that no key has are refused.
pub(crate) fn key(bits: u64) -> Answer<VertexKey> {
    let data = KeyData::from_ffi(bits);
    let wrong = || Failure::argument(format!("{bits:#x} is no key of a vertex: take keys from rhexis_vertex_keys"));
    (data.as_ffi() == bits).then(|| data.into()).ok_or_else(wrong)
}

pub(crate) fn keys(keys: &[u64]) -> Answer<Vec<VertexKey>> {
    keys.iter().map(|&bits| key(bits)).collect()
}

fn not_found(message: &str) -> Failure {
    Failure::new(RhexisStatus::NotFound, message)
}

/// Fills jaws with a constraint of radius 0.2 mm without a limit.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_jaws_init(jaws: Out<RhexisJaws>) -> RhexisStatus {
    call(|| {
        jaws.check("jaws")?;
        jaws.write(RhexisJaws { radius: 0.2, stiffness: 0.0, force_limit: 0.0, slides: 0 });
        Ok(())
    })
}

/// Fills a pose at the origin, not turned.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_pose_init(pose: Out<RhexisPose>) -> RhexisStatus {
    call(|| {
        pose.check("pose")?;
        pose.write(rhexis::components::Pose::default().into());
        Ok(())
    })
}

/// Fills a grasp of the nearest point within 1 mm.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_grasp_init(grasp: Out<RhexisGrasp>) -> RhexisStatus {
    call(|| {
        grasp.check("grasp")?;
        grasp.write(RhexisGrasp {
            kind: RHEXIS_GRASP_NEAREST,
            reach: 1.0,
            point: RhexisVec3::default(),
            direction: DVec3::NEG_Z.into(),
            vertices: Array::NULL,
            vertex_count: 0,
        });
        Ok(())
    })
}

/// Puts open forceps into the world. `name` may be NULL for "forceps".
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_forceps_create(
    world: RhexisWorld,
    name: Text,
    jaws: In<RhexisJaws>,
    pose: In<RhexisPose>,
    forceps: Out<RhexisEntity>,
) -> RhexisStatus {
    call(|| {
        forceps.check("forceps")?;
        let name = if name.is_null() { "forceps" } else { name.read("the name")? };
        let (given, pose) = (jaws.read("jaws")?, pose.read("pose")?.pose());
        let jaws = Jaws {
            radius: given.radius,
            stiffness: (given.stiffness != 0.0).then_some(given.stiffness),
            force_limit: (given.force_limit != 0.0).then_some(given.force_limit),
            slip: if given.slides != 0 { Slip::Slide } else { Slip::LetGo },
        };
        let made = with(world, |world| {
            let made = world.simulation().spawn_forceps(name, jaws, pose).map_err(refused)?;
            world.handle_of_new(made)
        })?;
        forceps.write(made);
        Ok(())
    })
}

fn grasp_of(given: &RhexisGrasp) -> Answer<Grasp> {
    Ok(match given.kind {
        RHEXIS_GRASP_NEAREST => Grasp::Nearest { reach: given.reach },
        RHEXIS_GRASP_RAY => {
            let (origin, direction) = (given.point.vector(), given.direction.vector());
            Grasp::Ray { origin, direction, reach: given.reach }
        }
        RHEXIS_GRASP_POINT => Grasp::Point(given.point.vector()),
        RHEXIS_GRASP_VERTICES => Grasp::Vertices(keys(given.vertices.read(given.vertex_count, "the vertices")?)?),
        other => return Err(Failure::argument(format!("there is no grasp of kind {other}: give 0 to 3"))),
    })
}

/// Closes forceps on a body. `held` gets the number of vertices that they hold, and may be NULL.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_forceps_close(
    world: RhexisWorld,
    forceps: RhexisEntity,
    body: RhexisEntity,
    grasp: In<RhexisGrasp>,
    held: Out<usize>,
) -> RhexisStatus {
    call(|| {
        held.check_if_any("held")?;
        let given = grasp.read("the grasp")?;
        let grasp = grasp_of(&given)?;
        let count = with(world, |world| {
            let (forceps, body) = (ForcepsId::from(world.entity(forceps)?), world.body(body)?);
            world.simulation().close_forceps(forceps, body, &grasp).map_err(refused)
        })?;
        held.write(count);
        Ok(())
    })
}

/// Moves forceps to a pose, evenly within a time \[ms\]: that of the step or frame about to be simulated.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_forceps_move(
    world: RhexisWorld,
    forceps: RhexisEntity,
    pose: In<RhexisPose>,
    within: f64,
) -> RhexisStatus {
    call(|| {
        let pose = pose.read("pose")?.pose();
        with(world, |world| {
            let forceps = ForcepsId::from(world.entity(forceps)?);
            world.simulation().move_forceps(forceps, pose, within).map_err(refused)
        })
    })
}

/// Opens forceps: they let go.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_forceps_open(world: RhexisWorld, forceps: RhexisEntity) -> RhexisStatus {
    call(|| {
        with(world, |world| {
            let forceps = ForcepsId::from(world.entity(forceps)?);
            world.simulation().open_forceps(forceps).map(|_| ()).map_err(refused)
        })
    })
}

/// Tells where forceps are, what they hold, and with which force. Does not change the world.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_forceps_state(
    world: RhexisWorld,
    forceps: RhexisEntity,
    state: Out<RhexisForcepsState>,
) -> RhexisStatus {
    call(|| {
        state.check("state")?;
        let found = with(world, |world| {
            let forceps = ForcepsId::from(world.entity(forceps)?);
            let simulation = world.simulation();
            let (now, tool) = (simulation.time(), simulation.forceps(forceps).map_err(refused)?);
            Ok(RhexisForcepsState {
                pose: tool.motion.at(now).into(),
                force: tool.force.into(),
                torque: tool.torque.into(),
                hand_ahead: simulation.hand_ahead(forceps).map_err(refused)?,
                body: tool.body.map_or(Ok(RhexisEntity::default()), |body| world.handle(body))?,
            })
        })?;
        state.write(found);
        Ok(())
    })
}

/// Cuts a body along a line through points of the rest shape \[mm\], three numbers each. `cut` may be NULL.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_cut(
    world: RhexisWorld,
    body: RhexisEntity,
    points: Array<f64>,
    point_count: usize,
    cut: Out<RhexisCut>,
) -> RhexisStatus {
    call(|| {
        cut.check_if_any("cut")?;
        let numbers = point_count.checked_mul(3).ok_or_else(|| Failure::argument("there are too many points"))?;
        let points = points.read(numbers, "the points")?.as_chunks::<3>().0;
        let line: Vec<DVec3> = points.iter().map(|&point| DVec3::from_array(point)).collect();
        let made = with(world, |world| {
            let body = world.body(body)?;
            world.simulation().cut(body, &line).map_err(refused)
        })?;
        cut.write((&made).into());
        Ok(())
    })
}

/// Punctures a body where its surface is nearest to a point \[mm\]: a slit of a length \[mm, rest shape\] along a direction. `cut` may be NULL.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_puncture(
    world: RhexisWorld,
    body: RhexisEntity,
    point: RhexisVec3,
    direction: RhexisVec3,
    length: f64,
    cut: Out<RhexisCut>,
) -> RhexisStatus {
    call(|| {
        cut.check_if_any("cut")?;
        let made = with(world, |world| {
            let body = world.body(body)?;
            world.simulation().puncture(body, point.vector(), direction.vector(), length).map_err(refused)
        })?;
        cut.write((&made).into());
        Ok(())
    })
}

/// Puts a blade into the world, out of any tissue: it cuts surface within `reach` \[mm\], in strokes of at least `least` \[mm\].
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_blade_create(
    world: RhexisWorld,
    reach: f64,
    least: f64,
    blade: Out<RhexisEntity>,
) -> RhexisStatus {
    call(|| {
        blade.check("blade")?;
        let made = with(world, |world| {
            let made = world.simulation().spawn_blade(reach, least).map_err(refused)?;
            world.handle_of_new(made)
        })?;
        blade.write(made);
        Ok(())
    })
}

/// Draws the edge of a blade to a point \[mm\], where it cuts a body from where it was; call it every frame. `cut` gets what it has cut, zeros
/// where it has saved the stroke up, and may be NULL.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_blade_draw(
    world: RhexisWorld,
    blade: RhexisEntity,
    body: RhexisEntity,
    edge: RhexisVec3,
    cut: Out<RhexisCut>,
) -> RhexisStatus {
    call(|| {
        cut.check_if_any("cut")?;
        let made = with(world, |world| {
            let (blade, body) = (BladeId::from(world.entity(blade)?), world.body(body)?);
            world.simulation().draw_blade(blade, body, edge.vector()).map_err(refused)
        })?;
        cut.write(made.as_ref().map_or(RhexisCut::default(), RhexisCut::from));
        Ok(())
    })
}

fn found(hit: Option<Hit>) -> Answer<RhexisHit> {
    hit.map(RhexisHit::from).ok_or_else(|| not_found("there is no tissue within reach"))
}

/// Finds the point of a body's surface that is nearest to a point, no farther than `within` \[mm\]. Does not change the world.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_nearest(
    world: RhexisWorld,
    body: RhexisEntity,
    point: RhexisVec3,
    within: f64,
    hit: Out<RhexisHit>,
) -> RhexisStatus {
    call(|| {
        hit.check("hit")?;
        let there = with(world, |world| {
            let body = world.body(body)?;
            found(world.simulation().nearest(body, point.vector(), within))
        })?;
        hit.write(there);
        Ok(())
    })
}

/// Finds the first point of a body's surface on a ray, no farther than `within` \[mm\]. Does not change the world.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_cast_ray(
    world: RhexisWorld,
    body: RhexisEntity,
    origin: RhexisVec3,
    direction: RhexisVec3,
    within: f64,
    hit: Out<RhexisHit>,
) -> RhexisStatus {
    call(|| {
        hit.check("hit")?;
        let there = with(world, |world| {
            let body = world.body(body)?;
            found(world.simulation().cast_ray(body, origin.vector(), direction.vector(), within))
        })?;
        hit.write(there);
        Ok(())
    })
}

/// Pushes a vertex with a force \[N\] for the next step.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_apply_force(
    world: RhexisWorld,
    body: RhexisEntity,
    vertex: u64,
    force: RhexisVec3,
) -> RhexisStatus {
    call(|| {
        let vertex = key(vertex)?;
        with(world, |world| {
            let body = world.body(body)?;
            world.simulation().apply_force(body, vertex, force.vector()).map_err(refused)
        })
    })
}
