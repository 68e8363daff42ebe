"""Shows simulations in an interactive viewer, with polyscope."""

from __future__ import annotations

from typing import Any

import numpy as np

from ._core import Body, Simulation
from .colliders import Plane
from .extras import import_optional

__all__ = ["Viewer", "view"]

#: Maximum frame rate of the window, in Hz.
_MAX_RATE = 60.0
#: Maximum half-width that the slider can set, in cells.
_MAX_HALF_WIDTH = 8


def view(target: Simulation | Body) -> None:
    """Open a viewer window and wait until it is closed.

    target : Simulation or Body
        A body is displayed with its simulation. A body outside a simulation does not move.

    The window has controls to run and pause the simulation. For each body it has a checkbox for the volume correction,
    and if the body has no material, sliders for the stiffness (or frequency) and the half-width. Static planes are
    drawn while they are enabled; other colliders are not. Needs polyscope (`pip install polyscope`) and a display.
    """
    Viewer(target).show()


class Viewer:
    """A viewer window of a simulation, with controls.

    Viewer(target)

    target : Simulation or Body, as for view

    Polyscope has only one window per process: a later Viewer replaces the content of an earlier one.
    """

    #: Whether the simulation is running.
    running: bool

    def __init__(self, target: Simulation | Body) -> None:
        """Set up the content of the window without opening it."""
        if not isinstance(target, (Simulation, Body)):
            raise TypeError(f"target must be a Simulation or a Body, not {type(target).__name__}")
        self._polyscope = import_optional("polyscope")
        self._imgui = import_optional("polyscope.imgui")
        bodies: tuple[Body, ...] = (target,) if isinstance(target, Body) else target.bodies
        self._simulation = target.simulation if isinstance(target, Body) else target
        if self._simulation is not None:
            bodies = self._simulation.bodies
        self.running = False
        if not self._polyscope.is_initialized():
            self._polyscope.set_use_prefs_file(False)
            self._polyscope.init()
        self._polyscope.remove_all_structures()
        self._polyscope.set_ground_plane_mode("none")
        self._panels = [_Panel(self._polyscope, self._imgui, body, index) for index, body in enumerate(bodies)]
        # The planes are added after the camera is set, so that the camera frames the bodies only.
        self._polyscope.reset_camera_to_home_view()
        self._draw_planes()
        self._polyscope.set_user_callback(self.frame)

    def show(self) -> None:
        """Open the window and wait until it is closed."""
        self._polyscope.show()

    def frame(self) -> None:
        """Update one frame of the window: controls, steps if the simulation is running, and surfaces."""
        if self._simulation is not None:
            self._control_time(self._simulation)
            colliders = self._simulation.colliders
            for index, plane, square in self._planes:
                is_present = index < len(colliders) and colliders[index] is plane
                square.set_enabled(is_present and plane.is_enabled)
        for panel in self._panels:
            panel.frame()

    def _control_time(self, simulation: Simulation) -> None:
        """Draw the time controls, and step the simulation if it is running or a single step is requested."""
        _, self.running = self._imgui.Checkbox("run", self.running)
        self._imgui.SameLine()
        single_step = self._imgui.Button("one step")
        self._imgui.SameLine()
        self._imgui.Text(f"{simulation.time:.3f} s")
        if self.running:
            simulation.step(max(1, round(1.0 / (_MAX_RATE * simulation.dt))))
        elif single_step:
            simulation.step()

    def _draw_planes(self) -> None:
        """Draw static planes as squares, each kept with its index."""
        self._planes: list[tuple[int, Plane, Any]] = []
        colliders = () if self._simulation is None else self._simulation.colliders
        low, high = np.min([panel.low for panel in self._panels], 0), np.max([panel.high for panel in self._panels], 0)
        size = 1.2 * float(np.linalg.norm(high - low))
        for index, plane in enumerate(colliders):
            if isinstance(plane, Plane) and not plane.keys:
                corners = _square_corners(
                    np.asarray(plane.point, float), np.asarray(plane.normal, float), (low + high) / 2, size
                )
                quad = np.array([[0, 1, 2, 3]])
                square = self._polyscope.register_surface_mesh(f"plane {index}", corners, quad, color=(0.7, 0.7, 0.7))
                square.set_enabled(plane.is_enabled)
                self._planes.append((index, plane, square))


