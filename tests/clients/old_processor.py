#!/usr/bin/python3
"""On a processor without AVX2, which qemu plays, umax ends with a word and 69, and not by a signal; on one with it it runs, and
to the bytes that --isa avx2 gives here."""
import json
import os
import pathlib
import subprocess
import sys
import tempfile

MESH = pathlib.Path(__file__).parent.parent / "support" / "octahedron.obj"
SCENE = """[clip]
frames = 3
[solver]
linear = "{solver}"
[body.block]
mesh = "{mesh}"
height = 0.4
position = [0, 0.25, 0]
rotation = [10, 0, 20]
velocity = [0, -3, 0]
cage.cells = 60
material.young = "20 kPa"
limit.stretch = "10 %"
[obstacle.ground]
shape = "plane"
"""


# as --isa avx2, which starts the program again: qemu would not be there any more
PINNED = {"UMAX_ISA": "avx2", "OPENBLAS_CORETYPE": "Haswell"}


def on(processor, *words, **variables):
    return subprocess.run(["qemu-x86_64", "-cpu", processor, sys.argv[1], *words], capture_output=True, text=True, timeout=1200,
                          env={**os.environ, **variables})


for words in ([], ["--version"], ["run", "beam"]):
    result = on("Nehalem", *words)
    assert result.returncode == 69, (words, result)
    assert result.stdout == "" and "AVX2" in result.stderr and result.stderr.count("\n") == 1, result
result = on("Haswell", "--version")
assert result.returncode == 0 and "kernels of multigrids for AVX2" in result.stdout, result

with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)

    def states(run):
        return {path.name: path.read_bytes() for path in (folder / run / "states").iterdir()}

    for solver in ("direct", "multigrid"):
        scene = folder / f"{solver}.toml"
        scene.write_text(SCENE.format(solver=solver, mesh=MESH))
        words = ["simulate", str(scene), "--quiet", "-o"]
        result = on("Haswell", *words, str(folder / f"{solver}-there"), **PINNED)
        assert result.returncode == 0, result
        subprocess.run([sys.argv[1], *words, str(folder / f"{solver}-here"), "--isa", "avx2"], check=True)
        sets = [json.loads((folder / f"{solver}-{place}" / "run.json").read_text())["instruction_set"] for place in ("there", "here")]
        assert sets[0] == sets[1] and sets[0].startswith("avx2 with OpenBLAS"), sets
        assert len(states(f"{solver}-here")) == 3 and states(f"{solver}-here") == states(f"{solver}-there"), solver
        print(f"{solver}: the same states by {sets[0]}")
print("passed")
