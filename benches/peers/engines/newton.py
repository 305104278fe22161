"""Newton: a cloth of neo-Hookean triangles, solved by vertex block descent on the processor, in single precision."""

from __future__ import annotations

import newton
import numpy as np
import warp as wp

from engines.outcome import Outcome, Setting
from sheet import Sheet


def model(sheet: Sheet) -> newton.Model:
    """The cloth, its edges held."""
    material = sheet.material
    builder = newton.ModelBuilder(gravity=(0.0, 0.0, 0.0))
    builder.add_cloth_mesh(
        pos=wp.vec3(),
        rot=wp.quat_identity(),
        scale=1.0,
        vel=wp.vec3(),
        vertices=[wp.vec3(x, y, 0.0) for x, y in sheet.points],
        indices=sheet.triangles.ravel().tolist(),
        density=material.density * material.thickness,
        tri_ke=material.mu * material.thickness,
        tri_ka=material.plane_stress_lambda * material.thickness,
        tri_kd=0.0,
        edge_ke=0.0,
        edge_kd=0.0,
        particle_radius=0.05,
    )
    for vertex in np.concatenate([sheet.held, sheet.driven]).tolist():
        builder.particle_mass[vertex] = 0.0
        builder.particle_flags[vertex] &= ~int(newton.ParticleFlags.ACTIVE)
    builder.color(include_bending=False)
    return builder.finalize(device="cpu")


def run(sheet: Sheet, setting: Setting) -> Outcome:
    """Runs the sheet."""
    wp.config.quiet = True
    cloth = model(sheet)
    solver = newton.solvers.SolverVBD(cloth, iterations=int(setting["iterations"]))
    substeps = int(setting["substeps"])
    before, after, control = cloth.state(), cloth.state(), cloth.control()
    for state in (before, after):
        # The arrays lie in this process' memory: what is written here is what the solver reads.
        state.particle_q.numpy()[:, : sheet.dimension] = sheet.start
    outcome, samples = Outcome(), set(sheet.samples.tolist())
    last = 0.0
    for step, pull in enumerate(sheet.hand, start=1):
        for part in range(1, substeps + 1):
            place = last + (pull - last) * part / substeps
            before.particle_q.numpy()[sheet.driven, sheet.axis] = sheet.start[sheet.driven, sheet.axis] + place
            outcome.step(lambda: solver.step(before, after, control, None, sheet.dt / substeps))
            before, after = after, before
        last = pull
        if step in samples:
            outcome.positions.append(before.particle_q.numpy()[:, : sheet.dimension].astype(np.float64))
    outcome.seconds = np.reshape(outcome.seconds, (-1, substeps)).sum(axis=1).tolist()
    return outcome
