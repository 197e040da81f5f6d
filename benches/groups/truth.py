"""Every operation to 66 digits (MPFR), by power series and by definition, never by a closed form under test.

All groups are subgroups of one, the matrices [s·R v p; 0 1 t; 0 0 1], so that ^ and its inverse define everything: ad
and Ad column by column, J_l = Σ ad^k/(k + 1)!, Exp = Σ (τ^)^k/k!. Only the logarithm solves, for V = Σ W^k/(k + 1)!.
"""

from __future__ import annotations

import math
from typing import Any

import gmpy2
import numpy as np
from gmpy2 import mpfr
from numpy.typing import NDArray

from inputs import Array, Group, Rows

gmpy2.get_context().precision = 220
Exact = NDArray[Any]  # of mpfr
OPERATIONS = ("exp", "log", "jr", "jr_inv", "adjoint", "compose", "act", "rminus")


def truth(group: Group, rows: Rows) -> dict[str, Array]:
    """The results of each operation, one row each, rounded to f64."""
    numbers = (rows.tau, rows.point, rows.a, rows.b)
    results = [_operations(group, *(_exact(column[i]) for column in numbers)) for i in range(len(rows.tau))]
    return {name: np.array([r[name].ravel() for r in results], dtype=float) for name in OPERATIONS}


def _operations(group: Group, tau: Exact, point: Exact, a: Exact, b: Exact) -> dict[str, Exact]:
    x, y = matrix(group, a), matrix(group, b)
    jr = series(small_adjoint(group, -tau), 1)
    moved = x.dot(np.array([*point, *[mpfr(0)] * (group.space + 1 - len(point)), mpfr(1)]))
    return {
        "exp": element(group, series(hat(group, tau), 0)),
        "log": log(group, x),
        "jr": jr,
        "jr_inv": inverse(jr),
        "adjoint": adjoint(group, x),
        "compose": element(group, x.dot(y)),
        "act": moved[: group.point],
        "rminus": log(group, inverse(x).dot(y)),
    }


def _exact(row: Array) -> Exact:
    return np.array([mpfr(float(x)) for x in row])


def identity(n: int) -> Exact:
    """n×n."""
    return np.array([[mpfr(int(i == j)) for j in range(n)] for i in range(n)])


def inverse(m: Exact) -> Exact:
    """By Gauss and Jordan, largest pivot first."""
    n = len(m)
    both = np.hstack([m, identity(n)])
    for k in range(n):
        pivot = k + int(np.argmax(abs(both[k:, k])))
        both[[k, pivot]] = both[[pivot, k]]
        both[k] = both[k] / both[k, k]
        for i in (i for i in range(n) if i != k):
            both[i] = both[i] - both[i, k] * both[k]
    return both[:, n:]


def series(m: Exact, shift: int) -> Exact:
    """Σ m^k/(k + shift)!."""
    term = identity(len(m)) / math.factorial(shift)
    total, k = term, 1
    while abs(term).max() > abs(total).max() * mpfr(10) ** -65:
        term = term.dot(m) / (k + shift)
        total = total + term
        k += 1
    return total


def _skew(phi: Exact) -> Exact:
    if len(phi) == 1:
        return np.array([[mpfr(0), -phi[0]], [phi[0], mpfr(0)]])
    x, y, z = phi
    return np.array([[mpfr(0), -z, y], [z, mpfr(0), -x], [-y, x, mpfr(0)]])


def hat(group: Group, tau: Exact) -> Exact:
    """τ^ = [φ^ + σI, ν, ρ; 0, 0, ι; 0, 0, 0]."""
    n = group.space
    parts = dict(zip(group.coordinates, np.split(tau, np.cumsum(group.tangent)[:-1]), strict=True))
    m = np.full((n + 2, n + 2), mpfr(0))
    m[:n, :n] = _skew(parts["φ"]) + parts.get("σ", [mpfr(0)])[0] * identity(n)
    m[:n, n] = parts.get("ν", mpfr(0))
    m[:n, n + 1] = parts.get("ρ", mpfr(0))
    m[n, n + 1] = parts.get("ι", [mpfr(0)])[0]
    return m


