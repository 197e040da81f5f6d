#!/usr/bin/env python3
"""Reference tables of the derivatives of the Jacobians: crates/boxplus/tests/reference/second_*.csv

    pip install mpmath && python3 scripts/second_order_tables.py

J_l(tau) = f(ad) with f(z) = sum z^k/(k+1)!, and f([a b; 0 a]) = [f(a), Df(a)[b]; 0, f(a)]: the derivative along delta is the
corner of the series at [ad_tau, ad_delta; 0, ad_tau], summed at 60 digits. Directions are generic, sizes of translations
run over twelve decades, two rows of three are representable in f32.
"""
from exact import (
    SIZES, direction, entries, few_angles, left_jacobian, mp_list, numbers, put, rng, se2_ad, se3_ad, sgal3_ad, sim2_ad, sim3_ad,
    table,
)
from mpmath import mp, mpf


def derivatives(ad, d_ad):
    n = ad.rows
    both = mp.zeros(2 * n)
    put(both, 0, 0, ad)
    put(both, n, n, ad)
    put(both, 0, n, d_ad)
    total = left_jacobian(both)
    inverse = total[0:n, 0:n] ** -1
    derivative = total[0:n, n : 2 * n]
    change = -inverse * derivative * inverse
    return [mp.chop(m, tol=mpf(10) ** -50 * max(mp.mnorm(m, 1), mpf(10) ** -20)) for m in (derivative, change)]


def tangent(kind, theta, size, sigma):
    """A tangent of the group: translations of the given size, an angle, and what else the group moves."""
    if kind == "se2":
        return [x * size for x in direction(2)] + [theta * rng.choice([-1, 1])]
    if kind == "sim2":
        return [x * size for x in direction(2)] + [theta * rng.choice([-1, 1]), sigma]
    rho, phi = [x * size for x in direction()], [x * theta for x in direction()]
    if kind == "se3":
        return rho + phi
    if kind == "sim3":
        return rho + phi + [sigma]
    return rho + phi + [x * size for x in direction()] + [sigma]


GROUPS = {
    "se2": (se2_ad, 3, [(0, 0, 2, 2), (0, 2, 2, 1)]),
    "se3": (se3_ad, 6, [(0, 0, 3, 3), (0, 3, 3, 3)]),
    "sgal3": (sgal3_ad, 10, [(0, 3, 3, 3), (0, 6, 3, 3), (0, 9, 3, 1)]),
    "sim2": (sim2_ad, 4, [(0, 0, 2, 2), (0, 2, 2, 2)]),
    "sim3": (sim3_ad, 7, [(0, 0, 3, 3), (0, 3, 3, 3), (0, 6, 3, 1), (3, 3, 3, 3)]),
}
SIGMAS = [0.3, -1.1, 1e-7, 2.0, -0.02, -2.9, 0.0]


def group_table(kind):
    ad, d, blocks = GROUPS[kind]
    rng.seed("second " + kind)
    rows = []
    thetas = few_angles() + ([4.0, 5.0, 6.0] if kind in ("se2", "se3") else [])
    for i, theta in enumerate(t for t in thetas for _ in range(3)):
        size = SIZES[i % 5] * (0.5 + rng.random())
        exact32 = i % 3 != 2
        tau = numbers(tangent(kind, theta, size, SIGMAS[i % 7]), exact32)
        delta = numbers(tangent(kind, 0.5 + rng.random(), size, rng.uniform(-1, 1)), exact32)
        results = derivatives(ad(mp_list(tau)), ad(mp_list(delta)))
        rows.append(tau + delta + [float(x) for m in results for x in entries(m, *blocks)])
    n = sum(h * w for _, _, h, w in blocks)
    columns = [("tau", d), ("delta", d), ("djl", n), ("djl_inv", n)]
    table(f"second_{kind}.csv", rows, columns)


if __name__ == "__main__":
    for kind in GROUPS:
        group_table(kind)
