"""Builds the simulation of a job."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

import supple

from .job import SURFACE_SETTINGS, Attachment, BakeError, Body, Collider, Job
from .motion import curve, is_rigid, is_still, rigid_keys, transformed


def build(job: Job) -> supple.Simulation:
    """Return the simulation of a job, in frame 0.

    Raises BakeError for a mesh or a setting that cannot be simulated.
    """
    bodies = [_body(body, job) for body in job.bodies]
    colliders = [_collider(collider, job.fps) for collider in job.colliders]
    try:
        return supple.Simulation(
            bodies,
            fps=job.fps,
            substeps=job.substeps or "auto",
            gravity=job.gravity,
            colliders=colliders,
            contact=job.contact,
        )
    except ValueError as error:
        raise BakeError(f"the simulation cannot start: {error}") from error


def _body(data: Body, job: Job) -> supple.Body:
    """Return a body with its attachments, its stiffness and its inflation."""
    try:
        body = supple.Body(supple.Mesh(data.vertices, data.faces), name=data.name, **data.options)
        if data.stiffness is not None:
            body.zone(data.stiffness.factor, map=data.stiffness.weights)
        if data.inflate is not None:
            body.inflate = curve(data.inflate, job.fps)
        if data.inflation is not None and (data.inflation.ratios != 1).any():
            body.zone(inflate=curve(data.inflation.ratios, job.fps), map=data.inflation.weights)
    except ValueError as error:
        raise BakeError(f'object "{data.name}" cannot be a soft body: {error}') from error
    for attachment in data.attachments:
        try:
            _attach(body, attachment, job.fps)
        except np.linalg.LinAlgError as error:
            raise BakeError(
                f'object "{data.name}", vertex group "{attachment.group}": the object or bone that moves it has no '
                "extent along an axis in the first frame, because its scale is zero; set a scale above 0"
            ) from error
        except ValueError as error:
            raise BakeError(f'object "{data.name}", vertex group "{attachment.group}": {error}') from error
    return body


def _attach(body: supple.Body, data: Attachment, fps: float) -> None:
    """Hold the vertices of an attachment, or move them."""
    part: dict[str, Any] = {("mesh_vertices" if data.vertices.dtype == bool else "map"): data.vertices}
    end = None if data.release is None else data.release / fps
    if end is not None and end <= 0:
        return
    if data.animation is not None and not is_still(data.animation):
        body.handle(**part, follow=data.animation, follow_fps=fps, end=end)
        return
    hold = body.pin(**part, end=end)
    if data.driver is not None and not is_still(data.driver):
        # Keyframes turn about the mean of the vertices that are held.
        hold.set_keys(rigid_keys(data.driver, body.positions[hold.vertices].mean(axis=0), fps))


def _collider(data: Collider, fps: float) -> supple.Collider:
    """Return a collider: still, moving rigidly, or deforming."""
    surface: dict[str, Any] = {name: getattr(data, name) for name in SURFACE_SETTINGS}
    try:
        if data.vertices is None:
            first = data.matrices[0]
            point, normal = first[:3, 3], _normal(first)
            return supple.Plane(point, normal, keys=_keys(data.matrices, point, fps), **surface)
        mesh = supple.Mesh(data.vertices, data.faces)
        if data.frames is None and (is_still(data.matrices) or is_rigid(data.matrices)):
            keys = _keys(data.matrices, mesh.bounds.mean(axis=0), fps)
            return supple.MeshCollider(mesh, keys=keys, **surface)
        frames = data.frames if data.frames is not None else _deformed(data)
        return supple.MeshCollider(mesh, frames=frames, fps=fps, **surface)
    except np.linalg.LinAlgError as error:
        raise BakeError(
            f'object "{data.name}" cannot be a moving collider: it has no extent along an axis in the first frame, '
            "because its scale is zero; set a scale above 0"
        ) from error
    except ValueError as error:
        raise BakeError(f'object "{data.name}" cannot be a collider: {error}') from error


def _keys(matrices: NDArray[np.float64], center: NDArray[np.float64], fps: float) -> list[tuple[float, object, object]]:
    """Return the keyframes of a collider, an empty list if it stands still."""
    return [] if is_still(matrices) else rigid_keys(matrices, center, fps)


def _normal(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the normal of the xy plane of an object, on the side to which its z axis points."""
    normal = np.cross(matrix[:3, 0], matrix[:3, 1])
    return normal if normal @ matrix[:3, 2] >= 0 else -normal


def _deformed(data: Collider) -> NDArray[np.float32]:
    """Return the positions in all frames of a mesh whose object changes its size."""
    assert data.vertices is not None, "a plane has no positions"
    local = transformed(np.linalg.inv(data.matrices[0]), data.vertices)
    return np.stack([transformed(matrix, local).astype(np.float32) for matrix in data.matrices])
