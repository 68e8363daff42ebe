"""Pictures of simulations without a display."""

import subprocess
import sys

import numpy as np
import pytest

import supple

WHITE = np.array([255, 255, 255])


@pytest.fixture
def cubes(cube):
    """Two cubes of edge 2, one at the origin, one of another color 4 to the right."""
    bodies = [supple.Body(cube, name=f"cube{x}", lattice_vertices=100, translate=(x, 0, 0)) for x in (0, 4)]
    return supple.Simulation(bodies)


def _covered(picture):
    return (picture != WHITE).any(axis=2)


def test_bodies_cover_their_projections(cubes):
    picture = supple.screenshot(cubes, size=(300, 200), view=(0, 0, 1))
    assert picture.shape == (200, 300, 3)
    assert picture.dtype == np.uint8
    covered = _covered(picture)
    # The 6 units of the width fill 92 % of 300 pixels. A pixel at each border may be covered in part.
    unit = 0.92 * 300 / 6
    columns = np.flatnonzero(covered.any(axis=0))
    assert np.ptp(columns) + 1 == pytest.approx(6 * unit, abs=2)
    assert columns.mean() == pytest.approx(149.5, abs=1)
    assert covered.sum() == pytest.approx(2 * (2 * unit) ** 2, rel=0.03)
    assert np.flatnonzero(covered.any(axis=1)).mean() == pytest.approx(99.5, abs=1)
    # Each front face has one color.
    middle = picture[100, [round(149.5 - 2 * unit), round(149.5 + 2 * unit)]].astype(int)
    assert np.abs(middle[0] - middle[1]).max() > 20


def test_up_is_against_gravity_and_the_camera_sees_the_front(cube):
    def rows(gravity, shift):
        body = supple.Body(cube, lattice_vertices=100, translate=shift)
        sim = supple.Simulation(body, gravity=gravity)
        return _covered(supple.screenshot(sim, size=(90, 90), bounds=[(-4, -4, -4), (4, 4, 4)])).nonzero()[0].mean()

    for gravity, up in [((0, -9.81, 0), (0, 2, 0)), ((0, 0, -9.81), (0, 0, 2)), ((0, 0, 0), (0, 2, 0))]:
        down = -np.array(up)
        assert rows(gravity, up) < rows(gravity, (0, 0, 0)) - 5
        assert rows(gravity, down) > rows(gravity, (0, 0, 0)) + 5


def test_the_nearer_body_hides_the_other(cubes):
    from_right = supple.screenshot(cubes, size=(60, 60), view=(1, 0, 0))
    other = supple.screenshot(cubes, size=(60, 60), view=(-1, 0, 0))
    assert np.abs(from_right[30, 30].astype(int) - other[30, 30]).max() > 20


def test_colliders_are_drawn_at_their_poses(cube):
    def columns(shape, **options):
        body = supple.Body(cube, lattice_vertices=100, translate=(0, 30, 0), half_width=1)
        sim = supple.Simulation(body, colliders=shape)
        sim.colliders[0].move_to((0, 0, 0), (0, 0, 90))
        sim.step()
        options = {"view": (0, 0, 1), "bounds": [(-2, -2, -2), (2, 2, 2)], "size": (200, 200), **options}
        return _covered(supple.screenshot(sim, **options))

    unit = 0.92 * 200 / 4
    mesh = supple.Mesh([[0, -1, 0], [2, -1, 0], [2, 0, 0], [0, 0, 0]], [[0, 1, 2, 3]])
    cases = [
        # The size along x and y, after a rotation by 90 degrees about z.
        (supple.Box((0, 0, 0), (1.5, 0.5, 1)), (1, 3)),
        (supple.Capsule((-1, 0, 0), (1, 0, 0), 0.5), (1, 3)),
        (supple.Sphere((0, 0, 0), 1), (2, 2)),
        (supple.MeshCollider(mesh, translate=(-1, 0.5, 0)), (1, 2)),
    ]
    for shape, (width, height) in cases:
        covered = columns(shape)
        # Circles are polygons of 48 edges, which are 0.2 % smaller.
        assert covered.any(axis=0).sum() == pytest.approx(width * unit, abs=2.5), shape
        assert covered.any(axis=1).sum() == pytest.approx(height * unit, abs=2.5), shape
        assert not columns(shape, colliders=False).any()
    # The plane is vertical after the rotation, a wall, and so it is not drawn.
    assert not columns(supple.Plane((0, 0, 0), (0, 1, 0)), view=(1, 1, 1)).any()
    assert columns(supple.Plane((0, 0, 0), (1, 0, 0)), view=(1, 1, 1)).any()


