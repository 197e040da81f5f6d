"""boxplus and GTSAM on the same inertial batch problems, in turn; prints the table of docs/inertial.md."""

import os
import subprocess
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

import gtsam
import numpy as np
from gtsam.symbol_shorthand import B, V, X

HERE = Path(__file__).resolve().parent
PROGRAM = HERE / "../../target/release/examples/inertial"
DATA = Path(os.environ.get("BOXPLUS_DATA", HERE / "../../../shared/data"))
# Name, seconds until judged, standard deviation of the truth in metres.
SETS = [("euroc", 0.0, 0.0), ("kitti", 20.0, 0.07)]


@dataclass
class Problem:
    """What the program wrote: see `Batch::text`."""

    noise: np.ndarray
    bias: np.ndarray
    stamps: list[int] = field(default_factory=list)
    states: list[np.ndarray] = field(default_factory=list)
    fixes: dict[int, np.ndarray] = field(default_factory=dict)
    readings: dict[int, list[np.ndarray]] = field(default_factory=dict)


@dataclass
class Estimate:
    """A state a row: stamp, position, quaternion x y z w, standard deviations of the local error; seconds of each stage."""

    cost: float
    iterations: int
    seconds: list[float]
    rows: list[tuple[int, np.ndarray]]


def read_problem(path: Path) -> Problem:
    """A line a fact."""
    problem = Problem(np.zeros(6), np.zeros(8))
    for line in path.read_text().splitlines():
        kind, *words = line.split()
        if kind == "noise":
            problem.noise = np.array(words, float)
        elif kind == "bias":
            problem.bias = np.array(words, float)
        elif kind == "state":
            problem.stamps.append(int(words[0]))
            problem.states.append(np.array(words[1:], float))
        elif kind == "fix":
            problem.fixes[int(words[0])] = np.array(words[1:], float)
        else:
            problem.readings.setdefault(int(words[0]), []).append(np.array(words[1:], float))
    return problem


def read_estimate(path: Path) -> Estimate:
    """Cost, iterations and seconds, then the states."""
    head, *lines = path.read_text().splitlines()
    _, cost, iterations, *seconds = head.split()
    rows = [(int(line.split()[0]), np.array(line.split()[1:], float)) for line in lines]
    return Estimate(float(cost), int(iterations), [float(x) for x in seconds], rows)


def rotation(q: np.ndarray) -> gtsam.Rot3:
    """Of x y z w."""
    return gtsam.Rot3(q[3], q[0], q[1], q[2])


def solve(problem: Problem, combined: bool) -> Estimate:
    """With CombinedImuFactor, or with ImuFactor and a walk of the bias beside it, as boxplus has it."""
    clock = time.perf_counter()
    graph, values = build(problem, combined)
    built = time.perf_counter()
    optimizer = gtsam.LevenbergMarquardtOptimizer(graph, values)
    result = optimizer.optimize()
    optimised = time.perf_counter()
    marginals = gtsam.Marginals(graph, result)
    rows = []
    for k, stamp in enumerate(problem.stamps):
        pose, covariance = result.atPose3(X(k)), marginals.marginalCovariance(X(k))
        sigmas = np.sqrt(np.diag(covariance))
        q = pose.rotation().toQuaternion()
        numbers = [*pose.translation(), q.x(), q.y(), q.z(), q.w(), *sigmas[3:], *sigmas[:3]]
        rows.append((stamp, np.array(numbers)))
    told = time.perf_counter()
    seconds = [built - clock, optimised - built, told - optimised]
    return Estimate(graph.error(result), optimizer.iterations(), seconds, rows)


def fastest(problem: Problem, combined: bool) -> Estimate:
    """Solved five times; of each stage the shortest time."""
    estimates = [solve(problem, combined) for _ in range(5)]
    estimates[0].seconds = [min(times) for times in zip(*(e.seconds for e in estimates), strict=True)]
    return estimates[0]


