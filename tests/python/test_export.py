"""Files for other programs: animated GLB, vertex animation textures and grids of VTK."""

import json
import struct
from pathlib import Path

import numpy as np
import pytest

import supple
from conftest import ROOT

EXAMPLES = ROOT / "examples" / "scenes"


def simulation() -> supple.Simulation:
    """Return a bust that falls on a plane."""
    body = supple.Body(EXAMPLES / "bust.obj", lattice_vertices=150, name="bust")
    return supple.Simulation([body], fps=24, colliders=[supple.Plane((0, 4, 0), (0, 1, 0))])


class Glb:
    """A GLB file: its JSON, and its arrays."""

    def __init__(self, path: Path) -> None:
        """Read the file."""
        data = path.read_bytes()
        magic, version, size, json_size = struct.unpack_from("<4sIII", data)
        assert (magic, version, size) == (b"glTF", 2, len(data))
        self.json = json.loads(data[20 : 20 + json_size])
        self.binary = data[28 + json_size :]

    def array(self, index: int) -> np.ndarray:
        """Return an array of numbers of 32 bits, with a row per element."""
        accessor = self.json["accessors"][index]
        view = self.json["bufferViews"][accessor["bufferView"]]
        data = self.binary[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
        kind = np.float32 if accessor["componentType"] == 5126 else np.uint32
        return np.frombuffer(data, kind).reshape(accessor["count"], -1)

    def positions(self, frame: int) -> np.ndarray:
        """Return the positions of the only node in a frame."""
        attributes = self.json["meshes"][0]["primitives"][0]
        moved = self.array(attributes["attributes"]["POSITION"]).astype(float)
        animation = self.json["animations"][0]
        values = {}
        for channel in animation["channels"]:
            sampler = animation["samplers"][channel["sampler"]]
            values[channel["target"]["path"]] = self.array(sampler["output"]).astype(float)
        targets = attributes.get("targets", [])
        weights = values["weights"].reshape(-1, len(targets))[frame] if targets else []
        for weight, target in zip(weights, targets, strict=True):
            moved += weight * self.array(target["POSITION"])
        x, y, z, w = values["rotation"][frame]
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        rotation = np.eye(3) + 2 * w * cross + 2 * cross @ cross
        return moved @ rotation.T + values["translation"][frame]


@pytest.mark.parametrize("error", [1e-2, 1e-4, 0.0])
def test_a_glb_file_has_the_motion_within_the_error_that_is_asked(tmp_path: Path, error: float) -> None:
    """Compare the frames of a recording with the surfaces of the simulation."""
    sim = simulation()
    expected = []
    with supple.Recorder(sim, tmp_path / "fall.glb", glb_error=error) as recorder:
        for _ in range(10):
            recorder.record()
            expected.append(sim["bust"].surface())
            sim.advance()
    found = Glb(tmp_path / "fall.glb")
    size = np.ptp(expected[0], axis=0).max()
    for frame, positions in enumerate(expected):
        distances = np.linalg.norm(found.positions(frame) - positions, axis=1)
        # Sums of numbers of 32 bits, of a size of a few units.
        assert distances.max() <= error * size + 1e-5
    assert [path.name for path in tmp_path.iterdir()] == ["fall.glb"]


def test_save_glb_advances_and_refuses_other_names_and_errors(tmp_path: Path) -> None:
    """Save a file, and read the number of its frames."""
    sim = simulation()
    supple.save_glb(sim, tmp_path / "fall.glb", 5)
    found = Glb(tmp_path / "fall.glb")
    times = found.array(found.json["animations"][0]["samplers"][0]["input"])
    np.testing.assert_allclose(times.ravel(), np.arange(6) / 24, rtol=1e-6)
    with pytest.raises(ValueError, match=r"must end in \.glb"):
        supple.save_glb(sim, tmp_path / "fall.gltf", 5)
    with pytest.raises(ValueError, match="glb_error"):
        supple.save_glb(sim, tmp_path / "other.glb", 5, glb_error=2)


def test_runs_write_the_files_of_all_formats(tmp_path: Path) -> None:
    """Run a scene to the formats for other programs."""
    formats = ["glb", "vat", "vtu", "lattice", "usdz"]
    report = supple.run(EXAMPLES / "stretch_and_drop.toml", tmp_path, formats, frames=2)
    assert report.written == 3
    names = {str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*") if path.is_file()}
    assert {"supple.glb", "bust_vat/bust_vat.png", "bust_vat/bust-remap_info.json", "bust.pvd", "supple.usdz"} <= names
    assert {"bust_0002.vtu", "bust_0002.lattice.vtu", "bust.lattice.pvd"} <= names
    with pytest.raises(ValueError, match="glb"):
        supple.run(EXAMPLES / "stretch_and_drop.toml", tmp_path, "gltf", frames=2)
    exr = {"output.vat_encoding": "exr"}
    supple.run(EXAMPLES / "stretch_and_drop.toml", tmp_path, "vat", frames=2, overrides=exr)
    images = sorted(path.name for path in (tmp_path / "bust_vat").iterdir() if path.suffix in (".png", ".exr"))
    assert images == ["bust_vat.exr", "bust_vnrm.exr"]
