"""Pose graphs and their cost in four conventions, written from the formulas: the judge of every solver's output.

With the error E = Z⁻¹ Xᵢ⁻¹ Xⱼ of an edge (i, j, Z, Ω), Ω ordered translation before rotation:

- ``log``:     G = ½ Σ eᵀΩe, e = Log(E), the full logarithm of SE(2) or SE(3) (GTSAM, factrs, apex-solver, boxplus);
- ``g2o``:     X = Σ eᵀΩe, e = (t, θ) of E in 2-D, (t, vec q) with q_w ≥ 0 in 3-D;
- ``ceres``:   E = ½ Σ eᵀΩe, e = (Rᵢᵀ(tⱼ − tᵢ) − t_Z, θ) in 2-D, (…, 2 vec(q_Z q̄ᵢⱼ)) in 3-D;
- ``se_sync``: F = Σ κ‖Rⱼ − RᵢR_Z‖²_F + τ‖tⱼ − tᵢ − Rᵢt_Z‖², 3-D: κ = 3/(2 tr Ω_R⁻¹), τ = 3/tr Ω_t⁻¹;
  2-D: κ = Ω_θθ, τ = 2/tr Ω_t⁻¹.

Poses are rows, ordered by vertex id: (x, y, θ) in 2-D, (x, y, z, qx, qy, qz, qw) in 3-D.
"""

from __future__ import annotations

import gzip
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# The least known values: F certified globally optimal (SE-Sync's dual certificate), G, X and E the minima
# reached from there; see the table of known optima in the documentation of the solver.
OPTIMA: dict[str, dict[str, float]] = {
    name: dict(zip(("se_sync", "log", "g2o", "ceres"), values, strict=True))
    for name, values in {
        "M3500": (193.8622584, 68.95743912, 137.9129509, 68.95647547),
        "manhattan": (6431.391387, 1774.520535, 3549.036796, 1766.729263),
        "intel": (52.34822729, 22.50211654, 45.00469581, 22.20890399),
        "MIT": (61.15411552, 20.60347352, 41.16326884, 19.80064724),
        "kitti_00": (125.693515, 49.16106912, 98.32201174, 49.13134093),
        "sphere2500": (1687.005814, 675.7009629, 727.1496672, 677.0084937),
        "parking-garage": (1.262524428, 0.6341924, 1.23869058, 0.6341932),
        "torus3D": (24227.04556, 12117.63688, 14574.74644, 12113.52278),
        "sphere_bignoise_vertex3": (2961756.49, 1494168.755, 743862.7209, 1476863.346),
        "smallGrid3D": (1025.398056, 517.9253324, 458.1537843, 512.6990278),
        "tinyGrid3D": (18.51936642, 9.313909434, 6.727881617, 9.259683211),
    }.items()
}

_TAGS = {"VERTEX_SE2": 2, "EDGE_SE2": 2, "VERTEX_SE3:QUAT": 3, "EDGE_SE3:QUAT": 3}


@dataclass(frozen=True)
class PoseGraph:
    """A pose graph of one dimension; edges refer to rows of ``poses``."""

    dim: int
    poses: Array  # n × 3 or n × 7
    tails: NDArray[np.intp]  # i of each edge
    heads: NDArray[np.intp]  # j of each edge
    measurements: Array  # m × 3 or m × 7
    information: Array  # m × 3 × 3 or m × 6 × 6


def read_g2o(path: Path) -> PoseGraph:
    """Read SE(2) or SE(3) vertices and edges; without vertices, the odometry is chained from the identity."""
    vertices: dict[int, list[float]] = {}
    edges: list[tuple[int, int, list[float]]] = []
    dims: set[int] = set()
    opener = gzip.open if path.suffix == ".gz" else open
    with opener(path, "rt") as lines:
        for line in lines:
            tag, *fields = line.split() or [""]
            if tag not in _TAGS:
                continue
            dims.add(_TAGS[tag])
            if tag.startswith("VERTEX"):
                vertices[int(fields[0])] = [float(f) for f in fields[1:]]
            else:
                edges.append((int(fields[0]), int(fields[1]), [float(f) for f in fields[2:]]))
    if len(dims) != 1 or not edges:
        raise ValueError(f"{path}: expected the vertices and edges of one dimension, found {sorted(dims)}")
    dim = dims.pop()
    width = 3 if dim == 2 else 7
    if not vertices:
        vertices = _chain(dim, edges)
    ids = sorted(vertices)
    row = {vertex: k for k, vertex in enumerate(ids)}
    values = np.array([fields for _, _, fields in edges])
    return PoseGraph(
        dim=dim,
        poses=np.array([vertices[v][:width] for v in ids]),
        tails=np.array([row[i] for i, _, _ in edges]),
        heads=np.array([row[j] for _, j, _ in edges]),
        measurements=values[:, :width],
        information=_symmetric(values[:, width:], 3 if dim == 2 else 6),
    )


