//! Contact: forces that balance, friction by Coulomb's law, layers that bear each other and do not pass.

use super::bodies;
use super::{Artifacts, Row, Rows, VerifyError, largest};
use glam::{DMat3, DVec3};
use rhexis::components::{Bending, Contact, Curve, Damping, Drag, Gravity, Hold, Material, SelfContact, Shape};
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::settings::Settings;
use rhexis::simulation::{Simulation, Solid};
use rhexis::storage::{BodyId, TriangleMesh, Triangles, Vertices};
use rhexis_scene::Scene;

/// Earth's \[mm/ms²\].
const GRAVITY: f64 = 9.81e-3;

/// Time steps \[ms\].
const STEPS: [f64; 3] = [1.0, 5.0, 16.0];

/// Meshes or time steps of a case: all, or the one in the middle.
fn of<'a, T>(out: &Artifacts, all: &'a [T]) -> &'a [T] {
    let middle = all.len() / 2;
    if out.is_quick() { &all[middle..=middle] } else { all }
}

fn tissue() -> Material {
    Material::isotropic(3.0, 0.3, 0.1)
}

fn bare() -> Settings {
    Settings { threads: 1, ..Settings::default() }
}

/// A sheet of 8 mm on a plane whose normal is z, under gravity that stands at an angle to it.
fn on_slope(degrees: f64, friction: f64, side: usize) -> Result<(Simulation, BodyId), VerifyError> {
    let angle = degrees.to_radians();
    let acceleration = DVec3::new(angle.sin(), 0.0, -angle.cos()) * GRAVITY;
    let sheet = Membrane::new("sheet", generate::grid(8.0, 8.0, side, side)?, tissue())
        .with(Gravity { acceleration })
        .with(Contact { friction, ..Contact::default() });
    let (mut simulation, body) = bodies::simulate(bare(), sheet)?;
    simulation.spawn_obstacle(Solid::new(Shape::Plane { point: DVec3::ZERO, normal: DVec3::Z }))?;
    Ok((simulation, body))
}

/// Mean position and velocity along the slope.
fn along(simulation: &Simulation, body: BodyId) -> [f64; 2] {
    let Ok(vertices) = simulation.world().get::<&Vertices>(body.entity()) else { return [f64::NAN; 2] };
    let mean = |values: &[DVec3]| values.iter().map(|value| value.x).sum::<f64>() / values.len() as f64;
    [mean(&vertices.position), mean(&vertices.velocity)]
}

/// Steps until a time \[ms\], which is returned.
fn run_for(simulation: &mut Simulation, dt: f64, time: f64) -> Result<f64, VerifyError> {
    let steps = (time / dt).round();
    for _ in 0..steps as u32 {
        simulation.step(dt)?;
    }
    Ok(steps * dt)
}

pub(super) fn friction(out: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("contact-friction");
    for &side in of(out, &[6, 9, 14]) {
        for dt in STEPS {
            let on = format!("{side} × {side} squares, dt {dt} ms");
            // The angle of friction is 16.70 degrees.
            let (mut simulation, body) = on_slope(16.0, 0.3, side)?;
            run_for(&mut simulation, dt, 400.0)?;
            let [before, _] = along(&simulation, body);
            run_for(&mut simulation, dt, 800.0)?;
            // Rounding of positions; a regularised law creeps by .2 mm.
            rows.add(
                format!("16° at μ .3: creep in .8 s, {on}"),
                (along(&simulation, body)[0] - before).abs(),
                1e-9,
                "mm",
            );
            for (degrees, friction) in [(18.0_f64, 0.3), (45.0, 0.5)] {
                let (mut simulation, body) = on_slope(degrees, friction, side)?;
                let time = run_for(&mut simulation, dt, 480.0)?;
                let angle = degrees.to_radians();
                let wanted = GRAVITY * (angle.sin() - friction * angle.cos()) * time;
                let [_, speed] = along(&simulation, body);
                // The step in which the sheet comes to lie on the plane may be lost, one of thirty at 16 ms.
                rows.relative(format!("{degrees}° at μ {friction}: speed, {on}"), speed, wanted, 0.05);
            }
        }
    }
    rows.finish()
}

