//! The lanes against one triangle, and the instruction sets against each other.

use super::*;
use crate::systems::kernels::simd::{force_portable, run};

/// Numbers in −1..1 without any pattern that matters: a linear congruential sequence.
fn numbers() -> impl FnMut() -> f64 {
    let mut state = 11_u64;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

struct Mesh {
    corners: Vec<[u32; 3]>,
    position: Vec<DVec3>,
    rest: Vec<RestTriangle>,
    stiffness: Vec<Orthotropic>,
    pre_stretch: Vec<Sym2>,
    thickness: Vec<f64>,
}

impl Mesh {
    /// Seventeen triangles, so that the last group is not whole: any shape, stretch and turn. One is collapsed to a segment, one to
    /// a point, and in the plane one is mirrored and one a pure mirror image.
    fn new(is_planar: bool) -> Self {
        let mut next = numbers();
        let (stiffness, pre_stretch, thickness) = (vec![], vec![], vec![]);
        let mut mesh = Self { corners: vec![], position: vec![], rest: vec![], stiffness, pre_stretch, thickness };
        for t in 0..17_u32 {
            let mut vector = || DVec3::new(next(), next(), if is_planar { 0.0 } else { next() });
            let x = [vector(), vector() + DVec3::X * 2.0, vector() + DVec3::Y * 2.0];
            let rest = if t == 6 { [DVec3::ZERO, DVec3::X, DVec3::Y] } else { x.map(|x| x + vector() * 0.2) };
            mesh.rest.push(RestTriangle::new(rest, if t == 6 { DVec3::X } else { vector() }).unwrap());
            mesh.position.extend(match t {
                3 => [x[0], x[0].lerp(x[1], 0.4), x[1]],
                4 => [x[0]; 3],
                5 if is_planar => [x[0], x[2], x[1]],
                6 if is_planar => [DVec3::ZERO, DVec3::X, -DVec3::Y],
                _ => x,
            });
            mesh.corners.push([3 * t, 3 * t + 1, 3 * t + 2]);
            mesh.stiffness.push(Orthotropic::new(10.0 + next(), 2.0 + next(), 0.3, 0.7 + 0.5 * next()).unwrap());
            mesh.pre_stretch.push(Sym2::new(0.02 * next(), 0.01, 0.01 * next()));
            mesh.thickness.push(0.1 + 0.05 * next());
        }
        mesh
    }

    fn states(&self, is_planar: bool) -> States<'_> {
        let Self { corners, position, rest, stiffness, .. } = self;
        let stiffness = PerRow::each(stiffness);
        let has_faded = AtomicBool::new(false);
        States {
            corners,
            position,
            rest,
            stiffness,
            is_planar,
            unstretched: Sym2::new(0.97, 1.02, 0.005),
            pre_stretch: PerRow::each(&self.pre_stretch),
            has_faded,
        }
    }
}

fn all<T: Clone>(count: usize, blank: T, kernel: &impl Kernel<T>) -> Vec<T> {
    let mut rows = vec![blank; count];
    run(kernel, 0, &mut rows);
    rows
}

/// State, geometric stiffness and forces on the corners of every triangle.
type Evaluated = (Vec<ElementState>, Vec<GeometricStiffness>, Vec<[DVec3; 3]>);

fn evaluate(mesh: &Mesh, is_planar: bool, reserve: f64) -> Evaluated {
    let (n, kernel) = (mesh.corners.len(), mesh.states(is_planar));
    let (rest, stiffness, thickness) = (&mesh.rest[..], PerRow::each(&mesh.stiffness), PerRow::each(&mesh.thickness));
    if is_planar {
        let state = all(n, FlatState::from(ElementState::REST), &kernel);
        let in_plane = all(n, 0.0, &Geometric { state: &state, start: 0, stiffness, reserve });
        let forces = all(n, [DVec3::ZERO; 3], &CornerForces { state: &state, rest, thickness });
        let geometric = in_plane.into_iter().map(|in_plane| GeometricStiffness { normal: Sym2::ZERO, in_plane });
        return (state.into_iter().map(ElementState::from).collect(), geometric.collect(), forces);
    }
    let state = all(n, ElementState::REST, &kernel);
    let blank = GeometricStiffness::default();
    let geometric = all(n, blank, &Geometric { state: &state, start: 0, stiffness, reserve });
    let forces = all(n, [DVec3::ZERO; 3], &CornerForces { state: &state, rest, thickness });
    (state, geometric, forces)
}

fn off(a: Sym2, b: Sym2) -> f64 {
    let d = a - b;
    d.xx.abs().max(d.yy.abs()).max(d.xy.abs())
}

#[test]
fn lanes_compute_what_one_triangle_does() {
    for (is_planar, reserve) in [(false, -0.5), (true, 1.0)] {
        let mesh = Mesh::new(is_planar);
        let (kernel, (state, geometric, forces)) = (mesh.states(is_planar), evaluate(&mesh, is_planar, reserve));
        let Mesh { rest, stiffness, thickness, .. } = &mesh;
        for t in 0..mesh.corners.len() {
            let alone = kernel.alone(t);
            // Stretches are of size one, stresses of ten; a rotation may lose a digit or two where a triangle is thin.
            assert!((alone.polar.fibre_axis - state[t].polar.fibre_axis).length() < 1e-13, "{t}");
            assert!((alone.polar.transverse_axis - state[t].polar.transverse_axis).length() < 1e-13, "{t}");
            assert!(off(alone.polar.stretch, state[t].polar.stretch) < 1e-14, "{t}");
            assert!(off(alone.stress, state[t].stress) < 1e-13, "{t}");
            let ElementState { polar, stress } = state[t];
            let shear = membrane::shear_majorant(stress, polar.stretch, &stiffness[t], reserve);
            assert!((geometric[t].in_plane - shear).abs() <= 1e-13 * shear.max(1.0), "{t}");
            let normal = match is_planar {
                true => Sym2::ZERO,
                false => membrane::second_piola(stress, polar.stretch).positive_part(),
            };
            // S grows without bound as a triangle collapses.
            let size = normal.xx.abs().max(normal.yy.abs()).max(1.0);
            assert!(off(geometric[t].normal, normal) <= 1e-12 * size, "{t}");
            let volume = rest[t].area * thickness[t];
            let alone = membrane::nodal_forces(&polar, stress, &rest[t], volume);
            assert!(alone.iter().zip(&forces[t]).all(|(a, b)| (*a - *b).length() < 1e-13), "{t}");
        }
    }
}

#[test]
fn every_instruction_set_gives_the_same_bits() {
    for is_planar in [false, true] {
        let mesh = Mesh::new(is_planar);
        let results = [false, true].map(|is_portable| {
            force_portable(is_portable);
            evaluate(&mesh, is_planar, -0.5)
        });
        force_portable(false);
        assert!(results[0] == results[1]);
    }
}
