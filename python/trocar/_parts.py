"""Prepares user-defined parts for the core."""

from __future__ import annotations

import ctypes
import inspect
from collections.abc import Callable
from typing import Any, Protocol, TypedDict, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._arrays import samples

_SIGNATURE = "(float64*, float64*, float64*) -> none"


class Compiled:
    """A compiled function as a part: from numba, C or another language that exports C functions.

    Its signature is ``void f(const double *inputs, double *outputs, double *state)``. Its role determines the inputs
    and outputs, in the order of :mod:`trocar.parts`; booleans are 1 and 0, and outputs that the function does not
    write are 0. The core calls it without the interpreter, at the speed of a built-in part.

    Parameters
    ----------
    function
        A numba ``cfunc`` with the signature ``void(CPointer(float64), CPointer(float64), CPointer(float64))``, a
        ``ctypes`` function, or an address. It must stay in memory during the run. Only numba's signature is checked;
        a ``ctypes`` function or an address with another signature has undefined behaviour.
    state : array, shape (numbers,)
        The initial state, of any length. Each run gets a copy.

    Raises
    ------
    TypeError
        For a numba function with another signature, and for a ``function`` that is not compiled.
    ValueError
        For the address 0 or an address out of range, and for a ``state`` that is not a one-dimensional array of
        numbers.

    >>> import ctypes, trocar
    >>> trocar.Compiled(0x1000, state=[0.0, 1.0])
    Compiled(0x1000, 2 numbers of state)
    """

    def __init__(self, function: Any, state: ArrayLike = ()) -> None:
        signature = str(getattr(function, "_sig", _SIGNATURE))
        if signature != _SIGNATURE:
            raise TypeError(f"the compiled function has the signature {signature}, must be {_SIGNATURE}")
        self.function = function
        self._trocar_state: NDArray[np.float64] = samples("state", np.array(state, dtype=np.float64))
        self._trocar_address = _address(function)

    def __repr__(self) -> str:
        return f"Compiled({self._trocar_address:#x}, {len(self._trocar_state)} numbers of state)"


# The base class of all functions of ctypes.
_CFunction: Any = ctypes.CFUNCTYPE(None).__mro__[1]


def _address(function: Any) -> int:
    address = getattr(function, "address", function)
    if isinstance(function, (_CFunction, ctypes.c_void_p)):
        address = ctypes.cast(function, ctypes.c_void_p).value or 0
    if isinstance(address, bool) or not isinstance(address, int):
        raise TypeError(f"{function!r} is not a compiled function: a numba cfunc, a function of ctypes, or an address")
    if not 0 < address < 2 ** (8 * ctypes.sizeof(ctypes.c_void_p)):
        raise ValueError(f"the compiled function has the address {address}")
    return address


class _Stepped(Protocol):
    # Read-only: a method does not match an attribute that can be set.
    @property
    def step(self) -> Callable[..., Any]: ...


class _Architecture(Protocol):
    @property
    def slave_target(self) -> Callable[..., float]: ...
    @property
    def master_force(self) -> Callable[..., float]: ...


Part = Union[Callable[..., Any], _Stepped, Compiled]
"""A user-defined part: a function, an object with the methods ``step`` and ``reset``, a class of objects with a method
``step``, or a :class:`Compiled` function."""


def takes_arguments(function: Callable[..., Any], count: int) -> bool:
    """Returns true if a function can be called with a number of positional arguments, or if its signature is unknown."""
    try:
        signature = inspect.signature(function)
    except (TypeError, ValueError):
        return True
    try:
        signature.bind(*range(count))
    except TypeError:
        return False
    return True


class Parts(TypedDict, total=False):
    """The roles that user-defined parts can have; :mod:`trocar.parts` lists their arguments and results."""

    tissue: Part | None
    operator: Part | None
    estimator: Part | None
    detector: Part | None
    distance: Part | None
    architecture: _Architecture | type[_Architecture] | None
    passivity: object | None
    force_law: Part | None
    motion_law: Part | None


def core_parts(parts: Parts) -> dict[str, Any]:
    """Returns the parts for the core. Wraps numba functions in :class:`Compiled`."""
    given = {role: part for role, part in parts.items() if part is not None}
    return {role: Compiled(part) if hasattr(part, "_sig") else part for role, part in given.items()}
