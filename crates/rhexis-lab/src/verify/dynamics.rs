//! Vibration in the plane: natural frequencies, the decay of one mode under backward Euler, order in time.

use super::bodies::{self, Snapshot};
use super::modes::lowest_frequencies;
use super::reference::{Json, file};
use super::{Artifacts, Row, Rows, VerifyError, largest};
use glam::DVec3;
use rhexis::components::{Damping, Fibres, FreeAxes, Material};
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::settings::{Advanced, Settings};
use rhexis::simulation::Simulation;
use rhexis::storage::BodyId;

/// Finer meshes cost 15 s each and show nothing new.
const MOST_CELLS: f64 = 60.0 * 50.0;

pub(super) fn run(_: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("dynamics");
    let (name, text) = file!("dynamics.json");
    let file = Json::new(name, text)?;
    frequencies(&mut rows, &file)?;
    decay(&mut rows, &file)?;
    order(&mut rows, &file)?;
    rows.finish()
}

fn square(nx: usize, ny: usize, material: Material) -> Result<Membrane, VerifyError> {
    let mesh = generate::grid(30.0, 30.0, nx, ny)?;
    Ok(Membrane::new("square", mesh, material).fibres(Fibres::at_degrees(45.0)).planar())
}

fn frequencies(rows: &mut Rows, file: &Json) -> Result<(), VerifyError> {
    for (case, is_all) in [("frequencies_clamped_all", true), ("frequencies_clamped_left_right", false)] {
        for i in 0..file.len(&format!("/{case}/P1_on_M"))? {
            let at = format!("/{case}/P1_on_M/{i}");
            let (nx, ny) = (file.number(&format!("{at}/nx"))?, file.number(&format!("{at}/ny"))?);
            if !file.is_true(&format!("{at}/lumped")) || nx * ny > MOST_CELLS {
                continue;
            }
            let membrane = square(nx as usize, ny as usize, Material::allard_2009())?;
            let is_held = |p: &DVec3| p.x == 0.0 || p.x == 30.0 || is_all && (p.y == 0.0 || p.y == 30.0);
            let in_plane = DVec3::new(1.0, 1.0, 0.0);
            let free = |p: &DVec3| if is_held(p) { DVec3::ZERO } else { in_plane };
            let free: FreeAxes = membrane.mesh().positions.iter().map(free).collect();
            let (mut simulation, body) = bodies::simulate(bodies::exacting(), membrane)?;
            let snapshot = Snapshot::new(&mut simulation, body)?;
            let wanted = file.numbers(&format!("{at}/f_kHz"))?;
            let found = lowest_frequencies(&snapshot, &free, wanted.len())?;
            let off = found.iter().zip(&wanted).map(|(f, w)| (f / w - 1.0).abs());
            // The mesh' own frequencies; what is left is that of the eigenvalue solver and of the listed digits.
            let held = if is_all { "all edges" } else { "left and right edge" };
            rows.ratio(format!("{held} held, M({nx},{ny}): three lowest frequencies"), largest(off), 1e-8);
        }
    }
    Ok(())
}

/// Amplitude of the mode \[mm\]: so small that what is not linear is 1e-6 of it.
const AMPLITUDE: f64 = 1e-5;

/// The square M(10, 8) with all edges held, displaced by its lowest mode and at rest.
struct Mode {
    simulation: Simulation,
    body: BodyId,
    shape: Vec<DVec3>,
}

impl Mode {
    fn new(file: &Json, density: f64, damping: f64) -> Result<Self, VerifyError> {
        let shape = file.vectors("/modal_backward_euler_decay/phi")?;
        let membrane = bodies::hold_rim(square(10, 8, Material { density, ..Material::allard_2009() })?, 30.0, 30.0);
        let membrane = if damping > 0.0 { membrane.with(Damping { time: damping }) } else { membrane };
        let (mut simulation, body) = bodies::simulate(
            Settings {
                advanced: Advanced { newton_iterations: 1, ..bodies::exacting().advanced },
                ..bodies::exacting()
            },
            membrane,
        )?;
        bodies::set_motion(&mut simulation, body, |v, x| (x + shape[v] * AMPLITUDE, DVec3::ZERO))?;
        Ok(Self { simulation, body, shape })
    }

