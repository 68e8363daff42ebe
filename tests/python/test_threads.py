"""The GIL, Ctrl-C, concurrent threads, and forks."""

import os
import signal
import subprocess
import sys
import textwrap
import threading
import time

import numpy as np
import pytest

import supple


def _large():
    lattice = supple.Lattice.from_cells(np.ones((60, 60, 60), bool))
    return supple.Simulation([supple.Body(lattice, half_width=2)], threads=1)


def test_a_step_releases_the_gil():
    sim = _large()
    ticks = []
    done = threading.Event()

    def tick():
        while not done.is_set():
            ticks.append(time.perf_counter())
            time.sleep(0.001)

    # A daemon, so that a failure does not keep the process alive.
    thread = threading.Thread(target=tick, daemon=True)
    thread.start()
    start = time.perf_counter()
    sim.step(5)
    end = time.perf_counter()
    done.set()
    thread.join()
    during = [t for t in ticks if start < t < end]
    assert end - start > 0.02
    # A thread that waits for the GIL ticks at most once; 2 % of the ideal rate allows for a busy machine.
    assert len(during) > max(1, 0.02 * (end - start) / 0.001)


def test_two_simulations_stepped_by_two_threads_have_the_same_bits(block):
    def run():
        bodies = [supple.Body(block, spin=(0, 1, 0)) for _ in range(2)]
        sims = [supple.Simulation([body]) for body in bodies]
        return bodies, sims

    bodies, sims = run()
    threads = [threading.Thread(target=sim.step, args=(300,)) for sim in sims]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    (expected, _), (sim, _) = run()
    sim.step(300)
    for body in bodies:
        assert body.positions.tobytes() == expected.positions.tobytes()


def test_one_simulation_is_stepped_and_evaluated_by_many_threads(cube):
    body = supple.Body(cube, lattice_vertices=300, half_width=2)
    sim = supple.Simulation([body])
    calls = [
        body.goals,
        body.surface,
        body.volume_report,
        lambda: sim.step(3),
        lambda: body.positions,
        lambda: sim.time,
    ]
    threads = [threading.Thread(target=lambda call=call: [call() for _ in range(50)]) for call in calls]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sim.time == pytest.approx(150 / 60)
    other = supple.Body(cube, lattice_vertices=300, half_width=2)
    supple.Simulation([other]).step(150)
    assert body.positions.tobytes() == other.positions.tobytes()


def test_surfaces_are_evaluated_while_a_body_breaks(cube):
    """Each cut gives the surface more rows; an array of another length is written only in whole, or refused."""
    bodies = [supple.Body(cube, lattice_vertices=300, half_width=2) for _ in range(2)]
    sim = supple.Simulation(bodies, gravity=(0, 0, 0), contact=False)
    whole, body = sim.save_state(), bodies[0]
    first, low, high = len(body.surface()), body.positions.min(axis=0), body.positions.max(axis=0)
    done, failures = threading.Event(), []
    force = body.add_force_field(lambda x, v, time: np.zeros_like(x))

    def cut_and_mend():
        for k in range(60):
            share = (k % 7 + 1) / 8
            body.cut((share * low + (1 - share) * high, (1, 0, 0)))
            sim.restore_state(whole)
        done.set()

    def repeat(call):
        while not done.is_set():
            try:
                call()
            except ValueError as error:
                if "because the body broke" not in str(error) and "it must be" not in str(error):
                    failures.append(error)
            except BaseException as error:  # a panic
                failures.append(error)
                return

    calls = [
        body.surface,
        body.surface_normals,
        sim.surfaces,
        lambda: body.surface(out=np.empty((first, 3), np.float32)),
        lambda: sim.surfaces(out=[np.empty((first, 3)), np.empty((first, 3))[::-1]]),
        lambda: force.vertices,
    ]
    threads = [threading.Thread(target=repeat, args=(call,)) for call in calls]
    threads.append(threading.Thread(target=cut_and_mend))
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert failures == []


@pytest.mark.usefixtures("interruptible")
def test_ctrl_c_ends_a_long_step_call(block):
    body = supple.Body(block)
    sim = supple.Simulation([body], dt=0.01, gravity=(0, 0, 0), threads=1)
    timer = threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    start = time.perf_counter()
    with pytest.raises(KeyboardInterrupt):
        sim.step(100_000_000)
    assert time.perf_counter() - start < 5
    timer.join()
    stopped = sim.time
    assert stopped > 0
    sim.step()
    assert sim.time > stopped


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_a_forked_process_continues_with_its_own_threads():
    # In a separate process, because the process of pytest has threads that must not be forked.
    program = """
        import os
        import numpy as np
        import supple

        lattice = supple.Lattice.from_cells(np.ones((25, 25, 25), bool))
        body = supple.Body(lattice, spin=(0, 0, 1))
        sim = supple.Simulation([body], threads=2)
        sim.step(3)
        read, write = os.pipe()
        child = os.fork()
        sim.step(3)
        if child == 0:
            os.write(write, body.positions.tobytes()[:1000])
            os._exit(0)
        assert os.waitpid(child, 0)[1] == 0
        assert os.read(read, 1000) == body.positions.tobytes()[:1000]
        """
    subprocess.run([sys.executable, "-c", textwrap.dedent(program)], check=True, timeout=60)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
