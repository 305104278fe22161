"""Runs the engines on the scenes and writes the tables of run time against error."""

from __future__ import annotations

import argparse
import csv
import importlib
import json
import math
import os
import platform
import subprocess
import sys
import time
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from engines.settings import SETTINGS
from sheet import Sheet, scene_cells

HERE = Path(__file__).parent
LEVELS = (0.1, 0.03, 0.01, 0.003, 0.001)
"""Errors of the force at which engines are compared."""
LONGEST = 90.0
"""An engine whose run has taken longer is not run at its finer settings on that mesh [s]."""
ROUNDS_END = 15.0
"""No further round of a run begins after this time [s]."""


@dataclass(frozen=True)
class Row:
    """One run of an engine."""

    scene: str
    triangles: int
    engine: str
    setting: str
    ms_per_step: float
    force_error: float
    displacement_error: float
    note: str


def words(setting: dict[str, float | int | str]) -> str:
    """A setting in one line."""
    return ", ".join(f"{name} {value:g}" if isinstance(value, float) else f"{name} {value}" for name, value in setting.items())


def one(scene: Path, cells: tuple[int, int], engine: str, setting: dict[str, float | int | str], rounds: int) -> dict[str, float]:
    """Runs a setting some times in this process; the errors and the least mean time of a step [ms]."""
    sheet = Sheet.read(scene, cells)
    run = importlib.import_module(f"engines.{engine}").run
    times: list[float] = []
    begin = time.monotonic()
    while len(times) < rounds and (not times or time.monotonic() - begin < ROUNDS_END):
        outcome = run(sheet, setting)
        times.append(1e3 * float(np.mean(outcome.seconds[sheet.first :])))
    errors = sheet.errors(np.array(outcome.positions))
    return {"ms": min(times), "force": errors.force, "displacement": errors.displacement}


def isolated(scene: Path, cells: tuple[int, int], engine: str, setting: dict[str, float | int | str], rounds: int) -> Row:
    """Runs a setting in a process of its own, on one core and one thread."""
    job = json.dumps({"scene": str(scene), "cells": cells, "engine": engine, "setting": setting, "rounds": rounds})
    core = [] if platform.system() != "Linux" else ["taskset", "-c", str(max(os.sched_getaffinity(0)))]
    threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "RAYON_NUM_THREADS"), "1")
    command = [*core, sys.executable, __file__, "--one", job]
    done = subprocess.run(command, capture_output=True, text=True, env=os.environ | threads, check=False)
    triangles, nothing = 2 * cells[0] * cells[1], (math.nan, math.nan, math.nan)
    if done.returncode != 0:
        reason = (done.stderr.strip().splitlines() or ["no message"])[-1]
        return Row(scene.stem, triangles, engine, words(setting), *nothing, f"not run: {reason}")
    figures = json.loads(done.stdout.strip().splitlines()[-1])
    numbers = (figures["ms"], figures["force"], figures["displacement"])
    note = "" if numbers[1] < 1 else "no solution: the error is as large as the force"
    return Row(scene.stem, triangles, engine, words(setting), *numbers, note)


def at_error(rows: list[Row], level: float) -> float | None:
    """Time at an error of the force: between the settings on the front, by logarithms; none where it is not reached."""
    front: list[tuple[float, float]] = []
    for row in sorted((row for row in rows if row.force_error > 0), key=lambda row: row.ms_per_step):
        if not front or row.force_error < front[-1][0]:
            front.append((row.force_error, row.ms_per_step))
    if not front or front[-1][0] > level:
        return None
    if front[0][0] <= level:
        return front[0][1]
    after = next(index for index, (error, _) in enumerate(front) if error <= level)
    (e0, t0), (e1, t1) = front[after - 1], front[after]
    part = math.log(e0 / level) / math.log(e0 / e1)
    return math.exp(math.log(t0) + part * math.log(t1 / t0))


