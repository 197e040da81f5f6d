"""The judge is judged: formulas against a matrix exponential, optima against solvers that minimise each cost."""

from __future__ import annotations

import gzip
from pathlib import Path

import numpy as np
import pytest

import harness
import peers
import score
from peers import Unavailable

RNG = np.random.default_rng(7)


def exp(twist: np.ndarray) -> np.ndarray:
    """The homogeneous matrix of exp(ρ, θ): Taylor's series of the matrix, scaled and squared."""
    dim = 2 if len(twist) == 3 else 3
    hat = np.zeros((dim + 1, dim + 1))
    hat[:dim, dim] = twist[:dim]
    if dim == 2:
        hat[1, 0], hat[0, 1] = twist[2], -twist[2]
    else:
        x, y, z = twist[3:]
        hat[:3, :3] = [[0, -z, y], [z, 0, -x], [-y, x, 0]]
    term = result = np.eye(dim + 1)
    for k in range(1, 20):
        term = term @ hat / (2**10 * k)
        result = result + term
    return np.linalg.matrix_power(result, 2**10)


def pose(matrix: np.ndarray) -> np.ndarray:
    """(x, y, θ) or (x, y, z, qx, qy, qz, qw) of a homogeneous matrix."""
    if len(matrix) == 3:
        return np.array([*matrix[:2, 2], np.arctan2(matrix[1, 0], matrix[0, 0])])
    # The quaternion is the eigenvector of the largest eigenvalue of Bar-Itzhack's matrix.
    r = matrix[:3, :3]
    bar_itzhack = np.zeros((4, 4))
    bar_itzhack[:3, :3] = r + r.T - np.trace(r) * np.eye(3)
    bar_itzhack[3, :3] = bar_itzhack[:3, 3] = r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]
    bar_itzhack[3, 3] = np.trace(r)
    values, vectors = np.linalg.eigh(bar_itzhack)
    return np.array([*matrix[:3, 3], *vectors[:, np.argmax(values)]])


def information(size: int) -> np.ndarray:
    """A random positive definite matrix."""
    root = RNG.normal(size=(size, size))
    return root @ root.T + np.eye(size)


def one_edge(error: np.ndarray, omega: np.ndarray) -> score.PoseGraph:
    """Two poses and a measurement Z with Log(Z⁻¹Xᵢ⁻¹Xⱼ) = error."""
    size = len(error)
    tail, measured = exp(RNG.normal(size=size)), exp(RNG.normal(size=size))
    head = tail @ measured @ exp(error)
    return score.PoseGraph(
        dim=2 if size == 3 else 3,
        poses=np.array([pose(tail), pose(head)]),
        tails=np.array([0]),
        heads=np.array([1]),
        measurements=pose(measured)[None],
        information=omega[None],
    )


@pytest.mark.parametrize("size", [3, 6])
@pytest.mark.parametrize("angle", [0.0, 1e-7, 9e-4, 1.1e-3, 0.0999, 0.1001, 1.0, 3.0, np.pi - 1e-6])
def test_log_inverts_the_matrix_exponential(size: int, angle: float) -> None:
    error = RNG.normal(size=size)
    error[2 if size == 3 else slice(3, 6)] *= angle / np.linalg.norm(error[2 if size == 3 else slice(3, 6)])
    omega = information(size)
    expected = error @ omega @ error / 2
    # Poses of size 1 to 10 through matrices, quaternions and back carry errors of some 1e-15 each.
    assert score.costs(one_edge(error, omega))["log"] == pytest.approx(expected, rel=1e-11, abs=1e-13)


def test_a_pure_rotation_costs_what_the_formulas_say() -> None:
    angle, omega = 0.3, np.diag([1.0, 2.0, 3.0])
    assert score.costs(one_edge(np.array([0, 0, angle]), omega)) == pytest.approx(
        {
            "log": 1.5 * angle**2,
            "g2o": 3 * angle**2,
            "ceres": 1.5 * angle**2,
            "se_sync": 3 * 8 * np.sin(angle / 2) ** 2,
        }
    )
    omega = np.diag([1.0, 2.0, 3.0, 4.0, 4.0, 4.0])
    assert score.costs(one_edge(np.array([0, 0, 0, 0, 0, angle]), omega)) == pytest.approx(
        {
            "log": 2 * angle**2,
            "g2o": 4 * np.sin(angle / 2) ** 2,
            "ceres": 8 * np.sin(angle / 2) ** 2,
            "se_sync": 1.5 / (3 / 4) * 8 * np.sin(angle / 2) ** 2,
        }
    )


