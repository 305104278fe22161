"""What the run of an engine gives, and the clock that all of them share."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Setting = dict[str, float | int | str]


class NotPossible(Exception):
    """An engine has nothing that the scene asks for."""


@dataclass
class Outcome:
    """A run: states after the compared steps and processor time of every measured step, or of every step [s]."""

    positions: list[Floats] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)

    def step(self, advance: Callable[[], None]) -> None:
        """Makes a step and notes the processor time of the whole process that it took."""
        begin = time.process_time_ns()
        advance()
        self.seconds.append((time.process_time_ns() - begin) * 1e-9)
