"""Agreement with other packages, each on its own numbers. Those that are not installed are skipped."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

import boxplus as bp
from test_pose_graph import helix

ROTATION_FIRST = [3, 4, 5, 0, 1, 2]


def poses(rng: np.random.Generator) -> tuple[bp.SE3, bp.SE3]:
    return bp.SE3.exp(rng.uniform(-1, 1, (50, 6))), bp.SE3.exp(rng.uniform(-1, 1, (50, 6)))


def test_jaxlie_agrees(rng: np.random.Generator) -> None:
    jaxlie: Any = pytest.importorskip("jaxlie")
    jax: Any = pytest.importorskip("jax")
    jax.config.update("jax_enable_x64", True)
    x, y = poses(rng)
    wxyz = [6, 3, 4, 5, 0, 1, 2]
    theirs_x, theirs_y = (jaxlie.SE3(np.asarray(z)[:, wxyz]) for z in (x, y))
    assert_allclose((x @ y).to_matrix(), (theirs_x @ theirs_y).as_matrix(), rtol=0, atol=1e-14)
    assert_allclose(x.log(), theirs_x.log(), rtol=0, atol=1e-13)
    assert_allclose(x.adjoint(), theirs_x.adjoint(), rtol=0, atol=1e-14)
    assert_allclose(y - x, jaxlie.manifold.rminus(theirs_x, theirs_y), rtol=0, atol=1e-13)
    tau = rng.uniform(-1, 1, (50, 3))
    assert_allclose(bp.SE2.exp(tau).to_matrix(), jaxlie.SE2.exp(tau).as_matrix(), rtol=0, atol=1e-14)
    assert_allclose(bp.SO3.exp(tau).to_matrix(), jaxlie.SO3.exp(tau).as_matrix(), rtol=0, atol=1e-14)
    assert_allclose(x @ tau, theirs_x @ tau, rtol=0, atol=1e-14)


def test_gtsam_agrees(rng: np.random.Generator) -> None:
    gtsam: Any = pytest.importorskip("gtsam")
    x, y = poses(rng)
    for a, b in zip(x, y, strict=True):
        theirs_a, theirs_b = gtsam.Pose3(a.to_matrix()), gtsam.Pose3(b.to_matrix())
        assert_allclose((a @ b).to_matrix(), theirs_a.compose(theirs_b).matrix(), rtol=0, atol=1e-14)
        assert_allclose(a.log()[ROTATION_FIRST], gtsam.Pose3.Logmap(theirs_a), rtol=0, atol=1e-13)
        ours = a.adjoint()[np.ix_(ROTATION_FIRST, ROTATION_FIRST)]
        assert_allclose(ours, theirs_a.AdjointMap(), rtol=0, atol=1e-14)


def test_scipy_agrees(rng: np.random.Generator) -> None:
    transform: Any = pytest.importorskip("scipy.spatial.transform")
    if not hasattr(transform, "RigidTransform"):
        pytest.skip("SciPy has rigid transforms from 1.16 on")
    x, y = poses(rng)
    theirs_x, theirs_y = x.to_scipy(), y.to_scipy()
    assert_allclose((x @ y).to_matrix(), (theirs_x * theirs_y).as_matrix(), rtol=0, atol=1e-14)
    assert_allclose(x.log()[:, ROTATION_FIRST], theirs_x.as_exp_coords(), rtol=0, atol=1e-13)
    p = rng.normal(size=(50, 3))
    assert_allclose(x @ p, theirs_x.apply(p), rtol=0, atol=1e-14)
    assert np.all(bp.SE3.from_scipy(theirs_x.inv()).is_near(x.inverse(), 1e-14))


def test_evo_agrees(rng: np.random.Generator) -> None:
    evo: Any = pytest.importorskip("evo.core.lie_algebra")
    x, y = poses(rng)
    for a, b in zip(x, y, strict=True):
        assert_allclose(a.inverse().to_matrix(), evo.se3_inverse(a.to_matrix()), rtol=0, atol=1e-14)
        assert_allclose(a.between(b).to_matrix(), evo.relative_se3(a.to_matrix(), b.to_matrix()), rtol=0, atol=1e-14)
        rotation = a.rotation
        assert_allclose(rotation.log(), evo.so3_log(rotation.to_matrix()).ravel(), rtol=0, atol=1e-12)


def test_gtsam_finds_the_same_optimum() -> None:
    gtsam: Any = pytest.importorskip("gtsam")
    _, pose_graph = helix(60)
    solution, edges = pose_graph.solve(), pose_graph.edges
    assert isinstance(edges.measured, bp.SE3) and isinstance(solution.poses, bp.SE3)
    theirs, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    sigmas = np.array([0.02, 0.02, 0.02, 0.01, 0.01, 0.01])
    noise = gtsam.noiseModel.Diagonal.Sigmas(sigmas[ROTATION_FIRST])
    for i, j, z in zip(edges.from_, edges.to, edges.measured, strict=True):
        theirs.add(gtsam.BetweenFactorPose3(int(i), int(j), gtsam.Pose3(z.to_matrix()), noise))
    for i, pose in zip(solution.ids, solution.poses, strict=True):
        values.insert(int(i), gtsam.Pose3(pose.to_matrix()))
    assert_allclose(theirs.error(values), solution.cost, rtol=1e-9)
    theirs.add(gtsam.PriorFactorPose3(0, values.atPose3(0), gtsam.noiseModel.Isotropic.Sigma(6, 1e-3)))
    again = gtsam.LevenbergMarquardtOptimizer(theirs, values).optimize()
    assert_allclose(theirs.error(again), solution.cost, rtol=1e-9)
