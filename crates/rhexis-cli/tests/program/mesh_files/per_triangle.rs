//! What a scene gives its triangles, from arrays of the mesh file, lists and text files.

use super::reading::{MATERIAL, refusal, scene, summary};
use super::samples::VTU;
use rhexis::math::Sym2;
use rhexis::storage::Triangles;

/// Strength, toughness and pre-stretch from arrays, lists and files, in place of the body's own; what is not given follows.
#[test]
fn what_differs_from_triangle_to_triangle() {
    let array = "<DataArray type=\"Float64\" Name=\"s\" format=\"ascii\">0.5 NaN</DataArray>\
        <DataArray type=\"Float64\" Name=\"e\" NumberOfComponents=\"3\" format=\"ascii\">0.1 0.02 0.01 0 0 0</DataArray></CellData>";
    let file = VTU.replace("</CellData>", array);
    let files = [("a.vtu", file.as_str()), ("t.txt", "# a line each\n0.5\n2 # the second\n")];
    let mesh = format!("mesh = {{ file = \"a.vtu\" }}\n{MATERIAL}");
    let strong = "[bodies.tearing]\nstrength_along_fibres = 1\nstrength_ratio = 3\nradius = 1\n";
    let tough = "[bodies.tearing]\ntoughness_along_fibres = 0.1\ntoughness_across_fibres = 0.3\nradius = 1\n";
    let of = |per_triangle: &str, more: &str| {
        let lines = format!("{mesh}per_triangle = {{ {per_triangle} }}\n{more}");
        let instance = scene(&files, &lines).unwrap().instantiate().unwrap_or_else(|error| panic!("{error}"));
        let triangles = instance.simulation.world().get::<&Triangles>(instance.bodies[0].entity()).unwrap();
        [0, 1].map(|t| (triangles.strength[t], triangles.toughness[t], triangles.pre_stretch[t]))
    };
    let none = Sym2::ZERO;
    // NaN is the body's own; strengths of a body that energy does not tear leave toughnesses alone.
    assert_eq!(of("strength = \"s\"", strong), [(0.5, 1.0, none), (1.0, 1.0, none)]);
    assert_eq!(of("strength = [0.5, 2]", strong), [(0.5, 1.0, none), (2.0, 1.0, none)]);
    assert_eq!(of("strength = { file = \"t.txt\" }", strong), [(0.5, 1.0, none), (2.0, 1.0, none)]);
    // A toughness that the strengths imply grows with their square, and strengths with the root of a toughness that implies them.
    let by_energy = format!("{strong}criterion = \"energy\"\n");
    assert_eq!(of("strength = [0.5, 2]", &by_energy), [(0.5, 0.25, none), (2.0, 4.0, none)]);
    let [(strength, toughness, _), _] = of("toughness = [0.025, 0.1]", tough);
    assert!((strength - 0.5).abs() < 1e-12 && (toughness - 0.25).abs() < 1e-12, "{strength} {toughness}");
    // Where the scene gives both, each is its own.
    let both =
        format!("{strong}[bodies.energy_criterion]\ntoughness_along_fibres = 0.2\ntoughness_across_fibres = 0.2\n");
    assert_eq!(of("strength = [0.5, 1]", &both), [(0.5, 1.0, none), (1.0, 1.0, none)]);
    assert_eq!(of("toughness = [0.1, 0.2]", &both), [(1.0, 0.5, none), (1.0, 1.0, none)]);
    // A pre-stretch stands in place of the body's.
    let own = "pre_stretch = [0.04, 0.02]\n";
    let [(.., first), (.., second)] = of("pre_stretch = \"e\"", own);
    assert!((first.xx - 0.06).abs() < 1e-15 && first.yy == 0.0 && first.xy == 0.01, "{first:?}");
    assert_eq!(second, Sym2::new(-0.04, -0.02, 0.0));
    let tensors = "pre_stretch = [[[0.1, 0.01], [0.01, 0.02]], [[0, 0], [0, 0]]]";
    assert_eq!(of(tensors, "")[0].2, Sym2::new(0.1, 0.02, 0.01));
    let lines = format!("{mesh}per_triangle = {{ strength = [0.5, 2] }}\n{strong}");
    let (_, text) = summary(&files, &lines);
    assert!(text.contains("per triangle: strength along the fibres 5.000e-1 to 2.000e0 MPa"), "{text}");
    for (per_triangle, more, told) in [
        ("strength = [1, 2, 3]", strong, "the list has 3 entries, and the mesh 2 triangles"),
        ("strength = [1, [2, 3]]", strong, "2 numbers for triangle 1, and 1 for the first"),
        ("strength = { file = \"u.txt\" }", strong, "u.txt"),
        ("strength = [1, 0]", strong, "the list has 0 at triangle 1"),
        ("toughness = [1, 1]", strong, "this body tears by its strengths"),
        ("strength = [1, 1]", "", "this body does not"),
        ("pre_stretch = [[1, 2, 3, 4], [1, 2, 3, 4]]", "", "not symmetric"),
        ("pre_stretch = [[1, 2, 3, 4, 5], [1, 2, 3, 4, 5]]", "", "5 numbers for a triangle"),
        (
            "pre_stretch = [0.1, 0]",
            "holzapfel_gasser_ogden = { k1 = 1, k2 = 10, degrees = 40 }\n",
            "takes one pre-stretch for the whole body",
        ),
    ] {
        let message = refusal(&files, &format!("{mesh}per_triangle = {{ {per_triangle} }}\n{more}"));
        assert!(message.contains(told), "{told}: {message}");
    }
}
