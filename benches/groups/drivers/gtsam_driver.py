"""GTSAM's wheel: right Jacobians, tangents with the rotation first but for Pose2; f64. A call is mostly overhead."""

from __future__ import annotations

from collections.abc import Callable

import gtsam
import numpy as np

from protocol import Array, Bench, order_matrix, order_vector


def quaternion(row: Array) -> gtsam.Rot3:
    """From xyzw."""
    return gtsam.Rot3.Quaternion(row[3], *row[:3])


def rotation_row(r: gtsam.Rot3) -> Array:
    """To xyzw."""
    q = r.toQuaternion()
    return np.array([q.x(), q.y(), q.z(), q.w()])


def group(
    name: str,
    kind: type,
    order: list[int],
    read: Callable[[Array], object],
    write: Callable[[object], Array],
    act: str = "",
) -> None:
    """All operations that the wrapper of one group has."""
    bench = Bench(name, "f64")
    native = np.argsort(order)
    tau = [np.ascontiguousarray(t[native]) for t in bench.tau]
    a, b, points = [read(r) for r in bench.a], [read(r) for r in bench.b], list(bench.point)

    def vectors(results: list[Array]) -> list[Array]:
        return [order_vector(order, np.ravel(t)) for t in results]

    def matrices(results: list[Array]) -> list[Array]:
        return [order_matrix(order, np.atleast_2d(m)) for m in results]

    bench.rows("exp", lambda: [write(kind.Expmap(t)) for t in tau])
    bench.rows("log", lambda: vectors([kind.Logmap(x) for x in a]))
    bench.rows("compose", lambda: [write(x.compose(y)) for x, y in zip(a, b, strict=True)])
    bench.rows("inverse", lambda: [write(x.inverse()) for x in a])
    bench.rows("rminus", lambda: vectors([kind.Logmap(x.between(y)) for x, y in zip(a, b, strict=True)]))
    bench.rows("adjoint", lambda: matrices([x.AdjointMap() for x in a]))
    if kind is not gtsam.Similarity3:  # the only one without
        bench.rows("jr", lambda: matrices([_jacobian(kind.Expmap, t, len(order)) for t in tau]))
        bench.rows("jr_inv", lambda: matrices([_jacobian(kind.Logmap, kind.Expmap(t), len(order)) for t in tau]))
    if act:
        bench.rows("act", lambda: [getattr(x, act)(p) for x, p in zip(a, points, strict=True)])
    bench.time("compose", lambda: [x.compose(y) for x, y in zip(a, b, strict=True)], len(a))
    bench.time("log", lambda: [kind.Logmap(x) for x in a], len(a))
    bench.time("empty", lambda: [x.equals for x in a], len(a))


def _jacobian(function: Callable[..., object], argument: object, dim: int) -> Array:
    """What a function writes into its second argument."""
    jacobian = np.zeros((dim, dim), order="F")
    function(argument, jacobian)
    return jacobian


def pose3(row: Array) -> gtsam.Pose3:
    """From a row of ours."""
    return gtsam.Pose3(quaternion(row), row[4:7])


def main() -> None:
    """All groups that the wheel has."""
    group("SO2", gtsam.Rot2, [0], lambda r: gtsam.Rot2.fromCosSin(*r), lambda x: np.array([x.c(), x.s()]), "rotate")
    group(
        "SE2",
        gtsam.Pose2,
        [0, 1, 2],
        lambda r: gtsam.Pose2(gtsam.Rot2.fromCosSin(*r[:2]), r[2:]),
        lambda x: np.array([x.rotation().c(), x.rotation().s(), x.x(), x.y()]),
        "transformFrom",
    )
    group("SO3", gtsam.Rot3, [0, 1, 2], quaternion, rotation_row, "rotate")
    group(
        "SE3",
        gtsam.Pose3,
        [3, 4, 5, 0, 1, 2],
        pose3,
        lambda x: np.concatenate([rotation_row(x.rotation()), x.translation()]),
        "transformFrom",
    )
    group(
        "SE23",
        gtsam.NavState,
        [3, 4, 5, 0, 1, 2, 6, 7, 8],
        lambda r: gtsam.NavState(pose3(r), r[7:10]),
        lambda x: np.concatenate([rotation_row(x.attitude()), x.position(), x.velocity()]),
    )
    group(
        "SGal3",
        gtsam.Gal3,
        [6, 7, 8, 0, 1, 2, 3, 4, 5, 9],
        lambda r: gtsam.Gal3(quaternion(r), r[4:7], r[7:10], r[10]),
        lambda x: np.concatenate([rotation_row(x.rotation()), x.translation(), x.velocity(), [x.time()]]),
    )
    group(
        "Sim3",
        gtsam.Similarity3,
        [3, 4, 5, 0, 1, 2, 6],
        lambda r: gtsam.Similarity3(quaternion(r), r[4:7] / np.exp(r[7]), np.exp(r[7])),
        lambda x: np.concatenate([rotation_row(x.rotation()), x.translation() * x.scale(), [np.log(x.scale())]]),
        "transformFrom",
    )


if __name__ == "__main__":
    main()
