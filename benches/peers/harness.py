"""Measures the time each solver takes to a cost within 0.1 % of the optimum, side by side; see README.md."""

from __future__ import annotations

import argparse
import datetime
import json
import os
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

import peers
import score
from peers import Method, Solver, Unavailable

DATASETS = ("M3500", "sphere2500", "parking-garage", "torus3D")
GOAL = 1e-3  # relative, above the optimum
POOLS = ("OMP_NUM", "OPENBLAS_NUM", "MKL_NUM", "RAYON_NUM", "VECLIB_NUM", "NUMEXPR_NUM", "PEERS")


@dataclass(frozen=True)
class Record:
    """A state of a solver, and the seconds from the call of the optimiser until it was reached."""

    iteration: int
    cpu: float
    wall: float
    poses: score.Array


@dataclass(frozen=True)
class Run:
    """One run of a solver: how it ended, its recorded states (the last is its result), the seconds to its end."""

    status: str
    records: list[Record] = field(default_factory=list)
    cpu: float = float("nan")
    wall: float = float("nan")
    peak: int = 0  # bytes of memory above those at the call of the optimiser


@dataclass
class Measurement:
    """All repetitions of one method on one graph."""

    status: str = ""
    iteration: int | None = None  # of the first state within the goal
    above: float = float("nan")  # final cost, relative, above the optimum
    cpu_to_goal: list[float] = field(default_factory=list)
    wall_to_goal: list[float] = field(default_factory=list)
    cpu_total: list[float] = field(default_factory=list)
    wall_total: list[float] = field(default_factory=list)
    peak: list[float] = field(default_factory=list)  # bytes


class Bench:
    """A graph, written where the solvers read it, and what is needed to run and score them on it."""

    def __init__(self, name: str, source: Path, folder: Path, timeout: float, threads: int = 1) -> None:
        if name not in score.OPTIMA:
            raise SystemExit(f"{name}: no known optimum; known are {', '.join(score.OPTIMA)}")
        self.name = name
        self.graph = score.read_g2o(source)
        self.path = folder / f"{name}.g2o"
        self._output = folder / "output"
        self._timeout = timeout
        self._environment = os.environ | {f"{pool}_THREADS": str(threads) for pool in POOLS}
        score.write_g2o(self.graph, self.path)

    def above(self, record: Record, objective: str) -> float:
        """The cost of a state relative to the optimum, less one."""
        return score.costs(self.graph, record.poses)[objective] / score.OPTIMA[self.name][objective] - 1

    def run(self, solver: Solver, method: Method, iterations: int | None = None) -> Run:
        """Run a solver once, with its own limit on the iterations or the one given."""
        self._output.unlink(missing_ok=True)
        try:
            return self._driver(solver, method, iterations)
        except subprocess.TimeoutExpired:
            return Run(f"timeout after {self._timeout:g} s")
        except (OSError, ValueError, KeyError) as error:
            return Run(f"unreadable output: {error!r}")

    def _process(self, command: list[str]) -> subprocess.CompletedProcess[str]:
        """A finished process."""
        # Wall time is limited: under RLIMIT_CPU Linux advances a process's CPU clock only at ticks, of 4 ms here.
        return subprocess.run(
            command,
            capture_output=True,
            text=True,
            timeout=self._timeout,
            env=self._environment,
            check=False,
        )

    def _driver(self, solver: Solver, method: Method, iterations: int | None) -> Run:
        """Call a driver, whose protocol drivers/record.py describes."""
        limit = [] if iterations is None else [str(iterations)]
        done = self._process([*solver.command, str(self.path), method.argument, str(self._output), *limit])
        if not done.stdout.startswith("{"):
            return Run(_crash(done))
        report = json.loads(done.stdout)
        states = np.fromfile(self._output, dtype="<f8").reshape(-1, *self.graph.poses.shape)
        pairs = zip(report["records"], states, strict=True)
        records = [Record(iteration, cpu, wall, state) for (iteration, cpu, wall), state in pairs]
        return Run(report["status"], records, *report["total"], report["peak"])


def _crash(done: subprocess.CompletedProcess[str]) -> str:
    """What to say of a process that printed no report."""
    lines = done.stderr.strip().splitlines()
    return f"exit code {done.returncode}: {lines[-1][:160] if lines else 'no message'}"


def smallest(reaches: Callable[[int], bool], first: int, limit: int) -> int | None:
    """The least k in first … limit that reaches, if all after one that reaches do; by doubling, then halving."""
    low, high = first - 1, max(first, 1)
    while not reaches(high):
        if high >= limit:
            return None
        low, high = high, min(2 * high, limit)
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if reaches(middle) else (middle, high)
    return high


