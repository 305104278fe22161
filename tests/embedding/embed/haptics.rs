//! The linear model of the tissue at a tool, against the simulation itself.

use glam::{DMat3, DVec3};
use rhexis::components::{Curve, Fibres, Grip, Grips, Hold, Jaws, Material, Path};
use rhexis::generate;
use rhexis::membrane::Membrane;
use rhexis::settings::Settings;
use rhexis::simulation::{Coupling, HapticBlend, HapticError, Haptics, Simulation, ToolSpring};
use rhexis::storage::{Attached, BodyId, Vertices};

/// Stiffness of the pinch \[N/mm\]: of the order of the tissue's own under it.
const PINCH: f64 = 0.2;

/// A taut sheet clamped around, pinched in the middle and drawn to `hand` \[mm\] within 10 ms, then to wherever the path goes.
fn pinched(cells: usize, hand: DVec3) -> (Simulation, BodyId) {
    let mesh = generate::grid(20.0, 20.0, cells, cells).unwrap();
    let mut sheet = Membrane::new("sheet", mesh, Material::allard_2009()).fibres(Fibres::at_degrees(30.0));
    let rim = sheet.select(|p| p.x == 0.0 || p.y == 0.0 || p.x == 20.0 || p.y == 20.0);
    // Drawn out by 5 %, as a membrane in its frame is.
    let out = |row: u32| (sheet.mesh().positions[row as usize] - DVec3::new(10.0, 10.0, 0.0)) * 0.05;
    let members = Attached::new(rim.into_iter().map(|row| (row, out(row))));
    sheet = sheet.hold(Hold { name: "rim".into(), members, axes: [true; 3], curve: Curve::constant(1.0) });
    let grip = Grip {
        name: "forceps".into(),
        from: 1.0,
        until: f64::INFINITY,
        material_point: DVec3::new(9.0, 11.0, 0.0),
        near_tip: None,
        jaws: Jaws { radius: 0.8, stiffness: Some(PINCH), ..Jaws::default() },
        path: Path { points: vec![(1.0, DVec3::ZERO), (10.0, hand)] },
        turns: Path::default(),
    };
    let mut simulation = Simulation::new(Settings { threads: 1, ..Settings::default() }).unwrap();
    let body = simulation.spawn(sheet.with(Grips::new(vec![grip]))).unwrap();
    simulation.settle(1.0, 1e-9).unwrap();
    simulation.settle(9.0, 1e-9).unwrap();
    (simulation, body)
}

/// Draws the hand to a place and gives the force there in equilibrium.
fn force_at(simulation: &mut Simulation, body: BodyId, hand: DVec3) -> DVec3 {
    simulation.entity_mut::<&mut Grips>(body).unwrap().list[0].path.points[1].1 = hand;
    simulation.settle(0.0, 1e-9).unwrap();
    let coupling = simulation.coupling_of_grip(body, 0).unwrap();
    force(simulation, body, &coupling)
}

fn force(simulation: &Simulation, body: BodyId, coupling: &Coupling) -> DVec3 {
    let vertices = simulation.world().get::<&Vertices>(body.entity()).unwrap();
    let Coupling::Springs { springs, .. } = coupling else { panic!("a grip has springs") };
    let pull = |s: &ToolSpring| (s.point - vertices.position[vertices.row(s.vertex).unwrap() as usize]) * s.stiffness;
    springs.iter().map(pull).sum()
}

#[test]
fn the_model_is_within_5_percent_within_a_fifth_of_a_millimetre() {
    let mut worst = 0.0_f64;
    // Drawn aside and out of the plane, as forceps draw.
    for hand in [DVec3::new(0.6, -0.2, 0.5), DVec3::new(0.0, 0.0, 1.5), DVec3::new(-0.8, 0.4, 0.1)] {
        let (mut simulation, body) = pinched(24, hand);
        let coupling = simulation.coupling_of_grip(body, 0).unwrap();
        let model = Haptics::new(1000.0).model(&simulation, body, &coupling).unwrap();
        assert!(model.force.distance(force(&simulation, body, &coupling)) < 1e-12);
        for way in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z, DVec3::ONE.normalize()] {
            let moved = way * 0.2;
            let simulated = force_at(&mut simulation, body, hand + moved);
            let error = model.force_at(model.position + moved).distance(simulated) / simulated.length();
            println!("hand {hand}, {way}: {error:.4} of {:.4} N", simulated.length());
            worst = worst.max(error);
        }
    }
    assert!(worst < 0.05, "{worst}");
}

