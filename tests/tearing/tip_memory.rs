//! What the criterion remembers of a tip's surroundings: right from the start, and the same bits after any edits.

use crate::meshes::{self, Body, Random};
use crate::plain_surface;
use glam::{DVec2, DVec3};
use rhexis::components::Bending;
use rhexis::math::Sym2;
use rhexis::storage::{Edit, NONE, apply, measure::rest_corners};
use rhexis::systems::fracture::{DiscAverage, Surface, TipMemory};
use rhexis::systems::kernels::disc::disc_triangle_overlap;
use rhexis::systems::kernels::failure::Strength;

fn surface(body: &Body, is_planar: bool) -> Surface<'_> {
    let Body { vertices, triangles, topology } = body;
    plain_surface(vertices, triangles, topology, is_planar)
}

fn average(memory: &mut TipMemory, body: &Body, tip: usize, vertex: u32, radius: f64) -> Option<DiscAverage> {
    let strength = Strength::new(2.0, 1.0, 0.5).unwrap();
    memory.at_tip(&surface(body, false), (tip, vertex), strength, radius).map(|(.., average)| average)
}

/// Material force and crack field or fault as text, in which two NaNs are equal.
fn energy(memory: &mut TipMemory, surface: &Surface, tip: usize, vertex: u32, radius: f64) -> Option<String> {
    let strength = Strength::new(2.0, 1.0, 0.5).unwrap();
    let (_, disc) = memory.shifted_disc(surface, (tip, vertex), strength, (radius, 2.0 * radius))?;
    Some(format!("{:?}", disc.read(surface)))
}

/// Of a sheet that does not bend.
fn plain(memory: &mut TipMemory, body: &Body, tip: usize, vertex: u32, radius: f64) -> Option<String> {
    energy(memory, &surface(body, false), tip, vertex, radius)
}

/// Of a sheet that bends.
fn bent(memory: &mut TipMemory, body: &Body, tip: usize, vertex: u32, radius: f64) -> Option<String> {
    let bending = Bending { stiffness: Some(0.02) };
    energy(memory, &Surface { bending: Some(&bending), ..surface(body, false) }, tip, vertex, radius)
}

/// Without a walk, without a disc's own axes: every triangle of a flat sheet by its overlap and its full state.
#[test]
fn on_a_flat_whole_sheet_the_average_is_that_over_all_triangles() {
    let mut random = Random::new(3);
    let mut body = Body::new(&meshes::jittered(24, 20, 12.0, 10.0, 5), DVec3::new(1.0, 0.7, 0.0));
    body.deform(&mut random);
    for _ in 0..50 {
        let (vertex, radius) = (random.below(body.vertices.len()) as u32, random.between(0.3, 4.0));
        let found = average(&mut TipMemory::default(), &body, 0, vertex, radius).unwrap();
        let surface = surface(&body, false);
        let (mut area, mut stress) = (0.0, Sym2::ZERO);
        for t in 0..body.triangles.len() {
            let x = rest_corners(&body.vertices, body.triangles.corners[t]).map(|x| x.truncate());
            let overlap = disc_triangle_overlap(body.vertices.rest_position[vertex as usize].truncate(), radius, x);
            let fibre = body.triangles.fibre[t].truncate();
            let axes = (DVec2::new(fibre.x, -fibre.y), DVec2::new(fibre.y, fibre.x));
            stress += surface.stress(t).in_axes(axes.0, axes.1) * overlap;
            area += overlap;
        }
        let d = found.stress - stress * (1.0 / area);
        // Some hundred roundings of stresses of size one.
        assert!(d.xx.abs().max(d.yy.abs()).max(d.xy.abs()) < 1e-13, "{d:?}");
        assert!(
            (found.area / area - 1.0).abs() < 1e-13 && found.area <= std::f64::consts::PI * radius * radius * 1.0001
        );
    }
}

#[test]
fn discs_of_the_material_force_are_laid_only_for_bodies_that_decide_by_energy() {
    let body = Body::new(&meshes::jittered(14, 12, 7.0, 6.0, 2), DVec3::X);
    let mut memory = TipMemory::default();
    average(&mut memory, &body, 0, 20, 1.0).unwrap();
    assert!(format!("{memory:?}").contains("shifted: []"));
    plain(&mut memory, &body, 0, 20, 1.0).unwrap();
    assert!(!format!("{memory:?}").contains("shifted: []"));
}

