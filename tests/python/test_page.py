"""docs/python.md: its examples run as they stand, and print what the page says."""
import os
import pathlib
import re
import subprocess
import sys

import pytest

PAGE = pathlib.Path(os.environ["UMAX_SOURCE_DIR"]) / "docs" / "python.md"
EXAMPLES = re.findall(r"```python\n(.*?)```\n(?:\n?```text\n(.*?)```)?", PAGE.read_text(), re.DOTALL)


def test_the_page_has_four_examples_with_output():
    assert sum(bool(output) for _, output in EXAMPLES) >= 4


@pytest.mark.parametrize("number", range(len(EXAMPLES)))
def test_an_example_prints_what_the_page_says(number, tmp_path):
    code, output = EXAMPLES[number]
    result = subprocess.run([sys.executable, "-B", "-c", code], capture_output=True, text=True, cwd=tmp_path, timeout=120)
    assert result.returncode == 0, result.stderr
    assert result.stdout == output
    for name in re.findall(r'savefig\("([^"]+)"\)', code):
        assert (tmp_path / name).stat().st_size > 5000
