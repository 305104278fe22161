"""Arrays that show the engine's own memory."""

from __future__ import annotations

import gc
import random
import threading
from collections.abc import Callable

import numpy as np
import pytest
from conftest import SOFT, grid, refused

import rhexis

COLUMNS = ("positions", "rest_positions", "velocities", "indices")


def lent(world: rhexis.World, column: str, body: rhexis.Entity | str | None = None) -> np.ndarray:
    array: np.ndarray = getattr(world, column)(body, copy=False)
    return array


def own(world: rhexis.World, column: str, body: rhexis.Entity | str | None = None) -> np.ndarray:
    array: np.ndarray = getattr(world, column)(body)
    return array


def address(array: np.ndarray) -> int:
    where: int = array.__array_interface__["data"][0]
    return where


@pytest.mark.parametrize("column", COLUMNS)
def test_nothing_is_copied(sheet: rhexis.World, column: str) -> None:
    sheet.step(5.0)
    array = lent(sheet, column)
    assert address(array) == address(lent(sheet, column)) != address(own(sheet, column))
    np.testing.assert_array_equal(array, own(sheet, column))
    assert array.dtype == own(sheet, column).dtype and array.flags.c_contiguous and not array.flags.owndata


@pytest.mark.parametrize("column", COLUMNS)
def test_an_array_that_is_let_go_costs_no_copy(sheet: rhexis.World, column: str) -> None:
    """An array that is kept takes the memory with it, one that was let go leaves it to the engine."""
    first = address(lent(sheet, column))
    sheet.set("sheet", "Gravity", acceleration=[0, 0, -1e-3])
    kept = lent(sheet, column)
    assert address(kept) == first
    sheet.set("sheet", "Gravity", acceleration=[0, 0, -2e-3])
    assert address(lent(sheet, column)) != first


@pytest.mark.parametrize("column", COLUMNS)
def test_no_one_writes_there(sheet: rhexis.World, column: str) -> None:
    before = sheet.hash()
    array = lent(sheet, column)
    for write in (
        lambda: array.__setitem__(0, 1),
        lambda: array[1:].__setitem__(0, 1),
        lambda: array.sort(axis=0),
        lambda: array.setflags(write=True),
        lambda: array[2:].setflags(write=True),
        lambda: np.add(array, 1, out=array),
        lambda: memoryview(array).cast("B").__setitem__(0, 1),
    ):
        with pytest.raises((ValueError, TypeError)):
            write()
    assert sheet.hash() == before


CHANGES: dict[str, Callable[[rhexis.World], object]] = {
    "step": lambda world: world.step(5.0),
    "record": lambda world: world.record(),
    "cut": lambda world: world.cut([[0, 4, 0], [2, 4, 0]]),
    "puncture": lambda world: world.puncture([2, 4, 0], [1, 0, 0], 1.0),
    "despawn": lambda world: world.despawn("sheet"),
    "spawn": lambda world: world.spawn(*grid(2), name="other"),
    "component": lambda world: world.set("sheet", "Drag", coefficient=1e-4),
    "pin": lambda world: world.pin("held", world.vertex_keys()[:3]),
    "restore": lambda world: world.restore(rhexis.World(threads=1).snapshot()),
    "refusal": lambda world: _refused(world),
}


def _refused(world: rhexis.World) -> None:
    with refused("invalid_input"):
        world.step(float("nan"))


@pytest.mark.parametrize("change", CHANGES)
def test_arrays_stay_what_they_are(sheet: rhexis.World, change: str) -> None:
    sheet.set("sheet", "Gravity", acceleration=[0, 0, -1e-2])
    arrays = [lent(sheet, column) for column in COLUMNS]
    parts = [array[1::2] for array in arrays]
    kept = [array.copy() for array in arrays]
    CHANGES[change](sheet)
    CHANGES["spawn"](sheet)
    _overwrite()
    for array, part, copy in zip(arrays, parts, kept, strict=True):
        np.testing.assert_array_equal(array, copy)
        np.testing.assert_array_equal(part, copy[1::2])


def _overwrite() -> None:
    """Has the allocator give out what was freed, and writes there."""
    for size in (100, 400, 900, 1200, 1800, 2400):
        arrays = [np.full(size, 255, dtype=np.uint8) for _ in range(200)]
        del arrays


def test_arrays_outlive_their_world(sheet: rhexis.World) -> None:
    world = rhexis.World(threads=1)
    world.spawn(*grid(6))
    part = lent(world, "positions")[3:]
    kept = part.copy()
    del world
    gc.collect()
    _overwrite()
    np.testing.assert_array_equal(part, kept)


def test_what_is_seen_is_the_same_with_and_without(sheet: rhexis.World) -> None:
    other = rhexis.World.from_snapshot(sheet.snapshot())
    seen = []
    for _ in range(20):
        sheet.step(5.0)
        other.step(5.0)
        seen.append(lent(sheet, "positions"))
        np.testing.assert_array_equal(seen[-1], own(other, "positions"))
        assert sheet.hash() == other.hash()
    assert len({address(array) for array in seen}) == 20


def test_random_uses_leave_every_array_as_it_was() -> None:
    """Worlds and bodies come, change and go; arrays are kept, sliced and let go, in any order."""
    chance = random.Random(5)
    worlds: list[rhexis.World] = []
    arrays: list[tuple[np.ndarray, np.ndarray]] = []
    checked = 0
    for _ in range(3000):
        if not worlds or chance.random() < 0.03:
            worlds.append(rhexis.World(threads=1))
            worlds[-1].spawn(*grid(chance.randint(2, 7)), name="sheet", components={"Tearing": SOFT})
        world = chance.choice(worlds)
        what = chance.random()
        if what < 0.35:
            array = lent(world, chance.choice(COLUMNS), chance.choice(world.bodies))
            array = array[chance.randint(0, 3) :: chance.randint(1, 3)] if chance.random() < 0.3 else array
            arrays.append((array, array.copy()))
        elif what < 0.5:
            world.step(chance.uniform(1, 10))
        elif what < 0.6:
            x, y = chance.uniform(0, 2), chance.uniform(0, 2)
            try:
                world.cut([[x, y, 0], [x + 0.7, y + 0.4, 0]], chance.choice(world.bodies))
            except rhexis.Error:
                pass
        elif what < 0.65:
            world.spawn(*grid(2), name="other")
        elif what < 0.68 and len(world.bodies) > 1:
            world.despawn(chance.choice(world.bodies))
        elif what < 0.72:
            world.restore(chance.choice(worlds).snapshot())
        elif what < 0.74:
            worlds.remove(world)
        elif arrays:
            array, kept = arrays.pop(chance.randrange(len(arrays)))
            np.testing.assert_array_equal(array, kept)
            checked += 1
        del world
    for array, kept in arrays:
        np.testing.assert_array_equal(array, kept)
    assert checked > 500


def test_arrays_are_read_while_the_world_is_stepped() -> None:
    world = rhexis.World(threads=1)
    world.spawn(*grid(20), components={"Gravity": {"acceleration": [0, 0, -1e-2]}})
    array = lent(world, "positions")
    expected = float(array.sum())
    sums: set[float] = set()
    done = threading.Event()

    def read() -> None:
        while not done.is_set():
            sums.add(float(array.sum()))

    reader = threading.Thread(target=read)
    reader.start()
    for _ in range(50):
        world.step(5.0)
        lent(world, "velocities")
    done.set()
    reader.join()
    assert sums == {expected}
    with refused("not_found"):
        lent(world, "positions", "nobody")