    /// Modal amplitude and velocity over [`AMPLITUDE`] (all masses inside are equal, so they drop out but for the mesh'
    /// alternation of 4 and 8 triangles to a vertex).
    fn amplitude(&mut self) -> Result<(f64, f64), VerifyError> {
        let Snapshot { vertices, .. } = Snapshot::new(&mut self.simulation, self.body)?;
        let (mut q, mut v, mut norm) = (0.0, 0.0, 0.0);
        for (i, shape) in self.shape.iter().enumerate() {
            let weighted = *shape * vertices.mass[i];
            q += weighted.dot(vertices.position[i] - vertices.rest_position[i]);
            v += weighted.dot(vertices.velocity[i]);
            norm += weighted.dot(*shape) * AMPLITUDE;
        }
        Ok((q / norm, v / norm))
    }
}

fn decay(rows: &mut Rows, file: &Json) -> Result<(), VerifyError> {
    for (dt, damping, key) in [(10.0, 0.0, "dt=10,beta=0"), (10.0, 0.1, "dt=10,beta=0.1"), (1.0, 0.1, "dt=1,beta=0.1")]
    {
        let wanted = file.numbers(&format!("/modal_backward_euler_decay/sequences/{key}/q"))?;
        let mut mode = Mode::new(file, 1e-3, damping)?;
        let mut errors = vec![(mode.amplitude()?.0 - wanted[0]).abs()];
        for q in &wanted[1..] {
            mode.simulation.step(dt)?;
            errors.push((mode.amplitude()?.0 - q).abs());
        }
        // Of the amplitude at the start: strains of 1e-6 make the step differ from the linear recursion by as much.
        rows.ratio(format!("decay of the lowest mode, dt {dt} ms, damping {damping} ms"), largest(errors), 1e-5);
    }
    Ok(())
}

fn order(rows: &mut Rows, file: &Json) -> Result<(), VerifyError> {
    let natural = file.number("/modal_backward_euler_decay/omega")?;
    for case in 0..file.len("/order_modal/cases")? {
        let at = |path: &str| format!("/order_modal/cases/{case}{path}");
        let (omega, zeta) = (file.number(&at("/omega"))?, file.number(&at("/zeta"))?);
        let exact = file.numbers(&at("/exact"))?;
        // The density that gives the mode the frequency of the table, and the damping that gives its ratio: 2ζω = βω².
        let (density, damping) = (1e-3 * (natural / omega).powi(2), 2.0 * zeta / omega);
        let (mut off, mut errors) = (Vec::new(), Vec::new());
        for i in 0..file.len(&at("/table"))? {
            let number = |path: &str| file.number(&at(&format!("/table/{i}/{path}")));
            let mut mode = Mode::new(file, density, damping)?;
            for _ in 0..number("n")? as u32 {
                mode.simulation.step(number("dt")?)?;
            }
            let (q, v) = mode.amplitude()?;
            off.push((q - number("backward_euler/q")?).abs());
            off.push((v - number("backward_euler/v")?).abs() / omega);
            errors.push((q - exact[0]).hypot((v - exact[1]) / omega));
        }
        // As the decay.
        rows.ratio(format!("mode after 30 ms, damping ratio {zeta}, five time steps"), largest(off), 1e-5);
        if let [.., coarse, fine] = errors[..] {
            // Each time step is half of the one before. The listed errors give 0.934 between these two.
            rows.ratio(
                format!("order in time, damping ratio {zeta}, distance from 1"),
                ((coarse / fine).log2() - 1.0).abs(),
                0.1,
            );
        }
    }
    Ok(())
}
