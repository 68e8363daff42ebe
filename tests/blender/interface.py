"""Checks commands and panels: undo, cancel, the operator of the button, errors."""

from __future__ import annotations

import itertools
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any, ClassVar

import bpy
import numpy as np
from scenes import (
    added,
    attach,
    collider,
    cube,
    group,
    local,
    module,
    new_scene,
    refused,
    soft,
)


def check_undo() -> None:
    """Undo takes the bake away, and redo plays it again."""
    scene = new_scene(8)
    soft(cube("box"))
    bpy.ops.ed.undo_push(message="before")
    assert bpy.ops.supple.bake() == {"FINISHED"}
    bpy.ops.ed.undo_push(message="bake")
    scene.frame_set(8)
    fallen = local(bpy.data.objects["box"])
    bpy.ops.ed.undo()
    found = bpy.data.objects["box"]
    assert not found.modifiers
    assert not found.supple.cache
    bpy.ops.ed.redo()
    found = bpy.data.objects["box"]
    bpy.context.scene.frame_set(8)
    assert np.array_equal(local(found), fallen)
    assert fallen[:, 2].max() < 0.4
    assert bpy.ops.supple.clear() == {"FINISHED"}
    assert not found.modifiers


def check_cancel() -> None:
    """A bake that is cancelled, while reading or simulating, changes neither the scene nor an earlier bake."""
    scene = new_scene(12)
    found = soft(cube("box"))
    assert bpy.ops.supple.bake() == {"FINISHED"}
    file = Path(bpy.path.abspath(found.modifiers["Supple"].filepath))
    contents = file.read_bytes()
    found.supple.material = "JELLY"
    scene.frame_end = 2000
    scene.frame_set(7)
    session_module = module("session")
    cancelled = module("bake").BakeCancelledError
    for phase in (session_module.Phase.READING, session_module.Phase.SIMULATING):
        session = session_module.Session(bpy.context)
        texts = set()
        while session.phase is not phase or session.progress == 0:
            session.work(0.02)
            texts.add(session.text)
        assert 0 < session.progress < 1
        assert any(phase.value in text for text in texts)
        assert not bpy.ops.supple.bake.poll(), "one bake at a time"
        assert bpy.ops.supple.cancel() == {"FINISHED"}
        while not session.is_done:
            session.work(0.02)
        try:
            session.finish()
        except cancelled:
            pass
        else:
            raise AssertionError("the session was not cancelled")
        assert file.read_bytes() == contents
        assert len(list(file.parent.iterdir())) == 1
        assert scene.frame_current == 7
        assert found.modifiers["Supple"].show_viewport
        assert bpy.ops.supple.bake.poll()


def check_removed() -> None:
    """An object that is removed during the bake is named, and the others get their bakes."""
    new_scene(6)
    found, removed = soft(cube("box")), soft(cube("removed", location=(3, 0, 0)))
    session = module("session").Session(bpy.context)
    while not session.is_done:
        session.work(0.05)
    bpy.data.objects.remove(removed)
    report = session.finish()
    assert [warning for warning in report.warnings if '"removed" was removed' in warning], report.warnings
    assert found.modifiers["Supple"].filepath.endswith("box.pc2")


def check_modal() -> None:
    """The operator that the button starts shows progress, restores the interface, adds results, and is ended by Esc."""
    scene = new_scene(300)
    found = soft(cube("box"))
    operators = module("operators")
    operators.PORTION = 0.0  # one frame per event; a scene as simple as this one is read in one portion otherwise

    # Without a window Blender sends no events, so that the methods of the operator are called directly.
    class Running:
        reports: ClassVar[list[tuple[set[str], str]]] = []
        _timer = bpy.context.window_manager.event_timer_add(0.1, window=bpy.context.window)
        _start, _finish, modal, cancel = (
            vars(operators.Bake)[name] for name in ("_start", "_finish", "modal", "cancel")
        )
        _has_module, _reported = (vars(operators.Command)[name] for name in ("_has_module", "_reported"))

        def report(self, kind: set[str], message: str) -> None:
            self.reports.append((kind, message))

    def run(events: Iterator[tuple[str, str]]) -> tuple[list[set[str]], list[str]]:
        operator, results, texts = Running(), [], []
        assert operator._start(bpy.context)
        while not results or results[-1] <= {"RUNNING_MODAL", "PASS_THROUGH"}:
            kind, value = next(events)
            results.append(operator.modal(bpy.context, SimpleNamespace(type=kind, value=value)))
            session = module("session").Session.current
            texts += [session.text] if session is not None else []
        assert module("session").Session.current is None
        return results, texts

    results, texts = run(itertools.repeat(("TIMER", "NOTHING")))
    assert results[0] == {"RUNNING_MODAL"}, "the interface is locked while the scene is read"
    assert {"PASS_THROUGH"} in results, "the interface is free during the simulation"
    assert results[-1] == {"FINISHED"}
    assert any("Reading frame" in text for text in texts)
    assert any("Simulating frame" in text for text in texts)
    assert Running.reports[-1][0] == {"INFO"}
    assert found.modifiers["Supple"].frame_start == 1
    assert scene.frame_current == 1
    assert bpy.ops.supple.clear() == {"FINISHED"}
    results, _ = run(itertools.chain([("ESC", "PRESS")], itertools.repeat(("TIMER", "NOTHING"))))
    assert results[-1] == {"CANCELLED"}
    assert "cancelled" in Running.reports[-1][1]
    assert not found.modifiers


