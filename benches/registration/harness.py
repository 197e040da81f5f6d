"""boxplus and small_gicp on the same scans, in turn; prints the tables of docs/benchmarks.md."""

import argparse
import gzip
import json
import os
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
DRIVER = HERE / "target/release/boxplus-registration-bench"
DATA = Path(os.environ.get("BOXPLUS_DATA", HERE / "../../../shared/data")) / "registration"
METHODS = {"point": "ICP", "plane": "PLANE_ICP", "generalised": "GICP"}
# Ours stops when a step moves the points by less than 1e-4 of the gate; so small a rotation moves a scan of 20 m as far.
STRICT = {"translation_epsilon": 1e-4, "rotation_epsilon": 5e-6}


@dataclass(frozen=True)
class Case:
    """Two clouds and what is known of them."""

    name: str
    source: str
    target: str
    truth: np.ndarray
    voxel: float
    gate: float


def cases() -> list[Case]:
    """The pairs of which a transform is known, see the README."""
    lidar = np.loadtxt(DATA / "small_gicp-T_target_source.txt")
    car = np.array(
        [
            [0.982304, 0.166685, -0.0854066, 0.0446816],
            [-0.150189, 0.973488, 0.172524, 0.191998],
            [0.111899, -0.156644, 0.981296, -0.0356313],
            [0, 0, 0, 1],
        ]
    )
    c, s = np.cos(np.radians(10)), np.sin(np.radians(10))
    rabbit = np.array([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    return [
        Case("lidar", "small_gicp-source.ply", "small_gicp-target.ply", lidar, 0.25, 1.0),
        Case("car", "car_cloud401.csv.gz", "car_cloud400.csv.gz", car, 0.1, 1.0),
        Case("rabbit", "bunny-part2.xyz", "bunny-part1.xyz", rabbit, 0.2, 0.5),
    ]


def load(name: str) -> np.ndarray:
    """The points of a file, n × 3."""
    raw = (DATA / name).read_bytes()
    raw = gzip.decompress(raw) if name.endswith(".gz") else raw
    if name.endswith(".ply"):
        body = raw.index(b"end_header\n") + len(b"end_header\n")
        return np.frombuffer(raw[body:], np.float32).reshape(-1, 4)[:, :3].astype(np.float64)
    lines = raw.decode().replace(",", " ").splitlines()
    lines = lines[1:] if lines[0].lstrip()[0].isalpha() else lines
    return np.array([line.split()[:3] for line in lines if line.strip()], dtype=np.float64)


def peer(case: Case, method: str, threads: int, stop: str) -> None:
    """Aligns once with small_gicp, in this process, and prints what it took."""
    import small_gicp

    source, target = load(case.source), load(case.target)
    wall, cpu = time.perf_counter(), time.process_time()
    result = small_gicp.align(
        target,
        source,
        registration_type=METHODS[method],
        downsampling_resolution=case.voxel,
        max_correspondence_distance=case.gate,
        num_threads=threads,
        max_iterations=50,
        **(STRICT if stop == "strict" else {}),
    )
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    matrix = result.T_target_source.ravel().tolist()
    print(json.dumps({"wall": wall, "cpu": cpu, "iterations": result.iterations, "matches": result.num_inliers, "T": matrix}))


def errors(found: list[float], truth: np.ndarray) -> tuple[float, float]:
    """Metres and milliradians from a truth that is printed with six digits."""
    u, _, v = np.linalg.svd(truth[:3, :3])
    matrix = np.array(found).reshape(4, 4)
    e = (u @ v).T @ matrix[:3, :3]
    turn = np.linalg.norm([e[2, 1] - e[1, 2], e[0, 2] - e[2, 0], e[1, 0] - e[0, 1]]) / 2
    return float(np.linalg.norm(matrix[:3, 3] - truth[:3, 3])), 1e3 * float(np.arcsin(min(turn, 1.0)))


def commands(case: Case, method: str, threads: int) -> dict[str, list[str]]:
    """The competitors."""
    files = [str(DATA / case.source), str(DATA / case.target)]
    ours = [str(DRIVER), *files, method, str(case.voxel), str(case.gate), str(threads)]
    theirs = [sys.executable, __file__, "--peer", case.name, method, str(threads)]
    return {"boxplus": ours, "small_gicp": [*theirs, "default"], "small_gicp, strict": [*theirs, "strict"]}


def main() -> None:
    """Runs everything in turn, and everything again."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeat", type=int, default=7)
    parser.add_argument("--peer", nargs=4, metavar=("CASE", "METHOD", "THREADS", "STOP"), help=argparse.SUPPRESS)
    options = parser.parse_args()
    known = {case.name: case for case in cases()}
    if options.peer:
        name, method, threads, stop = options.peer
        return peer(known[name], method, int(threads), stop)
    runs: dict[tuple[str, str, str, int], list[dict]] = {}
    for _ in range(options.repeat):
        for case in known.values():
            for method in METHODS:
                for threads in (1, 2):
                    for who, command in commands(case, method, threads).items():
                        done = subprocess.run(command, check=True, capture_output=True, text=True)
                        runs.setdefault((case.name, method, who, threads), []).append(json.loads(done.stdout))
    print("| scans | method | | error | steps | CPU, 1 thread | wall, 1 thread | wall, 2 threads |")
    print("|---|---|---|---|---|---|---|---|")
    for case, method, who, threads in runs:
        if threads == 2:
            continue
        one, two = runs[case, method, who, 1], runs[case, method, who, 2]
        metres, turn = errors(one[0]["T"], known[case].truth)
        least = lambda key, all_runs: 1e3 * min(run[key] for run in all_runs)  # noqa: E731
        times = f"{least('cpu', one):.1f} ms | {least('wall', one):.1f} ms | {least('wall', two):.1f} ms"
        print(f"| {case} | {method} | {who} | {metres:.4f} m, {turn:.2f} mrad | {one[0]['iterations']} | {times} |")
    return None


if __name__ == "__main__":
    main()
