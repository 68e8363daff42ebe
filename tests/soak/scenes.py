"""Shipped and generated scenes."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from . import meshes

#: The repository, and its folder of shipped scenes.
ROOT = Path(__file__).resolve().parents[2]
SHIPPED = ROOT / "examples" / "scenes"

#: Scenes that take too long for the cases of the soak: half a minute with the development profile.
SLOW = {"pile.toml"}


def link_shipped(folder: Path) -> list[str]:
    """Link the shipped scenes and models into a folder. Returns the names of the scenes that are fast enough to run."""
    for path in sorted(SHIPPED.iterdir()):
        if path.suffix in (".obj", ".mtl", ".toml"):
            (folder / path.name).symlink_to(path)
    return sorted(path.name for path in SHIPPED.glob("*.toml") if path.name not in SLOW)


def write_generated(folder: Path, random: np.random.Generator) -> str:
    """Write a scene with random bodies, pins, handles and colliders. Returns its name."""
    lines = [
        "[simulation]",
        f"fps = {random.choice([24, 30, 60])}",
        f"substeps = {random.integers(1, 5)}",
        "[output]",
        'directory = "out"',
    ]
    for body in range(random.integers(1, 4)):
        meshes.write_obj(folder / f"mesh{body}.obj", meshes.any_surface(random))
        lines += _body(body, random)
    lines += ["[[collider]]", "plane = { point = [0, -2, 0], normal = [0, 1, 0] }"]
    if random.random() < 0.5:
        lines += [
            "[[collider]]",
            f"sphere = {{ center = {_vector(random.uniform(-2, 0, 3))}, radius = 0.7 }}",
            "keys = [ { time = 0 }, { time = 0.5, translate = [0, 0.4, 0], rotate = [0, 90, 0] } ]",
        ]
    (folder / "generated.toml").write_text("\n".join(lines) + "\n")
    return "generated.toml"


def _body(body: int, random: np.random.Generator) -> list[str]:
    volumes = ['"auto"', '"off"', '"cells"', '{ scope = "regional" }', "{ max_correction = 0.1 }"]
    lines = [
        "[[body]]",
        f'name = "b{body}"',
        f'mesh = "mesh{body}.obj"',
        f"translate = {_vector([4 * body, 0, 0])}",
        f"rotate = {_vector(random.uniform(-180, 180, 3))}",
        f"lattice_vertices = {random.integers(50, 600)}",
        f"half_width = {random.choice([0.5, 1, 2, 3]):g}",
        f"poisson_ratio = {random.choice([0, 0.3, 0.45, 0.47])}",
        f"inflate = {_inflation(random)}",
        f"region_damping_rate = {random.uniform(0, 10):.3f}",
        f"volume = {random.choice(volumes)}",
        f"velocity = {_vector(random.uniform(-3, 3, 3))}",
        f"spin = {_vector(random.uniform(-5, 5, 3))}",
    ]
    half = f"plane = {{ point = {_vector([4 * body, 0, 0])}, normal = [0, 1, 0] }}"
    if random.random() < 0.3:
        lines += ["[[body.zone]]", half, f"factor = {random.uniform(0.1, 1):.3f}", f"inflate = {_inflation(random)}"]
    if random.random() < 0.3:
        lines += ["[[body.pin]]", half, "end = 0.1"]
    if random.random() < 0.3:
        lines += ["[[body.handle]]", half, "keys = [ { time = 0 }, { time = 0.3, translate = [0, 0.5, 0.2] } ]"]
    return lines


def _inflation(random: np.random.Generator) -> str:
    """A ratio of rest volumes as a number or keyframes, most often none."""
    first, second = (f"{random.uniform(0.5, 2):.3f}" for _ in range(2))
    keys = f"{{ time = 0, value = {first} }}, {{ time = 0.3, value = {second} }}"
    return str(random.choice(["1", "1", first, f"[ {keys} ]", f'{{ keys = [ {keys} ], interpolation = "smooth" }}']))


def _vector(values: object) -> str:
    return str([round(float(value), 6) for value in np.asarray(values)])
