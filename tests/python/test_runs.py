"""umax.simulate and umax.Run: the bytes of the program."""
import os
import subprocess

import numpy as np
import pytest
import umax
from bodies import BOX

PROGRAM = os.environ["UMAX_PROGRAM"]


def states(folder):
    return [path.read_bytes() for path in sorted((folder / "states").iterdir())]


@pytest.fixture(scope="module")
def by_program(tmp_path_factory):
    folder = tmp_path_factory.mktemp("program")
    (folder / "box.toml").write_text(umax.Scene(BOX).toml())
    subprocess.run([PROGRAM, "simulate", "box.toml", "--quiet", "-o", "run"], cwd=folder, check=True)
    return folder / "run"


def test_the_states_of_a_run_are_those_of_the_program(by_program, tmp_path):
    run = umax.simulate(by_program.parent / "box.toml", tmp_path / "run")
    assert states(tmp_path / "run") == states(by_program)
    assert len(run) == 6 and len(states(by_program)) == 6
    for name in ("scene.toml", "steps.csv"):
        ours, theirs = (folder / name for folder in (tmp_path / "run", by_program))
        if name == "scene.toml":
            assert ours.read_text() == theirs.read_text()
        else:  # but for the times
            assert len(ours.read_text().splitlines()) == len(theirs.read_text().splitlines()) == 6


def test_steps_in_memory_are_those_of_the_program(by_program):
    simulation = umax.Simulation(by_program / "scene.toml")
    mine = [simulation.state()]
    for _ in range(5):
        simulation.step()
        mine.append(simulation.state())
    assert mine == states(by_program)


def test_preroll_and_substeps_are_those_of_the_program(tmp_path):
    scene = umax.Scene({**BOX, "body.box.pin.hand": {"box": {"min": [-0.2, 0.44, -0.2], "max": [0.2, 0.46, 0.2]},
                                                     "follow.position": [0, 0.02, 0]}})
    scene["clip.substeps"] = 2
    scene["clip.preroll"] = 0.1
    scene["clip.frames"] = 3
    (tmp_path / "box.toml").write_text(scene.toml())
    subprocess.run([PROGRAM, "simulate", "box.toml", "--quiet", "-o", "run"], cwd=tmp_path, check=True)
    simulation = umax.Simulation(scene)
    mine = [simulation.state()]
    for _ in range(2):
        simulation.step(), simulation.step()
        mine.append(simulation.state())
    assert mine == states(tmp_path / "run")


def test_a_run_is_read_frame_by_frame(by_program):
    run = umax.Run(by_program)
    simulation = umax.Simulation(BOX)
    frames = list(run)
    assert [frame.number for frame in frames] == [1, 2, 3, 4, 5, 6]
    for frame in frames:
        assert frame.time == pytest.approx(simulation.time)
        for name in ("positions", "velocities", "surface", "energy_ratios"):
            assert np.array_equal(getattr(frame, name)(), getattr(simulation, name)("box"))
        simulation.step()
    assert run[-1].number == 6 and run[0].state() == states(by_program)[0]
    with pytest.raises(IndexError):
        run[6]
    simulation.restore(run[2].state())
    assert simulation.steps == 2
    assert run.bodies == ["box"] and np.array_equal(run.triangles(), simulation.triangles())
    assert run.steps["time_s"].shape == (5,) and run.steps["converged"].all()
    assert run.steps["max_energy_ratio"].max() <= 1.001


def test_progress_is_told_after_each_frame(tmp_path):
    told = []
    umax.simulate(BOX, tmp_path / "run", progress=lambda at: told.append((at.stage, at.frame, at.done, at.total)))
    assert told == [("simulate", n, n, 6) for n in range(1, 7)]


def test_what_progress_raises_ends_the_run_and_resume_goes_on(by_program, tmp_path):
    class Enough(Exception):
        pass

    def stop(at):
        if at.frame == 3:
            raise Enough("of this")

    with pytest.raises(Enough, match="of this"):
        umax.simulate(BOX, tmp_path / "run", progress=stop)
    assert len(umax.Run(tmp_path / "run")) == 3
    with pytest.raises(umax.Error) as caught:
        umax.simulate(BOX, tmp_path / "run")
    assert caught.value.exit_code == 73
    run = umax.simulate(BOX, tmp_path / "run", resume=True)
    assert len(run) == 6 and states(tmp_path / "run") == states(by_program)
    umax.simulate(BOX, tmp_path / "run", overwrite=True, frames=2)
    assert len(umax.Run(tmp_path / "run")) == 4  # with the neighbours that the pictures of two show


def test_what_is_no_run_is_refused(tmp_path):
    with pytest.raises(umax.Error) as caught:
        umax.Run(tmp_path)
    assert caught.value.exit_code == 66
    with pytest.raises(umax.Error, match="exclude each other"):
        umax.simulate(BOX, tmp_path / "run", resume=True, overwrite=True)
    run = umax.simulate(BOX, tmp_path / "run", frames="1-2")
    state = tmp_path / "run" / "states" / "0002.state"
    state.write_bytes(state.read_bytes()[:-3])
    with pytest.raises(umax.Error, match="0002.state"):
        list(run)


def test_strict_ends_with_the_programs_code(tmp_path):
    scene = umax.Scene(BOX)
    scene["solver.max_newton_iterations"] = 1
    scene["solver.max_augmented_iterations"] = 1
    scene["solver.max_halvings"] = 0
    scene["clip.frames"] = 40
    with pytest.raises(umax.Error) as caught:
        umax.simulate(scene, tmp_path / "run", strict=True)
    assert caught.value.exit_code == 75
    with pytest.warns(UserWarning, match="did not converge"):
        umax.simulate(scene, tmp_path / "loose")
