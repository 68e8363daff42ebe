"""Makes random calls of the Python module: `python -m soak.caller SEED COUNT`. The child process of calls.py.

Prints the number of each call and its name before the call, and a line `FAULT: ...` for each fault. Ends with code 1
if there is a fault, or if a call takes longer than 10 seconds.
"""

from __future__ import annotations

import dataclasses
import faulthandler
import sys
from typing import Any

import numpy as np

import supple

from .arguments import Arguments, OwnError
from .objects import Objects
from .operations import OPERATIONS, WITH_FILES

#: Longest time of a call in seconds.
TIME_LIMIT = 10.0

#: Exceptions that any call may raise.
DOCUMENTED = (ValueError, TypeError, IndexError, FileNotFoundError, OwnError)


def main(seed: int, count: int) -> int:
    """Make calls."""
    faulthandler.enable()
    draw = Arguments(np.random.default_rng(seed))
    objects = Objects(draw)
    operations, weights = zip(*OPERATIONS, strict=True)
    chosen = draw.random.choice(len(operations), size=count, p=np.array(weights) / sum(weights))
    faults = 0
    for index, which in enumerate(chosen):
        operation = operations[which]
        print(index, operation.__name__, flush=True)
        faulthandler.dump_traceback_later(TIME_LIMIT, exit=True)
        fault = None
        try:
            result = operation(objects)
        except DOCUMENTED:
            pass
        except OSError as error:
            fault = None if operation in WITH_FILES else repr(error)
        except AttributeError as error:
            fault = None if operation.__name__.startswith("set_") else repr(error)
        except BaseException as error:  # PanicException is no Exception
            fault = f"{type(error).__module__}.{error!r}"
        else:
            fault = None if is_finite(result) else f"the result has numbers that are not finite: {result!r}"
        faulthandler.cancel_dump_traceback_later()
        if fault is not None:
            faults += 1
            print(f"FAULT: call {index}, {operation.__name__}: {fault[:2000]}", flush=True)
    return min(faults, 1)


def is_finite(value: Any) -> bool:
    """Return whether all numbers of a result are finite."""
    if isinstance(value, np.ndarray) and value.dtype.kind == "f":
        return bool(np.isfinite(value).all())
    if isinstance(value, float):
        return bool(np.isfinite(value))
    if isinstance(value, (list, tuple)):
        return all(map(is_finite, value))
    if isinstance(value, dict):
        return all(map(is_finite, value.values()))
    if dataclasses.is_dataclass(value) and not isinstance(value, supple.colliders.Collider):
        return all(is_finite(getattr(value, part.name)) for part in dataclasses.fields(value))
    return True


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]), int(sys.argv[2])))
