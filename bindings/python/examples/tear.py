"""Tears the notched square of Figure 2, or another scene: `python examples/tear.py [SCENE [SHEET.obj]]`.

Prints the hash of the state at the end; writes the torn sheet where a file for it is named.
"""

from __future__ import annotations

import sys

import rhexis


def write_obj(world: rhexis.World, body: rhexis.Entity, path: str) -> None:
    """Writes a body as it lies. `rhexis.to_meshio` has its fields too, and other formats."""
    with open(path, "w", encoding="ascii") as file:
        for x, y, z in world.positions(body).tolist():
            file.write(f"v {x!r} {y!r} {z!r}\n")
        for a, b, c in (world.indices(body) + 1).tolist():
            file.write(f"f {a} {b} {c}\n")


def main(scene: str, sheet: str | None) -> None:
    run = rhexis.run_scene(scene, progress=sys.stderr.isatty())
    if sheet is not None:
        write_obj(run.world, run.world.bodies[0], sheet)
    print(f"{run.world.hash():016x}")


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "fig2-tear", sys.argv[2] if len(sys.argv) > 2 else None)
