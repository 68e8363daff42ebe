"""Arrays: accepted forms, returned types, errors, and `out` arguments."""

import tracemalloc

import numpy as np
import pytest

import supple


@pytest.fixture
def body(block):
    return supple.Body(block)


def _forms(array):
    """Returns the same numbers as lists and as arrays of several types and layouts."""
    read_only = array.copy()
    read_only.flags.writeable = False
    padded = np.zeros((2 * len(array), 5))
    padded[::2, 1:4] = array
    return {
        "list": array.tolist(),
        "tuples": tuple(map(tuple, array)),
        "float32": array.astype(np.float32),
        "read-only": read_only,
        "fortran": np.asfortranarray(array),
        "strided": padded[::2, 1:4],
        "reversed": array[::-1].copy()[::-1],
        "big-endian": array.astype(">f8"),
        "half": array.astype(np.float16),
        "integers": (4 * array).astype(np.int16),
        "unsigned": (4 * array).astype(np.uint64),
    }


@pytest.mark.parametrize("name", ["positions", "velocities"])
def test_all_number_types_and_layouts_are_accepted(body, name):
    values = np.round(4 * np.random.default_rng(1).random((len(body), 3))) / 4
    for form, given in _forms(values).items():
        setattr(body, name, given)
        expected = 4 * values if form in ("integers", "unsigned") else values
        assert np.allclose(getattr(body, name), expected, atol=1e-6), form


def test_state_arrays_are_new_float64_copies(body):
    for name, shape in [("positions", (3,)), ("velocities", (3,)), ("rotations", (3, 3)), ("masses", ())]:
        array = getattr(body, name)
        assert array.shape == (len(body), *shape)
        assert array.dtype == np.float64
        assert array.flags.c_contiguous
        before = array.copy()
        array[...] = 7
        assert np.array_equal(getattr(body, name), before)
    for evaluate in (body.goals, body.corrected_positions):
        assert evaluate().shape == (len(body), 3)
        assert evaluate().dtype == np.float64


@pytest.mark.parametrize("name", ["positions", "velocities"])
@pytest.mark.parametrize(
    ("value", "error", "message"),
    [
        (lambda n: np.zeros((n - 1, 3)), ValueError, r"has the shape \(59, 3\); it must be \(60, 3\)"),
        (lambda n: np.zeros(n), ValueError, r"has the shape \(60,\); it must be \(60, 3\)"),
        (lambda n: np.zeros((n, 3), complex), TypeError, "complex128"),
        (lambda n: np.zeros((n, 3), "U1"), TypeError, "<U1"),
        (lambda n: np.zeros((n, 3), object), TypeError, "object"),
        (lambda n: None, TypeError, "not NoneType"),
        (lambda n: 3.0, TypeError | ValueError, "must be"),
    ],
)
def test_errors_name_the_argument_the_value_and_the_expected_type(body, name, value, error, message):
    errors = (TypeError, ValueError) if error == TypeError | ValueError else error
    with pytest.raises(errors, match=f"^{name} .*{message}"):
        setattr(body, name, value(len(body)))


@pytest.mark.parametrize("name", ["positions", "velocities"])
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_non_finite_values_are_errors_with_their_index(body, name, bad):
    before = getattr(body, name)
    values = before.copy()
    values[17, 2] = bad
    with pytest.raises(ValueError, match=rf"{name}\[17, 2\] = .* is not finite"):
        setattr(body, name, values)
    assert np.array_equal(getattr(body, name), before)


@pytest.mark.parametrize("name", ["positions", "velocities"])
@pytest.mark.parametrize("scale", [1e16, 1e60, 1e300])
def test_values_beyond_the_limit_are_errors_with_their_index(body, name, scale):
    values = np.zeros((len(body), 3))
    values[4] = scale
    with pytest.raises(ValueError, match=rf"{name}\[4\] = .* is too large: the limit is 5\.000e14, 10\^15 cells"):
        setattr(body, name, values)


@pytest.mark.parametrize("method", ["surface", "surface_normals"])
def test_out_arguments_are_filled_and_returned(cube, method):
    body = supple.Body(cube, lattice_vertices=100)
    expected = getattr(body, method)()
    assert expected.dtype == np.float64
    for dtype, tolerance in [(np.float64, 0), (np.float32, 1e-6)]:
        padded = np.zeros((16, 4), dtype)
        for out in (np.empty((8, 3), dtype), np.empty((8, 3), dtype, order="F"), padded[::2, :3]):
            assert getattr(body, method)(out) is out
            assert np.allclose(out, expected, rtol=0, atol=tolerance)
    read_only = np.zeros((8, 3))
    read_only.flags.writeable = False
    for out, error, message in [
        (np.zeros((7, 3)), ValueError, r"out has the shape \(7, 3\); it must be \(8, 3\)"),
        (np.zeros((8, 3), int), TypeError, "out has dtype int64"),
        (read_only, ValueError, "out is read-only"),
        ([[0, 0, 0]] * 8, TypeError, "out must be a numpy array, not list"),
    ]:
        with pytest.raises(error, match=message):
            getattr(body, method)(out=out)


def test_out_allocates_nothing(bust):
    body = supple.Body(bust, lattice_vertices=500)
    out = body.surface().astype(np.float32)
    body.surface(out)
    tracemalloc.start()
    for _ in range(10):
        body.surface(out)
        body.surface_normals(out)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 10_000 < out.nbytes
