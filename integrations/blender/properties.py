"""The settings of soft bodies, colliders and scenes. Settings that supple has too have its names and defaults."""

from typing import Any

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)
from bpy.types import Collection, Object, PropertyGroup, Scene

#: Properties of objects can be set in library overrides of objects of other files, and items of lists be added there.
OVERRIDABLE = {"LIBRARY_OVERRIDABLE"}
ITEMS = {"LIBRARY_OVERRIDABLE", "USE_INSERTION"}

MOTIONS = [
    (
        "ANIMATION",
        "Animation",
        "The group moves as the object is animated: by its transformation, bones and shape keys. Without an animation "
        "it stays in place",
    ),
    ("PIN", "Pin", "The group stays where it is in the first frame, whatever the object does"),
    (
        "OBJECT",
        "Object or Bone",
        "The group moves with another object, such as an empty, or with a bone of an armature",
    ),
]

MATERIALS = [
    ("JELLY", "Jelly", "Sags and wobbles for seconds"),
    ("FLESH", "Flesh", "Yields visibly, comes to rest soon"),
    ("RUBBER", "Rubber", "Keeps its shape"),
    ("FIRM", "Firm", "Deforms little"),
    ("CUSTOM", "Young's Modulus", "The stiffness is a number"),
]

ACCURACIES = [
    ("FAST", "Fast", "The fewest steps"),
    ("BALANCED", "Balanced", "Exact for small lattices, fast for large ones"),
    ("EXACT", "Exact", "Each cell by itself: nothing folds at what holds or presses it"),
]

RESOLUTIONS = [
    ("VERTICES", "Lattice Vertices", "Number of simulated vertices, whatever the size of the object"),
    ("CELL_SIZE", "Cell Size", "Edge of the cells of the lattice; parts closer than a cell move together"),
]

VOLUMES = [
    ("GLOBAL", "Whole Body", "The displayed mesh keeps its volume, with one scale for the whole body"),
    ("REGIONAL", "By Region", "The displayed mesh keeps its volume, corrected where it changes"),
    ("OFF", "Off", "The volume changes where the body is stretched or squeezed"),
]

SKINS = [
    ("LINEAR", "Linear", "The mesh follows the cells of the lattice linearly"),
    ("SMOOTH", "Smooth", "Fewer creases at the faces of cells; takes longer"),
]

SHAPES = [
    ("MESH", "Mesh", "The surface of the object: a solid if it is closed, a thin shell if it is open"),
    ("PLANE", "Ground", "All below the xy plane of the object is solid, without a border"),
]


def _bounciness(description: str) -> Any:
    """Return the property of the restitution of a body or a collider."""
    return FloatProperty(
        name="Bounciness",
        description=description,
        default=0.0,
        min=0.0,
        max=1.0,
        subtype="FACTOR",
        override=OVERRIDABLE,
    )


def _thickness(description: str) -> Any:
    """Return the property of the thickness of a body or a collider."""
    return FloatProperty(
        name="Thickness",
        description=description,
        default=0.0,
        min=0.0,
        unit="LENGTH",
        precision=3,
        override=OVERRIDABLE,
    )


class SoftBodyAttachment(PropertyGroup):
    """A vertex group that is held or moved."""

    vertex_group: StringProperty(
        name="Vertex Group",
        description="Vertices with a weight of 0.5 or more are held; the cells around them too",
        override=OVERRIDABLE,
    )
    use_weights: BoolProperty(
        name="Soft by Weight",
        description="Hold vertices with weight 1, and pull those below by springs: the less the weight, the softer",
        default=False,
        override=OVERRIDABLE,
    )
    motion: EnumProperty(
        name="Motion", description="How the group moves", items=MOTIONS, default="ANIMATION", override=OVERRIDABLE
    )
    target: PointerProperty(
        name="Object", description="Object that moves the group, such as an empty", type=Object, override=OVERRIDABLE
    )
    bone: StringProperty(
        name="Bone",
        description="Bone of the armature that moves the group; empty: the object does",
        override=OVERRIDABLE,
    )
    use_release: BoolProperty(
        name="Release", description="Let the group go during the animation", default=False, override=OVERRIDABLE
    )
    release_frame: IntProperty(
        name="Release Frame", description="First frame in which the group is free", default=100, override=OVERRIDABLE
    )


