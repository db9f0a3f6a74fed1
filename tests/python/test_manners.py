"""What the module leaves as it found it, and what it lets go on meanwhile."""
import ctypes
import ctypes.util
import os
import signal
import subprocess
import sys
import textwrap
import threading
import time

import numpy as np
import umax
from bodies import BOX, ONE_HEX

LARGE = dict(BOX, body={"box": dict(BOX["body"]["box"], **{"cage.cells": [16, 16, 16]})})


def in_python(script, **environment):
    """the output of a script in a Python of its own"""
    result = subprocess.run([sys.executable, "-B", "-c", textwrap.dedent(script)], capture_output=True, text=True,
                            timeout=120, cwd=os.path.dirname(__file__), env={**os.environ, **environment})
    assert result.returncode == 0, result.stderr
    return result.stdout.split()


def test_other_threads_run_during_a_step():
    simulation = umax.Simulation(LARGE)
    counted, stop = [0], threading.Event()

    def count():
        while not stop.is_set():
            counted[0] += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    begin = time.monotonic()
    while time.monotonic() - begin < 0.5:
        simulation.step()
    during = counted[0]
    stop.set()
    thread.join()
    assert during > 25


def test_a_simulation_is_not_used_by_two_threads_at_once():
    simulation = umax.Simulation(LARGE)
    begun, refused = threading.Event(), []

    def step():
        begun.set()
        for _ in range(5):
            simulation.step()

    thread = threading.Thread(target=step)
    thread.start()
    begun.wait()
    while thread.is_alive() and not refused:
        try:
            simulation.positions()
        except umax.Error as error:
            refused.append(error)
    thread.join()
    assert refused and refused[0].exit_code == 75
    assert simulation.steps == 5


def test_ctrl_c_ends_a_step_and_leaves_the_state():
    simulation = umax.Simulation(LARGE)
    simulation.step()
    before = simulation.state()
    timer = threading.Timer(0.2, lambda: os.kill(os.getpid(), signal.SIGINT))
    timer.start()
    begin = time.monotonic()
    try:
        while True:
            before = simulation.state()
            simulation.step()
    except KeyboardInterrupt:
        pass
    assert time.monotonic() - begin < 5
    timer.join()
    simulation.step()
    other = umax.Simulation(LARGE)
    other.restore(before)
    other.step()
    assert simulation.state() == other.state() or other.steps == simulation.steps - 1


def test_ctrl_c_ends_a_run_keeps_its_frames_and_handlers(tmp_path):
    handler = signal.getsignal(signal.SIGINT)
    scene = umax.Scene(LARGE)
    scene["clip.frames"] = 10000
    timer = threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT))
    timer.start()
    try:
        umax.simulate(scene, tmp_path / "run")
        assert False, "it went on"
    except KeyboardInterrupt:
        pass
    timer.join()
    assert len(umax.Run(tmp_path / "run")) >= 1
    assert signal.getsignal(signal.SIGINT) is handler
    # nothing of the signal is left: the next run does not stop, and the next signal reaches Python
    assert len(umax.simulate(BOX, tmp_path / "next")) == 6
    try:
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(1)
        assert False, "no handler"
    except KeyboardInterrupt:
        pass


def test_handlers_of_the_callers_own_are_called_and_stay(tmp_path):
    came = []
    before = signal.signal(signal.SIGTERM, lambda number, frame: came.append(number))
    try:
        def raise_once(at):
            if at.frame == 2:
                os.kill(os.getpid(), signal.SIGTERM)

        scene = umax.Scene(BOX)
        scene["clip.frames"] = 500
        try:
            umax.simulate(scene, tmp_path / "run", progress=raise_once)
            assert False, "it went on"
        except KeyboardInterrupt:
            pass
        assert came == [signal.SIGTERM]
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(0.01)
        assert came == [signal.SIGTERM] * 2
    finally:
        signal.signal(signal.SIGTERM, before)


