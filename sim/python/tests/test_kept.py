"""What is kept: folders written and read back, pickles, comparisons, summaries of many, pictures in motion."""

import json
import pickle
import re
import subprocess

import efam
import numpy as np
import pytest

from conftest import EFAM, ROOT

EXPERIMENT = ROOT / "scenarios" / "diagnosis" / "nothing" / "experiment.toml"


def pictures(page):
    return re.findall("<svg.*?</svg>", page, re.S)


@pytest.fixture
def kept(tmp_path, model):
    """A run in memory, from its folder, and from a pickle of each."""
    run = efam.simulate(model, payload="20 g", sensitivities=["rod.mass"])
    folder = run.write(tmp_path / "run", csv=True)
    loaded = efam.load(folder)
    return [run, loaded, pickle.loads(pickle.dumps(run)), pickle.loads(pickle.dumps(loaded))]


def test_a_run_is_the_same_from_its_folder_and_from_its_pickle(kept, tmp_path):
    run, loaded, pickled, _ = kept
    assert (tmp_path / "run" / "trajectory.csv").is_file()
    for own in kept:
        assert np.array_equal(own.data, run.data) and own.columns == run.columns
        assert np.array_equal(own.nodes, run.nodes)
        assert own.text == run.text and own.warnings == run.warnings
        assert own.summary["damping_ratio"] == run.summary["damping_ratio"]
        assert str(own) == str(run)
        # The estimate of errors of a run that is made anew may come from another mesh.
        assert len(pictures(run.page())) > 3 and pictures(own.page()) == pictures(run.page())
    assert np.array_equal(pickled.sensitivity("rod.mass"), run.sensitivity("rod.mass"))
    with pytest.raises(KeyError, match="not asked for"):
        loaded.sensitivity("rod.mass")
    again = efam.load(pickled.write(tmp_path / "again"))
    assert np.array_equal(again.data, run.data)
    with pytest.raises(efam.ScenarioError, match="exists already"):
        run.write(tmp_path / "again")


def test_a_folder_of_the_program_is_read(scenario, tmp_path):
    out = tmp_path / "run"
    subprocess.run([*EFAM, "simulate", str(scenario), "--out", str(out), "-q"], check=True)
    assert np.array_equal(efam.load(out).data, efam.simulate(scenario).data)
    with pytest.raises(efam.ScenarioError, match="is no run"):
        efam.load(tmp_path)


def drawn_models_have_the_spread_of_the_prediction(found, muscle, scenario):
    model = efam.Model(scenario, muscle=muscle, pressure="15 psi")
    drawn = model.drawn(60, seed=7)
    poles = [min((pole for pole in own.linearise().poles if pole.imag > 0), key=abs) for own in drawn]
    low, high = np.percentile(np.abs(poles) / (2 * np.pi), [2.5, 97.5])
    prediction = efam.predict(found, pressure="15 psi", draws=200, seed=7)
    (due,) = (own for own in prediction["quantities"] if own["meaning"] == "frequency of small swings")
    assert low < due["value"] < high
    assert high - low == pytest.approx(due["interval_95"][1] - due["interval_95"][0], rel=0.4)
    assert np.array_equal([own["rod.mass"] for own in model.drawn(3, seed=7)], [own["rod.mass"] for own in drawn[:3]])
    with pytest.raises(efam.ScenarioError, match="no .calibration."):
        efam.Model(scenario).drawn(1)


def test_answers_are_the_same_from_their_folder_and_from_a_pickle(tmp_path, scenario):
    found = efam.calibrate(EXPERIMENT, **{"calibrate.mesh": "kept"})
    folder = found.write(tmp_path / "beam")
    for own in (efam.load(folder), pickle.loads(pickle.dumps(found)), pickle.loads(pickle.dumps(efam.load(folder)))):
        assert dict(own) == dict(found) and str(own) == str(found) and own.models == found.models
        assert own.page() == (folder / "report.html").read_text() or "calibration" in own.page().lower()
        again = own.write(tmp_path / "again", overwrite=True)
        assert {path.name for path in again.iterdir()} == {path.name for path in folder.iterdir()}
    drawn = found.plot()
    low, high = found["parameters"][0]["interval_95"]
    ends = drawn.lines[0].get_xdata()
    assert ends[1] - ends[0] == pytest.approx(100 * (high - low) / found["parameters"][0]["value"])
    assert len(drawn.lines) == 2 * len(found["parameters"]) and "kPa" in drawn.get_yticklabels()[0].get_text()
    with pytest.raises(TypeError, match="no intervals"):
        efam.effects().plot()
    by_folder = efam.predict(folder, pressure="15 psi", draws=5)
    by_answer = efam.predict(found, pressure="15 psi", draws=5)
    assert str(by_folder) == str(by_answer)
    prediction = pickle.loads(pickle.dumps(by_folder))
    assert str(efam.load(prediction.write(tmp_path / "prediction"))) == str(by_folder)
    drawn_models_have_the_spread_of_the_prediction(found, folder / "muscle.toml", scenario)
    with pytest.raises(TypeError, match="has no calibration"):
        efam.predict(efam.simulate(EXPERIMENT.parents[2] / "release-15psi.toml").write(tmp_path / "run"))


