"""Pins, forceps, cuts, blade and needle; events and what is seen of a tear."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import grid, refused

import rhexis


def test_pins_hold_shift_and_let_go(sheet: rhexis.World) -> None:
    keys, rest = sheet.vertex_keys(), sheet.rest_positions()
    left = keys[rest[:, 0] == 0.0]
    sheet.pin("left", left)
    assert sorted(sheet.pins("left")["vertices"].tolist()) == sorted(left.tolist())
    sheet.shift_pins("left", [-0.1, 0, 0])
    sheet.step(5.0)
    rows = np.isin(sheet.vertex_keys(), left)
    np.testing.assert_allclose(sheet.positions()[rows][:, 0], -0.1, atol=1e-12)
    assert sheet.reactions()["left"][0] < 0.0
    places = sheet.pins("left")["places"] + [0.0, 0.0, 0.2]
    sheet.move_pins("left", places)
    sheet.step(5.0)
    np.testing.assert_allclose(sheet.pins("left")["places"], places)
    with refused("invalid_input", "7 vertices are pinned, 2 places"):
        sheet.move_pins("left", places[:2])
    with refused("not_found"):
        sheet.shift_pins("right", [1, 0, 0])
    sheet.unpin(left[:2])
    assert len(sheet.pins("left")["vertices"]) == 5
    sheet.unpin_all("left")
    for bad in ([0], [2**63], [-1], [0.5], [[1, 2]]):
        with refused("invalid_input"):
            sheet.pin("none", bad)


def test_forceps_grasp_move_and_release(sheet: rhexis.World) -> None:
    sheet.pin("left", sheet.vertex_keys()[sheet.rest_positions()[:, 0] == 0.0])
    forceps = sheet.spawn_forceps("mine", [5, 1, 0.3], stiffness=0.2)
    assert sheet.tools == [forceps] and sheet.forceps(forceps)["body"] is None
    assert sheet.close_forceps(forceps, nearest=1.0) > 0
    state = sheet.forceps(forceps)
    assert state["name"] == "mine" and state["body"] == sheet.bodies[0]
    with refused("nothing_done", "closed"):
        sheet.close_forceps(forceps)
    sheet.move_forceps(forceps, [5.5, 1, 0.8], within=5.0)
    sheet.step(5.0)
    state = sheet.forceps(forceps)
    np.testing.assert_allclose(state["position"], [5.5, 1, 0.8])
    assert state["force"][0] > 0.0 and state["force"][2] > 0.0
    assert sheet.open_forceps(forceps)
    assert not sheet.open_forceps(forceps)
    assert sheet.forceps(forceps)["body"] is None
    sheet.move_forceps(forceps, [50, 1, 0.8], [0, 0, 1, 0], within=5.0)
    sheet.step(5.0)
    np.testing.assert_allclose(sheet.forceps(forceps)["orientation"], [0, 0, 1, 0])
    with refused("nothing_done", "no tissue"):
        sheet.close_forceps(forceps, nearest=1.0)
    with refused("invalid_input", "one of nearest"):
        sheet.close_forceps(forceps, nearest=1.0, point=[0, 0, 0])
    with refused("invalid_input"):
        sheet.move_forceps(forceps, [0, 0, float("nan")], within=1.0)
    with refused("invalid_input"):
        sheet.spawn_forceps(radius=-1.0)


@pytest.mark.parametrize("grasp", ["ray", "point", "vertices"])
def test_forceps_grasp_by_ray_point_and_vertices(sheet: rhexis.World, grasp: str) -> None:
    forceps = sheet.spawn_forceps("forceps", [5, 1, 0.3])
    given: dict[str, object] = {
        "ray": ([5.0, 1.0, 3.0], [0.0, 0.0, -1.0], 5.0),
        "point": [5.0, 1.0, 0.0],
        "vertices": sheet.vertex_keys()[:2],
    }
    assert sheet.close_forceps(forceps, "sheet", **{grasp: given[grasp]}) > 0  # type: ignore[arg-type]


def test_forceps_are_led_along_a_path(sheet: rhexis.World) -> None:
    sheet.pin("left", sheet.vertex_keys()[sheet.rest_positions()[:, 0] == 0.0])
    forceps = sheet.spawn_forceps("forceps", [5, 1, 0], stiffness=0.2)
    sheet.close_forceps(forceps)
    path = [[5, 1, 0.5], [5.5, 1, 0.5]]
    reports = list(rhexis.guide(sheet, forceps, [20, 40], path, dt=5))
    assert [report.time for report in reports] == [5.0 * step for step in range(1, 9)]
    np.testing.assert_allclose(sheet.forceps(forceps)["position"], path[-1])
    with pytest.raises(ValueError, match="ascend"):
        next(rhexis.guide(sheet, forceps, [20, 10], path, dt=5))


def test_cuts_punctures_and_blades_open_the_sheet(world: rhexis.World) -> None:
    world.spawn(*grid(6), name="sheet", components={"Tearing": {}})
    made = world.cut([[3, 0, 0], [3, 2, 0]])
    assert made["made"] == pytest.approx(2.0) and len(made["tips"]) == 1 and made["path"].shape[1] == 3
    assert world.tips()["keys"].tolist() == made["tips"]
    np.testing.assert_allclose(world.tips()["rest_positions"], [[3, 2, 0]], atol=1e-12)
    slit = world.puncture([1.5, 4.5, 0.2], [1, 0, 0], 1.0)
    assert slit["made"] == pytest.approx(1.0) and len(slit["tips"]) == 2
    blade = world.spawn_blade(0.5, 0.2)
    assert world.draw_blade(blade, [4.2, -0.5, 0]) is None
    cut = world.draw_blade(blade, [4.2, 3.1, 0])
    assert cut is not None and cut["made"] > 2.5
    kinds = {event["kind"] for event in world.events()}
    assert {"started", "cut"} <= kinds
    with refused("nothing_done"):
        world.cut([[30, 0, 0], [31, 0, 0]])
    with refused("invalid_input"):
        world.cut([3, 0, 0])
    with refused("invalid_input"):
        world.spawn_blade(-1, 0.2)


def test_rays_and_nearest_points_find_the_surface(world: rhexis.World) -> None:
    world.spawn(*grid(4))
    hit = world.cast_ray([1.2, 2.3, 5], [0, 0, -2], 10)
    assert hit is not None and hit["distance"] == pytest.approx(5.0)
    np.testing.assert_allclose(hit["position"], [1.2, 2.3, 0], atol=1e-12)
    assert sum(hit["weights"]) == pytest.approx(1.0) and set(hit["corners"]) <= set(world.vertex_keys().tolist())
    near = world.nearest([1.2, 2.3, 0.5], 1.0)
    assert near is not None and near["distance"] == pytest.approx(0.5)
    assert world.nearest([1.2, 2.3, 5], 1.0) is None
    assert world.cast_ray([1.2, 2.3, 5], [0, 0, 1], 10) is None
    here = world.current([1.2, 2.3, 0])
    assert here is not None and here["triangle"] == near["triangle"]


def test_a_push_on_a_vertex_moves_it(world: rhexis.World) -> None:
    world.spawn(*grid(2))
    key = int(world.vertex_keys()[4])
    world.apply_force(key, [0, 0, 1e-6])
    world.step(1.0)
    row = world.vertex_keys().tolist().index(key)
    assert world.velocities()[row, 2] > 0.0
    with refused("invalid_input", "no key"):
        world.apply_force(0, [0, 0, 1])
    with refused("invalid_input"):
        world.apply_force(key, [0, 0, float("inf")])


def test_a_tear_is_told_and_shown() -> None:
    world = rhexis.World.from_catalog("fig2-tear")
    world.track_changes()
    assert world.changes()["is_whole"]
    world.advance(2)
    calm = world.changes()
    world.events()
    vertices = len(world.positions())
    while not (events := [event for event in world.events() if event["kind"] == "advanced"]):
        world.advance()
    first = events[0]
    assert first["body"] == world.bodies[0] and isinstance(first["tip"], int)
    assert first["criterion"] >= 1.0 and len(first["to"]) == 3 and first["course"] in ("exact", "snapped", "part", "edge")
    # The tip glides on, and its lips are halved.
    world.advance(2)
    changes = world.changes()
    assert not changes["is_whole"] and changes["vertex_count"] == len(world.positions()) > vertices
    assert changes["vertices"].shape[1] == 2 and len(changes["triangles"]) > 0
    assert len(calm["triangles"]) == 0
    fields = world.fields()
    count = changes["triangle_count"]
    assert fields["criterion"].shape == (count,) and fields["stress"].shape == (count, 9)
    assert fields["principal_stress"].shape == (count, 2)
    assert world.energies()["elastic"] > 0.0 and world.fragments()["count"] == 1


def test_attributes_follow_the_mesh(world: rhexis.World) -> None:
    world.spawn(*grid(3))
    with refused("not_found", "Attributes"):
        world.attributes()
    with refused("not_found", "track_changes"):
        world.changes()
    rest = world.rest_positions()
    world.set(world.bodies[0], "Attributes", stride=3, values=rest.ravel())
    np.testing.assert_array_equal(world.attributes(), rest)
    world.cut([[1.5, 0, 0], [1.5, 1.4, 0]])
    np.testing.assert_allclose(world.attributes(), world.rest_positions(), atol=1e-12)
    before = world.positions()
    world.step(2.0)
    np.testing.assert_allclose(world.positions_before(2.0), before, atol=1e-12)
    with refused("invalid_input"):
        world.positions_before(float("nan"))
