//! Single edits: refusals, undo in order, what the validator finds.

use crate::meshes::{self, Body, Random, Sheet};
use glam::DVec3;
use rhexis::storage::{
    Broken, Edit, NONE, Refusal, Topology, apply,
    measure::{linear_momentum, total_area, total_mass},
    undo,
};

#[test]
fn a_refusal_names_its_reason_and_changes_nothing() {
    let sheet = meshes::grid(4, 4, 4.0, 4.0);
    let mut body = Body::new(&sheet, DVec3::X);
    let before = (body.vertices.clone(), body.triangles.clone(), body.topology.clone());
    let refuse = |body: &mut Body, edit: Edit| apply(&mut body.mesh(), &edit).unwrap_err();
    let open = |path: &[u32]| Edit::Open { path: path.into() };
    let split = |triangle, edge, weight| Edit::SplitEdge { triangle, edge, weight };

    assert_eq!(refuse(&mut body, split(99, 0, 0.5)), Refusal::NoSuchRow { what: "triangle", row: 99 });
    assert_eq!(refuse(&mut body, split(0, 3, 0.5)), Refusal::NoSuchEdge { from: NONE, to: NONE });
    for weight in [0.0, 1.0, -0.5, f64::NAN, f64::INFINITY] {
        assert!(matches!(refuse(&mut body, split(0, 0, weight)), Refusal::WeightOutOfRange { .. }));
    }
    assert!(matches!(refuse(&mut body, split(0, 0, 1e-6)), Refusal::WouldMakeSliver { .. }));
    let weights = [0.5, 0.5, 0.5];
    let edit = Edit::SplitTriangle { triangle: 0, weights };
    assert_eq!(refuse(&mut body, edit), Refusal::WeightOutOfRange { weight: 1.5 });
    assert_eq!(refuse(&mut body, Edit::Flip { triangle: 0, edge: 0 }), Refusal::BoundaryEdge { from: 0, to: 1 });
    // Triangle 0 is (0, 1, 6), its neighbour across the edge (1, 6) is (1, 2, 6): no convex quadrilateral.
    assert!(matches!(refuse(&mut body, Edit::Flip { triangle: 0, edge: 1 }), Refusal::WouldInvert { .. }));
    let slide = |vertex, towards, weight| Edit::Slide { vertex, towards, weight };
    assert_eq!(refuse(&mut body, slide(0, 6, 0.5)), Refusal::BoundaryVertex { vertex: 0 });
    assert_eq!(refuse(&mut body, slide(6, 24, 0.5)), Refusal::NoSuchEdge { from: 6, to: 24 });
    assert_eq!(refuse(&mut body, slide(6, 7000, 0.5)), Refusal::NoSuchRow { what: "vertex", row: 7000 });
    assert_eq!(refuse(&mut body, open(&[6, 7])), Refusal::NothingOpens);
    assert_eq!(refuse(&mut body, open(&[0, 1])), Refusal::BoundaryEdge { from: 0, to: 1 });
    assert_eq!(refuse(&mut body, open(&[6, 24])), Refusal::NoSuchEdge { from: 6, to: 24 });
    assert_eq!(refuse(&mut body, open(&[6, 7, 6])), Refusal::BadPath { count: 3 });
    assert_eq!(refuse(&mut body, open(&[])), Refusal::BadPath { count: 0 });
    assert_eq!(refuse(&mut body, open(&[6, u32::MAX])), Refusal::NoSuchRow { what: "vertex", row: u32::MAX });

    assert_eq!(body.topology, before.2);
    assert_eq!(body.vertices.position, before.0.position);
    assert_eq!(body.triangles.corners, before.1.corners);
}

