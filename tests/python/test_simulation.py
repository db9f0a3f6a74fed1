"""umax.Simulation: steps in memory, arrays, forces."""
import gc
import threading

import numpy as np
import pytest
import umax
from bodies import BOX, ONE_HEX, PAIR


def test_arrays_have_the_shapes_of_the_cage_and_the_mesh():
    simulation = umax.Simulation(BOX)
    assert simulation.bodies == ["box"]
    assert simulation.positions("box").shape == (36, 3)
    assert simulation.velocities().shape == (36, 3)
    assert simulation.energy_ratios().shape == (12,)
    assert simulation.hexes().shape == (12, 8) and simulation.hexes().max() == 35
    surface, triangles = simulation.surface(), simulation.triangles()
    assert surface.shape[1] == 3 and triangles.max() == len(surface) - 1
    assert triangles.dtype == np.int32 and surface.dtype == np.float64
    assert np.allclose(surface.max(axis=0), [0.15, 0.45, 0.1])
    assert simulation.time == 0 and simulation.steps == 0 and simulation.time_step == pytest.approx(1 / 60)


def test_a_step_tells_what_it_did():
    simulation = umax.Simulation(BOX)
    reports = [simulation.step() for _ in range(40)]
    assert all(report.converged and report.status == "converged" for report in reports)
    assert max(report.contacts for report in reports) > 0
    assert 0.5 < max(report.max_energy_ratio for report in reports) <= 1.001
    assert simulation.energy_ratios().max() == reports[-1].max_energy_ratio
    assert simulation.steps == 40 and simulation.time == pytest.approx(40 / 60)
    assert "converged" in repr(reports[0])


def test_copies_stay_and_views_follow():
    simulation = umax.Simulation(BOX)
    copies = [simulation.positions(), simulation.surface(), simulation.velocities()]
    views = [simulation.positions(copy=False), simulation.surface(copy=False), simulation.velocities(copy=False)]
    start = [view.copy() for view in views]
    simulation.step()
    now = [simulation.positions(), simulation.surface(), simulation.velocities()]
    for copy, view, before, after in zip(copies, views, start, now):
        assert np.array_equal(copy, before)
        assert np.array_equal(view, after) and not np.array_equal(view, before)
        assert not view.flags.writeable and copy.flags.writeable
        with pytest.raises(ValueError):
            view[0, 0] = 1
    # one memory for all views of a thing
    assert simulation.positions(copy=False).ctypes.data == views[0].ctypes.data


def test_views_outlive_their_simulation():
    simulation = umax.Simulation(BOX)
    view = simulation.positions(copy=False)
    simulation.step()
    expected = simulation.positions()
    del simulation
    gc.collect()
    assert np.array_equal(view, expected)


def test_a_state_brings_back_the_same_steps():
    simulation = umax.Simulation(BOX)
    for _ in range(10):
        simulation.step()
    view, state = simulation.surface(copy=False), simulation.state()
    positions, surface = simulation.positions(), view.copy()
    after = [(simulation.step(), simulation.positions())[1] for _ in range(5)]
    simulation.restore(state)
    assert np.array_equal(simulation.positions(), positions) and np.array_equal(view, surface)
    assert simulation.state() == state and simulation.steps == 10
    for expected in after:
        simulation.step()
        assert np.array_equal(simulation.positions(), expected)
    other = umax.Simulation(BOX)
    other.restore(state)
    other.step()
    assert np.array_equal(other.positions(), after[0])


def test_states_that_do_not_fit_are_refused():
    simulation = umax.Simulation(BOX)
    state = simulation.state()
    for wrong in (b"", b"nonsense", state[:-1], state[:200] + bytes([state[200] ^ 1]) + state[201:],
                  umax.Simulation(ONE_HEX).state()):
        with pytest.raises(umax.Error):
            simulation.restore(wrong)
    with pytest.raises(TypeError):
        simulation.restore("text")
    assert simulation.state() == state


def test_nodal_forces_accelerate_as_newton_says():
    simulation = umax.Simulation(ONE_HEX)  # 1 kg, no gravity
    h = simulation.time_step
    forces = np.tile([[0.25, 0.5, -0.125]], (8, 1))
    start = simulation.positions()
    for n in range(1, 6):
        simulation.step(forces)
        assert np.allclose(simulation.velocities(), n * h * 8 * forces, rtol=1e-9)
        assert np.allclose(simulation.positions() - start, h * h * n * (n + 1) / 2 * 8 * forces, rtol=1e-8)
    velocities = simulation.velocities()
    simulation.step()  # forces are those of one step
    assert np.allclose(simulation.velocities(), velocities, rtol=1e-9)


