"""What is refused, and how it is told."""

from __future__ import annotations

import numpy as np
import pytest

import boxplus as bp


def test_a_wrong_shape_names_what_was_expected_and_given() -> None:
    with pytest.raises(bp.ShapeError, match=r"tau: expected an array of shape \(\.\.\., 6\), not \(3, 5\)"):
        bp.SE3.exp(np.zeros((3, 5)))
    with pytest.raises(bp.ShapeError, match=r"p: expected an array of shape \(\.\.\., 3\), not \(\)"):
        bp.SE3().act(1.0)
    with pytest.raises(bp.ShapeError, match=r"matrix: expected an array of shape \(\.\.\., 4, 4\), not \(4,\)"):
        bp.SE3.from_matrix(np.zeros(4))
    with pytest.raises(bp.ShapeError, match=r"translation: expected an array of shape \(\.\.\., 3\), not \(2,\)"):
        bp.SE3(bp.SO3(), [1.0, 2.0])


def test_batches_that_do_not_broadcast_are_named() -> None:
    with pytest.raises(bp.ShapeError, match=r"do not broadcast: x \(3,\), y \(2, 4\)"):
        bp.SE3.identity(3).compose(bp.SE3.identity((2, 4)))
    with pytest.raises(bp.ShapeError, match=r"do not broadcast: translation \(2,\), rotation \(3,\)"):
        bp.SE3(bp.SO3.identity(3), np.zeros((2, 3)))


@pytest.mark.parametrize("count", [1, 100, 20_000])
@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf])
def test_a_number_that_is_not_finite_is_never_silent(wrong: float, count: int) -> None:
    tau = np.zeros((count, 6))
    tau[count // 2, 4] = wrong
    tau[-1, 5] = wrong
    place = rf"tau\[{count // 2}\] is NaN or infinite"
    with pytest.raises(bp.NotFiniteError, match=place):
        bp.SE3.exp(tau)
    with pytest.raises(bp.NotFiniteError, match=place):
        bp.SE3().rplus(tau)
    with pytest.raises(bp.NotFiniteError, match=rf"p\[{count // 2}, 0\] is NaN"):
        bp.SE3().act(tau.reshape(count, 2, 3)[:, 1:])
    with pytest.raises(bp.NotFiniteError, match="alpha is NaN"):
        bp.SE3().power(wrong)
    with pytest.raises(bp.NotFiniteError, match="numbers is NaN"):
        bp.SE3.from_array([0.0, 0.0, wrong, 0.0, 0.0, 0.0, 1.0])


def test_a_result_beyond_the_range_of_numbers_is_never_silent() -> None:
    far = bp.SE3(bp.SO3(), [[1e308, 0.0, 0.0], [0.0, 0.0, 0.0]])
    with pytest.raises(bp.NotFiniteError, match=r"the result at \[0\] is beyond the range"):
        far.compose(far)


def test_numbers_that_are_no_element_are_refused_with_their_place() -> None:
    rows = np.tile([0.0, 0.0, 0.0, 1.0], (3, 2, 1))
    rows[1, 1] = [0.0, 0.0, 0.0, 1.1]
    with pytest.raises(bp.LieError, match=r"numbers\[1, 1\]: the rotation is not of unit norm"):
        bp.SO3.from_array(rows)
    with pytest.raises(bp.LieError, match="reflection"):
        bp.SO3.from_matrix(np.diag([1.0, 1.0, -1.0]))
    with pytest.raises(bp.LieError, match="Euler sequence"):
        bp.SO3.from_euler("ZZX", [0.0, 0.0, 0.0])  # type: ignore[arg-type]  # pyright: ignore
    with pytest.raises(bp.LieError, match="x: a rotation by π has no Gibbs vector"):
        bp.SO3.from_quat_xyzw([1.0, 0.0, 0.0, 0.0]).to_gibbs()


def test_elements_of_another_group_are_refused() -> None:
    with pytest.raises(TypeError, match="expected elements of SE3, not SO3"):
        bp.SE3().compose(bp.SO3())  # type: ignore[arg-type]  # pyright: ignore
    with pytest.raises(TypeError, match="tau: expected numbers, not elements of SE2"):
        bp.Sim2.exp(bp.SE2())
    with pytest.raises(TypeError, match="tau: expected numbers"):
        bp.SO3.exp(np.zeros(3, dtype=np.complex128))
    with pytest.raises(TypeError, match="tau: expected numbers"):
        bp.SO3.exp("abc")
    with pytest.raises(TypeError):
        _ = np.zeros(3) @ bp.SO3()  # type: ignore[operator, unused-ignore]  # pyright: ignore


def test_every_exception_is_an_error_of_boxplus_and_of_values() -> None:
    for kind in (bp.ShapeError, bp.NotFiniteError, bp.LieError):
        assert issubclass(kind, bp.Error) and issubclass(kind, ValueError)
        assert kind.__module__ == "boxplus"
