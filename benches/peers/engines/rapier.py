"""rapier: a soft body of corotational triangles, driven by the program in `rapier/`."""

from __future__ import annotations

import os
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from engines.outcome import NotPossible, Outcome, Setting
from sheet import Sheet


def problem(sheet: Sheet) -> str:
    """The sheet as the program reads it: lists with their lengths before them."""
    material = sheet.material
    # The engine's law in two dimensions is that of plane strain: these moduli make it the plane stress of the scene.
    poisson = material.poisson / (1 + material.poisson)
    young = 2 * material.mu * (1 + poisson) * material.thickness
    lists = [sheet.points, sheet.masses, sheet.triangles, sheet.held, sheet.driven]
    text = [" ".join(map(repr, [len(flat), *flat])) for flat in (np.ravel(numbers).tolist() for numbers in lists)]
    text += [repr(young), repr(poisson), repr(float(sheet.dt))]
    text += [" ".join(map(repr, [len(flat), *flat])) for flat in (sheet.hand.tolist(), sheet.samples.tolist())]
    return "\n".join(text)


def run(sheet: Sheet, setting: Setting) -> Outcome:
    """Runs the sheet by the program that `RAPIER_PEER` names."""
    if not sheet.is_planar:
        raise NotPossible("its soft bodies of triangles lie in a plane; sheets in space are nets of springs, without moduli")
    with tempfile.TemporaryDirectory() as folder:
        given, out = Path(folder, "problem.txt"), Path(folder, "out.f64")
        given.write_text(problem(sheet))
        number = setting["iterations" if setting["solver"] == "fem" else "sweeps"]
        words = [setting["solver"], setting["substeps"], number]
        subprocess.run([os.environ["RAPIER_PEER"], given, out, *map(str, words)], check=True)
        numbers = np.fromfile(out, dtype="<f8")
    steps = len(sheet.hand)
    return Outcome(list(numbers[steps:].reshape(-1, len(sheet.points), 2)), numbers[:steps].tolist())
