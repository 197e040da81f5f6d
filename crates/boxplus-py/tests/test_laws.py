"""The laws of Lie groups, over batches."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import boxplus as bp
from conftest import GROUPS, MATRIX_GROUPS, elements, tangents

every_group = pytest.mark.parametrize("group", GROUPS)


@every_group
def test_log_inverts_exp(group: type[bp.Group], rng: np.random.Generator) -> None:
    tau = tangents(group, rng, 500)
    assert_allclose(group.exp(tau).log(), tau, rtol=0, atol=2e-15 * 4)


@every_group
def test_composition_is_associative_with_inverse_and_identity(group: type[bp.Group], rng: np.random.Generator) -> None:
    x, y, z = (elements(group, rng, 200) for _ in range(3))
    assert np.all(((x @ y) @ z).is_near(x @ (y @ z), 2e-14))
    assert np.all((x @ x.inverse()).is_near(group.identity(), 1e-14))
    assert np.all((x @ group.identity()).is_near(x, 1e-15))


@every_group
def test_between_and_the_steps_of_both_sides_agree(group: type[bp.Group], rng: np.random.Generator) -> None:
    x, y = elements(group, rng, 200), elements(group, rng, 200)
    assert np.all(x.between(y).is_near(x.inverse() @ y, 1e-13))
    assert np.all((x + (y - x)).is_near(y, 1e-13))
    assert np.all(x.lplus(y.lminus(x)).is_near(y, 1e-13))
    tau = tangents(group, rng, 200)
    assert np.all((x + tau).is_near(x.lplus(x.adjoint_times(tau)), 1e-13))
    assert_allclose(x.adjoint_times(tau), np.einsum("nij,nj->ni", x.adjoint(), tau), rtol=0, atol=1e-14)


@every_group
def test_action_is_that_of_the_product(group: type[bp.Group], rng: np.random.Generator) -> None:
    x, y = elements(group, rng, 200), elements(group, rng, 200)
    p = rng.normal(size=(200, group.point_dimension))
    assert_allclose((x @ y) @ p, x @ (y @ p), rtol=0, atol=1e-13)
    assert_allclose(x.act_inverse(x @ p), p, rtol=0, atol=1e-13)
    assert_allclose(x.act_direction(p), x @ p - x @ np.zeros(group.point_dimension), rtol=0, atol=1e-13)


@every_group
def test_interpolation_meets_both_ends_and_powers_add(group: type[bp.Group], rng: np.random.Generator) -> None:
    x, y = elements(group, rng, 50), elements(group, rng, 50)
    path = x.interpolate(y, np.linspace(0.0, 1.0, 5)[:, None])
    assert path.shape == (5, 50)
    assert np.all(path[0].is_near(x, 1e-13))
    assert np.all(path[-1].is_near(y, 1e-13))
    assert np.all((x**0.3 @ x**0.7).is_near(x, 1e-13))


@pytest.mark.parametrize("group", MATRIX_GROUPS)
def test_matrices_multiply_as_elements_do(group: type[bp.MatrixGroup], rng: np.random.Generator) -> None:
    x, y = group.exp(tangents(group, rng, 200)), group.exp(tangents(group, rng, 200))
    assert_allclose((x @ y).to_matrix(), x.to_matrix() @ y.to_matrix(), rtol=0, atol=2e-14)
    assert np.all(group.from_matrix(x.to_matrix()).is_near(x, 1e-14))
    assert np.all(group.project(x.to_matrix()).is_near(x, 1e-14))
    assert_allclose(group.vee(group.hat(x.log())), x.log(), rtol=0, atol=0)


DERIVATIVES = ["exp", "log", "inverse", "compose", "between", "rplus", "rminus", "lplus", "lminus", "power", "interpolate"]
ACTIONS = ["act", "act_inverse", "act_direction"]


@every_group
@pytest.mark.parametrize("side", ["", "_left"])
@pytest.mark.parametrize("name", DERIVATIVES + ACTIONS)
def test_jacobians_are_central_differences(
    group: type[bp.Group], name: str, side: str, rng: np.random.Generator
) -> None:
    x, y = (group.exp(0.5 * rng.uniform(-1.0, 1.0, (6, group.dimension))) for _ in range(2))
    tau, p = rng.normal(size=(6, group.dimension)) * 0.4, rng.normal(size=(6, group.point_dimension))
    t = np.linspace(-0.5, 1.5, 6)
    arguments = {
        "exp": (tau,), "log": (x,), "inverse": (x,), "compose": (x, y), "between": (x, y), "rplus": (x, tau),
        "rminus": (x, y), "lplus": (x, tau), "lminus": (x, y), "power": (x, t), "interpolate": (x, y, t),
        "act": (x, p), "act_inverse": (x, p), "act_direction": (x, p),
    }[name]  # fmt: skip
    function, with_jacobians = getattr(group, name), getattr(group, f"{name}{side}_jac")
    value, *jacobians = with_jacobians(*arguments)
    alone = function(*arguments)
    if isinstance(alone, bp.Group):
        assert np.all(alone.is_near(value, 1e-14)), "the value is that of the operation alone"
    else:
        assert_allclose(value, alone, rtol=0, atol=1e-14)
    step = 1e-5  # h²/6 and ε/h are both near 2e-11.

    def moved(argument: object, k: int, h: float) -> object:
        if isinstance(argument, bp.Group):
            tangent = h * np.eye(group.dimension)[k]
            return argument.lplus(tangent) if side else argument.rplus(tangent)
        array = np.asarray(argument)
        return array + h if array.ndim == 1 else array + h * np.eye(array.shape[-1])[k]

    for i, (argument, jacobian) in enumerate(zip(arguments, jacobians, strict=True)):
        width = 1 if jacobian.ndim == 2 else jacobian.shape[-1]
        for k in range(width):
            ahead, behind = (
                function(*arguments[:i], moved(argument, k, h), *arguments[i + 1 :]) for h in (step, -step)
            )
            if isinstance(ahead, bp.Group):
                difference = ahead.lminus(behind) if side else ahead.rminus(behind)
            else:
                difference = ahead - behind
            column = jacobian if jacobian.ndim == 2 else jacobian[..., k]
            assert_allclose(difference / (2 * step), column, rtol=0, atol=1e-8)
