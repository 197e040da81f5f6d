"""Factor graphs from arrays."""

from __future__ import annotations

import json
import signal
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import boxplus as bp
from conftest import ticks_during
from test_pose_graph import helix

SIGMAS = [0.02, 0.02, 0.02, 0.01, 0.01, 0.01]
Floats = npt.NDArray[np.float64]


def as_graph(pose_graph: bp.PoseGraph, count: int) -> tuple[bp.Graph, bp.Variables[bp.SE3]]:
    """The same measurements, as factors."""
    graph, edges = bp.Graph(), pose_graph.edges
    poses = graph.unknown(bp.SE3, count)
    assert isinstance(edges.measured, bp.SE3)
    graph.between(poses[edges.from_], poses[edges.to], edges.measured, information=edges.information)
    return graph, poses


def world(rng: np.random.Generator) -> tuple[bp.SE2, bp.R2, Floats]:
    """A way in the plane, landmarks beside it, and where each landmark is seen from each pose, ``(12, 5, 2)``."""
    step = bp.SE2([1.0, 0.0], 0.3)
    way = [bp.SE2()]
    for _ in range(11):
        way.append(way[-1] @ step)
    poses, points = bp.SE2.stack(way), bp.R2(rng.uniform(-4.0, 4.0, (5, 2)) + [0.0, 3.0])
    return poses, points, poses[:, None].act_inverse(points.vector)


def test_factors_and_pose_graphs_have_one_optimum() -> None:
    _, pose_graph = helix()
    graph, poses = as_graph(pose_graph, 200)
    solution, other = graph.solve(), pose_graph.solve()
    assert solution.converged and solution.held == ["SE3 0"] and solution.initialisation == other.initialisation
    assert_allclose(solution.cost, other.cost, rtol=1e-12)
    places = np.argsort(other.ids)
    expected = other.poses[places]
    assert isinstance(expected, bp.SE3)
    assert np.all(solution[poses].is_near(expected, 1e-9))
    assert repr(graph) == "Graph(200 variables, 379 factors)"
    assert repr(solution).startswith("converged (") and "held: SE3 0" in repr(solution)
    assert json.loads(json.dumps(solution.to_dict()))["cost"] == solution.cost


@pytest.mark.parametrize("kind", ["sighting", "bearing", "range"])
def test_landmarks_are_found_by_what_is_seen_of_them(kind: str, rng: np.random.Generator) -> None:
    poses, points, seen = world(rng)
    graph = bp.Graph()
    x = graph.variables(poses + 0.02 * rng.normal(size=(12, 3)))
    p = graph.variables(points + 0.1 * rng.normal(size=(5, 2)))
    graph.between(x[:-1], x[1:], poses[:-1].between(poses[1:]), sigmas=[0.01, 0.01, 0.01])
    graph.prior(x[0], poses[0], sigmas=[1e-3] * 3)
    i, j = np.repeat(np.arange(12), 5), np.tile(np.arange(5), 12)
    if kind == "sighting":
        factors = graph.sighting(x[i], p[j], seen.reshape(-1, 2), sigmas=[0.1, 0.1])
    elif kind == "bearing":
        factors = graph.bearing(x[i], p[j], np.arctan2(seen[..., 1], seen[..., 0]).ravel(), sigmas=0.01)
    else:
        factors = graph.range(x[i], p[j], np.linalg.norm(seen, axis=-1).ravel(), sigmas=0.1)
    solution = graph.solve()
    assert solution.converged and solution.cost < 1e-16 and len(factors) == 60
    assert np.all(solution[x].is_near(poses, 1e-7)) and np.all(solution[p].is_near(points, 1e-7))
    assert_allclose(solution.chi2(factors), 0.0, atol=1e-14)


def test_landmarks_in_space_are_found_too(rng: np.random.Generator) -> None:
    poses = bp.SE3.exp(rng.uniform(-1.0, 1.0, (8, 6)))
    points = bp.R3(rng.uniform(-3.0, 3.0, (6, 3)))
    seen = poses[:, None].act_inverse(points.vector).reshape(-1, 3)
    i, j = np.repeat(np.arange(8), 6), np.tile(np.arange(6), 8)
    graph = bp.Graph()
    x, p = graph.variables(poses + 0.01 * rng.normal(size=(8, 6))), graph.unknown(bp.R3, 6)
    graph.fix(x[0])
    graph.release(x[0])
    graph.prior(x, poses, sigmas=SIGMAS)
    graph.sighting(x[i], p[j], seen, covariance=0.01 * np.eye(3))
    graph.bearing(x[i], p[j], seen, sigmas=[0.01, 0.01])
    graph.range(x[i], p[j], np.linalg.norm(seen, axis=-1), sigmas=0.1)
    graph.range(x[:-1], x[1:], np.linalg.norm(poses[:-1].translation - poses[1:].translation, axis=-1), sigmas=0.1)
    solution = graph.solve()
    assert solution.cost < 1e-16 and np.all(solution[p].is_near(points, 1e-7))


