"""The readme's own examples run."""

from __future__ import annotations

import re
from pathlib import Path

import rhexis

README = Path(__file__).resolve().parents[1] / "README.md"


def test_the_examples_of_the_readme_run() -> None:
    blocks = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)
    # The environment's is what test_gym.py plays.
    blocks = [block for block in blocks if "rhexis.gym" not in block]
    assert len(blocks) == 4
    if "verify" not in rhexis.FEATURES:
        blocks = [block for block in blocks if "work_precision" not in block]
    for block in blocks:
        exec(compile(block, str(README), "exec"), {})
