"""The method in its naive form: plain sums in float64, slow, and the oracle of the fast ones."""

from ._core import reference_goals as goals

__all__ = ["goals"]
