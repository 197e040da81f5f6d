#!/usr/bin/env python3
"""Reference tables of rotation coordinates and of the sphere: crates/boxplus/tests/reference/{euler_scipy,coordinates,sphere}.csv

    pip install scipy mpmath && python3 scripts/rotation_tables.py

`euler_scipy.csv` is what scipy.spatial.transform.Rotation answers, all 24 sequences, at gimbal lock and near it.
The two others are true to the last digit: 50-digit arithmetic from the definitions, never the formulas under test.
Their inputs are representable in f32, so that one table serves f32 and f64.
"""
import itertools
import math
import random
import struct
import warnings
from pathlib import Path

from mpmath import matrix, mp, mpf
from scipy.spatial.transform import Rotation

mp.dps = 50
OUT = Path(__file__).resolve().parent.parent / "crates/boxplus/tests/reference"
rng = random.Random(20240912)
LETTERS = ["".join(s) for s in itertools.product("XYZ", repeat=3) if s[0] != s[1] and s[1] != s[2]]
SEQUENCES = LETTERS + [s.lower() for s in LETTERS]


def f32(x):
    """x rounded to the nearest f32."""
    return struct.unpack("f", struct.pack("f", x))[0]


def write(name, header, rows):
    lines = [",".join(header)]
    for row in rows:
        assert len(row) == len(header), (name, len(row), len(header))
        cells = (v if isinstance(v, str) else repr(float(v)).removesuffix(".0") for v in row)
        lines.append(",".join(cells))
    (OUT / name).write_text("\n".join(lines) + "\n")
    print(name, len(rows), "rows", (OUT / name).stat().st_size, "bytes")


# SciPy ----------------------------------------------------------------------------------------------------------------


def scipy_rows():
    rows = []
    for sequence in SEQUENCES:
        proper = sequence[0] == sequence[2]
        locks = [0.0, math.pi] if proper else [-math.pi / 2, math.pi / 2]
        middles = [rng.uniform(0.2, 2.9) if proper else rng.uniform(-1.4, 1.4) for _ in range(3)]
        middles += locks
        middles += [lock + sign * margin for lock, sign in zip(locks, (1, -1)) for margin in (1e-2, 1e-4, 1e-6)]
        for middle in middles:
            angles = [rng.uniform(-3, 3), middle, rng.uniform(-3, 3)]
            rotation = Rotation.from_euler(sequence, angles)
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # SciPy's own report of gimbal lock
                back = rotation.as_euler(sequence)
            rows.append([sequence, *angles, *rotation.as_quat(), *back])
    return rows


# Arbitrary precision --------------------------------------------------------------------------------------------------


