"""Worlds, bodies, components, settings, errors."""

from __future__ import annotations

import threading
import warnings

import numpy as np
import pytest
from conftest import grid, refused

import rhexis


def test_a_body_from_arrays_has_its_arrays(world: rhexis.World) -> None:
    positions, triangles = grid(3)
    body = world.spawn(positions, triangles, name="sheet")
    assert world.bodies == [body] and world.find("sheet") == body and world.name() == "sheet"
    assert world.positions().dtype == np.float64 and world.indices().dtype == np.uint32
    np.testing.assert_array_equal(np.sort(world.positions(body), axis=0), np.sort(positions, axis=0))
    assert world.indices(body).shape == triangles.shape
    np.testing.assert_array_equal(world.rest_positions(), world.positions())
    np.testing.assert_array_equal(world.velocities(), np.zeros_like(positions))
    np.testing.assert_array_equal(world.normals(), np.tile([0.0, 0.0, 1.0], (16, 1)))
    assert world.positions_f32().dtype == world.normals_f32().dtype == np.float32
    assert len(set(world.vertex_keys().tolist())) == 16 and len(world.triangle_keys()) == 18


def test_arrays_are_the_callers_own(world: rhexis.World) -> None:
    world.spawn(*grid(3), components={"Gravity": {"acceleration": [0, 0, -1e-3]}})
    before = world.positions()
    kept = before.copy()
    world.step(10.0)
    np.testing.assert_array_equal(before, kept)
    assert not np.array_equal(world.positions(), kept)
    before[:] = 99.0
    assert not np.any(world.positions() == 99.0)


@pytest.mark.parametrize(
    "convert", [np.asarray, np.asfortranarray, lambda a: a.tolist(), lambda a: np.repeat(a, 2, axis=0)[::2]]
)
def test_lists_and_arrays_of_any_layout_make_the_same_body(convert: object) -> None:
    hashes = []
    for change in (np.asarray, convert):
        world = rhexis.World(threads=1)
        positions, triangles = grid(3)
        world.spawn(change(positions), change(triangles.astype(np.int64)))  # type: ignore[operator]
        world.step(1.0)
        hashes.append(world.hash())
    assert hashes[0] == hashes[1]


def test_fibres_are_one_direction_or_one_per_triangle(world: rhexis.World) -> None:
    positions, triangles = grid(2)
    world.spawn(positions, triangles, [0, 1, 0], name="uniform")
    world.spawn(positions + [5, 0, 0], triangles, np.tile([0, 1.0, 0], (8, 1)), name="each")
    for name in ("uniform", "each"):
        np.testing.assert_allclose(world.fields(name)["fibre"], np.tile([0, 1.0, 0], (8, 1)), atol=1e-15)
    with refused("invalid_input", "fibres"):
        world.spawn(positions, triangles, np.ones((3, 2)))


@pytest.mark.parametrize(
    ("vertices", "triangles", "part"),
    [
        ([[0, 0], [1, 0], [0, 1]], [[0, 1, 2]], "vertices: the shape is [3, 2]"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1]], "triangles: the shape is [1, 2]"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0.0, 1.0, 2.0]], "integer type"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, -2]], "below zero"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2**40]], "no row"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 7]], "7"),
        ([[0, 0, 0], [np.nan, 0, 0], [0, 1, 0]], [[0, 1, 2]], ""),
        ([[0, 0, 0], [1, 0, 0], [0, "x", 0]], [[0, 1, 2]], "vertices"),
        ([[0, 0, 0], [1, 0], [0, 1, 0]], [[0, 1, 2]], "vertices"),
        (np.eye(3) * 1j, [[0, 1, 2]], "must be real"),
        ([], [], "vertices"),
    ],
)
def test_arrays_that_are_no_mesh_are_refused(
    world: rhexis.World, vertices: object, triangles: object, part: str
) -> None:
    before = world.hash()
    with refused("invalid_input", part):
        world.spawn(vertices, triangles)  # type: ignore[arg-type]
    assert world.hash() == before and world.bodies == []


