"""Runs notebooks in the root of the project and compares them with what is stored: run.py NOTEBOOK …

A notebook with outputs must show the words that are stored in it; numbers, and progress on stderr, may differ. EFAM_STORE=1 stores
what the notebooks show. EFAM_NOTEBOOKS names a folder that keeps their pictures.
"""

import base64
import copy
import os
import re
import sys
import time
from pathlib import Path

import nbformat
from nbclient import NotebookClient

ROOT = Path(__file__).resolve().parents[2]
MOST_BYTES = 150_000
kept = os.environ.get("EFAM_NOTEBOOKS")
stores = bool(os.environ.get("EFAM_STORE"))
# Pictures come with the cells.
os.environ.pop("MPLBACKEND", None)


def cleaned(cell):
    """The cell without the times of its run and without what goes to stderr."""
    cell.metadata.pop("execution", None)
    if cell.cell_type == "code":
        cell.outputs = [own for own in cell.outputs if own.get("name") != "stderr"]
    return cell


def words(notebook):
    """The printed lines of each code cell without their numbers and spaces."""
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    texts = ["".join(own.get("text", "") for own in cell.outputs) for cell in cells]
    return [[re.sub(r"[-+\d.e\s]+", " ", line) for line in text.splitlines()] for text in texts]


def pictures(notebook):
    data = [own.get("data", {}) for cell in notebook.cells for own in cell.get("outputs", [])]
    return [own["image/png"] for own in data if "image/png" in own]


for path in map(Path, sys.argv[1:]):
    stored = nbformat.read(path, as_version=4)
    notebook = copy.deepcopy(stored)
    begin = time.perf_counter()
    NotebookClient(notebook, timeout=1200, resources={"metadata": {"path": str(ROOT)}}).execute()
    notebook.cells = [cleaned(cell) for cell in notebook.cells]
    drawn = pictures(notebook)
    print(f"{path.name}: {time.perf_counter() - begin:.0f} s, {len(drawn)} pictures")
    if stores:
        notebook.metadata.get("language_info", {}).clear()
        notebook.metadata["language_info"] = {"name": "python"}
        nbformat.write(notebook, path)
        assert path.stat().st_size <= MOST_BYTES, f"{path.name} has more than {MOST_BYTES} bytes; draw less"
    elif any(cell.get("outputs") for cell in stored.cells):
        again = "store what it shows by EFAM_STORE=1 sim/python/check notebooks"
        for k, (was, now) in enumerate(zip(words(stored), words(notebook))):
            assert was == now, f"{path.name}, code cell {k + 1}: stored {was}, now {now}; {again}"
        assert len(pictures(stored)) == len(drawn), f"{path.name}: other pictures than stored; {again}"
    if kept:
        Path(kept).mkdir(parents=True, exist_ok=True)
        for k, picture in enumerate(drawn):
            Path(kept, f"{path.stem}-{k + 1}.png").write_bytes(base64.b64decode(picture))
