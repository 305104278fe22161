//! What a renderer draws: the arrays of all bodies one after the other, in single precision.

use crate::engine::Engine;
use glam::DVec3;
use rhexis::components::{Frames, Tearing};
use rhexis::frame::SolidKind;
use rhexis::simulation::{DebugKind, DebugLine, DebugLines};
use rhexis::storage::{BodyId, Tips, Triangles, Vertices};
use rhexis::systems::fracture::strength;
use rhexis::systems::kernels::failure::Search;

/// What a triangle is coloured by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shade {
    /// Largest principal stress \[MPa\].
    Stress,
    /// Largest value of the tear criterion from the triangle's own stress; above 1 it would tear. Zero for a body that cannot.
    Criterion,
}

/// The lines that a renderer asks for.
const NO_LINES: DebugLines =
    DebugLines { frames: false, fibres: false, stress: None, tips: false, contacts: false, grips: false };

fn put(into: &mut Vec<f32>, point: DVec3) {
    into.extend(point.to_array().map(|x| x as f32));
}

impl Engine {
    /// Positions \[mm\], three numbers per vertex.
    pub fn positions(&self) -> Vec<f32> {
        let mut all = Vec::new();
        for &body in &self.instance.bodies {
            if let Ok(vertices) = self.instance.simulation.world().get::<&Vertices>(body.entity()) {
                vertices.position.iter().for_each(|&point| put(&mut all, point));
            }
        }
        all
    }

    /// Rows of the vertices, three per triangle.
    pub fn indices(&self) -> Vec<u32> {
        let (mut all, mut first) = (Vec::new(), 0);
        for &body in &self.instance.bodies {
            let world = self.instance.simulation.world();
            let (Ok(vertices), Ok(triangles)) =
                (world.get::<&Vertices>(body.entity()), world.get::<&Triangles>(body.entity()))
            else {
                continue;
            };
            all.extend(triangles.corners.iter().flatten().map(|row| row + first));
            first += vertices.len() as u32;
        }
        all
    }

    /// Positions of the obstacles' surfaces \[mm\], three numbers per vertex, and rows of the vertices, three per triangle. Of a plane the part under
    /// the bodies.
    pub fn obstacles(&self) -> (Vec<f32>, Vec<u32>) {
        let (mut positions, mut indices) = (Vec::new(), Vec::new());
        let solids = self.instance.simulation.solids();
        for obstacle in solids.iter().filter(|solid| solid.kind == SolidKind::Obstacle) {
            let first = positions.len() as u32 / 3;
            indices.extend(obstacle.triangles.iter().flatten().map(|row| row + first));
            obstacle.positions.iter().for_each(|&point| put(&mut positions, point));
        }
        (positions, indices)
    }

    /// A number per triangle.
    pub fn shades(&mut self, shade: Shade) -> Vec<f32> {
        let mut all = Vec::new();
        for body in self.instance.bodies.clone() {
            // Evaluates the stresses of the state now.
            let _ = self.instance.simulation.debug_lines(body, &NO_LINES, &mut Vec::new());
            let world = self.instance.simulation.world();
            let (Ok(frames), Ok(triangles)) =
                (world.get::<&Frames>(body.entity()), world.get::<&Triangles>(body.entity()))
            else {
                continue;
            };
            match (shade, world.get::<&Tearing>(body.entity())) {
                (Shade::Stress, _) => {
                    all.extend(frames.states().map(|state| state.stress.principal_values().0 as f32));
                }
                (Shade::Criterion, Ok(tearing)) => {
                    let search = Search::new(strength(&tearing));
                    let values = frames.states().zip(triangles.strength.iter()).map(|(state, factor)| {
                        let found = search.evaluate(state.stress, glam::DVec2::X, None, None);
                        (found.map_or(0.0, |found| found.best.value) / factor) as f32
                    });
                    all.extend(values);
                }
                (Shade::Criterion, Err(_)) => all.extend(std::iter::repeat_n(0.0, triangles.len())),
            }
        }
        all
    }

    /// Means of the triangles' numbers around every vertex: smooth colours.
    pub fn vertex_shades(&mut self, shade: Shade) -> Vec<f32> {
        let (values, indices) = (self.shades(shade), self.indices());
        let count: usize = self.instance.bodies.iter().map(|&body| self.vertex_count(body)).sum();
        let mut sums = vec![[0.0_f32; 2]; count];
        for (corners, value) in indices.chunks_exact(3).zip(values) {
            for &row in corners {
                if let Some(sum) = sums.get_mut(row as usize) {
                    *sum = [sum[0] + value, sum[1] + 1.0];
                }
            }
        }
        sums.into_iter().map(|[sum, count]| sum / count.max(1.0)).collect()
    }

    fn vertex_count(&self, body: BodyId) -> usize {
        self.instance.simulation.world().get::<&Vertices>(body.entity()).map_or(0, |vertices| vertices.len())
    }

    /// A line along the fibre through every triangle: six numbers each \[mm\].
    pub fn fibres(&mut self) -> Vec<f32> {
        self.lines(&DebugLines { fibres: true, ..NO_LINES }, |line| line.kind == DebugKind::Fibre)
    }

    /// At every tip a line in the direction that the criterion prefers, as long as a triangle times the criterion: six numbers each
    /// \[mm\].
    pub fn tip_directions(&mut self) -> Vec<f32> {
        self.lines(&DebugLines { tips: true, ..NO_LINES }, |line| line.kind == DebugKind::TipNext)
    }

    /// From every gripped vertex to where its jaws draw it: six numbers each \[mm\].
    pub fn grips(&mut self) -> Vec<f32> {
        self.lines(&DebugLines { grips: true, ..NO_LINES }, |line| line.kind == DebugKind::Grip)
    }

    fn lines(&mut self, which: &DebugLines, wanted: impl Fn(&DebugLine) -> bool) -> Vec<f32> {
        let mut lines = Vec::new();
        for body in self.instance.bodies.clone() {
            // A body of the scene exists.
            let _ = self.instance.simulation.debug_lines(body, which, &mut lines);
        }
        let mut all = Vec::with_capacity(6 * lines.len());
        for line in lines.iter().filter(|line| wanted(line)) {
            put(&mut all, line.from);
            put(&mut all, line.to);
        }
        all
    }

    /// Positions of the tips \[mm\], three numbers each.
    pub fn tips(&self) -> Vec<f32> {
        let mut all = Vec::new();
        for &body in &self.instance.bodies {
            let world = self.instance.simulation.world();
            let (Ok(tips), Ok(vertices)) = (world.get::<&Tips>(body.entity()), world.get::<&Vertices>(body.entity()))
            else {
                continue;
            };
            let places = tips.vertex.iter().filter_map(|&row| vertices.position.get(row as usize));
            places.for_each(|&point| put(&mut all, point));
        }
        all
    }
}
