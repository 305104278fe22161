"""Rhexis: a membrane, run by the program `rhexis` from a scene file.

The program tells no processor time of single steps. A step's is the difference of a whole run and one that ends where the measured steps
begin, over their number; the account that the program keeps of every step (energies, reactions, `series.csv`) is in it.
"""

from __future__ import annotations

import base64
import os
import re
import struct
import subprocess
import tempfile
import zlib
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
        stretch=sheet.stretch,
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
