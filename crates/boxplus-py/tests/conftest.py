"""What the tests share: the groups, and elements of them where formulas break."""

from __future__ import annotations

import threading
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import pytest

import boxplus as bp

GROUPS: list[type[bp.Group]] = [
    bp.SO2, bp.SO3, bp.SE2, bp.SE3, bp.SE23, bp.SGal3, bp.Sim2, bp.Sim3, bp.R1, bp.R3, bp.R6,
]  # fmt: skip
MATRIX_GROUPS: list[type[bp.MatrixGroup]] = [g for g in GROUPS if issubclass(g, bp.MatrixGroup)]


@pytest.fixture
def rng() -> np.random.Generator:
    """Numbers at random, the same in every run."""
    return np.random.default_rng(7)


def tangents(group: type[bp.Group], rng: np.random.Generator, *shape: int) -> npt.NDArray[np.float64]:
    """Tangents of all sizes, 0, 1e-9 and up to beyond a half turn among them; principal ones where a group turns."""
    sizes = np.array([0.0, 1e-9, 1e-4, 0.1, 1.0, 1.7])[rng.integers(0, 6, (*shape, 1))]
    return np.asarray(rng.uniform(-1.0, 1.0, (*shape, group.dimension)) * sizes, dtype=np.float64)


def elements(group: type[bp.Group], rng: np.random.Generator, *shape: int) -> bp.Group:
    """Exp of such tangents."""
    return group.exp(tangents(group, rng, *shape))


def ticks_during(work: Callable[[], object]) -> int:
    """How far this thread counts while another one works."""
    ticks, done = 0, threading.Event()

    def run() -> None:
        try:
            work()
        finally:
            done.set()

    worker = threading.Thread(target=run)
    worker.start()
    while not done.is_set():
        ticks += 1
    worker.join()
    return ticks