class _Panel:
    """A body in the window, with its controls."""

    def __init__(self, polyscope: Any, imgui: Any, body: Body, index: int) -> None:
        self._imgui, self._body = imgui, body
        # polyscope needs unique names without "#".
        self._label = f"{body.name} [{index}]".replace("#", "-")
        self._last_options = body.volume_options
        self._polyscope = polyscope
        points = self._points()
        self.low, self.high = points.min(axis=0), points.max(axis=0)
        self._register(points)

    def _register(self, points: Any) -> None:
        """Add the body to the window, with its present faces. A body of the same name is replaced."""
        body = self._body
        self._mesh = body.mesh
        if self._mesh is None:
            self._count = len(points)
            self._shape = self._polyscope.register_point_cloud(self._label, points)
        else:
            self._shape = self._polyscope.register_surface_mesh(
                self._label, points, self._mesh.faces, smooth_shade=True
            )

    def frame(self) -> None:
        """Draw the controls and update the displayed surface."""
        self._imgui.PushID(self._label)
        self._imgui.Text(self._label)
        self._control_body()
        self._imgui.PopID()
        points = self._points()
        mesh = self._body.mesh
        if mesh is not self._mesh or (mesh is None and len(points) != self._count):
            # The body broke.
            self._register(points)
        elif mesh is None:
            self._shape.update_point_positions(points)
        else:
            self._shape.update_vertex_positions(points)

    def _control_body(self) -> None:
        """Draw the controls of the body and apply changes."""
        body, imgui = self._body, self._imgui
        if body.stiffness is not None:
            changed, stiffness = imgui.SliderFloat("stiffness", body.stiffness, v_min=0.01, v_max=1.0)
            if changed:
                body.stiffness = min(max(stiffness, 0.01), 1.0)
        elif body.frequency is not None:
            changed, frequency = imgui.SliderFloat("frequency [Hz]", body.frequency, v_min=0.1, v_max=60.0)
            if changed:
                body.frequency = max(frequency, 0.1)
        if body.stiffness is not None or body.frequency is not None:
            # 0 stands for regions of one cell.
            cells = int(body.half_width)
            changed, cells = imgui.SliderInt(
                "half-width [cells]", cells, v_min=0, v_max=_MAX_HALF_WIDTH, format="%d" if cells else "0.5"
            )
            if changed:
                body.half_width = cells if cells >= 1 else 0.5
        is_on = body.volume_options["measure"] != "off"
        changed, enable = imgui.Checkbox("keep the volume", is_on)
        if changed and enable != is_on:
            self._switch_correction(enable)

    def _switch_correction(self, enable: bool) -> None:
        """Switch the volume correction off, or on with the options that it had when it was switched off."""
        if enable:
            self._body.volume_options = self._last_options if self._last_options["measure"] != "off" else "auto"
        else:
            self._last_options = self._body.volume_options
            self._body.volume_options = "off"

    def _points(self) -> Any:
        """Return the points to draw: displayed mesh vertices, or lattice vertices if the body has no mesh."""
        return self._body.corrected_positions() if self._body.mesh is None else self._body.surface()


def _square_corners(point: Any, normal: Any, near: Any, size: float) -> Any:
    """Return the corners of a square in a plane. Its center is the point of the plane that is nearest to `near`."""
    normal = normal / np.linalg.norm(normal)
    center = near - np.dot(near - point, normal) * normal
    u = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    u *= size / 2 / np.linalg.norm(u)
    v = np.cross(normal, u)
    return np.array([center - u - v, center + u - v, center + u + v, center - u + v])
