"""Reads and writes OBJ files for `cut_mesh.py`: `Model`, `read`, `write`.

The text of every `v`, `vt` and `vn` statement is kept, so that an element that stays is written as it was read.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

Corner = tuple[int, int, int]
"""Indices from 0 of a vertex, a texture coordinate and a normal; -1 means absent."""

STATES = ("o", "g", "usemtl", "s")
"""Statements that apply to all faces after them."""


class ObjError(Exception):
    """A file that is no valid OBJ file."""


@dataclass(frozen=True)
class Face:
    """A polygon: its corners, and the text of the current statement of each of `STATES` ("" before the first)."""

    corners: tuple[Corner, ...]
    state: tuple[str, str, str, str]


@dataclass
class Model:
    """The contents of an OBJ file: comments at its start, `mtllib` statements, elements as text, and faces.

    `ignored` counts the statements of other kinds, such as lines, points and curves.
    """

    comments: list[str] = field(default_factory=list)
    libraries: list[str] = field(default_factory=list)
    vertices: list[str] = field(default_factory=list)
    textures: list[str] = field(default_factory=list)
    normals: list[str] = field(default_factory=list)
    faces: list[Face] = field(default_factory=list)
    ignored: Counter[str] = field(default_factory=Counter)

    def positions(self) -> np.ndarray:
        """Returns the positions of the vertices, (n, 3) f64."""
        return np.array([numbers(text)[:3] for text in self.vertices], dtype=float).reshape(-1, 3)


def numbers(text: str) -> list[float]:
    """Returns the numbers of the text of an element."""
    return [float(word) for word in text.split()]


def text(values: np.ndarray | list[float]) -> str:
    """Returns numbers as text: the shortest that reads back as the same f32."""
    return " ".join(np.format_float_positional(np.float32(value), trim="-") for value in values)


def statements(path: Path) -> Iterator[tuple[int, str]]:
    """Yields the line number and the text of each statement; a backslash at the end of a line continues it."""
    joined, first = "", 0
    for line, part in enumerate(path.read_text(encoding="latin-1").splitlines(), 1):
        first = first or line
        if part.endswith("\\"):
            joined += part[:-1] + " "
            continue
        yield first, (joined + part).strip()
        joined, first = "", 0
    if joined:
        yield first, joined.strip()


def read(path: Path) -> Model:
    """Reads an OBJ file.

    Raises `ObjError`, with the line, for a statement that cannot be read.
    """
    model = Model()
    state = dict.fromkeys(STATES, "")
    elements = {"v": model.vertices, "vt": model.textures, "vn": model.normals}
    for line, statement in statements(path):
        keyword, _, rest = statement.partition("#")[0].strip().partition(" ")
        rest = rest.strip()
        try:
            if not keyword:
                if statement and not (model.vertices or model.faces):
                    model.comments.append(statement)
            elif keyword in elements:
                if not np.isfinite(numbers(rest)).all() or len(numbers(rest)) < (1 if keyword == "vt" else 3):
                    raise ValueError(f"`{rest}` are not the numbers of `{keyword}`")
                elements[keyword].append(rest)
            elif keyword in state:
                state[keyword] = rest
            elif keyword == "mtllib":
                model.libraries.append(rest)
            elif keyword == "f":
                corners = tuple(corner(word, model) for word in rest.split())
                if len(corners) < 3:
                    raise ValueError(f"a face needs 3 corners, {len(corners)} found")
                model.faces.append(Face(corners, tuple(state[name] for name in STATES)))
            else:
                model.ignored[keyword] += 1
        except ValueError as error:
            raise ObjError(f"{path}:{line}: {error}") from error
    return model


def corner(word: str, model: Model) -> Corner:
    """Returns the indices of a corner `v`, `v/vt`, `v//vn` or `v/vt/vn`; negative numbers count from the end."""
    parts = [*word.split("/"), "", ""][:3]
    indices = []
    for part, elements in zip(parts, (model.vertices, model.textures, model.normals), strict=True):
        number = int(part) if part else 0
        index = number - 1 if number > 0 else len(elements) + number if number < 0 else -1
        if part and not 0 <= index < len(elements):
            raise ValueError(f"`{word}` refers to element {number} of {len(elements)}")
        indices.append(index)
    if indices[0] < 0:
        raise ValueError(f"`{word}` names no vertex")
    return indices[0], indices[1], indices[2]


def write(model: Model, path: Path) -> None:
    """Writes an OBJ file: comments, libraries, elements, then faces with the statements that apply to them."""
    lines = model.comments + [f"mtllib {library}" for library in model.libraries]
    for keyword, elements in (("v", model.vertices), ("vt", model.textures), ("vn", model.normals)):
        lines += [f"{keyword} {element}" for element in elements]
    current = ("",) * len(STATES)
    for face in model.faces:
        changes = zip(STATES, current, face.state, strict=True)
        lines += [f"{name} {value}".strip() for name, before, value in changes if value != before]
        current = face.state
        lines.append("f " + " ".join(map(corner_text, face.corners)))
    path.write_text("\n".join(lines) + "\n", encoding="latin-1")


def corner_text(indices: Corner) -> str:
    """Returns a corner as text."""
    vertex, texture, normal = (str(index + 1) if index >= 0 else "" for index in indices)
    return f"{vertex}/{texture}/{normal}".rstrip("/")
