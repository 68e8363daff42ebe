"""The type stubs agree with the compiled module."""

import subprocess
import sys

import pytest


def test_stubtest_finds_no_difference(tmp_path):
    pytest.importorskip("mypy")
    command = [sys.executable, "-m", "mypy.stubtest", "supple"]
    checked = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert checked.returncode == 0, checked.stdout
