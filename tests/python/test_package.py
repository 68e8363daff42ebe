"""Public names, exceptions, docstrings, SIMD level."""

import inspect
import os
import subprocess
import sys

import pytest

import supple


def test_all_names_exist_and_are_documented():
    for name in supple.__all__:
        assert hasattr(supple, name)
        if not name.startswith("__"):
            assert inspect.getdoc(getattr(supple, name)), name
    assert supple.__doc__.startswith("Soft bodies")


@pytest.mark.parametrize("name", ["Mesh", "Lattice", "Body", "Simulation", "Hold"])
def test_all_members_are_documented(name):
    for member, value in vars(getattr(supple, name)).items():
        if not member.startswith("_"):
            assert inspect.getdoc(value), f"{name}.{member}"


def test_exceptions():
    for error in (supple.MeshError, supple.LatticeError, supple.SceneError):
        assert issubclass(error, supple.SuppleError)
        assert issubclass(error, ValueError)
    assert issubclass(supple.OutputError, supple.SuppleError)
    assert issubclass(supple.OutputError, OSError)


def test_the_example_of_the_module_runs(bust, monkeypatch):
    monkeypatch.chdir(bust.parent)
    example = supple.__doc__.split("\n\n")[1:3]
    code = inspect.cleandoc("\n".join(example)).replace("range(120)", "range(3)")
    names = {}
    exec("import supple\n" + code, names)
    assert names["points"].shape == supple.read_obj("bust.obj").vertices.shape


@pytest.mark.parametrize(("level", "refused"), [("avx9", True), ("", False), (supple.simd_level(), False)])
def test_an_unknown_simd_level_is_an_import_error(level, refused):
    environment = os.environ | {"SUPPLE_SIMD": level}
    command = [sys.executable, "-c", "import supple; print(supple.simd_level())"]
    ended = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert (ended.returncode != 0) == refused, ended.stderr
    assert ('ImportError: SUPPLE_SIMD is "avx9"' in ended.stderr) == refused
    # The empty string is the default: the best level of the machine, which `SUPPLE_SIMD` may lower in this process.
    assert refused or ended.stdout.strip() == level or not level
