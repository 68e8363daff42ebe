"""Import of optional dependencies."""

from __future__ import annotations

from importlib import import_module
from typing import Any

__all__ = ["need"]


def need(module: str, extra: str) -> Any:
    """Import a module, or raise a ModuleNotFoundError with the install command of the extra that provides it."""
    try:
        return import_module(module)
    except ModuleNotFoundError as missing:
        message = f'{module} is not installed; install it with `pip install "supple[{extra}]"`'
        raise ModuleNotFoundError(message, name=missing.name) from missing
