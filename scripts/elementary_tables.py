#!/usr/bin/env python3
"""Reference table of the elementary functions: crates/boxplus/tests/reference/elementary.csv

    pip install mpmath && python3 scripts/elementary_tables.py

Where an argument is reduced, next to the multiples of pi/2 and ln 2 / 2; where a range ends; and everywhere between. Values come as
the nearest f64 and the remainder, for they are held to fractions of a unit in the last place. An empty range is nan.
"""
import math

from exact import f32, rng, write
from mpmath import acos, atan, cos, exp, mp, mpf, sin, sqrt

SIN_COS_END, EXP_END = 65536.0, 708.0  # as in lie/elementary.rs


def arguments():
    """Of every size, and next to where the remainder of the reduction vanishes or changes sides; most are f32."""
    xs = [0.0, math.pi, 6.2, EXP_END, math.nextafter(EXP_END, 0), SIN_COS_END, math.nextafter(SIN_COS_END, 0), 88.5]
    xs += [10.0**e for e in range(-12, 5)] + [f32(10 ** rng.uniform(-7, 4.8)) for _ in range(60)]
    for k in [1, 2, 3, 4, 5, 6, 7, 8, 15, 22, 355, 710, 2843, 41717, 41720] + [rng.randrange(1, 41720) for _ in range(40)]:
        near = float(mp.pi / 2 * k)
        xs += [near, f32(near), math.nextafter(near, 0), float(mp.pi / 4 * (2 * k - 1))]
    for k in [1, 2, 3, 4, 5, 100, 1000, 2041] + [rng.randrange(1, 2042) for _ in range(20)]:
        xs += [float(mp.ln2 / 2 * k), f32(float(mp.ln2 / 2 * k))]
    return sorted({s * x for x in xs for s in (-1.0, 1.0)})


def cosines():
    """In [0, 1], denser towards both ends."""
    ws = [f32(10.0**-e) for e in range(1, 13)] + [1 - 2.0**-e for e in range(1, 53)]
    return sorted({0.0, 1.0, *ws, *(f32(rng.random()) for _ in range(60)), *(rng.random() for _ in range(60))})


def arc(w):
    return acos(w) / sqrt(1 - w * w) if w < 1 else mpf(1)


def split(value):
    """The nearest f64 and what it leaves; nan for what has no value here."""
    if value is None:
        return [math.nan, math.nan]
    nearest = float(value)
    return [nearest, float(value - mpf(nearest))]


if __name__ == "__main__":
    rng.seed("elementary.csv")
    rows = []
    for x in arguments():
        exact = mpf(x)
        periodic = abs(x) <= SIN_COS_END
        values = [sin(exact), cos(exact)] if periodic else [None, None]
        values += [exp(exact) if abs(x) <= EXP_END else None, atan(exact), None]
        rows.append([x] + [y for v in values for y in split(v)])
    for w in cosines():
        rows.append([w] + [y for v in (None, None, None, None, arc(mpf(w))) for y in split(v)])
    columns = [c + s for c in ("sin", "cos", "exp", "atan", "arc") for s in ("", "_rest")]
    write("elementary.csv", ["x"] + columns, rows)
