"""Changes single positions and velocities of a body."""

from __future__ import annotations

from types import TracebackType

import numpy as np
from numpy.typing import NDArray

from ._core import Body

__all__ = ["Edit"]


class Edit:
    """The positions and velocities of a body as writable arrays, in a `with` block. Body.edit returns it.

    Arrays that differ from the state at the start of the block are written to the body at its end, or nothing if the
    block raises an exception or an array has an invalid value.
    """

    #: Positions of the lattice vertices: (n, 3).
    positions: NDArray[np.float64]
    #: Velocities of the lattice vertices in length/s: (n, 3).
    velocities: NDArray[np.float64]

    def __init__(self, body: Body) -> None:
        """Prepare the change of a body."""
        self._body = body

    def __enter__(self) -> Edit:
        """Copy the state of the body."""
        self._before = (self._body.positions, self._body.velocities)
        self.positions, self.velocities = (array.copy() for array in self._before)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Write changed arrays to the body, unless the block raised an exception."""
        if kind is not None:
            return
        arrays = (self.positions, self.velocities)
        changed = (not np.array_equal(now, before) for now, before in zip(arrays, self._before, strict=True))
        self._body._set_state(*(array if is_new else None for array, is_new in zip(arrays, changed, strict=True)))
