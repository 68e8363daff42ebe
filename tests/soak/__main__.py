"""Runs the checks and prints a table of them. Exit code 1 if there is a fault."""

from __future__ import annotations

import argparse
import shutil
import sys
import time
from pathlib import Path

from . import bounds, calls, damage, geometry, kills, mutants
from .context import Check, Settings

CHECKS = {
    "kills": kills.check,
    "bytes": mutants.check,
    "geometry": geometry.check,
    "calls": calls.check,
    "damage": damage.check,
    "bounds": bounds.check,
}


def main() -> int:
    """Run the checks."""
    parser = argparse.ArgumentParser(prog="scripts/soak", description="Runs long robustness checks.")
    parser.add_argument("--program", type=Path, required=True, help="the program `supple`")
    parser.add_argument("--output", type=Path, required=True, help="folder for all files")
    parser.add_argument("--seed", type=int, default=1, help="seed of all random numbers, at least 0 (default 1)")
    parser.add_argument("--quick", action="store_true", help="few cases of each check")
    parser.add_argument("--only", default=",".join(CHECKS), help=f"checks, of {','.join(CHECKS)} (default all)")
    arguments = parser.parse_args()
    unknown = set(arguments.only.split(",")) - CHECKS.keys()
    if unknown or arguments.seed < 0:
        parser.error(f"--only is {arguments.only}, --seed is {arguments.seed}")

    output = arguments.output.resolve()
    shutil.rmtree(output / "faults", ignore_errors=True)
    settings = Settings(arguments.program.resolve(), output, arguments.seed, arguments.quick)
    print(f"seed {settings.seed}", flush=True)
    table = []
    for name in CHECKS:
        if name in arguments.only.split(","):
            start = time.monotonic()
            table.append(CHECKS[name](settings))
            print(f"{name}: {time.monotonic() - start:.0f} s, {len(table[-1].faults)} faults", flush=True)
    shutil.rmtree(output / "work", ignore_errors=True)
    print_table(table)
    return 1 if any(check.faults for check in table) else 0


def print_table(table: list[Check]) -> None:
    """Print the faults and the figures of the checks."""
    for fault in (fault for check in table for fault in check.faults):
        print(fault)
    print()
    print("check         runs  faults  worst wall time  worst processor time  worst memory")
    for check in table:
        print(
            f"{check.name:<10} {check.runs:>7} {len(check.faults):>7} {check.wall:>14.2f} s"
            f" {check.processor:>19.2f} s {check.memory / 1e6:>10.0f} MB"
        )


if __name__ == "__main__":
    sys.exit(main())
