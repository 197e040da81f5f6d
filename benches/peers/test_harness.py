"""The harness, run against a boxplus of straw."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import harness
import score
from harness import Bench, Measurement
from peers import Method, Solver

METHOD = Method("boxplus", "boxplus", "boxplus", "log", "auto", traces=False)

# Halves the distance of the last vertex from the origin in each iteration, ten times unless told otherwise.
STRAW = """
import json, pathlib, struct, sys
iterations = int(sys.argv[4]) if len(sys.argv) > 4 else 10
poses = [0.0, 0.0, 0.0, 2.0 ** -iterations, 0.0, 0.0, 0.0, 0.0, 0.0]
pathlib.Path(sys.argv[3]).write_bytes(struct.pack("<9d", *poses))
seconds = 1e-9 * (1 + iterations)
records = [[iterations, seconds, 2 * seconds]]
print(json.dumps({"status": "cost", "records": records, "total": [2.0, 3.0], "peak": 4_000_000}))
"""


@pytest.fixture
def bench(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Bench:
    # One edge that wants the second pose at the first and a third edge that keeps the optimum, 1/2, from zero.
    source = tmp_path / "source.g2o"
    edges = ["EDGE_SE2 0 1 0 0 0 1 0 0 1 0 1", "EDGE_SE2 0 2 1 0 0 1 0 0 1 0 1"]
    vertices = [f"VERTEX_SE2 {k} {k % 2} 0 0" for k in range(3)]
    source.write_text("\n".join(vertices + edges))
    monkeypatch.setitem(score.OPTIMA, "straw", {"log": 0.5})
    return Bench("straw", source, tmp_path, timeout=20)


def solver(tmp_path: Path, program: str) -> Solver:
    (tmp_path / "program.py").write_text(program)
    return Solver("straw", (sys.executable, str(tmp_path / "program.py")))


def test_boxplus_is_stepped_to_the_first_iteration_within_the_goal(bench: Bench, tmp_path: Path) -> None:
    measurement = Measurement()
    for _ in range(2):
        harness.measure(bench, solver(tmp_path, STRAW), METHOD, measurement)
    # ½(1 + 4⁻ᵏ) ≤ ½(1 + 1e-3) first for k = 5.
    assert measurement.iteration == 5
    assert measurement.wall_to_goal == pytest.approx([12e-9] * 2)
    assert measurement.cpu_to_goal == pytest.approx([6e-9] * 2)
    assert measurement.wall_total == [3.0, 3.0]
    assert measurement.above == pytest.approx(4.0**-10)
    assert measurement.status == "cost"
    assert measurement.peak == [4e6, 4e6]
    table = harness.tables({"straw": {"boxplus": measurement}}, {"boxplus": METHOD}, {}, threads=2)
    assert "Wall-clock seconds" in table and "| boxplus | 4.0 |" in table


@pytest.mark.parametrize(
    ("program", "status"),
    [
        ("import sys; sys.exit('no such flag')", "exit code 1: no such flag"),
        ("import os; os.abort()", "exit code -6: no message"),
        ("print('{}'); open(__import__('sys').argv[3], 'w').close()", "unreadable output"),
        ("while True: pass", "timeout after 1 s"),
    ],
)
def test_a_failing_solver_is_reported_and_not_repeated(bench: Bench, tmp_path: Path, program: str, status: str) -> None:
    bench._timeout = 1.0
    measurement = Measurement()
    for _ in range(2):
        harness.measure(bench, solver(tmp_path, program), METHOD, measurement)
    assert measurement.status.startswith(status)
    assert len(measurement.cpu_total) == 1 and not measurement.cpu_to_goal
    table = harness.tables({"straw": {"boxplus": measurement}}, {"boxplus": METHOD}, {"peer": "no wheel"})
    assert "| did not reach |" in table and "- peer is not installed: no wheel" in table


@pytest.mark.parametrize("first", [0, 1])
@pytest.mark.parametrize("answer", [1, 2, 3, 7, 8, 30])
def test_the_smallest_number_of_iterations_is_found(first: int, answer: int) -> None:
    assert harness.smallest(lambda k: k >= answer, first, limit=30) == answer


def test_none_is_found_where_none_reaches() -> None:
    assert harness.smallest(lambda k: False, 1, limit=30) is None
    assert harness.smallest(lambda k: True, 0, limit=30) == 0


def test_medians_and_absences_are_printed() -> None:
    assert harness._timing([0.3, 0.1, 0.2]) == "0.2000 (0.1000)"
    assert harness._timing([np.nan]) == "–"