#[test]
fn a_collapse_that_would_change_the_surface_is_refused() {
    let mut body = Body::new(&meshes::grid(4, 4, 4.0, 4.0), DVec3::X);
    let refuse = |body: &mut Body, vertex, into| apply(&mut body.mesh(), &Edit::Collapse { vertex, into }).unwrap_err();
    assert_eq!(refuse(&mut body, 25, 6), Refusal::NoSuchRow { what: "vertex", row: 25 });
    assert_eq!(refuse(&mut body, 6, 25), Refusal::NoSuchRow { what: "vertex", row: 25 });
    assert_eq!(refuse(&mut body, 6, 6), Refusal::NoSuchEdge { from: 6, to: 6 });
    assert_eq!(refuse(&mut body, 6, 24), Refusal::NoSuchEdge { from: 6, to: 24 });
    assert_eq!(refuse(&mut body, 1, 6), Refusal::BoundaryVertex { vertex: 1 });
    assert_eq!(refuse(&mut body, 0, 1), Refusal::BentBoundary { vertex: 0 });
    // Vertex 12 into the corner 6 of its ring 6, 7, 8, 13, …: what was (12, 7, 8) would have no area.
    assert!(matches!(refuse(&mut body, 12, 6), Refusal::WouldInvert { .. }));
    // Triangle (6, 7, 12) with a vertex inside: 6 and 7 are joined across it by way of 12.
    let inside = body.topology.directed_edge(&body.triangles.corners, 6, 7).unwrap().0;
    let far = body.triangles.corners[inside as usize].into_iter().find(|&v| v != 6 && v != 7).unwrap();
    apply(&mut body.mesh(), &Edit::SplitTriangle { triangle: inside, weights: [0.25, 0.25, 0.5] }).unwrap();
    assert_eq!(refuse(&mut body, 6, 7), Refusal::EdgeExists { from: 7, to: far });
    assert_eq!(body.mesh().validate(), Ok(()));

    let tetrahedron = Sheet {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z],
        corners: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    };
    let mut body = Body::new(&tetrahedron, DVec3::ONE);
    assert_eq!(refuse(&mut body, 0, 1), Refusal::TooFewTriangles { vertex: 0 });
}

/// A sheet of 6 × 6 cells with a notch of three edges from the lower rim: row 24 is the tip, 17 and the last row are the lips' next.
fn notched() -> Body {
    let mut body = Body::new(&meshes::grid(6, 6, 6.0, 6.0), DVec3::X);
    apply(&mut body.mesh(), &Edit::Open { path: smallvec::smallvec![3, 10, 17, 24] }).unwrap();
    body
}

/// A glide of a vertex in the triangle at it that has the directed edge to `next`; the weights are those of the vertex, of `next`
/// and of the third corner.
fn glide(body: &Body, vertex: u32, next: u32, [own, along, across]: [f64; 3]) -> Edit {
    let (triangle, corner) = body.topology.directed_edge(&body.triangles.corners, vertex, next).unwrap();
    let mut weights = [own; 3];
    weights[(corner + 1) % 3] = along;
    weights[(corner + 2) % 3] = across;
    Edit::Glide { vertex, triangle, weights }
}

