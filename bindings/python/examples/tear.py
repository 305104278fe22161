"""Tears the notched square of Figure 2, or another scene: `python examples/tear.py [SCENE [MESH]]`.

Prints the hash of the state at the end; writes the sheet where a file for it is named, in a format of meshio.
"""

from __future__ import annotations

import sys

import rhexis


def main(scene: str, mesh: str | None) -> None:
    run = rhexis.run_scene(scene, progress=sys.stderr.isatty())
    if mesh is not None:
        rhexis.to_meshio(run.world, run.world.bodies[0]).write(mesh)
    print(f"{run.world.hash():016x}")


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "fig2-tear", sys.argv[2] if len(sys.argv) > 2 else None)
