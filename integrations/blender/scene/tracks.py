"""Reads the data of one object in every frame."""

from __future__ import annotations

import numpy as np
from bpy.types import Depsgraph, Mesh, Object, Scene
from numpy.typing import NDArray

from ..bake import SURFACE_SETTINGS, Attachment, BakeError, Body, Collider, Inflation, Stiffness, transformed
from ..properties import SoftBodyAttachment
from .caches import cache_path
from .meshes import evaluated, faces_of, matrix_of, positions_of, weights_of
from .settings import body_options

#: Least weight of a vertex that an attachment holds.
HELD_WEIGHT = 0.5


class DriverTrack:
    """World matrices of an object, or of a bone of it."""

    def __init__(self, target: Object, bone: str) -> None:
        """Prepare to read an object."""
        self._target, self._bone = target, bone
        self._matrices: list[NDArray[np.float64]] = []

    def read(self, depsgraph: Depsgraph) -> None:
        """Read the current frame."""
        matrix = matrix_of(self._target, depsgraph)
        if self._bone:
            pose = self._target.evaluated_get(depsgraph).pose
            matrix = matrix @ np.array(pose.bones[self._bone].matrix, np.float64)
        self._matrices.append(matrix)

    @property
    def matrices(self) -> NDArray[np.float64]:
        """World matrices of all frames: (f, 4, 4)."""
        return np.array(self._matrices)


class BodyTrack:
    """A soft body: the shape of the first frame, the matrices and ratios of all frames, and a mesh that is animated."""

    def __init__(self, found: Object, scene: Scene, bodies: list[Object]) -> None:
        """Prepare to read an object, one of all soft bodies of the bake, and check the settings of its attachments."""
        self._found, self._scene, self._path = found, scene, cache_path(scene, found)
        self._options = body_options(found, scene, bodies)
        self._drivers = [self._driver(attachment) for attachment in found.supple.attachments]
        self._is_animated = any(attachment.motion == "ANIMATION" for attachment in found.supple.attachments)
        self._matrices: list[NDArray[np.float64]] = []
        self._animation: list[NDArray[np.float32]] = []
        # Ratios of the rest volumes of the body and of its group.
        self._ratios: list[tuple[float, float]] = []

    def read(self, depsgraph: Depsgraph) -> None:
        """Read the current frame."""
        matrix = matrix_of(self._found, depsgraph)
        animated = self._found.evaluated_get(depsgraph).supple
        self._ratios.append((animated.inflate, animated.inflation_ratio))
        if not self._matrices:
            self._read_shape(depsgraph, matrix)
        if self._is_animated:
            self._read_animation(depsgraph, matrix)
        for driver in self._drivers:
            if driver is not None:
                driver.read(depsgraph)
        self._matrices.append(matrix)

    def body(self) -> Body:
        """Return the body, after all frames were read."""
        attachments = []
        moves = any(positions is not self._animation[0] for positions in self._animation)
        animation = np.stack(self._animation) if moves else None
        for settings, driver in zip(self._found.supple.attachments, self._drivers, strict=True):
            weights = self._weights[settings.vertex_group]
            part = weights if settings.use_weights else weights >= HELD_WEIGHT
            attachment = Attachment(settings.vertex_group, part)
            if driver is not None:
                attachment.driver = driver.matrices
            elif settings.motion == "ANIMATION":
                attachment.animation = animation
            if settings.use_release:
                attachment.release = settings.release_frame - self._scene.frame_start
            attachments.append(attachment)
        return Body(
            name=self._found.name,
            vertices=self._vertices,
            faces=self._faces,
            matrices=np.array(self._matrices),
            path=self._path,
            options=self._options,
            attachments=attachments,
            stiffness=self._stiffness(),
            inflate=np.array(self._ratios)[:, 0],
            inflation=self._inflation(),
        )

    def _driver(self, attachment: SoftBodyAttachment) -> DriverTrack | None:
        """Return the driver of an attachment, None if it has none."""
        if attachment.motion != "OBJECT":
            return None
        target, bone = attachment.target, attachment.bone
        about = f'object "{self._found.name}", vertex group "{attachment.vertex_group}"'
        if target is None:
            raise BakeError(f"{about}: choose the object that moves the group")
        if target == self._found:
            raise BakeError(f'{about}: a body cannot move its own group; set Motion to "Animation"')
        if bone and (target.type != "ARMATURE" or bone not in target.pose.bones):
            raise BakeError(f'{about}: "{target.name}" has no bone "{bone}"; choose one of its bones, or none')
        return DriverTrack(target, bone)

    def _read_shape(self, depsgraph: Depsgraph, matrix: NDArray[np.float64]) -> None:
        """Read the rest shape and the vertex groups."""
        name, settings = self._found.name, self._found.supple
        with evaluated(self._found, depsgraph, with_groups=True) as mesh:
            if not len(mesh.polygons):
                raise BakeError(f'object "{name}" has no faces; a soft body needs a surface')
            self._vertices = transformed(matrix, positions_of(mesh))
            self._faces = faces_of(mesh, mirrored=np.linalg.det(matrix[:3, :3]) < 0)
            used = [attachment.vertex_group for attachment in settings.attachments]
            parts = filter(None, [settings.stiffness_group, settings.inflation_group])
            self._weights = self._read_weights(mesh, [*used, *parts])
        for group in used:
            if not (self._weights[group] >= HELD_WEIGHT).any():
                raise BakeError(
                    f'object "{name}", vertex group "{group}": no vertex has a weight of {HELD_WEIGHT} or more; '
                    "assign vertices, or remove the attachment"
                )

    def _read_weights(self, mesh: Mesh, names: list[str]) -> dict[str, NDArray[np.float64]]:
        """Return the weights of vertex groups by name."""
        groups = self._found.vertex_groups
        for name in names:
            if name not in groups:
                problem = f'there is no vertex group "{name}"' if name else "an attachment has no vertex group"
                raise BakeError(f'object "{self._found.name}": {problem}; choose one, or remove the attachment')
        indices = {name: groups[name].index for name in names}
        weights = weights_of(mesh, set(indices.values()))
        return {name: weights[index] for name, index in indices.items()}

    def _read_animation(self, depsgraph: Depsgraph, matrix: NDArray[np.float64]) -> None:
        """Read the positions of the animated mesh."""
        with evaluated(self._found, depsgraph) as mesh:
            positions = transformed(matrix, positions_of(mesh)).astype(np.float32)
        _check_count(self._found, len(positions), len(self._vertices), depsgraph.scene.frame_current)
        _append(self._animation, positions)

    def _stiffness(self) -> Stiffness | None:
        """Return the group with another stiffness."""
        settings = self._found.supple
        group = settings.stiffness_group
        return Stiffness(self._weights[group], settings.stiffness_factor) if group else None

    def _inflation(self) -> Inflation | None:
        """Return the group whose rest volume changes."""
        group = self._found.supple.inflation_group
        return Inflation(self._weights[group], np.array(self._ratios)[:, 1]) if group else None