#[test]
fn a_glide_that_would_change_the_surface_is_refused() {
    let mut body = notched();
    let before = body.clone();
    let refuse = |body: &mut Body, edit: Edit| apply(&mut body.mesh(), &edit).unwrap_err();
    let third = [0.5, 0.25, 0.25];
    let (ahead, right) = (31, 25);
    let beyond = |vertex, triangle| Edit::Glide { vertex, triangle, weights: third };
    assert_eq!(refuse(&mut body, beyond(7000, 0)), Refusal::NoSuchRow { what: "vertex", row: 7000 });
    assert_eq!(refuse(&mut body, beyond(24, 72)), Refusal::NoSuchRow { what: "triangle", row: 72 });
    assert_eq!(refuse(&mut body, beyond(24, 0)), Refusal::NotACorner { vertex: 24, triangle: 0 });
    let out_of_range = |body: &mut Body, weights: [f64; 3], weight: f64| {
        let refusal = refuse(body, glide(body, 24, right, weights));
        // As text: a weight that is no number differs from itself.
        assert_eq!(format!("{refusal:?}"), format!("{:?}", Refusal::WeightOutOfRange { weight }));
    };
    out_of_range(&mut body, [0.0, 0.5, 0.5], 0.0);
    out_of_range(&mut body, [1.0, 0.0, 0.0], 1.0);
    out_of_range(&mut body, [0.75, 0.5, -0.25], -0.25);
    out_of_range(&mut body, [0.75, f64::NAN, 0.25], f64::NAN);
    out_of_range(&mut body, [0.5, 0.5, 0.5], 1.5);
    out_of_range(&mut body, [0.5, 0.25, 0.25 + 1e-13], 1.0 + 1e-13);

    let vertex = 16;
    let edit = glide(&body, vertex, 23, third);
    assert_eq!(refuse(&mut body, edit), Refusal::InnerVertex { vertex });
    let edit = glide(&body, 0, 1, third);
    assert_eq!(refuse(&mut body, edit), Refusal::LipsApart { vertex: 0, gap: 2.0_f64.sqrt() }, "a corner of the rim");
    let edit = glide(&body, 17, 24, third);
    assert_eq!(refuse(&mut body, edit), Refusal::LipsApart { vertex: 17, gap: 2.0 }, "a lip");

    // Onto the neighbour to the right, but for a millionth of the way.
    let edit = glide(&body, 24, right, [1e-6, 1.0 - 1e-6, 0.0]);
    assert!(matches!(refuse(&mut body, edit), Refusal::WouldMakeSliver { .. }));
    assert_eq!(body.topology, before.topology);
    assert!((0..body.vertices.len() as u32).all(|row| body.vertices.at(row) == before.vertices.at(row)));
    assert!((0..body.triangles.len() as u32).all(|row| body.triangles.at(row) == before.triangles.at(row)));

    // The vertex ahead is drawn near, in space alone and in the rest shape: triangles beside it would turn over.
    let mut in_space = body.clone();
    in_space.vertices.position[ahead as usize].y = 3.2;
    let aside = [0.1, 0.9, 0.0];
    let edit = glide(&body, 24, right, aside);
    assert!(apply(&mut body.clone().mesh(), &edit).is_ok());
    assert!(matches!(refuse(&mut in_space, edit.clone()), Refusal::WouldInvert { .. }));
    apply(&mut body.mesh(), &Edit::Slide { vertex: ahead, towards: 24, weight: 0.8 }).unwrap();
    body.vertices.position[ahead as usize].y = 4.0;
    assert!(matches!(refuse(&mut body, edit), Refusal::WouldInvert { .. }));

    // One lip is split: the lips have unequal lengths.
    let mut body = notched();
    let next = body.topology.next_boundary_vertex(&body.triangles.corners, 24).unwrap();
    let (triangle, edge) = body.topology.directed_edge(&body.triangles.corners, 24, next).unwrap();
    apply(&mut body.mesh(), &Edit::SplitEdge { triangle, edge, weight: 0.5 }).unwrap();
    let edit = glide(&body, 24, right, third);
    assert_eq!(refuse(&mut body, edit), Refusal::LipsApart { vertex: 24, gap: 0.5 });
    let refusal = Refusal::LipsApart { vertex: 24, gap: 0.5 };
    let words = "the boundary edges at vertex 24 end 5.000e-1 mm apart in the rest shape, not at one point as the lips of a tear";
    assert_eq!(refusal.to_string(), words);
}

