"""The tables: to standard output, and into the documents where asked."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

from inputs import GROUPS, SCALARS
from truth import OPERATIONS as JUDGED

PLAIN = ("exp", "log", "inverse", "compose", "between", "act", "rplus", "rminus", "adjoint", "jr", "jr_inv")
JACOBIANS = tuple(f"{name}_jac" for name in PLAIN[:8])
NAMES = {"jr": "J_r", "jr_inv": "J_r⁻¹", "adjoint": "Ad"}
TOLERANCE = {"f64": 1e-9, "f32": 2e-3}  # of results that are timed, to ours; the other document has their accuracy
BEGIN, END = "<!-- groups: written by benches/groups/run --docs docs -->", "<!-- groups: end -->"

_FIGURES = (
    ("speed", "least", "nanoseconds per operation"),
    ("speed", "instructions", "instructions per operation"),
    ("native", "least", "nanoseconds per operation, everything compiled for this machine alone"),
)

Cells = dict[str, dict[str, Any]]  # by operation, by library


def write(results: dict[str, Any], docs: Path | None) -> None:
    """All tables, from every figure; of a part that was never measured, none."""
    documents: dict[str, str] = {}
    if "accuracy" in results:
        documents["accuracy-peers.md"] = accuracy_document(results)
    if "speed" in results:
        documents["speed-peers.md"] = speed_document(results)
        documents["benchmarks.md"] = speed_section(results)
    for name, text in documents.items():
        if docs is None:
            print(f"{text}\n")
        elif name == "benchmarks.md":
            before, _, rest = (docs / name).read_text(encoding="utf-8").partition(BEGIN)
            after = rest.partition(END)[2]
            (docs / name).write_text(f"{before}{BEGIN}\n{text}\n{END}{after}", encoding="utf-8")
        else:
            (docs / name).write_text(text, encoding="utf-8")


def table(header: list[str], rows: list[list[str]]) -> str:
    """In Markdown."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _operation(name: str) -> str:
    stem = name.removesuffix("_jac")
    return NAMES.get(stem, stem) + (" with Jacobians" if name != stem else "")


def _what_ran(results: dict[str, Any]) -> str:
    versions = ", ".join(f"{key} {version}" for key, version in results["versions"].items())
    missing = "".join(f"\n- {key} is not here: {reason}" for key, reason in results["missing"].items())
    return f"Versions: {versions}.{missing}"


# Accuracy


def accuracy_document(results: dict[str, Any]) -> str:
    """One table a scalar: the worst error of each operation of each library."""
    parts = [_ACCURACY_HEAD, _what_ran(results)]
    for scalar in SCALARS:
        cells = {name: row for name, row in results["accuracy"].items() if name.split(".")[1] == scalar}
        keys = [key for key in results["versions"] if any(key in row for row in cells.values())]
        rows = []
        for group in GROUPS:
            for operation in JUDGED:
                row = cells.get(f"{group}.{scalar}.{operation}", {})
                rows.append([f"{group} {_operation(operation)}", *(_error(row.get(key)) for key in keys)])
        parts += [f"## `{scalar}`, ε = {'2⁻⁵²' if scalar == 'f64' else '2⁻²³'}", table(["", *keys], rows)]
    return "\n\n".join([*parts, _ACCURACY_NOTES]) + "\n"


def _error(worst: dict[str, Any] | None) -> str:
    if worst is None:
        return ""
    error, theta = worst["error"], worst["theta"]
    if error < 9.95:
        return f"{error:.1f}"
    if not math.isfinite(error):
        return f"NaN @ {_angle(theta)}"
    return f"{f'{error:.0f}' if error < 1000 else _power(error)} @ {_angle(theta)}"


def _power(x: float) -> str:
    return re.sub(r"e[+]?(-?)0*", r"e\1", f"{x:.0e}")


def _angle(theta: float) -> str:
    if 0 < math.pi - theta < 0.02:
        return f"π−{_power(math.pi - theta)}"
    return _power(theta) if theta < 0.1 else f"{theta:.2g}"


# Speed


