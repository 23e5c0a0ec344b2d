# SPDX-License-Identifier: GPL-3.0-or-later
"""What all objects of the library have in common, and all arrays and structs it is given."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Self

import numpy as np

from . import native


class Memory:
    """One object of the library: freed with the last reference to it, and before what it needs."""

    def __init__(self, pointer: object, destroy: Callable, needs: object = None) -> None:
        self.pointer, self._destroy, self._needs = pointer, destroy, needs

    def __del__(self) -> None:
        self._destroy(self.pointer)


class Owner:
    """Holds one object of the library until close()."""

    def __init__(self, memory: Memory) -> None:
        self._memory: Memory | None = memory

    @property
    def _pointer(self) -> object:
        if self._memory is None:
            raise ValueError(f"this {type(self).__name__} is closed")
        return self._memory.pointer

    def close(self) -> None:
        """Let go of the memory now; nothing but close() may be called afterwards."""
        self._memory = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()


def as_matrix(array: np.ndarray, dtype: type, rows: int | None = None) -> np.ndarray:
    array = np.ascontiguousarray(array, dtype)
    if array.ndim != 2 or rows not in (None, len(array)):
        raise ValueError(f"expected a matrix of {rows or 'some'} rows, not shape {array.shape}")
    return array


def offsets(parts: Sequence[Sequence]) -> np.ndarray:
    return np.cumsum([0, *map(len, parts)], dtype=np.int32)


def set_options(struct: native.Sized, options: dict[str, float]) -> None:
    names = {name.removesuffix("_"): name for name in options}  # lambda_ is a word of Python
    known = {name for name, _ in struct._fields_[1:]}
    if unknown := sorted(given for name, given in names.items() if name not in known):
        raise TypeError(f"unknown option {unknown[0]!r}; there are: {', '.join(sorted(known))}")
    for name, given in names.items():
        setattr(struct, name, options[given])


def fields_of(struct: native.Sized) -> dict[str, float]:
    values = {name: getattr(struct, name) for name, _ in struct._fields_[1:]}
    if "converged" in values:
        values["converged"] = bool(values["converged"])
    return values