def test_components_are_set_by_toml_dictionaries_and_keywords(world: rhexis.World) -> None:
    body = world.spawn(*grid(2), name="sheet")
    world.set(body, "Tearing", "strength_across_fibres = 3\nmode = 'Edge'")
    world.set("sheet", "Tearing", {"radius": np.float64(7.0)}, exponent=0.5)
    tearing = world.get(body, "Tearing")
    assert (tearing["strength_across_fibres"], tearing["mode"], tearing["radius"]) == (3.0, "Edge", 7.0)
    world.set(body, "Gravity", acceleration=np.array([0.0, 0.0, -1.0]))
    assert world.get(body, "Gravity") == {"acceleration": [0.0, 0.0, -1.0]}
    assert world.unset(body, "Gravity") and not world.unset(body, "Gravity")
    with refused("scene", "did you mean `strength_across_fibres`?"):
        world.set(body, "Tearing", strength_across_fibre=3)
    with refused("not_found", "did you mean `Tearing`?"):
        world.set(body, "Tearings")
    with refused("scene", "missing field `acceleration`"):
        world.set(body, "Gravity", "")
    with refused("invalid_input", "Tearing.radius"):
        world.set(body, "Tearing", radius=object())
    with refused("invalid_input"):
        world.set(body, "Tearing", radius=-1.0)
    with refused("not_found"):
        world.get(body, "Gravity")
    assert world.get(body, "Tearing") == tearing
    assert {"Tearing", "Gravity", "Contact"} <= set(rhexis.component_names())


def test_a_body_whose_component_is_refused_is_not_there(world: rhexis.World) -> None:
    with refused("scene", "radios"):
        world.spawn(*grid(2), components={"Gravity": "acceleration = [0, 0, -1]", "Tearing": {"radios": 1}})
    assert world.bodies == []


def test_material_and_obstacle(world: rhexis.World) -> None:
    body = world.spawn(*grid(4), material={"young_fibre": 3, "thickness": 0.02}, components={"Contact": {}})
    with refused("scene", "did you mean `thickness`?"):
        world.spawn(*grid(2), material="thicknes = 3")
    with refused("invalid_input"):
        world.spawn(*grid(2), material="thickness = -3")
    obstacle = world.spawn_obstacle(shape={"Sphere": {"centre": [2, 2, -5], "radius": 4}})
    assert world.obstacles == [obstacle]
    world.set(body, "Gravity", acceleration=[0, 0, -9.81e-3])
    world.step(5.0, 5)
    # The middle lies on the sphere at -1; without it the sheet would have fallen by 3 mm.
    assert -1.1 < world.positions()[:, 2].max() < -0.9
    world.despawn(obstacle)
    assert world.obstacles == []
    with refused("invalid_handle", "destroyed"):
        world.set(obstacle, "Obstacle", "")


def test_the_material_of_a_body_changes_while_it_runs(world: rhexis.World) -> None:
    sheet = world.spawn(*grid(4), material={"young_fibre": 2, "young_transverse": 2}, planar=True)
    world.pin("left", [key for key, x in zip(world.vertex_keys(), world.positions()) if x[0] < 0.1])
    right = [key for key, x in zip(world.vertex_keys(), world.positions()) if x[0] > 3.9]
    world.pin("right", right)
    world.shift_pins("right", [0.4, 0, 0])
    world.settle(1.0)
    before = world.reactions()["right"][0]
    world.set_material({"young_fibre": 1, "young_transverse": 1, "shear_modulus": 0.25}, sheet)
    world.settle(1.0)
    # The shear modulus was 0.5 MPa, which halves with the others.
    assert abs(world.reactions()["right"][0] / before - 0.5) < 1e-6
    with refused("invalid_input", "thickness"):
        world.set_material({"thickness": -1})
    with refused("scene", "yung"):
        world.set_material({"yung": 1})


