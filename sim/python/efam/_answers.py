"""Analysis, calibration, diagnosis, prediction and sweeps, with the options and the words of the program."""

from __future__ import annotations

import html
import json
import os
import re
import shutil
import tempfile
import webbrowser
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np
from numpy.typing import NDArray

from . import _efam
from ._efam import AnswerData, ResidualsData
from ._experiment import Source, data_of
from ._extras import optional
from ._progress import bar
from ._run import Run, model_of
from ._run import Source as Scenario
from ._stored import StoredAnswer, StoredRun, files_of

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._options import ExperimentOptions, Options

Path = Union[str, "os.PathLike[str]"]
Floats = NDArray[np.float64]

_REPORT = "report.html"


class Answer(Mapping[str, Any]):
    """What a command prints with --json, as a mapping; as text, the table that it prints."""

    def __init__(self, data: Union[AnswerData, StoredAnswer]) -> None:
        self._data = data

    def __reduce__(self) -> Any:
        own, files = self._data, []
        if isinstance(own, StoredAnswer):
            files = own.files
        elif own.has_folder:
            with tempfile.TemporaryDirectory(prefix="efam-") as folder:
                files = files_of(self.write(FilePath(folder) / "answer"))
        return type(self), (StoredAnswer(own.json, own.table, own.models, files),)

    @cached_property
    def _entries(self) -> dict[str, Any]:
        entries: dict[str, Any] = json.loads(self._data.json)
        return entries

    def __getitem__(self, key: str) -> Any:
        return self._entries[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)

    @property
    def warnings(self) -> list[str]:
        """Warnings: read them before you use the result."""
        return list(self._entries.get("warnings", []))

    @property
    def models(self) -> dict[str, str]:
        """Of a calibration: texts of the files with the calibrated model, by their names; `predict` takes them."""
        return dict(self._data.models)

    def to_pandas(self, key: str) -> Any:
        """A list of the answer, such as "parameters", as a pandas.DataFrame."""
        pandas = optional("pandas")

        return pandas.json_normalize(self[key])

    def plot(self, axes: Any = None) -> Any:
        """Draws the 95 % intervals of a calibration or prediction, in % of each value, by matplotlib; returns the axes."""
        rows = [own for own in self.get("parameters") or self.get("quantities") or [] if own.get("interval_95")]
        if not rows:
            raise TypeError("plot: there are no intervals here; report() shows the page with its pictures")
        if axes is None:
            pyplot = optional("matplotlib.pyplot")

            _, axes = pyplot.subplots(figsize=(8, 1 + 0.3 * len(rows)), layout="constrained")
        for place, own in enumerate(rows):
            low, high = (100 * (end - own["value"]) / abs(own["value"]) for end in own["interval_95"])
            axes.plot([low, high], [place, place], color="C0", marker="|")
            axes.plot(0, place, color="C0", marker="o")
        names = [own["name"] for own in rows]
        if len(set(names)) < len(names):
            names = [f"{own['name']}, {1e-3 * (own['pressure_pa'] or 0):.0f} kPa" for own in rows]
        values = [f"{name}: {own['value']:.4g} {own['unit']}" for name, own in zip(names, rows)]
        axes.set(yticks=range(len(rows)), yticklabels=values, xlabel="95 % interval, % of the value")
        axes.invert_yaxis()
        return axes

    def write(self, out: Optional[Path] = None, *, overwrite: bool = False) -> FilePath:
        """Writes the folder that the program writes: `out`, or a new one in outputs/. Returns where it is."""
        return FilePath(self._data.write(out, overwrite))

    def page(self) -> str:
        """The page, as the program writes it."""
        with tempfile.TemporaryDirectory(prefix="efam-") as folder:
            return (self.write(FilePath(folder) / "answer") / _REPORT).read_text(encoding="utf-8")

    def report(self) -> FilePath:
        """Writes the page to a new folder for temporary files and opens it in a browser."""
        path = FilePath(tempfile.mkdtemp(prefix="efam-")) / _REPORT
        path.write_text(self.page(), encoding="utf-8")
        webbrowser.open(path.as_uri())
        return path

    def _repr_html_(self) -> Optional[str]:
        if not self._data.has_folder:
            return f"<pre>{html.escape(str(self))}</pre>"
        return _framed(self.page())

    def __str__(self) -> str:
        return self._data.table

    def __repr__(self) -> str:
        names = list(self._entries)
        more = ", ..." if len(names) > 6 else ""
        return f"<efam.{type(self).__name__}: {', '.join(names[:6])}{more}>"


