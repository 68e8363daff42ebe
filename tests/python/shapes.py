"""Arrays that several tests share."""

import numpy as np

#: Corners of a unit cube, x fastest, and its faces, counter-clockwise as seen from outside.
CORNERS = np.array([[k & 1, k >> 1 & 1, k >> 2 & 1] for k in range(8)], dtype=float)
QUADS = np.array([[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]])
