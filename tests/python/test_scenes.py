"""Loading and running scenes."""

import gc
import os
import pickle
import signal
import threading
from functools import partial

import numpy as np
import pytest
import trimesh

import supple


def test_a_loaded_scene_is_a_live_simulation(scene):
    sim = supple.load_scene(scene)
    assert isinstance(sim, supple.Simulation)
    assert sim.dt == pytest.approx(1 / 60)
    assert sim.steps_per_frame == 2
    assert sim.colliders == (supple.Plane((0, 0, 0), (0, 1, 0)),)
    (body,) = sim.bodies
    assert body.name == "cube"
    assert body.region_damping == 0.1
    assert len(body) == 125
    with pytest.raises(ValueError, match="already belongs"):
        supple.Simulation([body])
    twin = pickle.loads(pickle.dumps(sim))
    for each in (sim, twin):
        each.step(10)
    assert twin.bodies[0].positions.tobytes() == body.positions.tobytes()
    assert pickle.loads(pickle.dumps((sim, body)))[1].name == "cube"


def test_a_body_of_a_loaded_scene_keeps_the_simulation_alive(scene):
    (body,) = supple.load_scene(scene).bodies
    gc.collect()
    before = body.positions
    body.simulation.step(10)
    assert body.positions.tobytes() != before.tobytes()
    assert body.simulation.bodies == (body,)


def test_the_pins_of_a_scene_can_be_driven(scene):
    body = supple.load_scene(scene).bodies[0]
    (pin,) = body.holds
    assert (pin.keys, pin.start, pin.end) == (None, 0, 0.1)
    top = pin.vertices
    assert np.all(body.positions[top, 1] > 1.5)
    start = body.positions[top]
    pin.set_keys([(0, (0, 0.5, 0))])
    body.simulation.step(3)
    assert np.allclose(body.positions[top], start + [0, 0.5, 0], atol=1e-5)
    pin.release()
    assert body.holds == ()


def test_overrides_change_the_loaded_scene(scene):
    overrides = {
        "simulation.fps": 25,
        "simulation.gravity": np.zeros(3),
        "body.cube.half_width": 1,
        "body.cube.volume": {"measure": "cells"},
        "body.cube.pin": [],
        "collider.0.friction": 0.9,
    }
    sim = supple.load_scene(str(scene), overrides=overrides)
    assert sim.dt == pytest.approx(1 / 50)
    assert sim.gravity.tolist() == [0, 0, 0]
    assert sim.bodies[0].half_width == 1
    assert sim.bodies[0].volume_report().measure == "cells"
    assert sim.colliders[0].friction == 0.9
    with pytest.raises(
        supple.SceneError,
        match=r"^overrides: .*unknown key `body\.cube\.half_widht`; the nearest one is `half_width`",
    ) as caught:
        supple.load_scene(scene, overrides={"body.cube.half_widht": 1})
    assert "--set" not in str(caught.value)
    for call in (supple.load_scene, supple.run):
        with pytest.raises(supple.SceneError, match=r"^overrides: body\.cube\.half_width=0: ") as caught:
            call(scene, overrides={"body.cube.half_width": 0})
        assert "--set" not in str(caught.value)
        for overrides, message in [
            (["a=1"], r'overrides must be a dict such as \{"body\.bust\.half_width": 3\}, not list'),
            ("a=1", "overrides must be a dict .*, not str"),
            ({3: 1}, "overrides: a key path must be a string, not int: 3"),
        ]:
            with pytest.raises(TypeError, match=message):
                call(scene, overrides=overrides)
    with pytest.raises(TypeError, match="cannot have a value of type object"):
        supple.load_scene(scene, overrides={"simulation.frames": object()})


def test_run_writes_the_evaluated_surface(scene, tmp_path):
    calls = []
    report = supple.run(scene, tmp_path / "out", "ply", 6, calls.append)
    assert isinstance(report, supple.RunReport)
    assert (report.outcome, report.last, report.simulated, report.written, report.substeps) == ("finished", 6, 7, 7, 2)
    assert report.directory == tmp_path / "out"
    assert [progress.frame for progress in calls] == list(range(7))
    assert calls[-1].last == 6
    assert calls[-1].time == pytest.approx(6 / 30)
    assert report.bodies[0].name == "cube"
    assert abs(report.bodies[0].volume.residual) < 1e-5
    sim = supple.load_scene(scene)
    sim.step(2 * 6)
    written = trimesh.load(tmp_path / "out" / "cube_0006.ply", process=False)
    assert np.array_equal(written.vertices, sim.bodies[0].surface().astype(np.float32))
    assert pickle.loads(pickle.dumps(report)) == report


