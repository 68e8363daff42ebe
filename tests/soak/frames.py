"""Reads frames and statistics, and compares folders of them."""

from __future__ import annotations

import csv
import io
import json
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from .context import FaultError

#: Names of numpy types, by the names of PLY.
_PLY_TYPES = {"float": "f4", "double": "f8", "uchar": "u1", "int": "i4", "uint": "u4"}

#: A line of a position or a normal in an OBJ file with a number that is not finite.
_NOT_FINITE = re.compile(rb"^vn?\s[^#\n]*\b(nan|inf)", re.MULTILINE | re.IGNORECASE)

#: Files of the program that are no frames.
CHECKPOINT, LOCK, MANIFEST = "supple.checkpoint", "supple.lock", "manifest.json"


def contents(folder: Path) -> dict[str, bytes]:
    """Return the bytes of the files in a folder, by path, without the checkpoint, the lock and the manifest."""
    if not folder.is_dir():
        return {}
    others = (CHECKPOINT, LOCK, MANIFEST)
    files = [path for path in folder.rglob("*") if path.is_file() and path.name not in others]
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}


def check_finite(files: dict[str, bytes]) -> None:
    """Raise a fault if a frame or a row of the statistics has NaN or infinity."""
    for name, data in files.items():
        if not _is_finite(name, data):
            raise FaultError(f"{name} has numbers that are not finite")


def _is_finite(name: str, data: bytes) -> bool:
    if name.endswith(".obj"):
        return _NOT_FINITE.search(data) is None
    if name.endswith(".ply"):
        head, _, body = data.partition(b"end_header\n")
        lines = [line.split() for line in head.decode().splitlines()]
        count = next(int(line[2]) for line in lines if line[:2] == ["element", "vertex"])
        types = np.dtype([(line[2], f"<{_PLY_TYPES[line[1]]}") for line in lines if _is_scalar(line)])
        vertices = np.frombuffer(body, types, count)
        return all(np.isfinite(vertices[field]).all() for field in types.names)
    if name.endswith((".html", ".usd", ".glb", ".png", ".vtu", ".pvd", "-remap_info.json")):
        return True
    if name.endswith(".pc2"):
        return bool(np.isfinite(np.frombuffer(data, "<f4", offset=32)).all())
    return all(np.isfinite(float(value)) for row in rows(name, data) for value in row.values() if _is_number(value))


def _is_scalar(line: list[str]) -> bool:
    return line[:1] == ["property"] and line[1] != "list"


def _is_number(value: object) -> bool:
    try:
        float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return False
    return True


def rows(name: str, data: bytes) -> list[dict[str, object]]:
    """Return the rows of statistics, without the columns of run times."""
    is_json = name.endswith(".json")
    table = json.loads(data) if is_json else csv.DictReader(io.StringIO(data.decode(), newline=""))
    return [{key: value for key, value in row.items() if not key.startswith("ms_")} for row in table]


def whole_rows(name: str, data: bytes) -> Iterator[dict[str, object]]:
    """Yield the rows of statistics that are complete; a run that was killed can leave a part of a row."""
    if name.endswith(".json"):
        for line in data.decode(errors="replace").splitlines():
            try:
                row = json.loads(line.rstrip(","))
            except json.JSONDecodeError:
                continue
            if isinstance(row, dict):
                yield {key: value for key, value in row.items() if not key.startswith("ms_")}
    else:
        yield from rows(name, data[: data.rfind(b"\n") + 1])


def compare(found: dict[str, bytes], expected: dict[str, bytes]) -> None:
    """Raise a fault unless two folders have the same files with the same bytes."""
    if found.keys() != expected.keys():
        missing, more = sorted(expected.keys() - found.keys()), sorted(found.keys() - expected.keys())
        raise FaultError(f"missing files {missing[:5]}, files too many {more[:5]}")
    for name in sorted(found):
        if found[name] != expected[name]:
            raise FaultError(f"{name} differs: {describe_difference(found[name], expected[name])}")


def describe_difference(found: bytes, expected: bytes) -> str:
    """Describe where two byte strings differ."""
    length = min(len(found), len(expected))
    a, b = (np.frombuffer(data, np.uint8, length) for data in (found, expected))
    differing = np.flatnonzero(a != b)
    first = int(differing[0]) if len(differing) else length
    return f"{len(found)} bytes, not {len(expected)}; {len(differing)} bytes differ, from byte {first}"


def same_rows(found: list[dict[str, object]], expected: list[dict[str, object]]) -> bool:
    """Return whether two lists of rows are equal. Compares the texts, because NaN is not equal to itself."""
    return repr(found) == repr(expected)