def vee(group: Group, m: Exact) -> Exact:
    """The inverse of `hat`."""
    n = group.space
    phi = [m[1, 0]] if n == 2 else [m[2, 1], m[0, 2], m[1, 0]]
    parts = {"ρ": m[:n, n + 1], "φ": phi, "ν": m[:n, n], "ι": [m[n, n + 1]], "σ": [m[0, 0]]}
    return np.concatenate([np.array(parts[c]) for c in group.coordinates])


def small_adjoint(group: Group, tau: Exact) -> Exact:
    """ad_τ, by the commutator with each basis vector."""
    t = hat(group, tau)
    basis = [hat(group, e) for e in identity(len(tau))]
    return np.array([vee(group, t.dot(e) - e.dot(t)) for e in basis]).T


def adjoint(group: Group, x: Exact) -> Exact:
    """Ad_X, by conjugation of each basis vector."""
    back = inverse(x)
    return np.array([vee(group, x.dot(hat(group, e)).dot(back)) for e in identity(sum(group.tangent))]).T


def matrix(group: Group, row: Exact) -> Exact:
    """An element as a matrix. The norm of its rotation does not matter."""
    n = group.space
    names = ["rotation", *(c for c in group.coordinates if c != "φ")]
    parts = dict(zip(names, np.split(row, np.cumsum(group.element)[:-1]), strict=True))
    x = identity(n + 2)
    x[:n, :n] = gmpy2.exp(parts.get("σ", [mpfr(0)])[0]) * _rotation(parts["rotation"])
    x[:n, n] = parts.get("ν", mpfr(0))
    x[:n, n + 1] = parts.get("ρ", mpfr(0))
    x[n, n + 1] = parts.get("ι", [mpfr(0)])[0]
    return x


def _rotation(row: Exact) -> Exact:
    norm2 = sum(x * x for x in row)
    if len(row) == 2:
        return np.array([[row[0], -row[1]], [row[1], row[0]]]) / gmpy2.sqrt(norm2)
    v = _skew(row[:3])
    return identity(3) + 2 * (row[3] * v + v.dot(v)) / norm2


def element(group: Group, x: Exact) -> Exact:
    """The inverse of `matrix`."""
    n = group.space
    scale = _scale(group, x)
    r = x[:n, :n] / scale
    rotation = r[:, 0] if n == 2 else _quaternion(r)
    parts = {"ρ": x[:n, n + 1], "ν": x[:n, n], "ι": [x[n, n + 1]], "σ": [gmpy2.log(scale)]}
    return np.concatenate([rotation, *(np.array(parts[c]) for c in group.coordinates if c != "φ")])


def _scale(group: Group, x: Exact) -> mpfr:
    return gmpy2.sqrt(sum(a * a for a in x[: group.space, 0]))


def _quaternion(r: Exact) -> Exact:
    """From the largest of its four products with itself: 4qqᵀ is linear in r."""
    w = [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]]
    trace = r[0, 0] + r[1, 1] + r[2, 2]
    m = np.array([[r[i, j] + r[j, i] for j in range(3)] for i in range(3)]) + (1 - trace) * identity(3)
    products = np.array([*(np.append(m[i], w[i]) for i in range(3)), np.array([*w, 1 + trace])])
    k = max(range(4), key=lambda i: products[i, i])
    q = products[k] / (2 * gmpy2.sqrt(products[k, k]))
    return q if q[3] >= 0 else -q


def log(group: Group, x: Exact) -> Exact:
    """φ by atan2, then v = Vν and p = Vρ + ιΓ₂ν solved for ν and ρ."""
    n = group.space
    scale = _scale(group, x)
    r = x[:n, :n] / scale
    if n == 2:
        phi = np.array([gmpy2.atan2(r[1, 0], r[0, 0])])
    else:
        q = _quaternion(r)
        sine = gmpy2.sqrt(sum(a * a for a in q[:3]))
        phi = q[:3] * (2 * gmpy2.atan2(sine, q[3]) / sine if sine > 0 else 2)
    sigma, iota = (gmpy2.log(scale) if "σ" in group.coordinates else mpfr(0)), x[n, n + 1]
    w = _skew(phi) + sigma * identity(n)
    v_inverse = inverse(series(w, 1))
    nu = v_inverse.dot(x[:n, n])
    rho = v_inverse.dot(x[:n, n + 1] - iota * series(w, 2).dot(nu))
    parts = {"ρ": rho, "φ": phi, "ν": nu, "ι": [iota], "σ": [sigma]}
    return np.concatenate([np.array(parts[c]) for c in group.coordinates])
