"""How a search for the best estimate is steered, and what it tells."""

from __future__ import annotations

from typing import Literal, TypedDict


class Iteration(TypedDict):
    """One trial step of a solve, as `progress` is told of it."""

    cost: float
    """Cost of the estimate after this trial."""
    decrease: float
    """Cost before, less the cost that the trial reached."""
    gain: float
    """The actual decrease over the one that the linear model promised."""
    damping: float
    """λ of Levenberg-Marquardt, or the trust radius of dogleg."""
    gradient: float
    """The largest slope along a coordinate, in its standard deviations."""
    step: float
    """The largest move of a coordinate, in its standard deviations."""
    accepted: bool
    """Whether the estimate moved."""
    seconds: float
    """Since the solve began."""


class Options(TypedDict, total=False):
    """The keywords of `Graph.solve`, and of every other. All are optional."""

    initial: Literal["auto", "as_given", "spanning_tree", "chordal", "grown"]
    """Where to start; "auto", the default, is whichever costs least."""
    algorithm: Literal["levenberg_marquardt", "gauss_newton", "dogleg"]
    """How the optimiser moves; the first is the default."""
    max_iterations: int
    """Trial steps at most; 100."""
    relative_cost: float
    """Stop when a step lowers the cost by less than this share of it; 1e-9."""
    gradient: float
    """Stop when no coordinate alone could gain this many standard deviations; 1e-9."""
    step: float
    """Stop when no coordinate moves by this many standard deviations; 1e-9."""
    threads: int
    """Threads that linearise, 0 for one per core. No bit of the result depends on it."""
