"""boxplus: state estimation on Lie groups. Where is it, and how sure are we?

>>> import boxplus as bp
>>> start = bp.SE3.identity()
>>> step = [1.0, 0.0, 0.0, 0.0, 0.0, 0.5]  # forward 1 m, turning left by 0.5 rad
>>> end = start + step + step
>>> (end - start).round(12)
array([2., 0., 0., 0., 0., 1.])
"""

from boxplus import filters
from boxplus._core import Error, FilterError, GraphError, LieError, NotFiniteError, ReadError, ShapeError, UncertaintyError, __version__
from boxplus._gaussian import Gaussian, Order, Side
from boxplus._graph import Certainty, Factors, Graph, GraphSolution, Variables
from boxplus._group import Group, MatrixGroup
from boxplus._numerical import numerical_jacobians
from boxplus._planar import SE2, SO2, Sim2
from boxplus._pose_graph import Edges, Format, PoseGraph, Settings, Solution
from boxplus._solving import Iteration, Options
from boxplus._spatial import SE3, SE23, SO3, Euler, SGal3, Sim3
from boxplus._vectors import R1, R2, R3, R4, R5, R6, Rn

__all__ = [
    "Certainty",
    "Edges",
    "Error",
    "Euler",
    "Factors",
    "FilterError",
    "Format",
    "Gaussian",
    "Graph",
    "GraphError",
    "GraphSolution",
    "Group",
    "Iteration",
    "LieError",
    "MatrixGroup",
    "NotFiniteError",
    "Options",
    "Order",
    "PoseGraph",
    "R1",
    "R2",
    "R3",
    "R4",
    "R5",
    "R6",
    "ReadError",
    "Rn",
    "SE2",
    "SE23",
    "SE3",
    "SGal3",
    "SO2",
    "SO3",
    "Settings",
    "ShapeError",
    "Side",
    "Sim2",
    "Sim3",
    "Solution",
    "UncertaintyError",
    "Variables",
    "__version__",
    "filters",
    "numerical_jacobians",
]