/// A skin that is held at its rim and pushed by an obstacle.
const PUSHED: &str = r#"
[scene]
name = "pushed"
allow = ["hasty-motion"]
[run]
dt = DT
steps = 1000000
advanced.linear_tolerance = TOLERANCE
[[bodies]]
name = "skin"
mesh = { grid = { width = 20, height = 20, nx = SIDE, ny = SIDE } }
material = { young = 1, poisson = 0.4, thickness = 0.2 }
bending = {}
damping = 2
drag = 1e-5
contact = { friction = 0.2 }
[[bodies.holds]]
name = "rim"
region = { boundary = true }
[[obstacles]]
OBSTACLE
path = [[0, [0, 0, 0]], [240, [0, 0, 3]], [300, [0, 0, 3]]]
"#;

pub(super) fn balance(out: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("contact-balance");
    let obstacles = [
        ("sphere", "sphere = { centre = [10.1, 9.8, -3.01], radius = 3 }"),
        ("capsule", "capsule = { from = [7, 9.8, -1.01], to = [13, 10.4, -1.01], radius = 1 }"),
        ("thin cylinder", "cylinder = { from = [10.33, 10.4, -8.05], to = [10.33, 10.4, -0.05], radius = 0.2 }"),
        ("box", "box = { centre = [10.2, 9.9, -1.03], half = [3, 2, 1] }"),
    ];
    for (name, obstacle) in obstacles {
        for (side, dt) in
            of(out, &[20, 16, 28]).iter().flat_map(|side| of(out, &STEPS).iter().map(move |dt| (side, dt)))
        {
            let text = PUSHED.replace("OBSTACLE", obstacle).replace("SIDE", &side.to_string());
            let text = text.replace("DT", &dt.to_string());
            let what = format!(
                "{name}: all forces less d(momentum)/dt, over the largest, {side} × {side} squares, dt {dt} ms"
            );
            let [off, rest] = pushed(&text.replace("TOLERANCE", "1e-8"))?;
            rows.ratio(what.as_str(), off, 1e-3);
            // Friction and damping bear a part of it while the obstacle moves; one that pierces the skin bears nothing.
            let what_rests = format!("{name}: force at rest over the largest, {side} × {side} squares, dt {dt} ms");
            rows.relative(what_rests, rest, 1.0, 0.15);
            if !out.is_quick() {
                // Contacts are stiff: a small residual of the solve is a large force of theirs.
                let [off, _] = pushed(&text.replace("TOLERANCE", "1e-4"))?;
                rows.note(format!("{what}, by default"), off, "1");
            }
        }
    }
    rows.finish()
}

/// Largest unbalanced force over 400 ms of a scene, and the obstacle's force at the end, over its largest.
fn pushed(text: &str) -> Result<[f64; 2], VerifyError> {
    let mut instance = Scene::parse(text, "contact-balance")?.instantiate()?;
    let (mut off, mut most, mut last) = (0.0_f64, 0.0_f64, 0.0_f64);
    while instance.simulation.time() < 400.0 {
        instance.advance()?;
        for &body in &instance.bodies {
            off = largest([off, instance.simulation.unbalanced_force(body)?.unwrap_or(DVec3::NAN).length()]);
            let forces = instance.simulation.contact_forces(body)?;
            last = forces.iter().map(|(_, force)| force.length()).sum();
            most = most.max(last);
        }
    }
    // Where nothing is felt there is nothing to balance.
    Ok([off, last].map(|force| if most > 1e-3 { force / most } else { f64::NAN }))
}

/// A sheet thrown onto a table.
const THROWN: &str = r#"
[scene]
name = "thrown"
[run]
dt = DT
steps = 1000000
[[bodies]]
name = "sheet"
mesh = { grid = { width = 20, height = 20, nx = SIDE, ny = SIDE } }
material = { young = 1, poisson = 0.4, thickness = 0.2 }
bending = {}
damping = 5
gravity = [0, 0, -9.81e-3]
contact = { friction = 0.3 }
initial = { velocity = [0, 0, -0.05] }
[[obstacles]]
plane = { point = [0, 0, -0.5], normal = [0, 0, 1] }
"#;

