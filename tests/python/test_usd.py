"""USD stages, read by the library of the format: points, topology, texture coordinates, groups, materials, time."""

from __future__ import annotations

import os
import shutil
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import supple
from conftest import ROOT
from shapes import BAR

pytest.importorskip("pxr", reason="usd-core is not installed")
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, UsdUtils, UsdValidation, Vt

#: A cube with texture coordinates, hard normals, two materials, and a face without a material.
MODEL = """
mtllib odd.mtl
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
v 0 0 1
v 1 0 1
v 1 1 1
v 0 1 1
vt 0 0
vt 0.5 0
vt 0.5 1
vt 0 1
vn 0 0 -1
vn 0 0 1
vn 0 -1 0
vn 0 1 0
vn -1 0 0
vn 1 0 0
o Cube
f 2/1/6 3/2/6 7//6 6/4/6
g bottom all
usemtl red paint
f 1/1/1 4/4/1 3/3/1 2/2/1
g top all
usemtl 2nd
f 5/1/2 6/2/2 7/3/2 8/4/2
f 1/1/3 2/2/3 6/3/3
f 1/1/3 6/3/3 5/4/3
f 3/1/4 4/2/4 8/3/4 7/4/4
f 1/1/5 5/2/5 8/3/5 4/4/5
"""

LIBRARY = "newmtl red paint\nKd 1 0.25 0\nd 0.5\nnewmtl 2nd\nmap_Kd textures/a b.png\n"

SCENE = """
[simulation]
frames = 6
fps = 25
substeps = 8

[output]
format = ["ply", "usd"]

[[body]]
name = "soft.1"
mesh = "odd.obj"
lattice_vertices = 200
translate = [0, 1.05, 0]

[[body]]
name = "Materials"
mesh = "plain.obj"
lattice_vertices = 200
translate = [3, 1, 0]

[[collider]]
plane = { point = [0, 1, 0], normal = [0, 1, 0] }

[[collider]]
sphere = { center = [0, 0, 5], radius = 0.5 }
keys = [ { time = 0 }, { time = 0.24, translate = [1, 0, 0], rotate = [0, 90, 0] } ]

[[collider]]
box = { center = [9, 1, 0], half_extents = [1, 2, 3], rotate = [0, 0, 90] }

[[collider]]
capsule = { a = [9, 0, 9], b = [11, 0, 9], radius = 0.25 }

[[collider]]
mesh = "plain.obj"
scale = 2
translate = [0, -5, 0]
"""

