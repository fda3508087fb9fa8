"""Recordings of markers: from files, tables of pandas or polars, and arrays."""

import os
from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._efam import DataError, RecordingData
from ._extras import optional

Floats = NDArray[np.float64]
Column = Union[Floats, str]


class Recording:
    """Positions of markers over time, as a motion-capture system saw them: nothing is filtered, filled in or cut.

    It comes from a file in any format that `efam inspect` reads, from a table with columns such as t_s, tip_x_m, tip_z_m,
    or from arrays:

    >>> efam.Recording("15psi.csv")
    >>> efam.Recording(frame, unit="mm")
    >>> efam.Recording(times=t, markers={"tip": tip, "base": base}, unit="mm")

    `markers` is an array per name, shape [T, 3], or [T, 2] for x and z in the plane of the swing; or one array of all,
    shape [T, markers, 3 or 2], with `names`. What is not a number was lost. Without `unit`, arrays are in metres;
    without `times`, samples come `rate` times a second. `columns` says what the columns of a file without names hold,
    such as ["t_s", "x_mm", "z_mm"].
    """

    def __init__(
        self,
        source: Any = None,
        /,
        *,
        times: Optional[ArrayLike] = None,
        markers: Union[ArrayLike, Mapping[str, ArrayLike], None] = None,
        names: Optional[Sequence[str]] = None,
        unit: Optional[str] = None,
        rate: Optional[float] = None,
        columns: Optional[Sequence[str]] = None,
        name: str = "recording",
    ) -> None:
        if (source is None) == (markers is None):
            raise TypeError("Recording: a file, a table, or times= and markers= are due, and only one of these")
        if source is None:
            assert markers is not None
            own, cells = _of_arrays(times, markers, names, unit or "m")
            self._data = RecordingData.table(name, own, cells, None, rate)
            return
        if times is not None or names is not None:
            raise TypeError("Recording: times= and names= belong to markers=; a file or table has its own")
        if hasattr(source, "columns"):
            if columns is not None:
                raise TypeError("Recording: columns= belongs to a file; a table names its own")
            own, cells = _of_table(source)
            self._data = RecordingData.table(name, own, cells, unit, rate)
        else:
            self._data = RecordingData.read(os.fspath(source), unit, rate, columns)

    @property
    def source(self) -> str:
        """The file, or the name that it was given."""
        return os.fspath(self._data.source)

    @property
    def name(self) -> str:
        """The last part of that."""
        return Path(self.source).name

    @property
    def rate(self) -> float:
        """Samples a second."""
        return self._data.rate

    @cached_property
    def times(self) -> Floats:
        """Time of each sample on the recording's own clock, s, shape [T]."""
        return self._data.times

    @cached_property
    def markers(self) -> list[str]:
        """Names of the markers."""
        return self._data.markers

    @cached_property
    def positions(self) -> Floats:
        """Positions in the recording's frame, m, shape [T, markers, 3]; not a number where a marker was lost."""
        return self._data.positions()

    @property
    def findings(self) -> list[str]:
        """What was found and decided in reading: units, gaps, jumps, lost points."""
        return self._data.findings

    def __getitem__(self, marker: str) -> Floats:
        """Positions of a marker, m, shape [T, 3]."""
        if marker not in self.markers:
            raise KeyError(f"{marker}: no such marker; there are {', '.join(self.markers)}")
        return self.positions[:, self.markers.index(marker)]

    def __len__(self) -> int:
        return len(self.times)

    def to_pandas(self) -> Any:
        """The recording as a pandas.DataFrame that makes the same recording again."""
        pandas = optional("pandas")

        names = [f"{marker}_{axis}_m" for marker in self.markers for axis in "xyz"]
        frame = pandas.DataFrame(self.positions.reshape(len(self), -1), columns=names)
        frame.insert(0, "t_s", self.times)
        return frame

    def plot(self, axes: Any = None) -> Any:
        """Draws the coordinates of all markers over time by matplotlib; returns the axes."""
        if axes is None:
            pyplot = optional("matplotlib.pyplot")

            _, axes = pyplot.subplots(3, 1, figsize=(8, 6), sharex=True, layout="constrained")
        for k, letter in enumerate("xyz"):
            axes[k].plot(self.times, 1e3 * self.positions[:, :, k])
            axes[k].set(ylabel=f"{letter}, mm")
        axes[2].set(xlabel="time, s")
        axes[0].legend(self.markers, fontsize="small", loc="upper left", bbox_to_anchor=(1, 1))
        return axes

    def __str__(self) -> str:
        seen = [f"  {name}: seen {share:.1%}" for name, share in zip(self.markers, self._shares())]
        return "\n".join([repr(self), *seen, *(f"  {finding}" for finding in self.findings)])

    def _shares(self) -> Floats:
        shares: Floats = np.isfinite(self.positions).all(axis=2).mean(axis=0)
        return shares

    def __repr__(self) -> str:
        return (
            f"<efam.Recording {self.name}: {len(self.markers)} markers, {len(self)} samples at {self.rate:g} Hz, "
            f"{self._data.format}>"
        )


