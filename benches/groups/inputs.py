"""Inputs of the operations, the same for every library: a grid that hurts, for accuracy; generic elements, for speed.

A row is a tangent, a point and two elements, in the convention of boxplus (`src/lib.rs`). Numbers are rounded to the
scalar type that reads them, so that what a library gets is exactly what the truth is computed from.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Group:
    """A group by the coordinates of its tangent, in order: ρ, φ, ν (velocity), ι (interval), σ (logarithm of scale).

    All are subgroups of the matrices [s·R v p; 0 1 t; 0 0 1], log s = σ, by these coordinates.
    """

    name: str
    space: int  # dimension of the space it moves: 2 or 3
    coordinates: str

    def size(self, coordinate: str) -> int:
        """Numbers of one coordinate."""
        return {"φ": 2 * self.space - 3, "ι": 1, "σ": 1}.get(coordinate, self.space)

    @property
    def tangent(self) -> tuple[int, ...]:
        """Sizes of the blocks of a tangent."""
        return tuple(self.size(c) for c in self.coordinates)

    @property
    def element(self) -> tuple[int, ...]:
        """Sizes of the blocks of an element: its rotation, (cos, sin) or quaternion xyzw, then the others in order."""
        return (2 * self.space - 2, *(self.size(c) for c in self.coordinates if c != "φ"))

    @property
    def point(self) -> int:
        """Numbers of what it acts on: a place, for the Galilean group a place and a time."""
        return self.space + ("ι" in self.coordinates)


GROUPS = {
    name: Group(name, space, coordinates)
    for name, space, coordinates in (
        ("SO2", 2, "φ"),
        ("SE2", 2, "ρφ"),
        ("SO3", 3, "φ"),
        ("SE3", 3, "ρφ"),
        ("SE23", 3, "ρφν"),
        ("SGal3", 3, "ρφνι"),
        ("Sim2", 2, "ρφσ"),
        ("Sim3", 3, "ρφσ"),
    )
}
SCALARS = {"f64": np.float64, "f32": np.float32}

# 1e-12 … π − 1e-10; between 1e-8 and 0.1, where the thresholds of the libraries are, four a decade.
_SMALL = [1e-12, 1e-11, 1e-10, 1e-9] + [10 ** (-8 + i / 4) for i in range(29)]
THETAS = [*_SMALL, 0.2, 0.5, 0.9, 1.3, 1.7, 2.1, 2.5, 2.9, 3.1]
THETAS += [math.pi - 10**-e for e in (2, 3, 4, 5, 6, 7, 8, 9, 10)]
RADII = (1e-3, 1.0, 1e3)  # of ρ, metres
SPEED_ROWS = 1024


@dataclass(frozen=True)
class Rows:
    """Inputs of one group in one scalar type, n rows each, and the angle each row is about."""

    tau: Array
    point: Array
    a: Array
    b: Array
    theta: Array

    def write(self, path: Path) -> None:
        """What the drivers read."""
        np.hstack([self.tau, self.point, self.a, self.b]).astype("<f8").tofile(path)


def accuracy_rows(group: Group, scalar: str) -> Rows:
    """The grid of angles, by directions (generic, ω ∥ ρ) and sizes of ρ; element a turns by the angle, b by any."""
    rng = np.random.default_rng(17)
    rows = []
    # In f32 a tangent closer to π may round to one beyond it, whose element has another logarithm.
    for theta in (t for t in THETAS if scalar == "f64" or t < math.pi - 9e-7):
        for k, (radius, parallel) in enumerate((r, p) for r in RADII for p in (False, True)):
            sigma = (0.0, 1e-9, -1e-5, 1e-3, -0.3, 1.1)[(k + len(rows)) % 6]
            rows.append((theta, *_row(group, rng, theta, radius, parallel, sigma)))
    return _rounded(rows, scalar)


def speed_rows(group: Group, scalar: str) -> Rows:
    """Generic elements, no two alike: angles up to 2.9, translations about 1."""
    rng = np.random.default_rng(4)
    rows = []
    for _ in range(SPEED_ROWS):
        theta = rng.uniform(0.05, 2.9)
        rows.append((theta, *_row(group, rng, theta, rng.uniform(0.5, 2.0), False, rng.uniform(-0.8, 0.8))))
    return _rounded(rows, scalar)


def _rounded(rows: list[tuple[float, Array, Array, Array, Array]], scalar: str) -> Rows:
    theta, *columns = (np.array(column) for column in zip(*rows, strict=True))
    return Rows(*(c.astype(SCALARS[scalar]).astype(float) for c in columns), theta=theta)


def _row(
    group: Group, rng: np.random.Generator, theta: float, radius: float, parallel: bool, sigma: float
) -> tuple[Array, Array, Array, Array]:
    axis = _direction(rng, group.size("φ"))
    along = axis if group.space == 3 else np.array([1.0, 0.0])

    def vector() -> Array:
        return radius * (along if parallel else _direction(rng, group.space))

    def others(sigma: float, coordinates: str) -> dict[str, Array]:
        values = {"ρ": vector(), "ν": vector(), "ι": rng.normal(size=1), "σ": np.array([sigma])}
        return {c: values[c] for c in coordinates if c != "φ"}

    tangent = others(sigma, group.coordinates) | {"φ": axis * theta}
    tau = np.concatenate([tangent[c] for c in group.coordinates])
    point = rng.normal(size=group.point) * radius
    a, b = _rotation(group, axis, theta), _rotation(group, _direction(rng, len(axis)), rng.uniform(0.3, 2.5))
    a = np.concatenate([a, *others(sigma, group.coordinates).values()])
    b = np.concatenate([b, *others(rng.uniform(-0.5, 0.5), group.coordinates).values()])
    return tau, point, a, b


def _rotation(group: Group, axis: Array, theta: float) -> Array:
    if group.space == 2:
        return np.array([math.cos(theta), axis[0] * math.sin(theta)])
    return np.append(axis * math.sin(theta / 2), math.cos(theta / 2))


def _direction(rng: np.random.Generator, n: int) -> Array:
    v = rng.normal(size=n)
    return v / np.linalg.norm(v)
