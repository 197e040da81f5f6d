"""Groups of space: SO(3), SE(3), SE₂(3), Sim(3), SGal(3)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from boxplus import _core
from boxplus._elements import joined, number
from boxplus._group import MatrixGroup

if TYPE_CHECKING:
    from scipy.spatial.transform import RigidTransform, Rotation
    from typing_extensions import Self

    from boxplus._elements import Floats, Scalars

Euler: TypeAlias = Literal[
    "XYX", "XYZ", "XZX", "XZY", "YXY", "YXZ", "YZX", "YZY", "ZXY", "ZXZ", "ZYX", "ZYZ",
    "xyx", "xyz", "xzx", "xzy", "yxy", "yxz", "yzx", "yzy", "zxy", "zxz", "zyx", "zyz",
]  # fmt: skip
"""The 24 sequences of Euler angles: capitals about the moving axes, small letters about the fixed ones."""


class SO3(MatrixGroup):
    """Rotations of space, stored as a unit quaternion (x, y, z, w) of Hamilton, **w last**.

    A tangent is the rotation vector φ in radians, in the local frame. q and -q are one rotation, and ``==`` knows it.
    ``SO3()`` is the identity.

    >>> import boxplus as bp
    >>> bp.SO3.from_euler("ZYX", [3.141592653589793 / 2, 0.0, 0.0]).to_quat_wxyz().round(3)
    array([0.707, 0.   , 0.   , 0.707])
    """

    __slots__ = ()

    dimension, numbers, point_dimension = 3, 4, 3
    fields = (("xyzw", 4),)
    _operations, _matrices = _core.SO3, _core.SO3_matrices

    def __init__(self) -> None:
        self._numbers = type(self).identity()._numbers

    # Quaternions

    @classmethod
    def from_quat_xyzw(cls, q: npt.ArrayLike) -> Self:
        """The rotations of quaternions x, y, z, w, ``(..., 4)``, of any norm but 0: the order of ROS, TUM files and SciPy."""
        return cls._of(_core.rotations.from_xyzw(q))

    @classmethod
    def from_quat_xyzw_jac(cls, q: npt.ArrayLike) -> tuple[Self, Floats]:
        """`from_quat_xyzw` and its right Jacobian, ``(..., 3, 4)``."""
        value, d_q = _core.rotations.from_xyzw_jac(q)
        return cls._of(value), d_q

    @classmethod
    def from_quat_wxyz(cls, q: npt.ArrayLike) -> Self:
        """The rotations of quaternions w, x, y, z, ``(..., 4)``, of any norm but 0: the order of Eigen's constructor and COLMAP."""
        return cls._of(_core.rotations.from_wxyz(q))

    @classmethod
    def from_quat_jpl_xyzw(cls, q: npt.ArrayLike) -> Self:
        """The rotations of quaternions of JPL's convention (ij = -k), ``(..., 4)``, w last."""
        return cls._of(_core.rotations.from_jpl_xyzw(q))

    def to_quat_xyzw(self) -> Floats:
        """The unit quaternions x, y, z, w, ``(..., 4)``, with the sign that is stored."""
        return self.to_array()

    def to_quat_xyzw_jac(self) -> tuple[Floats, Floats]:
        """The quaternions x, y, z, w and their right Jacobian, ``(..., 4, 3)``."""
        return _core.rotations.to_xyzw_jac(self._numbers)

    def to_quat_wxyz(self) -> Floats:
        """The unit quaternions w, x, y, z, ``(..., 4)``, with the sign that is stored."""
        return _core.rotations.to_wxyz(self._numbers)

    def to_quat_jpl_xyzw(self) -> Floats:
        """The unit quaternions of JPL's convention, ``(..., 4)``, w last."""
        return _core.rotations.to_jpl_xyzw(self._numbers)

    # Vectors and angles

    @classmethod
    def from_rotvec(cls, phi: npt.ArrayLike) -> Self:
        """The rotations by |φ| radians about φ, ``(..., 3)``: `exp`, by the name it has in SciPy."""
        return cls.exp(phi)

    def to_rotvec(self) -> Floats:
        """The rotation vectors, ``(..., 3)``, |φ| ≤ π: `log`, by the name it has in SciPy."""
        return self.log()

    @classmethod
    def from_axis_angle(cls, axis: npt.ArrayLike, angle: npt.ArrayLike) -> Self:
        """The rotations by `angle`, ``(...)`` in radians, about `axis`, ``(..., 3)``, of any length but 0."""
        return cls._of(_core.rotations.from_axis_angle(axis, angle))

    def to_axis_angle(self) -> tuple[Floats, Scalars]:
        """Unit axes, ``(..., 3)``, and angles, ``(...)``, in [0, π] radians."""
        return _core.rotations.to_axis_angle(self._numbers)

    @classmethod
    def from_euler(cls, sequence: Euler, angles: npt.ArrayLike) -> Self:
        """The rotations of Euler angles, ``(..., 3)`` in radians, in the order of the sequence.

        Capitals turn about the moving axes (intrinsic), small letters about the fixed ones (extrinsic), as in SciPy.
        ``"ZYX"`` is yaw, pitch, roll.
        """
        return cls._of(_core.from_euler(sequence, angles))

    @classmethod
    def from_euler_jac(cls, sequence: Euler, angles: npt.ArrayLike) -> tuple[Self, Floats]:
        """`from_euler` and its right Jacobian, ``(..., 3, 3)``."""
        value, d_angles = _core.from_euler_jac(sequence, angles)
        return cls._of(value), d_angles

    def to_euler(self, sequence: Euler) -> Floats:
        """Euler angles, ``(..., 3)`` in radians; always angles of the rotation, at gimbal lock with the third one 0.

        See `euler_margin` for how far from gimbal lock they are.
        """
        return _core.to_euler(sequence, self._numbers)[0]

    def to_euler_jac(self, sequence: Euler) -> tuple[Floats, Floats]:
        """Euler angles and their right Jacobian, ``(..., 3, 3)``; `LieError` at gimbal lock, which has none."""
        return _core.to_euler_jac(sequence, self._numbers)

    def euler_margin(self, sequence: Euler) -> Scalars:
        """How far the middle Euler angle is from gimbal lock, ``(...)``, in radians."""
        return _core.to_euler(sequence, self._numbers)[1]

    # Other coordinates

    @classmethod
    def between_directions(cls, a: npt.ArrayLike, b: npt.ArrayLike) -> Self:
        """The shortest rotations that turn directions `a` to directions `b`, ``(..., 3)``, of any length but 0."""
        return cls._of(_core.rotations.between_directions(a, b))

    @classmethod
    def from_gibbs(cls, g: npt.ArrayLike) -> Self:
        """The rotations of Gibbs (Rodrigues, Cayley) vectors tan(θ/2)·n, ``(..., 3)``."""
        return cls._of(_core.rotations.from_gibbs(g))

    @classmethod
    def from_gibbs_jac(cls, g: npt.ArrayLike) -> tuple[Self, Floats]:
        """`from_gibbs` and its right Jacobian, ``(..., 3, 3)``."""
        value, d_g = _core.rotations.from_gibbs_jac(g)
        return cls._of(value), d_g

    def to_gibbs(self) -> Floats:
        """Gibbs vectors tan(θ/2)·n, ``(..., 3)``; `LieError` at a half turn."""
        return _core.rotations.to_gibbs(self._numbers)

    def to_gibbs_jac(self) -> tuple[Floats, Floats]:
        """Gibbs vectors and their right Jacobian, ``(..., 3, 3)``."""
        return _core.rotations.to_gibbs_jac(self._numbers)

    @classmethod
    def from_mrp(cls, m: npt.ArrayLike) -> Self:
        """The rotations of modified Rodrigues parameters tan(θ/4)·n, ``(..., 3)``, of either set."""
        return cls._of(_core.rotations.from_mrp(m))

    @classmethod
    def from_mrp_jac(cls, m: npt.ArrayLike) -> tuple[Self, Floats]:
        """`from_mrp` and its right Jacobian, ``(..., 3, 3)``."""
        value, d_m = _core.rotations.from_mrp_jac(m)
        return cls._of(value), d_m

    def to_mrp(self) -> Floats:
        """Modified Rodrigues parameters tan(θ/4)·n, ``(..., 3)``, of norm at most 1."""
        return _core.rotations.to_mrp(self._numbers)

    def to_mrp_jac(self) -> tuple[Floats, Floats]:
        """Modified Rodrigues parameters and their right Jacobian, ``(..., 3, 3)``."""
        return _core.rotations.to_mrp_jac(self._numbers)

    @classmethod
    def from_6d(cls, a: npt.ArrayLike, b: npt.ArrayLike) -> Self:
        """The rotations whose first two columns come from vectors `a`, `b`, ``(..., 3)``, by Gram-Schmidt."""
        return cls._of(_core.rotations.from_6d(a, b))

    @classmethod
    def from_6d_jac(cls, a: npt.ArrayLike, b: npt.ArrayLike) -> tuple[Self, Floats]:
        """`from_6d` and its right Jacobian, ``(..., 3, 6)``."""
        value, d_ab = _core.rotations.from_6d_jac(a, b)
        return cls._of(value), d_ab

    # Distances

    def angle_to(self, other: SO3) -> Scalars:
        """The angle between two rotations, ``(...)``, in [0, π] radians."""
        return _core.rotations.angle_to(self._numbers, self._same(other))

    def chordal_distance(self, other: SO3) -> Scalars:
        """‖R₁ - R₂‖ of Frobenius, ``(...)``."""
        return _core.rotations.chordal_distance(self._numbers, self._same(other))

    def quaternion_distance(self, other: SO3) -> Scalars:
        """min(‖q₁ - q₂‖, ‖q₁ + q₂‖), ``(...)``."""
        return _core.rotations.quaternion_distance(self._numbers, self._same(other))

    # SciPy

    @classmethod
    def from_scipy(cls, rotation: Rotation) -> Self:
        """The rotations of a `scipy.spatial.transform.Rotation`."""
        return cls.from_quat_xyzw(rotation.as_quat())

    def to_scipy(self) -> Rotation:
        """A `scipy.spatial.transform.Rotation` of the same shape."""
        from scipy.spatial.transform import Rotation

        return Rotation.from_quat(self.to_array())


