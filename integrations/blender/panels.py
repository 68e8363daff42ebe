"""The settings in the Physics properties."""

from __future__ import annotations

from typing import ClassVar

import bpy
from bpy.types import Context, Object, Panel, UILayout, UIList

from .operators import missing_module, running
from .properties import SoftBodyAttachment


class AttachmentList(UIList):
    """The attachments of a soft body, one per row."""

    bl_idname = "SUPPLE_UL_attachments"

    def draw_item(
        self,
        context: Context,
        layout: UILayout,
        data: object,
        item: SoftBodyAttachment,
        icon: int,
        active_data: object,
        active_property: str,
    ) -> None:
        """Draw a row: the group and its motion."""
        row = layout.row()
        row.label(text=item.vertex_group or "no vertex group", icon="GROUP_VERTEX")
        row.label(text=item.bl_rna.properties["motion"].enum_items[item.motion].name)


class PhysicsPanel(Panel):
    """Base class: a panel of the Physics properties of a soft body."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "physics"

    @classmethod
    def poll(cls, context: Context) -> bool:
        """Return whether the active object is a soft body."""
        found = context.object
        return found is not None and found.type == "MESH" and found.supple.enabled


class SubPanel(PhysicsPanel):
    """Base class: a part of the panel of a soft body."""

    bl_parent_id = "SUPPLE_PT_soft_body"
    bl_options: ClassVar[set[str]] = {"DEFAULT_CLOSED"}


class BodyPanel(PhysicsPanel):
    """The material of the body, and the bake."""

    bl_idname = "SUPPLE_PT_soft_body"
    bl_label = "Supple Soft Body"

    def draw(self, context: Context) -> None:
        """Draw the panel."""
        layout, settings = self.layout, context.object.supple
        layout.use_property_split = True
        if missing_module() is not None:
            layout.label(text="The module supple is missing or too old", icon="ERROR")
        _draw_bake(layout)
        column = layout.column()
        column.prop(settings, "material")
        if settings.material == "CUSTOM":
            column.prop(settings, "youngs_modulus")
            column.prop(settings, "poisson_ratio")
        column.prop(settings, "accuracy")
        column.prop(settings, "density")
        row = column.row(heading="Damping")
        row.prop(settings, "use_damping_ratio", text="")
        part = row.row()
        part.active = settings.use_damping_ratio
        part.prop(settings, "damping_ratio", text="")
        column = layout.column()
        column.prop(settings, "resolution")
        column.prop(settings, "lattice_vertices" if settings.resolution == "VERTICES" else "cell_size")
        column.prop(settings, "join")
        column = layout.column()
        column.prop(settings, "volume")
        column.prop(settings, "skin")


class AttachmentsPanel(SubPanel):
    """Vertex groups that are held or moved."""

    bl_idname = "SUPPLE_PT_attachments"
    bl_label = "Attachments"
    bl_options: ClassVar[set[str]] = set()

    def draw(self, context: Context) -> None:
        """Draw the panel."""
        layout, found = self.layout, context.object
        settings = found.supple
        row = layout.row()
        row.template_list("SUPPLE_UL_attachments", "", settings, "attachments", settings, "active_attachment", rows=2)
        column = row.column(align=True)
        column.operator("supple.add_attachment", text="", icon="ADD")
        column.operator("supple.remove_attachment", text="", icon="REMOVE")
        layout.use_property_split = True
        if not 0 <= settings.active_attachment < len(settings.attachments):
            return
        attachment = settings.attachments[settings.active_attachment]
        column = layout.column()
        column.prop_search(attachment, "vertex_group", found, "vertex_groups")
        column.prop(attachment, "use_weights")
        column.prop(attachment, "motion")
        if attachment.motion == "OBJECT":
            column.prop(attachment, "target")
            if attachment.target is not None and attachment.target.type == "ARMATURE":
                column.prop_search(attachment, "bone", attachment.target.data, "bones")
        row = column.row(heading="Release")
        row.prop(attachment, "use_release", text="")
        part = row.row()
        part.active = attachment.use_release
        part.prop(attachment, "release_frame", text="Frame")


class StiffnessPanel(SubPanel):
    """Parts with another stiffness."""

    bl_idname = "SUPPLE_PT_stiffness"
    bl_label = "Stiffness"

    def draw(self, context: Context) -> None:
        """Draw the panel."""
        layout, found = self.layout, context.object
        layout.use_property_split = True
        _draw_group(layout, found, "stiffness_group", "stiffness_factor")


class InflationPanel(SubPanel):
    """Volumes at rest that grow and shrink."""

    bl_idname = "SUPPLE_PT_inflation"
    bl_label = "Inflation"

    def draw(self, context: Context) -> None:
        """Draw the panel."""
        layout, found = self.layout, context.object
        layout.use_property_split = True
        layout.prop(found.supple, "inflate")
        _draw_group(layout, found, "inflation_group", "inflation_ratio")


class ContactPanel(SubPanel):
    """How the body touches other bodies."""

    bl_idname = "SUPPLE_PT_contact"
    bl_label = "Contact"

    def draw(self, context: Context) -> None:
        """Draw the panel."""
        layout, settings = self.layout, context.object.supple
        layout.use_property_split = True
        layout.prop(settings, "friction")
        layout.prop(settings, "restitution")
        layout.prop(settings, "thickness")
        layout.prop(settings, "self_contact")
        layout.prop(settings, "ignore")
        layout.prop(context.scene.supple, "contact")


class ScenePanel(SubPanel):
    """Settings of all soft bodies of the scene."""

    bl_idname = "SUPPLE_PT_scene"
    bl_label = "Scene"

    def draw(self, context: Context) -> None:
        """Draw the panel."""
        layout, scene = self.layout, context.scene
        layout.use_property_split = True
        layout.prop(scene, "frame_start", text="Frame Start")
        layout.prop(scene, "frame_end", text="End")
        layout.prop(scene, "use_gravity")
        part = layout.column()
        part.active = scene.use_gravity
        part.prop(scene, "gravity")
        row = layout.row(heading="Set Steps")
        row.prop(scene.supple, "use_substeps", text="")
        part = row.row()
        part.active = scene.supple.use_substeps
        part.prop(scene.supple, "substeps", text="per Frame")
        layout.prop(scene.supple, "directory")


class ColliderPanel(PhysicsPanel):
    """How soft bodies collide with an object that has Blender's collision physics."""

    bl_idname = "SUPPLE_PT_collider"
    bl_label = "Supple Collider"

    @classmethod
    def poll(cls, context: Context) -> bool:
        """Return whether the active object has collision physics and is not a soft body."""
        found = context.object
        is_mesh = found is not None and found.type == "MESH" and not found.supple.enabled
        return is_mesh and found.collision is not None

    def draw(self, context: Context) -> None:
        """Draw the panel."""
        layout, settings = self.layout, context.object.supple_collider
        layout.use_property_split = True
        layout.prop(settings, "shape")
        layout.prop(settings, "friction")
        layout.prop(settings, "restitution")
        layout.prop(settings, "thickness")


