"""Installs the extension into Blender and checks it there.

    python extension.py ZIP [CHECK ...]     ZIP of scripts/blender-extension; names of checks, by default all

Needs the package bpy. Exits with an error at the first difference.
"""

from __future__ import annotations

import shutil
import sys

# Before bpy, because it gives Blender a temporary directory for settings and extensions.
from scenes import SCRATCH, install  # isort: skip

import bakes
import bpy
import interface
import movers

if __name__ == "__main__":
    try:
        install(sys.argv[1])
        chosen = sys.argv[2:]
        for check in (*bakes.CHECKS, *movers.CHECKS, *interface.CHECKS):
            name = check.__name__.removeprefix("check_")
            if not chosen or name in chosen:
                check()
                print(f"{name}: {check.__doc__.splitlines()[0]}", flush=True)
        print(f"Blender {bpy.app.version_string}: all checks of the extension passed")
    finally:
        shutil.rmtree(SCRATCH, ignore_errors=True)