pub(super) fn landing(out: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("contact-landing");
    let (mass, speed, time) = (0.08, 0.05, 592.0);
    for (side, dt) in of(out, &[10, 16, 24]).iter().flat_map(|side| STEPS.map(|dt| (side, dt))) {
        let text = THROWN.replace("SIDE", &side.to_string()).replace("DT", &dt.to_string());
        let mut instance = Scene::parse(&text, "contact-landing")?.instantiate()?;
        let (mut impulse, mut last) = (0.0, 0.0);
        while instance.simulation.time() < time - 1e-9 {
            instance.advance()?;
            let forces = instance.simulation.contact_forces(instance.bodies[0])?;
            last = forces.iter().map(|(_, force)| force.z).sum();
            impulse += last * dt;
        }
        let on = format!("{side} × {side} squares, dt {dt} ms");
        // Of a step taken in parts the forces are those of its last part.
        let wanted = mass * (speed + GRAVITY * instance.simulation.time());
        rows.relative(format!("impulse of the table against m·(v + g·t), {on}"), impulse, wanted, 0.01);
        rows.relative(format!("force at rest against the weight, {on}"), last, mass * GRAVITY, 1e-3);
    }
    rows.finish()
}

/// Adds a mesh to another as a piece of its own, each vertex moved.
fn add(mesh: &mut TriangleMesh, piece: &TriangleMesh, place: impl Fn(DVec3) -> DVec3) {
    let first = mesh.positions.len() as u32;
    mesh.positions.extend(piece.positions.iter().map(|p| place(*p)));
    mesh.triangles.extend(piece.triangles.iter().map(|corners| corners.map(|v| first + v)));
}

fn empty() -> TriangleMesh {
    TriangleMesh { positions: Vec::new(), triangles: Vec::new(), fibres: None }
}

/// Contact of a body with itself.
fn itself(radius: f64, band: f64) -> Contact {
    Contact { self_contact: Some(SelfContact { radius, band: Some(band) }), ..Contact::default() }
}

pub(super) fn layers(out: &Artifacts) -> Result<Vec<Row>, VerifyError> {
    let mut rows = Rows::new("contact-layers");
    for (side, dt) in of(out, &[7, 9, 12]).iter().flat_map(|side| [5.0, 16.0].map(|dt| (*side, dt))) {
        stacked(&mut rows, side, dt)?;
    }
    for &(side, dt) in of(out, &[(36, 20.0), (40, 10.0), (40, 20.0), (48, 5.0)]) {
        drawn_through(&mut rows, side, dt)?;
    }
    for (&(side, ratio), dt) in of(out, &[(9, 1.0), (7, 0.1), (12, 10.0)]).iter().flat_map(|of| [(of, 5.0), (of, 16.0)])
    {
        collided(&mut rows, (side, ratio), dt)?;
    }
    rows.finish()
}

/// A sheet thrown at another that floats, two bodies: an impact in one step is inelastic, and momentum is kept.
fn collided(rows: &mut Rows, (side, ratio): (usize, f64), dt: f64) -> Result<(), VerifyError> {
    let speed = DVec3::new(0.01, 0.0, -0.05);
    let sheet = |name: &str, size: f64, cells: usize, at: DVec3, density: f64| -> Result<Membrane, VerifyError> {
        let mut mesh = empty();
        add(&mut mesh, &generate::grid(size, size, cells, cells)?, |p| p + at);
        let material = Material { density, ..tissue() };
        let contact = Contact { between_bodies: true, ..itself(0.05, 0.0) };
        Ok(Membrane::new(name, mesh, material).with(Bending::default()).with(contact))
    };
    let mut simulation = Simulation::new(bare())?;
    let lower = simulation.spawn(sheet("lower", 10.0, 12, DVec3::ZERO, 1e-3)?)?;
    let upper = simulation.spawn(sheet("upper", 8.0, side, DVec3::new(1.13, 0.87, 0.9), 1e-3 * ratio)?)?;
    if let Ok(mut vertices) = simulation.world_mut().get::<&mut Vertices>(upper.entity()) {
        vertices.velocity.fill(speed);
    }
    let momentum = |simulation: &Simulation, body: BodyId| -> (DVec3, f64) {
        simulation.world().get::<&Vertices>(body.entity()).map_or((DVec3::NAN, f64::NAN), |vertices| {
            let of = vertices.velocity.iter().zip(&vertices.mass).map(|(v, m)| *v * *m).sum();
            (of, vertices.mass.iter().sum())
        })
    };
    let (before, mass) = momentum(&simulation, upper);
    run_for(&mut simulation, dt, 400.0)?;
    let [(of_lower, other), (of_upper, _)] = [lower, upper].map(|body| momentum(&simulation, body));
    let on = format!("mass ratio {ratio}, {side} × {side} squares, dt {dt} ms");
    let off = (of_lower + of_upper - before).length() / before.length();
    rows.add(format!("two bodies collide: momentum lost, {on}"), off, 1e-3, "");
    // Their edges do not leave at quite one speed.
    rows.relative(
        format!("momentum of the one that was hit, {on}"),
        of_lower.z / before.z,
        other / (mass + other),
        0.03,
    );
    Ok(())
}

