"""Films of simulations and of runs on disk."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import supple
from conftest import ROOT

EXAMPLES = ROOT / "examples" / "scenes"


def simulation() -> supple.Simulation:
    """Return a bust that falls on a plane."""
    body = supple.Body(EXAMPLES / "bust.obj", lattice_vertices=150, name="bust")
    return supple.Simulation([body], fps=20, colliders=[supple.Plane((0, 4, 0), (0, 1, 0))])


def pictures(path: Path) -> list[np.ndarray]:
    """Return the pictures of a film, (height, width, 3)."""
    with Image.open(path) as film:
        found = []
        for frame in range(film.n_frames):
            film.seek(frame)
            found.append(np.asarray(film.convert("RGB")).astype(int))
        return found


@pytest.mark.parametrize("name", ["fall.webp", "fall.gif"])
def test_a_film_of_a_simulation_shows_the_body_as_it_falls(tmp_path: Path, name: str) -> None:
    """Look for the blue of the body, which moves down."""
    sim = simulation()
    assert supple.film(sim, tmp_path / name, 6, size=(160, 120)) == tmp_path / name
    assert sim.time == pytest.approx(6 / 20)
    found = pictures(tmp_path / name)
    assert len(found) == 7
    assert found[0].shape == (120, 160, 3)
    blue = [np.argwhere(picture[..., 2] - picture[..., 0] > 30) for picture in found]
    assert all(len(pixels) > 500 for pixels in blue)
    assert blue[-1][:, 0].mean() > blue[0][:, 0].mean() + 3
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_a_film_of_a_run_is_that_of_its_page_or_its_frames(tmp_path: Path) -> None:
    """Show a run by its report, and its folder with frames."""
    options = {"output.film_size": [80, 60]}
    report = supple.run(EXAMPLES / "squeeze.toml", tmp_path / "out", ["film", "html"], frames=3, overrides=options)
    supple.film(report, tmp_path / "page.webp", size=(80, 60))
    of_run, of_page = pictures(tmp_path / "out" / "supple.webp"), pictures(tmp_path / "page.webp")
    assert len(of_run) == 4
    np.testing.assert_array_equal(of_run, of_page)
    supple.run(EXAMPLES / "squeeze.toml", tmp_path / "frames", "ply", frames=3)
    supple.film(tmp_path / "frames", tmp_path / "frames.gif", size=(80, 60), fps=10, view=(0, 0, 1))
    assert len(pictures(tmp_path / "frames.gif")) == 4


def test_colors_show_the_volume(tmp_path: Path) -> None:
    """Without a correction, a volume that is wrong is red."""
    sim = simulation()
    sim["bust"].volume_options = "off"
    body = sim["bust"]
    body.positions = body.positions * [1, 1.5, 1]
    with supple.Recorder(sim, tmp_path / "wrong.webp", film_size=(80, 60), film_color="volume") as recorder:
        recorder.record()
    red = pictures(tmp_path / "wrong.webp")[0]
    assert (red[..., 0] - red[..., 2] > 60).sum() > 100


def test_wrong_arguments_are_refused(tmp_path: Path) -> None:
    """Give names, sizes, views and runs that are none."""
    sim = simulation()
    with pytest.raises(ValueError, match=r"must end in \.webp or \.gif"):
        supple.film(sim, tmp_path / "fall.mp4")
    for wrong in ({"size": (8, 600)}, {"view": (0, 0, 0)}, {"color": "red"}, {"fps": 0}):
        with pytest.raises(ValueError, match=next(iter(wrong))):
            supple.film(sim, tmp_path / "fall.webp", 1, **wrong)  # type: ignore[arg-type]
        with pytest.raises(ValueError, match=next(iter(wrong))):
            supple.film(tmp_path, tmp_path / "fall.webp", **wrong)  # type: ignore[arg-type]
    with pytest.raises(FileNotFoundError):
        supple.film(tmp_path / "missing", tmp_path / "fall.webp")
    with pytest.raises(ValueError, match=r"neither a page supple\.html nor frames"):
        supple.film(tmp_path, tmp_path / "fall.webp")
    with pytest.raises(ValueError, match="frames is for simulations"):
        supple.film(tmp_path, tmp_path / "fall.webp", 3)
    assert list(tmp_path.iterdir()) == []