def test_blas_has_its_threads_again():
    counts = in_python("""
        import ctypes, tempfile
        import numpy, umax
        from bodies import BOX
        blas = ctypes.CDLL("libopenblas.so.0")
        blas.openblas_set_num_threads(3)
        print(blas.openblas_get_num_threads())
        within = []
        simulation = umax.Simulation(BOX)
        simulation.step()
        print(blas.openblas_get_num_threads())
        with tempfile.TemporaryDirectory() as folder:
            umax.simulate(BOX, folder + "/run", progress=lambda at: within.append(blas.openblas_get_num_threads()))
        print(max(within), blas.openblas_get_num_threads())
    """)
    assert counts == ["3", "3", "1", "3"]


def test_the_environment_is_as_it_was():
    lines = in_python("""
        import ctypes
        import umax
        from bodies import BOX
        libc = ctypes.CDLL(None)
        getenv = libc.getenv
        getenv.restype = ctypes.c_char_p
        def show(): print(getenv(b"LP_NUM_THREADS"), getenv(b"GALLIUM_DRIVER"))
        simulation = umax.Simulation(BOX, threads=2)
        simulation.step()
        show()
        libc.setenv(b"GALLIUM_DRIVER", b"softpipe", 1)
        libc.setenv(b"LP_NUM_THREADS", b"5", 1)
        simulation.step()
        umax.render(simulation, engine="osmesa", size=(64, 36), threads=2)
        show()
    """)
    assert lines == ["None", "None", "b'5'", "b'softpipe'"]


def test_flushing_denormal_numbers_changes_no_bit_and_stays():
    script = """
        import ctypes, hashlib
        libm = ctypes.CDLL("libm.so.6")
        environment = (ctypes.c_uint32 * 8)()
        libm.fegetenv(environment)
        if {flush}:
            environment[7] |= 0x8040
            libm.fesetenv(environment)
        import umax
        from bodies import BOX
        simulation = umax.Simulation(BOX)
        for _ in range(25): simulation.step()
        after = (ctypes.c_uint32 * 8)()
        libm.fegetenv(after)
        print(hashlib.sha256(simulation.state()).hexdigest(), after[7] & 0x8040)
    """
    plain, flushed = (in_python(script.format(flush=flush)) for flush in (False, True))
    assert plain[0] == flushed[0]
    assert plain[1] == "0" and flushed[1] == str(0x8040)


def test_importing_changes_nothing_of_the_process():
    same = in_python("""
        import os, signal, warnings
        before = ([signal.getsignal(n) for n in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)], dict(os.environ),
                  warnings.filters[:])
        import umax
        after = ([signal.getsignal(n) for n in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)], dict(os.environ),
                 warnings.filters[:])
        print(before == after)
    """)
    assert same == ["True"]


def test_results_do_not_depend_on_threads():
    scene = umax.Scene(LARGE)
    ends = []
    for threads in (1, 3):
        simulation = umax.Simulation(scene, threads=threads)
        for _ in range(3):
            simulation.step()
        ends.append(simulation.state())
    assert ends[0] == ends[1]


def test_nothing_is_lost_in_many_simulations():
    scene = umax.Scene(ONE_HEX)
    scene["body.cube.cage.cells"] = [10, 10, 10]  # a state of 64 kB, a cage of much more

    def memory():
        return int(open("/proc/self/statm").read().split()[1]) * 4096

    def work():
        simulation = umax.Simulation(scene)
        views = [simulation.positions(copy=False), simulation.surface(copy=False)]
        simulation.step(np.zeros((1331, 3)))
        simulation.restore(simulation.state())
        return views

    for _ in range(8):
        work()
    before = memory()
    for _ in range(24):
        work()
    assert memory() - before < 3 << 20


def test_an_older_processor_is_told_before_anything_runs():
    told = in_python("""
        import builtins, io, sys
        files = builtins.open
        def opened(name, *rest, **more):
            return io.StringIO("flags\\t\\t: fpu sse2 sse4_2\\n") if name == "/proc/cpuinfo" else files(name, *rest, **more)
        builtins.open = opened
        try:
            import umax
        except ImportError as error:
            print("avx2" in str(error), "umax._umax" in sys.modules)
    """)
    assert told == ["True", "False"]
