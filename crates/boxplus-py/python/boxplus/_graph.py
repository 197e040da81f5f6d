"""Factor graphs: variables and measurements from arrays, to the estimate that fits best."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Generic, TypeAlias, TypedDict, TypeVar, cast, overload

import numpy as np
import numpy.typing as npt

from boxplus import _core
from boxplus._gaussian import Gaussian
from boxplus._group import Group
from boxplus._numerical import numerical_jacobians
from boxplus._planar import SE2
from boxplus._spatial import SE3

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from typing_extensions import Unpack

    from boxplus._elements import Floats
    from boxplus._solving import Iteration, Options
    from boxplus._vectors import R2, R3

    Numbers: TypeAlias = npt.NDArray[np.uint32]

G = TypeVar("G", bound=Group)
P = TypeVar("P", bound=Group)
Q = TypeVar("Q", bound=Group)


class Certainty(TypedDict, total=False):
    """How sure measurements are, and how much they may pull. Exactly one of the first three, one for all or one for each."""

    sigmas: npt.ArrayLike
    """Standard deviations, ``(D,)`` or ``(N, D)``."""
    covariance: npt.ArrayLike
    """Covariances, ``(D, D)`` or ``(N, D, D)``."""
    information: npt.ArrayLike
    """Inverse covariances, ``(D, D)`` or ``(N, D, D)``."""
    robust: str
    """How much a large residual may pull: "none" (the default), "huber:1", "cauchy:2.5", ..., scales in standard deviations."""


class Variables(Generic[G]):
    """Variables of a graph, all of one group: what factors read, and what a solution is asked for. Indexing takes some of them."""

    __slots__ = ("_graph", "_group", "_numbers")

    def __init__(self, graph: Graph, group: type[G], numbers: Numbers) -> None:
        """Made by `Graph.variables` and `Graph.unknown`."""
        self._graph, self._group, self._numbers = graph, group, numbers

    @property
    def group(self) -> type[G]:
        """The group of their values."""
        return self._group

    def __len__(self) -> int:
        return len(self._numbers)

    def __getitem__(self, index: int | slice | Sequence[int] | npt.NDArray[Any]) -> Variables[G]:
        return Variables(self._graph, self._group, np.atleast_1d(self._numbers[index]))

    def __repr__(self) -> str:
        return f"Variables({len(self)} of {self._group.__name__})"


@dataclass(frozen=True)
class Factors:
    """Factors that were added together."""

    _graph: Graph
    _places: tuple[int, int]

    def __len__(self) -> int:
        return self._places[1] - self._places[0]


class Graph:
    """Variables, and what was measured of them. Whole arrays of factors are added at once.

    >>> import boxplus as bp
    >>> graph = bp.Graph()
    >>> corners = graph.unknown(bp.SE2, 4)
    >>> side = bp.SE2([1.0, 0.0], 1.5)  # ahead 1 m, then left by 1.5 rad
    >>> _ = graph.between(corners, corners[[1, 2, 3, 0]], side, sigmas=[0.1, 0.1, 0.05])
    >>> _ = graph.prior(corners[0], bp.SE2(), sigmas=[1e-3, 1e-3, 1e-3])
    >>> solution = graph.solve()
    >>> solution.converged, solution[corners].translation[2].round(1).tolist()
    (True, [1.0, 1.0])
    """

    __slots__ = ("_graph",)

    def __init__(self) -> None:
        """A graph without anything in it."""
        self._graph = _core.FactorGraph()

    def __repr__(self) -> str:
        variables, factors = self._graph.counts()
        return f"Graph({variables} variables, {factors} factors)"

    # Variables

    def variables(self, values: G) -> Variables[G]:
        """Adds variables with first estimates ``(N,)``; of a single element, one."""
        rows = values._numbers.reshape(-1, values.numbers)
        start = self._graph.add_variables(type(values).__name__, rows)
        return Variables(self, type(values), np.arange(start, start + len(rows), dtype=np.uint32))

    def unknown(self, group: type[G], count: int = 1) -> Variables[G]:
        """Adds variables without values: `solve` finds first estimates from displacements and sightings."""
        start = self._graph.declare(group.__name__, count)
        return Variables(self, group, np.arange(start, start + count, dtype=np.uint32))

    def fix(self, variables: Variables[Any]) -> None:
        """Holds variables where they are."""
        self._graph.hold(*self._named(variables), True)

    def release(self, variables: Variables[Any]) -> None:
        """Lets go of variables that were held."""
        self._graph.hold(*self._named(variables), False)

    # Factors

    def prior(self, x: Variables[G], mean: G, **certainty: Unpack[Certainty]) -> Factors:
        """X ≈ `mean`: residuals X ⊟ mean, D numbers, local."""
        return self._added(self._graph.add_priors(*self._named(x), x.group._same(mean), _certainty(certainty)))

    def between(self, a: Variables[G], b: Variables[G], measured: G, **certainty: Unpack[Certainty]) -> Factors:
        """A⁻¹·B ≈ `measured`: residuals A⁻¹B ⊟ measured, D numbers, local; position (m) before rotation (rad)."""
        kind, numbers = self._named(a)
        ends = numbers, self._named(b)[1]
        return self._added(self._graph.add_displacements(kind, *ends, a.group._same(measured), _certainty(certainty)))

    @overload
    def sighting(
        self, poses: Variables[SE2], points: Variables[R2], seen: npt.ArrayLike, **certainty: Unpack[Certainty]
    ) -> Factors: ...
    @overload
    def sighting(
        self, poses: Variables[SE3], points: Variables[R3], seen: npt.ArrayLike, **certainty: Unpack[Certainty]
    ) -> Factors: ...
    def sighting(
        self, poses: Variables[Any], points: Variables[Any], seen: npt.ArrayLike, **certainty: Unpack[Certainty]
    ) -> Factors:
        """X⁻¹·p ≈ `seen`, ``(N, P)``: points in the frames of poses, in metres."""
        ends = self._sight(poses, points)
        return self._added(self._graph.add_sightings(*ends, seen, _certainty(certainty)))

    def bearing(
        self, poses: Variables[Any], points: Variables[Any], measured: npt.ArrayLike, **certainty: Unpack[Certainty]
    ) -> Factors:
        """Where a point is seen from a pose: in the plane the angle from the x-axis, ``(N,)``, sigmas ``(1,)``; in space a direction
        ``(N, 3)`` of any length but 0, sigmas ``(2,)``. All in radians.
        """
        ends = self._sight(poses, points)
        return self._added(self._graph.add_bearings(*ends, measured, _certainty(certainty)))

    def range(
        self, a: Variables[Any], b: Variables[Any], measured: npt.ArrayLike, **certainty: Unpack[Certainty]
    ) -> Factors:
        """The distances ``(N,)`` in metres between poses or points, both of the plane or both of space; sigmas ``(1,)``."""
        (kind_a, numbers_a), (kind_b, numbers_b) = self._named(a), self._named(b)
        return self._added(
            self._graph.add_ranges((kind_a, kind_b), numbers_a, numbers_b, measured, _certainty(certainty))
        )

    def factor(
        self,
        variables: Sequence[Variables[Any]],
        residual: Callable[..., Any],
        *data: npt.ArrayLike | Group,
        jacobians: bool = False,
        relative: bool = False,
        **certainty: Unpack[Certainty],
    ) -> Factors:
        """Factors of your own over one to four variables each: ``residual(*values, *data)`` ≈ 0, ``(n, R)`` with R up to 9.

        `residual` is called with some of the factors at a time: elements ``(n,)`` of each of `variables`, and the rows of `data` that
        belong to them. With `jacobians` it returns ``(residual, *jacobians)``, the right (local) Jacobian by each variable, ``(n, R, D)``;
        else they are found by central differences. `relative` says that nothing changes where all variables are moved together as
        one rigid world.

        >>> import numpy as np, boxplus as bp
        >>> graph = bp.Graph()
        >>> x = graph.variables(bp.R2([[0.9, 0.2], [0.1, 2.0]]))
        >>> def radius(x, r):
        ...     return np.linalg.norm(x.vector, axis=-1, keepdims=True) - r[:, None]
        >>> _ = graph.factor([x], radius, [1.0, 2.0], sigmas=[0.1])
        >>> np.linalg.norm(graph.solve()[x].vector, axis=-1).round(6)
        array([1., 2.])
        """
        groups = [x.group for x in variables]
        rows = [x if isinstance(x, Group) else np.asarray(x) for x in data]

        def evaluate(start: int, stop: int, derive: bool, *numbers: Floats) -> Any:
            values = [group._of(row) for group, row in zip(groups, numbers, strict=True)]
            own = [row[start:stop] for row in rows]
            if jacobians:
                answer = residual(*values, *own)
                return answer if derive else answer[0]
            value = residual(*values, *own)
            if not derive:
                return value
            return value, *numerical_jacobians(lambda *moved: np.asarray(residual(*moved, *own)), *values)

        kind, array, robust = _certainty(certainty)
        size = array.shape[-1]
        named = [self._named(x) for x in variables]
        return self._added(self._graph.add_user_factors(named, size, evaluate, relative, (kind, array, robust)))

    # The estimate

    def solve(
        self, *, progress: Callable[[Iteration], object] | None = None, **options: Unpack[Options]
    ) -> GraphSolution:
        """The estimate of least cost. See `Options` for the keywords. Variables without values start where displacements and sightings
        say.

        `progress` is called with every trial step; where it returns False, or Ctrl-C is pressed, the search stops with the best
        estimate so far. Not converging is no exception: see `GraphSolution.termination`. Raises `GraphError` where the graph is faulty.
        """
        estimate, report = self._graph.solve({**options}, progress)
        return GraphSolution(self, estimate, **cast("dict[str, Any]", report))

    def cost(self) -> float:
        """½ Σ ρ(‖U·r‖²) at the first estimates."""
        return self._graph.cost(self._graph.initial())

    def _named(self, variables: Variables[Any]) -> tuple[str, Numbers]:
        if variables._graph is not self:
            raise ValueError("these variables belong to another graph")
        return variables.group.__name__, variables._numbers

    def _sight(self, poses: Variables[Any], points: Variables[Any]) -> tuple[bool, Numbers, Numbers]:
        kinds = self._named(poses)[0], self._named(points)[0]
        if kinds not in (("SE2", "R2"), ("SE3", "R3")):
            raise TypeError(f"expected poses SE2 and points R2, or SE3 and R3; not {kinds[0]} and {kinds[1]}")
        return kinds[0] == "SE2", poses._numbers, points._numbers

    def _added(self, places: tuple[int, int]) -> Factors:
        return Factors(self, places)


@dataclass(frozen=True, repr=False)
class GraphSolution:
    """An estimate of all variables, and how it was found. Indexing by variables gives their values."""

    graph: Graph
    """The graph that was solved."""
    _estimate: _core.Estimate
    cost: float
    """½ Σ ρ(‖U·r‖²) at the estimate."""
    initial_cost: float
    """That of the first estimate."""
    converged: bool
    """Whether a minimum was reached."""
    termination: str
    """Why the search stopped: "relative_cost", "gradient", "step", "max_iterations", "interrupted", ..."""
    initialisation: str
    """How the first estimate was made."""
    iterations: list[Iteration]
    """Every trial step."""
    held: list[str]
    """The variables that were held for lack of anything that says where the graph is."""
    unread: list[str]
    """Variables that no factor reads: they keep their values."""
    unconstrained: str | None
    """The directions that nothing constrains, in words."""
    unknowns: int
    """Free numbers."""
    seconds: dict[str, float]
    """Where the time went."""

    def __getitem__(self, variables: Variables[G]) -> G:
        """The values of variables, ``(N,)``."""
        return variables.group._of(self._estimate.get(*self.graph._named(variables)))

    def chi2(self, factors: Factors) -> Floats:
        """‖U·r‖² of each factor, ``(N,)``: χ² with as many degrees of freedom as its residual has numbers."""
        return self.graph._graph.chi2(self._estimate, factors._places)

    def gaussians(self, variables: Variables[G]) -> Gaussian[G]:
        """The marginals of variables, ``(N,)``: means and local covariances, relative to what is held."""
        marginals = self.graph._graph.marginals(self._estimate)
        covariances = marginals.covariances(self._estimate, *self.graph._named(variables))
        return Gaussian[G]._of(self[variables], covariances, "local")

    def joint_covariance(self, *variables: Variables[Any]) -> Floats:
        """The covariance of all given variables together, local each, in the order given, ``(ΣD, ΣD)``."""
        marginals = self.graph._graph.marginals(self._estimate)
        return marginals.joint(self._estimate, [self.graph._named(x) for x in variables])

    def to_dict(self) -> dict[str, Any]:
        """The report, ready for JSON."""
        return {key: value for key, value in vars(self).items() if key not in ("graph", "_estimate")}

    def __repr__(self) -> str:
        outcome = "converged" if self.converged else "not converged"
        lines = [
            f"{outcome} ({self.termination}) after {len(self.iterations)} steps, {self.seconds['total']:.3g} s",
            f"cost {self.cost:.10g}, from {self.initial_cost:.4g} ({self.initialisation})",
            f"{self.graph!r}, {self.unknowns} unknowns",
        ]
        lines += [f"held: {', '.join(self.held)}"] if self.held else []
        lines += [f"read by no factor: {', '.join(self.unread)}"] if self.unread else []
        lines += [f"unconstrained: {self.unconstrained}"] if self.unconstrained else []
        return "\n".join(lines)


def _certainty(given: Certainty) -> tuple[str, Floats, str]:
    """The one of sigmas, covariance and information that is given, as an array, and the kernel."""
    unknown = given.keys() - {"sigmas", "covariance", "information", "robust"}
    kinds = [kind for kind in ("sigmas", "covariance", "information") if kind in given]
    if unknown or len(kinds) != 1:
        raise TypeError("exactly one of sigmas, covariance and information, and perhaps robust")
    array = np.atleast_1d(np.asarray(cast("dict[str, Any]", given)[kinds[0]], dtype=np.float64))
    return kinds[0], array, given.get("robust", "none")