def test_a_loaded_scene_has_the_steps_and_materials_of_its_keys(scene):
    sim = supple.load_scene(scene)
    (body,) = sim.bodies
    assert (sim.fps, sim.substeps, sim.steps_per_frame, sim.sleep) == (30, 2, 2, True)
    assert (body.material, body.damping_ratio, body.region_damping) == ("flesh", 0.3, 0.1)
    for keys, expected in [
        ({"material": "jelly", "damping_rate": 3}, {"material": "jelly", "damping_rate": 3, "damping_ratio": None}),
        (
            {"youngs_modulus": 1e5, "damping_ratio": 0.5},
            {"material": None, "youngs_modulus": 1e5, "damping_ratio": 0.5},
        ),
        ({"stiffness_radius": 1.5, "frequency": 4}, {"stiffness_radius": 1.5, "frequency": 4, "material": None}),
        ({"half_width": 1, "stiffness": 0.5}, {"half_width": 1, "stiffness": 0.5, "material": None}),
    ]:
        overrides = {f"body.cube.{key}": value for key, value in keys.items()}
        overrides |= {"simulation.sleep": False, "simulation.substeps": "auto"}
        sim = supple.load_scene(scene, overrides=overrides)
        sim.advance(3)
        twin = pickle.loads(pickle.dumps(sim))
        for each in (sim, twin):
            each.advance(3)
            assert (each.fps, each.substeps, each.sleep) == (30, "auto", False)
            assert {name: getattr(each.bodies[0], name) for name in expected} == pytest.approx(expected)
        assert twin.bodies[0].positions.tobytes() == sim.bodies[0].positions.tobytes()


def test_reports_name_frames_without_the_volume_and_frequencies_that_are_too_high(scene, tmp_path):
    (kept,) = supple.run(scene, tmp_path / "kept", "pc2", overrides={"body.cube.poisson_ratio": 0}).bodies
    assert (kept.unkept_volume, kept.softened) == (None, None)
    overrides = {"body.cube.volume": {"max_correction": 1e-9}, "body.cube.frequency": 25}
    report = supple.run(scene, tmp_path / "out", "pc2", start_frame=1001, overrides=overrides)
    (body,) = report.bodies
    assert body.softened == supple.Softened("frequency", 25.0, pytest.approx(10.0), 1.0, 2, 5)
    unkept = body.unkept_volume
    assert 1 <= unkept.frames < unkept.written == report.written
    assert 1001 < unkept.worst_frame <= 1001 + report.last
    assert 1e-3 < abs(unkept.worst_error) < 1
    assert pickle.loads(pickle.dumps(report)) == report


@pytest.mark.skipif(os.name == "nt", reason="names of files cannot have control characters")
def test_messages_escape_control_characters_of_paths(scene, tmp_path):
    name = "a\n\x1b[2J\u202e"
    (tmp_path / name).write_text("")
    for options, error in [
        ({"output": tmp_path / name}, supple.OutputError),
        ({"output": tmp_path / name / "out"}, supple.OutputError),
        ({"stats": tmp_path / name}, supple.SceneError),
    ]:
        with pytest.raises(error) as caught:
            supple.run(scene, **({"output": tmp_path / "out"} | options))
        message = str(caught.value)
        assert message.isprintable(), message
        assert r"a\n\u{1b}[2J\u{202e}" in message


def test_run_writes_several_formats(scene, tmp_path):
    overrides = {"output.format": ["ply", "html"]}
    supple.run(scene, tmp_path / "a", ["ply", "html"], 1)
    supple.run(scene, tmp_path / "b", frames=1, overrides=overrides)
    for out in ["a", "b"]:
        names = {path.name for path in (tmp_path / out).iterdir() if path.suffix in {".ply", ".html"}}
        assert {"supple.html", "cube_0000.ply", "cube_0001.ply"} == names
    assert (tmp_path / "a" / "supple.html").read_bytes() == (tmp_path / "b" / "supple.html").read_bytes()


