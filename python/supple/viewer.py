"""A window on a simulation, through polyscope."""

from __future__ import annotations

from typing import Any

import numpy as np

from ._core import Body, Simulation
from .colliders import Plane
from .extras import need

__all__ = ["Viewer", "view"]

#: Pictures a second that a window shows at most.
_RATE = 60.0
_WIDEST = 8


def view(shown: Simulation | Body) -> None:
    """Open a window on a simulation and wait until it is closed.

    shown : Simulation or Body
        A body is shown with its simulation; one by itself stands still.

    The window runs and stops time, and has for each body a slider for stiffness (or frequency) and half-width, and a
    switch for the volume correction. Planes at rest are drawn, other colliders are not. Needs polyscope
    (`pip install "supple[view]"`) and a display.
    """
    Viewer(shown).show()


class Viewer:
    """What a window shows of a simulation, and its controls.

    Viewer(shown)

    shown : Simulation or Body, as for view

    Polyscope has one window for a process: a later Viewer takes it over.
    """

    #: Whether time runs.
    running: bool

    def __init__(self, shown: Simulation | Body) -> None:
        """Puts all that is to be seen into the window, which is not opened yet."""
        if not isinstance(shown, (Simulation, Body)):
            raise TypeError(f"shown must be a Simulation or a Body, not {type(shown).__name__}")
        self._polyscope = need("polyscope", "view")
        self._imgui = need("polyscope.imgui", "view")
        bodies: tuple[Body, ...] = (shown,) if isinstance(shown, Body) else shown.bodies
        self._simulation = shown.simulation if isinstance(shown, Body) else shown
        if self._simulation is not None:
            bodies = self._simulation.bodies
        self.running = False
        if not self._polyscope.is_initialized():
            self._polyscope.set_use_prefs_file(False)
            self._polyscope.init()
        self._polyscope.remove_all_structures()
        self._polyscope.set_ground_plane_mode("none")
        self._panels = [_Panel(self._polyscope, self._imgui, body, index) for index, body in enumerate(bodies)]
        # The camera looks at the bodies, not at all of the ground.
        self._polyscope.reset_camera_to_home_view()
        self._draw_planes()
        self._polyscope.set_user_callback(self.frame)

    def show(self) -> None:
        """Open the window and wait until it is closed."""
        self._polyscope.show()

    def frame(self) -> None:
        """What happens once a picture: controls, steps if time runs, and the surfaces as they are then."""
        if self._simulation is not None:
            self._step(self._simulation)
        for panel in self._panels:
            panel.frame()

    def _step(self, simulation: Simulation) -> None:
        _, self.running = self._imgui.Checkbox("run", self.running)
        self._imgui.SameLine()
        wanted = self._imgui.Button("one step")
        self._imgui.SameLine()
        self._imgui.Text(f"{simulation.time:.3f} s")
        if self.running:
            simulation.step(max(1, round(1.0 / (_RATE * simulation.dt))))
        elif wanted:
            simulation.step()

    def _draw_planes(self) -> None:
        colliders = () if self._simulation is None else self._simulation.colliders
        low, high = np.min([panel.low for panel in self._panels], 0), np.max([panel.high for panel in self._panels], 0)
        reach = 1.2 * float(np.linalg.norm(high - low))
        for index, plane in enumerate(colliders):
            if isinstance(plane, Plane) and not plane.keys:
                corners = _square(
                    np.asarray(plane.point, float), np.asarray(plane.normal, float), (low + high) / 2, reach
                )
                quad = np.array([[0, 1, 2, 3]])
                self._polyscope.register_surface_mesh(f"plane {index}", corners, quad, color=(0.7, 0.7, 0.7))


class _Panel:
    """A body in the window, and its controls."""

    def __init__(self, polyscope: Any, imgui: Any, body: Body, index: int) -> None:
        self._imgui, self._body = imgui, body
        # Names must differ, and polyscope takes no "#" in them.
        self._label = f"{body.name} [{index}]".replace("#", "-")
        self._kept = body.volume_options
        points = self._points()
        self.low, self.high = points.min(axis=0), points.max(axis=0)
        if body.mesh is None:
            self._shape = polyscope.register_point_cloud(self._label, points)
        else:
            self._shape = polyscope.register_surface_mesh(self._label, points, body.mesh.faces, smooth_shade=True)

    def frame(self) -> None:
        self._imgui.PushID(self._label)
        self._imgui.Text(self._label)
        self._control()
        self._imgui.PopID()
        points = self._points()
        if self._body.mesh is None:
            self._shape.update_point_positions(points)
        else:
            self._shape.update_vertex_positions(points)

    def _control(self) -> None:
        body, imgui = self._body, self._imgui
        if body.stiffness is not None:
            moved, stiffness = imgui.SliderFloat("stiffness", body.stiffness, v_min=0.01, v_max=1.0)
            if moved:
                body.stiffness = min(max(stiffness, 0.01), 1.0)
        elif body.frequency is not None:
            moved, frequency = imgui.SliderFloat("frequency [Hz]", body.frequency, v_min=0.1, v_max=60.0)
            if moved:
                body.frequency = max(frequency, 0.1)
        moved, half_width = imgui.SliderInt("half-width [cells]", body.half_width, v_min=1, v_max=_WIDEST)
        if moved:
            body.half_width = max(half_width, 1)
        keeps = body.volume_options["measure"] != "off"
        moved, keep = imgui.Checkbox("keep the volume", keeps)
        if moved and keep != keeps:
            self._switch(keep)

    def _switch(self, keep: bool) -> None:
        """Switches the correction off, or on as it was before."""
        if keep:
            self._body.volume_options = self._kept if self._kept["measure"] != "off" else "auto"
        else:
            self._kept = self._body.volume_options
            self._body.volume_options = "off"

    def _points(self) -> Any:
        return self._body.corrected_positions() if self._body.mesh is None else self._body.surface()


def _square(point: Any, normal: Any, near: Any, reach: float) -> Any:
    """The corners of a square of a plane, about the point of it that is nearest to another."""
    normal = normal / np.linalg.norm(normal)
    middle = near - np.dot(near - point, normal) * normal
    along = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    along *= reach / 2 / np.linalg.norm(along)
    across = np.cross(normal, along)
    return np.array(
        [middle - along - across, middle + along - across, middle + along + across, middle - along + across]
    )
