"""Recordings and experiments: from files, tables and arrays, the same to the bit; and the answers that come of them."""

import datetime
import json
import subprocess

import efam
import numpy as np
import pandas as pd
import pytest

from conftest import EFAM, ROOT

FOLDER = ROOT / "scenarios" / "diagnosis" / "nothing"
EXPERIMENT = FOLDER / "experiment.toml"
# One recording of the experiment, and what is said of it there; numbers are SI.
MODEL = {
    "muscle": {"name": "garbulinski-2022"},
    "effects": {"rayleigh_mass": {"alpha": 0.6}, "rayleigh_stiffness": {"beta": "10 ms"}},
    "calibrate": {"parameter": [{"path": "rod.bending_stiffness"}, {"path": "effects.rayleigh_mass.alpha"}]},
}
OF_RECORDING = {"pressure": "15 psi", "tip": "tip", "up": "+z", "along": "+x", "angle": 0.0, "offset": "none"}


@pytest.fixture
def frame():
    return pd.read_csv(FOLDER / "15psi-1.csv")


def experiment(file, **options):
    return efam.Experiment(**MODEL, recording={"file": file, **OF_RECORDING, **options})


def program(*arguments):
    ran = subprocess.run([*EFAM, *map(str, arguments), "--json"], check=True, capture_output=True, text=True)
    return json.loads(ran.stdout)


def test_a_file_a_table_and_arrays_are_one_recording(frame):
    by_file = efam.Recording(FOLDER / "15psi-1.csv")
    tip = frame[["tip_x_mm", "tip_z_mm"]].to_numpy()
    others = [
        efam.Recording(frame),
        efam.Recording(frame.set_index("t_s")),
        efam.Recording(times=frame["t_s"], markers={"tip": tip}, unit="mm"),
        efam.Recording(times=list(frame["t_s"]), markers=tip, unit="mm"),
        efam.Recording(markers=tip[:, np.newaxis], names=["tip"], unit="mm", rate=100),
        efam.Recording(by_file.to_pandas()),
    ]
    assert by_file.rate == 100 and by_file.markers == ["tip"] and by_file.positions.shape == (len(tip), 1, 3)
    for other in others:
        assert np.array_equal(other.times, by_file.times), other
        assert np.array_equal(other["tip"], by_file["tip"], equal_nan=True), other
    assert "100 Hz" in repr(by_file) and "mm, as the line of names states" in str(by_file)


def test_what_is_no_number_was_lost(frame):
    frame.loc[3, "tip_x_mm"] = np.nan
    recording = efam.Recording(frame.assign(note="text", seen=True))
    assert np.isnan(recording["tip"][3]).all() and np.isfinite(recording["tip"][4]).all()
    assert any("note" in finding for finding in recording.findings)
    assert any("lost" in finding for finding in recording.findings), recording.findings


def test_times_of_any_kind_are_seconds(frame):
    tip = frame[["tip_x_mm", "tip_z_mm"]].to_numpy()
    milliseconds = np.round(1e3 * frame["t_s"].to_numpy()).astype(int)
    due = 1e-3 * (milliseconds - milliseconds[0])
    start = np.datetime64("2026-01-01T23:59:59")
    for unit, factor in (("ms", 1), ("us", 10**3), ("ns", 10**6)):
        spans = (milliseconds * factor).astype(f"m8[{unit}]")
        for times in (spans, start + spans, list(spans), (start + spans).astype(object) if unit != "ns" else spans):
            own = efam.Recording(times=times, markers=tip, unit="mm")
            assert own.rate == 100 and np.allclose(own.times - own.times[0], due, rtol=0, atol=1e-9), times[:2]
    spans = pd.to_timedelta(milliseconds, unit="ms")
    dates = pd.Timestamp("2026-01-01", tz="Europe/Oslo") + spans
    bare = frame.drop(columns="t_s")
    tables = [bare.assign(**{name: clock}) for name in ("t_s", "Time", "timestamp", "t_ms") for clock in (spans, dates)]
    tables += [bare.set_axis(clock) for clock in (spans, dates)]
    tables += [bare.set_axis(clock.rename("time")) for clock in (spans, dates)]
    for table in tables:
        own = efam.Recording(table)
        assert own.rate == 100 and np.allclose(own.times - own.times[0], due, rtol=0, atol=1e-9), table.head(2)
    # A column of dates beside the clock of the recording is none.
    own = efam.Recording(frame.assign(date=dates, until=spans))
    assert own.rate == 100 and own.markers == ["tip"]


