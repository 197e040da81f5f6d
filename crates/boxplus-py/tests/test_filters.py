"""The Kalman filter of errors, over arrays of beliefs."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import boxplus as bp
from boxplus import filters

Floats = npt.NDArray[np.float64]
Q, N = np.diag([4e-4, 1e-4, 1e-4]), np.diag([9e-4, 9e-4])
BEACON = np.array([4.0, 1.0])


def start(side: bp.Side = "local") -> bp.Gaussian[bp.SE2]:
    return bp.Gaussian.from_sigmas(bp.SE2([0.2, 0.1], 0.3), [0.1, 0.2, 0.05], side)


@pytest.mark.parametrize("side", ["local", "global"])
def test_a_prediction_carries_errors_by_the_jacobian_of_the_motion(side: bp.Side) -> None:
    belief, step = start(side), np.array([1.0, 0.0, 0.2])
    after = filters.predict(belief, filters.Odometry(step, Q))
    _, f, g = belief.mean.rplus_jac(step) if side == "local" else belief.mean.rplus_left_jac(step)
    assert np.all(after.mean == belief.mean + step) and after.side == side
    assert_allclose(after.covariance, f @ belief.covariance @ f.T + g @ Q @ g.T, rtol=1e-12, atol=1e-16)


@pytest.mark.parametrize("side", ["local", "global"])
def test_an_update_is_that_of_kalman_in_the_tangent(side: bp.Side) -> None:
    belief, measured = start(side), np.array([3.6, -0.2])
    update = filters.update(belief, filters.Sighting(BEACON, measured, N))
    x, p = belief.mean, belief.covariance
    seen, h, _ = x.act_inverse_jac(BEACON) if side == "local" else x.act_inverse_left_jac(BEACON)
    s = h @ p @ h.T + N
    gain = p @ h.T @ np.linalg.inv(s)
    delta = gain @ (measured - seen)
    assert update.accepted is True
    assert_allclose(update.innovation, measured - seen, atol=1e-15)
    assert_allclose(update.covariance, s, rtol=1e-12)
    assert_allclose(update.nis, (measured - seen) @ np.linalg.inv(s) @ (measured - seen), rtol=1e-10)
    expected = x + delta if side == "local" else x.lplus(delta)
    assert np.all(update.belief.mean.is_near(expected, 1e-12))
    reset = (bp.SE2.right_jacobian if side == "local" else bp.SE2.left_jacobian)(delta)
    posterior = reset @ (np.eye(3) - gain @ h) @ p @ reset.T
    assert_allclose(update.belief.covariance, posterior, rtol=1e-9, atol=1e-14)


def test_the_gate_refuses_what_is_unlikely_and_leaves_the_belief_as_it_was() -> None:
    belief = start()
    far = filters.Sighting(BEACON, [[3.6, -0.2], [30.0, 3.0]], N)
    update = filters.update(belief, far, gate=0.999)
    assert_array_equal(update.accepted, [True, False])
    assert np.all(update.belief.mean[1] == belief.mean) and not np.all(update.belief.mean[0] == belief.mean)
    assert_array_equal(update.belief.covariance[1], belief.covariance)
    assert np.asarray(update.nis)[1] > 1000.0


def test_many_vehicles_are_filtered_as_each_alone(rng: np.random.Generator) -> None:
    means = bp.SE3.exp(rng.uniform(-1.0, 1.0, (50, 6)))
    beliefs = bp.Gaussian.from_sigmas(means, [0.1] * 6)
    steps, fixes = rng.normal(size=(50, 6)) * 0.1, means.translation + 0.05
    noise, gnss = 1e-4 * np.eye(6), 0.01 * np.eye(3)
    together = filters.predict(beliefs, filters.Odometry(steps, noise))
    together = filters.update(together, filters.PositionFix(fixes, gnss, antenna=[0.1, 0.0, 0.2])).belief
    for i in (0, 17, 49):
        alone = filters.predict(beliefs[i], filters.Odometry(steps[i], noise))
        alone = filters.update(alone, filters.PositionFix(fixes[i], gnss, antenna=[0.1, 0.0, 0.2])).belief
        assert np.all(alone.mean == together.mean[i])
        assert_array_equal(alone.covariance, together.covariance[i])


def sensors() -> list[tuple[Any, Any]]:
    """Each sensor of the library, and the innovation that it stands for."""
    up, y = np.array([0.0, 0.0, 9.81]), np.array([0.3, -0.2, 9.7])
    place, one, three = np.array([1.0, 2.0, 3.0]), np.eye(1), np.eye(3)

    def sighting(x: bp.SE3) -> Floats:
        return y - x.act_inverse(place)

    def levered(x: bp.SE3) -> Floats:
        return y - x.act([0.1, 0.2, 0.3])

    def fix(x: bp.SE3) -> Floats:
        return y - x.translation

    def direction(x: bp.SE3) -> Floats:
        return y - x.inverse().act_direction(up)

    def distance(x: bp.SE3) -> Floats:
        return np.asarray(2.5 - np.linalg.norm(x.translation - place, axis=-1, keepdims=True))

    return [
        (filters.Sighting(place, y, three), sighting),
        (filters.PositionFix(y, three, antenna=[0.1, 0.2, 0.3]), levered),
        (filters.PositionFix(y, three), fix),
        (filters.VectorSighting(up, y, three), direction),
        (filters.Range(place, 2.5, one), distance),
    ]


@pytest.mark.parametrize("place", range(5))
def test_sensors_of_the_library_and_of_ones_own_say_the_same(place: int, rng: np.random.Generator) -> None:
    sensor, innovation = sensors()[place]
    belief = bp.Gaussian.from_sigmas(bp.SE3.exp(rng.uniform(-1.0, 1.0, (4, 6))), [0.1] * 6, "global")
    known = filters.update(belief, sensor)
    with pytest.warns(UserWarning, match="central differences"):
        own = filters.update(belief, filters.Innovation(innovation, sensor.noise))
    assert_allclose(own.innovation, known.innovation, atol=1e-14)
    assert_allclose(own.covariance, known.covariance, rtol=1e-7)
    assert_allclose(own.belief.covariance, known.belief.covariance, rtol=1e-6, atol=1e-10)


def test_a_motion_of_ones_own_is_carried_as_that_of_the_library() -> None:
    belief, step = start(), np.array([1.0, 0.0, 0.2])

    def moved(x: bp.SE2) -> tuple[bp.SE2, Floats]:
        following, d_x, _ = x.rplus_jac(step)
        return following, d_x

    def moved_alone(x: bp.SE2) -> bp.SE2:
        return x + step

    known = filters.predict(belief, filters.Step(moved, Q, jacobians=True))
    with pytest.warns(UserWarning, match="central differences"):
        own = filters.predict(belief, filters.Step(moved_alone, Q))
    assert np.all(known.mean == own.mean)
    assert_allclose(own.covariance, known.covariance, rtol=1e-8, atol=1e-14)
    _, f, _ = belief.mean.rplus_jac(step)
    assert_allclose(known.covariance, f @ belief.covariance @ f.T + Q, rtol=1e-12, atol=1e-16)


def test_a_filter_is_as_sure_as_it_is_right() -> None:
    """NEES over 400 robots at once, driving among three beacons."""
    rng = np.random.default_rng(2)
    truth = bp.SE2.identity(400)
    belief = bp.Gaussian.from_sigmas(truth + rng.normal(size=(400, 3)) * [0.1, 0.1, 0.05], [0.1, 0.1, 0.05])
    beacons = np.array([[4.0, 1.0], [0.0, 3.0], [-2.0, -2.0]])
    for _ in range(20):
        step = np.array([0.2, 0.0, 0.1])
        truth = truth + (step + rng.normal(size=(400, 3)) * np.sqrt(np.diag(Q)))
        belief = filters.predict(belief, filters.Odometry(step, Q))
        for beacon in beacons:
            seen = truth.act_inverse(beacon) + 0.03 * rng.normal(size=(400, 2))
            belief = filters.update(belief, filters.Sighting(beacon, seen, N)).belief
    nees = np.mean(belief.mahalanobis_squared(truth))
    assert abs(nees - 3.0) < 5.0 * np.sqrt(6.0 / 400)


def test_faults_are_told() -> None:
    belief = start()
    with pytest.raises(bp.FilterError, match="the innovation has no variance along"):
        certain = bp.Gaussian(bp.SE2(), np.zeros((3, 3)))
        filters.update(certain, filters.Sighting(BEACON, BEACON, np.zeros((2, 2))))
    def number(_: bp.SE2) -> tuple[float, Floats]:
        return 0.0, np.zeros(3)

    with pytest.raises(bp.ShapeError, match="1 to 6 numbers"):
        filters.update(belief, filters.Innovation(number, [[1.0]], jacobians=True))
    with pytest.raises(bp.UncertaintyError):
        filters.predict(belief, filters.Odometry([1.0, 0.0, 0.0], -Q))
    with pytest.raises(bp.NotFiniteError, match="measured is NaN"):
        filters.update(belief, filters.Sighting(BEACON, [np.nan, 0.0], N))