def _framed(page: str) -> str:
    srcdoc = html.escape(page, quote=True)
    return f'<iframe srcdoc="{srcdoc}" style="width: 100%; height: 40em; border: 0"></iframe>'


class Posterior(Answer):
    """The posterior of a calibration. Warnings, R-hat and effective draws say whether it can be trusted."""

    @cached_property
    def draws(self) -> dict[str, Floats]:
        """Draws of each parameter and nuisance parameter by its name, SI, shape [chains, draws]."""
        return {own["name"]: np.array(own["draws"]) for own in [*self["parameters"], *self["nuisances"]]}

    @cached_property
    def log_likelihood(self) -> dict[str, Floats]:
        """Logarithm of the likelihood of each release by its name, up to a constant, shape [chains, draws]."""
        return {name: np.array(own) for name, own in zip(self["releases"], self["log_likelihood"])}

    def to_arviz(self) -> Any:
        """The same for ArviZ, with priors, predictions and recordings: its InferenceData, or its DataTree from 1.0 on."""
        arviz = optional("arviz")
        unknowns = [*self["parameters"], *self["nuisances"]]
        markers = {f"{own['marker']} of {own['release']}": own for own in self["markers"]}
        is_predicted = any(own["predicted_m"][0] for own in markers.values())
        groups: dict[str, Any] = {
            "posterior": self.draws,
            "log_likelihood": self.log_likelihood,
            "prior": {own["name"]: np.array(own["prior"]) for own in unknowns if own["prior"]},
            "observed_data": {name: np.array(own["recorded_m"]) for name, own in markers.items()},
        }
        if is_predicted:
            groups["posterior_predictive"] = {name: np.array(own["predicted_m"]) for name, own in markers.items()}
        axes = {
            "dims": {name: [f"time of {name}", "axis"] for name in markers},
            "coords": {f"time of {name}": own["time_s"] for name, own in markers.items()} | {"axis": ["x", "z"]},
        }
        is_tree = int(arviz.__version__.split(".")[0]) >= 1
        found = arviz.from_dict(groups, **axes) if is_tree else arviz.from_dict(**groups, **axes)
        for group, own in [(group, own) for group in ("posterior", "prior") for own in unknowns]:
            if own["name"] in groups[group]:
                found[group][own["name"]].attrs["units"] = own["unit"]
        for group in {"observed_data", "posterior_predictive"} & groups.keys():
            for name in markers:
                found[group][name].attrs["units"] = "m"
        return found


class Sweep(Answer):
    """A sweep: the spread of each number, and the table of all points."""

    def __init__(self, entries: str, table: str, folder: FilePath, columns: dict[str, Any], keep: Any) -> None:
        self._json, self._table = entries, table
        self.columns: dict[str, Any] = columns
        """All columns of the table by their names: arrays of numbers, lists of texts."""
        self.folder = folder
        """Path of its folder; a temporary folder is removed with this object."""
        self._keep = keep

    @cached_property
    def _entries(self) -> dict[str, Any]:
        entries: dict[str, Any] = json.loads(self._json)
        return entries

    @property
    def models(self) -> dict[str, str]:
        """None."""
        return {}

    def __reduce__(self) -> Any:
        if self._keep is not None:
            raise TypeError("a sweep in a temporary folder cannot be pickled; give out= to efam.sweep")
        return Sweep, (self._json, self._table, self.folder, self.columns, None)

    def _repr_html_(self) -> Optional[str]:
        return _framed(self.page())

    def to_pandas(self, key: Optional[str] = None) -> Any:
        """The table of all points as a pandas.DataFrame, or a list of the answer, such as "numbers"."""
        pandas = optional("pandas")

        return pandas.DataFrame(self.columns) if key is None else super().to_pandas(key)

    def write(self, out: Optional[Path] = None, *, overwrite: bool = False) -> FilePath:
        """Copies its folder, which is whole: it can be merged again, and shown by `efam report`."""
        if out is None:
            raise TypeError("write: name a folder, or give out= to efam.sweep")
        if overwrite:
            raise TypeError("write: a folder that is there is not replaced; choose another")
        return FilePath(shutil.copytree(self.folder, out))

    def page(self) -> str:
        """The page, as the program writes it."""
        return (self.folder / _REPORT).read_text(encoding="utf-8")

    def __str__(self) -> str:
        return self._table