def write_g2o(graph: PoseGraph, path: Path) -> None:
    """Write vertices 0 … n−1, then edges, with every digit, so that all solvers read the same numbers."""
    vertex, edge = ("VERTEX_SE2", "EDGE_SE2") if graph.dim == 2 else ("VERTEX_SE3:QUAT", "EDGE_SE3:QUAT")
    upper = np.triu_indices(graph.information.shape[1])
    with path.open("w") as out:
        for row, pose in enumerate(graph.poses):
            print(vertex, row, *map(repr, pose.tolist()), file=out)
        for i, j, z, omega in zip(graph.tails, graph.heads, graph.measurements, graph.information, strict=True):
            numbers = map(repr, [*z.tolist(), *omega[upper].tolist()])
            print(edge, i, j, *numbers, file=out)


def costs(graph: PoseGraph, poses: Array | None = None) -> dict[str, float]:
    """The cost of ``poses`` (default: those of the file) in the four conventions."""
    at = graph.poses if poses is None else np.asarray(poses, dtype=float).reshape(graph.poses.shape)
    tails, heads, z = at[graph.tails], at[graph.heads], graph.measurements
    residuals = _residuals_2d if graph.dim == 2 else _residuals_3d
    log, g2o, ceres = residuals(tails, heads, z)

    def chi2(e: Array) -> float:
        return float(np.einsum("mi,mij,mj->", e, graph.information, e))

    return {
        "log": chi2(log) / 2,
        "g2o": chi2(g2o),
        "ceres": chi2(ceres) / 2,
        "se_sync": _se_sync(graph, tails, heads),
    }


def _residuals_2d(tails: Array, heads: Array, z: Array) -> tuple[Array, Array, Array]:
    """The residuals of the ``log``, ``g2o`` and ``ceres`` conventions on SE(2), each m × 3."""
    between = _rotate_2d(-tails[:, 2], heads[:, :2] - tails[:, :2])
    error = _rotate_2d(-z[:, 2], between - z[:, :2])
    theta = heads[:, 2] - tails[:, 2] - z[:, 2]
    theta = np.arctan2(np.sin(theta), np.cos(theta))
    # V⁻¹ = a I − (θ/2) ^, a = (θ/2) cot(θ/2): below θ = 1e-3, 1 − θ²/12 is exact to θ⁴/720 < 2e-15.
    half = theta / 2
    small = np.abs(theta) < 1e-3
    a = np.where(small, 1 - theta**2 / 12, half / np.tan(np.where(small, 1, half)))
    x, y = error.T
    log = np.column_stack([a * x + half * y, a * y - half * x, theta])
    g2o = np.column_stack([error, theta])
    ceres = np.column_stack([between - z[:, :2], theta])
    return log, g2o, ceres


def _residuals_3d(tails: Array, heads: Array, z: Array) -> tuple[Array, Array, Array]:
    """The residuals of the ``log``, ``g2o`` and ``ceres`` conventions on SE(3), each m × 6."""
    q_i, q_j, q_z = (_unit(pose[:, 3:]) for pose in (tails, heads, z))
    q_ij = _multiply(_conjugate(q_i), q_j)
    between = _rotate_3d(_conjugate(q_i), heads[:, :3] - tails[:, :3])
    error = _rotate_3d(_conjugate(q_z), between - z[:, :3])
    q = _multiply(_conjugate(q_z), q_ij)
    q *= np.where(q[:, 3:] < 0, -1.0, 1.0)
    sine = np.linalg.norm(q[:, :3], axis=1)
    theta: Array = 2.0 * np.arctan2(sine, q[:, 3])
    # θ/sin(θ/2) → 2: below sin = 1e-9 the difference is under 1e-18.
    omega = q[:, :3] * np.where(sine < 1e-9, 2.0, theta / np.where(sine < 1e-9, 1.0, sine))[:, None]
    rho = error - np.cross(omega, error) / 2
    rho += _log_coefficient(theta)[:, None] * np.cross(omega, np.cross(omega, error))
    delta = _multiply(q_z, _conjugate(q_ij))
    delta *= np.where(delta[:, 3:] < 0, -1.0, 1.0)
    log = np.hstack([rho, omega])
    g2o = np.hstack([error, q[:, :3]])
    ceres = np.hstack([between - z[:, :3], 2 * delta[:, :3]])
    return log, g2o, ceres


