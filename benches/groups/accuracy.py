"""The worst error of each operation of each library, in units of ε, and where it is."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from inputs import Array, Group, Rows

EPSILON = {"f64": 2.0**-52, "f32": 2.0**-23}


@dataclass(frozen=True)
class Worst:
    """The largest error of one operation, in ε, the angle it is at, and the block of the result that has it."""

    error: float
    theta: float
    block: str


def worst(group: Group, operation: str, rows: Rows, computed: Array, truth: Array, scalar: str) -> Worst:
    """Normwise and block by block, so that a large translation cannot hide a wrong rotation."""
    result = Worst(0.0, float("nan"), "")
    for block, errors in _errors(group, operation, rows, computed, truth):
        errors = np.where(np.isfinite(errors), errors, math.inf) / EPSILON[scalar]
        k = int(errors.argmax())
        if errors[k] > result.error:
            result = Worst(float(errors[k]), float(rows.theta[k]), block)
    return result


def _errors(group: Group, operation: str, rows: Rows, computed: Array, truth: Array) -> list[tuple[str, Array]]:
    """The error of each block over its scale, row by row."""
    if operation in ("jr", "jr_inv", "adjoint"):
        return _matrix_errors(group, computed, truth, _leading(group, operation, rows))
    if operation == "act":
        scale = _largest(*_points(group, rows), truth)
        return [("", _norm(computed - truth) / scale)]
    element = operation in ("exp", "compose")
    sizes = group.element if element else group.tangent
    others = [c for c in group.coordinates if c != "φ"]
    names = ["rotation", *others] if element else list(group.coordinates)
    ends = np.cumsum(sizes)[:-1]
    pairs = zip(names, np.split(computed, ends, axis=1), np.split(truth, ends, axis=1), strict=True)
    return [(name, _block_error(group, operation, rows, name, c, t)) for name, c, t in pairs]


def _block_error(group: Group, operation: str, rows: Rows, name: str, computed: Array, truth: Array) -> Array:
    if name == "rotation":
        if computed.shape[1] == 4:  # both signs are the same rotation
            computed = computed * np.where((computed * truth).sum(axis=1, keepdims=True) < 0, -1, 1)
        return _norm(computed - truth)
    if name == "φ":
        difference = computed - truth
        if computed.shape[1] == 1:
            difference = (difference + math.pi) % (2 * math.pi) - math.pi if operation == "rminus" else difference
        return _norm(difference) / (_norm(truth) if operation == "log" else 1.0)
    if name in "σι":
        return _norm(computed - truth) / np.maximum(1.0, _norm(truth))
    return _norm(computed - truth) / _largest(*_inputs(group, operation, rows, name), truth)


def _inputs(group: Group, operation: str, rows: Rows, name: str) -> list[Array]:
    """What a translation or velocity is computed from, in its own units: rounding of these is nobody's fault."""
    if operation == "exp":
        tangent = dict(zip(group.coordinates, np.split(rows.tau, np.cumsum(group.tangent)[:-1], axis=1), strict=True))
        scales = [tangent[name]]
        return [*scales, tangent["ν"] * tangent["ι"]] if name == "ρ" and "ι" in tangent else scales
    a, b = _parts(group, rows.a), _parts(group, rows.b)
    if operation == "log":
        return [a[name], *([a["ν"] * a["ι"]] if name == "ρ" and "ι" in a else [])]
    if operation == "compose":
        scales = [a[name], b[name] * np.exp(a.get("σ", 0.0))]
        return [*scales, a["ν"] * b["ι"]] if name == "ρ" and "ι" in a else scales
    back = np.exp(-a["σ"]) if "σ" in a else 1.0
    scales = [a[name] * back, b[name] * back]
    return [*scales, a["ν"] * a["ι"], a["ν"] * b["ι"], b["ν"] * b["ι"]] if name == "ρ" and "ι" in a else scales


def _points(group: Group, rows: Rows) -> list[Array]:
    a = _parts(group, rows.a)
    place = rows.point[:, : group.space] * np.exp(a.get("σ", 0.0))
    scales = [place, *([a["ρ"]] if "ρ" in a else [])]
    return [*scales, a["ν"] * rows.point[:, -1:]] if "ι" in a else scales


def _parts(group: Group, rows: Array) -> dict[str, Array]:
    names = ["rotation", *(c for c in group.coordinates if c != "φ")]
    return dict(zip(names, np.split(rows, np.cumsum(group.element)[:-1], axis=1), strict=True))


def _leading(group: Group, operation: str, rows: Rows) -> Array:
    """What the block ρφ of Ad is at least relative to: (p − vt)^R may cancel."""
    if operation != "adjoint" or "ι" not in group.coordinates:
        return np.zeros(len(rows.a))
    a = _parts(group, rows.a)
    return math.sqrt(2) * _largest(a["ρ"], a["ν"] * a["ι"])


def _matrix_errors(group: Group, computed: Array, truth: Array, leading: Array) -> list[tuple[str, Array]]:
    """Each block over its own norm, or over the norm of the whole where it is zero."""
    d = sum(group.tangent)
    starts = np.concatenate([[0], np.cumsum(group.tangent)])
    c, t = computed.reshape(-1, d, d), truth.reshape(-1, d, d)
    whole = _norm(truth)
    found = []
    for i, row in enumerate(group.coordinates):
        for j, column in enumerate(group.coordinates):
            block = np.s_[:, starts[i] : starts[i + 1], starts[j] : starts[j + 1]]
            size = _norm(t[block].reshape(len(t), -1))
            # The truth has no exact zeros where it was computed by elimination.
            scale = np.where(size > 1e-50 * whole, size, whole)
            scale = np.maximum(scale, leading) if row + column == "ρφ" else scale
            found.append((row + column, _norm((c[block] - t[block]).reshape(len(t), -1)) / scale))
    return found


def _norm(x: Array) -> Array:
    return np.sqrt((x * x).sum(axis=1))


def _largest(*arrays: Array) -> Array:
    return np.max([_norm(a) for a in arrays], axis=0)
