"""Rhexis: a membrane, run by the program `rhexis` from a scene file.

The program tells no processor time of single steps. A step's is the difference of a whole run and one that ends where the measured steps
begin, over their number; the account that the program keeps of every step (energies, reactions, `series.csv`) is in it.
"""

from __future__ import annotations

import base64
import os
import re
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from engines.outcome import Floats, Outcome, Setting
from sheet import Sheet

SCENE = """
[scene]
name = "{name}"
about = "the sheet of a comparison with other engines"

[run]
dt = {dt}
steps = {steps}
threads = 1
advanced.linear_tolerance = 1    # a residual; no piece of the sheet comes free
advanced.stress_tolerance = {stress_tolerance}

[output]
pictures = 0
frames = 0

[[bodies]]
name = "sheet"
planar = {planar}
mesh = {{ file = "sheet.obj" }}
material = {{ young = {young}, poisson = {poisson}, thickness = {thickness}, density = {density} }}
pre_stretch = {stretch}

[[bodies.holds]]
name = "held"
region = {held}

[[bodies.holds]]
name = "hand"
region = {driven}
move = {{ offset = {offset} }}
curve = {curve}
"""


def write(sheet: Sheet, setting: Setting, folder: Path) -> Path:
    """Writes scene and mesh into a folder; the scene's path."""
    positions = np.column_stack([sheet.start, np.zeros(len(sheet.points))])[:, :3].tolist()
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in positions]
    lines += [f"f {a} {b} {c}" for a, b, c in (sheet.triangles + 1).tolist()]
    (folder / "sheet.obj").write_text("\n".join(lines) + "\n")
    material = sheet.material
    scene = folder / "sheet.toml"
    text = SCENE.format(
        name=sheet.name,
        dt=sheet.dt,
        steps=len(sheet.hand),
        planar=str(sheet.is_planar).lower(),
        young=material.young,
        poisson=material.poisson,
        thickness=material.thickness,
        density=material.density,
        stretch=sheet.stretch - 1,
        held={"vertices": 0},
        driven={"vertices": 0},
        offset=np.eye(3, dtype=int)[sheet.axis].tolist(),
        curve=[[0, 0], *([sheet.dt * step, place] for step, place in enumerate(sheet.hand.tolist(), start=1))],
        **setting,
    )
    for vertices in (sheet.held, sheet.driven):
        text = text.replace("{'vertices': 0}", f"{{ vertices = {vertices.tolist()} }}", 1)
    scene.write_text(text)
    return scene


def processor_time(words: list[str | Path]) -> float:
    """Runs the program that `RHEXIS_PEER` names; the processor time that it took [s]."""
    process = subprocess.Popen([os.environ["RHEXIS_PEER"], *words], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    assert process.stderr is not None
    message = process.stderr.read()
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        raise RuntimeError(message.strip() or f"rhexis ended with status {status}")
    return usage.ru_utime + usage.ru_stime


def positions(frame: Path) -> Floats:
    """Positions of a ParaView frame."""
    found = re.search(r"<Points><DataArray[^>]*>([^<]*)</DataArray>", frame.read_text())
    assert found is not None
    # The block begins with its length.
    return np.frombuffer(base64.b64decode(found[1])[8:], dtype="<f8").reshape(-1, 3)


def run(sheet: Sheet, setting: Setting) -> Outcome:
    """Runs the sheet for its times and once more for its states."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        command = ["run", write(sheet, setting, folder), "--quiet", "--out"]
        whole = min(processor_time([*command, folder / "whole"]) for _ in range(2))
        begun = min(processor_time([*command, folder / "begun", "--steps", str(sheet.first)]) for _ in range(2))
        every = float(sheet.samples[1] - sheet.samples[0]) * sheet.dt
        processor_time([*command, folder / "states", "--set", f"output.frames_every={every}"])
        names = re.findall(r'timestep="([^"]*)"[^>]*file="([^"]*)"', (folder / "states" / "frames.pvd").read_text())
        frames = {round(float(time) / sheet.dt): folder / "states" / file for time, file in names}
        states = [positions(frames[step])[:, : sheet.dimension] for step in sheet.samples.tolist()]
    steps = len(sheet.hand) - sheet.first
    return Outcome(states, [(whole - begun) / steps] * steps)
