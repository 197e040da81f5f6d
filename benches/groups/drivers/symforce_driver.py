"""SymForce's generated `sym` package, f64. Its poses are SO(n)×ℝⁿ: of these, what SE(n) has too."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import sym

from protocol import Array, Bench


def group(name: str, kind: type, storage: list[int], tangent: bool) -> None:
    """All operations of one group. ``storage``: theirs k is ours storage[k]."""
    bench = Bench(name, "f64")
    back = np.argsort(storage)

    def element(row: Array) -> object:
        return kind.from_storage([float(x) for x in row[storage]])

    def rows(results: list[object]) -> list[Array]:
        return [np.array(x.to_storage())[back] for x in results]

    def per_row(call: Callable[..., object], *columns: list[object]) -> list[object]:
        return [call(*row) for row in zip(*columns, strict=True)]

    a, b = [element(r) for r in bench.a], [element(r) for r in bench.b]
    bench.rows("inverse", lambda: rows(per_row(lambda x: x.inverse(), a)))
    bench.rows("compose", lambda: rows(per_row(lambda x, y: x.compose(y), a, b)))
    bench.rows("between", lambda: rows(per_row(lambda x, y: x.between(y), a, b)))
    bench.rows("act", lambda: per_row(lambda x, p: x.compose_with_point(p), a, list(bench.point)))
    if tangent:
        bench.rows("exp", lambda: rows(per_row(lambda t: kind.from_tangent(t), list(bench.tau))))
        bench.rows("log", lambda: per_row(lambda x: x.to_tangent(), a))
        bench.rows("rminus", lambda: per_row(lambda x, y: x.between(y).to_tangent(), a, b))


def main() -> None:
    """What is a Lie group there."""
    group("SO2", sym.Rot2, [0, 1], tangent=True)
    group("SE2", sym.Pose2, [0, 1, 2, 3], tangent=False)
    group("SO3", sym.Rot3, [0, 1, 2, 3], tangent=True)
    group("SE3", sym.Pose3, [0, 1, 2, 3, 4, 5, 6], tangent=False)


if __name__ == "__main__":
    main()
