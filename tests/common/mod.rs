//! The `fig2-tear` square: a notched sheet pulled apart until it tears through, and what a run of it leaves.
#![allow(dead_code, reason = "shared: each that takes it in uses a part")]

use glam::{DVec2, DVec3};
use rhexis::components::{Curve, Damping, Fibres, Hold, Material, TearLog, Tearing};
use rhexis::event::{Event, EventKind};
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::settings::Settings;
use rhexis::simulation::Simulation;
use rhexis::storage::{Attached, BodyId, Topology, Triangles, Vertices, measure, validate};

/// Side of the square \[mm\].
pub const SIDE: f64 = 30.0;
/// Speed of each grip \[mm/ms\]: 1.5 mm in 500 ms.
pub const GRIP_SPEED: f64 = 0.003;
/// Time step \[ms\].
pub const DT: f64 = 10.0;
/// The notch of the scene: 3 mm down from the middle of the top edge.
pub const NOTCH: [DVec3; 2] = [DVec3::new(15.0, 30.0, 0.0), DVec3::new(15.0, 27.0, 0.0)];

/// One square, before it is spawned.
#[derive(Clone)]
pub struct Square {
    /// Cells of the mesh M(nx, ny).
    pub cells: [usize; 2],
    pub material: Material,
    /// Fibre angle to x \[°\].
    pub fibre: f64,
    pub tearing: Tearing,
    pub notches: Vec<[DVec3; 2]>,
}

impl Square {
    pub fn new(cells: [usize; 2], fibre: f64) -> Self {
        let (material, tearing) = (Material::allard_2009(), Tearing::default());
        Self { cells, material, fibre, tearing, notches: vec![NOTCH] }
    }

    pub fn isotropic(cells: [usize; 2]) -> Self {
        let tearing = Tearing { strength_across_fibres: 0.2, strength_along_fibres: 0.2, ..Tearing::default() };
        Self { material: Material::isotropic(3.0, 0.3, 0.1), tearing, ..Self::new(cells, 0.0) }
    }

    /// Longest side of a cell \[mm\].
    pub fn edge(&self) -> f64 {
        SIDE / self.cells[0].min(self.cells[1]) as f64
    }

    /// A body whose left and right edges are drawn apart.
    pub fn membrane(&self) -> Membrane {
        self.membrane_along(Curve::new(vec![(0.0, 0.0), (1e4, 1e4 * GRIP_SPEED)]).unwrap())
    }

    /// A body whose left and right edges are each drawn out by `curve` \[mm\].
    pub fn membrane_along(&self, curve: Curve) -> Membrane {
        self.out_of_plane(curve).planar()
    }

    /// The same, free to leave its plane.
    pub fn out_of_plane(&self, curve: Curve) -> Membrane {
        self.held(&curve).with(self.tearing).with(Damping { time: 0.1 })
    }

    /// A body that cannot tear, drawn out slowly.
    pub fn elastic(&self) -> Membrane {
        self.held(&Curve::ramp(1e4, 1e4 * GRIP_SPEED).unwrap()).planar()
    }

    fn held(&self, curve: &Curve) -> Membrane {
        let membrane = self.unheld();
        let hold = |name: &str, x: f64, to: f64| {
            let rows = membrane.select(|p| p.x == x).into_iter();
            let members = Attached::new(rows.map(|row| (row, DVec3::X * to)));
            Hold { name: name.into(), members, axes: [true; 3], curve: curve.clone() }
        };
        let (left, right) = (hold("left", 0.0, -1.0), hold("right", SIDE, 1.0));
        membrane.hold(left).hold(right)
    }

    /// A body that hangs from its top edge, free to leave its plane.
    pub fn hanging(&self) -> Membrane {
        let membrane = self.unheld();
        let rows = membrane.select(|p| p.y == SIDE).into_iter();
        let members = Attached::new(rows.map(|row| (row, DVec3::ZERO)));
        membrane.hold(Hold { name: "top".into(), members, axes: [true; 3], curve: Curve::constant(0.0) })
    }

    fn unheld(&self) -> Membrane {
        let mesh = generate::grid(SIDE, SIDE, self.cells[0], self.cells[1]).unwrap();
        Membrane::new("square", mesh, self.material).fibres(Fibres::at_degrees(self.fibre))
    }

    /// Puts the square into a world and cuts its notches.
    pub fn spawn_into(&self, simulation: &mut Simulation) -> BodyId {
        let body = simulation.spawn(self.membrane()).unwrap();
        for notch in &self.notches {
            simulation.cut(body, notch).unwrap();
        }
        body
    }

    pub fn spawn(&self, settings: Settings) -> Run {
        let mut simulation = Simulation::new(settings).unwrap();
        let body = self.spawn_into(&mut simulation);
        let area = measure::total_area(&simulation.world().get::<&Triangles>(body.entity()).unwrap());
        let mass = measure::total_mass(&simulation.world().get::<&Vertices>(body.entity()).unwrap());
        let events = simulation.drain_events().collect();
        Run { simulation, body, events, area, mass }
    }
}