class _Placed(MatrixGroup):
    """Elements stored as a translation, a rotation, and whatever follows."""

    __slots__ = ()

    @property
    def translation(self) -> Floats:
        """t, ``(..., 3)``, in metres of the parent frame."""
        return self._numbers[..., 0:3]

    @property
    def rotation(self) -> SO3:
        """R, ``(...)``."""
        return SO3._of(self._numbers[..., 3:7])


class SE3(_Placed):
    """Poses in space, stored as (t₁, t₂, t₃, x, y, z, w): the order of TUM trajectories and of ROS poses.

    A tangent is (ρ, φ): metres, then radians, in the local frame.

    >>> import boxplus as bp
    >>> world_from_body = bp.SE3(bp.SO3.from_euler("ZYX", [3.141592653589793, 0.0, 0.0]), [1.0, 2.0, 3.0])
    >>> (world_from_body @ [1.0, 0.0, 0.0]).round(12)
    array([0., 2., 3.])
    """

    __slots__ = ()

    dimension, numbers, point_dimension = 6, 7, 3
    fields = (("translation", 3), ("xyzw", 4))
    _operations, _matrices = _core.SE3, _core.SE3_matrices

    def __init__(self, rotation: SO3 | None = None, translation: npt.ArrayLike = (0.0, 0.0, 0.0)) -> None:
        """The motions p ↦ R·p + t of rotations ``(...)`` and translations ``(..., 3)`` in m."""
        parts = joined((translation, 3), (_or_identity(rotation), 4), names=("translation", "rotation"))
        self._numbers = type(self).from_array(parts)._numbers

    @classmethod
    def from_scipy(cls, transform: RigidTransform) -> Self:
        """The poses of a `scipy.spatial.transform.RigidTransform` (SciPy 1.16)."""
        return cls(SO3.from_scipy(transform.rotation), transform.translation)

    def to_scipy(self) -> RigidTransform:
        """A `scipy.spatial.transform.RigidTransform` of the same shape (SciPy 1.16)."""
        from scipy.spatial.transform import RigidTransform

        return RigidTransform.from_components(self.translation, self.rotation.to_scipy())


