"""Pose graphs: from files and arrays, to their optimum."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from boxplus import _core
from boxplus._planar import SE2
from boxplus._solving import Options
from boxplus._spatial import SE3

if TYPE_CHECKING:
    from collections.abc import Callable

    from typing_extensions import Self, Unpack

    from boxplus._elements import Floats
    from boxplus._solving import Iteration

    Ids: TypeAlias = npt.NDArray[np.uint64]

Format: TypeAlias = Literal["g2o", "toro", "isam", "pyfg"]
"""The formats of files of pose graphs."""


class Settings(Options, total=False):
    """The keywords of `PoseGraph.solve`: `Options`, and these. All are optional."""

    chart: Literal["log", "g2o", "ceres", "se-sync"]
    """Whose cost is minimised: that of boxplus and GTSAM ("log", the default), g2o, Ceres or SE-Sync."""
    robust: str
    """How much a large residual may pull: "none" (the default), "huber:1", "cauchy:2.5", ..., scales in standard deviations; or
    "gnc-tls", "gnc-gm", which find false loop closures and leave them out."""
    fixed: list[int]
    """Vertices to hold, besides those that the graph holds."""
    indefinite: Literal["refuse", "clamp", "isotropic", "skip"]
    """What to do with an information matrix that is not positive definite; the default is to refuse the graph."""


class Edges(NamedTuple):
    """Displacements between poses: `measured` ≈ X_from⁻¹·X_to."""

    from_: Ids
    """The poses in whose frames they were measured, ``(N,)``."""
    to: Ids
    """The poses that were measured, ``(N,)``."""
    measured: SE2 | SE3
    """The measured displacements, ``(N,)``."""
    information: Floats
    """Their inverse covariances, local, translation first, ``(N, D, D)``."""


class PoseGraph:
    """Poses, and what was measured between them.

    >>> import boxplus as bp
    >>> steps = bp.SE2([[1.0, 0.0]] * 4, bp.SO2.from_angle([1.5] * 4))  # ahead 1 m, then left by 1.5 rad
    >>> graph = bp.PoseGraph()
    >>> graph.add_edges([0, 1, 2, 3], [1, 2, 3, 0], steps, sigmas=[0.1, 0.1, 0.05])  # the last one closes the loop
    >>> solution = graph.solve()
    >>> solution.converged, round(solution.cost, 3)
    (True, 4.01)
    """

    __slots__ = ("_graph",)

    def __init__(self) -> None:
        """A graph without anything in it."""
        self._graph = _core.PoseGraph()

    @classmethod
    def _of(cls, graph: _core.PoseGraph) -> Self:
        self = object.__new__(cls)
        self._graph = graph
        return self

    # Files

    @classmethod
    def read(cls, path: str | os.PathLike[str], format: Format | None = None) -> Self:
        """The graph of a file, plain or gzip. Without a `format` the content decides.

        Raises `ReadError`, with line and column, where the file is malformed.
        """
        return cls.parse(Path(path).read_bytes(), format, name=os.fspath(path))

    @classmethod
    def parse(cls, content: str | bytes, format: Format | None = None, *, name: str = "<string>") -> Self:
        """The graph of the content of a file; `name` appears in errors."""
        content = content.encode() if isinstance(content, str) else content
        return cls._of(_core.PoseGraph.parse(content, name, format)[0])

    def write(self, path: str | os.PathLike[str], format: Format = "g2o") -> None:
        """Writes a file. Numbers are the shortest decimals that read back as the same number."""
        Path(path).write_text(self.to_text(format), encoding="utf-8")

    def to_text(self, format: Format = "g2o") -> str:
        """What `write` writes."""
        return self._graph.print(format)

    # Arrays

    def add_poses(self, ids: npt.ArrayLike, poses: SE2 | SE3) -> None:
        """Adds poses with their initial values, `ids` being ``(N,)`` and `poses` ``(N,)``.

        A pose that only edges name needs none: it is found from them.
        """
        self._graph.add_poses(isinstance(poses, SE2), _ids(ids), poses._numbers)

    def add_edges(
        self,
        from_: npt.ArrayLike,
        to: npt.ArrayLike,
        measured: SE2 | SE3,
        *,
        information: npt.ArrayLike | None = None,
        sigmas: npt.ArrayLike | None = None,
    ) -> None:
        """Adds displacements, `measured` ≈ X_from⁻¹·X_to, ``(N,)`` each.

        How sure they are is either `information`, inverse covariances ``(D, D)`` or ``(N, D, D)``, or `sigmas`, standard deviations
        ``(D,)`` or ``(N, D)``; local, translation (m) before rotation (rad).
        """
        if (information is None) == (sigmas is None):
            raise TypeError("either information or sigmas, and not both")
        if sigmas is not None:
            deviations = np.asarray(sigmas, dtype=np.float64)
            if not np.all(deviations > 0.0):
                raise ValueError("a standard deviation must be positive")
            information = deviations[..., None] ** -2 * np.eye(measured.dimension)
        self._graph.add_edges(isinstance(measured, SE2), _ids(from_), _ids(to), measured._numbers, information)

    def fix(self, ids: npt.ArrayLike) -> None:
        """Holds these vertices where they are."""
        self._graph.fix(_ids(ids))

    def copy(self) -> Self:
        """A graph of its own."""
        return self._of(self._graph.copy())

    @property
    def ids(self) -> Ids:
        """The ids of the poses, ``(N,)``, in the order of the file."""
        return self._graph.poses(self._is_planar())[0]

    @property
    def poses(self) -> SE2 | SE3:
        """The poses `world_from_body`, ``(N,)``, in the order of `ids`."""
        planar = self._is_planar()
        return _poses(planar, self._graph.poses(planar)[1])

    @property
    def edges(self) -> Edges:
        """The displacements between poses."""
        planar = self._is_planar()
        from_, to, measured, information = self._graph.edges(planar)
        return Edges(from_, to, _poses(planar, measured), information)

    @property
    def fixed(self) -> Ids:
        """The ids of the vertices that are held."""
        return self._graph.fixed()

    def _is_planar(self) -> bool:
        planar, spatial = self._graph.dimensions()
        if planar and spatial:
            raise ValueError("the graph has poses of the plane and poses of space; it can only be solved and written as a whole")
        return planar

    def __repr__(self) -> str:
        planar, spatial, points, measurements, fixed = self._graph.counts()
        counts = [(planar, "poses in the plane"), (spatial, "poses in space"), (points, "points")]
        parts = [f"{count} {what}" for count, what in counts if count]
        return f"PoseGraph({', '.join([*parts, f'{measurements} measurements'])}{f', {fixed} fixed' if fixed else ''})"

    # The optimum

    def solve(self, *, progress: Callable[[Iteration], object] | None = None, **settings: Unpack[Settings]) -> Solution:
        """The optimum: initialises, optimises, and judges the result. See `Settings` for the keywords.

        `progress` is called with every trial step; where it returns False, or Ctrl-C is pressed, the search stops with the best
        estimate so far. Not converging is no exception: see `Solution.termination`. Raises `GraphError` where the graph is faulty.
        """
        graph, report = self._graph.solve({**settings}, progress)  # type: ignore[arg-type]  # pyright: ignore
        return Solution(PoseGraph._of(graph), _settings=dict(settings), **report)

    def chi2(self, **settings: Unpack[Settings]) -> Floats:
        """χ² of every measurement at the poses that the graph holds, ``(M,)``, in the order of the file; NaN where it is left out."""
        return self._graph.chi2({**settings})


@dataclass(frozen=True, repr=False)
class Solution:
    """An optimum, and how good it is."""

    graph: PoseGraph
    """The graph with its poses at the optimum."""
    cost: float
    """The objective at the optimum, as the tool of the chart counts it, with the kernel."""
    initial_cost: float
    """That of the first estimate."""
    converged: bool
    """Whether a minimum was reached."""
    termination: str
    """Why the search stopped: "relative_cost", "gradient", "step", "max_iterations", "interrupted", ..."""
    initialisation: str
    """How the first estimate was made."""
    costs: dict[str, float]
    """What four tools would print for this optimum, without kernel: "log" (boxplus, GTSAM), "g2o", "ceres", "se_sync"."""
    iterations: list[Iteration]
    """Every trial step."""
    held: list[str]
    """The poses that were held for lack of anything that says where the graph is."""
    unconstrained: str | None
    """The directions that nothing constrains, in words."""
    parts: int
    """Parts of the graph that no measurement joins."""
    unknowns: int
    """Free numbers."""
    rejected: npt.NDArray[np.uint64]
    """With `robust="gnc-tls"`: the measurements found to be false, as places among all of them."""
    chi2: Floats
    """χ² of every measurement, ``(M,)``, in the order of the file; NaN where it was left out."""
    seconds: dict[str, float]
    """Where the time went."""
    _settings: dict[str, object] = field(default_factory=dict[str, object])

    @property
    def ids(self) -> Ids:
        """The ids of the poses, ``(N,)``."""
        return self.graph.ids

    @property
    def poses(self) -> SE2 | SE3:
        """The poses `world_from_body` at the optimum, ``(N,)``, in the order of `ids`."""
        return self.graph.poses

    def position_covariances(self, ids: npt.ArrayLike | None = None) -> tuple[Ids, Floats]:
        """Covariances of positions in the world frame, ``(K, 3, 3)`` in m² (zero in z for the plane), relative to what is held.

        Returned with the ids ``(K,)`` they belong to: those of `ids`, by default of all poses, that measurements read.
        """
        wanted = self.ids if ids is None else _ids(ids)
        return self.graph._graph.position_covariances(wanted, self._settings)

    def to_dict(self) -> dict[str, Any]:
        """All numbers but the graph, ready for JSON."""
        told = {key: value for key, value in vars(self).items() if key not in ("graph", "_settings")}
        return told | {"rejected": self.rejected.tolist(), "chi2": self.chi2.tolist()}

    def __repr__(self) -> str:
        outcome = "converged" if self.converged else "not converged"
        lines = [
            f"{outcome} ({self.termination}) after {len(self.iterations)} steps, {sum(self.seconds.values()):.3g} s",
            f"cost {self.cost:.10g}, from {self.initial_cost:.4g} ({self.initialisation})",
            f"{self.graph!r}, {self.unknowns} unknowns",
        ]
        lines += [f"held: {', '.join(self.held)}"] if self.held else []
        lines += [f"unconstrained: {self.unconstrained}"] if self.unconstrained else []
        lines += [f"{len(self.rejected)} measurements found to be false"] if len(self.rejected) else []
        return "\n".join(lines)


def _poses(planar: bool, numbers: Floats) -> SE2 | SE3:
    numbers.flags.writeable = False
    return SE2._of(numbers) if planar else SE3._of(numbers)


def _ids(ids: npt.ArrayLike) -> Ids:
    given = np.atleast_1d(np.asarray(ids))
    if given.ndim != 1 or not (np.issubdtype(given.dtype, np.integer) or given.size == 0) or np.any(given < 0):
        raise ValueError(f"ids are whole numbers from 0, in one row; not {given.dtype} of shape {given.shape}")
    return np.ascontiguousarray(given, dtype=np.uint64)