/// An edit at a random place, not always a legal one.
fn random_edit(body: &Body, random: &mut Random) -> Edit {
    let triangle = random.below(body.triangles.len()) as u32;
    let edge = random.below(3);
    let corners = body.triangles.corners[triangle as usize];
    let (vertex, towards) = (corners[edge], corners[(edge + 1) % 3]);
    match random.below(12) {
        0 => Edit::SplitEdge { triangle, edge, weight: random.between(0.3, 0.7) },
        1 => Edit::SplitTriangle { triangle, weights: [0.25, 0.25, 0.5] },
        2 | 3 => Edit::Flip { triangle, edge },
        4 | 5 => Edit::Slide { vertex, towards, weight: random.between(0.05, 0.3) },
        6 | 7 => Edit::Collapse { vertex, into: towards },
        8 | 9 => {
            let tips = body.tips();
            let Some(&(vertex, _)) = tips.get(random.below(tips.len().max(1))) else {
                return Edit::Flip { triangle, edge };
            };
            let entry = body.topology.incident[vertex as usize][0];
            let mut weights = [0.15; 3];
            weights[entry as usize % 3] = 0.7;
            Edit::Glide { vertex, triangle: entry / 3, weights }
        }
        _ => {
            // From the boundary inwards, so that something opens.
            let open = (0..3).find(|&e| body.topology.neighbours[triangle as usize][e] == NONE).unwrap_or(edge);
            Edit::Open { path: [corners[open], corners[(open + 2) % 3]].into_iter().collect() }
        }
    }
}

#[test]
fn what_is_remembered_follows_random_edits() {
    let flat = || meshes::jittered(14, 12, 7.0, 6.0, 2);
    for (seed, sheet, radius) in [(1, flat(), 1.2), (2, meshes::cap(8), 2.5), (3, flat(), 0.2)] {
        let mut random = Random::new(seed);
        let mut body = Body::new(&sheet, DVec3::new(1.0, 0.4, 0.1));
        body.deform(&mut random);
        // A disc is laid for tissue that bends, or for tissue that does not.
        let (mut memory, mut bending) = (TipMemory::default(), TipMemory::default());
        let mut tips: Vec<u32> = (0..6).map(|_| random.below(body.vertices.len()) as u32).collect();
        let (mut done, mut glides, mut asked) = (0, 0, 0);
        while done < 400 {
            let edit = random_edit(&body, &mut random);
            if apply(&mut body.mesh(), &edit).is_ok() {
                body.mesh().release();
                done += 1;
                glides += usize::from(matches!(edit, Edit::Glide { .. }));
            }
            // Sometimes several edits lie between two looks, and sometimes a tip moves.
            tips.iter_mut().for_each(|tip| *tip = (*tip).min(body.vertices.len() as u32 - 1));
            if random.below(3) == 0 {
                for (tip, &vertex) in tips.iter().enumerate() {
                    let fresh = average(&mut TipMemory::default(), &body, 0, vertex, radius);
                    assert_eq!(average(&mut memory, &body, tip, vertex, radius), fresh, "{seed}: {done} {edit:?}");
                    let fresh = plain(&mut TipMemory::default(), &body, 0, vertex, radius);
                    assert_eq!(plain(&mut memory, &body, tip, vertex, radius), fresh, "{seed}: {done} {edit:?}");
                    // Bending reaches two triangles beyond the disc: an edit there left rows that were no more.
                    let fresh = bent(&mut TipMemory::default(), &body, 0, vertex, radius);
                    assert_eq!(bent(&mut bending, &body, tip, vertex, radius), fresh, "{seed}: {done} {edit:?}");
                    asked += 1;
                }
                let moved = random.below(tips.len());
                tips[moved] = random.below(body.vertices.len()) as u32;
            }
        }
        assert!(asked > 500 && glides > 20, "{asked} {glides}");
    }
}