def test_what_is_masked_was_lost(frame):
    tip = np.ma.array(frame[["tip_x_mm", "tip_z_mm"]].to_numpy())
    due = np.isnan(tip.data).any(axis=1)
    due[100:110] = True
    tip[100:110] = 99.0
    tip[100:110] = np.ma.masked
    whole = np.ma.stack([tip, tip], axis=1)
    for markers in ({"tip": tip}, tip, whole, list(tip), {"tip": tip.astype(np.float32)}):
        own = efam.Recording(markers=markers, unit="mm", rate=100)
        for marker in own.markers:
            assert np.array_equal(np.isnan(own[marker]).any(axis=1), due)
    # The tables of pandas mark lost numbers by an object of their own.
    frame = frame.astype({"tip_x_mm": "Float64"})
    frame.loc[100:109, "tip_x_mm"] = pd.NA
    marker = frame[["tip_x_mm", "tip_z_mm"]]
    of_arrays = efam.Recording(times=frame["t_s"], markers={"tip": marker}, unit="mm")
    for own in (efam.Recording(frame), of_arrays):
        assert np.array_equal(np.isnan(own["tip"]).any(axis=1), due)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        (np.zeros((5, 2), complex), "complex numbers, where real ones are due"),
        ([[0.0, 1j]] * 5, "complex numbers, where real ones are due"),
        (np.zeros((5, 2), bool), "booleans, where numbers are due"),
        ([[True, False]] * 5, "booleans, where numbers are due"),
        (np.array([[1.0, True]] * 5, dtype=object), "booleans, where numbers are due"),
        (np.array([["1.0", "2.0"]] * 5), "text, where numbers are due"),
        (np.zeros((5, 2), "m8[s]"), "give them as times="),
        (np.zeros((5, 2), "M8[s]"), "give them as times="),
        ([[datetime.timedelta(0)] * 2] * 5, "give them as times="),
    ],
)
def test_arrays_of_other_kinds_are_refused_by_name(values, words):
    with pytest.raises(efam.DataError) as met:
        efam.Recording(markers={"tip": values}, rate=100)
    assert "marker tip: " in str(met.value) and words in str(met.value)
    if "times=" not in words:
        with pytest.raises(efam.DataError, match=f"times: {words}"):
            efam.Recording(times=[row[-1] for row in values] if isinstance(values, list) else values[:, 1],
                           markers=np.zeros((5, 2)))


def test_clocks_without_a_unit_are_refused(frame):
    for times in (np.arange(5).astype("m8"), np.arange(5).astype("M8[M]")):
        with pytest.raises(efam.DataError, match="times: numbers in an array are due"):
            efam.Recording(times=times, markers=np.zeros((5, 2)))
    for column in (frame["tip_x_mm"] > 0, frame["tip_x_mm"] + 1j, frame["tip_x_mm"].astype(str)):
        with pytest.raises(efam.DataError, match="tip_x_mm.*(bool|complex128|str|object)"):
            efam.Recording(frame.assign(tip_x_mm=column))


@pytest.mark.parametrize(
    ("arguments", "error", "words"),
    [
        ({}, TypeError, "a file, a table, or"),
        ({"markers": [[1, 2]], "unit": "furlong"}, efam.DataError, "furlong"),
        ({"markers": np.zeros((5, 4)), "rate": 100}, efam.DataError, "[T, 3] is due"),
        ({"markers": np.zeros((5, 2)), "times": [0, 1]}, efam.DataError, "2 are due"),
        ({"markers": np.zeros((5, 2))}, efam.DataError, "rate"),
        ({"markers": np.zeros((5, 2)), "rate": -1}, efam.DataError, "rate"),
        ({"markers": np.zeros((3, 2)), "times": [0, 2, 1]}, efam.DataError, "2"),
        ({"markers": np.full((5, 2), np.nan), "rate": 1}, efam.DataError, "lost"),
        ({"markers": [["a", "b"]]}, efam.DataError, "numbers"),
        ({"markers": np.zeros((5, 2, 2)), "names": ["a", "a"]}, efam.DataError, "2 different ones"),
    ],
)
def test_arrays_that_are_no_recording(arguments, error, words):
    with pytest.raises(error) as met:
        efam.Recording(**arguments)
    assert words in str(met.value)


def test_files_and_tables_that_are_no_recording(tmp_path):
    with pytest.raises(efam.DataError, match="nowhere.csv: cannot be read"):
        efam.Recording("nowhere.csv")
    with pytest.raises(efam.DataError, match="must hold numbers"):
        efam.Recording(pd.DataFrame({"t_s": [0.0, 1.0], "tip_x_m": ["a", "b"], "tip_z_m": [0.0, 1.0]}))
    with pytest.raises(KeyError, match="no such marker"):
        efam.Recording(FOLDER / "15psi-1.csv")["top"]


