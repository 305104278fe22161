"""What tests share: a small sheet, and refusals."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

import numpy as np
import pytest

import rhexis

SOFT = "strength_across_fibres = 0.05\nstrength_along_fibres = 0.01\nradius = 1.5"


def grid(n: int) -> tuple[np.ndarray, np.ndarray]:
    """A grid of n × n squares of 1 mm in the plane z = 0, as the tests of `bindings/c` have it."""
    x, y = np.meshgrid(np.arange(n + 1.0), np.arange(n + 1.0))
    positions = np.column_stack([x.ravel(), y.ravel(), np.zeros((n + 1) ** 2)])
    a = (np.arange(n)[:, None] * (n + 1) + np.arange(n)[None, :]).ravel()
    squares = np.stack([a, a + 1, a + n + 2, a, a + n + 2, a + n + 1], axis=1)
    return positions, squares.reshape(-1, 3).astype(np.uint32)


@contextlib.contextmanager
def refused(kind: str, part: str = "") -> Iterator[None]:
    """Refused with this kind, and a message that says so."""
    with pytest.raises(rhexis.Error) as caught:
        yield
    assert caught.value.kind == kind, f"{caught.value.kind}: {caught.value}"
    assert part in str(caught.value)


@pytest.fixture
def world() -> rhexis.World:
    """An empty world of one thread."""
    return rhexis.World(threads=1)


@pytest.fixture
def sheet(world: rhexis.World) -> rhexis.World:
    """A world with the sheet of 6 × 6 squares, which can tear, notched at the lower edge."""
    world.spawn(*grid(6), name="sheet", components={"Tearing": SOFT})
    world.cut([[3, 0, 0], [3, 2, 0]])
    return world
