"""A first simulation: `python -m supple.example` writes it as a page and opens the page in a browser.

Three soft rings fall over a peg.
"""

from __future__ import annotations

import argparse
import os
import webbrowser
from pathlib import Path

import numpy as np

from ._core import Body, Mesh, Simulation
from .colliders import Capsule, Plane
from .recorder import save_html

__all__ = ["main", "ring", "simulation"]


def simulation() -> Simulation:
    """Return three rings of different materials above a peg that stands on a ground, at 30 frames per second."""
    torus = ring(0.6, 0.22)
    rings = [
        Body(torus, name="jelly", material="jelly", rotate=(12, 0, 0), translate=(0, 2.6, 0)),
        Body(torus, name="flesh", material="flesh", rotate=(-18, 0, 0), translate=(0, 3.6, 0)),
        Body(torus, name="rubber", material="rubber", rotate=(20, 0, 0), translate=(0, 4.8, 0)),
    ]
    peg = Capsule((0, 0, 0), (0, 1.5, 0), 0.18)
    return Simulation(rings, fps=30, colliders=[Plane((0, 0, 0), (0, 1, 0)), peg])


def ring(radius: float, thickness: float) -> Mesh:
    """Return a torus about y: the radius of its middle line, and that of its tube."""
    rows, columns = 48, 24
    around, across = (np.linspace(0, 2 * np.pi, count, endpoint=False) for count in (rows, columns))
    distance = radius + thickness * np.cos(across)
    points = np.stack(
        [
            np.outer(np.cos(around), distance),
            np.broadcast_to(thickness * np.sin(across), (rows, columns)),
            -np.outer(np.sin(around), distance),
        ],
        axis=-1,
    )
    corner = np.arange(rows * columns).reshape(rows, columns)
    next_row = np.roll(corner, -1, axis=0)
    quads = np.stack([corner, next_row, np.roll(next_row, -1, axis=1), np.roll(corner, -1, axis=1)], axis=-1)
    return Mesh(points.reshape(-1, 3), quads.reshape(-1, 4))


def main() -> None:
    """Write the page, and open it."""
    parser = argparse.ArgumentParser(prog="python -m supple.example", description=__doc__.splitlines()[0])
    parser.add_argument("page", nargs="?", default="supple_example.html", help="the page to write")
    parser.add_argument("--frames", type=int, default=105, help="number of frames, 30 per second")
    parser.add_argument("--no-browser", action="store_true", help="do not open the page")
    arguments = parser.parse_args()
    save_html(simulation(), arguments.page, arguments.frames)
    page = Path(arguments.page).absolute()
    print(f"{page} ({os.path.getsize(page) / 1e6:.1f} MB)")
    if not arguments.no_browser and not webbrowser.open(page.as_uri()):
        print("open it in a browser")


if __name__ == "__main__":
    main()
