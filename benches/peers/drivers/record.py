"""What a Python driver measures and prints; the Rust and C++ drivers keep the same protocol.

``driver GRAPH.g2o METHOD POSES [MAX_ITERATIONS]`` writes the poses of every recorded state to POSES (raw little-endian
doubles, states × poses × 3 or 7, rows by vertex id) and prints one JSON object:
``{"status": …, "records": [[iteration, cpu, wall], …], "total": [cpu, wall], "peak": bytes}``: seconds since the
optimiser was called, and how far the resident memory grew above what it was then, recorded states left out.
``PEERS_THREADS`` in the environment is the number of threads to use.
"""

from __future__ import annotations

import json
import re
import sys
import time
from pathlib import Path

import numpy as np

Seconds = tuple[float, float]  # CPU, wall
PROCESS = Path("/proc/self")


def memory(field: str) -> int:
    """Bytes that the process has (VmRSS), or had at most since the mark was reset (VmHWM)."""
    found = re.search(rf"{field}:\s+(\d+) kB", (PROCESS / "status").read_text(encoding="ascii"))
    return int(found[1]) * 1024 if found else 0


class Recorder:
    """A stopwatch that stands still while states are copied."""

    def __init__(self) -> None:
        self._records: list[tuple[int, float, float]] = []
        self._states: list[bytes] = []
        self._elapsed: Seconds = (0.0, 0.0)
        self._started: Seconds | None = None
        self._before: int | None = None  # bytes
        self._peak = 0

    def start(self) -> None:
        """Let the time run."""
        if self._before is None:
            (PROCESS / "clear_refs").write_text("5", encoding="ascii")  # the mark of the high water
            self._before = memory("VmRSS")
        self._started = (time.process_time(), time.perf_counter())

    def stop(self) -> None:
        """Hold the time."""
        now = (time.process_time(), time.perf_counter())
        if self._started is not None:
            cpu, wall = (e + n - s for e, n, s in zip(self._elapsed, now, self._started, strict=True))
            self._elapsed = (cpu, wall)
            self._started = None
            self._peak = max(self._peak, memory("VmHWM") - (self._before or 0) - sum(map(len, self._states)))

    def keep(self, iteration: int, poses: np.ndarray) -> None:
        """Record a state, at the time held."""
        self._records.append((iteration, *self._elapsed))
        self._states.append(np.ascontiguousarray(poses, dtype="<f8").tobytes())

    def report(self, status: str, path: Path) -> None:
        """Write the states, print the records."""
        path.write_bytes(b"".join(self._states))
        report = {"status": status, "records": self._records, "total": self._elapsed, "peak": self._peak}
        json.dump(report, sys.stdout)


def quaternions(rotations: np.ndarray) -> np.ndarray:
    """Unit quaternions x y z w of n × 3 × 3 rotation matrices, from the largest of the four components."""
    r = rotations
    trace = np.trace(r, axis1=1, axis2=2)
    # 4 q qᵀ, whose columns are all multiples of q; the one with the largest diagonal loses no digit.
    outer = np.empty((len(r), 4, 4))
    outer[:, :3, :3] = r + np.swapaxes(r, 1, 2)
    for k in range(3):
        outer[:, k, k] = 1 + 2 * r[:, k, k] - trace
    axial = np.column_stack([r[:, 2, 1] - r[:, 1, 2], r[:, 0, 2] - r[:, 2, 0], r[:, 1, 0] - r[:, 0, 1]])
    outer[:, :3, 3] = outer[:, 3, :3] = axial
    outer[:, 3, 3] = 1 + trace
    largest = np.argmax(np.diagonal(outer, axis1=1, axis2=2), axis=1)
    q = outer[np.arange(len(r)), :, largest]
    return q / np.linalg.norm(q, axis=1, keepdims=True)