def _log_coefficient(theta: Array) -> Array:
    """(1 − (θ/2) cot(θ/2))/θ² of V⁻¹ = I − ½ω^ + c ω^²."""
    t2 = theta**2
    small = theta < 0.1  # next term of the series: θ⁸/47900160 < 3e-16
    series = 1 / 12 + t2 / 720 + t2**2 / 30240 + t2**3 / 1209600
    safe = np.where(small, 1.0, theta)
    return np.where(small, series, (1 - safe / 2 / np.tan(safe / 2)) / safe**2)


def _se_sync(graph: PoseGraph, tails: Array, heads: Array) -> float:
    """SE-Sync's objective F."""
    d, z = graph.dim, graph.measurements
    tau = d / np.trace(np.linalg.inv(graph.information[:, :d, :d]), axis1=1, axis2=2)
    if d == 2:
        kappa = graph.information[:, 2, 2]
        # ‖R(a) − R(b)‖²_F = 4 (1 − cos(a − b)) = 8 sin²((a − b)/2)
        rotation = 8 * np.sin((heads[:, 2] - tails[:, 2] - z[:, 2]) / 2) ** 2
        translation = heads[:, :2] - tails[:, :2] - _rotate_2d(tails[:, 2], z[:, :2])
    else:
        kappa = 1.5 / np.trace(np.linalg.inv(graph.information[:, 3:, 3:]), axis1=1, axis2=2)
        q_i, q_j, q_z = (_unit(pose[:, 3:]) for pose in (tails, heads, z))
        # ‖R − I‖²_F = 8 sin²(θ/2) = 8 |vec q|²
        q = _multiply(_conjugate(_multiply(q_i, q_z)), q_j)
        rotation = 8 * np.sum(q[:, :3] ** 2, axis=1)
        translation = heads[:, :3] - tails[:, :3] - _rotate_3d(q_i, z[:, :3])
    return float(np.sum(kappa * rotation + tau * np.sum(translation**2, axis=1)))


def _chain(dim: int, edges: list[tuple[int, int, list[float]]]) -> dict[int, list[float]]:
    """Poses from the edges (k, k + 1), starting with the identity at the least id."""
    compose: Callable[[Array, Array], Array] = _compose_2d if dim == 2 else _compose_3d
    odometry = {(i, j): np.array([z[: 3 if dim == 2 else 7]]) for i, j, z in reversed(edges)}
    ids = sorted({vertex for i, j, _ in edges for vertex in (i, j)})
    pose = np.zeros((1, 3)) if dim == 2 else np.array([[0.0, 0, 0, 0, 0, 0, 1]])
    poses = {ids[0]: pose[0].tolist()}
    for previous, vertex in pairwise(ids):
        pose = compose(pose, odometry[previous, vertex])
        poses[vertex] = pose[0].tolist()
    return poses


def _compose_2d(a: Array, b: Array) -> Array:
    return np.column_stack([a[:, :2] + _rotate_2d(a[:, 2], b[:, :2]), a[:, 2] + b[:, 2]])


def _compose_3d(a: Array, b: Array) -> Array:
    q = _unit(_multiply(a[:, 3:], b[:, 3:]))
    return np.hstack([a[:, :3] + _rotate_3d(_unit(a[:, 3:]), b[:, :3]), q])


def _symmetric(upper: Array, size: int) -> Array:
    """m × size × size matrices from rows of upper triangles."""
    full = np.zeros((len(upper), size, size))
    rows, columns = np.triu_indices(size)
    full[:, rows, columns] = upper
    full[:, columns, rows] = upper
    return full


def _rotate_2d(theta: Array, v: Array) -> Array:
    c, s = np.cos(theta), np.sin(theta)
    return np.column_stack([c * v[:, 0] - s * v[:, 1], s * v[:, 0] + c * v[:, 1]])


def _unit(q: Array) -> Array:
    """Quaternions scaled to norm 1."""
    unit: Array = q / np.linalg.norm(q, axis=1, keepdims=True)
    return unit


def _conjugate(q: Array) -> Array:
    conjugate: Array = q * np.array([-1.0, -1, -1, 1])
    return conjugate


def _multiply(a: Array, b: Array) -> Array:
    """Hamilton product of quaternions x y z w."""
    u, p, v, q = a[:, :3], a[:, 3:], b[:, :3], b[:, 3:]
    return np.hstack([p * v + q * u + np.cross(u, v), p * q - np.sum(u * v, axis=1, keepdims=True)])


def _rotate_3d(q: Array, v: Array) -> Array:
    twice = 2 * np.cross(q[:, :3], v)
    rotated: Array = v + q[:, 3:] * twice + np.cross(q[:, :3], twice)
    return rotated
