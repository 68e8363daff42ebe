"""Frames, steps per frame, and sleep."""

import copy
import os
import pickle
import signal
import threading
import time

import numpy as np
import pytest

import supple

COPIES = [copy.deepcopy, lambda sim: pickle.loads(pickle.dumps(sim))]


def test_steps_per_frame_with_and_without_fps(block):
    sim = supple.Simulation([supple.Body(block)])
    assert (sim.dt, sim.fps, sim.substeps, sim.steps_per_frame, sim.sleep) == (1 / 60, None, 1, 1, True)
    sim = supple.Simulation([supple.Body(block, half_width=2)], fps=25, substeps=4)
    assert (sim.dt, sim.fps, sim.substeps, sim.steps_per_frame) == (0.01, 25, 4, 4)
    sim = supple.Simulation([supple.Body(block)], fps=24)
    assert sim.substeps == "auto"
    assert sim.steps_per_frame > 1
    assert sim.dt == pytest.approx(1 / (24 * sim.steps_per_frame), rel=1e-15)
    with pytest.raises(ValueError, match="dt cannot be set, because the simulation has fps = 24; set substeps"):
        sim.dt = 0.1
    sim.substeps = 5
    assert (sim.substeps, sim.steps_per_frame, sim.dt) == (5, 5, 1 / 120)
    for value, error in [(0, ValueError), ("all", ValueError), (None, TypeError), (1.5, TypeError)]:
        with pytest.raises(error, match="substeps"):
            sim.substeps = value
    assert sim.substeps == 5


def test_auto_is_evaluated_anew_when_it_is_set(block):
    body = supple.Body(block, half_width=2)
    sim = supple.Simulation([body], fps=30, gravity=(0, 0, 0))
    sim.advance()
    assert sim.steps_per_frame == 1
    # 45 length/s with cells of 0.5: 90 steps per second.
    body.handle(vertices=[0], keys=[(0,), (1, (45, 0, 0))])
    sim.advance()
    assert sim.steps_per_frame == 1
    sim.substeps = "auto"
    assert sim.substeps == "auto"
    sim.advance()
    assert sim.steps_per_frame == 3
    plain = supple.Simulation([supple.Body(block)])
    with pytest.raises(ValueError, match='substeps = "auto" needs fps'):
        plain.substeps = "auto"
    plain.substeps = 2
    assert (plain.substeps, plain.dt) == (2, 1 / 60)


def test_advance_runs_whole_frames(block):
    bodies = [supple.Body(block, spin=(0, 0, 1)) for _ in range(2)]
    sim, twin = (supple.Simulation([body], fps=30) for body in bodies)
    sim.advance(5)
    assert sim.time == pytest.approx(5 / 30)
    sim.advance(0)
    sim.advance()
    twin.step(6 * twin.steps_per_frame)
    assert sim.time == twin.time == pytest.approx(6 / 30)
    assert bodies[0].positions.tobytes() == bodies[1].positions.tobytes()
    for frames, error in [(-1, ValueError), (1.0, TypeError), (None, TypeError)]:
        with pytest.raises(error, match="frames"):
            sim.advance(frames)
    message = r"advance\(\) needs the number of frames per second; build the Simulation with fps= in place of dt="
    with pytest.raises(ValueError, match=message):
        supple.Simulation([supple.Body(block)]).advance()


@pytest.mark.usefixtures("interruptible")
def test_ctrl_c_ends_a_long_advance(block):
    sim = supple.Simulation([supple.Body(block, spin=(0, 0, 1))], fps=30, gravity=(0, 0, 0))
    timer = threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    start = time.perf_counter()
    with pytest.raises(KeyboardInterrupt):
        sim.advance(2**60)
    assert time.perf_counter() - start < 5
    timer.join()
    assert sim.time > 0


@pytest.mark.parametrize("again", COPIES)
@pytest.mark.parametrize("steps", [0, 7])
@pytest.mark.parametrize("change", [{}, {"substeps": 9}, {"substeps": "auto"}])
def test_a_copy_keeps_fps_substeps_and_sleep(cube, again, steps, change):
    body = supple.Body(cube, lattice_vertices=200, material="flesh", translate=(0, 1.1, 0))
    ground = supple.Plane((0, 0, 0), (0, 1, 0))
    sim = supple.Simulation([body], fps=30, colliders=ground, sleep=False)
    sim.step(steps)
    body.handle(vertices=[0], keys=[(0,), (1, (0, 60, 0))], end=0.5)
    for name, value in change.items():
        setattr(sim, name, value)
    twin = again(sim)
    for each in (sim, twin):
        each.advance(2)
    for name in ("fps", "substeps", "steps_per_frame", "sleep", "dt", "time"):
        assert getattr(twin, name) == getattr(sim, name), name
    assert twin.bodies[0].positions.tobytes() == body.positions.tobytes()
    assert twin.bodies[0].half_width == body.half_width


def test_a_body_at_rest_sleeps_until_something_moves_it(block):
    body = supple.Body(block)
    body.pin(vertices=block.indices[:, 0] == 0)
    sim = supple.Simulation([body], fps=30)
    sim.advance(150)
    assert body.is_asleep
    assert not body.velocities.any()
    positions = body.positions
    sim.advance(10)
    assert np.array_equal(body.positions, positions)
    assert pickle.loads(pickle.dumps(sim)).bodies[0].is_asleep
    body.wake()
    assert not body.is_asleep
    # Half a second of rest, and the rest of a frame.
    sim.advance(17)
    assert body.is_asleep
    body.apply_force((0, 1e6, 0), vertices=block.indices[:, 0] == 4)
    sim.step()
    assert not body.is_asleep
    assert body.velocities.any()
    sim.sleep = False
    sim.advance(200)
    assert not body.is_asleep
    assert not sim.sleep
    sim.sleep = True
    sim.advance(17)
    assert body.is_asleep
    with pytest.raises(TypeError, match="sleep must be True or False, not int"):
        sim.sleep = 1
