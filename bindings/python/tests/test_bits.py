"""The bits: those of Rust, of C, of a replay and of a way back."""

from __future__ import annotations

import copy
import pickle
import platform
from pathlib import Path

import numpy as np
import pytest
from conftest import SOFT, grid, refused

import rhexis

ROOT = Path(__file__).resolve().parents[3]
GOLDEN = ROOT / "crates" / "rhexis-scene" / "tests" / "golden" / "hashes.txt"


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


SCRIPT = ROOT / "bindings" / "c" / "tests" / "script"


def test_a_script_has_the_hash_of_rust_c_and_cs() -> None:
    """The tests of `bindings/c` hold the other languages to this hash, which no set of features changes."""
    world = rhexis.World.from_file(SCRIPT / "sheet.toml")
    world.pin("left", world.vertex_keys()[[0, 7, 14]])
    world.cut([[3, 0, 0], [3, 2, 0]])
    forceps = world.spawn_forceps("forceps", [5, 1, 0.3], stiffness=0.2)
    world.close_forceps(forceps)
    step, events = 0, []
    while not world.is_finished:
        step += 1
        world.move_forceps(forceps, [5 + 0.05 * step, 1, 0.3 + 0.05 * step], within=5.0)
        world.shift_pins("left", [-0.01, 0, 0])
        world.advance()
        events += world.events()
    advances = sum(event["kind"] == "advanced" for event in events)
    assert f"{world.hash():016x} {advances}" == (SCRIPT / "hash.txt").read_text(encoding="utf-8").strip()


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
    # A pickle has the progress of the scene and the courses too.
    for kept in (pickle.loads(pickle.dumps(snapshot)), copy.deepcopy(snapshot), copy.copy(snapshot)):
        world.restore(kept)
        assert world.scene["step"] == 10
        world.advance(10)
        assert world.hash() == end and str(world.course()) == str(course)
    with refused("unreadable"):
        pickle.loads(pickle.dumps(same).replace(b"rhexsnap", b"rhexnaps"))
    for bad in (b"", b"none", snapshot.to_bytes()[:-9]):
        with refused("unreadable"):
            rhexis.Snapshot.from_bytes(bad)
    with refused("file"):
        rhexis.Snapshot.load(tmp_path / "none")
