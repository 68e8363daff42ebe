"""The part of the Blender extension that needs no Blender: vertex groups, rigid motions, colliders, files, cancel."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import supple
from conftest import ROOT
from test_point_cache import read

sys.path.insert(0, str(ROOT / "integrations" / "blender"))
import bake
from bake import is_rigid, transformed

#: 32-bit positions, through a handful of additions and multiplications.
ROUNDING = 1e-6


def placed(rotate: Any = (0, 0, 0), translate: Any = (0, 0, 0), scale: Any = 1.0) -> np.ndarray:
    """Return a matrix (4, 4) that scales, turns by degrees about x, then y, then z, and moves."""
    matrix = np.eye(4)
    matrix[:3, :3] = supple._core.rotation_matrix(rotate) * scale
    matrix[:3, 3] = translate
    return matrix


def still(frames: int) -> np.ndarray:
    """Return the matrices of an object that does not move."""
    return np.repeat(np.eye(4)[None], frames, 0)


@pytest.fixture
def box(tmp_path: Path) -> bake.Body:
    """A cube of edge 1 about the origin with 9 x 9 vertices on each face, for 10 frames."""
    lines = np.linspace(-0.5, 0.5, 9)
    squares = [(i, j) for i in range(8) for j in range(8)]
    vertices, faces = [], []
    for axis in range(3):
        for side in (-0.5, 0.5):
            first = len(vertices)
            for u in lines:
                vertices += [np.roll((side, u, v), axis) for v in lines]
            quads = [
                [first + 9 * i + j for i, j in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))] for i, j in squares
            ]
            faces += quads if side > 0 else [quad[::-1] for quad in quads]
    options = {"lattice_vertices": 300}
    return bake.Body("box", np.array(vertices), faces, still(10), tmp_path / "box.pc2", options)


def job(*bodies: bake.Body, **settings: Any) -> bake.Job:
    """Return a job of 10 frames."""
    return bake.Job(list(bodies), **{"colliders": [], "frames": 10, "fps": 24.0, "gravity": (0, 0, -9.81), **settings})


def test_a_vertex_group_of_weights_holds_vertices_with_1_and_pulls_the_others_softly(box):
    top = np.clip(2 * box.vertices[:, 2], 0, 1)
    box.attachments = [bake.Attachment("top", top)]
    sim = bake.build(job(box, gravity=(0, 0, -2)))
    body = sim.bodies[0]
    (hold,) = body.holds
    weights = body.weights(top)
    assert np.array_equal(hold.vertices, np.flatnonzero(weights >= 0.01))
    sim.advance(9)
    sunk = body.lattice.rest_positions[:, 2] - body.positions[:, 2]
    held = weights > 1 - 1e-6
    assert held.any()
    assert np.abs(sunk[held]).max() < 1e-6
    soft = hold.vertices[weights[hold.vertices] < 0.3]
    assert sunk[soft].min() > 1e-5


def test_a_group_with_another_stiffness_has_the_factor_to_the_power_of_the_weight(box):
    weights = box.vertices[:, 2] + 0.5
    box.stiffness = bake.Stiffness(weights, 10.0)
    body = bake.build(job(box)).bodies[0]
    np.testing.assert_allclose(body.stiffness_factors, 10 ** body.weights(weights), rtol=1e-12)


def test_rest_volumes_follow_the_ratios_of_the_frames(box):
    box.inflate = np.linspace(1, 1.5, 10)
    box.inflation = bake.Inflation(np.ones(len(box.vertices)), np.linspace(1, 2, 10))
    sim = bake.build(job(box))
    body = sim.bodies[0]
    assert body.inflate == [(frame / 24, ratio) for frame, ratio in enumerate(box.inflate)]
    sim.advance(9)
    assert body.rest_volume_ratios == pytest.approx(3)
    # Numbers that do not change have no keyframes, and a ratio of 1 has no zones.
    box.inflate, box.inflation.ratios = np.full(10, 0.8), np.ones(10)
    body = bake.build(job(box)).bodies[0]
    assert body.inflate == 0.8
    box.inflate = np.full(10, 11.0)
    with pytest.raises(bake.BakeError, match='object "box" cannot be a soft body: inflate = 11 is out of range'):
        bake.build(job(box))


@pytest.mark.parametrize("axis", [(0, 1, 0), (1, 0, 0), (0.4, 0.8, -0.3)])
def test_a_driven_part_moves_with_its_object_through_any_rotation(box, axis):
    # A whole turn, also through 90 degrees about y, where the three angles of a keyframe are not unique.
    angles = np.linspace(0, 2 * np.pi, 25)
    half = np.asarray(axis) / np.linalg.norm(axis) * np.sin(angles / 2)[:, None]
    turns = [placed((*v, np.cos(angle / 2)), (0, 0.02 * k, 0)) for k, (v, angle) in enumerate(zip(half, angles))]  # noqa: B905
    start = placed((20, 40, 60), (1, 2, 3), scale=np.array([1.0, 2.0, -0.5]))
    driver = np.array(turns) @ start
    top = box.vertices[:, 2] > 0.3
    box.attachments = [bake.Attachment("top", top, driver=driver)]
    sim = bake.build(job(box, frames=25, gravity=(0, 0, 0)))
    size = np.abs(box.vertices).max() + 1
    for turn in turns:
        # Held by cells, whose corners have positions relative to the center of the part: twice the rounding.
        error = np.abs(sim.bodies[0].surface() - transformed(turn, box.vertices))[top].max()
        assert error < 4 * ROUNDING * size
        sim.advance()


def test_an_attachment_without_motion_is_a_pin_and_ends_at_its_release(box):
    group = box.vertices[:, 2] > 0.3
    frames = np.repeat(box.vertices[None].astype(np.float32), 10, 0)
    box.attachments = [
        bake.Attachment("pin", group),
        bake.Attachment("driven", group, driver=still(10)),
        bake.Attachment("animated", group, animation=frames, release=5),
        bake.Attachment("free", group, release=0),
    ]
    sim = bake.build(job(box))
    assert [hold.keys for hold in sim.bodies[0].holds] == [None, None, None]
    assert [hold.end for hold in sim.bodies[0].holds] == [None, None, 5 / 24]


def test_rigid_matrices_are_told_from_those_that_change_the_size():
    moving = np.array([placed((10 * k, 0, 5 * k), (k, 0, 0)) for k in range(10)])
    stretched = placed((10, 20, 30), scale=np.array([1.0, 2.0, -3.0]))
    assert is_rigid(moving)
    assert is_rigid(moving @ stretched)
    assert is_rigid((moving @ stretched).astype(np.float32).astype(float))
    growing = moving.copy()
    growing[-1, :3, :3] *= 1.001
    assert not is_rigid(growing)
    mirrored = moving.copy()
    mirrored[-1] = mirrored[-1] @ np.diag([1, 1, -1, 1])
    assert not is_rigid(mirrored)
    assert not is_rigid(np.zeros((2, 4, 4)))


def test_a_collider_moves_in_the_same_way_with_its_object_and_with_its_vertices(box):
    matrices = np.array([placed((0, 0, 3 * k), (-1.6 + 0.08 * k, 0.1, 0), 0.8) for k in range(10)])
    local = box.vertices
    shape = transformed(matrices[0], local)
    rigid = bake.Collider("pusher", matrices, shape, box.faces)
    frames = np.array([transformed(matrix, local) for matrix in matrices], np.float32)
    deforming = bake.Collider("pusher", matrices, shape, box.faces, frames=frames)
    center = (shape.min(axis=0) + shape.max(axis=0)) / 2
    for pusher in (rigid, deforming):
        sim = bake.build(job(box, colliders=[pusher], gravity=(0, 0, 0)))
        collider = sim.colliders[0]
        assert (collider.frames is None) == (pusher is rigid)
        for frame in frames:
            if pusher is rigid:
                turn = placed(collider.rotation, center + collider.translation)
                assert np.abs(transformed(turn, shape - center) - frame).max() < ROUNDING * 4
            sim.advance()
        assert sim.bodies[0].surface()[:, 0].mean() > 0.05, "the collider pushes the box"


def test_a_plane_is_solid_below_and_a_growing_object_deforms(box):
    tilted = placed((30, 0, 0), (0, 0, -1), scale=np.array([2.0, 2.0, -1.0]))
    growing = np.array([placed(scale=1 + 0.1 * k) for k in range(10)])
    colliders = [
        bake.Collider("ground", np.repeat(tilted[None], 10, 0), friction=0.2, thickness=0.25),
        bake.Collider("balloon", growing, box.vertices + 9, box.faces, restitution=0.3, thickness=0.5),
    ]
    ground, balloon = bake.build(job(box, colliders=colliders)).colliders
    # The side to which the z axis of the object points, although its scale mirrors it.
    assert np.allclose(np.asarray(ground.normal) / np.linalg.norm(ground.normal), tilted[:3, 2], atol=1e-6)
    assert (ground.friction, balloon.restitution) == (0.2, 0.3)
    assert (ground.thickness, balloon.thickness) == (0.25, 0.5)
    assert np.allclose(balloon.frames[9], 1.9 * (box.vertices + 9), rtol=1e-6)


def test_caches_are_in_the_space_of_their_objects(box):
    matrices = np.array([placed((5 * k, 40, 0), (k, 2, 3), np.array([2.0, 1.0, -0.5])) for k in range(10)])
    shape = box.vertices
    box.matrices = matrices
    counted: list[int] = []
    report = bake.run(job(box, first_frame=3), counted.append)
    assert counted == list(range(1, 11))
    assert report.warnings == []
    first, local = read(box.path)
    assert first == 3
    sim = supple.Simulation(
        [supple.Body(supple.Mesh(shape, box.faces), lattice_vertices=300)], fps=24, gravity=(0, 0, -9.81)
    )
    assert report.steps_per_frame == sim.steps_per_frame
    for matrix, frame in zip(matrices, local, strict=True):
        expected = sim.bodies[0].surface()
        assert np.abs(transformed(matrix, frame) - expected).max() < ROUNDING * np.abs(matrix).max() * 4
        sim.advance()


def test_a_bake_that_ends_early_changes_no_cache(box, tmp_path):
    other = bake.Body("other", box.vertices + 3, box.faces, box.matrices, tmp_path / "new" / "other.pc2", box.options)
    box.path.write_text("an earlier bake")
    done: list[int] = []
    with pytest.raises(bake.BakeCancelledError):
        bake.run(job(box, other), done.append, lambda: len(done) == 4)
    assert len(done) == 4

    def fail(frame: int) -> None:
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        bake.run(job(box, other), fail)
    assert box.path.read_text() == "an earlier bake"
    assert [path.name for path in tmp_path.rglob("*.pc2*")] == ["box.pc2"]
    bake.run(job(box, other))
    assert len(read(box.path)[1]) == len(read(other.path)[1]) == 10
    assert len(list(tmp_path.rglob("*.pc2*"))) == 2


def test_warnings_of_the_simulation_are_reported(box):
    other = bake.Body("other", box.vertices, box.faces, box.matrices, box.path.with_name("other.pc2"))
    other.vertices = box.vertices + [0.9, 0, 0]
    other.options = {**box.options, "youngs_modulus": 1e9}
    report = bake.run(job(box, other, substeps=1))
    assert len(report.warnings) == 3, report.warnings
    assert sum("overlap" in warning for warning in report.warnings) == 1


@pytest.mark.parametrize(
    ("change", "parts"),
    [
        ({"faces": [[0, 1, 999]]}, ('object "box" cannot be a soft body', "999")),
        ({"options": {"density": -1}}, ('object "box" cannot be a soft body', "density")),
        ({"matrices": np.zeros((10, 4, 4))}, ('object "box" has no extent', "scale")),
        (
            {"matrices": np.full((10, 4, 4), np.nan)},
            ('object "box" has no finite transformation in frame 0', "drivers"),
        ),
        (
            {
                "attachments": [
                    bake.Attachment("led", np.ones(486, bool), driver=np.arange(10)[:, None, None] * np.eye(4))
                ]
            },
            ('object "box", vertex group "led"', "scale"),
        ),
        ({"attachments": [bake.Attachment("empty", np.zeros(486, bool))]}, ('object "box", vertex group "empty"',)),
    ],
)
def test_errors_name_the_object_and_the_way_out(box, change, parts):
    for name, value in change.items():
        setattr(box, name, value)
    with pytest.raises(bake.BakeError) as raised:
        bake.run(job(box))
    for part in parts:
        assert part in str(raised.value)
    assert not list(box.path.parent.iterdir())


def test_a_cache_that_cannot_be_completed_leaves_no_file(box):
    in_the_way = box.path.with_name("box.baking.pc2")

    def obstruct(frames: int) -> None:
        if frames == 10:
            in_the_way.mkdir()

    with pytest.raises(bake.BakeError, match='cache of object "box" cannot be written'):
        bake.run(job(box), obstruct)
    assert [path.name for path in box.path.parent.iterdir()] == [in_the_way.name]


def test_a_collider_without_extent_along_an_axis_may_only_stand_still(box):
    flat = np.repeat(placed(scale=np.array([1.0, 1.0, 0.0]))[None], 10, 0)
    shape = transformed(flat[0], box.vertices)
    top = np.flatnonzero(box.vertices[:, 2] == 0.5)
    faces = [np.searchsorted(top, face).tolist() for face in box.faces if np.isin(face, top).all()]
    shelf = bake.Collider("shelf", flat, shape[top], faces)
    assert not bake.build(job(box, colliders=[shelf])).colliders[0].keys
    flat[1:, 0, 3] = 1.0
    with pytest.raises(bake.BakeError, match=r'"shelf" cannot be a moving collider: .* scale above 0'):
        bake.build(job(box, colliders=[shelf]))


def test_a_folder_that_cannot_be_written_is_named(box, tmp_path):
    (tmp_path / "file").write_text("")
    box.path = tmp_path / "file" / "box.pc2"
    with pytest.raises(bake.BakeError, match=r'cache of object "box" cannot be written to .*file'):
        bake.run(job(box))
