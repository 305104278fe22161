"""Runs the engines on the scenes and writes the tables of run time against error."""

from __future__ import annotations

import argparse
import csv
import importlib
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from engines.outcome import Setting
from engines.settings import SETTINGS
from sheet import Sheet, scene_cells

HERE = Path(__file__).parent
LEVELS = (0.1, 0.03, 0.01, 0.003, 0.001)
"""Errors of the force at which engines are compared."""
SLOWEST = 100.0
"""An engine one of whose steps has taken longer is not run at its later settings on that mesh [ms]; a fifth of it with --quick."""
MARK, END = "<!-- measured -->\n", "<!-- end -->"
"""Around the tables in README.md."""
ROUNDS = 3
ROUNDS_END = 15.0
"""No further round of a run begins after this time [s]."""


@dataclass(frozen=True)
class Row:
    """One run of an engine."""

    scene: str
    triangles: int
    engine: str
    setting: str = ""
    ms_per_step: float = math.nan
    force_error: float = math.nan
    displacement_error: float = math.nan
    note: str = ""


def one(job: dict[str, Any]) -> dict[str, float]:
    """Runs a setting some times in this process: errors, and the median of the rounds' mean times of a step [ms]."""
    sheet = Sheet.read(Path(job["scene"]), tuple(job["cells"]))
    run = importlib.import_module(f"engines.{job['engine']}").run
    measured = len(sheet.hand) - sheet.first
    times: list[float] = []
    begin = time.monotonic()
    while len(times) < job["rounds"] and (not times or time.monotonic() - begin < ROUNDS_END):
        outcome = run(sheet, job["setting"])
        times.append(1e3 * float(np.mean(outcome.seconds[-measured:])))
    errors = sheet.errors(np.array(outcome.positions), np.load(job["reference"]))
    return {"ms_per_step": statistics.median(times), "force_error": errors.force, "displacement_error": errors.displacement}


def isolated(job: dict[str, Any], row: Row) -> Row:
    """Runs a setting in a process of its own, on one core and one thread."""
    threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "RAYON_NUM_THREADS"), "1")
    command = [sys.executable, __file__, "--one", json.dumps(job)]
    core = (lambda: os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})) if hasattr(os, "sched_setaffinity") else None
    done = subprocess.run(command, capture_output=True, text=True, env=os.environ | threads, check=False, preexec_fn=core)
    if done.returncode != 0:
        reason = (done.stderr.strip().splitlines() or ["no message"])[-1]
        return Row(**asdict(row) | {"note": f"not run: {reason.removeprefix('engines.outcome.NotPossible: ')}"})
    return Row(**asdict(row) | json.loads(done.stdout.strip().splitlines()[-1]))


def measure(scenes: list[Path], is_quick: bool, missing: dict[str, str]) -> Iterator[Row]:
    """Runs every engine on every mesh, from coarse settings to fine ones."""
    with tempfile.TemporaryDirectory() as folder:
        for scene in scenes:
            for cells in scene_cells(scene)[: 1 if is_quick else None]:
                reference = Path(folder, "reference.npy")
                sheet = Sheet.read(scene, cells)
                exact = sheet.static_solutions()
                np.save(reference, exact)
                if sheet.is_planar:
                    linear = sheet.errors(sheet.linear_solutions(), exact).force
                    print(f"{scene.stem}, {len(sheet.triangles)} triangles: linear elasticity is {100 * linear:.2g} % of the force off", flush=True)
                for engine, settings in SETTINGS.items():
                    row = Row(scene.stem, 2 * cells[0] * cells[1], engine)
                    if engine in missing:
                        yield Row(**asdict(row) | {"note": f"not run: {missing[engine]}"})
                        continue
                    for setting in settings[:: 3 if is_quick else 1]:
                        job = {"scene": str(scene), "cells": cells, "reference": str(reference), "engine": engine, "setting": setting}
                        words = ", ".join(f"{name} {value:.2g}" if isinstance(value, float) else f"{name} {value}" for name, value in setting.items())
                        done = isolated(job | {"rounds": 1 if is_quick else ROUNDS}, Row(**asdict(row) | {"setting": words}))
                        print("|".join(cell(done)), flush=True)
                        yield done
                        if done.note or done.ms_per_step > SLOWEST / (5 if is_quick else 1):
                            break