#[test]
fn a_tip_that_glides_leaves_area_mass_momentum_and_outline() {
    let mut body = notched();
    body.deform(&mut Random::new(11));
    let totals = |body: &Body| [total_area(&body.triangles), total_mass(&body.vertices), body.outlined_area()];
    let (before, momentum) = (totals(&body), linear_momentum(&body.vertices));
    let size: f64 = body.vertices.mass.iter().zip(&body.vertices.velocity).map(|(m, v)| m * v.length()).sum();
    let mut done = Vec::new();
    let mut edit = |body: &mut Body, edit: Edit| {
        let earlier = body.clone();
        let record = apply(&mut body.mesh(), &edit).unwrap_or_else(|refusal| panic!("{edit:?}: {refusal}"));
        done.push((record, earlier));
        assert_eq!(body.mesh().validate(), Ok(()), "{edit:?}");
        // Sums of a hundred terms.
        let off = totals(body).iter().zip(&before).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
        assert!(
            off < 1e-14 && (linear_momentum(&body.vertices) - momentum).length() < 1e-15 * size,
            "{off:e} {edit:?}"
        );
    };
    // Up to the right, where both lips are split at one weight; to the left, a little back, and along the edge ahead.
    let mut expected = DVec3::new(3.0, 3.0, 0.0);
    for (next, weights) in
        [(25, [0.6, 0.1, 0.3]), (31, [0.7, 0.1, 0.2]), (23, [0.95, 0.03, 0.02]), (31, [0.5, 0.5, 0.0])]
    {
        let (triangle, corner) = body.topology.directed_edge(&body.triangles.corners, 24, next).unwrap();
        let across = body.triangles.corners[triangle as usize][(corner + 2) % 3];
        let rest = |row: u32| body.vertices.rest_position[row as usize];
        expected = expected * weights[0] + rest(next) * weights[1] + rest(across) * weights[2];
        let glides = glide(&body, 24, next, weights);
        edit(&mut body, glides);
        assert!(body.vertices.rest_position[24].distance(expected) < 1e-14, "{expected}");
        if next != 25 {
            continue;
        }
        let [previous, next] = body.tips().iter().find(|(row, _)| *row == 24).unwrap().1;
        for (from, to, weight) in [(24, next, 0.6), (previous, 24, 1.0 - 0.6)] {
            let (triangle, at) = body.topology.directed_edge(&body.triangles.corners, from, to).unwrap();
            edit(&mut body, Edit::SplitEdge { triangle, edge: at, weight });
        }
    }
    assert_eq!(done.len(), 6);
    for (record, earlier) in done.into_iter().rev() {
        undo(&mut body.mesh(), &record).unwrap();
        assert_eq!(body.mesh().validate(), Ok(()));
        assert_eq!(body.topology, earlier.topology);
        assert!((0..earlier.vertices.len() as u32).all(|row| body.vertices.at(row) == earlier.vertices.at(row)));
        assert!((0..earlier.triangles.len() as u32).all(|row| body.triangles.at(row) == earlier.triangles.at(row)));
    }
    assert_eq!(body.vertices.len(), notched().vertices.len());
}

/// Sets the values of all triangles of a body by their rest centroids.
fn set_fields(body: &mut Body, values: impl Fn(DVec3, &mut rhexis::storage::TriangleRow)) {
    for row in 0..body.triangles.len() as u32 {
        let mut triangle = body.triangles.at(row);
        values(centroid(body, row), &mut triangle);
        body.triangles.set(row, triangle);
    }
    rhexis::storage::measure::rest_data(&mut body.mesh()).unwrap();
}

fn centroid(body: &Body, row: u32) -> DVec3 {
    let corners = body.triangles.corners[row as usize];
    corners.iter().map(|&v| body.vertices.rest_position[v as usize]).sum::<DVec3>() / 3.0
}

/// Edits of every kind that moves triangles, in the midst of a sheet of 6 × 6 cells with a notch.
fn moves(body: &Body) -> [Edit; 4] {
    let (flipped, edge) = body.topology.directed_edge(&body.triangles.corners, 18, 26).unwrap();
    [
        Edit::Slide { vertex: 33, towards: 34, weight: 0.3 },
        Edit::Flip { triangle: flipped, edge },
        glide(body, 24, 31, [0.6, 0.3, 0.1]),
        Edit::Collapse { vertex: 25, into: 24 },
    ]
}

