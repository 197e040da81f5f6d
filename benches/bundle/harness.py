"""Runs boxplus and Ceres in turn on the same problems and prints what each took: `run` builds both first.

Usage: harness.py [--repeat N] [PROBLEM.txt ...]; without problems, the two of bundle-adjustment/ in the folder of public data.
"""
import argparse
import os
import statistics
import subprocess
from pathlib import Path

HERE = Path(__file__).resolve().parent
DATA = Path(os.environ.get("BOXPLUS_DATA", HERE.parents[2] / "shared" / "data")) / "bundle-adjustment"
SOLVERS = {"boxplus": HERE / "target/release/boxplus-bundle-bench", "Ceres": HERE / "build/ceres"}
# The lowest costs known of minimisers in space, and those that are compared with: within a thousandth of them.
BEST = {"bal-ladybug-49-7776-pre.txt": 13344.27, "bal-trafalgar-21-11315-pre.txt": 30378.64}
NEAR = 1.001


def run(solver, problem):
    """Costs, CPU and wall seconds after each iteration, and at the end; on one core."""
    command = ["taskset", "--cpu-list", "0", str(SOLVERS[solver]), str(problem)]
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    output = subprocess.run(command, check=True, capture_output=True, text=True, env=environment).stdout
    rows = [line.split() for line in output.splitlines()]
    steps = [tuple(map(float, row)) for row in rows if row[0] != "end"]
    return steps, tuple(map(float, rows[-1][1:]))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("problems", nargs="*", type=Path)
    arguments = parser.parse_args()
    problems = arguments.problems or [DATA / name for name in BEST]
    print("| problem | solver | to 0.1 % (CPU s) | steps | to its own stop (CPU s) | (wall s) | steps | cost there |")
    print("|---|---|---|---|---|---|---|---|")
    for problem in problems:
        runs = {solver: [] for solver in SOLVERS}
        for _ in range(arguments.repeat):
            for solver, measured in runs.items():
                measured.append(run(solver, problem))
        best = BEST.get(problem.name) or min(end[0] for all_runs in runs.values() for _, end in all_runs)
        for solver, measured in runs.items():
            near = [next((i, s) for i, s in enumerate(steps, 1) if s[0] <= NEAR * best) for steps, _ in measured]
            median = lambda numbers: f"{statistics.median(numbers):.3f}"
            cells = [
                problem.name.removeprefix("bal-").removesuffix("-pre.txt"),
                solver,
                median(s[1] for _, s in near),
                str(near[0][0]),
                median(end[1] for _, end in measured),
                median(end[2] for _, end in measured),
                str(len(measured[0][0])),
                f"{measured[0][1][0]:.2f}",
            ]
            print("| " + " | ".join(cells) + " |", flush=True)


main()
