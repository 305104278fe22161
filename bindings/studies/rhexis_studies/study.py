"""A sweep file and its output directory, run over a cluster."""

from __future__ import annotations

import contextlib
import csv
import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Callable, Iterator, Sequence

from .program import Program, ProgramError, _set, run_case

if TYPE_CHECKING:
    from distributed import Client

try:
    import fcntl
except ImportError:  # Windows: two studies at once into one directory are not told apart there.
    fcntl = None


class StudyError(RuntimeError):
    """Cases that gave no record, with their reasons; the others are done and in the table."""


@dataclass(frozen=True)
class Case:
    """A case of a sweep: its number, its key, its values by parameter, and whether it is done."""

    number: int
    key: str
    values: dict[str, str]
    is_done: bool


class Study:
    """A sweep file (see `rhexis sweep --help`) and the directory of its results.

    `file` and what it names must lie at the same path for all workers; `out` is written by this process alone. `changes` are
    assignments `key=value` for all cases, as `--set` has them. `program` is the path of the program on the workers.
    """

    def __init__(
        self,
        file: str | os.PathLike[str],
        out: str | os.PathLike[str] | None = None,
        *,
        changes: Sequence[str] = (),
        program: str | os.PathLike[str] | None = None,
    ):
        self.file = Path(file).resolve()
        self.out = Path(out) if out is not None else Path("out") / self.file.stem
        self.changes = tuple(changes)
        self.program = Program(program)

    def cases(self) -> list[Case]:
        """All cases in their order. Raises ProgramError for a file that is refused, with line and remedy."""
        told = json.loads(self._sweep("--list", "--json"))
        return [Case(case["case"], case["key"], case["values"], case["is_done"]) for case in told["cases"]]

    def run(
        self,
        client: Client | None = None,
        *,
        retries: int = 2,
        done: Callable[[Case, dict], None] | None = None,
    ) -> Path:
        """Runs the cases that are not done and returns the path of the table.

        `client` is that of a cluster; without one, a cluster of a process per core of this machine is started and closed again. The
        cases of a worker that is lost are run by others; a case whose program fails is tried `retries` times more. A failed run or a
        refused scene is no failure of the program: it is a row with its reason. `done` is called for each case with its record.

        Raises StudyError for cases without a record, after all others, and ProgramError where the directory is in use.
        """
        with _locked(self.out):
            if client is None:
                from distributed import Client, LocalCluster

                with LocalCluster(threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as own:
                    lost = self._run(own, retries, done)
            else:
                lost = self._run(client, retries, done)
        self._sweep("--table", "--quiet")
        if lost:
            reasons = "\n".join(f"case {case.number}: {reason}" for case, reason in sorted(lost, key=lambda l: l[0].number))
            raise StudyError(f"{len(lost)} case(s) gave no record; run the study again to try them anew\n{reasons}")
        return self.out / "table.csv"

    def table(self) -> list[dict[str, str]]:
        """The rows of the table, by column."""
        with open(self.out / "table.csv", newline="", encoding="utf-8") as file:
            return list(csv.DictReader(file))

    def _sweep(self, *arguments: str) -> str:
        return self.program.sweep(str(self.file), "--out", str(self.out), *_set(self.changes), *arguments)

    def _run(self, client: Client, retries: int, done: Callable[[Case, dict], None] | None) -> list[tuple[Case, str]]:
        from distributed import as_completed

        # Two cases of one key are one run.
        waiting = {case.key: case for case in self.cases() if not case.is_done}
        if not waiting:
            return []
        futures = {
            client.submit(
                run_case,
                self.program.path,
                str(self.file),
                case.number,
                self.changes,
                key=f"rhexis-{key}",
                retries=retries,
                pure=False,
            ): case
            for key, case in waiting.items()
        }
        lost = []
        with _journal(self.out / "cases.jsonl") as journal:
            for future in as_completed(futures):
                case = futures[future]
                error = future.exception()
                if error is not None:
                    lost.append((case, f"{type(error).__name__}: {error}"))
                else:
                    line = future.result().strip()
                    record = json.loads(line)
                    if record["key"] != case.key:
                        reason = "the worker has another program, scene or mesh file than this process"
                        lost.append((case, reason))
                    else:
                        journal(line)
                        if done is not None:
                            done(case, record)
                # The result is kept here and need not be there.
                future.release()
        return lost


@contextlib.contextmanager
def _journal(path: Path) -> Iterator[Callable[[str], None]]:
    """Appends lines, each on the disk before the next; half a line that a killed writer has left is taken away first."""
    with open(path, "ab+") as file:
        file.seek(0)
        whole = file.read().rfind(b"\n") + 1
        file.truncate(whole)

        def append(line: str) -> None:
            file.write(line.encode() + b"\n")
            file.flush()
            os.fsync(file.fileno())

        yield append


@contextlib.contextmanager
def _locked(folder: Path) -> Iterator[None]:
    """Keeps other studies and `rhexis sweep` out of a directory."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "run.lock"
    with _taken(path) as file:
        file.truncate(0)
        file.write(f"process {os.getpid()}\n")
        file.flush()
        try:
            yield
        finally:
            with contextlib.suppress(OSError):
                path.unlink()


def _taken(path: Path):
    """The locked file at a path."""
    while True:
        file = open(path, "a+", encoding="utf-8")
        if fcntl is None:
            return file
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            file.close()
            what = f"{path.parent} is in use by another sweep; wait for its end, or choose another `out`"
            raise ProgramError(what) from None
        # Whoever had it before may have taken the file away in between: it would lock nothing.
        with contextlib.suppress(FileNotFoundError):
            if os.path.samestat(os.fstat(file.fileno()), os.stat(path)):
                return file
        file.close()