def rotation_matrix(q):
    x, y, z, w = q
    n = x * x + y * y + z * z + w * w
    v = matrix([x, y, z])
    hat = matrix([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return (mp.eye(3) * (w * w - x * x - y * y - z * z) + 2 * v * v.T + 2 * w * hat) / n


def axis_matrix(axis, angle):
    c, s = mp.cos(angle), mp.sin(angle)
    i, j = [(1, 2), (2, 0), (0, 1)][axis]
    m = mp.eye(3)
    m[i, i] = m[j, j] = c
    m[i, j], m[j, i] = -s, s
    return m


def euler(r, sequence):
    """Angles of an intrinsic sequence from matrix entries, in plain 50-digit textbook form."""
    axes = ["XYZ".index(a) for a in sequence.upper()]
    if sequence.islower():
        return euler(r, sequence.upper()[::-1])[::-1]
    a, b, c = axes
    if a == c:
        k = 3 - a - b
        sign = 1 if (a + 1) % 3 == b else -1
        middle = mp.acos(r[a, a])
        first = mp.atan2(r[b, a], -sign * r[k, a])
        third = mp.atan2(r[a, b], sign * r[a, k])
    else:
        sign = 1 if (a + 1) % 3 == b else -1
        middle = mp.asin(sign * r[a, c])
        first = mp.atan2(-sign * r[b, c], r[c, c])
        third = mp.atan2(-sign * r[a, b], r[a, a])
    again = axis_matrix(a, first) * axis_matrix(b, middle) * axis_matrix(c, third)
    assert mp.mnorm(again - r, 1) < mpf(10) ** -20, sequence
    return [first, middle, third]


def quaternions():
    """Numerators of quaternions, exact in f32: generic, small, near a half turn, near the identity, near pitch 90 deg."""
    result = []
    for _ in range(10):
        result.append([f32(rng.uniform(-1, 1)) for _ in range(4)])
    for size in (1e-2, 1e-4, 1e-7):
        v = [f32(size * rng.uniform(-1, 1)) for _ in range(3)]
        result += [[*v, 1.0], [*v, -1.0]]
        result.append([f32(rng.uniform(-1, 1)) for _ in range(3)] + [f32(size)])
        result.append([v[0], f32(0.7071 + v[1]), v[2], f32(0.7071)])
    return result


def coordinate_rows():
    rows = []
    for q in quaternions():
        exact = [mpf(c) for c in q]
        n = mp.sqrt(sum(c * c for c in exact))
        x, y, z, w = [c / n for c in exact]
        if w < 0:
            x, y, z, w = -x, -y, -z, -w
        v, theta = [x, y, z], 2 * mp.atan2(mp.sqrt(x * x + y * y + z * z), w)
        axis = [c / mp.sqrt(x * x + y * y + z * z) for c in v]
        gibbs = [a * mp.tan(theta / 2) for a in axis]
        mrp = [a * mp.tan(theta / 4) for a in axis]
        shadow = [a * mp.tan((theta - 2 * mp.pi) / 4) for a in axis]
        r = rotation_matrix(exact)
        angles = [angle for sequence in SEQUENCES for angle in euler(r, sequence)]
        rows.append([*q, theta, *axis, *gibbs, *mrp, *shadow, *angles])
    return rows


# The sphere -----------------------------------------------------------------------------------------------------------


def basis(n):
    """The columns of the shortest rotation from e_z to n, without the third."""
    x, y, z = n
    k = 1 / (1 + z)
    return matrix([[1 - x * x * k, -x * y * k], [-x * y * k, 1 - y * y * k], [-x, -y]])


def normalized(v):
    n = mp.sqrt(sum(c * c for c in v))
    return matrix([c / n for c in v])


def plus(n, tau):
    step, theta = basis(n) * tau, mp.sqrt(tau[0] ** 2 + tau[1] ** 2)
    return n if theta == 0 else n * mp.cos(theta) + step * (mp.sin(theta) / theta)


def minus(m, n):
    c = (n.T * m)[0]
    t = basis(n).T * m
    s = mp.sqrt(t[0] ** 2 + t[1] ** 2)
    return t * (mp.atan2(s, c) / s)


def jacobian(f, columns):
    """Central differences of a vector function of `columns` small numbers, at 50 digits."""
    h = mpf(10) ** -16
    result = []
    for i in range(columns):
        e = matrix([h if i == j else 0 for j in range(columns)])
        difference = (8 * (f(e) - f(-e)) - (f(2 * e) - f(-2 * e))) / (12 * h)
        result.append(list(difference))
    return [result[j][i] for i in range(len(result[0])) for j in range(columns)]  # by rows


def sphere_rows():
    rows, starts = [], []
    for _ in range(5):
        starts.append([f32(rng.uniform(-1, 1)) for _ in range(3)])
    for size in (1e-1, 1e-3, 1e-6):
        starts.append([f32(size * rng.uniform(-1, 1)), f32(size * rng.uniform(-1, 1)), 1.0])
        starts.append([f32(size * rng.uniform(-1, 1)), f32(size * rng.uniform(-1, 1)), -1.0])
    lengths = [1e-9, 1e-5, 1e-2, 0.3, 1.0, 1.6, 2.5, 3.1]
    for k, start in enumerate(starts):
        for length in lengths[k % 2 :: 2]:
            angle = rng.uniform(-3, 3)
            tau = [f32(length * math.cos(angle)), f32(length * math.sin(angle))]
            n, t = normalized([mpf(c) for c in start]), matrix([mpf(c) for c in tau])
            y = plus(n, t)
            d_n = jacobian(lambda u: minus(plus(plus(n, u), t), y), 2)
            d_tau = jacobian(lambda u: minus(plus(n, t + u), y), 2)
            # ⊟ of two directions given exactly, near each other or not.
            other = [f32(c) for c in y]
            m = normalized([mpf(c) for c in other])
            step = minus(m, n)
            e_m = jacobian(lambda u: minus(plus(m, u), n), 2)
            e_n = jacobian(lambda u: minus(m, plus(n, u)), 2)
            rows.append([*start, *tau, *other, *y, *d_n, *d_tau, *step, *e_m, *e_n])
    return rows


def columns(**sizes):
    return [f"{name}{i}" for name, size in sizes.items() for i in range(size)]


if __name__ == "__main__":
    write("euler_scipy.csv", ["sequence", *columns(angles=3, xyzw=4, back=3)], scipy_rows())
    header = columns(xyzw=4, angle=1, axis=3, gibbs=3, mrp=3, shadow=3, euler=3 * len(SEQUENCES))
    write("coordinates.csv", header, coordinate_rows())
    header = columns(start=3, tau=2, other=3, plus=3, d_start=4, d_tau=4, minus=2, e_other=4, e_start=4)
    write("sphere.csv", header, sphere_rows())
