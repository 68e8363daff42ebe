"""What notebooks show of simulations, bodies and recorded pages; the first example."""

import base64
import struct
import subprocess
import sys
from html.parser import HTMLParser

import numpy as np
import pytest

import supple
from supple import example

VOID = {"img", "meta", "link", "br", "input"}


class Reader(HTMLParser):
    """Reads elements with their attributes, and the texts between them; fails for an element that is not closed."""

    def __init__(self, text):
        super().__init__()
        self.open, self.elements, self.texts = [], [], []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.texts.append(data)

    def attributes(self, tag):
        return [attributes for name, attributes in self.elements if name == tag]


@pytest.fixture
def sim(cube):
    lattice = supple.Lattice.from_cells(np.ones((2, 2, 2), bool), origin=(4, 0, 0))
    bodies = [supple.Body(cube, name="Würfel-1", lattice_vertices=100), supple.Body(lattice, name="bare")]
    return supple.Simulation(bodies, fps=30, colliders=supple.Plane((0, -2, 0), (0, 1, 0)))


def test_a_simulation_shows_a_picture_and_a_table(sim):
    sim.advance(3)
    shown = Reader(sim._repr_html_())
    (image,) = shown.attributes("img")
    kind, _, data = image["src"].partition(",")
    picture = base64.b64decode(data, validate=True)
    assert kind == "data:image/png;base64"
    assert picture[:8] == b"\x89PNG\r\n\x1a\n"
    size = struct.unpack(">II", picture[16:24])
    assert size == (int(image["width"]), int(image["height"]))
    assert image["alt"] == "Picture of Würfel-1, bare"
    assert shown.texts[0] == "Simulation at 0.1 s, 1 collider"
    cells = shown.texts[5:]
    assert cells == ["Würfel-1", "8", str(len(sim.bodies[0])), "8", "bare", "no mesh", "27", "8"]


def test_a_body_shows_itself(sim):
    shown = Reader(sim.bodies[0]._repr_html_())
    assert shown.attributes("img")[0]["alt"] == "Picture of Würfel-1"
    assert "bare" not in shown.texts
    alone = Reader(supple.Body(sim.bodies[1].lattice, name="alone")._repr_html_())
    assert alone.attributes("img")[0]["alt"] == "Picture of alone"


def test_a_sleeping_body_is_marked(cube):
    sim = supple.Simulation(
        supple.Body(cube, lattice_vertices=30), fps=30, colliders=supple.Plane((0, -1, 0), (0, 1, 0))
    )
    sim.advance(150)
    assert sim.bodies[0].is_asleep
    assert Reader(sim._repr_html_()).texts[-1] == "asleep"


@pytest.fixture
def page(cube, tmp_path):
    sim = supple.Simulation(supple.Body(cube, lattice_vertices=30), fps=30)
    return supple.save_html(sim, tmp_path / 'a "b" & <i>.html', 4)


def test_a_recorded_page_is_shown_whole_in_a_frame(page, tmp_path):
    (file,) = tmp_path.glob("*.html")
    shown = Reader(page._repr_html_())
    assert [tag for tag, _ in shown.elements] == ["iframe"]
    (frame,) = shown.attributes("iframe")
    assert frame["title"] == 'Animation of a "b" & <i>'
    assert frame["sandbox"] == "allow-scripts"
    assert frame["srcdoc"] == file.read_bytes().decode()
    assert repr(page) == f"<supple.Recorder of {file}: closed>"


def test_pages_that_are_not_complete_and_stages_are_shown_as_text(cube, tmp_path, page, monkeypatch):
    sim = supple.Simulation(supple.Body(cube, lattice_vertices=30), fps=30)
    with supple.Recorder(sim, tmp_path / "open.html") as recorder:
        recorder.record()
        assert recorder._repr_html_() is None
        assert repr(recorder).endswith("open.html: open, frames: 1>")
    assert recorder._repr_html_() is not None
    assert supple.save_usd(sim, tmp_path / "a.usd", 1)._repr_html_() is None
    monkeypatch.setattr(supple.notebook, "_MAX_PAGE", 1000)
    shown = Reader(page._repr_html_())
    assert "too many for a notebook" in shown.texts[0]
    assert 'a "b" & <i>.html' in shown.texts[0]


def test_the_example_writes_a_page(tmp_path):
    command = [sys.executable, "-W", "error", "-m", "supple.example", "first.html", "--frames", "5", "--no-browser"]
    ended = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert ended.stdout.startswith(str(tmp_path / "first.html"))
    assert "6 frames" in (tmp_path / "first.html").read_text(encoding="utf-8")


def test_the_rings_of_the_example_are_closed_and_fall_over_the_peg():
    mesh = example.ring(0.6, 0.22)
    # A torus has 2 pi^2 R r^2; the inscribed polygons of 24 and 48 corners take 1.2 and 0.3 % of it.
    assert mesh.volume == pytest.approx(2 * np.pi**2 * 0.6 * 0.22**2, rel=0.016)
    assert mesh.is_closed
    sim = example.simulation()
    sim.advance(105)
    for body in sim.bodies:
        # The peg of radius 0.18 is within the hole of radius 0.38.
        assert np.linalg.norm(body.center_of_mass[[0, 2]]) < 0.38
        assert body.center_of_mass[1] < 1.5