def test_rest_modes_and_effects_are_those_of_the_program(scenario):
    def printed(*arguments):
        command = [*EFAM, *arguments, "--json"]
        return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)

    statics = efam.statics(scenario, payload="20 g")
    assert dict(statics) == printed("statics", str(scenario), "--payload", "20g")
    modes = efam.modes(efam.Model(scenario), count=2)
    assert dict(modes) == printed("modes", str(scenario), "--count", "2")
    assert len(modes.to_pandas("modes")) == 2 and "frequency" in str(modes)
    assert "<pre>" in modes._repr_html_()
    assert dict(efam.effects()) == printed("effects")
    assert dict(efam.effects("air_drag")) == printed("effects", "air_drag")
    with pytest.raises(efam.ScenarioError, match="did you mean `air_drag`"):
        efam.effects("air_drog")
    with pytest.raises(efam.ScenarioError, match="no folder"):
        modes.write()
    assert dict(pickle.loads(pickle.dumps(modes))) == dict(modes)


def test_runs_are_compared_as_by_the_program(model, tmp_path):
    run, heavy = efam.simulate(model), efam.simulate(model, payload="20 g")
    folders = [own.write(tmp_path / name) for own, name in ((run, "a"), (heavy, "b"))]
    command = [*EFAM, "report", *map(str, folders), "--json", "--out", str(tmp_path / "both")]
    printed = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    found = efam.compare(folders[0], heavy)
    for own, of_program in zip(found["runs"], printed["comparison"]["runs"]):
        assert own["name"] == of_program["name"]
    assert found["differences"] == printed["comparison"]["differences"]
    assert found["quantities"] == printed["comparison"]["quantities"]
    assert "effects.payload.mass" in str(found) and "<svg" in found.page()


def test_summaries_of_many_are_those_of_each(model):
    models = [model.replace(payload=mass) for mass in (0.0, 0.02)]
    many = efam.simulate_many(models, summaries=True)
    assert set(many.summaries) == set(many.units) and many.units["settling_5_percent_s"] == "s"
    for k, own in enumerate(models):
        summary = efam.simulate(own, error_estimate=False).summary
        for name in ("damped_frequency_hz", "damping_ratio", "settling_2_percent_s", "least_tip_angle_rad"):
            assert many.summaries[name][k] == pytest.approx(summary[name] or np.nan, nan_ok=True), name
        assert many.summaries["rest_tip_z_m"][k] == summary["rest"]["tip_z_m"]
        assert many.summaries["peak_speed_m_s"][k] == summary["peak_speed"]["speed_m_s"]
    frame, data = many.to_pandas(), many.to_xarray()
    assert frame.attrs["units"]["rest_tip_z_m"] == "m" and len(frame) == 2
    assert data["tip"].attrs["units"] == "m" and data["damping_ratio"].dims == ("model",)
    assert repr(many) == f"<efam.Many: 2 runs, {len(many.t)} samples>"
    again = pickle.loads(pickle.dumps(many))
    assert np.array_equal(again.tip, many.tip) and again.units == many.units
    without = efam.simulate_many(models)
    assert np.array_equal(without.tip, many.tip) and without.summaries == {}
    with pytest.raises(TypeError, match="summaries=True"):
        without.to_pandas()


def test_a_run_moves_in_a_picture(model, tmp_path):
    moving = efam.simulate(model).animate()
    file = moving.write(tmp_path / "swing.gif")
    assert file.read_bytes().startswith(b"GIF89a") and "data:image/gif" in moving._repr_html_()
    with pytest.raises(FileExistsError):
        moving.write(file)


def test_postures_are_spread_along_the_path(scenario):
    run = efam.simulate(scenario)
    lines = run.plot()[0].lines
    tips = np.array([[line.get_xdata()[-1], line.get_ydata()[-1]] for line in lines[:-1]])
    # At rest they would lie on one another.
    assert len(tips) >= 10 and len(np.unique(np.round(tips[:, 1]), axis=0)) >= 8