def _fastest(cells: dict[str, Any], figure: str, scalar: str) -> tuple[float, str] | None:
    """The best figure of any peer that computes the same."""
    found = [
        (_figure(cell, figure), key)
        for key, cell in cells.items()
        if key not in ("boxplus", "gtsam", "jaxlie", "symforce") and cell["differs"] <= TOLERANCE[scalar]
    ]
    found = [(value, key) for value, key in found if math.isfinite(value)]
    return min(found) if found else None


def _figure(cell: dict[str, Any], figure: str) -> float:
    if figure == "instructions":
        return float(cell.get("instructions", math.inf))
    return min(cell["least"], default=math.inf)


def speed_section(results: dict[str, Any]) -> str:
    """Ours beside the fastest peer of each operation, and where the goals are missed."""
    parts = [_SPEED_HEAD.format(**_machine(results)), _what_ran(results)]
    for scalar in SCALARS:
        for part, figure, unit in (f for f in _FIGURES if f[0] in results):
            rows = []
            for name in (*PLAIN, *JACOBIANS):
                cells = (_against(results[part], f"{group}.{scalar}.{name}", figure) for group in GROUPS)
                rows.append([_operation(name), *cells])
            parts += [f"**`{scalar}`, {unit}**", table(["", *GROUPS], rows)]
    texts = [*parts, *batches(results["speed"]), goals(results["speed"]), misses(results)]
    return "\n\n".join(text for text in texts if text)


def batches(speed: Cells) -> list[str]:
    """Nanoseconds per element of whole slices, beside the fastest peer's loop and jaxlie's batch."""
    parts = []
    for scalar in SCALARS:
        rows = []
        for operation in (*PLAIN, *JACOBIANS):
            names = [f"{group}.{scalar}.{operation}" for group in GROUPS]
            if any("boxplus" in speed.get(f"{name}_batch", {}) for name in names):
                rows.append([_operation(operation), *(_batch(speed, name, scalar) for name in names)])
        if rows:
            parts += [_BATCH_HEAD.format(scalar=scalar), table(["", *GROUPS], rows)]
    return parts


def goals(speed: Cells) -> str:
    """How many times an element of a batch takes the fastest peer has for one call, on SE(3), beside what was aimed at."""
    parts = []
    for aim, operations in ((5, ("exp", "log", "rminus")), (20, ("exp_jac", "log_jac", "rminus_jac"))):
        for scalar in SCALARS:
            reached = []
            for name in (f"SE3.{scalar}.{operation}" for operation in operations):
                ours = _figure(speed.get(f"{name}_batch", {}).get("boxplus", {"least": []}), "least")
                best = _fastest(speed.get(name, {}), "least", scalar)
                if best and math.isfinite(ours):
                    ratio = best[0] / ours
                    shown = f"{ratio:.0f}×" if ratio > 9.95 else f"{ratio:.1f}×"
                    reached.append(f"{_operation(name.split('.')[2])} {shown if ratio >= aim else f'**{shown}**'}")
            if reached:
                parts.append(f"aim {aim}×, `{scalar}`: {', '.join(reached)}")
    return f"Batches of SE(3) beside the fastest peer's loop, {'; '.join(parts)}. {_GOAL_NOTES}" if parts else ""


def _batch(speed: Cells, name: str, scalar: str) -> str:
    ours = _figure(speed.get(f"{name}_batch", {}).get("boxplus", {"least": []}), "least")
    if not math.isfinite(ours):
        return ""
    texts = [f"{ours:.1f}"]
    best = _fastest(speed.get(name, {}), "least", scalar)
    jaxlie = _figure(speed.get(name, {}).get("jaxlie", {"least": []}), "least")
    for value, key in ([best] if best else []) + [(jaxlie, "jaxlie")] * math.isfinite(jaxlie):
        texts.append(f"{value / ours:.1f}× {key}")
    return texts[0] if len(texts) == 1 else f"{texts[0]} ({', '.join(texts[1:])})"


def _machine(results: dict[str, Any]) -> dict[str, str]:
    machine = dict(results["machine"])
    return {"date": machine.pop("date"), "machine": ", ".join(str(value) for value in machine.values() if value)}


