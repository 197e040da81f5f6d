"""Pose graphs from arrays and files, to their optimum."""

from __future__ import annotations

import gzip
import json
import os
import signal
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import boxplus as bp
from conftest import ticks_during

DATA = Path(os.environ.get("BOXPLUS_DATA", Path(__file__).parents[4] / "shared" / "data"))
"""Public benchmark files, which are not part of the repository."""


def helix(count: int = 200, seed: int = 3) -> tuple[bp.SE3, bp.PoseGraph]:
    """Poses along a helix of 20 poses a turn, and the graph of noisy steps and of closures between the turns."""
    rng = np.random.default_rng(seed)
    angle = np.arange(count) * 2 * np.pi / 20
    rotation = bp.SO3.from_euler("ZYX", np.stack([angle, 0 * angle, 0 * angle], -1))
    truth = bp.SE3(rotation, np.stack([3 * np.cos(angle), 3 * np.sin(angle), 0.05 * angle], -1))
    i = np.concatenate([np.arange(count - 1), np.arange(count - 20)])
    j = np.concatenate([np.arange(1, count), np.arange(20, count)])
    sigmas = np.array([0.02, 0.02, 0.02, 0.01, 0.01, 0.01])
    measured = truth[i].between(truth[j]) + rng.normal(size=(len(i), 6)) * sigmas
    graph = bp.PoseGraph()
    graph.add_edges(i, j, measured, sigmas=sigmas)
    return truth, graph


def disturbed() -> bp.PoseGraph:
    """The graph of the helix with poses that some steps are needed from."""
    truth, graph = helix()
    graph.add_poses(np.arange(200), truth + 0.1 * np.random.default_rng(5).normal(size=(200, 6)))
    return graph


def test_a_graph_of_arrays_is_solved_to_what_the_noise_allows() -> None:
    truth, graph = helix()
    solution = graph.solve()
    assert solution.converged and solution.held == ["SE3 0"]
    assert_array_equal(np.sort(solution.ids), np.arange(200))
    found = solution.poses[np.argsort(solution.ids)]
    assert isinstance(found, bp.SE3)
    error = found[0].between(found).translation - truth[0].between(truth).translation
    assert np.abs(error).max() < 0.3
    freedom = 6 * len(graph.edges.from_) - 6 * 199
    assert abs(2 * solution.cost - freedom) < 5 * np.sqrt(2 * freedom), "χ² is what its degrees of freedom say"
    assert_allclose(2 * solution.costs["log"], np.sum(solution.chi2), rtol=1e-12)
    assert_allclose(solution.graph.chi2(), solution.chi2, rtol=1e-12)


def test_arrays_come_back_as_they_went_in() -> None:
    rng = np.random.default_rng(0)
    poses = bp.SE2(rng.normal(size=(5, 2)), rng.normal(size=5))
    information = np.eye(3) * rng.uniform(1, 9, (4, 1, 1))
    graph = bp.PoseGraph()
    graph.add_poses([3, 1, 4, 15, 9], poses)
    graph.add_edges([3, 1, 4, 15], [1, 4, 15, 9], poses[1:], information=information)
    graph.fix(3)
    assert graph.ids.tolist() == [3, 1, 4, 15, 9] and graph.fixed.tolist() == [3]
    assert np.all(graph.poses == poses)
    from_, to, measured, again = graph.edges
    assert from_.tolist() == [3, 1, 4, 15] and to.tolist() == [1, 4, 15, 9]
    assert np.all(measured == poses[1:])
    assert_array_equal(again, information)
    for elements in (graph.poses, measured):
        with pytest.raises(ValueError, match="read-only"):
            np.asarray(elements)[...] = 0.0
    assert repr(graph) == "PoseGraph(5 poses in the plane, 4 measurements, 1 fixed)"
    other = graph.copy()
    other.add_poses(100, bp.SE2.identity(1))
    assert len(graph.ids) == 5 and len(other.ids) == 6


def test_files_are_read_and_written(tmp_path: Path) -> None:
    _, graph = helix(40)
    solved = graph.solve().graph
    path = tmp_path / "helix.g2o"
    solved.write(path)
    again = bp.PoseGraph.read(path)
    assert np.all(again.poses == solved.poses) and again.to_text() == solved.to_text() == path.read_text()
    packed = tmp_path / "helix.g2o.gz"
    packed.write_bytes(gzip.compress(path.read_bytes()))
    assert bp.PoseGraph.read(packed).to_text() == again.to_text()
    assert bp.PoseGraph.parse(solved.to_text("toro")).ids.tolist() == solved.ids.tolist()


def test_a_malformed_file_is_told_by_line_and_column() -> None:
    with pytest.raises(bp.ReadError, match=r"typo\.g2o:2:16: `O` is not a number"):
        bp.PoseGraph.parse("VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 0 O 0", name="typo.g2o")
    with pytest.raises(ValueError, match="g2o, toro, isam or pyfg"):
        bp.PoseGraph.parse("", "csv")  # type: ignore[arg-type]  # pyright: ignore


def test_progress_is_told_and_may_stop_the_search() -> None:
    graph = disturbed()
    told: list[bp.Iteration] = []
    full = graph.solve(initial="as_given", progress=told.append)
    assert full.converged and len(told) == len(full.iterations) > 2
    assert told[-1]["cost"] == full.cost and told[0]["accepted"]
    stopped = graph.solve(initial="as_given", progress=lambda _: False)
    assert stopped.termination == "interrupted" and len(stopped.iterations) == 1
    assert full.cost < stopped.cost < stopped.initial_cost


