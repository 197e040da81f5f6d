#!/usr/bin/env python3
"""What other libraries compute from a tangent in their own order: crates/boxplus/tests/reference/tangent_orders.csv

    pip install gtsam && python3 scripts/tangent_orders.py                     # GTSAM 4.3
    pip install sophuspy 'numpy<2' && python3 scripts/tangent_orders.py        # Sophus (an environment of its own: it crashes with NumPy 2)
    MANIF=path/to/manif python3 scripts/tangent_orders.py                      # manif: headers, with g++ and Eigen
    PYLGMATH=path/to/pylgmath python3 scripts/tangent_orders.py                # lgmath, of Barfoot's group

Rows of libraries that are not there stay as they are. A row has the tangent, then what the library's accessors say of its
Exp: rotation matrix by rows, position (of a similarity: where the origin goes), velocity, the last coordinate (time, or
the logarithm of the scale), and the adjoint matrix by rows. Numbers within a column are separated by spaces.
"""
import math
import os
import random
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

OUT = Path(__file__).resolve().parent.parent / "crates/boxplus/tests/reference/tangent_orders.csv"
HEADER = "library,group,tangent,rotation,position,velocity,last,adjoint"
SAMPLES = 4


def tangents(dimension):
    rng = random.Random(dimension)
    return [[round(rng.uniform(-0.9, 0.9), 3) for _ in range(dimension)] for _ in range(SAMPLES)]


def row(library, group, tangent, rotation, position, velocity=(), last=(), adjoint=()):
    columns = [np.asarray(c, dtype=float).ravel() for c in (tangent, rotation, position, velocity, last, adjoint)]
    return ",".join([library, group] + [" ".join(repr(float(x)) for x in c) for c in columns])


def gtsam_rows():
    import gtsam

    for tau in tangents(3):
        x = gtsam.Pose2.Expmap(np.array(tau))
        yield row("gtsam", "Pose2", tau, x.rotation().matrix(), x.translation(), adjoint=x.AdjointMap())
    for tau in tangents(6):
        x = gtsam.Pose3.Expmap(np.array(tau))
        yield row("gtsam", "Pose3", tau, x.rotation().matrix(), x.translation(), adjoint=x.AdjointMap())
    for tau in tangents(9):
        x = gtsam.NavState.Expmap(np.array(tau))
        yield row("gtsam", "NavState", tau, x.attitude().matrix(), x.position(), x.velocity(), adjoint=x.AdjointMap())
    for tau in tangents(10):
        x = gtsam.Gal3.Expmap(np.array(tau))
        yield row("gtsam", "Gal3", tau, x.rotation().matrix(), x.position(), x.velocity(), x.time(), x.AdjointMap())
    for tau in tangents(4):
        x = gtsam.Similarity2.Expmap(np.array(tau))
        origin = x.transformFrom(np.zeros(2))
        yield row("gtsam", "Similarity2", tau, x.rotation().matrix(), origin, (), math.log(x.scale()), x.AdjointMap())
    for tau in tangents(7):
        x = gtsam.Similarity3.Expmap(np.array(tau))
        origin = x.transformFrom(np.zeros(3))
        yield row("gtsam", "Similarity3", tau, x.rotation().matrix(), origin, (), math.log(x.scale()), x.AdjointMap())


def sophus_rows():
    import sophuspy

    for name, dimension in (("SE2", 3), ("SE3", 6)):
        for tau in tangents(dimension):
            x = getattr(sophuspy, name).exp(np.array(tau))
            yield row("sophus", name, tau, x.rotationMatrix(), x.translation())


def lgmath_rows():
    sys.path.insert(0, os.environ["PYLGMATH"])
    from pylgmath.se3 import operations as se3

    for tau in tangents(6):
        xi = np.array(tau).reshape(6, 1)
        m = se3.vec2tran(xi)
        yield row("lgmath", "SE3", tau, m[:3, :3], m[:3, 3], adjoint=se3.tranAd(m))


MANIF = """
#include <iostream>
#include <manif/manif.h>
template <class M> void print(const M& m) {
  for (int i = 0; i < m.rows(); ++i) for (int j = 0; j < m.cols(); ++j) std::cout << m(i, j) << ' ';
  std::cout << ',';
}
template <class T> auto read() {
  typename T::DataType x;
  for (int i = 0; i < x.size(); ++i) std::cin >> x(i);
  return T(x).exp();
}
int main() {
  std::cout.precision(17);
  std::string group;
  while (std::cin >> group) {
    if (group == "SE2") { auto x = read<manif::SE2Tangentd>(); print(x.rotation()); print(x.translation()); std::cout << ",,"; print(x.adj()); }
    if (group == "SE3") { auto x = read<manif::SE3Tangentd>(); print(x.rotation()); print(x.translation()); std::cout << ",,"; print(x.adj()); }
    if (group == "SE_2_3") { auto x = read<manif::SE_2_3Tangentd>(); print(x.rotation()); print(x.translation()); print(x.linearVelocity()); std::cout << ","; print(x.adj()); }
    if (group == "SGal3") { auto x = read<manif::SGal3Tangentd>(); print(x.rotation()); print(x.translation()); print(x.linearVelocity()); std::cout << x.t() << ','; print(x.adj()); }
    std::cout << std::endl;
  }
}
"""


def manif_rows():
    root = Path(os.environ["MANIF"])
    inputs = [(g, tau) for g, d in (("SE2", 3), ("SE3", 6), ("SE_2_3", 9), ("SGal3", 10)) for tau in tangents(d)]
    with tempfile.TemporaryDirectory() as folder:
        source, program = Path(folder) / "orders.cpp", Path(folder) / "orders"
        source.write_text(MANIF)
        includes = [f"-I{root}/include", f"-I{root}/external/tl", "-I/usr/include/eigen3"]
        subprocess.run(["g++", "-O1", "-std=c++17", *includes, str(source), "-o", str(program)], check=True)
        text = "\n".join(" ".join([g, *map(repr, tau)]) for g, tau in inputs)
        out = subprocess.run([str(program)], input=text, capture_output=True, text=True, check=True).stdout
    for (group, tau), line in zip(inputs, out.splitlines(), strict=True):
        columns = [c.split() for c in line.split(",")]
        yield row("manif", group, tau, *columns[:5])


def main():
    rows = {}
    if OUT.exists():
        for line in OUT.read_text().splitlines()[1:]:
            rows.setdefault(line.split(",")[0], []).append(line)
    for library, make in (("gtsam", gtsam_rows), ("lgmath", lgmath_rows), ("manif", manif_rows), ("sophus", sophus_rows)):
        try:
            rows[library] = list(make())
            print(f"{library}: {len(rows[library])} rows")
        except (ImportError, KeyError) as missing:
            print(f"{library}: not here ({missing}), its rows stay")
    OUT.write_text("\n".join([HEADER, *(line for library in sorted(rows) for line in rows[library])]) + "\n")


if __name__ == "__main__":
    main()
