"""Every block of Python that the documents show is run, page by page, in the root of the project."""

import os
import re

import pytest

from conftest import ROOT

PAGES = ["README.md", "docs/src/guide/linear.md", "docs/src/guide/python.md"]


@pytest.mark.parametrize("page", PAGES)
def test_the_blocks_of_a_page_run(page, monkeypatch):
    blocks = re.findall(r"^```python\n(.*?)^```", (ROOT / page).read_text(encoding="utf-8"), re.M | re.S)
    assert blocks, page
    monkeypatch.chdir(ROOT)
    names: dict[str, object] = {}
    before = set(os.listdir())
    for block in blocks:
        exec(compile(block, page, "exec"), names)
    assert set(os.listdir()) == before, "nothing is written"
