"""`rhexis-study FILE`: a sweep file over a cluster, from the shell."""

from __future__ import annotations

import argparse
import sys

from .program import ProgramError
from .study import Study, StudyError


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="rhexis-study", description="Runs a sweep file of rhexis over a Dask cluster.")
    parser.add_argument("file", help="a sweep file, see `rhexis sweep --help`")
    parser.add_argument("--out", help="output directory [default: out/<name of the file>]")
    parser.add_argument("--scheduler", help="address of a Dask scheduler, tcp://host:8786 [default: a process per core here]")
    parser.add_argument("--set", dest="changes", action="append", default=[], metavar="KEY=VALUE", help="a value of all cases")
    parser.add_argument("--program", help="path of the program `rhexis` on the workers [default: the variable RHEXIS, or PATH]")
    parser.add_argument("--retries", type=int, default=2, help="further attempts of a case whose program fails [default: 2]")
    given = parser.parse_args(arguments)
    try:
        study = Study(given.file, given.out, changes=given.changes, program=given.program)
        client = None
        if given.scheduler:
            from distributed import Client

            client = Client(given.scheduler)
        told = lambda case, record: print(f"case {case.number}: {record['end']}", file=sys.stderr)  # noqa: E731
        print(study.run(client, retries=given.retries, done=told))
    except (ProgramError, StudyError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