#: The first body turns.
SPIN = {"body.0.spin": [0, 0, 9]}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with the scene and its files."""
    (tmp_path / "odd.obj").write_text(MODEL)
    (tmp_path / "odd.mtl").write_text(LIBRARY)
    plain = [line for line in MODEL.splitlines() if line.split()[:1] == ["v"]]
    faces = [line.split()[1:] for line in MODEL.splitlines() if line.startswith("f")]
    plain += ["f " + " ".join(corner.split("/")[0] for corner in face) for face in faces]
    (tmp_path / "plain.obj").write_text("\n".join(plain) + "\n")
    (tmp_path / "scene.toml").write_text(SCENE)
    (tmp_path / "textures").mkdir()
    shutil.copy(ROOT / "docs" / "images" / "page.png", tmp_path / "textures" / "a b.png")
    return tmp_path


def run(folder: Path, name: str = "out", **options: Any) -> Usd.Stage:
    """Run the scene and open its stage."""
    supple.run(folder / "scene.toml", folder / name, **options)
    return Usd.Stage.Open(str(folder / name / "supple.usd"))


def mesh(stage: Usd.Stage, name: str) -> UsdGeom.Mesh:
    found = UsdGeom.Mesh(stage.GetPrimAtPath(f"/World/{name}"))
    assert found
    return found


def ply_points(path: Path) -> np.ndarray[Any, np.dtype[np.float32]]:
    data = path.read_bytes()
    head, _, body = data.partition(b"end_header\n")
    count = int(next(line.split()[2] for line in head.decode().splitlines() if line.startswith("element vertex")))
    return np.frombuffer(body, "<f4", 6 * count).reshape(-1, 6)[:, :3]


def problems(stage: Usd.Stage) -> list[str]:
    """Return what the validators of the installed library say about a stage."""
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    errors = UsdValidation.ValidationContext(validators).Validate(stage)
    found = [f"{error.GetName()}: {error.GetMessage()}" for error in errors]
    if hasattr(UsdUtils, "ComplianceChecker"):  # up to 26.3; its rules are validators
        checker = UsdUtils.ComplianceChecker(skipARKitRootLayerCheck=True)
        checker.CheckCompliance(stage.GetRootLayer().identifier)
        found += checker.GetErrors() + checker.GetFailedChecks() + checker.GetWarnings()
    return found


def test_points_have_the_bits_of_the_frames_and_lie_in_their_extents(folder):
    stage = run(folder, start_frame=1001, every=2)
    for name, prim in [("soft.1", "soft_1"), ("Materials", "Materials")]:
        points, extent = mesh(stage, prim).GetPointsAttr(), mesh(stage, prim).GetExtentAttr()
        assert points.GetTimeSamples() == extent.GetTimeSamples() == [1001, 1003, 1005, 1007]
        for frame in points.GetTimeSamples():
            expected = ply_points(folder / "out" / f"{name}_{int(frame)}.ply")
            found = np.array(points.Get(frame), np.float32)
            assert found.tobytes() == expected.tobytes()
            assert np.array_equal(extent.Get(frame), [expected.min(axis=0), expected.max(axis=0)])
        # A program that asks for no time gets the first frame.
        assert points.Get() == points.Get(1001) != points.Get(1007)
        assert extent.Get() == extent.Get(1001)


def test_the_stage_states_its_axes_units_and_time(folder):
    stage = run(folder, start_frame=10)
    assert UsdGeom.GetStageUpAxis(stage) == "Y"
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1
    assert stage.GetTimeCodesPerSecond() == stage.GetFramesPerSecond() == 25
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (10, 16)
    assert stage.GetDefaultPrim().GetPath() == "/World"
    assert Usd.ModelAPI(stage.GetDefaultPrim()).GetKind() == "component"
    overrides = {"output.up": "z", "output.scale": 100, "output.fps": 24, "output.meters_per_unit": 0.01}
    turned = run(folder, "turned", overrides=overrides)
    assert UsdGeom.GetStageUpAxis(turned) == "Z"
    assert UsdGeom.GetStageMetersPerUnit(turned) == 0.01
    assert turned.GetTimeCodesPerSecond() == 24
    for frame in range(7):
        before = np.array(mesh(stage, "soft_1").GetPointsAttr().Get(10 + frame), float)
        after = np.array(mesh(turned, "soft_1").GetPointsAttr().Get(frame))
        expected = 100 * np.stack([before[:, 0], -before[:, 2], before[:, 1]], axis=1)
        assert np.array_equal(after, expected.astype(np.float32))


def test_topology_texture_coordinates_and_normals_are_those_of_the_file(folder):
    stage = run(folder, overrides=SPIN)
    soft, plain = mesh(stage, "soft_1"), mesh(stage, "Materials")
    for body in (soft, plain):
        assert list(body.GetFaceVertexCountsAttr().Get()) == [4, 4, 4, 3, 3, 4, 4]
        corners = [1, 2, 6, 5, 0, 3, 2, 1, 4, 5, 6, 7, 0, 1, 5, 0, 5, 4, 2, 3, 7, 6, 0, 4, 7, 3]
        assert list(body.GetFaceVertexIndicesAttr().Get()) == corners
        assert body.GetSubdivisionSchemeAttr().Get() == "none"
        assert body.GetDoubleSidedAttr().Get() is False
    coordinates = UsdGeom.PrimvarsAPI(soft).GetPrimvar("st")
    assert (coordinates.GetInterpolation(), coordinates.GetTypeName()) == ("faceVarying", "texCoord2f[]")
    a, b, c, d = (0, 0), (0.5, 0), (0.5, 1), (0, 1)
    flattened = [tuple(pair) for pair in coordinates.ComputeFlattened()]
    # The third corner of the first face has no vt.
    assert flattened == [a, b, (0, 0), d, a, d, c, b, a, b, c, d, a, b, c, a, c, d] + 2 * [a, b, c, d]
    normals = UsdGeom.PrimvarsAPI(soft).GetPrimvar("normals")
    assert normals.GetInterpolation() == "faceVarying"
    x, y, z = np.eye(3)
    by_face = [x, -z, z, -y, -y, y, -x]
    expected = np.repeat(by_face, [4, 4, 4, 3, 3, 4, 4], axis=0)
    assert np.array_equal(normals.ComputeFlattened(0), expected)
    last = np.array(normals.ComputeFlattened(6))
    assert np.abs(np.linalg.norm(last, axis=1) - 1).max() < 1e-6
    assert np.abs(last - expected).max() > 0.1, "they follow the surface"
    assert not UsdGeom.PrimvarsAPI(plain).HasPrimvar("st")
    assert not UsdGeom.PrimvarsAPI(plain).HasPrimvar("normals")
    assert not plain.GetNormalsAttr().HasAuthoredValue()


def test_smooth_normals_are_those_of_the_vertices(folder):
    normals = MODEL.splitlines()
    faces = [line.split()[1:] for line in normals if line.startswith("f")]
    smooth = [line for line in normals if line.split()[:1] == ["v"]]
    smooth += ["vn {} {} {}".format(*[2 * int(word) - 1 for word in line.split()[1:]]) for line in smooth]
    smooth += ["f " + " ".join(f"{corner.split('/')[0]}//{corner.split('/')[0]}" for corner in face) for face in faces]
    (folder / "odd.obj").write_text("\n".join(smooth))
    stage = run(folder, overrides=SPIN)
    soft = mesh(stage, "soft_1")
    assert soft.GetNormalsInterpolation() == "vertex"
    corners = np.array([[x, y, z] for z in (-1, 1) for x, y in [(-1, -1), (1, -1), (1, 1), (-1, 1)]])
    assert np.abs(np.array(soft.GetNormalsAttr().Get(0)) - corners / 3**0.5).max() < 1e-6
    last = np.array(soft.GetNormalsAttr().Get(6))
    assert np.abs(np.linalg.norm(last, axis=1) - 1).max() < 1e-6
    assert np.abs(last - corners / 3**0.5).max() > 0.1


def test_groups_and_materials_are_subsets(folder):
    stage = run(folder)
    soft = mesh(stage, "soft_1")
    families = {name: list(UsdGeom.Subset.GetGeomSubsets(soft, "face", name)) for name in ("materialBind", "group")}
    faces = {
        family: {subset.GetPrim().GetName(): list(subset.GetIndicesAttr().Get()) for subset in subsets}
        for family, subsets in families.items()
    }
    assert faces == {
        "materialBind": {"red_paint": [1], "_2nd": [2, 3, 4, 5, 6]},
        "group": {"bottom": [1], "all": [1, 2, 3, 4, 5, 6], "top": [2, 3, 4, 5, 6]},
    }
    assert UsdGeom.Subset.GetFamilyType(soft, "materialBind") == "nonOverlapping"
    assert UsdGeom.Subset.GetFamilyType(soft, "group") == "unrestricted"
    assert families["materialBind"][0].GetPrim().GetDisplayName() == "red paint"
    red, second = (
        UsdShade.MaterialBindingAPI(subset.GetPrim()).ComputeBoundMaterial()[0] for subset in families["materialBind"]
    )
    # A body has the name Materials, so the scope gets another one.
    assert str(red.GetPath()) == "/World/Materials_2/red_paint"
    surface = red.ComputeSurfaceSource()[0]
    assert surface.GetIdAttr().Get() == "UsdPreviewSurface"
    assert surface.GetInput("diffuseColor").Get() == Gf.Vec3f(1, 0.25, 0)
    assert surface.GetInput("opacity").Get() == 0.5
    texture = second.ComputeSurfaceSource()[0].GetInput("diffuseColor").GetConnectedSource()[0]
    image = UsdShade.Shader(texture.GetPrim()).GetInput("file").Get()
    assert image.path == "../textures/a b.png"
    assert os.path.samefile(image.resolvedPath, folder / "textures" / "a b.png")
    assert not UsdShade.MaterialBindingAPI(soft.GetPrim()).GetDirectBinding().GetMaterial()


def test_one_material_is_bound_to_the_body(folder):
    lines = [line for line in MODEL.splitlines() if not line.startswith(("usemtl", "g "))]
    (folder / "odd.obj").write_text("usemtl unknown\n" + "\n".join(lines))
    stage = run(folder)
    material = UsdShade.MaterialBindingAPI(mesh(stage, "soft_1").GetPrim()).ComputeBoundMaterial()[0]
    assert material.GetPrim().GetName() == "unknown"
    assert not UsdGeom.Subset.GetAllGeomSubsets(mesh(stage, "soft_1"))
    assert problems(stage) == []


def test_colliders_are_guides_where_the_scene_puts_them(folder):
    stage = run(folder)
    prims = {prim.GetName(): prim for prim in stage.GetPrimAtPath("/World/Colliders").GetChildren()}
    types = {name: prim.GetTypeName() for name, prim in prims.items()}
    assert types == {"plane": "Mesh", "sphere": "Sphere", "box": "Cube", "capsule": "Capsule", "mesh": "Mesh"}
    assert all(UsdGeom.Imageable(prim).ComputePurpose() == "guide" for prim in prims.values())

    def bounds(name: str, frame: float = 0) -> np.ndarray[Any, np.dtype[np.float64]]:
        cache = UsdGeom.BBoxCache(frame, ["guide"], useExtentsHint=False)
        found = cache.ComputeWorldBound(prims[name]).ComputeAlignedRange()
        return np.array([found.GetMin(), found.GetMax()])

    assert np.allclose(bounds("box"), [[7, 0, -3], [11, 2, 3]])
    assert np.allclose(bounds("capsule"), [[8.75, -0.25, 8.75], [11.25, 0.25, 9.25]])
    assert np.allclose(bounds("mesh"), [[0, -5, 0], [2, -3, 2]])
    low, high = bounds("plane")
    assert np.allclose([low[1], high[1]], 1)
    assert (low[[0, 2]] < [0, 0]).all()
    assert (high[[0, 2]] > [4, 1]).all()
    # The ball moves; the others have one transformation.
    samples = {name: UsdGeom.Xformable(prim).GetTimeSamples() for name, prim in prims.items()}
    assert samples.pop("sphere") == list(range(7))
    assert not any(samples.values())
    turned = UsdGeom.Xformable(prims["sphere"]).ComputeLocalToWorldTransform(3)
    assert Gf.IsClose(turned.ExtractTranslation(), Gf.Vec3d(0.5, 0, 5), 1e-12)
    assert Gf.IsClose(turned.TransformDir((0, 0, 1)), Gf.Vec3d(0.5**0.5, 0, 0.5**0.5), 1e-12)


def test_animated_colliders_have_points_in_every_frame(folder):
    points = np.array([line.split()[1:] for line in (folder / "plain.obj").read_text().splitlines()[:8]], "<f4")
    frames = [points + [0, 0, k] for k in range(7)]
    head = b"POINTCACHE2\0" + np.array([1, 8], "<i4").tobytes() + np.array([0, 1], "<f4").tobytes()
    data = head + np.array([7], "<i4").tobytes() + np.array(frames, "<f4").tobytes()
    (folder / "walk.pc2").write_bytes(data)
    with (folder / "scene.toml").open("a") as scene:
        scene.write('animation = "walk.pc2"\n')
    stage = run(folder)
    found = UsdGeom.Mesh(stage.GetPrimAtPath("/World/Colliders/mesh"))
    assert [np.array(found.GetPointsAttr().Get(k)).tolist() for k in range(7)] == [frame.tolist() for frame in frames]
    assert np.array_equal(found.GetExtentAttr().Get(6), [frames[6].min(axis=0), frames[6].max(axis=0)])
    assert problems(stage) == []


def test_disabled_colliders_are_invisible_and_keep_their_place(folder):
    out_and_in = [{"time": 0.08, "value": False}, {"time": 0.16, "value": True}]
    late = [{"time": 0.04, "value": True}]
    overrides = {"collider.1.enabled": out_and_in, "collider.2.enabled": late, "collider.3.enabled": False}
    stage = run(folder, overrides=overrides)
    prims = {prim.GetName(): UsdGeom.Imageable(prim) for prim in stage.GetPrimAtPath("/World/Colliders").GetChildren()}
    # The capsule is never enabled.
    assert list(prims) == ["plane", "sphere", "box", "mesh"]

    def visible(name: str) -> list[bool]:
        return [prims[name].ComputeVisibility(frame) != "invisible" for frame in range(7)]

    assert visible("sphere") == [True, True, False, False, True, True, True]
    assert visible("box") == [False] + 6 * [True]
    assert prims["box"].GetVisibilityAttr().Get() == "invisible", "without a time, the stage is at its first frame"
    assert prims["sphere"].GetVisibilityAttr().Get() == "inherited"
    assert visible("plane") == visible("mesh") == 7 * [True]
    assert not any(prims[name].GetVisibilityAttr().HasAuthoredValue() for name in ("plane", "mesh"))
    places = [UsdGeom.Xformable(prims["sphere"]).ComputeLocalToWorldTransform(frame) for frame in range(7)]
    assert np.allclose([place.ExtractTranslation()[0] for place in places], np.array([0, 1, 1, 1, 4, 5, 6]) / 6)
    assert not UsdGeom.Xformable(prims["box"]).GetTimeSamples()
    assert problems(stage) == []


def test_validators_find_no_problem_and_do_find_one_in_a_broken_stage(folder):
    stage = run(folder)
    assert problems(stage) == []
    assert problems(run(folder, "turned", overrides={"output.up": "z", "output.scale": 100})) == []
    # A copy of the stage in text has the same values; each of three faults is found.
    for fault in ("axis", "binding", "subset"):
        path = folder / f"{fault}.usda"
        stage.GetRootLayer().Export(str(path))
        broken = Usd.Stage.Open(str(path))
        assert [text for text in problems(broken) if "a b.png" not in text] == []
        subset = broken.GetPrimAtPath("/World/soft_1/red_paint")
        match fault:
            case "axis":
                broken.GetRootLayer().pseudoRoot.ClearInfo("upAxis")
            case "binding":
                subset.RemoveAPI(UsdShade.MaterialBindingAPI)
            case "subset":
                UsdGeom.Subset(subset).GetIndicesAttr().Set(Vt.IntArray([1, 2]))
        broken.GetRootLayer().Save()
        assert [text for text in problems(broken) if "a b.png" not in text] != [], fault


def test_the_library_writes_the_same_values_again(folder):
    # The text of a layer has all its values; it is read and written by the library alone.
    stage = run(folder)
    layer = stage.GetRootLayer()
    assert layer.Export(str(folder / "again.usd"))
    again = Sdf.Layer.FindOrOpen(str(folder / "again.usd"))
    assert again.ExportToString() == layer.ExportToString()


def test_a_recorder_writes_the_frames_of_a_run(folder):
    stage = run(folder)
    overrides = {"simulation.frames": 6}
    for name in ("save.usd", "mine.usd"):
        sim = supple.load_scene(folder / "scene.toml", overrides=overrides)
        if name == "save.usd":
            supple.save_usd(sim, folder / name, 6)
        else:
            with supple.Recorder(sim, folder / name) as recorder:
                for frame in range(7):
                    sim.advance(min(frame, 1))
                    recorder.record()
                    assert recorder.frames == frame + 1
            assert recorder.frames is None
            with pytest.raises(ValueError, match="has ended; start another Recorder"):
                recorder.record()
        mine = Usd.Stage.Open(str(folder / name))
        for prim in ("soft_1", "Materials"):
            for frame in range(7):
                a, b = (mesh(each, prim).GetPointsAttr().Get(frame) for each in (stage, mine))
                assert np.array(a).tobytes() == np.array(b).tobytes()
        assert problems(mine) == []
    sim = supple.load_scene(folder / "scene.toml")
    supple.save_html(sim, folder / "mine.html", 3, up="z")
    assert (folder / "mine.html").read_text().startswith("<!doctype html>")


def test_a_recorded_stage_has_the_faces_of_each_frame_of_a_body_that_is_cut(folder):
    sim = supple.load_scene(folder / "scene.toml")
    body = sim.bodies[0]
    whole, center = sim.save_state(), body.center_of_mass
    expected = []
    with supple.Recorder(sim, folder / "mine.usd") as recorder:
        # Whole, cut, cut in another way with the same number of events, whole.
        for normal in (None, (1, 0.2, 0), (0.2, 0, 1), None):
            sim.restore_state(whole)
            if normal:
                body.cut(supple.Plane(center, normal))
            recorder.record()
            expected.append((body.topology_version, body.surface(), body.faces))
    assert [version for version, _, _ in expected] == [0, 1, 1, 0]
    mine = Usd.Stage.Open(str(folder / "mine.usd"))
    assert problems(mine) == []
    (prim,) = (prim for prim in mine.Traverse() if prim.IsA(UsdGeom.Mesh) and prim.GetDisplayName() == body.name)
    for frame, (_, surface, faces) in enumerate(expected):
        shown = UsdGeom.Mesh(prim)
        points = np.array(shown.GetPointsAttr().Get(frame))
        counts = np.array(shown.GetFaceVertexCountsAttr().Get(frame))
        corners = np.array(shown.GetFaceVertexIndicesAttr().Get(frame))
        assert points.tobytes() == surface.astype(np.float32).tobytes()
        assert counts.sum() == len(corners)
        # The triangles of a polygon have its corners.
        assert (counts - 2).sum() == len(faces)
        assert set(corners) == set(faces.ravel())


def test_a_frame_and_its_velocities_give_the_points_between_frames(folder):
    # The body spins in the air.
    air = {"body.0.volume": "off", "body.0.translate": [0, 4, 0], "simulation.gravity": [0, 0, 0], "output.scale": 10}
    stage = run(folder, overrides=SPIN | air | {"output.usd_velocities": True}, format="usd")
    assert problems(stage) == []
    twice = {"simulation.fps": 50, "simulation.substeps": 4, "simulation.frames": 12}
    fine = run(folder, "fine", overrides=SPIN | air | twice, format="usd")
    for frame in range(6):
        between = mesh(stage, "soft_1").ComputePointsAtTime(Usd.TimeCode(frame + 0.5), Usd.TimeCode(frame))
        expected = np.array(mesh(fine, "soft_1").GetPointsAttr().Get(2 * frame + 1))
        error = np.linalg.norm(np.array(between) - expected, axis=1).max()
        # Half of the acceleration spin² x radius in 0.02 s, and as much again for the elastic motion, a choice.
        assert error < 10 * 0.5 * 0.02**2 * 2 * 9 * 9 * 0.9
        points = np.array(mesh(stage, "soft_1").GetPointsAttr().Get(frame))
        assert error < 0.25 * np.linalg.norm(points - expected, axis=1).max()
    assert not mesh(fine, "soft_1").GetVelocitiesAttr().HasAuthoredValue()


def test_a_package_has_the_stage_and_its_images(folder):
    report = supple.run(folder / "scene.toml", folder / "out", format=["usd", "usdz"])
    assert report.written == 7
    path = str(folder / "out" / "supple.usdz")
    with zipfile.ZipFile(path) as archive:
        assert archive.namelist() == ["stage.usdc", "images/a_b.png"]
        assert archive.testzip() is None
        assert archive.read("images/a_b.png") == (folder / "textures" / "a b.png").read_bytes()
    stage, package = Usd.Stage.Open(str(folder / "out" / "supple.usd")), Usd.Stage.Open(path)
    assert problems(package) == []
    for prim in ("soft_1", "Materials"):
        for frame in range(7):
            points = [mesh(found, prim).GetPointsAttr().Get(frame) for found in (stage, package)]
            assert points[0] == points[1]
    (image,) = (prim for prim in package.Traverse() if prim.GetName() == "Image")
    file = UsdShade.Shader(image).GetInput("file").Get()
    assert file.resolvedPath == f"{path}[images/a_b.png]"


def test_a_recording_is_a_package(folder):
    sim = supple.load_scene(folder / "scene.toml")
    supple.save_usd(sim, folder / "mine.usdz", 2)
    package = Usd.Stage.Open(str(folder / "mine.usdz"))
    assert problems(package) == []
    assert package.GetEndTimeCode() == 2
    assert not (folder / "mine.usdz.usd.part").exists()


def test_a_recorded_stage_of_a_broken_body_has_a_velocity_per_point(folder):
    sim = supple.load_scene(folder / "scene.toml")
    body = sim.bodies[0]
    with supple.Recorder(sim, folder / "mine.usd", usd_velocities=True, scale=2) as recorder:
        recorder.record()
        body.cut(supple.Plane(body.center_of_mass, (1, 0.2, 0)))
        expected = []
        for _ in range(2):
            sim.advance()
            recorder.record()
            expected.append(body.surface_velocities())
    mine = Usd.Stage.Open(str(folder / "mine.usd"))
    assert problems(mine) == []
    (prim,) = (prim for prim in mine.Traverse() if prim.IsA(UsdGeom.Mesh) and prim.GetDisplayName() == body.name)
    for frame, velocities in enumerate(expected, 1):
        found = np.array(UsdGeom.Mesh(prim).GetVelocitiesAttr().Get(frame))
        assert len(found) > 8
        np.testing.assert_allclose(found, 2 * velocities, rtol=1e-6, atol=1e-6)


def test_a_recorder_keeps_its_frames_after_an_exception(folder):
    sim = supple.load_scene(folder / "scene.toml")

    def fail():
        with supple.Recorder(sim, folder / "mine.usd") as recorder:
            recorder.record()
            raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        fail()
    assert Usd.Stage.Open(str(folder / "mine.usd")).GetEndTimeCode() == 0


def test_wrong_arguments_of_a_recorder_are_errors(folder, block):
    sim = supple.load_scene(folder / "scene.toml")
    for options, words in [
        ({"path": folder / "a.obj"}, r"ends in \.usd, \.usdz, \.html, \.glb, \.webp or \.gif"),
        ({"up": "x"}, 'up is "x"'),
        ({"scale": 0}, "scale = 0 is out of range: it must be a number above 0"),
        ({"fps": float("nan")}, "fps = NaN is out of range"),
        ({"meters_per_unit": -1}, "meters_per_unit = -1 is out of range"),
    ]:
        with pytest.raises(ValueError, match=words):
            supple.Recorder(sim, **({"path": folder / "a.usd"} | options))
    with pytest.raises(ValueError, match="is a bare lattice"):
        supple.Recorder(supple.Simulation([supple.Body(block)]), folder / "a.usd")
    with pytest.raises(supple.OutputError, match="cannot write"):
        supple.Recorder(sim, folder / "none" / "a.usd")
    with pytest.raises(TypeError):
        supple.Recorder(None, folder / "a.usd")
    with pytest.raises(ValueError, match=r"it must end in \.usd"):
        supple.save_usd(sim, folder / "a.html", 3)
    stepped = supple.Simulation([supple.Body(supple.read_obj(folder / "plain.obj"), lattice_vertices=100)], dt=0.01)
    with pytest.raises(ValueError, match="fps"):
        supple.save_usd(stepped, folder / "a.usd", 3)
    assert not (folder / "a.usd").exists()


#: A bar of 12 x 4 x 4 is pulled apart.
PULL = """
[simulation]
frames = 32
substeps = 4
gravity = [0, 0, 0]

