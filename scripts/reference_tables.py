#!/usr/bin/env python3
"""Reference tables of the coefficients, SE(2) and SE(3): crates/boxplus/tests/reference/{coefficients,se2,se3}.csv

    pip install mpmath && python3 scripts/reference_tables.py

See `exact.py` for where truth and inputs come from. The coefficients carry the remainder as a second number, for they are held
to about one unit of rounding.
"""
import math
import struct

from exact import (
    SIZES, conjugate, direction, element, entries, exp_quaternion, f32, f64, table, left_jacobian, mp_list, numbers,
    product, rng, rotate, rotation_log, rotation_matrix, se2_ad, se3_ad, skew, write,
)
from mpmath import matrix, mp, mpf


# Coefficients ----------------------------------------------------------------------------------------------------------


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


# Groups ----------------------------------------------------------------------------------------------------------------


def rows(row):
    """Of every angle three; the third probes f64 alone."""
    return [row(3 * i + k, theta, k < 2) for i, theta in enumerate([0.0] + angles()) for k in range(3)]


def se3_log(q, t):
    phi = rotation_log(q)
    inverse = left_jacobian(skew(phi)) ** -1
    return [x for x in inverse * matrix(t)] + phi


def se3_row(i, theta, exact32):
    size = SIZES[i % 5] * (0.5 + rng.random())
    tau = numbers([x * size for x in direction()] + [x * theta for x in direction()], exact32)
    point = [f32(x * SIZES[(i + 2) % 5]) for x in direction()]
    qa, ta = element(min(theta, 2 * math.pi - theta) / 2, None, i)
    if abs(theta - math.pi) < 0.1:
        qa[3] = f32(-(theta - math.pi) / 2)  # exact to the last digit where cos(theta/2) is not
    qb, tb = element(0.2 + 1.2 * rng.random(), (qa, ta), i)

    exact = mp_list(tau)
    rho, phi = exact[:3], exact[3:]
    jl = left_jacobian(se3_ad(exact))
    parts = [(0, 0, 3, 3), (0, 3, 3, 3)]
    exp = exp_quaternion(phi) + [x for x in jl[0:3, 0:3] * matrix(rho)]
    a, b = (mp_list(qa), mp_list(ta)), (mp_list(qb), mp_list(tb))
    r, back = rotation_matrix(a[0]), conjugate(a[0])
    adjoint = entries(r, (0, 0, 3, 3)) + entries(skew(a[1]) * r, (0, 0, 3, 3))
    compose = product(a[0], b[0]) + [x + y for x, y in zip(rotate(a[0], b[1]), a[1])]
    step = rotate(back, [y - x for x, y in zip(a[1], b[1])])
    rminus = se3_log(product(back, b[0]), step)
    turned = rotate(a[0], mp_list(point))
    act = [x + y for x, y in zip(turned, a[1])]
    outputs = exp + entries(jl, *parts) + entries(jl**-1, *parts)
    outputs += se3_log(*a) + adjoint + compose + turned + act + rminus
    return tau + point + qa + ta + qb + tb + [f64(x) for x in outputs]


def se3_table():
    columns = [("tau", 6), ("point", 3), ("a", 7), ("b", 7), ("exp", 7), ("jl", 18), ("jl_inv", 18), ("log", 6)]
    columns += [("adjoint", 18), ("compose", 7), ("turned", 3), ("act", 3), ("rminus", 6)]
    table("se3.csv", rows(se3_row), columns)


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

    exact = mp_list(tau)
    jl = left_jacobian(se2_ad(exact))
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
    columns = [("tau", 3), ("point", 2), ("a", 4), ("b", 4), ("exp", 4), ("jl", 4), ("jl_inv", 4), ("log", 3)]
    columns += [("adjoint", 4), ("compose", 4), ("turned", 2), ("act", 2), ("rminus", 3)]
    table("se2.csv", rows(se2_row), columns)


if __name__ == "__main__":
    coefficient_table()
    se2_table()
    se3_table()