#[test]
fn the_stiffness_is_that_of_small_motions_and_gives_no_energy() {
    let hand = DVec3::new(0.5, 0.3, 0.4);
    let (mut simulation, body) = pinched(16, hand);
    let coupling = simulation.coupling_of_grip(body, 0).unwrap();
    let mut haptics = Haptics::new(1000.0);
    let model = haptics.model(&simulation, body, &coupling).unwrap();
    let s = model.stiffness;
    assert_eq!(s, s.transpose());
    for i in 0..60_i32 {
        let way = DVec3::new(f64::from(i * 37 % 11) - 5.0, f64::from(i * 17 % 13) - 6.0, f64::from(i * 5 % 7) - 3.0);
        let energy = way.dot(s * way) / way.length_squared();
        // Between nothing and the tool's own springs, but for the rounding of a sum of some hundred terms.
        assert!((-1e-12..=PINCH * (1.0 + 1e-9)).contains(&energy), "{energy}");
    }
    // Central differences of 0.01 mm are off by the third derivative, some 1e-6 of the stiffness; here nothing presses, where the
    // projected tangent would be stiffer.
    let columns = [DVec3::X, DVec3::Y, DVec3::Z].map(|way| {
        let ends = [1.0, -1.0].map(|sign| force_at(&mut simulation, body, hand + way * (0.01 * sign)));
        (ends[0] - ends[1]) / 0.02
    });
    let measured = DMat3::from_cols(columns[0], columns[1], columns[2]);
    let off = (s - measured).to_cols_array().into_iter().map(f64::abs).fold(0.0, f64::max);
    println!("model {s}\nmeasured {measured}");
    assert!(off < 1e-4 * PINCH, "{off}");
    // Over a short time masses resist as well: stiffer in every direction.
    let short = Haptics::new(1.0).model(&simulation, body, &coupling).unwrap().stiffness;
    for axis in 0..3 {
        assert!(short.col(axis)[axis] >= s.col(axis)[axis] - 1e-9);
    }
}

#[test]
fn pins_have_a_model_too() {
    let (mut simulation, body) = pinched(24, DVec3::ZERO);
    let view = simulation.view(body).unwrap();
    let near = |p: &DVec3| p.distance(DVec3::new(5.0, 5.0, 0.0)) < 1.0;
    let keys: Vec<_> =
        view.vertex_keys.iter().zip(view.rest_positions).filter(|(_, p)| near(p)).map(|(k, _)| *k).collect();
    simulation.pin(body, "tool", &keys).unwrap();
    simulation.move_pins(body, "tool", |pin| pin.place + DVec3::new(0.3, 0.1, 0.8)).unwrap();
    simulation.settle(0.0, 1e-9).unwrap();
    let coupling = simulation.coupling_of_pins(body, "tool").unwrap();
    let model = Haptics::new(1000.0).model(&simulation, body, &coupling).unwrap();
    let mut worst = 0.0_f64;
    for way in [DVec3::X, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z] {
        let by = |simulation: &mut Simulation, d: DVec3| {
            simulation.move_pins(body, "tool", |pin| pin.place + d).unwrap();
            simulation.settle(0.0, 1e-9).unwrap();
        };
        by(&mut simulation, way * 0.2);
        let Coupling::Pins { force, .. } = simulation.coupling_of_pins(body, "tool").unwrap() else { panic!("pins") };
        by(&mut simulation, way * -0.2);
        let error = model.force_at(model.position + way * 0.2).distance(force) / force.length();
        println!("{way}: {error:.4} of {:.4} N", force.length());
        worst = worst.max(error);
    }
    assert!(worst < 0.05, "{worst}");
}

/// Moves the hand and steps.
fn step_to(simulation: &mut Simulation, body: BodyId, hand: DVec3) {
    simulation.entity_mut::<&mut Grips>(body).unwrap().list[0].path.points[1].1 = hand;
    simulation.step(5.0).unwrap();
}

/// Passes over the body's operator that a refreshed model may take: one product for each answer and three iterations.
const REFRESHED: u32 = 6;

#[test]
fn refreshed_models_stay_near_those_made_anew_at_a_part_of_their_cost() {
    let (mut simulation, body) = pinched(24, DVec3::ZERO);
    let mut haptics = Haptics::new(5.0);
    let coupling = simulation.coupling_of_grip(body, 0).unwrap();
    haptics.model(&simulation, body, &coupling).unwrap();
    assert!(haptics.work() > REFRESHED, "{}", haptics.work());
    for i in 1..60 {
        let part = f64::from(i) / 60.0;
        step_to(&mut simulation, body, DVec3::new(0.6, -0.3, 1.2) * part);
        let coupling = simulation.coupling_of_grip(body, 0).unwrap();
        let model = haptics.refresh(&mut simulation, body, &coupling).unwrap();
        assert!(haptics.work() <= REFRESHED, "{}", haptics.work());
        let anew = Haptics::new(5.0).model(&simulation, body, &coupling).unwrap();
        assert!(model.force == anew.force && model.position == anew.position);
        let off = (model.stiffness - anew.stiffness).to_cols_array().into_iter().map(f64::abs).fold(0.0, f64::max);
        // A hand feels some per cent; the refreshed one is of the operator at the start of the step, in which the tissue moves by a fiftieth
        // of its way.
        assert!(off < 0.05 * PINCH, "step {i}: {} instead of {}", model.stiffness, anew.stiffness);
        let energies = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::ONE].map(|way| way.dot(model.stiffness * way));
        assert!(energies.iter().all(|energy| *energy >= 0.0), "{energies:?}");
    }
}