[output]
format = ["obj", "usd"]

[[body]]
name = "bar"
mesh = "bar.obj"
cell_size = 0.8
half_width = 1
fracture = { strain = 0.1 }

[[body.pin]]
box = { min = [-1, -1, -1], max = [0.5, 5, 5] }

[[body.handle]]
box = { min = [11.5, -1, -1], max = [13, 5, 5] }
keys = [ { time = 0 }, { time = 1, translate = [5, 0, 0] } ]
"""


def bar_text(is_textured: bool = True) -> str:
    """Return a bar whose halves have different materials. Its upper side is a group."""
    lines = ["mtllib bar.mtl", *(f"v {x} {y} {z}" for x, y, z in BAR.vertices)]
    faces = []
    for face in BAR.faces:
        corners = BAR.vertices[list(face)]
        axis = int(np.ptp(corners, axis=0).argmin())
        normal = 2 * axis + 1 + int(corners[0, axis] > 0)
        group = "top" if (corners[:, 1] == 4).all() else "rest"
        material = "wood" if corners[:, 0].mean() < 6 else "steel"
        first = 3 * len(faces) + 1  # the faces are triangles
        uvs = np.delete(corners, axis, axis=1) / 12
        words = [f"{v + 1}/{first + k}/{normal}" if is_textured else f"{v + 1}" for k, v in enumerate(face)]
        faces.append((group, material, " ".join(["f", *words]), [f"vt {u} {v}" for u, v in uvs]))
    if is_textured:
        lines += [line for *_, uvs in faces for line in uvs]
        lines += [f"vn {' '.join(str(side * x) for x in axis)}" for axis in np.eye(3, dtype=int) for side in (-1, 1)]
    for group, material, face, _ in sorted(faces):
        lines += [f"g {group}", f"usemtl {material}", face]
    return "\n".join(lines) + "\n"


def obj_faces(text: str) -> dict[tuple[int, ...], tuple[Any, ...]]:
    """Return the texture coordinates, normals, material and group of each face of an OBJ file, by its corners."""
    numbers: dict[str, list[list[float]]] = {"v": [], "vt": [], "vn": []}
    state, faces = {"g": "", "usemtl": ""}, []
    for line in text.splitlines():
        keyword, *words = line.split() or [""]
        if keyword in numbers:
            numbers[keyword].append([float(word) for word in words])
        elif keyword in state:
            state[keyword] = words[0]
        elif keyword == "f":
            faces.append((np.array([word.split("/") for word in words], int) - 1, state["usemtl"], state["g"]))
    vt, vn = np.array(numbers["vt"]), np.array(numbers["vn"])
    found = {}
    for corners, material, group in faces:
        found[tuple(corners[:, 0])] = (vt[corners[:, 1]], vn[corners[:, 2]], material, group)
    assert len(found) == len(faces)
    return found


def stage_faces(prim: UsdGeom.Mesh, frame: int) -> dict[tuple[int, ...], tuple[Any, ...]]:
    """Return the same of a stage."""
    counts = np.array(prim.GetFaceVertexCountsAttr().Get(frame))
    corners = np.array(prim.GetFaceVertexIndicesAttr().Get(frame))
    primvars = UsdGeom.PrimvarsAPI(prim)
    st, normals = (np.array(primvars.GetPrimvar(name).ComputeFlattened(frame)) for name in ("st", "normals"))
    assert len(st) == len(normals) == len(corners) == counts.sum()
    names = {}
    for family in ("materialBind", "group"):
        names[family] = np.full(len(counts), "", object)
        for subset in UsdGeom.Subset.GetGeomSubsets(prim, "face", family):
            names[family][list(subset.GetIndicesAttr().Get(frame))] = subset.GetPrim().GetName()
    ends = np.cumsum(counts)
    rows = [slice(end - count, end) for end, count in zip(ends, counts, strict=True)]
    data = zip(rows, names["materialBind"], names["group"], strict=True)
    return {tuple(corners[row]): (st[row], normals[row], material, group) for row, material, group in data}


def test_a_broken_stage_has_the_faces_of_the_obj_frames(tmp_path):
    (tmp_path / "bar.obj").write_text(bar_text())
    (tmp_path / "bar.mtl").write_text("newmtl wood\nKd 1 0.5 0\nnewmtl bar_cap\nKd 0.25 0.5 0.75\n")
    (tmp_path / "scene.toml").write_text(PULL)
    stage = run(tmp_path)
    assert problems(stage) == []
    prim, versions = mesh(stage, "bar"), set()
    for frame in range(33):
        expected = obj_faces((tmp_path / "out" / f"bar_{frame:04}.obj").read_text())
        found = stage_faces(prim, frame)
        assert sorted(found) == sorted(expected)
        for corners, (st, normals, material, group) in found.items():
            vt, vn, usemtl, g = expected[corners]
            np.testing.assert_allclose(st, vt, atol=1e-6)
            np.testing.assert_allclose(normals, vn, atol=2e-6)
            assert material == usemtl
            # Caps belong to the group of the rim in OBJ files, and to none in stages.
            assert group == g or material == "bar_cap"
        versions.add((len(found), sum(face[2] == "bar_cap" for face in found.values())))
    assert (len(BAR.faces), 0) in versions
    assert max(caps for _, caps in versions) > 20
    caps = next(s for s in UsdGeom.Subset.GetAllGeomSubsets(prim) if s.GetPrim().GetName() == "bar_cap")
    material = UsdShade.MaterialBindingAPI(caps.GetPrim()).ComputeBoundMaterial()[0]
    assert material.GetPrim().GetName() == "bar_cap"
    # The color is that of the library of the input.
    assert material.ComputeSurfaceSource()[0].GetInput("diffuseColor").Get() == Gf.Vec3f(0.25, 0.5, 0.75)


@pytest.mark.parametrize("source", ["scene", "arrays"])
def test_caps_have_texture_coordinates_if_the_input_has_none(tmp_path, source):
    (tmp_path / "bar.obj").write_text(bar_text(is_textured=False))
    (tmp_path / "scene.toml").write_text(PULL)
    if source == "scene":
        stage = run(tmp_path, format="usd")
    else:
        array = supple.Body(BAR, name="bar", cell_size=0.8, half_width=1)
        sim = supple.Simulation([array], fps=30, substeps=4, gravity=(0, 0, 0))
        with supple.Recorder(sim, tmp_path / "out.usd") as recorder:
            recorder.record()
            array.cut(((5.9, 0, 0), (1, 0, 0)))
            recorder.record()
        stage = Usd.Stage.Open(str(tmp_path / "out.usd"))
    assert problems(stage) == []
    prim = mesh(stage, "bar")
    last = stage.GetEndTimeCode()
    counts = np.array(prim.GetFaceVertexCountsAttr().Get(last))
    caps = next(s for s in UsdGeom.Subset.GetAllGeomSubsets(prim) if s.GetPrim().GetName() == "bar_cap")
    is_cap = np.zeros(len(counts), bool)
    is_cap[list(caps.GetIndicesAttr().Get(last))] = True
    is_cap = np.repeat(is_cap, counts)
    coordinates = UsdGeom.PrimvarsAPI(prim).GetPrimvar("st")
    assert coordinates.GetInterpolation() == "faceVarying"
    assert not np.array(coordinates.Get(0)).any()
    assert len(coordinates.Get(0)) == sum(prim.GetFaceVertexCountsAttr().Get(0))
    st = np.array(coordinates.Get(last))
    assert is_cap.any()
    assert not st[~is_cap].any()
    # Lengths in the plane of a section of 4 x 4.
    assert (np.ptp(st[is_cap], axis=0) > 3.5).all()