def between(a: bp.SE3, b: bp.SE3, measured: bp.SE3) -> Floats:
    return a.between(b) - measured


def between_jac(a: bp.SE3, b: bp.SE3, measured: bp.SE3) -> tuple[Floats, Floats, Floats]:
    displacement, d_a, d_b = a.between_jac(b)
    residual, d_displacement, _ = displacement.minus_jac(measured)
    return residual, d_displacement @ d_a, d_displacement @ d_b


@pytest.mark.parametrize("jacobians", [False, True])
def test_factors_of_ones_own_do_what_those_of_the_library_do(jacobians: bool) -> None:
    _, pose_graph = helix(100)
    library, poses = as_graph(pose_graph, 100)
    edges = pose_graph.edges
    graph = bp.Graph()
    x = graph.variables(library.solve(max_iterations=1)[poses] + [0.01] * 6)
    residual: Any = between_jac if jacobians else between
    factors = graph.factor(
        [x[edges.from_], x[edges.to]], residual, edges.measured, jacobians=jacobians, relative=True, sigmas=SIGMAS
    )
    solution, expected = graph.solve(initial="as_given"), library.solve()
    assert solution.converged and solution.held == ["SE3 0"] and len(solution.iterations) < 10
    assert_allclose(solution.cost, expected.cost, rtol=1e-9)
    assert_allclose(np.sum(solution.chi2(factors)), 2.0 * solution.cost, rtol=1e-9)
    ours, theirs = solution[x], expected[poses]
    assert np.all(ours[0].between(ours).is_near(theirs[0].between(theirs), 1e-5))
    own, same = solution.gaussians(x[[50]]).covariance, expected.gaussians(poses[[50]]).covariance
    assert_allclose(own, same, rtol=0, atol=1e-6 * np.abs(same).max())


def test_what_a_residual_raises_comes_through() -> None:
    graph = bp.Graph()
    x = graph.variables(bp.R2([[1.0, 2.0]]))
    calls: list[bp.R2] = []

    def fail_later(x: bp.R2) -> Floats:
        calls.append(x)
        if len(calls) > 8:
            raise RuntimeError("no more")
        return np.sin(x.vector) + 2.0

    graph.factor([x], fail_later, sigmas=[1.0, 1.0])
    with pytest.raises(RuntimeError, match="no more"):
        graph.solve()
    one, three = np.ones((1, 2)), np.zeros((3, 3))
    wrong: list[tuple[Any, str]] = [
        (one[:, :1], r"the residual: expected an array of shape \(\.\.\., 2\), not \(1, 1\)"),
        ((one,), "expected a residual and 1 Jacobian"),
        ((one, three), r"Jacobian 0: expected an array of shape \(\.\.\., 2, 2\)"),
    ]
    for answer, told in wrong:

        def answered(_: bp.R2, answer: Any = answer) -> Any:
            return answer

        graph = bp.Graph()
        graph.factor([graph.variables(bp.R2([1.0, 2.0]))], answered, jacobians="Jac" in told, sigmas=[1.0, 1.0])
        with pytest.raises(bp.ShapeError, match=told):
            graph.solve()


def test_a_robust_kernel_bounds_the_pull_of_an_outlier() -> None:
    found: dict[str, float] = {}
    for robust in ("none", "huber:1", "cauchy:1"):
        graph = bp.Graph()
        x = graph.variables(bp.R1([0.0]))
        graph.prior(x[[0] * 5], bp.R1([[1.0], [1.1], [0.9], [1.0], [50.0]]), sigmas=0.1, robust=robust)
        found[robust] = float(graph.solve()[x].vector[0, 0])
    assert_allclose(found["none"], 10.8)
    assert abs(found["huber:1"] - 1.025) < 0.01 and abs(found["cauchy:1"] - 1.0) < 0.01


def test_marginals_are_the_inverse_of_the_information() -> None:
    graph = bp.Graph()
    x = graph.variables(bp.R2(np.zeros((3, 2))))
    graph.prior(x[0], bp.R2([0.0, 0.0]), covariance=[[0.04, 0.01], [0.01, 0.09]])
    graph.between(x[:-1], x[1:], bp.R2([1.0, 0.0]), sigmas=[0.1, 0.2])
    solution = graph.solve()
    gaussians = solution.gaussians(x)
    first, step = np.array([[0.04, 0.01], [0.01, 0.09]]), np.diag([0.01, 0.04])
    assert_allclose(gaussians.covariance, [first, first + step, first + 2 * step], atol=1e-15)
    assert_allclose(gaussians.mean.vector, [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]], atol=1e-8)
    joint = solution.joint_covariance(x[2], x[[0]])
    assert_allclose(joint, np.block([[first + 2 * step, first], [first, first]]), atol=1e-15)
    held = bp.Graph()
    a = held.variables(bp.R2(np.zeros((2, 2))))
    held.fix(a[0])
    held.between(a[0], a[1], bp.R2([1.0, 0.0]), sigmas=[0.1, 0.2])
    assert_allclose(held.solve().gaussians(a).covariance, [np.zeros((2, 2)), step], atol=1e-16)


