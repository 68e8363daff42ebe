"""Errors of arguments: the name, the value or type, and the expected range or type."""

import inspect

import numpy as np
import pytest

import supple
from supple import _core

ONES = np.ones((2, 2, 2), bool)


def _simulation(**settings):
    return supple.Simulation([supple.Body(supple.Lattice.from_cells(ONES))], **settings)


@pytest.mark.parametrize(
    ("settings", "error", "message"),
    [
        ({"dt": "x"}, TypeError, "dt must be a number, not str"),
        ({"dt": 1j}, TypeError, "dt must be a number, not complex"),
        ({"dt": np.array([0.1])}, TypeError, "dt must be a number, not ndarray"),
        ({"dt": 10**400}, ValueError, "dt is too large"),
        ({"dt": np.nan}, ValueError, "dt = NaN is out of range"),
        ({"dt": 0}, ValueError, "dt = 0 is out of range: it must be a time in seconds, from 1e-12 to 1e6"),
        ({"gravity": None}, TypeError, r"gravity must be numbers of shape \(3,\), not NoneType"),
        ({"gravity": (0, np.inf, 0)}, ValueError, r"gravity\[1\] = inf is not finite"),
        (
            {"colliders": None},
            TypeError,
            "colliders must be a list of Plane, Sphere, Box, Capsule or MeshCollider, or one of them, not None",
        ),
        (
            {"colliders": [supple.Collider()]},
            TypeError,
            r"colliders\[0\] must be a Plane, Sphere, Box, Capsule or MeshCollider, not Collider",
        ),
        ({"threads": np.array([1])}, TypeError, "threads must be a number, not ndarray"),
        ({"threads": 1.5}, TypeError, "threads must be a whole number, not float"),
        ({"threads": -1}, ValueError, "threads = -1 is out of range"),
        ({"substeps": 0}, ValueError, "substeps = 0 is out of range: it must be a whole number, at least 1"),
        ({"substeps": 2.0}, TypeError, "substeps must be a whole number, not float"),
        ({"substeps": "all"}, ValueError, 'substeps is "all"; it must be "auto" or a whole number, at least 1'),
        ({"substeps": "auto"}, ValueError, 'substeps = "auto" needs fps'),
        ({"dt": 0.1, "fps": 30}, ValueError, "dt and fps are mutually exclusive; pass only one of them"),
        ({"fps": 0}, ValueError, "fps = 0 is out of range: it must be frames per second, > 0"),
        ({"fps": "30"}, TypeError, "fps must be a number, not str"),
        ({"sleep": None}, TypeError, "sleep must be True or False, not None"),
        ({"gravty": (0, 0, 0)}, TypeError, '"gravty"; the nearest one is "gravity"'),
    ],
)
def test_invalid_arguments_of_simulation(settings, error, message):
    with pytest.raises(error, match=message):
        _simulation(**settings)


@pytest.mark.parametrize(("name", "value"), [("dt", "x"), ("dt", None), ("time", "x"), ("time", None)])
def test_settable_numbers_refuse_other_types(name, value):
    sim = _simulation()
    with pytest.raises(TypeError, match=f"{name} must be a number, not"):
        setattr(sim, name, value)


@pytest.mark.parametrize(
    ("make", "error", "message"),
    [
        (lambda cube: supple.Lattice.from_mesh(cube, cell_size="x"), TypeError, "cell_size must be a number, not str"),
        (lambda cube: supple.Lattice.from_mesh(cube, join="x"), TypeError, "join must be True or False, not str"),
        (lambda cube: supple.Lattice.from_mesh(cube, vertices=9.5), TypeError, "vertices must be a whole number"),
        (lambda cube: supple.Lattice.from_mesh(cube, vertexes=9), TypeError, 'the nearest one is "vertices"'),
        (lambda cube: supple.Lattice.from_mesh(3), TypeError, r"mesh must be a supple\.Mesh, a path, an .* not int"),
        (lambda cube: supple.Lattice.from_cells(ONES, "x"), TypeError, "cell_size must be a number, not str"),
        (lambda cube: supple.Lattice.from_cells(ONES, join="x"), TypeError, "join must be True or False, not str"),
        (lambda cube: supple.read_obj(3), TypeError, "path must be a path .*, not int"),
        (lambda cube: supple.read_obj("a.obj", object=3), TypeError, "object must be a string, not int"),
        (lambda cube: supple.load_scene(None), TypeError, "path must be a path .*, not None"),
        (lambda cube: supple.run(None), TypeError, "path must be a path .*, not None"),
        (
            lambda cube: supple.run("a.toml", overrides={"a": object()}),
            TypeError,
            "overrides: a scene cannot have a value of type object",
        ),
    ],
)
def test_invalid_arguments_of_functions(cube, make, error, message):
    with pytest.raises(error, match=message):
        make(cube)


class UnknownError(Exception):
    """An exception that supple does not know."""


class Failing:
    """Raises an exception in every conversion."""

    def __init__(self, error):
        self._error = error

    def _raise(self, *_arguments, **_settings):
        raise self._error

    __array__ = __index__ = __float__ = __iter__ = __fspath__ = __len__ = __getitem__ = _raise


