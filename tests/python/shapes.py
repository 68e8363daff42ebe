"""Arrays that several tests share."""

import numpy as np

import supple

#: Corners of a unit cube, x fastest, and its faces, counter-clockwise as seen from outside.
CORNERS = np.array([[k & 1, k >> 1 & 1, k >> 2 & 1] for k in range(8)], dtype=float)
QUADS = np.array([[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]])


def box_mesh(size):
    """Return a box with the given edges, whose sides are divided into squares of edge 1."""
    vertices, faces = {}, []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for side in (0, size[axis]):
            for i in range(size[u]):
                for j in range(size[v]):
                    quad = []
                    for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1)):
                        corner = [0, 0, 0]
                        corner[axis], corner[u], corner[v] = side, i + di, j + dj
                        quad.append(vertices.setdefault(tuple(corner), len(vertices)))
                    faces.append(quad if side else quad[::-1])
    return supple.Mesh(np.array(list(vertices), float), faces)


#: A bar of 12 x 4 x 4.
BAR = box_mesh((12, 4, 4))
