"""Calibration, diagnosis and prediction, with the options and the words of the program."""

import json
import os
from collections.abc import Mapping, Sequence
from typing import Any, Union

from . import _efam

Path = Union[str, "os.PathLike[str]"]


class Answer(Mapping[str, Any]):
    """What a command prints with --json, as a mapping; as text, the table that it prints."""

    def __init__(self, answer: tuple[str, str]) -> None:
        self._entries: dict[str, Any] = json.loads(answer[0])
        self._table = answer[1]

    def __getitem__(self, key: str) -> Any:
        return self._entries[key]

    def __iter__(self) -> Any:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)

    def __str__(self) -> str:
        return self._table

    def __repr__(self) -> str:
        return f"<efam.Answer: {', '.join(self._entries)}>"


def _set(options: Mapping[str, Any]) -> list[str]:
    """As --set takes them: what JSON writes, TOML reads."""
    return [f"{path}={json.dumps(value)}" for path, value in options.items()]


def calibrate(experiment: Path, /, *, profile: bool = False, **options: Any) -> Answer:
    """Finds parameters of a model from the releases of an experiment, as `efam calibrate` does.

    Options set keys of the experiment by their paths: **{"calibrate.mesh": "kept"}.
    """
    return Answer(_efam.calibrate(experiment, _set(options), profile))


def diagnose(
    experiment: Path,
    /,
    *,
    false_alarm: float = 0.01,
    most: int = 3,
    without: Sequence[str] = (),
    **options: Any,
) -> Answer:
    """Finds which effect the model of an experiment lacks, as `efam diagnose` does, without a limit of time."""
    return Answer(_efam.diagnose(experiment, _set(options), false_alarm, most, list(without)))


def predict(of: Path, /, *, draws: int = 200, seed: int = 1, **options: Any) -> Answer:
    """Predicts how a calibrated rod or muscle responds, with intervals, as `efam predict` does of one case.

    `of` is a scenario, such as the rod.toml of a calibration, its muscle.toml, or the name of a built-in muscle. Options
    are those of `simulate`.
    """
    return Answer(_efam.predict(os.fspath(of), draws, seed, **options))
