"""Runs that are killed at random times and resumed: the frames and statistics are those of an uninterrupted run."""

from __future__ import annotations

import os

from . import scenes
from .context import Case, Check, FaultError, Settings, check_limits
from .frames import CHECKPOINT, check_finite, compare, contents, rows, same_rows, whole_rows
from .process import Ended

#: Largest number of times that a run is killed.
KILLS = 4


def check(settings: Settings) -> Check:
    """Kill runs."""
    result = Check("kills", settings)
    result.cases(settings.count(200, 4), _case)
    return result


def _case(case: Case) -> None:
    random = case.random
    shipped = scenes.link_shipped(case.folder)
    if random.random() < 0.5:
        scene = str(random.choice([*shipped, "bust.obj"]))
        # Enough steps that a kill hits them, and few enough for hundreds of runs: fewer frames of several bodies.
        bodies = (case.folder / scene).read_text(errors="replace").count("[[body]]") if scene.endswith(".toml") else 1
        frames = max(10, int(random.integers(30, 240)) // max(bodies, 1))
        options = ["--set", "body.0.lattice_vertices=400", "--frames", str(frames)]
    else:
        scene = scenes.write_generated(case.folder, random)
        options = ["--frames", str(random.integers(50, 400))]
    kinds = ["obj", "ply", "usd", "html", "obj,usd,html", "vtu,lattice"]
    if "fracture" not in (case.folder / scene).read_text(errors="replace"):
        kinds += ["pc2", "glb", "vat", "obj,glb,vat"]
    kind = str(random.choice(kinds))
    stats = str(random.choice(["stats.csv", "stats.json"]))
    options += ["--format", kind, "--threads", "1", "-q"]
    options += ["--every", str(random.integers(1, 4)), "--start-frame", str(random.choice([0, 1, 9990]))]
    options += ["--checkpoint", str(random.choice(["0", "0.02", "0.1", "10"]))]
    case.label = f"{case.index} ({scene}, {kind}, {stats})"

    def once(name: str, *more: str, kill_after: float | None = None) -> Ended:
        out = case.folder / name
        out.mkdir(exist_ok=True)
        arguments = [*options, "-o", name, "--stats", os.path.join(name, stats), *more]
        ended = case.supple("run", scene, *arguments, kill_after=kill_after)
        if ended.code != 0 and not ended.killed:
            raise FaultError(f"exit code {ended.code}: {ended.last_line}")
        check_limits(ended)
        return ended

    whole = once("whole")
    expected = contents(case.folder / "whole")
    check_finite(expected)
    expected_rows = rows(stats, expected.pop(stats))
    # Times at which a run is killed are spread over its phases: the start is as likely as the rest.
    for attempt in range(random.integers(1, KILLS + 1)):
        after = whole.wall * float(random.uniform(0, 1.1)) ** random.choice([1, 2])
        ended = once("killed", *(["--resume"] if attempt else []), kill_after=after)
        _check_killed(contents(case.folder / "killed"), expected, stats, expected_rows)
        if not ended.killed:
            break
    once("killed", "--resume")
    found = contents(case.folder / "killed")
    if stats not in found:
        raise FaultError("no statistics after the run was resumed")
    found_rows = rows(stats, found.pop(stats))
    compare(found, expected)
    if not same_rows(found_rows, expected_rows):
        raise FaultError("the statistics differ from those of an uninterrupted run")
    left = [path.name for path in (case.folder / "killed").iterdir() if path.name.endswith((".part", ".data"))]
    if left or not (case.folder / "killed" / CHECKPOINT).exists():
        raise FaultError(f"temporary files {left}, or no checkpoint, after the end of the run")


def _check_killed(
    found: dict[str, bytes], expected: dict[str, bytes], stats: str, expected_rows: list[dict[str, object]]
) -> None:
    """Raise a fault unless all files under final names are whole, and the rows of the statistics are right."""
    for name, data in found.items():
        if name == stats:
            kept = list(whole_rows(name, data))
            if not same_rows(kept, expected_rows[: len(kept)]):
                raise FaultError("rows of the statistics are wrong after the run was killed")
        elif not name.endswith((".part", ".data")) and data != expected.get(name):
            raise FaultError(f"{name} is not a whole frame after the run was killed")
