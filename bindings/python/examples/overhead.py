"""What a step costs through Python: `python examples/overhead.py`.

The scene `fig2-tear` (1,500 triangles) twice side by side: one world does several steps in a single call, whose loop is in Rust;
the other is stepped, and its positions and triangles are fetched, step by step in Python. Printed is the ratio of the processor
times of this process per step, with its spread over the rounds.
"""

from __future__ import annotations

import statistics
import sys
import time

import rhexis

CHUNK = 10
"""Steps of the one call."""


def one_call(world: rhexis.World) -> float:
    start = time.process_time()
    world.advance(CHUNK)
    return time.process_time() - start


def step_by_step(world: rhexis.World) -> float:
    start = time.process_time()
    for _ in range(CHUNK):
        world.advance()
        world.positions()
        world.indices()
    return time.process_time() - start


def main(rounds: int) -> None:
    ratios = []
    for round_ in range(rounds):
        rust, python = (rhexis.World.from_catalog("fig2-tear", {"run.threads": 1}) for _ in range(2))
        times = [0.0, 0.0]
        steps = 0
        while not rust.is_finished and rust.scene["steps"] - rust.scene["step"] >= CHUNK:
            # Each goes first every other time: the first to touch a cache pays for it.
            order = [(0, one_call, rust), (1, step_by_step, python)]
            spent = {}
            for which, work, world in order if (steps // CHUNK + round_) % 2 == 0 else order[::-1]:
                spent[which] = work(world)
            if rust.is_finished:
                # It may have ended within the call.
                break
            times = [times[0] + spent[0], times[1] + spent[1]]
            steps += CHUNK
        ratios.append(times[1] / times[0])
        per_step = [1e6 * value / steps for value in times]
        print(f"{steps} steps: {per_step[0]:.0f} µs in Rust, {per_step[1]:.0f} µs through Python, ratio {ratios[-1]:.4f}")
    print(f"median ratio {statistics.median(ratios):.4f} of {rounds} rounds, {min(ratios):.4f} to {max(ratios):.4f}")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 5)
