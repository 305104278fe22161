"""What a step costs through Python: `python examples/overhead.py [ROUNDS]`.

The scene `fig2-tear` (1,500 triangles) twice side by side: one world does ten steps in a single call, whose loop is in Rust; the other
is stepped, and its positions and triangles are fetched, step by step in Python. Every round does the same work: the least time of
each ten steps over the rounds is what they take undisturbed. Printed are the ratio of their sums, which a busy machine blurs by some
per cent, and what the calls take by themselves.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

import rhexis

CHUNK = 10
"""Steps of the one call."""
REPEATS = 1000
"""Calls that are timed at a time."""


def one_call(world: rhexis.World) -> None:
    world.advance(CHUNK)


def step_by_step(world: rhexis.World) -> None:
    for _ in range(CHUNK):
        world.advance()
        world.positions()
        world.indices()


def timed(work: Callable[[rhexis.World], None], world: rhexis.World) -> float:
    """Processor time of this process [s]."""
    start = time.process_time()
    work(world)
    return time.process_time() - start


def repeated(call: Callable[[rhexis.World], object]) -> Callable[[rhexis.World], None]:
    def work(world: rhexis.World) -> None:
        for _ in range(REPEATS):
            call(world)

    return work


def chunks(is_first: bool) -> list[tuple[float, float]]:
    """Times of every ten steps by one call and step by step, until the scene is at its end."""
    rust, python = (rhexis.World.from_catalog("fig2-tear", {"run.threads": 1}) for _ in range(2))
    times: list[tuple[float, float]] = []
    while True:
        # Each goes first every other time: the first to touch a cache pays for it.
        if (len(times) % 2 == 0) == is_first:
            a = timed(one_call, rust)
            b = timed(step_by_step, python)
        else:
            b = timed(step_by_step, python)
            a = timed(one_call, rust)
        if rust.is_finished:
            # The last call may have done fewer steps.
            return times
        times.append((a, b))


def main(rounds: int) -> None:
    all_rounds = [chunks(round_ % 2 == 0) for round_ in range(rounds)]
    least = [[min(pair[which] for pair in chunk) for chunk in zip(*all_rounds, strict=True)] for which in (0, 1)]
    steps = CHUNK * len(least[0])
    rust, python = (1e6 * sum(times) / steps for times in least)
    print(f"{steps} steps: {rust:.1f} µs in Rust, {python:.1f} µs through Python, ratio {python / rust:.4f}")
    world = rhexis.World.from_catalog("fig2-tear", {"run.threads": 1})
    fetches: dict[str, Callable[[rhexis.World], object]] = {
        "time": lambda world: world.time,
        "positions": rhexis.World.positions,
        "indices": rhexis.World.indices,
    }
    for name, fetch in fetches.items():
        print(f"{name}: {1e6 * min(timed(repeated(fetch), world) for _ in range(10)) / REPEATS:.2f} µs")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 10)