class ColliderTrack:
    """A collider: its matrices, and its mesh in all frames if it deforms."""

    def __init__(self, found: Object) -> None:
        """Prepare to read an object."""
        self._found = found
        self._matrices: list[NDArray[np.float64]] = []
        self._local: list[NDArray[np.float32]] = []

    def read(self, depsgraph: Depsgraph) -> None:
        """Read the current frame."""
        matrix = matrix_of(self._found, depsgraph)
        if self._found.supple_collider.shape == "MESH":
            with evaluated(self._found, depsgraph) as mesh:
                positions = positions_of(mesh)
                if not self._matrices:
                    self._faces = faces_of(mesh, mirrored=np.linalg.det(matrix[:3, :3]) < 0)
                    self._has_faces = len(mesh.polygons) > 0
            _append(self._local, positions)
            _check_count(self._found, len(positions), len(self._local[0]), depsgraph.scene.frame_current)
        self._matrices.append(matrix)

    def collider(self) -> Collider | None:
        """Return the collider after all frames were read; None for a mesh without faces."""
        settings, matrices = self._found.supple_collider, np.array(self._matrices)
        surface = {name: getattr(settings, name) for name in SURFACE_SETTINGS}
        collider = Collider(self._found.name, matrices, **surface)
        if settings.shape == "MESH":
            if not self._has_faces:
                return None
            collider.vertices, collider.faces = transformed(matrices[0], self._local[0]), self._faces
            if any(positions is not self._local[0] for positions in self._local):
                placed = zip(matrices, self._local, strict=True)
                collider.frames = np.stack(
                    [transformed(matrix, positions).astype(np.float32) for matrix, positions in placed]
                )
        return collider


def _append(frames: list[NDArray[np.float32]], positions: NDArray[np.float32]) -> None:
    """Append the positions of a frame. Frames that are equal to the first one share its memory."""
    frames.append(frames[0] if frames and np.array_equal(positions, frames[0]) else positions)


def _check_count(found: Object, count: int, first: int, frame: int) -> None:
    """Raise an error if the number of vertices has changed since the first frame."""
    if count != first:
        raise BakeError(
            f'object "{found.name}" has {count} vertices in frame {frame} and {first} in the first frame; '
            "remove the modifier that changes their number"
        )