def measure(bench: Bench, solver: Solver, method: Method, so_far: Measurement) -> None:
    """Add one repetition. A method that did not reach the goal in its first is not repeated."""
    first = not so_far.status
    if not first and so_far.iteration is None:
        return
    run = bench.run(solver, method)
    reached: Record | None = None
    if first:
        so_far.status = run.status
        so_far.above = bench.above(run.records[-1], method.objective) if run.records else float("nan")
    so_far.cpu_total.append(run.cpu)
    so_far.wall_total.append(run.wall)
    so_far.peak.append(run.peak)
    if method.traces:
        reached = next((r for r in run.records if bench.above(r, method.objective) <= GOAL), None)
        so_far.iteration = reached.iteration if reached else None
    elif so_far.above <= GOAL:
        reached = _stepped(bench, solver, method, so_far)
    if reached:
        so_far.cpu_to_goal.append(reached.cpu)
        so_far.wall_to_goal.append(reached.wall)


def _stepped(bench: Bench, solver: Solver, method: Method, so_far: Measurement) -> Record | None:
    """The state after the fewest iterations that lead within the goal, from a run that stops there."""

    def within(iterations: int) -> Record | None:
        records = bench.run(solver, method, iterations).records
        return records[-1] if records and bench.above(records[-1], method.objective) <= GOAL else None

    if so_far.iteration is None:
        first = 0 if method.solver == "boxplus" else 1
        so_far.iteration = smallest(lambda k: within(k) is not None, first, limit=1000)
    return None if so_far.iteration is None else within(so_far.iteration)


Results = dict[str, dict[str, Measurement]]  # by graph, by method


def tables(results: Results, methods: dict[str, Method], missing: dict[str, str], threads: int = 1) -> str:
    """Summaries of time and memory and one table a graph, in Markdown."""
    clock = "CPU" if threads == 1 else "Wall-clock"
    lines = [f"{clock} seconds (median) to a cost within {GOAL:.1%} of the optimum:", ""]
    lines += _overview(results, methods, lambda m: _summary(m, m.cpu_to_goal if threads == 1 else m.wall_to_goal))
    lines += [f"| {name} | {' | '.join(['not installed'] * len(results))} |" for name in missing]
    lines += ["", "Memory: MB of growth (median) from the call of the optimiser to its own stop:", ""]
    lines += _overview(results, methods, lambda m: f"{_median(m.peak) / 1e6:.1f}" if np.isfinite(m.above) else "–")
    for graph, measured in results.items():
        lines += ["", f"**{graph}**", "", _HEADER, "|---" * _HEADER.count(" | ") + "|---|"]
        order = sorted(measured, key=lambda key: (_median(measured[key].cpu_to_goal), measured[key].above))
        lines += [_row(methods[key], measured[key]) for key in order]
    if missing:
        lines += ["", *(f"- {name} is not installed: {reason}" for name, reason in missing.items())]
    return "\n".join(lines)


_HEADER = (
    "| solver | minimises | CPU s to 0.1 %: median (min) | wall s | iteration "
    "| CPU s to its own stop: median (min) | wall s | final cost above the optimum | ended |"
)


def _overview(results: Results, methods: dict[str, Method], cell: Callable[[Measurement], str]) -> list[str]:
    lines = [f"| solver | {' | '.join(results)} |", "|---" * (1 + len(results)) + "|"]
    for key, method in methods.items():
        measured = [results[graph].get(key) for graph in results]
        lines.append(f"| {method.label} | {' | '.join('–' if m is None else cell(m) for m in measured)} |")
    return lines


def _summary(measurement: Measurement, to_goal: list[float]) -> str:
    if to_goal:
        return f"{_median(to_goal):.4f}"
    return "did not reach" if np.isfinite(measurement.above) else measurement.status.split(":")[0]


def _row(method: Method, m: Measurement) -> str:
    iteration = "did not reach" if m.iteration is None else str(m.iteration)
    cells = [method.label, method.objective, _timing(m.cpu_to_goal), f"{_median(m.wall_to_goal):.4f}", iteration]
    cells += [_timing(m.cpu_total), f"{_median(m.wall_total):.4f}", f"{m.above:.1e}", m.status]
    return "| " + " | ".join(cell.replace("|", "/") for cell in cells).replace("inf", "–").replace("nan", "–") + " |"


def _timing(seconds: list[float]) -> str:
    return f"{_median(seconds):.4f} ({min(seconds):.4f})" if np.isfinite(seconds).any() else "–"