@pytest.mark.parametrize("size", [3, 6])
def test_a_pure_translation_costs_what_the_formulas_say(size: int) -> None:
    dim = 2 if size == 3 else 3
    error, omega = np.zeros(size), 2 * np.eye(size)
    error[:dim] = RNG.normal(size=dim)
    square = float(error @ error)
    assert score.costs(one_edge(error, omega)) == pytest.approx(
        {"log": square, "g2o": 2 * square, "ceres": square, "se_sync": 2 * square}
    )


@pytest.mark.parametrize("size", [3, 6])
def test_costs_do_not_depend_on_the_frame_or_the_sign_of_quaternions(size: int) -> None:
    graph = one_edge(RNG.normal(size=size) / 3, information(size))
    moved = graph.poses.copy()
    if size == 3:
        frame = np.array([[1.0, 2.0, 0.7]])
        moved = score._compose_2d(np.repeat(frame, 2, axis=0), moved)
    else:
        frame = np.array([[1.0, 2.0, 3.0, 0.1, 0.5, -0.1, 0.8]])
        moved = score._compose_3d(np.repeat(frame, 2, axis=0), moved)
        moved[1, 3:] *= -1
    assert score.costs(graph, moved) == pytest.approx(score.costs(graph), rel=1e-12)


@pytest.fixture(scope="module")
def data() -> Path:
    try:
        return harness.data_folder()
    except SystemExit as missing:
        pytest.skip(f"without the data: {missing}")


@pytest.mark.parametrize(
    ("name", "chi2"),
    [("M3500", 2.56667e6), ("sphere2500", 2.54781e6), ("parking-garage", 16720.0), ("torus3D", 2.94683e6)],
)
def test_the_start_of_each_file_costs_what_others_print(data: Path, name: str, chi2: float) -> None:
    graph = score.read_g2o(harness.dataset(data, name))
    assert score.costs(graph)["g2o"] == pytest.approx(chi2, rel=3e-6)


def test_se_sync_is_twice_ceres_where_information_is_isotropic(data: Path) -> None:
    costs = score.costs(score.read_g2o(harness.dataset(data, "torus3D")))
    assert costs["se_sync"] == pytest.approx(2 * costs["ceres"], rel=1e-12)


def test_a_graph_written_and_read_again_is_the_same(tmp_path: Path) -> None:
    graph = one_edge(RNG.normal(size=6), information(6))
    score.write_g2o(graph, tmp_path / "graph.g2o")
    (tmp_path / "graph.g2o.gz").write_bytes(gzip.compress((tmp_path / "graph.g2o").read_bytes()))
    for path in (tmp_path / "graph.g2o", tmp_path / "graph.g2o.gz"):
        again = score.read_g2o(path)
        assert (again.poses == graph.poses).all() and (again.measurements == graph.measurements).all()
        assert score.costs(again)["log"] == pytest.approx(score.costs(graph)["log"], rel=1e-12)


def test_without_vertices_the_odometry_is_chained(tmp_path: Path) -> None:
    path = tmp_path / "graph.g2o"
    path.write_text("EDGE_SE2 0 1 1 0 1.5707963267948966 1 0 0 1 0 1\nEDGE_SE2 1 2 1 0 0 1 0 0 1 0 1\n")
    assert score.read_g2o(path).poses == pytest.approx(np.array([[0, 0, 0], [1, 0, np.pi / 2], [1, 1, np.pi / 2]]))


@pytest.mark.parametrize(
    ("name", "key"),
    [
        ("M3500", "gtsam-lm"),
        ("sphere2500", "gtsam-chordal"),
        ("parking-garage", "gtsam-chordal"),
        ("torus3D", "gtsam-chordal"),
        ("sphere_bignoise_vertex3", "gtsam-chordal"),
        ("smallGrid3D", "gtsam-chordal"),
        ("M3500", "g2o-lm"),
        ("sphere2500", "tiny-lm"),
        ("M3500", "ceres-dogleg"),
        ("sphere2500", "ceres-lm"),
        ("sphere2500", "apex-lm"),
    ],
)
def test_solvers_reach_the_known_optimum_of_what_they_minimise(data: Path, tmp_path: Path, name: str, key: str) -> None:
    method = next(method for method in peers.METHODS if method.key == key)
    try:
        solver = peers.prepare(method.solver)
    except Unavailable as reason:
        pytest.skip(str(reason))
    bench = harness.Bench(name, harness.dataset(data, name), tmp_path, timeout=120)
    run = bench.run(solver, method)
    assert run.records, run.status
    # Solvers stop at relative decreases of 1e-5 or 1e-6, and steps converge quadratically; optima have ten digits.
    assert -1e-9 < bench.above(run.records[-1], method.objective) < 3e-6
