"""Sweeps: runs of one scene with different parameters."""

from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from pathlib import Path

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
        with pytest.raises(
            supple.SceneError, match=r"`body\.cube\.half_width` is 0; it must be 0.5 or a whole number of cells"
        ):
            supple.sweep(scene, {"body.cube.half_width": [0]}, client.get_executor(), frames=1)
    for a, b in zip(local, remote, strict=True):
        assert a.parameters == b.parameters
        assert a.report.bodies == b.report.bodies


def test_frames_are_written_to_the_output_directory(scene, tmp_path):
    results = supple.sweep(scene, [{"body.cube.stiffness": 0.5}, {}], output=tmp_path / "out", frames=2)
    for k, result in enumerate(results):
        assert result.report.directory == tmp_path / "out" / str(k)
        assert (tmp_path / "out" / str(k) / "cube_0002.obj").exists()


def test_exceptions_of_a_run_are_raised(scene):
    with pytest.raises(
        supple.SceneError, match=r"`body\.cube\.half_width` is 0; it must be 0.5 or a whole number of cells"
    ):
        supple.sweep(scene, {"body.cube.half_width": [1, 0]}, frames=1)
    with pytest.raises(FileNotFoundError) as caught:
        supple.sweep("none.toml", {}, frames=1)
    assert Path(caught.value.filename).name == "none.toml"


def test_a_failing_run_cancels_the_runs_that_have_not_begun(scene, tmp_path):
    values = [0, *[1] * 40]
    with ThreadPoolExecutor(1) as executor, pytest.raises(supple.SceneError, match="half_width` is 0"):
        supple.sweep(scene, {"body.cube.half_width": values}, executor, frames=3, output=tmp_path / "out")
    assert len(list((tmp_path / "out").glob("*"))) < 20


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
        ({"parameters": [{}, 3]}, r"parameters\[1\] must be a dict, not int"),
    ],
)
def test_wrong_types_are_errors_before_the_first_run(scene, tmp_path, arguments, message):
    with pytest.raises(TypeError, match=message):
        supple.sweep(**{"scene": scene, "parameters": {}, "output": tmp_path / "out", **arguments})
    assert not (tmp_path / "out").exists()
