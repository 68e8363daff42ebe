"""Sweeps: runs of one scene with different parameters."""

import json
import os
from concurrent.futures import BrokenExecutor, ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest

import supple

PARAMETERS = {"body.cube.half_width": [1, 2], "body.cube.region_damping": [0.0, 0.2]}


def test_sweep_runs_all_combinations_in_order(scene):
    results = supple.sweep(scene, PARAMETERS, frames=3)
    assert [tuple(result.parameters.values()) for result in results] == [(1, 0.0), (1, 0.2), (2, 0.0), (2, 0.2)]
    assert all(result.report.outcome == "finished" for result in results)
    assert not any(result.report.directory.exists() for result in results)


def test_executors_change_no_bit(scene):
    local = supple.sweep(scene, PARAMETERS, frames=5)
    with ThreadPoolExecutor(2) as executor:
        threads = supple.sweep(scene, PARAMETERS, executor, frames=5)
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as executor:
        processes = supple.sweep(str(scene), PARAMETERS, executor, frames=5)
    for other in (threads, processes):
        for a, b in zip(local, other, strict=True):
            assert a.parameters == b.parameters
            assert a.report.bodies == b.report.bodies


# Dask warns of slow machines and used ports, and leaves sockets to the garbage collector.
@pytest.mark.filterwarnings("ignore")
def test_a_dask_cluster_changes_no_bit(scene, tmp_path):
    distributed = pytest.importorskip("distributed")
    local = supple.sweep(scene, PARAMETERS, frames=5)
    settings = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": None, "local_directory": str(tmp_path)}
    with distributed.LocalCluster(processes=True, **settings) as cluster, distributed.Client(cluster) as client:
        assert len(client.scheduler_info()["workers"]) == 2
        remote = supple.sweep(scene, PARAMETERS, client.get_executor(), frames=5)
        (failed,) = supple.sweep(scene, {"body.cube.half_width": [0]}, client.get_executor(), frames=1)
        assert isinstance(failed.error, supple.SceneError)
    for a, b in zip(local, remote, strict=True):
        assert a.parameters == b.parameters
        assert a.report.bodies == b.report.bodies


def test_frames_are_written_to_the_output_directory(scene, tmp_path):
    results = supple.sweep(scene, [{"body.cube.stiffness": 0.5}, {}], output=tmp_path / "out", frames=2)
    for k, result in enumerate(results):
        assert result.report.directory == tmp_path / "out" / str(k)
        assert (tmp_path / "out" / str(k) / "cube_0002.obj").exists()


def height(simulation):
    """Measure the height of the cube."""
    return float(simulation["cube"].center_of_mass[1])


def test_a_failed_run_loses_no_other(scene, tmp_path):
    values = [1, 0, 2]
    results = supple.sweep(scene, {"body.cube.half_width": values}, frames=1, output=tmp_path / "out")
    assert [result.index for result in results] == [0, 1, 2]
    assert [result.parameters["body.cube.half_width"] for result in results] == values
    assert [result.error is None for result in results] == [True, False, True]
    assert results[2].report.outcome == "finished"
    failed = results[1]
    assert isinstance(failed.error, supple.SceneError)
    message = r"`body\.cube\.half_width` is 0; it must be 0.5 or a whole number of cells"
    with pytest.raises(supple.SceneError, match=message) as caught:
        _ = failed.report
    if hasattr(caught.value, "__notes__"):
        assert caught.value.__notes__ == ["in run 1 of the sweep, with the parameters {'body.cube.half_width': 0}"]
    (missing,) = supple.sweep("none.toml", {}, frames=1)
    assert isinstance(missing.error, FileNotFoundError)
    assert Path(missing.error.filename).name == "none.toml"


def test_a_failed_run_of_an_executor_loses_no_other(scene):
    for executor in (ThreadPoolExecutor(2), ProcessPoolExecutor(2, mp_context=get_context("spawn"))):
        with executor:
            results = supple.sweep(scene, {"body.cube.half_width": [0, 1]}, executor, frames=1)
        assert isinstance(results[0].error, supple.SceneError)
        assert results[1].report.outcome == "finished"


def die(simulation):
    """End the process of a run."""
    os._exit(3)


def test_a_process_that_dies_is_an_error_of_its_runs(scene):
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as executor:
        results = supple.sweep(scene, {"body.cube.half_width": [1, 2]}, executor, frames=1, measure=die)
    assert all(isinstance(result.error, BrokenExecutor) for result in results)


def test_measure_sees_the_simulation_after_the_last_frame(scene, tmp_path):
    gravity = {"simulation.gravity": [[0, -1, 0], [0, -2, 0]]}
    results = supple.sweep(scene, gravity, frames=3, measure=height)
    assert results[0].measured > results[1].measured
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as executor:
        others = supple.sweep(scene, gravity, executor, frames=3, measure=height, output=tmp_path / "out")
    assert [result.measured for result in others] == [result.measured for result in results]

    (wrong,) = supple.sweep(scene, {}, frames=1, measure=lambda simulation: simulation["none"])
    assert isinstance(wrong.error, KeyError)