class SoftBodySettings(PropertyGroup):
    """The settings of a soft body."""

    enabled: BoolProperty(
        name="Soft Body", description="Simulate the object as a soft body", default=False, override=OVERRIDABLE
    )
    cache: StringProperty(
        name="Cache", description="Name of the file of the bake", options={"HIDDEN"}, override=OVERRIDABLE
    )

    resolution: EnumProperty(
        name="Resolution", description="Detail of the simulation", items=RESOLUTIONS, override=OVERRIDABLE
    )
    lattice_vertices: IntProperty(
        name="Lattice Vertices",
        description="Number of simulated vertices; more take longer and separate finer parts",
        default=1000,
        min=8,
        soft_max=100_000,
        override=OVERRIDABLE,
    )
    cell_size: FloatProperty(
        name="Cell Size",
        description="Edge of the cells of the lattice",
        default=0.1,
        min=1e-6,
        unit="LENGTH",
        precision=3,
        override=OVERRIDABLE,
    )
    join: BoolProperty(
        name="Join Loose Parts",
        description="Parts of the mesh that are not connected, such as eyes, move along with the nearest part",
        default=True,
        override=OVERRIDABLE,
    )

    material: EnumProperty(
        name="Material",
        description="Stiffness and damping of the body",
        items=MATERIALS,
        default="FLESH",
        override=OVERRIDABLE,
    )
    youngs_modulus: FloatProperty(
        name="Young's Modulus",
        description="Stiffness in pascal",
        default=1e5,
        min=1e-3,
        soft_min=100,
        soft_max=1e9,
        override=OVERRIDABLE,
    )
    poisson_ratio: FloatProperty(
        name="Poisson's Ratio",
        description="By how much the body narrows when it is stretched: 0 keeps its width, 0.45 nearly its volume. "
        "Other materials have their own",
        default=0.0,
        min=0.0,
        max=0.47,
        override=OVERRIDABLE,
    )
    accuracy: EnumProperty(
        name="Accuracy",
        description="How closely the body follows the material: the more exact, the more steps",
        items=ACCURACIES,
        default="BALANCED",
        override=OVERRIDABLE,
    )
    density: FloatProperty(
        name="Density",
        description="Mass per volume in kg/m³; water has 1000",
        default=1000.0,
        min=1e-6,
        soft_max=20_000,
        override=OVERRIDABLE,
    )
    use_damping_ratio: BoolProperty(
        name="Damping",
        description="Set the damping, in place of that of the material",
        default=False,
        override=OVERRIDABLE,
    )
    damping_ratio: FloatProperty(
        name="Damping Ratio",
        description="Of the slowest wobble: 0 wobbles on, 1 returns to the shape without wobbling",
        default=0.2,
        min=0.0,
        max=1.0,
        subtype="FACTOR",
        override=OVERRIDABLE,
    )
    stiffness_group: StringProperty(
        name="Stiffness Group",
        description="Vertex group of parts with another stiffness; empty: the same everywhere",
        override=OVERRIDABLE,
    )
    stiffness_factor: FloatProperty(
        name="Factor",
        description="Factor of the stiffness at weight 1: below 1 is softer, above 1 is stiffer. At weight 0 it is 1",
        default=10.0,
        min=0.001,
        max=100.0,
        override=OVERRIDABLE,
    )

    inflate: FloatProperty(
        name="Inflate",
        description="Ratio of the volume at rest to that of the mesh: the body grows above 1 and shrinks below it. Can "
        "be animated",
        default=1.0,
        min=0.1,
        max=10.0,
        override=OVERRIDABLE,
    )
    inflation_group: StringProperty(
        name="Inflation Group",
        description="Vertex group of parts that grow or shrink beside the body, such as a muscle; empty: none",
        override=OVERRIDABLE,
    )
    inflation_ratio: FloatProperty(
        name="Ratio",
        description="Ratio of the volume at rest at weight 1, times that of the body. At weight 0 it is 1. Can be "
        "animated",
        default=1.0,
        min=0.1,
        max=10.0,
        override=OVERRIDABLE,
    )

    friction: FloatProperty(
        name="Friction",
        description="At other soft bodies; at a collider that of the collider counts",
        default=0.5,
        min=0.0,
        override=OVERRIDABLE,
    )
    restitution: _bounciness("Speed after an impact on another soft body, over the speed before")
    thickness: _thickness("Distance outside of the surface at which the body touches, at most half of its longest side")
    ignore: PointerProperty(
        name="Ignore",
        description="Soft bodies of this collection pass through the body, such as eyes in a head",
        type=Collection,
        override=OVERRIDABLE,
    )
    self_contact: BoolProperty(
        name="Self Contact",
        description="Folds of the body do not pass through each other",
        default=False,
        override=OVERRIDABLE,
    )

    volume: EnumProperty(
        name="Keep Volume", description="Volume of the displayed mesh", items=VOLUMES, override=OVERRIDABLE
    )
    skin: EnumProperty(name="Skin", description="How the mesh follows the lattice", items=SKINS, override=OVERRIDABLE)

    attachments: CollectionProperty(type=SoftBodyAttachment, override=ITEMS)
    active_attachment: IntProperty(
        name="Attachment", description="Attachment whose settings are shown", override=OVERRIDABLE
    )


class SoftBodyCollider(PropertyGroup):
    """The settings of an object with which soft bodies collide."""

    shape: EnumProperty(name="Shape", description="The solid part of the object", items=SHAPES, override=OVERRIDABLE)
    friction: FloatProperty(
        name="Friction", description="At 0 bodies slide without friction", default=0.5, min=0.0, override=OVERRIDABLE
    )
    restitution: _bounciness(
        "Speed of the surface after an impact, over the speed before; elastic bodies bounce anyway"
    )
    thickness: _thickness("Distance outside of the surface at which bodies touch the object")


class SoftBodyScene(PropertyGroup):
    """The settings of all soft bodies of a scene."""

    contact: BoolProperty(name="Bodies Collide", description="Soft bodies touch each other", default=True)
    use_substeps: BoolProperty(
        name="Set Steps",
        description="Set the steps per frame, in place of as many as the materials need",
        default=False,
    )
    substeps: IntProperty(
        name="Steps per Frame", description="With too few steps bodies are softer", default=10, min=1, max=1000
    )
    directory: StringProperty(
        name="Cache Folder",
        description="Folder of the bakes; empty: a folder beside the blend file",
        subtype="DIR_PATH",
    )


CLASSES = (SoftBodyAttachment, SoftBodySettings, SoftBodyCollider, SoftBodyScene)


def register() -> None:
    """Add the settings to objects and scenes."""
    for found in CLASSES:
        bpy.utils.register_class(found)
    Object.supple = PointerProperty(type=SoftBodySettings, override=OVERRIDABLE)
    Object.supple_collider = PointerProperty(type=SoftBodyCollider, override=OVERRIDABLE)
    Scene.supple = PointerProperty(type=SoftBodyScene)


def unregister() -> None:
    """Remove the settings."""
    del Scene.supple, Object.supple_collider, Object.supple
    for found in reversed(CLASSES):
        bpy.utils.unregister_class(found)
