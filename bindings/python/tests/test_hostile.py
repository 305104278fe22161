"""Random calls with hostile arguments: each works, or is refused; the world stays sound."""

from __future__ import annotations

import contextlib
import inspect
import os
import random
import signal
from collections.abc import Callable

import numpy as np
import pytest
from conftest import SOFT, grid, refused

import rhexis

CALLS = 6_000
# They leave the test's world or its folder.
LEFT_OUT = {"from_file", "from_catalog"}
NUMBERS = [0, -1, 1, 3, 1e-300, 1e300, float("nan"), float("inf"), -0.0, 2**31, 2**64, -(2**70)]
TEXTS = ["", "sheet", "Tearing", "Gravity", "\0", "é" * 50, "radius = 1", "[" * 40, "acceleration = [0, 0, nan]", "left"]


class Hostile:
    """A thing of Python that answers everything with an error of its own."""

    def __getattr__(self, name: str) -> object:
        raise KeyError(name)

    def __float__(self) -> float:
        raise ZeroDivisionError


class Junk:
    """Draws arguments, most of them wrong."""

    def __init__(self, seed: int, world: rhexis.World, known: list[object]) -> None:
        self.random = random.Random(seed)
        self.world = world
        self.known = known

    def vector(self) -> object:
        if self.random.random() < 0.7:
            return [self.random.uniform(-1, 7) for _ in range(3)]
        return [self.random.choice(NUMBERS) for _ in range(self.random.randrange(5))]

    def array(self) -> object:
        shape = self.random.choice([(0,), (3,), (4, 3), (1, 3), (0, 3), (2, 2), (2, 3, 3)])
        rng = np.random.default_rng(self.random.randrange(1000))
        kind = self.random.choice([np.float64, np.float32, np.int32, np.uint64, np.int64, bool, complex, object])
        return (10 * rng.random(shape)).astype(kind)

    def keys(self) -> object:
        keys = self.world.vertex_keys("sheet") if "sheet" in [self.world.name(b) for b in self.world.bodies] else [1]
        return list(self.random.choices(list(keys), k=self.random.randrange(4)))

    def any(self) -> object:
        makers = [
            lambda: self.random.choice(NUMBERS),
            lambda: self.random.choice(TEXTS),
            lambda: self.random.choice(self.known),
            self.vector,
            self.array,
            self.keys,
            lambda: {self.random.choice(TEXTS): self.random.choice(NUMBERS)},
            lambda: {"shape": {"Sphere": {"centre": [0, 0, -9], "radius": 1}}},
            lambda: (self.vector(), self.vector(), self.random.choice(NUMBERS)),
            lambda: self.random.choice([None, True, b"bytes", object(), Hostile(), [], {}, ()]),
        ]
        return self.random.choice(makers)()

    def likely(self, name: str) -> object:
        """An argument that may well do for a parameter of this name."""
        likely = {
            "dt": lambda: self.random.choice([1.0, 5.0]),
            "count": lambda: 1,
            "within": lambda: self.random.choice([0.0, 5.0]),
            "body": lambda: self.random.choice([None, "sheet"]),
            "forceps": lambda: self.random.choice([*self.known, *[self.known[1]] * 5]),
            "blade": lambda: self.random.choice(self.known),
            "entity": lambda: self.random.choice(["sheet", "sheet", *self.known]),
            "vertices": self.keys,
            "component": lambda: self.random.choice(rhexis.component_names()),
            "line": lambda: [self.vector(), self.vector()],
            "name": lambda: "left",
            "values": dict,
            "orientation": lambda: None,
        }
        return likely.get(name, self.vector)()


