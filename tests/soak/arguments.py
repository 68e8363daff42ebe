"""Random arguments of the Python module, valid and invalid."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

#: Share of the arguments that are taken from `INVALID`.
INVALID_SHARE = 0.08


class OwnError(Exception):
    """Raised by arguments themselves; the module passes it on."""


class Raises:
    """An argument whose conversion to anything raises an exception."""

    def __array__(self, *_arguments: object, **_keywords: object) -> Any:
        raise OwnError

    def __index__(self) -> int:
        raise OwnError

    def __float__(self) -> float:
        raise OwnError

    def __iter__(self) -> Any:
        raise OwnError

    def __fspath__(self) -> str:
        raise OwnError


#: Values that most arguments must refuse. None of them asks for a long calculation.
INVALID: list[Any] = [
    *[None, True, False, -1, 0, 1.5, np.nan, np.inf, -np.inf, 1e308, -1e308, 1e-320, 1e39, 2**31, -(2**31), 2**63],
    *[2**64, 10**400, "", "text", "\0", "\ud800", "a" * 5000, b"bytes", 1j, object(), Raises(), len, range(3)],
    *[[], [[]], (), {}, {"a": 1}, {1: 2}, {3}, [1, 2], [1, 2, "a"], [1, [2], 3], [None] * 3, [[1, 2, 3]]],
    *[np.zeros(0), np.zeros((0, 3)), np.zeros((1, 3)), np.full(3, np.nan), np.full((4, 3), np.inf)],
    *[np.zeros((3, 3), complex), np.array(["a", "b", "c"]), np.array([object()] * 3), np.zeros((2, 2, 2, 2))],
    *[np.array(7), np.float32(2), np.int64(-5), np.array([2**64 - 1], np.uint64), np.zeros(3, ">f4")[::-1]],
    *[np.array(["2020-01-01"] * 3, "datetime64[D]"), np.zeros(3, [("a", "f8")]), Path("missing.obj"), Path("."), "."],
]


class Arguments:
    """Draws random arguments."""

    def __init__(self, random: np.random.Generator) -> None:
        self.random = random

    def chance(self, probability: float) -> bool:
        """Return whether an event of the given probability happens."""
        return bool(self.random.random() < probability)

    def one_of(self, values: Any) -> Any:
        """Return one of the values, without a conversion by numpy."""
        return values[int(self.random.integers(len(values)))]

    def or_invalid(self, value: Any) -> Any:
        """Return the value, or sometimes an invalid one."""
        return self.one_of(INVALID) if self.chance(INVALID_SHARE) else value

    def number(self, low: float, high: float) -> Any:
        """Return a number in a range, as one of several types."""
        value = float(self.random.uniform(low, high))
        return self.or_invalid(self.one_of([value, np.float32(value), np.float64(value), np.array(value)]))

    def whole(self, low: int, high: int) -> Any:
        """Return a whole number in a range, the end excluded."""
        value = int(self.random.integers(low, high))
        return self.or_invalid(self.one_of([value, value, np.int32(value), np.uint8(value & 255)]))

    def vector(self, size: float = 1.0) -> Any:
        """Return three numbers."""
        return self.array(self.random.uniform(-size, size, 3))

    def array(self, values: np.ndarray) -> Any:
        """Return an array as one of several types."""
        wide = np.repeat(values, 2, axis=-1)[..., ::2]
        forms = [values, values.tolist(), values.astype("f4"), values.astype(">f8"), np.asfortranarray(values), wide]
        return self.or_invalid(self.one_of(forms))

    def options(self, **values: Any) -> dict[str, Any]:
        """Return some of the keywords, and rarely an unknown one."""
        chosen = {name: value for name, value in values.items() if self.chance(0.25)}
        return {**chosen, "unknown": 1} if self.chance(0.01) else chosen

    def keys(self) -> Any:
        """Return keyframes."""
        times = np.cumsum(self.random.uniform(0.01, 0.5, int(self.random.integers(1, 4))))
        keys: list[Any] = [(float(time), self.vector(), self.vector(90)) for time in times]
        if self.chance(0.1):
            keys = [{"time": time, "translate": translate} for time, translate, _ in keys]
        return self.or_invalid(keys if self.chance(0.95) else keys[::-1])

    def curve(self, low: float, high: float) -> Any:
        """Return a number in a range, or keyframes of such numbers."""
        times = np.cumsum(self.random.uniform(0.01, 0.5, int(self.random.integers(1, 4))))
        keys: Any = [(float(time), self.number(low, high)) for time in times]
        if self.chance(0.3):
            keys = {"keys": keys, "interpolation": self.one_of(["linear", "smooth", "cubic"])}
        return self.number(low, high) if self.chance(0.5) else self.or_invalid(keys)

    def selection(self, count: int) -> dict[str, Any]:
        """Return a selection of vertices of a body with `count` lattice vertices."""
        box = (self.vector(), self.vector(2)) if self.chance(0.3) else ((-2, -2, -2), (2, self.number(-1, 2), 2))
        choices = {
            "box": self.or_invalid(self.one_of([box, {"min": box[0], "max": box[1]}])),
            "sphere": self.or_invalid((self.vector(), self.number(0.5, 2))),
            "plane": self.or_invalid(((0, 0, 0), self.vector())),
            "vertices": self.or_invalid(self.random.integers(0, count + self.chance(0.1), 5)),
        }
        names = [name for name in choices if self.chance(0.02)] or [self.one_of(list(choices))]
        return {name: choices[name] for name in names}

    def window(self) -> dict[str, Any]:
        """Return the time window of a pin or handle."""
        return self.options(start=self.number(0, 0.1), end=self.number(0.1, 0.5))
