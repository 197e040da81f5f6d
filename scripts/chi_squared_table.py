#!/usr/bin/env python3
"""Writes crates/boxplus/tests/reference/chi_squared.csv: tails and quantiles of χ² with 50 digits, rounded to 17.

    pip install mpmath && scripts/chi_squared_table.py
"""

from pathlib import Path

from mpmath import findroot, gammainc, mp, mpf, nstr, sqrt

mp.dps = 50
OUT = Path(__file__).parent.parent / "crates/boxplus/tests/reference/chi_squared.csv"
DEGREES = [1, 2, 3, 4, 6, 7, 9, 10, 15, 16, 17, 30, 101, 300, 6000]
PROBABILITIES = ["1e-12", "0.001", "0.025", "0.1", "0.5", "0.68268949213708585", "0.95", "0.99", "0.999999"]


def lower(k: int, x: mpf) -> mpf:
    return gammainc(mpf(k) / 2, 0, x / 2, regularized=True)


def upper(k: int, x: mpf) -> mpf:
    return gammainc(mpf(k) / 2, x / 2, mp.inf, regularized=True)


def quantile(k: int, p: mpf) -> mpf:
    """Bisection to a bracket, then Newton by secants."""
    low, high = mpf(0), mpf(k) + 40 * sqrt(mpf(2) * k) + 100
    for _ in range(60):
        middle = (low + high) / 2 if low > high / 100 else high / 8
        low, high = (middle, high) if lower(k, middle) < p else (low, middle)
    return findroot(lambda x: lower(k, x) / p - 1, (low, high), solver="anderson", tol=mpf(10) ** -60)


def main() -> None:
    rows = ["degrees,probability,quantile,x,cdf,survival"]
    for k in DEGREES:
        # Doubles, so that the argument is exact on both sides.
        ratios = ["0.0009765625", "0.125", "0.75", "1", "1.0625", "2", "5", "20"]
        for index, probability in enumerate(PROBABILITIES):
            p = mpf(float(probability))
            x = mpf(k) * mpf(ratios[index % len(ratios)])
            values = [quantile(k, p), x, lower(k, x), upper(k, x)]
            rows.append(f"{k},{float(probability)!r}," + ",".join(nstr(v, 17, min_fixed=0, max_fixed=0) for v in values))
    OUT.write_text("\n".join(rows) + "\n")


if __name__ == "__main__":
    main()
