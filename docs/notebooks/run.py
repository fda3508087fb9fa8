"""Runs notebooks in the root of the project, without writing into them: run.py NOTEBOOK …

EFAM_NOTEBOOKS names a folder that keeps them with what they show, and their pictures.
"""

import base64
import os
import sys
import time
from pathlib import Path

import nbformat
from nbclient import NotebookClient

ROOT = Path(__file__).resolve().parents[2]
NEEDS_RECORDINGS = {"calibrate.ipynb"}
kept = os.environ.get("EFAM_NOTEBOOKS")
# Pictures come with the cells.
os.environ.pop("MPLBACKEND", None)

for path in map(Path, sys.argv[1:]):
    notebook = nbformat.read(path, as_version=4)
    assert not any(cell.get("outputs") for cell in notebook.cells), f"{path.name}: clear its outputs before a commit"
    folder = Path(os.environ.get("EFAM_RECORDINGS", ROOT.parent / "shared" / "recordings"))
    if path.name in NEEDS_RECORDINGS and not folder.is_dir():
        print(f"-- skipped: {path.name}, because its recordings are not in {folder}; set EFAM_RECORDINGS")
        continue
    begin = time.perf_counter()
    NotebookClient(notebook, timeout=1200, resources={"metadata": {"path": str(ROOT)}}).execute()
    pictures = [
        output["data"]["image/png"]
        for cell in notebook.cells
        for output in cell.get("outputs", [])
        if "image/png" in output.get("data", {})
    ]
    print(f"{path.name}: {time.perf_counter() - begin:.0f} s, {len(pictures)} pictures")
    if kept:
        Path(kept).mkdir(parents=True, exist_ok=True)
        nbformat.write(notebook, Path(kept) / path.name)
        for k, picture in enumerate(pictures):
            Path(kept, f"{path.stem}-{k + 1}.png").write_bytes(base64.b64decode(picture))