def check_errors() -> None:
    """Errors name the object and the way out."""
    scene = new_scene(4)
    refused("No visible object is a soft body", "Physics properties")
    found = soft(cube("box"))
    attach(found, "missing")
    refused('"box"', 'no vertex group "missing"', "choose one")
    found.vertex_groups.new(name="missing")
    refused('"box", vertex group "missing"', "no vertex has a weight of 0.5", "assign vertices")
    found.supple.attachments.clear()
    attach(found, "")
    refused('"box"', "an attachment has no vertex group")
    found.supple.attachments[0].vertex_group = "missing"
    found.vertex_groups["missing"].add([0, 1], 1.0, "REPLACE")
    found.supple.attachments[0].motion = "OBJECT"
    refused('"box", vertex group "missing"', "choose the object that moves the group")
    empty = added(bpy.ops.object.empty_add, "empty")
    found.supple.attachments[0].target = empty
    found.supple.attachments[0].bone = "hand"
    refused('"empty" has no bone "hand"')
    found.supple.attachments[0].bone = ""
    empty.hide_set(True)
    refused('"empty" is hidden', "show it")
    empty.hide_set(False)
    for frame, empty.hide_viewport in ((1, False), (3, True)):
        empty.keyframe_insert("hide_viewport", frame=frame)
    scene.frame_set(4)
    refused('"empty" is hidden in the viewport in frame 3')
    assert scene.frame_current == 4
    empty.animation_data_clear()
    empty.hide_viewport = False
    found.supple.attachments[0].target = found
    refused("cannot move its own group", '"Animation"')
    found.supple.attachments.clear()
    found.scale.z = 0
    refused('"box" has no extent along an axis in frame 1', "scale")
    found.scale.z = 1
    scene.frame_end = 1
    refused("frame range", "later end frame")
    scene.frame_end = 4
    array = found.modifiers.new("Array", "ARRAY")
    for frame, array.count in ((1, 1), (4, 4)):
        array.keyframe_insert("count", frame=frame)
    attach(found, "missing")
    refused('"box" has', "vertices in frame", "remove the modifier")
    found.modifiers.clear()
    found.supple.attachments.clear()
    occupied = Path(bpy.data.filepath).parent / "occupied"
    occupied.write_text("a file, not a folder")
    scene.supple.directory = str(occupied / "bakes")
    refused('The cache of object "box" cannot be written', "choose another Cache Folder")
    scene.supple.directory = ""
    found.supple.lattice_vertices = 2_000_000_000
    refused('"box" cannot be a soft body')
    found.supple.lattice_vertices = 200
    bpy.context.view_layer.objects.active = found
    bpy.ops.object.mode_set(mode="EDIT")
    refused('"box" is in Edit Mode', "Tab")
    bpy.ops.object.mode_set(mode="OBJECT")
    found.data.clear_geometry()
    refused('"box" has no faces')
    missing = sys.modules.pop("supple")
    sys.modules["supple"] = None
    try:
        refused("module supple cannot be imported", "zip file", "scripts/blender-extension")
    finally:
        sys.modules["supple"] = missing