#[test]
fn refreshed_models_go_on_through_cuts() {
    let (mut simulation, body) = pinched(24, DVec3::ZERO);
    let mut haptics = Haptics::new(5.0);
    for i in 1..30 {
        step_to(&mut simulation, body, DVec3::new(0.0, 0.0, 0.05) * f64::from(i));
        if i % 3 == 0 {
            let at = |x: f64| DVec3::new(2.0 + x, 6.1 + 0.02 * x, 0.0);
            let x = 0.4 * f64::from(i);
            simulation.cut(body, &[at(x), at(x + 1.3)]).unwrap();
        }
        let coupling = simulation.coupling_of_grip(body, 0).unwrap();
        let model = haptics.refresh(&mut simulation, body, &coupling).unwrap();
        let anew = Haptics::new(5.0).model(&simulation, body, &coupling).unwrap();
        let off = (model.stiffness - anew.stiffness).to_cols_array().into_iter().map(f64::abs).fold(0.0, f64::max);
        // Right after a cut it has the stiffness of before.
        assert!(off < 0.1 * PINCH, "step {i}: {} instead of {}", model.stiffness, anew.stiffness);
    }
}

#[test]
fn a_blend_neither_jumps_nor_gives_energy() {
    let (mut simulation, body) = pinched(16, DVec3::ZERO);
    let (mut haptics, mut blend) = (Haptics::new(5.0), HapticBlend::new(5.0));
    let coupling = simulation.coupling_of_grip(body, 0).unwrap();
    let start = haptics.model(&simulation, body, &coupling).unwrap();
    blend.hand_over(&start);
    let hand = |tick: u32| {
        // Rounds that begin and end at rest.
        let part = f64::from(tick) * std::f64::consts::TAU / 400.0;
        let angle = part - part.sin();
        DVec3::new(0.8 * angle.sin(), 0.4 * (2.0 * angle).sin(), 0.6 * (1.0 - angle.cos()))
    };
    let (mut work, mut last) = (0.0, (start.position, DVec3::ZERO));
    let mut raw = 0.0_f64;
    for tick in 0..=800 {
        let at = start.position + hand(tick);
        if tick % 5 == 0 {
            step_to(&mut simulation, body, hand(tick));
            let coupling = simulation.coupling_of_grip(body, 0).unwrap();
            let model = haptics.refresh(&mut simulation, body, &coupling).unwrap();
            let before = blend.model().unwrap().force_at(at);
            raw = raw.max(model.force_at(at).distance(before));
            blend.hand_over(&model);
            assert!(blend.model().unwrap().force_at(at).distance(before) < 1e-12);
        }
        let force = blend.force_at(1.0, at).unwrap();
        let way = at - last.0;
        work += 0.5 * (force + last.1).dot(way);
        last = (at, force);
        if tick % 400 == 0 && tick > 0 {
            println!(
                "after {tick} ms: {work:.3e} mJ put in, {:.3e} withheld; largest jump of models {raw:.2e} N",
                blend.withheld()
            );
            // It starts from rest: its motions grow by 2e-4 mm from call to call, under less than 0.1 N.
            assert!(work > -1e-5, "{work}");
        }
    }
}

#[test]
fn what_holds_nothing_has_no_model() {
    let (mut simulation, body) = pinched(8, DVec3::X * 0.2);
    let mut haptics = Haptics::new(1000.0);
    assert_eq!(simulation.coupling_of_grip(body, 1), Err(HapticError::NotClosed(1)));
    let nothing = Coupling::Springs { springs: Vec::new(), is_in_steps: false };
    assert_eq!(haptics.model(&simulation, body, &nothing), Err(HapticError::HoldsNothing));
    let nothing = Coupling::Pins { pins: Vec::new(), force: DVec3::X };
    assert_eq!(haptics.model(&simulation, body, &nothing), Err(HapticError::HoldsNothing));
    assert!(matches!(simulation.coupling_of_pins(body, "tool"), Err(HapticError::Pins(_))));
    let Coupling::Springs { springs, .. } = simulation.coupling_of_grip(body, 0).unwrap() else { panic!() };
    let vertex = springs[0].vertex;
    let tool = |stiffness: f64| {
        let point = DVec3::new(9.0, 11.0, 1.0);
        Coupling::Springs { springs: vec![ToolSpring { vertex, point, stiffness }], is_in_steps: false }
    };
    for bad in [0.0, -1.0, f64::NAN] {
        assert_eq!(haptics.model(&simulation, body, &tool(bad)), Err(HapticError::BadSpring(vertex)));
    }
    // A tool of one's own that no component knows of: through a cut as well.
    let tool = tool(0.1);
    let whole = haptics.model(&simulation, body, &tool).unwrap();
    simulation.cut(body, &[DVec3::new(0.0, 10.1, 0.0), DVec3::new(8.0, 10.1, 0.0)]).unwrap();
    let cut = haptics.model(&simulation, body, &tool).unwrap();
    assert!(cut.stiffness.is_finite() && cut.stiffness != whole.stiffness);
    simulation.despawn(body).unwrap();
    assert_eq!(haptics.model(&simulation, body, &tool), Err(HapticError::NoSuchBody));
}
