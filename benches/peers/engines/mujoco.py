"""MuJoCo: a flex of two dimensions with elasticity in its plane, in implicit steps.

An elastic flex takes no `mocap` bodies. What is held or driven is therefore a body with so much mass that the sheet's forces do not move
it, and its place is set before every step.
"""

from __future__ import annotations

from functools import partial

import mujoco
import numpy as np

from engines.outcome import Outcome, Setting
from sheet import Sheet

HEAVY = 1e6
"""Mass of what is held [g]."""

HEAD = """
<mujoco>
  <option timestep="{dt}" integrator="discrete" solver="CG" jacobian="sparse" tolerance="1e-10" iterations="{iterations}" gravity="0 0 0">
    <flag contact="disable"/>
  </option>
  <size memory="1G"/>
  <worldbody>
"""
BODY = """
    <body name="{name}" pos="{x:.17g} {y:.17g} 0">
      <inertial pos="0 0 0" mass="{mass:.17g}" diaginertia="{mass:.17g} {mass:.17g} {mass:.17g}"/>
      {joints}
    </body>
"""
FLEX = """
  </worldbody>
  <deformable>
    <flex name="sheet" dim="2" radius="0.05" body="{bodies}" vertex="{vertices}" element="{elements}">
      <contact selfcollide="none"/>
      <elasticity young="{young}" poisson="{poisson}" thickness="{thickness}" elastic2d="stretch"/>
    </flex>
  </deformable>
</mujoco>
"""


def model(sheet: Sheet, setting: Setting) -> str:
    """The model's file: a body with slides for every vertex, in the rest shape."""
    axes = ("1 0 0", "0 1 0", "0 0 1")[: sheet.dimension]
    joints = "".join(f'<joint type="slide" axis="{axis}"/>' for axis in axes)
    fixed = set(sheet.held.tolist()) | set(sheet.driven.tolist())
    parts = [HEAD.format(dt=sheet.dt / float(setting["substeps"]), iterations=setting["iterations"])]
    for index, ((x, y), mass) in enumerate(zip(sheet.points, sheet.masses, strict=True)):
        parts.append(BODY.format(name=f"v{index}", x=x, y=y, mass=HEAVY if index in fixed else mass, joints=joints))
    count, material = len(sheet.points), sheet.material
    parts.append(
        FLEX.format(
            bodies=" ".join(f"v{index}" for index in range(count)),
            vertices=" ".join(["0 0 0"] * count),
            elements=" ".join(map(str, sheet.triangles.ravel())),
            young=material.young,
            poisson=material.poisson,
            thickness=material.thickness,
        )
    )
    return "".join(parts)


def run(sheet: Sheet, setting: Setting) -> Outcome:
    """Runs the sheet."""
    compiled = mujoco.MjModel.from_xml_string(model(sheet, setting))
    data = mujoco.MjData(compiled)
    count, d = len(sheet.points), sheet.dimension
    rest = np.column_stack([sheet.points, np.zeros(count)])[:, :d]
    places, velocities = data.qpos.reshape(count, d), data.qvel.reshape(count, d)
    places[:] = sheet.start - rest
    fixed = np.concatenate([sheet.held, sheet.driven])
    outcome, samples = Outcome(), set(sheet.samples.tolist())
    substeps = int(setting["substeps"])

    def step_to(last: float, pull: float) -> None:
        for part in range(1, substeps + 1):
            places[fixed] = (sheet.start - rest)[fixed]
            places[sheet.driven, sheet.axis] += last + (pull - last) * part / substeps
            velocities[fixed] = 0
            mujoco.mj_step(compiled, data)

    last = 0.0
    for step, pull in enumerate(sheet.hand.tolist(), start=1):
        outcome.step(partial(step_to, last, pull))
        last = pull
        if step in samples:
            outcome.positions.append(rest + places)
    return outcome
