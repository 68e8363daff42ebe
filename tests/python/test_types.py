"""The type stubs agree with the compiled module, and have its docstrings."""

import subprocess
import sys
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

import supple

SCRIPT = Path(__file__).parents[2] / "scripts" / "stub_docstrings"


def test_stubtest_finds_no_difference(tmp_path):
    pytest.importorskip("mypy")
    # stubtest takes an alias of a Literal for a function.
    literals = tmp_path / "literals"
    literals.write_text(r"supple\.types\.(Accuracy|Interpolation|Material|Skin|VolumeMeasure)")
    command = [sys.executable, "-m", "mypy.stubtest", "supple", "--allowlist", str(literals)]
    checked = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert checked.returncode == 0, checked.stdout


@pytest.mark.parametrize(
    ("name", "argument"),
    [("Accuracy", "accuracy"), ("Material", "material"), ("Skin", "skin"), ("VolumeMeasure", "volume")],
)
def test_types_of_arguments_have_the_values_that_a_body_takes(name, argument):
    lattice = supple.Lattice.from_cells(np.ones((2, 2, 2)))
    values = get_args(getattr(supple.types, name))
    for value in values:
        supple.Body(lattice, **{argument: value} if value != "mesh" else {})
    with pytest.raises(ValueError, match=values[0]):
        supple.Body(lattice, **{argument: "none of these"})


def test_the_type_of_volume_options_has_the_keys_that_a_body_has():
    lattice = supple.Lattice.from_cells(np.ones((2, 2, 2)))
    assert supple.types.VolumeOptions.__annotations__.keys() == supple.Body(lattice).volume_options.keys()


def test_the_stubs_have_the_docstrings_of_the_module(tmp_path):
    command = [sys.executable, str(SCRIPT), "--check"]
    checked = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert checked.returncode == 0, checked.stderr
