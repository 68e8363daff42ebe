"""Plots of volumes and studies, the viewer, and conversion to trimesh."""

import json
import pickle
import sys

import numpy as np
import pytest
import trimesh

import supple
from shapes import QUADS


@pytest.fixture
def stretched(cube):
    body = supple.Body(cube, lattice_vertices=64)
    body.positions = body.positions * [1.5, 1, 1]
    return body


def test_to_trimesh_has_the_evaluated_surface(cube, block):
    body = supple.Body(cube, lattice_vertices=100)
    body.positions = body.positions + [0, 3, 0]
    made = body.to_trimesh()
    assert isinstance(made, trimesh.Trimesh)
    assert np.array_equal(made.vertices, body.surface())
    assert np.array_equal(made.faces, cube.faces)
    assert made.is_watertight
    assert made.volume == pytest.approx(8, rel=1e-5)
    assert np.allclose(supple.Body(made, lattice_vertices=100).surface(), made.vertices, atol=1e-6)
    with pytest.raises(ValueError, match=r"the body is a bare lattice .* corrected_positions\(\)"):
        supple.Body(block).to_trimesh()


@pytest.mark.parametrize(
    ("module", "call"),
    [
        ("trimesh", lambda body: body.to_trimesh()),
        ("matplotlib.pyplot", lambda body: supple.plot_volume(body.volume_report())),
        ("polyscope", lambda body: supple.view(body)),
        ("polyscope", lambda body: body.show()),
    ],
)
def test_missing_dependencies_are_errors_with_the_package_to_install(stretched, monkeypatch, module, call):
    monkeypatch.setitem(sys.modules, module, None)
    package = module.partition(".")[0]
    message = f"{package} is not installed; install it with `pip install {package}`"
    with pytest.raises(ModuleNotFoundError, match=message):
        call(stretched)


@pytest.fixture
def pyplot(monkeypatch):
    monkeypatch.setenv("MPLBACKEND", "Agg")
    pyplot = pytest.importorskip("matplotlib.pyplot")
    yield pyplot
    pyplot.close("all")


def test_plot_volume_of_one_report_has_bars_before_and_after(stretched, pyplot):
    report = stretched.volume_report()
    axes = supple.plot_volume(report)
    assert isinstance(axes, pyplot.Axes)
    heights = [bar.get_height() for bar in axes.patches]
    before = [volume[1] / volume[0] for volume in report.volumes.values()]
    after = [volume[2] / volume[0] for volume in report.volumes.values()]
    assert heights == pytest.approx(before + after)
    names = [label.get_text() for label in axes.get_xticklabels()]
    assert names == [f"{name} (kept)" if name == "mesh" else name for name in report.volumes]


def test_plot_volume_of_several_reports_has_lines_over_time(stretched, pyplot):
    sim = supple.Simulation([stretched], gravity=(0, 0, 0))
    reports, times = [], []
    for _ in range(5):
        reports.append(stretched.volume_report())
        times.append(sim.time)
        sim.step()
    _, given = pyplot.subplots()
    assert supple.plot_volume(reports, times, ax=given) is given
    before, after = given.lines[:2]
    assert before.get_xdata().tolist() == times
    assert before.get_ydata() == pytest.approx([one.before / one.rest for one in reports])
    assert after.get_ydata() == pytest.approx(np.ones(5), abs=1e-5)
    assert supple.plot_volume(reports).lines[0].get_xdata().tolist() == [0, 1, 2, 3, 4]


def test_plot_volume_accepts_the_body_of_a_run_report(scene, tmp_path, pyplot):
    run = supple.run(scene, tmp_path / "out", frames=2)
    assert len(supple.plot_volume(run.bodies[0]).patches) == 6


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        (lambda report: ([],), ValueError, "report is an empty list"),
        (lambda report: ([3],), TypeError, "report must be a VolumeReport, or a list of them, not int"),
        (lambda report: (None,), TypeError, "report must be a VolumeReport, a BodyReport, or a list of them, not None"),
        (lambda report: ([report], 3), TypeError, "times must be a list of numbers, not int"),
        (lambda report: ([report], [0, 1]), ValueError, "times has 2 entries; it must have 1, one per report"),
        (lambda report: (report, [0]), ValueError, "times has 1 entries; a single report has no times"),
    ],
)
def test_plot_volume_refuses_invalid_arguments(stretched, pyplot, arguments, error, message):
    with pytest.raises(error, match=message):
        supple.plot_volume(*arguments(stretched.volume_report()))


