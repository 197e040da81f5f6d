"""The truth against identities it is not computed from, and the judge against errors that are known."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from gmpy2 import mpfr

import report
from accuracy import EPSILON, worst
from harness import difference
from inputs import GROUPS, SCALARS, Group, Rows, accuracy_rows, speed_rows
from truth import OPERATIONS, adjoint, element, hat, log, matrix, series, small_adjoint, truth

ALL = pytest.mark.parametrize("group", GROUPS.values(), ids=GROUPS)


def some(group: Group, step: int = 61) -> Rows:
    """A few rows of the grid."""
    rows = accuracy_rows(group, "f64")
    return Rows(*(getattr(rows, field.name)[::step] for field in dataclasses.fields(rows)))


def tangents(group: Group) -> list[np.ndarray]:
    """Exactly."""
    return [np.array([mpfr(float(x)) for x in row]) for row in some(group).tau]


@ALL
def test_adjoint_of_exp_is_the_exponential_of_ad(group: Group) -> None:
    for tau in tangents(group):
        x = series(hat(group, tau), 0)
        expected = series(small_adjoint(group, tau), 0)
        assert abs(adjoint(group, x) - expected).max() < mpfr(10) ** -55 * (1 + abs(expected).max())


@ALL
def test_log_inverts_exp_and_matrix_inverts_element(group: Group) -> None:
    for tau in tangents(group):
        x = series(hat(group, tau), 0)
        assert abs(log(group, x) - tau).max() < mpfr(10) ** -50 * (1 + abs(tau).max())
        assert abs(matrix(group, element(group, x)) - x).max() < mpfr(10) ** -60 * (1 + abs(x).max())


@ALL
def test_right_jacobian_is_the_derivative_of_exp(group: Group) -> None:
    h = mpfr(10) ** -20  # the remainder is of order h
    for tau in tangents(group)[::3]:
        inverse = series(hat(group, -tau), 0)
        columns = [
            log(group, inverse.dot(series(hat(group, tau + h * e), 0))) / h for e in np.eye(len(tau), dtype=object)
        ]
        expected = series(small_adjoint(group, -tau), 1)
        assert abs(np.array(columns).T - expected).max() < mpfr(10) ** -13 * (1 + abs(expected).max())


@ALL
@pytest.mark.parametrize("scalar", SCALARS)
def test_inputs_are_representable_and_stay_below_pi(group: Group, scalar: str) -> None:
    for rows in (accuracy_rows(group, scalar), speed_rows(group, scalar)):
        for column in (rows.tau, rows.point, rows.a, rows.b):
            assert (column.astype(SCALARS[scalar]).astype(float) == column).all()
        starts = dict(zip(group.coordinates, np.cumsum((0, *group.tangent)), strict=False))
        phi = rows.tau[:, starts["φ"] : starts["φ"] + group.size("φ")]
        assert (np.linalg.norm(phi, axis=1) < np.pi).all()


@ALL
def test_the_truth_has_no_error_and_a_change_of_one_number_is_found(group: Group) -> None:
    rows = some(group)
    exact = truth(group, rows)
    for operation in OPERATIONS:
        assert worst(group, operation, rows, exact[operation], exact[operation], "f64").error == 0
        wrong = exact[operation].copy()
        k = int(abs(wrong[2]).argmax())
        wrong[2, k] *= 1 + 1000 * EPSILON["f64"]
        found = worst(group, operation, rows, wrong, exact[operation], "f64")
        assert 10 < found.error < 4000, (operation, found)
        assert found.theta == rows.theta[2]


@ALL
def test_a_result_that_is_no_number_is_the_worst(group: Group) -> None:
    rows = some(group)
    exact = truth(group, rows)["exp"]
    broken = exact.copy()
    broken[1, -1] = np.nan
    assert worst(group, "exp", rows, broken, exact, "f64").error == np.inf


def test_a_document_keeps_what_stands_around_the_section_that_is_written(tmp_path: Path) -> None:
    cells = {"boxplus": (2.0, 0.0), "manif": (9.0, 0.0), "glam": (1.0, 1.0)}  # nanoseconds, difference to ours
    figures = {k: {"differs": d, "least": [t], "median": [t], "instructions": t} for k, (t, d) in cells.items()}
    machine = {"date": "2026-01-01", "cpu": "?"}
    results = {
        "speed": {"SE3.f64.exp": figures},
        "versions": dict.fromkeys(cells, "1"),
        "missing": {},
        "machine": machine,
    }
    document = tmp_path / "benchmarks.md"
    document.write_text(f"before\n{report.BEGIN}\nstale\n{report.END}\nafter\n", encoding="utf-8")
    for _ in range(2):
        report.write(results, tmp_path)
    text = document.read_text(encoding="utf-8")
    assert text.startswith("before\n") and text.endswith("\nafter\n") and "stale" not in text
    assert "2.0 (4.5× manif)" in text  # a wrong result may be fast
    assert "1.0 (1.0) / 1†" in (tmp_path / "speed-peers.md").read_text(encoding="utf-8")


def test_both_signs_of_a_quaternion_are_one_rotation() -> None:
    rows = some(GROUPS["SE3"])
    exact = truth(GROUPS["SE3"], rows)["compose"]
    flipped = exact.copy()
    flipped[:, :4] *= -1
    assert worst(GROUPS["SE3"], "compose", rows, flipped, exact, "f64").error == 0
    assert difference(exact, flipped) == 0
