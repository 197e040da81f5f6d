"""g2o from its PyPI wheel, with its own edges, Eigen's sparse Cholesky and g2o's terminate action."""

from __future__ import annotations

import sys
from pathlib import Path

import g2o
import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))
from record import Recorder, quaternions
from score import PoseGraph, read_g2o

ALGORITHMS = {
    "lm": g2o.OptimizationAlgorithmLevenberg,
    "gn": g2o.OptimizationAlgorithmGaussNewton,
    "dogleg": g2o.OptimizationAlgorithmDogleg,
}


def isometry(pose: np.ndarray) -> g2o.Isometry3d:
    """An isometry from x y z qx qy qz qw."""
    x, y, z, w = pose[3:] / np.linalg.norm(pose[3:])
    return g2o.Isometry3d(g2o.Quaternion(w, x, y, z), pose[:3])


def build(graph: PoseGraph, method: str) -> g2o.SparseOptimizer:
    """The optimizer with the graph's vertices and edges, the first vertex fixed."""
    optimizer = g2o.SparseOptimizer()
    if graph.dim == 2:
        solver = g2o.BlockSolverSE2(g2o.LinearSolverEigenSE2())
        vertex_type, edge_type, element = g2o.VertexSE2, g2o.EdgeSE2, lambda p: g2o.SE2(*p)
    else:
        solver = g2o.BlockSolverSE3(g2o.LinearSolverEigenSE3())
        vertex_type, edge_type, element = g2o.VertexSE3, g2o.EdgeSE3, isometry
    optimizer.set_algorithm(ALGORITHMS[method](solver))
    for row, pose in enumerate(graph.poses):
        vertex = vertex_type()
        vertex.set_id(row)
        vertex.set_estimate(element(pose))
        vertex.set_fixed(row == 0)
        optimizer.add_vertex(vertex)
    for i, j, z, omega in zip(graph.tails, graph.heads, graph.measurements, graph.information, strict=True):
        edge = edge_type()
        edge.set_vertex(0, optimizer.vertex(int(i)))
        edge.set_vertex(1, optimizer.vertex(int(j)))
        edge.set_measurement(element(z))
        edge.set_information(omega)
        optimizer.add_edge(edge)
    return optimizer


def poses(optimizer: g2o.SparseOptimizer, graph: PoseGraph) -> np.ndarray:
    """Rows x y θ or x y z qx qy qz qw."""
    estimates = [optimizer.vertex(row).estimate() for row in range(len(graph.poses))]
    if graph.dim == 2:
        return np.array([estimate.to_vector() for estimate in estimates])
    matrices = np.array([estimate.matrix() for estimate in estimates])
    return np.hstack([matrices[:, :3, 3], quaternions(matrices[:, :3, :3])])


def main(path: str, method: str, output: str, max_iterations: str = "100") -> None:
    """Run METHOD (lm, gn, dogleg) for at most MAX_ITERATIONS."""
    graph = read_g2o(Path(path))
    optimizer = build(graph, method)
    terminate = g2o.SparseOptimizerTerminateAction()
    optimizer.add_post_iteration_action(terminate)
    recorder = Recorder()
    recorder.start()
    optimizer.initialize_optimization()
    iterations = optimizer.optimize(int(max_iterations))
    recorder.stop()
    recorder.keep(iterations, poses(optimizer, graph))
    ended = "max_iterations" if iterations == int(max_iterations) else "converged"
    recorder.report(ended if iterations > 0 else "failed", Path(output))


if __name__ == "__main__":
    main(*sys.argv[1:])