class Layout:
    """Stands for the layout of a panel: notes what is drawn, and checks that properties, operators and icons exist."""

    def __init__(self, drawn: list[str]) -> None:
        """Share the list of a parent."""
        self._drawn = drawn

    @staticmethod
    def _check(function: str, options: dict[str, Any]) -> None:
        """Check the arguments of a function of Blender's layout."""
        parameters = bpy.types.UILayout.bl_rna.functions[function].parameters
        for name, value in options.items():
            assert name in parameters, f"{function} has no argument {name}"
            if name == "icon":
                assert value in parameters["icon"].enum_items, f"there is no icon {value}"

    def prop(self, data: Any, name: str, **options: Any) -> None:
        """Note a property."""
        self._check("prop", options)
        getattr(data, name)
        self._drawn.append(name)

    def prop_search(self, data: Any, name: str, source: Any, collection: str, **options: Any) -> None:
        """Note a property that is chosen from a collection."""
        self._check("prop_search", options)
        getattr(source, collection)
        self.prop(data, name)

    def operator(self, name: str, **options: Any) -> None:
        """Note an operator."""
        self._check("operator", options)
        category, operator = name.split(".")
        getattr(getattr(bpy.ops, category), operator).get_rna_type()
        self._drawn.append(name)

    def template_list(
        self, kind: str, name: str, data: Any, items: str, active_data: Any, active: str, **options: Any
    ) -> None:
        """Draw all items of a list."""
        self._check("template_list", options)
        for item in getattr(data, items):
            module("panels").AttachmentList.draw_item(None, bpy.context, self, data, item, 0, active_data, active)

    def label(self, **options: Any) -> None:
        """Note a text."""
        self._check("label", options)
        self._drawn.append(options["text"])

    def progress(self, **options: Any) -> None:
        """Note a progress bar."""
        self._check("progress", options)
        self._drawn.append(options["text"])

    def row(self, **options: Any) -> Layout:
        """Return a part of the layout."""
        self._check("row", options)
        return Layout(self._drawn)

    def column(self, **options: Any) -> Layout:
        """Return a part of the layout."""
        self._check("column", options)
        return Layout(self._drawn)


def drawn() -> list[str]:
    """Draw all panels of the active object, and return what they show."""
    panels, shown = module("panels"), []
    panel = type("Panel", (), {"layout": Layout(shown)})()
    panels.draw_button(panel, bpy.context)
    for kind in panels.CLASSES:
        if issubclass(kind, bpy.types.Panel) and kind.poll(bpy.context):
            kind.draw(panel, bpy.context)
    return shown


def check_panels() -> None:
    """Panels show the settings of soft bodies and of colliders, and the progress of a bake."""
    scene = new_scene(6)
    found = cube("box")
    assert drawn() == ["supple.add"]
    assert bpy.ops.supple.add() == {"FINISHED"}
    group(found, "top", lambda point: point.z > 0.4)
    bpy.ops.supple.add_attachment()
    rig = bpy.data.objects.new("rig", bpy.data.armatures.new("rig"))
    scene.collection.objects.link(rig)
    attachment = found.supple.attachments[0]
    assert attachment.vertex_group == "top"
    attachment.motion, attachment.target = "OBJECT", rig
    shown = drawn()
    settings = set(type(found.supple).bl_rna.properties.keys()) - {"rna_type", "name"}
    of_number = {"youngs_modulus", "poisson_ratio"}
    hidden = {"enabled", "cache", "cell_size", "attachments", "active_attachment", *of_number}
    assert settings - hidden <= set(shown), settings - hidden - set(shown)
    assert {"supple.remove", "supple.bake", "supple.clear", "target", "bone", "Object or Bone", "gravity"} <= set(shown)
    found.supple.material, found.supple.resolution = "CUSTOM", "CELL_SIZE"
    assert {"cell_size", *of_number} <= set(drawn())
    bpy.ops.supple.remove_attachment()
    assert not found.supple.attachments
    assert "target" not in drawn()
    session = module("session").Session(bpy.context)
    session.work(0.0)
    assert {session.text, "supple.cancel"} <= set(drawn())
    session.close()
    collider(added(bpy.ops.mesh.primitive_plane_add, "ground"))
    assert drawn() == ["supple.add", "shape", "friction", "restitution", "thickness"]
    bpy.ops.preferences.addon_disable(module="bl_ext.user_default.supple")
    assert not hasattr(bpy.types.Object, "supple")
    bpy.ops.preferences.addon_enable(module="bl_ext.user_default.supple")
    assert bpy.data.objects["box"].supple.enabled


def check_unsaved() -> None:
    """A file that is not saved has its bakes in Blender's temporary folder."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.preferences.addon_enable(module="bl_ext.user_default.supple")
    bpy.context.scene.frame_end = 4
    found = soft(cube("box"))
    assert bpy.ops.supple.bake() == {"FINISHED"}
    assert Path(bpy.app.tempdir) in Path(found.modifiers["Supple"].filepath).parents


CHECKS = (check_undo, check_cancel, check_removed, check_modal, check_errors, check_panels, check_unsaved)
