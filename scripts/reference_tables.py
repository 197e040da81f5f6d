#!/usr/bin/env python3
"""Reference tables of the Lie groups, by arbitrary precision: crates/boxplus/tests/reference/*.csv

    pip install mpmath && python3 scripts/reference_tables.py

Truth comes from power series at 60 digits (J_l = sum ad^k/(k+1)!, Exp from the definition), never from the closed forms
under test. Inputs are exact: most are representable in f32, so that one table serves f32 and f64; the rest probe f64 closer
to pi and to the switch than f32 can. Directions are generic (omega neither parallel nor orthogonal to rho). Outputs are
the nearest f64; the coefficients carry the remainder as a second number, for they are held to about one unit of rounding.
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


# Coefficients ---------------------------------------------------------------------------------------------------------


def stumpff(k, x):
    """c_k(x) = sum (-x)^j/(k+2j)!, summed until it no longer changes."""
    term, total, j = 1 / mp.factorial(k), mpf(0), 0
    while True:
        total += term
        j += 1
        term *= -x / ((k + 2 * j) * (k + 2 * j - 1))
        if abs(term) < abs(total) * mpf(10) ** -(mp.dps + 5):
            return total


def coefficients(x):
    c = {k: stumpff(k, x) for k in range(7)}
    b1, b2 = 2 * c[4] - c[3], 3 * c[5] - c[4]
    d = -b1 / (2 * c[2])
    e = ((5 * c[5] - c[4] - 8 * c[6]) * c[2] + b1**2) / (2 * c[2] ** 2)
    if x > 1:  # independent check by the textbook forms, where these keep their digits
        t = mp.sqrt(x)
        assert abs(d - (1 - t / 2 * mp.cot(t / 2)) / x) < mpf(10) ** -50
        assert abs(e - mp.diff(lambda s: (1 - s / 2 * mp.cot(s / 2)) / s**2, t) / t) < mpf(10) ** -20
        assert abs(b1 - (t * mp.sin(t) + 2 * mp.cos(t) - 2) / x**2) < mpf(10) ** -50
        assert abs(b2 - (3 * mp.sin(t) - t * mp.cos(t) - 2 * t) / t**5) < mpf(10) ** -50
    return [c[1], c[2], c[3], c[4], c[5], c[6], d, e, b1, b2]


def angles():
    """The grid of theta, principal and beyond, with both sides of every switch."""
    grid = [10.0**e for e in range(-12, -1)]
    grid += [0.01 * 1.3**i for i in range(22)]
    grid += [0.2 * i for i in range(6, 16)]
    # Of the series (theta^2 = 10), of c1 and c0 (theta and theta/2 = 1/2), of the logarithm (tan theta/2, f64 and f32).
    for switch in [math.sqrt(10.0), 0.5, 1.0, 2 * math.atan(1e-3), 2 * math.atan(0.05)]:
        grid += [switch * (1 + s * 10.0**-e) for s in (-1, 1) for e in (3, 6, 10, 14)]
    grid += [math.pi + s * 10.0**-e for s in (-1, 1) for e in (2, 3, 5, 7, 9, 12)]
    grid += [3.2 + 0.25 * i for i in range(13)]
    return sorted(set(grid))


def write(name, header, rows):
    lines = [",".join(header)]
    for row in rows:
        assert len(row) == len(header), (name, len(row), len(header))
        lines.append(",".join("0" if v == 0 else repr(v).removesuffix(".0") for v in row))
    (OUT / name).write_text("\n".join(lines) + "\n")
    print(name, len(rows), "rows", (OUT / name).stat().st_size, "bytes")


def coefficient_table():
    names = ["c1", "c2", "c3", "c4", "c5", "c6", "d", "e", "beta1", "beta2"]
    xs = {0.0}
    for theta in angles() + [2 * math.pi * (1 - 10.0**-e) for e in (2, 3, 4)]:
        xs |= {f32(theta * theta), theta * theta}
    for x in (0.25, 10.0):  # the switches themselves and their neighbours
        up, down = struct.unpack("I", struct.pack("f", x))[0] + 1, struct.unpack("I", struct.pack("f", x))[0] - 1
        xs |= {x, math.nextafter(x, 0), math.nextafter(x, 99)}
        xs |= {struct.unpack("f", struct.pack("I", i))[0] for i in (up, down)}
    rows = []
    for x in sorted(xs):
        row = [x]
        for value in coefficients(mpf(x)):
            high = f64(value)
            row += [high, float(f"{f64(value - high):.3g}")]
        rows.append(row)
    write("coefficients.csv", ["x"] + [n + s for n in names for s in ("", "_rest")], rows)


# Groups ---------------------------------------------------------------------------------------------------------------


def skew(v):
    return matrix([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def norm(v):
    return mp.sqrt(sum(x * x for x in v))


def left_jacobian(ad):
    """sum ad^k/(k+1)!"""
    n = ad.rows
    total, term, k = mp.eye(n), mp.eye(n), 1
    while mp.mnorm(term, 1) > mp.mnorm(total, 1) * mpf(10) ** -(mp.dps + 2):
        term = term * ad / (k + 1)
        total += term
        k += 1
    return total


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


def rotation_log(q):
    v, w = (q[:3], q[3]) if q[3] >= 0 else ([-x for x in q[:3]], -q[3])
    n = norm(v)
    if n == 0:
        return [mpf(0)] * 3
    f = 2 * mp.atan2(n, w) / n
    return [f * x for x in v]


def se3_ad(tau):
    ad = mp.zeros(6)
    p, w = skew(tau[:3]), skew(tau[3:])
    for i in range(3):
        for j in range(3):
            ad[i, j] = ad[i + 3, j + 3] = w[i, j]
            ad[i, j + 3] = p[i, j]
    return ad


def blocks(m):
    """Upper left and upper right 3x3 blocks, by rows."""
    return [f64(m[i, j + s]) for s in (0, 3) for i in range(3) for j in range(3)]


def se3_log(q, t):
    phi = rotation_log(q)
    inverse = left_jacobian(skew(phi)) ** -1
    return [x for x in inverse * matrix(t)] + phi


def direction(n=3):
    v = [rng.gauss(0, 1) for _ in range(n)]
    size = math.sqrt(sum(x * x for x in v))
    return [x / size for x in v]


def numbers(values, exact32):
    return [f32(x) if exact32 else x for x in values]


def element(half, near, i):
    """A quaternion of rotation angle 2*half and a translation; `near` an element close to which it shall be, or None."""
    if near and i % 3 == 0:
        q = [f32(x + 1e-4 * rng.gauss(0, 1)) for x in near[0]]
        return q, [f32(x * (1 + 1e-5 * rng.gauss(0, 1))) for x in near[1]]
    s, c = math.sin(half), math.cos(half)
    # Beyond what cos resolves near pi, its small value itself is the input.
    q = [f32(x * s) for x in direction()] + [f32(c)]
    return q, [f32(x * SIZES[(i // 3) % 5] * (0.5 + rng.random())) for x in direction()]


def se3_row(i, theta, exact32):
    size = SIZES[i % 5] * (0.5 + rng.random())
    tau = numbers([x * size for x in direction()] + [x * theta for x in direction()], exact32)
    point = [f32(x * SIZES[(i + 2) % 5]) for x in direction()]
    qa, ta = element(min(theta, 2 * math.pi - theta) / 2, None, i)
    if abs(theta - math.pi) < 0.1:
        qa[3] = f32(-(theta - math.pi) / 2)  # exact to the last digit where cos(theta/2) is not
    qb, tb = element(0.2 + 1.2 * rng.random(), (qa, ta), i)

    exact = [mpf(x) for x in tau]
    rho, phi = exact[:3], exact[3:]
    angle = norm(phi)
    half = mp.sin(angle / 2) / angle if angle > 0 else mpf(1) / 2
    jl = left_jacobian(se3_ad(exact))
    t = [x for x in jl[0:3, 0:3] * matrix(rho)]
    exp = [half * x for x in phi] + [mp.cos(angle / 2)] + t
    a, b = ([mpf(x) for x in qa], [mpf(x) for x in ta]), ([mpf(x) for x in qb], [mpf(x) for x in tb])
    r = matrix([rotate(a[0], e) for e in ([1, 0, 0], [0, 1, 0], [0, 0, 1])]).T
    adjoint = [r[i, j] for i in range(3) for j in range(3)]
    lower = skew(a[1]) * r
    adjoint += [lower[i, j] for i in range(3) for j in range(3)]
    compose = product(a[0], b[0]) + [x + y for x, y in zip(rotate(a[0], b[1]), a[1])]
    conjugate = [-x for x in a[0][:3]] + [a[0][3]]
    step = rotate(conjugate, [y - x for x, y in zip(a[1], b[1])])
    rminus = se3_log(product(conjugate, b[0]), step)
    turned = rotate(a[0], [mpf(x) for x in point])
    act = [x + y for x, y in zip(turned, a[1])]
    outputs = exp + blocks(jl) + blocks(jl**-1) + se3_log(*a) + adjoint + compose + turned + act + rminus
    return tau + point + qa + ta + qb + tb + [f64(x) for x in outputs]


def se3_table():
    def names(stem, n):
        return [f"{stem}{i}" for i in range(n)]

    header = names("tau", 6) + names("point", 3) + names("a", 7) + names("b", 7)
    header += names("exp", 7) + names("jl", 18) + names("jl_inv", 18) + names("log", 6)
    header += names("adjoint", 18) + names("compose", 7) + names("turned", 3) + names("act", 3) + names("rminus", 6)
    rows, i = [], 0
    for theta in [0.0] + angles():
        for exact32 in (True, True, False):
            rows.append(se3_row(i, theta, exact32))
            i += 1
    write("se3.csv", header, rows)


def se2_log(z, t):
    theta = mp.arg(z)
    x = mp.mpc(0, theta)
    v = 1 if theta == 0 else mp.expm1(x) / x
    rho = mp.mpc(*t) / v
    return [rho.real, rho.imag, theta]


def se2_row(i, theta, exact32):
    theta *= rng.choice([-1, 1])
    size = SIZES[i % 5] * (0.5 + rng.random())
    tau = numbers([x * size for x in direction(2)] + [theta], exact32)
    point = [f32(x * SIZES[(i + 2) % 5]) for x in direction(2)]

    def pose(angle, k):
        c = [f32(math.cos(angle)), f32(math.sin(angle))]
        if abs(abs(angle) - math.pi) < 0.1:
            c[1] = f32(math.copysign(math.pi - abs(angle), angle))
        return c, [f32(x * SIZES[k % 5] * (0.5 + rng.random())) for x in direction(2)]

    ca, ta = pose(theta, i // 3)
    cb, tb = pose(rng.uniform(-1.4, 1.4), i // 3)
    if i % 3 == 0:
        cb = [f32(x + 1e-4 * rng.gauss(0, 1)) for x in ca]
        tb = [f32(x * (1 + 1e-5 * rng.gauss(0, 1))) for x in ta]

    exact = [mpf(x) for x in tau]
    ad = matrix([[0, -exact[2], exact[1]], [exact[2], 0, -exact[0]], [0, 0, 0]])
    jl = left_jacobian(ad)
    inverse = jl**-1
    t = jl[0:2, 0:2] * matrix(exact[:2])
    exp = [mp.cos(exact[2]), mp.sin(exact[2]), t[0], t[1]]
    unit = lambda c: mp.mpc(*c) / mp.sqrt(mpf(c[0]) ** 2 + mpf(c[1]) ** 2)  # noqa: E731
    a, b, pa, pb = unit(ca), unit(cb), mp.mpc(*ta), mp.mpc(*tb)
    ab, moved, turned = a * b, a * pb + pa, a * mp.mpc(*point)
    acted = turned + pa
    step = (pb - pa) * mp.conj(a)
    outputs = exp + [jl[0, 0], jl[1, 0], jl[0, 2], jl[1, 2]]
    outputs += [inverse[0, 0], inverse[1, 0], inverse[0, 2], inverse[1, 2]] + se2_log(a, [pa.real, pa.imag])
    outputs += [a.real, a.imag, pa.imag, -pa.real]
    outputs += [ab.real, ab.imag, moved.real, moved.imag, turned.real, turned.imag, acted.real, acted.imag]
    outputs += se2_log(b * mp.conj(a), [step.real, step.imag])
    return tau + point + ca + ta + cb + tb + [f64(x) for x in outputs]


def se2_table():
    def names(stem, n):
        return [f"{stem}{i}" for i in range(n)]

    header = names("tau", 3) + names("point", 2) + names("a", 4) + names("b", 4)
    header += names("exp", 4) + names("jl", 4) + names("jl_inv", 4) + names("log", 3)
    header += names("adjoint", 4) + names("compose", 4) + names("turned", 2) + names("act", 2) + names("rminus", 3)
    rows, i = [], 0
    for theta in [0.0] + angles():
        for exact32 in (True, True, False):
            rows.append(se2_row(i, theta, exact32))
            i += 1
    write("se2.csv", header, rows)


# Similarities and the Galilean group ----------------------------------------------------------------------------------


def put(m, i, j, block):
    for a in range(block.rows):
        for b in range(block.cols):
            m[i + a, j + b] = block[a, b]


def entries(m, *blocks):
    """The named blocks (row, column, rows, columns) of m, each by rows."""
    return [m[i + a, j + b] for i, j, h, w in blocks for a in range(h) for b in range(w)]


def column(v):
    return matrix([[x] for x in v])


def exp_quaternion(phi):
    angle = norm(phi)
    half = mp.sin(angle / 2) / angle if angle > 0 else mpf(1) / 2
    return [half * x for x in phi] + [mp.cos(angle / 2)]


def rotation_matrix(q):
    return matrix([rotate(q, e) for e in ([1, 0, 0], [0, 1, 0], [0, 0, 1])]).T


def conjugate(q):
    return [-x for x in q[:3]] + [q[3]]


def mp_list(v):
    return [mpf(x) for x in v]


def few_angles():
    """A thinner grid of theta up to pi: these groups share the coefficients held by the tables above."""
    grid = [0.0, 1e-12, 1e-8, 1e-5, 1e-3, 0.01, 0.05, 0.2, 0.45, 0.55, 0.9, 1.3, 1.7, 1.95, 2.05, 2.4, 2.8, 3.1]
    return grid + [math.pi - 1e-3, math.pi - 1e-7]


SIGMAS = [0.0, 1e-12, -1e-7, 1e-3, -0.03, 0.4, -0.9, 1.1, -1.95, 2.05, -3.0, 4.5, -6.0, 6.0]


def grid_of_similarities():
    """(theta, sigma): both, either, and none of them small; each circle theta^2 + sigma^2 = 4 is approached from both sides."""
    thetas = few_angles()
    pairs = [(t, SIGMAS[(3 * i + k * 5) % len(SIGMAS)]) for i, t in enumerate(thetas) for k in range(2)]
    pairs += [(0.0, s) for s in SIGMAS] + [(t, 0.0) for t in thetas[::2]] + [(1e-9, s) for s in SIGMAS[::3]]
    pairs += [(2 * math.sin(a), s * 2 * math.cos(a) * (1 + e)) for a in (0.3, 1.2) for s in (-1, 1) for e in (-1e-3, 1e-3)]
    return pairs


def near(values, size):
    return [f32(x * (1 + size * rng.gauss(0, 1))) for x in values]


def sim3_log(q, t, sigma):
    phi = rotation_log(q)
    z = skew(phi) + sigma * mp.eye(3)
    return [x for x in left_jacobian(z) ** -1 * column(t)] + phi + [sigma]


def sim3_row(i, theta, sigma, exact32):
    size = SIZES[i % 5] * (0.5 + rng.random())
    tau = numbers([x * size for x in direction()] + [x * theta for x in direction()] + [sigma], exact32)
    point = [f32(x * SIZES[(i + 2) % 5]) for x in direction()]
    qa, ta = element(theta / 2, None, i)
    qb, tb = element(0.2 + 1.2 * rng.random(), (qa, ta), i)
    sa = f32(sigma)
    sb = near([sa], 1e-5)[0] if i % 3 == 0 else f32(rng.uniform(-1, 1))

    exact = mp_list(tau)
    rho, phi, sg = exact[:3], exact[3:6], exact[6]
    ad = mp.zeros(7)
    put(ad, 0, 0, skew(phi) + sg * mp.eye(3))
    put(ad, 0, 3, skew(rho))
    put(ad, 0, 6, -column(rho))
    put(ad, 3, 3, skew(phi))
    jl = left_jacobian(ad)
    parts = [(0, 0, 3, 3), (0, 3, 3, 3), (0, 6, 3, 1)]
    t = [x for x in jl[0:3, 0:3] * column(rho)]
    a, b, p = mp_list(qa), mp_list(qb), mp_list(point)
    pa, pb, s = mp_list(ta), mp_list(tb), mp.exp(mpf(sa))
    r = rotation_matrix(a)
    ad_a = entries(s * r, (0, 0, 3, 3)) + entries(skew(pa) * r, (0, 0, 3, 3)) + [-x for x in pa]
    moved = lambda v: [s * x + y for x, y in zip(rotate(a, v), pa)]  # noqa: E731
    compose = product(a, b) + moved(pb) + [mpf(sa) + mpf(sb)]
    step = [x / s for x in rotate(conjugate(a), [y - x for x, y in zip(pa, pb)])]
    rminus = sim3_log(product(conjugate(a), b), step, mpf(sb) - mpf(sa))
    outputs = exp_quaternion(phi) + t + [sg] + entries(jl, *parts) + entries(jl**-1, *parts)
    outputs += sim3_log(a, pa, mpf(sa)) + ad_a + compose + moved(p) + rminus
    return tau + point + qa + ta + [sa] + qb + tb + [sb] + [f64(x) for x in outputs]


def sim2_row(i, theta, sigma, exact32):
    theta *= rng.choice([-1, 1])
    size = SIZES[i % 5] * (0.5 + rng.random())
    tau = numbers([x * size for x in direction(2)] + [theta, sigma], exact32)
    point = [f32(x * SIZES[(i + 2) % 5]) for x in direction(2)]
    pose = lambda angle, k: [f32(math.cos(angle)), f32(math.sin(angle))] + [  # noqa: E731
        f32(x * SIZES[k % 5] * (0.5 + rng.random())) for x in direction(2)
    ]
    ea, eb = pose(theta, i // 3) + [f32(sigma)], pose(rng.uniform(-1.4, 1.4), i // 3) + [f32(rng.uniform(-1, 1))]
    if i % 3 == 0:
        eb = near(ea, 1e-5)

    exact = mp_list(tau)
    rho, z = mp.mpc(*exact[:2]), mp.mpc(exact[3], exact[2])
    phi1 = lambda z: (mp.expm1(z)) / z if z != 0 else mpf(1)  # noqa: E731
    ad = matrix([[z.real, -z.imag, rho.imag, -rho.real], [z.imag, z.real, -rho.real, -rho.imag], [0] * 4, [0] * 4])
    jl = left_jacobian(ad)
    parts = [(0, 0, 2, 2), (0, 2, 2, 1), (0, 3, 2, 1)]
    t = jl[0:2, 0:2] * column([rho.real, rho.imag])
    unit = lambda e: mp.mpc(e[0], e[1]) / mp.sqrt(mpf(e[0]) ** 2 + mpf(e[1]) ** 2)  # noqa: E731
    ra, rb, pa, pb = unit(ea), unit(eb), mp.mpc(*ea[2:4]), mp.mpc(*eb[2:4])
    sa, sb = mpf(ea[4]), mpf(eb[4])
    pair = lambda c: [c.real, c.imag]  # noqa: E731

    def log(r, t, sigma):
        theta = mp.arg(r)
        return pair(mp.mpc(t) / phi1(mp.mpc(sigma, theta))) + [theta, sigma]

    grown = ra * mp.exp(sa)
    ab = ra * rb
    outputs = pair(mp.expj(z.imag)) + [x for x in t] + [z.real]
    outputs += entries(jl, *parts) + entries(jl**-1, *parts) + log(ra, pa, sa)
    outputs += [grown.real, -grown.imag, grown.imag, grown.real, pa.imag, -pa.real, -pa.real, -pa.imag]
    outputs += pair(ab) + pair(grown * pb + pa) + [sa + sb] + pair(grown * mp.mpc(*point) + pa)
    outputs += log(rb * mp.conj(ra), (pb - pa) / grown, sb - sa)
    return tau + point + ea + eb + [f64(x) for x in outputs]


def sgal3_log(q, p, v, t):
    phi = rotation_log(q)
    w = skew(phi)
    nu = left_jacobian(w) ** -1 * column(v)
    rho = left_jacobian(w) ** -1 * (column(p) - t * gamma2(w) * nu)
    return [x for x in rho] + phi + [x for x in nu] + [t]


def gamma2(w):
    """sum w^k/(k+2)!, the coupling block of sum ad^k/(k+1)! for [w, I; 0, 0]."""
    m = mp.zeros(6)
    put(m, 0, 0, w)
    put(m, 0, 3, mp.eye(3))
    return left_jacobian(m)[0:3, 3:6]


def sgal3_tangent(i, theta):
    size, speed = SIZES[i % 5] * (0.5 + rng.random()), SIZES[(i // 2) % 4]
    clock = [0.0, 1e-6, -0.01, 1.7, -30.0, 1000.0][i % 6]
    tau = [x * size for x in direction()] + [x * theta for x in direction()] + [x * speed for x in direction()]
    return tau + [clock], speed, clock


def sgal3_aligned(i, theta):
    """Rotation axis, position and velocity on one line, or the latter across, and alike in size: terms that cancel."""
    axis = direction()
    vectors = [axis, axis] if i % 2 else [cross(axis, direction()) for _ in range(2)]
    clock = rng.gauss(0, 1)
    return vectors[0] + [x * theta for x in axis] + vectors[1] + [clock], 1.0, clock


def coupling_sizes(ad, jl):
    """Norms of the two terms of the block rho-phi of J_l and of its inverse: one of rho alone, one that iota multiplies."""
    still = ad.copy()
    put(still, 0, 6, mp.zeros(3))
    at_rest = left_jacobian(still)
    pairs = [(at_rest, jl), (at_rest**-1, jl**-1)]
    norms = lambda m: mp.sqrt(sum(x * x for x in entries(m, (0, 3, 3, 3))))  # noqa: E731
    return [x for rest, both in pairs for x in (norms(rest), norms(both - rest))]


def sgal3_row(i, theta, exact32, tangent=sgal3_tangent):
    tau, speed, clock = tangent(i, theta)
    tau = numbers(tau, exact32)
    event = [f32(x * SIZES[(i + 2) % 5]) for x in direction()] + [f32(rng.uniform(-5, 5))]
    qa, pa = element(theta / 2, None, i)
    qb, pb = element(0.2 + 1.2 * rng.random(), (qa, pa), i)
    va, ta = [f32(x * speed) for x in direction()], f32(clock)
    vb, tb = ([f32(x * speed) for x in direction()], f32(rng.uniform(-9, 9)))
    if i % 3 == 0:
        vb, tb = near(va, 1e-5), near([ta], 1e-5)[0]

    exact = mp_list(tau)
    rho, phi, nu, iota = exact[:3], exact[3:6], exact[6:9], exact[9]
    ad = mp.zeros(10)
    for k in (0, 3, 6):
        put(ad, k, k, skew(phi))
    put(ad, 0, 3, skew(rho))
    put(ad, 6, 3, skew(nu))
    put(ad, 0, 6, -iota * mp.eye(3))
    put(ad, 0, 9, column(nu))
    jl = left_jacobian(ad)
    parts = [(0, 3, 3, 3), (0, 6, 3, 3), (0, 9, 3, 1)]
    j = left_jacobian(skew(phi))
    v = [x for x in j * column(nu)]
    p = [x for x in j * column(rho) + iota * gamma2(skew(phi)) * column(nu)]
    a, b, e, w = mp_list(qa), mp_list(qb), mp_list(event), mp_list(va)
    start = [x - mpf(ta) * y for x, y in zip(pa, w)]
    r = rotation_matrix(a)
    ad_a = entries(skew(start) * r, (0, 0, 3, 3)) + entries(-mpf(ta) * r, (0, 0, 3, 3)) + w
    moved = lambda v, time: [x + y + z * time for x, y, z in zip(rotate(a, v), pa, w)]  # noqa: E731
    compose = product(a, b) + moved(mp_list(pb), mpf(tb))
    compose += [x + y for x, y in zip(rotate(a, mp_list(vb)), w)] + [mpf(ta) + mpf(tb)]
    back, dt = conjugate(a), mpf(tb) - mpf(ta)
    step = rotate(back, [mpf(y) - mpf(x) - z * dt for x, y, z in zip(pa, pb, w)])
    speed_step = rotate(back, [mpf(y) - z for y, z in zip(vb, w)])
    rminus = sgal3_log(product(back, b), step, speed_step, dt)
    inverse = mp.chop(jl**-1, tol=mp.mnorm(jl, 1) * mpf(10) ** -45)  # zeros where iota is zero
    outputs = exp_quaternion(phi) + p + v + [iota] + entries(jl, *parts) + entries(inverse, *parts)
    outputs += sgal3_log(a, mp_list(pa), w, mpf(ta)) + ad_a + compose + moved(e[:3], e[3]) + [e[3] + mpf(ta)] + rminus
    outputs += coupling_sizes(ad, jl)
    return tau + event + qa + pa + va + [ta] + qb + pb + vb + [tb] + [f64(x) for x in outputs]


def further_table(name, rows, columns):
    header = [f"{stem}{i}" for stem, n in columns for i in range(n)]
    write(name, header, rows)


def similarity_tables():
    for name, row, (d, e, n, k) in (("sim3.csv", sim3_row, (7, 8, 3, 21)), ("sim2.csv", sim2_row, (4, 5, 2, 8))):
        rng.seed(name)  # no table depends on those before it; every third row probes f64 alone
        rows = [row(i, t, s, i % 3 != 2) for i, (t, s) in enumerate(grid_of_similarities())]
        columns = [("tau", d), ("point", n), ("a", e), ("b", e), ("exp", e), ("jl", k), ("jl_inv", k), ("log", d)]
        further_table(name, rows, columns + [("adjoint", k), ("compose", e), ("act", n), ("rminus", d)])


def sgal3_table():
    rng.seed("sgal3.csv")
    rows = [sgal3_row(3 * i + k, t, k < 2) for i, t in enumerate(few_angles()) for k in range(3)]
    hard = [1e-3, 1.0, 1.7, 2.3, 2.6, 2.9, 3.0, 3.1, 3.14]
    rows += [sgal3_row(4 * i + k, t, k < 3, sgal3_aligned) for i, t in enumerate(hard) for k in range(4)]
    columns = [("tau", 10), ("point", 4), ("a", 11), ("b", 11), ("exp", 11), ("jl", 21), ("jl_inv", 21), ("log", 10)]
    further_table("sgal3.csv", rows, columns + [("adjoint", 21), ("compose", 11), ("act", 4), ("rminus", 10), ("coupling", 4)])


if __name__ == "__main__":
    OUT.mkdir(parents=True, exist_ok=True)
    coefficient_table()
    se2_table()
    se3_table()
    similarity_tables()
    sgal3_table()