class _ScriptedImgui:
    """Dear ImGui whose controls with a label in `inputs` return the value there once. `labels` records all controls."""

    def __init__(self, imgui):
        self._imgui, self.inputs, self.labels = imgui, {}, []

    def __getattr__(self, name):
        return getattr(self._imgui, name)

    def _result(self, label, drawn):
        self.labels.append(label)
        return (True, self.inputs.pop(label)) if label in self.inputs else drawn

    def Checkbox(self, label, value):  # noqa: N802
        return self._result(label, self._imgui.Checkbox(label, value))

    def SliderFloat(self, label, value, **limits):  # noqa: N802
        return self._result(label, self._imgui.SliderFloat(label, value, **limits))

    def SliderInt(self, label, value, **limits):  # noqa: N802
        return self._result(label, self._imgui.SliderInt(label, value, **limits))


def _point(method, milliseconds, front=(), **errors):
    unknown = dict.fromkeys(["mesh_volume", "surface_rms", "path"])
    known = {"cells_volume": 0.2, "cell_volumes": 0.3}
    total = {"median": milliseconds, "low": milliseconds, "high": milliseconds}
    timing, finest = {"total": total}, errors.pop("finest", False)
    errors = unknown | known | errors
    return {"method": method, "timing": timing, "errors": errors, "front": list(front), "finest": finest}


STUDY = {
    "points": [
        _point("off", 0.5, ["surface", "volume"], surface_rms=0.1),
        _point("mesh global", 2.0, ["surface", "volume"], surface_rms=0.01, mesh_volume=1e-8),
        _point("mesh global", 1.0, ["surface"], surface_rms=0.02, mesh_volume=2e-8, path={"rms_cells": 1e-6}),
        _point("mesh global", 9.0, surface_rms=0.0, mesh_volume=3e-8, finest=True),
    ]
}


@pytest.mark.parametrize(
    ("error", "points", "front"),
    [
        ("surface", {(0.5, 0.1), (2.0, 0.01), (1.0, 0.02)}, [(0.5, 0.1), (1.0, 0.02), (2.0, 0.01)]),
        ("volume", {(0.5, 0.2), (2.0, 1e-8), (1.0, 2e-8), (9.0, 3e-8)}, [(0.5, 0.2), (2.0, 1e-8)]),
        ("path", {(1.0, 1e-6)}, []),
    ],
)
def test_plot_study_has_points_fronts_and_a_legend(error, points, front, tmp_path, pyplot):
    (tmp_path / "study.json").write_text(json.dumps(STUDY))
    for study in (STUDY, tmp_path, str(tmp_path / "study.json")):
        axes = supple.plot_study(study, error)
        plotted = [tuple(point) for cloud in axes.collections for point in cloud.get_offsets().tolist()]
        assert len(plotted) == len(points)
        assert set(plotted) == points
        assert [tuple(point) for line in axes.lines for point in line.get_xydata().tolist()] == front
        assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
        names = [text.get_text() for text in axes.get_legend().get_texts()]
        assert len(names) == len(axes.collections) + len(axes.lines)


def test_plot_study_refuses_invalid_studies(tmp_path, pyplot):
    with pytest.raises(ValueError, match='error is "speed"; it must be "surface" or "volume"'):
        supple.plot_study(STUDY, "speed")
    with pytest.raises(ValueError, match="study has no points"):
        supple.plot_study({"frames": 3})
    with pytest.raises(FileNotFoundError) as caught:
        supple.plot_study(tmp_path)
    assert caught.value.filename == str(tmp_path / "study.json")


def _screenshot(polyscope, path):
    polyscope.screenshot(str(path), transparent_bg=False)
    pixels = pytest.importorskip("matplotlib.image").imread(path)
    return pixels[..., :3]


def test_the_viewer_renders_steps_and_changes_a_simulation(cube, block, polyscope, tmp_path):
    body = supple.Body(cube, name="cube", lattice_vertices=200, translate=(0, 0.5, 0), stiffness=0.5)
    other = supple.Body(block, name="bare", frequency=8)
    ground = supple.Plane((0, -1, 0), (0, 1, 0))
    sim = supple.Simulation([body, other], dt=1 / 120, colliders=[ground])
    viewer = supple.viewer.Viewer(sim)
    imgui = viewer._imgui = _ScriptedImgui(viewer._imgui)
    for panel in viewer._panels:
        panel._imgui = imgui
    polyscope.frame_tick()
    assert (sim.time, viewer.running) == (0, False)
    assert set(imgui.labels) == {"run", "stiffness", "frequency [Hz]", "half-width [cells]", "keep the volume"}
    before = _screenshot(polyscope, tmp_path / "before.png")

    imgui.inputs = {"run": True, "stiffness": 0.25, "frequency [Hz]": 5.0, "keep the volume": False}
    for _ in range(20):
        polyscope.frame_tick()
    assert sim.time == pytest.approx(20 * 2 / 120)
    assert (body.stiffness, other.frequency) == (0.25, 5.0)
    assert body.volume_options["measure"] == "off"
    imgui.inputs = {"half-width [cells]": 3, "keep the volume": True, "run": False}
    polyscope.frame_tick()
    assert (body.half_width, body.volume_options["measure"], viewer.running) == (3, "auto", False)
    after = _screenshot(polyscope, tmp_path / "after.png")
    assert before.std() > 0.01
    assert np.abs(after - before).max() > 0.1


