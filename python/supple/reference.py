"""Naive implementation of the method in float64: slow, for comparison with the fast implementation."""

from ._core import reference_goals as goals

__all__ = ["goals"]
