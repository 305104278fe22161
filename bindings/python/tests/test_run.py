"""Whole runs, and exchange with meshio and PyVista."""

from __future__ import annotations

import builtins
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import grid

import rhexis


def test_a_scene_runs_to_its_end_and_tells_of_it(capsys: pytest.CaptureFixture[str]) -> None:
    seen: list[float] = []
    run = rhexis.run_scene("fig2-tear", steps=40, progress=True, on_step=lambda world, report: seen.append(report.time))
    assert run.steps == len(seen) == 40 and run.world.time == seen[-1]
    assert run.course is not None and run.course["outcome"] in ("unfinished", "ran_out")
    assert [event["step"] for event in run.events] == sorted(event["step"] for event in run.events)
    captured = capsys.readouterr()
    assert "step" in captured.err + captured.out


def test_progress_without_tqdm_is_lines(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    imported = builtins.__import__

    def without_tqdm(name: str, *rest: object) -> object:
        if name.startswith("tqdm"):
            raise ImportError(name)
        return imported(name, *rest)  # type: ignore[arg-type]

    monkeypatch.setattr(builtins, "__import__", without_tqdm)
    rhexis.run_scene("fig2-tear", steps=20, progress=True)
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 10 and lines[-1].startswith("20 of 20 steps")


def test_a_run_ends_where_it_is_asked_to() -> None:
    run = rhexis.run_scene("fig2-tear", on_step=lambda world, report: report.step < 5)
    assert run.steps == 5
    # A world goes on from where it is.
    assert rhexis.run_scene(run.world, steps=2).world.scene["step"] == 7


def test_scene_files_find_their_meshes(tmp_path: Path) -> None:
    (tmp_path / "one.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", encoding="utf-8")
    scene = tmp_path / "mine.toml"
    scene.write_text(
        """
[scene]
name = "one"
[run]
dt = 1
steps = 2
[[bodies]]
name = "one"
mesh = { file = "one.obj" }
material = { young_fibre = 10, young_transverse = 1, poisson_major = 0.3, thickness = 0.1 }
""",
        encoding="utf-8",
    )
    for given in (scene, str(scene)):
        assert rhexis.run_scene(given, changes={"run.steps": 1}).steps == 1


def test_meshio_takes_and_gives_bodies(sheet: rhexis.World, tmp_path: Path) -> None:
    meshio = pytest.importorskip("meshio")
    sheet.step(5.0)
    mesh = rhexis.to_meshio(sheet)
    assert set(mesh.point_data) == {"rest_position", "displacement", "velocity", "force"}
    assert {"fibre", "stress", "principal_stress", "criterion", "fragment"} == set(mesh.cell_data)
    file = tmp_path / "sheet.vtu"
    mesh.write(file)
    vertices, triangles, fibres = rhexis.from_meshio(meshio.read(file))
    np.testing.assert_allclose(vertices, sheet.positions())
    np.testing.assert_array_equal(triangles, sheet.indices())
    np.testing.assert_allclose(fibres, sheet.fields()["fibre"])
    again = rhexis.World(threads=1)
    again.spawn(vertices, triangles, fibres)
    assert again.indices().shape == sheet.indices().shape


def test_meshes_of_meshio_may_be_flat_and_have_other_cells() -> None:
    meshio = pytest.importorskip("meshio")
    points = np.array([[9.0, 9.0], [0, 0], [1, 0], [0, 1], [1, 1]])
    cells = [("line", [[0, 1]]), ("triangle", [[1, 2, 3]]), ("triangle", [[2, 4, 3]])]
    vertices, triangles, fibres = rhexis.from_meshio(meshio.Mesh(points, cells))
    assert vertices.shape == (4, 3) and triangles.tolist() == [[0, 1, 2], [1, 3, 2]] and fibres is None
    with pytest.raises(ValueError, match="no triangles; its cells: line"):
        rhexis.from_meshio(meshio.Mesh(points, cells[:1]))


def test_pyvista_shows_bodies(world: rhexis.World) -> None:
    pytest.importorskip("pyvista")
    world.spawn(*grid(4))
    surface = rhexis.to_pyvista(world)
    assert (surface.n_points, surface.n_cells) == (25, 32)
    assert surface.area == pytest.approx(16.0)
    assert "fibre" in surface.cell_data and "velocity" in surface.point_data


def test_verification_is_there_or_says_how_to_have_it() -> None:
    if "verify" in rhexis.FEATURES:
        assert "constitutive" in rhexis.verify_cases()
        rows = rhexis.verify("constitutive")
        assert rows and all(row["passes"] for row in rows)
    else:
        calls = (
            rhexis.verify_cases,
            lambda: rhexis.verify("patch"),
            rhexis.work_precision_cases,
            lambda: rhexis.work_precision("cook"),
        )
        for call in calls:
            with pytest.raises(rhexis.Error, match="--features verify") as caught:
                call()
            assert caught.value.kind == "unavailable"


@pytest.mark.skipif("verify" not in rhexis.FEATURES, reason="the build is without `verify`")
def test_work_precision_is_measured(tmp_path: Path) -> None:
    assert rhexis.work_precision_cases()["fig2-static"] == "fig2"
    told = rhexis.work_precision("cook", directory=tmp_path)
    errors = [row["stress_error"] for row in told["solvers"] if row["setting"] == "block Jacobi"]
    # Each tolerance is ten or more times the next; a solve may go on to the same iteration for two of them.
    assert len(errors) == 6 and errors == sorted(errors, reverse=True) and errors[5] < 1e-6 * errors[0]
    assert [row["tolerance"] for row in told["solvers"] if row["is_default"]] == [1e-9]
    (mesh,) = told["discretisation"]
    assert mesh["is_default"] and mesh["triangles"] == told["solvers"][0]["triangles"] == 2048
    assert all(row["median_ms"] > 0.0 for row in told["solvers"])
    assert told["fma_gflops"] > 0.0 and any("default" in remark for remark in told["remarks"])
    assert (tmp_path / "work-precision-cook-solvers.csv").is_file()
    for case, depth, kind in [("cok", "quick", "not_found"), ("cook", "deep", "invalid_input")]:
        with pytest.raises(rhexis.Error, match="did you mean `cook`|quick, usual or full") as caught:
            rhexis.work_precision(case, depth)  # type: ignore[arg-type]
        assert caught.value.kind == kind


@pytest.mark.parametrize(
    ("module", "use"),
    [
        ("meshio", "rhexis.to_meshio(rhexis.World.from_catalog('fig2-tear'))"),
        ("pyvista", "rhexis.to_pyvista(rhexis.World.from_catalog('fig2-tear'))"),
        ("gymnasium", "import rhexis.gym"),
    ],
)
def test_a_missing_extra_is_named_with_its_remedy(module: str, use: str) -> None:
    code = f"import sys; sys.modules[{module!r}] = None\nimport rhexis\n{use}"
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert ended.returncode == 1 and f"pip install {module}" in ended.stderr.splitlines()[-1]


def test_the_example_writes_the_torn_sheet(tmp_path: Path) -> None:
    example = Path(__file__).resolve().parents[1] / "examples" / "tear.py"
    sheet = tmp_path / "torn.obj"
    subprocess.run([sys.executable, str(example), "fig2-tear", str(sheet)], check=True, capture_output=True)
    run = rhexis.run_scene("fig2-tear")
    lines = sheet.read_text(encoding="ascii").splitlines()
    points = np.array([line.split()[1:] for line in lines if line.startswith("v ")], dtype=float)
    rows = np.array([line.split()[1:] for line in lines if line.startswith("f ")], dtype=int)
    np.testing.assert_array_equal(points, run.world.positions())
    np.testing.assert_array_equal(rows - 1, run.world.indices())