def test_a_sweep_lists_its_parameters_and_outcomes(scene, tmp_path):
    out = tmp_path / "out"
    parameters = {"body.cube.half_width": np.array([1, 0]), "output.format": ["ply"]}
    supple.sweep(scene, parameters, frames=1, output=out, measure=height)
    listed = json.loads((out / "sweep.json").read_text())
    assert (listed["program"], listed["version"], listed["scene"]) == ("supple", supple.__version__, scene.name)
    first, second = listed["runs"]
    assert first["parameters"] == {"body.cube.half_width": 1, "output.format": "ply"}
    assert (first["index"], first["directory"], first["outcome"]) == (0, "0", "finished")
    assert first["measured"] > 0
    assert (second["index"], second["outcome"]) == (1, "failed")
    assert second["error"].startswith("SceneError: ")
    assert json.loads((out / "0" / "manifest.json").read_text())["outcome"] == "finished"


def test_a_sweep_can_be_resumed(scene, tmp_path):
    out = tmp_path / "out"
    parameters = {"body.cube.half_width": [1, 2]}
    calls = []

    def measure(simulation):
        calls.append(simulation)
        return height(simulation)

    whole = supple.sweep(scene, parameters, frames=4, measure=measure)
    supple.sweep(scene, {"body.cube.half_width": [1]}, frames=4, output=out, measure=measure)
    calls.clear()
    again = supple.sweep(scene, parameters, frames=4, output=out, measure=measure, resume=True)
    assert [result.report.outcome for result in again] == ["already finished", "finished"]
    assert [result.measured for result in again] == [result.measured for result in whole]
    assert len(calls) == 1
    # What was not measured before is simulated again.
    supple.sweep(scene, parameters, frames=4, output=out)
    again = supple.sweep(scene, parameters, frames=4, output=out, measure=measure, resume=True)
    assert [result.measured for result in again] == [result.measured for result in whole]
    # The directory of other parameters is not continued.
    with pytest.warns(supple.ResumeWarning, match="half_width = 1"):
        (other,) = supple.sweep(scene, {"body.cube.half_width": [3]}, frames=4, output=out, resume=True)
    assert other.report.outcome == "finished"


def test_progress_is_called_after_each_run_and_can_end_the_sweep(scene, tmp_path):
    seen = []
    results = supple.sweep(scene, PARAMETERS, frames=1, progress=seen.append)
    assert [(step.done, step.total) for step in seen] == [(k, 4) for k in (1, 2, 3, 4)]
    assert [step.result for step in seen] == results

    def refuse(step):
        raise RuntimeError("enough")

    values = [1] * 40
    with ThreadPoolExecutor(1) as executor, pytest.raises(RuntimeError, match="enough"):
        supple.sweep(scene, {"body.cube.half_width": values}, executor, frames=3, output=tmp_path, progress=refuse)
    assert len(list(tmp_path.glob("*/cube_0003.obj"))) < 20


def test_failed_runs_are_retried_and_continue(scene, tmp_path):
    class Unreliable:
        calls = 0

        def __call__(self, simulation):
            self.calls += 1
            if self.calls < 3:
                raise OSError("the disk is away")
            return self.calls

    (result,) = supple.sweep(scene, {}, frames=2, output=tmp_path, measure=Unreliable(), retries=2)
    assert (result.error, result.measured, result.attempts) == (None, 3, 3)
    (result,) = supple.sweep(scene, {}, frames=2, measure=Unreliable(), retries=1)
    assert isinstance(result.error, OSError)
    assert result.attempts == 2
    (result,) = supple.sweep(scene, {"body.cube.half_width": [0]}, frames=2, retries=5)
    assert result.attempts == 1, "an invalid scene is not tried again"


def test_retries_and_resume_are_checked(scene):
    with pytest.raises(ValueError, match="retries is -1; it must be at least 0"):
        supple.sweep(scene, {}, retries=-1)
    with pytest.raises(ValueError, match="resume needs output"):
        supple.sweep(scene, {}, resume=True)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"executor": "x"}, r"executor must be a concurrent\.futures\.Executor, not str"),
        ({"scene": 3}, r"scene must be a path \(str or os\.PathLike\), not int"),
        ({"parameters": {"a": 3}}, r"parameters: a must be a list of values, not int; pass \[3\] for one value"),
        (
            {"parameters": {"a": "off"}},
            r"parameters: a must be a list of values, not str; pass \['off'\] for one value",
        ),
        ({"parameters": {"a": {"b": 1}}}, r"parameters: a must be a list of values, not dict; pass \[\{'b': 1\}\]"),
        ({"parameters": 3}, "parameters must be a dict of lists or a list of dicts, not int"),
        ({"parameters": "a"}, "parameters must be a dict of lists or a list of dicts, not str"),
        ({"measure": 3}, "measure must be callable, not int"),
        ({"progress": 3}, "progress must be callable, not int"),
        ({"resume": "auto"}, "resume must be True or False, not str"),
        ({"retries": 1.5}, "retries must be a whole number, not float"),
        ({"parameters": [{}, 3]}, r"parameters\[1\] must be a dict, not int"),
    ],
)
def test_wrong_types_are_errors_before_the_first_run(scene, tmp_path, arguments, message):
    with pytest.raises(TypeError, match=message):
        supple.sweep(**{"scene": scene, "parameters": {}, "output": tmp_path / "out", **arguments})
    assert not (tmp_path / "out").exists()
