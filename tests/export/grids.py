"""Reads grids of VTK with PyVista: python tests/export/grids.py FOLDER, of a run with obj, vtu and lattice frames."""

import sys
from pathlib import Path

import numpy as np
import pyvista

folder = Path(sys.argv[1])
for name, arrays in (("bust.pvd", {"Normals"}), ("bust.lattice.pvd", {"velocity", "strain", "volume_ratio", "E"})):
    reader = pyvista.get_reader(folder / name)
    assert len(reader.time_values) == 41
    assert np.allclose(reader.time_values, np.arange(41) / 30)
    for frame in (0, 17, 40):
        reader.set_active_time_value(reader.time_values[frame])
        grid = reader.read()[0]
        assert set(grid.array_names) == arrays, grid.array_names
        if name == "bust.pvd":
            lines = (folder / f"bust_{frame:04}.obj").read_text().splitlines()
            points = np.array([line.split()[1:4] for line in lines if line.startswith("v ")], dtype=np.float32)
            assert np.array_equal(grid.points, points)
        else:
            # A cell that is turned over, or whose corners are in another order, has no volume of this size.
            volumes = grid.compute_cell_sizes(length=False, area=False)["Volume"]
            if frame == 0:
                assert np.allclose(volumes, volumes[0], rtol=1e-3)
                at_rest = volumes[0]
                modulus = grid["E"][0]
            # The scene has no zones.
            assert modulus > 0
            assert (grid["E"] == modulus).all()
            assert np.allclose(volumes / at_rest, grid["volume_ratio"], atol=0.1)
print("PyVista reads the surface and the lattice")
