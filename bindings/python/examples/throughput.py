"""How many steps the environment makes in a second: `python examples/throughput.py [STEPS]`.

First one environment in this process, then 1, 2, 4, … in processes of Gymnasium's `AsyncVectorEnv`, up to one per core. Each plays the
expert's first grasp: the flap between the jaws, drawn round; what is counted are steps of all environments over the time on the clock.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable

import gymnasium
import numpy as np

import rhexis.gym

ACTION = np.array([0.0, 0.1, 0.02, 1.0], dtype=np.float32)
OPTIONS = {"grasped": True}
EPISODE = 60
"""Steps after which an environment begins anew, so that all have the same work."""


def per_second(steps: int, environments: int, reset: Callable[[], object], step: Callable[[], object]) -> float:
    reset()
    step()
    start = time.perf_counter()
    for done in range(steps):
        if done % EPISODE == 0:
            reset()
        step()
    return steps * environments / (time.perf_counter() - start)


def main(steps: int) -> None:
    env = gymnasium.make(rhexis.gym.ENV_ID)
    begin = time.process_time()
    alone = per_second(steps, 1, lambda: env.reset(seed=1, options=OPTIONS), lambda: env.step(ACTION))
    used = 1e3 * (time.process_time() - begin) / (steps + 1)
    print(f"in this process: {alone:.0f} steps per second, {used:.1f} ms of processor time each")
    count, cores = 1, os.cpu_count() or 1
    seeds: list[int | None]
    while count <= cores:
        envs = gymnasium.vector.AsyncVectorEnv([lambda: gymnasium.make(rhexis.gym.ENV_ID)] * count)
        actions = np.tile(ACTION, (count, 1))
        seeds = list(range(1, count + 1))
        rate = per_second(
            steps, count, lambda: envs.reset(seed=seeds, options=OPTIONS), lambda: envs.step(actions)  # noqa: B023
        )
        print(f"in {count} processes: {rate:.0f} steps per second, {rate / alone:.2f} times one")
        envs.close()
        count *= 2


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 240)
