"""Runs, with their numbers as arrays."""

from __future__ import annotations

import base64
import html
import json
import os
import tempfile
import webbrowser
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np
from numpy.typing import NDArray

from . import _efam
from ._efam import Model, RunData
from ._extras import optional
from ._progress import bar
from ._stored import StoredRun

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._options import Options

Source = Union[Model, str, "os.PathLike[str]", Mapping[str, Any]]
Floats = NDArray[np.float64]


def model_of(source: Source, **options: Unpack[Options]) -> Model:
    """The model of whatever describes one, with options set over it."""
    model = source if isinstance(source, Model) else Model(source)
    return model.replace(**options) if options else model


class Run:
    """A run: arrays in SI units, in the frame of the clamp with x along the level rod and z up."""

    def __init__(self, data: Union[RunData, StoredRun]) -> None:
        self._data = data

    def __reduce__(self) -> Any:
        return Run, (StoredRun.of(self._data),)

    @cached_property
    def columns(self) -> list[str]:
        """Names of the columns of `data`, those of trajectory.parquet."""
        return self._data.columns

    @cached_property
    def data(self) -> Floats:
        """All numbers, shape [T, columns]; the other arrays are views of it."""
        return self._data.data()

    def __getitem__(self, column: str) -> Floats:
        """A column by its name."""
        if column not in self.columns:
            raise KeyError(f"{column}: no such column; there are {', '.join(self.columns)}")
        return self.data[:, self.columns.index(column)]

    @property
    def t(self) -> Floats:
        """Times of the samples, s, shape [T]."""
        return self["time_s"]

    @property
    def tip(self) -> Floats:
        """Position of the observed tip, m, shape [T, 2]."""
        return self._pair("tip_x_m")

    @property
    def tip_velocity(self) -> Floats:
        """Velocity of the observed tip, m/s, shape [T, 2]."""
        return self._pair("tip_vx_m_s")

    def _pair(self, first: str) -> Floats:
        begin = self.columns.index(first)
        return self.data[:, begin : begin + 2]

    def _of_nodes(self, part: slice) -> Floats:
        count = self._data.nodes
        begin = len(self.columns) - 4 * count
        return self.data[:, begin:].reshape(len(self.data), count, 4)[:, :, part]

    @property
    def nodes(self) -> Floats:
        """Positions of the nodes, m, shape [T, N+1, 2]."""
        return self._of_nodes(slice(0, 2))

    @property
    def velocities(self) -> Floats:
        """Velocities of the nodes, m/s, shape [T, N+1, 2]."""
        return self._of_nodes(slice(2, 4))

    @property
    def energies(self) -> dict[str, Floats]:
        """Energies by their kind, J, shape [T] each."""
        return {name.removesuffix("_J"): self[name] for name in self.columns if name.endswith("_J")}

    @cached_property
    def summary(self) -> dict[str, Any]:
        """What `efam simulate --json` prints of the run."""
        summary: dict[str, Any] = json.loads(self._data.json)
        return summary

    @property
    def warnings(self) -> list[str]:
        """Warnings: read them before you use the run."""
        return self._data.warnings

    @property
    def text(self) -> str:
        """The scenario, in SI units, that gives the same bits."""
        return self._data.text

    def sensitivity(self, parameter: str) -> Floats:
        """Derivative of the tip's position by a parameter, m per SI unit, shape [T, 2]."""
        found = self._data.sensitivity(parameter)
        if found is None:
            raise KeyError(f"{parameter}: not asked for; simulate with sensitivities=[{parameter!r}]")
        return found

    def to_pandas(self) -> Any:
        """The table of the run as a pandas.DataFrame, with the columns of trajectory.parquet."""
        pandas = optional("pandas")

        frame = pandas.DataFrame(self.data, columns=self.columns)
        frame.attrs = {"name": self.summary["name"], "units": "SI, as the names of the columns say"}
        return frame

    def to_xarray(self) -> Any:
        """The run as an xarray.Dataset over time, node and axis."""
        xarray = optional("xarray")

        axes = ("time", "axis")
        energies = {f"{name}_energy": (("time",), own, {"units": "J"}) for name, own in self.energies.items()}
        data = {
            "tip": (axes, self.tip, {"units": "m"}),
            "tip_velocity": (axes, self.tip_velocity, {"units": "m/s"}),
            "nodes": (("time", "node", "axis"), self.nodes, {"units": "m"}),
            **energies,
        }
        coordinates = {"time": ("time", self.t, {"units": "s"}), "axis": ["x", "z"]}
        return xarray.Dataset(data, coords=coordinates, attrs={"name": self.summary["name"]})

    def plot(self, axes: Any = None) -> Any:
        """Draws postures, evenly spread along the path of the tip, and its height by matplotlib; returns the axes."""
        if axes is None:
            pyplot = optional("matplotlib.pyplot")

            _, axes = pyplot.subplots(1, 2, figsize=(9, 3.5), layout="constrained")
        for sample in self._along_the_path(12):
            axes[0].plot(*(1e3 * self.nodes[sample].T), color="C0", alpha=0.5)
        axes[0].plot(*(1e3 * self.tip.T), color="C1", linewidth=0.5)
        axes[0].set(xlabel="x, mm", ylabel="z, mm", aspect="equal")
        axes[1].plot(self.t, 1e3 * self.tip[:, 1])
        axes[1].set(xlabel="time, s", ylabel="height of the tip, mm")
        return axes

    def _along_the_path(self, count: int) -> NDArray[np.intp]:
        """Samples between which the tip covers equal distances."""
        distance = np.concatenate([[0.0], np.linalg.norm(np.diff(self.tip, axis=0), axis=1).cumsum()])
        places = np.searchsorted(distance, np.linspace(0, distance[-1], count))
        return np.unique(places)[: len(self.t)]

    def animate(self) -> Animation:
        """The rod in motion: a notebook shows it, `write("swing.gif")` saves it."""
        with tempfile.TemporaryDirectory(prefix="efam-") as folder:
            file = Path(folder) / "run.gif"
            _efam.animated(self.write(Path(folder) / "run"), file)
            return Animation(file.read_bytes())

    def write(
        self, out: Union[str, os.PathLike[str], None] = None, *, overwrite: bool = False, csv: bool = False
    ) -> Path:
        """Writes the folder that the program writes: `out`, or a new one in outputs/. Returns where it is."""
        return Path(self._data.write(out, overwrite, csv))

    def page(self) -> str:
        """The page of the run, as the program writes it."""
        return self._data.page()

    def report(self) -> Path:
        """Writes the page to a new folder for temporary files and opens it in a browser."""
        path = Path(tempfile.mkdtemp(prefix="efam-")) / "report.html"
        path.write_text(self.page(), encoding="utf-8")
        webbrowser.open(path.as_uri())
        return path

    def _repr_html_(self) -> str:
        page = html.escape(self.page(), quote=True)
        return f'<iframe srcdoc="{page}" style="width: 100%; height: 40em; border: 0"></iframe>'

    def __str__(self) -> str:
        return self._data.report

    def __repr__(self) -> str:
        return f"<efam.Run {self.summary['name']}: {len(self.t)} samples>"


