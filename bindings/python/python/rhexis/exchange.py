"""Exchange with meshio and PyVista: both are extras."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ._rhexis import Entity, World

if TYPE_CHECKING:
    import meshio
    import pyvista

FIBRE_NAMES = ("fibre", "fiber", "fibres", "fibers", "f0")
"""Names of the cell array of the fibres, in any case of letters."""


def _arrays(world: World, body: Entity | str | None) -> tuple[dict[str, NDArray[Any]], dict[str, NDArray[Any]]]:
    """Arrays by vertex and by triangle."""
    rest = world.rest_positions(body)
    fields = dict(world.fields(body))
    points = {
        "rest_position": rest,
        "displacement": world.positions(body) - rest,
        "velocity": world.velocities(body),
        "force": fields.pop("force"),
    }
    return points, {**fields, "fragment": world.fragments(body)["of_triangle"]}


def to_meshio(world: World, body: Entity | str | None = None) -> meshio.Mesh:
    """Mesh of meshio of a body as it lies: its fields by vertex and by triangle, lengths in mm, stresses in MPa."""
    try:
        import meshio
    except ModuleNotFoundError as error:
        raise ModuleNotFoundError("to_meshio needs meshio: pip install meshio") from error

    points, cells = _arrays(world, body)
    triangles = [("triangle", world.indices(body).astype(np.int64))]
    by_cell = {name: [values] for name, values in cells.items()}
    return meshio.Mesh(world.positions(body), triangles, point_data=points, cell_data=by_cell)


def from_meshio(mesh: meshio.Mesh) -> tuple[NDArray[np.float64], NDArray[np.uint32], NDArray[np.float64] | None]:
    """Vertices (n, 3), triangles (m, 3) and fibres (m, 3) or None of a mesh of meshio, for `World.spawn`.

    Cells of other kinds are left out, and vertices that no triangle has. A cell array of a usual name gives the fibres.
    """
    blocks = [(i, block.data) for i, block in enumerate(mesh.cells) if block.type == "triangle"]
    if not blocks:
        kinds = ", ".join(sorted({block.type for block in mesh.cells})) or "none"
        raise ValueError(f"the mesh has no triangles; its cells: {kinds}")
    triangles = np.vstack([data for _, data in blocks])
    used, rows = np.unique(triangles, return_inverse=True)
    points = np.asarray(mesh.points, dtype=np.float64)[used]
    if points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points))])
    fibres = None
    for name, values in mesh.cell_data.items():
        if name.lower() in FIBRE_NAMES:
            fibres = np.vstack([np.asarray(values[i], dtype=np.float64) for i, _ in blocks])
    return points, rows.reshape(-1, 3).astype(np.uint32), fibres


def to_pyvista(world: World, body: Entity | str | None = None) -> pyvista.PolyData:
    """Surface of PyVista of a body as it lies, with the arrays of `to_meshio`."""
    try:
        import pyvista
    except ModuleNotFoundError as error:
        raise ModuleNotFoundError("to_pyvista needs PyVista: pip install pyvista") from error

    triangles = world.indices(body)
    faces = np.column_stack([np.full(len(triangles), 3, dtype=np.int64), triangles])
    surface = pyvista.PolyData(world.positions(body), faces.ravel())
    points, cells = _arrays(world, body)
    for name, values in points.items():
        surface.point_data[name] = values
    for name, values in cells.items():
        surface.cell_data[name] = values
    return surface
