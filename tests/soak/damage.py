"""Runs that are resumed from damaged files: the run is refused, or the frames in the end are right."""

from __future__ import annotations

import shutil

import numpy as np

from . import scenes
from .context import Case, Check, FaultError, Settings, check_limits
from .frames import CHECKPOINT, LOCK, MANIFEST, contents, describe_difference, rows, same_rows

#: Frames before and after the run is resumed.
BEFORE, AFTER = "6", "12"

FORMATS = ("obj", "ply", "pc2", "usd", "html")


def check(settings: Settings) -> Check:
    """Damage files."""
    result = Check("damage", settings)
    source = result.folder("source")
    random = result.random()
    # Two bodies, so that the checkpoint has several lists of frames.
    while len(list(source.glob("*.obj"))) != 2:
        scene = scenes.write_generated(source, random)
    for kind in FORMATS:
        runs = Case(result, 1_000_000 + FORMATS.index(kind))
        try:
            for name, frames in ((f"{kind}_before", BEFORE), (f"{kind}_after", AFTER)):
                ended = runs.supple("run", source / scene, *_options(kind, name, frames))
                if ended.code != 0:
                    raise FaultError(f"exit code {ended.code}: {ended.last_line}")
                (runs.folder / name).rename(source / name)
        except FaultError as fault:
            runs.keep(str(fault))
            return result
    result.cases(settings.count(350, 9), lambda case: _case(case, scene))
    return result


def _options(kind: str, name: str, frames: str) -> list[str]:
    return ["--format", kind, "-o", name, "--stats", f"{name}/stats.csv", "--frames", frames, "--threads", "1", "-q"]


def _case(case: Case, scene: str) -> None:
    random = case.random
    source = case.folder.parent / "source"
    kind = FORMATS[case.index % len(FORMATS)]
    out = case.folder / "out"
    shutil.copytree(source / f"{kind}_before", out)
    names = sorted(path.name for path in out.iterdir() if path.name not in (LOCK, MANIFEST))
    target = CHECKPOINT if random.random() < 0.5 else str(random.choice(names))
    original = (out / target).read_bytes()
    damaged, how = _damage(original, random)
    (out / target).write_bytes(damaged)
    verify = bool(random.random() < 0.5)
    case.label = f"{case.index} ({kind}, {target}: {how}{', --verify' if verify else ''})"
    before = {**contents(out), CHECKPOINT: (out / CHECKPOINT).read_bytes()}
    options = [*_options(kind, "out", AFTER), "--resume", *(["--verify"] if verify else [])]
    ended = case.supple("run", source / scene, *options)
    check_limits(ended)
    found = contents(out)
    if ended.code in (1, 2):
        if {**found, CHECKPOINT: (out / CHECKPOINT).read_bytes()} != before:
            raise FaultError("the run is refused and has changed files")
        if target not in (CHECKPOINT, "stats.csv"):
            raise FaultError(f"a damaged frame is replaced, not refused: {ended.last_line}")
        return
    if ended.code != 0:
        raise FaultError(f"exit code {ended.code}: {ended.last_line}")
    expected = contents(source / f"{kind}_after")
    if target == CHECKPOINT and damaged != original:
        raise FaultError("a damaged checkpoint is accepted")
    # Without --verify, only the sizes of the frames are compared: a damaged byte stays.
    if not verify and len(damaged) == len(original) and target not in (CHECKPOINT, "stats.csv"):
        _restore(found, expected, target, damaged, original)
    if not same_rows(rows("stats.csv", found.pop("stats.csv")), rows("stats.csv", expected.pop("stats.csv"))):
        raise FaultError("the statistics are wrong")
    if found.keys() != expected.keys():
        raise FaultError(f"the files are {sorted(found)}")
    for name in sorted(found):
        if found[name] != expected[name]:
            raise FaultError(f"{name} is wrong: {describe_difference(found[name], expected[name])}")


def _restore(found: dict[str, bytes], expected: dict[str, bytes], target: str, damaged: bytes, original: bytes) -> None:
    """Replace the bytes of a frame that were damaged, and are not written again, by the right ones."""
    a, b = np.frombuffer(damaged, np.uint8), np.frombuffer(original, np.uint8)
    data, right = bytearray(found.get(target, b"")), expected[target]
    for at in np.flatnonzero(a != b).tolist():
        if at < len(data) and data[at] == damaged[at]:
            data[at] = right[at]
    found[target] = bytes(data)


def _damage(data: bytes, random: np.random.Generator) -> tuple[bytes, str]:
    """Return changed bytes, and how they were changed."""
    size = len(data)
    at = int(random.integers(size))
    changed = bytearray(data)
    match random.integers(6):
        case 0:
            bit = int(random.integers(8))
            changed[at] ^= 1 << bit
            return bytes(changed), f"bit {bit} of byte {at} of {size} flipped"
        case 1:
            return data[:at], f"truncated to {at} of {size} bytes"
        case 2:
            length = int(random.integers(1, 64))
            changed[at : at + length] = bytes(len(changed[at : at + length]))
            return bytes(changed), f"zeros at byte {at} of {size}"
        case 3:
            more = random.bytes(int(random.integers(1, 64)))
            return data + more, f"{len(more)} bytes appended"
        case 4:
            del changed[at : at + int(random.integers(1, 16))]
            return bytes(changed), f"bytes removed at {at} of {size}"
        case _:
            # Early bytes have the sizes, counts and settings.
            start = int(random.integers(min(size, 200)))
            changed[start] = int(random.integers(256))
            return bytes(changed), f"byte {start} of {size} set to {changed[start]}"
