"""Measures the groups beside their peers: accuracy, nanoseconds, instructions; see README.md."""

from __future__ import annotations

import argparse
import datetime
import json
import os
import re
import subprocess
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict
from hashlib import sha256
from pathlib import Path
from shutil import which
from typing import Any

import numpy as np

import accuracy
import libraries
import report
from inputs import GROUPS, SCALARS, Array, Rows, accuracy_rows, speed_rows
from libraries import HERE, Library, Unavailable
from truth import truth

COUNTED = "boxplus_group_peers::sweep_counted", "sweep_counted"  # in Rust, in C++


class Bench:
    """A folder of inputs, and what is read off the libraries run on it."""

    def __init__(self, rows: dict[tuple[str, str], Rows], folder: Path) -> None:
        self.rows = rows
        self.inputs = folder / "inputs"
        self.inputs.mkdir(parents=True)
        for (group, scalar), r in rows.items():
            r.write(self.inputs / f"{group}.{scalar}")

    def results(self, library: Library) -> dict[str, Array]:
        """All results of a library by `GROUP.SCALAR.OPERATION`, a row per input. A driver that crashes has none."""
        with tempfile.TemporaryDirectory() as outputs:
            _run(*library.command, "eval", self.inputs, outputs)
            return {
                path.name: np.fromfile(path, dtype="<f8").reshape(len(self._of(path.name).tau), -1)
                for path in sorted(Path(outputs).iterdir())
                if path.stat().st_size
            }

    def _of(self, name: str) -> Rows:
        group, scalar, _ = name.split(".")
        return self.rows[group, scalar]

    def nanoseconds(self, library: Library) -> dict[str, tuple[float, float]]:
        """Least and median of each operation, in one process."""
        lines = _run(*library.command, "time", self.inputs).splitlines()
        return {name: (float(least), float(median)) for name, least, median in map(str.split, lines)}

    def instructions(self, library: Library) -> dict[str, float]:
        """Instructions per call, those of an empty loop taken off. The same on every machine, but for its libm."""
        with tempfile.TemporaryDirectory() as scratch:
            out = Path(scratch) / "callgrind"
            events = [f"--{when}={name}" for name in COUNTED for when in ("zero-before", "dump-after")]
            command = ("valgrind", "--tool=callgrind", *events, f"--callgrind-out-file={out}")
            lines = _run(*command, *library.command, "count", self.inputs).splitlines()
            counts = {}
            for k, (name, calls) in enumerate(map(str.split, lines), start=1):
                dump = Path(f"{out}.{k}").read_text(encoding="utf-8")
                counts[name] = int(dump.split("totals: ", 1)[1].split()[0]) / int(calls)
        return {name: count - counts[name.rsplit(".", 1)[0] + ".empty"] for name, count in counts.items()}


def _run(*command: str | Path) -> str:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise Unavailable(f"{Path(command[0]).name} ended with {done.returncode}: {done.stderr.strip()[-300:]}")
    return done.stdout


def truths(rows: dict[tuple[str, str], Rows]) -> dict[tuple[str, str], dict[str, Array]]:
    """The truth of all inputs, kept on disk until the inputs or the formulas change."""
    found, missing = {}, {}
    formulas = (HERE / "truth.py").read_bytes()
    for key, r in rows.items():
        numbers = b"".join(column.tobytes() for column in (r.tau, r.point, r.a, r.b))
        path = libraries.BUILD / "truth" / f"{'.'.join(key)}.{sha256(formulas + numbers).hexdigest()[:16]}.npz"
        if path.exists():
            with np.load(path) as stored:
                found[key] = dict(stored)
        else:
            missing[key] = path
    if missing:
        print(f"computing the truth of {len(missing)} tables, some minutes …", file=sys.stderr)
    with ProcessPoolExecutor() as pool:
        computed = pool.map(truth, [GROUPS[group] for group, _ in missing], [rows[key] for key in missing])
        for (key, path), values in zip(missing.items(), computed, strict=True):
            path.parent.mkdir(parents=True, exist_ok=True)
            np.savez(path, **values)
            found[key] = values
    return found


def measure_accuracy(ready: dict[str, Library], scratch: Path) -> dict[str, dict[str, Any]]:
    """The worst error of each operation, by `GROUP.SCALAR.OPERATION` and library."""
    rows = {(g, s): accuracy_rows(GROUPS[g], s) for g in GROUPS for s in SCALARS}
    exact = truths(rows)
    bench = Bench(rows, scratch / "accuracy")
    errors: dict[str, dict[str, Any]] = {}
    for key, library in ready.items():
        for name, computed in bench.results(library).items():
            group, scalar, operation = name.split(".")
            if operation in exact[group, scalar]:
                one = (GROUPS[group], operation, rows[group, scalar], computed, exact[group, scalar][operation], scalar)
                errors.setdefault(name, {})[key] = asdict(accuracy.worst(*one))
    return errors


