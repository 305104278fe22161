"""The sheet of a scene file: mesh, motion of the hand, static solution and errors against it.

Nothing here comes from an engine that is measured. Units are those of the scene: mm, g, ms, N, MPa.
"""

from __future__ import annotations

import math
import random
import tomllib
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import splu

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]


@dataclass(frozen=True)
class Material:
    """Isotropic elasticity in plane stress."""

    young: float
    poisson: float
    thickness: float
    density: float

    @property
    def mu(self) -> float:
        """Shear modulus [MPa]."""
        return self.young / (2 * (1 + self.poisson))

    @property
    def plane_stress_lambda(self) -> float:
        """Lamé's first parameter in plane stress [MPa]."""
        return self.young * self.poisson / (1 - self.poisson**2)


@dataclass(frozen=True)
class Errors:
    """Errors of a run over its samples, relative to the largest reference value."""

    force: float
    displacement: float


@dataclass(frozen=True)
class Sheet:
    """A scene on one of its meshes."""

    name: str
    material: Material
    width: float
    height: float
    stretch: float
    """Of the sheet in its plane, before the hand moves."""
    axis: int
    """Along which the hand moves: 0 in the plane, from the right edge; 2 out of it, from the middle."""
    patch: float
    """Half the side of the square that the hand holds in the middle [mm]."""
    cells: tuple[int, int]
    dt: float
    hand: Floats
    """Displacement of the hand at the end of each step [mm]."""
    first: int
    """Number of steps before the measured ones."""
    samples: Ints
    """Steps after which positions are compared, counted from 1."""

    @classmethod
    def read(cls, path: Path, cells: tuple[int, int]) -> Sheet:
        """Reads a scene file for one of its meshes."""
        scene = tomllib.loads(path.read_text())
        sheet, run, hand = scene["sheet"], scene["run"], scene["hand"]
        material = Material(sheet["young"], sheet["poisson"], sheet["thickness"], sheet["density"])
        first = round(hand["rise"] / run["dt"])
        return cls(
            name=scene["name"],
            material=material,
            width=sheet["width"],
            height=sheet["height"],
            stretch=sheet["stretch"],
            axis="xyz".index(hand["axis"]),
            patch=hand["patch"],
            cells=cells,
            dt=run["dt"],
            hand=motion(hand, run["dt"], run["steps"]),
            first=first,
            samples=np.arange(run["sample"], run["steps"] + 1, run["sample"], dtype=np.int32)[first // run["sample"] :],
        )

    @property
    def is_planar(self) -> bool:
        """Whether nothing leaves the plane."""
        return self.axis < 2

    @property
    def dimension(self) -> int:
        """Axes of a position."""
        return 2 if self.is_planar else 3

    @cached_property
    def points(self) -> Floats:
        """Vertices at rest, row by row, about the origin: single precision is finest there."""
        (nx, ny), (x, y) = self.cells, (self.width / 2, self.height / 2)
        x, y = np.meshgrid(np.linspace(-x, x, nx + 1), np.linspace(-y, y, ny + 1))
        return np.column_stack([x.ravel(), y.ravel()])

    @cached_property
    def start(self) -> Floats:
        """Positions before the hand moves, as many axes as there are."""
        return np.column_stack([self.stretch * self.points, np.zeros(len(self.points))])[:, : self.dimension]

    @cached_property
    def triangles(self) -> Ints:
        """Corners, counter-clockwise; the diagonals alternate."""
        nx, ny = self.cells
        corners = []
        for j in range(ny):
            for i in range(nx):
                a = j * (nx + 1) + i
                b, c, d = a + 1, a + nx + 2, a + nx + 1
                corners += [(a, b, c), (a, c, d)] if (i + j) % 2 == 0 else [(a, b, d), (b, c, d)]
        return np.array(corners, dtype=np.int32)

    @cached_property
    def held(self) -> Ints:
        """Vertices at rest: the left edge, or the sheet's whole boundary."""
        x, y = np.abs(self.points).T
        is_held = self.points[:, 0] == -self.width / 2
        if not self.is_planar:
            is_held = (x == self.width / 2) | (y == self.height / 2)
        return np.flatnonzero(is_held).astype(np.int32)

    @cached_property
    def driven(self) -> Ints:
        """Vertices that the hand moves."""
        is_driven = self.points[:, 0] == self.width / 2
        if not self.is_planar:
            is_driven = np.abs(self.points).max(axis=1) <= self.patch
        return np.flatnonzero(is_driven).astype(np.int32)

    @cached_property
    def gradients(self) -> tuple[Floats, Floats]:
        """Gradients of the shape functions (triangle, corner, axis), and areas times thickness."""
        a, b, c = (self.points[self.triangles[:, k]] for k in range(3))
        edges = np.stack([b - a, c - a], axis=2)
        inverse = np.linalg.inv(edges)
        gradients = np.concatenate([-inverse.sum(axis=1, keepdims=True), inverse], axis=1)
        return gradients, np.linalg.det(edges) / 2 * self.material.thickness

    @cached_property
    def masses(self) -> Floats:
        """Lumped masses [g]."""
        masses = np.zeros(len(self.points))
        for k in range(3):
            np.add.at(masses, self.triangles[:, k], self.gradients[1] * self.material.density / 3)
        return masses

    def forces(self, state: Floats) -> tuple[Floats, sparse.csc_matrix]:
        """Gradient of Saint Venant–Kirchhoff's energy [N] and its derivative [N/mm], all axes of a vertex together."""
        (gradients, volumes), (mu, lam) = self.gradients, (self.material.mu, self.material.plane_stress_lambda)
        count, d = len(volumes), self.dimension
        deformation = np.einsum("tki,tkj->tij", state[self.triangles], gradients)
        green = (np.einsum("tki,tkj->tij", deformation, deformation) - np.eye(2)) / 2
        trace = np.trace(green, axis1=1, axis2=2)
        stress = 2 * mu * green + lam * trace[:, None, None] * np.eye(2)
        strain = np.zeros((count, 3, 3, d))
        for k in range(3):
            along, across = gradients[:, k, :1], gradients[:, k, 1:]
            strain[:, 0, k] = deformation[:, :, 0] * along
            strain[:, 1, k] = deformation[:, :, 1] * across
            strain[:, 2, k] = deformation[:, :, 0] * across + deformation[:, :, 1] * along
        strain = strain.reshape(count, 3, 3 * d)
        voigt = np.stack([stress[:, 0, 0], stress[:, 1, 1], stress[:, 0, 1]], axis=1)
        axes = (d * self.triangles[:, :, None] + np.arange(d)).reshape(count, 3 * d)
        total = np.zeros(d * len(self.points))
        np.add.at(total, axes, np.einsum("tki,tk->ti", strain, voigt) * volumes[:, None])
        law = np.array([[2 * mu + lam, lam, 0], [lam, 2 * mu + lam, 0], [0, 0, mu]])
        element = np.einsum("tki,kl,tlj->tij", strain, law, strain, optimize=True)
        geometric = np.einsum("tai,tij,tbj->tab", gradients, stress, gradients, optimize=True)
        element += np.einsum("tab,ij->taibj", geometric, np.eye(d)).reshape(count, 3 * d, 3 * d)
        element *= volumes[:, None, None]
        rows, columns = np.repeat(axes, 3 * d, axis=1), np.tile(axes, (1, 3 * d))
        return total, sparse.csc_matrix((element.ravel(), (rows.ravel(), columns.ravel())))

    def force(self, state: Floats) -> float:
        """Force of the hand along its way [N], that the positions ask for."""
        return float(self.forces(state)[0].reshape(-1, self.dimension)[self.driven, self.axis].sum())

    @cached_property
    def free(self) -> Ints:
        """Axes that nothing prescribes."""
        d, fixed = self.dimension, np.concatenate([self.held, self.driven])
        return np.setdiff1d(np.arange(d * len(self.points)), (d * fixed[:, None] + np.arange(d)).ravel()).astype(np.int32)

    def linear_solutions(self) -> Floats:
        """Static solutions of linear elasticity about the start, at the samples (sample, vertex, axis)."""
        unit = np.zeros_like(self.start)
        unit[self.driven, self.axis] = 1
        tangent = self.forces(self.start)[1]
        unit.reshape(-1)[self.free] = -splu(tangent[self.free][:, self.free].tocsc()).solve((tangent @ unit.ravel())[self.free])
        return self.start + self.hand[self.samples - 1, None, None] * unit

    def static_solutions(self) -> Floats:
        """Static solutions at the samples (sample, vertex, axis)."""
        states, state, last = [], self.start, 0.0
        for pull in self.hand[self.samples - 1].tolist():
            # The first one in parts: Newton's method from the sheet at rest finds none on a fine mesh.
            for place in np.linspace(last, pull, 2 if last else 11)[1:].tolist():
                # From the last solution, scaled: exact where the sheet answers in proportion.
                state = self.static_solution(self.start + (state - self.start) * (place / last if last else 1.0), place)
                last = place
            states.append(state)
        return np.array(states)

    def static_solution(self, guess: Floats, pull: float) -> Floats:
        """Static solution at a place of the hand, by Newton's method with direct solves; no step makes the imbalance larger."""
        free, state = self.free, guess.copy()
        state[self.driven, self.axis] = self.start[self.driven, self.axis] + pull
        gradient, tangent = self.forces(state)
        for _ in range(60):
            change = splu(tangent[free][:, free].tocsc()).solve(gradient[free])
            if np.abs(change).max() < 1e-8 * abs(pull):
                return state
            before, part = np.abs(gradient[free]).max(), 1.0
            while True:
                following = state.copy()
                following.reshape(-1)[free] -= part * change
                gradient, tangent = self.forces(following)
                if np.abs(gradient[free]).max() < before or part < 1e-3:
                    break
                part /= 2
            state = following
        raise RuntimeError(f"{self.name}: no static solution at a pull of {pull} mm")

    def errors(self, positions: Floats, reference: Floats) -> Errors:
        """Errors of the positions at the samples against the static solutions there."""
        pulls = self.hand[self.samples - 1]
        exact = np.array([self.force(state) for state in reference])
        reached = np.array([self.force(state) for state in positions])
        distance = math.sqrt(float(((positions - reference) ** 2).sum(axis=2).mean()))
        force = math.sqrt(float(((reached - exact) ** 2).mean()))
        return Errors(force / float(np.abs(exact).max()), distance / float(np.abs(pulls).max()))


def scene_cells(path: Path) -> list[tuple[int, int]]:
    """Cells of the meshes of a scene file."""
    return [(nx, ny) for nx, ny in tomllib.loads(path.read_text())["sheet"]["cells"]]


def motion(hand: dict[str, float], dt: float, steps: int) -> Floats:
    """Displacement of the hand at the end of each step [mm]."""
    source = random.Random(int(hand["seed"]))
    places = []
    for step in range(1, steps + 1):
        time = step * dt
        place = min(time / hand["rise"], 1.0)
        if time > hand["rise"]:
            place += hand["tremor"] * math.sin(2 * math.pi * (time - hand["rise"]) / hand["period"])
            place += hand["noise"] * source.uniform(-1, 1)
        places.append(hand["pull"] * place)
    return np.array(places)
