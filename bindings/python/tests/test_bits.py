"""The bits: those of Rust, of C, of a replay and of a way back."""

from __future__ import annotations

import ctypes
import os
import platform
from pathlib import Path

import numpy as np
import pytest
from conftest import SOFT, grid, refused

import rhexis

ROOT = Path(__file__).resolve().parents[3]
GOLDEN = ROOT / "crates" / "rhexis-scene" / "tests" / "golden" / "hashes.txt"
LIBRARY = os.environ.get("RHEXIS_C_LIBRARY")


def column() -> str:
    """The column of the golden file for this build and machine, as `tests/golden/main.rs` has it."""
    if "direct" not in rhexis.FEATURES:
        return "any"
    machine = {"amd64": "x86_64", "arm64": "aarch64"}.get(platform.machine().lower(), platform.machine())
    if machine != "x86_64":
        return machine
    flags = Path("/proc/cpuinfo").read_text(encoding="utf-8") if Path("/proc/cpuinfo").exists() else ""
    return "x86_64-avx2" if " avx2 " in flags and " fma " in flags else "x86_64-sse2"


def golden() -> dict[str, tuple[int, str]]:
    lines = (line.split() for line in GOLDEN.read_text(encoding="utf-8").splitlines() if not line.startswith("#"))
    return {name: (int(steps), value) for kind, name, steps, value in lines if kind == column()}


# A minute and more each, or many bodies: Rust's own tests have them.
LONG = {"fig2-haptic", "many", "capsulorhexis-rescue", "capsulorhexis-runout"}


@pytest.mark.parametrize("name", sorted(set(rhexis.catalog()) - LONG))
def test_scenes_have_the_hash_of_rust(name: str) -> None:
    """`tests/golden` of the crate rhexis-scene holds Rust to these hashes."""
    known = golden() if GOLDEN.exists() else {}
    if name not in known:
        pytest.skip(f"no golden hash of {name} in the column {column()}")
    steps, value = known[name]
    world = rhexis.World.from_catalog(name)
    for _ in range(steps):
        world.advance()
    assert f"{world.hash():016x}" == value


def script(world: rhexis.World) -> None:
    """A sheet hung up by pins, cut, drawn by forceps: the script of `bindings/c/tests/calls.rs`."""
    body = world.spawn(*grid(6), name="sheet")
    world.set(body, "Tearing", SOFT)
    world.set(body, "Gravity", "acceleration = [0, 0, -9.81e-3]")
    world.pin("left", world.vertex_keys()[[0, 7, 14]])
    world.cut([[3, 0, 0], [3, 2, 0]])
    forceps = world.spawn_forceps("forceps", [5, 1, 0.3], stiffness=0.2)
    world.close_forceps(forceps, body)
    for step in range(1, 21):
        world.move_forceps(forceps, [5 + 0.05 * step, 1, 0.3 + 0.05 * step], within=5.0)
        world.shift_pins("left", [-0.01, 0, 0])
        world.step(5.0)


def test_tools_do_what_a_replay_in_rust_does(world: rhexis.World) -> None:
    world.record()
    script(world)
    recording = world.end_recording()
    assert recording.end == world.hash() and len(recording) > 60
    again = rhexis.Recording.from_bytes(recording.to_bytes()).replay()
    assert again.hash() == world.hash()
    np.testing.assert_array_equal(again.positions(), world.positions())
    with refused("invalid_input", "record"):
        world.end_recording()
    with refused("unreadable"):
        rhexis.Recording.from_bytes(b"none")


class _Vector(ctypes.Structure):
    _fields_ = [(axis, ctypes.c_double) for axis in "xyz"]


class _Pose(ctypes.Structure):
    _fields_ = [("position", _Vector), ("orientation", ctypes.c_double * 4)]


class _Jaws(ctypes.Structure):
    _fields_ = [(name, ctypes.c_double) for name in ("radius", "stiffness", "force_limit")] + [("slides", ctypes.c_uint8)]


class _View(ctypes.Structure):
    _fields_ = [("data", ctypes.POINTER(ctypes.c_uint64)), ("count", ctypes.c_size_t)]


class _Grasp(ctypes.Structure):
    _fields_ = [
        ("kind", ctypes.c_uint32),
        ("reach", ctypes.c_double),
        ("point", _Vector),
        ("direction", _Vector),
        ("vertices", ctypes.c_void_p),
        ("vertex_count", ctypes.c_size_t),
    ]


SCENE = """
[scene]
name = "sheet"
[run]
dt = 5
steps = 20
[[bodies]]
name = "sheet"
mesh = { grid = { width = 6, height = 6, nx = 6, ny = 6 } }
material = { young_fibre = 10, young_transverse = 1, poisson_major = 0.3, thickness = 0.1 }
fibres = { degrees = 0 }
tearing = { strength_fibre = 0.05, strength_transverse = 0.01, radius = 1.5 }
gravity = [0, 0, -9.81e-3]
"""


