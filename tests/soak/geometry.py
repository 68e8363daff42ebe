"""Degenerate and extreme surfaces, at many lattice vertices."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from . import meshes
from .context import Case, Check, Settings
from .meshes import Surface
from .outcome import run_or_refuse

Random = np.random.Generator


def check(settings: Settings) -> Check:
    """Run surfaces."""
    result = Check("geometry", settings)

    def case(case: Case) -> None:
        kind = KINDS[case.index % len(KINDS)]
        case.label = f"{case.index} ({kind.__name__})"
        vertices, faces = kind(case.random)
        path = case.folder / "surface.obj"
        meshes.write_obj(path, (vertices, faces))
        options = []
        if case.random.random() < 0.3:
            options += ["--set", f'body.0.volume={{ scope = "{case.random.choice(["global", "regional"])}" }}']
        if case.random.random() < 0.2:
            options += ["--set", "body.0.join=false"]
        run_or_refuse(case, "surface.obj", *options, input_bytes=path.stat().st_size)

    result.cases(settings.count(240, 12), case)
    return result


def scaled(random: Random) -> Surface:
    """Scaled by a factor from 1e-12 to 1e12."""
    vertices, faces = meshes.any_surface(random)
    return vertices * 10.0 ** random.choice([-12, -9, -6, 6, 9, 12]), faces


def scaled_on_one_axis(random: Random) -> Surface:
    """Very thin or very long along one axis."""
    vertices, faces = meshes.any_surface(random)
    factors = np.ones(3)
    factors[random.integers(3)] = 10.0 ** random.choice([-12, -7, -4, 4, 7, 12])
    return vertices * factors, faces


def near_the_limits_of_floats(random: Random) -> Surface:
    """With coordinates near the largest or the smallest float."""
    vertices, faces = meshes.any_surface(random)
    return vertices * 10.0 ** random.choice([-310, -300, -160, -45, -38, 37, 38, 39, 153, 160, 307]), faces


def not_a_number(random: Random) -> Surface:
    """With a coordinate that is not finite."""
    vertices, faces = meshes.any_surface(random)
    vertices[random.integers(len(vertices)), random.integers(3)] = random.choice([np.nan, np.inf, -np.inf])
    return vertices, faces


def far_from_the_origin(random: Random) -> Surface:
    """Moved by up to 1e15 times its size."""
    vertices, faces = meshes.any_surface(random)
    return vertices + random.normal(size=3) * 10.0 ** random.integers(3, 16), faces


def one_vertex_far_away(random: Random) -> Surface:
    """With one vertex far away."""
    vertices, faces = meshes.any_surface(random)
    vertices[random.integers(len(vertices))] *= 10.0 ** random.integers(2, 13)
    return vertices, faces


def unused_vertex_far_away(random: Random) -> Surface:
    """With a vertex far away that no face uses."""
    vertices, faces = meshes.any_surface(random)
    return np.concatenate([vertices, [[1e30, -1e30, 1e12]]]), faces


def degenerate_faces(random: Random) -> Surface:
    """With faces of one point or one line."""
    vertices, faces = meshes.any_surface(random)
    vertices[random.integers(len(vertices), size=len(vertices) // 3)] = vertices[0]
    repeated = [[face[0], face[1], *face] for face in faces if random.random() < 0.3]
    return vertices, faces + repeated


def only_degenerate_faces(random: Random) -> Surface:
    """All vertices on one line, or in one point."""
    vertices, faces = meshes.any_surface(random)
    direction = random.normal(size=3) * random.integers(2)
    return vertices[:, :1] * direction, faces


def duplicate_faces(random: Random) -> Surface:
    """With each face several times."""
    vertices, faces = meshes.any_surface(random)
    return vertices, faces * int(random.integers(2, 50))


def flipped_faces(random: Random) -> Surface:
    """With some or all faces inside out."""
    vertices, faces = meshes.any_surface(random)
    share = random.choice([0.1, 0.5, 1.0])
    return vertices, [face[::-1] if random.random() < share else face for face in faces]


def both_orientations(random: Random) -> Surface:
    """With each face in both orientations: no volume."""
    vertices, faces = meshes.any_surface(random)
    return vertices, faces + [face[::-1] for face in faces]


def missing_faces(random: Random) -> Surface:
    """With holes."""
    vertices, faces = meshes.any_surface(random)
    share = random.choice([0.1, 0.5, 0.95])
    return vertices, [face for face in faces if random.random() > share] or faces[:1]


def huge_polygon(random: Random) -> Surface:
    """With ends of up to 20,000 corners."""
    return meshes.prism(int(random.choice([1000, 5000, 20_000])), float(random.choice([1e-9, 0.1, 10.0])))


def random_polygon(random: Random) -> Surface:
    """One face through random points, which crosses itself."""
    count = int(random.integers(4, 3000))
    return random.normal(size=(count, 3)), [list(range(count))]


def needles(random: Random) -> Surface:
    """Triangles that are long and thin."""
    triangles = random.normal(size=(500, 3, 3))
    triangles[:, 2] = triangles[:, 1] + 1e-9 * random.normal(size=(500, 3))
    return meshes.soup(triangles)


def spikes(random: Random) -> Surface:
    """A sphere with some vertices moved far along their normals."""
    vertices, faces = meshes.sphere(20, 30)
    chosen = random.random(len(vertices)) < 0.05
    vertices[chosen] *= random.uniform(5, 100)
    return vertices, faces


def rough(random: Random) -> Surface:
    """A sphere with noise that is larger than its faces."""
    vertices, faces = meshes.sphere(60, 80)
    return vertices + random.normal(size=vertices.shape) * 0.2, faces


def nonmanifold(random: Random) -> Surface:
    """Faces between random vertices: edges with many faces, and vertices with many fans."""
    vertices = random.normal(size=(40, 3))
    faces = [random.choice(40, size=int(random.integers(3, 7)), replace=False).tolist() for _ in range(400)]
    return vertices, faces


def fan_at_one_edge(random: Random) -> Surface:
    """Thousands of triangles at one edge."""
    count = 5000
    angles = random.uniform(0, 2 * np.pi, count)
    around = np.stack([np.cos(angles), np.sin(angles), random.uniform(0, 1, count)], axis=-1)
    vertices = np.concatenate([[[0, 0, 0], [0, 0, 1]], around])
    return vertices, [[0, 1, k + 2] for k in range(count)]


def plane(random: Random) -> Surface:
    """All in one plane, along the axes or oblique."""
    vertices, faces = meshes.any_surface(random)
    normal = random.normal(size=3) if random.random() < 0.5 else np.eye(3)[random.integers(3)]
    normal /= np.linalg.norm(normal)
    return vertices - np.outer(vertices @ normal, normal), faces


def one_triangle(random: Random) -> Surface:
    """One triangle."""
    return meshes.soup(random.normal(size=(1, 3, 3)) * 10.0 ** random.integers(-6, 7, size=3))


def disjoint_parts(random: Random) -> Surface:
    """100,000 disjoint triangles, or as many faces in disjoint boxes."""
    if random.random() < 0.5:
        corners = random.uniform(0, 100, size=(100_000, 1, 3))
        return meshes.soup(corners + 0.1 * random.normal(size=(100_000, 3, 3)))
    corners, quads = meshes.box([0.3, 0.3, 0.3])
    offsets = random.uniform(0, 50, size=(16_000, 1, 3))
    faces = (np.array(quads)[None] + 8 * np.arange(16_000)[:, None, None]).reshape(-1, 4)
    return (corners[None] + offsets).reshape(-1, 3), faces.tolist()


def two_distant_parts(random: Random) -> Surface:
    """Two parts with a gap of up to 1e9 times their size."""
    first, second = meshes.any_surface(random), meshes.any_surface(random)
    return meshes.joined([first, (second[0] + random.normal(size=3) * 10.0 ** random.integers(1, 10), second[1])])


def nested_shells(random: Random) -> Surface:
    """Spheres within spheres."""
    radii = np.sort(random.uniform(0.01, 2, 40))
    return meshes.joined(meshes.sphere(8, 10, float(radius)) for radius in radii)


def parts_of_all_sizes(random: Random) -> Surface:
    """Parts whose sizes differ by 12 orders of magnitude."""
    parts = [meshes.any_surface(random) for _ in range(12)]
    scales = 10.0 ** np.arange(-6, 6)
    return meshes.joined(
        (vertices * s + [2 * s, 0, 0], faces) for (vertices, faces), s in zip(parts, scales, strict=True)
    )


def coincident_parts(random: Random) -> Surface:
    """The same part many times in the same place."""
    part = meshes.any_surface(random)
    return meshes.joined([part] * 100)


def touching_boxes(random: Random) -> Surface:
    """Boxes that share corners, edges and faces, on a grid."""
    cells = random.integers(0, 8, size=(200, 3))
    return meshes.joined((meshes.box()[0] + cell, meshes.box()[1]) for cell in cells)


def random_triangles(random: Random) -> Surface:
    """Large triangles that cross each other."""
    return meshes.soup(random.normal(size=(int(random.choice([10, 300, 5000])), 3, 3)))


def rounded(random: Random) -> Surface:
    """A fine sphere whose coordinates are rounded to few values."""
    vertices, faces = meshes.sphere(60, 80)
    return np.round(vertices * 8) / 8, faces


KINDS: list[Callable[[Random], Surface]] = [
    *[scaled, scaled_on_one_axis, near_the_limits_of_floats, not_a_number, far_from_the_origin],
    *[one_vertex_far_away, unused_vertex_far_away, degenerate_faces, only_degenerate_faces, duplicate_faces],
    *[flipped_faces, both_orientations, missing_faces, huge_polygon, random_polygon, needles, spikes, rough],
    *[nonmanifold, fan_at_one_edge, plane, one_triangle, disjoint_parts, two_distant_parts, nested_shells],
    *[parts_of_all_sizes, coincident_parts, touching_boxes, random_triangles, rounded],
]
