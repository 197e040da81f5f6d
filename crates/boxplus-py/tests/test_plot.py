"""Pictures hold what they should show."""

from __future__ import annotations

from collections.abc import Iterator

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import boxplus as bp
from boxplus import plot


@pytest.fixture(autouse=True)
def _no_windows() -> Iterator[None]:  # pyright: ignore[reportUnusedFunction]
    mpl.use("Agg")
    yield
    plt.close("all")


def test_a_trajectory_is_a_line_through_its_positions() -> None:
    poses = bp.SE3.exp(np.random.default_rng(1).normal(size=(30, 6)))
    axes = plot.trajectory(poses, arrows=5, color="k")
    assert_array_equal(axes.lines[0].get_xydata(), poses.translation[:, :2])
    assert plot.trajectory(bp.SE2([[0.0, 0.0], [1.0, 2.0]]), axes) is axes and len(axes.lines) == 2


def test_a_graph_shows_each_edge_once_and_closures_apart() -> None:
    graph = bp.PoseGraph()
    graph.add_poses([7, 8, 9], bp.SE2([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]))
    graph.add_edges([7, 8, 9], [8, 9, 7], bp.SE2.identity(3), sigmas=[1.0] * 3)
    closures, odometry = plot.graph(graph).lines
    assert_array_equal(np.asarray(closures.get_xydata())[:2], [[1.0, 1.0], [0.0, 0.0]])
    assert_array_equal(np.asarray(odometry.get_xydata())[[0, 1, 3, 4]], [[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [1.0, 1.0]])


def test_edges_without_values_of_their_poses_are_not_drawn() -> None:
    graph = bp.PoseGraph()
    graph.add_edges([0, 1], [1, 2], bp.SE2.identity(2), sigmas=[1.0] * 3)
    assert all(np.size(line.get_xdata()) == 0 for line in plot.graph(graph).lines)
    graph.add_poses([0, 2], bp.SE2([[0.0, 0.0], [2.0, 0.0]]))
    assert all(np.size(line.get_xdata()) == 0 for line in plot.graph(graph).lines)
    graph.add_poses(1, bp.SE2.identity(1))
    assert np.size(plot.graph(graph).lines[1].get_xdata()) == 6


def test_ellipses_and_bananas_are_where_the_region_ends() -> None:
    points = bp.Gaussian.from_sigmas(bp.R2([[0.0, 0.0], [5.0, 5.0]]), [1.0, 2.0])
    lines = plot.ellipses(points, probability=0.5).lines
    assert len(lines) == 2
    for line, centre in zip(lines, points.mean.vector, strict=True):
        scaled = (np.asarray(line.get_xydata()) - centre) / [1.0, 2.0]
        assert_allclose(np.sum(scaled**2, -1), 2 * np.log(2), rtol=1e-9)
    heading = bp.Gaussian.from_sigmas(bp.SE2([1.0, 0.0]), [0.01, 0.01, 0.4])
    path = heading @ bp.Gaussian.from_sigmas(bp.SE2([5.0, 0.0]), [0.01, 0.01, 0.01])
    outlines = plot.banana(path).lines
    assert len(outlines) == 3
    bent = np.vstack([np.asarray(line.get_xydata()) for line in outlines])
    assert np.max(np.abs(bent[:, 1])) > 3.5 and np.max(bent[:, 0]) < 6.3