def cell(row: Row) -> list[str]:
    """A run's entries of the table."""
    figures = [f"{row.ms_per_step:.3g}", f"{100 * row.force_error:.2g} %", f"{100 * row.displacement_error:.2g} %"]
    return [row.scene, str(row.triangles), row.engine, row.setting, *([row.note, "", ""] if row.note else figures)]


def at_error(rows: list[Row], level: float) -> float | None:
    """Time at an error of the force: between the settings on the front, by logarithms; none where it is not reached."""
    front: list[tuple[float, float]] = []
    for row in sorted((row for row in rows if row.force_error > 0), key=lambda row: row.ms_per_step):
        if not front or row.force_error < front[-1][0]:
            front.append((row.force_error, row.ms_per_step))
    after = next((index for index, (error, _) in enumerate(front) if error <= level), None)
    if after is None:
        return None
    if after == 0:
        return front[0][1]
    (e0, t0), (e1, t1) = front[after - 1], front[after]
    return t0 * (t1 / t0) ** (math.log(e0 / level) / math.log(e0 / e1))


def table(head: list[str], lines: list[list[str]]) -> str:
    """A table in Markdown."""
    return "\n".join("| " + " | ".join(line) + " |" for line in [head, ["---"] * len(head), *lines])


def equal_error(rows: list[Row]) -> list[list[str]]:
    """Milliseconds per step at equal error of the force, and in brackets their ratio to those of Rhexis."""
    lines = []
    for scene, triangles in dict.fromkeys((row.scene, row.triangles) for row in rows):
        here = [row for row in rows if (row.scene, row.triangles) == (scene, triangles)]
        own = [at_error([row for row in here if row.engine == "rhexis"], level) for level in LEVELS]
        for engine in dict.fromkeys(row.engine for row in here):
            mine = [row for row in here if row.engine == engine]
            line = []
            for level, ours in zip(LEVELS, own, strict=True):
                reached = at_error(mine, level)
                ratio = "" if reached is None or ours is None or engine == "rhexis" else f" ({reached / ours:.2g} ×)"
                line.append("not reached" if reached is None else f"{reached:.3g}{ratio}")
            if all(row.note for row in mine):
                line = [mine[0].note] + [""] * (len(LEVELS) - 1)
            lines.append([scene, str(triangles), engine, *line])
    return lines


def main() -> None:
    """Measures, prints the tables and writes the file."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--one", type=json.loads, help=argparse.SUPPRESS)
    parser.add_argument("--quick", action="store_true", help="the smallest meshes, every third setting, one round")
    parser.add_argument("--out", type=Path, default=HERE.parent / "results" / "peers.csv")
    parser.add_argument("--page", action="store_true", help="put the tables into README.md")
    parser.add_argument("--missing", action="append", default=[], metavar="ENGINE=REASON", help="an engine that is not there")
    arguments = parser.parse_args()
    if arguments.one:
        print(json.dumps(one(arguments.one)))
        return
    missing = dict(entry.split("=", 1) for entry in arguments.missing)
    rows = []
    arguments.out.parent.mkdir(parents=True, exist_ok=True)
    with arguments.out.open("w", newline="") as file:
        writer = csv.DictWriter(file, fieldnames=list(Row.__dataclass_fields__), lineterminator="\n")
        writer.writeheader()
        # As they come, lest a run that ends early leaves nothing.
        for row in measure(sorted((HERE / "scenes").glob("*.toml"), reverse=True), arguments.quick, missing):
            rows.append(row)
            writer.writerow({name: f"{value:.4g}" if isinstance(value, float) else value for name, value in asdict(row).items()})
            file.flush()
    head = ["scene", "triangles", "engine"]
    levels = table([*head, *(f"{100 * level:g} %" for level in LEVELS)], equal_error(rows))
    runs = table([*head, "setting", "ms per step", "force", "displacement"], [cell(row) for row in rows])
    text = f"Milliseconds per step at equal error of the force, in brackets their ratio to those of Rhexis:\n\n{levels}\n\nEvery run:\n\n{runs}\n"
    print(f"\n{text}\nwritten: {arguments.out}")
    if arguments.page:
        page = HERE / "README.md"
        before, after = page.read_text().split(MARK, 1)
        page.write_text(before + MARK + text + after[after.index(END) :])


if __name__ == "__main__":
    main()
