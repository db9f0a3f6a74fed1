#!/usr/bin/python3
"""On a processor without AVX2, which qemu plays, umax ends with a word and 69, and not by a signal; on one with it it runs."""
import subprocess
import sys


def on(processor, *words):
    return subprocess.run(["qemu-x86_64", "-cpu", processor, sys.argv[1], *words], capture_output=True, text=True, timeout=300)


for words in ([], ["--version"], ["run", "beam"]):
    result = on("Nehalem", *words)
    assert result.returncode == 69, (words, result)
    assert result.stdout == "" and "AVX2" in result.stderr and result.stderr.count("\n") == 1, result
result = on("Haswell", "--version")
assert result.returncode == 0 and "kernels of multigrids for AVX2" in result.stdout, result
print("passed")
