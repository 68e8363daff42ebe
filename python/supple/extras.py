"""Libraries that only some of supple needs."""

from __future__ import annotations

from importlib import import_module
from typing import Any

__all__ = ["need"]


def need(module: str, extra: str) -> Any:
    """The module, or a ModuleNotFoundError that says how to get it."""
    try:
        return import_module(module)
    except ModuleNotFoundError as missing:
        message = f'{module} is not installed; `pip install "supple[{extra}]"` brings it'
        raise ModuleNotFoundError(message, name=missing.name) from missing