def draw_button(panel: Panel, context: Context) -> None:
    """Draw the button that adds or removes a soft body, below those of Blender's own physics."""
    if context.object is None or context.object.type != "MESH":
        return
    if context.object.supple.enabled:
        panel.layout.operator("supple.remove", text="Supple Soft Body", icon="X")
    else:
        panel.layout.operator("supple.add", text="Supple Soft Body", icon="MOD_SOFT")


def _draw_group(layout: UILayout, found: Object, group: str, number: str) -> None:
    """Draw a vertex group and the number of its parts, which has no effect without a group."""
    layout.prop_search(found.supple, group, found, "vertex_groups")
    part = layout.column()
    part.active = bool(getattr(found.supple, group))
    part.prop(found.supple, number)


def _draw_bake(layout: UILayout) -> None:
    """Draw the buttons of the bake, or its progress."""
    session = running()
    if session is None:
        row = layout.row(align=True)
        row.operator("supple.bake", text="Bake All", icon="PHYSICS")
        row.operator("supple.clear", text="Clear All", icon="TRASH")
        return
    row = layout.row(align=True)
    row.progress(factor=session.progress, text=session.text)
    row.operator("supple.cancel", text="", icon="X")


CLASSES = (
    AttachmentList,
    BodyPanel,
    AttachmentsPanel,
    StiffnessPanel,
    InflationPanel,
    ContactPanel,
    ScenePanel,
    ColliderPanel,
)


def register() -> None:
    """Add the panels."""
    for found in CLASSES:
        bpy.utils.register_class(found)
    bpy.types.PHYSICS_PT_add.append(draw_button)


def unregister() -> None:
    """Remove the panels."""
    bpy.types.PHYSICS_PT_add.remove(draw_button)
    for found in reversed(CLASSES):
        bpy.utils.unregister_class(found)
