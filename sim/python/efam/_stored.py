"""Runs and answers that were written or pickled before: nothing is computed until a page of a run is wanted."""

import json
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import NDArray

from . import _efam
from ._efam import Model, RunData

Floats = NDArray[np.float64]
Files = list[tuple[str, bytes]]


def files_of(folder: Path) -> Files:
    """All files of a folder, by their paths below it."""
    paths = sorted(path for path in folder.rglob("*") if path.is_file())
    return [(path.relative_to(folder).as_posix(), path.read_bytes()) for path in paths]


@dataclass(frozen=True)
class StoredAnswer:
    """The data of an answer, from the files of its folder."""

    json: str
    table: str
    models: list[tuple[str, str]]
    files: Files

    @property
    def has_folder(self) -> bool:
        """Whether it has a folder."""
        return bool(self.files)

    def write(self, out: Any, overwrite: bool) -> Any:
        """Writes the folder again."""
        name: str = json.loads(dict(self.files)["summary.json"])["name"]
        return _efam.write_files(name, self.files, out, overwrite)


@dataclass(frozen=True)
class StoredRun:
    """The data of a run: its numbers as they were, and its scenario, which gives the same bits again."""

    columns: list[str]
    numbers: Floats
    json: str
    report: str
    text: str
    tips: dict[str, Floats]
    """Derivatives of the tip by parameters."""

    @classmethod
    def of(cls, data: Union[RunData, "StoredRun"]) -> "StoredRun":
        """That of a run."""
        if isinstance(data, StoredRun):
            return data
        found = {path: data.sensitivity(path) for path in data.sensitivities}
        tips = {path: tip for path, tip in found.items() if tip is not None}
        return cls(data.columns, data.data(), data.json, data.report, data.text, tips)

    @classmethod
    def read(cls, folder: Path, json: str, report: str) -> "StoredRun":
        """That of a folder."""
        found = _efam.columns(folder / "trajectory.parquet")
        text = (folder / "scenario.resolved.toml").read_text(encoding="utf-8")
        return cls(list(found), np.column_stack(list(found.values())), json, report, text, {})

    def __reduce__(self) -> Any:
        return StoredRun, tuple(getattr(self, own.name) for own in fields(self))

    @property
    def nodes(self) -> int:
        """Nodes of the mesh."""
        return sum(name.startswith("x_") for name in self.columns)

    @property
    def warnings(self) -> list[str]:
        """Warnings of the run."""
        return list(json.loads(self.json)["warnings"])

    @property
    def sensitivities(self) -> list[str]:
        """Parameters by which the tip is differentiated."""
        return list(self.tips)

    def data(self) -> Floats:
        """All numbers."""
        return self.numbers

    def sensitivity(self, path: str) -> Optional[Floats]:
        """Derivatives of the tip by a parameter."""
        return self.tips.get(path)

    @cached_property
    def _again(self) -> RunData:
        has_errors = json.loads(self.json)["errors"] is not None
        return Model(self.text).run(error_estimate=has_errors)

    def page(self) -> str:
        """The page, of the same run made again."""
        return self._again.page()

    def write(self, out: Any, overwrite: bool, csv: bool) -> Any:
        """Writes the folder of the same run made again."""
        return self._again.write(out, overwrite, csv)
