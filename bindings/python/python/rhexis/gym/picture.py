"""Pictures of the capsule, as `render` gives them: shaded triangles with a depth per pixel, in NumPy alone."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

_Array = NDArray[np.float64]

HALF = 5.3
"""Half of the picture's width [mm]."""
TILT = np.radians(32.0)
"""Angle of the view from the axis, towards -y."""
CAMERA = np.array([
    [1.0, 0.0, 0.0],
    [0.0, np.cos(TILT), np.sin(TILT)],
    [0.0, -np.sin(TILT), np.cos(TILT)],
])
"""Rows: directions to the right, upwards and to the eye. Parallel rays."""
CENTRE = np.array([0.0, 0.0, -0.4])
"""Place in the picture's centre [mm]."""
LIGHT = np.array([-0.45, 0.35, 0.82]) / np.linalg.norm([-0.45, 0.35, 0.82])
"""Direction to the light, as the camera has directions."""
GROUND = (30, 26, 34)
FRONT = (232, 196, 178)
BACK = (150, 178, 214)
EDGE = (96, 22, 34)
EDGE_WIDTH = 1.4
"""Width of the line along free edges [pixels]."""


class Ball(NamedTuple):
    """A shaded ball: the jaws, or a tip."""

    place: _Array
    radius: float
    colour: tuple[int, int, int]


def draw(positions: _Array, triangles: NDArray[np.uint32], balls: Sequence[Ball], size: int) -> NDArray[np.uint8]:
    """Draws triangles and balls: an array (size, size, 3). The side that triangles have counter-clockwise has another colour than their back;
    edges with a triangle on one side alone are dark.
    """
    picture = np.empty((size * size, 3))
    picture[:] = GROUND
    nearest = np.full(size * size, -np.inf)
    _draw_triangles(picture, nearest, on_screen(positions, size), triangles, size)
    for ball in balls:
        _draw_ball(picture, nearest, ball, size)
    return np.clip(picture, 0, 255).astype(np.uint8).reshape(size, size, 3)


def on_screen(places: _Array, size: int) -> _Array:
    """Column, row and distance towards the eye of places, in pixels."""
    seen = (places - CENTRE) @ CAMERA.T * (size / (2.0 * HALF))
    pixels: _Array = seen * np.array([1.0, -1.0, 1.0]) + np.array([size / 2.0, size / 2.0, 0.0])
    return pixels


def _draw_triangles(picture: _Array, nearest: _Array, points: _Array, triangles: NDArray[np.uint32], size: int) -> None:
    is_free = _free_edges(triangles)
    corners = points[triangles]
    # Pixels whose centres lie in the box of the corners.
    first = np.clip(np.ceil(corners[:, :, :2].min(axis=1) - 0.5), 0, size).astype(np.int64)
    last = np.clip(np.ceil(corners[:, :, :2].max(axis=1) - 0.5), 0, size).astype(np.int64)
    width, height = np.moveaxis(np.maximum(last - first, 0), 1, 0)
    count = width * height
    row_of = np.repeat(np.arange(len(triangles)), count)
    place = np.arange(len(row_of)) - np.repeat(np.cumsum(count) - count, count)
    column, line = first[row_of, 0] + place % width[row_of], first[row_of, 1] + place // width[row_of]

    # Weights of the corners: twice the areas of the parts over that of the whole.
    opposite = np.roll(corners, -2, axis=1) - np.roll(corners, -1, axis=1)
    whole = opposite[:, 2, 0] * -opposite[:, 1, 1] + opposite[:, 2, 1] * opposite[:, 1, 0]
    whole = np.where(np.abs(whole) > 1e-12, whole, np.inf)
    from_edge = np.stack([column + 0.5, line + 0.5], axis=1)[:, None, :] - np.roll(corners, -1, axis=1)[row_of, :, :2]
    side = opposite[row_of]
    weights = (side[:, :, 0] * from_edge[:, :, 1] - side[:, :, 1] * from_edge[:, :, 0]) / whole[row_of, None]
    is_inside = (weights >= 0.0).all(axis=1) & np.isfinite(whole[row_of])
    row_of, weights = row_of[is_inside], weights[is_inside]
    pixel = line[is_inside] * size + column[is_inside]
    depth = (weights * corners[row_of, :, 2]).sum(axis=1)

    # Rows of the picture go downwards, which turns the triangles' sense.
    normal = np.cross(opposite[:, 2], opposite[:, 0])
    normal *= np.array([-1.0, 1.0, -1.0]) / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    is_front = normal[:, 2] > 0.0
    colour = np.where(is_front[:, None], FRONT, BACK) * _shade(np.where(is_front[:, None], normal, -normal))[:, None]
    colour = colour[row_of]
    altitude = np.abs(whole)[:, None] / np.maximum(np.hypot(opposite[:, :, 0], opposite[:, :, 1]), 1e-300)
    is_edge = (is_free[row_of] & (weights * altitude[row_of] < EDGE_WIDTH)).any(axis=1)
    colour[is_edge] = EDGE

    # Of several assignments to a pixel the last one stands: that of the nearest.
    order = np.argsort(depth, kind="stable")
    picture[pixel[order]] = colour[order]
    nearest[pixel[order]] = depth[order]


def _shade(normal: _Array) -> _Array:
    """Brightness by the direction of surfaces that face the eye."""
    brightness: _Array = 0.45 + 0.6 * np.maximum(normal @ LIGHT, 0.0)
    return brightness


def _free_edges(triangles: NDArray[np.uint32]) -> NDArray[np.bool_]:
    """Whether the edge opposite to each corner belongs to one triangle alone."""
    ends = np.stack([np.roll(triangles, -1, axis=1), np.roll(triangles, -2, axis=1)], axis=2).astype(np.uint64)
    key = ends.min(axis=2) << np.uint64(32) | ends.max(axis=2)
    _, inverse, count = np.unique(key.ravel(), return_inverse=True, return_counts=True)
    is_free: NDArray[np.bool_] = (count[inverse] == 1).reshape(triangles.shape)
    return is_free


def _draw_ball(picture: _Array, nearest: _Array, ball: Ball, size: int) -> None:
    column, line, depth = on_screen(ball.place, size)
    radius = ball.radius * size / (2.0 * HALF)
    low = np.clip(np.floor([column - radius, line - radius]), 0, size).astype(int)
    high = np.clip(np.ceil([column + radius, line + radius]), 0, size).astype(int)
    y, x = np.mgrid[low[1] : high[1], low[0] : high[0]]
    right, up = (x + 0.5 - column) / radius, (line - y - 0.5) / radius
    bulge = 1.0 - right**2 - up**2
    pixel, towards = y * size + x, np.sqrt(np.maximum(bulge, 0.0))
    is_seen = (bulge > 0.0) & (depth + radius * towards > nearest[pixel])
    normal = np.stack([right, up, towards], axis=-1)[is_seen]
    picture[pixel[is_seen]] = np.array(ball.colour) * _shade(normal)[:, None]
    nearest[pixel[is_seen]] = depth + radius * towards[is_seen]