def build(problem: Problem, combined: bool) -> tuple[gtsam.NonlinearFactorGraph, gtsam.Values]:
    """The same states, priors, sums and positions from the same start."""
    gyro, accel, gyro_walk, accel_walk, fix, gravity = problem.noise
    kind = gtsam.PreintegrationCombinedParams if combined else gtsam.PreintegrationParams
    params = kind.MakeSharedU(gravity)
    params.setGyroscopeCovariance(np.eye(3) * gyro**2)
    params.setAccelerometerCovariance(np.eye(3) * accel**2)
    params.setIntegrationCovariance(np.eye(3) * 1e-10)
    if combined:
        params.setBiasOmegaCovariance(np.eye(3) * gyro_walk**2)
        params.setBiasAccCovariance(np.eye(3) * accel_walk**2)
    sums = gtsam.PreintegratedCombinedMeasurements if combined else gtsam.PreintegratedImuMeasurements
    # GTSAM orders a bias (accelerometer, gyroscope).
    bias = gtsam.imuBias.ConstantBias(problem.bias[3:6], problem.bias[:3])
    graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    sigmas = np.repeat(problem.bias[[7, 6]], 3)
    graph.add(gtsam.PriorFactorConstantBias(B(0), bias, gtsam.noiseModel.Diagonal.Sigmas(sigmas)))
    position = gtsam.noiseModel.Isotropic.Sigma(3, fix)
    for k, state in enumerate(problem.states):
        values.insert(X(k), gtsam.Pose3(rotation(state[3:7]), state[:3]))
        values.insert(V(k), state[7:])
        values.insert(B(k), bias)
        if k in problem.fixes:
            graph.add(gtsam.GPSFactor(X(k), problem.fixes[k], position))
        if k not in problem.readings:
            continue
        total = sums(params, bias)
        for z in problem.readings[k]:
            total.integrateMeasurement(z[3:6], z[:3], z[6])
        if combined:
            graph.add(gtsam.CombinedImuFactor(X(k), V(k), X(k + 1), V(k + 1), B(k), B(k + 1), total))
            continue
        graph.add(gtsam.ImuFactor(X(k), V(k), X(k + 1), V(k + 1), B(k), total))
        root = np.sqrt(total.deltaTij())
        walk = gtsam.noiseModel.Diagonal.Sigmas(np.repeat([accel_walk, gyro_walk], 3) * root)
        graph.add(gtsam.BetweenFactorConstantBias(B(k), B(k + 1), gtsam.imuBias.ConstantBias(), walk))
    return graph, values


def judge(estimate: Estimate, truth: dict[int, np.ndarray], settled: float, sigma: float) -> str:
    """Position and rotation RMSE, share inside 3σ coordinate by coordinate, and the local error behind them."""
    start = estimate.rows[0][0]
    errors, bands = [], []
    for stamp, row in estimate.rows:
        if stamp not in truth or (stamp - start) * 1e-9 < settled:
            continue
        so, turn = truth[stamp], rotation(row[3:7])
        error, band = turn.unrotate(so[:3] - row[:3]), np.hypot(row[7:10], sigma)
        if len(so) > 3:
            error = np.concatenate([error, gtsam.Rot3.Logmap(turn.between(rotation(so[3:])))])
            band = np.concatenate([band, row[10:13]])
        errors.append(error)
        bands.append(band)
    error, band = np.array(errors), np.array(bands)
    inside = 100 * np.mean(np.abs(error) <= 3 * band)
    square = np.mean(error**2, axis=0)
    turned = f"{np.degrees(np.sqrt(square[3:].sum())):.2f}°" if len(square) > 3 else ""
    return f"{np.sqrt(square[:3].sum()):.3f} m | {turned} | {inside:.1f} %"


def main() -> None:
    """One run: the problems, boxplus, GTSAM twice."""
    print("| problem | solver | position | rotation | inside 3σ | cost | steps | sums, graph | optimum | covariances |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        subprocess.run([PROGRAM, DATA, folder], check=True, stdout=subprocess.DEVNULL)
        for title, settled, sigma in SETS:
            problem = read_problem(folder / f"{title}.problem")
            lines = [line.split() for line in (folder / f"{title}.truth").read_text().splitlines()]
            truth = {int(stamp): np.array(numbers, float) for stamp, *numbers in lines}
            estimates = {
                "boxplus": read_estimate(folder / f"{title}.estimate"),
                "GTSAM, `ImuFactor`": fastest(problem, combined=False),
                "GTSAM, `CombinedImuFactor`": fastest(problem, combined=True),
            }
            for solver, estimate in estimates.items():
                seconds = " | ".join(f"{x:.3f} s" for x in estimate.seconds)
                judged = judge(estimate, truth, settled, sigma)
                print(f"| {title} | {solver} | {judged} | {estimate.cost:.2f} | {estimate.iterations} | {seconds} |")


if __name__ == "__main__":
    main()