@pytest.mark.parametrize("error", [UnknownError("mine"), TypeError("mine"), ValueError("mine"), OverflowError("mine")])
def test_exceptions_of_an_argument_are_raised_unchanged(cube, error):
    lattice = supple.Lattice.from_cells(ONES)
    body = supple.Body(lattice)
    sim = supple.Simulation([body])
    failing = Failing(error)
    for call in [
        lambda: setattr(body, "positions", failing),
        lambda: setattr(body, "half_width", failing),
        lambda: setattr(sim, "dt", failing),
        lambda: setattr(sim, "colliders", failing),
        lambda: sim.step(failing),
        lambda: body.pin(vertices=failing),
        lambda: body.pin(box=failing),
        lambda: body.handle(vertices=[0], keys=failing),
        lambda: body.handle(vertices=[0], keys=[failing]),
        lambda: supple.Mesh(failing, [[0, 1, 2]]),
        lambda: supple.Mesh(cube.vertices, [[0, 1, failing]]),
        lambda: supple.Lattice.from_cells(failing),
        lambda: supple.Simulation(failing),
        lambda: supple.read_obj(failing),
        lambda: supple.rotations(failing),
    ]:
        with pytest.raises(type(error), match=r"^mine$") as caught:
            call()
        assert caught.value is error


@pytest.mark.parametrize("name", ["cell_size", "origin", "join"])
def test_none_is_not_a_missing_argument(name):
    with pytest.raises(TypeError, match=f"^{name} must be .*, not None"):
        supple.Lattice.from_cells(ONES, **{name: None})


def test_fracture_and_plastic_have_the_keys_of_a_scene():
    fracture, plastic = set(_core.body_keys("fracture")), set(_core.body_keys("plastic"))
    assert supple.types.FractureOptions.__annotations__.keys() == fracture
    assert supple.types.PlasticOptions.__annotations__.keys() == plastic
    lattice = supple.Lattice.from_cells(ONES)
    by_strain = supple.Body(lattice, fracture={"strain": 1}, plastic=True)
    by_strength = supple.Body(lattice, fracture={"strength": 1})
    assert by_strain.fracture.keys() | by_strength.fracture.keys() == fracture
    assert by_strain.plastic.keys() == plastic
    # The dicts are valid arguments with all of their keys.
    twin = supple.Body(lattice, fracture=by_strain.fracture, plastic=by_strain.plastic)
    assert (twin.fracture, twin.plastic) == (by_strain.fracture, by_strain.plastic)


def test_body_accepts_the_keys_of_a_scene():
    shape, *arguments = inspect.signature(supple.Body).parameters
    assert shape == "shape"
    assert sorted(arguments) == sorted(_core.body_keys())


@pytest.mark.parametrize(
    ("word", "way_out"),
    [
        ("E", 'write "youngs_modulus"'),
        ("mass", 'write "density", the mass per volume'),
        ("position", 'write "translate"'),
        ("rotation", 'write "rotate"'),
        ("half_widht", 'the nearest one is "half_width"'),
        ("color", 'give one of "name", '),
    ],
)
def test_words_of_other_programs_are_answered_with_ours(block, word, way_out):
    with pytest.raises(TypeError, match=rf'^Body\(\) has no argument "{word}"; {way_out}'):
        supple.Body(block, **{word: 1})


def test_a_time_step_is_answered_with_dt(block):
    for word in ("timestep", "time_step", "h"):
        with pytest.raises(TypeError, match=f'"{word}"; write "dt"'):
            supple.Simulation(supple.Body(block), **{word: 0.01})


def test_values_that_a_scene_has_are_taken_from_numpy(cube):
    body = supple.Body(
        cube,
        lattice_vertices=np.float64(64),
        join=np.bool_(True),
        scale=np.array([1, 2, -1]),
        ignore=np.array(["a", "b"]),
        volume={"measure": "cells", "max_correction": np.array(0.5)},
        fracture={"strain": np.float32(0.5), "cracks": np.int8(2), "rotation": None},
        inflate=np.array([(0, 1), (1, 1.5)]),
    )
    assert body.volume_options == {"measure": "cells", "scope": "global", "field": "auto", "max_correction": 0.5}
    assert list(body.fracture.items())[:3] == [("strain", 0.5), ("rotation", None), ("cracks", 2)]
    assert (list(body.ignore), body.inflate) == (["a", "b"], [(0, 1), (1, 1.5)])
    assert np.ptp(body.mesh.vertices, axis=0) == pytest.approx(np.ptp(cube.vertices, axis=0) * [1, 2, 1])


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("density", 0),
        ("youngs_modulus", -1.5),
        ("half_width", 1.5),
        ("stiffness_radius", 0),
        ("frequency", 0),
        ("damping_rate", -1),
        ("poisson_ratio", 0.5),
        ("lattice_vertices", 7),
        ("cell_size", 0),
        ("scale", 0),
        ("inflate", 11),
        ("accuracy", "best"),
        ("volume", {"max_correction": -1}),
        ("plastic", {"creep": 0}),
        ("fracture", {"strain": 1, "noise": 0.6}),
    ],
)
def test_python_and_scenes_have_the_same_ranges(cube, bust, tmp_path, key, value):
    path = tmp_path / "scene.toml"
    path.write_text(f"[[body]]\nmesh = '{bust}'\n", encoding="utf-8")
    with pytest.raises(ValueError, match=key) as in_python:
        supple.Body(cube, **{key: value})
    with pytest.raises(supple.SceneError, match=key) as in_scene:
        supple.load_scene(path, overrides={f"body.bust.{key}": value})
    ranges = [str(error.value).split("it must be ")[1] for error in (in_python, in_scene)]
    assert ranges[0] == ranges[1]


def test_a_list_that_contains_itself_is_an_error(block):
    loop = [1.0]
    loop.append(loop)
    for key in ("scale", "volume", "ignore", "inflate", "density"):
        with pytest.raises((TypeError, ValueError), match=key):
            supple.Body(block, **{key: loop})
    with pytest.raises(ValueError, match="max_correction"):
        supple.Body(block, volume={"max_correction": 10**400})