/// Two sheets on a held one: the hold bears all three, and each sheet lies above the one below.
fn stacked(rows: &mut Rows, side: usize, dt: f64) -> Result<(), VerifyError> {
    let radius = 0.05;
    let mut mesh = empty();
    add(&mut mesh, &generate::grid(24.0, 12.0, 24, 12)?, |p| p);
    let held = mesh.positions.len();
    let sheet = generate::grid(8.0, 8.0, side, side)?;
    for k in [1.0, 2.0] {
        add(&mut mesh, &sheet, |p| p + DVec3::new(2.0 + 0.07 * k, 2.1 - 0.05 * k, 0.04 * k));
    }
    let sheets = Membrane::new("sheets", mesh, tissue())
        .with(Gravity { acceleration: DVec3::NEG_Z * GRAVITY })
        .with(Bending::default())
        .with(Damping { time: 5.0 })
        .with(Drag { coefficient: 1e-4 })
        .with(itself(radius, 0.0))
        .hold(Hold::new("lower", 0..held as u32));
    let (mut simulation, body) = bodies::simulate(bare(), sheets)?;
    run_for(&mut simulation, dt, 2000.0)?;
    let on = format!("{side} × {side} squares, dt {dt} ms");
    let Ok(vertices) = simulation.world().get::<&Vertices>(body.entity()) else { return Ok(()) };
    let weight = vertices.mass.iter().sum::<f64>() * GRAVITY;
    let borne = simulation.reactions(body)?.first().map_or(f64::NAN, |(_, force)| force.z);
    // Residual of the solve, and the sheets' last motion.
    rows.relative(format!("three sheets: the lowest one's hold bears their weight, {on}"), borne, weight, 1e-4);
    let count = sheet.positions.len();
    for (layer, z) in vertices.position[held..].chunks(count).enumerate() {
        let mean = z.iter().map(|p| p.z).sum::<f64>() / count as f64;
        // Repulsion begins at the radius, and a sheet as light as this sinks by little of it.
        let wanted = radius * (layer + 1) as f64;
        rows.add(format!("sheet {} above its place, {on}", layer + 1), (mean - wanted).abs(), 0.02 * radius, "mm");
    }
    Ok(())
}

