"""Batched operations on SE(3) beside SciPy and jaxlie, and single calls beside GTSAM, on the same inputs in one run.

    pip install ./crates/boxplus-py scipy jaxlie gtsam && python benches/python/groups.py [largest power of ten]

Prints nanoseconds per element, the least of seven runs, as a table. What is not installed is left out. jaxlie is compiled (jit), in double
precision, and waited for; arrays are already where each package wants them.
"""

from __future__ import annotations

import sys
import timeit
from collections.abc import Callable
from importlib.util import find_spec
from typing import Any

import numpy as np
import boxplus as bp

Run = Callable[[], Any]


def ours(tau: Any, p: Any) -> dict[str, Run]:
    x, y = bp.SE3.exp(tau), bp.SE3.exp(tau[::-1])
    return {
        "exp": lambda: bp.SE3.exp(tau),
        "log": x.log,
        "compose": lambda: x @ y,
        "inverse": x.inverse,
        "act": lambda: x @ p,
        "minus": lambda: x - y,
        "minus_jac": lambda: x.minus_jac(y),
    }


def scipy(tau: Any, p: Any) -> dict[str, Run]:
    from scipy.spatial.transform import RigidTransform

    rotation_first = np.ascontiguousarray(tau[:, [3, 4, 5, 0, 1, 2]])
    x = RigidTransform.from_exp_coords(rotation_first)
    y = RigidTransform.from_exp_coords(rotation_first[::-1])
    return {
        "exp": lambda: RigidTransform.from_exp_coords(rotation_first),
        "log": x.as_exp_coords,
        "compose": lambda: x * y,
        "inverse": x.inv,
        "act": lambda: x.apply(p),
        "minus": lambda: (y.inv() * x).as_exp_coords(),
    }


def jaxlie(tau: Any, p: Any) -> dict[str, Run]:
    import jax
    import jaxlie

    jax.config.update("jax_enable_x64", True)
    tau, p = jax.numpy.asarray(tau), jax.numpy.asarray(p)
    x, y = jaxlie.SE3.exp(tau), jaxlie.SE3.exp(tau[::-1])

    def timed(function: Any, *arguments: Any) -> Run:
        compiled = jax.jit(function)
        jax.block_until_ready(compiled(*arguments))
        return lambda: jax.block_until_ready(compiled(*arguments))

    return {
        "exp": timed(jaxlie.SE3.exp, tau),
        "log": timed(lambda x: x.log(), x),
        "compose": timed(lambda x, y: x @ y, x, y),
        "inverse": timed(lambda x: x.inverse(), x),
        "act": timed(lambda x, p: x @ p, x, p),
        "minus": timed(jaxlie.manifold.rminus, y, x),
    }


def gtsam_single(tau: Any, p: Any) -> dict[str, Run]:
    import gtsam

    rotation_first = np.ascontiguousarray(tau[[3, 4, 5, 0, 1, 2]])
    x, y = gtsam.Pose3.Expmap(rotation_first), gtsam.Pose3.Expmap(rotation_first[::-1])
    return {
        "exp": lambda: gtsam.Pose3.Expmap(rotation_first),
        "log": lambda: gtsam.Pose3.Logmap(x),
        "compose": lambda: x.compose(y),
        "inverse": x.inverse,
        "act": lambda: x.transformFrom(p),
        "minus": lambda: y.localCoordinates(x),
    }


def nanoseconds(run: Run, count: int) -> float:
    timer = timeit.Timer(run)
    number = max(1, timer.autorange()[0] // 2) if count < 100_000 else 1
    return min(timer.repeat(7, number)) / number / count * 1e9


def table(title: str, columns: dict[str, dict[str, Run]], count: int) -> None:
    print(f"\n### {title}\n\n| |{'|'.join(columns)}|\n|---|{'---:|' * len(columns)}")
    for name in columns["boxplus"]:
        cells = [f"{nanoseconds(runs[name], count):.3g}" if name in runs else "" for runs in columns.values()]
        print(f"| {name} | {' | '.join(cells)} |")


def main() -> None:
    largest = int(sys.argv[1]) if len(sys.argv) > 1 else 6
    rng = np.random.default_rng(1)
    peers = {"scipy": scipy, "jaxlie": jaxlie}
    installed = {name: peer for name, peer in peers.items() if find_spec(name)}
    for power in (4, 5, 6, 7)[: max(0, largest - 3)]:
        tau, p = rng.normal(size=(10**power, 6)), rng.normal(size=(10**power, 3))
        columns = {"boxplus": ours(tau, p)} | {name: peer(tau, p) for name, peer in installed.items()}
        table(f"10^{power} elements, ns per element", columns, 10**power)
    tau, p = rng.normal(size=6), rng.normal(size=3)
    columns = {"boxplus": ours(tau, p)}
    if find_spec("gtsam"):
        columns["gtsam"] = gtsam_single(tau, p)
    table("one element, ns per call", columns, 1)


if __name__ == "__main__":
    main()
