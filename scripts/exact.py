"""Lie groups in arbitrary precision: what the scripts that write tables of them share.

Truth comes from power series at 60 digits (J_l = sum ad^k/(k+1)!, Exp from the definition), never from the closed forms
under test. Inputs are exact: most are representable in f32, so that one table serves f32 and f64; the rest probe f64 closer
to pi and to the switch than f32 can. Directions are generic (omega neither parallel nor orthogonal to rho). Outputs are
the nearest f64.
"""
import math
import random
import struct
from pathlib import Path

from mpmath import matrix, mp, mpf

mp.dps = 60
OUT = Path(__file__).resolve().parent.parent / "crates/boxplus/tests/reference"
SIZES = [1e-6, 1e-3, 1.0, 1e3, 1e6]  # of rho, in metres
rng = random.Random(20240607)


def f32(x):
    """x rounded to the nearest f32."""
    return struct.unpack("f", struct.pack("f", x))[0]


def f64(x):
    return float(x)


# Tables ----------------------------------------------------------------------------------------------------------------


def write(name, header, rows):
    lines = [",".join(header)]
    for row in rows:
        assert len(row) == len(header), (name, len(row), len(header))
        lines.append(",".join("0" if v == 0 else repr(v).removesuffix(".0") for v in row))
    (OUT / name).write_text("\n".join(lines) + "\n")
    print(name, len(rows), "rows", (OUT / name).stat().st_size, "bytes")


def table(name, rows, columns):
    """`columns` are stems with their numbers of columns: tau0, tau1, …"""
    header = [f"{stem}{i}" for stem, n in columns for i in range(n)]
    write(name, header, rows)


# Inputs ----------------------------------------------------------------------------------------------------------------


def numbers(values, exact32):
    return [f32(x) if exact32 else x for x in values]


def near(values, size):
    return [f32(x * (1 + size * rng.gauss(0, 1))) for x in values]


def mp_list(v):
    return [mpf(x) for x in v]


def direction(n=3):
    v = [rng.gauss(0, 1) for _ in range(n)]
    size = math.sqrt(sum(x * x for x in v))
    return [x / size for x in v]


def element(half, near, i):
    """A quaternion of rotation angle 2*half and a translation; `near` an element close to which it shall be, or None."""
    if near and i % 3 == 0:
        q = [f32(x + 1e-4 * rng.gauss(0, 1)) for x in near[0]]
        return q, [f32(x * (1 + 1e-5 * rng.gauss(0, 1))) for x in near[1]]
    s, c = math.sin(half), math.cos(half)
    # Beyond what cos resolves near pi, its small value itself is the input.
    q = [f32(x * s) for x in direction()] + [f32(c)]
    return q, [f32(x * SIZES[(i // 3) % 5] * (0.5 + rng.random())) for x in direction()]


def few_angles():
    """A thinner grid of theta up to pi: for groups that share the coefficients held by `reference_tables.py`."""
    grid = [0.0, 1e-12, 1e-8, 1e-5, 1e-3, 0.01, 0.05, 0.2, 0.45, 0.55, 0.9, 1.3, 1.7, 1.95, 2.05, 2.4, 2.8, 3.1]
    return grid + [math.pi - 1e-3, math.pi - 1e-7]


# Matrices and quaternions ----------------------------------------------------------------------------------------------


def skew(v):
    return matrix([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def norm(v):
    return mp.sqrt(sum(x * x for x in v))


def column(v):
    return matrix([[x] for x in v])


def put(m, i, j, block):
    for a in range(block.rows):
        for b in range(block.cols):
            m[i + a, j + b] = block[a, b]


def entries(m, *blocks):
    """The named blocks (row, column, rows, columns) of m, each by rows."""
    return [m[i + a, j + b] for i, j, h, w in blocks for a in range(h) for b in range(w)]


def rotate(q, p):
    """q p q* for a quaternion of any norm, divided by that norm's square."""
    v, w = q[:3], q[3]
    a = cross(v, p)
    b = cross(v, a)
    n = sum(x * x for x in q)
    return [p[i] + 2 * (w * a[i] + b[i]) / n for i in range(3)]


def product(a, b):
    va, wa, vb, wb = a[:3], a[3], b[:3], b[3]
    c = cross(va, vb)
    q = [c[i] + wa * vb[i] + wb * va[i] for i in range(3)] + [wa * wb - sum(va[i] * vb[i] for i in range(3))]
    n = norm(q)
    return [x / n for x in q]


def conjugate(q):
    return [-x for x in q[:3]] + [q[3]]


def rotation_matrix(q):
    return matrix([rotate(q, e) for e in ([1, 0, 0], [0, 1, 0], [0, 0, 1])]).T


def exp_quaternion(phi):
    angle = norm(phi)
    half = mp.sin(angle / 2) / angle if angle > 0 else mpf(1) / 2
    return [half * x for x in phi] + [mp.cos(angle / 2)]


def rotation_log(q):
    v, w = (q[:3], q[3]) if q[3] >= 0 else ([-x for x in q[:3]], -q[3])
    n = norm(v)
    if n == 0:
        return [mpf(0)] * 3
    f = 2 * mp.atan2(n, w) / n
    return [f * x for x in v]


# Algebras --------------------------------------------------------------------------------------------------------------


def left_jacobian(ad):
    """sum ad^k/(k+1)!"""
    n = ad.rows
    total, term, k = mp.eye(n), mp.eye(n), 1
    while mp.mnorm(term, 1) > mp.mnorm(total, 1) * mpf(10) ** -(mp.dps + 2):
        term = term * ad / (k + 1)
        total += term
        k += 1
    return total


def se2_ad(tau):
    return matrix([[0, -tau[2], tau[1]], [tau[2], 0, -tau[0]], [0, 0, 0]])


def se3_ad(tau):
    ad = mp.zeros(6)
    for i in (0, 3):
        put(ad, i, i, skew(tau[3:]))
    put(ad, 0, 3, skew(tau[:3]))
    return ad


def sim2_ad(tau):
    x, y, t, s = tau
    return matrix([[s, -t, y, -x], [t, s, -x, -y], [0] * 4, [0] * 4])


def sim3_ad(tau):
    rho, phi, sigma = tau[:3], tau[3:6], tau[6]
    ad = mp.zeros(7)
    put(ad, 0, 0, skew(phi) + sigma * mp.eye(3))
    put(ad, 0, 3, skew(rho))
    put(ad, 0, 6, -column(rho))
    put(ad, 3, 3, skew(phi))
    return ad


def sgal3_ad(tau):
    rho, phi, nu, iota = tau[:3], tau[3:6], tau[6:9], tau[9]
    ad = mp.zeros(10)
    for i in (0, 3, 6):
        put(ad, i, i, skew(phi))
    put(ad, 0, 3, skew(rho))
    put(ad, 6, 3, skew(nu))
    put(ad, 0, 6, -iota * mp.eye(3))
    put(ad, 0, 9, column(nu))
    return ad
