"""Uncertain elements."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import boxplus as bp
from boxplus import Gaussian
from conftest import GROUPS, elements, tangents

uncertain_group = pytest.mark.parametrize("group", [g for g in GROUPS if g is not bp.R6])
both_sides = pytest.mark.parametrize("side", ["local", "global"])


def covariances(group: type[bp.Group], rng: np.random.Generator, *shape: int) -> npt.NDArray[np.float64]:
    factor = 0.1 * rng.normal(size=(*shape, group.dimension, group.dimension))
    return np.asarray(factor @ np.swapaxes(factor, -1, -2), dtype=np.float64)


def gaussians(
    group: type[bp.Group], rng: np.random.Generator, side: bp.Side = "local", *shape: int
) -> Gaussian[bp.Group]:
    return Gaussian(elements(group, rng, *shape), covariances(group, rng, *shape), side)


@uncertain_group
@both_sides
def test_first_order_is_what_the_jacobians_of_the_side_say(
    group: type[bp.Group], side: bp.Side, rng: np.random.Generator
) -> None:
    x, y = (Gaussian(group.exp(0.5 * rng.normal(size=(20, group.dimension))), covariances(group, rng, 20), side) for _ in range(2))
    suffix = "_jac" if side == "local" else "_left_jac"
    for name in ("compose", "between"):
        mean, d_x, d_y = getattr(x.mean, name + suffix)(y.mean)
        result = getattr(x, name)(y, order=1)
        expected = d_x @ x.covariance @ d_x.swapaxes(-1, -2) + d_y @ y.covariance @ d_y.swapaxes(-1, -2)
        assert np.all(result.mean.is_near(mean, 1e-13))
        assert_allclose(result.covariance, expected, rtol=0, atol=1e-13 * (1 + np.abs(expected).max()))
    value, d_x = getattr(x.mean, "inverse" + suffix)()
    assert np.all(x.inverse().mean.is_near(value, 1e-13))
    assert_allclose(x.inverse().covariance, d_x @ x.covariance @ d_x.swapaxes(-1, -2), rtol=0, atol=1e-12)


@uncertain_group
def test_sides_are_linked_by_the_adjoint(group: type[bp.Group], rng: np.random.Generator) -> None:
    local = gaussians(group, rng, "local", 30)
    assert_allclose(local.to_global().covariance, local.mean.covariance_to_left(local.covariance), rtol=1e-12, atol=1e-14)
    assert_allclose(local.to_global().to_local().covariance, local.covariance, rtol=1e-9, atol=1e-13)
    assert local.to_local() is local and local.to_global().side == "global"
    with pytest.raises(ValueError, match="one Gaussian is local, the other global"):
        local.compose(local.to_global())


@uncertain_group
@both_sides
def test_samples_have_the_mean_and_the_covariance(group: type[bp.Group], side: bp.Side, rng: np.random.Generator) -> None:
    x = gaussians(group, rng, side)
    drawn = x.sample(rng, 20_000)
    assert drawn.shape == (20_000,)
    errors = x.error_of(drawn)
    deviation = np.abs(np.cov(errors.T).reshape(group.dimension, -1) - x.covariance)
    scale = np.sqrt(np.outer(np.diag(x.covariance), np.diag(x.covariance)))
    assert np.all(deviation < 0.05 * scale), "five standard deviations of a sample covariance are 0.05"
    assert np.all(x.perturbed(errors).is_near(drawn, 1e-12))
    assert abs(np.mean(x.mahalanobis_squared(drawn)) - group.dimension) < 5 * np.sqrt(2 * group.dimension / 20_000)


@both_sides
def test_fourth_order_is_nearer_to_monte_carlo_than_first(side: bp.Side, rng: np.random.Generator) -> None:
    step = Gaussian.from_sigmas(bp.SE2([1.0, 0.0], 0.3), [0.02, 0.02, 0.35], side)
    drawn = step.sample(rng, 200_000) @ step.sample(rng, 200_000)
    errors: list[float] = []
    orders: tuple[bp.Order, ...] = (1, 4)
    for order in orders:
        product = step.compose(step, order)
        true = np.cov(product.error_of(drawn).T)
        errors.append(float(np.abs(product.covariance - true).max() / true.max()))
    assert errors[1] < 0.3 * errors[0]


def test_points_are_moved_with_their_own_uncertainty(rng: np.random.Generator) -> None:
    heading = Gaussian.from_sigmas(bp.SE2(), [0.0, 0.0, 0.3])
    tip = heading.act([1.0, 0.0], order=4)
    assert_allclose(tip.mean.vector[0], np.exp(-0.045), rtol=0, atol=2e-5)
    assert_allclose(tip.covariance[1, 1], (1 - np.exp(-0.18)) / 2, rtol=0, atol=6e-4)
    certain = Gaussian(bp.SE2.identity(5), np.zeros((3, 3)))
    own = np.diag([0.1, 0.2])
    assert_allclose(certain.act(rng.normal(size=(5, 2)), own).covariance, np.broadcast_to(own, (5, 2, 2)), atol=1e-16)


def test_moved_events_are_gaussians_like_others() -> None:
    later = Gaussian.from_sigmas(bp.SGal3(time=2.0), [0.1] * 10).act([1.0, 0.0, 0.0, 5.0], order=1)
    assert_allclose(later.mean.vector, [1.0, 0.0, 0.0, 7.0])
    assert later.sigmas.shape == (4,) and later.sigmas[3] == pytest.approx(0.1)
    assert repr(later).startswith("Gaussian(R4(")


def test_fusion_of_vectors_is_the_weighted_mean() -> None:
    a, b = Gaussian.from_sigmas(bp.R2([0.0, 0.0]), [1.0, 2.0]), Gaussian.from_sigmas(bp.R2([1.0, 1.0]), [1.0, 1.0])
    both = a.fuse(b)
    assert_allclose(both.mean.vector, [0.5, 0.8], atol=1e-12)
    assert_allclose(np.diag(both.covariance), [0.5, 0.8], atol=1e-12)
    assert_allclose(both.information, a.information + b.information, atol=1e-12)
    assert_allclose(a.kl_divergence(a), 0.0, atol=1e-15)


@uncertain_group
def test_densities_and_regions_agree_with_chi_squared(group: type[bp.Group], rng: np.random.Generator) -> None:
    x = gaussians(group, rng)
    directions = rng.normal(size=(50, group.dimension))
    edge = x.boundary(directions, 0.5)
    squared = np.asarray(x.mahalanobis_squared(edge))
    assert_allclose(squared, squared[0], rtol=1e-6)
    drawn = np.asarray(x.mahalanobis_squared(x.sample(rng, 20_000)))
    share = np.count_nonzero(drawn < squared[0]) / len(drawn)
    assert abs(share - 0.5) < 0.02
    peak = x.tangent_log_density(x.mean)
    assert_allclose(peak - np.asarray(x.tangent_log_density(edge)), squared / 2, rtol=1e-6)
    assert_allclose(x.tangent_entropy(), group.dimension / 2 - np.asarray(peak), rtol=1e-9, atol=1e-9)


def test_batches_broadcast_and_equal_their_elements(rng: np.random.Generator) -> None:
    x, y = gaussians(bp.SE3, rng, "local", 4, 1), gaussians(bp.SE3, rng, "local", 3)
    product = x.compose(y, order=4)
    assert product.shape == (4, 3) and len(product) == 4
    alone = x[2][0].compose(y[1], order=4)
    assert_array_equal(np.asarray(product[2][1].mean), np.asarray(alone.mean))
    assert_array_equal(product.covariance[2, 1], alone.covariance)
    with pytest.raises(ValueError, match="read-only"):
        product.covariance[...] = 0.0


def test_what_is_no_covariance_is_told_with_its_direction(rng: np.random.Generator) -> None:
    with pytest.raises(bp.UncertaintyError, match=r"the variance along 1.00·τ\[2\] is -1"):
        Gaussian(bp.SO3(), np.diag([1.0, 1.0, -1.0]))
    with pytest.raises(bp.UncertaintyError, match=r"at \[1\]: entries \(1, 0\) and \(0, 1\)|at \[1\]: entries \(0, 1\)"):
        Gaussian(bp.R2([0.0, 0.0]), [[[1.0, 0.0], [0.0, 1.0]], [[1.0, 0.5], [0.0, 1.0]]])
    with pytest.raises(bp.UncertaintyError, match="singular: nothing is uncertain along"):
        _ = Gaussian(bp.SO3(), np.diag([1.0, 0.0, 1.0])).information
    with pytest.raises(bp.NotFiniteError, match=r"covariance is NaN"):
        Gaussian(bp.SO3(), np.full((3, 3), np.nan))
    with pytest.raises(bp.ShapeError, match=r"covariance: expected an array of shape \(\.\.\., 3, 3\)"):
        Gaussian(bp.SO3(), np.eye(6))
    with pytest.raises(bp.ShapeError, match=r"do not broadcast: mean \(2,\), covariance \(3,\)"):
        Gaussian(bp.SO3.identity(2), np.stack([np.eye(3)] * 3))
    with pytest.raises(ValueError, match="order is 1, 2 or 4, not 3"):
        gaussians(bp.SO3, rng).compose(gaussians(bp.SO3, rng), 3)  # type: ignore[arg-type]  # pyright: ignore
    with pytest.raises(ValueError, match="side is local or global"):
        Gaussian(bp.SO3(), np.eye(3), "left")  # type: ignore[arg-type]  # pyright: ignore


def test_frames_and_resets(rng: np.random.Generator) -> None:
    x = gaussians(bp.SE3, rng)
    known, theta = elements(bp.SE3, rng), 0.1 * tangents(bp.SE3, rng)
    assert np.all(x.change_parent(known).mean.is_near(known @ x.mean, 1e-13))
    assert_array_equal(x.change_parent(known).covariance, x.covariance)
    assert np.all(x.change_body(known).mean.is_near(x.mean @ known, 1e-13))
    moved, carried = x.reset(theta), x.transport(theta)
    assert np.all(moved.mean.is_near(x.mean + theta, 1e-13)) and np.all(carried.mean.is_near(moved.mean, 1e-13))
    j = bp.SE3.right_jacobian(theta)
    assert_allclose(moved.covariance, j @ x.covariance @ j.T, rtol=0, atol=1e-14)
