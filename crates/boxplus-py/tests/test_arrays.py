"""Groups behave like arrays of elements."""

from __future__ import annotations

import copy
import multiprocessing
import os
import pickle

import numpy as np
import pytest
from numpy.testing import assert_array_equal

import boxplus as bp
from conftest import GROUPS, elements, ticks_during

every_group = pytest.mark.parametrize("group", GROUPS)


@every_group
def test_constants_are_those_of_the_stored_elements(group: type[bp.Group]) -> None:
    one = group.identity()
    assert one.log().shape == (group.dimension,)
    assert np.asarray(one).shape == (group.numbers,) == (sum(n for _, n in group.fields),)
    assert one.linear_part().shape == (group.point_dimension,) * 2


@every_group
def test_shapes_broadcast_like_numpy(group: type[bp.Group], rng: np.random.Generator) -> None:
    x, y = elements(group, rng, 3, 1, 4), elements(group, rng, 5, 1)
    product = x @ y
    assert product.shape == (3, 5, 4) and product.ndim == 3 and product.size == 60 and len(product) == 3
    for i, j, k in np.ndindex(3, 5, 4):
        assert_array_equal(np.asarray(product[i, j, k]), np.asarray(x[i, 0, k] @ y[j, 0]))
    p = rng.normal(size=(2, group.point_dimension))
    assert (x[..., None] @ p).shape == (3, 1, 4, 2, group.point_dimension)


@every_group
def test_indexing_iteration_stacking_and_reshaping_keep_elements(group: type[bp.Group], rng: np.random.Generator) -> None:
    x = elements(group, rng, 4, 3)
    rows = list(x)
    assert [row.shape for row in rows] == [(3,)] * 4
    assert np.all(group.stack(rows) == x)
    assert np.all(group.stack(rows, axis=-1) == group.stack([x[:, i] for i in range(3)]))
    assert np.all(group.concatenate([x[:1], x[1:]]) == x)
    assert x.reshape(-1).shape == (12,) and np.all(x.reshape(2, 6).reshape(4, 3) == x)
    assert x[1:, [0, 2]].shape == (3, 2) and x[..., -1].shape == (4,) and x[x[:, 0] == x[:, 0]].shape == (4, 3)
    assert group.identity((0,)).shape == (0,) and list(group.identity(0)) == []
    assert (group.identity((0, 3)) @ x[0]).shape == (0, 3)


@every_group
def test_the_axis_of_the_stored_numbers_is_none_of_the_elements(group: type[bp.Group], rng: np.random.Generator) -> None:
    x = elements(group, rng, group.numbers)
    for axis in (2, -3):
        with pytest.raises(IndexError, match="out of bounds"):
            group.stack([x, x], axis)
    assert group.stack([x, x], 1).shape == (group.numbers, 2) and group.stack([x, x], -2).shape == (2, group.numbers)
    for axis in (1, -2):
        with pytest.raises(IndexError, match="out of bounds"):
            group.concatenate([x, x], axis)
    with pytest.raises(IndexError, match="out of bounds"):
        group.concatenate([x[0], x[1]])
    with pytest.raises(ValueError, match="at least one array"):
        group.stack([])


@every_group
def test_elements_do_not_change(group: type[bp.Group], rng: np.random.Generator) -> None:
    given = np.array(elements(group, rng, 5))
    x = group.from_array(given)
    given[:] = 0.0
    assert np.all(x == copy.deepcopy(x)), "the array that was given is not the one that is kept"
    for derived in (x, x[0], x[1:], x[[0, 1]], x.reshape(5, 1), group.stack([x, x]), x.inverse(), x.broadcast_to((2, 5)), x.broadcast_to((2, 5)).reshape(-1)):
        with pytest.raises(ValueError, match="read-only"):
            np.asarray(derived)[...] = 0.0
    assert np.shares_memory(np.asarray(x), np.asarray(x[1:]))
    changeable = x.to_array()
    changeable[:] = 0.0
    assert not np.any(np.asarray(x)[:, -1:] == 0.0) or group.dimension > 0


