"""Rhexis: tearing of fibre-reinforced soft-tissue membranes.

Units are fixed: mm, g, ms, hence N and MPa = N/mm². Arrays are copies: they are the caller's own and stay what they are.
"""

from ._rhexis import (
    ERROR_KINDS,
    FEATURES,
    Entity,
    Error,
    Recording,
    Report,
    Snapshot,
    World,
    __version__,
    cap,
    catalog,
    component_names,
    disc,
    grid,
    read_mesh,
    scene_text,
    verify,
    verify_cases,
    work_precision,
    work_precision_cases,
)
from .exchange import from_meshio, to_meshio, to_pyvista
from .run import Run, guide, load, run_scene

__all__ = [
    "ERROR_KINDS",
    "FEATURES",
    "Entity",
    "Error",
    "Recording",
    "Report",
    "Run",
    "Snapshot",
    "World",
    "__version__",
    "cap",
    "catalog",
    "component_names",
    "disc",
    "from_meshio",
    "grid",
    "guide",
    "load",
    "read_mesh",
    "run_scene",
    "scene_text",
    "to_meshio",
    "to_pyvista",
    "verify",
    "verify_cases",
    "work_precision",
    "work_precision_cases",
]
