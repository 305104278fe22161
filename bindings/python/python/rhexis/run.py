"""Whole runs of scenes, and tools that are led along a path."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ._rhexis import Entity, Error, Report, World

_Scene = str | os.PathLike[str] | World


@dataclass(frozen=True)
class Run:
    """Result of `run_scene`."""

    world: World
    """World at the end."""
    steps: int
    """Steps done."""
    events: list[dict[str, Any]]
    """Events in order, as `World.events` gives them."""
    course: dict[str, Any] | None
    """Figures of the rhexis, as `World.course` gives them; None for several bodies and for a body without a rim."""


def load(scene: str | os.PathLike[str], changes: Mapping[str, Any] | None = None) -> World:
    """World of a scene of the catalog, or of the scene file at this path.

    `changes` replaces values by their dotted keys: `{"run.dt": 5, "bodies.0.tearing.radius": 1}`.
    """
    path = Path(scene)
    if isinstance(scene, os.PathLike) or path.suffix == ".toml" or path.is_file():
        return World.from_file(path, changes)
    return World.from_catalog(scene, changes)


def run_scene(
    scene: _Scene,
    *,
    changes: Mapping[str, Any] | None = None,
    steps: int | None = None,
    progress: bool = False,
    on_step: Callable[[World, Report], object] | None = None,
) -> Run:
    """Runs a scene to its end, or for so many steps.

    `progress` shows a bar of tqdm where that is installed, else a line per tenth of the run. `on_step` is called after every
    step; where it answers False the run ends.
    """
    world = scene if isinstance(scene, World) else load(scene, changes)
    is_followed = _follow(world)
    total = world.scene["steps"] - world.scene["step"]
    total = total if steps is None else min(steps, total)
    events: list[dict[str, Any]] = []
    done = 0
    with _Bar(total, progress) as bar:
        while done < total and not world.is_finished:
            report = world.advance()
            done += 1
            events += world.events()
            bar.move(report)
            if on_step is not None and on_step(world, report) is False:
                break
    course = dict(world.course()) if is_followed else None
    return Run(world, done, events, course)


def _follow(world: World) -> bool:
    if len(world.bodies) != 1:
        return False
    try:
        world.follow_course()
    except Error:
        return False
    return True


class _Bar:
    """Bar of tqdm, lines, or nothing."""

    def __init__(self, total: int, is_shown: bool) -> None:
        self._total, self._done, self._is_shown, self._bar = total, 0, is_shown, None
        if is_shown:
            try:
                with warnings.catch_warnings():
                    # In a notebook without widgets it falls back to text, and says so.
                    warnings.simplefilter("ignore")
                    from tqdm.auto import tqdm
            except ImportError:
                return
            self._bar = tqdm(total=total, unit="step")

    def __enter__(self) -> _Bar:
        return self

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.close()

    def move(self, report: Report) -> None:
        self._done += 1
        if self._bar is not None:
            self._bar.update(1)
            self._bar.set_postfix(ms=round(report.time, 3), tips=report.tip_count, refresh=False)
        elif self._is_shown and self._done * 10 // self._total > (self._done - 1) * 10 // self._total:
            print(f"{self._done} of {self._total} steps, {report.time:g} ms, {report.tip_count} tips")


def guide(
    world: World, forceps: Entity, times: ArrayLike, positions: ArrayLike, dt: float
) -> Iterator[Report]:
    """Leads forceps along a path while the world is stepped: yields the report of every step of `dt` [ms].

    `times` [ms, from now, ascending, shape (n,)] and `positions` [mm, shape (n, 3)] are the path, straight between its points;
    it begins where the forceps are now and lasts to the last of its times.
    """
    when = np.concatenate([[0.0], np.asarray(times, dtype=float)])
    if np.ndim(positions) != 2 or np.shape(positions) != (len(when) - 1, 3) or not np.all(np.diff(when) > 0.0):
        raise ValueError("times must ascend from above zero, positions have the shape (len(times), 3)")
    where = np.vstack([world.forceps(forceps)["position"], np.asarray(positions, dtype=float)])
    # The relative 1e-9 keeps a path that is a multiple of dt from gaining a step by rounding.
    for step in range(1, int(np.ceil(when[-1] / dt * (1.0 - 1e-9))) + 1):
        now = min(step * dt, float(when[-1]))
        to = np.array([np.interp(now, when, where[:, axis]) for axis in range(3)])
        world.move_forceps(forceps, to, within=dt)
        yield world.step(dt)
