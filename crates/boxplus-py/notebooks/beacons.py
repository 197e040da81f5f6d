# %% [markdown]
# # A robot among beacons
#
# The three examples of Solà, Deray & Atchuthan (2018), §V, in the plane and in space: localisation with known beacons, smoothing and
# mapping with unknown ones, and the same while calibrating an unknown bias of the odometry.

# %%
from __future__ import annotations

from typing import Any

import numpy as np

import boxplus as bp
from boxplus import filters

rng = np.random.default_rng(4)


def world(pose: Any, steps: int = 30) -> tuple[Any, Any, Any, Any]:
    """A drive along an arc: the true poses, odometry, beacons, and where each beacon is seen from each pose."""
    dimension, place = pose.dimension, pose.point_dimension
    step = np.zeros(dimension)
    step[0], step[-1] = 0.3, 0.1  # ahead, and turning left
    truth = [pose()]
    for _ in range(steps):
        truth.append(truth[-1] + step)
    odometry = step + 0.01 * rng.normal(size=(steps, dimension))
    beacons = rng.uniform(-3.0, 5.0, (6, place))
    poses = pose.stack(truth)
    seen = poses[:, None].act_inverse(beacons) + 0.05 * rng.normal(size=(steps + 1, 6, place))
    return poses, odometry, beacons, seen


def nees(estimate: bp.Gaussian[Any], truth: Any) -> float:
    """The mean squared error in standard deviations, per degree of freedom: about 1 where a filter is as sure as it is right."""
    return float(np.mean(estimate.mahalanobis_squared(truth)) / estimate.mean.dimension)


# %% [markdown]
# ## Localisation
# Predict by odometry, correct by sightings of beacons at known places.

# %%
for pose in (bp.SE2, bp.SE3):
    truth, odometry, beacons, seen = world(pose)
    dimension, place = pose.dimension, pose.point_dimension
    q, n = 1e-4 * np.eye(dimension), 0.0025 * np.eye(place)
    belief: bp.Gaussian[Any] = bp.Gaussian.from_sigmas(pose(), [0.1] * dimension)
    for step, sightings in zip(odometry, seen[1:], strict=True):
        belief = filters.predict(belief, filters.Odometry(step, q))
        for beacon, sighting in zip(beacons, sightings, strict=True):
            belief = filters.update(belief, filters.Sighting(beacon, sighting, n), gate=0.9999).belief
    error = np.abs(belief.error_of(truth[-1]))
    print(f"{pose.__name__} localised: errors {error.round(3)}, 3σ {(3 * belief.sigmas).round(3)}")
    assert np.all(error < 4 * belief.sigmas)

# %% [markdown]
# ## Smoothing and mapping
# All poses and all beacons at once; no beacon is known beforehand.

# %%
for pose, point in ((bp.SE2, bp.R2), (bp.SE3, bp.R3)):
    truth, odometry, beacons, seen = world(pose)
    dimension, place, count = pose.dimension, pose.point_dimension, len(truth)
    graph = bp.Graph()
    x: bp.Variables[Any] = graph.unknown(pose, count)
    b: bp.Variables[Any] = graph.unknown(point, len(beacons))
    graph.prior(x[0], truth[0], sigmas=[1e-3] * dimension)
    graph.between(x[:-1], x[1:], pose.exp(odometry), sigmas=[0.01] * dimension)
    i, j = np.repeat(np.arange(count), 6), np.tile(np.arange(6), count)
    graph.sighting(x[i], b[j], seen.reshape(-1, place), sigmas=[0.05] * place)
    solution = graph.solve()
    poses, places = solution.gaussians(x), solution.gaussians(b)
    print(f"{pose.__name__} mapped: χ² per measurement {2 * solution.cost / (6 * count * place):.2f}, NEES {nees(poses, truth):.2f}")
    assert solution.converged and nees(poses, truth) < 3.0
    assert np.all(np.abs(places.mean.vector - beacons) < 5 * places.sigmas)

# %% [markdown]
# ## Self-calibration
# The odometer has an unknown, constant bias: one more variable, which every step reads through a factor of our own.

# %%
for pose, vector in ((bp.SE2, bp.R3), (bp.SE3, bp.R6)):
    truth, odometry, beacons, seen = world(pose)
    dimension, place, count = pose.dimension, pose.point_dimension, len(truth)
    bias = 0.05 * rng.uniform(-1.0, 1.0, dimension)

    def drive(a: Any, b: Any, c: Any, measured: Any) -> Any:
        """What the odometer says of a step, less its bias, against the step."""
        return b - (a + (measured - c.vector))

    graph = bp.Graph()
    chained = [truth[0]]
    for step in odometry + bias:
        chained.append(chained[-1] + step)
    x = graph.variables(pose.stack(chained))
    c: bp.Variables[Any] = graph.variables(vector(np.zeros(dimension)))
    graph.prior(x[0], truth[0], sigmas=[1e-3] * dimension)
    graph.factor([x[:-1], x[1:], c[[0] * (count - 1)]], drive, odometry + bias, sigmas=[0.01] * dimension)
    i, j = np.repeat(np.arange(count), 6), np.tile(np.arange(6), count)
    b = graph.variables((bp.R2 if place == 2 else bp.R3)(beacons + 0.5))
    graph.sighting(x[i], b[j], seen.reshape(-1, place), sigmas=[0.05] * place)
    solution = graph.solve(initial="as_given")
    found, sigmas = solution[c].vector[0], np.sqrt(np.diag(solution.joint_covariance(c)))
    error = np.abs(found - bias)
    print(f"{pose.__name__} calibrated: bias {found.round(3)}, errors {error.round(4)}, 3σ {(3 * sigmas).round(4)}")
    assert solution.converged and np.all(error < 4 * sigmas)