/// A ribbon that is drawn through a slot, down and aside: no edge passes through a triangle.
fn drawn_through(rows: &mut Rows, side: usize, dt: f64) -> Result<(), VerifyError> {
    let (band, time) = (0.78, 2000.0);
    let mut sheet = generate::grid(20.0, 20.0, side, side)?;
    let middle = |corners: &[u32; 3]| corners.map(|v| sheet.positions[v as usize]).iter().sum::<DVec3>() / 3.0;
    let is_kept = |corners: &[u32; 3]| {
        let p = middle(corners);
        (p.x - 10.0).abs() > 0.5 || (p.y - 10.0).abs() > 2.5
    };
    sheet.triangles = sheet.triangles.iter().copied().filter(is_kept).collect();
    let mut of = vec![u32::MAX; sheet.positions.len()];
    let mut kept = Vec::new();
    for v in sheet.triangles.iter_mut().flatten() {
        let place = &mut of[*v as usize];
        if *place == u32::MAX {
            *place = kept.len() as u32;
            kept.push(sheet.positions[*v as usize]);
        }
        *v = *place;
    }
    sheet.positions = kept;
    let mut mesh = empty();
    add(&mut mesh, &sheet, |p| p);
    let first = mesh.positions.len();
    add(&mut mesh, &generate::grid(3.6, 20.0, 8, 44)?, |p| DVec3::new(10.013, p.x + 8.217, p.y - 0.93));
    let is_rim = |p: &DVec3| [p.x, p.y].iter().any(|c| *c == 0.0 || *c == 20.0);
    let rim: Vec<u32> = (0..).zip(&sheet.positions).filter(|(_, p)| is_rim(p)).map(|(v, _)| v).collect();
    let end = (first as u32..).zip(&mesh.positions[first..]).filter(|(_, p)| p.z < -0.9).map(|(v, _)| v);
    let end: Vec<u32> = end.collect();
    let way = Curve::ramp(time, 1.0).unwrap_or_else(|_| Curve::constant(1.0));
    let body = Membrane::new("slot", mesh, Material::isotropic(3.0, 0.3, 0.05))
        .with(Damping { time: 1.0 })
        .with(Drag { coefficient: 1e-4 })
        .with(Gravity { acceleration: DVec3::NEG_Z * 1e-4 })
        .with(Bending::default())
        .with(itself(0.05, band))
        .hold(Hold::new("rim", rim))
        .hold(Hold::new("end", end).moved(DVec3::new(5.0, 0.0, -12.0), way));
    let (mut simulation, body) = bodies::simulate(bare(), body)?;
    let (mut most, mut touching) = (0, 0);
    for step in 0..(time / dt) as u32 {
        touching = touching.max(simulation.step(dt)?.bodies[0].self_contacts);
        if step % 4 == 3 {
            most = most.max(crossings(&simulation, body, band));
        }
    }
    // A ribbon that touches nothing shows nothing.
    let most = if touching > 20 { f64::from(most) } else { f64::NAN };
    rows.add(format!("ribbon through a slot of {side} × {side} squares, dt {dt} ms: crossings"), most, 0.0, "");
    Ok(())
}

/// Edges through triangles all of whose corners are farther from theirs than the band in the rest shape: all that overlap along x, by solving for the
/// point.
pub(super) fn crossings(simulation: &Simulation, body: BodyId, band: f64) -> u32 {
    let world = simulation.world();
    let tables = (world.get::<&Vertices>(body.entity()), world.get::<&Triangles>(body.entity()));
    let (Ok(vertices), Ok(triangles)) = tables else { return u32::MAX };
    let (x, rest) = (&vertices.position, &vertices.rest_position);
    let mut edges: Vec<[u32; 2]> = Vec::new();
    for [a, b, c] in &triangles.corners {
        edges.extend([[a, b], [b, c], [c, a]].map(|[p, q]| [*p.min(q), *p.max(q)]));
    }
    edges.sort_unstable();
    edges.dedup();
    let low_of = |edge: &[u32; 2]| edge.map(|v| x[v as usize].x).into_iter().fold(f64::INFINITY, f64::min);
    edges.sort_by(|a, b| low_of(a).total_cmp(&low_of(b)));
    let longest = edges.iter().map(|edge| (x[edge[0] as usize].x - x[edge[1] as usize].x).abs()).fold(0.0, f64::max);
    let is_near = |v: u32, w: u32| rest[v as usize].distance(rest[w as usize]) < band;
    let mut count = 0;
    for corners in &triangles.corners {
        let [a, b, c] = corners.map(|v| x[v as usize]);
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let first = edges.partition_point(|edge| low_of(edge) < low.x - longest);
        for edge in edges[first..].iter().take_while(|edge| low_of(edge) <= high.x) {
            let [p, q] = edge.map(|v| x[v as usize]);
            let is_apart = p.max(q).cmplt(low).any() || p.min(q).cmpgt(high).any();
            if is_apart || edge.iter().any(|&v| corners.iter().any(|&w| v == w || is_near(v, w))) {
                continue;
            }
            // p + t·(q − p) = a + u·(b − a) + v·(c − a)
            let matrix = DMat3::from_cols(p - q, b - a, c - a);
            if matrix.determinant() == 0.0 {
                continue;
            }
            let at = matrix.inverse() * (p - a);
            let is_inside = at.y > 0.0 && at.z > 0.0 && at.y + at.z < 1.0;
            count += u32::from(is_inside && at.x > 0.0 && at.x < 1.0);
        }
    }
    count
}
