"""Pictures with matplotlib, which is an optional dependency: ``pip install './crates/boxplus-py[plot]'``.

Each function draws into the given axes, or into new ones, and returns them. Poses and points in space are seen from above.
"""

# pyright: reportUnknownMemberType=false
# (The types of matplotlib leave its styles open.)

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from boxplus._gaussian import Gaussian
from boxplus._pose_graph import PoseGraph
from boxplus._planar import SE2
from boxplus._spatial import SE3
from boxplus._vectors import R2, R3

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["banana", "ellipses", "graph", "trajectory"]


def trajectory(poses: SE2 | SE3, axes: Axes | None = None, *, arrows: int = 0, **style: Any) -> Axes:
    """The way of poses `world_from_body`, ``(N,)``, in metres; with `arrows`, as many x-axes along it."""
    axes = _axes(axes)
    x, y = poses.translation[:, 0], poses.translation[:, 1]
    axes.plot(x, y, **style)
    if arrows:
        chosen = np.unique(np.linspace(0, len(poses) - 1, arrows).astype(int))
        ahead = poses.act_direction(np.eye(poses.point_dimension)[0])[chosen]
        axes.quiver(x[chosen], y[chosen], ahead[:, 0], ahead[:, 1], angles="xy", width=0.003)
    return axes


def graph(pose_graph: PoseGraph, axes: Axes | None = None) -> Axes:
    """A pose graph at the poses it holds: odometry as a line, loop closures, edges of ids that do not follow each other, thin.

    Edges whose poses have no values yet are left out.
    """
    axes = _axes(axes)
    ids, poses, edges = pose_graph.ids, pose_graph.poses, pose_graph.edges
    order = np.argsort(ids)
    known = np.isin(edges.from_, ids) & np.isin(edges.to, ids)
    from_, to = edges.from_[known], edges.to[known]
    ends = np.stack([order[np.searchsorted(ids, end, sorter=order)] for end in (from_, to)], -1)
    closes = np.abs(to.astype(np.int64) - from_.astype(np.int64)) != 1
    for chosen, color, width in ((closes, "tab:red", 0.4), (~closes, "tab:blue", 1.0)):
        gap = np.full((int(chosen.sum()), 1), np.nan)
        x, y = (np.hstack([poses.translation[ends[chosen], k], gap]).ravel() for k in (0, 1))
        axes.plot(x, y, color=color, linewidth=width)
    return axes


def ellipses(points: Gaussian[R2] | Gaussian[R3], axes: Axes | None = None, *, probability: float = 0.95, **style: Any) -> Axes:
    """The ellipses that hold uncertain points with a probability: Gaussians on `R2`, or on `R3`, of which x and y are taken."""
    axes = _axes(axes)
    seen = Gaussian(R2(points.mean.vector[..., :2]), points.covariance[..., :2, :2])
    for outline in _outlines(seen, probability):
        axes.plot(outline.vector[:, 0], outline.vector[:, 1], **style)
    return axes


def banana(pose: Gaussian[SE2], axes: Axes | None = None, *, probability: float = 0.95, **style: Any) -> Axes:
    """Where an uncertain pose of the plane may be: the sections of its region by the principal axes, each a closed curve of places."""
    axes = _axes(axes)
    for outline in _outlines(pose, probability):
        axes.plot(outline.translation[:, 0], outline.translation[:, 1], **style)
    return axes


def _outlines(gaussians: Gaussian[Any], probability: float) -> list[Any]:
    """Closed curves on the boundary, one for each pair of whitened axes."""
    dimension, turn = gaussians.mean.dimension, np.linspace(0.0, 2 * np.pi, 121)
    outlines: list[Any] = []
    for i in range(dimension):
        for j in range(i):
            directions = np.zeros((len(turn), dimension))
            directions[:, i], directions[:, j] = np.cos(turn), np.sin(turn)
            alone = [gaussians[k] for k in range(len(gaussians))] if gaussians.shape else [gaussians]
            outlines += [single.boundary(directions, probability) for single in alone]
    return outlines


def _axes(axes: Axes | None) -> Axes:
    if axes is not None:
        return axes
    import matplotlib.pyplot as plt

    _, new = plt.subplots()
    new.set_aspect("equal", "datalim")
    new.set_xlabel("x [m]")
    new.set_ylabel("y [m]")
    return new