def measure_speed(
    ready: dict[str, Library], scratch: Path, rounds: int, core: int, counted: bool
) -> dict[str, dict[str, Any]]:
    """Nanoseconds, instructions and the difference to our results, by operation and library."""
    bench = Bench({(g, s): speed_rows(GROUPS[g], s) for g in GROUPS for s in SCALARS}, scratch / "speed")
    cells: dict[str, dict[str, Any]] = {}
    ours = bench.results(ready["boxplus"])
    scalar = {key: library for key, library in ready.items() if library.scalar}
    for key, library in ready.items():
        for name, computed in bench.results(library).items():
            differs = difference(ours[name.removesuffix("_batch")], computed)
            cells.setdefault(name, {})[key] = {"differs": differs, "least": [], "median": []}
    if counted and which("valgrind"):  # which knows no AVX-512
        for key, library in scalar.items():
            for name, count in bench.instructions(library).items():
                if name in cells:
                    cells[name][key]["instructions"] = count
    os.sched_setaffinity(0, {core})
    for turn in range(rounds):
        print(f"round {turn + 1} of {rounds} …", file=sys.stderr)
        for key, library in ready.items():
            if not library.scalar and turn > 1:
                continue  # batches are long enough
            for name, (least, median) in bench.nanoseconds(library).items():
                if name in cells and key in cells[name]:
                    cells[name][key]["least"].append(least)
                    cells[name][key]["median"].append(median)
    return cells


def difference(ours: Array, theirs: Array) -> float:
    """The largest difference of two rows over the norm of ours; of two signs of a quaternion, the nearer."""
    scale = np.linalg.norm(ours, axis=1) + 1e-300
    flipped = theirs.copy()
    flipped[:, :4] *= -1
    errors = [np.linalg.norm(ours - t, axis=1) / scale for t in (theirs, flipped)]
    return float(np.nan_to_num(np.minimum(*errors), nan=np.inf).max())


def machine() -> dict[str, str]:
    """What the figures depend on."""
    info = Path("/proc/cpuinfo").read_text(encoding="utf-8") if Path("/proc/cpuinfo").exists() else ""
    model = next((line.split(":", 1)[1].strip() for line in info.splitlines() if line.startswith("model name")), "?")
    tools = {"rustc": "--version", "g++": "-dumpfullversion", "valgrind": "--version"}
    outputs = {tool: _run(tool, flag) for tool, flag in tools.items() if which(tool)}
    found = {tool: f"{tool} {re.search(r'[0-9.]+', text)[0]}" for tool, text in outputs.items()}
    return {"date": datetime.date.today().isoformat(), "cpu": model, "cores": f"{os.cpu_count()} cores", **found}


def arguments() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(prog="run", description=__doc__)
    parser.add_argument("--only", nargs="+", choices=libraries.KEYS, metavar="LIBRARY", help=" ".join(libraries.KEYS))
    parser.add_argument("--rounds", type=int, default=5, help="of timing, libraries interleaved (default: 5)")
    parser.add_argument("--skip", nargs="+", choices=("accuracy", "speed"), default=(), help="leave out a part")
    parser.add_argument("--native", action="store_true", help="time all compiled for this machine, beside the rest")
    parser.add_argument("--core", type=int, help="the core to time on (default: the last one allowed)")
    parser.add_argument("--results", type=Path, default=HERE / "results.json", help="every figure")
    parser.add_argument("--docs", type=Path, help="write the tables into the documents of this folder")
    return parser.parse_args()


def install(keys: list[str], native: bool) -> tuple[dict[str, Library], dict[str, str]]:
    """The libraries that can run, and why the others cannot."""
    ready, missing = {}, {}
    for key in keys:
        print(f"preparing {key} …", file=sys.stderr)
        try:
            ready[key] = libraries.prepare(key, native)
        except Unavailable as reason:
            missing[key] = str(reason)
            print(f"  {key} is not available: {reason}", file=sys.stderr)
    return ready, missing


def main() -> None:
    """Install, measure, report."""
    options = arguments()
    keys = [key for key in libraries.KEYS if key in ("boxplus", *(options.only or libraries.KEYS))]
    ready, missing = install(keys, options.native)
    if "boxplus" not in ready:
        raise SystemExit(missing["boxplus"])
    core = max(os.sched_getaffinity(0)) if options.core is None else options.core
    stored = json.loads(options.results.read_text(encoding="utf-8")) if options.results.exists() else {}
    with tempfile.TemporaryDirectory() as scratch:
        if "accuracy" not in options.skip and not options.native:
            stored["accuracy"] = measure_accuracy(ready, Path(scratch))
        if "speed" not in options.skip:
            part = "native" if options.native else "speed"
            stored[part] = measure_speed(ready, Path(scratch), options.rounds, core, counted=not options.native)
    if not options.native:
        versions = {key: library.version for key, library in ready.items()}
        stored |= {"machine": machine(), "versions": versions, "missing": missing}
    options.results.write_text(json.dumps(stored, indent=1), encoding="utf-8")
    report.write(stored, options.docs)


if __name__ == "__main__":
    main()