@pytest.mark.parametrize("alone", [False, True])
def test_a_process_forked_during_a_step_raises_instead_of_waiting(alone):
    # The thread that holds the lock does not exist in the child process, so the lock is never released there.
    program = f"""
        import os, sys, threading, time
        import numpy as np
        import supple

        body = supple.Body(supple.Lattice.from_cells(np.ones((60, 60, 60), bool)))
        sim = None if {alone} else supple.Simulation([body], threads=2)
        busy = [True]

        def work():
            while busy:
                body.goals() if sim is None else sim.step(5)

        calls = [lambda: body.positions, lambda: repr(body), body.goals]
        calls += [lambda: supple.Simulation([body])] if sim is None else [sim.step, lambda: sim.time]

        def refusals():
            refused = 0
            for call in calls:
                try:
                    call()
                except RuntimeError as error:
                    refused += "forked while another thread used" in str(error)
            return refused

        thread = threading.Thread(target=work)
        thread.start()
        refused = 0
        # Sometimes the thread holds no lock at the moment of the fork, and the calls succeed.
        for _ in range(20):
            time.sleep(0.02)
            child = os.fork()
            if child == 0:
                os._exit(refusals())
            refused = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
            if refused:
                break
        busy.clear()
        thread.join()
        assert refused == len(calls), refused
        assert refusals() == 0
        """
    subprocess.run([sys.executable, "-c", textwrap.dedent(program)], check=True, timeout=60)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_a_forked_process_evaluates_before_its_first_step():
    program = """
        import os, sys
        import numpy as np
        import supple

        sides = np.linspace(-1, 1, 150)
        u, v = (grid.ravel() for grid in np.meshgrid(sides, sides))
        faces = [(k, k + 1, k + 151, k + 150) for k in range(150 * 149) if k % 150 < 149]
        sheet = supple.Mesh(np.stack([u, v, 0.1 * np.sin(3 * u)], axis=1), faces)
        body = supple.Body(sheet, lattice_vertices=3000)
        sim = supple.Simulation([body], threads=2)
        sim.step(2)
        before = body.surface()
        child = os.fork()
        if child == 0:
            os._exit(0 if np.array_equal(body.surface(), before) and body.volume_report() else 1)
        sys.exit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
        """
    subprocess.run([sys.executable, "-c", textwrap.dedent(program)], check=True, timeout=60)


def _threads():
    with open("/proc/self/status") as status:
        return next(int(line.split()[1]) for line in status if line.startswith("Threads:"))


@pytest.mark.skipif(not os.path.exists("/proc/self/status"), reason="counts threads in /proc")
def test_simulations_share_the_threads_of_a_process(block):
    before = _threads()
    sims = [supple.Simulation(supple.Body(block), threads=5) for _ in range(30)]
    for sim in sims:
        sim.step()
    # The threads of a build end by themselves, some moments after it.
    deadline = time.monotonic() + 10
    while _threads() > before + 5 and time.monotonic() < deadline:
        time.sleep(0.01)
    assert _threads() <= before + 5
    assert {sim.threads for sim in sims} == {5}


#: Long work, as code that is run after `lattice` was built of 170 x 170 x 100 cells.
LONG = {
    "body": "supple.Body(lattice)",
    "lattice": "supple.Lattice.from_cells(np.ones((400, 400, 200), bool))",
    "first step": "sim.step()",
    "simulation": "supple.Simulation([supple.Body(lattice, half_width=2)], fps=30)",
    "lowest frequency": "body.lowest_frequency",
    "reference": "supple.reference.goals(lattice, lattice.rest_positions, 20)",
}


@pytest.mark.skipif(os.name == "nt", reason="sends the signal of Ctrl-C")
@pytest.mark.parametrize("name", LONG)
def test_ctrl_c_ends_the_wait_for_long_work_within_a_second(name):
    needs_sim = name in ("first step", "lowest frequency")
    program = f"""
        import os, signal, threading, time
        import numpy as np
        import supple

        signal.signal(signal.SIGINT, signal.default_int_handler)
        lattice = supple.Lattice.from_cells(np.ones((170, 170, 100), bool))
        if {needs_sim}:
            body = supple.Body(lattice, half_width=2)
            sim = supple.Simulation([body], fps=30)
        pressed = []

        def press():
            time.sleep(0.2)
            pressed.append(time.monotonic())
            os.kill(os.getpid(), signal.SIGINT)

        threading.Thread(target=press).start()
        try:
            {LONG[name]}
        except KeyboardInterrupt:
            print("waited", time.monotonic() - pressed[0], flush=True)
        else:
            print("too fast to be interrupted", flush=True)
        os._exit(0)
        """
    command = [sys.executable, "-c", textwrap.dedent(program)]
    ended = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    if ended.stdout.startswith("too fast"):
        pytest.skip("the machine ended the work within a fifth of a second")
    assert ended.stdout.startswith("waited"), ended.stderr
    assert float(ended.stdout.split()[1]) < 1


def test_an_error_in_another_thread_is_raised_here(block):
    with pytest.raises(supple.LatticeError):
        supple.Lattice.from_cells(np.zeros((3, 3, 3), bool))
    with pytest.raises(ValueError, match="density"):
        supple.Body(block, density=-1)
