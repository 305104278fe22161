//! A haptic device at 1 kHz beside a simulation that steps as fast as it can: the device reads a linear model of the tissue at the
//! forceps. `cargo run --release --example haptics_thread`

use glam::DVec3;
use rhexis::components::{Curve, Damping, Grip, Grips, Hold, Jaws, Material, Path};
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::settings::Settings;
use rhexis::simulation::{HapticBlend, HapticReceiver, Haptics, Simulation, haptic_feed};
use rhexis::storage::Attached;
use std::sync::Mutex;
use std::thread;
use std::time::Duration;

/// Where the hand goes \[mm\], in so many ticks of the device.
const LIFT: DVec3 = DVec3::new(0.5, 0.0, 1.5);
const TICKS: u32 = 300;

/// Lifts a sheet with forceps in a device's hand.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut sheet = Membrane::new("sheet", generate::grid(20.0, 20.0, 24, 24)?, Material::allard_2009());
    let rim = sheet.select(|p| p.x == 0.0 || p.y == 0.0 || p.x == 20.0 || p.y == 20.0);
    let out = |row: u32| (sheet.mesh().positions[row as usize] - DVec3::new(10.0, 10.0, 0.0)) * 0.05;
    let members = Attached::new(rim.into_iter().map(|row| (row, out(row))));
    let forceps = Grip {
        name: "forceps".into(),
        from: 1.0,
        until: f64::INFINITY,
        material_point: DVec3::new(10.0, 10.0, 0.0),
        near_tip: None,
        jaws: Jaws { radius: 0.8, stiffness: Some(0.2), ..Jaws::default() },
        path: Path { points: vec![(1.0, DVec3::ZERO), (2.0, DVec3::ZERO)] },
        turns: Path::default(),
    };
    sheet = sheet
        .hold(Hold { name: "rim".into(), members, axes: [true; 3], curve: Curve::constant(1.0) })
        .with(Damping { time: 0.1 })
        .with(Grips::new(vec![forceps]));
    let mut simulation = Simulation::new(Settings::default())?;
    let body = simulation.spawn(sheet)?;
    simulation.settle(1.0, 1e-8)?;
    simulation.settle(1.0, 1e-8)?;

    let mut haptics = Haptics::new(1000.0);
    let coupling = simulation.coupling_of_grip(body, 0)?;
    let first = haptics.model(&simulation, body, &coupling)?;
    let (mut sender, receiver) = haptic_feed();
    sender.send(&first);

    let hand = Mutex::new(DVec3::ZERO);
    let forces = thread::scope(|scope| {
        let device = scope.spawn(|| device(&receiver, first.position, &hand));
        while !device.is_finished() {
            let to = hand.lock().map_or(DVec3::ZERO, |hand| *hand);
            simulation.entity_mut::<&mut Grips>(body)?.list[0].path.points[1].1 = to;
            simulation.step(5.0)?;
            let coupling = simulation.coupling_of_grip(body, 0)?;
            sender.send(&haptics.refresh(&mut simulation, body, &coupling)?);
        }
        device.join().map_err(|_| "the device has stopped".into())
    });
    let forces: Vec<DVec3> = forces.map_err(|error: Box<dyn std::error::Error>| error)?;

    simulation.settle(0.0, 1e-8)?;
    let simulated = simulation.world().get::<&Grips>(body.entity())?.pinches[0].force;
    let felt = forces.last().copied().ok_or("no force was felt")?;
    println!(
        "{} forces in {} steps; at the end {felt:.4} N, simulated {simulated:.4} N",
        forces.len(),
        simulation.report().step
    );
    assert!(felt.distance(simulated) < 0.05 * simulated.length(), "{felt} against {simulated}");
    Ok(())
}

/// The device: moves the hand, then rests until the simulation has caught up. Returns the forces on the tissue \[N\].
fn device(receiver: &HapticReceiver, start: DVec3, hand: &Mutex<DVec3>) -> Vec<DVec3> {
    let (mut forces, mut last, mut models_at_rest) = (Vec::new(), 0.0, 0);
    let mut blend = HapticBlend::new(5.0);
    for tick in 0.. {
        let at = LIFT * (f64::from(tick.min(TICKS)) / f64::from(TICKS));
        if let Ok(mut hand) = hand.lock() {
            *hand = at;
        }
        if let Some(model) = receiver.latest() {
            blend.hand_over(&model);
            // A real device says how long it has been since the last tick.
            forces.extend(blend.force_at(1.0, start + at));
            models_at_rest += u32::from(tick > TICKS && model.time > last);
            last = model.time;
        }
        if models_at_rest > 40 {
            break;
        }
        thread::sleep(Duration::from_millis(1));
    }
    forces
}
