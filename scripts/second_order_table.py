#!/usr/bin/env python3
"""Writes crates/boxplus/tests/reference/second_order.csv: D J_r(tau)[delta] to 17 digits, from 80.

J_r(tau) = sum over n of (-ad)^n/(n + 1)!, differentiated term by term; no closed form is used. Needs mpmath.
Tangents are numbers of f32, so that one table serves f32 and f64.
"""

import math
import random
import struct
from pathlib import Path

from mpmath import mp, mpf, matrix, nstr, zeros

mp.dps = 80
TERMS = 90


def skew(v):
    return matrix([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def put(m, i, j, block):
    for r in range(block.rows):
        for c in range(block.cols):
            m[i + r, j + c] = block[r, c]


def so3(t):
    return skew(t)


def se2(t):
    x, y, w = t
    return matrix([[0, -w, y], [w, 0, -x], [0, 0, 0]])


def vectors(t, blocks):
    """Groups of a rotation and vectors turned by it; the rotation stands at 3."""
    n = 3 * blocks
    m = zeros(n, n)
    w = skew(t[3:6])
    for i in range(0, n, 3):
        put(m, i, i, w)
        if i != 3:
            put(m, i, 3, skew(t[i : i + 3]))
    return m


def se3(t):
    return vectors(t, 2)


def se23(t):
    return vectors(t, 3)


def sgal3(t):
    m = zeros(10, 10)
    put(m, 0, 0, vectors(t, 3))
    for i in range(3):
        m[i, 6 + i] = -t[9]
        m[i, 9] = t[6 + i]
    return m


def sim3(t):
    m = zeros(7, 7)
    put(m, 0, 0, vectors(t, 2))
    for i in range(3):
        m[i, i] += t[6]
        m[i, 6] = -t[i]
    return m


def sim2(t):
    x, y, w, s = t
    return matrix([[s, -w, y, -x], [w, s, -x, -y], [0, 0, 0, 0], [0, 0, 0, 0]])


def derivative(a, b):
    term, d_term = mp.eye(a.rows), zeros(a.rows, a.rows)
    total = zeros(a.rows, a.rows)
    for k in range(1, TERMS):
        d_term = -(d_term * a + term * b) / (k + 1)
        term = -term * a / (k + 1)
        total += d_term
    return total


def single(x):
    return struct.unpack("f", struct.pack("f", x))[0]


GROUPS = {
    "so3": (so3, 3, 0, 3),
    "se2": (se2, 3, 2, 1),
    "se3": (se3, 6, 3, 3),
    "se23": (se23, 9, 3, 3),
    "sgal3": (sgal3, 10, 3, 3),
    "sim2": (sim2, 4, 2, 1),
    "sim3": (sim3, 7, 3, 3),
}
ANGLES = [0.0, 1e-9, 1e-4, 0.03, 0.4, 1.0, 2.0, 3.0, math.pi]


def main():
    rng = random.Random(7)
    folder = Path(__file__).parent.parent / "crates/boxplus/tests/reference"
    with open(folder / "second_order.csv", "w") as out:
        out.write("# scripts/second_order_table.py: group, tau, delta, D J_r(tau)[delta] by rows\n")
        for name, (ad, n, at, k) in GROUPS.items():
            for angle in ANGLES:
                tau = [rng.uniform(-2, 2) for _ in range(n)]
                norm = math.sqrt(sum(x * x for x in tau[at : at + k]))
                for i in range(at, at + k):
                    tau[i] *= angle / norm
                tau = [single(x) for x in tau]
                delta = [single(rng.uniform(-1, 1)) for _ in range(n)]
                d = derivative(ad([mpf(x) for x in tau]), ad([mpf(x) for x in delta]))
                entries = [nstr(d[i, j], 17) for i in range(n) for j in range(n)]
                out.write(",".join([name, *map(repr, tau), *map(repr, delta), *entries]) + "\n")


main()