class _Moving(MatrixGroup):
    """Elements stored as a position, a rotation, a velocity, and whatever follows."""

    __slots__ = ()

    @property
    def position(self) -> Floats:
        """p, ``(..., 3)``, in metres of the parent frame."""
        return self._numbers[..., 0:3]

    @property
    def rotation(self) -> SO3:
        """R, ``(...)``."""
        return SO3._of(self._numbers[..., 3:7])

    @property
    def velocity(self) -> Floats:
        """v, ``(..., 3)``, in m/s of the parent frame."""
        return self._numbers[..., 7:10]


class SE23(_Moving):
    """Extended poses, stored as (position, x, y, z, w, velocity).

    A tangent is (ρ, φ, ν): metres, radians, metres per second, in the local frame. Points are moved by the pose.
    """

    __slots__ = ()

    dimension, numbers, point_dimension = 9, 10, 3
    fields = (("position", 3), ("xyzw", 4), ("velocity", 3))
    _operations, _matrices = _core.SE23, _core.SE23_matrices

    def __init__(
        self,
        rotation: SO3 | None = None,
        position: npt.ArrayLike = (0.0, 0.0, 0.0),
        velocity: npt.ArrayLike = (0.0, 0.0, 0.0),
    ) -> None:
        """Rotations ``(...)``, positions ``(..., 3)`` in m and velocities ``(..., 3)`` in m/s, in the parent frame."""
        parts = joined(
            (position, 3),
            (_or_identity(rotation), 4),
            (velocity, 3),
            names=("position", "rotation", "velocity"),
        )
        self._numbers = type(self).from_array(parts)._numbers

    @property
    def pose(self) -> SE3:
        """(R, p), ``(...)``: the pose without its velocity."""
        return SE3._of(self._numbers[..., 0:7])