class Residuals:
    """Residuals of an experiment at any values of its unknowns, and their Jacobian, for solvers of Python."""

    def __init__(self, experiment: Source, /, **options: Unpack[ExperimentOptions]) -> None:
        self._data = ResidualsData(data_of(experiment, options))

    @property
    def names(self) -> list[str]:
        """Name of each unknown."""
        return self._data.names

    @property
    def units(self) -> list[str]:
        """SI unit of each unknown."""
        return self._data.units

    @property
    def start(self) -> Floats:
        """Where a search starts, SI."""
        return self._data.start

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """Lowest and highest value of each unknown, as scipy takes them."""
        return self._data.bounds

    def residuals_and_jacobian(
        self, theta: Union[Sequence[float], Floats], *, exact: bool = False
    ) -> tuple[Floats, Floats]:
        """Residuals over the noise, and their derivatives, shape [residuals, unknowns].

        The derivatives are some per cent off, or exact by a run more for each unknown.
        """
        return self._data.residuals_and_jacobian(theta, exact=exact)


def check(experiment: Source, /, **options: Unpack[ExperimentOptions]) -> Answer:
    """Cuts the releases out of the recordings of an experiment, as `efam experiment check` does."""
    return Answer(_efam.analyse(data_of(experiment, options), None))


def analyse(
    experiment: Source, /, *, nodes: Optional[Sequence[int]] = None, **options: Unpack[ExperimentOptions]
) -> Answer:
    """Finds frequency, damping and stiffness of each release of an experiment, as `efam analyse` does."""
    own = list(nodes) if nodes is not None else _efam.analysis_nodes()
    return Answer(_efam.analyse(data_of(experiment, options), own))


def calibrate(
    experiment: Source,
    /,
    *,
    profile: bool = False,
    progress: Optional[bool] = None,
    **options: Unpack[ExperimentOptions],
) -> Answer:
    """Finds parameters of a model from the releases of an experiment, as `efam calibrate` does.

    Options set keys of the experiment by their paths: **{"calibrate.mesh": "kept"}.
    """
    data = data_of(experiment, options)
    with bar("calibrate", " stages", progress) as tell:
        return Answer(_efam.calibrate(data, profile, tell))


def sample(
    experiment: Source,
    /,
    *,
    chains: int = 4,
    draws: int = 225,
    warm_up: int = 50,
    predictions: int = 10,
    seed: int = 1,
    progress: Optional[bool] = None,
    **options: Unpack[ExperimentOptions],
) -> Posterior:
    """Draws from the posterior of the calibration of an experiment, by the no-U-turn sampler of nuts-rs.

    It calibrates first. Options are those of `calibrate`. A parameter without a prior is flat within its bounds, in its
    logarithm if the calibration has that scale. The spread is that of the calibration's errors, and the shape that of the cost.
    Of each chain, `predictions` draws predict the recordings.
    """
    data = data_of(experiment, options)
    with bar("sample", " stages", progress) as tell:
        return Posterior(_efam.sample(data, chains, draws, warm_up, predictions, seed, tell))