/// One advance, from its event.
#[derive(Clone, Copy, Debug)]
pub struct Advance {
    /// Displacement of each grip at that time \[mm\].
    pub u: f64,
    pub from: DVec2,
    pub to: DVec2,
    pub direction: DVec2,
    pub margin: f64,
    pub is_ambiguous: bool,
}

/// A square in its world.
pub struct Run {
    pub simulation: Simulation,
    pub body: BodyId,
    pub events: Vec<Event>,
    /// Rest area \[mm²\] and mass \[g\] at the start.
    pub area: f64,
    pub mass: f64,
}

impl Run {
    /// Goes statically to a displacement of the grips \[mm\] that is below the first tear: saves the ramp.
    pub fn stretch_to(&mut self, u: f64) {
        self.simulation.settle(u / GRIP_SPEED - self.simulation.time(), 1e-8).unwrap();
    }

    pub fn step(&mut self) {
        assert!(!self.simulation.step(DT).unwrap().has_failed);
        self.events.extend(self.simulation.drain_events());
    }

    /// Steps until `is_done`, at most `limit` times.
    pub fn run_until(&mut self, limit: usize, is_done: impl Fn(&Self) -> bool) {
        for _ in 0..limit {
            if is_done(self) {
                return;
            }
            self.step();
        }
        assert!(is_done(self), "not done after {limit} steps: {:?}", self.log());
    }

    pub fn tear_through(&mut self) {
        self.run_until(150, |run| run.log().end_count > 0);
    }

    pub fn log(&self) -> TearLog {
        (*self.simulation.world().get::<&TearLog>(self.body.entity()).unwrap()).clone()
    }

    pub fn vertices(&self) -> Vertices {
        (*self.simulation.world().get::<&Vertices>(self.body.entity()).unwrap()).clone()
    }

    pub fn triangle_count(&self) -> usize {
        self.simulation.world().get::<&Triangles>(self.body.entity()).unwrap().len()
    }

    pub fn fragment_count(&self) -> usize {
        self.simulation.world().get::<&Topology>(self.body.entity()).unwrap().components().0
    }

    pub fn advances(&self) -> Vec<Advance> {
        let advance = |e: &Event| match e.kind {
            EventKind::Advanced { from, to, direction, margin, is_ambiguous, .. } => Some(Advance {
                u: e.time * GRIP_SPEED,
                from: from.truncate(),
                to: to.truncate(),
                direction: direction.truncate(),
                margin,
                is_ambiguous,
            }),
            _ => None,
        };
        self.events.iter().filter_map(advance).collect()
    }

    /// Where the tear ended \[mm, rest shape\].
    pub fn end(&self) -> DVec2 {
        let end = |e: &Event| if let EventKind::Ended { at, .. } = e.kind { Some(at.truncate()) } else { None };
        self.events.iter().find_map(end).unwrap()
    }

    /// What must hold after any tear: the tables are whole, nothing was lost, no triangle is a sliver.
    pub fn assert_sound(&self) {
        let world = self.simulation.world();
        let vertices = world.get::<&Vertices>(self.body.entity()).unwrap();
        let triangles = world.get::<&Triangles>(self.body.entity()).unwrap();
        let topology = world.get::<&Topology>(self.body.entity()).unwrap();
        assert_eq!(validate(&vertices, &triangles, &topology), Ok(()));
        // Roundings of sums of some thousand terms.
        assert!((measure::total_area(&triangles) / self.area - 1.0).abs() < 1e-12);
        assert!((measure::total_mass(&vertices) / self.mass - 1.0).abs() < 1e-12);
        let least = 10_f64.to_radians();
        assert!(self.log().smallest_angle.is_none_or(|angle| angle >= least), "{:?}", self.log());
        assert!(measure::rest_angles(&vertices, &triangles).all(|angle| angle >= least));
    }
}

/// Distance of a point \[mm\] from the line through `origin` at `degrees` to x.
pub fn off_line(point: DVec2, origin: DVec2, degrees: f64) -> f64 {
    DVec2::from_angle(degrees.to_radians()).perp_dot(point - origin).abs()
}

/// Every number of a body's state as bits.
pub fn state_bits(simulation: &Simulation, body: BodyId) -> Vec<u64> {
    let vertices = simulation.world().get::<&Vertices>(body.entity()).unwrap();
    let triangles = simulation.world().get::<&Triangles>(body.entity()).unwrap();
    let points = vertices.position.iter().chain(&vertices.velocity).chain(&vertices.rest_position);
    let coordinates = points.flat_map(|p| p.to_array()).chain(vertices.mass.iter().copied()).map(f64::to_bits);
    let corners = triangles.corners.iter().flatten().map(|&row| u64::from(row));
    coordinates.chain(corners).collect()
}