@pytest.mark.parametrize("seed", [1, 2])
def test_random_calls_work_or_are_refused(seed: int) -> None:
    world = rhexis.World(threads=1)
    sheet = world.spawn(*grid(6), name="sheet", components={"Tearing": SOFT})
    other = rhexis.World(threads=1)
    known: list[object] = [sheet, world.spawn_forceps(), world.spawn_blade(0.5, 0.2), other.spawn(*grid(2))]
    start = world.snapshot()
    known += [start, None]
    junk = Junk(seed, world, known)
    names = sorted(name for name in dir(rhexis.World) if not name.startswith("_") and name not in LEFT_OUT)
    calls = [(name, getattr(rhexis.World, name)) for name in names]
    calls = [(name, call) for name, call in calls if callable(call)]
    done: dict[str, int] = {}
    kinds: set[str] = set()
    for _ in range(CALLS):
        name, call = junk.random.choice(calls)
        given = [p for p in inspect.signature(call).parameters.values() if p.name != "self" and p.kind != p.VAR_KEYWORD]
        arguments = [junk.any() if junk.random.random() < 0.3 else junk.likely(p.name) for p in given]
        named = [(p, a) for p, a in zip(given, arguments) if p.kind == p.KEYWORD_ONLY]
        by_name = {p.name: a for p, a in named if p.default is p.empty or junk.random.random() < 0.3}
        by_place = [a for p, a in zip(given, arguments) if p.kind != p.KEYWORD_ONLY]
        if name == "step" or name == "advance":
            # A count of millions is no fault; nor is a step of a year.
            by_place = by_place[:1] if name == "step" else []
        try:
            getattr(world, name)(*by_place, **by_name)
            done[name] = done.get(name, 0) + 1
        except rhexis.Error as error:
            kinds.add(error.kind)
        except (TypeError, ValueError, OverflowError):
            kinds.add("type")
        # Errors of the arguments' own come through.
        except (KeyError, ZeroDivisionError):
            pass
        if len(world.bodies) > 6 or len(world.obstacles) > 6 or "sheet" not in [world.name(b) for b in world.bodies]:
            world.restore(start)
    world.validate()
    world.restore(start)
    assert not world.step(1.0).has_failed
    assert "panic" not in kinds and "poisoned" not in kinds
    assert {"invalid_input", "invalid_handle", "not_found", "type"} <= kinds
    print({name: count for name, count in sorted(done.items())}, kinds)
    # Not all was refused.
    assert {"step", "cut", "pin", "close_forceps", "move_forceps", "snapshot", "set"} <= set(done)


def test_values_that_hold_themselves_are_refused(sheet: rhexis.World) -> None:
    itself: dict[str, object] = {}
    itself["time"] = itself
    row: list[object] = []
    row.append(row)
    deep: object = 1.0
    for _ in range(100_000):
        deep = [deep]

    class Endless:
        def tolist(self) -> object:
            return self

    for value in (itself, {"time": row}, {"time": deep}, {"time": Endless()}):
        with refused("invalid_input", "holds itself"):
            sheet.set("sheet", "Damping", value)  # type: ignore[arg-type]
    with refused("invalid_input", "holds itself"):
        rhexis.World(settings=itself)


@pytest.mark.parametrize(
    "convert",
    [
        lambda a: np.ma.array(a, mask=np.arange(a.size).reshape(a.shape) == 0),
        lambda a: np.ma.array(a),
        lambda a: a.astype("M8[s]"),
        lambda a: a.astype("m8[s]"),
    ],
)
def test_arrays_that_hide_or_time_their_numbers_are_refused(convert: Callable[[np.ndarray], np.ndarray]) -> None:
    world = rhexis.World(threads=1)
    positions, triangles = grid(3)
    with refused("invalid_input", "vertices"):
        world.spawn(convert(positions), triangles)
    with refused("invalid_input", "triangles"):
        world.spawn(positions, convert(triangles.astype(np.int64)))
    assert world.bodies == []


@pytest.mark.skipif(not hasattr(os, "fork"), reason="forks are of Unix")
@pytest.mark.filterwarnings("ignore:This process:DeprecationWarning")
@pytest.mark.parametrize("threads", [1, 2])
def test_a_world_is_refused_after_a_fork(threads: int) -> None:
    world = rhexis.World(threads=threads)
    world.spawn(*grid(3), name="sheet")
    world.step(1.0)
    start = world.snapshot()
    child = os.fork()
    if child == 0:
        signal.alarm(60)
        answers = 0
        with contextlib.suppress(BaseException):
            calls: list[Callable[[], object]] = [lambda: world.step(1.0), world.positions, world.hash, world.snapshot]
            for call in calls:
                try:
                    call()
                except rhexis.Error as error:
                    answers += error.kind == "invalid_handle" and "fork" in str(error)
            # The snapshot is nobody's: it goes on here.
            answers += rhexis.World.from_snapshot(start).step(1.0) is not None
            del world
        os._exit(answers)
    status = os.waitpid(child, 0)[1]
    assert os.WIFEXITED(status) and os.WEXITSTATUS(status) == 5, status
    world.step(1.0)