def fit_pressure_line(
    time: Union[Sequence[float], Floats],
    command: Union[Sequence[float], Floats],
    reading: Union[Sequence[float], Floats],
) -> Answer:
    """Finds time constant, dead time and rate limit of a pressure line from its command and the pressure that was read.

    All three have one length, in s and Pa. The command moves on straight lines between its samples; a reading that is missing is
    not a number. `answer["options"]` are options of a model: `efam.Model(scenario, **answer["options"])`.
    """
    columns = [np.asarray(own, float).ravel().tolist() for own in (time, command, reading)]
    return Answer(_efam.fit_pressure_line(*columns))


def diagnose(
    experiment: Source,
    /,
    *,
    false_alarm: float = 0.01,
    most: int = 3,
    without: Sequence[str] = (),
    budget: float = 2e9,
    progress: Optional[bool] = None,
    **options: Unpack[ExperimentOptions],
) -> Answer:
    """Finds which effect the model of an experiment lacks, as `efam diagnose` does.

    `budget` is a number of node steps (nodes times steps of the integrator), after which no further part of the search
    begins. The answer then says in which round. It depends on no clock, load or number of threads.
    """
    data = data_of(experiment, options)
    with bar("diagnose", " stages", progress) as tell:
        return Answer(_efam.diagnose(data, false_alarm, most, list(without), budget, tell))


def predict(
    of: Union[Path, Answer, None] = None,
    /,
    *,
    check: Source = None,
    draws: int = 200,
    seed: int = 1,
    progress: Optional[bool] = None,
    **options: Unpack[Options],
) -> Answer:
    """Predicts how a calibrated rod or muscle responds, with intervals, as `efam predict` does of one case.

    `of` is a calibration or its folder, a scenario or its text, such as the rod.toml of a calibration, its muscle.toml, or
    the name of a built-in muscle. Options are those of `simulate`. With `check`, an experiment, the releases of that are predicted
    and compared with it, and options set its keys.
    """
    with tempfile.TemporaryDirectory(prefix="efam-") as folder:
        rod = _rod(of, FilePath(folder))
        if check is not None:
            return Answer(_efam.compare(data_of(check, options), rod, draws, seed))
        if rod is None:
            raise TypeError("predict: a calibration, a scenario, a muscle.toml or a built-in muscle is due")
        with bar("predict", " draws", progress) as tell:
            return Answer(_efam.predict(rod, draws, seed, tell, **options))


def predict_grid(
    of: Union[Path, Answer],
    /,
    *,
    pressures: Sequence[Union[float, str]] = (),
    payloads: Sequence[Union[float, str]] = (0.0,),
    progress: Optional[bool] = None,
    **options: Unpack[Options],
) -> Answer:
    """Predicts every pressure with every payload, as `efam predict` does of several.

    `of` and the options are those of `predict`; pressures in Pa and payloads in kg, or with a unit. Without pressures it is at that of
    the scenario. Intervals follow from the principal directions of the calibration's errors instead of draws.
    """
    with tempfile.TemporaryDirectory(prefix="efam-") as folder:
        rod = _rod(of, FilePath(folder))
        assert rod is not None
        with bar("predict", " cases", progress) as tell:
            return Answer(_efam.predict_grid(rod, list(pressures), list(payloads), tell, **options))


def plan(
    *scenarios: Scenario,
    noise: Union[float, str] = "0.3 mm",
    markers: Sequence[float] = (),
    repeatability: Union[float, str, None] = None,
    progress: Optional[bool] = None,
) -> Answer:
    """What releases that are not recorded yet could show of each effect, as `efam diagnose --plan` says it.

    `noise` is that of the camera, `markers` are shares of the length on the body, and `repeatability` is the root mean square
    distance between two releases of one condition; lengths in m or with a unit.
    """
    models = [model_of(scenario) for scenario in scenarios]
    with bar("plan", " steps", progress) as tell:
        return Answer(_efam.plan(models, noise, list(markers), repeatability, tell))


