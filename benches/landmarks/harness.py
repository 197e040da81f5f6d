"""boxplus and GTSAM on the same maps with ranges, from the same start, in turn: final cost and seconds of one thread."""

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import gtsam
import numpy as np

BOXPLUS = os.environ["BOXPLUS"]


def key(name: str) -> int:
    """GTSAM's symbol of `A0`."""
    return gtsam.symbol(name[0], int(name[1:]))


def covariance(numbers: list[float]) -> gtsam.noiseModel.Gaussian:
    """The noise of an upper triangle by rows, in the order translation, rotation."""
    size = int((2 * len(numbers)) ** 0.5)
    matrix = np.zeros((size, size))
    matrix[np.triu_indices(size)] = numbers
    matrix = matrix + np.triu(matrix, 1).T
    if size == 6:  # GTSAM has the rotation first
        order = [3, 4, 5, 0, 1, 2]
        matrix = matrix[np.ix_(order, order)]
    return gtsam.noiseModel.Gaussian.Covariance(matrix)


def pose3(x: list[float]) -> gtsam.Pose3:
    """`x y z qx qy qz qw`."""
    return gtsam.Pose3(gtsam.Rot3.Quaternion(x[6], x[3], x[4], x[5]), np.array(x[:3]))


def load(path: Path) -> tuple[gtsam.NonlinearFactorGraph, gtsam.Values]:
    """The factors and the vertices of a map, with the first pose held all but exactly."""
    graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    points: set[str] = set()
    first = True
    for line in path.read_text().splitlines():
        tag, *fields = line.split()
        if tag in ("VERTEX_XY", "VERTEX_XYZ"):
            points.add(fields[0])
            values.insert(key(fields[0]), np.array([float(x) for x in fields[1:]]))
        elif tag in ("VERTEX_SE2", "VERTEX_SE3:QUAT"):
            x = [float(x) for x in fields[2:]]
            flat = tag == "VERTEX_SE2"
            pose = gtsam.Pose2(*x) if flat else pose3(x)
            values.insert(key(fields[1]), pose)
            if first:
                equality = gtsam.NonlinearEqualityPose2 if flat else gtsam.NonlinearEqualityPose3
                graph.add(equality(key(fields[1]), pose))
                first = False
        elif tag == "EDGE_SE2":
            x = [float(x) for x in fields[3:]]
            ends = (key(fields[1]), key(fields[2]))
            graph.add(gtsam.BetweenFactorPose2(*ends, gtsam.Pose2(*x[:3]), covariance(x[3:])))
        elif tag == "EDGE_SE3:QUAT":
            x = [float(x) for x in fields[3:]]
            ends = (key(fields[1]), key(fields[2]))
            graph.add(gtsam.BetweenFactorPose3(*ends, pose3(x[:7]), covariance(x[7:])))
        elif tag == "EDGE_RANGE":
            distance, variance = float(fields[3]), float(fields[4])
            factor = gtsam.RangeFactor2D if len(values.atVector(key(fields[2]))) == 2 else gtsam.RangeFactor3D
            ends = (key(fields[1]), key(fields[2]))
            graph.add(factor(*ends, distance, gtsam.noiseModel.Isotropic.Variance(1, variance)))
        else:
            raise ValueError(f"{path}: {tag}")
    return graph, values


def peer(start: Path) -> tuple[float, int, float]:
    """Cost, steps and seconds of GTSAM's Levenberg–Marquardt."""
    graph, values = load(start)
    parameters = gtsam.LevenbergMarquardtParams()
    parameters.setRelativeErrorTol(1e-9)
    parameters.setAbsoluteErrorTol(0.0)
    parameters.setMaxIterations(200)
    begin = time.perf_counter()
    optimizer = gtsam.LevenbergMarquardtOptimizer(graph, values, parameters)
    result = optimizer.optimize()
    return graph.error(result), optimizer.iterations(), time.perf_counter() - begin


def ours(arguments: list[str]) -> dict:
    """The document of `boxplus solve`."""
    command = [BOXPLUS, "solve", *arguments, "--threads", "1", "--json"]
    return json.loads(subprocess.run(command, capture_output=True, check=False, text=True).stdout)


def public_maps() -> list[str]:
    """Those of the data folder, BOXPLUS_DATA or `../shared/data` beside the checkout."""
    data = Path(os.environ.get("BOXPLUS_DATA", Path(__file__).resolve().parents[3] / "shared/data"))
    return sorted(str(path) for path in (data / "ranging").glob("*.pyfg*"))


def main() -> None:
    """Prints one row for each map and start."""
    print("| map | start | its cost | boxplus: cost, steps, s | GTSAM: cost, steps, s |")
    print("|---|---|---:|---:|---:|")
    for path in sys.argv[1:] or public_maps():
        for init in ["spanning-tree", "grown"]:
            with tempfile.TemporaryDirectory() as folder:
                start = Path(folder) / "start.pyfg"
                ours([path, "--init", init, "--max-iterations", "0", "-o", str(start)])
                mine = ours([str(start), "--init", "file", "--max-iterations", "200"])
                theirs = peer(start)
            cost = f"{mine['initial_cost']:.6g}"
            left = f"{mine['cost']:.7g}, {mine['iterations']}, {mine['seconds']['optimise']:.3f}"
            right = f"{theirs[0]:.7g}, {theirs[1]}, {theirs[2]:.3f}"
            print(f"| {Path(path).name} | {init} | {cost} | {left} | {right} |", flush=True)


if __name__ == "__main__":
    main()
