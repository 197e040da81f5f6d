#!/usr/bin/env python3
"""Reference tables of similarities and the Galilean group: crates/boxplus/tests/reference/{sim2,sim3,sgal3}.csv

    pip install mpmath && python3 scripts/extended_tables.py

See `exact.py` for where truth and inputs come from. Their rotations are those of SO(2) and SO(3), hence a thinner grid of angles;
the angle and the scale vanish independently.
"""
import math

from exact import (
    SIZES, column, conjugate, cross, direction, element, entries, exp_quaternion, f32, f64, few_angles, table,
    left_jacobian, mp_list, near, numbers, product, put, rng, rotate, rotation_log, rotation_matrix, sgal3_ad, sim2_ad, sim3_ad,
    skew,
)
from mpmath import mp, mpf


# Similarities ----------------------------------------------------------------------------------------------------------


SIGMAS = [0.0, 1e-12, -1e-7, 1e-3, -0.03, 0.4, -0.9, 1.1, -1.95, 2.05, -3.0, 4.5, -6.0, 6.0]


def grid_of_similarities():
    """(theta, sigma): both, either, and none of them small; each circle theta^2 + sigma^2 = 4 is approached from both sides."""
    thetas = few_angles()
    pairs = [(t, SIGMAS[(3 * i + k * 5) % len(SIGMAS)]) for i, t in enumerate(thetas) for k in range(2)]
    pairs += [(0.0, s) for s in SIGMAS] + [(t, 0.0) for t in thetas[::2]] + [(1e-9, s) for s in SIGMAS[::3]]
    pairs += [(2 * math.sin(a), s * 2 * math.cos(a) * (1 + e)) for a in (0.3, 1.2) for s in (-1, 1) for e in (-1e-3, 1e-3)]
    return pairs


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
    jl = left_jacobian(sim3_ad(exact))
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
    jl = left_jacobian(sim2_ad(exact))
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


def similarity_tables():
    for name, row, (d, e, n, k) in (("sim3.csv", sim3_row, (7, 8, 3, 21)), ("sim2.csv", sim2_row, (4, 5, 2, 8))):
        rng.seed(name)  # no table depends on those before it; every third row probes f64 alone
        rows = [row(i, t, s, i % 3 != 2) for i, (t, s) in enumerate(grid_of_similarities())]
        columns = [("tau", d), ("point", n), ("a", e), ("b", e), ("exp", e), ("jl", k), ("jl_inv", k), ("log", d)]
        table(name, rows, columns + [("adjoint", k), ("compose", e), ("act", n), ("rminus", d)])


# The Galilean group ----------------------------------------------------------------------------------------------------


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
    ad = sgal3_ad(exact)
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


def sgal3_table():
    rng.seed("sgal3.csv")
    rows = [sgal3_row(3 * i + k, t, k < 2) for i, t in enumerate(few_angles()) for k in range(3)]
    hard = [1e-3, 1.0, 1.7, 2.3, 2.6, 2.9, 3.0, 3.1, 3.14]
    rows += [sgal3_row(4 * i + k, t, k < 3, sgal3_aligned) for i, t in enumerate(hard) for k in range(4)]
    columns = [("tau", 10), ("point", 4), ("a", 11), ("b", 11), ("exp", 11), ("jl", 21), ("jl_inv", 21), ("log", 10)]
    table("sgal3.csv", rows, columns + [("adjoint", 21), ("compose", 11), ("act", 4), ("rminus", 10), ("coupling", 4)])


if __name__ == "__main__":
    similarity_tables()
    sgal3_table()