class SGal3(_Moving):
    """Galilean transformations, stored as (position, x, y, z, w, velocity, time).

    A tangent is (ρ, φ, ν, ι): metres, radians, metres per second, seconds. Events (p, τ), ``(..., 4)``, are moved.
    """

    __slots__ = ()

    dimension, numbers, point_dimension = 10, 11, 4
    fields = (("position", 3), ("xyzw", 4), ("velocity", 3), ("time", 1))
    _operations, _matrices = _core.SGal3, _core.SGal3_matrices

    def __init__(
        self,
        rotation: SO3 | None = None,
        position: npt.ArrayLike = (0.0, 0.0, 0.0),
        velocity: npt.ArrayLike = (0.0, 0.0, 0.0),
        time: npt.ArrayLike = 0.0,
    ) -> None:
        """Rotations ``(...)``, positions ``(..., 3)`` in m, velocities ``(..., 3)`` in m/s, times ``(...)`` in s."""
        parts = joined(
            (position, 3),
            (_or_identity(rotation), 4),
            (velocity, 3),
            (time, None),
            names=("position", "rotation", "velocity", "time"),
        )
        self._numbers = type(self).from_array(parts)._numbers

    @property
    def time(self) -> Scalars:
        """t, ``(...)`` in seconds: time in the parent frame minus time in the local one."""
        return number(self._numbers, 10)

    @property
    def extended_pose(self) -> SE23:
        """(R, p, v), ``(...)``, without the time."""
        return SE23._of(self._numbers[..., 0:10])


class Sim3(_Placed):
    """Similarities of space, p ↦ s·R·p + t, stored as (t₁, t₂, t₃, x, y, z, w, σ) with s = e^σ.

    A tangent is (ρ, φ, σ): metres, radians, and the rate of ln s.
    """

    __slots__ = ()

    dimension, numbers, point_dimension = 7, 8, 3
    fields = (("translation", 3), ("xyzw", 4), ("log_scale", 1))
    _operations, _matrices = _core.Sim3, _core.Sim3_matrices

    def __init__(
        self,
        rotation: SO3 | None = None,
        translation: npt.ArrayLike = (0.0, 0.0, 0.0),
        log_scale: npt.ArrayLike = 0.0,
    ) -> None:
        """The similarities of rotations ``(...)``, translations ``(..., 3)`` in m and log-scales ``(...)``."""
        parts = joined(
            (translation, 3),
            (_or_identity(rotation), 4),
            (log_scale, None),
            names=("translation", "rotation", "log_scale"),
        )
        self._numbers = type(self).from_array(parts)._numbers

    @property
    def log_scale(self) -> Scalars:
        """σ = ln s, ``(...)``."""
        return number(self._numbers, 7)

    @property
    def scale(self) -> Scalars:
        """s = e^σ, ``(...)``: lengths in the parent frame over lengths in the local one."""
        return number(np.exp(self._numbers[..., 7:8]))


def _or_identity(rotation: SO3 | None) -> SO3:
    return SO3() if rotation is None else rotation