def test_surface_forces_push_with_their_sum():
    simulation = umax.Simulation(ONE_HEX)
    vertices = len(simulation.surface())
    simulation.step(surface_forces=np.tile([[0, 3.0 / vertices, 0]], (vertices, 1)))
    assert np.allclose(simulation.velocities().mean(axis=0), [0, 3 * simulation.time_step, 0], atol=1e-9)


def test_forces_by_body_reach_that_body_alone():
    scene = umax.Scene(PAIR)
    scene["clip.gravity"] = [0, 0, 0]
    simulation = umax.Simulation(scene)
    nodes, vertices = len(simulation.positions("left")), len(simulation.surface("right"))
    simulation.step({"left": np.full((nodes, 3), 1.0)})
    assert simulation.velocities("left").min() > 0 and not simulation.velocities("right").any()
    simulation.step(surface_forces={"right": np.full((vertices, 3), -1.0)})
    assert simulation.velocities("right").max() < 0


def test_forces_that_do_not_fit_are_refused_and_nothing_moves():
    simulation = umax.Simulation(PAIR)
    before = simulation.state()
    nodes = len(simulation.positions("left"))
    for forces, part in [(np.zeros((nodes, 3)), "must be named"),
                         ({"left": np.zeros((nodes + 1, 3))}, r'forces\["left"\].*shape'),
                         ({"left": np.zeros(nodes)}, "shape"),
                         ({"left": np.full((nodes, 3), np.nan)}, "finite"),
                         ({"left": [["a", "b", "c"]] * nodes}, "numbers"),
                         ({"lift": np.zeros((nodes, 3))}, "did you mean left")]:
        with pytest.raises(umax.Error, match=part):
            simulation.step(forces)
    assert simulation.state() == before
    with pytest.raises(umax.Error, match="did you mean left"):
        simulation.positions("lift")


def test_forces_of_any_layout_are_read():
    results = []
    for make in (lambda f: f, np.asfortranarray, lambda f: f.astype(np.float32), lambda f: f.tolist(),
                 lambda f: np.repeat(f, 2, axis=0)[::2]):
        simulation = umax.Simulation(ONE_HEX)
        simulation.step(make(np.arange(24.0).reshape(8, 3) / 16))
        results.append(simulation.positions())
    assert all(np.array_equal(result, results[0]) for result in results)


def test_both_linear_solvers_know_forces():
    ends = []
    for linear in ("direct", "multigrid"):
        scene = umax.Scene(BOX)
        scene["solver.linear"] = linear
        simulation = umax.Simulation(scene)
        forces = np.zeros((36, 3))
        forces[::2, 0] = 0.5
        for _ in range(12):
            simulation.step(forces)
        ends.append(simulation.positions())
    assert abs(ends[0] - ends[1]).max() < 1e-5
    assert ends[0][:, 0].mean() > 0.01


def test_deform_is_the_surface_of_given_nodes():
    simulation = umax.Simulation(BOX)
    nodes = simulation.positions()
    assert np.array_equal(umax.deform(simulation, "box", nodes), simulation.surface())
    turn = np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1.0]])
    assert np.allclose(umax.deform(simulation, "box", nodes @ turn), simulation.surface() @ turn)
    with pytest.raises(umax.Error, match="nodes.*shape"):
        umax.deform(simulation, "box", nodes[1:])


def test_threads_of_python_step_simulations_of_their_own():
    alone = umax.Simulation(BOX)
    for _ in range(20):
        alone.step()
    ends = [None] * 4

    def work(i):
        simulation = umax.Simulation(BOX, threads=1 + i % 2)
        for _ in range(20):
            simulation.step()
        ends[i] = simulation.state()

    threads = [threading.Thread(target=work, args=(i,)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert ends == [alone.state()] * 4


def test_what_cannot_be_simulated_is_said():
    scene = umax.Scene(BOX)
    scene["body.box.fixed"] = [{"min": [9, 9, 9], "max": [10, 10, 10]}]
    with pytest.raises(umax.Error, match="box 1 holds no node"):
        umax.Simulation(scene)
    with pytest.raises(umax.Error, match="no such|not found|cannot"):
        umax.Simulation({"body": {"a": {"mesh": "nowhere.obj"}}})
