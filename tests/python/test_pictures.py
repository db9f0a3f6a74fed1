"""umax.render and umax.compare: pictures as arrays, with the bytes of the program."""
import os
import subprocess

import numpy as np
import pytest
import umax
from bodies import BOX

PROGRAM = os.environ["UMAX_PROGRAM"]
SMALL = {"size": (64, 36), "samples": 2}


def read_png(path):
    from matplotlib import image
    return np.round(255 * image.imread(path)[..., :3]).astype(np.uint8)


def test_frames_have_the_bytes_of_the_program(tmp_path):
    run = umax.simulate(BOX, tmp_path / "run")
    for engine in ("embree", "osmesa"):
        subprocess.run([PROGRAM, "render", "run", "--size", "64x36", "--samples", "2", "--engine", engine, "--frames", "3",
                        "--no-clip", "--quiet", "-o", engine], cwd=tmp_path, check=True)
        picture = umax.render(run[2], engine=engine, **SMALL)
        assert picture.shape == (36, 64, 3) and picture.dtype == np.uint8
        assert np.array_equal(picture, read_png(tmp_path / engine / "frames" / "0003.png"))
        assert umax.compare(picture, tmp_path / engine / "frames" / "0003.png").mean == 0


def test_simulations_are_drawn_as_they_are_now():
    scene = umax.Scene(BOX)
    scene["camera.position"], scene["camera.target"] = [0, 0.5, 2], [0, 0.2, 0]
    scene["render.sky.kind"] = "gradient"  # not the studio's
    simulation = umax.Simulation(scene)
    first = umax.render(simulation, engine="osmesa", size=(65, 37))
    assert first.shape == (37, 65, 3)
    assert np.array_equal(first, umax.render(scene, engine="osmesa", size=(65, 37)))
    for _ in range(20):
        simulation.step()
    second = umax.render(simulation, engine="osmesa", size=(65, 37))
    difference = umax.compare(first, second)
    assert 0.005 < difference.mean < 1 and difference.maximum > 0.3 and difference.map.shape == (37, 65, 1)
    # the simulation's own settings are as before
    assert umax.render(simulation, samples=1).shape == (720, 1280, 3)


def test_linear_pictures_are_floats():
    picture = umax.render(BOX, linear=True, **SMALL)
    assert picture.dtype == np.float32 and picture.shape == (36, 64, 3)
    assert np.isfinite(picture).all() and picture.max() > 0


def test_settings_that_do_not_fit_are_refused():
    for wishes, part in [({"engine": "cycles"}, "engine"), ({"size": (0, 10)}, "size"), ({"samples": 0}, "samples"),
                         ({"heatmap": "hot"}, "heatmap")]:
        with pytest.raises(umax.Error, match=part):
            umax.render(BOX, **wishes)


def test_compare_refuses_what_is_no_picture_of_one_size():
    picture = np.zeros((4, 5, 3))
    assert umax.compare(picture, picture).mean == 0
    assert umax.compare(picture, picture + 1).mean > 0.5
    assert umax.compare(np.zeros((4, 5, 3), np.uint8), np.zeros((4, 5), np.float32)).mean == 0
    for a, b in [(picture, np.zeros((5, 4, 3))), (picture, np.zeros((4, 5, 2))), (picture, np.zeros(3)),
                 (picture, picture.astype(np.int64)), (picture, picture + np.nan)]:
        with pytest.raises(umax.Error):
            umax.compare(a, b)
    with pytest.raises(umax.Error):
        umax.compare("nowhere.png", picture)