def test_what_nothing_constrains_is_named() -> None:
    graph = bp.Graph()
    x = graph.variables(bp.SE2(np.zeros((2, 2)), [0.1, 0.2]))
    graph.range(x[0], x[1], [1.0], sigmas=0.1)
    graph.prior(x[0], bp.SE2(), sigmas=[1.0] * 3)
    lost = graph.variables(bp.R3([1.0, 2.0, 3.0]))
    solution = graph.solve()
    assert solution.unconstrained is not None and "SE2 1" in solution.unconstrained
    assert solution.unread == ["Rn 0"] and "read by no factor: Rn 0" in repr(solution)
    assert_array_equal(solution[lost].vector, [[1.0, 2.0, 3.0]])
    with pytest.raises(bp.GraphError, match="SE2 1"):
        solution.gaussians(x)


def test_faults_are_told_by_their_place() -> None:
    graph, other = bp.Graph(), bp.Graph()
    x, y = graph.variables(bp.SE2.identity(3)), other.variables(bp.SE2.identity(3))
    with pytest.raises(ValueError, match="belong to another graph"):
        graph.between(x[0], y[1], bp.SE2(), sigmas=[1.0] * 3)
    with pytest.raises(bp.ShapeError, match="2 factors begin, but 3 end"):
        graph.between(x[:2], x, bp.SE2(), sigmas=[1.0] * 3)
    with pytest.raises(bp.ShapeError, match=r"measured: \[2\] rows where 3 are expected"):
        graph.between(x, x, bp.SE2.identity(2), sigmas=[1.0] * 3)
    with pytest.raises(bp.GraphError, match=r"sigmas\[1\]: a standard deviation must be positive"):
        graph.between(x[:2], x[1:], bp.SE2(), sigmas=[[1.0] * 3, [1.0, 0.0, 1.0]])
    with pytest.raises(bp.NotFiniteError, match=r"measured\[2\] is NaN or infinite"):
        graph.range(x, x, [1.0, 2.0, np.nan], sigmas=0.1)
    with pytest.raises(TypeError, match="exactly one of sigmas, covariance and information"):
        graph.prior(x, bp.SE2())
    with pytest.raises(TypeError, match="expected elements of SE2, not SE3"):
        graph.prior(x, bp.SE3(), sigmas=[1.0] * 6)  # type: ignore[misc]
    with pytest.raises(TypeError, match="expected poses SE2 and points R2"):
        graph.bearing(x, x, [0.0] * 3, sigmas=0.1)
    with pytest.raises(ValueError, match="1 to 9 numbers"):
        graph.factor([x], bp.SE2.log, sigmas=[1.0] * 10)
    with pytest.raises(IndexError):
        x[3]
    unknown = graph.unknown(bp.SE2)
    graph.prior(unknown[[0, 0]], bp.SE2(), sigmas=[1.0] * 3)
    with pytest.raises(ValueError, match='no setting is called "iterations"'):
        graph.solve(iterations=5)  # type: ignore[call-arg]  # pyright: ignore


def disturbed() -> bp.Graph:
    truth, pose_graph = helix()
    edges = pose_graph.edges
    assert isinstance(edges.measured, bp.SE3)
    graph = bp.Graph()
    x = graph.variables(truth + 0.1 * np.random.default_rng(5).normal(size=(200, 6)))
    graph.between(x[edges.from_], x[edges.to], edges.measured, sigmas=SIGMAS)
    return graph


def test_progress_and_ctrl_c_stop_the_search_with_the_best_so_far() -> None:
    graph = disturbed()
    told: list[bp.Iteration] = []
    full = graph.solve(initial="as_given", progress=told.append)
    assert full.converged and len(told) == len(full.iterations) > 2
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        pressed = graph.solve(initial="as_given", progress=lambda _: signal.raise_signal(signal.SIGINT))
    finally:
        signal.signal(signal.SIGINT, before)
    for stopped in (pressed, graph.solve(initial="as_given", progress=lambda _: False)):
        assert stopped.termination == "interrupted" and full.cost < stopped.cost < stopped.initial_cost


def test_other_threads_run_while_factors_are_fitted() -> None:
    graph, _ = as_graph(helix(2000)[1], 2000)
    assert ticks_during(graph.solve) > 1000
