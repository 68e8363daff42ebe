"""Large inputs: the time is O(N log N), and the memory is a multiple of the size of the input."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import chain, islice, repeat

import numpy as np

from . import meshes
from .context import Case, Check, Settings
from .outcome import run_or_refuse

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
BODY = '[[body]]\nname = "a"\nmesh = "triangle.obj"\n'

#: Lines written at once.
BLOCK = 10_000


@dataclass(frozen=True)
class Input:
    """A large input."""

    name: str
    suffix: str
    #: Returns the parts of the text for a number of elements.
    text: Callable[[int], Iterator[str]]
    #: Number of elements.
    count: int


def check(settings: Settings) -> Check:
    """Run the inputs; with `--quick`, a hundredth of their size."""
    result = Check("bounds", settings)

    def case(case: Case) -> None:
        large = INPUTS[case.index]
        case.label = f"{case.index} ({large.name})"
        path = case.folder / f"large{large.suffix}"
        (case.folder / "triangle.obj").write_text(TRIANGLE)
        with path.open("w") as stream:
            parts = large.text(settings.count(large.count, max(1, large.count // 100)))
            while block := "".join(islice(parts, BLOCK)):
                stream.write(block)
        run_or_refuse(case, path.name, input_bytes=path.stat().st_size, resolve=large.suffix == ".obj")

    result.cases(len(INPUTS), case)
    return result


def _each(text: str, *around: str) -> Callable[[int], Iterator[str]]:
    """Return a function that gives `text` with each number in place of `#`, between two texts."""
    before, after = around

    def parts(count: int) -> Iterator[str]:
        return chain([before], (text.replace("#", str(k)) for k in range(count)), [after])

    return parts


def _same(text: str, before: str, after: str) -> Callable[[int], Iterator[str]]:
    """Return a function that gives the same text many times, between two texts."""
    return lambda count: chain([before], repeat(text, count), [after])


def _tables(count: int) -> Iterator[str]:
    return chain([BODY], (f"[t{k}.a]\n" for k in range(count)), (f"[t{k}]\n" for k in range(count)))


def _beam(_count: int) -> Iterator[str]:
    vertices, faces = meshes.box([1000, 1, 1])
    return _obj(vertices, [np.array(faces)])


def _polygon(count: int) -> Iterator[str]:
    angles = np.linspace(0, 2 * np.pi, max(3, count), endpoint=False)
    circle = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=-1)
    return _obj(circle, [np.arange(len(angles))[None]])


def _overlapping(count: int) -> Iterator[str]:
    triangles = np.random.default_rng(1).normal(size=(count, 3, 3))
    return _obj(triangles.reshape(-1, 3), [np.arange(3 * count).reshape(-1, 3)])


def _parallel(count: int) -> Iterator[str]:
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]])[None].repeat(count, axis=0).astype(float)
    corners[:, :, 2] += np.linspace(0, 1, count)[:, None]
    return _obj(corners.reshape(-1, 3), [np.arange(3 * count).reshape(-1, 3)])


def _fine_sphere(count: int) -> Iterator[str]:
    rings = max(3, int(np.sqrt(count / 2)))
    vertices, faces = meshes.sphere(rings, 2 * rings)
    return chain(
        (f"v {x} {y} {z}\n" for x, y, z in vertices.tolist()),
        (f"f {' '.join(str(corner + 1) for corner in face)}\n" for face in faces),
    )


def _obj(vertices: np.ndarray, blocks: list[np.ndarray]) -> Iterator[str]:
    yield from (f"v {x} {y} {z}\n" for x, y, z in vertices)
    for faces in blocks:
        yield from (f"f {' '.join(map(str, face))}\n" for face in faces + 1)


INPUTS = [
    Input("a beam of 8 vertices, 1000 x 1 x 1", ".obj", _beam, 1),
    Input("coincident faces", ".obj", _same("f 1 2 3\n", TRIANGLE, ""), 100_000),
    Input("an n-gon", ".obj", _polygon, 100_000),
    Input("a continued line of 2 MB", ".obj", _same(" \\\n 1", TRIANGLE + "f 1 2 3", "\n"), 400_000),
    Input("a `g` line with a million names", ".obj", _each(" n#", "g", "\n" + TRIANGLE), 1_000_000),
    Input("a line of 200 MB of blanks in a model", ".obj", _same(" " * 1000, TRIANGLE, "\n"), 200_000),
    Input("overlapping large faces", ".obj", _overlapping, 100_000),
    Input("parallel large faces", ".obj", _parallel, 100_000),
    Input("a sphere of a million vertices", ".obj", _fine_sphere, 1_000_000),
    Input("vertices without faces", ".obj", _each("v # 0 0\n", TRIANGLE, ""), 1_000_000),
    Input("objects", ".obj", _each("o n#\nf 1 2 3\n", TRIANGLE, ""), 200_000),
    Input("materials", ".obj", _each("usemtl n#\nf 1 2 3\n", TRIANGLE, ""), 200_000),
    Input("texture coordinates", ".obj", _each("vt 0.# 0\n", TRIANGLE, ""), 1_000_000),
    Input("unknown keys", ".toml", _each("key# = 1\n", BODY, ""), 100_000),
    Input("a list of vertices of a pin", ".toml", _each("#, ", BODY + "[[body.pin]]\nvertices = [", "]\n"), 100_000),
    Input("a line of blanks in a scene", ".toml", _same(" " * 1000, BODY, "\n"), 30_000),
    Input("a line of 200 MB of blanks in a scene", ".toml", _same(" " * 1000, BODY, "\n"), 200_000),
    Input("tables below tables that follow", ".toml", _tables, 100_000),
    Input("tables below one table", ".toml", _each("[t.a#]\n", BODY, "[t]\n"), 100_000),
    Input("dotted keys of one table", ".toml", _each("t.a#.b = 1\n", BODY, ""), 100_000),
    Input("a table in a table, many times", ".toml", _each("[t#.a.b.c.d]\n", BODY, ""), 100_000),
    Input("inline tables", ".toml", _each("{ a# = 1 }, ", BODY + "x = [", "]\n"), 100_000),
    Input("bodies", ".toml", _each('[[body]]\nname = "b#"\nmesh = "triangle.obj"\n', "", ""), 1000),
    Input("pins", ".toml", _each("[[body.pin]]\nvertices = [0]\n", BODY, ""), 20_000),
    Input("colliders", ".toml", _each("[[collider]]\nsphere = { center = [#, -9, 0], radius = 1 }\n", BODY, ""), 5000),
    Input(
        "keyframes of a handle",
        ".toml",
        _each(" { time = # },", BODY + "[[body.handle]]\nvertices = [0]\nkeys = [", " ]\n"),
        100_000,
    ),
]