def test_run_uses_the_output_settings_of_the_scene(scene, tmp_path):
    report = supple.run(scene, every=4, start_frame=100, stats=tmp_path / "stats.csv")
    names = sorted(os.listdir(tmp_path / "frames"))
    assert [name for name in names if name.endswith(".obj")] == [f"cube_{100 + k:04}.obj" for k in (0, 4, 8, 12)]
    assert report.written == 4
    assert len((tmp_path / "stats.csv").read_text().splitlines()) == 1 + 4


def test_a_run_can_be_stopped_and_resumed(scene, tmp_path):
    whole = supple.run(scene, tmp_path / "whole")
    stopped = supple.run(scene, tmp_path / "out", progress=lambda progress: progress.frame < 5)
    assert (stopped.outcome, stopped.last) == ("stopped", 5)
    resumed = supple.run(scene, tmp_path / "out", resume=True)
    assert (resumed.outcome, resumed.resumed_after, resumed.last) == ("finished", 5, whole.last)
    for frame in range(13):
        name = f"cube_{frame:04}.obj"
        assert (tmp_path / "out" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()
    assert supple.run(scene, tmp_path / "out", resume=True).outcome == "already finished"
    assert supple.run(scene, tmp_path / "out", resume="auto").outcome == "already finished"


def test_an_automatic_resume_starts_again_if_the_scene_has_changed(scene, tmp_path):
    out, changed = tmp_path / "out", {"simulation.gravity": [0, -1, 0]}
    supple.run(scene, out, frames=3)
    with pytest.raises(supple.SceneError, match="gravity"):
        supple.run(scene, out, frames=3, overrides=changed, resume=True)
    with pytest.warns(supple.ResumeWarning, match="gravity.*starting again from frame 0"):
        report = supple.run(scene, out, frames=3, overrides=changed, resume="auto")
    assert (report.outcome, report.resumed_after) == ("finished", None)
    with pytest.raises(ValueError, match='resume is "always"; it must be "auto"'):
        supple.run(scene, out, resume="always")
    with pytest.raises(TypeError, match='resume must be True, False or "auto", not int'):
        supple.run(scene, out, resume=3)


def test_changes_by_a_callback_survive_stopping_and_resuming(scene, tmp_path):
    def drive(progress, last, surfaces):
        sim = progress.simulation
        assert sim.time == progress.time
        (body,) = sim.bodies
        assert body.name == "cube"
        if progress.frame == 2:
            sim.gravity = (0, 0, 0)
            body.half_width = 1
        body.apply_force((1e5, 0, 0), vertices=[0, 1])
        surfaces.append(body.surface())
        return progress.frame != last

    whole, parts = [], []
    supple.run(scene, tmp_path / "whole", "ply", 8, partial(drive, last=None, surfaces=whole))
    supple.run(scene, tmp_path / "parts", "ply", 8, partial(drive, last=5, surfaces=parts))
    supple.run(scene, tmp_path / "parts", "ply", 8, partial(drive, last=None, surfaces=parts), resume=True)
    assert len(parts) == len(whole) == 9
    assert np.array_equal(parts[-1], whole[-1])
    written = [trimesh.load(tmp_path / name / "cube_0008.ply", process=False).vertices for name in ("whole", "parts")]
    assert np.array_equal(written[0], whole[-1].astype(np.float32))
    assert np.array_equal(*written)
    supple.run(scene, tmp_path / "alone", "ply", 8)
    alone = trimesh.load(tmp_path / "alone" / "cube_0008.ply", process=False).vertices
    assert np.abs(alone - written[0]).max() > 0.01


def test_the_simulation_of_a_run_stays_valid_after_it(scene, tmp_path):
    calls = []
    supple.run(scene, tmp_path / "out", frames=3, progress=calls.append)
    sim = calls[-1].simulation
    assert all(progress.simulation is sim for progress in calls)
    twin = supple.load_scene(scene)
    twin.step(2 * 3)
    for each in (sim, twin):
        each.step(2)
    assert sim.bodies[0].positions.tobytes() == twin.bodies[0].positions.tobytes()


def test_an_exception_of_a_callback_ends_the_run(scene, tmp_path):
    def fail(progress):
        if progress.frame == 3:
            raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        supple.run(scene, tmp_path / "out", progress=fail)
    assert (tmp_path / "out" / "cube_0003.obj").exists()
    assert not (tmp_path / "out" / "cube_0004.obj").exists()


@pytest.mark.usefixtures("interruptible")
def test_ctrl_c_ends_a_run_after_a_frame(scene, tmp_path):
    timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        supple.run(scene, tmp_path / "out", frames=1_000_000)
    timer.join()
    assert supple.run(scene, tmp_path / "out", frames=20, resume=True).outcome in ("finished", "already finished")


def test_a_model_is_loaded_with_a_default_scene(scene, tmp_path):
    sim = supple.load_scene(tmp_path / "cube.obj")
    (body,) = sim.bodies
    assert body.name == "cube"
    (ground,) = sim.colliders
    assert isinstance(ground, supple.Plane)
    assert tuple(ground.normal) == (0, 1, 0)
    # It falls its own height of 2 in half a second.
    assert np.allclose(sim.gravity, (0, -16, 0), rtol=1e-4)


def test_invalid_scenes_are_errors_with_file_line_and_key(scene, tmp_path):
    for call in (supple.load_scene, supple.run):
        for name in ("none.toml", "none.obj", "none.txt"):
            with pytest.raises(FileNotFoundError) as caught:
                call(tmp_path / name)
            assert caught.value.filename == str(tmp_path / name)
        with pytest.raises(TypeError, match=r"path must be a path .*, not int"):
            call(3)
    text = scene.read_text()
    for wrong, message in [
        ("frames = 12", None),
        ("frames = -1", r"fall\.toml:3: `simulation\.frames` is -1; it must be a whole number from 0"),
        ("frams = 12", "`simulation.frams`; the nearest one is `frames`"),
        ("frames = ", r"fall\.toml:3: .*TOML"),
    ]:
        scene.write_text(text.replace("frames = 12", wrong))
        if message:
            with pytest.raises(supple.SceneError, match=message) as caught:
                supple.load_scene(scene)
            assert isinstance(caught.value, ValueError)
    scene.write_text(text.replace("min = [-2, 2, -2]", "min = [-2, 2.9, -2]"))
    with pytest.raises(supple.SceneError, match=r"body\.cube\.pin\.0: the box selects nothing"):
        supple.load_scene(scene)
    scene.write_text(text.replace("lattice_vertices = 125", "cell_size = 1e-6"))
    with pytest.raises(supple.LatticeError, match=r"cells of size 1\.0000e-6 .* a cell size of .* would fit"):
        supple.load_scene(scene)
    scene.write_text(text.replace("cube.obj", "bad.obj"))
    (tmp_path / "bad.obj").write_text("v 0 0 0\n")
    with pytest.raises(supple.MeshError, match=r"bad\.obj.*no faces"):
        supple.load_scene(scene)
    scene.write_text(text.replace("cube.obj", "none.obj"))
    with pytest.raises(FileNotFoundError) as caught:
        supple.run(scene, tmp_path / "out")
    assert caught.value.filename == str(tmp_path / "none.obj")
    assert not (tmp_path / "out").exists()


def test_invalid_outputs_are_errors(scene, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(
        supple.OutputError, match=r"the output directory .*/file is a file; choose a directory"
    ) as caught:
        supple.run(scene, tmp_path / "file")
    assert isinstance(caught.value, OSError)
    for settings, error, message in [
        ({"format": "stl"}, ValueError, 'format is "stl"; it must be one of "obj",'),
        ({"format": ["obj", "stl"]}, ValueError, r'format\[1\] is "stl"; it must be one of "obj",'),
        ({"format": []}, ValueError, r"format is \[\]; it must be a list with at least one format"),
        ({"format": 3}, TypeError, "format must be a format like .*, or a list like .*, not int"),
        ({"frames": -1}, ValueError, "frames = -1 is out of range: it must be a whole number, at least 0"),
        ({"every": 0}, ValueError, "every = 0 is out of range: it must be a whole number, at least 1"),
        ({"stats": tmp_path / "stats.txt"}, ValueError, r"stats\.txt must end in \.csv or \.json"),
        ({"frames": "all"}, TypeError, "frames must be a whole number, not str"),
        ({"progress": 3}, TypeError, "progress must be callable, not int"),
    ]:
        with pytest.raises(error, match=message):
            supple.run(scene, tmp_path / "out", **settings)
        assert not (tmp_path / "out").exists()
