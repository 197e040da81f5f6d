#!/usr/bin/env python3
"""Reference tables of trajectories, by arbitrary precision: crates/boxplus/tests/reference/{discretise,increments}.csv

    pip install mpmath && python3 scripts/trajectory_tables.py

discretise: van Loan's own matrix exponential at 200 digits, of systems from mild to stiff and unstable.
increments: R' = R w^, v' = R a, p' = v with w and a linear in time, by the Taylor series of the differential equation at 40
digits, which shares nothing with exponentials of groups. Inputs are exact f64; outputs the nearest f64.
"""
import random
from pathlib import Path

from mpmath import eye, expm, matrix, mp, mpf, zeros

mp.dps = 200  # van Loan inverts exp(A): e^120 for the stiffest
OUT = Path(__file__).resolve().parent.parent / "crates/boxplus/tests/reference"
rng = random.Random(20261124)


def write(name, header, rows):
    lines = [",".join(header)] + [",".join(repr(float(x)) for x in row) for row in rows]
    (OUT / name).write_text("\n".join(lines) + "\n")
    print(name, len(rows))


def entries(m):
    return [m[i, j] for i in range(m.rows) for j in range(m.cols)]


def discretise():
    rows, n = [], 3
    for scale in [0.0, 1e-6, 0.1, 1.0, 5.0, 40.0]:
        for kind in ["general", "damped", "rotating", "chain"]:
            a = matrix(n, n)
            for i in range(n):
                for j in range(n):
                    a[i, j] = mpf(rng.uniform(-1, 1))
            if kind == "damped":
                a = matrix([[float(-(a * a.T)[i, j]) for j in range(n)] for i in range(n)])
            if kind == "rotating":
                a = matrix([[float(a[i, j] - a[j, i]) for j in range(n)] for i in range(n)])
            if kind == "chain":
                a = matrix([[0, 1, 0], [0, 0, 1], [0, 0, 0]])
            a = matrix([[float(a[i, j] * mpf(scale)) for j in range(n)] for i in range(n)])
            b = matrix([[rng.randint(-8, 8) / 4 for _ in range(n)] for _ in range(n)])
            w = b * b.T  # exact
            if kind == "chain":
                w = matrix([[0, 0, 0], [0, 0, 0], [0, 0, 2]])
            dt = mpf(rng.choice([0.25, 0.5, 1.0]))
            big = zeros(2 * n, 2 * n)
            for i in range(n):
                for j in range(n):
                    big[i, j] = -a[i, j] * dt
                    big[i, n + j] = w[i, j] * dt
                    big[n + i, n + j] = a[j, i] * dt
            e = expm(big, method="taylor")
            phi = matrix([[e[n + j, n + i] for j in range(n)] for i in range(n)])
            q = phi * matrix([[e[i, n + j] for j in range(n)] for i in range(n)])
            check = expm(a * dt, method="taylor")
            assert max(abs(x) for x in entries(phi - check)) < mpf(10) ** -30 * (1 + max(abs(x) for x in entries(phi)))
            rows.append(entries(a) + entries(w) + [dt] + entries(phi) + entries(q))
    header = [f"{m}{i}" for m in ["a", "w"] for i in range(9)] + ["dt0"]
    write("discretise.csv", header + [f"{m}{i}" for m in ["phi", "q"] for i in range(9)], rows)


def skew(v):
    return matrix([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def increments():
    """Power series: (k+1) R_{k+1} = R_k w0^ + R_{k-1} w1^ and likewise for v; p_{k+1} = v_k/(k+1)."""
    mp.dps = 40
    rows = []
    for rate, slope in [(0.0, 0.0), (1e-4, 0.0), (0.5, 0.0), (3.0, 0.0), (0.5, 0.7), (2.0, 3.0)]:
        w0, w1 = ([mpf(rng.uniform(-1, 1) * s) for _ in range(3)] for s in (rate, slope))
        a0, a1 = ([mpf(rng.uniform(-10, 10) * s) for _ in range(3)] for s in (1.0, 1.0 if slope else 0.0))
        t = mpf(0.75)
        r, v, p = [eye(3)], [zeros(3, 1)], [zeros(3, 1)]
        for k in range(120):
            before = r[k - 1] if k else zeros(3, 3)
            r.append((r[k] * skew(w0) + before * skew(w1)) / (k + 1))
            v.append((r[k] * matrix(a0) + before * matrix(a1)) / (k + 1))
            p.append(v[k] / (k + 1))
        total = lambda terms: sum((c * t**k for k, c in enumerate(terms[1:], 1)), terms[0])
        big_r = total(r)
        assert max(abs(x) for x in entries(big_r * big_r.T - eye(3))) < mpf(10) ** -30
        rows.append(w0 + w1 + a0 + a1 + [t] + entries(big_r) + entries(total(v)) + entries(total(p)))
    header = [f"{m}{i}" for m in ["w", "dw", "a", "da"] for i in range(3)] + ["t0"]
    header += [f"r{i}" for i in range(9)] + [f"{m}{i}" for m in ["v", "p"] for i in range(3)]
    write("increments.csv", header, rows)


discretise()
increments()