def _against(speed: Cells, name: str, figure: str) -> str:
    cells = speed.get(name, {})
    if "boxplus" not in cells or not math.isfinite(ours := _figure(cells["boxplus"], figure)):
        return ""
    shown = f"{ours:.1f}" if figure == "least" and ours < 99.95 else f"{ours:.0f}"
    best = _fastest(cells, figure, name.split(".")[1])
    if best is None:
        return shown
    ratio = best[0] / max(ours, 0.1)
    return f"{shown} ({f'**{ratio:.2f}**' if ratio < 0.95 else f'{ratio:.1f}'}× {best[1]})"


def misses(results: dict[str, Any]) -> str:
    """Operations where a peer is faster, by time and by instructions, and the goal of SE(3) ⊖."""
    rows, compared = [], 0
    for name, cells in results["speed"].items():
        group, scalar, operation = name.split(".")
        best = {figure: _fastest(cells, figure, scalar) for figure in ("least", "instructions")}
        if best["least"] is None or "boxplus" not in cells or operation.endswith("_batch"):
            continue
        compared += 1
        ours = {figure: _figure(cells["boxplus"], figure) for figure in best}
        behind = [figure for figure, peer in best.items() if peer and peer[0] < 0.95 * ours[figure]]
        if behind:
            texts = [f"{ours[figure]:.3g} : {peer[0]:.3g} ({peer[1]})" if peer else "" for figure, peer in best.items()]
            rows.append([f"`{scalar}` {group} {_operation(operation)}", *texts])
    goal = [f"`{s}` {_against(results['speed'], f'SE3.{s}.rminus_jac', 'least')}" for s in SCALARS]
    head = (
        f"Of {compared} operations that a peer has too, these {len(rows)} are more than 5 % slower than the fastest "
        f"peer's, by nanoseconds or by instructions. SE(3) `rminus` with both Jacobians, goal 5×: {'; '.join(goal)}."
    )
    return f"{head}\n\n" + table(["ours : the fastest peer's", "nanoseconds", "instructions"], rows) + f"\n\n{_WHY}"


def speed_document(results: dict[str, Any]) -> str:
    """Every figure of every library."""
    parts = [_DETAIL_HEAD, _what_ran(results)]
    for scalar in SCALARS:
        for group in GROUPS:
            names = [f"{group}.{scalar}.{operation}" for operation in (*PLAIN, *JACOBIANS)]
            cells = {name: results["speed"][name] for name in names if name in results["speed"]}
            keys = [key for key in results["versions"] if any(key in row for row in cells.values())]
            rows = [
                [_operation(name.split(".")[2]), *(_times(row.get(key), key, scalar) for key in keys)]
                for name, row in cells.items()
            ]
            parts += [f"## {group}, `{scalar}`", table(["", *keys], rows)]
    return "\n\n".join(parts) + "\n"