def test_a_rigid_ball_is_pushed_by_tissue(world: rhexis.World) -> None:
    sheet = world.spawn(*grid(8), components={"Contact": {}})
    positions = world.positions()
    rim = [key for key, x in zip(world.vertex_keys(), positions) if min(x[0], x[1]) < 0.1 or max(x[0], x[1]) > 7.9]
    world.pin("rim", rim, sheet)
    ball = world.spawn_obstacle(shape={"Sphere": {"centre": [4, 4, 2.01], "radius": 2}})
    assert world.rigid(ball) is None
    with refused("scene", "give `mass`"):
        world.set_rigid(ball, velocity=[0, 0, 1])
    with refused("invalid_input", "mass"):
        world.set_rigid(ball, mass=-1)
    world.set_rigid(ball, mass=0.5, acceleration=[0, 0, -9.81e-3])
    world.step(2.0, 40)
    rigid = world.rigid(ball)
    assert rigid is not None and rigid["mass"] == 0.5 and rigid["impulse"][2] > 0 and rigid["centre"][2] > 1
    world.set_rigid(ball, velocity=[0.1, 0, 0])
    rigid = world.rigid(ball)
    assert rigid is not None and rigid["velocity"] == [0.1, 0, 0]
    world.set_rigid(ball)
    assert world.rigid(ball) is None


def test_settings_presets_and_budget(world: rhexis.World) -> None:
    world.set_settings("advanced.linear.tolerance = 1e-6", max_tear_passes=2)
    settings = world.settings
    assert settings["advanced"]["linear"]["tolerance"] == 1e-6 and settings["max_tear_passes"] == 2
    with refused("scene", "max_tear_passes"):
        world.set_settings(resumes=2)
    assert rhexis.World("game").settings["budget"] == 80
    assert rhexis.World("game", budget=7).settings["budget"] == 7
    assert "budget" not in rhexis.World("game", budget=0).settings
    with refused("invalid_input", "accuracy"):
        rhexis.World("default")  # type: ignore[arg-type]
    world.spawn(*grid(4), components={"Gravity": "acceleration = [0, 0, -1e-2]"})
    report = world.step(10.0, budget=3)
    assert report.iterations <= 3 and world.settings["budget"] == 4000


def test_steps_tell_what_they_did(world: rhexis.World) -> None:
    world.spawn(*grid(4), name="sheet")
    report = world.step(2.5, count=4)
    assert (report.step, report.time, world.time) == (4, 10.0, 10.0)
    assert not report.has_failed and not report.is_late
    whole = world.report()
    assert whole["bodies"][0]["name"] == "sheet" and whole["bodies"][0]["triangle_count"] == 32
    assert whole["bodies"][0]["body"] == world.bodies[0] and sum(whole["systems"].values()) > 0.0
    for bad in (0.0, -1.0, float("nan"), float("inf")):
        with refused("invalid_input"):
            world.step(bad)
    with refused("invalid_input", "0 steps"):
        world.step(1.0, count=0)
    with refused("invalid_input", "not from a scene"):
        world.advance()
    assert world.time == 10.0
    world.validate()


def test_stale_and_foreign_handles_are_refused(world: rhexis.World) -> None:
    other = rhexis.World(threads=1)
    body, foreign = world.spawn(*grid(2)), other.spawn(*grid(2))
    assert body != foreign and len({body, foreign, world.bodies[0]}) == 2
    with refused("invalid_handle", "another world"):
        world.positions(foreign)
    forceps = world.spawn_forceps()
    with refused("invalid_handle", "no body"):
        world.positions(forceps)
    world.despawn(body)
    for call in (world.positions, world.tips, world.fragments, world.fields, world.energies, world.reactions):
        with refused("invalid_handle", "destroyed"):
            call(body)
    with refused("invalid_input", "0 bodies"):
        world.positions()
    with refused("not_found", "sheet"):
        world.positions("sheet")
    world.spawn(*grid(2))
    with refused("invalid_handle", "destroyed"):
        world.positions(body)


