"""A study over a local cluster of processes: the same table as the program's own, whatever is lost on the way."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import threading
import time
from pathlib import Path

import pytest
from distributed import Client, LocalCluster

from rhexis_studies import Program, ProgramError, Study, StudyError

SWEEP = """
scene = "fig2-tear"
samples = 2

[set]
"run.steps" = 150
"run.until_torn" = false
"bodies.0.mesh" = { grid = { width = 30, height = 30, nx = 12, ny = 12 } }
"bodies.0.tearing.radius" = 4

[vary]
"bodies.0.fibres.degrees" = [45, 60, 75]
"bodies.0.material.young_fibre" = [5, 10]

[sample]
"bodies.0.damping" = { uniform = [0.05, 0.2] }
"""


@pytest.fixture(scope="session")
def cluster():
    with LocalCluster(n_workers=3, threads_per_worker=1, processes=True, dashboard_address=None) as cluster:
        yield cluster


@pytest.fixture
def client(cluster):
    with Client(cluster) as client:
        client.wait_for_workers(3)
        yield client


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "twelve.toml"
    path.write_text(SWEEP)
    return path


@pytest.fixture(scope="session")
def expected(tmp_path_factory) -> bytes:
    """The table of `rhexis sweep` itself."""
    folder = tmp_path_factory.mktemp("whole")
    (folder / "twelve.toml").write_text(SWEEP)
    subprocess.run([Program().path, "sweep", "twelve.toml", "--quiet"], cwd=folder, check=True)
    return (folder / "out/twelve/table.csv").read_bytes()


def keys(study: Study) -> list[str]:
    return [json.loads(line)["key"] for line in (study.out / "cases.jsonl").read_text().splitlines()]


def children() -> list[str]:
    """Command lines of programs that run a case alone."""
    lines = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            words = (process / "cmdline").read_bytes().split(b"\0")
        except OSError:
            continue
        if b"--until-input-ends" in words:
            lines.append(b" ".join(words).decode())
    return lines


def test_a_worker_killed_in_the_middle_loses_and_doubles_no_case(client, file, expected):
    study = Study(file, file.parent / "out")
    workers = client.run(os.getpid)
    killed = threading.Event()
    calls: list[int] = []

    def kill() -> None:
        # One that runs a case now: all are busy while cases wait.
        _, victim = sorted(workers.items())[0]
        os.kill(victim, signal.SIGKILL)
        killed.set()

    def done(case, record) -> None:
        calls.append(case.number)
        if len(calls) == 2:
            threading.Thread(target=kill).start()

    table = study.run(client, done=done)
    assert killed.wait(10)
    assert sorted(calls) == list(range(12))
    assert len(keys(study)) == len(set(keys(study))) == 12
    assert table.read_bytes() == expected
    # What the killed worker had begun has ended as well.
    deadline = time.monotonic() + 20
    while children() and time.monotonic() < deadline:
        time.sleep(0.1)
    assert children() == []


def test_what_is_done_is_not_run_again(client, file, expected):
    study = Study(file, file.parent / "out")
    whole = Study(file, file.parent / "whole")
    whole.run(client)
    lines = (whole.out / "cases.jsonl").read_text().splitlines(keepends=True)
    study.out.mkdir()
    # Five are done, and one was being written when the process was killed.
    (study.out / "cases.jsonl").write_text("".join(lines[:5]) + lines[5][:40])
    calls: list[int] = []
    study.run(client, done=lambda case, record: calls.append(case.number))
    assert len(calls) == 7
    assert len(set(keys(study))) == len(keys(study)) == 12
    assert (study.out / "table.csv").read_bytes() == expected
    rows = study.table()
    assert [row["case"] for row in rows] == [str(number) for number in range(12)]
    assert all(float(row["right_peak_n"]) > 0 for row in rows)
    # And the program's own command finds nothing left to do.
    subprocess.run([Program().path, "sweep", str(file), "--out", str(study.out), "--quiet"], check=True)
    assert len(keys(study)) == 12


def test_refused_scenes_are_rows_and_refused_files_are_errors(client, file):
    file.write_text(SWEEP.replace('"bodies.0.damping" = { uniform = [0.05, 0.2] }', '"bodies.0.damping" = { choice = [-1] }'))
    study = Study(file, file.parent / "out")
    study.run(client)
    rows = study.table()
    assert [row["end"] for row in rows] == ["refused"] * 12
    assert "damping" in rows[0]["reason"]
    file.write_text(SWEEP.replace("damping", "dumping"))
    with pytest.raises(ProgramError, match=r"twelve\.toml:16:1(.|\n)*damping"):
        study.run(client)


def test_what_gives_no_record_is_told_and_tried_again(client, file, expected, tmp_path):
    # A program that fails in two cases, as one does that is not installed everywhere.
    program = tmp_path / "sometimes"
    program.write_text(
        f'#!/bin/sh\ncase " $* " in *" --case 3 "*|*" --case 7 "*) echo "not here" >&2; exit 1;; esac\nexec "{Program().path}" "$@"\n'
    )
    program.chmod(0o755)
    study = Study(file, tmp_path / "out", program=program)
    with pytest.raises(StudyError, match=r"2 case\(s\)(.|\n)*case 3: ProgramError: not here"):
        study.run(client, retries=1)
    assert len(study.table()) == 10
    again = Study(file, tmp_path / "out")
    again.run(client)
    assert (again.out / "table.csv").read_bytes() == expected


def test_two_studies_do_not_write_into_one_directory(client, file, tmp_path):
    study = Study(file, tmp_path / "out")
    refused: list[Exception] = []

    def second(case, record) -> None:
        if not refused:
            try:
                Study(file, study.out).run(client)
            except ProgramError as error:
                refused.append(error)

    study.run(client, done=second)
    assert "in use" in str(refused[0])
    with pytest.raises(ProgramError, match="no program"):
        Program("no-such-program")