def _median(seconds: list[float]) -> float:
    return statistics.median(seconds) if seconds else float("inf")


def machine() -> dict[str, str]:
    """What the figures depend on."""
    info = Path("/proc/cpuinfo").read_text(encoding="utf-8") if Path("/proc/cpuinfo").exists() else ""
    model = next((line.split(":", 1)[1].strip() for line in info.splitlines() if line.startswith("model name")), "?")
    rustc = subprocess.run(["rustc", "--version"], capture_output=True, text=True, check=False).stdout.strip()
    return {
        "date": datetime.date.today().isoformat(),
        "cpu": model,
        "cores": str(os.cpu_count()),
        "rustc": rustc,
        "python": sys.version.split()[0],
    }


def arguments() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(prog="run", description=__doc__)
    keys = [method.key for method in peers.METHODS]
    parser.add_argument("datasets", nargs="*", default=DATASETS, help=f"default: {' '.join(DATASETS)}")
    parser.add_argument("--repeat", type=int, default=5, metavar="N", help="repetitions, interleaved (default: 5)")
    parser.add_argument("--only", nargs="+", choices=keys, metavar="METHOD", help=f"of {' '.join(keys)}")
    parser.add_argument("--all", action="store_true", help="measure every method, not the standard ones alone")
    parser.add_argument("--timeout", type=float, default=120.0, help="wall seconds for one run (default: 120)")
    parser.add_argument("--threads", type=int, default=1, metavar="N", help="threads, a core for each (default: 1)")
    parser.add_argument("--results", type=Path, default=peers.HERE / "results.json")
    return parser.parse_args()


def data_folder() -> Path:
    """$BOXPLUS_DATA, or `shared/data` beside the repository."""
    given = os.environ.get("BOXPLUS_DATA")
    folder = (Path(given) if given else peers.REPOSITORY.parent / "shared" / "data") / "pose-graph"
    if not folder.is_dir():
        raise SystemExit(f"{folder} is no folder; set BOXPLUS_DATA to the folder that holds `pose-graph`")
    return folder


def dataset(folder: Path, name: str) -> Path:
    """The file of a pose graph, plain or gzip."""
    for path in (folder / f"{name}.g2o", folder / f"{name}.g2o.gz"):
        if path.exists():
            return path
    raise SystemExit(f"{folder} has no {name}.g2o")


def install(methods: dict[str, Method]) -> tuple[dict[str, Solver], dict[str, str]]:
    """The solvers that can run, and why the others cannot."""
    solvers: dict[str, Solver] = {}
    missing: dict[str, str] = {}
    for name in dict.fromkeys(method.solver for method in methods.values()):
        print(f"preparing {name} …", file=sys.stderr)
        try:
            solvers[name] = peers.prepare(name)
        except Unavailable as reason:
            missing[name] = str(reason)
            print(f"  {name} is not available: {reason}", file=sys.stderr)
    return solvers, missing


def main() -> None:
    """Install, measure, report."""
    options = arguments()
    chosen = options.only or [m.key for m in peers.METHODS if m.standard or options.all]
    methods = {method.key: method for method in peers.METHODS if method.key in chosen}
    folder = data_folder()
    solvers, missing = install(methods)
    methods = {key: method for key, method in methods.items() if method.solver in solvers}
    os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[-options.threads :])
    results: Results = {}
    with tempfile.TemporaryDirectory() as scratch:
        benches = [
            Bench(n, dataset(folder, n), Path(scratch), options.timeout, options.threads) for n in options.datasets
        ]
        for repetition in range(options.repeat):
            for bench in benches:
                measured = results.setdefault(bench.name, {})
                for key, method in methods.items():
                    if bench.graph.dim in method.dims:
                        print(f"{repetition + 1}/{options.repeat} {bench.name} {key}", file=sys.stderr)
                        measure(bench, solvers[method.solver], method, measured.setdefault(key, Measurement()))
    versions = {name: solver.version for name, solver in solvers.items()}
    context = machine()
    report = {
        "machine": context,
        "versions": versions,
        "missing": missing,
        "goal": GOAL,
        "results": {graph: {k: asdict(m) for k, m in measured.items()} for graph, measured in results.items()},
    }
    options.results.write_text(json.dumps(report, indent=1), encoding="utf-8")
    print(f"{context['date']}, {context['cpu']} ({context['cores']} cores, {options.threads} used), ", end="")
    print(f"{options.repeat} interleaved repetitions, {context['rustc']}, Python {context['python']}; ", end="")
    print(", ".join(versions.values()) + ".\n")
    print(tables(results, methods, missing, options.threads))


if __name__ == "__main__":
    main()
