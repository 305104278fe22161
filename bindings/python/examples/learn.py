"""A small agent learns to draw the flap: `python examples/learn.py [--out FILE.png]`, some minutes on two cores.

The task is the first 3 s of a grasp: the flap is between the jaws, the sum of rewards is mostly how far the tear goes round.
The policy is linear in a few numbers of the observation, squashed; its weights are sought by CMA-ES (Hansen and Ostermeier 2001) of the
package `cma`: 27 numbers and episodes of a third of a second want no gradients and no network, and `cma` needs NumPy alone.
Seeds are fixed: the curve is the same every time.
"""

from __future__ import annotations

import argparse
import multiprocessing
from typing import Any

import cma
import numpy as np
from numpy.typing import NDArray

from rhexis.gym import Capsulorhexis, Expert, RandomPolicy, play

FRAMES = 30
POPULATION, GENERATIONS = 20, 12
SPREAD = 0.7
"""Standard deviation of the weights at the start."""
SEEN = [1, 2, 3, 5, 6, 12, 13, 14]
"""Rows of the observation: height, angle ahead of the tip, way to the tip, force."""
SHAPE = (3, len(SEEN) + 1)

_Array = NDArray[np.float64]
_envs: list[Capsulorhexis] = []


class Linear:
    """Velocity by a linear map of what is seen; the jaws stay closed."""

    def __init__(self, weights: _Array) -> None:
        self._weights = weights.reshape(SHAPE)

    def __call__(self, observation: NDArray[np.float32]) -> NDArray[np.float32]:
        seen = np.append(observation[SEEN], 1.0)
        return np.array([*np.tanh(self._weights @ seen), 1.0], dtype=np.float32)


def env() -> Capsulorhexis:
    """The environment of this process, made once."""
    if not _envs:
        _envs.append(Capsulorhexis(spread=0.0))
    return _envs[0]


def score(weights: _Array) -> float:
    return _score(Linear(weights))


def _score(policy: Any) -> float:
    return play(env(), policy, seed=0, options={"grasped": True}, frames=FRAMES)[0]


def of_chance(seed: int) -> float:
    """Random velocities with closed jaws, as the agent has them."""
    chance = RandomPolicy(env(), seed)
    return _score(lambda observation: np.append(chance(observation)[:3], 1.0).astype(np.float32))


def of_expert(_: int) -> float:
    return _score(Expert(env()))


def learn(pool: Any, generations: int) -> tuple[list[list[float]], _Array]:
    """Scores of every generation, and the mean weights at the end."""
    options = {"seed": 1, "popsize": POPULATION, "verbose": -9}
    strategy = cma.CMAEvolutionStrategy(np.zeros(np.prod(SHAPE)), SPREAD, options)
    scores: list[list[float]] = []
    for generation in range(generations):
        weights = strategy.ask()
        scores.append(pool.map(score, weights, chunksize=1))
        # It minimises.
        strategy.tell(weights, [-reward for reward in scores[-1]])
        print(f"generation {generation + 1}: mean {np.mean(scores[-1]):.3f}, best {np.max(scores[-1]):.3f}", flush=True)
    mean: _Array = strategy.mean
    return scores, mean


def draw(scores: list[list[float]], chance: float, expert: float, end: float, out: str) -> None:
    import matplotlib

    matplotlib.use("agg")
    import matplotlib.pyplot as plt

    generations = np.arange(1, len(scores) + 1)
    fig, ax = plt.subplots(figsize=(6, 3.6), dpi=120)
    ax.fill_between(generations, np.min(scores, axis=1), np.max(scores, axis=1), alpha=0.2, label="all of a generation")
    ax.plot(generations, np.mean(scores, axis=1), marker="o", label="mean of a generation")
    ax.axhline(expert, color="tab:green", ls="--", label="scripted expert")
    ax.axhline(chance, color="tab:red", ls=":", label="random velocities")
    ax.plot([generations[-1]], [end], marker="*", ms=12, color="k", ls="", label="mean weights at the end")
    ax.set_xlabel(f"generation of {POPULATION} policies")
    ax.set_ylabel(f"reward of the first {FRAMES / 10:g} s")
    ax.legend(fontsize=8)
    fig.tight_layout()
    fig.savefig(out)


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    arguments.add_argument("--out", default="learning.png")
    arguments.add_argument("--processes", type=int, default=2)
    arguments.add_argument("--generations", type=int, default=GENERATIONS)
    given = arguments.parse_args()
    with multiprocessing.Pool(given.processes) as pool:
        chance = float(np.mean(pool.map(of_chance, range(8))))
        expert = pool.map(of_expert, [0])[0]
        scores, mean = learn(pool, given.generations)
        end = pool.map(score, [mean])[0]
    print(f"chance {chance:.3f}, expert {expert:.3f}, learnt {end:.3f}")
    draw(scores, chance, expert, end, given.out)


if __name__ == "__main__":
    main()
