"""Imports optional dependencies."""

from __future__ import annotations

from importlib import import_module
from typing import Any

__all__ = ["import_optional"]


def import_optional(module: str, extra: str) -> Any:
    """Import a module. If it is missing, raise a ModuleNotFoundError with the install command of the extra.

    The extra is the group of optional dependencies in pyproject.toml that contains the module.
    """
    try:
        return import_module(module)
    except ModuleNotFoundError as missing:
        command = f'pip install ".[{extra}]"'
        message = f"{missing.name or module} is not installed; install it with `{command}` in a checkout of supple"
        raise ModuleNotFoundError(message, name=missing.name) from missing
