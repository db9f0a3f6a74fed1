"""umax.Scene: from everything that makes one, and key by key."""
import pathlib
import re

import numpy as np
import pytest
import umax
from bodies import BOX

TEXT = """
[body.box]
shape = "box"
size = [0.3, 0.2, 0.2]
cage.cells = [3, 2, 2]
limit.stretch = "10 %"
"""


def test_names_paths_text_and_dicts_make_scenes(tmp_path):
    file = tmp_path / "box.toml"
    file.write_text(TEXT)
    assert umax.Scene("figure").bodies == ["figure"]
    assert umax.Scene(str(file)).name == "box"
    assert umax.Scene(pathlib.Path(file)).bodies == ["box"]
    assert umax.Scene(TEXT).bodies == ["box"]
    assert umax.Scene(BOX)["body.box.limit.stretch"] == umax.Scene(TEXT)["body.box.limit.stretch"]
    assert set(umax.scenes()) >= {"figure", "beam", "sphere"}


def test_a_dict_says_what_the_same_text_says():
    scene = umax.Scene({"body": {"box": {"shape": "box", "size": np.array([0.3, 0.2, 0.2]), "cage.cells": (3, 2, 2),
                                         "limit": {"stretch": "10 %"}}}})
    assert scene.toml() == umax.Scene(TEXT).toml()


def test_values_are_set_and_read_in_si_units():
    scene = umax.Scene(BOX)
    scene["body.box.material.young"] = "0.1 MPa"
    assert scene["body.box.material.young"] == pytest.approx(1e5)
    scene["body.box.material.young"] = np.float64(2e5)
    assert scene["body.box.material.young"] == 2e5
    scene["clip.frames"] = np.int64(9)
    assert scene["clip.frames"] == 9
    scene["clip.gravity"] = np.array([0, -1.5, 0])
    assert scene["clip.gravity"] == [0, -1.5, 0]
    scene["obstacle.ground.position"] = {"keys": [[0, [0, 0, 0]], [1, [0, 1, 0]]]}
    assert scene["obstacle.ground.position"]["keys"][1] == [1, [0, 1, 0]]
    assert scene["body.box"]["cage"]["cells"] == [3, 2, 2]


def test_setting_one_limit_replaces_another():
    scene = umax.Scene(BOX)
    scene["body.box.limit.energy"] = "2 J"
    assert scene["body.box.limit.energy"] == 2
    scene["body.box.limit.stretch"] = "15 %"
    assert umax.Scene(scene.toml())["body.box.limit.stretch"] == scene["body.box.limit.stretch"]
    with pytest.raises(umax.Error):
        scene["body.box.limit.energy"]


def test_the_readers_errors_come_with_where_what_value_and_remedy():
    scene = umax.Scene(BOX)
    with pytest.raises(umax.Error) as caught:
        scene["body.box.limit.stretch"] = "15 kg"
    assert caught.value.where == 'scene["body.box.limit.stretch"]'
    assert "15 kg" in caught.value.value and caught.value.what and caught.value.remedy
    assert caught.value.exit_code == 65
    assert caught.value.where in str(caught.value) and caught.value.remedy in str(caught.value)
    assert isinstance(caught.value, RuntimeError)
    with pytest.raises(umax.Error, match="did you mean body.box.limit.stretch"):
        scene["body.box.limit.strech"] = "15 %"
    with pytest.raises(umax.Error, match="did you mean body.box.limit.stretch"):
        scene["body.box.limit.strech"]
    with pytest.raises(umax.Error, match="did you mean figure"):
        umax.Scene("figur")
    with pytest.raises(umax.Error, match="line|:3"):
        umax.Scene("[body.box]\nshape = \"box\"\nshap = 3\n")
    for nothing in (3, None, object(), b"x"):
        with pytest.raises(umax.Error):
            umax.Scene(nothing)
    with pytest.raises(umax.Error, match="cannot be written into a scene"):
        scene["clip.frames"] = object()


def test_a_scene_that_refused_a_value_is_as_it_was():
    scene = umax.Scene(BOX)
    before = scene.toml()
    for key, value in [("clip.frames", -1), ("clip.frame", 3), ("body.bax.limit.stretch", "1 %"), ("", 1), (".", 2)]:
        with pytest.raises(umax.Error):
            scene[key] = value
    assert scene.toml() == before


def test_copies_are_changed_apart():
    scene = umax.Scene(BOX)
    other = scene.copy()
    other["clip.frames"] = 77
    assert scene["clip.frames"] == 6 and other["clip.frames"] == 77
    assert umax.Scene(other)["clip.frames"] == 77


def test_hints_name_everything_that_the_module_has():
    import ast
    stub = pathlib.Path(umax.__file__).with_suffix(".pyi")
    tree = ast.parse(stub.read_text())
    hinted = {node.name: {inner.name for inner in node.body if isinstance(inner, ast.FunctionDef)} |
              {inner.target.id for inner in node.body if isinstance(inner, ast.AnnAssign)}
              for node in tree.body if isinstance(node, ast.ClassDef)}
    functions = {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
    for name in umax.__all__:
        thing = getattr(umax, name)
        if not isinstance(thing, type):
            assert name in functions and thing.__doc__, name
            continue
        assert name in hinted and thing.__doc__, name
        if thing is umax.Error:
            assert hinted[name] == {"where", "what", "value", "remedy", "exit_code"}
            continue
        public = {member for member in vars(thing) if not member.startswith("_")}
        assert public <= hinted[name], name
        assert {member for member in hinted[name] if not member.startswith("__")} <= public, name
    assert stub.with_name("py.typed").exists()


ARRAYS = {"positions", "velocities", "surface", "energy_ratios", "triangles", "hexes", "map", "deform", "render"}


def test_everything_is_explained_and_arrays_with_type_and_shape():
    explained = {name: getattr(umax, name).__doc__ for name in umax.__all__}
    for name in umax.__all__:
        kind = getattr(umax, name)
        if isinstance(kind, type) and kind is not umax.Error:
            explained.update({f"{name}.{key}": member.__doc__ for key, member in vars(kind).items() if key[0] != "_"})
    assert not [name for name, text in explained.items() if not text or not text.strip()]
    arrays = {name: text for name, text in explained.items() if name.split(".")[-1] in ARRAYS or name == "Run.steps"}
    assert len(arrays) == 15
    for name, text in arrays.items():
        assert re.search(r"(float64|float32|int32|uint8) \([a-z]+,[a-z0-9, ]*\)", text), name
    for name in ("Simulation", "Run", "deform", "compare", "fit"):
        assert "Raises umax.Error" in explained[name], name
