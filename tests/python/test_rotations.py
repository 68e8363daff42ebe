"""Rotation factors compared with a sign-corrected singular value decomposition."""

import re

import numpy as np
import pytest

import supple


def _svd_rotations(a):
    u, _, vt = np.linalg.svd(a)
    u[:, :, 2] *= np.linalg.det(u @ vt)[:, None]
    return u @ vt


def test_rotations_of_random_matrices_equal_the_svd():
    a = np.random.default_rng(0).normal(size=(20_000, 3, 3))
    r = supple.rotations(a)
    s = np.linalg.svd(a, compute_uv=False)
    gap = s[:, 1] + np.sign(np.linalg.det(a)) * s[:, 2]
    unique = gap > 1e-2
    # A perturbation E of A rotates its factor by about E/gap; 4e-6 for E as in rotations.rs.
    error = np.abs(r - _svd_rotations(a)).max(axis=(1, 2))
    assert np.all(error[unique] <= 4e-6 * (s[:, 0] / gap)[unique])
    assert np.abs(r @ r.swapaxes(1, 2) - np.eye(3)).max() < 1e-6
    assert np.linalg.det(r).min() > 0


@pytest.mark.parametrize("scale", [1e-30, 1e-3, 1e30])
def test_rotations_are_independent_of_scale(scale):
    a = np.random.default_rng(1).normal(size=(100, 3, 3))
    assert np.allclose(supple.rotations(scale * a), supple.rotations(a), atol=1e-6)


def test_degenerate_matrices_give_proper_rotations():
    a = np.array([np.zeros((3, 3)), np.diag([1.0, 0, 0]), np.diag([1.0, 1, 0]), -np.eye(3), np.diag([1.0, 1, -1])])
    r = supple.rotations(a)
    assert np.array_equal(r[0], np.eye(3))
    assert np.abs(r @ r.swapaxes(1, 2) - np.eye(3)).max() < 1e-6
    # Optimal: the trace of R^T A is s1 + s2 +- s3.
    assert np.allclose(np.einsum("nij,nij->n", r, a), [0, 1, 2, 1, 1], atol=1e-6)
    assert np.abs(np.linalg.det(r) - 1).max() < 1e-6


def test_one_matrix_and_an_empty_list():
    assert np.allclose(supple.rotations(2 * np.eye(3)), np.eye(3))
    assert supple.rotations(np.zeros((0, 3, 3))).shape == (0, 3, 3)
    assert supple.rotations([[[1, 0, 0], [0, 1, 0], [0, 0, 1]]]).shape == (1, 3, 3)


@pytest.mark.parametrize("shape", [(3,), (2, 3), (4, 3, 2), (1, 1, 3, 3)])
def test_wrong_shapes_are_errors(shape):
    expected = (3, 3) if len(shape) == 2 else "(n, 3, 3)"
    with pytest.raises(ValueError, match=re.escape(f"a has the shape {shape}; it must be {expected}")):
        supple.rotations(np.zeros(shape))


def test_non_finite_entries_are_errors():
    a = np.zeros((4, 3, 3))
    a[2, 1, 0] = np.nan
    with pytest.raises(ValueError, match=r"a\[2, 1, 0\] = NaN"):
        supple.rotations(a)
