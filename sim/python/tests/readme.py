"""Runs README's lines of Python as they are, and saves the picture that they draw: readme.py PICTURE."""

import re
import sys
import warnings
from pathlib import Path

README = Path(__file__).resolve().parents[3] / "README.md"

blocks = re.findall(r"^```python\n(.*?)^```", README.read_text(encoding="utf-8"), re.M | re.S)
assert blocks, "README has no Python"
# Without a screen, plt.show() only warns, and the figure stays.
warnings.filterwarnings("ignore", message=".*non-interactive")
for block in blocks:
    exec(compile(block, "README.md", "exec"), {})

from matplotlib import pyplot  # noqa: E402: README's lines import it first

figures = [pyplot.figure(number) for number in pyplot.get_fignums()]
lines = [line for figure in figures for axes in figure.axes for line in axes.lines]
assert lines and all(len(line.get_xdata()) > 1 for line in lines), "README's lines draw nothing"
figures[-1].savefig(sys.argv[1])
print(f"README: {len(figures)} picture with {len(lines)} lines")
