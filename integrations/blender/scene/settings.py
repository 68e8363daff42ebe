"""The settings of an object as arguments of supple."""

from __future__ import annotations

from typing import Any

from bpy.types import Object, Scene


def meters_per_unit(scene: Scene) -> float:
    """Return the length of a unit of the scene in meters."""
    units = scene.unit_settings
    return 1.0 if units.system == "NONE" else float(units.scale_length)


def body_options(found: Object, scene: Scene, bodies: list[Object]) -> dict[str, Any]:
    """Return the keyword arguments of supple.Body, in Blender's units of length.

    bodies : list of Object
        All soft bodies of the bake.

    Pascal is kg/(m s^2), so Young's modulus per unit of length has one factor of meters per unit, and density three.
    """
    settings, meters = found.supple, meters_per_unit(scene)
    options: dict[str, Any] = {
        "join": settings.join,
        "density": settings.density * meters**3,
        "friction": settings.friction,
        "restitution": settings.restitution,
        "thickness": settings.thickness,
        "self_contact": settings.self_contact,
        "skin": settings.skin.lower(),
        "volume": {"measure": "auto", "scope": settings.volume.lower()} if settings.volume != "OFF" else "off",
    }
    if settings.ignore is not None:
        others = set(settings.ignore.all_objects) - {found}
        options["ignore"] = [other.name for other in bodies if other in others]
    if settings.resolution == "VERTICES":
        options["lattice_vertices"] = settings.lattice_vertices
    else:
        options["cell_size"] = settings.cell_size
    if settings.material == "CUSTOM":
        options["youngs_modulus"] = settings.youngs_modulus * meters
        options["poisson_ratio"] = settings.poisson_ratio
    else:
        options["material"] = settings.material.lower()
    options["accuracy"] = settings.accuracy.lower()
    if settings.use_damping_ratio:
        options["damping_ratio"] = settings.damping_ratio
    return options
