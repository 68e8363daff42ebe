"""Write a PC2 file for Blender. In Blender the Mesh Cache modifier applies the file to the model.

python examples/python/06_blender.py [SCENE.toml [DIR]]

Then, in Blender:

1. Output properties: set the frame rate to the frame rate of the scene, which is 30 in twist.toml.
2. File > Import > Wavefront (.obj): choose the model of the scene, examples/scenes/bust.obj. In the import settings set
   Forward Axis to Y and Up Axis to Z, so that the model is not rotated, and switch Split By Object, which is on by
   default, and Split By Group off, so that the mesh has the vertices of the file in the same order.
3. With the model selected: Modifiers > Add Modifier > Deform > Mesh Cache. Format: PC2. File Path: DIR/bust.pc2. Time
   Mode: Frame, Play Mode: Scene. Leave the axes at Y forward and Z up.
4. Rotate the object by 90 degrees about x (R X 90): y is up in the scene, and z is up in Blender.
5. Play. The file has one sample per written frame, and the modifier plays them from frame 0. For a run with
   start_frame=N (--start-frame N) set Frame Start of the modifier to N. For a run with every=K (--every K) set Frame
   Scale to 1/K.
"""

from __future__ import annotations

import struct
import sys
from pathlib import Path

import supple


def main(scene: str = "examples/scenes/twist.toml", output: str = "frames/blender") -> None:
    """Run the first 30 frames of the scene, and print the header of each PC2 file."""
    report = supple.run(scene, output, "pc2", frames=30)
    for body in report.bodies:
        path = Path(report.directory, f"{body.name}.pc2")
        with path.open("rb") as file:
            magic, _, vertices, start, rate, samples = struct.unpack("<12siiffi", file.read(32))
        assert magic == b"POINTCACHE2\0"
        print(f"{path}: samples {samples}, vertices {vertices}, first frame {start:.0f}, frame interval {rate:.0f}")


if __name__ == "__main__":
    main(*sys.argv[1:])