def test_a_recording_in_memory_gives_the_calibration_of_its_file(frame):
    by_file = efam.calibrate(experiment(str(FOLDER / "15psi-1.csv")))
    in_memory = efam.calibrate(experiment(efam.Recording(frame, name="15psi-1.csv")))
    assert in_memory["parameters"] == by_file["parameters"] and in_memory["releases"] == by_file["releases"]
    # What it found goes on without a file.
    (name,) = in_memory.models
    prediction = efam.predict(in_memory, pressure="15 psi", payload="20 g", draws=8)
    assert name == "muscle.toml" and prediction["draws"] == 8, prediction
    compared = efam.predict(in_memory, check=experiment(efam.Recording(frame)), draws=8)
    assert len(compared["releases"]) == 1 and "recording#1" in str(compared)
    frame = in_memory.to_pandas("parameters")
    assert list(frame["name"]) == ["rod.bending_stiffness", "effects.rayleigh_mass.alpha"]


def test_an_answer_writes_the_folder_of_the_program(tmp_path):
    # A check is the shortest command with a page.
    found = efam.check(EXPERIMENT)
    printed = program("experiment", "check", EXPERIMENT, "--out", tmp_path / "program")
    assert found["releases"] == printed["releases"] and found["decisions"] == printed["decisions"]
    folder = found.write(tmp_path / "own")
    names = [sorted(path.name for path in of.iterdir()) for of in (folder, tmp_path / "program")]
    assert names[0] == names[1]
    with pytest.raises(efam.ScenarioError, match="--overwrite"):
        found.write(tmp_path / "own")
    found.write(tmp_path / "own", overwrite=True)
    assert "15psi-1.csv" in found.page() and found._repr_html_().startswith("<iframe srcdoc=")


def test_an_analysis_is_that_of_the_program(tmp_path):
    options = ["--nodes", "8", "--set", "recording[1].up=\"+z\"", "--out", tmp_path / "out"]
    printed = program("analyse", EXPERIMENT, *options)
    found = efam.analyse(EXPERIMENT, nodes=[8], **{"recording[1].up": "+z"})
    assert found["analysis"] == printed["analysis"]
    assert "EI from the tip" in str(found)


def test_a_first_experiment_is_that_of_the_program(tmp_path):
    file = FOLDER / "15psi-1.csv"
    subprocess.run([*EFAM, "experiment", "init", str(file), "--out", str(tmp_path / "experiment.toml")], check=True,
                   capture_output=True)
    own = efam.Experiment.init(file)
    lines = [text.splitlines() for text in (own.text, (tmp_path / "experiment.toml").read_text())]
    differing = [pair for pair in zip(*lines) if pair[0] != pair[1]]
    assert len(lines[0]) == len(lines[1]) and all(pair[0].startswith("file = ") for pair in differing)
    assert not own.has_model and own.recordings == ["15psi-1.csv"]
    assert len(efam.check(own)["releases"]) == 1
    with_model = own.replace(**MODEL, **{"recording[1].pressure": 103421.355})
    assert with_model.has_model and "GUESS" in str(with_model)


def test_errors_of_experiments_have_the_words_of_the_program(frame):
    recording = efam.Recording(frame)
    for made, error, words in [
        (lambda: efam.Experiment(), efam.ScenarioError, "[[recording]]"),
        (lambda: efam.Experiment("nowhere.toml"), efam.ScenarioError, "cannot be read"),
        (lambda: experiment(recording, tipp="x"), efam.ScenarioError, "did you mean `tip`"),
        (lambda: efam.check(experiment(recording, pressure=-1e9)), efam.ScenarioError, "pressure"),
        (lambda: efam.check(experiment(recording, tip="top")), efam.EfamError, "top"),
        (lambda: efam.check(experiment(recording, unit="mm")), efam.ScenarioError, "is in memory"),
        (lambda: efam.check(experiment("nowhere.csv")), efam.EfamError, "nowhere.csv"),
        (lambda: efam.Experiment(recording="15psi.csv"), TypeError, "a table or a list"),
        (lambda: efam.diagnose(experiment(recording), false_alarm=2), efam.ScenarioError, "between 0 and 1"),
        (lambda: efam.diagnose(experiment(recording), budget=0), efam.ScenarioError, "number of node steps"),
        (lambda: efam.diagnose(experiment(recording), without=["air_drg"]), efam.ScenarioError, "did you mean `air_drag`"),
        (lambda: efam.analyse(experiment(recording), nodes=[1]), efam.ScenarioError, "4..=2000"),
        (lambda: efam.predict("nowhere.toml"), efam.DataError, "cannot be read"),
        (lambda: efam.predict(), TypeError, "is due"),
        (lambda: efam.sweep("nowhere.toml"), efam.ScenarioError, "cannot be read"),
        (lambda: efam.sweep({"sweep": {"scenario": "x"}}), efam.ScenarioError, "x"),
        (lambda: efam.calibrate(experiment(recording), progress=True) and None, None, ""),
    ]:
        if error is None:
            made()
            continue
        with pytest.raises(error) as met:
            made()
        assert words in str(met.value), met.value


