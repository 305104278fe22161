//! Single edits: refusals, undo in order, what the validator finds.

use crate::meshes::{self, Body, Sheet};
use glam::DVec3;
use rhexis::storage::{Broken, Edit, NONE, Refusal, Topology, apply, undo};

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
