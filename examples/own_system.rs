//! A component and a system of one's own: a magnet that draws the tissue. `cargo run --release --example own_system`

use glam::DVec3;
use hecs::World;
use rhexis::components::{Curve, ExternalStiffness, Forces, Hold, Material, SolveResult};
use rhexis::generate;
use rhexis::math::Sym3;
use rhexis::membrane::Membrane;
use rhexis::schedule::Place;
use rhexis::schedule::StepContext;
use rhexis::settings::Settings;
use rhexis::simulation::Simulation;
use rhexis::storage::{Attached, Topology, Triangles, Vertices};

/// Draws every vertex towards a point, by a spring per rest area.
#[derive(Clone)]
struct Magnet {
    at: DVec3,
    /// \[N/mm³\].
    stiffness: f64,
    /// What it exerts \[N\], for whoever asks.
    force: DVec3,
}

/// Adds force and stiffness: implicit in the step, so that no strength makes it unstable.
fn magnet(world: &mut World, _: &StepContext) -> usize {
    type Query<'a> = (
        (&'a Vertices, &'a Triangles, &'a Topology, &'a SolveResult),
        (&'a mut Magnet, &'a mut Forces, &'a mut ExternalStiffness),
    );
    let mut count = 0;
    for ((vertices, triangles, topology, result), (magnet, forces, external)) in world.query_mut::<Query>() {
        // Asleep, or solved already.
        if !result.is_active() {
            continue;
        }
        count += 1;
        magnet.force = DVec3::ZERO;
        for (v, &position) in vertices.position.iter().enumerate() {
            let stiffness = magnet.stiffness * topology.vertex_area(triangles, v as u32);
            let pull = (magnet.at - position) * stiffness;
            forces.nodal[v] += pull;
            external.block[v] += Sym3::isotropic(stiffness);
            magnet.force += pull;
        }
    }
    count
}

/// Lifts a taut sheet.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut sheet = Membrane::new("sheet", generate::grid(20.0, 20.0, 20, 20)?, Material::allard_2009());
    let rim = sheet.select(|p| p.x == 0.0 || p.y == 0.0 || p.x == 20.0 || p.y == 20.0);
    let out = |row: u32| (sheet.mesh().positions[row as usize] - DVec3::new(10.0, 10.0, 0.0)) * 0.02;
    let members = Attached::new(rim.into_iter().map(|row| (row, out(row))));
    sheet = sheet
        .hold(Hold { name: "rim".into(), members, axes: [true; 3], curve: Curve::constant(1.0) })
        .with(Magnet { at: DVec3::new(10.0, 10.0, 30.0), stiffness: 1e-4, force: DVec3::ZERO })
        // There for the magnet; springs, grips, drag and contact bring it along.
        .with(ExternalStiffness::default());
    let mut simulation = Simulation::new(Settings::default())?;
    let body = simulation.spawn(sheet)?;
    simulation.insert_system(Place::After("contact"), "magnet", magnet)?;
    println!("{}", simulation.insert_system(Place::Before("slove"), "mistyped", magnet).unwrap_err());

    for _ in 0..20 {
        simulation.step(5.0)?;
    }
    simulation.settle(0.0, 1e-10)?;
    let report = simulation.report().systems.iter().find(|system| system.name == "magnet");
    let report = report.ok_or("the magnet is not in the report")?;
    println!("the magnet ran {} times in the static solve, in {:?}", report.bodies, report.time);
    let pull = simulation.world().get::<&Magnet>(body.entity())?.force;
    let reaction = simulation.reactions(body)?[0].1;
    let lifted = simulation.view(body)?.positions.iter().map(|x| x.z).fold(0.0, f64::max);
    println!("lifted by {lifted:.2} mm; the magnet pulls {pull:.4} N, the rim holds {reaction:.4} N");
    assert!(lifted > 1.0, "{lifted}");
    assert!((pull + reaction).length() < 1e-6 * pull.length(), "action is reaction");
    Ok(())
}
