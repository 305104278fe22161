//! Bodies from arrays, and obstacles.

use crate::pointer::{Array, In, Out, Text};
use crate::status::{Answer, Failure, RhexisStatus, call, refused, unreadable};
use crate::toml_form::patched;
use crate::types::*;
use crate::world::with;
use glam::DVec3;
use rhexis::components::{Fibres, Material, Obstacle};
use rhexis::membrane::Membrane;
use rhexis::storage::TriangleMesh;
use rhexis_scene::patch::patched_rigid;

/// Fills a description with the material of Figure 2 of Allard, Marchal and Cotin 2009, fibres along x, and no mesh.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_body_init(body: Out<RhexisBodyDesc>) -> RhexisStatus {
    call(|| {
        body.check("body")?;
        let Material { young_fibre, young_transverse, poisson_major, shear_modulus, thickness, density } =
            Material::allard_2009();
        body.write(RhexisBodyDesc {
            name: Text::NULL,
            positions: Array::NULL,
            vertex_count: 0,
            triangles: Array::NULL,
            triangle_count: 0,
            fibres: Array::NULL,
            fibre: DVec3::X.into(),
            young_fibre,
            young_transverse,
            poisson_major,
            shear_modulus: shear_modulus.unwrap_or(0.0),
            thickness,
            density,
            planar: 0,
        });
        Ok(())
    })
}

/// Three numbers each; a count beyond all memory is refused.
fn triples<'a, T: crate::pointer::Plain>(numbers: &'a Array<T>, count: usize, what: &str) -> Answer<&'a [[T; 3]]> {
    let of_three = count.checked_mul(3);
    let of_three = of_three.ok_or_else(|| Failure::argument(format!("{what}: {count} are more than memory holds")))?;
    Ok(numbers.read(of_three, what)?.as_chunks().0)
}

fn material(given: &RhexisBodyDesc) -> Material {
    Material {
        young_fibre: given.young_fibre,
        young_transverse: given.young_transverse,
        poisson_major: given.poisson_major,
        shear_modulus: (given.shear_modulus != 0.0).then_some(given.shear_modulus),
        thickness: given.thickness,
        density: given.density,
    }
}

fn membrane(given: &RhexisBodyDesc) -> Answer<Membrane> {
    let name = if given.name.is_null() { "body" } else { given.name.read("the body's name")? };
    let positions = triples(&given.positions, given.vertex_count, "positions")?;
    let triangles = triples(&given.triangles, given.triangle_count, "triangles")?;
    let mesh = TriangleMesh {
        positions: positions.iter().map(|&position| DVec3::from_array(position)).collect(),
        triangles: triangles.to_vec(),
        fibres: None,
    };
    let fibres = if given.fibres.is_null() {
        Fibres::Uniform(given.fibre.vector())
    } else {
        let fibres = triples(&given.fibres, given.triangle_count, "fibres")?;
        Fibres::PerTriangle(fibres.iter().map(|&fibre| DVec3::from_array(fibre)).collect())
    };
    let membrane = Membrane::new(name, mesh, material(given)).fibres(fibres);
    Ok(if given.planar != 0 { membrane.planar() } else { membrane })
}

/// Puts a body into the world; the arrays are copied. Give it components by `rhexis_set`: it tears with "Tearing".
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_body_create(
    world: RhexisWorld,
    desc: In<RhexisBodyDesc>,
    body: Out<RhexisEntity>,
) -> RhexisStatus {
    call(|| {
        body.check("body")?;
        let membrane = membrane(&desc.read("the description")?)?;
        let made = with(world, |world| {
            let made = world.simulation().spawn(membrane).map_err(refused)?;
            world.handle_of_new(made)
        })?;
        body.write(made);
        Ok(())
    })
}

/// Gives all triangles of a body another material while it runs: tissue that ages or dries. Of the description only the material counts, from
/// `young_fibre` to `density`. Positions, fibres and components stay.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_material_set(
    world: RhexisWorld,
    body: RhexisEntity,
    desc: In<RhexisBodyDesc>,
) -> RhexisStatus {
    call(|| {
        let material = material(&desc.read("the description")?);
        with(world, |world| {
            let body = world.body(body)?;
            world.simulation().set_material(body, |_, _| material).map_err(refused)
        })
    })
}

/// Puts an obstacle into the world, a shape in TOML such as "shape = { Sphere = { centre = [0, 0, -5], radius = 4 } }". Bodies with the
/// component "Contact" touch it; `rhexis_set` with "Obstacle" moves it.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_obstacle_create(world: RhexisWorld, toml: Text, obstacle: Out<RhexisEntity>) -> RhexisStatus {
    call(|| {
        obstacle.check("obstacle")?;
        let shape: Obstacle = patched("Obstacle", None, toml.read("the obstacle")?)?;
        let made = with(world, |world| {
            let made = world.simulation().spawn_obstacle(shape).map_err(refused)?;
            world.handle_of_new(made)
        })?;
        obstacle.write(made);
        Ok(())
    })
}

/// Makes an obstacle a rigid body that tissue pushes, or changes its motion: TOML such as "mass = 2.0\nacceleration = [0, 0, -9.81e-3]" with the keys of
/// `RhexisRigid` and "acceleration" and "inertia". A new one needs its mass \[g\], from which centre and inertia follow by its shape. An empty
/// text takes the mass away. Its place is set by `rhexis_set` with "Obstacle".
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_rigid_set(world: RhexisWorld, obstacle: RhexisEntity, toml: Text) -> RhexisStatus {
    call(|| {
        let text = toml.read("the rigid body")?;
        let patch = toml::from_str(text).map_err(|error| unreadable(format!("Rigid: {error}")))?;
        with(world, |world| {
            let obstacle = world.obstacle(obstacle)?;
            let rigid = patched_rigid(world.simulation(), obstacle, patch).map_err(unreadable)?;
            world.simulation().set_rigid(obstacle, rigid).map_err(refused)
        })
    })
}

/// Mass and motion of a rigid obstacle, and the impulse of tissue in the last step; a mass of 0 for an obstacle that yields to nothing.
#[unsafe(no_mangle)]
pub extern "C" fn rhexis_rigid(world: RhexisWorld, obstacle: RhexisEntity, rigid: Out<RhexisRigid>) -> RhexisStatus {
    call(|| {
        rigid.check("the rigid body")?;
        let found = with(world, |world| {
            let obstacle = world.obstacle(obstacle)?;
            world.simulation().rigid(obstacle).map_err(refused)
        })?;
        rigid.write(found.map_or(RhexisRigid::default(), RhexisRigid::from));
        Ok(())
    })
}
