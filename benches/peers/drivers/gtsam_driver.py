"""GTSAM from its PyPI wheel: graph by its own reader, state recorded after each call of `iterate`."""

from __future__ import annotations

import sys
from pathlib import Path

import gtsam
import numpy as np

from record import Recorder, quaternions

LINEAR_SOLVERS = gtsam.NonlinearOptimizerParams.LinearSolverType
OPTIMIZERS = {
    "lm": (gtsam.LevenbergMarquardtOptimizer, gtsam.LevenbergMarquardtParams),
    "gn": (gtsam.GaussNewtonOptimizer, gtsam.GaussNewtonParams),
    "dogleg": (gtsam.DoglegOptimizer, gtsam.DoglegParams),
}


def load(path: str) -> tuple[gtsam.NonlinearFactorGraph, gtsam.Values, bool]:
    """The graph with a prior at the first pose's start, of the noise GTSAM's examples use."""
    spatial = "SE3" in Path(path).read_text(encoding="utf-8")[:10_000]
    graph, values = gtsam.readG2o(path, spatial)
    first = min(values.keys())
    if spatial:
        noise = gtsam.noiseModel.Diagonal.Variances(np.array([1e-6] * 3 + [1e-4] * 3))
        graph.add(gtsam.PriorFactorPose3(first, values.atPose3(first), noise))
    else:
        noise = gtsam.noiseModel.Diagonal.Variances(np.array([1e-6, 1e-6, 1e-8]))
        graph.add(gtsam.PriorFactorPose2(first, values.atPose2(first), noise))
    return graph, values, spatial


def poses(values: gtsam.Values, spatial: bool) -> np.ndarray:
    """Rows x y θ or x y z qx qy qz qw; GTSAM keeps keys sorted."""
    if not spatial:
        return gtsam.utilities.extractPose2(values)
    rows = gtsam.utilities.extractPose3(values)
    return np.hstack([rows[:, 9:], quaternions(rows[:, :9].reshape(-1, 3, 3))])


def initialize(graph: gtsam.NonlinearFactorGraph, spatial: bool) -> gtsam.Values:
    """GTSAM's own initial guess: chordal in 3-D, LAGO in 2-D."""
    return gtsam.InitializePose3.initialize(graph) if spatial else gtsam.lago.initialize(graph)


def main(path: str, method: str, output: str, max_iterations: str = "") -> None:
    """Run METHOD = [init+](lm|gn|dogleg)[+solver][+metis], with the stopping rule of GTSAM's `optimize`."""
    graph, values, spatial = load(path)
    options = method.split("+")
    optimizer_type, params_type = next(OPTIMIZERS[name] for name in options if name in OPTIMIZERS)
    params = params_type()
    if "solver" in options:
        params.setLinearSolver(LINEAR_SOLVERS.MULTIFRONTAL_SOLVER)
    if "metis" in options:
        params.setOrderingType("METIS")
    if max_iterations:
        params.setMaxIterations(int(max_iterations))
    recorder, status, iteration = Recorder(), "max_iterations", 0
    recorder.start()
    try:
        if "init" in options:
            values = initialize(graph, spatial)
        optimizer = optimizer_type(graph, values, params)
        error = optimizer.error()
        recorder.stop()
        recorder.keep(0, poses(values, spatial))
        while iteration < params.getMaxIterations():
            recorder.start()
            iteration += 1
            optimizer.iterate()
            previous, error = error, optimizer.error()
            decrease = previous - error
            done = decrease <= params.getAbsoluteErrorTol() or decrease <= params.getRelativeErrorTol() * previous
            recorder.stop()
            recorder.keep(iteration, poses(optimizer.values(), spatial))
            if done or not np.isfinite(error):
                # GTSAM, too, stops at the first step that raises the error.
                status = "converged" if decrease >= 0 else "error increased"
                break
    except RuntimeError as failure:
        recorder.stop()
        status = f"error: {' '.join(str(failure).split())[:200]}"
    recorder.report(status, Path(output))


if __name__ == "__main__":
    main(*sys.argv[1:])