def test_the_viewer_renders_a_body_without_a_simulation(cube, polyscope, tmp_path):
    body = supple.Body(cube, lattice_vertices=64)
    viewer = supple.viewer.Viewer(body)
    assert np.allclose(viewer._panels[0].low, -1)
    polyscope.frame_tick()
    assert _screenshot(polyscope, tmp_path / "body.png").std() > 0.01
    with pytest.raises(TypeError, match="target must be a Simulation or a Body, not Mesh"):
        supple.view(cube)


def test_the_viewer_shows_planes_while_they_are_enabled(cube, polyscope):
    planes = [supple.Plane((0, -3, 0), (0, 1, 0), enabled=enabled) for enabled in (True, False, [(9, False)])]
    sim = supple.Simulation([supple.Body(cube, lattice_vertices=64)], colliders=planes)
    viewer = supple.viewer.Viewer(sim)
    squares = [polyscope.get_surface_mesh(f"plane {index}") for index in range(3)]
    assert [square.is_enabled() for square in squares] == [True, False, True]
    sim.colliders[1].enabled = True
    sim.time = 9
    polyscope.frame_tick()
    assert viewer.running is False
    assert [square.is_enabled() for square in squares] == [True, True, False]
    sim.colliders[0].enabled = False
    polyscope.frame_tick()
    assert [square.is_enabled() for square in squares] == [False, True, False]
    sim.colliders = [supple.Plane((0, -3, 0), (0, 1, 0))]
    polyscope.frame_tick()
    assert not any(square.is_enabled() for square in squares), "the planes are no longer those of the simulation"


def test_the_viewer_of_a_body_steps_its_simulation(cube, polyscope):
    body = supple.Body(cube, lattice_vertices=64, half_width=2)
    assert body.simulation is None
    sim = supple.Simulation([body])
    assert body.simulation is sim
    viewer = supple.viewer.Viewer(body)
    viewer.running = True
    polyscope.frame_tick()
    assert sim.time == pytest.approx(1 / 60)


def test_the_viewer_renders_bodies_of_equal_name(cube, polyscope):
    bodies = [supple.Body(cube, name="#", lattice_vertices=64, translate=(3 * k, 0, 0)) for k in range(2)]
    supple.viewer.Viewer(supple.Simulation(bodies))
    assert polyscope.get_surface_mesh("- [0]").n_vertices() == len(np.unique(QUADS))
    assert polyscope.has_surface_mesh("- [1]")


def test_the_smooth_skin_is_exact_at_rest_and_removes_creases(bust):
    def bent(skin):
        body = supple.Body(bust, lattice_vertices=300, skin=skin, volume="off")
        x, y, z = body.positions.T
        body.positions = np.stack([x + 0.2 * (y - 7) ** 2, y, z], axis=1)
        return body

    rest = supple.Body(bust, lattice_vertices=300, skin="smooth")
    assert rest.skin == "smooth"
    np.testing.assert_allclose(rest.surface(), rest.mesh.vertices, atol=1e-5)
    exact = rest.mesh.vertices.copy()
    exact[:, 0] += 0.2 * (exact[:, 1] - 7) ** 2
    errors = {skin: np.abs(bent(skin).surface() - exact) for skin in ("linear", "smooth")}
    # The linear skin is off by up to 1/8 of the second derivative, 0.4, times the squared cell size. The smooth skin is
    # exact for motions with y², except in the lowest and highest cells, whose slopes are one-sided.
    cell = rest.lattice.cell_size
    assert 0.9 < errors["linear"].max() / (0.05 * cell**2) < 1.01
    y = rest.mesh.vertices[:, 1]
    links = {tuple(index) for index in rest.lattice.indices}
    cells = np.floor((rest.mesh.vertices - rest.lattice.origin) / cell).astype(int)
    corners = np.array([[i & 1, i >> 1 & 1, i >> 2 & 1] for i in range(8)])
    inner = np.array(
        [all(tuple(c + corner + [0, s, 0]) in links for corner in corners for s in (-1, 1)) for c in cells]
    )
    assert inner.sum() > 100
    assert np.ptp(y[inner]) > 1
    assert errors["smooth"][inner].max() < 2e-5


def test_skin_is_kept_by_pickles_and_other_names_are_errors(cube):
    assert supple.Body(cube).skin == "linear"
    body = supple.Body(cube, skin="smooth")
    assert pickle.loads(pickle.dumps(body)).skin == "smooth"
    assert "smooth skin" in supple.Simulation([body]).plan()
    with pytest.raises(ValueError, match='skin is "soft"; it must be one of "linear", "smooth"'):
        supple.Body(cube, skin="soft")
    with pytest.raises(TypeError, match="skin must be"):
        supple.Body(cube, skin=1)