def _of_arrays(
    times: Optional[ArrayLike],
    markers: Union[ArrayLike, Mapping[str, ArrayLike]],
    names: Optional[Sequence[str]],
    unit: str,
) -> tuple[list[str], list[Column]]:
    """Columns of a table from arrays."""
    if isinstance(markers, Mapping):
        if names is not None:
            raise TypeError("Recording: markers= has names already; leave names= out")
        each = {str(name): _floats(f"marker {name}", own) for name, own in markers.items()}
    else:
        whole = _floats("markers", markers)
        if whole.ndim == 2:
            whole = whole[:, np.newaxis]
        if whole.ndim != 3:
            raise DataError(f"markers: shape {whole.shape}; [T, markers, 3] is due, or [T, 3] of one")
        count = whole.shape[1]
        own_names = list(names or (["tip"] if count == 1 else [f"marker {k + 1}" for k in range(count)]))
        if len(own_names) != count or len(set(own_names)) != count:
            raise DataError(f"names: {count} different ones are due, one for each marker, and {own_names} were given")
        each = {str(name): whole[:, k] for k, name in enumerate(own_names)}
    columns: dict[str, Column] = {}
    samples = None
    if times is not None:
        clock = _floats("times", times)
        if clock.ndim != 1:
            raise DataError(f"times: shape {clock.shape}; one time for each sample is due, [T]")
        columns["t_s"], samples = clock, len(clock)
    for name, own in each.items():
        if own.ndim != 2 or own.shape[1] not in (2, 3):
            raise DataError(f"marker {name}: shape {own.shape}; [T, 3] is due, or [T, 2] for x and z")
        samples = len(own) if samples is None else samples
        if len(own) != samples:
            raise DataError(f"marker {name}: {len(own)} samples, and {samples} are due, as times and others have")
        for k, axis in enumerate("xyz" if own.shape[1] == 3 else "xz"):
            columns[f"{name}_{axis}_{unit}"] = np.ascontiguousarray(own[:, k])
    return list(columns), list(columns.values())


def _of_table(table: Any) -> tuple[list[str], list[Column]]:
    """Columns of a table of pandas, or of whatever has columns by their names."""
    index = getattr(table, "index", None)
    if getattr(index, "name", None):
        table = table.reset_index()
    names, columns = [], []
    for name in table.columns:
        own = np.asarray(table[name])
        if own.dtype.kind == "m":
            own = own / np.timedelta64(1, "s")
        names.append(str(name))
        columns.append(own.astype(float) if own.dtype.kind in "fiu" else str(own.dtype))
    return names, columns


def _floats(name: str, values: ArrayLike) -> Floats:
    try:
        return np.asarray(values, dtype=float)
    except (TypeError, ValueError) as error:
        raise DataError(f"{name}: numbers in an array are due ({error})") from None
