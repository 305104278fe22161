//! Every verification case as a test of its own, so that they run side by side.

use rhexis_lab::verify::{Artifacts, CASES, Depth};

fn passes(name: &str) {
    let case = CASES.iter().find(|case| case.name == name).unwrap();
    let rows = (case.run)(&Artifacts { directory: None, depth: Depth::Quick }).unwrap();
    assert!(!rows.is_empty());
    for row in &rows {
        println!("{:12} {:90} {:9.2e} of {:7.1e} {}", row.case, row.what, row.error, row.tolerance, row.unit);
    }
    let failed: Vec<_> = rows.iter().filter(|row| !row.passes()).collect();
    assert!(failed.is_empty(), "{failed:#?}");
}

macro_rules! cases {
    ($($test:ident $name:literal),* $(,)?) => {
        $( #[test] fn $test() { passes($name); } )*

        #[test]
        fn no_case_is_left_out() {
            assert_eq!(CASES.iter().map(|case| case.name).collect::<Vec<_>>(), [$($name),*]);
        }
    };
}

cases! {
    constitutive "constitutive",
    patch "patch",
    free_triangle "free-triangle",
    cook "cook",
    fig2_small "fig2-small",
    hole "hole",
    fig2_large "fig2-large",
    fig2_dynamic "fig2-dynamic",
    dynamics "dynamics",
    membrane "membrane",
    motion "motion",
    integrator "integrator",
    stability "stability",
    time_relaxation "time-relaxation",
    time_limits "time-limits",
    time_creep "time-creep",
    time_rate "time-rate",
    time_cycle "time-cycle",
    time_spin "time-spin",
    bed_peel "bed-peel",
    compartment_laplace "compartment-laplace",
    compartment_gas "compartment-gas",
    compartment_bulge "compartment-bulge",
    compartment_orifice "compartment-orifice",
    compartment_hole "compartment-hole",
    contact_balance "contact-balance",
    contact_landing "contact-landing",
    contact_friction "contact-friction",
    contact_layers "contact-layers",
    contact_flap "contact-flap",
    tear_fibre "tear-fibre",
    tear_mesh "tear-mesh",
    tear_mesh_stable "tear-mesh-stable",
    tear_mesh_edge "tear-mesh-edge",
    tear_quality "tear-quality",
    tear_symmetry "tear-symmetry",
    tear_shape "tear-shape",
    tear_time_step "tear-time-step",
    tear_energy "tear-energy",
    tear_tip_stress "tear-tip-stress",
    tear_release "tear-release",
    tear_load "tear-load",
    tear_kink "tear-kink",
    tear_strip "tear-strip",
    tear_start "tear-start",
    tear_trouser "tear-trouser",
    tear_trouser_mesh "tear-trouser-mesh",
    tear_trouser_fibre "tear-trouser-fibre",
    tear_hand_force "tear-hand-force",
    tear_rate "tear-rate",
    tear_flap "tear-flap",
    tear_turn "tear-turn",
    tear_two_points "tear-two-points",
}