def _times(cell: dict[str, Any] | None, key: str, scalar: str) -> str:
    if cell is None or not cell["least"]:
        return ""
    wrong = "†" if cell["differs"] > TOLERANCE[scalar] else ""
    counted = f" / {cell['instructions']:.0f}" if "instructions" in cell else ""
    median = sorted(cell["median"])[len(cell["median"]) // 2]
    return f"{min(cell['least']):.1f} ({median:.1f}){counted}{wrong}"


_ACCURACY_HEAD = """# Accuracy beside the peers

The largest error of each operation, in units of ε of the scalar, over one grid of inputs for all libraries: θ
from 10⁻¹² to π − 10⁻¹⁰ (`f32`: to π − 10⁻⁶), four angles a decade where the libraries change formulas, rotation
axes generic and parallel to ρ, ρ of 10⁻³, 1 and 10³ m, log-scales from 0 to 1.1. The truth has 66 digits and is
computed by power series and definition, not by closed forms. Errors are normwise and block by block (position,
rotation, velocity, …; for matrices each block over its own norm); an error above 10 stands with the angle it is
at. 4.5e15 ε is an error of 100 % in `f64`, 8e6 ε in `f32`. An empty cell: the library has no such operation.
`benches/groups/run --skip speed --docs docs` measures again and writes this file; the bounds that tests hold
boxplus to are in [`accuracy.md`](accuracy.md)."""

_ACCURACY_NOTES = """## What is behind the large ones

J_r is J_l(−τ) where a library has the left one. J_r⁻¹ of jaxlie and GTSAM is the derivative of Log at Exp τ.

- Formulas of order θ⁻² … θ⁻⁵ used down to a threshold near machine precision: manif, Sophus, smooth, GTSAM's Pose2
  and jaxlie at θ from 10⁻⁸ to 10⁻³; cotangent forms that lose digits near π: manif, apex-manifolds, GTSAM.
- sophus_lie's series of the left Jacobians below θ = 10⁻³ are those of the right ones: the error is θ itself.
- factrs takes SE(2) exp and log as if the angle were zero wherever it is negative; its SE₂(3) log uses the wrong
  Jacobian for position and velocity; its SE(2) adjoint indexes out of bounds and is left out.
- glam's logarithm is that of the rotation by up to 2π, not the shortest, and zero where 1 − w² rounds to zero.
- SymForce's maps are off by its ε near the identity by design; its poses are products SO(n)×ℝⁿ and are not compared
  as such.
- apex-manifolds' SGal3 composes by p₁ + R₁(p₂ + t₁v₂), another group than the Galilean one, and is left out.
- Sophus, nalgebra and apex-manifolds store the scale and not its logarithm; σ counts relative to the larger of 1 and
  |σ|."""

_SPEED_HEAD = """## Groups, beside the peers

{date}, {machine}. Nanoseconds per call, the least over interleaved rounds on one core, over 1024 inputs that
vary and with results kept in memory; and instructions per call by callgrind, which no noise touches. Everything
is compiled for any x86-64, Rust at level 3 with fat LTO, C++ with `-O3 -DNDEBUG`. In brackets: how many times
ours the fastest peer takes, bold where it takes less. A peer counts where its results are ours to 10⁻⁹ (`f32`:
2·10⁻³). One command measures all again and writes this section, [`speed-peers.md`](speed-peers.md) with every
library's figures, and [`accuracy-peers.md`](accuracy-peers.md):

```sh
benches/groups/run --docs docs
```"""

_BATCH_HEAD = """**`{scalar}`, nanoseconds per element of a batch**, one call on 1024 elements, one thread,
instructions chosen at run time. In brackets: the fastest peer's loop, and jaxlie's jit on 10⁵, as multiples."""

_GOAL_NOTES = """Bold misses it. With Jacobians a batch writes 42 to 78 numbers an element, and most of
its instructions are their layout. With fat link-time optimisation, as here, LLVM packs pairs of numbers within an
element before it looks at loops over elements, and leaves the logarithms in `f64` as they are; with the thin one
of this workspace it does not (*Batches of groups*, above)."""

_WHY = """Why:

- compose, between, inverse and act of SO(2) to SE(3), by 0.1 to 3 ns: a product is brought back to unit norm, some ten
  instructions, so that 10⁷ of them stay on the group; glam has an affine matrix of twelve numbers, and vectors of `f32`.
- Ad and Jacobians of SO(2), by 0.1 ns: our 1 goes through memory as the matrices of all groups do.
- exp, log and J_r of SE(2): ours keep the last digit at every angle. The quotients of manif and Sophus, which share a sine and
  a cosine, have an error of 10⁶ to 10⁹ ε at small ones ([`accuracy-peers.md`](accuracy-peers.md)).
- Sim(2), Sim(3): the logarithm of the scale is kept, so that scales neither drift nor overflow; what moves a point pays
  one exponential. Exp and Log of apex-manifolds and Sophus are wrong by 10⁷ to 10¹⁰ ε at small angles."""

_DETAIL_HEAD = """# Groups: every figure

Nanoseconds per call, least (median of medians) / instructions, as [`benchmarks.md`](benchmarks.md) explains;
written by `benches/groups/run --docs docs`. † results differ from ours by more than 10⁻⁹ (`f32`: 2·10⁻³):
timed, but not compared. jaxlie: jit, nanoseconds per element of a batch of 10⁵ on one thread. GTSAM: calls from
Python, whose overhead is most of it; `between`, `rminus`, `exp_jac`, … of libraries without such a function are
composed from their parts as a user must."""
