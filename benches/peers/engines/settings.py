"""Settings of every engine, from coarse to fine."""

from __future__ import annotations

from engines.outcome import Setting

SETTINGS: dict[str, list[Setting]] = {
    "rhexis": [{"stress_tolerance": 10.0**power} for power in (-0.5, -1, -1.5, -2, -3, -4, -5)],
    "rapier": [
        *({"solver": "fem", "substeps": 1, "iterations": count} for count in (3, 5, 10, 20, 40, 80, 160)),
        *({"solver": "constraints", "substeps": count, "sweeps": 4} for count in (1, 4, 16, 64)),
    ],
    "mujoco": [
        *({"substeps": 1, "iterations": count} for count in (1, 2, 3, 5, 10, 20, 40)),
        *({"substeps": count, "iterations": 20} for count in (2, 4)),
        *({"substeps": 1, "iterations": count} for count in (80, 160)),
    ],
    "newton": [
        *({"substeps": 1, "iterations": count} for count in (1, 3, 10, 30, 100)),
        *({"substeps": 10, "iterations": count} for count in (1, 10)),
    ],
}