def test_a_second_thread_is_told_that_the_world_is_busy() -> None:
    world = rhexis.World.from_catalog("fig2-tear")
    kinds: list[str] = []
    has_begun = threading.Event()

    def steps() -> None:
        has_begun.set()
        world.advance(30)

    thread = threading.Thread(target=steps)
    thread.start()
    has_begun.wait()
    # The thread steps without the interpreter's lock: calls of this one get in and are refused.
    while thread.is_alive():
        try:
            _ = world.time
        except rhexis.Error as error:
            kinds.append(error.kind)
    thread.join()
    assert set(kinds) == {"busy"} and world.time > 0.0


def test_scenes_say_what_is_wrong_with_them(tmp_path: object) -> None:
    with refused("scene", "did you mean `fig2-tear`?"):
        rhexis.World.from_catalog("fig2-teer")
    with refused("scene", "mine.toml:2:1"):
        rhexis.World.from_scene("[scene]\nnam = 'x'\n", "mine.toml")
    with refused("scene", "cannot be read"):
        rhexis.load("no-such.toml")
    with refused("scene"):
        rhexis.World.from_catalog("fig2-tear", {"run.dtt": 5})
    world = rhexis.World.from_catalog("fig2-tear", {"run.dt": 5, "run.steps": 3})
    assert world.scene["dt"] == 5.0 and world.scene["steps"] == 3 and not world.is_finished
    assert world.advance(10).step == 3 and world.is_finished
    assert "capsulorhexis" in rhexis.catalog() and rhexis.scene_text("fig2-tear").startswith("#")


def test_kinds_of_errors_are_listed() -> None:
    assert "invalid_handle" in rhexis.ERROR_KINDS and len(set(rhexis.ERROR_KINDS)) == len(rhexis.ERROR_KINDS)
    with pytest.raises(TypeError):
        rhexis.World(threads="many")  # type: ignore[arg-type]


def test_meshes_are_made_and_read(tmp_path: object) -> None:
    for vertices, triangles, fibres in (rhexis.grid(3, 2, 3, 2), rhexis.disc(2, 50), rhexis.cap(10, 9.8, 200)):
        assert vertices.shape[1] == triangles.shape[1] == 3 and fibres is None
    with refused("invalid_input"):
        rhexis.grid(-1, 2, 3, 2)
    file = f"{tmp_path}/one.obj"
    with open(file, "w", encoding="utf-8") as obj:
        obj.write("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    vertices, triangles, _ = rhexis.read_mesh(file)
    assert vertices.shape == (3, 3) and triangles.tolist() == [[0, 1, 2]]
    with refused("file", "none.obj"):
        rhexis.read_mesh(f"{tmp_path}/none.obj")


def test_worlds_are_stepped_at_the_same_time_to_the_same_bits() -> None:
    def run(hashes: list[int]) -> None:
        world = rhexis.World.from_catalog("fig2-tear", {"run.threads": 1})
        world.advance(20)
        hashes.append(world.hash())

    hashes: list[int] = []
    threads = [threading.Thread(target=run, args=[hashes]) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    run(hashes)
    assert len(hashes) == 4 and len(set(hashes)) == 1


def test_slips_are_told_before_the_first_step() -> None:
    world = rhexis.World(threads=1)
    world.spawn(*grid(3), material={"young_fibre": 1e6, "thickness": 0.01})
    names = [name for name, _ in world.doubts(0.016)]
    assert names == ["time-step", "stiffness", "no-holds"]
    with pytest.warns(UserWarning, match="MPa, 1e6 Pa"):
        world.step(0.016)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        world.step(0.016)
    assert rhexis.World.from_catalog("fig2").doubts() == []