@dataclass(frozen=True)
class Animation:
    """A moving picture."""

    gif: bytes = field(repr=False)
    """The file."""

    def write(self, file: Union[str, os.PathLike[str]], *, overwrite: bool = False) -> Path:
        """Writes it to a file."""
        with open(file, "wb" if overwrite else "xb") as out:
            out.write(self.gif)
        return Path(file)

    def _repr_html_(self) -> str:
        return f'<img src="data:image/gif;base64,{base64.b64encode(self.gif).decode()}">'


@dataclass(frozen=True)
class Many:
    """The tips of many runs, and the numbers of each."""

    t: Floats
    """Times, s, shape [T]."""
    tip: Floats
    """Positions of the tips, m, shape [models, T, 2]; not a number after the end of a run."""
    failures: dict[int, str]
    """Why a run ended early, by its place among the models."""
    summaries: dict[str, Floats] = field(default_factory=dict)
    """Frequency, damping ratio, settling and more, with the names of `Run.summary`, shape [models] each; empty without
    `summaries=True`."""

    @property
    def units(self) -> dict[str, str]:
        """SI unit of each of the summaries."""
        return {name: unit for name, unit in _efam.numbers_of_many() if name in self.summaries}

    def to_pandas(self) -> Any:
        """The summaries as a pandas.DataFrame with a row for each model; `attrs["units"]` has their units."""
        if not self.summaries:
            raise TypeError("to_pandas: the summaries are due: efam.simulate_many(models, summaries=True)")
        pandas = optional("pandas")

        frame = pandas.DataFrame(self.summaries)
        frame.index.name = "model"
        frame.attrs["units"] = self.units
        return frame

    def to_xarray(self) -> Any:
        """Tips and summaries as an xarray.Dataset over model, time and axis, with units in `attrs`."""
        xarray = optional("xarray")

        units = self.units
        data: dict[str, Any] = {"tip": (("model", "time", "axis"), self.tip, {"units": "m"})}
        data |= {name: ("model", own, {"units": units[name]}) for name, own in self.summaries.items()}
        coordinates = {
            "model": np.arange(len(self.tip)),
            "time": ("time", self.t, {"units": "s"}),
            "axis": ["x", "z"],
        }
        return xarray.Dataset(data, coords=coordinates)

    def __repr__(self) -> str:
        failed = f", {len(self.failures)} failed" if self.failures else ""
        return f"<efam.Many: {len(self.tip)} runs, {len(self.t)} samples{failed}>"


def simulate(
    scenario: Source,
    /,
    *,
    error_estimate: bool = True,
    sensitivities: Sequence[str] = (),
    **options: Unpack[Options],
) -> Run:
    """Simulates a scenario: a path, its text, a dict or a model.

    Options are those of `efam simulate`, such as payload="80 g", pressure="15 psi", angle, duration. A key of the
    scenario goes by its path: **{"effects.air_drag.drag_coefficient": 1.1}. A text has its unit, a number is SI.
    """
    model = model_of(scenario, **options)
    return Run(model.run(error_estimate=error_estimate, sensitivities=list(sensitivities)))


def simulate_many(
    models: Iterable[Source],
    *,
    rate: float = 100.0,
    summaries: bool = False,
    progress: Optional[bool] = None,
) -> Many:
    """Simulates many models on all cores, without estimates of errors, with their tips sampled `rate` times a second.

    `summaries` adds frequency, damping ratio, settling and more of each.
    """
    own = [model_of(model) for model in models]
    with bar("simulate", " runs", progress) as tell:
        t, tip, numbers, failures = _efam.tips_of_many(own, rate, summaries, tell)
    names = [name for name, _ in _efam.numbers_of_many()] if summaries else []
    columns = dict(zip(names, numbers.reshape(len(own), -1).T))
    return Many(t, tip.reshape(len(own), len(t), 2), dict(failures), columns)
