"""Computes goal positions by naive sums in float64. This is slow; use it to check the fast implementation."""

from ._core import reference_goals as goals

__all__ = ["goals"]
