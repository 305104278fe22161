"""Worlds that come and go leave no memory behind."""

from __future__ import annotations

import gc
from pathlib import Path

import pytest
from conftest import grid

import rhexis


def resident() -> int:
    """Resident memory of this process [bytes]."""
    statm = Path("/proc/self/statm")
    if not statm.exists():
        pytest.skip("the system does not tell resident memory")
    return int(statm.read_text(encoding="ascii").split()[1]) * 4096


def come_and_go() -> None:
    world = rhexis.World(threads=1)
    world.spawn(*grid(8), components={"Tearing": {}})
    world.snapshot()
    world.report()
    for _ in range(3):
        world.step(5.0)
        world.positions()
        world.normals_f32()
        world.velocities(copy=False)
    lent = world.positions(copy=False)
    del world
    lent.sum()


def test_worlds_leave_no_memory_behind() -> None:
    """A world of 128 triangles is 100 kB and more: one in a hundred of 2,000 that stayed would be seen."""
    for _ in range(100):
        come_and_go()
    gc.collect()
    before = resident()
    for _ in range(2_000):
        come_and_go()
    gc.collect()
    grown = resident() - before
    print(f"2000 worlds: resident memory has grown by {grown} bytes")
    # Allocator and interpreter keep pages for later: some, whatever the number of rounds.
    assert grown < 2 << 20


def test_refusals_leave_no_memory_behind() -> None:
    world = rhexis.World(threads=1)
    world.spawn(*grid(8))
    foreign = rhexis.World(threads=1).spawn(*grid(2))

    def refuse(rounds: int) -> None:
        for _ in range(rounds):
            for call in (lambda: world.positions(foreign), lambda: world.step(-1.0), lambda: world.pin("a", [0])):
                with pytest.raises(rhexis.Error):
                    call()

    refuse(200)
    gc.collect()
    before = resident()
    refuse(5_000)
    gc.collect()
    # 15,000 messages of 100 bytes that stayed would be 1.5 MB.
    assert resident() - before < 1 << 20