def statics(scenario: Scenario, /, **options: Unpack[Options]) -> Answer:
    """Finds the rest posture of a model, as `efam statics` does."""
    return Answer(_efam.statics(model_of(scenario, **options)))


def modes(scenario: Scenario, /, *, count: int = 3, **options: Unpack[Options]) -> Answer:
    """Finds the slowest vibrations of a model about its rest, as `efam modes` does."""
    return Answer(_efam.modes(model_of(scenario, **options), count))


def effects(name: Optional[str] = None, /) -> Answer:
    """The catalogue of effects, or the page of one, as `efam effects` shows them."""
    return Answer(_efam.effects(name))


def figures(experiment: Source = None, /, **options: Any) -> Answer:
    """Draws the paper's Figures 4 to 9, as `efam figures` does: from the recordings of an experiment, or else from runs.

    Options set keys of the experiment, or of the figures' scenario: **{"effects.rayleigh_mass.alpha": "0.8 1/s"}.
    `write` writes the pictures with their numbers, and `report` opens the page.
    """
    if experiment is None:
        return Answer(_efam.figures(None, options))
    return Answer(_efam.figures(data_of(experiment, options), {}))


def compare(*runs: Union[Path, Run, Answer]) -> Answer:
    """Compares runs and answers, or their folders, as `efam report` does."""
    with tempfile.TemporaryDirectory(prefix="efam-") as folder:
        folders = [
            FilePath(folder) / str(k) if isinstance(own, (Run, Answer)) else FilePath(own)
            for k, own in enumerate(runs)
        ]
        for own, where in zip(runs, folders):
            if isinstance(own, (Run, Answer)):
                own.write(where)
        return Answer(_efam.compare_runs(folders))


def load(folder: Path, /) -> Union[Run, Answer]:
    """Reads the folder of a run or an answer back, by whichever version and program it was written."""
    kind, text, table = _efam.loaded(folder)
    own = FilePath(folder)
    if kind == "simulation":
        return Run(StoredRun.read(own, text, table))
    files = files_of(own)
    is_model = re.compile(r"rod(-[0-9]+)?\.toml|muscle\.toml").fullmatch
    models = [(name, content.decode()) for name, content in files if is_model(name)]
    return Answer(StoredAnswer(text, table, models, files))


def _rod(of: Union[Path, Answer, None], folder: FilePath) -> Optional[str]:
    """What `predict` is about, as the program takes it."""
    if of is not None and not isinstance(of, Answer):
        if not os.path.isdir(of):
            return os.fspath(of)
        found = load(of)
        if not isinstance(found, Answer):
            raise TypeError("predict: the folder of a run has no calibration; efam.load reads it")
        of = found
    if of is None:
        return None
    if len(of.models) != 1:
        names = ", ".join(of.models) or "none"
        raise TypeError(f"predict: the answer has {len(of.models)} models ({names}); give one of answer.models")
    ((name, text),) = of.models.items()
    file = folder / name
    file.write_text(text, encoding="utf-8")
    return os.fspath(file)


def sweep(
    of: Union[Path, Mapping[str, Any]],
    /,
    *,
    out: Optional[Path] = None,
    overwrite: bool = False,
    csv: bool = False,
    points_per_shard: Optional[int] = None,
    progress: Optional[bool] = None,
    **options: Any,
) -> Sweep:
    """Simulates every point of a design, or diagnoses many experiments, as `efam sweep` does.

    `of` is the file of a sweep, its text, or tables with its keys. With `out` it goes on where it was interrupted;
    without, it uses a folder for temporary files.
    """
    keep = None if out is not None else tempfile.TemporaryDirectory(prefix="efam-")
    folder = FilePath(keep.name) / "sweep" if keep is not None else FilePath(os.fspath(out or "."))
    own: Any = dict(of) if isinstance(of, Mapping) else of
    with bar("sweep", " points", progress) as tell:
        found = _efam.sweep(own, folder, overwrite, csv, points_per_shard, tell, options)
    return Sweep(found[0], found[1], FilePath(found[2]), found[3], keep)