#[test]
fn fields_stay_where_they_are_when_triangles_move() {
    let mut body = notched();
    let thickness = |at: DVec3| 1.0 + 0.02 * at.x - 0.01 * at.y;
    let toughness = |at: DVec3| 2.0 - 0.03 * at.x + 0.02 * at.y;
    let fibre = |at: DVec3| DVec3::Z.cross(at - DVec3::new(3.0, -20.0, 0.0)).normalize();
    set_fields(&mut body, |at, row| {
        (row.thickness, row.toughness, row.fibre) = (thickness(at), toughness(at), fibre(at));
    });
    for edit in moves(&body) {
        let mass = total_mass(&body.vertices);
        apply(&mut body.mesh(), &edit).unwrap();
        assert!((total_mass(&body.vertices) - mass).abs() < 1e-12 * mass, "{edit:?}");
        for row in 0..body.triangles.len() as u32 {
            let (at, triangle) = (centroid(&body, row), body.triangles.at(row));
            // The gradient of a linear field is exact but for 1e-9 of its own, by which the matrix is kept regular.
            assert!((triangle.thickness - thickness(at)).abs() < 1e-9, "{edit:?}, {row}");
            assert!((triangle.toughness - toughness(at)).abs() < 1e-9, "{edit:?}, {row}");
            // Circles of 23 mm over triangles of 1 mm: the error is of second order, (1/23)² = 0.002; carried along it would be 0.04.
            assert!(triangle.fibre.cross(fibre(at)).length() < 2e-3, "{edit:?}, {row}");
        }
    }
}

#[test]
fn fields_are_not_smeared_over_a_border_of_materials() {
    let mut body = notched();
    // Triangles on both sides of the notch's line have other values; a fibre across counts as one.
    set_fields(&mut body, |at, row| {
        let is_left = at.x < 3.0;
        row.thickness = if is_left { 1.0 } else { 2.0 };
        row.fibre = if is_left { DVec3::X } else { DVec3::Y };
    });
    for edit in
        [Edit::Slide { vertex: 31, towards: 38, weight: 0.3 }, Edit::Slide { vertex: 33, towards: 34, weight: 0.3 }]
    {
        apply(&mut body.mesh(), &edit).unwrap();
        for row in 0..body.triangles.len() as u32 {
            let (is_left, triangle) = (centroid(&body, row).x < 3.0, body.triangles.at(row));
            assert_eq!(triangle.thickness, if is_left { 1.0 } else { 2.0 }, "{edit:?}, {row}");
            assert_eq!(triangle.fibre, if is_left { DVec3::X } else { DVec3::Y }, "{edit:?}, {row}");
        }
    }
}

#[test]
fn the_lips_of_a_tear_can_be_coarsened_up_to_the_tip() {
    let mut body = Body::new(&meshes::grid(6, 6, 6.0, 6.0), DVec3::X);
    let triangle_count = body.triangles.len();
    // A notch of three edges from the lower rim; rows 3, 10, 17 get copies, 24 is the tip.
    let notch = apply(&mut body.mesh(), &Edit::Open { path: smallvec::smallvec![3, 10, 17, 24] }).unwrap();
    let copies: Vec<u32> = notch.created().map(|(row, _)| row).collect();
    let collapse = |body: &mut Body, vertex, into| apply(&mut body.mesh(), &Edit::Collapse { vertex, into });
    let tip = body.vertices.key(24).unwrap();
    assert_eq!(collapse(&mut body, 24, 17), Err(Refusal::BentBoundary { vertex: 24 }), "the tip stays");
    assert_eq!(collapse(&mut body, 3, 10), Err(Refusal::BentBoundary { vertex: 3 }), "the corner at the rim stays");
    // The upper vertex of each lip goes towards the rim, so that its last edge runs from the tip over two cells.
    for (upper, lower) in [(copies[2], copies[1]), (17, 10)] {
        collapse(&mut body, upper, lower).unwrap();
    }
    assert_eq!(body.triangles.len(), triangle_count - 2);
    let tip = body.vertices.row(tip).unwrap();
    let next = body.topology.next_boundary_vertex(&body.triangles.corners, tip).unwrap();
    assert_eq!(body.vertices.rest_position[next as usize], DVec3::new(3.0, 1.0, 0.0));
    assert_eq!(body.mesh().validate(), Ok(()));
}

#[test]
fn a_collapsed_vertex_comes_back_under_its_key_until_it_is_released() {
    let mut body = Body::new(&meshes::grid(4, 4, 4.0, 4.0), DVec3::X);
    let key = body.vertices.key(12).unwrap();
    let record = apply(&mut body.mesh(), &Edit::Collapse { vertex: 12, into: 7 }).unwrap();
    assert_eq!((body.vertices.row(key), record.vertex_after(12), record.vertex_after(24)), (None, None, Some(12)));
    undo(&mut body.mesh(), &record).unwrap();
    assert_eq!(body.vertices.row(key), Some(12));
    let record = apply(&mut body.mesh(), &Edit::Collapse { vertex: 12, into: 7 }).unwrap();
    body.mesh().release();
    assert_eq!(undo(&mut body.mesh(), &record), Err(Refusal::NotTheLast));
    assert_eq!((body.vertices.row(key), body.mesh().validate()), (None, Ok(())));
}

