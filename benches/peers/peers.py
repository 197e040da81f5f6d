"""The solvers: how each is installed or built, and the methods of each that are measured."""

from __future__ import annotations

import importlib.metadata
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent
REPOSITORY = HERE.parents[1]
DRIVERS = HERE / "drivers"
BUILD = HERE / "build"


class Unavailable(Exception):
    """A solver could not be installed or built."""


@dataclass(frozen=True)
class Solver:
    """A solver ready to run: its version and how its driver is called."""

    version: str
    command: tuple[str, ...]


@dataclass(frozen=True)
class Method:
    """One algorithm of one solver.

    ``objective`` names the cost it minimises, a key of `score.costs`. A method that ``traces`` reports its state after
    each iteration; any other is run again with a limit on the iterations. The ``standard`` methods are measured unless
    others are asked for. ``dims`` are the dimensions it is meant for.
    """

    key: str
    label: str
    solver: str
    objective: str
    argument: str
    traces: bool = True
    standard: bool = True
    dims: tuple[int, ...] = (2, 3)


METHODS = (
    Method("boxplus", "boxplus", "boxplus", "log", "auto", traces=False),
    Method("boxplus-file", "boxplus, start of the file", "boxplus", "log", "file", traces=False),
    Method("gtsam-lm", "GTSAM LM, MULTIFRONTAL_CHOLESKY (default)", "gtsam", "log", "lm"),
    Method("gtsam-lm-solver", "GTSAM LM, MULTIFRONTAL_SOLVER", "gtsam", "log", "lm+solver"),
    Method("gtsam-lm-metis", "GTSAM LM, METIS ordering", "gtsam", "log", "lm+metis", standard=False),
    Method("gtsam-gn-metis", "GTSAM GN, METIS ordering", "gtsam", "log", "gn+metis", standard=False),
    Method("gtsam-gn", "GTSAM GN", "gtsam", "log", "gn", standard=False),
    Method("gtsam-gn-solver", "GTSAM GN, MULTIFRONTAL_SOLVER", "gtsam", "log", "gn+solver", standard=False),
    Method("gtsam-dogleg", "GTSAM dogleg", "gtsam", "log", "dogleg", standard=False),
    Method("gtsam-chordal", "GTSAM chordal start + LM", "gtsam", "log", "init+lm", dims=(3,)),
    Method("gtsam-lago", "GTSAM LAGO start + LM", "gtsam", "log", "init+lm", dims=(2,)),
    Method("g2o-lm", "g2o LM", "g2o", "g2o", "lm", traces=False),
    Method("g2o-gn", "g2o GN", "g2o", "g2o", "gn", traces=False, standard=False),
    Method("g2o-dogleg", "g2o dogleg", "g2o", "g2o", "dogleg", traces=False, standard=False),
    Method("ceres-lm", "Ceres LM (default)", "ceres", "ceres", "lm"),
    Method("ceres-dogleg", "Ceres dogleg", "ceres", "ceres", "dogleg"),
    Method("factrs-lm", "factrs LM", "factrs", "log", "lm"),
    Method("factrs-gn", "factrs GN", "factrs", "log", "gn", standard=False),
    Method("tiny-lm", "tiny-solver LM", "tiny-solver", "g2o", "lm", traces=False),
    Method("tiny-gn", "tiny-solver GN", "tiny-solver", "g2o", "gn", traces=False, standard=False),
    Method("apex-lm", "apex-solver LM (default)", "apex-solver", "log", "lm"),
    Method("apex-gn", "apex-solver GN", "apex-solver", "log", "gn", standard=False),
    Method("apex-dogleg", "apex-solver dogleg", "apex-solver", "log", "dogleg", standard=False),
)


def prepare(name: str) -> Solver:
    """Install or build a solver. Raises `Unavailable` with the reason where that fails."""
    return _PREPARE[name]()


def _call(*command: str | Path, cwd: Path = HERE) -> str:
    """The standard output of a command that must succeed."""
    try:
        done = subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False)
    except OSError as error:
        raise Unavailable(f"{command[0]}: {error.strerror}") from error
    if done.returncode:
        lines = [line for line in (done.stderr or done.stdout).splitlines() if line.strip()]
        reason = next((line for line in lines if "error" in line.lower()), lines[-1] if lines else "no message")
        raise Unavailable(f"{Path(command[0]).name} failed: {reason.strip()[:200]}")
    return done.stdout


def _wheel(package: str, version: str, driver: str) -> Callable[[], Solver]:
    """A solver from PyPI."""

    def install() -> Solver:
        pip = (sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check")
        # NumPy is named again so that no wheel moves it.
        _call(*pip, f"{package}=={version}", f"numpy=={importlib.metadata.version('numpy')}")
        return Solver(f"{package} {version} (PyPI)", (sys.executable, str(DRIVERS / driver)))

    return install


def _crate(package: str, binary: str) -> Callable[[], Solver]:
    """A solver in Rust, with our driver."""

    def build() -> Solver:
        _call("cargo", "build", "--release", "--features", package, "--bin", binary)
        target = Path(os.environ.get("CARGO_TARGET_DIR", HERE / "target"))
        lock = (HERE / "Cargo.lock").read_text(encoding="utf-8")
        version = lock.split(f'name = "{package}"\nversion = "', 1)[1].split('"', 1)[0]
        origin = "this repository" if package == "boxplus" else "crates.io"
        return Solver(f"{package} {version} ({origin})", (str(target / "release" / binary),))

    return build


def _ceres() -> Solver:
    """Ceres from Debian, whose wheel `pyceres` has no pose-graph factor; OpenBLAS is the fastest BLAS there."""
    if not Path("/usr/include/ceres/ceres.h").exists():
        sudo = () if os.geteuid() == 0 else ("sudo", "-n")
        _call(*sudo, "apt-get", "install", "--yes", "libceres-dev", "libopenblas0-serial")
    BUILD.mkdir(exist_ok=True)
    binary = BUILD / "ceres_driver"
    flags = ("-std=c++17", "-O3", "-DNDEBUG", "-I/usr/include/eigen3")
    _call("g++", *flags, HERE / "ceres" / "pose_graph.cpp", "-o", binary, "-lceres", "-lglog")
    libraries = dict(line.split(" => ", 1) for line in _call("ldd", binary).splitlines() if " => " in line)
    blas = next((path.split()[0] for name, path in libraries.items() if name.strip().startswith("libblas")), "")
    version = _call(binary, "--version").strip()
    return Solver(f"Ceres {version} (Debian; SuiteSparse with {Path(blas).resolve()})", (str(binary),))


_PREPARE: dict[str, Callable[[], Solver]] = {
    "boxplus": _crate("boxplus", "boxplus_driver"),
    "gtsam": _wheel("gtsam", "4.3.0", "gtsam_driver.py"),
    "g2o": _wheel("g2o-python", "0.0.12", "g2o_driver.py"),
    "ceres": _ceres,
    "factrs": _crate("factrs", "factrs_driver"),
    "tiny-solver": _crate("tiny-solver", "tiny_driver"),
    "apex-solver": _crate("apex-solver", "apex_driver"),
}
