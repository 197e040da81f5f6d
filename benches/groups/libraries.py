"""The libraries: how each is installed or built, and how its driver is called."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent
BUILD = HERE / "build"
SOURCES = Path(os.environ.get("BOXPLUS_PEER_SOURCES", HERE / "sources"))


class Unavailable(Exception):
    """A library could not be installed or built."""


@dataclass(frozen=True)
class Library:
    """A library ready to run. A ``scalar`` one is timed call by call, by compiled code that callgrind can count."""

    label: str
    version: str
    command: tuple[str, ...]
    scalar: bool = True


def prepare(key: str, native: bool = False) -> Library:
    """Install or build a library, for any x86-64 or for this machine. Raises `Unavailable` where that fails."""
    return _PREPARE[key](native)


def _call(*command: str | Path, **environment: str) -> str:
    """The standard output of a command that must succeed."""
    try:
        env = os.environ | environment
        done = subprocess.run(command, cwd=HERE, env=env, capture_output=True, text=True, check=False)
    except OSError as error:
        raise Unavailable(f"{command[0]}: {error.strerror}") from error
    if done.returncode:
        lines = [line for line in (done.stderr or done.stdout).splitlines() if line.strip()]
        reason = next((line for line in lines if "error" in line.lower()), lines[-1] if lines else "no message")
        raise Unavailable(f"{Path(command[0]).name} failed: {reason.strip()[:200]}")
    return done.stdout


def _crate(package: str, binary: str) -> Callable[[bool], Library]:
    """A crate, with our driver."""

    def build(native: bool) -> Library:
        target = HERE / ("target-native" if native else "target")
        flags = "-C target-cpu=native" if native else ""
        cargo = ("cargo", "build", "--release", "--target-dir", target)
        _call(*cargo, "--features", package, "--bin", binary, RUSTFLAGS=flags)
        lock = (HERE / "Cargo.lock").read_text(encoding="utf-8")
        version = lock.rsplit(f'name = "{package}"\nversion = "', 1)[1].split('"', 1)[0]
        return Library(package, version, (str(target / "release" / binary),))

    return build


def _headers(name: str, driver: str, standard: str, *flags: str) -> Callable[[bool], Library]:
    """A C++ library of headers, from a clone; Eigen comes from the system."""

    def build(native: bool) -> Library:
        source = SOURCES / name
        if not source.is_dir():
            raise Unavailable(f"no clone of it in {SOURCES}")
        if not Path("/usr/include/eigen3").is_dir():
            sudo = () if os.geteuid() == 0 else ("sudo", "-n")
            _call(*sudo, "apt-get", "install", "--yes", "libeigen3-dev")
        _smooth_version(source)
        binary = BUILD / (f"{driver}_native" if native else driver)
        code = HERE / "cpp" / f"{driver}.cpp"
        paths = [f"-I{source / flag}" for flag in flags] + ["-I/usr/include/eigen3", f"-I{BUILD / 'include'}"]
        binary.parent.mkdir(parents=True, exist_ok=True)
        if not binary.exists() or binary.stat().st_mtime < max(p.stat().st_mtime for p in code.parent.iterdir()):
            tuned = ("-march=native",) if native else ()
            # fmt is not needed for what Sophus prints when it aborts.
            options = (f"-std={standard}", "-O3", "-DNDEBUG", "-DSOPHUS_USE_BASIC_LOGGING", *tuned, *paths)
            _call("g++", *options, code, "-o", binary)
        return Library(name, _described(source), (str(binary),))

    return build


def _smooth_version(source: Path) -> None:
    """The header that smooth's own build would generate."""
    template = source / "config" / "version.hpp.in"
    if template.exists():
        header = BUILD / "include" / "smooth" / "version.hpp"
        header.parent.mkdir(parents=True, exist_ok=True)
        header.write_text(re.sub(r"@\w+@", "0", template.read_text(encoding="utf-8")), encoding="utf-8")


def _described(source: Path) -> str:
    """The version a clone gives to its build."""
    if (source / "SOPHUS_VERSION").exists():
        return (source / "SOPHUS_VERSION").read_text(encoding="utf-8").strip()
    stated = re.search(r"project\([^)]*VERSION\s+([\d.]+)", (source / "CMakeLists.txt").read_text(encoding="utf-8"))
    return stated[1] if stated else "?"


def _wheel(package: str, version: str, driver: str, *more: str) -> Callable[[bool], Library]:
    """A wheel."""

    def install(native: bool) -> Library:
        if native:
            raise Unavailable("a wheel is built already")
        pip = (sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check")
        _call(*pip, f"{package}=={version}", *more)
        return Library(package, version, (sys.executable, str(HERE / "drivers" / driver)), scalar=False)

    return install


_PREPARE: dict[str, Callable[[bool], Library]] = {
    "boxplus": _crate("boxplus", "boxplus_driver"),
    "nalgebra": _crate("nalgebra", "nalgebra_driver"),
    "glam": _crate("glam", "glam_driver"),
    "sophus_lie": _crate("sophus_lie", "sophus_driver"),
    "factrs": _crate("factrs", "factrs_driver"),
    "apex-manifolds": _crate("apex-manifolds", "apex_driver"),
    "manif": _headers("manif", "manif_driver", "c++17", "include", "external/tl"),
    "Sophus": _headers("Sophus", "sophus_driver", "c++17", "."),
    "smooth": _headers("smooth", "smooth_driver", "c++20", "include"),
    "gtsam": _wheel("gtsam", "4.3.0", "gtsam_driver.py"),
    "jaxlie": _wheel("jaxlie", "1.5.0", "jaxlie_driver.py", "jax==0.7.1"),
    "symforce": _wheel("symforce", "0.12.0", "symforce_driver.py"),
}
KEYS = tuple(_PREPARE)
