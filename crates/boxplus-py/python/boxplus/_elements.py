"""Elements as NumPy has numbers: one, or an array of them, stored as the rows of one array."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar, TypeAlias

import numpy as np
import numpy.typing as npt

from boxplus._core import ShapeError

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from types import EllipsisType

    from typing_extensions import Self

    from boxplus import _core

    Floats: TypeAlias = npt.NDArray[np.float64]
    Scalars: TypeAlias = float | npt.NDArray[np.float64]
    Bools: TypeAlias = bool | npt.NDArray[np.bool_]
    Axis: TypeAlias = int | slice | EllipsisType | None | Sequence[int] | npt.NDArray[np.intp] | npt.NDArray[np.bool_]
    Index: TypeAlias = Axis | tuple[Axis, ...]


class Elements:
    """One element or an array of them, of any shape, as an array of stored numbers that nobody writes to."""

    __slots__ = ("_numbers",)

    dimension: ClassVar[int]
    """D, the length of a tangent."""
    numbers: ClassVar[int]
    """How many numbers an element is stored as; `fields` names them."""
    point_dimension: ClassVar[int]
    """P, the length of the points that the group moves."""
    fields: ClassVar[tuple[tuple[str, int], ...]]
    """The names and lengths of the parts of the stored numbers, in order."""

    _operations: ClassVar[_core.Group]
    _numbers: Floats

    @classmethod
    def _of(cls, numbers: Floats) -> Self:
        """The elements of an array that is known to hold elements and that nobody writes to."""
        elements = object.__new__(cls)
        elements._numbers = numbers
        return elements

    @classmethod
    def _same(cls, other: Elements) -> Floats:
        if type(other) is not cls:
            raise TypeError(f"expected elements of {cls.__name__}, not {type(other).__name__}")
        return other._numbers

    @classmethod
    def from_array(cls, numbers: npt.ArrayLike) -> Self:
        """The elements whose stored numbers are given, ``(..., numbers)``.

        A rotation that is of unit norm to rounding keeps its bits, one that was rounded in print (by 1e-5) is normalised, anything else
        raises `LieError`.
        """
        return cls._of(cls._operations.from_array(numbers))

    @classmethod
    def stack(cls, elements: Sequence[Self], axis: int = 0) -> Self:
        """Elements of equal shapes along a new axis."""
        rows = [cls._same(x) for x in elements]
        return cls._of(_frozen(np.stack(rows, _place(axis, rows[0].ndim if rows else 1))))

    @classmethod
    def concatenate(cls, elements: Sequence[Self], axis: int = 0) -> Self:
        """Arrays of elements one behind the other along an existing axis."""
        rows = [cls._same(x) for x in elements]
        return cls._of(_frozen(np.concatenate(rows, _place(axis, rows[0].ndim - 1 if rows else 1))))

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape of the array of elements, ``()`` for a single one."""
        return self._numbers.shape[:-1]

    @property
    def ndim(self) -> int:
        """How many axes `shape` has."""
        return self._numbers.ndim - 1

    @property
    def size(self) -> int:
        """How many elements there are."""
        return self._numbers.size // self.numbers

    def to_array(self) -> Floats:
        """A copy of the stored numbers, ``(..., numbers)``, which may be written to."""
        return self._numbers.copy()

    def __array__(self, dtype: npt.DTypeLike | None = None, copy: bool | None = None) -> npt.NDArray[Any]:
        """The stored numbers, ``(..., numbers)``: without a copy and read-only where the caller allows it."""
        if copy or (dtype is not None and np.dtype(dtype) != self._numbers.dtype):
            if copy is False:
                raise ValueError("elements are stored in double precision; another type needs a copy")
            return np.array(self._numbers, dtype=dtype)
        return self._numbers

    def reshape(self, *shape: int) -> Self:
        """The same elements in another shape, in row-major order; one extent may be -1."""
        return self._of(_frozen(self._numbers.reshape(*shape, self.numbers)))

    def broadcast_to(self, shape: tuple[int, ...]) -> Self:
        """The elements repeated to `shape`, without a copy."""
        return self._of(np.broadcast_to(self._numbers, (*shape, self.numbers)))

    def __len__(self) -> int:
        if self._numbers.ndim == 1:
            raise TypeError(f"a single element of {type(self).__name__} has no length")
        return len(self._numbers)

    def __iter__(self) -> Iterator[Self]:
        if self._numbers.ndim == 1:
            raise TypeError(f"a single element of {type(self).__name__} cannot be iterated over")
        return map(self._of, self._numbers)

    def __getitem__(self, index: Index) -> Self:
        index = index if isinstance(index, tuple) else (index,)
        index = index if any(part is Ellipsis for part in index) else (*index, Ellipsis)
        return self._of(_frozen(self._numbers[(*index, slice(None))]))

    def __copy__(self) -> Self:
        return self

    def __deepcopy__(self, _: object) -> Self:
        return self

    def __reduce__(self) -> tuple[object, ...]:
        return type(self).from_array, (self.to_array(),)

    def __repr__(self) -> str:
        name, rows = type(self).__name__, self._numbers.reshape(-1, self.numbers)
        if self.ndim == 0:
            return f"{name}({self._described(rows[0], '=')})"
        lines = [f"  {self._described(row, ' ')}" for row in rows[:4]] + ["  …"] * (len(rows) > 4)
        return "\n".join([f"{name} of shape {self.shape}:", *lines])

    @classmethod
    def _described(cls, row: Floats, separator: str) -> str:
        ends = np.cumsum([length for _, length in cls.fields])
        parts = zip(cls.fields, np.split(row, ends[:-1]), strict=True)
        told = (
            (name, ", ".join(f"{x:.6g}" for x in part), length) for (name, length), part in parts
        )
        return ", ".join(
            f"{name}{separator if name else ''}" + (f"[{text}]" if length > 1 or not name else text)
            for name, text, length in told
        )


def _frozen(array: Floats) -> Floats:
    array.flags.writeable = False
    return array


def _place(axis: int, axes: int) -> int:
    """An axis of so many, from the front: behind them is that of the stored numbers."""
    if not -axes <= axis < axes:
        raise np.exceptions.AxisError(axis, axes)
    return axis % axes


def joined(*parts: tuple[npt.ArrayLike | Elements, int | None], names: Sequence[str]) -> Floats:
    """Stored numbers of parts whose batches broadcast: elements, vectors of a given length, or numbers (None)."""
    arrays: list[Floats] = []
    for (part, length), name in zip(parts, names, strict=True):
        array = np.asarray(part, dtype=np.float64)
        if length is None:
            array = array[..., None]
        elif array.shape[-1:] != (length,):
            raise ShapeError(f"{name}: expected an array of shape (..., {length}), not {array.shape}")
        arrays.append(array)
    try:
        batch = np.broadcast_shapes(*(array.shape[:-1] for array in arrays))
    except ValueError:
        told = ", ".join(f"{name} {array.shape[:-1]}" for name, array in zip(names, arrays, strict=True))
        raise ShapeError(f"batches do not broadcast: {told}") from None
    return np.concatenate([np.broadcast_to(array, (*batch, array.shape[-1])) for array in arrays], -1)


def number(array: Floats, index: int = 0) -> Scalars:
    """One number of each row; a float of a single row."""
    return float(array[index]) if array.ndim == 1 else array[..., index]
