"""boxplus: state estimation on Lie groups. Where is it, and how sure are we?

>>> import boxplus as bp
>>> start = bp.SE3.identity()
>>> step = [1.0, 0.0, 0.0, 0.0, 0.0, 0.5]  # forward 1 m, turning left by 0.5 rad
>>> end = start + step + step
>>> (end - start).round(12)
array([2., 0., 0., 0., 0., 1.])
"""

from boxplus._core import Error, GraphError, LieError, NotFiniteError, ReadError, ShapeError, UncertaintyError, __version__
from boxplus._gaussian import Gaussian, Order, Side
from boxplus._group import Group, MatrixGroup
from boxplus._planar import SE2, SO2, Sim2
from boxplus._pose_graph import Edges, Format, Iteration, PoseGraph, Settings, Solution
from boxplus._spatial import SE3, SE23, SO3, Euler, SGal3, Sim3
from boxplus._vectors import R1, R2, R3, R4, R5, R6, Rn

__all__ = [
    "R1",
    "R2",
    "R3",
    "R4",
    "R5",
    "R6",
    "SE2",
    "SE23",
    "SE3",
    "SO2",
    "SO3",
    "Edges",
    "Error",
    "Euler",
    "Format",
    "Gaussian",
    "GraphError",
    "Group",
    "Iteration",
    "LieError",
    "MatrixGroup",
    "NotFiniteError",
    "Order",
    "PoseGraph",
    "ReadError",
    "Rn",
    "SGal3",
    "Settings",
    "ShapeError",
    "Sim2",
    "Sim3",
    "Side",
    "Solution",
    "UncertaintyError",
    "__version__",
]
