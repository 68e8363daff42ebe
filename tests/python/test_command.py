"""The program `supple` that the wheel installs."""

import os
import re
import signal
import subprocess
import sys
import sysconfig
import time
from pathlib import Path

import pytest

import supple

PROGRAM = Path(sysconfig.get_path("scripts"), "supple")


def _run(*arguments, **options):
    return subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, check=False, **options)


def test_version_and_help():
    version = _run("--version")
    assert (version.returncode, version.stdout) == (0, f"supple {supple.__version__}\n")
    assert "Usage: supple" in _run("--help").stdout


@pytest.mark.parametrize("arguments", [["fly"], ["run"], ["run", "missing.toml"], ["inspect", "missing.obj"]])
def test_invalid_arguments_and_inputs_exit_with_2(arguments, tmp_path):
    ended = _run(*arguments, cwd=tmp_path)
    assert (ended.returncode, ended.stdout) == (2, "")
    assert ended.stderr.startswith("error: ")


@pytest.mark.skipif(os.name == "nt", reason="sends signals")
@pytest.mark.parametrize(("sent", "code"), [("SIGINT", 130), ("SIGTERM", 143)])
def test_signals_stop_a_run_which_can_be_resumed(sent, code, bust, tmp_path):
    command = ["run", bust, "-o", "frames", "--frames", "2000", "--quiet"]
    with subprocess.Popen([PROGRAM, *command], cwd=tmp_path, stdout=subprocess.PIPE, text=True) as process:
        deadline = time.monotonic() + 60
        while not list(tmp_path.glob("frames/*.obj")):
            assert time.monotonic() < deadline
            time.sleep(0.05)
        process.send_signal(getattr(signal, sent))
        output = process.communicate(timeout=60)[0]
    assert process.returncode == code
    resume = re.search(r"^resume with: (.*)$", output, re.MULTILINE)
    assert resume is not None, output
    assert resume[1].split()[0].endswith("supple")
    assert resume[1].endswith("--frames 2000 --quiet --resume")


def test_the_module_is_the_program():
    ended = subprocess.run([sys.executable, "-m", "supple", "--version"], capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stdout) == (0, f"supple {supple.__version__}\n")
    ended = subprocess.run([sys.executable, "-m", "supple", "fly"], capture_output=True, text=True, check=False)
    assert ended.returncode == 2
