"""HTML that notebooks such as Jupyter show in place of the text of an object."""

from __future__ import annotations

import base64
import html
from pathlib import Path

from ._core import Body, Simulation
from .pictures import png
from .screenshots import screenshot

__all__ = ["page_html", "picture_html"]

#: Width and height of pictures, in pixels.
_SIZE = (480, 360)
#: Largest page that is embedded, in bytes. A notebook stores the page with its other results.
_MAX_PAGE = 32_000_000


def picture_html(target: Simulation | Body) -> str:
    """Return a picture of a simulation or a body, and a table of the bodies."""
    if isinstance(target, Simulation):
        bodies, title = target.bodies, f"Simulation at {target.time:.4g} s"
        count = len(target.colliders)
        title += f", {count} collider{'s' * (count != 1)}" if count else ""
    else:
        bodies, title = (target,), "Body"
    names = ", ".join(body.name for body in bodies[:10]) + (", …" if len(bodies) > 10 else "")
    data = base64.b64encode(png(screenshot(target, size=_SIZE))).decode()
    width, height = _SIZE
    picture = (
        f'<img src="data:image/png;base64,{data}" width="{width}" height="{height}" '
        f'alt="{html.escape(f"Picture of {names}")}">'
    )
    heads = "".join(f"<th>{head}</th>" for head in ("body", "vertices", "lattice vertices", "volume", ""))
    rows = "".join(map(_row, bodies))
    return (
        f"<div><div>{html.escape(title)}</div>{picture}"
        f"<table><thead><tr>{heads}</tr></thead><tbody>{rows}</tbody></table></div>"
    )


def _row(body: Body) -> str:
    """Return the row of a body in the table."""
    vertices = "no mesh" if body.mesh is None else str(len(body.mesh.vertices))
    cells = (body.name, vertices, str(len(body)), f"{body.volume:.4g}", "asleep" if body.is_asleep else "")
    return "<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in cells) + "</tr>"


def page_html(path: Path) -> str:
    """Return a frame with a page that a Recorder wrote, or a line that says where the page is if it is too large."""
    size = path.stat().st_size
    if size > _MAX_PAGE:
        text = f"{path} has {size / 1e6:.0f} MB, too many for a notebook; open it in a browser."
        return f"<div>{html.escape(text)}</div>"
    page = html.escape(path.read_text(encoding="utf-8"))
    # The page runs its scripts, and cannot reach the notebook.
    return (
        f'<iframe srcdoc="{page}" sandbox="allow-scripts" width="100%" height="560" '
        f'style="border: 1px solid #bbb" title="Animation of {html.escape(path.stem)}"></iframe>'
    )
