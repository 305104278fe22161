"""Sweeps of the tearing simulation rhexis over the processes and machines of a Dask cluster.

    from dask.distributed import Client
    from rhexis_studies import Study

    if __name__ == "__main__":
        study = Study("capsule.toml", out="out/capsule")
        study.run(Client("tcp://scheduler:8786"))     # or study.run(): this machine
        for row in study.table():
            print(row["case"], row["end"], row["force_rms_n"])

The cases, their runs, the table and its plots are those of `rhexis sweep`: a study may be begun by the one and ended by the other.
"""

from .program import Program, ProgramError
from .study import Case, Study, StudyError

__all__ = ["Case", "Program", "ProgramError", "Study", "StudyError"]
