"""The program `rhexis`, as a sweep needs it."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Sequence


class ProgramError(RuntimeError):
    """The program has refused or failed; the message is what it said."""


class Program:
    """Where the program is: a path, or a name on the PATH; by default the variable RHEXIS, then `rhexis`."""

    def __init__(self, path: str | os.PathLike[str] | None = None):
        named = os.fspath(path or os.environ.get("RHEXIS") or "rhexis")
        found = shutil.which(named)
        if found is None:
            raise ProgramError(
                f"there is no program {named}: install it by `cargo install --path crates/rhexis-cli`, "
                "or name it by the variable RHEXIS or by Program(path)"
            )
        self.path = str(Path(found).resolve())

    def sweep(self, *arguments: str) -> str:
        """Runs `rhexis sweep` to its end and returns what it has printed.

        The program ends after its step when this process dies: it sees that its standard input has ended, where it is asked to look
        (`--until-input-ends`). So a worker that is killed leaves nothing behind that takes the place of the case's next attempt.
        """
        with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
            command = [self.path, "sweep", *arguments]
            # Not by `communicate`, which would end the program's standard input at once.
            with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=out, stderr=err) as child:
                code = child.wait()
            said, complaint = (_text(file) for file in (out, err))
        if code != 0:
            raise ProgramError(complaint.strip().removeprefix("error: ") or f"{_quoted(command)} ended with code {code}")
        return said


def _text(file) -> str:
    file.seek(0)
    return file.read().decode("utf-8", "replace")


def _quoted(command: Sequence[str]) -> str:
    return " ".join(command)


def run_case(program: str, file: str, number: int, changes: Sequence[str]) -> str:
    """Runs one case on a worker, in a directory of its own that goes with it; returns its record, a line of cases.jsonl."""
    with tempfile.TemporaryDirectory(prefix="rhexis-case-") as folder:
        return Program(program).sweep(
            file, "--case", str(number), "--out", folder, "--until-input-ends", *_set(changes)
        )


def _set(changes: Sequence[str]) -> list[str]:
    return [word for change in changes for word in ("--set", change)]
