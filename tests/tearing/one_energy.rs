//! One energy at every tip.

use glam::{DVec2, DVec3};
use rhexis::components::{
    Curve, EdgeLoad, EdgeLoads, EnergyCriterion, Fibres, Hold, Material, Refinement, Tearing, Toughness,
};
use rhexis::generate;
use rhexis::math::Sym2;
use rhexis::membrane::Membrane;
use rhexis::settings::Settings;
use rhexis::simulation::Simulation;
use rhexis::storage::{Attached, Tips, Topology, TriangleMesh, Triangles, Vertices};
use rhexis::systems::fracture::{EnergyTerms, Surface, TipMemory, energy_decision};
use std::f64::consts::PI;

const SIDE: f64 = 14.0;
const YOUNG: f64 = 3.0;

struct Torn {
    mesh: TriangleMesh,
    positions: Vec<DVec3>,
    tips: Vec<(u32, DVec3)>,
    tension: f64,
}

fn material() -> Material {
    Material::isotropic(YOUNG, 0.3, 0.1)
}

/// A plate with a slit of 2 mm at an angle from the load, on a mesh of this seed.
fn plate(degrees: f64, seed: u64, tension: f64, radius: f64, edges: f64) -> Torn {
    let mesh = generate::jittered(SIDE, SIDE, 70, 70, seed).unwrap();
    let mut sheet = Membrane::new("plate", mesh, material()).planar();
    let groups = [(0.0, DVec3::NEG_Y), (SIDE, DVec3::Y)].map(|(y, way)| {
        let mut rows = sheet.select(|p| p.y == y);
        let x = |row: &u32| sheet.mesh().positions[*row as usize].x;
        rows.sort_by(|a, b| x(a).total_cmp(&x(b)));
        let edges = rows.windows(2).map(|w| [w[0], w[1]]).collect();
        EdgeLoad { edges, traction: way * (tension * 0.1), curve: Curve::constant(1.0) }
    });
    for (name, at, axes) in [("left", 0.0, [true, true, false]), ("right", SIDE, [false, true, false])] {
        let rows = sheet.select(|p| p.x == at && p.y == 0.0);
        let members = Attached::new(rows.into_iter().map(|row| (row, DVec3::ZERO)));
        sheet = sheet.hold(Hold { name: name.into(), members, axes, curve: Curve::constant(0.0) });
    }
    let tearing = Tearing { radius, ..Tearing::default() };
    let refinement = Refinement { edges_per_radius: edges, margin: Some(1.0), budget: 100.0, ..Refinement::default() };
    let sheet = sheet.with(EdgeLoads { groups: groups.into() }).with(tearing).with(refinement);
    let mut simulation = Simulation::new(Settings { threads: 1, ..Settings::default() }).unwrap();
    let toughness = Toughness { along: 1e9, across: 1e9 };
    let body = simulation.spawn(sheet.with(EnergyCriterion::new(toughness))).unwrap();
    let way = DVec2::new(degrees.to_radians().sin(), degrees.to_radians().cos());
    let crack = [DVec2::splat(0.5 * SIDE) - way, DVec2::splat(0.5 * SIDE) + way];
    simulation.cut(body, &crack.map(|p| p.extend(0.0))).unwrap();
    let settled = simulation.settle(1.0, 1e-9);
    if let Err(error) = settled { println!("{error}"); }
    let world = simulation.world();
    let vertices = world.get::<&Vertices>(body.entity()).unwrap();
    let triangles = world.get::<&Triangles>(body.entity()).unwrap();
    let tips = world.get::<&Tips>(body.entity()).unwrap();
    let mesh =
        TriangleMesh { positions: vertices.rest_position.clone(), triangles: triangles.corners.clone(), fibres: None };
    let middle = vertices.position.iter().zip(&vertices.rest_position).min_by(|a, b| {
        let off = |p: &DVec3| p.distance(DVec3::new(0.5 * SIDE, 0.5 * SIDE, 0.0));
        off(a.1).total_cmp(&off(b.1))
    });
    let shift: DVec3 = (0..tips.len()).map(|tip| tips.vertex[tip] as usize).map(|v| vertices.position[v] - vertices.rest_position[v]).sum::<DVec3>() * 0.5;
    let _ = middle;
    let tips = (0..tips.len()).map(|tip| (tips.vertex[tip], tips.previous[tip])).collect();
    Torn { mesh, positions: vertices.position.iter().map(|p| *p - shift).collect(), tips, tension }
}

