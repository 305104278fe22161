//! What a trainer does: steps of one length under a loop of pictures, a tool that the hand moves, events, and a renderer's
//! buffers that follow what has changed. `cargo run --release --example trainer_loop`

use glam::{DVec3, Vec3};
use rhexis::components::{ChangeSet, Changes, Damping, Fibres, Material, Refinement, Tearing};
use rhexis::event::EventKind;
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::settings::Settings;
use rhexis::simulation::{FixedStep, Simulation, normals};

/// What lies in the renderer's memory, in single precision.
#[derive(Default)]
struct Buffers {
    indices: Vec<[u32; 3]>,
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    /// Rows of indices written so far.
    written: usize,
}

/// Tears a sheet by hand.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let sheet = Membrane::new("sheet", generate::grid(30.0, 30.0, 30, 25)?, Material::allard_2009())
        .fibres(Fibres::at_degrees(75.0))
        .with(Tearing::default())
        .with(Refinement::default())
        .with(Damping { time: 0.1 })
        .with(Changes::default());
    let mut simulation = Simulation::new(Settings::default())?;
    let body = simulation.spawn(sheet)?;
    for (name, x) in [("table", 0.0), ("hand", 30.0)] {
        let view = simulation.view(body)?;
        let all = view.vertex_keys.iter().zip(view.rest_positions);
        let keys: Vec<_> = all.filter(|(_, p)| p.x == x).map(|(key, _)| *key).collect();
        simulation.pin(body, name, &keys)?;
    }
    simulation.cut(body, &[DVec3::new(15.0, 30.0, 0.0), DVec3::new(15.0, 27.0, 0.0)])?;

    let mut clock = FixedStep::new(5.0, 4)?;
    let (mut changes, mut buffers) = (ChangeSet::default(), Buffers::default());
    let (mut drawn, mut shades) = (Vec::new(), Vec::new());
    let (mut advances, mut torn_through, mut peak) = (0, false, 0.0_f64);
    for picture in 0..200 {
        // Here the loop would say how long the last picture took.
        for _ in 0..clock.steps_after(16.7)? {
            // Here the device would say where the hand is: it draws aside and lifts.
            let hand = DVec3::new(5.0, 0.0, 3.0) * (simulation.time() / 2000.0);
            simulation.move_pins(body, "hand", |pin| pin.rest_position + hand)?;
            simulation.step(clock.dt())?;
            peak = peak.max(simulation.reactions(body)?[1].1.length());
        }
        for event in simulation.drain_events() {
            match event.kind {
                EventKind::Advanced { .. } => advances += 1,
                EventKind::Ended { .. } => torn_through = true,
                _ => {}
            }
        }
        simulation.drain_changes(body, &mut changes)?;
        clock.positions(&mut simulation, body, &mut drawn)?;
        let triangles = simulation.view(body)?.triangles;
        normals(&drawn, triangles, &mut shades);
        buffers.indices.resize(changes.triangle_count as usize, [0; 3]);
        for rows in &changes.triangles {
            let rows = rows.start as usize..rows.end as usize;
            buffers.indices[rows.clone()].copy_from_slice(&triangles[rows.clone()]);
            buffers.written += rows.len();
        }
        for (to, from) in [(&mut buffers.positions, &drawn), (&mut buffers.normals, &shades)] {
            to.clear();
            to.extend(from.iter().map(|v| v.as_vec3()));
        }
        assert_eq!(buffers.indices, triangles, "picture {picture}: the renderer has the mesh as it is");
        let whole = (picture + 1) * triangles.len();
        if torn_through {
            println!(
                "torn through after {picture} pictures and {advances} advances; the hand pulled {peak:.3} N at most"
            );
            println!("indices written: {} of the {whole} that a rebuild per picture would write", buffers.written);
            assert!(advances > 10 && buffers.written < whole / 10, "{} of {whole}", buffers.written);
            return Ok(());
        }
    }
    Err("the sheet was not torn through".into())
}