def equal_error_table(rows: list[Row]) -> str:
    """Milliseconds per step at equal error of the force, and in brackets how many times that of Rhexis."""
    lines = ["| scene | triangles | engine | " + " | ".join(f"{100 * level:g} %" for level in LEVELS) + " |"]
    lines.append("|---|---|---|" + "---|" * len(LEVELS))
    for scene, triangles in sorted({(row.scene, row.triangles) for row in rows}):
        here = [row for row in rows if (row.scene, row.triangles) == (scene, triangles)]
        own = [at_error([row for row in here if row.engine == "rhexis"], level) for level in LEVELS]
        for engine in dict.fromkeys(row.engine for row in here):
            mine = [row for row in here if row.engine == engine]
            cells = []
            for level, ours in zip(LEVELS, own, strict=True):
                reached = at_error(mine, level)
                ratio = "" if reached is None or ours is None or engine == "rhexis" else f" ({reached / ours:.2g} ×)"
                cells.append("not reached" if reached is None else f"{reached:.3g}{ratio}")
            notes = [row.note for row in mine if row.note.startswith("not run")]
            if len(notes) == len(mine):
                cells = [notes[0]] + [""] * (len(LEVELS) - 1)
            lines.append(f"| {scene} | {triangles} | {engine} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def run_table(rows: list[Row]) -> str:
    """All runs."""
    lines = ["| scene | triangles | engine | setting | ms per step | force | displacement | |", "|---|---|---|---|---|---|---|---|"]
    for row in rows:
        errors = f"{row.ms_per_step:.3g} | {100 * row.force_error:.2g} % | {100 * row.displacement_error:.2g} %"
        lines.append(f"| {row.scene} | {row.triangles} | {row.engine} | {row.setting} | {errors} | {row.note} |")
    return "\n".join(lines)


def measure(scenes: list[Path], quick: bool, missing: dict[str, str]) -> list[Row]:
    """Runs every engine on every mesh, from coarse settings to fine ones."""
    rows: list[Row] = []
    for scene in scenes:
        for cells in scene_cells(scene)[: 1 if quick else None]:
            for engine in SETTINGS:
                triangles = 2 * cells[0] * cells[1]
                if engine in missing:
                    nothing = (math.nan, math.nan, math.nan)
                    rows.append(Row(scene.stem, triangles, engine, "", *nothing, f"not run: {missing[engine]}"))
                    continue
                for setting in SETTINGS[engine][:: 2 if quick else 1]:
                    begin = time.monotonic()
                    rows.append(isolated(scene, cells, engine, setting, 1 if quick else 3))
                    is_slow = time.monotonic() - begin > LONGEST / (10 if quick else 1)
                    row = rows[-1]
                    print(f"{row.scene} {row.triangles} {engine}: {row.setting}: {row.ms_per_step:.3g} ms, "
                          f"force {row.force_error:.2g}, displacement {row.displacement_error:.2g} {row.note}", flush=True)
                    if is_slow:
                        break
    return rows


def main() -> None:
    """Measures, prints the tables and writes the file."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--one", help=argparse.SUPPRESS)
    parser.add_argument("--quick", action="store_true", help="the smallest mesh, every other setting, one round")
    parser.add_argument("--out", type=Path, default=HERE.parent / "results" / "peers.csv")
    parser.add_argument("--missing", action="append", default=[], metavar="ENGINE=REASON", help="an engine that is not there")
    arguments = parser.parse_args()
    if arguments.one:
        job = json.loads(arguments.one)
        print(json.dumps(one(Path(job["scene"]), tuple(job["cells"]), job["engine"], job["setting"], job["rounds"])))
        return
    missing = dict(entry.split("=", 1) for entry in arguments.missing)
    rows = measure(sorted((HERE / "scenes").glob("*.toml")), arguments.quick, missing)
    arguments.out.parent.mkdir(parents=True, exist_ok=True)
    with arguments.out.open("w", newline="") as file:
        writer = csv.DictWriter(file, fieldnames=list(Row.__dataclass_fields__), lineterminator="\n")
        writer.writeheader()
        for row in rows:
            writer.writerow({name: f"{value:.4g}" if isinstance(value, float) else value for name, value in asdict(row).items()})
    print(f"\nEvery run, processor time of one core:\n\n{run_table(rows)}")
    print(f"\nms per step at equal error of the force (in brackets: times Rhexis):\n\n{equal_error_table(rows)}")
    print(f"\nwritten: {arguments.out}")


if __name__ == "__main__":
    main()
