//! The law as scene files write it.

use rhexis::components::StiffeningFibres;
use rhexis_scene::Document;

#[test]
fn a_scene_names_its_constants() {
    let scene = |keys: &[&str]| {
        let mut document = Document::named("fig2-tear").unwrap();
        keys.iter().for_each(|key| document.set(key).unwrap());
        document.scene()
    };
    let law = ["bodies.0.stiffening_fibres.k1=3", "bodies.0.stiffening_fibres.k2=20"];
    let instance = scene(&law).unwrap().instantiate().unwrap();
    let found = instance.simulation.world().query::<&StiffeningFibres>().iter().copied().next();
    assert_eq!(found, Some(StiffeningFibres { k1: 3.0, k2: 20.0 }));
    let error = scene(&[law[0], "bodies.0.stiffening_fibres.k2=-1"]).and_then(|s| s.instantiate()).err().unwrap();
    assert!(error.to_string().contains("stiffening_fibres") && error.to_string().contains("1e-9"), "{error}");
}