@every_group
def test_pickle_and_copy_keep_every_bit(group: type[bp.Group], rng: np.random.Generator) -> None:
    x = elements(group, rng, 6, 2)
    for again in (pickle.loads(pickle.dumps(x)), copy.copy(x), group.from_array(x.to_array())):
        assert type(again) is group
        assert_array_equal(np.asarray(again), np.asarray(x))


def test_any_array_of_real_numbers_is_taken(rng: np.random.Generator) -> None:
    tau = rng.integers(-3, 3, (4, 6))
    exact = bp.SE3.exp(tau.astype(np.float64))
    for same in (tau, tau.tolist(), tau.astype(np.float32), np.asfortranarray(tau), tau[:, ::-1][:, ::-1]):
        assert np.all(bp.SE3.exp(same) == exact)
    wide = rng.normal(size=(4, 12))
    assert np.all(bp.SE3.exp(wide[:, ::2]) == bp.SE3.exp(wide[:, ::2].copy()))
    assert np.all(bp.SE3.exp(wide.astype(">f8")[:, :6]) == bp.SE3.exp(wide[:, :6]))
    assert bp.SO2.from_angle(1).angle == bp.SO2.from_angle(np.float32(1.0)).angle == bp.SO2.from_angle(1.0).angle


def test_large_batches_equal_their_elements_alone(rng: np.random.Generator) -> None:
    tau = rng.normal(size=(10_001, 6))
    x = bp.SE3.exp(tau)
    value, d_x, d_base = x.rminus_jac(x[0])
    for i in (0, 1, 1023, 1024, 4095, 10_000):
        assert_array_equal(np.asarray(x[i]), np.asarray(bp.SE3.exp(tau[i])))
        alone = x[i].rminus_jac(x[0])
        assert_array_equal(value[i], alone[0])
        assert_array_equal(d_x[i], alone[1])
        assert_array_equal(d_base[i], alone[2])


def test_other_threads_run_while_a_batch_is_computed() -> None:
    tau = np.random.default_rng(0).normal(size=(400_000, 9))
    assert ticks_during(lambda: bp.SE23.exp_jac(tau)) > 1000


@pytest.mark.skipif(not hasattr(os, "fork"), reason="processes do not fork here")
@pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")
def test_a_forked_process_computes_large_batches_too() -> None:
    tau = np.random.default_rng(0).normal(size=(10_000, 6))
    expected = np.asarray(bp.SE3.exp(tau))
    child = multiprocessing.get_context("fork").Process(
        target=lambda: os._exit(0 if np.array_equal(np.asarray(bp.SE3.exp(tau)), expected) else 1)
    )
    child.start()
    child.join(60)
    child.kill()
    assert child.exitcode == 0, "it waits for threads that are not there, or other numbers come out"


def test_equality_knows_that_q_and_its_negative_are_one_rotation() -> None:
    q = np.array([[0.1, 0.2, 0.3, 0.9], [0.0, 0.0, 0.0, 1.0]])
    assert np.all(bp.SO3.from_quat_xyzw(q) == bp.SO3.from_quat_xyzw(-q))
    assert (bp.SO3() == bp.SO3()) is True and (bp.SO3() != bp.SO3()) is False
    assert bp.SO3() != bp.SE3()
    with pytest.raises(TypeError, match="unhashable"):
        hash(bp.SO3())


def test_repr_reads_well() -> None:
    pose = bp.SE3(bp.SO3(), [1.0, 2.5, 3.0])
    assert repr(pose) == "SE3(translation=[1, 2.5, 3], xyzw=[0, 0, 0, 1])"
    assert repr(bp.Sim2(log_scale=0.5)) == "Sim2(translation=[0, 0], cos_sin=[1, 0], log_scale=0.5)"
    assert repr(bp.R1([2.0])) == "R1([2])"
    assert repr(bp.SO2.identity(9)).splitlines() == ["SO2 of shape (9,):", *["  cos_sin [1, 0]"] * 4, "  …"]
