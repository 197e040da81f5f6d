#!/usr/bin/env python3
"""Coefficients of the polynomials in `lie/elementary.rs`, printed as Rust. Needs mpmath.

Near-minimax by interpolation at Chebyshev nodes, in 60 digits, then rounded to double one by one. What stands beside a
table is the error of the rounded polynomial relative to the function, over the whole interval.
"""
from mpmath import mp, mpf, acos, atan, chebyfit, cos, exp, fabs, factorial, linspace, pi, polyval, sin, sqrt, log

mp.dps = 60


def table(name, function, terms, low, high, approximated):
    """`function` on [low, high] by `terms` coefficients; `approximated(x, p)` rebuilds what the caller computes."""
    # A removable singularity at 0 is left to the interpolation: 0 is no Chebyshev node.
    exact = chebyfit(function, [low, high], terms)
    rounded = [mpf(float(c)) for c in exact]
    error = max(fabs(approximated(x, polyval(rounded, x))) for x in linspace(low + mpf(10) ** -9, high, 500))
    print(f"/// Relative error {float(error):.1e}.")
    print(f"const {name}: [f64; {terms}] = [")
    for c in reversed(rounded):
        print(f"    {float(c)!r},")
    print("];")


def arc(u):
    w = 1 - u
    return acos(w) / sqrt(1 - w * w)


quarter = (pi / 4) ** 2
sine = lambda z: (sin(sqrt(z)) / sqrt(z) - 1) / z
cosine = lambda z: (cos(sqrt(z)) - 1 + z / 2) / z**2
growth = lambda r: (exp(r) - 1 - r) / r**2
excess = lambda u: (arc(u) - 1) / u
half = log(2) / 2
table("SIN", sine, 6, mpf(0), quarter, lambda z, p: (1 + z * p) / (sin(sqrt(z)) / sqrt(z)) - 1)
table("COS", cosine, 6, mpf(0), quarter, lambda z, p: (1 - z / 2 + z * z * p) / cos(sqrt(z)) - 1)
table("EXP", growth, 10, -half, half, lambda r, p: (1 + r + r * r * p) / exp(r) - 1)
table("ARC", excess, 21, mpf(0), mpf(1), lambda u, p: (1 + u * p) / arc(u) - 1)
table("ARC_SINGLE", excess, 10, mpf(0), mpf(1), lambda u, p: (1 + u * p) / arc(u) - 1)
