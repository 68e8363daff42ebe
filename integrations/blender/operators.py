"""The commands: add and remove soft bodies and attachments, bake, cancel, clear."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING, ClassVar

import bpy
from bpy.types import Context, Event, Object, Operator, Timer

if TYPE_CHECKING:
    from collections.abc import Iterator
    from types import ModuleType

    from .session import Session

#: Time that a bake takes from the interface while it reads the scene, in seconds per event of its timer.
PORTION = 0.05

#: Time between the events of the timer, in seconds.
INTERVAL = 0.1


class Command(Operator):
    """Base class: an operator that needs the module supple, and reports errors with the way out."""

    @contextmanager
    def _reported(self) -> Iterator[None]:
        """Report errors that a user can correct."""
        from .bake import BakeCancelledError, BakeError

        try:
            yield
        except BakeError as error:
            self.report({"ERROR"}, _sentence(str(error)))
        except BakeCancelledError:
            self.report({"WARNING"}, "The bake was cancelled; earlier bakes are unchanged")

    def _has_module(self) -> bool:
        """Return whether the compiled module is at hand, and report if it is not."""
        problem = missing_module()
        if problem is not None:
            self.report({"ERROR"}, problem)
        return problem is None


class Add(Operator):
    """Make the selected meshes soft bodies"""

    bl_idname = "supple.add"
    bl_label = "Add Supple Soft Body"
    bl_options: ClassVar[set[str]] = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        """Return whether the active object can be a soft body."""
        return _is_mesh(context.object)

    def execute(self, context: Context) -> set[str]:
        """Enable the settings of all selected meshes."""
        for found in (context.object, *context.selected_objects):
            if _is_mesh(found):
                found.supple.enabled = True
        return {"FINISHED"}


class Remove(Command):
    """Make the object a usual mesh again, and remove its bake"""

    bl_idname = "supple.remove"
    bl_label = "Remove Supple Soft Body"
    bl_options: ClassVar[set[str]] = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        """Return whether the active object is a soft body."""
        return _is_body(context.object) and running() is None

    def execute(self, context: Context) -> set[str]:
        """Remove the bake and disable the settings."""
        if not self._has_module():
            return {"CANCELLED"}
        from .scene import clear

        context.object.supple.enabled = False
        with self._reported():
            clear(context.object)
        return {"FINISHED"}


class AddAttachment(Operator):
    """Hold or move a vertex group"""

    bl_idname = "supple.add_attachment"
    bl_label = "Add Attachment"
    bl_options: ClassVar[set[str]] = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        """Return whether the active object is a soft body."""
        return _is_body(context.object)

    def execute(self, context: Context) -> set[str]:
        """Add an attachment of the active vertex group."""
        settings, group = context.object.supple, context.object.vertex_groups.active
        attachment = settings.attachments.add()
        attachment.vertex_group = group.name if group else ""
        settings.active_attachment = len(settings.attachments) - 1
        return {"FINISHED"}


class RemoveAttachment(Operator):
    """Remove the attachment from the list"""

    bl_idname = "supple.remove_attachment"
    bl_label = "Remove Attachment"
    bl_options: ClassVar[set[str]] = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        """Return whether the active object has attachments."""
        return _is_body(context.object) and len(context.object.supple.attachments) > 0

    def execute(self, context: Context) -> set[str]:
        """Remove the active attachment."""
        settings = context.object.supple
        settings.attachments.remove(settings.active_attachment)
        settings.active_attachment = max(0, min(settings.active_attachment, len(settings.attachments) - 1))
        return {"FINISHED"}


class Bake(Command):
    """Simulate all soft bodies of the scene over its frame range, and play the result on their meshes"""

    bl_idname = "supple.bake"
    bl_label = "Bake Supple Soft Bodies"
    bl_options: ClassVar[set[str]] = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        """Return whether no bake is in progress."""
        return running() is None

    def execute(self, context: Context) -> set[str]:
        """Bake, and return at the end. Scripts call this."""
        if not self._start(context):
            return {"CANCELLED"}
        try:
            while not self._session.is_done:
                self._session.work(INTERVAL)
        finally:
            self._session.close()
        return self._finish()

    def invoke(self, context: Context, event: Event) -> set[str]:
        """Start a bake that goes on while the interface is used."""
        if not self._start(context):
            return {"CANCELLED"}
        manager = context.window_manager
        self._timer: Timer = manager.event_timer_add(INTERVAL, window=context.window)
        manager.modal_handler_add(self)
        manager.progress_begin(0.0, 1.0)
        return {"RUNNING_MODAL"}

    def modal(self, context: Context, event: Event) -> set[str]:
        """Go on with each event of the timer. Esc cancels."""
        session = self._session
        if event.type == "ESC" and event.value == "PRESS":
            session.cancel()
            return {"RUNNING_MODAL"}
        if event.type == "TIMER":
            # The simulation runs in its own thread and needs no time of the interface.
            session.work(PORTION if session.is_reading else 0.0)
            context.window_manager.progress_update(session.progress)
            context.workspace.status_text_set(f"Supple: {session.text}   Esc: Cancel")
            _redraw(context)
        if not session.is_done:
            # The scene must not change while it is read.
            return {"RUNNING_MODAL"} if session.is_reading else {"PASS_THROUGH"}
        self.cancel(context)
        return self._finish()

    def cancel(self, context: Context) -> None:
        """End the bake, also when Blender ends or loads another file."""
        self._session.close()
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        context.workspace.status_text_set(None)
        _redraw(context)

    def _start(self, context: Context) -> bool:
        """Check the scene and start, or report why that is impossible."""
        if not self._has_module():
            return False
        from .session import Session

        with self._reported():
            self._session: Session = Session(context)
            return True
        return False

    def _finish(self) -> set[str]:
        """Add the results, and report."""
        with self._reported():
            report = self._session.finish()
            for note in report.warnings:
                self.report({"WARNING"}, _sentence(note))
            if self._session.is_temporary:
                self.report({"WARNING"}, "The bake is lost when Blender ends: save the file, then bake again")
            self.report({"INFO"}, f"Baked in {report.seconds:.1f} s, with {report.steps_per_frame} steps per frame")
            return {"FINISHED"}
        return {"CANCELLED"}


class Cancel(Operator):
    """Cancel the bake in progress; earlier bakes stay as they are"""

    bl_idname = "supple.cancel"
    bl_label = "Cancel Bake"

    @classmethod
    def poll(cls, context: Context) -> bool:
        """Return whether a bake is in progress."""
        return running() is not None

    def execute(self, context: Context) -> set[str]:
        """End the bake soon."""
        session = running()
        if session is not None:
            session.cancel()
        return {"FINISHED"}


class Clear(Command):
    """Remove the bakes of all soft bodies of the scene: their modifiers and their files"""

    bl_idname = "supple.clear"
    bl_label = "Clear Bakes"
    bl_options: ClassVar[set[str]] = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        """Return whether no bake is in progress."""
        return running() is None

    def execute(self, context: Context) -> set[str]:
        """Clear all objects of the scene."""
        if not self._has_module():
            return {"CANCELLED"}
        from .scene import clear

        count = 0
        for found in context.scene.objects:
            if found.supple.cache:
                with self._reported():
                    count += clear(found)
        self.report({"INFO"}, f"Cleared {count} bake{'' if count == 1 else 's'}")
        return {"FINISHED"}


def running() -> Session | None:
    """Return the bake in progress, or None."""
    module = _session_module()
    return None if module is None else module.Session.current


def missing_module() -> str | None:
    """Return why the module supple cannot be used and how to get it, or None if it can."""
    try:
        import supple
    except ImportError as error:
        return (
            f"The module supple is not at hand ({error}). Install the extension from a zip file that was built for "
            "this operating system and processor, by scripts/blender-extension"
        )
    return None if hasattr(supple, "PointCache") else f"The module supple at {supple.__file__} is too old; update it"


def _session_module() -> ModuleType | None:
    """Return the module with the bake in progress; None if it was not needed yet."""
    import sys

    return sys.modules.get(f"{__package__}.session")


def _is_mesh(found: Object | None) -> bool:
    """Return whether an object can be a soft body."""
    return found is not None and found.type == "MESH"


def _is_body(found: Object | None) -> bool:
    """Return whether an object is a soft body."""
    return found is not None and found.type == "MESH" and found.supple.enabled


def _sentence(text: str) -> str:
    """Return a text that begins with a capital letter."""
    return text[:1].upper() + text[1:]


def _redraw(context: Context) -> None:
    """Redraw the properties, which show the progress."""
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "PROPERTIES":
                area.tag_redraw()


CLASSES = (Add, Remove, AddAttachment, RemoveAttachment, Bake, Cancel, Clear)


def register() -> None:
    """Add the commands."""
    for found in CLASSES:
        bpy.utils.register_class(found)


def unregister() -> None:
    """End a bake in progress, and remove the commands."""
    session = running()
    if session is not None:
        session.close()
    for found in reversed(CLASSES):
        bpy.utils.unregister_class(found)
