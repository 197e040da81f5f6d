"""jaxlie: quaternions wxyz, tangents as ours; jitted over batches. Its one Jacobian is `jlog`, of Log."""

from __future__ import annotations

import os

os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"
os.environ["JAX_PLATFORMS"] = "cpu"

from collections.abc import Callable

import jax
import jaxlie
import numpy as np
from jax import numpy as jnp

from protocol import Bench

jax.config.update("jax_enable_x64", True)
BATCH = 100_000
QUATERNION = [3, 0, 1, 2]
POSE = [3, 0, 1, 2, 4, 5, 6]


def group(name: str, scalar: str, kind: type[jaxlie.MatrixLieGroup], storage: list[int]) -> None:
    """All operations of one group. ``storage``: theirs k is ours storage[k]."""
    bench = Bench(name, scalar)
    dtype = jnp.float64 if scalar == "f64" else jnp.float32
    back = np.argsort(storage)

    def operation(key: str, function: Callable[..., jax.Array], *columns: np.ndarray) -> None:
        jitted = jax.jit(jax.vmap(function))
        inputs = [jnp.asarray(c, dtype) for c in columns]
        bench.rows(key, lambda: np.asarray(jitted(*inputs), dtype=float))
        if bench.mode == "time" and len(bench.a):
            many = [jnp.tile(c, (BATCH // len(c) + 1, 1))[:BATCH] for c in inputs]
            bench.time(key, lambda: jax.block_until_ready(jitted(*many)), BATCH)

    def element(row: jax.Array) -> jaxlie.MatrixLieGroup:
        return kind(row[jnp.array(storage)])

    def row(x: jaxlie.MatrixLieGroup) -> jax.Array:
        return x.wxyz_xyz[back] if name == "SE3" else x.parameters()[back]

    operation("exp", lambda t: row(kind.exp(t)), bench.tau)
    operation("log", lambda a: element(a).log(), bench.a)
    operation("inverse", lambda a: row(element(a).inverse()), bench.a)
    operation("compose", lambda a, b: row(element(a) @ element(b)), bench.a, bench.b)
    operation("between", lambda a, b: row(element(a).inverse() @ element(b)), bench.a, bench.b)
    operation("act", lambda a, p: element(a) @ p, bench.a, bench.point)
    operation("rplus", lambda a, t: row(element(a) @ kind.exp(t)), bench.a, bench.tau)
    operation("rminus", lambda a, b: (element(a).inverse() @ element(b)).log(), bench.a, bench.b)
    operation("adjoint", lambda a: element(a).adjoint(), bench.a)
    operation("jr_inv", lambda t: kind.exp(t).jlog(), bench.tau)


def main() -> None:
    """Both scalars."""
    for scalar in ("f64", "f32"):
        group("SO2", scalar, jaxlie.SO2, [0, 1])
        group("SE2", scalar, jaxlie.SE2, [0, 1, 2, 3])
        group("SO3", scalar, jaxlie.SO3, QUATERNION)
        group("SE3", scalar, jaxlie.SE3, POSE)


if __name__ == "__main__":
    main()