def test_disabled_colliders_are_not_drawn(cube):
    ball = supple.Sphere((0, 0, 0), 1, enabled=False)
    sim = supple.Simulation(supple.Body(cube, lattice_vertices=100, translate=(0, 30, 0), half_width=1), colliders=ball)
    options = {"bounds": [(-2, -2, -2), (2, 2, 2)], "size": (60, 60)}
    assert not _covered(supple.screenshot(sim, **options)).any()
    sim.colliders[0].enabled = True
    assert _covered(supple.screenshot(sim, **options)).any()


def test_animated_meshes_are_drawn_at_the_time(cube):
    flat = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    plate = supple.MeshCollider(supple.Mesh(flat, [[0, 1, 2, 3]]), frames=[flat, flat + [1, 0, 0]], fps=30)
    sim = supple.Simulation(
        supple.Body(cube, lattice_vertices=100, translate=(0, 30, 0), half_width=1), dt=1 / 60, colliders=plate
    )
    columns = []
    for _ in range(2):
        picture = supple.screenshot(sim, view=(0, 0, 1), bounds=[(-2, -2, -2), (2, 2, 2)], size=(200, 200))
        columns.append(np.flatnonzero(_covered(picture).any(axis=0)).mean())
        sim.step()
    # After half a frame the plate is half a unit to the right.
    assert columns[1] - columns[0] == pytest.approx(0.5 * 0.92 * 200 / 4, abs=1)


def test_a_bare_lattice_is_drawn_as_its_cells():
    cells = np.ones((3, 3, 1), bool)
    cells[1, 1] = False
    body = supple.Body(supple.Lattice.from_cells(cells))
    picture = _covered(supple.screenshot(body, size=(300, 300), view=(0, 0, 1)))
    assert not picture[120:180, 120:180].any()
    assert picture.sum() == pytest.approx(8 / 9 * (0.92 * 300) ** 2, rel=0.02)


def test_the_file_is_the_picture_and_needs_no_package(cubes, tmp_path):
    path = tmp_path / "cubes.png"
    picture = supple.screenshot(cubes, path, size=(64, 48))
    image = pytest.importorskip("PIL.Image").open(path)
    assert np.array_equal(np.asarray(image), picture)
    program = f"""
import sys
for name in ("matplotlib", "PIL", "trimesh", "polyscope"):
    sys.modules[name] = None
import supple
body = supple.Body(supple.Lattice.from_cells([[[True]]]))
supple.screenshot(body, {str(tmp_path / "other.png")!r})
"""
    subprocess.run([sys.executable, "-c", program], check=True)
    assert (tmp_path / "other.png").stat().st_size > 1000


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"path": "cubes.jpg"}, ValueError, r"path is 'cubes.jpg'; it must end in .png"),
        ({"size": (0, 10)}, ValueError, "both numbers must be from 1 to 8192"),
        ({"view": (0, 0, 0)}, ValueError, "view must be"),
        ({"bounds": [(0, 0, 0), (-1, 1, 1)]}, ValueError, "bounds must be"),
        ({"target": 3}, TypeError, "target must be a Simulation or a Body, not int"),
    ],
)
def test_invalid_arguments_are_errors(cubes, options, error, message):
    with pytest.raises(error, match=message):
        supple.screenshot(**{"target": cubes, **options})