impl Torn {
    /// Tells of all tips what they release, of the sheet whose rest shape and present shape are both placed by a map.
    fn tell(&self, name: &str, radius: f64, placed: impl Fn(DVec3) -> DVec3, present: impl Fn(DVec3) -> DVec3) {
        let positions: Vec<DVec3> = self.mesh.positions.iter().map(|p| placed(*p)).collect();
        let along = |c: &[u32; 3]| (positions[c[1] as usize] - positions[c[0] as usize]).normalize();
        let fibres = self.mesh.triangles.iter().map(along).collect();
        let mesh = TriangleMesh { positions: positions.clone(), triangles: self.mesh.triangles.clone(), fibres: None };
        let sheet = Membrane::new("s", mesh, material()).fibres(Fibres::PerTriangle(fibres));
        let mut simulation = Simulation::new(Settings { threads: 1, ..Settings::default() }).unwrap();
        let body = simulation.spawn(sheet.with(Tearing { radius, ..Tearing::default() })).unwrap();
        {
            let vertices = simulation.entity_mut::<&mut Vertices>(body).unwrap();
            vertices.position.iter_mut().zip(&self.positions).for_each(|(x, p)| *x = present(*p));
        }
        let world = simulation.world();
        let (vertices, triangles, topology) = (
            world.get::<&Vertices>(body.entity()).unwrap(),
            world.get::<&Triangles>(body.entity()).unwrap(),
            world.get::<&Topology>(body.entity()).unwrap(),
        );
        let surface = Surface {
            vertices: &vertices,
            triangles: &triangles,
            topology: &topology,
            is_planar: false,
            unstretched: Sym2::IDENTITY,
            fibres: None,
            bending: None,
        };
        let tearing = Tearing { radius, ..Tearing::default() };
        for (tip, (vertex, previous)) in self.tips.iter().enumerate() {
            let ahead = (placed(self.mesh.positions[*vertex as usize] + *previous * 1e-6)
                - placed(self.mesh.positions[*vertex as usize]))
            .normalize();
            let mut line = format!("{name}, tip {tip}:");
            for ring in [1.0, 1.5, 2.0, 3.0, 4.0] {
                let energy = EnergyCriterion { ring, ..EnergyCriterion::new(Toughness { along: 1.0, across: 1.0 }) };
                let terms = EnergyTerms { tearing: &tearing, energy: &energy };
                let g0 = self.tension * self.tension * PI / YOUNG;
                let contour = terms.crack_field(&surface, (tip, *vertex), &mut TipMemory::default());
                let (axes, force) = terms.material_force(&surface, (tip, *vertex), &mut TipMemory::default()).unwrap();
                let a = DVec2::new(ahead.dot(axes[0]), ahead.dot(axes[1])).normalize();
                let g = [a.dot(force.release), a.perp_dot(force.release)];
                let found =
                    energy_decision(&surface, terms, tip, (*vertex, ahead), &mut TipMemory::default()).unwrap().0;
                let d = DVec2::new(found.direction.dot(axes[0]), found.direction.dot(axes[1]));
                let j = contour.map_or(f64::NAN, |c| c.release() / g0);
                line += &format!(
                    " [{ring}: J {j:.4} g {:.4} {:.4} kink {:.2}° {:?}]",
                    g[0] / g0,
                    g[1] / g0,
                    a.angle_to(d).to_degrees(),
                    found.by
                );
            }
            println!("{line}");
        }
    }
}

fn tube(radius: f64) -> impl Fn(DVec3) -> DVec3 {
    move |p| {
        let angle = (p.x - 0.5 * SIDE) / radius;
        DVec3::new(radius * angle.sin(), p.y, radius * angle.cos())
    }
}

fn dome(radius: f64) -> impl Fn(DVec3) -> DVec3 {
    move |p| {
        let v = DVec2::new(p.x - 0.5 * SIDE, p.y - 0.5 * SIDE);
        let angle = v.length() / radius;
        let w = v.normalize_or_zero() * angle.sin() * radius;
        DVec3::new(w.x, w.y, radius * angle.cos())
    }
}

#[test]
fn measure() {
    for seed in 1..6 {
        let torn = plate(90.0, seed, 1e-3, 0.25, 3.0);
        torn.tell(&format!("slit, seed {seed}"), 0.25, |p| p, |p| p);
    }
    let torn = plate(90.0, 1, 0.3, 0.25, 3.0);
    torn.tell("slit, 10 %", 0.25, |p| p, |p| p);
    let torn = plate(90.0, 1, 0.3, 0.1, 3.0);
    torn.tell("slit, 10 %, R .1", 0.1, |p| p, |p| p);
    let torn = plate(45.0, 1, 0.3, 0.25, 3.0);
    torn.tell("45°, 10 %", 0.25, |p| p, |p| p);
    for tension in [1e-3, 0.03] {
        for degrees in [45.0, 60.0] {
            let torn = plate(degrees, 1, tension, 0.25, 3.0);
            let name = format!("{tension} {degrees}°");
            torn.tell(&name, 0.25, |p| p, |p| p);
            for r in [2.0, 4.0, 10.0] {
                torn.tell(&format!("{name}, tube {r}"), 0.25, tube(r), tube(r));
            }
            torn.tell(&format!("{name}, dome 10"), 0.25, dome(10.0), dome(10.0));
            torn.tell(&format!("{name}, rolled 2"), 0.25, |p| p, tube(2.0));
        }
    }
}
