"""Rotations go in and out as in SciPy, and derivatives of coordinates are those of a difference."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import RigidTransform, Rotation

import boxplus as bp
from boxplus import SO3

Floats = npt.NDArray[np.float64]
SEQUENCES = [
    "".join(axes)
    for letters in ("XYZ", "xyz")
    for axes in itertools.product(letters, repeat=3)
    if axes[0] != axes[1] and axes[1] != axes[2]
]


def rotations(rng: np.random.Generator, count: int = 300) -> SO3:
    return SO3.from_quat_xyzw(rng.normal(size=(count, 4)))


def test_quaternions_and_matrices_are_those_of_scipy(rng: np.random.Generator) -> None:
    x = rotations(rng)
    theirs = Rotation.from_quat(x.to_quat_xyzw())
    assert_allclose(x.to_matrix(), theirs.as_matrix(), rtol=0, atol=1e-15)
    assert_allclose(x.to_rotvec(), theirs.as_rotvec(), rtol=0, atol=1e-14)
    assert np.all(SO3.from_rotvec(theirs.as_rotvec()).is_near(x, 1e-14))
    assert_allclose(x.to_quat_wxyz(), theirs.as_quat(scalar_first=True), rtol=0, atol=1e-15)
    assert np.all(SO3.from_quat_wxyz(x.to_quat_wxyz()).is_near(x, 1e-15))
    assert np.all(SO3.from_quat_jpl_xyzw(x.to_quat_jpl_xyzw()).is_near(x, 1e-15))
    p = rng.normal(size=(300, 3))
    assert_allclose(x @ p, theirs.apply(p), rtol=0, atol=3e-15)
    assert_allclose(x.angle_to(SO3()), theirs.magnitude(), rtol=0, atol=1e-14)
    assert_allclose((x @ x[::-1]).to_matrix(), (theirs * theirs[::-1]).as_matrix(), rtol=0, atol=2e-15)


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_euler_angles_are_those_of_scipy(sequence: bp.Euler, rng: np.random.Generator) -> None:
    x = rotations(rng)
    theirs = x.to_scipy()
    assert_allclose(x.to_euler(sequence), theirs.as_euler(sequence), rtol=0, atol=1e-11)
    assert np.all(SO3.from_euler(sequence, x.to_euler(sequence)).is_near(x, 1e-14))
    assert np.all(SO3.from_scipy(Rotation.from_euler(sequence, x.to_euler(sequence))).is_near(x, 1e-14))
    assert np.all(np.asarray(x.euler_margin(sequence)) > 0)


def test_poses_are_those_of_scipy(rng: np.random.Generator) -> None:
    x = bp.SE3(rotations(rng), rng.normal(size=(300, 3)) * 10)
    theirs = x.to_scipy()
    assert isinstance(theirs, RigidTransform)
    assert_allclose(x.to_matrix(), theirs.as_matrix(), rtol=0, atol=1e-14)
    assert np.all(bp.SE3.from_scipy(theirs).is_near(x, 1e-14))
    rotation_first = theirs.as_exp_coords()
    assert_allclose(x.log()[:, [3, 4, 5, 0, 1, 2]], rotation_first, rtol=0, atol=2e-12)
    assert_allclose((x @ x[::-1]).to_matrix(), (theirs * theirs[::-1]).as_matrix(), rtol=0, atol=2e-14)


def test_other_coordinates_invert(rng: np.random.Generator) -> None:
    x = rotations(rng)
    assert np.all(SO3.from_gibbs(x.to_gibbs()).is_near(x, 1e-12))
    assert np.all(SO3.from_mrp(x.to_mrp()).is_near(x, 1e-14))
    assert np.all(SO3.from_axis_angle(*x.to_axis_angle()).is_near(x, 1e-14))
    columns = x.to_matrix()
    assert np.all(SO3.from_6d(columns[..., 0], columns[..., 1]).is_near(x, 1e-14))
    a, b = rng.normal(size=(2, 300, 3))
    turned = SO3.between_directions(a, b) @ (a / np.linalg.norm(a, axis=-1, keepdims=True))
    assert_allclose(turned, b / np.linalg.norm(b, axis=-1, keepdims=True), rtol=0, atol=1e-14)


INTO: dict[str, Callable[[Floats], tuple[SO3, Floats]]] = {
    "quaternion": SO3.from_quat_xyzw_jac,
    "gibbs": SO3.from_gibbs_jac,
    "mrp": SO3.from_mrp_jac,
    "6d": lambda ab: SO3.from_6d_jac(ab[..., :3], ab[..., 3:]),
    "euler": lambda angles: SO3.from_euler_jac("ZYX", angles),
}


@pytest.mark.parametrize(("name", "width"), [("quaternion", 4), ("gibbs", 3), ("mrp", 3), ("6d", 6), ("euler", 3)])
def test_jacobians_of_coordinates_are_central_differences(name: str, width: int, rng: np.random.Generator) -> None:
    centre = np.array([1.0, 0.0, 0.0, 0.0, 1.0, 0.0])[:width]  # As 6d: two directions far from parallel.
    given, step = centre + rng.uniform(-0.3, 0.3, (20, width)), 1e-5
    jacobian = INTO[name](given)[1]
    for k in range(width):
        ahead, behind = (INTO[name](given + h * np.eye(width)[k])[0] for h in (step, -step))
        assert_allclose((ahead - behind) / (2 * step), jacobian[..., k], rtol=0, atol=1e-8)


OUT_OF: dict[str, Callable[[SO3], tuple[Floats, Floats]]] = {
    "quaternion": SO3.to_quat_xyzw_jac,
    "gibbs": SO3.to_gibbs_jac,
    "mrp": SO3.to_mrp_jac,
    "euler": lambda x: x.to_euler_jac("ZYX"),
}


@pytest.mark.parametrize("name", OUT_OF)
def test_jacobians_to_coordinates_are_central_differences(name: str, rng: np.random.Generator) -> None:
    x, step = SO3.exp(rng.uniform(-0.6, 0.6, (20, 3))), 1e-5
    jacobian = OUT_OF[name](x)[1]
    for k in range(3):
        ahead, behind = (OUT_OF[name](x + h * np.eye(3)[k])[0] for h in (step, -step))
        assert_allclose((ahead - behind) / (2 * step), jacobian[..., k], rtol=0, atol=1e-8)


def test_gimbal_lock_is_told() -> None:
    nose_up = SO3.from_euler("ZYX", [0.7, -np.pi / 2, 0.2])
    assert np.asarray(nose_up.euler_margin("ZYX")) < 1e-15
    assert SO3.from_euler("ZYX", nose_up.to_euler("ZYX")).is_near(nose_up, 1e-15)
    with pytest.raises(bp.LieError, match="gimbal lock"):
        nose_up.to_euler_jac("ZYX")


def test_planar_groups_go_in_and_out_as_angles(rng: np.random.Generator) -> None:
    angle = rng.uniform(-3.1, 3.1, (4, 5))
    x = bp.SO2.from_angle(angle)
    assert_allclose(x.angle, angle, rtol=0, atol=1e-15)
    assert np.all(bp.SO2.from_cos_sin(3 * np.cos(angle), 3 * np.sin(angle)).is_near(x, 1e-15))
    assert_allclose(x.angle_to(bp.SO2()), np.abs(angle), rtol=0, atol=1e-15)
    pose = bp.SE2(rng.normal(size=(4, 5, 2)), angle)
    assert_allclose(pose.angle, angle, rtol=0, atol=1e-15)
    assert np.all(pose == bp.SE2(pose.translation, pose.rotation))
    assert isinstance(pose[0, 0].angle, float)


def test_parts_put_together_are_the_element(rng: np.random.Generator) -> None:
    r, p, v, t = rotations(rng, 20), *rng.normal(size=(2, 20, 3)), rng.normal(size=20)
    moving = bp.SE23(r, p, v)
    assert np.all(moving.pose == bp.SE3(r, p))
    assert np.all(moving == bp.SE23(moving.rotation, moving.position, moving.velocity))
    event = bp.SGal3(r, p, v, t)
    assert np.all(event.extended_pose == moving) and np.all(np.asarray(event.time) == t)
    similar = bp.Sim3(r, p, t)
    assert np.all(np.asarray(similar.log_scale) == t) and np.all(similar.rotation == r)
    assert_allclose(similar.scale, np.exp(t), rtol=0, atol=1e-14)
    assert np.all(bp.SE3(r, [1.0, 2.0, 3.0]).translation == [1.0, 2.0, 3.0])
