"""Runs a file that may be invalid: it is refused with a message, or its frames are finite."""

from __future__ import annotations

from .context import Case, FaultError, check_limits
from .frames import check_finite, contents

#: Numbers of lattice vertices of the first body of a file, without and with `--quick`.
LATTICE_VERTICES, QUICK_LATTICE_VERTICES = 20_000, 2000


def run_or_refuse(case: Case, name: str, *options: str, input_bytes: int = 0, resolve: bool = True) -> None:
    """Run a scene or a model for two frames. A result that is neither a refusal nor right is a fault.

    `input_bytes`: size of the input. `resolve`: whether to set the number of lattice vertices.
    """
    if resolve:
        count = case.check.settings.count(LATTICE_VERTICES, QUICK_LATTICE_VERTICES)
        options = ("--set", f"body.0.lattice_vertices={count}", *options)
    stats = ("--stats", "out/stats.csv") if case.index % 4 == 0 else ()
    kind = ("obj", "ply", "pc2")[case.index % 3]
    (case.folder / "out").mkdir()
    # The frames and the steps are bounded, because a file may ask for any number of them.
    limits = ("--frames", "2", "--set", "simulation.substeps=2", "--threads", "1")
    ended = case.supple("run", name, "-q", "-o", "out", "--format", kind, *limits, *stats, *options)
    check_limits(ended, input_bytes)
    if ended.code == 2:
        if "error" not in ended.output or len(ended.output) > 4000:
            raise FaultError(f"refused without a message, or with a long one: {ended.last_line}")
        left = contents(case.folder / "out")
        if left:
            raise FaultError(f"refused, and has written {sorted(left)[:5]}")
        return
    if ended.code != 0:
        raise FaultError(f"exit code {ended.code}: {ended.last_line}")
    found = contents(case.folder / "out")
    if not any(file.endswith(kind) for file in found):
        raise FaultError("exit code 0 and no frames")
    check_finite(found)