def test_a_scene_and_its_tools_have_the_hash_of_c() -> None:
    if LIBRARY is None:
        pytest.skip("set RHEXIS_C_LIBRARY to librhexis_c.so of `cargo build --release -p rhexis-c`, with the features of this build")
    c = ctypes.CDLL(LIBRARY)
    c.rhexis_last_error_message.restype = ctypes.c_char_p

    def ok(status: int) -> None:
        assert status == 0, c.rhexis_last_error_message()

    ok(c.rhexis_check_abi(_abi_version(), ctypes.c_uint64(0)))
    world, body, forceps = ctypes.c_uint64(), ctypes.c_uint64(), ctypes.c_uint64()
    ok(c.rhexis_world_from_scene(SCENE.encode(), b"sheet", ctypes.byref(world)))
    ok(c.rhexis_find_body(world, b"sheet", ctypes.byref(body)))
    keys, pinned = _View(), (ctypes.c_uint64 * 3)()
    ok(c.rhexis_vertex_keys(world, body, ctypes.byref(keys)))
    pinned[:] = [keys.data[row] for row in (0, 7, 14)]
    ok(c.rhexis_pin(world, body, b"left", pinned, ctypes.c_size_t(3)))
    line = (ctypes.c_double * 6)(3, 0, 0, 3, 2, 0)
    ok(c.rhexis_cut(world, body, line, ctypes.c_size_t(2), None))
    jaws, pose, grasp = _Jaws(), _Pose(), _Grasp()
    ok(c.rhexis_jaws_init(ctypes.byref(jaws)))
    ok(c.rhexis_pose_init(ctypes.byref(pose)))
    ok(c.rhexis_grasp_init(ctypes.byref(grasp)))
    jaws.stiffness, pose.position = 0.2, _Vector(5, 1, 0.3)
    ok(c.rhexis_forceps_create(world, None, ctypes.byref(jaws), ctypes.byref(pose), ctypes.byref(forceps)))
    ok(c.rhexis_forceps_close(world, forceps, body, ctypes.byref(grasp), None))

    mine = rhexis.World.from_scene(SCENE, "sheet")
    mine.pin("left", mine.vertex_keys()[[0, 7, 14]])
    mine.cut([[3, 0, 0], [3, 2, 0]])
    own = mine.spawn_forceps("forceps", [5, 1, 0.3], stiffness=0.2)
    mine.close_forceps(own)
    for step in range(1, 21):
        to = [5 + 0.05 * step, 1, 0.3 + 0.05 * step]
        pose.position = _Vector(*to)
        ok(c.rhexis_forceps_move(world, forceps, ctypes.byref(pose), ctypes.c_double(5.0)))
        ok(c.rhexis_advance(world, None))
        mine.move_forceps(own, to, within=5.0)
        mine.advance()
        value = ctypes.c_uint64()
        ok(c.rhexis_hash(world, ctypes.byref(value)))
        assert mine.hash() == value.value, f"step {step}"
    ok(c.rhexis_world_destroy(world))


def _abi_version() -> int:
    header = (ROOT / "bindings" / "c" / "include" / "rhexis.h").read_text(encoding="utf-8")
    line = next(line for line in header.splitlines() if line.startswith("#define RHEXIS_ABI_VERSION"))
    return int(line.split()[2].rstrip("u"), 0)


def test_any_number_of_threads_gives_the_same_bits() -> None:
    hashes = set()
    for threads in (1, 2, 3):
        world = rhexis.World.from_catalog("fig2-tear", {"run.threads": threads})
        world.advance(20)
        hashes.add(world.hash())
    assert len(hashes) == 1


def test_snapshots_go_back_and_on_to_the_same_bits(tmp_path: Path) -> None:
    world = rhexis.World.from_catalog("fig2-tear")
    world.follow_course()
    world.advance(10)
    snapshot = world.snapshot()
    assert (snapshot.step, snapshot.time) == (10, world.time)
    world.advance(10)
    end, course = world.hash(), world.course()
    world.restore(snapshot)
    assert world.time == snapshot.time and world.scene["step"] == 10 and world.events() == []
    world.advance(10)
    assert world.hash() == end and str(world.course()) == str(course)
    snapshot.save(tmp_path / "state")
    bare = rhexis.World.from_snapshot(rhexis.Snapshot.load(tmp_path / "state"))
    bare.step(world.scene["dt"], 10)
    assert bare.hash() == end
    same = rhexis.Snapshot.from_bytes(snapshot.to_bytes())
    assert (same.step, same.to_bytes()) == (10, snapshot.to_bytes())
    for bad in (b"", b"none", snapshot.to_bytes()[:-9]):
        with refused("unreadable"):
            rhexis.Snapshot.from_bytes(bad)
    with refused("file"):
        rhexis.Snapshot.load(tmp_path / "none")
