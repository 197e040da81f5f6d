"""Pose graphs from NumPy arrays beside GTSAM, on the same numbers in one run: building, and solving.

    pip install ./crates/boxplus-py gtsam && python benches/python/graphs.py FILE.g2o...

Prints seconds, the least of five runs, and the cost ½Σ‖U·Log(Z⁻¹X₁⁻¹X₂)‖² where each ends, as a table. Both start at the poses of the file, with the
first one held (a prior of 1e-6 in GTSAM), and minimise the same cost by Levenberg-Marquardt, on one thread.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import boxplus as bp

ROTATION_FIRST = [3, 4, 5, 0, 1, 2]
Numbers = dict[str, Any]


def numbers(path: Path) -> Numbers:
    """A graph in space as plain arrays."""
    graph = bp.PoseGraph.read(path)
    from_, to, measured, information = graph.edges
    return {
        "poses": np.asarray(graph.poses), "from": np.searchsorted(graph.ids, from_), "to": np.searchsorted(graph.ids, to),
        "measured": np.asarray(measured), "information": information,
    }  # fmt: skip


def pose_graph(n: Numbers) -> Callable[[], float]:
    graph = bp.PoseGraph()
    graph.add_poses(np.arange(len(n["poses"])), bp.SE3.from_array(n["poses"]))
    graph.add_edges(n["from"], n["to"], bp.SE3.from_array(n["measured"]), information=n["information"])
    graph.fix(0)
    return lambda: graph.solve(initial="as_given", threads=1).cost


def factor_graph(n: Numbers) -> Callable[[], float]:
    graph = bp.Graph()
    x = graph.variables(bp.SE3.from_array(n["poses"]))
    graph.between(x[n["from"]], x[n["to"]], bp.SE3.from_array(n["measured"]), information=n["information"])
    graph.fix(x[0])
    return lambda: graph.solve(initial="as_given", threads=1).cost


def gtsam_graph(n: Numbers) -> Callable[[], float]:
    import gtsam

    def pose(row: Any) -> Any:
        return gtsam.Pose3(gtsam.Rot3.Quaternion(row[6], row[3], row[4], row[5]), row[:3])

    graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    for i, row in enumerate(n["poses"]):
        values.insert(i, pose(row))
    for i, j, row, information in zip(n["from"], n["to"], n["measured"], n["information"], strict=True):
        noise = gtsam.noiseModel.Gaussian.Information(information[np.ix_(ROTATION_FIRST, ROTATION_FIRST)])
        graph.add(gtsam.BetweenFactorPose3(int(i), int(j), pose(row), noise))
    graph.add(gtsam.PriorFactorPose3(0, pose(n["poses"][0]), gtsam.noiseModel.Isotropic.Sigma(6, 1e-6)))
    parameters = gtsam.LevenbergMarquardtParams.CeresDefaults()
    parameters.setRelativeErrorTol(1e-9)
    return lambda: graph.error(gtsam.LevenbergMarquardtOptimizer(graph, values, parameters).optimize())


def least(run: Callable[[], Any]) -> tuple[float, Any]:
    """The least time of five runs, and the last result."""
    seconds, result = [], None
    for _ in range(5):
        start = time.perf_counter()
        result = run()
        seconds.append(time.perf_counter() - start)
    return min(seconds), result


def main() -> None:
    tools = {"boxplus.PoseGraph": pose_graph, "boxplus.Graph": factor_graph}
    if find_spec("gtsam"):
        tools["GTSAM"] = gtsam_graph
    print("| graph | tool | build | solve | cost |\n|---|---|---:|---:|---:|")
    for path in map(Path, sys.argv[1:]):
        n = numbers(path)
        for name, build in tools.items():
            built, solve = least(lambda build=build: build(n))  # type: ignore[misc]
            solved, cost = least(solve)
            print(f"| {path.stem} | {name} | {built:.3f} s | {solved:.3f} s | {cost:.7g} |")


if __name__ == "__main__":
    main()
