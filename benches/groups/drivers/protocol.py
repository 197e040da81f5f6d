"""What the Python drivers share; the protocol and the convention are those of `src/lib.rs`."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
LAYOUTS = {
    "SO2": (1, 2, 2),
    "SE2": (3, 2, 4),
    "SO3": (3, 3, 4),
    "SE3": (6, 3, 7),
    "SE23": (9, 3, 10),
    "SGal3": (10, 4, 11),
    "Sim2": (4, 2, 5),
    "Sim3": (7, 3, 8),
}


class Bench:
    """The inputs of one group in one scalar type, and what becomes of each of its operations."""

    def __init__(self, group: str, scalar: str) -> None:
        self.mode, inputs = sys.argv[1], Path(sys.argv[2])
        self.name = f"{group}.{scalar}"
        d, n, e = LAYOUTS[group]
        path = inputs / self.name
        rows = np.fromfile(path).reshape(-1, d + n + 2 * e) if path.exists() else np.empty((0, d + n + 2 * e))
        self.tau, self.point, self.a, self.b = np.split(rows, np.cumsum([d, n, e]), axis=1)

    def rows(self, operation: str, results: Callable[[], Iterable[Array]]) -> None:
        """One operation, by its results for all rows, in the common convention."""
        if self.mode == "eval" and len(self.a):
            flat = np.array([np.ravel(r) for r in results()], dtype="<f8")
            flat.tofile(Path(sys.argv[3]) / f"{self.name}.{operation}")

    def time(self, operation: str, call: Callable[[], object], count: int) -> None:
        """Nanoseconds per result of a call that yields ``count``: least and median."""
        if self.mode != "time":
            return
        call()
        sweeps = []
        begin = time.perf_counter()
        while len(sweeps) < 5 or time.perf_counter() - begin < 0.1:
            start = time.perf_counter()
            call()
            sweeps.append((time.perf_counter() - start) / count * 1e9)
        print(f"{self.name}.{operation} {min(sweeps):.3f} {sorted(sweeps)[len(sweeps) // 2]:.3f}")


def order_vector(order: list[int], theirs: Array) -> Array:
    """A vector of theirs in our order: ours k is theirs order[k]."""
    return theirs[..., order]


def order_matrix(order: list[int], theirs: Array) -> Array:
    """The same of a square matrix."""
    return theirs[..., order, :][..., :, order]
