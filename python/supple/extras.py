"""Imports optional dependencies."""

from __future__ import annotations

from importlib import import_module
from typing import Any

__all__ = ["import_optional"]


def import_optional(module: str) -> Any:
    """Import a module. If it is missing, raise a ModuleNotFoundError with the command that installs it."""
    try:
        return import_module(module)
    except ModuleNotFoundError as missing:
        name = (missing.name or module).partition(".")[0]
        raise ModuleNotFoundError(
            f"{name} is not installed; install it with `pip install {name}`", name=name
        ) from missing
