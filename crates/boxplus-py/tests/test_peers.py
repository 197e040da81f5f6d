"""Agreement with other packages, each on its own numbers. Those that are not installed are skipped."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

import boxplus as bp

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
    tau = rng.uniform(-1, 1, (50, 7))
    similar = jaxlie.Sim3.exp(tau)
    assert_allclose(bp.Sim3.exp(tau).to_matrix(), similar.as_matrix(), rtol=0, atol=1e-13)


def test_gtsam_agrees(rng: np.random.Generator) -> None:
    gtsam: Any = pytest.importorskip("gtsam")
    x, y = poses(rng)
    for a, b in zip(x, y, strict=True):
        theirs_a, theirs_b = gtsam.Pose3(a.to_matrix()), gtsam.Pose3(b.to_matrix())
        assert_allclose((a @ b).to_matrix(), theirs_a.compose(theirs_b).matrix(), rtol=0, atol=1e-14)
        assert_allclose(a.log()[ROTATION_FIRST], gtsam.Pose3.Logmap(theirs_a), rtol=0, atol=1e-13)
        ours = a.adjoint()[np.ix_(ROTATION_FIRST, ROTATION_FIRST)]
        assert_allclose(ours, theirs_a.AdjointMap(), rtol=0, atol=1e-14)