def test_a_sweep_is_that_of_the_program(tmp_path, scenario):
    tables = {
        "scenario": str(scenario),
        "design": "grid",
        "parameter": [
            {"path": "effects.payload.mass", "values": ["0 g", "50 g"]},
            {"path": "rod.nodes", "values": [12, 16]},
        ],
    }
    own = efam.sweep({"name": "map", "sweep": tables}, points_per_shard=2)
    assert len(own.to_pandas()) == 4 and list(own.columns["effects_payload_mass_kg"]) == [0, 0, 0.05, 0.05]
    assert own["points"] == 4 and own["failed"] == 0 and "4 points" in str(own)
    file = tmp_path / "map.toml"
    rows = "".join(f"[[sweep.parameter]]\npath = {json.dumps(row['path'])}\nvalues = {json.dumps(row['values'])}\n"
                   for row in tables["parameter"])
    file.write_text(f"name = \"map\"\n[sweep]\ndesign = \"grid\"\nscenario = {json.dumps(str(scenario))}\n{rows}")
    printed = program("sweep", file, "--points-per-shard", 2, "--out", tmp_path / "out")["sweep"]
    # The hash is that of the text as well.
    assert {**own, "plan_sha256": ""} == {**printed, "plan_sha256": ""}
    again = efam.sweep(file, points_per_shard=2, out=tmp_path / "out")
    assert again["numbers"] == own["numbers"] and again.folder == tmp_path / "out"
    folder = own.folder
    assert folder.is_dir() and own.write(tmp_path / "copy").joinpath("sweep.parquet").is_file()
    del own
    assert not folder.exists(), "a folder for temporary files goes with its object"


def test_progress_is_told_and_what_it_raises_ends_the_work(model):
    told = []
    efam._efam.tips_of_many([model] * 30, 10.0, False, lambda *seen: told.append(seen))
    assert told[-1] == (30, 30, "") and told == sorted(told)

    def stop(*_):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        efam._efam.tips_of_many([model.replace(duration=1000)] * 30, 10.0, False, stop)
    assert efam.simulate_many([model], progress=True).failures == {}


def random_value(random, depth=2):
    """Something that a person might give by mistake, or as it should be."""
    values = [0, -1, 1e308, float("nan"), True, None, "", "15 psi", "x\x00", "+z", "held", b"bytes", object(), 10**400,
              np.zeros(3), np.float32(1), "tip", [], {}, ["tip", "top"], "0 deg", [[0, 1], [2, 3]], 2, [1, 2]]
    kind = random.integers(5) if depth else 0
    if kind == 1:
        return [random_value(random, depth - 1) for _ in range(random.integers(3))]
    if kind == 2:
        return {random_key(random): random_value(random, depth - 1) for _ in range(random.integers(3))}
    return values[random.integers(len(values))]


def random_key(random):
    keys = ["file", "pressure", "payload", "tip", "body", "base", "up", "angle", "start", "offset", "instants", "keep",
            "held_out", "noise", "mask", "release", "muscle", "rod", "effects", "recording", "calibrate", "recording[1]",
            "recording[1].angle", "recording[9].tip", "recording[1].mask", "a b", "", "a\nb", "calibrate.mesh", "name"]
    return keys[random.integers(len(keys))]


def test_no_argument_makes_experiments_and_recordings_panic(frame):
    """Whatever is given, there is an answer or an exception of Python, and never that of a panic."""
    random = np.random.default_rng(2)
    recording = efam.Recording(frame)
    met = {}
    for turn in range(1500):
        options = {random_key(random): random_value(random) for _ in range(random.integers(1, 4))}
        try:
            if turn % 3 == 0:
                shape = random.integers(0, 5, size=random.integers(1, 4))
                markers = random_value(random) if random.random() < 0.3 else random.normal(size=shape)
                efam.Recording(markers=markers, times=random_value(random, 0), unit=random_value(random, 0) or "m",
                               rate=random_value(random, 0))
            elif turn % 3 == 1:
                efam.Experiment(**{**MODEL, "recording": [{"file": recording, **OF_RECORDING, **options}]})
            else:
                made = experiment(recording).replace(**options)
                efam.check(made) if turn % 9 == 2 else None
        except BaseException as error:
            met.setdefault(type(error).__name__, error)
    allowed = {"ScenarioError", "DataError", "SimulationError", "TypeError", "OverflowError", "ValueError"}
    assert set(met) <= allowed, {name: met[name] for name in set(met) - allowed}
    assert {"ScenarioError", "DataError", "TypeError"} <= set(met), "the arguments are bad enough"
