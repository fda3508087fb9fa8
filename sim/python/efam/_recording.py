"""Recordings of markers: from files, tables of pandas or polars, and arrays."""

import datetime
import os
import re
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
    shape [T, markers, 3 or 2], with `names`. What is masked or not a number was lost. Without `unit`, arrays are in
    metres; without `times`, samples come `rate` times a second. Times are seconds, timedelta64 or datetime64. `columns`
    says what the columns of a file without names hold, such as ["t_s", "x_mm", "z_mm"].
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
        clock = _floats("times", times, is_clock=True)
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


# Names of columns of times, whatever unit they state.
CLOCK = re.compile(r"(elapsed[ _]?)?(t|time|timestamp)([^a-z].*)?$", re.IGNORECASE)


def _of_table(table: Any) -> tuple[list[str], list[Column]]:
    """Columns of a table of pandas, or of whatever has columns by their names."""
    index: Any = getattr(table, "index", None)
    is_clock = getattr(getattr(index, "dtype", None), "kind", "") in ("m", "M")
    names: list[str] = []
    columns: list[Column] = []
    if is_clock and not any(CLOCK.match(str(name)) for name in table.columns):
        names.append("time_s")
        columns.append(_floats("index", index, is_clock=True))
    elif getattr(index, "name", None):
        table = table.reset_index()
    for name in table.columns:
        own = table[name]
        kind = np.asarray(own).dtype
        try:
            numbers = _floats(str(name), own, is_clock=bool(CLOCK.match(str(name))))
        except DataError:
            # It may be of no importance to the recording; if it is, this names it.
            names.append(str(name))
            columns.append(str(getattr(own, "dtype", kind)))
            continue
        # Durations and dates have become seconds, whatever their name states.
        names.append(str(name) if kind.kind in "fiu" or not _is_clock(np.asarray(own)) else "time_s")
        columns.append(numbers)
    return names, columns


def _is_clock(values: NDArray[Any]) -> bool:
    """Whether values are durations or dates, also as objects."""
    if values.dtype.kind != "O":
        return values.dtype.kind in "mM"
    return values.size > 0 and isinstance(values.flat[0], (datetime.datetime, datetime.timedelta))


def _floats(name: str, values: ArrayLike, *, is_clock: bool = False) -> Floats:
    """Real numbers in an array. What is masked is not a number; of a clock, durations and dates are seconds."""
    if isinstance(values, (list, tuple)) and any(np.ma.isMaskedArray(own) for own in values):
        values = np.ma.array(values)
    try:
        own = np.asarray(values)
        if _is_clock(own):
            if not is_clock:
                raise DataError(f"{name}: dates or durations, where positions are due; give them as times=")
            numbers = _seconds(own)
        else:
            numbers = _reals(name, own)
    except (TypeError, ValueError) as error:
        raise DataError(f"{name}: numbers in an array are due ({error})") from None
    if np.ma.isMaskedArray(values):
        numbers = np.where(np.ma.getmaskarray(values), np.nan, numbers)
    return numbers


def _reals(name: str, own: NDArray[Any]) -> Floats:
    """Real numbers of any width; none of a kind that would become some silently."""
    kinds = {own.dtype.kind} if own.dtype.kind != "O" else {_kind(value) for value in own.flat}
    for kind, what in (
        ("b", "booleans, where numbers are due; mark lost samples by NaN or a masked array"),
        ("c", "complex numbers, where real ones are due; give x and z apart, such as values.real and values.imag"),
        ("U", "text, where numbers are due; convert it, such as by values.astype(float)"),
    ):
        if kind in kinds:
            raise DataError(f"{name}: {what}")
    if own.dtype.kind == "O":
        # The missing value of pandas has no number.
        own = np.array([np.nan if _kind(value) == "-" else value for value in own.flat]).reshape(own.shape)
    return np.asarray(own, dtype=float)


def _kind(value: Any) -> str:
    if value is None or type(value).__name__ == "NAType":
        return "-"
    for kind, types in (("b", (bool, np.bool_)), ("c", (complex, np.complexfloating)), ("U", (str, bytes))):
        if isinstance(value, types):
            return kind
    return "O"


def _seconds(own: NDArray[Any]) -> Floats:
    """Seconds of durations, or of dates since the first."""
    if own.dtype.kind == "O":
        first = own.flat[0]
        is_date = isinstance(first, datetime.datetime)
        since = ((value - first) if is_date else value for value in own.flat)
        return np.array([value.total_seconds() for value in since], dtype=float).reshape(own.shape)
    if np.datetime_data(own.dtype)[0] == "generic":
        raise ValueError(f"{own.dtype} states no unit of time, such as timedelta64[ms]")
    if own.dtype.kind == "M":
        own = own - own[~np.isnat(own)][:1]
    seconds: Floats = own / np.timedelta64(1, "s")
    return seconds
