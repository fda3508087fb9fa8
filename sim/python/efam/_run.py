"""Runs, with their numbers as arrays."""

import html
import json
import os
import tempfile
import webbrowser
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import NDArray

from ._efam import Model, RunData, tips_of_many
from ._extras import optional
from ._progress import bar

Source = Union[Model, str, "os.PathLike[str]", Mapping[str, Any]]
Floats = NDArray[np.float64]


def model_of(source: Source) -> Model:
    """The model of whatever describes one."""
    return source if isinstance(source, Model) else Model(source)


class Run:
    """A run: arrays in SI units, in the frame of the clamp with x along the level rod and z up."""

    def __init__(self, data: RunData) -> None:
        self._data = data

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

        return pandas.DataFrame(self.data, columns=self.columns)

    def to_xarray(self) -> Any:
        """The run as an xarray.Dataset over time, node and axis."""
        xarray = optional("xarray")

        axes = ("time", "axis")
        data = {
            "tip": (axes, self.tip),
            "tip_velocity": (axes, self.tip_velocity),
            "nodes": (("time", "node", "axis"), self.nodes),
            **{f"{name}_energy": (("time",), energy) for name, energy in self.energies.items()},
        }
        coordinates = {"time": self.t, "axis": ["x", "z"]}
        return xarray.Dataset(data, coords=coordinates, attrs={"name": self.summary["name"]})

    def plot(self, axes: Any = None) -> Any:
        """Draws postures and the height of the tip by matplotlib; returns the axes."""
        if axes is None:
            pyplot = optional("matplotlib.pyplot")

            _, axes = pyplot.subplots(1, 2, figsize=(9, 3.5), layout="constrained")
        for sample in np.linspace(0, len(self.t) - 1, 12).astype(int) if len(self.t) else []:
            axes[0].plot(*(1e3 * self.nodes[sample].T), color="C0", alpha=0.5)
        axes[0].plot(*(1e3 * self.tip.T), color="C1", linewidth=0.5)
        axes[0].set(xlabel="x, mm", ylabel="z, mm", aspect="equal")
        axes[1].plot(self.t, 1e3 * self.tip[:, 1])
        axes[1].set(xlabel="time, s", ylabel="height of the tip, mm")
        return axes

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
class Many:
    """The tips of many runs."""

    t: Floats
    """Times, s, shape [T]."""
    tip: Floats
    """Positions of the tips, m, shape [models, T, 2]; not a number after the end of a run."""
    failures: dict[int, str]
    """Why a run ended early, by its place among the models."""


def simulate(
    scenario: Source,
    /,
    *,
    error_estimate: bool = True,
    sensitivities: Sequence[str] = (),
    **options: Any,
) -> Run:
    """Simulates a scenario: a path, its text, a dict or a model.

    Options are those of `efam simulate`, such as payload="80 g", pressure="15 psi", angle, duration. A key of the
    scenario goes by its path: **{"effects.air_drag.drag_coefficient": 1.1}. A text has its unit, a number is SI.
    """
    model = model_of(scenario)
    model = model.replace(**options) if options else model
    return Run(model.run(error_estimate=error_estimate, sensitivities=list(sensitivities)))


def simulate_many(
    models: Iterable[Source], *, rate: float = 100.0, progress: Optional[bool] = None
) -> Many:
    """Simulates many models on all cores, without estimates of errors, with their tips sampled `rate` times a second."""
    own = [model_of(model) for model in models]
    with bar("simulate", " runs", progress) as tell:
        t, tip, failures = tips_of_many(own, rate, tell)
    return Many(t, tip.reshape(len(own), len(t), 2), dict(failures))