#[test]
fn a_vertex_with_three_triangles_keeps_them() {
    let mut body = Body::new(&meshes::grid(3, 3, 3.0, 3.0), DVec3::X);
    let third = 1.0 / 3.0;
    let split = Edit::SplitTriangle { triangle: 7, weights: [third; 3] };
    let record = apply(&mut body.mesh(), &split).unwrap();
    let [a, b, _] = record.new_triangles[1].corners;
    assert_eq!(b, record.first_vertex);
    let edge = body.topology.directed_edge(&body.triangles.corners, a, b).unwrap();
    let flip = Edit::Flip { triangle: edge.0, edge: edge.1 };
    assert!(matches!(apply(&mut body.mesh(), &flip), Err(Refusal::EdgeExists { .. })));
}

#[test]
fn only_the_last_edit_can_be_undone() {
    let mut body = Body::new(&meshes::grid(3, 3, 3.0, 3.0), DVec3::X);
    let first = apply(&mut body.mesh(), &Edit::SplitEdge { triangle: 4, edge: 0, weight: 0.5 }).unwrap();
    let second = apply(&mut body.mesh(), &Edit::SplitEdge { triangle: 9, edge: 0, weight: 0.5 }).unwrap();
    assert_eq!(undo(&mut body.mesh(), &first), Err(Refusal::NotTheLast));
    assert_eq!(undo(&mut body.mesh(), &second), Ok(()));
    assert_eq!(undo(&mut body.mesh(), &second), Err(Refusal::NotTheLast));
    assert_eq!(undo(&mut body.mesh(), &first), Ok(()));
}

#[test]
fn a_loop_frees_a_disc_and_leaves_single_fans() {
    let mut body = Body::new(&meshes::grid(6, 6, 6.0, 6.0), DVec3::X);
    let ring: Vec<u32> = vec![16, 17, 18, 25, 32, 31, 30, 23, 16];
    apply(&mut body.mesh(), &Edit::Open { path: ring.into() }).unwrap();
    assert_eq!(body.topology.components().0, 2);
    assert_eq!(body.mesh().validate(), Ok(()));
}

#[test]
fn the_validator_names_what_is_broken() {
    let fresh = || Body::new(&meshes::grid(3, 3, 3.0, 3.0), DVec3::X);
    let mut body = fresh();
    body.vertices.velocity.pop();
    assert_eq!(body.mesh().validate(), Err(Broken::Misaligned { table: "vertices", column: "velocity" }));
    let mut body = fresh();
    body.topology.neighbours[4][0] = 7;
    assert_eq!(body.mesh().validate(), Err(Broken::Neighbours { triangle: 4 }));
    let mut body = fresh();
    body.topology.incident[5].swap(0, 1);
    assert_eq!(body.mesh().validate(), Err(Broken::Incidence { vertex: 5 }));
    let mut body = fresh();
    body.vertices.position[3].y = f64::NAN;
    assert_eq!(body.mesh().validate(), Err(Broken::NotFinite { column: "position", vertex: 3 }));
    let mut body = fresh();
    body.vertices.rest_position[5].x += 1e-9;
    assert!(matches!(body.mesh().validate(), Err(Broken::RestData { .. })));
    let mut body = fresh();
    body.vertices.mass[2] *= 1.0 + 1e-15;
    assert_eq!(body.mesh().validate(), Err(Broken::Mass { vertex: 2 }));
    let mut body = fresh();
    body.triangles.corners[0].swap(0, 1);
    assert!(matches!(body.mesh().validate(), Err(Broken::EdgeUsedTwice { .. })));
    assert!(Topology::new(0, &[]).is_ok());
}
