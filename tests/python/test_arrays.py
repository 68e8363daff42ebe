"""Arrays: accepted forms, returned types, errors, and `out` arguments."""

import contextlib
import threading
import time
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


def test_state_arrays_are_new_read_only_float64_copies(body):
    for name, shape in [("positions", (3,)), ("velocities", (3,)), ("rotations", (3, 3)), ("masses", ())]:
        array = getattr(body, name)
        assert array.shape == (len(body), *shape)
        assert array.dtype == np.float64
        assert array.flags.c_contiguous
        assert array is not getattr(body, name)
        with pytest.raises(ValueError, match="assignment destination is read-only"):
            array[0] = 7
        copy = array.copy()
        copy[0] = 7
        assert np.array_equal(getattr(body, name), array)
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


@pytest.mark.parametrize("method", ["surface", "surface_normals", "surface_velocities"])
def test_out_arguments_are_filled_and_returned(cube, method):
    body = supple.Body(cube, lattice_vertices=100, velocity=(1, 2, 3), spin=(0, 0, 4))
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


@pytest.mark.parametrize("name", ["positions", "velocities"])
def test_lattice_arrays_are_filled_and_returned(body, name):
    sim = supple.Simulation([body], dt=0.01)
    body.velocities = np.random.default_rng(5).normal(size=(len(body), 3))
    sim.step(3)
    function, expected = getattr(body, f"lattice_{name}"), getattr(body, name)
    assert function().tobytes() == expected.tobytes()
    out = np.empty((len(body), 3))
    assert function(out) is out
    assert out.tobytes() == expected.tobytes()
    out = np.empty((len(body), 3), np.float32)
    assert np.array_equal(function(out=out), expected.astype(np.float32))
    with pytest.raises(ValueError, match=rf"out has the shape \(7, 3\); it must be \({len(body)}, 3\)"):
        function(out=np.empty((7, 3)))


def test_out_allocates_nothing(bust):
    body = supple.Body(bust, lattice_vertices=500)
    out = body.surface().astype(np.float32)
    positions = np.empty((len(body), 3))
    body.surface(out)
    body.lattice_positions(positions)
    tracemalloc.start()
    for _ in range(10):
        body.surface(out)
        body.surface_normals(out)
        body.lattice_positions(positions)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 10_000 < out.nbytes


def test_an_edit_writes_the_arrays_that_changed(body):
    sim = supple.Simulation([body], gravity=(0, 0, 0))
    body.velocities = np.random.default_rng(2).normal(size=(len(body), 3))
    sim.step(3)
    positions, velocities = body.positions, body.velocities
    with body.edit() as state:
        assert np.array_equal(state.positions, positions)
        state.positions[3] += [0.1, 0, 0]
    assert np.allclose(body.positions[3], positions[3] + [0.1, 0, 0], atol=1e-6)
    assert np.allclose(np.delete(body.positions, 3, axis=0), np.delete(positions, 3, axis=0), atol=1e-6)
    assert body.velocities.tobytes() == velocities.tobytes()
    with body.edit() as state:
        state.velocities[:, 1] = 2
        state.positions = 1.5 * state.positions
    assert np.allclose(body.velocities[:, 1], 2, atol=1e-6)
    assert np.allclose(body.positions[3], 1.5 * (positions[3] + [0.1, 0, 0]), atol=1e-5)


def test_an_edit_that_fails_changes_no_bit(body):
    body.velocities = np.random.default_rng(2).normal(size=(len(body), 3))
    positions, velocities = body.positions.tobytes(), body.velocities.tobytes()

    def change(value):
        with body.edit() as state:
            state.positions[0] = 7
            state.velocities[5] = value

    for value, message in [
        ("fast", "could not convert string to float"),
        (np.nan, r"velocities\[5, 0\] = NaN is not finite"),
        (1e30, r"velocities\[5\] = .* is too large"),
    ]:
        with pytest.raises(ValueError, match=message):
            change(value)
    assert (body.positions.tobytes(), body.velocities.tobytes()) == (positions, velocities)


@pytest.mark.parametrize("method", ["surface", "surface_normals", "surface_velocities"])
def test_unaligned_arrays_are_read_and_filled(cube, method):
    body = supple.Body(cube, lattice_vertices=100)
    expected = getattr(body, method)()
    out = np.frombuffer(bytearray(1 + expected.nbytes), np.float64, offset=1).reshape(-1, 3)
    assert not out.flags.aligned
    assert np.array_equal(getattr(body, method)(out), expected)
    positions = np.frombuffer(bytearray(1 + body.positions.nbytes), np.float64, offset=1).reshape(-1, 3)
    np.copyto(positions, body.positions)
    body.positions = positions + [1, 0, 0]
    body.positions = positions
    assert np.array_equal(body.positions, positions)


def test_an_array_that_another_thread_fills_is_an_error_with_its_name(bust):
    bodies = [supple.Body(bust, lattice_vertices=4000) for _ in range(2)]
    out = np.empty_like(bodies[0].surface())
    stop = threading.Event()
    found = set()

    def fill():
        while not stop.is_set():
            with contextlib.suppress(ValueError):
                bodies[0].surface(out)

    thread = threading.Thread(target=fill)
    thread.start()
    try:
        end = time.monotonic() + 60
        while len(found) < 2 and time.monotonic() < end:
            for call in (lambda: bodies[1].surface(out), lambda: supple.Mesh(out, [[0, 1, 2]])):
                try:
                    call()
                except ValueError as error:
                    found.add(str(error))
    finally:
        stop.set()
        thread.join()
    message = "{} is in use by another call, in another thread; pass another array"
    assert found == {message.format(name) for name in ("out", "vertices")}