def test_an_exception_in_progress_comes_through() -> None:
    _, graph = helix(40)

    def fail(_: bp.Iteration) -> None:
        raise RuntimeError("no more")

    with pytest.raises(RuntimeError, match="no more"):
        graph.solve(progress=fail)


def test_ctrl_c_stops_with_the_best_so_far() -> None:
    graph = disturbed()

    def press(_: bp.Iteration) -> None:
        signal.raise_signal(signal.SIGINT)

    # A process started in the background ignores the signal, and so would the interpreter.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        solution = graph.solve(initial="as_given", progress=press)
    finally:
        signal.signal(signal.SIGINT, before)
    assert solution.termination == "interrupted" and solution.cost < solution.initial_cost


def test_other_threads_run_while_a_graph_is_solved() -> None:
    _, graph = helix(2000)
    assert ticks_during(graph.solve) > 1000


def test_settings_are_checked_by_name() -> None:
    _, graph = helix(40)
    assert graph.solve(threads=1).cost == graph.solve(threads=2).cost
    for algorithm in ("levenberg_marquardt", "gauss_newton", "dogleg"):
        assert_allclose(graph.solve(algorithm=algorithm).cost, graph.solve().cost, rtol=1e-9)
    with pytest.raises(ValueError, match='initial is one of auto, as_given, spanning_tree, chordal, grown, not "best"'):
        graph.solve(initial="best")  # type: ignore[arg-type]  # pyright: ignore
    with pytest.raises(ValueError, match='no setting is called "iterations"'):
        graph.solve(iterations=5)  # type: ignore[call-arg]  # pyright: ignore
    assert graph.solve(max_iterations=1).termination == "max_iterations"
    assert graph.solve().graph.solve(fixed=[7]).held == []


def test_false_closures_are_found() -> None:
    _, graph = helix()
    graph.add_edges([10, 50], [120, 190], bp.SE3.exp([[5.0, 0, 0, 0, 0, 1.0], [0, 9.0, 0, 0, 0, 2.0]]), sigmas=[0.02] * 6)
    solution = graph.solve(robust="gnc-tls")
    measurements = len(graph.edges.from_)
    assert {measurements - 2, measurements - 1} <= set(solution.rejected.tolist())
    assert solution.costs["log"] > 10 * helix()[1].solve().cost
    assert graph.solve(robust="cauchy:1").cost < graph.solve().cost


def test_positions_have_covariances() -> None:
    _, graph = helix(60)
    solution = graph.solve()
    ids, covariances = solution.position_covariances([0, 1, 59])
    assert ids.tolist() == [0, 1, 59] and covariances.shape == (3, 3, 3)
    assert np.all(covariances[0] == 0.0), "the first pose is held"
    assert np.all(np.linalg.eigvalsh(covariances[1:]) > 0)
    assert np.trace(covariances[2]) > np.trace(covariances[1])


def test_faults_are_told_in_words() -> None:
    graph = bp.PoseGraph()
    graph.add_edges([0, 1], [1, 2], bp.SE3.identity(2), information=np.stack([np.eye(6), -np.eye(6)]))
    with pytest.raises(bp.GraphError, match="1 fault"):
        graph.solve()
    graph.add_poses([0, 1, 2], bp.SE3.identity(3))
    assert graph.solve(indefinite="skip").unknowns == 6
    with pytest.raises(bp.GraphError, match="no vertex and no measurement"):
        bp.PoseGraph().solve()
    with pytest.raises(ValueError, match="ids are whole numbers"):
        graph.fix([-1])
    with pytest.raises(ValueError, match="ids are whole numbers"):
        graph.fix([0.5])
    with pytest.raises(bp.ShapeError, match="measured"):
        graph.add_edges([0, 1, 2], [1, 2, 3], bp.SE3.identity(2), sigmas=[1.0] * 6)
    with pytest.raises(TypeError, match="either information or sigmas"):
        graph.add_edges([0], [1], bp.SE3.identity(1))
    with pytest.raises(bp.NotFiniteError, match=r"information\[0\]"):
        graph.add_edges([0], [1], bp.SE3.identity(1), information=np.full((6, 6), np.nan))


def test_a_solution_prints_and_becomes_json() -> None:
    _, graph = helix(40)
    solution = graph.solve()
    text = repr(solution)
    assert text.startswith("converged (") and "cost " in text and "held: SE3 0" in text
    assert json.loads(json.dumps(solution.to_dict()))["cost"] == solution.cost


@pytest.mark.skipif(not DATA.is_dir(), reason=f"the public benchmark files are not in {DATA}")
@pytest.mark.parametrize(
    ("name", "optimum"), [("M3500", 68.95743912), ("parking-garage", 0.6341924), ("sphere2500", 675.7009629)]
)
def test_public_files_reach_their_known_optimum(name: str, optimum: float) -> None:
    found = sorted(DATA.rglob(f"{name}.g2o*"))
    if not found:
        pytest.skip(f"{name} is not in {DATA}")
    assert_allclose(bp.PoseGraph.read(found[0]).solve().cost, optimum, rtol=1e-6)
