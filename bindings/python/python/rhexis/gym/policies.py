"""Policies: an expert by script, and chance."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from .env import FRAME, SPEED, Capsulorhexis, beside

_Action = NDArray[np.float32]


class Expert:
    """The hand of the scene `capsulorhexis`: takes the flap beside the tip, lifts it by 0.5 mm, draws it over along a circle by
    210° in 4 s, and takes it anew until the tear has closed.
    """

    RISE = 0.5
    """How far the flap is lifted [mm]."""
    LIFT = 450.0
    """Time of the lift [ms]."""
    HOLD = 4500.0
    """Time of a grasp [ms]."""
    DEGREES = 210.0
    """Angle of the hand's way in a grasp."""
    RADIUS = 2.3
    """Radius of the hand's circle [mm]."""
    ABOVE = 0.5
    """Height of the open jaws above the tissue on their way [mm]."""

    def __init__(self, env: gymnasium.Env[Any, Any]) -> None:
        core = env.unwrapped
        if not isinstance(core, Capsulorhexis):
            raise TypeError(f"the expert plays Capsulorhexis, not {type(core).__name__}")
        self._env = core
        self._since = -1.0
        self._centre = self._from = np.zeros(3)

    def __call__(self, _observation: object) -> _Action:
        if self._since < 0.0 and self._env.is_closed():
            # Jaws that hold the flap already have lifted it.
            self._begin(self._env.jaws - np.array([0.0, 0.0, self.RISE]), self.LIFT)
        return self._draw() if self._since >= 0.0 else self._approach()

    def _towards(self, to: NDArray[np.float64], is_closed: bool) -> _Action:
        """The action that leads the jaws to a place, or as far as they go in a frame."""
        way = (to - self._env.jaws) / (SPEED * FRAME)
        outward, around = self._env.frame(self._env.jaws)
        velocity = np.array([way @ outward, way @ around, way[2]])
        velocity /= max(1.0, float(np.abs(velocity).max()))
        return np.array([*velocity, 1.0 if is_closed else -1.0], dtype=np.float32)

    def _approach(self) -> _Action:
        place, way = self._env.tip()
        hit = self._env.world.current(place + beside(way))
        target = self._env.jaws if hit is None else hit["position"]
        off = float(np.linalg.norm((target - self._env.jaws)[:2]))
        if off > 0.05:
            return self._towards(target + np.array([0.0, 0.0, self.ABOVE]), is_closed=False)
        if float(np.linalg.norm(target - self._env.jaws)) > 0.02:
            return self._towards(target, is_closed=False)
        self._begin(self._env.jaws, 0.0)
        return self._draw()

    def _begin(self, place: NDArray[np.float64], since: float) -> None:
        """Begins the way of a grasp at a place, along a circle that touches the tear's direction there."""
        _, way = self._env.tip()
        level = np.array([way[0], way[1], 0.0]) / max(float(np.hypot(way[0], way[1])), 1e-9)
        self._from = place.copy()
        self._centre = self._from + self.RADIUS * np.array([-level[1], level[0], 0.0])
        self._since = since

    def _draw(self) -> _Action:
        self._since += FRAME
        if self._since > self.HOLD or (self._since > FRAME and not self._env.is_closed()):
            self._since = -1.0
            return self._towards(self._env.jaws, is_closed=False)
        lift = self.RISE * min(self._since / self.LIFT, 1.0)
        drawn = max(self._since - self.LIFT, 0.0) / (self.HOLD - self.LIFT)
        angle = np.radians(self.DEGREES) * drawn
        cos, sin = np.cos(angle), np.sin(angle)
        turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
        to = self._centre + turn @ (self._from - self._centre) + np.array([0.0, 0.0, lift])
        return self._towards(to, is_closed=True)


class RandomPolicy:
    """Actions drawn evenly from the space."""

    def __init__(self, env: gymnasium.Env[Any, Any], seed: int | None = None) -> None:
        self._space = env.action_space
        self._space.seed(seed)

    def __call__(self, _observation: object) -> _Action:
        action: _Action = self._space.sample()
        return action


def play(
    env: gymnasium.Env[Any, Any],
    policy: Callable[[Any], _Action],
    *,
    seed: int | None = None,
    options: dict[str, Any] | None = None,
    frames: int | None = None,
) -> tuple[float, dict[str, Any]]:
    """Plays an episode, or its first frames: sum of the rewards, and the last info."""
    observation, info = env.reset(seed=seed, options=options)
    total, done = 0.0, 0
    while frames is None or done < frames:
        observation, reward, has_ended, is_cut_off, info = env.step(policy(observation))
        total += float(reward)
        done += 1
        if has_ended or is_cut_off:
            break
    return total, info
