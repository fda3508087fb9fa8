"""Experiments: recordings, what was measured in each, and the model that is compared with them."""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Optional, Union

from ._efam import ExperimentData, RecordingData, first_experiment
from ._recording import Recording

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._options import ExperimentOptions

Source = Union["Experiment", str, "os.PathLike[str]", Mapping[str, Any], None]
Held = list[tuple[str, RecordingData]]

_count = itertools.count(1)


class Experiment:
    """An experiment: recordings, what is known of each, and a model. It does not change.

    It comes from a file, its text, or tables with the keys of the file. A recording's `file` may be an efam.Recording.
    Options set keys by their paths. A text has its unit, a number is SI.

    >>> efam.Experiment("beam.toml", **{"calibrate.mesh": "kept"})
    >>> efam.Experiment(rod={"length": 0.3, ...}, recording={"file": recording, "tip": "tip", "angle": "0 deg"})
    """

    _data: ExperimentData

    def __init__(self, source: Source = None, /, **options: Unpack[ExperimentOptions]) -> None:
        held: Held = []
        tables = _tables(options, held)
        if isinstance(source, Experiment):
            self._data = source._data.replace(tables, held)
        elif source is None:
            self._data = ExperimentData(tables, {}, held)
        elif isinstance(source, Mapping):
            self._data = ExperimentData(_tables(source, held), tables, held)
        else:
            self._data = ExperimentData(source, tables, held)

    @classmethod
    def init(
        cls, *recordings: Union[Recording, str, "os.PathLike[str]"], name: str = "experiment"
    ) -> Experiment:
        """A first experiment from recordings, as `efam experiment init` writes it.

        `text` marks with GUESS what was guessed, and with FILL IN what nobody can know from recordings. `replace` sets
        it, and adds the model.
        """
        if not recordings:
            raise TypeError("Experiment.init: one recording at least is due")
        held: Held = []
        for own in recordings:
            held.append(_hold(own if isinstance(own, Recording) else Recording(own)))
        made = cls.__new__(cls)
        made._data = ExperimentData(first_experiment(name, held), {}, held)
        return made

    def replace(self, **options: Unpack[ExperimentOptions]) -> Experiment:
        """The same with something else: **{"recording[1].pressure": "15 psi"}, or rod={...}."""
        return Experiment(self, **options)

    @property
    def name(self) -> str:
        """Its name."""
        return self._data.name

    @property
    def text(self) -> str:
        """Its text, without what options set."""
        return self._data.text

    @property
    def settings(self) -> list[str]:
        """What options set, as --set takes it."""
        return self._data.settings

    @property
    def recordings(self) -> list[str]:
        """Name of each recording."""
        return self._data.recordings

    @property
    def has_model(self) -> bool:
        """Whether it has a model that can be compared with the recordings."""
        return self._data.has_model

    def write(self, path: Union[str, "os.PathLike[str]"], *, overwrite: bool = False) -> Path:
        """Writes its text to a file."""
        with open(path, "w" if overwrite else "x", encoding="utf-8") as file:
            file.write(self.text)
        return Path(path)

    def __str__(self) -> str:
        settings = "".join(f"# set: {setting}\n" for setting in self.settings)
        return self.text + settings

    def __repr__(self) -> str:
        model = "with a model" if self.has_model else "without a model"
        return f"<efam.Experiment {self.name}: {', '.join(self.recordings)}; {model}>"


def data_of(source: Source, options: Optional[Mapping[str, Any]] = None) -> ExperimentData:
    """The experiment of whatever describes one, with options set over it."""
    if isinstance(source, Experiment) and not options:
        return source._data
    return Experiment(source, **(options or {}))._data


def _hold(recording: Recording) -> tuple[str, RecordingData]:
    # Paths of no file, and different ones for recordings of one name.
    return f"in memory {next(_count)}/{recording.name}", recording._data


def _tables(options: Mapping[str, Any], held: Held) -> dict[str, Any]:
    """Options with paths in place of recordings, which go to `held`."""
    tables = dict(options)
    for key, value in tables.items():
        if isinstance(value, Recording):
            held.append(_hold(value))
            tables[key] = held[-1][0]
        elif key == "recording":
            each: Iterable[Any] = [value] if isinstance(value, Mapping) else value
            if isinstance(value, str) or not isinstance(value, Iterable):
                raise TypeError(f"recording: a table or a list of them is due, not {type(value).__name__}")
            tables[key] = [_tables(own, held) if isinstance(own, Mapping) else own for own in each]
    return tables
